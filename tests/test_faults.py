"""What can happen to a run from outside: killed, interrupted, no room on the disk, damaged files.

Nothing is lost but the window in progress, and the end is that of an undisturbed run, bit for bit.
"""

import errno
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from run_folders import assert_same, assert_same_results, consistent
from test_restart import killed_after
from typer.testing import CliRunner

from coupling import casefile, journal, locks, simulation
from coupling.cli import app
from coupling.errors import BadCase
from coupling.export import export
from coupling.plot import plot
from coupling.results import Recorder, Results
from coupling.simulation import Outcome

ROOT = Path(__file__).parent.parent
ARM = ROOT / "cases" / "arm_rotation"
SHORT = ("time.end=2", "body.arm.elements=4", "output.frames=7", "output.export=[]")
NOBODY = 65534

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and limits of POSIX")


def arm(*more):
    return casefile.read(ARM, [*SHORT, *more])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return simulation.run(arm(), tmp_path_factory.mktemp("whole"))


@pytest.fixture
def broken_off(tmp_path, monkeypatch):
    """Folder of runs; that in it was killed after 7 of 20 windows, 5 of them in the journal."""
    flushed = []

    def now_and_then(self):
        flushed.append(self)
        return 0.0 if len(flushed) == 2 else np.inf

    with monkeypatch.context() as patch:
        patch.setattr(Recorder, "patience", 0.0)
        patch.setattr(Recorder, "interval", property(now_and_then))
        killed_after(7, arm(), tmp_path, monkeypatch)
    with Results.open(tmp_path / "001", journal=False) as results:
        assert len(results["windows/time"]) == 2
    return tmp_path


class Child:
    """A forked process that runs something."""

    def __init__(self, work):
        self.pid = os.fork()
        if self.pid == 0:
            code = 1
            try:
                code = work()
            finally:
                os._exit(code)
        self.returncode = None

    def wait(self, delay=None):
        started = time.monotonic()
        while True:
            pid, status = os.waitpid(self.pid, os.WNOHANG if delay is not None else 0)
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
                return
            if time.monotonic() - started > delay:
                raise subprocess.TimeoutExpired("child", delay)
            time.sleep(1e-3)

    def kill(self):
        os.kill(self.pid, signal.SIGKILL)


def words_of(*words, settings=SHORT):
    """What is typed behind the name of the command."""
    return [*map(str, words), *(part for setting in settings for part in ("--set", setting))]


def command(*words):
    """Exit code of the command and what it said; a traceback is never the answer."""
    found = CliRunner().invoke(app, list(map(str, words)))
    assert found.exception is None or isinstance(found.exception, SystemExit), found.exception
    return found.exit_code, " ".join(found.output.split())


class Command(Child):
    """The command in a process of its own, which begins with something else."""

    def __init__(self, *words, begin=lambda: None):
        reading, self._writing = os.pipe()
        self._reading = reading

        def work():  # what is started in the background inherits that Ctrl-C is ignored
            signal.signal(signal.SIGINT, signal.default_int_handler)
            begin()
            code, said = command(*words)
            os.write(self._writing, said.encode()[-4000:])
            return code

        super().__init__(work)
        os.close(self._writing)

    def ended(self):
        """Exit code and what it said."""
        self.wait()
        with open(self._reading, encoding="utf-8") as file:
            return self.returncode, file.read()


# ------------------------------------------------------------------------------------- killed


def killed_again_and_again(begin, folder, moments):
    """Start, kill after the next of ``moments`` [s], resume, … until it ends.

    Number of kills, and what came out.
    """
    kills = 0
    for delay in moments:
        process = begin(resume=any(folder.glob("*/results.h5")))
        try:
            process.wait(delay)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            kills += 1
            for file in folder.glob("*/results.h5"):
                consistent(file.parent)
        else:
            assert process.returncode == 0
            return kills, Outcome(0, next(folder.glob("*/results.h5")).parent, "")
    raise AssertionError("it never ended")


