"""Joints: counts, zero in the reference, derivatives by finite differences, what stays free."""

from itertools import product

import numpy as np
import pytest
from joint_cases import (
    BODIES,
    DIAGONAL,
    ENDS,
    POINT,
    Rows,
    X,
    Y,
    Z,
    beam,
    check_derivatives,
    difference,
    rotation,
)

from mechanics.description import (
    AxialDrive,
    Clamp,
    ClearanceRevolute,
    Cylindrical,
    Distance,
    Fixing,
    Gear,
    Guide,
    Latch,
    Planar,
    Prismatic,
    Revolute,
    Site,
    Spherical,
    Universal,
)
from mechanics.layout import Layout

LAYOUT = Layout.of(BODIES)
THERE = Site(None, position=np.array([0.0, 1.0, 1.0]))
ORIENTED = ("arm", "strut", "spar", "pipe", "skin", "hub", "block", "quad", "thick")
LINES = ("wire", "rope", "plate")


def turn(t):
    return 0.3 * t + 0.1 * t**2


def path(t):
    return 0.05 * t - 0.01 * t**2


def own(name):
    """Unit direction that an end with one direction has."""
    return LAYOUT.site(ENDS[name]).frame[1]


def across(name):
    w = np.cross(own(name), X)
    return w / np.linalg.norm(w)


def hinge(journal, bearing, angle=None, axis=DIAGONAL):
    return ClearanceRevolute(
        "j", journal, bearing, axis, 0.025, 5e-5, None, None, 298.15, angle=angle
    )


RIGHT = np.cross(DIAGONAL, X) / np.linalg.norm(np.cross(DIAGONAL, X))
KINDS = {
    "clamp": (lambda a, b: Clamp("j", a, b), 6),
    "spherical": (lambda a, b: Spherical("j", a, b), 3),
    "universal": (lambda a, b: Universal("j", a, b, DIAGONAL, RIGHT), 4),
    "revolute": (lambda a, b: Revolute("j", a, b, DIAGONAL), 5),
    "revolute, driven": (lambda a, b: Revolute("j", a, b, DIAGONAL, turn), 6),
    "cylindrical": (lambda a, b: Cylindrical("j", a, b, DIAGONAL), 4),
    "cylindrical, driven": (lambda a, b: Cylindrical("j", a, b, DIAGONAL, turn, path), 6),
    "prismatic": (lambda a, b: Prismatic("j", a, b, DIAGONAL), 5),
    "prismatic, driven": (lambda a, b: Prismatic("j", a, b, DIAGONAL, path), 6),
    "planar": (lambda a, b: Planar("j", a, b, DIAGONAL), 3),
    "axial drive": (lambda a, b: AxialDrive("j", a, b, DIAGONAL), 1),
    "axial drive, driven": (lambda a, b: AxialDrive("j", a, b, DIAGONAL, path), 1),
    "clearance": (lambda a, b: hinge(a, b), 3),
    "clearance, driven": (lambda a, b: hinge(a, b, turn), 4),
}
PAIRS = [*((a, "ground") for a in ORIENTED), ("ground", "arm"), ("arm", "hub"), ("skin", "strut"),
         ("spar", "pipe"), ("block", "skin"), ("hub", "spar")]  # fmt: skip
CASES = {
    f"{kind} of {a} and {b}": (make(ENDS[a], ENDS[b]), count)
    for (kind, (make, count)), (a, b) in product(KINDS.items(), PAIRS)
}
for line in LINES:
    CASES |= {
        f"clamp of {line}": (Clamp("j", ENDS["arm"], ENDS[line]), 5),
        f"clamp of {line} to ground": (Clamp("j", ENDS[line], ENDS["ground"]), 5),
        f"revolute of {line}": (Revolute("j", ENDS["hub"], ENDS[line], across(line), turn), 5),
        f"prismatic of {line}": (Prismatic("j", ENDS[line], ENDS["spar"], across(line)), 4),
        f"universal of {line}": (
            Universal("j", ENDS[line], ENDS["skin"], own(line), across(line)), 4,
        ),
    }  # fmt: skip
for name in ENDS:
    if name != "ground":
        CASES |= {
            f"distance of {name}": (Distance("j", ENDS[name], THERE), 1),
            f"distance of {name}, driven": (Distance("j", THERE, ENDS[name], path), 1),
            f"guide of {name}": (Guide("j", ENDS[name], np.array([X, DIAGONAL])), 2),
            f"spherical of {name}": (Spherical("j", ENDS[name], ENDS["ground"]), 3),
        }
