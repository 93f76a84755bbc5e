"""The energy ledger: it closes, and each of its terms equals a closed form."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from coupling.verify.models import Model, elastic, model, sections, straight
from mechanics.description import (
    ClearanceRevolute,
    Force,
    Friction,
    Guide,
    NormalContact,
    Particle,
    Revolute,
    Site,
    Spherical,
)
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.ledger import TERMS
from mechanics.schemes import Scheme
from meshes.materials import library_material
from meshes.sections import rectangle

X, Y, Z = np.eye(3)
THICK = rectangle(0.1, 0.1)
LOSSES = ("friction", "hysteresis", "damping", "numerical")
WORKS = ("work_loads", "work_drive", "work_thermal")
STORED = ("kinetic", "strain", "contact_elastic")


def fixed(h, alpha=-0.1, newton=1e-13):
    """Steps of h, shorter only in impacts."""
    return Control(np.inf, h, 1e-12, Scheme(alpha=alpha, newton_tolerance=newton))


def bore(contact, friction=None, clearance=1e-3, at=(0.0, 0.0, 0.0)):
    metal = elastic(70e9, 0.3, 2700.0)
    return ClearanceRevolute(
        "pin", Site("ball"), Site(None, position=np.array(at)), Z, 0.02, clearance, metal, metal,
        298.15, contact, friction,
    )  # fmt: skip


def run(made, control, end, windows=1, heated=None, start=None):
    """Start, end, and everything that was lost in contacts; ``heated`` coefficients at the end."""
    state, why = start or initial_state(made.system, control, made.coef)
    assert why == ""
    begun, losses = state, 0.0
    for k in range(windows):
        t = end * k / windows
        window = Window(t, end * (k + 1) / windows - t, made.coef, heated or made.coef)
        state, lost, why = advance(made.system, control, state, window)
        assert why == ""
        losses = losses + lost
    return begun, state, losses


def terms(state):
    return dict(zip(TERMS, state.ledger, strict=True))


# ------------------------------------------------------------------------------ the whole ledger


@cache
def everything():
    """A driven rope with a ball in a bore that rattles, rubs, warms up, falls and is pushed."""
    rope = straight(1.0, 2, THICK, elastic(1e6, 0.0, 100.0, 1e-4), "cable")
    rope = replace(rope, damping_time=1e-4)
    ball = Particle("ball", X, 0.5)
    joints = [
        Revolute("motor", Site("beam", 0), Site(None), Z, lambda t: 0.02 - 0.02 * np.cos(40.0 * t)),
        Spherical("knot", Site("beam", 2), Site("ball")),
        bore(NormalContact("linear", 1e5, restitution=0.7), Friction(0.3), at=X),
    ]  # fmt: skip
    push = Force("push", Site("beam", 1), Y, lambda t: 5.0 * np.sin(60.0 * t))
    made = model([rope, ball], joints, [push], gravity=(0.0, -9.81, 0.0))
    warm = made.system.coefficients(sections(made.system, 299.15, 50.0, 20.0))
    return made, warm


@pytest.mark.parametrize("alpha", [-0.02, -0.1, -1 / 3])
@pytest.mark.parametrize("h", [1e-3, 1e-4])
def test_the_ledger_closes(alpha, h):
    made, warm = everything()
    start, end, _ = run(made, fixed(h, alpha, 1e-14), 0.1, heated=warm)
    a, b = terms(start), terms(end)
    gained = sum(b[k] - a[k] for k in STORED)
    known = sum(b[k] for k in WORKS) - sum(b[k] for k in LOSSES)
    largest = np.abs(end.ledger).max()
    assert largest > 0.01
    assert abs(b["defect"]) < 1e-7 * largest
    assert gained - known == pytest.approx(b["defect"], abs=1e-13 * largest)


def test_every_term_is_at_work_in_the_scene_that_closes():
    made, warm = everything()
    row = terms(run(made, fixed(1e-4), 0.1, heated=warm)[1])
    idle = {name for name, value in row.items() if abs(value) < 1e-7}
    assert idle <= {"defect", "numerical", "contact_elastic"}
    assert row["friction"] > 0 and row["hysteresis"] > 0 and row["damping"] > 0


def test_numerical_loss_falls_with_the_step():
    """A wrong sign or a forgotten work would stay, in the line of the numerical loss."""
    made, warm = everything()
    coarse, fine = (run(made, fixed(h), 0.05, heated=warm)[1] for h in (1e-3, 5e-5))
    fine = terms(fine)
    assert abs(fine["numerical"]) < 0.1 * abs(terms(coarse)["numerical"])
    others = (fine[name] for name in ("hysteresis", "damping", "work_thermal"))
    assert abs(fine["numerical"]) < 0.1 * min(others)


def test_the_defect_shows_a_newton_iteration_that_stops_too_early():
    made, warm = everything()
    coarse = run(made, fixed(1e-3, newton=1e-4), 0.1, heated=warm)[1]
    fine = run(made, fixed(1e-3, newton=1e-14), 0.1, heated=warm)[1]
    assert abs(terms(coarse)["defect"]) > 1e2 * abs(terms(fine)["defect"])


def test_stored_energies_are_those_of_the_state():
    made, warm = everything()
    _, end, _ = run(made, fixed(1e-3), 0.1, heated=warm)
    m, row = end.motion, terms(end)
    assert row["kinetic"] == pytest.approx(0.5 * m.v @ (made.system.mass @ m.v), rel=1e-14)
    y = made.system.unknowns(m.q, m.lam)
    found = made.system.energies(y, np.concatenate([m.v, 0.0 * m.lam]), warm)
    assert (row["strain"], row["contact_elastic"]) == tuple(found[:2])


# -------------------------------------------------------------------------------------- works


def test_work_of_a_force_and_of_gravity():
    """A free ball: F d = m v^2/2, with d and v from the state."""
    push = Force("push", Site("ball"), X, lambda t: 6.0)
    made = model(Particle("ball", np.zeros(3), 2.0), [], [push], gravity=(0.0, -9.81, 0.0))
    _, end, _ = run(made, fixed(1e-2), 0.5)
    row, d = terms(end), end.motion.q
    assert row["work_loads"] == pytest.approx(6.0 * d[0] + 2.0 * -9.81 * d[1], rel=1e-12)
    assert row["work_loads"] == pytest.approx(0.5 * 2.0 * 0.5**2 * (3.0**2 + 9.81**2), rel=1e-12)
    assert row["kinetic"] == pytest.approx(row["work_loads"], rel=1e-12)


def test_work_of_a_drive_is_torque_times_angle_and_turns_into_kinetic_energy():
    rod = straight(1.0, 2, THICK, elastic(1e9, 0.0, 1000.0), "cable")
    rate, rise = 2.0, 0.5

    def angle(t):  # the rate rises as sin^2 and stays
        x = min(t / rise, 1.0)
        return rate * rise * (0.5 * x - np.sin(np.pi * x) / (2 * np.pi)) + rate * max(t - rise, 0.0)

    made = model(rod, [Revolute("motor", Site("beam", 0), Site(None), Z, angle)])
    control = fixed(2e-3)
    start, kept = initial_state(made.system, control, made.coef)[0], []
    window = Window(0.0, 0.6, made.coef, made.coef)
    end, _, why = advance(made.system, control, start, window, kept.append)
    assert why == ""
    row = terms(end)
    inertia = 1000.0 * 1e-2 * 1.0**3 / 3.0
    assert row["work_drive"] == pytest.approx(0.5 * inertia * rate**2, rel=1e-2)
    first = start.motion.lam[made.system.driven]
    torque = -np.concatenate([first, *(rows.drive[:, 0] for rows in kept)])
    turned = np.diff([angle(t) for t in np.concatenate([[0.0], *(rows.t for rows in kept)])])
    by_torque = np.sum(0.5 * (torque[1:] + torque[:-1]) * turned)
    assert row["work_drive"] == pytest.approx(by_torque, rel=1e-4)
    assert row["work_drive"] == pytest.approx(row["kinetic"] + row["strain"], rel=1e-3)


def held_bar(material):
    """A bar between two fixed points, at the reference temperature."""
    bar = straight(0.5, 2, THICK, material, "cable")
    there = Site(None, position=0.5 * X)
    ends = [Spherical("a", Site("beam", 0), Site(None)), Spherical("b", Site("beam", 2), there)]
    return model(bar, ends)


def energy_of_held_bar(material, T):
    """E V e^2/2: the volume of the free bar, and Green's strain from it back to the held one."""
    stretch = 1.0 + material.thermal_strain(T, 298.15)
    volume, strain = 1e-2 * 0.5 * stretch**3, 0.5 * (1.0 / stretch**2 - 1.0)
    return 0.5 * material.youngs_modulus(T) * volume * strain**2


