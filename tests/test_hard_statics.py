"""Descriptions that cannot be, and statics that is hard: a correct result or a clear reason."""

from dataclasses import replace

import numpy as np
import pytest

from coupling.verify.models import ROOM, clamp, elastic, model, straight
from mechanics.check import check
from mechanics.description import (
    Beam,
    Clamp,
    Description,
    Fixing,
    Force,
    Gear,
    Latch,
    Particle,
    Prismatic,
    Revolute,
    RigidBody,
    Shell,
    Site,
    Sliding,
    Spherical,
    Spring,
    Torque,
    TorsionSpring,
)
from mechanics.modes import modes
from mechanics.statics import equilibrium
from meshes.sections import general, rectangle
from meshes.surfaces import patch

X, Y, Z = np.eye(3)
BAR = rectangle(0.01, 0.02)
METAL = elastic(70e9, 0.3, 2700.0)
GOOD = straight(1.0, 4, BAR, METAL)
HINGE = Revolute("hinge", Site("beam", 0), Site(None), Z)
BALL = Particle("ball", X, 1.0)
BLOCK = RigidBody("block", X, 1.0, np.eye(3))


def plate():
    grid = np.linspace(0.0, 1.0, 3)

    def flat(u, v):
        e, zero = np.ones_like(u)[:, None], np.zeros_like(u)
        return np.stack([u, v, zero], axis=1), e * X, e * Y, 0.0 * e * Z

    return Shell("plate", patch(flat, grid, grid), 0.01, METAL, ROOM)


def told(bodies=(GOOD,), joints=(), loads=(), **more):
    return check(Description(list(bodies), list(joints), list(loads), **more))


def with_section(**changes):
    return replace(GOOD, section=replace(BAR, **changes))


def moved(node, place):
    points = np.array(GOOD.points)
    points[node] = place
    return replace(GOOD, points=points)


def pushed(direction=Y, site=None):
    return Force("push", site or Site("beam", 4), direction, lambda s: s)


