"""Window loop, recording, ends of a run: done, stopped, interrupted, killed, resumed."""

import csv
import os
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from run_folders import assert_same, assert_same_results, consistent
from scipy.sparse import csr_array

from coupling import casefile, simulation
from coupling.errors import BadCase
from coupling.manager import Coupled, Pair, isothermal
from coupling.model import build
from coupling.overrides import parse
from coupling.results import Recorder, new_run_folder
from coupling.simulation import TICKS, Done, Stopped, windows
from coupling.transfer import Transfer

ROOT = Path(__file__).parent.parent

# ----------------------------------------------------------------- the loop, with a made-up solver


class Picky:
    """Refuses what ``refuses`` (start, length of the window) says; its state is the time."""

    def __init__(self, refuses):
        self.refuses, self.asked = refuses, []

    def advance(self, t, h, T0, T1, observe=None):
        self.asked.append((t, h))
        return t + h, np.zeros(0), "too long" if self.refuses(t, h) else ""


def knot(t, h, begin=0.14, end=0.16):
    """Windows that touch this stretch must be a sixteenth, 0.00625 s, or shorter."""
    return t < end and t + h > begin and h > 0.007


def looped(refuses, count=4, smallest=0.0, window=0.1):
    solver = Picky(refuses)
    nothing = Transfer(csr_array((0, 0)), np.zeros((0, 3)))
    model = SimpleNamespace(
        advance=isothermal, pace=None, pair=Pair(None, solver, nothing),
        window=window, windows=count, smallest_window=smallest,
    )  # fmt: skip
    start = Coupled(np.zeros(0), 0.0, np.zeros(0), np.zeros(0), 0.0, 0.0, {}, {}, 0.0)
    return model, solver, start


def run_all(refuses, *start, **more):
    model, solver, begin = looped(refuses, **more)
    return list(windows(model, *(start or (begin,)))), solver


def test_windows_of_equal_length_end_at_whole_ticks():
    found, _ = run_all(lambda t, h: False)
    assert [w.tick for w in found] == [TICKS, 2 * TICKS, 3 * TICKS, 4 * TICKS]
    assert [w.t for w in found] == [0.1, 0.2, 3 * 0.1, 0.4]
    assert all(w.halvings == 0 and w.size == TICKS for w in found)


def test_a_refused_window_is_halved_and_grows_again():
    """Around t = 0.15 no more than a sixteenth of a window is taken."""
    found, _ = run_all(knot)
    assert found[-1].tick == 4 * TICKS and all(isinstance(w, Done) for w in found)
    sizes = np.array([w.size for w in found])
    starts = np.array([w.tick for w in found]) - sizes
    assert np.all(starts % sizes == 0), "each starts on a multiple of itself"
    assert np.array_equal(starts[1:], [w.tick for w in found[:-1]])
    assert sizes.min() == TICKS // 16 and sizes[0] == sizes[-1] == TICKS
    assert np.all(sizes[1:] <= 2 * sizes[:-1])
    assert max(w.halvings for w in found) >= 2


def test_times_follow_from_ticks_and_never_from_sums():
    found, solver = run_all(knot)
    for w in found:
        whole, part = divmod(w.tick, TICKS)
        assert w.t == (whole + part / TICKS) * 0.1
    assert found[-1].t == 0.4
    assert max(h for _, h in solver.asked) <= 0.1 + 1e-15


def test_the_state_goes_from_window_to_window_and_failed_attempts_leave_none():
    found, _ = run_all(lambda t, h: h > 0.03)
    for before, after in pairwise(found):
        assert after.state.motion == before.state.motion + after.h


@pytest.mark.parametrize(("smallest", "last"), [(0.0, 0.1 / TICKS), (0.025, 0.025), (0.03, 0.05)])
def test_a_window_that_cannot_be_halved_further_stops_the_run(smallest, last):
    found, solver = run_all(lambda t, h: t >= 0.2, smallest=smallest)
    assert isinstance(found[-1], Stopped) and len(found) == 3
    assert found[-1] == Stopped(0.2, "too long")
    assert solver.asked[-1][1] == pytest.approx(last, rel=1e-12)


def test_attempts_are_announced_and_failures_reported():
    calls = []
    model, _, start = looped(lambda t, h: h > 0.03, count=1)
    attempts = simulation.Attempts(
        lambda: calls.append("begin"), None, lambda: calls.append("failed")
    )
    found = list(windows(model, start, attempts=attempts))
    assert calls[:5] == ["begin", "failed", "begin", "failed", "begin"]
    assert calls.count("begin") == len(found) + calls.count("failed")


