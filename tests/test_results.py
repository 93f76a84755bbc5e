"""results.h5 and probes.csv: what is recorded comes back, whatever happens in between."""

import csv
import json
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coupling.columns import STANDARD
from coupling.results import BadResults, Recorder, Results, new_run_folder
from coupling.tables import Table

META = {"title": "an arm", "scene": "[body]\n", "overrides": ["a=1"], "versions": {"numpy": "2"}}


@pytest.fixture
def recorder(tmp_path: Path) -> Recorder:
    return Recorder(tmp_path, META)


def joint_row(time: float, force: float = 0.0) -> dict[str, Any]:
    return {"time": time, "orbit": [1e-5 * time, 0.0], "normal_force": force, "regime": 3}


# ------------------------------------------------------------------------------ folders


def test_run_folders_count_up_and_skip_what_is_no_number(tmp_path: Path) -> None:
    parent = tmp_path / "case" / "results"
    assert new_run_folder(parent).name == "001"
    (parent / "best").mkdir()
    (parent / "041").mkdir()
    assert new_run_folder(parent).name == "042"


def test_simultaneous_runs_get_different_folders(tmp_path: Path) -> None:
    made: list[Path] = []
    threads = [
        threading.Thread(target=lambda: made.extend(new_run_folder(tmp_path) for _ in range(20)))
        for _ in range(5)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(p.name for p in made) == [f"{k:03d}" for k in range(1, 101)]


# ---------------------------------------------------------------------- writing, reading


def test_rows_come_back_with_types_units_and_descriptions(recorder: Recorder) -> None:
    for k in range(200):
        recorder.append("joints/hinge", joint_row(0.1 * k, float(k)))
        recorder.append("windows", {"time": 0.1 * k, "steps": k})
    recorder.close("done")
    with Results.open(recorder.path) as results:
        hinge = results.table("joints/hinge")
        assert hinge["orbit"].shape == (200, 2)
        np.testing.assert_array_equal(hinge["orbit"][:, 0], 1e-5 * (0.1 * np.arange(200)))
        assert hinge["regime"].dtype == np.int8
        assert results["windows/steps"].dtype == np.int64
        assert results.column("joints/hinge/normal_force")[:2] == ("N", "normal contact force")


def test_a_whole_number_at_first_does_not_make_a_column_of_integers(recorder: Recorder) -> None:
    recorder.append("ledger", {"friction": 0})
    recorder.append("ledger", {"friction": 0.75})
    recorder.close("done")
    assert Results.open(recorder.path)["ledger/friction"].tolist() == [0.0, 0.75]


def test_every_dataset_says_its_unit_and_meaning(recorder: Recorder) -> None:
    recorder.declare("joints/hinge", "wear", "m", "worn depth")
    recorder.append("joints/hinge", {**joint_row(0.0), "wear": 1e-9})
    recorder.append("ledger", {"kinetic": 1.0, "heat_sun": 2.0})
    recorder.append("bodies/arm", {"position": np.zeros((4, 3))})
    recorder.state({"q": np.zeros(3)})
    recorder.close("done")
    found = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = (item.attrs["unit"], item.attrs["description"])

    with h5py.File(recorder.path) as file:
        file.visititems(visit)
    assert len(found) == 9
    assert found["joints/hinge/wear"] == ("m", "worn depth")
    assert found["ledger/heat_sun"] == ("J", "heat that entered through sun")
    assert all(description for _, description in found.values())


def test_blocks_of_rows_equal_single_rows(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    one, many = Recorder(tmp_path / "a", META), Recorder(tmp_path / "b", META)
    times = np.linspace(0.0, 1.0, 150)
    for t in times:
        one.append("probes/tip", {"time": t, "position": [t, 2 * t, 3 * t]})
    position = np.outer(times, [1, 2, 3])
    for part in (slice(0, 1), slice(1, 100), slice(100, 150)):
        many.append_many("probes/tip", {"time": times[part], "position": position[part]})
    one.close("done")
    many.close("done")
    first, second = (Results.open(r.path).table("probes/tip") for r in (one, many))
    np.testing.assert_array_equal(first["time"], second["time"])
    np.testing.assert_allclose(first["position"], second["position"], rtol=1e-15)


def test_root_attributes(recorder: Recorder) -> None:
    assert Results.open(recorder.path).attributes()["outcome"] == "running"
    recorder.close("stopped", "joint hinge: no convergence at 0.3 s")
    attributes = Results.open(recorder.path).attributes()
    assert attributes["outcome"] == "stopped"
    assert attributes["reason"] == "joint hinge: no convergence at 0.3 s"
    assert attributes["format_version"] == 2
    assert json.loads(attributes["overrides"]) == ["a=1"]
    assert json.loads(attributes["versions"]) == {"numpy": "2"}


def test_a_very_long_scene_is_kept(tmp_path: Path) -> None:
    scene = "# é\n" * 500_000  # attributes of fixed length end at 64 kB
    Recorder(tmp_path, {"scene": scene})
    assert Results.open(tmp_path).attributes()["scene"] == scene


def test_group_attributes(recorder: Recorder) -> None:
    attributes = {"section_kind": "tube", "radius": 0.27, "directions": [[1.0, 0, 0], [0, 1, 0]]}
    recorder.describe_group("bodies/arm", attributes)
    recorder.close("done")
    found = Results.open(recorder.path).attributes("bodies/arm")
    assert found["section_kind"] == "tube" and found["radius"] == 0.27
    np.testing.assert_array_equal(found["directions"], np.eye(3)[:2])


def test_mistakes_of_the_caller_are_named(recorder: Recorder) -> None:
    with pytest.raises(ValueError, match="joints/hinge/wear: declare"):
        recorder.append("joints/hinge", {"wear": 1.0})
    recorder.append("joints/hinge", joint_row(0.0))
    with pytest.raises(ValueError, match=r"joints/hinge: .*'slip_speed'"):
        recorder.append("joints/hinge", {**joint_row(0.1), "slip_speed": 1.0})
    with pytest.raises(ValueError, match="joints/hinge/orbit: shape"):
        recorder.append("joints/hinge", {**joint_row(0.1), "orbit": 0.0})
    with pytest.raises(ValueError, match="different length"):
        recorder.append_many("frames", {"time": [0.0, 1.0], "n": [1]})
    with pytest.raises(ValueError, match="expected one of running, done, stopped"):
        recorder.close("finished")


# -------------------------------------------------------------------------------- windows


def test_a_rejected_window_leaves_nothing(recorder: Recorder) -> None:
    recorder.state({"t": 0.0})
    recorder.begin()
    recorder.append("windows", {"time": 1.0})
    recorder.state({"t": 1.0})
    recorder.commit()
    recorder.begin()
    recorder.append("windows", {"time": 2.0})
    recorder.append("joints/hinge", joint_row(2.0))
    recorder.state({"t": 2.0})
    recorder.rollback()
    recorder.begin()
    recorder.append("windows", {"time": 1.5})
    recorder.commit()
    recorder.flush()
    results = Results.open(recorder.path)
    assert results["windows/time"].tolist() == [1.0, 1.5]
    assert results["joints/hinge/time"].size == 0
    assert results.read_state() == {"t": 1.0}


def test_an_open_window_is_never_written(recorder: Recorder) -> None:
    recorder.state({"t": 0.0})
    recorder.begin()
    recorder.append("windows", {"time": 1.0})
    recorder.state({"t": 1.0})
    recorder.flush()
    results = Results.open(recorder.path)
    assert results["windows/time"].size == 0 and results.read_state() == {"t": 0.0}
    with pytest.raises(RuntimeError, match="neither committed nor rolled back"):
        recorder.begin()
    recorder.close("stopped", "interrupted")
    assert Results.open(recorder.path)["windows/time"].size == 0


def test_the_file_is_written_now_and_then_only(recorder: Recorder) -> None:
    def written_after(seconds: float, duration: float) -> bool:
        recorder._written, recorder._duration = time.monotonic() - seconds, duration
        before = recorder._written
        recorder.begin()
        recorder.commit()
        return recorder._written > before

    assert not written_after(9.9, 0.0)
    assert written_after(10.1, 0.0)
    assert not written_after(49.0, 0.5)
    assert written_after(50.5, 0.5)


# ---------------------------------------------------------------------------------- state


class Motion(NamedTuple):
    q: np.ndarray
    steps: int
    contact: dict[str, Any]


def test_state_comes_back_exactly(recorder: Recorder) -> None:
    q = np.random.default_rng(1).standard_normal((5, 3))
    contact = {"since": None, "closed": np.array([True, False]), "none": np.empty((0, 3))}
    motion = Motion(q, 7, {**contact, "law": "exact", "open": False, "list": [1.5, None, "a"]})
    recorder.state({"motion": motion, "T": np.array([1e-300, np.inf]), "t": 0.1 + 0.2})
    recorder.flush()
    state = Results.open(recorder.path).read_state()
    np.testing.assert_array_equal(state["motion"]["q"], q)
    assert state["t"] == 0.1 + 0.2 and state["T"].tolist() == [1e-300, np.inf]
    assert state["motion"]["steps"] == 7
    back = state["motion"]["contact"]
    assert back["since"] is None and back["closed"].tolist() == [True, False]
    assert back["none"].shape == (0, 3) and back["law"] == "exact" and back["open"] is False
    assert back["list"] == [1.5, None, "a"]


def test_state_that_cannot_be_kept_is_named_and_the_old_file_stays(recorder: Recorder) -> None:
    recorder.append("windows", {"time": 1.0})
    recorder.flush()
    recorder.append("windows", {"time": 2.0})
    recorder.state({"motion": {"law": object()}})
    with pytest.raises(TypeError, match="/state/motion/law: cannot store a object"):
        recorder.flush()
    assert Results.open(recorder.path)["windows/time"].tolist() == [1.0]
    assert [p.name for p in recorder.path.parent.iterdir()] == ["results.h5"]


# ------------------------------------------------------------------------------- resuming


def test_a_reopened_recorder_goes_on_as_if_never_closed(tmp_path: Path) -> None:
    force = np.random.default_rng(0).random(1000)

    def record(recorder: Recorder, rows: range) -> None:
        recorder.describe_group("joints/hinge", {"position": [0.0, 0.0, 1.0]})
        recorder.declare("joints/hinge", "wear", "m", "worn depth")
        for k in rows:
            recorder.append("joints/hinge", {**joint_row(float(k), force[k]), "wear": 0.0})
            recorder.append("probes/tip", {"time": float(k), "position": [k, 0.0, 0.0]})
        recorder.state({"k": rows[-1], "deep": {"list": [1, 2]}})

    for name in ("whole", "parts"):
        (tmp_path / name).mkdir()
    whole = Recorder(tmp_path / "whole", META, max_rows=100)
    record(whole, range(1000))
    whole.close("done")
    first = Recorder(tmp_path / "parts", META, max_rows=100)
    record(first, range(437))
    first.flush()
    second = Recorder.reopen(tmp_path / "parts", max_rows=100)
    record(second, range(437, 1000))
    second.close("done")
    a, b = Results.open(tmp_path / "whole"), Results.open(tmp_path / "parts")
    assert a.groups() == b.groups()
    for group in a.groups():
        assert a.attributes(group).keys() == b.attributes(group).keys()
        for name, column in a.table(group).items():
            np.testing.assert_array_equal(column, b[f"{group}/{name}"])
            assert a.column(f"{group}/{name}") == b.column(f"{group}/{name}")
    assert a.read_state() == b.read_state()


def test_reopening_keeps_a_state_that_nobody_replaces(recorder: Recorder) -> None:
    recorder.state({"motion": Motion(np.arange(3.0), 1, {"none": None})})
    recorder.flush()
    Recorder.reopen(recorder.path.parent).close("stopped", "again")
    state = Results.open(recorder.path).read_state()
    assert state["motion"]["q"].tolist() == [0.0, 1.0, 2.0]
    assert state["motion"]["contact"] == {"none": None}


def test_truncate_drops_later_rows_everywhere(recorder: Recorder) -> None:
    for k in range(10):
        recorder.append("windows", {"time": float(k)})
        recorder.append("ledger", {"kinetic": 2.0 * k})
        recorder.append_many("joints/hinge", {"time": k - np.array([0.5, 0.0]), "angle": [0, 0]})
    for k in range(4):
        recorder.append("frames", {"time": 3.0 * k})
        recorder.append("bodies/arm", {"position": np.full((2, 3), float(k))})
    recorder.truncate(5.0)
    recorder.close("done")
    results = Results.open(recorder.path)
    assert results["windows/time"][-1] == 5.0
    assert results["ledger/kinetic"].tolist() == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]
    assert results["joints/hinge/time"][-1] == 5.0
    assert results["frames/time"].tolist() == [0.0, 3.0]
    assert len(results["bodies/arm/position"]) == 2


# ------------------------------------------------------------------------------- thinning


def thinned(force: np.ndarray, windows: list[int], limit: int) -> Table:
    """Rows 0, 1, … in windows of the given lengths, each preceded by a rejected attempt."""
    table = Table("joints/hinge", lambda name: STANDARD["joints"][name], "normal_force", limit)
    start = 0
    for length in [*windows, len(force)]:
        rows = slice(start, min(start + length, len(force)))
        block = {"time": np.arange(len(force))[rows], "normal_force": force[rows]}
        table.append_many({"time": [-1.0], "normal_force": [np.inf]})
        table.reject()
        table.append_many(block)
        table.accept()
        start = rows.stop
    return table


def strongest_of_blocks(force: np.ndarray, limit: int) -> np.ndarray:
    """The definition, evaluated with all rows at hand."""
    stride = 1
    while -(-len(force) // stride) > limit:
        stride *= 2
    starts = range(0, len(force), stride)
    return np.array([s + int(np.argmax(force[s : s + stride])) for s in starts])


@settings(max_examples=60, deadline=None)
@given(
    rows=st.integers(1, 700),
    levels=st.integers(1, 50),
    seed=st.integers(0, 9),
    windows=st.lists(st.integers(0, 90), max_size=12),
)
def test_thinning_keeps_the_strongest_row_of_each_block(
    rows: int, levels: int, seed: int, windows: list[int]
) -> None:
    force = np.random.default_rng(seed).integers(0, levels, rows).astype(float)
    table = thinned(force, windows, limit=40)
    assert table.kept <= 40
    np.testing.assert_array_equal(table.rows()["time"], strongest_of_blocks(force, 40))


def test_a_joint_without_contact_is_thinned_too(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path, META, max_rows=10)
    for k in range(35):
        recorder.append("joints/drive", {"time": float(k), "angle": 0.1 * k})
        recorder.append("windows", {"time": float(k)})
    recorder.close("done")
    results = Results.open(tmp_path)
    assert results["joints/drive/time"].tolist() == [
        0.0,
        4.0,
        8.0,
        12.0,
        16.0,
        20.0,
        24.0,
        28.0,
        32.0,
    ]
    assert results["windows/time"].size == 35
    assert results.attributes("joints/drive") == {"stride": 4, "rows_recorded": 35}


# ------------------------------------------------------------------------------ bad files


def test_reading_what_does_not_exist_names_what_does(recorder: Recorder) -> None:
    recorder.append("windows", {"time": 1.0})
    recorder.close("done")
    results = Results.open(recorder.path)
    with pytest.raises(BadResults, match="has no windows/tine; windows has time"):
        results["windows/tine"]
    with pytest.raises(BadResults, match="windows is a group; it has time"):
        results["windows"]
    assert results.names("joints") == [] and results.table("joints/hinge") == {}
    assert "windows/time" in results and "windows/tine" not in results


def test_files_that_are_no_results_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadResults, match=r"results\.h5: no such file"):
        Results.open(tmp_path)
    (tmp_path / "note.h5").write_text("hello")
    with pytest.raises(BadResults, match="damaged, or no HDF5 file"):
        Results.open(tmp_path / "note.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(BadResults, match="not written by thermobody"):
        Results.open(tmp_path / "other.h5")
    with h5py.File(tmp_path / "newer.h5", "w") as file:
        file.attrs.update({"format": "thermobody-results", "format_version": 3})
    with pytest.raises(BadResults, match="format version 3; this program reads 1 and 2"):
        Results.open(tmp_path / "newer.h5")


@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.3, 0.7, 0.999])
def test_a_truncated_file_is_refused(recorder: Recorder, fraction: float) -> None:
    recorder.append_many("frames", {"time": np.arange(5000.0)})
    recorder.close("done")
    whole = recorder.path.read_bytes()
    recorder.path.write_bytes(whole[: int(fraction * len(whole))])
    with pytest.raises(BadResults, match="damaged"):
        Results.open(recorder.path)


