"""Onset of impacts: located to 1e-6 of the flight, never missed, with the true approach speed."""

import numpy as np
import pytest

from coupling.verify.contact import AXIS, X, ball, joint
from coupling.verify.models import ROOM, elastic, model
from coupling.verify.motion import run
from mechanics.contact import elastic_impact
from mechanics.description import ClearanceRevolute, NormalContact, Particle, Site
from mechanics.dynamics import Control
from mechanics.march import DEPTH, DISSIPATIVE, ELASTIC

CLEARANCE = 5e-5
MASS = 0.2
STIFFNESS = 1e14  # impacts are short against flights
HERTZ = NormalContact(value=STIFFNESS, restitution=0.85)
STEPS = [0.03, 0.4, 0.7, 3.3, 57.0]
"""Steps into which the flight to the wall would divide."""


def fly(velocity, steps, end, gravity=0.0 * X, contact=HERTZ, flight=None, mass=MASS, start=0.0):
    """Path of a ball from ``start`` clearances off the middle; steps of a part of the flight."""
    body = Particle("ball", start * CLEARANCE * X, mass, np.asarray(velocity, float))
    made = model(body, [joint(contact, CLEARANCE)], gravity=gravity)
    flight = CLEARANCE / np.linalg.norm(velocity) if flight is None else flight
    return run(made, end * flight, Control(1e-6, flight / steps, 1e-20))


def onset(path, which=0):
    """Index of the first step at whose end the impact runs."""
    return int(np.flatnonzero(path.approach[:, which])[0])


@pytest.mark.parametrize("steps", STEPS)
@pytest.mark.parametrize("speed", [1e-5, 1e-2, 10.0])
def test_free_flight(speed, steps):
    path = fly(speed * X, steps, 1.01)
    k = onset(path)
    assert path.t[k] == pytest.approx(CLEARANCE / speed, rel=1e-6)
    assert path.approach[k, 0] == pytest.approx(speed, rel=1e-6)


@pytest.mark.parametrize("steps", STEPS)
@pytest.mark.parametrize("away", [0.0, 0.9, 3.0])
def test_constant_force(away, steps):
    """From rest in the middle, or first thrown against the force as far as ``away`` allows."""
    a = 2.0
    fall = np.sqrt(2.0 * CLEARANCE / a)
    v = -away * np.sqrt(2.0 * a * CLEARANCE)
    if away > 1.0:  # reaches the opposite wall first
        speed = np.sqrt(v**2 - 2.0 * a * CLEARANCE)
        time = (-v - speed) / a
    else:
        speed = np.sqrt(v**2 + 2.0 * a * CLEARANCE)
        time = (speed - v) / a
    path = fly(v * X, steps, 1.01 * time / fall, a * X, flight=fall)
    k = onset(path)
    assert path.t[k] == pytest.approx(time, rel=1e-6)
    assert path.approach[k, 0] == pytest.approx(speed, rel=1e-6)
    assert np.sign(path.q[k, 0]) == (-1.0 if away > 1.0 else 1.0)


@pytest.mark.parametrize("steps", STEPS)
def test_oblique_chord(steps):
    """Half a clearance off the middle across; the approach speed is the radial one."""
    body = Particle("ball", np.array([0.0, 0.5 * CLEARANCE, 0.0]), MASS, 0.1 * X)
    made = model(body, [joint(HERTZ, CLEARANCE)])
    time = np.sqrt(0.75) * CLEARANCE / 0.1
    path = run(made, 1.01 * time, Control(1e-6, time / steps, 1e-20))
    k = onset(path)
    assert path.t[k] == pytest.approx(time, rel=1e-6)
    assert path.approach[k, 0] == pytest.approx(0.1 * np.sqrt(0.75), rel=1e-6)


@pytest.mark.parametrize("steps", [0.3, 1.7, 20.0])
@pytest.mark.parametrize("apex", [0.9999, 1.0001, 1.3])
def test_grazing_flight_out_and_back(apex, steps):
    """Thrown to ``apex`` clearances and back, all of it within one step if steps < 1."""
    a = 2.0
    v = np.sqrt(2.0 * a * apex * CLEARANCE)
    path = fly(v * X, steps, 1.9, -a * X, flight=v / a)
    if apex < 1.0:
        assert not path.approach.any()
        assert path.t[-1] == pytest.approx(1.9 * v / a)
        assert path.q[-1, 0] == pytest.approx(0.19 * v**2 / (2.0 * a), rel=1e-6)
        return
    k, speed = onset(path), np.sqrt(v**2 - 2.0 * a * CLEARANCE)
    # a grazing rise takes the last half of a millionth of the clearance slowly
    assert path.t[k] == pytest.approx((v - speed) / a, rel=1e-6 / np.sqrt(1.0 - 1.0 / apex))
    assert path.approach[k, 0] ** 2 == pytest.approx(speed**2, abs=1.01e-6 * a * CLEARANCE)


