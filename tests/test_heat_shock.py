"""Heat shocks: no undershoot where it is promised, and how much elsewhere."""

from math import sqrt

import pytest
from pytest import approx

from coupling.reports import heat_shock
from coupling.reports.heat_shock import CONTROLLED, FOURIER, undershoot
from coupling.verify import shock
from coupling.verify.heat import calculix_is_there


@pytest.mark.parametrize("solve", [shock.no_undershoot, shock.bounded], ids=["none", "bounds"])
def test_promises_hold(solve):
    assert [check.name for check in solve() if not check.passed] == []


@pytest.mark.parametrize("name", shock.LENGTHWISE)
@pytest.mark.parametrize("Fo", [1.0, 100.0, 1e4])
def test_undershoot_is_that_of_the_scheme(name, Fo):
    for scheme in shock.KINDS[name].schemes:
        if scheme != CONTROLLED:
            expected = shock.of_matrices(scheme, Fo, True)
            assert undershoot(name, scheme, Fo) == approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", ["line", "wall, tube"])
def test_controlled_steps_leave_the_range_by_no_more_than_their_tolerance(name):
    for Fo in FOURIER[::3]:
        assert undershoot(name, CONTROLLED, Fo) <= shock.BY_TOLERANCE


def test_short_steps_with_consistent_capacity():
    """What the face stored is missing beside it: 2 - sqrt(3) of the jump, with changing sign."""
    assert shock.of_matrices("backward-euler", 1e-9, False) == approx(100.0 * (2.0 - sqrt(3.0)))
    found = undershoot("solid, consistent", "backward-euler", 1e-5)
    assert found == approx(100.0 * (2.0 - sqrt(3.0)), abs=0.01)


def test_long_steps_of_crank_nicolson_mirror_the_jump():
    assert undershoot("line", "crank-nicolson", 1e7) == approx(100.0, abs=1e-3)


@pytest.mark.slow
@pytest.mark.skipif(not calculix_is_there(), reason="CalculiX is not installed")
def test_calculix_without_the_coupling_to_given_temperatures():
    """At steps of the size of elements nothing falls below."""
    assert undershoot("calculix", "backward-euler", 1.0) <= 1e-3


@pytest.mark.slow
def test_report():
    (result,) = heat_shock.report()
    assert {row[0] for row in result.rows} == set(heat_shock.there())
    assert len(result.pictures) == 5
