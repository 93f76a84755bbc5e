"""Several elements at once: results are those of each alone, and those of numpy."""

from types import SimpleNamespace

import numpy as np
import pytest
from numba import njit

from mechanics import beam3243, kernels
from mechanics.description import Beam
from mechanics.lane_products import BEYOND, ROWS, combine, combine_two, dots
from mechanics.lanes import WIDTH, compiled
from mechanics.layout import Layout
from meshes.materials import constant_material
from meshes.sections import rectangle

PLAIN = constant_material("plain", 2700.0, 70e9, 0.3, 23e-6, 160.0, 900.0)
RNG = np.random.default_rng(5)
shown = compiled(lambda x: [2.0 * (x[0] * x[0] + x[1]).root() - 1.0 / x[1], -x[0], x[1] * 0.0], 2)


def beams(count):
    """Term of beams of one element, every third without damping; a state; coefficients."""
    points, axes = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]]), np.tile(np.eye(3), (2, 1, 1))
    section = rectangle(0.03, 0.02)
    members = [
        Beam(f"{k}", points, axes, section, PLAIN, 293.15, 1e-3 * (k % 3)) for k in range(count)
    ]
    layout = Layout.of(members)
    term = beam3243.build(members, layout)
    coef = term.coefficients(np.tile([300.0, 10.0, 3.0], (len(layout.x), 1)))
    q = layout.q0 + 0.01 * RNG.standard_normal(layout.ndof)
    return term, q, RNG.standard_normal(layout.ndof), coef


def alone(term, k):
    """Element k and nothing else."""
    parts = {name: getattr(term, name) for name in ("force", "energy")}
    return SimpleNamespace(ints=term.ints[k : k + 1], floats=term.floats[k : k + 1], **parts)


@pytest.mark.parametrize("count", [1, WIDTH - 1, WIDTH, WIDTH + 3])
def test_each_element_is_what_it_is_alone(count):
    term, q, v, coef = beams(count)
    together, each, energies = np.zeros(q.size), np.zeros(q.size), np.zeros(3)
    kernels.add_force(term, q, v, coef, together)
    for k in range(count):
        kernels.add_force(alone(term, k), q, v, coef[k : k + 1], each)
        energies += kernels.energies(alone(term, k), q, v, coef[k : k + 1])
    np.testing.assert_array_equal(together, each)
    np.testing.assert_allclose(kernels.energies(term, q, v, coef), energies, rtol=1e-14)


def test_formula_is_that_of_numpy():
    @njit
    def run(source, target):
        shown(source, target)

    x, y = RNG.random((2, WIDTH)) + 0.1
    target = np.full((3, WIDTH), np.nan)
    run(np.concatenate([x, y]), target.ravel())
    np.testing.assert_array_equal(target, [2.0 * np.sqrt(x * x + y) - 1.0 / y, -x, 0.0 * x])


@njit
def _products(rows, stride, n, factors, second, values, out, other, third, found):
    combine(out, factors, rows, stride, n, len(factors))
    combine_two(other, third, factors, second, rows, stride, n, len(factors))
    dots(rows, stride, values, n, found)


@pytest.mark.parametrize("n", [1, WIDTH - 1, WIDTH, 3 * WIDTH, 3 * WIDTH + 2])
def test_products_are_those_of_numpy(n):
    matrix = RNG.standard_normal((7, n + 5))
    rows = np.concatenate([matrix.ravel(), np.zeros(BEYOND)])
    factors, second = RNG.standard_normal((2, 7))
    values = np.concatenate([RNG.standard_normal(n), np.zeros(BEYOND)])
    out, other, third = np.empty((3, n + BEYOND))
    found = np.empty(ROWS)
    _products(rows, n + 5, n, factors, second, values, out, other, third, found)
    part = matrix[:, :n]
    np.testing.assert_allclose(out[:n], -factors @ part, atol=1e-13)
    np.testing.assert_array_equal(other[:n], out[:n])
    np.testing.assert_allclose(third[:n], -second @ part, atol=1e-13)
    np.testing.assert_allclose(found, part[:ROWS] @ values[:n], atol=1e-13)
