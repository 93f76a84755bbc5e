"""thermobody sweep: points in processes of their own, what happens when they die, going on."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from sweep_cases import CASE
from typer.testing import CliRunner

from coupling import casefile, sweeps
from coupling.cli import app
from coupling.sweeps import local, points
from coupling.sweeps.points import DONE, GIVEN_UP, LOST, REFUSED, STOPPED, Job, Point
from coupling.sweeps.progress import Progress
from coupling.sweeps.table import tabulated

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}"}
INERT = Job("0" * 20, "", "", (), np.inf)


@pytest.fixture
def case(tmp_path) -> Path:
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """All sweeps of the case, by the command, from another folder."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "case.toml").write_text(CASE)
    result = CliRunner().invoke(app, ["sweep", str(folder), "--workers", "2"])
    return folder / "results" / "sweeps", result


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(newline="", encoding="utf-8") as file:
        return [*csv.DictReader(file)]


def swing(t: float, mass: float, stiffness: float) -> float:
    """Place [m] of the weight, which begins 0.1 m beyond the rest of the spring."""
    return 0.4 + 0.1 * float(np.cos(np.sqrt(stiffness / mass) * t))


def test_the_table_has_what_the_formula_says(swept):
    folder, result = swept
    assert result.exit_code == 0, result.output
    rows = table(folder / "stiffness" / "001")
    assert [float(row["stiffness [N/m]"]) for row in rows] == [8.0, 18.0, 32.0]
    own = [float(row["place [m]"]) for row in rows]
    assert own == pytest.approx([swing(1.0, 2.0, k) for k in (8.0, 18.0, 32.0)], abs=2e-4)
    assert [row["place printed [m]"] for row in rows] == ["0.35", "nan", "0.5"]
    rows = table(folder / "two" / "001")
    pairs = [(m, k) for k in (4.0, 16.0) for m in (1.0, 4.0)]
    own = [float(row["place [m]"]) for row in rows]
    assert own == pytest.approx([swing(0.5, *pair) for pair in pairs], abs=2e-4)


def test_effects_stand_in_words(swept):
    text = (swept[0] / "two" / "001" / "table.md").read_text()
    a, b, c, d = (swing(0.5, m, k) for k in (4.0, 16.0) for m in (1.0, 4.0))
    for name, effect in {"mass": b + d - a - c, "mass × stiffness": a + d - b - c}.items():
        said = float(re.search(rf"\| {name} \| ([-.\de]+) ", text)[1])
        assert said == pytest.approx(0.5 * effect, abs=3e-4)


def test_pictures_and_points_are_there(swept):
    for name, pictures in {
        "stiffness": {"quantities", "portraits", "regularity"},
        "two": {"quantities", "effects"},
    }.items():
        folder = swept[0] / name / "001"
        made = {path.stem for path in folder.glob("*.png")}
        assert pictures - {"regularity"} <= made <= pictures
        assert len([*(folder / "points").glob("*.npz")]) == (3 if name == "stiffness" else 4)
        assert not [*folder.rglob("*.part")]


def test_resuming_computes_nothing_that_is_there(swept, monkeypatch):
    folder, _ = swept

    def nothing(*_):
        raise AssertionError("there is nothing to compute")

    monkeypatch.setattr(local, "local", nothing)
    given = ["sweep", str(folder.parent.parent), "two", "--resume"]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 0, result.output
    assert "4 of 4 points are there" in result.output
    assert "has changed" not in result.output
    assert not (folder / "two" / "002").exists()


def test_a_changed_case_is_said_and_takes_what_is_the_same(swept, tmp_path):
    folder, _ = swept
    changed = CASE.replace('"8 N/m", "18 N/m", "32 N/m"', '"18 N/m", "8 N/m"')
    changed = changed.replace("printed = [0.35, nan, 0.5]", "")
    (tmp_path / "case.toml").write_text(changed)
    given = ["sweep", str(tmp_path), "stiffness", "--resume", "--output", str(folder)]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 0, result.output
    assert "2 of 2 points are there; the case has changed" in " ".join(result.output.split())


def test_nothing_to_resume_is_bad_input(case):
    result = CliRunner().invoke(app, ["sweep", str(case), "two", "--resume"])
    assert result.exit_code == 2
    assert not (case / "results").exists()


def test_bad_input_runs_nothing(case):
    file = case / "case.toml"
    file.write_text(CASE.replace('"32 N/m"', '"-32 N/m"'))
    result = CliRunner().invoke(app, ["sweep", str(case)])
    assert result.exit_code == 2
    assert not (case / "results").exists()


# ----------------------------------------------------------------------- points that fail


