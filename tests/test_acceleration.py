"""The iterated exchange on linear equations whose rates of convergence are known."""

import numpy as np
import pytest
from coupled_pairs import linear_pair, solution

from coupling.acceleration import Aitken, Columns, QuasiNewton, Relaxed, filtered
from coupling.iteration import Iterated
from coupling.manager import corrected, initial

TIGHT = {"temperature_tolerance": 1e-10, "heat_tolerance": 1e-10}


def residuals(acceleration, G, b, count):
    """Sizes of the residuals of x = G x + b, from x = 0."""
    x, sizes = np.zeros(len(b)), []
    for _ in range(count):
        found = G @ x + b
        sizes.append(float(np.linalg.norm(found - x)))
        x = acceleration.next(x, found)
    return np.array(sizes)


def mixing(eigenvalues, seed=1):
    """A matrix with these eigenvalues and other than unit vectors."""
    n = len(eigenvalues)
    basis = np.eye(n) + 0.3 * np.random.default_rng(seed).standard_normal((n, n))
    return basis @ np.diag(eigenvalues) @ np.linalg.inv(basis)


# ------------------------------------------------------------------------------ rates of iterations


@pytest.mark.parametrize("radius", [0.2, 0.5, 0.9])
def test_plain_iteration_converges_with_the_spectral_radius(radius):
    found = residuals(Relaxed(1.0), mixing([radius, -0.1 * radius, 0.05]), np.ones(3), 15)
    assert found[-1] / found[-2] == pytest.approx(radius, rel=1e-3)


@pytest.mark.parametrize(("gain", "factor"), [(-3.0, 0.3), (-3.0, 0.45), (0.8, 0.5), (-0.5, 0.5)])
def test_relaxation_converges_with_one_minus_factor_times_one_minus_gain(gain, factor):
    found = residuals(Relaxed(factor), np.array([[gain]]), np.ones(1), 8)
    theory = abs(1.0 - factor * (1.0 - gain))
    np.testing.assert_allclose(found[1:] / found[:-1], theory, rtol=1e-6)


@pytest.mark.parametrize("gain", [-1.5, -20.0, 1.5, 20.0])
def test_gains_beyond_one_need_acceleration(gain):
    G, b = np.array([[gain]]), np.ones(1)
    assert residuals(Relaxed(1.0), G, b, 10)[-1] > 10.0
    for kind in (Aitken, QuasiNewton):
        found = residuals(kind(1.0), G, b, 3)
        assert found[-1] < 1e-10, "a secant ends a linear equation of one unknown at once"


@pytest.mark.parametrize("n", [2, 3, 5])
def test_quasi_newton_ends_a_linear_equation_after_one_iteration_per_unknown_and_two(n):
    G = mixing(np.linspace(-8.0, 5.5, n))
    found = residuals(QuasiNewton(0.1), G, np.ones(n), n + 3)
    assert found[n + 1] < 1e-8 * found[0]


def test_accelerations_rank_as_expected():
    G, b = mixing([-0.95, -0.6, 0.7, 0.3]), np.ones(4)
    counts = {}
    for name, kind in (("plain", Relaxed), ("aitken", Aitken), ("quasi-newton", QuasiNewton)):
        counts[name] = int(np.argmax(residuals(kind(1.0), G, b, 2000) < 1e-8))
    assert 0 < counts["quasi-newton"] < counts["aitken"] < counts["plain"]


def test_a_solution_that_is_met_stays():
    for kind in (Relaxed, Aitken, QuasiNewton):
        made, x = kind(1.0), np.array([2.0, 3.0])
        for _ in range(4):
            x = made.next(x, x.copy())
        assert np.array_equal(x, [2.0, 3.0])


# -------------------------------------------------------------------------------------- columns


def test_changes_that_newer_ones_make_already_are_left_out():
    one, two = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    rows = np.array([one, two, 3.0 * one + 2.0 * two, np.zeros(3), one + 1e-10 * two])
    kept = filtered(Columns(rows, rows, np.arange(5), 0.1))
    assert kept.ages.tolist() == [0, 1]


def test_no_more_changes_than_unknowns_are_kept():
    rows = np.random.default_rng(2).standard_normal((7, 3))
    assert len(filtered(Columns(rows, rows, np.arange(7), 0.1)).ages) == 3


def test_changes_age_and_are_forgotten_with_the_length_of_the_window():
    seen = Columns.none(2)._replace(length=0.1).with_newest(np.ones(2), np.ones(2))
    assert seen.for_window(0.1, 2, 2).ages.tolist() == [1]
    assert seen.for_window(0.1, 0, 2).ages.size == 0
    assert seen.for_window(0.05, 2, 2).ages.size == 0
    assert seen.for_window(0.1, 2, 3).residuals.shape == (0, 3)


