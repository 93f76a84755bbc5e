"""Equilibria by load stepping, and vibrations about them."""

from dataclasses import replace

import numpy as np
import pytest

from coupling.verify.models import ROOM, clamp, elastic, model, sections, straight
from mechanics import statics
from mechanics.beam3243_kernels import evaluate
from mechanics.description import (
    Force,
    Guide,
    Moment,
    Particle,
    Prismatic,
    Revolute,
    RigidBody,
    Site,
    Spherical,
    TorsionSpring,
)
from mechanics.mechanism import free_motions
from mechanics.modes import modes
from mechanics.prediction import predicted
from mechanics.statics import at_rest, equilibrium
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
    y = system.unknowns(found.q, found.lam)
    residual = system.residual(y, np.zeros_like(y), 1.0, made.coef)
    assert np.abs(residual[: system.n]).max() < 1e-6 * 30.0
    assert np.abs(residual[system.n :]).max() < 1e-12


def test_reactions_balance_the_load():
    """-lam acts on the clamped node: force rows of a clamp are along the axes."""
    made = cantilever(tip_force(30.0))
    y = made.system.unknowns(made.system.layout.q0, solved(made).lam)
    reaction = made.system.constraint_force(y, 1.0, made.coef)
    np.testing.assert_allclose(reaction[:3], [0.0, 30.0, 0.0], atol=1e-6)


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


PUSH = np.array([0.1, 1.0, 0.2])