def test_going_on_from_any_window_gives_the_same_windows():
    def knots(t, h):
        return knot(t, h) or knot(t, h, 0.27, 0.29)

    found, _ = run_all(knots)
    assert len({w.size for w in found}) > 3
    for k, w in enumerate(found[:-1]):
        rest, _ = run_all(knots, w.state, w.tick, w.size)
        assert rest == found[k + 1 :]


# ------------------------------------------------------------------------------- small real runs

ROD = """
title = "a pushed rod"

[time]
end = 0.4
window = 0.05

[coupling]
smallest_window = 0.05

[integrator]
tolerance = 1e-7
largest_step = 2e-3
smallest_step = 2e-3

[section.bar]
kind = "rectangle"
height = 0.02
width = 0.02

[body.rod]
kind = "beam"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
elements = 2
section = "bar"
material = "al6061"
damping = 1e-3

[joint.root]
kind = "clamp"
a = { body = "rod", at = "start" }

[load.blow]
kind = "force"
at = { body = "rod", at = "end" }
direction = [0.0, 1.0, 0.0]
amplitude = { step = { at = 0.22, from = 0.0, to = 0.2 } }

[probe.tip]
body = "rod"
at = "end"
"""

HEATED = """
[thermal]
initial = 300.0
wall_points = 1

[thermal.source.flame]
at = { body = "rod", at = "end" }
power = { step = { at = 0.15, from = 0.0, to = 1e8 } }
"""

ARM = ROOT / "cases" / "arm_rotation"
SHORT = ("time.end=2", "body.arm.elements=4", "output.frames=7", "output.export=[]")


def arm(**changes):
    given = dict(s.split("=", 1) for s in SHORT) | changes
    return casefile.read(ARM, [f"{key}={value}" for key, value in given.items()])


