"""Joints that own coordinates, ropes, sliders and transmissions against closed forms."""

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
    arc,
    beam,
    check_derivatives,
    rigid,
    rotation,
)

from coupling.verify.models import elastic, straight
from mechanics.description import (
    Clamp,
    Cylindrical,
    Description,
    Gear,
    Latch,
    Particle,
    Prismatic,
    Pulley,
    Revolute,
    Site,
    Sliding,
    Spherical,
    TorsionSpring,
    Universal,
)
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.system import System
from meshes.sections import rectangle


def ground(*position):
    return Site(None, position=np.array(position, float))


def turn_of(rows, body, about, zero):
    """Angle [rad] of e1 of a rigid body about an axis, from direction ``zero``."""

    def angle(q):
        at = rows.layout.node_dofs[body][0]
        e1 = q[at + 3 : at + 6]
        return np.arctan2(e1 @ np.cross(about, zero), e1 @ zero)

    return angle


# -- turns and travels -------------------------------------------------------------------------

TURNING = [("arm", "strut"), ("hub", "ground"), ("ground", "hub"), ("spar", "skin"), ("hub", "arm")]


@pytest.mark.parametrize(("a", "b"), TURNING)
def test_turn_as_a_coordinate_against_finite_differences(a, b):
    joints = [Revolute("h", ENDS[a], ENDS[b], DIAGONAL), Latch("j", "h", 2.0)]
    rows = Rows(joints)
    for rows.caught in (False, True):
        q = rows.moved()
        q[rows.layout.joint_dofs["h.turn"]] = 2.7
        check_derivatives(rows, q)


def test_turn_of_a_cable_and_travel_against_finite_differences():
    axis = np.cross(BODIES[2].axes[0, 0], X)
    joints = [
        Revolute("h", ENDS["arm"], ENDS["wire"], axis),
        TorsionSpring("s", "h", 3.0),
        Prismatic("p", ENDS["block"], ENDS["spar"], DIAGONAL),
        Latch("l", "p", 0.1),
    ]
    rows = Rows(joints)
    assert set(rows.layout.joint_dofs) == {"h.turn", "p.travel"}
    rows.caught = True
    check_derivatives(rows, rows.moved())


def test_turn_counts_revolutions_about_the_axis():
    """A hub turned in steps through five revolutions carries its coordinate along."""
    joints = [Revolute("h", Site("hub"), ground(0, 0, 0), DIAGONAL), TorsionSpring("s", "h", 1.0)]
    rows = Rows(joints, [rigid("hub", np.zeros(3))])
    q, own = rows.layout.q0.copy(), rows.layout.joint_dofs["h.turn"]
    start = q[3:12].reshape(3, 3).copy()
    for angle in np.arange(0.3, 10 * np.pi, 0.3):
        q[3:12] = (start @ rotation(DIAGONAL, angle).T).ravel()
        J = rows.jacobian(q)
        q[own] -= (J[:, own] @ rows.values(q)) / (J[:, own] @ J[:, own])
        for _ in range(3):
            q[own] -= (J[:, own] @ rows.values(q)) / (J[:, own] @ rows.jacobian(q)[:, own])
        assert q[own] == pytest.approx(angle, abs=1e-12)


def test_gear_over_many_turns():
    """Two wheels on parallel axes: the second turns by the ratio, eight revolutions long."""
    wheels = [rigid("one", np.zeros(3), 0.0), rigid("two", X, 0.0)]
    joints = [
        Revolute("first", Site("one"), ground(0, 0, 0), Z, angle=lambda t: t),
        Cylindrical("second", Site("two"), ground(1, 0, 0), Z, travel=lambda t: 0.1 * t),
        Gear("gear", "first", "second", -2.5),
    ]
    rows = Rows(joints, wheels, rigid_too=True)
    assert rows.m == rows.n
    q, angle = rows.layout.q0.copy(), turn_of(rows, "two", Z, X)
    for t in np.arange(0.25, 16 * np.pi, 0.25):
        q = rows.follow(q, t)
        assert q[rows.layout.joint_dofs["second.turn"]] == pytest.approx(-2.5 * t, abs=1e-11)
        assert np.exp(1j * angle(q)) == pytest.approx(np.exp(-2.5j * t), abs=1e-11)
        assert q[rows.layout.node_dofs["two"][0] + 2] == pytest.approx(0.1 * t)