@pytest.mark.parametrize("steps", [1e-3, 0.01, 0.1])
def test_no_impact_is_missed_when_steps_are_long(steps):
    """Between walls for twenty crossings, in steps that could jump over a thousand of them."""
    speed, stiff = 0.3, NormalContact("linear", 1e12, "exact", 1.0)
    path = fly(speed * X, steps, 40.0, contact=stiff, mass=1e-3)
    radius = np.abs(path.q[:, 0])
    assert radius.max() < 1.001 * CLEARANCE
    running = path.approach[:, 0] != 0.0
    onsets = path.t[running & ~np.append(False, running[:-1])]
    assert len(onsets) == 20
    assert np.diff(onsets) == pytest.approx(2.0 * CLEARANCE / speed, rel=1e-2)


@pytest.mark.parametrize("law", ["exact", "hua2026"])
@pytest.mark.parametrize("restitution", [0.05, 0.5, 0.95])
def test_rebound_does_not_depend_on_the_step_before(law, restitution):
    contact = NormalContact(value=STIFFNESS, dissipation=law, restitution=restitution)
    rebounds = []
    for steps in (0.01, 0.6, 9.0):
        speed = 1e-3
        path = fly(speed * X, steps, 1.0 + 1.0 / restitution, contact=contact)
        rebounds.append(-path.v[-1, 0] / speed)
    assert np.ptp(rebounds) < 1e-3
    if law == "exact":
        assert rebounds[0] == pytest.approx(restitution, abs=2e-3)


@pytest.mark.parametrize("restitution", [0.05, 0.85])
def test_force_never_pulls(restitution):
    contact = NormalContact(value=STIFFNESS, dissipation="hua2026", restitution=restitution)
    made = model(ball(MASS, 0.5 * X), [joint(contact, CLEARANCE)])
    path = run(made, 1.5 * CLEARANCE / 0.5, Control(1e-6, 1e-5, 1e-20))
    elastic_part, dissipative, depth = path.response[:, 0, [ELASTIC, DISSIPATIVE, DEPTH]].T
    assert (dissipative < 0.0).any()
    assert (elastic_part + dissipative >= 0.0).all()
    assert (elastic_part[depth <= 0.0] == 0.0).all()
    assert path.v[-1, 0] < 0.0


def pair(second):
    """Two balls in two joints, at 0.1 m/s and at ``second`` of it."""
    metal = elastic(2e11, 0.3)
    balls = [Particle(n, np.zeros(3), MASS, v * X) for n, v in (("a", 0.1), ("b", 0.1 * second))]
    joints = [
        ClearanceRevolute(
            f"hinge {b.name}", Site(b.name), Site(None), AXIS, 0.025, CLEARANCE, metal, metal,
            ROOM, HERTZ,
        )
        for b in balls
    ]  # fmt: skip
    return model(balls, joints)


@pytest.mark.parametrize("second", [1.0, 1.0 - 1e-9, 0.99999, 0.9, 0.2])
@pytest.mark.parametrize("steps", [0.1, 4.7])
def test_two_joints(second, steps):
    """Both onsets are located, at one instant or not; neither impact changes the other.

    One that begins while the other is resolved is known to such a short step.
    """
    flight = CLEARANCE / 0.1
    resolved = float(elastic_impact(MASS, STIFFNESS, 0.1).duration) / 32.0
    path = run(pair(second), 1.1 * flight / second, Control(1e-6, flight / steps, 1e-20))
    for which, factor in enumerate((1.0, second)):
        k = onset(path, which)
        near = resolved if 0.0 < 1.0 - second < 1e-4 else 0.0
        assert path.t[k] == pytest.approx(flight / factor, rel=1.01e-6, abs=near)
        assert path.approach[k, which] == pytest.approx(0.1 * factor, rel=1e-6)
        released = k + np.flatnonzero(path.approach[k:, which] == 0.0)[0]
        rebound = abs(path.v[released, 3 * which]) / (0.1 * factor)
        assert rebound == pytest.approx(0.85, abs=2e-3)


def test_pressed_journal_at_rest_in_contact_stays():
    """Begins at the depth that carries the force: no onset, no motion."""
    force = MASS * 9.81
    depth = (force / STIFFNESS) ** (2.0 / 3.0)
    start = 1.0 + depth / CLEARANCE
    path = fly(0.0 * X, 1.0, 5.0, 9.81 * X, flight=1e-3, start=start)
    assert path.q[:, 0] == pytest.approx(start * CLEARANCE, rel=1e-9)
    assert (path.approach != 0.0).all()


def test_journal_that_starts_touching_is_pressed_in_without_a_flight():
    """Rest at zero gap under a force: the deepest point is that of a load suddenly applied."""
    path = fly(0.0 * X, 1.0, 1.0, 9.81 * X, flight=1e-3, start=1.0, contact=NormalContact(
        "linear", 1e7, "exact", 1.0))  # fmt: skip
    deepest = path.q[:, 0].max() - CLEARANCE
    assert deepest == pytest.approx(2.0 * MASS * 9.81 / 1e7, rel=5e-3)
