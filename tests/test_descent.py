"""Downhill where Newton's method finds no equilibrium: what snaps arrives where it is stable."""

import numpy as np
import pytest

from coupling.verify.models import model
from coupling.verify.stability import cylindrical_roof, lee
from mechanics import descent, statics
from mechanics.arclength import LIMIT, follow
from mechanics.description import Guide, Particle, Site, Spring
from mechanics.eigen import negatives
from mechanics.modes import stiffness
from mechanics.statics import Allowed, at_rest, equilibrium, newton

X, Y, Z = np.eye(3)


@pytest.fixture(scope="module")
def roof():
    """A hinged cylindrical shell under 3 kN in the middle; its limit load is 2.2 kN."""
    return cylindrical_roof(2, 12.7)[0]


def snapped(made, steps):
    """Coordinates under the full load, where the structure is stable."""
    found = equilibrium(made.system, made.coef, made.coef, steps)
    assert found.why == ""
    y = np.concatenate([found.q, found.lam])
    assert negatives(*stiffness(made.system, y, 1.0, made.coef)) == 0
    return found.q


def by_arc_length(made, **more):
    """The same at the end of the path that passes the limit points."""
    path = follow(made.system, made.coef, made.coef, **more)
    assert path.why == "" and [e.kind for e in path.events].count(LIMIT) == 2
    found = newton(made.system, path.points[-1].y, 1.0, made.coef, Allowed(1e-10, 30, np.inf))
    assert found.why == ""
    return found.y[: made.system.n]


@pytest.mark.parametrize("steps", [1, 10])
def test_a_shell_snaps_through_under_more_than_its_limit_load(roof, steps):
    wanted = by_arc_length(roof, arc=5e-3, largest=2e-2)
    np.testing.assert_allclose(snapped(roof, steps), wanted, atol=1e-6)


def test_load_steps_alone_end_at_the_limit_load(roof, monkeypatch):
    monkeypatch.setattr(statics, "downhill", lambda system, y, *rest: (y, 0))
    found = equilibrium(roof.system, roof.coef, roof.coef, 10)
    assert found.why.startswith("statics did not converge at load factor 0.741")
    assert 3000.0 * found.fraction == pytest.approx(2223.0, rel=1e-3)


def test_a_frame_with_hinges_snaps():
    """Multipliers of rotating joints take part: Lee's frame under 2.2 kN, its limit is 1.855."""
    made = lee(10, 2.2)
    wanted = by_arc_length(made, arc=2e-2, largest=4e-2)
    np.testing.assert_allclose(snapped(made, 5), wanted, atol=1e-6)


def test_downhill_from_the_reference_keeps_constraints(roof):
    """In one go; Newton's method has little to do afterwards."""
    system, y = roof.system, at_rest(roof.system)
    lower, spent = descent.downhill(system, y, 1.0, roof.coef)
    assert spent < 60
    residual = system.residual(lower, 0.0 * y, 1.0, roof.coef)
    assert np.abs(residual[system.n :]).max() < 1e-9
    assert newton(system, lower, 1.0, roof.coef, Allowed(1e-10, 4, np.inf)).why == ""


def test_equilibrium_is_left_alone(roof):
    system = roof.system
    y, spent = descent.downhill(system, at_rest(system), 0.0, roof.coef)
    assert spent == 1
    np.testing.assert_allclose(y[: system.n], system.layout.q0, atol=1e-9)


def test_iterations_are_bounded(roof):
    assert descent.downhill(roof.system, at_rest(roof.system), 1.0, roof.coef, 5)[1] == 5


@pytest.mark.parametrize("size", [0.01, 1.0, 10.0])
def test_a_step_ends_before_it_leads_up_again(size):
    """A particle pushed by springs from y = 0.19 to their rest at y = 0.2, and far beyond it."""
    joints = [
        Guide("plane", Site("top"), np.array([X, Z])),
        Spring("left", Site("top"), Site(None, position=-X), 1e3),
        Spring("right", Site("top"), Site(None, position=X), 1e3),
    ]
    made = model(Particle("top", 0.2 * Y, 1.0), joints)
    y, step = at_rest(made.system), np.zeros(made.system.n + made.system.m)
    y[1], step[1] = 0.19, size
    part = descent._part(made.system, y, 0.0, made.coef, step)
    driving = [descent._driving(made.system, y, 0.0, made.coef, step, p) for p in (0.0, part, 1.0)]
    assert driving[0] > 0.0 and driving[1] >= -0.5 * driving[0]
    assert (part == 1.0) == (driving[2] >= -0.5 * driving[0]) == (size < 0.1)