def test_a_point_that_fails_does_not_lose_the_others(case):
    """One stops: it would need steps that are smaller than the case allows."""
    bad = """
[sweep.steps]
vary."joint.spring.stiffness" = ["8 N/m", "1e7 N/m"]
set = { "integrator.smallest_step" = "10 ms", "integrator.tolerance" = 1e-8 }
[sweep.steps.quantity.place]
of = "probe.weight.x"
"""
    (case / "case.toml").write_text(CASE + bad)
    result = CliRunner().invoke(app, ["sweep", str(case), "steps", "--workers", "1"])
    rows = table(case / "results" / "sweeps" / "steps" / "001")
    assert [row["outcome"] for row in rows] == [DONE, STOPPED], rows
    assert result.exit_code == 3
    assert "local error" in rows[1]["reason"]
    assert rows[1]["place [m]"] == "nan"


def test_what_a_worker_says_of_a_case_that_it_cannot_compute(tmp_path):
    point = points.compute(INERT._replace(text="[time]\nend = 1.0\n", folder=str(tmp_path)))
    assert point.outcome == REFUSED
    assert "missing" in point.reason


def dies(job: Job) -> Point:
    """In place of ``compute``: ends its process the first time, or whenever it is told to."""
    if job.text == "always" or not Path(job.text).exists():
        if job.text != "always":
            Path(job.text).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Point(DONE, "")


def stays(job: Job) -> Point:
    return Point(DONE, job.text)


def either(job: Job) -> Point:
    return stays(job) if job.folder else dies(job)


def test_a_process_that_is_killed_loses_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(local, "compute", either)
    jobs = [INERT._replace(key=str(i), folder="here") for i in range(4)]
    jobs.insert(1, INERT._replace(key="once", text=str(tmp_path / "killed")))
    jobs.insert(3, INERT._replace(key="always", text="always"))
    with closing(local.local(jobs, 2)) as found:
        became = {job.key: point for job, point in found}
    assert len(became) == 6
    assert {key for key, point in became.items() if point.outcome == DONE} == set("0123") | {"once"}
    assert became["always"].outcome == LOST
    assert "died 3 times" in became["always"].reason


def test_a_lost_point_is_computed_again_and_a_stopped_one_is_not(tmp_path):
    points.keep(tmp_path, INERT, Point(LOST, "killed"))
    assert points.kept(tmp_path, INERT) is None
    points.keep(tmp_path, INERT, Point(GIVEN_UP, "long"))
    assert points.kept(tmp_path, INERT) is None
    points.keep(tmp_path, INERT, Point(STOPPED, "at t = 1 s"))
    assert points.kept(tmp_path, INERT).reason == "at t = 1 s"


def test_a_file_that_is_not_whole_is_no_point(tmp_path):
    done = Point(DONE, "", 1.0, np.arange(3.0), {"a.b.c": np.arange(3.0) ** 2})
    file = points.keep(tmp_path, INERT, done)
    back = points.kept(tmp_path, INERT._replace(wanted=("a.b.c",)))
    assert back.courses["a.b.c"] == pytest.approx([0.0, 1.0, 4.0])
    assert points.kept(tmp_path, INERT._replace(wanted=("a.b.d",))) is None
    file.write_bytes(file.read_bytes()[:-40])
    assert points.kept(tmp_path, INERT) is None


# ---------------------------------------------------------------------- interrupt and resume


