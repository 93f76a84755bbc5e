"""The predicted stress: that of the linear step, the same equilibrium, fewer iterations."""

import numpy as np
import pytest
from element_cases import make

from coupling.verify import thick_shells
from coupling.verify.models import clamp, elastic, model, straight
from mechanics import statics
from mechanics.description import Force, Site
from mechanics.statics import equilibrium
from meshes import surfaces
from meshes.sections import rectangle

Y = np.eye(3)[1]
PREDICTED = ["cable", "beam3333", "shell48", "shell24", "shell3443"]
LINEAR = {"cable": [0]}
"""Resultants that are linear in the strains whose stress is predicted; all, if not named."""


@pytest.mark.parametrize("family", PREDICTED)
def test_stress_is_that_of_the_linear_step(family):
    """Resultants at the new place, against their derivative along the step at the old one."""
    rng = np.random.default_rng(3)
    c = make(family)
    y, step = c.q + 0.02 * rng.standard_normal(c.q.size), 0.1 * rng.standard_normal(c.q.size)
    new, rest, coef = y + 0.7 * step, 0.0 * y, c.term.coefficients(c.uneven(rng))
    columns = LINEAR.get(family, slice(None))

    def resultants(y, coef):
        return c.term.resultants(y, rest, coef)[:, columns]

    def ahead(h):
        return (resultants(y + h * step, coef) - resultants(y - h * step, coef)) / (2.0 * h)

    h = 1e-3
    wanted = resultants(y, coef) + (4.0 * ahead(0.5 * h) - ahead(h)) / 3.0
    found = resultants(new, c.term.predicted(coef, y, step, new))
    assert found == pytest.approx(wanted, rel=1e-6, abs=1e-6 * np.abs(wanted).max())
    assert resultants(new, coef) != pytest.approx(wanted, rel=1e-2)


@pytest.mark.parametrize("family", PREDICTED)
def test_no_step_changes_nothing(family):
    c = make(family)
    coef = c.coefficients()
    assert np.array_equal(c.term.predicted(coef, c.q, 0.0 * c.q, c.q), coef)
    assert c.term.predicted(coef, c.q, 0.0 * c.q, c.q) is not coef


def bar(family):
    """A cantilever 100 times longer than high, with 8 elements and an end load of 5 EI/L^2."""
    section, nodes = rectangle(1e-2, 1e-2), 16 if family == "beam3333" else 8
    load = 5e9 * section.second_moment_2
    push = Force("p", Site("beam", nodes), Y, lambda s: load * s)
    return model(straight(1.0, nodes, section, elastic(1e9), family), [clamp()], [push])


def strip(family):
    """The same made of a shell."""
    surface = surfaces.plate(1.0, 0.1, 8, 1)
    grid = thick_shells._grid(surface, 2)
    shell = thick_shells._shell(family, surface, 1e-2, 1e9, 0.0)
    loads = thick_shells._edge(surface, grid[-1], 5e9 * 1e-6 / 12.0)
    return thick_shells._model(shell, thick_shells._clamped(grid[0]), loads)


@pytest.mark.parametrize("family", PREDICTED)
def test_the_equilibrium_is_the_same_and_found_sooner(family, monkeypatch):
    made = strip(family) if family.startswith("shell") else bar(family)
    mixed = equilibrium(made.system, made.coef, made.coef, 2)
    monkeypatch.setattr(statics, "predicted", lambda system, coef, *rest: coef)
    plain = equilibrium(made.system, made.coef, made.coef, 2)
    assert mixed.why == plain.why == ""
    np.testing.assert_allclose(mixed.q, plain.q, atol=1e-9)
    assert mixed.iterations < 0.7 * plain.iterations
