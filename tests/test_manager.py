"""Coupling schemes on two small equations: order, roll back, account of the heat."""

import numpy as np
import pytest
from coupled_pairs import CAPACITY, OUTSIDE, START, Cup, Slider, exact, pair, run
from scipy.sparse import csr_array

from coupling.iteration import Iterated
from coupling.manager import Pair, corrected, initial, isothermal, parallel, serial
from coupling.transfer import Transfer

ITERATED = Iterated(temperature_tolerance=1e-8, heat_tolerance=1e-8)
SECOND = [corrected, ITERATED]
FIRST = [serial, parallel]
COUPLED = [*FIRST, *SECOND]


@pytest.fixture(scope="module", name="exact")
def exact_end():
    """Speed and temperature at the end, both equations solved together."""
    return exact()


# ------------------------------------------------------------------------------------- order


@pytest.mark.parametrize(
    ("scheme", "order"), [*((s, 1.0) for s in FIRST), *((s, 2.0) for s in SECOND)]
)
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


@pytest.mark.parametrize("acceleration", ["none", "relaxation", "aitken", "quasi-newton"])
def test_what_is_iterated_to_does_not_depend_on_the_acceleration(acceleration):
    factor = 0.7 if acceleration == "relaxation" else 1.0
    scheme = Iterated(1e-9, 1e-9, acceleration=acceleration, factor=factor)
    found, other = run(scheme, 8), run(ITERATED, 8)
    np.testing.assert_allclose(found.T, other.T, rtol=1e-9)
    assert found.motion.v == pytest.approx(other.motion.v, rel=1e-7)


def test_neither_side_of_parallel_waits_for_the_other():
    """Heat and motion are given the same whatever the other side has just done."""
    start, _ = parallel(pair(), initial(pair()), 0.0, 0.1, None)

    class Hotter(Cup):
        def advance(self, T, t, h, heat, outside=None):
            T, flows, why = super().advance(T, t, h, heat, outside)
            return T + 5.0, flows, why

    one, _ = parallel(pair(), start, 0.1, 0.1, None)
    two, _ = parallel(pair()._replace(heat_solver=Hotter()), start, 0.1, 0.1, None)
    assert one.motion == two.motion and two.T[0] == one.T[0] + 5.0


# --------------------------------------------------------------------- the error of a prediction


@pytest.mark.parametrize("scheme", COUPLED)
def test_the_window_error_is_of_second_order(scheme):
    sizes = []
    for windows in (32, 64, 128):
        sizes.append(run(scheme, windows).window_error)
    assert np.log2(sizes[1] / sizes[2]) == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize("scheme", SECOND)
def test_the_sum_of_window_errors_bounds_the_error_of_the_end(scheme, exact):
    """What the prediction misses is more than what is left once it has been corrected."""
    solvers, state, total = pair(), initial(pair()), 0.0
    for k in range(32):
        state, _ = scheme(solvers, state, k / 16.0, 1.0 / 16.0, None)
        total += state.window_error
    assert abs(state.T[0] - exact[1]) < total < 1.0


def test_iterations_are_counted_window_by_window_and_in_all():
    solvers, state, total = pair(), initial(pair()), 0
    for k in range(4):
        state, _ = ITERATED(solvers, state, 0.1 * k, 0.1, None)
        total += state.exchange.iterations
    assert state.exchange.total == total > 4
    assert run(corrected, 4).exchange.total == 4


# -------------------------------------------------------------------------- account of the heat


@pytest.mark.parametrize("scheme", COUPLED)
def test_released_heat_is_deposited_or_pending(scheme):
    state = run(scheme, 16)
    assert state.released == pytest.approx(state.motion.lost, rel=1e-13)
    assert state.released > 1.0
    assert state.deposited + state.pending.sum() == pytest.approx(state.released, rel=1e-13)


@pytest.mark.parametrize("scheme", FIRST)
def test_explicit_schemes_deposit_the_heat_of_the_window_before(scheme):
    solvers, state = pair(), initial(pair())
    first, _ = scheme(solvers, state, 0.0, 0.1, None)
    assert first.deposited == 0.0 and first.pending.sum() == first.released > 0.0
    second, _ = scheme(solvers, first, 0.1, 0.1, None)
    assert second.deposited == first.released
    late = abs(second.released - 2.0 * first.released)
    assert second.exchange.heat_error == pytest.approx(late, rel=1e-12)


@pytest.mark.parametrize("scheme", SECOND)
def test_the_others_deposit_the_heat_where_it_arose(scheme):
    state = run(scheme, 16)
    assert state.deposited == state.released and not state.pending.any()


@pytest.mark.parametrize("scheme", COUPLED)
def test_stored_heat_is_what_was_deposited_and_what_came_through_boundaries(scheme):
    state = run(scheme, 16)
    stored = CAPACITY * (state.T[0] - START)
    assert abs(state.flows["air"]) > 0.1
    assert stored == pytest.approx(state.deposited + state.flows["air"], rel=1e-12)


@pytest.mark.parametrize("scheme", COUPLED)
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

    def energy(self, T):
        return self.solver.energy(T)

    def advance(self, *given):
        self.calls -= 1
        *result, why = self.solver.advance(*given)
        return (*result, why) if self.calls > 0 else (*result, "no more")


@pytest.mark.parametrize(
    ("scheme", "heat_calls", "motion_calls", "reason"),
    [
        (serial, 1, 9, "heat: no more"),
        (serial, 9, 1, "motion: no more"),
        (parallel, 1, 9, "heat: no more"),
        (parallel, 9, 1, "motion: no more"),
        (ITERATED, 2, 9, "heat: no more"),
        (ITERATED, 9, 2, "motion: no more"),
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


@pytest.mark.parametrize("scheme", COUPLED)
def test_after_a_refusal_a_shorter_window_gives_what_it_would_have_given_at_once(scheme):
    solvers = pair()
    start, _ = scheme(solvers, initial(solvers), 0.0, 0.1, None)
    at_once, _ = scheme(solvers, start, 0.1, 0.05, None)
    refusing = solvers._replace(motion_solver=Refusing(Slider(), 1))
    assert scheme(refusing, start, 0.1, 0.1, None)[0] is None
    again, _ = scheme(solvers, start, 0.1, 0.05, None)
    assert again.motion == at_once.motion and np.array_equal(again.T, at_once.T)


@pytest.mark.parametrize("scheme", [serial, parallel, corrected, isothermal])
def test_the_observer_reaches_the_motion(scheme):
    class Watched(Slider):
        def advance(self, state, h, T0, T1, observe=None):
            observe("seen")
            return super().advance(state, h, T0, T1)

    seen = []
    solvers = pair()._replace(motion_solver=Watched())
    scheme(solvers, initial(solvers), 0.0, 0.1, seen.append)
    assert seen == ["seen"]