def test_a_run_killed_again_and_again_ends_as_if_undisturbed(whole, tmp_path):
    """Six times or more, each life a little longer."""
    rng = np.random.default_rng()
    alone = time.monotonic()
    simulation.run(arm(), tmp_path / "alone")
    alone = time.monotonic() - alone
    moments = (part * alone * rng.uniform(0.7, 1.3) for part in np.linspace(0.05, 1.5, 40))
    folder = tmp_path / "killed"
    kills, outcome = killed_again_and_again(
        lambda resume: Child(lambda: simulation.run(arm(), folder, resume).code), folder, moments
    )
    assert kills >= 6
    assert_same_results(outcome, whole)
    assert sorted(p.name for p in outcome.folder.iterdir()) == ["probes.csv", "results.h5"]


KILLS = 50
LIVES = {
    "arm": ("arm_rotation", ("time.end=60", "body.arm.elements=4", "output.export=[]")),
    "hinge": ("single_hinge", ("time.window=0.5 ms", "output.export=[]")),
}
"""Cases of 600 windows; the hinge hits, rubs and warms its pin all the time."""


def process(words):
    words = [sys.executable, "-m", "coupling.cli", *words]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    quiet = subprocess.DEVNULL
    return subprocess.Popen(words, cwd=ROOT, stdout=quiet, stderr=quiet, env=environment)


def stamp(folder):
    """What changes when ``results.h5`` is written [ns]; None while there is none."""
    return next((file.stat().st_mtime_ns for file in folder.glob("*/results.h5")), None)


def is_under_way(folder, before):
    """Whether a life has written ``results.h5`` since it was so, and windows behind it."""
    written, head = stamp(folder), len(journal.FIRST) + 17
    if written in (None, before):
        return False
    try:
        found = [file.stat() for file in folder.glob("*/journal")]
    except FileNotFoundError:  # removed a moment ago
        return False
    return any(each.st_size > head and each.st_mtime_ns > written for each in found)


def windows_of(folder):
    """How many windows a run has, and its state and tables belong together."""
    (file,) = folder.glob("*/results.h5")
    return len(consistent(file.parent)[0].get("windows", {"time": []})["time"])


def killed_under_way(begin, folder, delay):
    """Kill a life so long after its first windows [s]; whether it was still alive."""
    before, life = stamp(folder), begin(folder)
    while life.poll() is None and not is_under_way(folder, before):
        time.sleep(1e-3)
    time.sleep(delay)
    life.kill()
    assert life.wait() in (0, -signal.SIGKILL)
    return life.returncode != 0


@pytest.mark.slow
@pytest.mark.parametrize("name", LIVES)
def test_fifty_kills_of_the_command(name, tmp_path):
    """Each at a random moment after the process has gone on: up to two windows later.

    Where one run is too short for all of them, another follows.
    """
    case, settings = LIVES[name]

    def begin(folder):
        more = ["--resume"] if stamp(folder) else []
        words = ("run", ROOT / "cases" / case, "--output", folder, *more)
        return process(words_of(*words, settings=settings))

    assert begin(tmp_path / "whole").wait() == 0
    whole = Outcome(0, tmp_path / "whole" / "001", "")
    clock = consistent(whole.folder)[0]["windows"]["wall_time"]
    window = float(np.median(np.diff(clock)))
    rng, started = np.random.default_rng(), time.monotonic()
    kills, runs, windows = 0, 1, 0
    while kills < KILLS:
        folder = tmp_path / f"killed{runs}"
        if killed_under_way(begin, folder, rng.uniform(0.0, 2.0 * window)):
            kills, before = kills + 1, windows
            windows = windows_of(folder)
            assert windows > before
        else:
            assert_same_results(Outcome(0, folder / "001", ""), whole)
            runs, windows = runs + 1, 0
    assert begin(folder).wait() == 0
    assert_same_results(Outcome(0, folder / "001", ""), whole)
    lasted = time.monotonic() - started
    print(f"{name}: {kills} kills in {runs} runs and {lasted:.0f} s, the last after {windows} of")
    print(f"{len(clock)} windows of {1e3 * window:.0f} ms")