def warmed(made: Model, T):
    return made.system.coefficients(sections(made.system, T))


@pytest.mark.parametrize("name", ["constant", "al6061-paper"])
@pytest.mark.parametrize("windows", [1, 3])
def test_work_of_heating_a_bar_between_walls(name, windows):
    """What it takes to hold the bar back is stored in it; nothing moves."""
    material = elastic(70e9, 0.3, 2700.0, 2e-5) if name == "constant" else library_material(name)
    made, T = held_bar(material), 298.15 + 40.0
    state, _ = initial_state(made.system, fixed(0.01), made.coef)
    temperatures = np.linspace(298.15, T, windows + 1)
    for k in range(windows):
        c0, c1 = (warmed(made, t) for t in temperatures[k : k + 2])
        window = Window(0.1 * k, 0.1, c0, c1)
        state, _, why = advance(made.system, fixed(0.01), state, window)
        assert why == ""
    expected = energy_of_held_bar(material, T)
    row = terms(state)
    assert expected > 1.0
    assert row["work_thermal"] == pytest.approx(expected, rel=1e-9)
    assert row["strain"] == pytest.approx(expected, rel=1e-9)
    assert abs(row["defect"]) < 1e-9 * expected


def test_free_expansion_takes_no_work():
    """A bar that is free to grow, heated slowly: what it pushes is its own small mass."""
    bar = straight(0.5, 2, THICK, elastic(70e9, 0.3, 2700.0, 2e-5), "cable")
    made = model(replace(bar, damping_time=1e-5))
    cold, warm = made.coef, warmed(made, 338.15)
    state, _ = initial_state(made.system, fixed(0.01), cold)
    state, _, why = advance(made.system, fixed(0.01), state, Window(0.0, 1.0, cold, warm))
    assert why == ""
    held = 0.5 * 70e9 * 1e-2 * 0.5 * (2e-5 * 40.0) ** 2
    assert abs(terms(state)["work_thermal"]) < 1e-4 * held  # by one-sided sums 1e-2 of it


