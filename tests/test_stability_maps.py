"""Stability maps and the catalogue of extremes: theory is met, what is unstable is called so."""

import numpy as np
import pytest

from coupling.report import publish
from coupling.reports import coupling_extremes, extreme_catalogue, mechanics_extremes
from coupling.reports import stability_clearance as clearance
from coupling.reports import stability_exchange as exchange
from coupling.reports import stability_heating as heating
from coupling.reports import stability_slenderness as slender
from coupling.reports import stability_steps as steps
from coupling.reports.maps import DONE, GROWS, REFUSED, WRONG, Map, Spot, counted, reasons
from coupling.reports.registry import OWN, Result, load
from mechanics.schemes import FORMULATIONS, SCHEMES, Scheme

# ------------------------------------------------------------------------------ steps, stiffness


@pytest.mark.parametrize("name", SCHEMES)
def test_spectral_radius_of_a_run_is_that_of_theory(name):
    scheme = Scheme(name=name)
    for x in (0.1, 1.0, 3.0):
        assert steps.measured(x, scheme) == pytest.approx(steps.radius(x, scheme), abs=1e-6)


def test_radii_at_infinity_are_the_known_ones():
    """(1 + alpha)/(1 - alpha); the parameter itself; 0."""
    assert steps.radius(1e6, Scheme()) == pytest.approx(0.9 / 1.1, abs=1e-5)
    assert steps.radius(1e6, Scheme("generalised-alpha")) == pytest.approx(0.8, abs=1e-4)
    assert steps.radius(1e6, Scheme("bdf2")) < 1e-2
    assert steps.radius(1e6, Scheme("backward-euler")) < 1e-5


@pytest.mark.parametrize("constraints", FORMULATIONS)
@pytest.mark.parametrize("name", SCHEMES)
def test_nothing_grows_however_long_the_steps(name, constraints):
    for h, k in ((1e-5, 1e-4), (1e-3, 1e6), (10.0, 1e14)):
        spot = steps.oscillator(h, k, Scheme(name=name, constraints=constraints))
        assert spot.outcome == DONE
        assert spot.value <= 1e-12


def test_a_scheme_outside_its_bounds_is_said_to_grow(monkeypatch):
    """HHT with a positive alpha: theory has a radius above one, and the run follows it."""
    monkeypatch.setattr(steps, "MOVED", 1e-6)  # far enough from where the spring turns round
    scheme = Scheme(alpha=0.02)
    assert steps.radius(10.0, scheme) > 1.01
    assert steps.measured(10.0, scheme) == pytest.approx(steps.radius(10.0, scheme), rel=1e-4)
    assert steps.oscillator(1.0, 100.0, scheme).outcome == GROWS


def test_a_beam_that_spins_gains_nothing_or_stops_with_a_reason():
    way = steps.WAYS[0]
    assert steps.beam(1e-5, 70e9, way).outcome == DONE
    stopped = steps.beam(0.3, 70e9, way)
    assert stopped.outcome == REFUSED
    assert "Newton did not converge" in stopped.why
    assert steps.beam(0.3, 1e12, steps.WAYS[-1]).outcome == DONE


def test_border_of_the_beam_is_where_the_first_run_stops():
    spots = [Spot(1e-3, 1.0, DONE, 0.0), Spot(1e-2, 1.0, DONE, 0.0), Spot(1e-2, 2.0, REFUSED)]
    assert steps.longest(spots) == pytest.approx(1e-3 * steps.SPIN)


# ------------------------------------------------------------------------------ window, strength


def test_matrices_have_the_borders_that_limits_give():
    """Long windows: T = -S/2 (T + T0) handed on grows from S = 2 on; corrected ones from 1."""
    assert exchange.radius("serial", 50.0, 1.99) < 1.0 < exchange.radius("serial", 50.0, 2.01)
    assert exchange.radius("corrected", 50.0, 0.99) < 1.0 < exchange.radius("corrected", 50.0, 1.01)
    assert exchange.iterates("iterated, none", 50.0, 2.0) == pytest.approx(1.0)
    for scheme in exchange.ADVANCES:  # short windows: none loses what the equation does not
        h, strength = 1e-4, 3.0
        found = exchange.radius(scheme, h, strength)
        assert found == pytest.approx(np.exp(-(1.0 + strength) * h), abs=1e-6)


