"""Measures of regularity of motions whose nature is known."""

from time import perf_counter

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import digamma

from coupling import regularity as own
from coupling.regularity import regularity


def _duffing(amplitude, periods=200, each=25):
    """x'' + 0.3 x' - x + x^3 = a cos(1.2 t) (Jordan & Smith 2007), after 50 periods."""
    period = 2.0 * np.pi / 1.2
    t = np.arange(periods * each) * period / each

    def rate(t, s):
        return [s[1], -0.3 * s[1] + s[0] - s[0] ** 3 + amplitude * np.cos(1.2 * t)]

    settled = 50.0 * period
    end = t[-1] + settled
    found = solve_ivp(rate, (0.0, end), [1.0, 0.0], t_eval=t + settled, rtol=1e-9, atol=1e-9)
    return t, found.y[0], found.y[1], period


def _logistic(n):
    x = [0.3]
    for _ in range(n - 1):
        x.append(4.0 * x[-1] * (1.0 - x[-1]))
    return np.array(x)


def _lorenz():
    """Parameters of Rosenstein, Collins & De Luca (1993), Table 1: exponent 1.50 1/s."""

    def rate(_, s):
        x, y, z = s
        return [16.0 * (y - x), x * (45.92 - z) - y, x * y - 4.0 * z]

    t = np.arange(5000) * 0.01
    found = solve_ivp(rate, (0.0, 70.0), [1.0, 1.0, 40.0], t_eval=t + 20.0, rtol=1e-9, atol=1e-9)
    return t, found.y[0], found.y[2]


def test_sine_is_regular():
    t = np.linspace(0.0, 500.0, 5000)
    found = regularity(t, np.sin(t), np.cos(t), 2.0 * np.pi)
    assert found.chaos < 0.1 and found.word == "regular"
    assert found.spread < 1e-3 and found.periods == 1
    assert abs(found.lyapunov) < 1e-3
    assert (found.width, found.height) == pytest.approx((2.0, 2.0), abs=1e-3)


def test_two_tones_are_regular_and_do_not_come_back():
    t = np.linspace(0.0, 800.0, 20000)
    y = np.cos(t) + 0.8 * np.cos(0.5 * (1.0 + 5.0**0.5) * t)
    found = regularity(t, y, y, 2.0 * np.pi)
    assert found.chaos < 0.1
    assert found.periods == 0 and found.spread > 0.3


@pytest.mark.parametrize(("amplitude", "periods"), [(0.2, 1), (0.28, 2), (0.29, 4), (0.37, 5)])
def test_duffing_periodic(amplitude, periods):
    found = regularity(*_duffing(amplitude))
    assert found.chaos < 0.2 and found.periods == periods
    assert abs(found.lyapunov) < 1e-3


def test_duffing_chaotic():
    found = regularity(*_duffing(0.5))
    assert found.chaos > 0.9 and found.word == "irregular" and found.periods == 0
    # 0.103 1/s by the equations of variation over 2950 periods
    assert found.lyapunov == pytest.approx(0.103, rel=0.25)


def test_lorenz():
    found = regularity(*_lorenz())
    assert found.chaos > 0.9
    assert found.lyapunov == pytest.approx(1.50, rel=0.15)


def test_logistic_map():
    x = _logistic(20000)
    assert own.chaos(x[:2000]) > 0.95
    # the map is conjugate to the tent map with uniform density, where theta < T theta < T^2 theta
    # and the other rankings hold on intervals of these lengths; falling twice is impossible
    shares = np.array([1 / 3, 4 / 15, 1 / 5, 2 / 15, 1 / 15])
    exact = -(shares @ np.log(shares)) / np.log(6.0)
    assert own.permutation_entropy(x, order=3) == pytest.approx(exact, abs=0.005)


def test_logistic_map_where_it_is_periodic():
    x = [0.3]
    for _ in range(3000):
        x.append(3.55 * x[-1] * (1.0 - x[-1]))
    assert abs(own.chaos(np.array(x[1000:]))) < 0.1


def test_white_noise():
    n = np.random.default_rng(0).standard_normal(5000)
    found = regularity(np.arange(5000.0), np.cumsum(n), n)
    assert found.chaos > 0.95
    assert found.entropy == pytest.approx(1.0, abs=0.01)
    assert own.spectral_flatness(n) == pytest.approx(np.exp(digamma(8)) / 8, abs=0.03)


def test_what_stands_still_is_regular():
    t = np.arange(100.0)
    found = regularity(t, np.ones(100), np.zeros(100), 5.0)
    assert found[:4] == (0.0, 0.0, 0.0, 0.0) and found.height == 0.0
    assert (found.spread, found.periods) == (0.0, 1)


def test_what_a_drive_does_not_explain():
    t = np.arange(20000) * np.pi / 300
    noise = np.random.default_rng(3).standard_normal(20000)
    found = regularity(t, np.sin(t), np.cos(t) + 0.1 * noise, 2.0 * np.pi)
    # white noise of variance 0.01 on one of two coordinates of variance 1/2
    assert found.spread == pytest.approx((0.5 * 0.01 / 0.51) ** 0.5, rel=0.05)
    assert found.chaos > 0.95 and found.periods == 0


def test_a_steady_drift_is_no_spread():
    t = np.linspace(0.0, 100.0, 5000)
    found = regularity(t, 3.0 * t + np.sin(2.0 * t), 3.0 + 2.0 * np.cos(2.0 * t), np.pi)
    assert found.spread < 0.02 and found.periods == 1


def test_too_few_samples_are_unknown():
    t = np.linspace(0.0, 20.0, 400)
    found = regularity(t, np.sin(t), np.cos(t))
    assert np.isnan(found.chaos) and found.word == "unknown"
    with pytest.raises(ValueError, match="too short"):
        regularity(t[:10], t[:10], t[:10])
    with pytest.raises(ValueError, match="400, 399 and 400"):
        regularity(t, t[1:], t)


def test_uneven_times_are_made_even():
    rng = np.random.default_rng(2)
    t = np.sort(rng.uniform(0.0, 500.0, 20000))
    found = regularity(t, np.sin(t), np.cos(t), 2.0 * np.pi)
    assert found.word == "regular" and found.periods == 1


@pytest.mark.benchmark
def test_time():
    t = np.linspace(0.0, 500.0, 5000)
    begun = perf_counter()
    regularity(t, np.sin(t), np.cos(t), 2.0 * np.pi)
    print(f"5000 samples: {perf_counter() - begun:.3f} s")
