"""Reports of contact: their numbers against closed forms, with few sizes."""

import numpy as np
import pytest
from rich.console import Console

from coupling.report import report
from coupling.reports import extremes, impacts, ring_clearance
from coupling.reports.travel import travel
from coupling.rings import Play, ring_description
from coupling.verify.contact import CLEARANCE, X, ball, joint
from coupling.verify.models import model
from mechanics.contact import elastic_impact
from mechanics.description import Force, Friction, NormalContact, Site
from mechanics.dynamics import Control
from mechanics.system import System
from meshes.materials import library_material
from meshes.sections import tube
from meshes.truss import ring_truss


@pytest.fixture(scope="module")
def table():
    (result,) = extremes.report()
    return {row[0]: dict(zip(result.columns, row, strict=True)) for row in result.rows}


@pytest.mark.slow
def test_extremes_of_single_impacts_are_right(table):
    for what, row in table.items():
        if row["quantity"] == "restitution":
            assert row["outcome"] == "right", what
            assert row["steps"] < 2000


@pytest.mark.slow
def test_no_extreme_stops_the_solver(table):
    assert len(table) > 60
    for what, row in table.items():
        assert np.isfinite(row["delivered"]), (what, row["outcome"])
        assert row["energy gained [-]"] < 5e-3, what


def test_a_case_that_stops_says_why():
    case = extremes.flight("pulled endlessly")
    pull = Force("pull", Site("ball"), X, lambda t: np.inf if t > 4e-4 else 0.0)
    contact = NormalContact(value=1e10)
    made = model([ball(0.01, 0.1 * X)], [joint(contact, CLEARANCE)], [pull])
    row = extremes._row(case._replace(made=made, largest=1e-4))
    assert "not finite" in row[1]
    assert "at t = 0.0004" in row[1]
    assert np.isnan(row[3])


def test_a_wrong_expectation_is_called_wrong():
    case = extremes.flight("wrong")
    assert extremes._row(case)[1] == "right"
    assert extremes._row(case._replace(expected=0.8))[1].startswith("off by 5")


def test_ways_of_slowing_down():
    """Coulomb: w^2/2 sqrt(1 + mu^2)/mu; with a regularisation (w^2/2 + eps w/r)/mu more, for small
    mu.
    """
    half = 0.5 * extremes.SPIN**2
    exact = half * np.sqrt(1.04) / 0.2
    assert extremes._slowing(extremes.Law(Friction(0.2))) == pytest.approx(exact, rel=1e-9)
    loose = extremes._slowing(extremes.Law(Friction(1e-3), 0.01))
    more = half + 0.01 / extremes.PIN * extremes.SPIN
    assert loose == pytest.approx(more / 1e-3, rel=1e-6)


def test_travel_counts_energy_and_impacts():
    contact = NormalContact("linear", 1e6, restitution=1.0)
    made = model(ball(0.01, 0.1 * X), [joint(contact, CLEARANCE)])
    duration = float(elastic_impact(0.01, 1e6, 0.1, 1.0).duration)
    path = travel(made, 1e-3 + 1.5 * duration, Control(1e-6, 1e-4, 1e-18))
    assert path.onsets() == pytest.approx([1e-3], rel=2e-6)
    assert len(path.t) == path.steps + 1
    kinetic = 0.5 * 0.01 * np.sum(path.v**2, axis=1)
    most = max(kinetic[0], kinetic[-1])
    assert path.gained == pytest.approx(max(0.0, kinetic[-1] - kinetic[0]) / most, abs=3e-4)
    assert path.made == pytest.approx((kinetic[-1] - kinetic[0]) / most, abs=1e-4)


def test_largest_step_is_not_what_errors_of_a_sequence_hang_on():
    exact = impacts.ballistic(20)
    for largest in (1e-3, 1e-4):
        times = impacts.sequence(largest, 1e-8).onsets()
        np.testing.assert_allclose(times[:20], exact, rtol=2e-4)


def test_restitution_converges_with_steps_per_impact():
    coarse, fine = (impacts._worst("linear", 0.85, tolerance) for tolerance in (1e-6, 1e-8))
    assert impacts.steps_per_impact(1e-8) == pytest.approx(10 * impacts.steps_per_impact(1e-6))
    assert fine[0] < coarse[0] / 20.0
    assert coarse[0] < 3e-3


def test_the_ring_report_counts_what_happens(monkeypatch, tmp_path):
    def small():
        play = Play(0.01, 1e-6, NormalContact(), Friction(0.1))
        truss = ring_truss(4, 10.0, 2.0, 2, 0.2)
        metal = library_material("al6061-paper")
        section = tube(0.02, 0.001)
        return System(ring_description(truss, section, metal, 1e-3, 473.15, clearance=play))

    monkeypatch.setattr(ring_clearance, "ring", small)
    monkeypatch.setattr(ring_clearance, "FAR", "batten_2")
    monkeypatch.setattr(ring_clearance, "SHORT", 0.02)
    monkeypatch.setattr(ring_clearance, "WINDOW", 0.01)
    files = report("ring_truss", "clearance", tmp_path, Console(quiet=True))
    assert {f.name for f in files} >= {"clearance.csv", "clearance.png", "clearance_error.md"}
    system = small()
    run = list(ring_clearance.motion(system, ring_clearance.control(3e-5), 0.02))
    assert len(run) == 2
    for stretch in run:
        assert len(stretch.t) == stretch.counts[0] == len(stretch.contacts)
        assert stretch.sizes.sum() == pytest.approx(0.01)
        assert stretch.contacts.max() <= 16
    assert sum(len(s.onsets) for s in run) > 0
