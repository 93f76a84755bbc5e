"""Impacts in joints with clearance of every kind: onset, restitution, sequences, energy."""

from dataclasses import replace

import numpy as np
import pytest
from clearance_motions import (
    CLEARANCE,
    FLIGHTS,
    HARD,
    INERTIA,
    KINDS,
    LENGTH,
    MASS,
    X,
    Y,
    Z,
    body,
    flying,
    kinetic,
    law,
    particle,
    steps,
)

from coupling.verify.models import model
from coupling.verify.motion import run
from mechanics.contact import elastic_impact
from mechanics.description import Force, Friction
from mechanics.dynamics import Control
from mechanics.march import CONTACT_ELASTIC, DEPTH, HYSTERESIS, LANDING, RUBBED
from mechanics.schemes import FORMULATIONS, SCHEMES, Scheme

SPEED = 0.1
FLIGHT = CLEARANCE / SPEED
TOGETHER = {"planar revolute": [1, 1], "revolute": [2, 3], "spherical": [1, 1], "cylindrical": [2],
            "planar translational": [2, 2], "translational": [4, 4]}  # fmt: skip
"""Contact points that are struck together in the flights of each kind."""


def onsets(path):
    """Times at which impacts begin, of all contacts together."""
    running = np.concatenate([np.zeros_like(path.approach[:1]), path.approach]) != 0.0
    step, _ = np.nonzero(running[1:] & ~running[:-1])
    return path.t[step]


# ------------------------------------------------------------------------------------- the onset


@pytest.mark.parametrize("length", [0.3, 0.9, 7.0])
@pytest.mark.parametrize(("kind", "way"), FLIGHTS)
def test_onset_is_located_in_long_steps(kind, way, length):
    """A fraction of the flight, nearly all of it, more than there and back."""
    path = run(flying(kind, way, SPEED, law()), 1.05 * FLIGHT, steps(length * FLIGHT))
    first = np.flatnonzero(path.approach.any(axis=1))[0]
    struck = path.approach[first] != 0.0
    assert struck.sum() == TOGETHER[kind][way]
    assert path.t[first] == pytest.approx(FLIGHT, rel=1e-6)
    np.testing.assert_allclose(path.approach[first, struck], SPEED, rtol=1e-6)
    assert np.abs(path.response[first, struck, DEPTH]).max() <= LANDING * CLEARANCE
    assert path.response[:first, :, DEPTH].max(initial=-CLEARANCE) < 0.0


B, TURN = 0.5 * LENGTH, 0.2 * SPEED
"""Lever of the corners of a slider, and what its spin adds to the speed of two of them."""


def struck(restitution):
    """Time of the first impact of a slider that flies and spins, speed of its centre and what its
    spin adds at the corner after that, time of the second impact.

    Impulse J = (1 + e) u/(1/m + b²/J_y) at speed u = v + ω b of the corner.
    """
    first = CLEARANCE / (SPEED + TURN)
    impulse = (1.0 + restitution) * (SPEED + TURN) / (1.0 / MASS + B**2 / INERTIA[1, 1])
    speed, turn = SPEED - impulse / MASS, TURN - impulse * B**2 / INERTIA[1, 1]
    left = CLEARANCE - (SPEED - TURN) * first
    return first, speed, turn, first + left / (speed - turn)


def spinning_slider(restitution):
    slider = body(SPEED * X, TURN / B * Y)
    return model([slider], [KINDS["planar translational"][0](contact=law(restitution, 1e17))])


@pytest.mark.parametrize("length", [0.05, 3.0])
def test_corners_of_a_slider_strike_one_after_the_other_in_one_step(length):
    path = run(spinning_slider(0.2), 2.0 * FLIGHT, steps(length * FLIGHT))
    first, _, _, second = struck(0.2)
    np.testing.assert_allclose(onsets(path)[:2], [first, second], rtol=2e-3)