def test_good_ones_are_not_told():
    spring = TorsionSpring("spring", "hinge", 1.0)
    joints = [
        HINGE,
        spring,
        Latch("latch", "hinge", 1.0),
        Spherical("s", Site("block"), Site("ball")),
    ]
    assert told([GOOD, BALL, BLOCK, plate()], joints, [pushed()]) == []


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (with_section(area=0.0), "area of its section must be positive and finite, got 0"),
        (with_section(second_moment_2=-1e-9), "second moment 2 of its section must be positive"),
        (with_section(torsion_constant=0.0), "torsion constant of its section must be positive"),
        (with_section(shear_factor_3=np.nan), "shear factor 3 of its section must be positive"),
        (moved(2, GOOD.points[1]), "nodes 1 and 2 coincide"),
        (moved(2, np.array([np.nan, 0, 0])), "its points and axes are not finite"),
        (replace(GOOD, points=GOOD.points[:1], axes=GOOD.axes[:1]), "it has 1 nodes"),
        (replace(GOOD, axes=GOOD.axes[:3]), "it has 5 points and 3 triads"),
        (replace(GOOD, axes=2.0 * GOOD.axes), "a section triad is not orthonormal"),
        (replace(GOOD, element="beam9999"), "there is no element 'beam9999'"),
        (replace(GOOD, element="beam3333", points=GOOD.points[:4], axes=GOOD.axes[:4]),
         "1 + a multiple of 2 nodes"),
        (replace(GOOD, damping_time=-1.0), "damping time must not be negative"),
        (replace(GOOD, reference_temperature=-3.0), "must be above 0 K"),
        (replace(GOOD, velocity=np.array([np.inf, 0, 0])), "its velocity is not finite"),
        (replace(BALL, mass=0.0), "its mass must be positive and finite, got 0 kg"),
        (replace(BALL, position=np.full(3, np.nan)), "its position is not finite"),
        (replace(BLOCK, mass=-1.0), "its mass must be positive and finite, got -1 kg"),
        (replace(BLOCK, inertia=np.diag([1.0, 1.0, 0.0])), "moments of inertia must be positive"),
        (replace(BLOCK, inertia=np.diag([1.0, 1.0, 3.0])), "exceeds the sum of the others"),
        (replace(BLOCK, inertia=np.eye(3) + Y[:, None] * Z), "its inertia is not a symmetric"),
        (replace(BLOCK, axes=2.0 * np.eye(3)), "its axes are not orthonormal"),
        (replace(plate(), thickness=0.0), "its thickness must be positive and finite, got 0 m"),
        (replace(plate(), surface=replace(plate().surface, points=0.0 * plate().surface.points)),
         "nodes 0 and 3 coincide"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_bodies_that_cannot_be(body, said):
    problems = told([body])
    assert len(problems) == 1
    assert problems[0].startswith(f"body {body.name!r}: ")
    assert said in problems[0]


@pytest.mark.parametrize("nu", [0.5, 0.7, -1.0])
def test_materials_that_cannot_be(nu):
    with pytest.raises(ValueError, match="poissons_ratio must stay between"):
        elastic(70e9, nu)


NOWHERE = Site("nowhere")


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        (Clamp("j", Site("beam", 0), NOWHERE), "there is no body 'nowhere'"),
        (Clamp("j", Site("beam", 9), Site(None)), "body 'beam' has 5 nodes, not a node 9"),
        (Clamp("j", Site(None), Site(None)), "all its ends are on the ground"),
        (Clamp("j", Site("beam", 1), Site("beam", 1)), "both its ends are the same point"),
        (Revolute("j", Site("beam", 0), Site(None), 0 * Z), "its axis has no direction"),
        (Gear("j", "hinge", "none", 1.0), "there is no joint 'none'"),
        (Gear("j", "hinge", "hinge", 1.0), "it couples a joint with itself"),
        (Latch("j", "none", 1.0), "there is no joint 'none'"),
        (Latch("j", "fixed", 1.0), "joint 'fixed' is none that turns or slides"),
        (TorsionSpring("j", "slide", 1.0), "joint 'slide' is none that turns"),
        (Spring("j", Site("beam", 4), Site(None), -1.0), "its stiffness must not be negative"),
        (Sliding("j", Site("ball"), "nowhere"), "there is no body 'nowhere'"),
        (Sliding("j", Site("beam", 0), "ball"), "'ball' is no beam or cable to slide on"),
        (Sliding("j", Site("beam", 0), "beam"), "'beam' cannot slide on itself"),
        (Fixing("j", "beam", 7, "r_x", Y[None]), "body 'beam' has 5 nodes, not a node 7"),
        (Spherical("j", Site("ball", offset=X), Site(None)), "no point beside its centre"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_joints_that_cannot_be(joint, said):
    others = [HINGE, Clamp("fixed", Site("beam", 4), Site("block")),
              Prismatic("slide", Site("block"), Site(None), X)]  # fmt: skip
    problems = told([GOOD, BALL, BLOCK], [*others, joint])
    assert len(problems) == 1
    assert problems[0].startswith("joint 'j': ")
    assert said in problems[0]


@pytest.mark.parametrize(
    ("load", "said"),
    [
        (pushed(0 * Y), "its direction has no length"),
        (pushed(site=NOWHERE), "there is no body 'nowhere'"),
        (pushed(site=Site(None)), "it must act on a body, not on the ground"),
        (Torque("push", Site(None), Site(None), Z, lambda s: s), "all its ends are on the ground"),
    ],
)
def test_loads_that_cannot_be(load, said):
    problems = told(loads=[load])
    assert len(problems) == 1
    assert said in problems[0]


def test_every_problem_is_told_at_once():
    problems = told(
        [with_section(area=0.0), replace(BALL, mass=0.0)], [Clamp("j", NOWHERE, Site(None))]
    )
    assert len(problems) == 3


def test_names_must_differ():
    assert told([GOOD, GOOD]) == ["2 bodies have the same name 'beam'"]
    assert told(joints=[HINGE, HINGE]) == ["2 joints have the same name 'hinge'"]
    assert told(gravity=np.array([0, 0, np.nan])) == ["gravity is not finite"]


# ---------------------------------------------------------------------------------- hard statics


def test_a_beam_100000_times_longer_than_high_bends_as_the_elastica():
    bar, E = rectangle(1e-5, 1e-5), 1e9
    load = Force("push", Site("beam", 16), Y, lambda s: 10.0 * E * bar.second_moment_2 * s)
    made = model(straight(1.0, 16, bar, elastic(E)), [clamp()], [load])
    found = equilibrium(made.system, made.coef, made.coef, 2)
    assert found.why == ""
    tip = made.position(found.q, "beam", 16)
    np.testing.assert_allclose(tip, [1 - 0.55499560, 0.81060902, 0.0], atol=2e-4)


def test_its_first_frequency_is_right_too():
    bar, E = rectangle(1e-5, 1e-5), 70e9
    made = model(straight(1.0, 16, bar, elastic(E, 0.3, 2700.0)), [clamp()])
    found = modes(made.system, made.system.layout.q0, np.zeros(made.system.m), made.coef, 2)
    wanted = 1.8751041**2 * np.sqrt(E * bar.second_moment_2 / (2700.0 * bar.area)) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies, wanted, rtol=1e-4)
    assert found.unstable == 0


@pytest.mark.parametrize("ratio", [1e-8, 1e8])
def test_stiffness_ratio_of_a_hundred_million(ratio):
    """Two bars in a row: the tip moves by P L^3/3EI of each, and by the turn of the first."""
    second = straight(1.0, 4, BAR, elastic(70e9 * ratio, 0.3))
    second = replace(second, name="second", points=second.points + X)
    joints = [clamp(), Clamp("weld", Site("beam", 4), Site("second", 0))]
    EI = 70e9 * BAR.second_moment_2
    size = 1e-4 * min(1.0, ratio) * EI
    load = Force("push", Site("second", 4), Y, lambda s: size * s)
    made = model([GOOD, second], joints, [load])
    found = equilibrium(made.system, made.coef, made.coef, 1)
    assert found.why == ""
    # beam 1 under P and P L: P/3 + P/2 and slope P/2 + P; beam 2: slope L + P/3
    bending = size / EI * (1 / 3 + 1 / 2 + 3 / 2 + 1 / (3 * ratio))
    shear = size / (70e9 / 2.6 * BAR.shear_factor_2 * BAR.area) * (1 + 1 / ratio)
    assert made.position(found.q, "second", 4)[1] == pytest.approx(bending + shear, rel=1e-3)


@pytest.mark.parametrize("stiffness", [1e-4, 1e8])
def test_a_spring_much_softer_or_stiffer_than_the_beam(stiffness):
    spring = Spring("spring", Site("beam", 4), Site(None, position=X + Y), stiffness, preload=1e-3)
    made = model(GOOD, [clamp(), spring])
    found = equilibrium(made.system, made.coef, made.coef, 1)
    assert found.why == ""
    beam = 3.0 * 70e9 * BAR.second_moment_2
    assert found.q[4 * 12 + 1] == pytest.approx(1e-3 / (beam + stiffness), rel=2e-3)


def test_an_infinitely_large_load_ends_with_a_reason():
    made = model(GOOD, [clamp()], [Force("push", Site("beam", 4), Y, lambda s: 1e300 * s)])
    found = equilibrium(made.system, made.coef, made.coef, 1)
    assert found.why
    assert found.fraction < 1.0
    assert np.all(np.isfinite(found.q))


def test_a_rope_of_no_bending_stiffness_to_speak_of_hangs():
    """A straight cable under its weight is soft across: it sags all the same, as sqrt(3) would."""
    thin = general(1e-4, 1e-14, 1e-14, 1e-14)
    rope = Beam(
        "beam", GOOD.points, GOOD.axes, thin, elastic(1e9, 0.0, 1000.0), ROOM, element="cable"
    )
    joints = [Spherical("a", Site("beam", 0), Site(None)),
              Spherical("b", Site("beam", 4), Site(None, position=X))]  # fmt: skip
    made = model(rope, joints, gravity=-9.81 * Y)
    found = equilibrium(made.system, made.coef, made.coef, 10)
    assert found.why == ""
    # shallow parabola: H = q L^2/(8 f), stretch 8 f^2/(3 L^2) = H/EA
    sag = (3.0 * 1000.0 * 1e-4 * 9.81 / (64.0 * 1e9 * 1e-4)) ** (1 / 3)
    assert -found.q[2 * 6 + 1] == pytest.approx(sag, rel=2e-2)
