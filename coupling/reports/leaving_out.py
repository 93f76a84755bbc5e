"""What scenes do not pay for: imports, machine code and memory of each case; the coupled command
against the bare mechanics module."""

import ast
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

from coupling.casefile import FILE_NAME
from coupling.reports.leaving_out_probe import HEAVY, PACKAGES, WINDOWS
from coupling.reports.registry import Curve, Picture, Result

ROOT = Path(__file__).parents[2]
PROBE = "coupling.reports.leaving_out_probe"
MECHANICS_ONLY = ("slider_crank", "slider_crank_guide")
"""Cases without heat, for the price of the coupled command."""
SETTINGS: tuple[list[str], ...] = ([], ["time.window='10 ms'", "time.end='240 ms'"])
"""As it is shipped: a window of 10 us, for a row of the probes each; a longer run."""
PAIRS = 5
"""Times that both are run, one after the other."""
COMPILED = ("njit", "cfunc", "kernel")
"""Decorators of functions that become machine code."""


def report(cases: Path = Path("cases")) -> Iterator[Result]:
    """Both tables: the cases in a folder, and what the coupled command costs."""
    yield _cases(cases)
    yield _command(cases)


# ------------------------------------------------------------------------------------- cases


def _cases(cases: Path) -> Result:
    modules, functions = _whole()
    rows = [_row(file.parent, modules, functions) for file in sorted(cases.glob(f"*/{FILE_NAME}"))]
    columns = (
        "case", "modules of ours", "of all [%]", "libraries of " + str(len(HEAVY)),
        "functions compiled", "of all [%]", "compiling, once [CPU s]", "then ready in [CPU s]",
        "allocated at most [MB]", "process [MB]",
    )  # fmt: skip
    notes = [
        f"The program has {modules} modules and {functions} functions that can become machine "
        "code. Compiled once per machine, then taken from disk.",
        f"Ready: imported, read, built, and {WINDOWS} coupling windows done, or statics or modes. "
        "Allocated: the most that Python and numpy held at once.",
        f"Libraries that a case may leave out: {', '.join(HEAVY)}.",
    ]
    bars = [
        Curve("functions compiled", range(len(rows)), [float(r[5]) for r in rows], "o"),
        Curve("modules imported", range(len(rows)), [float(r[2]) for r in rows], "s"),
    ]
    names = ", ".join(f"{i} {row[0]}" for i, row in enumerate(rows))
    picture = Picture(f"case: {names}", "part of the program [%]", bars, "")
    return Result("leaving_out_cases", "What each case takes of the program", columns, rows, notes,
                  [picture])  # fmt: skip


def _row(case: Path, modules: int, functions: int) -> tuple[Any, ...]:
    with TemporaryDirectory() as empty:
        cold = _probed(case, "plain", NUMBA_CACHE_DIR=empty)
        warm = _probed(case, "plain", NUMBA_CACHE_DIR=empty)
        traced = _probed(case, "traced", NUMBA_CACHE_DIR=empty)
    libraries = ", ".join(warm["libraries"]) or "none"
    return (
        case.name, warm["modules"], 100.0 * warm["modules"] / modules, libraries,
        cold["kernels"], 100.0 * cold["kernels"] / functions, cold["compiling"],
        warm["seconds"], traced["allocated"] / 1e6, warm["resident"] / 1e6,
    )  # fmt: skip


def _probed(case: Path, how: str, **environment: str) -> dict[str, Any]:
    """What the probe says of a case."""
    done = subprocess.run(
        [sys.executable, "-m", PROBE, str(case.resolve()), how],
        cwd=ROOT, env=os.environ | environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(done.stdout.splitlines()[-1])


def _whole() -> tuple[int, int]:
    """Modules of the program, and functions in them that can become machine code."""
    files = [f for package in PACKAGES for f in (ROOT / package).rglob("*.py")]
    return len(files), sum(_compiled(ast.parse(f.read_text(encoding="utf-8"))) for f in files)


def _compiled(tree: ast.Module) -> int:
    return sum(
        isinstance(node, ast.FunctionDef) and any(map(_compiles, node.decorator_list))
        for node in ast.walk(tree)
    )


def _compiles(decorator: ast.expr) -> bool:
    named = decorator.func if isinstance(decorator, ast.Call) else decorator
    return isinstance(named, ast.Name) and named.id in COMPILED


# ------------------------------------------------------------------------------- the command


def _command(cases: Path) -> Result:
    rows = [
        row for name in MECHANICS_ONLY for made in SETTINGS for row in _prices(cases / name, made)
    ]
    columns = (
        "case", "window [ms]", "windows", "what", "CPU time, least [s]",
        "over bare, median of pairs [%]", "of each window [ms]",
    )  # fmt: skip
    notes = [
        "Each builds its model. Bare: the mechanics module steps through the windows. Windows: by "
        "the coupling manager, nothing recorded. Command: what thermobody run does, histories, "
        "frames, checkpoints and all, without pictures.",
        f"{PAIRS} times one after the other in one process; processor time.",
    ]
    return Result("leaving_out_command", "What the coupled command costs a scene without heat",
                  columns, rows, notes)  # fmt: skip


def _prices(case: Path, made: list[str]) -> list[tuple[Any, ...]]:
    """A row for each way of running a case."""
    from coupling import casefile

    scene = casefile.read(case, made)
    count = scene.time.windows
    with TemporaryDirectory() as folder:
        times = _times(scene, Path(folder))
    return [
        (case.name, 1e3 * scene.time.window, count, name, min(t[name] for t in times),
         100.0 * (median(t[name] / t["bare"] for t in times) - 1.0),
         1e3 * median(t[name] - t["bare"] for t in times) / count)
        for name in times[0]
    ]  # fmt: skip


def _times(scene: Any, folder: Path) -> list[dict[str, float]]:
    """Processor times [s] of each way, one after the other, several times."""
    from coupling.model import build

    works: dict[str, Callable[[], None]] = {
        "bare": lambda: _bare(build(scene)),
        "windows": lambda: _windows(build(scene)),
        "command": lambda: _recorded(scene, folder),
    }
    for work in works.values():
        work()
    return [{name: _cpu(work) for name, work in works.items()} for _ in range(PAIRS)]


def _cpu(work: Callable[[], None]) -> float:
    begun = process_time()
    work()
    return process_time() - begun


def _bare(model: Any) -> None:
    """The windows of a model by its mechanics alone."""
    solver, state = model.motion_solver, model.initial()
    motion, T = state.motion, model.sections(state)
    for _ in range(model.windows):
        motion, _, why = solver.advance(motion, model.window, T, T)
        assert not why, why


def _windows(model: Any) -> None:
    from coupling.simulation import Done, windows

    for window in windows(model, model.initial()):
        assert isinstance(window, Done), window


def _recorded(scene: Any, folder: Path) -> None:
    from coupling import simulation

    assert simulation.run(scene, folder).code == 0