def test_gear_shares_its_moment_by_the_ratio():
    """Statics: a moment M on the second wheel is held by ratio M on the first."""
    wheels = [rigid("one", np.zeros(3), 0.0), rigid("two", X, 0.0)]
    joints = [
        Revolute("first", Site("one"), ground(0, 0, 0), Z),
        Revolute("second", Site("two"), ground(1, 0, 0), Z),
        Gear("gear", "first", "second", 3.0),
    ]
    rows = Rows(joints, wheels, rigid_too=True)
    turns = [rows.layout.joint_dofs[f"{name}.turn"] for name in ("first", "second")]
    load = np.zeros(rows.n)
    load[turns] = -3.0 * 0.7, 0.7
    _, lam = rows.balance(rows.layout.q0, load, np.arange(rows.n))
    assert lam[rows.names.index("gear")] == pytest.approx(0.7)
    load[turns] = -3.0 * 0.7 + 0.1, 0.7
    with pytest.raises(AssertionError, match="forces left"):
        rows.balance(rows.layout.q0, load, np.arange(rows.n))


def test_universal_joint_transmits_as_a_cardan_joint():
    """tan b = cos(beta) tan a, for shafts at angle beta (Hooke's joint)."""
    beta = 0.7
    shaft = np.array([np.cos(beta), np.sin(beta), 0.0])
    bodies = [rigid("in", np.zeros(3), 0.0), rigid("out", np.zeros(3), 0.0)]
    joints = [
        Revolute("drive", Site("in"), ground(0, 0, 0), X, angle=lambda t: t),
        Cylindrical("bearing", Site("out"), ground(0, 0, 0), shaft),
        Universal("cardan", Site("in"), Site("out"), Z, np.cross(Z, shaft)),
    ]
    rows = Rows(joints, bodies, rigid_too=True)
    q = rows.layout.q0.copy()
    at = rows.layout.node_dofs["out"][0]
    for a in np.arange(0.1, 2 * np.pi, 0.1):
        q = rows.follow(q, a)
        e3 = q[at + 9 : at + 12]  # was z, turns about the shaft
        b = np.arctan2(e3 @ np.cross(shaft, Z), e3 @ Z)
        assert np.exp(2j * b) == pytest.approx(
            np.exp(2j * np.arctan2(np.cos(beta) * np.sin(a), np.cos(a))), abs=1e-11
        )


# -- latches -----------------------------------------------------------------------------------


def test_latch_holds_nothing_before_it_has_caught_and_the_turn_afterwards():
    joints = [Revolute("h", Site("hub"), ground(0, 0, 0), Z), Latch("latch", "h", 0.5)]
    rows = Rows(joints, [rigid("hub", np.zeros(3), 0.0)], rigid_too=True)
    term = next(term for term in rows.terms if getattr(term, "latches", None))
    (latch,) = term.latches
    assert (term.names[latch.row], latch.at) == ("latch", 0.5)
    assert latch.coordinate == rows.layout.joint_dofs["h.turn"]
    lam = np.random.default_rng(3).standard_normal(rows.m)
    at = rows.names.index("latch")
    q = rows.layout.q0
    assert rows.force(q, lam)[rows.n + at] == lam[at]
    without = lam.copy()
    without[at] = 0.0
    assert np.array_equal(rows.force(q, lam)[: rows.n], rows.force(q, without)[: rows.n])
    full = rows.tangent(q, lam)
    assert np.count_nonzero(full[rows.n + at]) == full[rows.n + at, rows.n + at] == 1.0
    rows.caught = True
    held = rows.follow(q, 0.0)
    assert turn_of(rows, "hub", Z, X)(held) == pytest.approx(0.5)


def test_latch_at_the_reference_holds_from_the_start():
    joints = [Prismatic("p", Site("hub"), ground(0, 0, 0), Z), Latch("latch", "p", 0.0)]
    rows = Rows(joints, [rigid("hub", np.zeros(3), 0.0)])
    assert not any(term.latches for term in rows.terms)
    assert all(term.start[:, 1:].all() for term in rows.terms)


# -- ropes -------------------------------------------------------------------------------------


def test_rope_against_finite_differences():
    path = [
        Site("ball"), ground(0, 1, 1), Site("pipe", 1), ground(2, 0, 0),
        Site("spar", 1, fraction=0.4),
        Site("block", offset=np.array([0.5, 0.2, 0.1])),
    ]  # fmt: skip
    rows = Rows([Pulley("r", path, winch=lambda t: 0.1 * t), Pulley("s", path[:2])])
    assert np.abs(rows.values(rows.layout.q0)).max() < 1e-14
    check_derivatives(rows, rows.moved())