@pytest.mark.parametrize("steps_of_flight", [0.2, 2.0])
def test_joints_that_strike_within_one_step(steps_of_flight):
    """Balls that arrive after 1, 1.00001, 1.2 and 1.9 of the flight.

    The second one does while the impact of the first is resolved.
    """
    speeds = SPEED / np.array([1.0, 1.00001, 1.2, 1.9])
    balls, joints = [], []
    for i, speed in enumerate(speeds):
        balls.append(replace(particle(speed * (2 * X - Y + 2 * Z) / 3), name=f"b{i}"))
        joint = KINDS["spherical"][0](contact=law())
        joints.append(replace(joint, name=f"j{i}", journal=replace(joint.journal, body=f"b{i}")))
    path = run(model(balls, joints), 2.0 * FLIGHT, steps(steps_of_flight * FLIGHT))
    for i, speed in enumerate(speeds):
        first = np.flatnonzero(path.approach[:, i])[0]
        resolved = float(elastic_impact(MASS, HARD, speed).duration) / 32.0
        assert path.t[first] == pytest.approx(CLEARANCE / speed, rel=2e-6, abs=resolved)
        assert path.approach[first, i] == pytest.approx(speed, rel=1e-6)
        after = path.v[-1, 3 * i : 3 * i + 3] @ (2 * X - Y + 2 * Z) / 3
        assert after == pytest.approx(-0.85 * speed, rel=2e-3)


# ------------------------------------------------------------------------------------ restitution


@pytest.mark.parametrize("restitution", [0.05, 0.5, 0.85, 1.0])
@pytest.mark.parametrize(("kind", "way"), FLIGHTS)
def test_delivered_restitution(kind, way, restitution):
    path = run(flying(kind, way, SPEED, law(restitution)), 1.2 * FLIGHT, steps(0.3 * FLIGHT))
    rebound = -path.v[-1, :3] @ KINDS[kind][1][way] / SPEED
    assert rebound == pytest.approx(restitution, abs=2e-3)
    aside = path.v[-1, :3] + rebound * SPEED * KINDS[kind][1][way]
    assert np.abs(aside).max() < 1e-6 * SPEED


@pytest.mark.parametrize("restitution", [0.2, 0.9])
def test_a_corner_off_the_centre_rebounds_as_rigid_bodies_do(restitution):
    """The corner leaves with −e times its speed, the slider turns; impacts are short."""
    first, speed, turn, second = struck(restitution)
    path = run(spinning_slider(restitution), 0.5 * (first + second), steps(0.1 * FLIGHT))
    assert path.v[-1, 0] == pytest.approx(speed, abs=3e-3 * SPEED)
    # rate of the third director, along the guide: the spin about y
    assert path.v[-1, 9] * B == pytest.approx(turn, abs=3e-3 * SPEED)


@pytest.mark.parametrize("speed", [1e-4, 1e-2, 1.0])
@pytest.mark.parametrize("stiffness", ["linear", "hertz-external", "cylinder"])
def test_restitution_is_that_of_the_law_at_every_speed(stiffness, speed):
    kind, value = ("cylindrical", 1e10) if stiffness == "cylinder" else ("spherical", 1e10)
    for restitution in (0.1, 0.7):
        made = flying(kind, 0, speed, law(restitution, value, stiffness))
        duration = float(
            elastic_impact(
                MASS,
                value if stiffness != "cylinder" else 1e9,
                speed,
                1.5 if stiffness == "hertz-external" else 1.0,
            ).duration
        )
        end = CLEARANCE / speed + (1.5 + 0.2 / restitution) * duration
        path = run(made, end, steps(0.3 * CLEARANCE / speed))
        assert not path.approach[-1].any()
        rebound = -path.v[-1, :3] @ KINDS[kind][1][0] / speed
        assert rebound == pytest.approx(restitution, abs=1.5e-3)


# -------------------------------------------------------------------------------------- sequences


def ballistic(restitution, count):
    """Times of impacts between walls, 2 c apart, from the middle, of no duration."""
    return FLIGHT * (1.0 + 2.0 * np.cumsum(np.append(0.0, restitution ** -np.arange(1.0, count))))


