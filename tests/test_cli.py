import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from coupling import simulation
from coupling.cli import app
from coupling.simulation import Outcome
from coupling.verify import registry
from coupling.verify.registry import Check

CASE = """
title = "a falling ball"
[time]
end = 1
window = 0.25
[body.ball]
kind = "particle"
position = [0, 0, 0]
mass = 1
[gravity]
acceleration = [0, 0, -9.81]
[output]
export = ["vtk", "pictures"]
"""

COMMANDS = ["run", "check", "plan", "schema", "export", "plot", "list", "verify"]


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.fixture
def case(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path


@pytest.fixture
def writers(monkeypatch):
    """Stand-ins for what writes pictures and VTK files; the list of what they were asked."""
    asked = []

    def writer(name):
        def write(results, *format):
            asked.append((name, Path(results), *format))
            return [Path(results).with_name(name)]

        return write

    for name in ("export", "plot"):
        module = SimpleNamespace(**{name: writer(name)})
        monkeypatch.setitem(sys.modules, f"coupling.{name}", module)
    return asked


def outcome(monkeypatch, result):
    """Let every run end in ``result`` without computing; what it was called with."""
    calls = []

    def fake(scene, folder, resume, console):
        calls.append(SimpleNamespace(scene=scene, folder=folder, resume=resume))
        if isinstance(result, BaseException):
            raise result
        return result

    monkeypatch.setattr(simulation, "run", fake)
    return calls


# ----------------------------------------------------------------------------------- help


@pytest.mark.parametrize("command", COMMANDS)
def test_help_says_what_a_command_is_for_and_shows_an_example(command):
    result = run(command, "--help")
    assert result.exit_code == 0
    assert f"Example:  thermobody {command}" in result.output
    assert len(result.output.split()) > 25


def test_help_names_every_command_and_the_exit_codes():
    output = run("--help").output
    assert all(re.search(rf"\b{command}\b", output) for command in COMMANDS)
    assert "0 done, 1 a verification failed, 2 something is wrong" in output


def test_help_imports_nothing_heavy():
    code = (
        "import sys; sys.argv = ['thermobody', '--help']\n"
        "try:\n import coupling.cli; coupling.cli.main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'numba', 'pydantic', 'pint', 'h5py', 'skfem', 'matplotlib'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_usage_errors_are_bad_input():
    for arguments in (["rum"], ["run"], ["run", "x", "--foo"], ["export", "x", "--format", "xdmf"]):
        assert run(*arguments).exit_code == 2


def test_version():
    result = run("--version")
    assert result.exit_code == 0
    assert result.output.startswith("thermobody")


# ------------------------------------------------------------------------------------ run


def test_a_finished_run_writes_what_the_case_asks_for(case, monkeypatch, writers):
    folder = case / "results" / "001"
    calls = outcome(monkeypatch, Outcome(0, folder, ""))
    result = run("run", case, "--set", "time.end=2")
    assert result.exit_code == 0
    assert (calls[0].scene.time.end, calls[0].folder, calls[0].resume) == (
        2.0,
        case / "results",
        False,
    )
    assert writers == [
        ("export", folder / "results.h5", "pvd"),
        ("plot", folder / "results.h5"),
    ]
    assert f"results in {folder}" in result.output


def test_output_and_resume_are_passed_on(case, monkeypatch, writers, tmp_path):
    calls = outcome(monkeypatch, Outcome(0, tmp_path / "runs" / "001", ""))
    run("run", case / "case.toml", "--output", tmp_path / "runs", "--resume")
    assert (calls[0].folder, calls[0].resume) == (tmp_path / "runs", True)


def test_nothing_is_exported_unless_asked_for(case, monkeypatch, writers):
    outcome(monkeypatch, Outcome(0, case / "results" / "001", ""))
    assert run("run", case, "--set", "output.export=[]").exit_code == 0
    assert writers == []


def test_a_stopped_run_says_why(case, monkeypatch, writers):
    reason = "stopped at t = 0.3 s: joint hinge: no convergence"
    outcome(monkeypatch, Outcome(3, case / "results" / "001", reason))
    result = run("run", case)
    assert result.exit_code == 3
    assert reason in result.output
    assert len(writers) == 2  # what there is can be looked at


def test_an_interrupted_run_keeps_its_results(case, monkeypatch, writers):
    outcome(monkeypatch, KeyboardInterrupt())
    result = run("run", case)
    assert result.exit_code == 130
    assert "interrupted" in result.output and "--resume" in result.output
    assert writers == []


def test_a_full_disk_stops_a_run(case, monkeypatch, writers):
    outcome(monkeypatch, OSError(28, "No space left on device"))
    result = run("run", case)
    assert result.exit_code == 3
    assert "No space left on device" in result.output


def test_nothing_to_resume_is_bad_input(case):
    result = run("run", case, "--resume")
    assert result.exit_code == 2
    assert "no run to resume" in result.output


def test_a_bug_is_not_taken_for_bad_input(case, monkeypatch, writers):
    outcome(monkeypatch, ZeroDivisionError("a bug"))
    assert isinstance(run("run", case).exception, ZeroDivisionError)


# ------------------------------------------------------------------------- check and plan


def test_check_and_plan(case):
    checked = run("check", case)
    assert checked.exit_code == 0
    assert checked.output == f"{case}: ok: 1 body, 0 joints, 0 loads, no heat, 4 windows\n"
    planned = run("plan", case)
    assert planned.exit_code == 0
    assert "a falling ball" in planned.output and "left out" in planned.output
    assert list(case.iterdir()) == [case / "case.toml"]


def test_what_building_refuses_is_bad_input(case):
    """A cable has only its tangent, so it cannot hold a slanting axis: seen when built."""
    (case / "case.toml").write_text(
        CASE + '[section.s]\nkind = "circle"\nradius = 0.01\n[body.rope]\nkind = "cable"\n'
        'start = [0, 0, 0]\nend = [1, 0, 0]\nelements = 2\nsection = "s"\nmaterial = "invar"\n'
        '[joint.j]\nkind = "revolute"\na = { body = "rope", at = "start" }\naxis = [1, 1, 0]\n'
    )
    for command in ("check", "plan", "run"):
        result = run(command, case)
        assert result.exit_code == 2, result.output
        assert "joint 'j'" in result.output
    assert list(case.iterdir()) == [case / "case.toml"]


# -------------------------------------------------------------------------------- results


def test_results_are_found_by_file_run_or_case(case, writers):
    for name in ("001", "002", "010"):
        (case / "results" / name).mkdir(parents=True)
        (case / "results" / name / "results.h5").write_bytes(b"")
    newest = case / "results" / "010" / "results.h5"
    first = case / "results" / "001"
    for path, found in (
        (case, newest),
        (case / "case.toml", newest),
        (case / "results", newest),
        (first, first / "results.h5"),
        (first / "results.h5", first / "results.h5"),
    ):
        assert run("plot", path).exit_code == 0
        assert writers.pop() == ("plot", found)
    assert run("export", first, "--format", "vtkhdf").output == f"wrote {first / 'export'}\n"
    assert writers.pop() == ("export", first / "results.h5", "vtkhdf")


def test_no_results_are_bad_input(case, writers):
    for command in ("plot", "export"):
        for path in (case, case / "nothing", case / "case.toml"):
            result = run(command, path)
            assert result.exit_code == 2
            assert "no results there" in result.output
    assert writers == []


# ------------------------------------------------------------------------ list and verify


def test_list_shows_cases_and_all_that_a_case_may_name(case, monkeypatch):
    monkeypatch.chdir(case)
    (case / "cases" / "ball").mkdir(parents=True)
    (case / "cases" / "ball" / "case.toml").write_text(CASE)
    (case / "cases" / "torn").mkdir()
    (case / "cases" / "torn" / "case.toml").write_text("[")
    result = run("list")
    assert result.exit_code == 0
    for words in (
        "cases/ball  a falling ball",
        "cases/torn  (cannot be read",
        "al6061-paper    73.15 K to 473.15 K",
        "prescribed  walls and fields give all temperatures",
        "dynamics, statics, modes",
        "clearance_revolute",
        "lankarani-nikravesh",
        "hertz-internal",
        "thermoelastic",
    ):
        assert words in result.output, words


def verification(monkeypatch, **solutions):
    problems = [registry.Problem("heat", n, "a book", solve) for n, solve in solutions.items()]
    monkeypatch.setattr(registry, "problems", lambda area: problems)
    return run("verify", "heat")


def good():
    return [Check("tip", 1.0001, 1.0, 1e-3, "m"), Check("slope", 0.0, 0.0, 1e-9, absolute=True)]


def poor():
    return [Check("tip", 1.0, 1.0, 1e-3), Check("period", 2.2, 2.0, 0.05, "s")]


def raising():
    raise RuntimeError("did not converge")


def test_verify_prints_a_row_for_each_quantity(monkeypatch):
    result = verification(monkeypatch, slab=good)
    assert result.exit_code == 0
    assert "heat: slab  (a book)" in result.output
    row = next(line for line in result.output.splitlines() if line.startswith("  tip"))
    assert row.split() == ["tip", "1.0001", "m", "1", "1.0e-04", "1.0e-03", "pass"]
    assert "1 problems" not in result.output
    assert "1 problem in 0 s: all pass" in result.output


@pytest.mark.parametrize(
    ("solve", "words"),
    [
        (poor, r"period .*2\.2 s .*1\.0e-01 .*FAIL"),
        (raising, "RuntimeError: did not converge"),
        (lambda: [], "nothing was checked"),
        (lambda: [Check("x", float("nan"), 1.0, 1.0)], r"x +nan .*FAIL"),
        (lambda: [Check("x", 1.0, 0.0, 1.0)], r"x +1 +0 +inf .*FAIL"),
    ],
)
def test_verify_fails_when_a_problem_does(monkeypatch, solve, words):
    result = verification(monkeypatch, sound=good, other=solve)
    assert result.exit_code == 1
    assert re.search(words, result.output), result.output
    assert "2 problems in 0 s: 1 FAIL" in result.output


def test_verify_of_an_unknown_area_is_bad_input():
    result = run("verify", "haet")
    assert result.exit_code == 2
    assert "there is no area 'haet'; did you mean 'heat'?" in result.output


def test_output_is_plain_when_piped(case):
    for arguments in (["list"], ["check", case], ["verify", "nothing"]):
        assert "\x1b" not in run(*arguments).output