def test_nothing_is_lost_but_the_window_in_progress(broken_off):
    """Every window that was finished is found, and reading changes nothing."""
    before = {p.name: p.read_bytes() for p in (broken_off / "001").iterdir()}
    groups, state, attributes = consistent(broken_off / "001")
    assert len(groups["windows"]["time"]) == 7 and attributes["outcome"] == "running"
    assert state["tick"] == 7 * simulation.TICKS
    assert {p.name: p.read_bytes() for p in (broken_off / "001").iterdir()} == before


@pytest.mark.slow
def test_a_killed_run_is_drawn_and_exported(broken_off):
    file = broken_off / "001" / "results.h5"
    assert all(path.is_file() for path in [*plot(file), *export(file)])
    for verb in ("plot", "export"):
        assert command(verb, broken_off)[0] == 0


def test_an_interrupted_command_ends_with_130_and_goes_on(whole, tmp_path):
    run = Command(*words_of("run", ARM, "--output", tmp_path))
    while not (tmp_path / "001" / "journal").exists():
        time.sleep(5e-3)
    os.kill(run.pid, signal.SIGINT)
    code, said = run.ended()
    assert code == 130 and "--resume goes on" in said
    assert consistent(tmp_path / "001")[2]["outcome"] == "stopped"
    assert command(*words_of("run", ARM, "--output", tmp_path, "--resume"))[0] == 0
    assert_same_results(Outcome(0, tmp_path / "001", ""), whole)


# ------------------------------------------------------------------------- no room, no permission


