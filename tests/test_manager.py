"""Coupling schemes on two small equations: order, roll back, account of the heat."""

from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.sparse import csr_array

from coupling.manager import Pair, corrected, initial, isothermal, serial
from coupling.transfer import Transfer

CAPACITY, LOSS, OUTSIDE, START = 2.0, 0.6, 10.0, 10.5
END = 2.0


def resistance(T):
    """Drag [N s/m] that falls with temperature."""
    return 3.0 * np.exp(-0.3 * (T - OUTSIDE))


def push(t):
    return 4.0 + 3.0 * np.sin(2.0 * t)


class Cup:
    """C T' = loss (outside - T) + heat/h, solved exactly."""

    x = np.zeros((1, 3))
    regions = MappingProxyType({"slider": np.array([0])})

    def initial(self):
        return np.array([START])

    def energy(self, T):
        return CAPACITY * float(T[0])

    def advance(self, T, t, h, heat, outside=None):
        settled = OUTSIDE + heat / h / LOSS
        end = settled + (T - settled) * np.exp(-LOSS / CAPACITY * h)
        return end, {"air": CAPACITY * float((end - T)[0]) - float(heat[0])}, ""


class Sliding(NamedTuple):
    t: float
    v: float
    lost: float


class Slider:
    """v' = push - r(T) v with T linear over the window; r v^2 becomes heat."""

    x = np.zeros((1, 3))
    axes = np.zeros((1, 3, 3))
    regions = MappingProxyType({"slider": np.array([0])})

    def initial(self, T):
        return Sliding(0.0, 1.0, 0.0)

    def advance(self, state, h, T0, T1, observe=None):
        def rates(t, y):
            s = (t - state.t) / h
            r = resistance((1.0 - s) * T0[0, 0] + s * T1[0, 0])
            return [push(t) - r * y[0], r * y[0] ** 2]

        end = solve_ivp(rates, (state.t, state.t + h), [state.v, 0.0], rtol=1e-11, atol=1e-13)
        v, lost = end.y[:, -1]
        return Sliding(state.t + h, v, state.lost + lost), np.array([lost]), ""


def pair():
    read = csr_array(np.array([[1.0], [0.0], [0.0]]))
    return Pair(Cup(), Slider(), Transfer(read, np.zeros((1, 3))))


def run(scheme, windows, solvers=None):
    solvers = solvers or pair()
    state, h = initial(solvers), END / windows
    for k in range(windows):
        new, why = scheme(solvers, state, k * h, h, None)
        assert why == ""
        state = new
    return state


@pytest.fixture(scope="module")
def exact():
    """Speed and temperature at the end, both equations solved together."""

    def rates(t, y):
        r = resistance(y[1])
        return [push(t) - r * y[0], (LOSS * (OUTSIDE - y[1]) + r * y[0] ** 2) / CAPACITY]

    return solve_ivp(rates, (0.0, END), [1.0, START], rtol=1e-12, atol=1e-12).y[:, -1]


# ------------------------------------------------------------------------------------- order


@pytest.mark.parametrize(("scheme", "order"), [(serial, 1.0), (corrected, 2.0)])
def test_order_in_the_window(scheme, order, exact):
    errors = []
    for windows in (16, 32, 64):
        state = run(scheme, windows)
        errors.append(np.abs(np.array([state.motion.v, state.T[0]]) - exact))
    errors = np.array(errors)
    observed = np.log2(errors[:-1] / errors[1:])
    assert np.all(errors[-1] > 1e-9), "the coupling error must stand out"
    np.testing.assert_allclose(observed[-1], order, atol=0.15)


def test_the_exchange_matters(exact):
    """Without heat the speed is another: the orders above measure the coupling."""
    alone = run(isothermal, 32)
    assert abs(alone.motion.v - exact[0]) > 0.05
    assert alone.T[0] == START


# -------------------------------------------------------------------------- account of the heat


@pytest.mark.parametrize("scheme", [serial, corrected])
def test_released_heat_is_deposited_or_pending(scheme):
    state = run(scheme, 16)
    assert state.released == pytest.approx(state.motion.lost, rel=1e-13)
    assert state.released > 1.0
    assert state.deposited + state.pending.sum() == pytest.approx(state.released, rel=1e-13)


def test_serial_deposits_the_heat_of_the_window_before():
    solvers, state = pair(), initial(pair())
    first, _ = serial(solvers, state, 0.0, 0.1, None)
    assert first.deposited == 0.0 and first.pending.sum() == first.released > 0.0
    second, _ = serial(solvers, first, 0.1, 0.1, None)
    assert second.deposited == first.released


def test_corrected_deposits_the_heat_where_it_arose():
    state = run(corrected, 16)
    assert state.deposited == state.released and not state.pending.any()


