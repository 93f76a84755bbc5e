"""The report of response amplitudes: its describing function, its motion, its trend."""

from math import cos, pi

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from coupling.reports import response_amplitude as report
from coupling.reports.response_amplitude import KINDS, peak, stiffness_share, sweep

FAST, LARGE = report.CLEARANCES[0], report.CLEARANCES[-1]


def behind_a_gap(clearance, frequency, cycles=30):
    """Amplitude over the static deflection of one mass on a spring with a gap, by DOP853."""
    k, d, m = report.STIFFNESS, report.DAMPING + report.END_DAMPING, report.MASS

    def rate(t, y):
        deflection = np.sign(y[0]) * max(abs(y[0]) - clearance, 0.0)
        return [y[1], (report.FORCE * cos(frequency * t) - d * y[1] - k * deflection) / m]

    cycle = 2.0 * pi / frequency
    times = np.linspace(cycles - 2, cycles, 401) * cycle
    found = solve_ivp(rate, (0.0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-9, atol=1e-12,
                      max_step=cycle / 50)  # fmt: skip
    return 0.5 * np.ptp(found.y[0]) * k / report.FORCE


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.9])
def test_the_share_of_stiffness_is_the_first_harmonic_of_a_dead_zone(ratio):
    def force(phase):
        x = cos(phase)
        return np.sign(x) * max(abs(x) - ratio, 0.0) * x

    first = 4.0 / pi * quad(force, 0.0, pi / 2, points=[np.arccos(ratio)])[0]
    assert stiffness_share(ratio) == pytest.approx(first, rel=1e-9)


def test_nothing_acts_inside_the_gap():
    assert stiffness_share(1.5) == 0.0 and stiffness_share(0.0) == 1.0


@pytest.mark.parametrize("clearance", [FAST, LARGE])
def test_the_peak_of_the_describing_function_is_that_of_a_mass_behind_a_gap(clearance):
    height, frequency = report.expected_peak(clearance)
    assert behind_a_gap(clearance, frequency) == pytest.approx(height, rel=0.01)
    both = report.response(0.999 * height * report.FORCE / report.STIFFNESS, clearance)
    assert both is not None and both[0] < frequency < both[1]
    assert report.response(1.001 * height * report.FORCE / report.STIFFNESS, clearance) is None


def test_the_peak_of_a_parabola_is_its_top():
    x = report.FREQUENCIES
    y = 5.0 - 0.3 * (np.array(x) - 8.3) ** 2
    assert peak(y) == pytest.approx((5.0, 8.3))


@pytest.mark.parametrize("kind", KINDS)
def test_the_payload_moves_as_a_mass_behind_a_gap(kind, monkeypatch):
    """The lighter the end of the arm, the less its impacts take: 6 % at 10 g, 1 % at 1 g."""
    monkeypatch.setattr(report, "END_MASS", 1e-3)
    (ours,) = sweep(kind, LARGE, (8.5,))
    assert ours == pytest.approx(behind_a_gap(LARGE, 8.5), rel=0.015)


def test_the_peak_rises_and_its_frequency_falls_with_the_clearance():
    frequencies = (8.0, 8.5, 9.0, 9.5, 10.0)
    small, large = (peak(sweep("spherical", c, frequencies), frequencies) for c in (FAST, LARGE))
    assert large[0] > 1.05 * small[0] and large[1] < small[1] - 0.8


def test_a_moved_root_makes_peaks_that_fall():
    base = report.FORCE / report.STIFFNESS
    d = report.DAMPING + report.END_DAMPING
    without = report.moved_peak(1e-9, base)
    exact = max(
        report.STIFFNESS / abs(complex(report.STIFFNESS - report.MASS * w * w, d * w))
        for w in np.linspace(9.0, 10.5, 301)
    )
    assert without == pytest.approx(exact, rel=1e-3)
    assert without > report.moved_peak(FAST, base) > report.moved_peak(LARGE, base)


def test_the_drive_changes_its_frequency_without_a_jump():
    drive = report.Drive(2.0)
    before = drive(1.3)
    drive.change(1.3, 5.0)
    assert drive(1.3) == pytest.approx(before, rel=1e-12)
    assert drive(1.3 + 2.0 * pi / 5.0) == pytest.approx(before, rel=1e-12)


def test_notes_say_what_the_numbers_do():
    rows = [
        ("spherical", c, top, at, 0.0, 0.0) for c, top, at in ((1, 4, 9), (2, 5, 8), (3, 4.5, 7))
    ]
    note = report._trend("spherical", rows)
    assert "peak goes up and down from 4.00 to 4.50" in note
    assert "frequency falls from 9.00 to 7.00 rad/s" in note


def test_the_map_is_of_amplitudes_over_angle_and_frequency(monkeypatch):
    """Spots are those of the sweep, computed once for each clearance; the ridge falls."""
    asked = []

    def sweep(kind, clearance):
        asked.append((kind, clearance))
        w = np.array(report.FREQUENCIES)
        return 1.0 / np.hypot(1.0 - (w / 9.0) ** 2, 0.2 * w / 9.0)

    monkeypatch.setattr(report, "sweep", sweep)
    results = list(report.report())
    assert [r.name for r in results] == ["response_amplitude", "response_map"]
    assert len(asked) == len(set(asked)) == 12 + 4
    (picture,) = results[1].pictures
    assert len(picture.spots) == len(report.ANGLES) * len(report.FREQUENCIES)
    assert np.all(np.diff(picture.curves[0].x) < 0.0)
    for row in results[1].rows:
        assert row[1] == pytest.approx(0.1 * row[0])
        # |H| = 2 at w/9 from sqrt(x), (1 - x)^2 + 0.04 x = 1/4
        low, high = 9.0 * np.sqrt(np.sort(np.roots([1.0, -1.96, 0.75])))
        assert row[6:] == pytest.approx((low, high), abs=0.3)