@pytest.mark.parametrize("kind", ["planar revolute", "planar translational", "revolute"])
def test_the_largest_step_does_not_change_the_sequence_of_impacts(kind):
    """Twenty impacts with e = 0.9: what is left is the error in restitution, with the tolerance."""
    way = 1 if kind == "revolute" else 0
    for tolerance, error in ((1e-6, 5e-3), (1e-7, 5e-4)):
        for largest in (1e-3, 3e-4, 1e-4, 1e-5):
            made = flying(kind, way, SPEED, law(0.9, 1e18))
            path = run(made, 0.131, steps(largest, tolerance))
            times = onsets(path).reshape(-1, TOGETHER[kind][way])
            assert np.ptp(times, axis=1).max() < 1e-9
            np.testing.assert_allclose(times[:20, 0], ballistic(0.9, 20), rtol=error)


def test_the_largest_step_does_not_change_oblique_impacts_in_a_socket():
    """A skew path in space: chords, whose impacts turn it."""
    found = []
    for largest in (1e-3, 1e-4, 1e-5):
        ball = particle(SPEED * (2 * X - Y + 2 * Z) / 3, 0.3 * CLEARANCE * (Y + Z))
        path = run(model([ball], [KINDS["spherical"][0](contact=law(0.9))]), 0.02, steps(largest))
        found.append(onsets(path)[:9])
    for times in found:
        assert len(times) == 9
        np.testing.assert_allclose(times, found[-1], rtol=1e-3)


@pytest.mark.parametrize(
    ("restitution", "count", "last"), [(0.5, 10, 1.354571), (0.9, 60, 8.578949)]
)
@pytest.mark.parametrize("kind", ["spherical", "planar revolute"])
def test_a_bouncing_ball_comes_to_rest(kind, restitution, count, last):
    """(1 + e)/(1 − e) √(2 h/g), scaled from a fall of 0.1 mm to one of 1 m; then m g/K deep."""
    mass, stiffness = 1e-3, 1e10
    contact, scale = law(restitution, stiffness, "linear"), np.sqrt(1.0 / CLEARANCE)
    made = model([particle(mass=mass)], [KINDS[kind][0](contact=contact)], gravity=9.81 * X)
    path = run(made, 1.1 * last / scale, steps(1e-3))
    times, fall = scale * onsets(path), np.sqrt(2.0 / 9.81)
    assert len(times) >= count
    np.testing.assert_allclose(
        times[:4], fall * (1.0 + 2.0 * np.cumsum(np.append(0.0, restitution ** np.arange(1, 4)))),
        rtol=3e-3,
    )  # fmt: skip
    assert times[-1] == pytest.approx(last, rel=1e-2)
    assert path.response[-1, 0, DEPTH] == pytest.approx(mass * 9.81 / stiffness, rel=1e-4)
    assert np.abs(path.v[-1]).max() < 1e-8
    assert len(path.t) < 20_000


# ----------------------------------------------------------------------------------------- energy

NO_GAIN = 1e-9
"""Relative energy that rounding may bring in thousands of steps."""
ELASTIC_GAIN = 2e-5
"""The same of an impact without any loss: its end is located to that part of the speed."""