@pytest.mark.parametrize("scheme", [serial, corrected])
def test_stored_heat_is_what_was_deposited_and_what_came_through_boundaries(scheme):
    state = run(scheme, 16)
    stored = CAPACITY * (state.T[0] - START)
    assert abs(state.flows["air"]) > 0.1
    assert stored == pytest.approx(state.deposited + state.flows["air"], rel=1e-12)


@pytest.mark.parametrize("scheme", [serial, corrected])
def test_heat_waits_where_windows_have_different_lengths(scheme):
    solvers = pair()
    state, t = initial(solvers), 0.0
    for h in (0.1, 0.025, 0.05, 0.2):
        state, _ = scheme(solvers, state, t, h, None)
        t += h
    assert state.deposited + state.pending.sum() == pytest.approx(state.motion.lost, rel=1e-13)
    stored = CAPACITY * (state.T[0] - START)
    assert stored == pytest.approx(state.deposited + state.flows["air"], rel=1e-12)


def test_isothermal_counts_released_heat_and_deposits_none():
    state = run(isothermal, 8)
    assert state.released == pytest.approx(state.motion.lost, rel=1e-13)
    assert state.deposited == 0.0 and state.flows == {}


def test_a_scene_without_heat_has_no_temperatures():
    at_rest = Transfer(csr_array((3, 0)), np.array([[OUTSIDE, 0.0, 0.0]]))
    solvers = Pair(None, Slider(), at_rest)
    state, why = isothermal(solvers, initial(solvers), 0.0, 0.1, None)
    assert why == "" and state.T.shape == (0,)
    assert state.released > 0.0


# ----------------------------------------------------------------------------------- failures


class Refusing:
    """A solver that refuses from its n-th call on, after spoiling what it returns."""

    def __init__(self, solver, calls):
        self.solver, self.calls = solver, calls
        self.x, self.regions = solver.x, solver.regions
        self.axes = getattr(solver, "axes", None)

    def initial(self, *given):
        return self.solver.initial(*given)

    def advance(self, *given):
        self.calls -= 1
        *result, why = self.solver.advance(*given)
        return (*result, why) if self.calls > 0 else (*result, "no more")


@pytest.mark.parametrize(
    ("scheme", "heat_calls", "motion_calls", "reason"),
    [
        (serial, 1, 9, "heat: no more"),
        (serial, 9, 1, "motion: no more"),
        (corrected, 1, 9, "heat: no more"),
        (corrected, 2, 9, "heat: no more"),
        (corrected, 9, 1, "motion: no more"),
    ],
)
def test_a_refusal_gives_the_reason_and_leaves_the_state(scheme, heat_calls, motion_calls, reason):
    good = pair()
    state, _ = scheme(good, initial(good), 0.0, 0.1, None)
    before = state.T.copy(), state.motion, state.pending.copy(), dict(state.flows)
    refusing = good._replace(
        heat_solver=Refusing(Cup(), heat_calls), motion_solver=Refusing(Slider(), motion_calls)
    )
    new, why = scheme(refusing, state, 0.1, 0.1, None)
    assert new is None and why == reason
    assert np.array_equal(state.T, before[0]) and np.array_equal(state.pending, before[2])
    assert state.motion == before[1] and state.flows == before[3]


def test_an_isothermal_refusal_gives_the_reason():
    refusing = pair()._replace(motion_solver=Refusing(Slider(), 1))
    new, why = isothermal(refusing, initial(refusing), 0.0, 0.1, None)
    assert new is None and why == "no more"


@pytest.mark.parametrize("scheme", [serial, corrected])
def test_after_a_refusal_a_shorter_window_gives_what_it_would_have_given_at_once(scheme):
    solvers = pair()
    start, _ = scheme(solvers, initial(solvers), 0.0, 0.1, None)
    at_once, _ = scheme(solvers, start, 0.1, 0.05, None)
    refusing = solvers._replace(motion_solver=Refusing(Slider(), 1))
    assert scheme(refusing, start, 0.1, 0.1, None)[0] is None
    again, _ = scheme(solvers, start, 0.1, 0.05, None)
    assert again.motion == at_once.motion and np.array_equal(again.T, at_once.T)


@pytest.mark.parametrize("scheme", [serial, corrected, isothermal])
def test_the_observer_reaches_the_motion(scheme):
    class Watched(Slider):
        def advance(self, state, h, T0, T1, observe=None):
            observe("seen")
            return super().advance(state, h, T0, T1)

    seen = []
    solvers = pair()._replace(motion_solver=Watched())
    scheme(solvers, initial(solvers), 0.0, 0.1, seen.append)
    assert seen == ["seen"]
