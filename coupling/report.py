"""``thermobody report``: measures, prints tables, writes them as CSV and Markdown, draws them."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from coupling.errors import BadCase, Problem, unknown
from coupling.reports.maps import Map, draw_map
from coupling.reports.registry import (
    OF_A_CASE,
    OF_MANY_SIZES,
    OWN,
    Picture,
    Result,
    load,
    reports_of,
)
from coupling.scene import Scene

PAPER = "paper"
"""What stands for the report on the source of the project."""


def report(
    what: str,
    name: str | None,
    folder: Path,
    out: Console,
    large: bool = False,
    settings: Sequence[str] = (),
    wanted: float | None = None,
    variants: Sequence[str] = (),
) -> list[Path]:
    """Make the reports of a case, or of a model of the program's own; the files that were written.

    Parameters
    ----------
    what : in ``OWN``, or a case
    name : of the report; None: all that there are for it
    large : sizes that take minutes too
    settings : changed entries of the case, such as ``time.end=20 s``
    wanted : error under which the cheapest setting is sought; None: as the case says
    variants : names of [variant.NAME] of the case, whose changes come before the settings

    Raises
    ------
    BadCase : the case is faulty, or there is no such report
    """
    if what == PAPER:
        from coupling.paper.document import report as paper

        return paper(name, folder, out, large)
    if what in OWN:
        made = _results(what, _chosen(what, name, ()), large)
    else:
        from coupling.casefile import read

        if not Path(what).exists():
            _chosen(what, name, ())
        made = _of_case(read(what, settings, variants), what, name, out, wanted)
    return [file for result in made for file in publish(result, folder, out)]


def publish(result: Result, folder: Path, out: Console) -> list[Path]:
    """Print a result and write its table, its words and its pictures; the files."""
    _show(out, result)
    return _written(folder, result)


def _of_case(
    scene: Scene, what: str, name: str | None, out: Console, wanted: float | None
) -> Iterator[Result]:
    """The reports of a case: those of every case, then its own."""
    for one in _chosen(what, name, tuple(scene.report)):
        if one in OF_A_CASE:
            yield from load(what, one)(*_system_of(scene))
        else:
            from coupling.reports.error_time import report as error_time

            yield from error_time(scene, one, out, wanted)


def _chosen(what: str, name: str | None, own: Sequence[str]) -> Sequence[str]:
    there = (*reports_of(what), *own)
    if name is None:
        return there
    if name in there:
        return (name,)
    owner = next((owner for owner, names in OWN.items() if name in names), None)
    if owner is None:
        known = dict.fromkeys([*own, *(known for names in OWN.values() for known in names)])
        raise BadCase("report", [Problem("", unknown("report", name, known))])
    text = f"'{name}' measures models of its own: thermobody report {owner} {name}"
    raise BadCase("report", [Problem("", text)])


def _results(what: str, names: Sequence[str], large: bool) -> Iterator[Result]:
    for name in names:
        make = load(what, name)
        if what == "ring_truss" and name in OF_A_CASE:
            from coupling.reports.rings import STEP, ring

            yield from make(ring(), STEP)
        else:
            yield from make(*([large] if (what, name) in OF_MANY_SIZES else []))


def _system_of(scene: Scene) -> tuple[Any, float]:
    """The system to measure, and the step [s]."""
    from coupling.model import build

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
        files.append(drawn(folder / f"{result.name}.png", result.title, result.pictures))
    return files


def _markdown(result: Result) -> str:
    lines = [f"# {result.title}", "", "| " + " | ".join(result.columns) + " |"]
    lines.append("|" + "---|" * len(result.columns))
    lines += ["| " + " | ".join(map(_cell, row)) + " |" for row in result.rows]
    return "\n".join([*lines, "", *(f"{note}  " for note in result.notes)]) + "\n"


def drawn(path: Path, title: str, pictures: Sequence[Picture | Map]) -> Path:
    """Draw pictures one below the other."""
    import matplotlib
    from matplotlib.figure import Figure

    from coupling.plot import STYLE

    with matplotlib.rc_context(STYLE):
        size = (9.0, max(6.0, 3.2 * len(pictures)))
        figure = Figure(figsize=size, dpi=150, layout="constrained")
        panels = figure.subplots(len(pictures), squeeze=False)[:, 0]
        for ax, picture in zip(panels, pictures, strict=True):
            if isinstance(picture, Map):
                draw_map(ax, picture)
            else:
                _draw(ax, picture)
        figure.suptitle(title, x=0.01, ha="left", weight="bold")
        figure.savefig(path)
    return path


def _draw(ax: Any, picture: Picture) -> None:
    for curve, marker in zip(picture.curves, "osD^v<>phX*+" * 3, strict=False):
        style = curve.style or f"-{marker}"
        ax.plot(curve.x, curve.y, style, label=curve.label, ms=5)
        for x, y, name in zip(curve.x, curve.y, curve.names, strict=False):
            ax.annotate(name, (x, y), (4, 4), textcoords="offset points", fontsize=6)
    for name in picture.logarithmic:
        ax.set(**{f"{name}scale": "log"})
    ax.set_xlabel(picture.x)
    ax.set_ylabel(picture.y)
    ax.grid(which="minor", lw=0.3)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
