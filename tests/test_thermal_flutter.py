"""Thermal flutter of a boom against Routh and Hurwitz, and eigenvalues of several modes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from coupling import casefile
from coupling.model import build
from coupling.verify import flutter
from coupling.verify.flutter import BOOM, found_ratio, measured, swing

CASE = Path(__file__).parent.parent / "cases" / "thermal_flutter"


def of_modes(boom, count=3):
    """Least damped eigenvalue of some modes about the straight boom, with their heat."""
    starts = [1.8751, 4.6941, 7.8548][:count]
    roots = [brentq(lambda x: np.cos(x) * np.cosh(x) + 1.0, b - 0.1, b + 0.1) for b in starts]
    x, rows = np.linspace(0.0, 1.0, 1001), []
    for b in roots:
        ratio, z = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b)), b * x
        slope = b * (np.sinh(z) + np.sin(z) - ratio * (np.cosh(z) - np.cos(z)))
        bend = b**2 * (np.cosh(z) + np.cos(z) - ratio * (np.sinh(z) + np.sin(z)))
        rows.append((slope, bend))
    gain = boom.curvature * boom.length * np.sin(boom.sun)
    light = [[gain * np.trapezoid(s * b, x) / np.trapezoid(b * b, x) for s, _ in rows]
             for _, b in rows]  # fmt: skip
    w = np.diag(boom.frequency * (np.array(roots) / roots[0]) ** 2)
    one, none = np.eye(count), np.zeros((count, count))
    matrix = np.block([
        [none, one, none],
        [-w @ w, -boom.damping * w @ w, w @ w @ np.array(light)],
        [one / boom.lag, none, -one / boom.lag],
    ])  # fmt: skip
    values = np.linalg.eigvals(matrix)
    return values[np.argmin(np.abs(values - 1j * boom.frequency))]


def test_the_growth_vanishes_at_the_ratio_of_routh_and_hurwitz():
    boom = replace(BOOM, damping=2.0 * BOOM.critical_ratio / BOOM.frequency)
    assert_allclose(boom.growth.real, 0.0, atol=1e-12)
    assert_allclose(BOOM.delayed_ratio(0.0), BOOM.critical_ratio, rtol=1e-12)


def test_one_mode_is_enough():
    faint = replace(BOOM, absorptivity=0.03, emissivity=0.01, damping=0.0)  # hardly bent
    assert_allclose(faint.growth.real, of_modes(faint).real, rtol=0.04)
    assert_allclose(faint.growth.imag, of_modes(faint).imag, rtol=1e-5)


def test_the_shipped_case_flutters_as_the_formula_says():
    model = build(casefile.read(CASE, ["time.end='300 s'"]))
    found = measured(*swing(model), BOOM.growth)
    light = BOOM.growth.real + BOOM.ratio * BOOM.frequency
    assert_allclose(found.real, BOOM.growth.real, atol=0.05 * light)
    assert_allclose(found.imag, BOOM.growth.imag, rtol=1e-3)


def test_more_damping_or_sun_ahead_of_the_clamp_keep_it_quiet():
    for boom in (replace(BOOM, damping=0.2), replace(BOOM, sun=np.pi / 4.0)):
        assert boom.growth.real < 0.0
        found = measured(*swing(boom.model("corrected", 2.0, 300.0)), boom.growth)
        assert found.real < 0.0


def test_a_measured_rate_is_that_of_the_oscillation():
    t = np.arange(0.0, 400.0, 2.0)
    y = 0.3 + 1e-4 * t + 0.02 * np.exp(-2e-3 * t) * np.cos(0.11 * t + 1.0)
    found = measured(t, y, 1e-3 + 0.118j)
    assert_allclose([found.real, found.imag], [-2e-3, 0.11], rtol=1e-6)


@pytest.mark.slow
def test_the_schemes_against_the_formulas():
    for check in (*flutter.growing(), *flutter.threshold()):
        assert check.passed, check


@pytest.mark.slow
def test_late_light_moves_the_threshold_of_serial_and_not_of_iterated():
    serial, iterated = (found_ratio(BOOM, scheme, 4.0) for scheme in ("serial", "iterated"))
    assert serial > 1.15 * BOOM.critical_ratio
    assert_allclose(iterated, BOOM.critical_ratio, rtol=0.05)
