"""The table of ``thermobody verify``: printed row by row as the problems finish."""

import time
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.text import Text

from coupling.errors import BadCase, Problem, unknown
from coupling.verify import registry
from coupling.verify.registry import Check, Convergence, Grid, Result

WIDTHS = (34, 24, 12, 9, 9)  # quantity, value with unit, reference, error, tolerance
GRID = (22, 8)  # name, numbers


def show(area: str | None, out: Console) -> bool:
    """Solve the problems of an area, or of all; True if all pass.

    Raises
    ------
    BadCase : there is no such area
    """
    names = (*registry.AREAS, *registry.GROUPS)
    if area is not None and area not in names:
        raise BadCase("verify", [Problem("", unknown("area", area, names))])
    started = time.perf_counter()
    out.print(Text(_columns("", "value", "reference", "error", "tolerance"), "bold"))
    passed = [_solve(problem, out) for problem in registry.problems(area)]
    _summary(passed, time.perf_counter() - started, out)
    return all(passed)


def _solve(problem: registry.Problem, out: Console) -> bool:
    """Solve one problem and print its rows; whatever it raises is a failure."""
    started = time.perf_counter()
    rows, reason = [], ""
    try:
        results: Sequence[Result] = problem.solve()
        rows = [(_shown(result), result.passed) for result in results]
        reason = "" if rows else "nothing was checked"
    except Exception as error:
        rows, reason = [], f"{type(error).__name__}: {error}"
    passed = bool(rows) and all(good for _, good in rows)
    title = Text(f"{problem.area}: {problem.name}", "bold")
    title.append(f"  ({problem.source})  {time.perf_counter() - started:.1f} s  ", "dim not bold")
    out.print(title.append(_verdict(passed)))
    for row, good in rows:
        out.print(Text(row).append("  ").append(_verdict(good)))
    if reason:
        out.print(Text(f"  {reason}", "red"))
    return passed


def _shown(result: Result) -> str:
    if isinstance(result, Grid):
        return _grid(result)
    return _row(result) if isinstance(result, Check) else _rows(result)


def _grid(grid: Grid) -> str:
    """Values row by row, the largest error at the end of each."""

    def line(name: str, cells: Sequence[str], last: str) -> str:
        return f"  {name:<{GRID[0]}}" + "".join(f"{cell:>{GRID[1]}}" for cell in (*cells, last))

    lines = [line(grid.name, grid.columns, "error")]
    for name, values, error in zip(grid.rows, np.asarray(grid.values), grid.errors, strict=True):
        lines.append(line(name, [f"{value:.4f}" for value in values], f"{error:.1e}"))
    return "\n".join([*lines, f"  {'tolerance':<{GRID[0]}}{grid.tolerance:.1e}"])


def _rows(found: Convergence) -> str:
    """Small table of sizes and errors; its last line is the order over all rows."""
    lines = [_columns(found.name, found.unit, "", "error", "order")]
    orders = ["", *(f"{order:.2f}" for order in found.orders)]
    for size, error, order in zip(found.sizes, found.errors, orders, strict=True):
        lines.append(_columns("", f"{size:g}", "", f"{error:.1e}", order))
    observed = f"{found.order:.2f}", f"{found.theory:g}", f"{found.order - found.theory:+.2f}"
    return "\n".join([*lines, _columns("  order", *observed, f"{found.tolerance:.2g}")])


def _row(check: Check) -> str:
    value = f"{check.value:.7g} {check.unit}".rstrip()
    tolerance = f"{check.tolerance:.1e}" + (" abs" if check.absolute else "")
    return _columns(check.name, value, f"{check.reference:.7g}", f"{check.error:.1e}", tolerance)


def _columns(name: str, *numbers: str) -> str:
    cells = [f"{n:>{w}}" for n, w in zip(numbers, WIDTHS[1:], strict=True)]
    return "  ".join([f"  {name:<{WIDTHS[0]}}", *cells])


def _verdict(passed: bool) -> Text:
    return Text("pass", "green") if passed else Text("FAIL", "bold red")


def _summary(passed: Sequence[bool], seconds: float, out: Console) -> None:
    failed = len(passed) - sum(passed)
    word = "all pass" if not failed else f"{failed} FAIL"
    style = "bold red" if failed else "bold green"
    many = "problem" if len(passed) == 1 else "problems"
    out.print(Text(f"{len(passed)} {many} in {seconds:.0f} s: {word}", style))