def limited(size):
    """No file may become larger than ``size`` bytes."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


@pytest.mark.parametrize("size", [0, 30_000, 140_000])
def test_without_room_the_command_says_so_and_goes_on_later(size, whole, tmp_path):
    """Nothing, the start, and some windows can be written."""
    run = Command(*words_of("run", ARM, "--output", tmp_path), begin=limited(size))
    code, said = run.ended()
    assert code == 3 and "results cannot be written" in said
    if not (tmp_path / "001" / "results.h5").exists():
        assert size == 0
        return
    windows = consistent(tmp_path / "001")[0].get("windows", {"time": []})["time"]
    assert len(windows) < 20 and (size < 100_000 or len(windows) > 0)
    assert simulation.run(arm(), tmp_path, resume=True).code == 0
    assert_same_results(Outcome(0, tmp_path / "001", ""), whole)


@pytest.mark.parametrize("call", [1, 2, 5, 12])
def test_a_full_disk_during_a_window_loses_that_window_only(call, whole, tmp_path, monkeypatch):
    calls, write = [], os.write

    def full(descriptor, data):
        calls.append(len(data))
        if len(calls) == call:
            return write(descriptor, data[: len(data) // 2])
        if len(calls) > call:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(descriptor, data)

    with monkeypatch.context() as patch, pytest.raises(OSError, match="No space"):
        patch.setattr(journal.os, "write", full)
        simulation.run(arm(), tmp_path)
    windows = consistent(tmp_path / "001")[0].get("windows", {"time": []})["time"]
    assert len(windows) == max(0, call - 2)  # the first call writes the name of the journal
    assert simulation.run(arm(), tmp_path, resume=True).code == 0
    assert_same_results(Outcome(0, tmp_path / "001", ""), whole)


def test_a_record_that_did_not_fit_does_not_hide_later_ones(tmp_path, monkeypatch):
    kept = journal.Journal(tmp_path, "name")
    kept.append({"rows": {}, "state": 1})
    with monkeypatch.context() as patch:
        patch.setattr(journal.os, "fsync", lambda descriptor: None)
        write, first = os.write, []

        def torn(descriptor, data):
            if first:
                raise OSError(errno.ENOSPC, "full")
            first.append(write(descriptor, data[:9]))
            return 9

        patch.setattr(journal.os, "write", torn)
        with pytest.raises(OSError):
            kept.append({"rows": {}, "state": 2})
    kept.append({"rows": {}, "state": 3})
    found, damage = journal.records(tmp_path, "name")
    assert [record["state"] for record in found] == [1, 3] and damage == ""


def without_rights():
    if os.getuid() == 0:
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)


@pytest.mark.parametrize("more", [[], ["--resume"]])
def test_a_folder_that_cannot_be_written_is_refused_at_once(more, broken_off):
    os.chmod(broken_off, 0o555)
    os.chmod(broken_off / "001", 0o555)
    for parent in list(broken_off.parents)[:3]:  # of pytest's own, closed to others
        os.chmod(parent, 0o755)
    words = words_of("run", ARM, "--output", broken_off, *more)
    code, said = Command(*words, begin=without_rights).ended()
    assert code == 2 and "results cannot go there" in said
    code, said = Command("export", broken_off, begin=without_rights).ended()
    assert code == 3 and "Permission denied" in said


# ---------------------------------------------------------------------------------- damaged files


def whole_records(data, end):
    """How many records lie before a place."""
    count, at = 0, data.index(b"\n", len(journal.FIRST)) + 1
    while True:
        at += journal.LENGTHS.size + sum(journal.LENGTHS.unpack_from(data, at)[:2])
        if at > end:
            return count
        count += 1


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_of_a_truncated_journal_the_whole_records_count(part, broken_off, whole):
    file = broken_off / "001" / "journal"
    data = file.read_bytes()
    file.write_bytes(data[: int(part * len(data))])
    windows = consistent(broken_off / "001")[0]["windows"]["time"]
    assert len(windows) == 2 + whole_records(data, part * len(data)) < 7
    assert simulation.run(arm(), broken_off, resume=True).code == 0
    assert_same_results(Outcome(0, broken_off / "001", ""), whole)


def test_a_damaged_journal_counts_up_to_there_and_is_told(broken_off, whole):
    file = broken_off / "001" / "journal"
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(bytes(data))
    count = whole_records(data, len(data) // 2)
    assert len(consistent(broken_off / "001")[0]["windows"]["time"]) == 2 + count
    code, said = command(*words_of("run", ARM, "--output", broken_off, "--resume"))
    assert code == 0 and f"journal: damaged after {count} windows" in said
    assert_same_results(Outcome(0, broken_off / "001", ""), whole)


def test_a_journal_of_another_file_means_nothing(broken_off):
    """As when the run was killed after results.h5 was written and before the journal was gone."""
    with Results.open(broken_off / "001", journal=False) as results:
        before = results.table("windows")
    file = broken_off / "001" / "results.h5"
    with h5py.File(file, "r+") as inside:
        inside.attrs["journal"] = "another"
    assert_same(consistent(broken_off / "001")[0]["windows"], before)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.999])
def test_a_truncated_results_file_is_refused(part, broken_off):
    file = broken_off / "001" / "results.h5"
    data = file.read_bytes()
    file.write_bytes(data[: int(part * len(data))])
    resumed = words_of("run", ARM, "--resume", "--output", broken_off)
    for words in (resumed, ["plot", broken_off], ["export", broken_off]):
        code, said = command(*words)
        assert code == 2 and "damaged" in said, words


def shorten(file, name):
    """An array loses its last number."""
    values = file[name][()]
    del file[name]
    file[name] = values[:-1]


OTHERS = {
    "version": (lambda file: file.attrs.update(format_version=0), "format version 0"),
    "older version": (lambda file: file.attrs.update(format_version=1), "format version 1, not 2"),
    "no field": (lambda file: file["state/coupled"].pop("released"), "differ: released"),
    "another field": (lambda file: file["state/coupled"].create_group("heats"), "differ: heats"),
    "no part": (lambda file: file["state/coupled"].pop("motion"), "differ: motion"),
    "no tick": (lambda file: file["state"].pop("tick"), "its state is of another version"),
    "size": (lambda file: shorten(file, "state/coupled/motion/motion/q"), "an array (59,)"),
    "no column": (lambda file: file["windows"].pop("exchanges"), "windows: a row needs"),
    "another column": (lambda file: file["ledger"].move("damping", "loss"), "ledger: a row needs"),
    "other places": (lambda file: file["probes/tip"].pop("velocity"), "probes/tip: a row needs"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_runs_of_other_versions_are_not_resumed(name, broken_off):
    """Nor is anything lost of them."""
    change, text = OTHERS[name]
    (broken_off / "001" / "journal").unlink()
    with h5py.File(broken_off / "001" / "results.h5", "r+") as file:
        change(file)
        before = file["windows/time"][()]
    code, said = command(*words_of("run", ARM, "--output", broken_off, "--resume"))
    assert code == 2 and text in said and "leave out --resume" in said
    with h5py.File(broken_off / "001" / "results.h5") as file:
        assert_same(file["windows/time"][()], before)
    assert sorted(p.name for p in (broken_off / "001").iterdir()) == ["results.h5"]


def test_runs_of_the_version_before_are_read(broken_off):
    (broken_off / "001" / "journal").unlink()
    with h5py.File(broken_off / "001" / "results.h5", "r+") as file:
        file.attrs.update(format_version=1)
    assert command("export", broken_off)[0] == 0


def test_another_case_is_refused_with_the_tables_that_differ(broken_off):
    settings = (*SHORT, "body.arm.elements=6")
    words = words_of("run", ARM, "--resume", "--output", broken_off, settings=settings)
    code, said = command(*words)
    assert code == 2 and "body: is not what the run to resume was started with" in said
    assert len(consistent(broken_off / "001")[0]["windows"]["time"]) == 7


# --------------------------------------------------------------------------------- one at a time


def test_a_run_in_progress_is_not_resumed(broken_off, whole):
    with locks.holding(broken_off / "001"):
        code, said = command(*words_of("run", ARM, "--output", broken_off, "--resume"))
        assert code == 2 and f"is being computed by process {os.getpid()} on " in said
        with pytest.raises(BadCase, match="is being computed"):
            simulation.run(arm(), broken_off, resume=True)
    assert simulation.run(arm(), broken_off, resume=True).code == 0
    assert_same_results(Outcome(0, broken_off / "001", ""), whole)


def test_the_lock_of_a_dead_process_keeps_nobody_out(broken_off):
    (broken_off / "001" / "lock").write_text("process 1 on this computer\n")
    assert simulation.run(arm(), broken_off, resume=True).code == 0
    assert not (broken_off / "001" / "lock").exists()


def test_of_many_that_want_a_folder_one_has_it_at_a_time(tmp_path):
    """They count up in a file, which fails if two are at it."""
    (tmp_path / "count").write_text("0")

    def count():
        done = 0
        while done < 20:
            try:
                with locks.holding(tmp_path):
                    number = int((tmp_path / "count").read_text())
                    time.sleep(1e-4)
                    (tmp_path / "count").write_text(str(number + 1))
                    done += 1
            except BadCase:
                time.sleep(1e-4)
        return 0

    children = [Child(count) for _ in range(4)]
    for child in children:
        child.wait()
    assert [child.returncode for child in children] == [0] * 4
    assert (tmp_path / "count").read_text() == "80"


def test_two_commands_at_the_same_time_have_folders_of_their_own(tmp_path, whole):
    both = [Command(*words_of("run", ARM, "--output", tmp_path)) for _ in range(2)]
    assert [run.ended()[0] for run in both] == [0, 0]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["001", "002"]
    for name in ("001", "002"):
        assert_same_results(Outcome(0, tmp_path / name, ""), whole)


# --------------------------------------------------------------------------- written when it ends


def test_an_interrupted_export_is_made_good_by_the_next(whole, tmp_path, monkeypatch):
    from coupling import export as module

    file = tmp_path / "results.h5"
    file.write_bytes((whole.folder / "results.h5").read_bytes())
    expected = {path.name: path.read_bytes() for path in export(file)}
    written, write = [], module._write

    def until(*arguments):
        written.append(write(*arguments))
        if len(written) == 3:
            written[-1].write_bytes(written[-1].read_bytes()[:100])
            raise KeyboardInterrupt
        return written[-1]

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(module, "_write", until)
        export(file)
    assert {path.name: path.read_bytes() for path in export(file)} == expected


def test_a_finished_run_resumed_is_finished(tmp_path, whole):
    simulation.run(arm(), tmp_path)
    code, said = command(*words_of("run", ARM, "--output", tmp_path, "--resume"))
    assert code == 0 and str(tmp_path / "001") in said
    assert_same_results(Outcome(0, tmp_path / "001", ""), whole)