def test_load_on_a_rope_hangs_where_both_segments_are_alike():
    """Rope of length l between points at distance a: tension W/(2 cos), tan = a/sqrt(l^2-a^2)."""
    ball = Particle("ball", np.array([0.3, 0.0, -1.2]), 1.0)
    path = [ground(0, 0, 0), Site("ball"), ground(1.0, 0, 0)]
    rows = Rows([Pulley("rope", path, winch=lambda t: t)], [ball])
    start = np.hypot(0.3, 1.2) + np.hypot(0.7, 1.2)
    for paid in (0.0, 0.4):
        length = start + paid
        q, lam = rows.balance(rows.layout.q0, np.array([0, 0, -9.0]), np.arange(3), paid)
        depth = np.sqrt(length**2 - 1.0) / 2.0
        assert q == pytest.approx([0.5, 0.0, -depth], abs=1e-10)
        assert lam[0] == pytest.approx(9.0 / 2.0 / (2.0 * depth / length))


def test_rope_over_a_carried_pulley_pulls_with_twice_its_tension():
    """A block in the bight of a rope: 2 T = W, the other end needs T."""
    bodies = [Particle("block", np.array([0, 0, -1.0]), 1.0), Particle("hand", X - Z, 1.0)]
    path = [ground(0, 0, 0), Site("block"), ground(0, 0, 0), ground(1, 0, 0), Site("hand")]
    rows = Rows([Pulley("rope", path)], bodies)
    load = np.zeros(6)
    load[[2, 5]] = -8.0, -4.0
    _, lam = rows.balance(rows.layout.q0, load, np.arange(6))
    assert lam[0] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("path", "length", "message"),
    [
        ([ground(0, 0, 0), ground(1, 0, 0)], None, "goes to no body"),
        ([Site("ball")], None, "goes to no body"),
        ([Site("ball"), ground(*POINT)], None, "coincide"),
        ([Site("ball"), ground(0, 0, 0)], 1.0, "m long, its rope 1 m"),
    ],
)
def test_ropes_that_cannot_be_made_name_themselves(path, length, message):
    with pytest.raises(ValueError, match=rf"joint 'rope'.*{message}"):
        Rows([Pulley("rope", path, length=length)])


# -- sliding -----------------------------------------------------------------------------------


def slider_bodies(element):
    rail = arc("rail", 2.0, 1.5, 5, element)
    middle = 2.0 * np.array([np.cos(0.75), np.sin(0.75), 0.0])
    shifted = beam("runner", middle, middle + np.array([0.4, 0.3, 0.5]))
    string = beam("string", middle, middle - np.array([0.3, 0.3, 0.9]), element="cable")
    return [rail, shifted, rigid("car", middle), Particle("bead", middle, 1.0), string]


def slider(end, aligned=False, travel=None):
    return Sliding("slider", end, "rail", aligned, travel)


@pytest.mark.parametrize("element", ["beam3243", "cable"])
@pytest.mark.parametrize(
    ("end", "aligned"),
    [("bead", False), ("runner", False), ("string", False), ("car", True), ("runner", True)],
)
@pytest.mark.parametrize("place", [0.31, 1.24, 1.9, -0.2, 3.4])
def test_sliding_against_finite_differences(element, end, aligned, place):
    rows = Rows([slider(Site(end), aligned, lambda t: 0.1 * t)], slider_bodies(element))
    q = rows.moved(amount=0.1)
    q[rows.layout.joint_dofs["slider.place"]] = place
    check_derivatives(rows, q, tolerance=2e-7)


@pytest.mark.parametrize("element", ["beam3243", "cable"])
def test_slider_starts_at_the_nearest_point_and_drops_nothing(element):
    rows = Rows([slider(Site("car"), aligned=True)], slider_bodies(element))
    q0 = rows.layout.q0
    assert np.abs(rows.values(q0)).max() < 1e-12
    (limit,) = (limit for term in rows.terms for limit in term.limits)
    assert q0[limit.coordinate] == pytest.approx(0.5 * limit.upper, abs=1e-9)
    assert rows.m == (6 if element == "beam3243" else 5)
    assert np.linalg.svd(rows.jacobian(q0), compute_uv=False).min() > 0.1