def test_a_jump_of_the_temperature_between_windows_is_work_of_heating():
    material = elastic(70e9, 0.3, 2700.0, 2e-5)
    made = held_bar(material)
    control = fixed(0.01)
    state, _ = initial_state(made.system, control, made.coef)
    warm = warmed(made, 338.15)
    state, _, _ = advance(made.system, control, state, Window(0.0, 0.1, made.coef, made.coef))
    state, _, _ = advance(made.system, control, state, Window(0.1, 0.1, warm, warm))
    row = terms(state)
    expected = energy_of_held_bar(material, 338.15)
    assert row["work_thermal"] == pytest.approx(expected, rel=1e-9)
    assert row["strain"] == pytest.approx(expected, rel=1e-9)


# ------------------------------------------------------------------------------------- losses


def test_friction_of_a_bead_that_slides_round_a_bore():
    """N = m v^2/r, hence v = v0/(1 + mu v0 t/r): all kinetic energy lost is friction."""
    mass, speed, radius, mu, stiffness = 1.0, 1.0, 0.1, 0.2, 1e7
    depth = mass * speed**2 / radius / stiffness
    ball = Particle("ball", (radius + depth) * X, mass, speed * Y)
    contact = NormalContact("linear", stiffness, restitution=0.9)
    made = model(ball, [bore(contact, Friction(mu, regularisation_speed=1e-7), radius)])
    _, end, lost = run(made, fixed(2e-4), 0.1)
    slowed = speed / (1.0 + mu * speed * 0.1 / radius)
    assert np.linalg.norm(end.motion.v) == pytest.approx(slowed, rel=1e-3)
    row = terms(end)
    assert row["friction"] == pytest.approx(0.5 * mass * (speed**2 - slowed**2), rel=2e-3)
    assert lost[0, 1] == pytest.approx(row["friction"], rel=1e-12)
    assert abs(row["hysteresis"]) < 1e-4 * row["friction"]


