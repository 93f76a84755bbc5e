"""Friction of joints with clearance in time: slopes, blocks, belts, memory, energy, heat."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from clearance_motions import (
    CLEARANCE,
    HALVES,
    INERTIA,
    KINDS,
    MASS,
    RADIUS,
    X,
    Y,
    Z,
    body,
    kinetic,
    law,
    particle,
    steps,
)

from coupling.verify.models import model, sections
from coupling.verify.motion import run
from mechanics.description import (
    ClearanceSpherical,
    Description,
    Fixing,
    Force,
    Friction,
    Guide,
    Prismatic,
    RigidBody,
    Site,
    Spring,
)
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.ledger import TERMS
from mechanics.march import DEPTH, ELASTIC, STUCK
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from mechanics.statics import equilibrium

G = 9.81
STIFFNESS = 1e8
SLIDING = {"planar translational": 2, "translational": 4, "cylindrical": 2}
"""Kinds that slide along z, with the number of contacts that carry a load along x."""
BRISTLES = ("stick", "lugre", "rising")
LAWS = ("regularised", "stribeck", *BRISTLES)


def friction(name, mu, **more):
    return Friction(mu, law=name, **({"presliding": 1e-6, "regularisation_speed": 1e-4} | more))


def pressed(kind, rubbing, pull, along=0.0, speed=0.0):
    """A slider that lies on its guide under ``pull`` [N] across it, ``along`` [N] pulling too."""
    share = STIFFNESS * (1.0 if "translational" in kind else 0.5)
    depth = pull / (SLIDING[kind] * share)
    at = Site(None, position=-(CLEARANCE + depth) * X)
    joint = KINDS[kind][0](contact=law(0.3, STIFFNESS, "linear"), friction=rubbing)
    if kind == "cylindrical":  # so long that the load stays between the ends of the bush
        joint = replace(joint, length=10.0)
    loads = [Force("press", joint.journal, X, lambda t: pull)]
    loads += [Force("pull", joint.journal, Z, lambda t: along)] if along else []
    return model([body(speed * Z)], [replace(joint, bearing=at)], loads)


# --------------------------------------------------------------------------- slopes and blocks


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("kind", SLIDING)
def test_acceleration_down_a_slope(kind, name):
    """20 degrees, mu = 0.3: 0.589702 m/s²; late, when the regularised law slides as well."""
    slope = np.radians(20.0)
    made = pressed(kind, friction(name, 0.3), MASS * G * np.cos(slope), MASS * G * np.sin(slope))
    path = run(made, 0.6, steps(1e-3))
    late = np.searchsorted(path.t, 0.3)
    found = (path.v[-1, 2] - path.v[late, 2]) / (path.t[-1] - path.t[late])
    assert found == pytest.approx(0.589702, rel=2e-3)


@pytest.mark.parametrize("name", BRISTLES)
@pytest.mark.parametrize("kind", ["planar translational", "cylindrical"])
def test_what_sticks_does_not_creep(kind, name):
    """Under half the limit for ten seconds; it moves by the bristles, mg sin/(N sigma), only."""
    pull = 2.0
    made = pressed(kind, friction(name, 0.6), pull, 0.5 * 0.6 * pull)
    path = run(made, 10.0, steps(1e-2))
    settled = path.q[path.t > 2.0, 2]
    assert np.ptp(settled) < (1e-9 if name == "lugre" else 1e-11)
    assert path.response[-1, :, STUCK].sum() == SLIDING[kind]
    if name == "stick":
        assert settled[-1] == pytest.approx(0.5e-6, rel=0.02)


@pytest.mark.parametrize("name", ["regularised", "stribeck"])
def test_regularised_friction_creeps(name):
    """v = eps r/(1 - r) under a part r = 1/2 of the limit."""
    made = pressed("planar translational", friction(name, 0.6), 2.0, 0.6)
    path = run(made, 1.0, steps(1e-2))
    assert path.v[-1, 2] == pytest.approx(1e-4, rel=1e-6)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("kind", ["planar translational", "cylindrical"])
def test_a_sliding_block_stops_and_stays(kind, name):
    """v0 = 3 m/s, mu = 0.25: 1.223242 s, 1.834862 m, 4.5 J/kg."""
    made = pressed(kind, friction(name, 0.25), MASS * G, speed=3.0)
    path = run(made, 1.4, steps(1e-3))
    slow = np.flatnonzero(path.v[:, 2] < 0.3)[0]
    stop = path.t[slow] + path.v[slow, 2] / (0.25 * G)
    assert stop == pytest.approx(1.223242, rel=2e-3)
    assert path.q[-1, 2] == pytest.approx(1.834862, rel=2e-3)
    assert path.ledger[-1, TERMS.index("friction")] / MASS == pytest.approx(4.5, rel=2e-3)
    assert np.abs(path.v[-1, :3]).max() < 1e-3
    if name in BRISTLES:
        stays = path.q[path.t > 1.3, 2]
        assert np.ptp(stays) < 2e-6


@pytest.mark.parametrize("largest", [1e-3, 2e-4])
def test_a_mass_on_a_belt_sticks_and_slips(largest):
    """m = 1, k = 100, N = 10, mu_s = 0.4, mu_k = 0.3, v = 0.1: stick 0.2 s, slip 0.471239 s.

    Bristles are damped: what they keep of the friction at which they caught would shake the mass
    loose before its time.
    """
    pull, speed = 10.0, 0.1
    depth = pull / (2.0 * STIFFNESS)
    belt = RigidBody("belt", -(CLEARANCE + depth) * X, 5.0, np.eye(3), np.eye(3), speed * Z)
    joint = replace(
        KINDS["planar translational"][0](
            contact=law(0.3, STIFFNESS, "linear"),
            friction=friction(
                "stick", 0.3, static_coefficient=0.4, presliding=1e-5, bristle_damping=100.0
            ),
        ),
        bearing=Site("belt"),
    )
    drive = Prismatic("drive", Site("belt"), Site(None, position=-(CLEARANCE + depth) * X), Z,
                      lambda t: speed * t)  # fmt: skip
    spring = Spring("spring", Site("body"), Site(None, position=-5.0 * Z), 100.0)
    load = Force("press", Site("body"), X, lambda t: pull)
    made = model([body(speed * Z, mass=1.0), belt], [joint, drive, spring], [load])
    path = run(made, 2.2, steps(largest))
    x, late = path.q[:, 2], path.t > 0.6
    assert x[late].max() == pytest.approx(0.044142, rel=1e-2)
    assert x[late].min() == pytest.approx(0.015858, rel=1e-2)
    stuck = path.response[:, :, STUCK].max(axis=1) > 0.0
    begins, ends = (path.t[1:][np.diff(stuck.astype(int)) == s] for s in (1, -1))
    begins = begins[begins > ends[0]]
    assert begins[0] - ends[0] == pytest.approx(0.471239, rel=1e-2)
    assert ends[1] - begins[0] == pytest.approx(0.2, rel=2e-2)


def test_a_pin_in_a_spinning_bush_is_dragged_along():
    """The moment on a spinning ball in a socket is mu N R about the spin: α = mu N R/J."""
    pull, mu, spin = 3.0, 0.2, 50.0
    depth = pull / STIFFNESS
    joint = replace(
        KINDS["spherical"][0](
            contact=law(0.3, STIFFNESS, "linear"), friction=friction("stick", mu)
        ),
        bearing=Site(None, position=-(CLEARANCE + depth) * X),
    )
    loads = [Force("press", Site("body"), X, lambda t: pull)]
    hold = Spring("hold", Site("body"), Site(None, position=-1.0 * Y), 1e5)
    made = model([body(spin=spin * Z)], [joint, hold], loads)
    path = run(made, 0.1, steps(1e-3))
    # first director d1 turns in the plane: spin from its rate
    rate = np.linalg.norm(path.v[:, 3:6], axis=1)
    late = np.searchsorted(path.t, 0.05)
    found = (rate[-1] - rate[late]) / (path.t[-1] - path.t[late])
    assert found == pytest.approx(-mu * pull * RADIUS / INERTIA[2, 2], rel=2e-2)


# ----------------------------------------------------------------------------- memory of friction


def rattling(kind, name="stick"):
    """Everything at once: flight, spin, impacts, friction, an oscillating load."""
    make, ways = KINDS[kind]
    rubbing = friction(name, 0.3, static_coefficient=0.4, stribeck_speed=1e-2)
    joint = make(contact=law(0.6, 1e9), friction=rubbing)
    shake = Force("shake", joint.journal, (X + 0.3 * Y + 0.2 * Z), lambda t: 4.0 * np.sin(90.0 * t))
    flier = body(0.1 * ways[0] + 0.03 * Y, 2.0 * Z + 0.5 * X)
    return model([flier], [joint], [shake], gravity=(1.0, 0.0, -1.0))


def windows(made, control, state, ends, seen=None):
    t = state.motion.t
    for end in ends:
        window = Window(t, end - t, made.coef, made.coef)
        state, _, why = advance(made.system, control, state, window, seen, full=seen is not None)
        assert why == ""
        t = end
    return state


def same(a, b):
    """Bit for bit the same state."""
    return all(
        np.array_equal(x, y)
        for one, other in zip(a, b, strict=True)
        for x, y in (zip(one, other, strict=True) if isinstance(one, tuple) else [(one, other)])
    )


@pytest.mark.parametrize("name", BRISTLES)
@pytest.mark.parametrize("kind", KINDS)
def test_a_window_that_is_done_again_gives_the_same_bits(kind, name):
    """Advanced, thrown away and advanced again, also from a state that was written and read."""
    made, control = rattling(kind, name), steps(1e-3)
    start = windows(made, control, initial_state(made.system, control, made.coef)[0], [0.004])
    kept = pickle.dumps(start)
    first = windows(made, control, start, [0.006, 0.008])
    again = windows(made, control, start, [0.006, 0.008])
    read = windows(made, control, pickle.loads(kept), [0.006, 0.008])
    assert same(first, again) and same(first, read)
    assert pickle.dumps(start) == kept


@pytest.mark.parametrize("name", BRISTLES)
def test_history_is_carried_from_window_to_window(name):
    """A slider that sticks: without its history it would slip back by the bristles each time."""
    made = pressed("planar translational", friction(name, 0.6), 2.0, 0.6)
    control = Control(np.inf, 1e-2, 1e-12, Scheme(newton_tolerance=1e-13))
    start = initial_state(made.system, control, made.coef)[0]
    whole = windows(made, control, start, [2.0])
    parts = windows(made, control, start, np.linspace(0.05, 2.0, 40))
    np.testing.assert_allclose(parts.motion.q, whole.motion.q, rtol=0, atol=1e-7)
    np.testing.assert_allclose(parts.motion.history, whole.motion.history, rtol=0, atol=2e-7)
    assert np.abs(whole.motion.history[:, :3]).max() > 1e-7
    forgot = whole._replace(motion=whole.motion._replace(history=0.0 * whole.motion.history))
    goes_on, slips = (windows(made, control, s, [2.1]) for s in (whole, forgot))
    moved = [s.motion.q[2] - whole.motion.q[2] for s in (goes_on, slips)]
    assert abs(moved[0]) < 1e-9 and abs(moved[1]) > 1e-7


def test_static_friction_grows_while_it_sticks():
    """mu_s - (mu_s - mu_k) exp(-g τ^m) is what breaks loose under a load that grows slowly."""
    rubbing = friction("rising", 0.3, static_coefficient=0.6)
    pull = 2.0

    def slips(wait, level):
        """Whether a load of ``level`` mu_k N after ``wait`` [s] makes it slide."""
        made = pressed("planar translational", rubbing, pull)
        load = Force("pull", Site("body"), Z, lambda t: level * pull * min(t / wait, 1.0))
        joint = made.system.contacts[0].joints[0]
        press = Force("press", Site("body"), X, lambda t: pull)
        made = model([body()], [joint], [press, load])
        path = run(made, wait + 0.05, steps(1e-2))
        return path.q[-1, 2] > 1e-4

    def bound(wait):
        return 0.6 - 0.3 * np.exp(-0.570 * wait**0.629)

    for wait in (1.0, 4.0):
        assert slips(wait, 1.03 * bound(wait))
        assert not slips(wait, 0.97 * bound(wait))


# ------------------------------------------------------------------------------- energy and heat


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("kind", KINDS)
def test_the_ledger_closes(kind, name):
    """Impacts, slip and stick of every kind with every law; friction and hysteresis take."""
    made = rattling(kind, name)
    path = run(made, 0.02, Control(1e-6, 1e-3, 1e-20, Scheme(newton_tolerance=1e-15)))
    row = dict(zip(TERMS, path.ledger[-1], strict=True))
    largest = np.abs(path.ledger).max()
    assert abs(row["defect"]) < 1e-9 * largest
    assert row["friction"] > 0.0 and row["hysteresis"] > 0.0
    assert row["kinetic"] == pytest.approx(kinetic(made, path)[-1], rel=1e-12)
    start = initial_state(made.system, Control(), made.coef)[0].ledger[0]
    stored = row["kinetic"] + row["contact_elastic"] - start
    spent = row["work_loads"] - row["friction"] - row["hysteresis"] - row["numerical"]
    assert stored == pytest.approx(spent, abs=1e-8 * largest)
    assert abs(row["numerical"]) < 0.05 * (row["friction"] + row["hysteresis"])


@pytest.mark.parametrize("name", LAWS)
def test_friction_work_of_every_contact_grows_on_the_whole(name):
    """Bristles give back what they store, never more: per contact the work stays positive."""
    made, control = rattling("revolute", name), steps(1e-3)
    state, total = initial_state(made.system, control, made.coef)[0], 0.0
    for k in range(10):
        window = Window(2e-3 * k, 2e-3, made.coef, made.coef)
        state, lost, why = advance(made.system, control, state, window)
        assert why == ""
        total = total + lost
        assert np.all(total[:, 1] > -1e-9)
    assert total[:, 1].sum() == pytest.approx(state.ledger[TERMS.index("friction")], rel=1e-12)
    assert total[:, 0].sum() == pytest.approx(state.ledger[TERMS.index("hysteresis")], rel=1e-9)


def test_the_heat_of_a_window_is_the_work_of_friction():
    make, ways = KINDS["translational"]
    joint = make(contact=law(0.6, 1e9), friction=friction("stick", 0.3))
    flier = body(0.1 * ways[0] + 0.2 * Z, 1.0 * Z)
    solver = Mechanics(Description([flier], [joint]), steps(1e-3))
    T = sections(solver.system)
    state, heat, why = solver.advance(solver.initial(T), 0.01, T, T)
    assert why == ""
    assert heat.sum() == pytest.approx(state.ledger[TERMS.index("friction")], rel=1e-12)
    assert heat.sum() > 1e-6 and heat.shape == (len(T),)


# ------------------------------------------------------------------- two bodies, and hot journals


@cache
def pair(name):
    """Two free bodies that meet in a ball joint with friction, off their centres."""
    arm = np.array([0.03, 0.0, 0.0])
    first = body(0.2 * Y + 0.1 * X, 3.0 * Z)
    other = RigidBody("other", 2 * arm, 0.4, 2 * INERTIA, np.eye(3), -0.1 * Y, 2.0 * X)
    joint = ClearanceSpherical(
        "j", Site("body", offset=arm), Site("other", offset=-arm), RADIUS, CLEARANCE, *HALVES,
        contact=law(0.7, 1e9), friction=friction(name, 0.4),
    )  # fmt: skip
    made = model([first, other], [joint])
    return made, run(made, 0.03, steps(5e-5))


@pytest.mark.parametrize("name", ["regularised", "stick"])
def test_momenta_of_two_free_bodies_are_conserved(name):
    made, path = pair(name)
    assert path.approach.any() and path.ledger[-1, TERMS.index("friction")] > 1e-6
    start = made.system.layout.v0
    M = made.system.mass
    positions = np.zeros((len(start) // 3, 1))
    positions[::4] = 1.0

    def momenta(q, v):
        p = (M @ v).reshape(-1, 3)
        return (p * positions).sum(axis=0), np.cross(q.reshape(-1, 3), p).sum(axis=0)

    before, after = momenta(made.system.layout.q0, start), momenta(path.q[-1], path.v[-1])
    np.testing.assert_allclose(after[0], before[0], atol=1e-9 * np.abs(before[0]).max())
    np.testing.assert_allclose(after[1], before[1], atol=1e-4 * np.abs(before[1]).max())


@pytest.mark.parametrize("rubbing", [None, friction("stick", 0.2), friction("regularised", 0.2)])
@pytest.mark.parametrize("kind", KINDS)
def test_a_seized_joint_stays_centred(kind, rubbing):
    """A journal so hot that it is pressed all round: it holds a load, and does not move."""
    make, ways = KINDS[kind]
    joint = make(contact=law(0.5, 1e9), friction=rubbing)
    load = Force("pull", joint.journal, 5.0 * ways[0], lambda t: min(t / 0.01, 1.0))
    made = model([body()], [joint], [load])
    T = sections(made.system)
    T[made.system.layout.point_index["j.journal"], 0] += 600.0
    made = made._replace(coef=made.system.coefficients(T))
    path = run(made, 0.03, steps(1e-3))
    assert np.abs(path.q[-1, :3]).max() < 0.1 * CLEARANCE
    assert np.abs(path.q[-1, :3] @ ways[0]) < 1e-6
    assert path.response[-1, :, DEPTH].max() > 0.0 and path.response[-1, :, ELASTIC].max() > 10.0


@pytest.mark.parametrize("kind", ["spherical", "cylindrical", "translational"])
def test_statics_of_a_seized_joint_under_a_load(kind):
    """Held by the pressure all round: equilibrium with the load, next to the middle."""
    make, ways = KINDS[kind]
    joint = make(contact=law(0.5, 1e9))
    load = Force("pull", joint.journal, 5.0 * ways[0], lambda t: 1.0)
    along, turn = Guide("along", joint.journal, Z[None]), Fixing("turn", "body", 0, "e1", Y[None])
    if kind == "spherical":
        made = model([particle()], [joint], [load])
    else:
        made = model([body()], [joint, along, *([turn] if kind == "cylindrical" else [])], [load])
    T = sections(made.system)
    T[made.system.layout.point_index["j.journal"], 0] += 1200.0
    hot = made.system.coefficients(T)
    found = equilibrium(made.system, hot, hot, 4)
    assert found.why == ""
    assert 0.0 < found.q[:3] @ ways[0] < 1e-6