def test_slider_follows_its_drive_along_a_curved_beam():
    """On the arc within h^4 max|r''''|/384 of cubics; sections on the chord of those at nodes."""
    rows = Rows([slider(Site("car"), True, lambda t: t)], slider_bodies("beam3243"), True)
    (limit,) = (limit for term in rows.terms for limit in getattr(term, "limits", ()))
    q, at = rows.layout.q0.copy(), rows.layout.node_dofs["car"][0]
    free = np.append(at + np.arange(12), limit.coordinate)
    for way in (0.05, 0.125, 0.25, 0.4, 0.5, -0.25, -0.5):
        for _ in range(40):
            values = rows.values(q, way * limit.upper)
            J = rows.jacobian(q, way * limit.upper)[:, free]
            q[free] -= np.linalg.lstsq(J, values, rcond=1e-10)[0]
        assert np.abs(rows.values(q, way * limit.upper)).max() < 1e-12
        phi, x = 0.75 + 1.5 * way, 4.0 * way % 1.0
        expected = 2.0 * np.array([np.cos(phi), np.sin(phi), 0.0])
        bound = 0.75**4 / 8.0 / 384.0 if x else 1e-10
        assert q[at : at + 3] == pytest.approx(expected, abs=bound)
        chord = np.arctan2(x * np.sin(0.375), 1.0 - x + x * np.cos(0.375))
        turned = rotation(Z, 1.5 * way + chord - 0.375 * x) @ q_axes(rows)
        assert pytest.approx(turned, abs=1e-10) == q[at + 3 : at + 12].reshape(3, 3).T


def q_axes(rows):
    at = rows.layout.node_dofs["car"][0]
    return rows.layout.q0[at + 3 : at + 12].reshape(3, 3).T


def test_slider_on_a_rigid_chute_rests_at_the_lowest_point():
    """Down is towards the middle of the arc from outside: no force along the axis."""
    rows = Rows([slider(Site("bead"))], slider_bodies("beam3243"))
    q, at = rows.layout.q0.copy(), rows.layout.node_dofs["bead"][0]
    place = rows.layout.joint_dofs["slider.place"]
    down = np.array([np.cos(1.0), np.sin(1.0), 0.0])
    load = np.zeros(rows.n)
    load[at : at + 3] = 5.0 * down
    q[place] = 1.8
    found, lam = rows.balance(q, load, np.array([at, at + 1, at + 2, place]))
    assert found[place] == pytest.approx(2.0, abs=1e-3)
    assert lam == pytest.approx(5.0 * down)
    tangent = np.zeros(rows.n)
    tangent[place] = 1.0
    assert abs(rows.force(found, lam)[: rows.n] @ tangent) < 1e-12
    total = rows.force(found, lam)[: rows.n]
    nodes = rows.layout.node_dofs["rail"][:, None] + np.arange(3)
    assert total[nodes].sum(axis=0) == pytest.approx(-5.0 * down)


def test_slider_passes_from_element_to_element_without_a_jump():
    """Values, slopes and forces on both sides of a node, of an uneven beam that has been bent."""
    rows = Rows([slider(Site("car"), aligned=True)], slider_bodies("beam3243"))
    q = rows.moved(amount=0.1)
    place = rows.layout.joint_dofs["slider.place"]
    lam = np.random.default_rng(4).standard_normal(rows.m)
    lam[3:] = 0.0  # position rows: no kink; orientation rows: no jump
    before, after = q.copy(), q.copy()
    before[place], after[place] = 1.5 - 1e-9, 1.5 + 1e-9
    jump = rows.force(after, lam) - rows.force(before, lam)
    assert np.abs(jump).max() < 2e-7
    slope = rows.jacobian(after)[:3] - rows.jacobian(before)[:3]
    assert np.abs(slope).max() < 2e-7


def test_slider_knows_where_its_body_ends():
    rows = Rows([slider(Site("bead"))], slider_bodies("beam3243"))
    (limit,) = (limit for term in rows.terms for limit in term.limits)
    assert limit.coordinate == rows.layout.joint_dofs["slider.place"]
    assert (limit.lower, limit.upper) == (0.0, pytest.approx(3.0, abs=1e-4))
    assert limit.reason == "joint 'slider' slides off the end of 'rail'"


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (Sliding("s", Site("bead"), "car"), "no beam or cable to slide on"),
        (Sliding("s", Site("rail", 1), "rail"), "does not slide on itself"),
        (Sliding("s", ground(0, 0, 3), "rail"), "m off the axis"),
        (Sliding("s", Site("bead"), "rail", aligned=True), "no orientation"),
    ],
)
def test_sliders_that_cannot_be_made_name_themselves(joint, message):
    with pytest.raises(ValueError, match=rf"joint 's'.*{message}"):
        Rows([joint], slider_bodies("beam3243"))