def test_hysteresis_of_one_impact():
    """m v^2 (1 - e^2)/2 with the speed after the impact from the state; no friction."""
    ball = Particle("ball", np.zeros(3), 2.0, 0.05 * X)
    made = model(ball, [bore(NormalContact(restitution=0.7))])
    _, end, lost = run(made, Control(1e-7, 1e-2, 1e-12), 0.03)
    row, after = terms(end), end.motion.v[0]
    assert -0.05 < after < -0.03
    assert row["contact_elastic"] == 0.0
    assert row["hysteresis"] == pytest.approx(0.5 * 2.0 * (0.05**2 - after**2), rel=2e-3)
    assert row["friction"] == 0.0 and lost[0, 1] == 0.0
    assert lost[0, 0] == pytest.approx(row["hysteresis"], rel=1e-12)


PULL, RATE = 1e-3, 10.0
SWING = 0.5 * PULL**2 / RATE**2
"""Energy [J] of the oscillation that a sudden PULL [N] starts: k = RATE^2 for 1 kg."""


def spring(damping_time=0.0):
    """A ball of 1 kg on a light elastic rope, pulled along it from t = 0 on."""
    rope = straight(1.0, 1, THICK, elastic(RATE**2 / 1e-2, 0.0, 0.01), "cable")
    joints = [
        Guide("nail", Site("beam", 0), np.eye(3)),
        Spherical("knot", Site("beam", 1), Site("ball")),
        Guide("line", Site("ball"), np.array([Y, Z])),
    ]
    pull = Force("pull", Site("ball"), X, lambda t: PULL)
    return model(
        [replace(rope, damping_time=damping_time), Particle("ball", X, 1.0)], joints, [pull]
    )


def unaccounted(row):
    """Work of the loads that is not stored [J]."""
    return row["work_loads"] - sum(row[k] for k in STORED)


def test_structural_damping_takes_energy_at_its_rate():
    """Kelvin-Voigt: the oscillation decays with exp(-omega^2 tau t)."""
    tau, end = 2e-3, 2.0 * np.pi  # ten periods
    row = terms(run(spring(tau), fixed(5e-3, alpha=-1e-3), end)[1])
    lost = SWING * (1.0 - np.exp(-(RATE**2) * tau * end))
    assert row["damping"] == pytest.approx(lost, rel=5e-3)
    assert abs(row["numerical"]) < 2e-3 * lost
    assert unaccounted(row) == pytest.approx(row["damping"] + row["numerical"], rel=1e-6)


@pytest.mark.parametrize("alpha", [-0.1, -1 / 3])
def test_numerical_damping_is_what_the_oscillator_loses(alpha):
    row = terms(run(spring(), fixed(2e-2, alpha), 2.0 * np.pi)[1])
    assert row["numerical"] > 5e-3 * SWING
    assert row["numerical"] == pytest.approx(unaccounted(row), rel=1e-6)


def test_the_trapezoidal_rule_loses_nothing():
    row = terms(run(spring(), fixed(2e-2, alpha=0.0), 2.0 * np.pi)[1])
    assert abs(row["numerical"]) < 1e-3 * SWING  # the rope is nearly linear
    assert abs(row["defect"]) < 1e-9 * SWING
