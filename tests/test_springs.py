"""Springs, ropes, torsion springs and bushings."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from slopes import expected_jacobian, force, jacobian, slopes

from mechanics import kernels, springs
from mechanics.description import (
    Beam,
    Bushing,
    Description,
    Particle,
    Pulley,
    Revolute,
    RigidBody,
    Site,
    Spring,
    TorsionSpring,
)
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.layout import Layout
from mechanics.ledger import TERMS
from mechanics.schemes import Scheme
from mechanics.system import System
from meshes.materials import constant_material
from meshes.sections import circle

STEEL = constant_material("steel", 7800.0, 210e9, 0.3, 12e-6, 16.0, 500.0)
TURN = Rotation.from_rotvec([0.4, -0.2, 0.9]).as_matrix()
STIFFNESS = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
POINTS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
BODIES = [
    Beam("arm", POINTS, np.tile(np.eye(3), (3, 1, 1)), circle(0.2), STEEL, 293.15),
    Particle("ball", np.array([1.0, 1.0, 1.0]), 4.0),
    RigidBody("hub", np.array([0.0, 2.0, 0.0]), 2.0, np.diag([1.0, 2.0, 2.5]), TURN),
    RigidBody("lid", np.array([0.0, 2.0, 0.0]), 2.0, np.diag([1.0, 2.0, 2.5])),
]
HINGE = Revolute("hinge", Site("hub"), Site("lid"), np.array([0.0, 0.0, 1.0]))
CORNER = Site("hub", offset=np.array([0.3, -0.2, 0.5]))
INSIDE = Site("arm", 1, fraction=0.4)
GROUND = Site(None, position=np.array([-1.0, 0.5, 0.3]))


def build(*items):
    layout = Layout.of(BODIES, [HINGE, *items])
    return springs.build(items, layout, layout.ndof), layout


def timed(term, t=0.0):
    coef = term.coefficients(None)
    for row, column, history in term.signals:
        coef[row, column] = history(t)
    return coef


def moved(layout, size=0.2, seed=1):
    return layout.q0 + size * np.random.default_rng(seed).standard_normal(layout.ndof)


def lines(**law):
    return (
        Spring("one", CORNER, INSIDE, **law),
        Spring("two", GROUND, Site("ball"), **law),
        Spring("three", Site("lid"), Site("ball"), **law),
    )


def ropes(**law):
    path = [CORNER, GROUND, INSIDE, Site("ball")]
    long, short = (
        Pulley("long", path, 50.0, 3.0, **law),
        Pulley("short", path[1:3], 20.0, 1.0, **law),
    )
    return long, short, Pulley("free", [CORNER, INSIDE, Site("ball")], 50.0, 3.0, **law)


def bushings():
    def made(name, a, b):
        return Bushing(name, a, b, TURN, STIFFNESS, 0.1 * STIFFNESS[::-1])

    at_arm = Site(None, position=POINTS[1])
    return (
        made("bodies", Site("hub"), Site("lid")),
        made("ground", Site("arm", 1), at_arm),
        made("held", Site(None, position=POINTS[2]), Site("arm", 2)),
    )


def power(term, q, v, coef):
    return force(term, q, v, coef) @ v


FAMILIES = {
    "springs": lines(stiffness=30.0, damping=2.0, preload=4.0, length=0.7),
    "ropes": ropes(length=1.5),
    "winch": ropes(winch=lambda t: -1.0 + 0.3 * t),
    "torsion": (TorsionSpring("coil", "hinge", 3.0, 0.5, 0.2, 0.7),),
    "bushings": bushings(),
}


@pytest.mark.parametrize("items", FAMILIES.values(), ids=FAMILIES)
def test_tangent_and_energy(items):
    """Tangent by differences; power = change of energy + loss + work on the free length."""
    (term,), layout = build(*items)
    q, v, coef = moved(layout), moved(layout, 0.5, 2) - layout.q0, timed(term, 0.4)
    found = jacobian(term, q, v, coef, 0.8, 0.3)
    expected = expected_jacobian(term, q, v, coef, 0.8, 0.3, q.size, 1e-3)
    assert np.abs(expected).max() > 0.1
    assert found == pytest.approx(expected, abs=2e-9 * np.abs(expected).max())
    elastic = jacobian(term, q, 0.0 * v, coef, 1.0, 0.0)
    assert elastic == pytest.approx(elastic.T, abs=1e-12 * np.abs(expected).max())
    stored = slopes(lambda x: np.atleast_1d(kernels.energies(term, x, v, coef)[0]), q).ravel()
    _, lost, fed = kernels.energies(term, q, v, coef)
    assert power(term, q, v, coef) == pytest.approx(stored @ v + lost + fed, rel=1e-9)
    assert lost > 0.0


@pytest.mark.parametrize("family", ["springs", "ropes", "winch", "bushings"])
def test_motion_as_one_body_does_no_work(family):
    """Ends on the ground left out: no net force, no net moment."""
    items = FAMILIES[family]
    free = [item for item in items if "ground" not in repr(item) and "body=None" not in repr(item)]
    (term,), layout = build(*free)
    q = moved(layout)
    f = force(term, q, 0.0 * q, timed(term)).reshape(-1, 3)
    assert np.abs(f).max() > 0.1
    for turn in np.eye(3):
        assert np.sum(f * np.cross(turn, q.reshape(-1, 3))) == pytest.approx(0.0, abs=1e-12)
    positions = f[[0, 4, 8, 12, 13, 17]]
    assert positions.sum(axis=0) == pytest.approx(0.0, abs=1e-12)


def test_spring_pulls_its_points_together():
    (term,), layout = build(Spring("s", Site("ball"), GROUND, 10.0, length=0.5, preload=3.0))
    line = np.array([1.0, 1.0, 1.0]) - GROUND.position
    length = np.linalg.norm(line)
    f = force(term, layout.q0, 0.0 * layout.q0, timed(term))
    assert f[36:39] == pytest.approx((10.0 * (length - 0.5) + 3.0) * line / length)


def test_spring_at_its_reference_length_has_the_preload_only():
    (term,), layout = build(Spring("s", Site("ball"), INSIDE, 10.0, preload=3.0))
    f = force(term, layout.q0, 0.0 * layout.q0, timed(term))
    assert np.linalg.norm(f[36:39]) == pytest.approx(3.0)


def test_what_an_actuator_does_is_external_work():
    actuator = Spring("s", Site("ball"), GROUND, force=lambda t: 5.0 * t)
    (passive, active), layout = build(actuator)
    rest = 0.0 * layout.q0
    assert active.external and not passive.external
    assert not force(passive, layout.q0, rest, timed(passive, 2.0)).any()
    assert np.linalg.norm(force(active, layout.q0, rest, timed(active, 2.0))) == pytest.approx(10.0)
    assert not kernels.energies(active, layout.q0, rest, timed(active, 2.0)).any()


def test_motor_drives_the_turn():
    (passive, motor), layout = build(TorsionSpring("m", "hinge", 2.0, torque=lambda t: 7.0))
    turn = layout.joint_dofs["hinge.turn"]
    q = layout.q0.copy()
    q[turn] = 0.5
    assert force(passive, q, 0.0 * q, timed(passive))[turn] == pytest.approx(1.0)
    assert force(motor, q, 0.0 * q, timed(motor))[turn] == -7.0 and motor.external


def test_slack_rope_carries_nothing():
    (term,), layout = build(*ropes(length=30.0))
    v = moved(layout) - layout.q0
    assert not force(term, layout.q0, v, timed(term)).any()
    assert not jacobian(term, layout.q0, v, timed(term), 1.0, 1.0).any()
    assert not kernels.energies(term, layout.q0, v, timed(term)).any()


def test_rope_has_one_tension_everywhere():
    """Force on a point: tension times the sum of the unit vectors to its neighbours."""
    (term,), layout = build(Pulley("r", [Site("ball"), INSIDE, GROUND], 50.0, length=2.0))
    q = layout.q0
    ball, inside = q[36:39], layout.site(INSIDE).position
    first, last = inside - ball, GROUND.position - inside
    length = np.linalg.norm(first) + np.linalg.norm(last)
    tension = 50.0 * (length - 2.0) / 2.0
    f = force(term, q, 0.0 * q, timed(term))
    assert f[36:39] == pytest.approx(-tension * first / np.linalg.norm(first))
    positions = f[[12, 13, 14]] + f[[24, 25, 26]]
    pull = first / np.linalg.norm(first) - last / np.linalg.norm(last)
    assert positions == pytest.approx(tension * pull)


def test_winch_shortens_the_rope():
    """Rope wound up in place of rope stretched: the same tension."""
    (wound,), layout = build(Pulley("r", [Site("ball"), GROUND], 50.0, winch=lambda t: -0.3 * t))
    length = np.linalg.norm(np.ones(3) - GROUND.position)
    (short,), _ = build(Pulley("r", [Site("ball"), GROUND], 50.0, length=length - 0.6))
    rest = 0.0 * layout.q0
    expected = force(short, layout.q0, rest, timed(short))
    assert force(wound, layout.q0, rest, timed(wound, 2.0)) == pytest.approx(expected)
    assert timed(wound, 2.0)[0, 1] == pytest.approx(-0.3)


@pytest.mark.parametrize("axis", np.eye(3))
def test_bushing_turned_by_an_angle_has_a_moment_of_its_sine(axis):
    """Objective: both ends turned and moved together besides."""
    (term,), layout = build(bushings()[0])
    common, angle = Rotation.from_rotvec([1.0, 2.0, -0.5]), 0.5
    about = axis @ TURN  # the same axis of the bushing, in the reference
    turn = common * Rotation.from_rotvec(angle * about)
    q = layout.q0.copy()
    hub, lid = layout.node_dofs["hub"][0], layout.node_dofs["lid"][0]
    q[hub + 3 : hub + 12] = turn.apply(TURN).ravel()
    q[lid + 3 : lid + 12] = common.apply(np.eye(3)).ravel()
    q[hub : hub + 3] = q[lid : lid + 3] = 9.0
    f = force(term, q, 0.0 * q, timed(term))[hub + 3 : hub + 12].reshape(3, 3)
    moment = np.cross(q[hub + 3 : hub + 12].reshape(3, 3), f).sum(axis=0)
    k = STIFFNESS[3:] @ axis
    # energy k sin^2/2: moment k sin cos
    expected = k * np.sin(angle) * np.cos(angle) * common.apply(about)
    assert moment == pytest.approx(expected, abs=1e-12)


def test_bushing_moved_along_its_axes():
    (term,), layout = build(bushings()[0])
    q = layout.q0.copy()
    hub = layout.node_dofs["hub"][0]
    q[hub : hub + 3] += 0.1 * np.array([1.0, -2.0, 0.5]) @ TURN
    f = force(term, q, 0.0 * q, timed(term))[hub : hub + 3]
    assert f == pytest.approx(0.1 * (np.array([1.0, -2.0, 0.5]) * STIFFNESS[:3]) @ TURN)


SAME = Site("hub", offset=np.zeros(3))


@pytest.mark.parametrize(
    ("item", "message"),
    [
        (Spring("s", Site("hub"), Site("lid"), 1.0), "'s'.*'hub' and 'lid' coincide"),
        (Spring("s", GROUND, Site(None), 1.0), "'s'.*on the ground"),
        (Spring("s", Site("hub"), GROUND, -1.0), "'s'.*must not be negative"),
        (Pulley("r", [Site("hub")], 1.0), "'r'.*two points"),
        (Pulley("r", [Site("hub"), GROUND, GROUND], 1.0), "'r'.*coincide"),
        (Pulley("r", [Site("hub"), GROUND], 1.0, length=0.0), "'r'.*length"),
        (Bushing("b", Site("ball"), Site(None, position=np.ones(3)), TURN, STIFFNESS, STIFFNESS),
         "'b'.*'ball' has no section"),
        (Bushing("b", Site("hub"), GROUND, TURN, STIFFNESS, STIFFNESS), "'b'.*apart"),
        (Bushing("b", Site("hub"), Site("lid"), 2 * TURN, STIFFNESS, STIFFNESS), "'b'.*axes"),
        (Bushing("b", Site("hub"), Site("lid"), TURN, -STIFFNESS, STIFFNESS), "'b'.*negative"),
        (Bushing("b", GROUND, GROUND, TURN, STIFFNESS, STIFFNESS), "'b'.*on the ground"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_by_name(item, message):
    with pytest.raises(ValueError, match=message):
        build(item)


def test_torsion_spring_needs_a_joint_that_turns():
    layout = SimpleNamespace(joint_dofs={})
    with pytest.raises(ValueError, match=r"'t'.*'nowhere'"):
        springs.build([TorsionSpring("t", "nowhere", 1.0)], layout, 0)


def run(description, end, h):
    """Last state, and the terms of the ledger over the largest of them."""
    system = System(description)
    coef = system.coefficients(np.tile([293.15, 0.0, 0.0], (len(system.layout.x), 1)))
    control = Control(np.inf, h, h, Scheme(newton_tolerance=1e-13))
    state, why = initial_state(system, control, coef)
    assert why == ""
    state, _, why = advance(system, control, state, Window(0.0, end, coef, coef))
    assert why == ""
    return system, state, state.ledger[-1] / np.abs(state.ledger).max()


def test_mass_on_spring_and_damper_swings_as_in_the_textbook():
    ball = Particle("ball", np.array([1.0, 0.0, 0.0]), 2.0, np.array([0.5, 0.0, 0.0]))
    spring = Spring("s", Site("ball"), Site(None), 50.0, 1.0, force=lambda t: -3.0)
    _, state, defect = run(Description([ball], [spring]), 3.0, 1e-3)
    decay, w = 0.25, np.sqrt(25.0 - 0.25**2)
    # x'' = -25 (x - 1.06) - .5 x': the actuator pushes
    c, s = np.cos(3.0 * w), np.sin(3.0 * w)
    swing = np.exp(-3.0 * decay) * (-0.06 * c + (0.5 - 0.06 * decay) / w * s)
    assert state.motion.q[0] == pytest.approx(1.06 + swing, abs=1e-5)
    assert abs(defect) < 1e-6
    assert state.ledger[TERMS.index("work_loads")] == pytest.approx(
        3.0 * (state.motion.q[0] - 1.0), rel=1e-5
    )


def test_ledger_closes_with_ropes_bushings_coils_and_motors():
    hub = RigidBody("hub", np.zeros(3), 2.0, np.diag([1.0, 2.0, 2.5]), TURN)
    lid = RigidBody("lid", np.zeros(3), 1.0, np.eye(3), spin=np.array([0.3, 0.5, 0.0]))
    ball = Particle("ball", np.array([1.0, 1.0, 1.0]), 1.0)
    joints = [
        Revolute("hinge", Site("hub"), Site(None), np.array([0.0, 0.0, 1.0])),
        Bushing("soft", Site("lid"), Site("hub"), TURN, 30.0 * STIFFNESS, STIFFNESS),
        TorsionSpring("coil", "hinge", 5.0, 0.3, torque=lambda t: 4.0 * np.sin(3.0 * t)),
        Pulley("rope", [Site("ball"), Site("lid", offset=np.array([0.3, 0.0, 0.0])), GROUND],
               400.0, 8.0, length=2.0),
    ]  # fmt: skip
    bodies, gravity = [hub, lid, ball], np.array([0.0, 0.0, -9.81])
    found = [run(Description(bodies, joints, gravity=gravity), 1.0, h) for h in (2e-3, 1e-3, 5e-4)]
    ledger, defect = found[-1][1].ledger, found[-1][2]
    assert abs(defect) < 1e-6
    assert ledger[TERMS.index("damping")] > 0.1
    assert ledger[TERMS.index("work_loads")] > 0.1
    coarse, middle, fine = (state.motion.q for _, state, _ in found)
    order = np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))
    assert order == pytest.approx(2.0, abs=0.2)


def test_winch_lifts_a_load():
    """Slow enough for the rope to hang still: height by closed form."""
    ball = Particle("ball", np.array([0.0, 0.0, -2.0]), 1.0)
    rope = Pulley("r", [Site("ball"), Site(None)], 2000.0, 200.0, winch=lambda t: -0.1 * t)
    gravity = np.array([0.0, 0.0, -9.81])
    _, state, _ = run(Description([ball], [rope], gravity=gravity), 4.0, 2e-3)
    free = 2.0 - 0.4
    assert state.motion.q[2] == pytest.approx(-free * (1.0 + 9.81 / 2000.0), rel=1e-4)