CASES |= {
    "clearance of a particle": (hinge(ENDS["ball"], ENDS["hub"]), 1),
    "clamp at a distance": (Clamp("j", Site("arm"), ENDS["strut"]), 6),
    "clamp of one body": (Clamp("j", Site("arm"), Site("arm", 2)), 6),
    "spherical of one node": (Spherical("j", ENDS["hub"], Site("hub")), 3),
    "fixing": (Fixing("j", "skin", 3, "r_uv", np.array([X, DIAGONAL])), 2),
    "fixing of a position": (Fixing("j", "ball", 0, "position", Z), 1),
}
SINGULAR = {"spherical of one node"}


@pytest.mark.parametrize("case", CASES)
def test_rows_vanish_in_the_reference(case):
    joint, count = CASES[case]
    rows = Rows([joint])
    assert rows.names == [joint.name] * count
    assert np.abs(rows.values(rows.layout.q0)).max() < 2e-15


@pytest.mark.parametrize("case", CASES)
def test_derivatives_against_finite_differences(case):
    rows = Rows([CASES[case][0]])
    check_derivatives(rows, rows.moved())


@pytest.mark.parametrize("case", [c for c in CASES if c not in SINGULAR])
def test_rows_are_independent_in_the_reference(case):
    rows = Rows([CASES[case][0]])
    J = rows.jacobian(rows.layout.q0)
    assert np.linalg.svd(J, compute_uv=False).min() > 0.04