@pytest.mark.parametrize("restitution", [0.01, 0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize(
    ("stiffness", "value"),
    [("linear", 1e4), ("linear", 1e7), ("linear", 1e12), ("hertz-external", 1e4),
     ("hertz-external", 1e8), ("hertz-external", 1e12), ("cylinder", 1e10)],
)  # fmt: skip
def test_no_impact_gains_energy(stiffness, value, restitution):
    """Whatever the largest step, and with friction on a pin that spins."""
    kind = "cylindrical" if stiffness == "cylinder" else "planar revolute"
    exponent = 1.5 if stiffness == "hertz-external" else 1.0
    duration = float(elastic_impact(MASS, value, SPEED, exponent).duration)
    end = FLIGHT + (1.2 + 0.1 / restitution) * duration
    for mu in (0.0, 0.3, 2.0):
        friction = Friction(mu, law="stick", presliding=1e-6) if mu else None
        for largest in (1e-3, 1e-4, 1e-5, 1e-6):
            if end > 3e3 * largest and largest < 1e-4:
                continue
            contact = law(restitution, value, stiffness)
            made = flying(kind, 0, SPEED, contact, friction, 3.0 * Z)
            path = run(made, end, steps(largest))
            before = 0.5 * MASS * SPEED**2 + 0.5 * INERTIA[2, 2] * 9.0
            gain = kinetic(made, path).max() / before - 1.0
            bound = ELASTIC_GAIN if restitution == 1.0 else NO_GAIN
            assert gain < bound, (mu, largest)


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("stiffness", ["linear", "hertz-external"])
def test_no_impact_gains_energy_without_a_tolerance(stiffness, restitution):
    """With as few steps as there may be."""
    exponent = 1.5 if stiffness == "hertz-external" else 1.0
    duration = float(elastic_impact(MASS, 1e8, SPEED, exponent).duration)
    for part in np.geomspace(0.03, 1.0, 20):
        made = flying("spherical", 0, SPEED, law(restitution, 1e8, stiffness))
        end = FLIGHT + (1.3 + 0.1 / restitution) * duration
        path = run(made, end, steps(part * FLIGHT, np.inf))
        assert kinetic(made, path).max() < (1.0 + NO_GAIN) * 0.5 * MASS * SPEED**2


@pytest.mark.parametrize("constraints", FORMULATIONS)
@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_delivers_the_restitution(name, constraints):
    """Those of second order; backward Euler takes a part of the speed more. None of them brings."""
    scheme = Scheme(name=name, constraints=constraints)
    lacking = 0.2 if name == "backward-euler" else 2e-3
    for restitution in (0.1, 0.85, 1.0):
        path = run(
            made := flying("planar translational", 0, SPEED, law(restitution, 1e10)), 1.4 * FLIGHT,
            Control(1e-6, 0.3 * FLIGHT, 1e-20, scheme),
        )  # fmt: skip
        rebound = -path.v[-1, 0] / SPEED
        assert restitution - lacking < rebound < restitution + 1e-3
        gain = kinetic(made, path).max() / (0.5 * MASS * SPEED**2) - 1.0
        assert gain < (ELASTIC_GAIN if restitution == 1.0 else NO_GAIN)


@pytest.mark.parametrize(("stiffness", "most"), [("linear", 0.08), ("hertz-external", 0.04)])
def test_an_elastic_impact_loses_and_never_gains_in_the_fewest_steps(stiffness, most):
    """Without a tolerance there are six steps for an impact."""
    exponent, gains = 1.5 if stiffness == "hertz-external" else 1.0, []
    end = FLIGHT + 1.3 * float(elastic_impact(MASS, 1e8, SPEED, exponent).duration)
    for part in np.geomspace(0.03, 1.0, 20):
        made = flying("spherical", 0, SPEED, law(1.0, 1e8, stiffness))
        path = run(made, end, steps(part * FLIGHT, np.inf))
        gains.append(kinetic(made, path)[-1] / (0.5 * MASS * SPEED**2) - 1.0)
    assert max(gains) < ELASTIC_GAIN
    assert min(gains) > -most


def test_the_loss_of_elastic_impacts_falls_with_the_square_of_the_steps():
    """Worst of many phases of the last step; 16 times from four times as many steps."""
    stiffness, worst = 1e7, []
    duration = float(elastic_impact(MASS, stiffness, SPEED, 1.0).duration)
    for count in (32, 128):
        gains = []
        for phase in np.linspace(0.9, 1.0, 9):
            made = flying("planar revolute", 0, SPEED, law(1.0, stiffness, "linear"))
            path = run(made, FLIGHT + 1.3 * duration, steps(phase * duration / count))
            gains.append(abs(kinetic(made, path)[-1] / (0.5 * MASS * SPEED**2) - 1.0))
        worst.append(max(gains))
    assert 1e-4 < worst[0] < 4e-3
    assert worst[1] < worst[0] / 6.0


# --------------------------------------------------------------------------------------- extremes


def test_a_cylinder_pressed_beyond_the_range_of_its_law_says_so():
    """P/e² is the largest force of Johnson's law, .9 of it the largest that is used."""
    made = flying("cylindrical", 0, SPEED, law(0.85, 1e4, "cylinder"))
    with pytest.raises(RuntimeError, match=r"holds up to .* N, at t = ") as stopped:
        run(made, 10.0 * FLIGHT, steps(FLIGHT))
    assert "'j.end_" in str(stopped.value)


@pytest.mark.parametrize("clearance", [2e-6, 5e-3])
@pytest.mark.parametrize("kind", KINDS)
def test_clearances_of_two_micrometres_and_five_millimetres(kind, clearance):
    """First impact and rebound."""
    make, ways = KINDS[kind]
    joint = replace(make(contact=law(0.7, 1e13)), clearance=clearance)
    if kind == "revolute":
        joint = replace(joint, axial_clearance=clearance)
    made = model([body(SPEED * ways[0])], [joint])
    flight = clearance / SPEED
    duration = float(elastic_impact(MASS, 1e13, SPEED).duration)
    path = run(made, 1.1 * flight + 1.5 * duration, steps(flight))
    assert onsets(path)[0] == pytest.approx(flight, rel=2e-6)
    assert -path.v[-1, :3] @ ways[0] / SPEED == pytest.approx(0.7, abs=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_a_joint_that_loses_nearly_all_stays_where_it_strikes(kind):
    """e = 0.01: after three flights the journal has hardly left the wall."""
    make, ways = KINDS[kind]
    made = model([body(SPEED * ways[0])], [make(contact=law(0.01, 1e10))])
    path = run(made, 3.0 * FLIGHT, steps(FLIGHT))
    assert -path.v[-1, :3] @ ways[0] / SPEED == pytest.approx(0.01, abs=2e-3)
    assert path.response[-1, :, DEPTH].max() > -0.03 * CLEARANCE


@pytest.mark.parametrize("kind", KINDS)
def test_a_preload_of_ten_tonnes_is_carried(kind):
    """Let go on the wall under 1e5 N, with friction and little restitution: F = Σ K δ^p at rest."""
    make, ways = KINDS[kind]
    contact = law(0.1, 1e10, "linear")
    joint = make(contact=contact, friction=Friction(0.2, regularisation_speed=1e-6))
    press = Force("press", joint.journal, ways[0], lambda t: 1e5)
    made = model([body(position=0.999 * CLEARANCE * ways[0])], [joint], [press])
    path = run(made, 0.01, steps(1e-4))
    carried = 1e10 * np.maximum(path.response[-1, :, DEPTH], 0.0)
    share = 0.5 if kind in ("revolute", "cylindrical") else 1.0
    assert share * carried.sum() == pytest.approx(1e5, rel=1e-6)
    assert np.abs(path.v[-1]).max() < 1e-3


def test_a_spinning_pin_that_tumbles_touches_at_both_edges():
    """Spin about its axis and across: it tilts until both ends of the bore stop it, on opposite
    sides; friction and hysteresis only take."""
    make, _ = KINDS["revolute"]
    pin = body(spin=4.0 * Y + 300.0 * Z)
    made = model([pin], [make(contact=law(0.5, 1e9), friction=Friction(0.1, law="stick"))])
    path = run(made, 0.02, steps(1e-4))
    names = made.system.contact_names
    ends = [names.index(f"j.end_{k}") for k in (1, 2)]
    touching = np.flatnonzero((path.response[:, ends, DEPTH] > 0.0).all(axis=1))
    e1, e2 = (path.response[touching[0], k, :2] for k in ends)
    np.testing.assert_allclose(e1, -e2, atol=1e-2 * CLEARANCE)
    assert path.t[touching[0]] == pytest.approx(CLEARANCE / B / 4.0, rel=0.1)
    energy = kinetic(made, path) + path.ledger[:, CONTACT_ELASTIC]
    assert energy.max() < (1.0 + 1e-5) * energy[0] and energy[-1] < 0.999 * energy[0]
    assert path.ledger[-1, RUBBED] > 0.0 and path.ledger[-1, HYSTERESIS] > 0.0
