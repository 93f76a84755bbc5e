"""Equilibria by load stepping, and vibrations about them."""

import numpy as np
import pytest

from coupling.verify.models import ROOM, clamp, elastic, model, sections, straight
from mechanics.description import Force, Guide, Moment, Particle, Revolute, Site, Spherical
from mechanics.modes import modes
from mechanics.statics import equilibrium
from meshes.sections import circle, rectangle

X, Y, Z = np.eye(3)
E, NU, RHO, ALPHA = 70e9, 0.3, 2700.0, 2e-5
METAL = elastic(E, NU, RHO, ALPHA)
BAR = rectangle(0.01, 0.02)


def cantilever(load, elements=8):
    beam = straight(1.0, elements, BAR, METAL)
    return model(beam, [clamp()], [load])


def tip_force(size, direction=Y, elements=8):
    return Force("pull", Site("beam", elements), direction, lambda s: size * s)


def solved(made, steps=10, heated=None, **more):
    found = equilibrium(made.system, made.coef, heated or made.coef, steps, **more)
    assert found.why == "" and found.fraction == 1.0
    return found


# ------------------------------------------------------------------------------------ statics


def test_small_deflection_of_a_cantilever():
    """P L^3/(3 E I) and the shear deflection P L/(k G A)."""
    made = cantilever(tip_force(1e-3))
    tip = made.position(solved(made).q, "beam", 8)[1]
    shear = 1e-3 / (BAR.shear_factor_2 * METAL.shear_modulus(ROOM) * BAR.area)
    assert tip == pytest.approx(1e-3 / (3 * E * BAR.second_moment_2) + shear, rel=1e-4)


def test_equilibrium_balances_forces_at_every_coordinate():
    made = cantilever(tip_force(30.0, np.array([0.3, 0.8, 0.5])))
    found, system = solved(made), made.system
    forces = system.force(found.q, np.zeros(system.n), 1.0, made.coef, np.zeros(0))
    residual = forces + system.constraint_force(found.q, 1.0, found.lam)
    assert np.abs(residual).max() < 1e-6 * 30.0
    assert np.abs(system.constraints.values(found.q, 1.0)).max() < 1e-12


def test_reactions_balance_the_load():
    """-lam acts on the clamped node: force rows of a clamp are along the axes."""
    made = cantilever(tip_force(30.0))
    reaction = made.system.constraint_force(np.array(made.system.layout.q0), 1.0, solved(made).lam)
    np.testing.assert_allclose(reaction[:3], [0.0, 30.0, 0.0], atol=1e-6)


def test_equilibrium_is_where_motion_would_not_begin():
    made = cantilever(tip_force(30.0))
    found, system = solved(made), made.system
    a, lam = system.initial_acceleration(found.q, np.zeros(system.n), 1.0, made.coef, np.zeros(0))
    free = 30.0 / (RHO * BAR.area)
    assert np.abs(a[1::12]).max() < 1e-6 * free
    np.testing.assert_allclose(lam[:3], found.lam[:3], atol=1e-4)


def rolled_up(steps):
    """A moment that rolls the bar into a circle."""
    size = 2.0 * np.pi * E * BAR.second_moment_2
    made = cantilever(Moment("roll", Site("beam", 16), Z, lambda s: size * s), 16)
    return made, equilibrium(made.system, made.coef, made.coef, steps)


def test_the_number_of_load_steps_does_not_change_the_equilibrium():
    made, fine = rolled_up(20)
    _, coarse = rolled_up(4)
    assert fine.why == coarse.why == ""
    np.testing.assert_allclose(coarse.q, fine.q, atol=1e-8)
    assert np.linalg.norm(made.position(fine.q, "beam", 16)) < 0.01


def test_load_steps_that_do_not_converge_are_halved():
    """One step for a full circle cannot converge in 8 iterations, the halved ones do."""
    size = np.pi * E * BAR.second_moment_2
    made = cantilever(Moment("roll", Site("beam", 8), Z, lambda s: size * s))
    halved = solved(made, steps=1, iterations=8)
    np.testing.assert_allclose(halved.q, solved(made, steps=10).q, atol=1e-8)
    assert halved.iterations > 16


def test_a_given_start_is_taken():
    made = cantilever(tip_force(30.0))
    first = solved(made)
    again = solved(made, steps=1, start=first)
    assert again.iterations <= 2
    np.testing.assert_allclose(again.q, first.q, atol=1e-9)


def test_drives_turn_with_the_load_factor():
    hinge = Revolute("hinge", Site("beam", 0), Site(None), Z, lambda s: 0.7 * s)
    made = model(straight(1.0, 4, BAR, METAL), [hinge])
    tip = made.position(solved(made).q, "beam", 4)
    np.testing.assert_allclose(tip, [np.cos(0.7), np.sin(0.7), 0.0], atol=1e-9)