def rigid_motions(layout, body):
    """(n, 6) velocities of the coordinates of one body in its rigid motions."""
    nodes, kind = layout.node_dofs[body], layout.kinds[body]
    q = layout.q0[nodes[0] : nodes[-1] + kind].reshape(-1, kind // 3, 3)
    columns = np.zeros((layout.ndof, 6))
    for axis in range(3):
        slide, spin = np.zeros_like(q), np.cross(np.eye(3)[axis], q)
        slide[:, 0, axis] = 1.0
        for k, motion in ((axis, slide), (3 + axis, spin)):
            columns[nodes[0] : nodes[-1] + kind, k] = motion.ravel()
    return columns


FREEDOMS = {
    "clamp": 0, "spherical": 3, "universal": 2, "revolute": 1, "cylindrical": 2, "prismatic": 1,
    "planar": 3, "axial drive": 5, "axial drive, driven": 5, "revolute, driven": 0,
    "cylindrical, driven": 0, "prismatic, driven": 0,
}  # fmt: skip


@pytest.mark.parametrize("kind", FREEDOMS)
@pytest.mark.parametrize("pair", [*((a, "ground") for a in ORIENTED), ("ground", "hub")])
def test_as_many_freedoms_of_a_rigid_body_as_the_textbook_says(kind, pair):
    """Rank of the rows on the six rigid motions of the body."""
    rows = Rows([KINDS[kind][0](ENDS[pair[0]], ENDS[pair[1]])])
    body = next(name for name in pair if name != "ground")
    held = rows.jacobian(rows.layout.q0) @ rigid_motions(rows.layout, body)
    assert 6 - np.linalg.matrix_rank(held, tol=1e-6) == FREEDOMS[kind]


@pytest.mark.parametrize("kind", FREEDOMS)
@pytest.mark.parametrize("pair", PAIRS[10:])
def test_joints_resist_no_rigid_motion_of_both_bodies(kind, pair):
    rows = Rows([KINDS[kind][0](ENDS[pair[0]], ENDS[pair[1]])])
    q = (rows.layout.q0.reshape(-1, 3) @ rotation(DIAGONAL, 1.1).T).ravel()
    assert np.abs(rows.values(q)).max() < 1e-14


def turned(layout, body, matrix, centre):
    """Coordinates after a rigid rotation of one body about a point."""
    nodes, kind = layout.node_dofs[body], layout.kinds[body]
    q = layout.q0.copy()
    vectors = q[nodes[0] : nodes[-1] + kind].reshape(-1, kind // 3, 3)
    vectors[:, 0] -= centre
    vectors[:] = vectors @ matrix.T
    vectors[:, 0] += centre
    return q


DRIVEN = [
    ("arm", "strut", DIAGONAL), ("hub", "ground", DIAGONAL), ("spar", "hub", DIAGONAL),
    ("skin", "pipe", DIAGONAL), ("block", "skin", DIAGONAL), ("wire", "arm", across("wire")),
    ("hub", "rope", across("rope")), ("plate", "hub", across("plate")),
]  # fmt: skip


@pytest.mark.parametrize(("a", "b", "axis"), DRIVEN)
def test_drive_turns_the_first_end_about_the_axis(a, b, axis):
    rows = Rows([Revolute("j", ENDS[a], ENDS[b], axis, turn)])

    def values(angle, t):
        return rows.values(turned(rows.layout, a, rotation(axis, angle), POINT), t)

    for t in (0.0, 2.0, 7.0, 30.0):
        assert np.abs(values(turn(t), t)).max() < 1e-13
        rate = difference(lambda x, t=t: values(turn(t) + x[0], t), np.zeros(1))[:, 0]
        assert np.allclose(np.abs(rate), rows.driven, atol=1e-9)


@pytest.mark.parametrize("a", ORIENTED)
def test_slides_are_driven_along_the_axis_as_it_moves(a):
    """Body ``a`` is carried by a turned hub, and moved along the axis that turned with it."""
    body = ENDS[a].body
    other = "hub" if body != "hub" else "strut"
    rows = Rows([Prismatic("j", ENDS[a], ENDS[other], DIAGONAL, path)])
    matrix = rotation(Y, 0.7)
    q = (rows.layout.q0.reshape(-1, 3) @ matrix.T).ravel()
    nodes = rows.layout.node_dofs[body][:, None] + np.arange(3)
    q[nodes] += path(2.0) * matrix @ DIAGONAL
    assert np.abs(rows.values(q, 2.0)).max() < 1e-14
    assert np.abs(rows.values(q, 0.0)).max() == pytest.approx(path(2.0))


def test_distance_follows_its_length():
    rows = Rows([Distance("j", ENDS["ball"], THERE, path)])
    q, away = rows.layout.q0.copy(), POINT - THERE.position
    d = np.linalg.norm(away)
    at = rows.layout.node_dofs["ball"][0]
    q[at : at + 3] = THERE.position + away * (d + path(1.5)) / d
    assert abs(rows.values(q, 1.5)[0]) < 1e-15


def test_clearance_drive_and_tilt_follow_a_turned_journal():
    rows = Rows([hinge(ENDS["arm"], ENDS["strut"], turn)])
    q = turned(rows.layout, "arm", rotation(DIAGONAL, turn(4.0)), POINT)
    q[rows.layout.node_dofs["arm"][-1] + np.arange(3)] += 1e-3 * np.cross(DIAGONAL, X)
    assert np.abs(rows.values(q, 4.0)).max() < 1e-13
    assert np.count_nonzero(rows.driven) == 1


def test_clamp_lets_the_section_of_a_beam_breathe_but_not_turn():
    root, bodies = Site("root"), [beam("root", (0, 0, 0), (2, 1, 0))]
    rows = Rows([Clamp("j", root, Site(None))], bodies)
    q = rows.layout.q0.copy()
    e1, e2, e3 = bodies[0].axes[0]
    q[3:12] = np.concatenate([1.02 * e1, 1.03 * e2 + 0.01 * e3, 0.97 * e3 + 0.01 * e2])
    assert np.abs(rows.values(q)).max() < 1e-15
    for axis in np.eye(3):
        values = rows.values(turned(rows.layout, "root", rotation(axis, 1e-3), np.zeros(3)))
        assert np.isclose(np.linalg.norm(values), 1e-3, rtol=1e-2)


def test_clamp_lets_a_shell_stretch_but_not_turn():
    rows = Rows([Clamp("j", ENDS["skin"], ENDS["ground"])])
    at = rows.layout.node_dofs["skin"][4]
    q = rows.layout.q0.copy()
    u, v = q[at + 3 : at + 6].copy(), q[at + 6 : at + 9].copy()
    q[at + 3 : at + 6], q[at + 6 : at + 9] = 1.02 * u + 0.01 * v, 0.97 * v + 0.01 * u
    assert np.abs(rows.values(q)).max() < 1e-15
    for axis in np.eye(3):
        values = rows.values(turned(rows.layout, "skin", rotation(axis, 1e-3), POINT))
        assert np.isclose(np.linalg.norm(values), 1e-3, rtol=1e-2)


def test_evenly_heated_bodies_keep_their_angle():
    """A direction oblique to the section must not turn when the section grows evenly."""
    for a, b in (("arm", "strut"), ("skin", "spar")):
        rows = Rows([Clamp("j", ENDS[a], ENDS[b]), Revolute("k", ENDS[a], ENDS[b], DIAGONAL)])
        assert np.abs(rows.values(rows.layout.q0 * 1.004)).max() < 2e-14


def test_fixing_holds_a_vector_along_its_directions_only():
    rows = Rows([Fixing("j", "skin", 4, "r_v", np.array([DIAGONAL]))])
    q = rows.layout.q0.copy()
    at = rows.layout.node_dofs["skin"][4] + 6 + np.arange(3)
    q[at] += 0.3 * np.cross(DIAGONAL, Z) + 0.02 * DIAGONAL
    assert rows.values(q) == pytest.approx([0.02])


def test_many_joints_stack():
    joints = [
        Clamp("root", ENDS["arm"], ENDS["ground"]),
        Spherical("pin", ENDS["spar"], ENDS["wire"]),
        Revolute("pivot", ENDS["hub"], ENDS["block"], DIAGONAL, turn),
    ]
    rows = Rows(joints)
    assert sorted(rows.names) == sorted(["root"] * 6 + ["pin"] * 3 + ["pivot"] * 6)
    multipliers = np.concatenate([term.dofs[:, -1] for term in rows.terms])
    assert np.array_equal(multipliers, rows.n + np.arange(rows.m))
    together = dict.fromkeys(("root", "pin", "pivot"), 0.0)
    q = rows.moved()
    for name, value in zip(rows.names, rows.values(q, 2.0), strict=True):
        together[name] += value**2
    for joint in joints:
        alone = Rows([joint], rows.layout.bodies.values())
        assert np.sum(alone.values(q, 2.0) ** 2) == pytest.approx(together[joint.name], rel=1e-14)
    assert Rows([]).terms == []


def test_joints_at_plain_nodes_stay_narrow():
    """A hinge of two beams: positions touch two coordinates, directions two vectors each."""
    rows = Rows([Revolute("j", ENDS["arm"], ENDS["strut"], DIAGONAL)])
    assert [(term.name, term.dofs.shape) for term in rows.terms] == [
        ("linear joints", (3, 7)), ("joints", (2, 14)),
    ]  # fmt: skip
    assert np.count_nonzero(rows.terms[0].dofs >= 0) == 3 * 3


BASE = ENDS["ground"]


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (Clamp("j", ENDS["ball"], BASE), "no orientation"),
        (Revolute("j", ENDS["ball"], BASE, Z), "no orientation"),
        (Prismatic("j", ENDS["hub"], ENDS["ball"], Z), "no orientation"),
        (hinge(ENDS["arm"], ENDS["ball"]), "no orientation"),
        (Clamp("j", ENDS["wire"], ENDS["rope"]), "no direction but its tangent"),
        (Revolute("j", ENDS["arm"], ENDS["wire"], DIAGONAL), "no direction but its tangent"),
        (Revolute("j", ENDS["wire"], ENDS["arm"], own("wire"), turn), "about its own direction"),
        (Universal("j", ENDS["arm"], ENDS["hub"], X, DIAGONAL), "right angles"),
        (Spherical("j", ENDS["arm"], THERE), "m apart"),
        (Universal("j", ENDS["arm"], THERE, X, Y), "m apart"),
        (Distance("j", ENDS["arm"], BASE), "coincide"),
        (Guide("j", ENDS["arm"], np.array([X, X])), "independent"),
        (Guide("j", ENDS["arm"], np.zeros((1, 3))), "no length"),
        (Fixing("j", "skin", 0, "r_x", X), "has no 'r_x': position, r_u"),
        (Fixing("j", "skin", 99, "r_u", X), "nodes, not a node 99"),
        (Fixing("j", "leg", 0, "r_u", X), "no body 'leg'"),
        (Spherical("j", BASE, THERE), "both ends are on the ground"),
        (Spherical("j", Site("leg"), BASE), "no body 'leg'"),
        (Spherical("j", Site("arm", 7), BASE), "3 nodes"),
        (Gear("j", "a", "b", 2.0), "no joint 'a'"),
        (Gear("j", "a", "a", 2.0), "needs two joints|no joint 'a'"),
        (Latch("j", "a", 2.0), "no joint 'a'"),
    ],
)
def test_joints_that_cannot_be_made_name_themselves(joint, message):
    with pytest.raises(ValueError, match=rf"joint '{joint.name}'.*({message})"):
        Rows([joint])