@pytest.mark.parametrize("scheme", exchange.ADVANCES)
def test_the_exchange_does_what_theory_says(scheme):
    for h in (0.03, 1.0, 30.0):
        for strength in (0.3, 30.0, 3e3):
            spot = exchange.linear_spot(scheme, h, strength)
            assert exchange.agrees(scheme, spot), spot


def test_an_exchange_that_is_too_strong_is_called_so():
    assert exchange.linear_spot("serial", 1.0, 100.0).outcome == GROWS
    refused = exchange.linear_spot("iterated, none", 1.0, 100.0)
    assert refused.outcome == REFUSED
    assert "do not agree" in refused.why
    assert exchange.linear_spot("iterated, quasi-newton", 1.0, 100.0).outcome == DONE


@pytest.mark.parametrize(
    ("scheme", "outcome"),
    [
        ("corrected", GROWS),
        ("iterated, quasi-newton", DONE),
        pytest.param("iterated, none", REFUSED, marks=pytest.mark.slow),
    ],
)
def test_friction_in_the_solvers_has_the_same_borders(scheme, outcome):
    spot = exchange.rubbing_spot(scheme, 3.0, 3.0)
    assert spot.outcome == outcome
    assert exchange.agrees(scheme, spot)


# ---------------------------------------------------------------------------- clearance, stiffness


@pytest.mark.parametrize("name", clearance.MOTIONS)
def test_contacts_gain_nothing_over_decades(name):
    for c, K in ((1e-6, 1e6), (1e-2, 1e12)):
        spot, error, _ = clearance.spot(clearance.MOTIONS[name](c, K), c, K)
        assert spot.outcome == DONE
        assert spot.value <= 1e-9
        assert error <= clearance.RIGHT


def test_a_contact_that_comes_out_wrong_is_called_so():
    case = clearance.MOTIONS["falls and rests, linear"](1e-4, 1e6)
    spot, *_ = clearance.spot(case._replace(expected=2e-4), 1e-4, 1e6)
    assert spot.outcome == WRONG


# ------------------------------------------------------------------------------------ slenderness


@pytest.mark.parametrize("family", slender.ELEMENTS)
@pytest.mark.parametrize("ratio", [5.0, 1e6])
def test_nothing_locks(family, ratio):
    for question in ("bends", "rolls"):
        assert slender.asked(question, family, ratio).value < 5e-3


def test_beams_of_all_slendernesses_vibrate_right():
    assert slender.asked("frequency", "beam3243", 5.0).value < 1e-3
    assert slender.asked("suddenly loaded", "beam3243", 1e4).value < 2e-3


# ------------------------------------------------------------------------------------ rates of heat


@pytest.mark.parametrize("rate", [1e-2, 1e4])
def test_a_hinge_that_closes_by_heat_gains_nothing(rate):
    for gap in (1e-5, 1e-3, 0.0):
        spot = heating.warmed_spot(rate, gap)
        assert spot.outcome == DONE
        assert spot.value < 1e-6


def test_cooled_bars_stay_in_range_and_those_that_do_not_are_called_so():
    assert heating.cooled_spot("line", 1e4, 1e-2).outcome == DONE
    assert heating.cooled_spot("hermite", 1e4, 1e-2).outcome == WRONG


# --------------------------------------------------------------------------------------- catalogue


