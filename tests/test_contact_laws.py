"""Compiled normal laws against integration, quadrature and closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from mechanics import contact
from mechanics import contact_laws as laws
from mechanics.description import NormalContact

STEEL = (210e9, 0.3, 210e9, 0.3)
MODULUS = 210e9 / (1 - 0.3**2) / 2
MASS = 0.2


def slot(stiffness="hertz-external", value=None, factor=0.0, approach=0.0, reference=0.0):
    """Contact of a pin of 9.5 mm in a bore of 10 mm, 15 mm long."""
    law = NormalContact(stiffness, value)
    c = np.zeros(laws.SLOT)
    c[laws.ACTIVE], c[laws.APPROACH], c[laws.REFERENCE] = 1.0, approach, reference
    c[laws.LAW : laws.P + 1] = contact.law_columns(law, 9.5e-3, 0.5e-3, 15e-3, 1.0, *STEEL)
    c[laws.FACTOR] = factor
    return c


SLOTS = {
    "hertz-external": slot(),
    "hertz-internal": slot("hertz-internal"),
    "linear": slot("linear", 3e6),
    "cylinder": slot("cylinder"),
}


def with_factor(name, factor, approach):
    c = SLOTS[name].copy()
    c[laws.FACTOR], c[laws.APPROACH] = factor, approach
    return c


def impact(c, speed):
    """Speed of separation and duration of m δ̈ = -N(δ, δ̇), integrated."""
    length = laws.duration(MASS, speed, c)

    def motion(t, state):
        return [state[1], -sum(laws.normal(state[0], state[1], c)) / MASS]

    def apart(t, state):
        return state[0] if t > 0.0 else 1.0

    apart.terminal, apart.direction = True, -1
    run = solve_ivp(
        motion, (0.0, 20 * length), [0.0, speed], events=apart, method="DOP853", rtol=1e-10,
        atol=1e-14 * np.array([speed * length, speed]), max_step=length / 50,
    )  # fmt: skip
    return -run.y_events[0][0, 1], run.t_events[0][0]


@pytest.mark.parametrize("stiffness", SLOTS)
@pytest.mark.parametrize("law", contact.DISSIPATION)
def test_delivered_restitution(law, stiffness):
    """D (1 + e) = ln((1 + D)/(1 - D e)) holds for any elastic law."""
    for e, speed in ((0.3, 0.02), (0.85, 1.0)):
        D = contact.DISSIPATION[law](e)
        delivered = impact(with_factor(stiffness, D, speed), speed)[0] / speed
        assert D * (1 + delivered) == pytest.approx(np.log((1 + D) / (1 - D * delivered)), rel=2e-5)
        assert delivered == pytest.approx(contact.delivered_restitution(D), rel=2e-5)
        if law == "exact":
            assert delivered == pytest.approx(e, rel=2e-5)


@pytest.mark.parametrize("stiffness", SLOTS)
def test_elastic_impact_keeps_its_speed_and_lasts_as_estimated(stiffness):
    tolerance = 0.03 if stiffness == "cylinder" else 1e-6  # 30 m/s leads beyond its range
    for speed in (1e-4, 0.1, 30.0):
        rebound, lasted = impact(SLOTS[stiffness], speed)
        assert rebound == pytest.approx(speed, rel=1e-7)
        assert laws.duration(MASS, speed, SLOTS[stiffness]) == pytest.approx(lasted, rel=tolerance)


def test_duration_of_power_laws_in_closed_form():
    steel_ball = SLOTS["hertz-external"].copy()
    steel_ball[laws.K] = 1.53846e10
    assert laws.duration(0.032673, 1.0, steel_ball) == pytest.approx(6.8934e-5, rel=1e-4)
    for speed in (0.0, 1e-9, 7.0):
        lasted = laws.duration(MASS, speed, SLOTS["linear"])
        assert lasted == pytest.approx(np.pi * np.sqrt(MASS / 3e6), rel=1e-12)


@pytest.mark.parametrize("stiffness", SLOTS)
def test_energy_is_the_integral_of_the_force(stiffness):
    c = SLOTS[stiffness]
    for depth in (1e-9, 1e-6, 1e-4, 2.6e-4, 2.69e-4, 2.71e-4, 1e-3):
        # in ln δ, because the slope of two of the laws is singular at 0
        work = quad(
            lambda u: np.exp(u) * laws.normal(np.exp(u), 0.0, c)[0],
            np.log(depth) - 60.0, np.log(depth), epsabs=0.0, epsrel=1e-11, limit=400,
        )[0]  # fmt: skip
        assert laws.stored(depth, c) == pytest.approx(work, rel=1e-9)


def test_cylinder_force_solves_johnsons_equation():
    """δ = F/(π E* L) (ln(4 π E* L ΔR/F) - 1), ΔR = 0.5 mm, L = 15 mm."""
    for depth in (1e-12, 1e-9, 1e-7, 5e-6, 1e-4, 2.5e-4):
        force, dissipated = laws.normal(depth, 1.0, SLOTS["cylinder"])

        def excess(F, depth=depth):
            line = F / (np.pi * MODULUS * 15e-3)
            return line * (np.log(4 * np.pi * MODULUS * 15e-3 * 0.5e-3 / F) - 1) - depth

        top = 0.9 * 4 * np.pi * MODULUS * 15e-3 * 0.5e-3 / np.e**2
        expected = brentq(excess, 1e-12 * top, top, xtol=1e-300, rtol=1e-14)
        assert force == pytest.approx(expected, rel=1e-11)
        assert dissipated == 0.0


def test_cylinder_law_goes_on_with_its_slope():
    c = SLOTS["cylinder"]
    last = (0.9 / np.e**2 * c[laws.P] / c[laws.K]) * (1 - np.log(0.9))
    at, slope = (laws.normal(last * (1 + s), 0.0, c)[0] for s in (0.0, 1e-6))
    assert at == pytest.approx(0.9 * c[laws.P] / np.e**2, rel=1e-12)
    slope = (slope - at) / (1e-6 * last)
    assert slope == pytest.approx(c[laws.K] / -np.log(0.9), rel=1e-6)
    for part in (1 - 1e-9, 1 + 1e-9, 1.5, 10.0):
        force = laws.normal(part * last, 0.0, c)[0]
        assert force == pytest.approx(at + slope * (part - 1) * last, rel=1e-6)


def test_cylinder_law_without_clearance_is_linear():
    """What the law tends to where the clearance vanishes; also with interference."""
    c = SLOTS["cylinder"].copy()
    expected = c[laws.K] / -np.log(0.9) * 1e-5
    for limit, tolerance in ((-1.0, 1e-12), (0.0, 1e-12), (1e-9 * c[laws.P], 1e-3)):
        c[laws.P] = limit
        assert laws.normal(1e-5, 0.0, c)[0] == pytest.approx(expected, rel=tolerance)
        assert laws.stored(1e-5, c) == pytest.approx(0.5e-5 * expected, rel=tolerance)
        assert laws.duration(MASS, 0.1, c) == pytest.approx(
            np.pi * np.sqrt(MASS * 1e-5 / expected), rel=tolerance
        )


@pytest.mark.parametrize("stiffness", SLOTS)
def test_derivatives_by_an_imaginary_step(stiffness):
    c = with_factor(stiffness, 0.4, 0.2)
    for depth in (1e-8, 3e-6, 2e-4, 2.6e-4, 6e-4):
        for rate in (-1.0, -0.3, 0.0, 0.2, 5.0):  # the first is clipped
            for part in range(2):
                step, small = 1e-5 * depth, 1e-25j
                by_depth = [laws.normal(depth + s * step, rate, c)[part] for s in (-1, 1)]
                by_rate = [laws.normal(depth, rate + s * 1e-5, c)[part] for s in (-1, 1)]
                exact = [laws.normal(depth + small, rate, c)[part].imag / 1e-25,
                         laws.normal(depth, rate + small, c)[part].imag / 1e-25]  # fmt: skip
                force = laws.normal(depth, 0.0, c)[0]
                assert np.diff(by_depth)[0] / (2 * step) == pytest.approx(
                    exact[0], rel=1e-6, abs=1e-6 * force / depth
                )
                assert np.diff(by_rate)[0] / 2e-5 == pytest.approx(
                    exact[1], rel=1e-6, abs=1e-6 * force
                )
    assert laws.normal(-1e-6 + 1e-25j, 1.0, c) == (0.0, 0.0)


def test_dissipation_by_the_approach_speed():
    c = with_factor("linear", 0.5, 0.1)
    assert laws.normal(1e-6, 0.1, c) == pytest.approx((3.0, 1.5))
    assert laws.normal(1e-6, -0.1, c) == pytest.approx((3.0, -1.5))
    assert laws.normal(1e-6, -0.3, c) == pytest.approx((3.0, -3.0))  # it does not pull
    c[laws.APPROACH] = -1.0
    assert laws.normal(1e-6, 0.1, c) == pytest.approx((3.0, 0.0))
    c[laws.REFERENCE] = 0.2
    assert laws.normal(1e-6, 0.1, c) == pytest.approx((3.0, 0.75))
    c[laws.ACTIVE] = 0.0
    assert laws.normal(1e-6, 0.1, c) == (0.0, 0.0)
    assert laws.stored(1e-6, c) == 0.0


def test_forces_and_energies_are_numbers():
    for c in (*SLOTS.values(), np.where(np.arange(laws.SLOT) == laws.P, 0.0, SLOTS["cylinder"])):
        for depth in 10.0 ** np.arange(-320, 20, 5):
            for z in (depth, depth + 1e-30j):
                assert np.all(np.isfinite(laws.normal(z, -3.0, c)))
            assert np.isfinite(laws.stored(depth, c))
        for speed in 10.0 ** np.arange(-99, 9, 3):
            assert laws.duration(MASS, speed, c) > 0.0
