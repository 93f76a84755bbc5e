"""Joints that repeat or contradict others are found and named."""

import time

import numpy as np
import pytest
from joint_cases import DIAGONAL, Rows, X, Y, Z, beam, rigid

from mechanics.description import (
    Clamp,
    Cylindrical,
    Distance,
    Gear,
    Guide,
    Latch,
    Particle,
    Prismatic,
    Revolute,
    Site,
    Sliding,
    Spherical,
)
from mechanics.redundancy import repetitions


def ground(*position):
    return Site(None, position=np.array(position, float))


def found(joints, bodies):
    rows = Rows(joints, bodies, rigid_too=True)
    names = [joint.name for joint in joints]
    return repetitions(rows.terms, rows.layout.q0, rows.layout.scale, names)


ARM = beam("arm", (0, 0, 0), (2, 0, 0), 3)
HUB = rigid("hub", np.zeros(3))


def hinge(name, angle=None):
    return Revolute(name, Site("hub"), ground(0, 0, 0), Z, angle=angle)


def test_sound_joints_are_left_alone():
    joints = [
        Clamp("root", Site("arm"), ground(0, 0, 0)),
        Spherical("tip", Site("arm", -1), ground(2, 0, 0)),
        Revolute("hinge", Site("hub"), Site("arm"), Z, angle=lambda t: t),
        Latch("latch", "hinge", 1.0),
    ]
    assert found(joints, [ARM, HUB]) == []


def test_the_same_joint_twice_repeats_all_of_it():
    (again,) = found([hinge("one"), hinge("two")], [HUB])
    assert again == ("two", 5, 5, ("one",), False)
    assert str(again) == "joint 'two': 5 of 5 constraints repeat 'one'"


def test_only_the_part_that_is_held_already_is_counted():
    joints = [
        Guide("wall", Site("hub"), np.array([X, Y])),
        Spherical("pin", Site("hub"), ground(0, 0, 0)),
    ]
    (again,) = found(joints, [HUB])
    assert again == ("pin", 2, 3, ("wall",), False)


def test_joints_after_a_repetition_are_not_blamed_for_it():
    joints = [hinge("one"), hinge("two"), Revolute("three", Site("arm"), Site("hub"), X)]
    assert [r.joint for r in found(joints, [HUB, ARM])] == ["two"]


def test_only_the_joints_that_are_repeated_are_named():
    joints = [
        Spherical("far", Site("arm", -1), ground(2, 0, 0)),
        Revolute("tie", Site("hub"), Site("arm"), Y),
        Spherical("one", Site("hub"), ground(0, 0, 0)),
        Spherical("two", Site("hub"), ground(0, 0, 0)),
    ]
    (again,) = found(joints, [HUB, ARM])
    assert again == ("two", 3, 3, ("one",), False)


@pytest.mark.parametrize(
    ("first", "second", "contradicts"),
    [
        (None, lambda t: 0.1 * t, False),
        (lambda t: 0.1 * t, lambda t: 0.1 * t, False),
        (lambda t: 0.1 * t, lambda t: 0.2 * t, True),
        (lambda t: 0.1 * t, lambda t: 0.0, True),
        (lambda t: min(t, 50.0) ** 3, lambda t: 0.0, True),
    ],
)
def test_two_drives_of_one_turn(first, second, contradicts):
    again = found([hinge("one", first), hinge("two", second)], [HUB])
    assert [r.contradicts for r in again] == [contradicts]
    assert again[0].repeated == (5 if first is None else 6)


def test_drive_against_a_clamp_contradicts():
    joints = [Clamp("clamp", Site("hub"), ground(0, 0, 0)), hinge("drive", lambda t: 0.1 * t)]
    (again,) = found(joints, [HUB])
    assert again == ("drive", 6, 6, ("clamp",), True)
    assert str(again).startswith("joint 'drive' contradicts 'clamp'")


