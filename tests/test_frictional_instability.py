"""Friction that feeds itself, against the differential equation of two lumps and its threshold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from coupling import casefile
from coupling.manager import initial
from coupling.model import build
from coupling.monolithic import Monolithic
from coupling.simulation import Stopped, windows
from coupling.verify import seizure
from coupling.verify.seizure import AMBIENT, SLOW, course

CASE = Path(__file__).parent.parent / "cases" / "frictional_instability"


def equilibria(model, most):
    """Whether heating of the shaft vanishes somewhere below a rise, the bush being in balance."""

    def left(shaft):
        def bush(rise):
            return model.heating(np.array([shaft, rise]))[1]

        return model.heating(np.array([shaft, brentq(bush, -1.0, 1e4)]))[0]

    return min(left(rise) for rise in np.linspace(1.0, most, 200)) < 0.0


def test_the_formula_parts_speeds_with_an_equilibrium_from_those_without():
    rate = SLOW.critical_speed / SLOW.radius
    most = 3.0 * SLOW.critical_rise[0]
    # the growth of the rubbing radius, 0.2 %, is not in the formula
    assert equilibria(replace(SLOW, rate=0.995 * rate), most)
    assert not equilibria(replace(SLOW, rate=1.005 * rate), most)


@pytest.mark.parametrize(("slope", "expansion"), [(1e-3, (0.0, 0.0)), (0.0, (23.1e-6, 18e-6))])
def test_each_feedback_alone_has_its_own_threshold(slope, expansion):
    model = replace(SLOW, slope=slope, expansion=expansion)
    a, b = model.feedback
    heat = model.friction * model.press * model.critical_speed
    assert_allclose(heat * max(a, b), 1.0, rtol=1e-12)
    assert min(a, b) == 0.0


def case_course(*settings):
    """Times and rises (k, 2) of the shipped case, or as far as it comes."""
    model = build(casefile.read(CASE, settings))
    rows = [(0.0, 0.0, 0.0)]
    for window in windows(model, model.initial()):
        if isinstance(window, Stopped):
            break
        rows.append((window.t, *(window.state.T - AMBIENT)))
    table = np.array(rows)[1:]
    return table[:, 0], table[:, 1:]


def test_the_shipped_case_is_that_of_the_formula_and_iterates_in_long_windows():
    t, rises = case_course("time.end='240 s'", "time.window='20 s'")
    assert len(t) == 12  # none was halved
    # after the bush has settled; that windows of 20 s do not resolve
    assert_allclose(rises[6:], SLOW.course(t)[6:], atol=0.15)


def test_serial_and_corrected_exchange_do_not_hold_in_those_windows():
    exact = SLOW.course(20.0 * np.arange(1.0, 16.0))
    off = {
        scheme: np.abs(course(SLOW.pair(), scheme, 300.0, 15) - exact)[-5:].max()
        for scheme in ("serial", "corrected", "iterated")
    }
    assert off["serial"] > 4.0 and off["corrected"] > 20.0
    assert off["iterated"] < 0.2


@pytest.mark.slow
def test_above_the_threshold_the_shaft_warms_the_faster_the_warmer_it_is():
    fast = replace(SLOW, rate=2.5, masses=(0.015, 0.001))
    run = course(fast.pair(), "iterated", 160.0, 320)
    assert_allclose(run[-1], fast.course(np.array([160.0]))[-1], rtol=0.01)
    pace = np.diff(run[:, 0])
    assert pace[-1] > 1.5 * pace[40]


def test_the_monolithic_solution_agrees():
    pair = SLOW.pair()
    solver = Monolithic(pair)
    end = solver.run(solver.begin(initial(pair, settle=True)), 0.05, 40)
    assert_allclose(end.T - AMBIENT, SLOW.course(np.array([2.0]))[-1], atol=2e-3)


@pytest.mark.slow
def test_the_threshold_found_by_runs():
    (check,) = seizure.threshold()
    assert check.passed, check


@pytest.mark.slow
def test_orders_of_the_schemes():
    assert all(row.passed for row in seizure.courses())


def test_the_case_is_drawn_from_the_same_numbers():
    scene = casefile.read(CASE)
    joint, thermal = scene.joint["bore"], scene.thermal
    assert (joint.radius, joint.clearance) == (SLOW.radius, SLOW.clearance)
    assert joint.friction.coefficient == SLOW.friction
    assert joint.friction.temperature_slope == SLOW.slope
    assert tuple(p.mass for p in thermal.part.values()) == pytest.approx(SLOW.masses)
    assert tuple(x.conductance for x in thermal.link.values()) == SLOW.conductances