# --------------------------------------------------------------------------------------- windows


@pytest.mark.parametrize("acceleration", ["aitken", "quasi-newton"])
@pytest.mark.parametrize("radius", [0.5, 4.0])
def test_a_window_ends_at_the_implicit_solution(acceleration, radius):
    solvers = linear_pair(mixing([-radius, -0.3 * radius, -0.1]))
    scheme = Iterated(**TIGHT, acceleration=acceleration, most=200)
    new, why = scheme(solvers, initial(solvers), 0.0, 0.5, None)
    assert why == ""
    np.testing.assert_allclose(new.T, solution(solvers, 0.5), rtol=1e-10)
    assert new.exchange.iterations == new.exchange.total == solvers.motion_solver.calls > 1


def test_without_acceleration_strong_coupling_is_refused_with_a_reason():
    solvers = linear_pair(mixing([-1.5, 0.2]))
    new, why = Iterated(acceleration="none", most=20)(solvers, initial(solvers), 0.0, 0.5, None)
    assert new is None
    assert "do not agree after 20 iterations" in why and "temperature_tolerance" in why


def test_iterations_that_leave_all_numbers_are_refused():
    solvers = linear_pair(np.array([[-1e200]]))
    scheme = Iterated(acceleration="none", most=20)
    with np.errstate(all="ignore"):
        new, why = scheme(solvers, initial(solvers), 0.0, 0.5, None)
    assert new is None and "do not agree" in why


@pytest.mark.parametrize("factor", [0.3, 0.45])
def test_relaxation_holds_what_plain_iteration_loses(factor):
    solvers = linear_pair(np.array([[-3.0]]))
    scheme = Iterated(**TIGHT, acceleration="relaxation", factor=factor, most=200)
    new, why = scheme(solvers, initial(solvers), 0.0, 0.5, None)
    assert why == ""
    np.testing.assert_allclose(new.T, solution(solvers, 0.5), rtol=1e-10)


def test_one_pass_is_the_corrected_scheme():
    """Tolerances that anything meets leave heat, motion, heat."""
    solvers = linear_pair(mixing([0.2, 0.1]))
    start, _ = corrected(solvers, initial(solvers), 0.0, 0.1, None)
    loose = Iterated(temperature_tolerance=1e9, heat_tolerance=1e9)
    once, _ = loose(solvers, start, 0.1, 0.1, None)
    other, _ = corrected(solvers, start, 0.1, 0.1, None)
    assert once.exchange.iterations == 1
    assert np.array_equal(once.T, other.T) and once.deposited == other.deposited


def test_both_fields_are_tested():
    """Heat that motion reads nothing of: temperatures given and found agree, heat does not yet."""
    solvers = linear_pair(mixing([-0.5, 0.4]))
    loose, tight = (
        Iterated(temperature_tolerance=1e9, heat_tolerance=tolerance, acceleration="none")
        for tolerance in (1e-2, 1e-8)
    )
    first, second = (s(solvers, initial(solvers), 0.0, 0.1, None)[0] for s in (loose, tight))
    assert second.exchange.iterations > first.exchange.iterations > 1


def test_only_the_last_iteration_is_observed():
    solvers, seen = linear_pair(mixing([-3.0, 0.2])), []
    new, _ = Iterated(**TIGHT)(solvers, initial(solvers), 0.0, 0.5, seen.append)
    assert new.exchange.iterations > 2
    assert seen == [("pass", new.exchange.iterations)]


def test_windows_that_remember_need_fewer_iterations():
    counts = {}
    for reused in (0, 2):
        solvers = linear_pair(mixing([-6.0, 3.0, -0.4, 0.2]))
        state, scheme = initial(solvers), Iterated(**TIGHT, reused=reused)
        for k in range(3):
            state, why = scheme(solvers, state, 0.1 * k, 0.1, None)
            assert why == ""
        counts[reused] = state.exchange.iterations
    assert counts[2] < counts[0]


def test_the_state_of_before_does_not_change():
    solvers = linear_pair(mixing([-6.0, 3.0, -0.4]))
    state, _ = Iterated(**TIGHT)(solvers, initial(solvers), 0.0, 0.1, None)
    kept = state.T.copy(), state.exchange.columns.residuals.copy()
    first, _ = Iterated(**TIGHT)(solvers, state, 0.1, 0.1, None)
    again, _ = Iterated(**TIGHT)(solvers, state, 0.1, 0.1, None)
    assert np.array_equal(state.T, kept[0])
    assert np.array_equal(state.exchange.columns.residuals, kept[1])
    assert np.array_equal(first.T, again.T)
