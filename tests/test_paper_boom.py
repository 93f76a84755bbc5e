"""The boom of Table 7 against closed forms, and the numbers of the section about it."""

from math import cos, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from coupling import casefile
from coupling.paper import boom
from coupling.paper.workshop import Workshop
from coupling.report_tables import Sought
from coupling.reports.timed_runs import timed

CASE = Path(__file__).resolve().parents[1] / "cases" / "boom_temperature"
LENGTH, RADIUS, WALL = 65.5, 0.27, 2e-3
MODULUS, DENSITY, EXPANSION = 69e9, 2700.0, 23.1e-6  # Table 1 at 25 degC
OMEGA = 1.8751041**2 * sqrt(MODULUS / DENSITY * RADIUS**2 / 2) / LENGTH**2


def _final(variants, of, **overrides):
    scene = casefile.read(CASE, [f"{k}={v}" for k, v in overrides.items()], variants)
    ran = timed(scene, {"q": Sought(of=of)})
    assert ran.outcome == "done", ran.reason
    return ran.values["q"][:, 0]


def test_bow_is_an_arc():
    kappa = EXPANSION * 50.0
    found = _final(["bow", "hua2026"], "probe.tip.y")[-1]
    assert found == pytest.approx((1.0 - cos(kappa * LENGTH)) / kappa, rel=1e-3)


def test_first_bending_mode_is_that_of_a_cantilever():
    found = _final(["modes", "hua2026"], "mode.1.frequency")[-1]
    assert found == pytest.approx(OMEGA / (2.0 * pi), rel=2e-3)


def test_first_mode_along_the_boom():
    found = _final(["modes", "axial", "hua2026"], "mode.16.frequency")[-1]
    assert found == pytest.approx(sqrt(MODULUS / DENSITY) / (4.0 * LENGTH), rel=1e-3)


@pytest.mark.slow
def test_swing_after_sudden_sunlight():
    """The tip drifts at the rate of the bow and swings by that over the frequency (Boley 1956)."""
    speed = _final(["hua2026"], "probe.tip.vy")
    lag = RADIUS**2 * DENSITY * 896.0 / 167.0
    drift = EXPANSION * 50.0 * LENGTH**2 / 2.0 / lag
    assert np.ptp(speed) / 2.0 == pytest.approx(drift, rel=0.05)


def test_printed_power_of_the_clearance():
    clearance, force, rate = boom._printed(Workshop(Path()), boom.LOOSE, "table_8")
    assert boom.exponent(clearance, force) == pytest.approx(0.494, abs=5e-4)
    assert boom.exponent(clearance, rate) == pytest.approx(0.448, abs=5e-3)
    assert boom.direction(force) == pytest.approx(1.0)
    assert boom.direction(-rate) == pytest.approx(-1.0)
    assert np.isnan(boom.direction(np.ones(6)))
