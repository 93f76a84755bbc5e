from math import inf, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from coupling.histories import Constant, Ramp, SCurve, Sine, Step, Table

DRIVE = SCurve(rate=0.0014, rise=10.0, total=0.79, start=3.0)

HISTORIES = [
    Constant(5.0),
    Table((0.0, 1.0, 4.0), (1.0, 7.0, -2.0)),
    Table((2.0,), (3.0,)),
    Ramp(1.0, 3.0, 10.0, -10.0),
    Step(2.0, 1.0, 4.0),
    Sine(2.0, 0.25, 0.3, 1.0),
    DRIVE,
    SCurve(rate=-1.0, rise=1.0, total=-1.0),
]


def test_constant():
    assert Constant(5.0)(-1.0) == Constant(5.0)(1e9) == 5.0


@given(st.floats(0.0, 6.0))
def test_table_is_what_numpy_interpolates(t):
    times, values = (0.0, 1.0, 4.0, 4.5), (1.0, 7.0, -2.0, 0.0)
    assert Table(times, values)(t) == pytest.approx(np.interp(t, times, values), abs=1e-12)


def test_table_hits_its_points():
    table = Table((0.0, 0.1, 0.7), (0.3, 0.2, 0.9))
    assert [table(t) for t in table.times] == list(table.values)


def test_ramp():
    ramp = Ramp(1.0, 3.0, 10.0, 20.0)
    assert [ramp(t) for t in (0.0, 1.0, 1.5, 3.0, 99.0)] == [10.0, 10.0, 12.5, 20.0, 20.0]


@pytest.mark.parametrize(
    "history", [Ramp(0.0, 2.0, 1.0, 7.0), Table((0.0, 2.0, 3.0), (1.0, 7.0, 0.0))]
)
def test_what_begins_with_a_slope_has_it_at_once(history):
    assert [history(t) for t in (-0.5, 0.0, 0.5)] == [-0.5, 1.0, 2.5]


def test_what_begins_later_rests_before():
    assert Ramp(1.0, 3.0, 10.0, 20.0)(-1.0) == Table((1.0, 3.0), (10.0, 20.0))(-1.0) == 10.0


def test_step_acts_from_its_time_on():
    step = Step(2.0, 1.0, 4.0)
    assert [step(t) for t in (0.0, np.nextafter(2.0, 0.0), 2.0, 3.0)] == [1.0, 1.0, 4.0, 4.0]


def test_sine():
    sine = Sine(amplitude=2.0, frequency=0.5, phase=pi / 6, offset=1.0)
    assert sine(0.0) == pytest.approx(2.0)
    assert sine(0.7) == pytest.approx(1.0 + 2.0 * sin(pi * 0.7 + pi / 6))


def test_s_curve_is_at_rest_before_and_after():
    assert DRIVE(0.0) == DRIVE(3.0) == 0.0
    assert DRIVE(3.0 + DRIVE.duration) == DRIVE(1e6) == DRIVE.total


def test_s_curve_is_the_integral_of_a_quintic_rise_and_fall_of_its_rate():
    def rate(t):
        x = min(max(min(t - 3.0, 3.0 + DRIVE.duration - t) / 10.0, 0.0), 1.0)
        return 0.0014 * (10 * x**3 - 15 * x**4 + 6 * x**5)

    corners = [13.0, 3.0 + DRIVE.duration - 10.0]
    for t in (5.0, 8.0, 13.0, 200.0, 3.0 + DRIVE.duration - 4.0, 3.0 + DRIVE.duration):
        expected, _ = quad(rate, 3.0, t, points=[c for c in corners if c < t], epsabs=1e-13)
        assert DRIVE(t) == pytest.approx(expected, abs=1e-12)


def test_s_curve_runs_at_its_rate_in_the_middle():
    middle = 3.0 + DRIVE.duration / 2
    assert (DRIVE(middle + 1.0) - DRIVE(middle - 1.0)) / 2.0 == pytest.approx(0.0014, rel=1e-12)


@pytest.mark.parametrize("corner", [0.0, 1.0, 3.0, 4.0])
def test_s_curve_has_three_continuous_derivatives(corner):
    """Third differences on both sides of a corner meet as the step is halved."""
    drive = SCurve(rate=1.0, rise=1.0, total=3.0)

    def jump(h):
        left = [drive(corner - i * h) for i in range(4)]
        right = [drive(corner + i * h) for i in range(4)]
        third = [a - 3 * b + 3 * c - d for a, b, c, d in (left, right)]
        return abs(third[0] + third[1]) / h**3

    assert jump(0.01) < 2.0  # a cubic rise of the rate would make it 6
    assert jump(0.01) == pytest.approx(2 * jump(0.005), rel=0.1, abs=1e-6)


def test_s_curve_without_a_plateau_reaches_its_rate_once():
    drive = SCurve(rate=2.0, rise=1.0, total=2.0)
    assert drive.duration == 2.0
    assert drive(1.0) == pytest.approx(1.0)
    assert (drive(1.0 + 1e-6) - drive(1.0 - 1e-6)) / 2e-6 == pytest.approx(2.0)


@pytest.mark.parametrize("history", HISTORIES)
@pytest.mark.parametrize("end", [0.5, 2.5, 100.0])
def test_bounds_hold_all_values(history, end):
    values = [history(t) for t in np.linspace(0.0, end, 1001)]
    low, high = history.bounds(end)
    assert low <= min(values) + 1e-12
    assert high >= max(values) - 1e-12
    if not isinstance(history, Sine):  # whose bounds are those of a whole period
        assert (low, high) == pytest.approx((min(values), max(values)), abs=0.05)


@pytest.mark.parametrize("history", HISTORIES)
def test_bounds_of_all_times_are_finite(history):
    assert all(abs(bound) < inf for bound in history.bounds(inf))


@pytest.mark.parametrize("history", HISTORIES)
def test_values_are_floats(history):
    assert all(type(history(t)) is float for t in (0.0, 1.0, 2.0, 50.0))
