"""The main case, its first two seconds: balances, swapped solvers, schemes, gradients."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from coupling import casefile
from coupling.errors import BadCase
from coupling.model import Model, build
from coupling.simulation import Done, windows
from mechanics import march
from meshes.materials import library_material

CASE = Path(__file__).parent.parent / "cases" / "arm_rotation"
END = 2.0


class Run(NamedTuple):
    """A model, its windows, and the way of the tip: (windows + 1, 3) [m]."""

    model: Model
    windows: list[Done]
    tip: np.ndarray

    @property
    def last(self):
        return self.windows[-1].state

    def sections(self, name):
        """Section temperatures at the end."""
        return self.model.sections(self.last)[self.model.layout.point_index[name]]


@cache
def run(*settings):
    model = build(casefile.read(CASE, [f"time.end={END}", *settings]))
    start = model.initial()
    done = list(windows(model, start))
    assert all(isinstance(w, Done) for w in done)
    states = [start, *(w.state for w in done)]
    tip = np.array([model.probes(s)["tip"]["position"] for s in states])
    return Run(model, done, tip)


def assert_same_tip(other, part, every=1):
    """The tips differ by no more than ``part`` of the range of each coordinate in the plane."""
    main = run().tip
    largest = np.ptp(main, axis=0)
    assert np.all(largest[:2] > 1e-5)
    difference = np.abs(other.tip[::every] - main).max(axis=0)
    assert np.all(difference[:2] <= part * largest[:2])
    assert difference[2] < 1e-9 and largest[2] < 1e-9  # the motion is plane


# ------------------------------------------------------------------------------------ balances


def test_the_mechanical_ledger_closes():
    for window in run().windows:
        row = window.state.motion.ledger
        assert abs(row[-1]) <= 1e-6 * np.abs(row).max()


def test_the_heat_balance_closes():
    done = run()
    for window in done.windows:
        row = done.model.ledger(window.state)
        exchanged = sum(abs(v) for v in window.state.flows.values()) + window.state.deposited
        assert exchanged > 1.0
        assert abs(row["heat_defect"]) <= 1e-9 * exchanged


def test_frictional_heat_is_in_the_balance():
    """It is little beside the sunlight, and much beside round-off."""
    state = run().last
    assert abs(run().model.ledger(state)["heat_defect"]) < 0.01 * state.deposited


def test_what_friction_takes_is_the_heat_that_is_released_and_deposited():
    done = run()
    row, state = done.model.ledger(done.last), done.last
    assert row["friction"] > 1e-7
    assert state.released == pytest.approx(row["friction"], rel=1e-9)
    assert state.deposited == state.released and not state.pending.any()
    assert row["heat_exchanged"] == state.deposited


def test_impacts_and_damping_take_energy():
    row = run().model.ledger(run().last)
    assert row["hysteresis"] > 0.0 and row["damping"] > 0.0
    assert row["work_thermal"] > row["kinetic"] > 0.0


def test_the_hinge_is_in_contact_and_the_journal_stays_in_its_bearing():
    done = run()
    motion = done.last.motion.motion
    system = done.model.motion_solver.system
    coef = done.model.motion_solver.coefficients(done.model.sections(done.last))
    v = np.concatenate([motion.v, np.zeros(system.m)])
    response = system.respond(system.unknowns(motion.q), v, coef)[0]
    clearance, depth = response[march.GAP], response[march.DEPTH]
    assert motion.approach[0] != 0.0
    assert depth < 0.05 * clearance
    assert np.hypot(*response[:2]) == pytest.approx(clearance + depth, rel=1e-6)


# --------------------------------------------------------------------------------- temperatures


def test_the_gradient_follows_the_sun():
    """50 K/m after 60 s, linear in time; 50 K from root to tip likewise."""
    arm = run().sections("arm")
    np.testing.assert_allclose(arm[8, 1:], [50.0 * END / 60.0, 0.0], rtol=1e-6, atol=1e-9)
    drop = arm[1, 0] - arm[16, 0]
    assert drop == pytest.approx(50.0 * END / 60.0, rel=1e-6)


def test_friction_warms_journal_and_bearing_by_the_heat_it_releases():
    """Against the same run without friction; in two seconds almost nothing flows on."""
    with_it, without = run(), run("joint.hinge.friction.coefficient=0.0")
    assert without.last.released == 0.0
    gained = 0.0
    for side, mass, name in (("journal", 1.55, "steel-304"), ("bearing", 2.0, "al6061-paper")):
        T = [r.sections(f"hinge.{side}")[0, 0] for r in (without, with_it)]
        assert T[1] > T[0]
        gained += mass * library_material(name).heat_capacity(T[0]) * (T[1] - T[0])
    assert gained == pytest.approx(with_it.last.deposited, rel=0.02)


def test_the_bearing_cools_towards_the_spacecraft():
    initial = run().model.scene.thermal.initial
    assert 293.15 < run().sections("hinge.bearing")[0, 0] < initial


# -------------------------------------------------------------------------- solvers and schemes


def test_another_thermal_solver_leaves_the_motion():
    swapped = run("thermal.solver=lumped")
    assert type(swapped.model.pair.heat_solver) is not type(run().model.pair.heat_solver)
    assert_same_tip(swapped, 0.01)


def test_more_wall_points_leave_the_motion():
    finer = run("thermal.wall_points=8")
    assert len(finer.model.pair.heat_solver.x) > len(run().model.pair.heat_solver.x)
    assert_same_tip(finer, 1e-3)
    np.testing.assert_allclose(finer.sections("arm"), run().sections("arm"), rtol=1e-4, atol=1e-4)


def test_serial_and_corrected_agree():
    serial = run("coupling.scheme=serial")
    assert_same_tip(serial, 1e-3)
    state = serial.last
    assert state.deposited + state.pending.sum() == pytest.approx(state.released, rel=1e-12)
    assert state.pending.sum() > 0.0
    hinge = [r.sections("hinge.journal")[0, 0] for r in (serial, run())]
    assert hinge[0] == pytest.approx(hinge[1], abs=1e-9)


def test_half_the_window_leaves_the_motion():
    assert_same_tip(run("time.window=0.05"), 0.01, every=2)


def test_prescribed_temperatures_must_cover_the_arm():
    with pytest.raises(BadCase, match="the prescribed solver needs a wall along all of it"):
        casefile.read(CASE, ["thermal.solver=prescribed"])


def test_prescribed_temperatures_move_the_arm_as_solved_ones_do():
    """With the wall from the very root on; the links at the hinge then have no effect."""
    whole = run("thermal.solver=prescribed", "thermal.wall.sunlight.start=0.0")
    solved = run("thermal.wall.sunlight.start=0.0")
    difference = np.abs(whole.tip - solved.tip).max(axis=0)
    assert np.all(difference[:2] <= 0.01 * np.ptp(solved.tip, axis=0)[:2])


def test_the_first_seconds_take_few_steps():
    """20 ms where nothing happens, some hundred steps for the first contacts."""
    accepted, refused, corrections, _ = run().last.motion.counts
    assert accepted < 1000
    assert refused < 0.1 * accepted
    assert corrections < 6 * accepted
