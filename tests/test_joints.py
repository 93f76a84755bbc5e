"""Joints: counts, zero in the reference, derivatives by finite differences, what stays free."""

import numpy as np
import pytest

from mechanics.description import (
    Beam,
    Clamp,
    ClearanceRevolute,
    Distance,
    Guide,
    Particle,
    Revolute,
    Site,
    Spherical,
)
from mechanics.joints import build
from mechanics.layout import Layout

X, Y, Z = np.eye(3)
DIAGONAL = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)


def triad(tangent, normal):
    e1 = tangent / np.linalg.norm(tangent)
    e2 = normal - (normal @ e1) * e1
    e2 /= np.linalg.norm(e2)
    return np.array([e1, e2, np.cross(e1, e2)])


def beam(name, start, end, nodes=2, element="beam3243", **motion):
    start, end = np.array(start, float), np.array(end, float)
    points = np.linspace(start, end, nodes)
    axes = np.tile(triad(end - start, np.array([0.3, 1.0, 0.2])), (nodes, 1, 1))
    return Beam(name, points, axes, None, None, 293.15, element=element, **motion)


ARM = beam("arm", (1, 2, 3), (3, 2.5, 3.2), 3)
STRUT = beam("strut", (3, 2.5, 3.2), (3.4, 1.0, 4.0))
WIRE = beam("wire", (3, 2.5, 3.2), (1.0, 4.5, 3.2 + 15.0), element="cable")
BALL = Particle("ball", np.array([0.5, 0.2, 0.1]), 2.0, np.array([1.0, 0.0, 0.0]))
BODIES = (ARM, STRUT, WIRE, BALL)
LAYOUT = Layout.of(BODIES)
ROOT, TIP = Site("arm", 0), Site("arm", -1)
BASE, THERE = Site(None, position=ARM.points[0]), Site(None, position=np.array([0.0, 1.0, 1.0]))
STRUT_END, WIRE_END, MASS = Site("strut", 0), Site("wire", 0), Site("ball")
ACROSS_WIRE = np.cross(WIRE.axes[0, 0], X) / np.linalg.norm(np.cross(WIRE.axes[0, 0], X))


def turn(t):
    return 0.3 * t + 0.1 * t**2


def hinge(journal, bearing, angle=None, axis=DIAGONAL):
    return ClearanceRevolute(
        "hinge", journal, bearing, axis, 0.025, 5e-5, None, None, 298.15, angle=angle
    )


CASES = {
    "clamp to ground": (Clamp("j", ROOT, BASE), 6),
    "clamp of ground": (Clamp("j", BASE, ROOT), 6),
    "clamp of two bodies": (Clamp("j", TIP, STRUT_END), 6),
    "clamp at a distance": (Clamp("j", ROOT, STRUT_END), 6),
    "clamp of a cable": (Clamp("j", TIP, WIRE_END), 5),
    "clamp of a cable to ground": (Clamp("j", WIRE_END, Site(None, position=WIRE.points[0])), 5),
    "spherical to ground": (Spherical("j", ROOT, BASE), 3),
    "spherical of two bodies": (Spherical("j", TIP, WIRE_END), 3),
    "revolute to ground": (Revolute("j", ROOT, BASE, Z), 5),
    "revolute of two bodies": (Revolute("j", TIP, STRUT_END, DIAGONAL), 5),
    "revolute, driven": (Revolute("j", TIP, STRUT_END, DIAGONAL, turn), 6),
    "revolute of a cable, driven": (Revolute("j", TIP, WIRE_END, ACROSS_WIRE, turn), 5),
    "revolute of ground, driven": (Revolute("j", BASE, ROOT, DIAGONAL, turn), 6),
    "distance to ground": (Distance("j", MASS, THERE), 1),
    "distance of two bodies": (Distance("j", STRUT_END, MASS), 1),
    "guide": (Guide("j", TIP, np.array([X, DIAGONAL])), 2),
    "clearance to ground": (hinge(ROOT, BASE), 3),
    "clearance of two bodies, driven": (hinge(TIP, STRUT_END, turn), 4),
    "clearance of a particle": (hinge(MASS, ROOT), 1),
}


def moved(seed=1, amount=0.2):
    """Coordinates away from the reference, sections strained and sheared."""
    return LAYOUT.q0 + amount * np.random.default_rng(seed).standard_normal(LAYOUT.ndof)


def dense(constraints, blocks):
    """(m, n) matrix of rows."""
    full = np.zeros((len(blocks), LAYOUT.ndof + 1))
    for row, dofs, block in zip(full, constraints.dofs, blocks, strict=True):
        np.add.at(row, dofs, block)
    return full[:, :-1]