def test_catalogues_tell_right_from_wrong():
    case = mechanics_extremes.Case("a case", "number", lambda: 1.0, 1.0)
    assert mechanics_extremes.row(case)[1:3] == ("right", "right")
    assert mechanics_extremes.row(case._replace(expected=2.0))[1] == "off by 50 %"
    assert mechanics_extremes.row(case._replace(said="why"))[1:3] == ("silent", "reason")

    def refuses() -> float:
        raise ValueError("that is why\nindeed")

    refused = case._replace(found=refuses)
    assert mechanics_extremes.row(refused)[1:3] == ("no result", "right")
    assert mechanics_extremes.row(refused._replace(said="is why"))[1] == "reason"
    assert mechanics_extremes.row(refused._replace(said="else"))[1] == "other reason"
    crashed = mechanics_extremes.row(case._replace(found=lambda: 1 / 0))
    assert crashed[1] == "crash: ZeroDivisionError"


KNOWN = "stiff spring let go, equal steps of 10000 radians"
"""Backward Euler in steps of 1e4 radians finds the other place where the spring is at rest."""


def test_extremes_of_mechanics():
    (result,) = mechanics_extremes.report()
    bad = [row[0] for row in result.rows if row[1] != row[2]]
    assert bad == [KNOWN]
    assert len(result.rows) > 30


def test_extremes_of_the_exchange():
    (result,) = coupling_extremes.report()
    assert [row for row in result.rows if row[1] != row[2]] == []


def test_the_whole_catalogue_is_one_table(monkeypatch):
    few = {name: extreme_catalogue.AREAS[name] for name in ("coupling",)}
    monkeypatch.setattr(extreme_catalogue, "AREAS", few)
    (result,) = extreme_catalogue.report()
    assert result.notes[0] == f"{len(result.rows)} of {len(result.rows)} correct or stopped with " \
        "the due reason"  # fmt: skip
    assert {row[0] for row in result.rows} == {"coupling"}


def test_rows_of_other_catalogues_are_read():
    contact: dict[str, str | float | int] = {"what": "a", "outcome": "off by 3 %", "error": 0.03}
    assert extreme_catalogue._of_contact(contact)[1:3] == ("off by 3 %", "right")
    heat: dict[str, str | float | int] = {
        "what": "a",
        "solver": "line",
        "outcome": "silent",
        "error": 0.0,
        "reason": "",
    }
    assert extreme_catalogue._of_heat(heat)[:3] == ("a, line", "silent", "reason")
    heat["outcome"] = "correct"
    assert extreme_catalogue._of_heat(heat)[1:3] == ("right", "right")


# ---------------------------------------------------------------------------------------- pictures


def test_a_map_is_drawn(tmp_path):
    from rich.console import Console

    spots = [Spot(1.0, 1.0, DONE, 1e-3), Spot(10.0, 1.0, REFUSED, why="no step of 3 s at node 4"),
             Spot(1.0, 10.0, GROWS), Spot(10.0, 10.0, WRONG)]  # fmt: skip
    assert counted(spots) == {DONE: 1, REFUSED: 1, GROWS: 1, WRONG: 1}
    assert reasons(spots) == ["no step of .. s (1)"]
    result = Result("a", "A", ("n",), [(1,)], [], [Map("m", "x", "y", "v", spots)])
    files = publish(result, tmp_path, Console(quiet=True))
    assert [f.suffix for f in files] == [".csv", ".md", ".png"]


def test_all_reports_can_be_loaded():
    for what in ("stability", "mechanics", "coupling", "extremes"):
        assert all(callable(load(what, name)) for name in OWN[what])


@pytest.mark.slow
@pytest.mark.parametrize("name", OWN["stability"])
def test_whole_maps(name):
    """Every run is done or has its reason; only explicit exchanges grow, only hermite is wrong."""
    for result in load("stability", name)():
        for row in result.rows:
            found = dict(zip(result.columns, row, strict=True))
            explicit = row[0] in ("serial", "parallel", "corrected")
            assert found.get("grows", 0) == 0 or explicit
            assert found.get("wrong", 0) == 0 or row[0] == "hermite"
            assert found.get("against theory", 0) == 0