@pytest.mark.slow
def test_an_interrupt_keeps_what_is_done(case):
    """Ctrl-C after the first point of many: exit code 130, then --resume does the rest."""
    many = ", ".join(f'"{k} N/m"' for k in range(8, 20))
    file = case / "case.toml"
    file.write_text(CASE.replace('"8 N/m", "18 N/m", "32 N/m"', many).replace(
        "printed = [0.35, nan, 0.5]", "").replace('end = "1 s"', 'end = "20 s"'))  # fmt: skip
    given = [
        sys.executable,
        "-m",
        "coupling.cli",
        "sweep",
        str(case),
        "stiffness",
        "--workers",
        "2",
    ]
    run = subprocess.Popen(given, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    folder = case / "results" / "sweeps" / "stiffness" / "001"
    while not (folder / "points").exists() or not [*(folder / "points").glob("*.npz")]:
        assert run.poll() is None
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    said = run.communicate(timeout=60)[1]
    assert run.returncode == 130
    assert "--resume" in said
    there = {path.name: path.stat().st_mtime_ns for path in (folder / "points").glob("*.npz")}
    assert 0 < len(there) < 12
    again = subprocess.run([*given, "--resume"], env=ENVIRONMENT, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    assert f"{len(there)} of 12 points are there" in again.stdout
    for name, when in there.items():
        assert (folder / "points" / name).stat().st_mtime_ns == when
    assert {row["outcome"] for row in table(folder)} == {DONE}


@pytest.mark.slow
def test_two_workers_of_a_cluster_of_which_one_is_killed(case, tmp_path_factory):
    """All points are there, and the same as local processes compute them."""
    pytest.importorskip("distributed", reason="Dask is not installed: thermobody[cluster]")
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    many = ", ".join(f'"{k} N/m"' for k in range(8, 18))
    text = CASE.replace('"8 N/m", "18 N/m", "32 N/m"', many)
    text = text.replace("printed = [0.35, nan, 0.5]", "").replace('end = "1 s"', 'end = "20 s"')
    (case / "case.toml").write_text(text)
    address = elsewhere / "scheduler.json"
    started = [dask(elsewhere, "scheduler", "--port", "0", "--scheduler-file", str(address),
                    "--no-dashboard")]  # fmt: skip
    try:
        while not address.exists() or not address.read_text().strip():
            time.sleep(0.1)
        of_worker = ["worker", "--scheduler-file", str(address), "--nthreads", "1", "--no-nanny",
                     "--no-dashboard"]  # fmt: skip
        started += [dask(elsewhere, *of_worker) for _ in range(2)]
        where = json.loads(address.read_text())["address"]
        given = [sys.executable, "-m", "coupling.cli", "sweep", str(case), "stiffness",
                 "--scheduler", where]  # fmt: skip
        run = subprocess.Popen(given, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True)
        folder = case / "results" / "sweeps" / "stiffness" / "001"
        while len([*(folder / "points").glob("*.npz")]) < 3:
            assert run.poll() is None
            time.sleep(0.05)
        started[1].kill()
        said = run.communicate(timeout=300)[0]
    finally:
        for process in started:
            process.kill()
            process.wait()
    assert run.returncode == 0, said
    rows = table(folder)
    assert [row["outcome"] for row in rows] == [DONE] * 10
    here = sweeps.run(casefile.read(case), "stiffness", elsewhere / "here", workers=1)
    own = [float(row["place [m]"]) for row in rows]
    assert here.column("place") == pytest.approx(own, abs=1e-12)


def dask(folder: Path, *given: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    if given[0] == "worker":
        command = [sys.executable, "-m", "distributed.cli.dask_worker"]
    log = (folder / f"{given[0]}-{time.monotonic_ns()}.log").open("w")
    return subprocess.Popen(
        [*command, *given[1:]], cwd=folder, env=ENVIRONMENT, stdout=log, stderr=log
    )


# -------------------------------------------------------------------------------- what is said


def test_time_left_is_at_the_pace_so_far(monkeypatch):
    clock = iter([100.0, 104.0, 110.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    progress = Progress(None, "a", 10, 4)
    progress.told("one", Point(DONE, ""))
    assert progress.seconds_left() == pytest.approx(4.0 * 5)
    progress.told("two", Point(STOPPED, "why"))
    assert progress.seconds_left() == pytest.approx(10.0 / 2 * 4)
    assert progress.failed == 1


def test_columns_by_name_and_failures_in_words(case):
    scene = casefile.read(case)
    one = scene.sweep["stiffness"]
    done = Point(DONE, "", 1.0, np.arange(3.0), {
        "probe.weight.x": np.array([0.0, 2.0, 1.0]), "probe.weight.vx": np.zeros(3)})  # fmt: skip
    made = tabulated("stiffness", "", one, [done, Point(STOPPED, "why"), done])
    assert made.column("stiffness") == [8.0, 18.0, 32.0]
    assert made.column("place [m]")[::2] == [1.0, 1.0]
    assert made.failures == ["point 2 (stiffness 18 N/m): stopped: why"]
    with pytest.raises(KeyError):
        made.column("weight")


@pytest.mark.parametrize(
    ("measure", "value"),
    [("final", 1.0), ("max", 5.0), ("range", 6.0), ("amplitude", 3.0), ("mean", 7.0 / 3.0)],
)
def test_measures_after_a_time(case, measure, value):
    """Of 9, then 5, -1, 5, 1 from 1 s on."""
    one = casefile.read(case).sweep["stiffness"].quantity["place"]
    one = one.model_copy(update={"measure": measure, "after": 1.0})
    from coupling.sweeps.table import quantity

    course = {"probe.weight.x": np.array([9.0, 5.0, -1.0, 5.0, 1.0])}
    found = quantity("place", one, [Point(DONE, "", 0.0, np.arange(5.0), course)])
    assert found.values[0] == pytest.approx(value)
