"""Two faces on one another: balance, meshes that do not match, laws, closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from heat_cases import varying

from thermal.boundary import Moment
from thermal.description import Interface, Side
from thermal.discretisation import Block
from thermal.interface import Pressed

SIGMA = 5.670374419e-8
NOW = Moment(0.0, {})
GAUSS = 0.5 + 0.5 * np.array([-1.0, 1.0]) / np.sqrt(3.0)
TOUCH = Interface("touch", Side("a"), Side("b"), 500.0)


def square(cells, first, up, size=1.0, z=0.0, offset=(0.0, 0.0)):
    """A face of cells x cells bilinear quads with 2 x 2 points; its nodes, positions (n, 2)."""
    s = np.linspace(0.0, size, cells + 1)
    x = np.stack(np.meshgrid(s, s, indexing="ij"), axis=-1).reshape(-1, 2) + offset
    i, j = (v.ravel() for v in np.meshgrid(range(cells), range(cells), indexing="ij"))
    corner = i * (cells + 1) + j
    quads = np.stack([corner, corner + cells + 1, corner + cells + 2, corner + 1], axis=1)
    u, v = (w.ravel() for w in np.meshgrid(GAUSS, GAUSS, indexing="ij"))
    values = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    flat = np.einsum("pk,gkc->gpc", values, x[quads])
    points = np.concatenate([flat, np.full((*flat.shape[:2], 1), z)], axis=2)
    normals = np.broadcast_to([0.0, 0.0, 1.0 if up else -1.0], points.shape)
    areas = np.full(points.shape[:2], (size / cells) ** 2 / 4)
    return [Block(quads + first, values, areas, points, normals, np.empty((len(quads), 0, 3)))], x


def pair(m, n, interface=TOUCH, **other):
    a, xa = square(m, 0, True)
    b, xb = square(n, len(xa), False, **other)
    return Pressed(interface, a, b), xa, xb


def power(term, T):
    out = np.zeros(len(T))
    assert list(term.add(np.asarray(T, float), NOW, out)) == []
    return out


def dense_slopes(term, T):
    rows, columns = term.entries()
    matrix = np.zeros((len(T), len(T)))
    np.add.at(matrix, (rows, columns), term.slopes(T, NOW))
    return matrix


@pytest.mark.parametrize(("m", "n"), [(3, 3), (2, 5), (7, 3)])
def test_even_temperatures_on_meshes_that_do_not_match(m, n):
    term, xa, xb = pair(m, n)
    out = power(term, np.concatenate([np.full(len(xa), 310.0), np.full(len(xb), 300.0)]))
    assert out[: len(xa)].sum() == pytest.approx(-5000.0, rel=1e-13)
    assert out[len(xa) :].sum() == pytest.approx(5000.0, rel=1e-13)


@pytest.mark.parametrize(("m", "n"), [(4, 4), (3, 8), (8, 3)])
def test_temperatures_that_are_linear_along_the_faces_are_exact(m, n):
    """Both linear: first moment of the power over the square is int x h (b x) = h b/12 about it."""
    term, xa, xb = pair(m, n)
    T = np.concatenate([300.0 + 12.0 * xa[:, 0], np.full(len(xb), 300.0)])
    out = power(term, T)
    assert out[: len(xa)].sum() == pytest.approx(-3000.0, rel=1e-12)
    moment = (xa[:, 0] - 0.5) @ out[: len(xa)]
    assert moment == pytest.approx(-500.0 * 12.0 / 12.0, rel=1e-12)
    same = np.concatenate([300.0 + 12.0 * xa[:, 0], 300.0 + 12.0 * xb[:, 0]])
    np.testing.assert_allclose(power(term, same), 0.0, atol=1e-9)


def test_what_leaves_one_face_enters_the_other():
    term, xa, xb = pair(5, 3, replace(TOUCH, law=varying().conductivity, radiating=0.7))
    T = np.random.default_rng(0).uniform(250.0, 350.0, len(xa) + len(xb))
    out = power(term, T)
    assert abs(out.sum()) < 1e-13 * np.abs(out).sum()


def test_law_and_radiation_across_the_gap():
    law = varying().conductivity
    term, xa, xb = pair(2, 3, replace(TOUCH, law=law, radiating=0.7), z=1e-3)
    out = power(term, np.concatenate([np.full(len(xa), 320.0), np.full(len(xb), 300.0)]))
    exact = 500.0 * law(310.0) * 20.0 + 0.7 * SIGMA * (320.0**4 - 300.0**4)
    assert out[len(xa) :].sum() == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(("m", "n"), [(1, 2), (2, 1), (2, 2)])
def test_tangent(m, n):
    term, xa, xb = pair(m, n, replace(TOUCH, law=varying().conductivity, radiating=0.7))
    size = len(xa) + len(xb)
    T, step = np.random.default_rng(1).uniform(280.0, 330.0, size), 1e-3
    expected = np.zeros((size, size))
    for i, d in enumerate(step * np.eye(size)):
        expected[:, i] = -(power(term, T + d) - power(term, T - d)) / (2.0 * step)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(dense_slopes(term, T), expected, rtol=0, atol=1e-8 * scale)


def test_only_where_they_overlap():
    """A unit square against a smaller one, and against one that is displaced by a half."""
    small, xa, xb = pair(4, 4, size=0.5, offset=(0.25, 0.25))
    T = np.concatenate([np.full(len(xa), 310.0), np.full(len(xb), 300.0)])
    assert power(small, T)[len(xa) :].sum() == pytest.approx(5000.0 / 4, rel=1e-12)
    shifted, _, _ = pair(16, 16, offset=(0.5, 0.0))
    assert power(shifted, T0 := _hot(16, 16))[len(T0) // 2 :].sum() == pytest.approx(2500, rel=0.1)


def _hot(m, n):
    return np.concatenate([np.full((m + 1) ** 2, 310.0), np.full((n + 1) ** 2, 300.0)])


def test_faces_that_do_not_meet_are_refused():
    a, xa = square(2, 0, True)
    turned, _ = square(2, len(xa), True)
    with pytest.raises(ValueError, match="face 'outer' of 'a' does not lie on face 'outer' of 'b'"):
        Pressed(TOUCH, a, turned)
    beside, _ = square(2, len(xa), False, offset=(5.0, 0.0))
    with pytest.raises(ValueError, match="does not lie on"):
        Pressed(TOUCH, a, beside)