def test_two_slides_driven_at_odds():
    """A hub on a slide along x, and at a distance that is driven on the same line."""
    slide = Prismatic("slide", Site("hub"), ground(0, 0, 0), X, travel=lambda t: 0.1 * t)
    for speed, contradicts in ((0.1, False), (0.2, True)):
        rod = Distance("rod", Site("hub"), ground(-1, 0, 0), lambda t, v=speed: v * t)
        (again,) = found([slide, rod], [HUB])
        assert (again.joint, again.before, again.contradicts) == ("rod", ("slide",), contradicts)


def test_closed_loop_of_rigid_bars_repeats_three():
    """A planar four-bar of revolutes in space: Grubler counts -2, it moves with 1."""
    bars = [
        rigid("a", (0, 0.5, 0), 0.0),
        rigid("b", (0.5, 1, 0), 0.0),
        rigid("c", (1, 0.5, 0), 0.0),
    ]
    up, down = np.array([0, 0.5, 0]), np.array([0, -0.5, 0])
    left, right = np.array([-0.5, 0, 0]), np.array([0.5, 0, 0])
    joints = [
        Revolute("j1", Site("a", offset=down), ground(0, 0, 0), Z),
        Revolute("j2", Site("b", offset=left), Site("a", offset=up), Z),
        Revolute("j3", Site("c", offset=up), Site("b", offset=right), Z),
        Revolute("j4", Site("c", offset=down), ground(1, 0, 0), Z),
    ]
    (again,) = found(joints, bars)
    assert (again.joint, again.repeated, again.contradicts) == ("j4", 3, False)
    assert again.before == ("j1", "j2", "j3")
    loose = [*joints[:3], Cylindrical("j4", Site("c", offset=down), ground(1, 0, 0), Z)]
    assert found(loose, bars)[0].repeated == 2


def test_gears_in_a_circle_contradict_only_with_drives():
    hubs = [rigid(name, place, 0.0) for name, place in (("one", (0, 0, 0)), ("two", (1, 0, 0)))]
    joints = [
        Revolute("first", Site("one"), ground(0, 0, 0), Z, angle=lambda t: t),
        Revolute("second", Site("two"), ground(1, 0, 0), Z, angle=lambda t: 2.0 * t),
        Gear("gear", "first", "second", 2.0),
    ]
    (again,) = found(joints, hubs)
    assert (again.joint, again.contradicts) == ("gear", False)
    assert set(again.before) >= {"first", "second"}
    joints[2] = Gear("gear", "first", "second", 3.0)
    assert found(joints, hubs)[0].contradicts


def test_a_joint_of_a_point_with_itself_holds_nothing():
    (again,) = found([Spherical("self", Site("hub"), Site("hub"))], [HUB])
    assert str(again) == "joint 'self': 3 of 3 constraints hold nothing"


def test_a_slider_that_is_pinned_as_well():
    joints = [
        Sliding("slider", Site("bead"), "arm"),
        Spherical("pin", Site("bead"), Site("arm", 1)),
    ]
    again = found(joints, [ARM, Particle("bead", X, 1.0)])
    assert [(r.joint, r.repeated) for r in again] == [("pin", 2)]


def test_size_of_the_model_does_not_matter():
    for size in (1e-4, 1e4):
        hub = rigid("hub", np.zeros(3))
        rod = beam("arm", (0, 0, 0), size * DIAGONAL)
        joints = [
            Revolute("a", Site("arm"), ground(0, 0, 0), Z),
            Clamp("b", Site("hub"), Site("arm")),
            Distance("c", Site("arm", 1), Site(None, position=2.0 * size * DIAGONAL)),
        ]
        assert found(joints, [hub, rod]) == []


def test_hundreds_of_hinges_take_no_time():
    beams = [beam(f"m{i}", (i, 0, 0), (i + 1, 0, 0)) for i in range(180)]
    joints = [
        Revolute(f"h{i}", Site(f"m{i}", -1), Site(f"m{i + 1}"), Y) for i in range(179)
    ]  # fmt: skip
    joints += [Spherical("again", Site("m77", -1), Site("m78"))]
    start = time.process_time()
    (again,) = found(joints, beams)
    assert time.process_time() - start < 2.0
    assert again == ("again", 3, 3, ("h77",), False)
