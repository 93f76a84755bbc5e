"""The error that a run says of itself, against its distance from a much finer run."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from coupling import error_estimate
from coupling.casefile import from_text
from coupling.cli import app
from coupling.error_estimate import Estimate
from coupling.model import build
from coupling.results import Results
from coupling.simulation import windows

LENGTH, RATE, HALF, END = 2.0, 2.0, 0.1, 5.0  # [m], [rad/s], amplitude [m], [s]
SPRING = """
[time]
end = 5.0
window = 0.5
[integrator]
alpha = 0.0
[body.ball]
kind = "particle"
position = [1.0, 0.0, 0.0]
mass = 2.0
[joint.wire]
kind = "spring"
a = { body = "ball" }
b = { body = "ground", position = [0.0, 0.0, 0.0] }
stiffness = 8.0
length = 0.9
[probe.ball]
body = "ball"
"""
BOOM = """
[time]
end = 20.0
window = 1.0
[section.tube]
kind = "tube"
mean_radius = 0.1
thickness = 0.002
[body.boom]
kind = "beam"
start = [0.0, 0.0, 0.0]
end = [20.0, 0.0, 0.0]
elements = 6
normal = [0.0, 1.0, 0.0]
section = "tube"
material = "al6061"
damping = 0.01
[joint.root]
kind = "clamp"
a = { body = "boom", at = "start" }
[thermal]
solver = "line"
initial = "25 degC"
wall_points = 8
[thermal.flux.sun]
body = "boom"
density = 1361.0
absorptivity = 0.3
direction = [0.0, -1.0, 0.0]
[thermal.radiation.space]
body = "boom"
emissivity = 0.8
sink = 3.0
[probe.tip]
body = "boom"
at = "end"
"""


def ran(text, *changes):
    """States at the ends of the windows, the model, and what the windows add to the estimate."""
    from coupling.overrides import parse

    model = build(from_text(text, Path("."), parse(changes)))
    states, rows = [model.initial()], []
    for window in windows(model, states[0]):
        rows.append(error_estimate.of_window(model, states[-1], window.state))
        rows[-1] |= {"wall_time": 1.0 + len(rows), "window_error": window.window_error}
        states.append(window.state)
    return model, states, {name: np.array([row[name] for row in rows]) for name in rows[0]}


def apart(states, finer, scale):
    """Largest distance of coordinates at the times of the states, relative to their sizes."""
    stride = (len(finer) - 1) // (len(states) - 1)
    pairs = zip(states, finer[::stride], strict=True)
    return max(np.max(np.abs(a.motion.motion.q - b.motion.motion.q) / scale) for a, b in pairs)


@pytest.mark.parametrize("tolerance", ["1e-4", "1e-5", "1e-6"])
def test_the_estimate_of_motion_is_within_a_factor_of_three_of_the_truth(tolerance):
    """A mass on a spring, x = 0.9 + 0.1 cos 2t, swings without damping."""
    model, states, rows = ran(SPRING, f"integrator.tolerance={tolerance}")
    times = np.array([state.motion.motion.t for state in states])
    exact = 0.9 + HALF * np.cos(RATE * times)
    found = np.array([state.motion.motion.q[0] for state in states])
    true = np.abs(found - exact).max() / model.motion_solver.system.scale[0]
    said = error_estimate.estimate(model, rows)
    assert true / 3.0 < said.motion < 3.0 * true


@pytest.mark.parametrize("tolerance", ["1e-5", "1e-6"])
def test_of_a_flexible_body_with_damping_it_errs_on_the_safe_side(tolerance):
    """Up to ten times the truth, which damping makes smaller than the sum of local errors."""
    model, states, rows = ran(BOOM, f"integrator.tolerance={tolerance}")
    _, finer, _ = ran(BOOM, "integrator.tolerance=1e-9", "time.window=0.5")
    true = apart(states, finer, model.motion_solver.system.scale)
    said = error_estimate.estimate(model, rows)
    assert true < said.motion < 10.0 * true
    assert said.length == pytest.approx(said.motion * 20.0)


@pytest.mark.parametrize("tolerance", ["0.1", "0.01"])
def test_the_estimate_of_heat_bounds_the_truth(tolerance):
    changes = "time.window=10.0", "integrator.largest_step=10.0"
    model, states, rows = ran(BOOM, *changes, f"thermal.tolerance={tolerance}")
    _, finer, _ = ran(BOOM, *changes, "thermal.tolerance=1e-7")
    true = max(np.abs(a.T - b.T).max() for a, b in zip(states, finer, strict=True))
    said = error_estimate.estimate(model, rows)
    assert 0.2 * true < said.heat < 20.0 * true


def test_errors_of_the_state_are_sum_and_largest():
    _, states, rows = ran(SPRING, "integrator.tolerance=1e-5")
    total, largest = states[-1].motion.errors
    assert total == pytest.approx(rows["motion_error"].sum())
    assert 0.0 < largest <= 1e-5
    assert largest <= total <= largest * states[-1].motion.counts[0]


def test_equal_steps_of_heat_estimate_nothing():
    model, _, rows = ran(BOOM, "time.end=2.0", "thermal.steps=1")
    assert np.isnan(error_estimate.estimate(model, rows).heat)


def test_run_time_of_a_run_that_was_resumed():
    assert error_estimate.run_time(np.array([1.0, 2.0, 0.5, 3.0])) == 5.0


def test_attributes_come_back():
    found = Estimate(1e-4, 2e-3, 0.1, 0.2, 3.0)
    assert error_estimate.kept(error_estimate.attributes(found)) == found
    assert error_estimate.kept({}) is None


def test_what_is_not_known_is_left_out():
    text = error_estimate.said(Estimate(1e-4, 2e-3, np.nan, np.nan, 3.0))
    assert text == (
        "estimated error in time: motion 0.0001 of its size, at most 0.002 m; run time 3 s"
    )


def test_a_run_ends_with_it_and_its_results_keep_it(tmp_path):
    (tmp_path / "case.toml").write_text(BOOM)
    given = ["run", str(tmp_path), "--set", "time.end=3.0"]
    shown = CliRunner().invoke(app, given)
    assert shown.exit_code == 0, shown.output
    assert "estimated error in time: motion" in shown.output
    assert "(tolerance 1e-06 per step), heat" in shown.output
    with Results.open(tmp_path / "results/001") as results:
        kept = error_estimate.kept(results.attributes())
        rows = results.table("windows")
    assert kept.motion == pytest.approx(rows["motion_error"].sum())
    assert kept.heat == pytest.approx(rows["heat_error"].sum())


def test_going_on_with_a_run_goes_on_with_its_estimate(tmp_path):
    (tmp_path / "case.toml").write_text(SPRING)
    run = ["run", str(tmp_path), "--output", str(tmp_path / "whole")]
    assert CliRunner().invoke(app, run).exit_code == 0
    part = ["run", str(tmp_path), "--output", str(tmp_path / "parts")]
    assert CliRunner().invoke(app, [*part, "--set", "time.end=2.0"]).exit_code == 0
    assert CliRunner().invoke(app, [*part, "--resume"]).exit_code == 0
    found = []
    for name in ("whole", "parts"):
        with Results.open(tmp_path / name / "001") as results:
            found.append(error_estimate.kept(results.attributes()).motion)
    assert found[0] == pytest.approx(found[1], rel=1e-12)