@pytest.mark.parametrize(
    ("joints", "free"),
    [
        ([], "move along x, y and z and turn about x, y and z"),
        ([Revolute("a", Site("beam", 0), Site(None), Z)], "turn about z"),
        ([Revolute("a", Site("beam", 0), Site(None), np.array([0.6, 0.8, 0.0]))],
         "turn about (0.6, 0.8, 0)"),
        ([Spherical("a", Site("beam", 0), Site(None))], "turn about x, y and z"),
        ([Guide("a", Site("beam", 0), np.array([Y, Z])), Prismatic("p", Site("beam", 2),
          Site(None, position=X), X)], "move along x"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("steps", [1, 10])
def test_a_mechanism_is_told_by_body_and_direction(joints, free, steps):
    made = model(straight(1.0, 2, BAR, METAL), joints, [tip_force(10.0, PUSH, 2)])
    found = equilibrium(made.system, made.coef, made.coef, steps)
    assert found.fraction == 0.0
    assert found.why == f"nothing holds body 'beam': it can {free}"
    assert np.array_equal(found.q, made.system.layout.q0)


def test_only_the_loose_body_is_told():
    ball = RigidBody("ball", X, 1.0, np.eye(3))
    hinge = Revolute("hinge", Site("ball"), Site("beam", 2), Z)
    made = model([straight(1.0, 2, BAR, METAL), ball], [clamp(), hinge], [tip_force(1.0, Y, 2)])
    assert loose(made) == ["body 'ball': it can turn about z"]


def loose(made):
    return free_motions(made.system, at_rest(made.system), made.coef)


def test_what_a_weak_spring_holds_is_no_mechanism():
    """Eleven orders of magnitude softer than the axis of the bar."""
    hinge = Revolute("hinge", Site("beam", 0), Site(None), Z)
    spring = TorsionSpring("spring", "hinge", stiffness=1e-2)
    made = model(straight(1.0, 2, BAR, METAL), [hinge, spring], [tip_force(1e-5, Y, 2)])
    assert loose(made) == []
    tip = made.position(solved(made).q, "beam", 2)
    angle = np.arctan2(tip[1], tip[0])
    assert angle == pytest.approx(1e-3 * np.cos(angle), rel=1e-4)


def test_a_clamped_bar_is_no_mechanism():
    assert loose(cantilever(tip_force(0.0))) == []


def test_motions_of_a_chain_are_those_of_its_hinges():
    """Two bars in a row on spherical joints: each spins, and the middle moves across."""
    second = replace(straight(1.0, 1, BAR, METAL), name="second")
    second = replace(second, points=second.points + X)
    joints = [
        Spherical("a", Site("beam", 0), Site(None)),
        Spherical("b", Site("beam", 1), Site("second", 0)),
        Spherical("c", Site("second", 1), Site(None, position=2 * X)),
    ]
    told = loose(model([straight(1.0, 1, BAR, METAL), second], joints))
    assert told == [f"body {name!r}: it can turn about x, y and z" for name in ("beam", "second")]


def test_a_load_beyond_the_strength_of_the_steps_names_the_place(monkeypatch):
    monkeypatch.setattr(statics, "downhill", lambda system, y, *rest: (y, 0))
    made = cantilever(tip_force(1e3))
    found = equilibrium(made.system, made.coef, made.coef, 1, iterations=1)
    assert found.why.startswith("statics did not converge at load factor ")
    assert "beam node " in found.why


def test_a_load_that_is_no_number_ends_where_it_was_one():
    made = cantilever(tip_force(1.0))
    push = Force("p", Site("beam", 8), Y, lambda s: s if s <= 0.5 else np.nan)
    made = cantilever(push)
    found = equilibrium(made.system, made.coef, made.coef, 10)
    assert "beam node" in found.why
    assert 0.49 < found.fraction <= 0.5
    assert np.all(np.isfinite(found.q))


# ----------------------------------------------------------------------------- predicted stress


@pytest.mark.parametrize("height", [1e-2, 1e-3, 1e-5])
def test_slender_rods_need_no_more_iterations(height):
    """Elastica with P L^2/EI = 10 in one load step, up to 100000 times longer than high."""
    bar = rectangle(height, height)
    load = Force("p", Site("beam", 16), Y, lambda s: 10e9 * bar.second_moment_2 * s)
    made = model(straight(1.0, 16, bar, elastic(1e9)), [clamp()], [load])
    found = solved(made, 1)
    assert found.iterations <= 14
    if height < 1e-2:  # no shear, no stretch
        assert made.position(found.q, "beam", 16)[1] == pytest.approx(0.81060902, abs=1e-4)


def test_ordinary_stress_gives_the_same_equilibrium_later(monkeypatch):
    made = cantilever(tip_force(300.0, PUSH))
    mixed = solved(made, 4)
    monkeypatch.setattr(statics, "predicted", lambda system, coef, *rest: coef)
    plain = solved(made, 4)
    np.testing.assert_allclose(plain.q, mixed.q, atol=1e-9)
    assert mixed.iterations < 0.7 * plain.iterations


def test_predicted_stress_is_the_linear_one():
    """At the new place the shifted coefficients leave the stresses D (eps + B dq - free)."""
    made = cantilever(tip_force(0.0, elements=2), 2)
    rng, system = np.random.default_rng(1), made.system
    y = at_rest(system)
    y[: system.n] += 0.1 * rng.standard_normal(system.n)
    step = 0.1 * rng.standard_normal(y.size)
    shifted = predicted(system, made.coef, y, step, y + step)

    def strains(y):
        eps, rate = np.empty((2, 2, 18))
        term = system.elements[0]
        evaluate(y, y, term.ints, term.floats, eps, rate)
        return eps

    h = 1e-6
    slope = (strains(y + h * step) - strains(y - h * step)) / (2 * h)
    wanted = strains(y) + slope - made.coef[0][:, 18:36]
    np.testing.assert_allclose(strains(y + step) - shifted[0][:, 18:36], wanted, atol=1e-8)
    assert all(a is b for a, b in zip(shifted[1:], made.coef[1:], strict=True))


# -------------------------------------------------------------------------------------- modes


def vibrations(made, count):
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
    lowest = vibrations(made, made.system.n - made.system.m).frequencies
    spring = np.sqrt(1e4 * 1e-2) / (2.0 * np.pi)
    assert np.abs(lowest / spring - 1.0).min() < 1e-5


def test_a_free_bar_has_six_motions_without_frequency():
    made = model(straight(1.0, 8, BAR, METAL))
    f = vibrations(made, 7).frequencies
    first = 4.73004074**2 * np.sqrt(E * BAR.second_moment_2 / (RHO * BAR.area)) / (2 * np.pi)
    assert np.abs(f[:6]).max() < 1e-3 * first
    assert f[6] == pytest.approx(first, rel=2e-3)


def test_modes_obey_the_constraints_and_are_orthonormal_in_the_mass():
    made = cantilever(tip_force(0.0))
    found, system = vibrations(made, 6), made.system
    moved = system.jacobian(at_rest(system), 0.0, made.coef) @ found.shapes
    assert np.abs(moved).max() < 1e-12 * np.abs(found.shapes).max()
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


def test_coordinates_of_joints_carry_no_mass_and_do_no_harm():
    """A block on a torsion spring, which acts on a coordinate of the hinge: sqrt(k/I)."""
    hinge = Revolute("hinge", Site("block"), Site(None), Z)
    spring = TorsionSpring("spring", "hinge", stiffness=50.0)
    made = model([RigidBody("block", 0 * X, 2.0, np.diag([1.0, 2.0, 2.5]))], [hinge, spring])
    assert np.count_nonzero(made.system.mass.diagonal() == 0.0) == 1
    found = vibrations(made, 1).frequencies
    assert found == pytest.approx(np.sqrt(50.0 / 2.5) / (2 * np.pi))


def test_a_hinge_with_a_stiff_spring_vibrates_like_a_clamp():
    hinge = Revolute("hinge", Site("beam", 0), Site(None), Z)
    spring = TorsionSpring("spring", "hinge", stiffness=1e8)
    held = model(straight(1.0, 8, BAR, METAL), [hinge, spring])
    clamped = cantilever(tip_force(0.0))
    np.testing.assert_allclose(
        vibrations(held, 2).frequencies, vibrations(clamped, 2).frequencies, rtol=1e-4
    )