def test_coefficients_go_from_cold_to_warm():
    """A free end moves by alpha dT L, a gradient g bends the axis by alpha g."""
    made = model(straight(1.0, 8, BAR, METAL), [clamp()])
    warm = made.system.coefficients(sections(made.system, ROOM + 50.0, 40.0))
    tip = made.position(solved(made, heated=warm).q, "beam", 8)
    bow = 0.5 * ALPHA * 40.0
    assert tip[0] == pytest.approx(1.0 + ALPHA * 50.0, abs=1e-6)
    assert tip[1] == pytest.approx(-bow, rel=2e-3)  # away from the hot side


@pytest.mark.parametrize("steps", [1, 10])
def test_what_has_no_equilibrium_gives_a_reason(steps):
    """A bar that hangs on nothing is pushed."""
    made = model(straight(1.0, 2, BAR, METAL), [], [tip_force(1.0, elements=2)])
    found = equilibrium(made.system, made.coef, made.coef, steps)
    assert found.fraction == 0.0
    assert found.why == "the stiffness matrix is singular" or "beam node" in found.why
    assert np.array_equal(found.q, made.system.layout.q0)


def test_a_load_beyond_the_strength_of_the_steps_names_the_place():
    made = cantilever(tip_force(1e3))
    found = equilibrium(made.system, made.coef, made.coef, 1, iterations=1)
    assert found.why.startswith("statics did not converge at load factor ")
    assert "beam node " in found.why


# -------------------------------------------------------------------------------------- modes


def at_rest(made, count):
    system = made.system
    return modes(system, system.layout.q0, np.zeros(system.m), made.coef, count)


def test_a_ball_on_a_spring():
    rope = straight(1.0, 1, rectangle(0.1, 0.1), elastic(1e4, 0.0, 1e-6), "cable")
    joints = [
        Guide("nail", Site("beam", 0), np.eye(3)),
        Spherical("knot", Site("beam", 1), Site("ball")),
        Guide("line", Site("ball"), np.array([Y, Z])),
    ]
    made = model([rope, Particle("ball", X, 1.0)], joints)
    lowest = at_rest(made, made.system.n - made.system.m).frequencies
    spring = np.sqrt(1e4 * 1e-2) / (2.0 * np.pi)
    assert np.abs(lowest / spring - 1.0).min() < 1e-5


def test_a_free_bar_has_six_motions_without_frequency():
    made = model(straight(1.0, 8, BAR, METAL))
    f = at_rest(made, 7).frequencies
    first = 4.73004074**2 * np.sqrt(E * BAR.second_moment_2 / (RHO * BAR.area)) / (2 * np.pi)
    assert np.abs(f[:6]).max() < 1e-3 * first
    assert f[6] == pytest.approx(first, rel=2e-3)


def test_modes_obey_the_constraints_and_are_orthonormal_in_the_mass():
    made = cantilever(tip_force(0.0))
    found, system = at_rest(made, 6), made.system
    for shape in found.shapes.T:
        moved = [
            system.constraints.values(system.layout.q0 + s * 1e-4 * shape, 0.0) for s in (-1, 1)
        ]
        assert np.abs(moved[1] - moved[0]).max() < 1e-12
    gram = found.shapes.T @ (system.mass @ found.shapes)
    np.testing.assert_allclose(gram, np.eye(6), atol=1e-8)
    assert np.all(np.diff(found.frequencies) >= 0.0)


def tightened(cooling):
    """A thin wire between two walls that pull as it cools; its equilibrium."""
    wire = straight(1.0, 16, circle(1e-4), METAL, "cable")
    ends = [
        Spherical("a", Site("beam", 0), Site(None)),
        Spherical("b", Site("beam", 16), Site(None, position=X)),
    ]
    made = model(wire, ends)
    cold = made.system.coefficients(sections(made.system, ROOM - cooling))
    return made, cold, solved(made, heated=cold)


def test_a_taut_string():
    """f_n = n/(2 L) sqrt(sigma/rho), each in two planes; sigma = E alpha dT."""
    made, cold, found = tightened(50.0)
    f = modes(made.system, found.q, found.lam, cold, 4).frequencies
    first = 0.5 * np.sqrt(E * ALPHA * 50.0 / RHO)
    np.testing.assert_allclose(f, [first, first, 2 * first, 2 * first], rtol=5e-3)


def test_an_unstable_equilibrium_has_negative_frequencies():
    """A pinned bar heated beyond its Euler load stays straight, and would not."""
    beam = straight(1.0, 8, BAR, METAL)
    made = model(beam, [Revolute("a", Site("beam", 0), Site(None), Z),
                        Revolute("b", Site("beam", 8), Site(None, position=X), Z)])  # fmt: skip
    critical = np.pi**2 * BAR.second_moment_2 / (BAR.area * ALPHA)

    def lowest(heating):
        warm = made.system.coefficients(sections(made.system, ROOM + heating))
        found = solved(made, heated=warm)
        return modes(made.system, found.q, found.lam, warm, 1).frequencies[0]

    assert lowest(0.9 * critical) > 0.0 > lowest(1.1 * critical)
    cold = lowest(0.0)
    assert lowest(0.5 * critical) == pytest.approx(cold * np.sqrt(0.5), rel=5e-3)