def jacobian(constraints, q, t):
    blocks = np.full((len(constraints.names), 18), np.nan)
    constraints.jacobian(q, t, blocks)
    return dense(constraints, blocks)


def difference(function, q, step=1e-6):
    columns = [
        (function(q + step * e) - function(q - step * e)) / (2 * step) for e in np.eye(q.size)
    ]
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("case", CASES)
def test_rows_vanish_in_the_reference(case):
    joint, count = CASES[case]
    constraints = build([joint], LAYOUT)
    assert constraints.names == (joint.name,) * count
    assert np.abs(constraints.values(LAYOUT.q0, 0.0)).max() < 1e-15


@pytest.mark.parametrize("case", CASES)
def test_derivatives_against_finite_differences(case):
    constraints = build([CASES[case][0]], LAYOUT)
    q, m = moved(), len(constraints.names)
    lam = np.random.default_rng(2).standard_normal(m)
    for t in (0.0, 1.7, 5.3):
        exact = difference(lambda x, t=t: constraints.values(x, t), q)
        assert np.allclose(jacobian(constraints, q, t), exact, rtol=0, atol=2e-9)

        def force(x, t=t):
            out = np.zeros(LAYOUT.ndof)
            constraints.add_force(x, t, lam, out)
            return out

        assert np.allclose(force(q), exact.T @ lam, rtol=0, atol=1e-8)
        blocks = np.full((m, 18, 18), np.nan)
        constraints.hessian(q, t, lam, -0.7, blocks)
        total = np.zeros((LAYOUT.ndof + 1, LAYOUT.ndof + 1))
        for dofs, block in zip(constraints.dofs, blocks, strict=True):
            np.add.at(total, (dofs[:, None], dofs[None]), block)
        expected = -0.7 * difference(force, q)
        assert np.allclose(total[:-1, :-1], expected, rtol=0, atol=5e-9)


@pytest.mark.parametrize("case", CASES)
def test_rows_are_independent_in_the_reference_and_at_every_angle(case):
    constraints = build([CASES[case][0]], LAYOUT)
    smallest = np.linalg.svd(jacobian(constraints, LAYOUT.q0, 0.0), compute_uv=False).min()
    assert smallest > 0.3