def rod(text=ROD):
    return casefile.from_text(text, ROOT)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The short arm in one go, and how long that took."""
    folder = tmp_path_factory.mktemp("whole")
    model_ready = time.monotonic()
    outcome = simulation.run(arm(), folder)
    assert outcome == (0, folder / "001", "")
    return outcome, time.monotonic() - model_ready


def test_a_finished_run_has_all_its_windows(whole):
    groups, state, attributes = consistent(whole[0].folder)
    assert attributes["outcome"] == "done" and attributes["reason"] == ""
    np.testing.assert_allclose(groups["windows"]["time"], 0.1 * np.arange(1, 21), rtol=1e-14)
    assert state["tick"] == 20 * TICKS
    assert groups["windows"]["iterations"].min() > 0
    assert 7 <= len(groups["frames"]["time"]) <= 9


def test_recorded_substeps_tell_the_smallest_and_largest_step(whole):
    groups = consistent(whole[0].folder)[0]
    t = np.concatenate([[0.0], groups["joints/hinge"]["time"]])
    ends = np.concatenate([[0.0], groups["windows"]["time"]])
    for k in range(20):
        sizes = np.diff(t[(t >= ends[k]) & (t <= ends[k + 1])])
        assert groups["windows"]["step_min"][k] == pytest.approx(sizes.min(), rel=1e-9)
        assert groups["windows"]["step_max"][k] == pytest.approx(sizes.max(), rel=1e-9)


def test_probes_are_written_as_a_table_with_units(whole):
    with (whole[0].folder / "probes.csv").open() as file:
        header, *rows = csv.reader(file)
    kinds = (("", "m"), ("v", "m/s"), ("a", "m/s^2"))
    of_tip = [f"tip.{kind}{axis} [{unit}]" for kind, unit in kinds for axis in "xyz"]
    assert header[0] == "time [s]" and header[11:] == [*of_tip, "tip.temperature [K]"]
    values = np.array(rows, float)
    assert values.shape == (21, 21)
    tip = consistent(whole[0].folder)[0]["probes/tip"]
    assert np.array_equal(values[:, 11:14], tip["position"])
    assert np.array_equal(values[:, 17:20], tip["acceleration"])
    assert values[0, [0, 11, 12, 13]].tolist() == [0.0, 63.5, 0.0, 0.0]


def test_every_dataset_says_its_unit_and_meaning(whole):
    silent = []

    def visit(name, item):
        told = "unit" in item.attrs and item.attrs.get("description")
        if isinstance(item, h5py.Dataset) and not name.startswith("state") and not told:
            silent.append(name)

    with h5py.File(whole[0].folder / "results.h5") as file:
        file.visititems(visit)
    assert silent == []


def test_two_runs_never_share_a_folder(tmp_path, whole):
    scene = rod(ROD.replace("end = 0.4", "end = 0.1"))
    first = simulation.run(scene, tmp_path).folder
    kept = (first / "results.h5").read_bytes()
    second = simulation.run(scene, tmp_path).folder
    assert (first.name, second.name) == ("001", "002")
    assert (first / "results.h5").read_bytes() == kept


def test_the_same_case_gives_the_same_bits(whole, tmp_path):
    assert_same_results(simulation.run(arm(), tmp_path), whole[0])


# ------------------------------------------------------------------------------- stopped runs


def test_a_step_that_cannot_be_taken_stops_the_run_with_its_place_and_time(tmp_path):
    outcome = simulation.run(rod(), tmp_path)
    assert outcome.code == 3
    assert outcome.reason.startswith("stopped at t = 0.2 s: ")
    assert "the local error stays above the tolerance at rod node 2" in outcome.reason
    groups, _, attributes = consistent(outcome.folder)
    assert (attributes["outcome"], attributes["reason"]) == ("stopped", outcome.reason)
    assert len(groups["windows"]["time"]) == 4
    assert (outcome.folder / "probes.csv").read_text().count("\n") == 1 + 5


def test_a_stopped_run_can_be_resumed_and_stops_again(tmp_path):
    first = simulation.run(rod(), tmp_path)
    before = consistent(first.folder)[0]
    again = simulation.run(rod(), tmp_path, resume=True)
    assert again == first
    assert_same(consistent(again.folder)[0], before)


def test_a_stopped_run_goes_on_with_a_looser_tolerance(tmp_path):
    stopped = simulation.run(rod(), tmp_path)
    looser = casefile.from_text(ROD, ROOT, parse(["integrator.tolerance=0.1"]))
    done = simulation.run(looser, tmp_path, resume=True)
    assert (done.code, done.folder) == (0, stopped.folder)
    assert consistent(done.folder)[0]["windows"]["time"][-1] == pytest.approx(0.4, rel=1e-12)


def test_temperatures_beyond_the_data_stop_the_run_with_their_place(tmp_path):
    text = ROD.replace("0.2 }", "0.0 }") + HEATED
    outcome = simulation.run(rod(text), tmp_path)
    assert outcome.code == 3
    assert "heat: " in outcome.reason and "'rod' left the range" in outcome.reason
    groups, _, _ = consistent(outcome.folder)
    assert len(groups["windows"]["time"]) == 3


def test_the_command_ends_with_exit_code_3_and_says_why(tmp_path):
    from typer.testing import CliRunner

    from coupling.cli import app

    (tmp_path / "case.toml").write_text(ROD)
    ended = CliRunner().invoke(app, ["run", str(tmp_path)])
    assert ended.exit_code == 3
    assert "stopped at t = 0.2 s" in ended.output and "rod node 2" in ended.output
    assert consistent(tmp_path / "results" / "001")[2]["outcome"] == "stopped"


LOOSE_PIN = """
[joint.pin]
kind = "clearance_revolute"
journal = { body = "rod", at = "end" }
axis = [0.0, 0.0, 1.0]
radius = 0.02
clearance = 1e-3
journal_material = "al6061"
bearing_material = "al6061"
"""
HALVED = (
    ROD.replace("smallest_window = 0.05", "smallest_window = 1e-4").replace(
        "smallest_step = 2e-3", "smallest_step = 5e-4"
    )
    + LOOSE_PIN
)


def test_windows_are_halved_where_the_motion_asks_for_it(tmp_path):
    outcome = simulation.run(rod(HALVED), tmp_path)
    assert outcome.code == 0
    groups, _, _ = consistent(outcome.folder)
    lengths, halvings = groups["windows"]["window"], groups["windows"]["halvings"]
    assert lengths[:4].tolist() == pytest.approx([0.05] * 4)
    assert halvings.max() > 2 and lengths.min() < 0.05 / 4
    assert lengths.sum() == pytest.approx(0.4, rel=1e-12)
    assert groups["windows"]["time"][-1] == 0.4


# ------------------------------------------------------------------ interrupted, resumed, killed


def test_an_interrupted_run_goes_on_to_the_same_end(whole, tmp_path, monkeypatch):
    from coupling.progress import Progress

    def interrupt(self, model, window):
        if window.t > 0.7:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Progress, "window", interrupt)
        with pytest.raises(KeyboardInterrupt):
            simulation.run(arm(), tmp_path)
    groups, _, attributes = consistent(tmp_path / "001")
    assert (attributes["outcome"], attributes["reason"]) == ("stopped", "interrupted")
    assert 0.7 < groups["windows"]["time"][-1] < 1.0
    outcome = simulation.run(arm(), tmp_path, resume=True)
    assert outcome == (0, tmp_path / "001", "")
    assert_same_results(outcome, whole[0])


def test_a_longer_run_goes_on_from_a_shorter_one(whole, tmp_path):
    simulation.run(arm(**{"time.end": "1.1"}), tmp_path)
    outcome = simulation.run(arm(), tmp_path, resume=True)
    (ours, state, _), (theirs, expected, _) = (
        consistent(outcome.folder),
        consistent(whole[0].folder),
    )
    assert_same(state, expected)
    for group in ("windows", "ledger", "probes/tip", "joints/hinge"):  # not the frames
        assert_same(ours[group], theirs[group], group)


def test_a_finished_run_resumed_is_finished(whole, tmp_path):
    scene = rod(ROD.replace("end = 0.4", "end = 0.1"))
    done = simulation.run(scene, tmp_path)
    before = consistent(done.folder)
    assert simulation.run(scene, tmp_path, resume=True) == done
    after = consistent(done.folder)
    assert_same(after[0], before[0])
    assert_same(after[1], before[1])


def test_halved_windows_go_on_as_they_would_have(tmp_path):
    """From every window of a run with halvings, the rest follows bit for bit."""
    model = build(rod(HALVED))
    found = list(windows(model, model.initial()))
    assert len({w.size for w in found}) > 2
    for k in range(3, len(found) - 1, 3):
        rest = list(windows(model, found[k].state, found[k].tick, found[k].size))
        assert [(w.tick, w.size) for w in rest] == [(w.tick, w.size) for w in found[k + 1 :]]
        q = rest[-1].state.motion.motion.q
        assert np.array_equal(q, found[-1].state.motion.motion.q)


@pytest.mark.parametrize("change", ["body.arm.elements=5", "time.window=0.05"])
def test_another_case_is_not_resumed(whole, change):
    key, value = change.split("=")
    with pytest.raises(BadCase, match=key.split(".")[0]):
        simulation.run(arm(**{key: value}), whole[0].folder.parent, resume=True)


def test_without_a_run_there_is_nothing_to_resume(tmp_path):
    with pytest.raises(BadCase, match="no run to resume"):
        simulation.run(rod(), tmp_path, resume=True)


def write_always(patch):
    """Results are written after every window."""
    patch.setattr(Recorder, "interval", 0.0)
    patch.setattr(Recorder, "patience", 0.0)


def test_a_run_killed_before_its_first_state_begins(tmp_path):
    killed = new_run_folder(tmp_path)
    Recorder(killed, {"scene": ROD})
    assert simulation.run(rod(), tmp_path, resume=True).folder == killed
    assert_same(consistent(killed)[0], consistent(simulation.run(rod(), tmp_path).folder)[0])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("moment", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_a_killed_run_is_readable_and_goes_on_to_the_same_end(whole, tmp_path, monkeypatch, moment):
    with monkeypatch.context() as patch:
        write_always(patch)
        pid = os.fork()
        if pid == 0:
            try:
                simulation.run(arm(), tmp_path)
            finally:
                os._exit(1)
        wait_for(tmp_path / "001" / "results.h5")
        time.sleep(moment * np.random.default_rng().uniform(0.8, 1.2) * whole[1])
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
    check_killed(tmp_path, whole)


def wait_for(file, seconds=60.0):
    started = time.monotonic()
    while not file.exists():
        assert time.monotonic() - started < seconds, "the run did not begin"
        time.sleep(0.002)


def check_killed(folder, whole):
    attributes = consistent(folder / "001")[2]
    assert attributes["outcome"] in ("running", "done")
    outcome = simulation.run(arm(), folder, resume=True)
    assert outcome == (0, folder / "001", "")
    assert_same_results(outcome, whole[0])


@pytest.mark.slow
@pytest.mark.parametrize("moment", np.linspace(0.0, 1.2, 20))
def test_a_process_killed_at_any_moment_leaves_readable_results(whole, tmp_path, moment):
    program = (
        "import sys; from pathlib import Path; from coupling import casefile, simulation;"
        "from coupling.results import Recorder; Recorder.interval = Recorder.patience = 0.0;"
        f"simulation.run(casefile.read({str(ARM)!r}, {SHORT!r}), Path(sys.argv[1]))"
    )
    process = subprocess.Popen([sys.executable, "-c", program, str(tmp_path)], cwd=ROOT)
    wait_for(tmp_path / "001" / "results.h5")
    time.sleep(moment * whole[1])
    process.kill()
    process.wait()
    check_killed(tmp_path, whole)