@pytest.mark.parametrize("block", [b"TREE", b"HEAP", b"SNOD", b"GCOL"])
def test_damage_inside_is_told_as_damage(recorder: Recorder, block: bytes) -> None:
    recorder.append_many("frames", {"time": np.arange(50.0)})
    recorder.close("done")
    whole = recorder.path.read_bytes()
    assert block in whole
    recorder.path.write_bytes(whole.replace(block, b"gone"))
    with pytest.raises(BadResults, match="damaged"), Results.open(recorder.path) as results:
        results.table("frames")
        results.attributes("frames")
        results.column("frames/time")


KILLED = """
import sys
import numpy as np
from pathlib import Path
from coupling.results import Recorder

Recorder.interval = Recorder.patience = 0.0
recorder = Recorder(Path(sys.argv[1]), {"title": "killed"})
print("ready", flush=True)
for k in range(10**9):
    recorder.begin()
    recorder.append_many("joints/hinge", {"time": np.full(500, k), "normal_force": np.ones(500)})
    recorder.append("windows", {"time": k})
    recorder.state({"k": k})
    recorder.commit()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_run_killed_at_any_moment_leaves_a_readable_file(tmp_path: Path) -> None:
    for delay in (0.0, 0.05, 0.13, 0.22):
        folder = new_run_folder(tmp_path)
        process = subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(KILLED), str(folder)],
            stdout=subprocess.PIPE,
            cwd=Path(__file__).parents[1],
        )
        assert process.stdout is not None and process.stdout.readline() == b"ready\n"
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        with Results.open(folder) as results:
            windows = len(results.table("windows").get("time", []))
            assert results.read_state() == ({"k": windows - 1} if windows else {})
            assert len(results.table("joints/hinge").get("time", [])) == 500 * windows
        assert windows > 0 or delay == 0.0
        Recorder.reopen(folder).close("stopped", "was killed")
        assert sorted(p.name for p in folder.iterdir()) == ["results.h5"]


# ----------------------------------------------------------------------------- probes.csv


def test_probes_become_a_table_with_units(recorder: Recorder) -> None:
    for k in range(3):
        t = k / 3
        recorder.append(
            "probes/tip",
            {"time": t, "temperature": 300 + t, "velocity": [t, 0, 0], "position": [t, 2, t / 7]},
        )
        if k != 1:
            recorder.append("probes/a,b", {"time": t, "position": [0.0, 0.0, 1.0]})
    recorder.close("done")
    with recorder.path.with_name("probes.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == [
        "time [s]", "a,b.x [m]", "a,b.y [m]", "a,b.z [m]", "tip.x [m]", "tip.y [m]", "tip.z [m]",
        "tip.vx [m/s]", "tip.vy [m/s]", "tip.vz [m/s]", "tip.temperature [K]",
    ]  # fmt: skip
    assert len(rows) == 4
    assert rows[2][:4] == [repr(1 / 3), "", "", ""]
    assert float(rows[2][6]) == 1 / 3 / 7


def test_no_probes_no_table(recorder: Recorder) -> None:
    recorder.close("done")
    assert not recorder.path.with_name("probes.csv").exists()