def rotation(axis, angle):
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def turned(body, matrix, centre):
    """Coordinates after a rigid rotation of one body about a point."""
    nodes = LAYOUT.node_dofs[body]
    kind = LAYOUT.kinds[body]
    q = LAYOUT.q0.copy()
    vectors = q[nodes[0] : nodes[-1] + kind].reshape(-1, kind // 3, 3)
    vectors[:, 0] -= centre
    vectors[:] = vectors @ matrix.T
    vectors[:, 0] += centre
    return q


@pytest.mark.parametrize(
    ("case", "sign", "centre"),
    [
        ("revolute, driven", 1, ARM.points[-1]),
        ("revolute of a cable, driven", 1, ARM.points[-1]),
        ("revolute of ground, driven", -1, ARM.points[0]),
    ],
)
def test_drive_turns_the_first_end_about_the_axis(case, sign, centre):
    joint = CASES[case][0]
    constraints = build([joint], LAYOUT)

    def values(angle, t):
        return constraints.values(turned("arm", rotation(joint.axis, sign * angle), centre), t)

    for t in (0.0, 2.0, 7.0, 30.0):
        assert np.abs(values(turn(t), t)).max() < 1e-13
        rate = difference(lambda a, t=t: values(turn(t) + a[0], t), np.zeros(1))[:, 0]
        assert np.allclose(np.abs(rate), constraints.driven, atol=1e-9)


def test_clearance_drive_and_tilt_follow_a_turned_journal():
    constraints = build([hinge(TIP, STRUT_END, turn)], LAYOUT)
    q = turned("arm", rotation(DIAGONAL, turn(4.0)), ARM.points[-1])
    eccentric = q.copy()
    eccentric[LAYOUT.node_dofs["arm"][-1] + np.arange(3)] += 1e-3 * np.cross(DIAGONAL, X)
    assert np.abs(constraints.values(eccentric, 4.0)).max() < 1e-13
    assert constraints.driven.tolist() == [False, False, False, True]


def test_clamp_lets_the_section_breathe_but_not_turn():
    constraints = build([Clamp("root", ROOT, BASE)], LAYOUT)
    q = LAYOUT.q0.copy()
    e1, e2, e3 = ARM.axes[0]
    q[3:12] = np.concatenate([1.02 * e1, 1.03 * e2 + 0.01 * e3, 0.97 * e3 + 0.01 * e2])
    assert np.abs(constraints.values(q, 0.0)).max() < 1e-15
    for axis in np.eye(3):
        matrix = rotation(axis, 1e-3)
        values = constraints.values(turned("arm", matrix, ARM.points[0]), 0.0)
        assert np.isclose(np.linalg.norm(values), 1e-3, rtol=1e-2)


def test_evenly_heated_bodies_keep_their_angle():
    """A direction oblique to the section must not turn when the section grows evenly."""
    constraints = build([Clamp("joint", TIP, STRUT_END)], LAYOUT)
    hot = LAYOUT.q0 * 1.004  # everything grows about the origin
    assert np.abs(constraints.values(hot, 0.0)).max() < 1e-15


def test_rigid_motion_of_two_bodies_keeps_their_joint():
    q = LAYOUT.q0.reshape(-1, 3) @ rotation(DIAGONAL, 1.1).T
    for case in ("clamp of two bodies", "clamp at a distance", "revolute of two bodies"):
        assert np.abs(build([CASES[case][0]], LAYOUT).values(q.ravel(), 0.0)).max() < 1e-14


def test_many_joints_stack():
    joints = [Clamp("root", ROOT, BASE), Spherical("pin", TIP, WIRE_END), hinge(MASS, ROOT)]
    constraints = build(joints, LAYOUT)
    assert constraints.names == ("root",) * 6 + ("pin",) * 3 + ("hinge",)
    parts = [build([joint], LAYOUT).values(moved(), 0.0) for joint in joints]
    assert np.array_equal(constraints.values(moved(), 0.0), np.concatenate(parts))
    assert build([], LAYOUT).values(LAYOUT.q0, 0.0).shape == (0,)


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (Clamp("j", MASS, Site(None, position=BALL.position)), "no orientation"),
        (Revolute("j", MASS, Site(None, position=BALL.position), Z), "no orientation"),
        (hinge(ROOT, MASS), "no orientation"),
        (Clamp("j", WIRE_END, Site("wire", 0)), "no direction but its tangent"),
        (Revolute("j", TIP, WIRE_END, DIAGONAL), "no direction but its tangent"),
        (Spherical("j", ROOT, THERE), "m apart"),
        (Distance("j", ROOT, BASE), "coincide"),
        (Guide("j", ROOT, np.array([X, X])), "independent"),
        (Guide("j", ROOT, np.zeros((1, 3))), "no length"),
        (Spherical("j", BASE, THERE), "both ends are on the ground"),
        (Spherical("j", Site("leg"), BASE), "no body 'leg'"),
        (Spherical("j", Site("arm", 7), BASE), "3 nodes"),
    ],
)
def test_joints_that_cannot_be_made_name_themselves(joint, message):
    with pytest.raises(ValueError, match=rf"joint '{joint.name}'.*{message}"):
        build([joint], LAYOUT)


def test_layout_numbers_names_and_scales():
    assert LAYOUT.ndof == 3 * 12 + 2 * 12 + 2 * 6 + 3
    assert LAYOUT.name_of(12 + 7) == "arm node 1 r_y y"
    assert LAYOUT.name_of(60 + 6 + 5) == "wire node 1 r_x z"
    assert LAYOUT.name_of(LAYOUT.ndof - 3) == "ball position x"
    assert np.isclose(LAYOUT.scale[0], np.linalg.norm(ARM.points[-1] - ARM.points[0]))
    assert LAYOUT.scale[3] == LAYOUT.scale[-1] == 1.0
    with pytest.raises(IndexError):
        LAYOUT.name_of(LAYOUT.ndof)


def test_layout_spins_bodies_rigidly():
    """Velocity of every coordinate against the displaced rigid body."""
    spin, velocity = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, 3.0])
    layout = Layout.of([beam("a", (1, 2, 3), (2, 2, 2), 3, spin=spin, velocity=velocity)])
    angle = 1e-6
    matrix = rotation(spin / np.linalg.norm(spin), angle * np.linalg.norm(spin))
    q = layout.q0.reshape(3, 4, 3)
    after = q @ matrix.T
    after[:, 0] += angle * velocity
    assert np.allclose((after - q).ravel() / angle, layout.v0, atol=1e-5)


def test_layout_lists_temperature_points():
    layout = Layout.of(BODIES, [hinge(TIP, Site("ball"))])
    assert list(layout.point_index) == ["arm", "strut", "wire", "hinge.journal", "hinge.bearing"]
    assert np.array_equal(layout.x[layout.point_index["arm"]], ARM.points)
    assert np.array_equal(layout.axes[layout.point_index["strut"]], STRUT.axes)
    assert np.array_equal(layout.x[layout.point_index["hinge.journal"][0]], ARM.points[-1])
    assert np.array_equal(layout.x[layout.point_index["hinge.bearing"][0]], BALL.position)
    assert not layout.axes[-2:].any()