def test_turns_and_travels_are_had_by_hinges_and_slides_only():
    ball = Spherical("ball", ENDS["arm"], ENDS["hub"])
    with pytest.raises(ValueError, match=r"joint 'ball'.*has no turn"):
        Rows([ball, Latch("j", "ball", 1.0)])


# -- layout ------------------------------------------------------------------------------------


def test_layout_numbers_names_and_scales():
    assert LAYOUT.name_of(12 + 7) == "arm node 1 r_y y"
    assert LAYOUT.name_of(60 + 6 + 5) == "wire node 1 r_x z"
    assert LAYOUT.name_of(LAYOUT.node_dofs["ball"][0]) == "ball position x"
    arm = BODIES[0]
    assert np.isclose(LAYOUT.scale[0], np.linalg.norm(arm.points[-1] - arm.points[0]))
    assert LAYOUT.scale[3] == 1.0
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
    layout = Layout.of(BODIES[:3] + BODIES[8:9], [hinge(ENDS["arm"], Site("ball"))])
    assert list(layout.point_index) == ["arm", "strut", "wire", "j.journal", "j.bearing"]
    assert np.array_equal(layout.x[layout.point_index["arm"]], BODIES[0].points)
    assert np.array_equal(layout.axes[layout.point_index["strut"]], BODIES[1].axes)
    assert np.array_equal(layout.x[layout.point_index["j.journal"][0]], POINT)
    assert np.array_equal(layout.x[layout.point_index["j.bearing"][0]], POINT)
    assert not layout.axes[-2:].any()
