"""``thermobody report``: measures, prints tables, writes them as CSV and Markdown, draws them."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from coupling.errors import BadCase, Problem, unknown
from coupling.reports.registry import (
    OF_A_CASE,
    OF_MANY_SIZES,
    OWN,
    Picture,
    Result,
    load,
    reports_of,
)


def report(
    what: str, name: str | None, folder: Path, out: Console, large: bool = False
) -> list[Path]:
    """Make the reports of a case, or of a model of the program's own; the files that were written.

    Parameters
    ----------
    what : in ``OWN``, or a case
    name : of the report; None: all that there are for it
    large : sizes that take minutes too

    Raises
    ------
    BadCase : the case is faulty, or there is no such report
    """
    files: list[Path] = []
    for result in _results(what, _chosen(what, name), large):
        files += publish(result, folder, out)
    return files


def publish(result: Result, folder: Path, out: Console) -> list[Path]:
    """Print a result and write its table, its words and its pictures; the files."""
    _show(out, result)
    return _written(folder, result)


def _chosen(what: str, name: str | None) -> Sequence[str]:
    there = reports_of(what)
    if name is None:
        return there
    if name in there:
        return (name,)
    owner = next((owner for owner, names in OWN.items() if name in names), None)
    if owner is None:
        known = dict.fromkeys(known for names in OWN.values() for known in names)
        raise BadCase("report", [Problem("", unknown("report", name, known))])
    text = f"'{name}' measures models of its own: thermobody report {owner} {name}"
    raise BadCase("report", [Problem("", text)])


def _results(what: str, names: Sequence[str], large: bool) -> Iterator[Result]:
    system = None
    for name in names:
        make = load(what, name)
        if what in OWN and (what, name) not in _measured(what):
            yield from make(*([large] if (what, name) in OF_MANY_SIZES else []))
            continue
        system = system or _system(what)
        yield from make(*system)


def _measured(what: str) -> set[tuple[str, str]]:
    """Reports of a model that measure its system as they would that of a case."""
    return {(what, name) for name in OF_A_CASE} if what == "ring_truss" else set()


def _system(what: str) -> tuple[Any, float]:
    """The system to measure, and the step [s]."""
    if what == "ring_truss":
        from coupling.reports.rings import STEP, ring

        return ring(), STEP
    from coupling.casefile import read
    from coupling.model import build

    scene = read(what)
    return build(scene).motion_solver.system, scene.integrator.largest_step or scene.time.window


# ------------------------------------------------------------------------------------ output


def _cell(value: str | float | int) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _show(out: Console, result: Result) -> None:
    rows = [result.columns, *(tuple(map(_cell, row)) for row in result.rows)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(result.columns))]
    out.print(result.title, style="bold", markup=False)
    for row in rows:
        line = "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        out.print(f"  {line}".rstrip(), markup=False)
    for note in result.notes:
        out.print(f"  {note}", markup=False)
    out.print()


def _written(folder: Path, result: Result) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    table, text = folder / f"{result.name}.csv", folder / f"{result.name}.md"
    with table.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([result.columns, *result.rows])
    text.write_text(_markdown(result), encoding="utf-8")
    files = [table, text]
    if result.pictures:
        files.append(_drawn(folder / f"{result.name}.png", result.title, result.pictures))
    return files


def _markdown(result: Result) -> str:
    lines = [f"# {result.title}", "", "| " + " | ".join(result.columns) + " |"]
    lines.append("|" + "---|" * len(result.columns))
    lines += ["| " + " | ".join(map(_cell, row)) + " |" for row in result.rows]
    return "\n".join([*lines, "", *(f"{note}  " for note in result.notes)]) + "\n"


def _drawn(path: Path, title: str, pictures: Sequence[Picture]) -> Path:
    import matplotlib
    from matplotlib.figure import Figure

    from coupling.plot import STYLE

    with matplotlib.rc_context(STYLE):
        size = (9.0, max(6.0, 3.2 * len(pictures)))
        figure = Figure(figsize=size, dpi=150, layout="constrained")
        panels = figure.subplots(len(pictures), squeeze=False)[:, 0]
        for ax, picture in zip(panels, pictures, strict=True):
            _draw(ax, picture)
        figure.suptitle(title, x=0.01, ha="left", weight="bold")
        figure.savefig(path)
    return path


def _draw(ax: Any, picture: Picture) -> None:
    for curve, marker in zip(picture.curves, "osD^v<>phX*+" * 3, strict=False):
        style = curve.style or f"-{marker}"
        ax.plot(curve.x, curve.y, style, label=curve.label, ms=5)
    for name in picture.logarithmic:
        ax.set(**{f"{name}scale": "log"})
    ax.set_xlabel(picture.x)
    ax.set_ylabel(picture.y)
    ax.grid(which="minor", lw=0.3)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
