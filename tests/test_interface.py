"""Two faces on one another: balance, meshes that do not match, laws, closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from heat_cases import member, plain, still, varying

from meshes.sections import rectangle
from meshes.solids import bore, pin
from meshes.surfaces import plate as surface
from thermal.boundary import Moment
from thermal.description import Description, Fixed, Interface, Place, Sheet, Side, Solid
from thermal.discretisation import Block
from thermal.interface import Pressed
from thermal.solid import SolidSpace
from thermal.solvers import build

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


# ---------------------------------------------------------------------------- by solvers

ENDS = Place("one", "end"), Place("two", "start")


@pytest.mark.parametrize("name", ["line", "hermite", "lumped", "solid"])
def test_two_bars_pressed_end_to_end(name):
    """Steady: the two halves and the contact are resistances in a row."""
    one = member("one", 0.5, 4, material=plain(), section=rectangle(0.02, 0.02))
    two = member("two", 0.5, 4, material=plain(), section=one.section, start=(0.5, 0.0, 0.0))
    touch = Interface("touch", Side("one", "end"), Side("two", "start"), 300.0)
    conditions = (
        Fixed("hot", Place("one", "start"), still(400.0)),
        Fixed("cold", Place("two", "end"), still(300.0)),
    )
    d = Description((one, two), conditions=conditions, interfaces=(touch,))
    solver = build(name, d)
    T, _, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    flux = 100.0 / (2 * 0.5 / 167.0 + 1.0 / 300.0)
    ends = [T[m.nodes] @ m.weights for m in map(solver.space.place, ENDS)]
    assert ends[0] - ends[1] == pytest.approx(flux / 300.0, rel=1e-9)
    end, flows, _ = solver.advance(T, 0.0, 10.0, np.zeros_like(T))
    assert flows["hot"] == pytest.approx(flux * 4e-4 * 10.0, rel=1e-8)
    np.testing.assert_allclose(end, T, rtol=1e-9)


def test_a_pin_in_a_bush_whose_meshes_do_not_match():
    """Even temperatures, touching all round: power is h A dT of the smaller face, the pin's."""
    pin_mesh, bush_mesh = pin(0.01, 0.03, 12, 2, 3), bore(0.0101, 0.02, 0.03, 20, 2, 4)
    solids = (
        Solid("pin", pin_mesh, {"": plain()}, 310.0),
        Solid("bush", bush_mesh, {"": plain()}, 300.0),
    )
    space = SolidSpace(Description(solids=solids))
    faces = [space.face(Side("pin", "outer")), space.face(Side("bush", "inner"))]
    touch = Interface("fit", Side("pin", "outer"), Side("bush", "inner"), 1000.0)
    term, T = Pressed(touch, *faces), space.start
    area = sum(block.areas.sum() for block in faces[0])
    out = power(term, T)
    assert out[space.regions["bush"]].sum() == pytest.approx(1000.0 * area * 10.0, rel=1e-12)
    assert area < sum(block.areas.sum() for block in faces[1])


def test_two_plates_exchange_across_their_gap():
    """Sheets, top on bottom: radiation factor and conductance."""
    low, high = (
        Sheet(n, surface(0.3, 0.2, *cells), 1e-3, plain(), T)
        for n, cells, T in (("low", (3, 2), 320.0), ("high", (2, 3), 300.0))
    )
    touch = Interface("gap", Side("low", "top"), Side("high", "bottom"), 50.0, None, 0.4)
    d = Description(sheets=(low, high), interfaces=(touch,))
    solver = build("wall", d)
    start = solver.initial()
    T, flows, why = solver.advance(start, 0.0, 1e4, np.zeros_like(start))
    assert why == ""
    assert flows == {}
    assert solver.energy(T) == pytest.approx(solver.energy(start), rel=1e-13)
    np.testing.assert_allclose(T, 310.0, atol=1e-3)