def test_spherical_joint_between_nodes_takes_the_point_of_the_axis():
    """Against the cubic itself: the point moves with (r_a + r_b)/2 + L (r_x,a − r_x,b)/8."""
    rows = Rows([Spherical("j", Site("spar", 1, fraction=0.3), ENDS["hub"])])
    layout = rows.layout
    a, b = layout.node_dofs["spar"][1:3]
    J, x = rows.jacobian(rows.layout.q0), 0.3
    L = np.linalg.norm(BODIES[3].points[2] - BODIES[3].points[1])
    expected = {
        a: (1 - x) ** 2 * (1 + 2 * x), a + 3: L * x * (1 - x) ** 2,
        b: x * x * (3 - 2 * x), b + 3: L * x * x * (x - 1),
    }  # fmt: skip
    for column, weight in expected.items():
        assert J[:, column : column + 3] == pytest.approx(weight * np.eye(3), abs=1e-15)
    assert J[:, layout.node_dofs["hub"][0]] == pytest.approx([-1.0, 0.0, 0.0])


def test_axis_of_a_slide_is_that_of_its_second_end():
    """The first body goes along the axis as the second has turned it, not as it was."""
    rows = Rows([Prismatic("p", Site("car"), Site("runner"), Y)], slider_bodies("beam3243"))
    q = (rows.layout.q0.reshape(-1, 3) @ rotation(DIAGONAL, 0.8).T).ravel()
    at = rows.layout.node_dofs["car"][0]
    q[at : at + 3] += 0.3 * rotation(DIAGONAL, 0.8) @ Y
    assert np.abs(rows.values(q)).max() < 1e-14
    q[at : at + 3] += 0.1 * rotation(DIAGONAL, 0.8) @ X
    assert np.linalg.norm(rows.values(q)) == pytest.approx(0.1)


# -- in motion ---------------------------------------------------------------------------------


def run(description, times, control):
    """Motions at the given times, and the last reason."""
    system = System(description)
    coef = system.coefficients(np.tile([293.15, 0.0, 0.0], (len(system.layout.x), 1)))
    state, why = initial_state(system, control, coef)
    motions = []
    for h in np.diff(times, prepend=0.0):
        if not why:
            state, _, why = advance(
                system, control, state, Window(state.motion.t, h, coef, coef)
            )  # fmt: skip
            motions.append(state.motion)
    return system, motions, why


def test_bead_slides_down_a_stiff_beam_and_off_its_end():
    """s = s0 + g sin(slope) t^2/2, but for what the beam yields."""
    slope, start = 0.3, 0.3
    rail = straight(2.0, 4, rectangle(0.05, 0.05), elastic(70e9, 0.3, 2700.0))
    joints = [
        Clamp("near", Site("beam"), ground(0, 0, 0)),
        Clamp("far", Site("beam", -1), ground(2, 0, 0)),
        Sliding("slide", Site("bead"), "beam"),
    ]
    down = 9.81 * np.array([np.sin(slope), 0.0, -np.cos(slope)])
    scene = Description([rail, Particle("bead", start * X, 0.1)], joints, gravity=down)
    system, motions, why = run(scene, [0.4, 0.8, 1.2], Control(1e-6, 1e-2))
    place = system.layout.joint_dofs["slide.place"]
    for motion in motions[:2]:
        expected = start + 0.5 * 9.81 * np.sin(slope) * motion.t**2
        assert motion.q[place] == pytest.approx(expected, rel=1e-3)
    assert "joint 'slide' slides off the end of 'beam'" in why


def test_falling_bar_is_caught_by_its_latch_and_stays():
    bar = rigid("bar", X, 0.0)
    joints = [
        Revolute("pivot", Site("bar", offset=-X), ground(0, 0, 0), Z),
        Latch("latch", "pivot", -0.8),
    ]
    scene = Description([bar], joints, gravity=np.array([0.0, -9.81, 0.0]))
    system, motions, why = run(scene, [0.2, 0.6, 1.0], Control(1e-6, 1e-2))
    assert not why
    turn = system.layout.joint_dofs["pivot.turn"]
    assert -0.8 < motions[0].q[turn] < -0.1
    for motion in motions[1:]:
        assert motion.q[turn] == pytest.approx(-0.8, abs=1e-9)
        assert np.abs(motion.v).max() < 1e-9
        moment = 2.0 * 9.81 * np.cos(0.8)
        row = [name == "latch" for name in system.row_names].index(True)
        assert abs(motion.lam[row]) == pytest.approx(moment, rel=1e-6)
