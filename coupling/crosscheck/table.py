"""The comparison as tables: on the terminal, as CSV and as Markdown."""

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text

from coupling.crosscheck.comparison import ANCF, CONTINUUM, EXACT, OUTSIDE, Comparison, Row
from coupling.crosscheck.measured import Measured
from coupling.crosscheck.solved import asked

TARGET = 100.0
"""Times less that beams are to take than a converged continuum, which is what they are for."""


def show(result: Comparison, out: Console) -> None:
    """Print what deviates how far, then what it costs."""
    for grid in (_quantities(result), _costs(result)):
        _print(out, grid)
    for note in notes(result):
        out.print(note, markup=False)


def _print(out: Console, grid: Grid) -> None:
    """As wide as it is: numbers that wrap or are cut cannot be read."""
    from rich.measure import Measurement

    wide = out.options.update(max_width=1000)
    width = Measurement.get(out, wide, grid).maximum
    Console(file=out.file, width=width, no_color=out.no_color).print(grid)


def participants(result: Comparison) -> list[str]:
    """In the order of the columns."""
    there = {name for row in result.rows for name in row.values}
    return [name for name in (CONTINUUM, ANCF, *OUTSIDE, EXACT) if name in there]


def _quantities(result: Comparison) -> Grid:
    names = participants(result)
    grid = Grid(title=f"Cross-check: {_title(result)}", title_justify="left", title_style="bold")
    grid.add_column("stage")
    grid.add_column("quantity")
    grid.add_column("unit")
    for name in names:
        grid.add_column(name, justify="right")
    for name in (n for n in names if n != CONTINUUM):
        grid.add_column(f"{name} off", justify="right")
    grid.add_column("allowed", justify="right")
    grid.add_column("continuum ±", justify="right")
    before = ""
    for row in result.rows:
        cells: list[str | Text] = [row.stage if row.stage != before else "", row.quantity, row.unit]
        cells += [_number(row.values.get(name)) for name in names]
        for name in (n for n in names if n != CONTINUUM):
            style = "red" if name in row.beyond else ""
            cells.append(Text(_percent(row.deviations.get(name), row.unit), style))
        cells.append(_percent(row.tolerances.get(ANCF), row.unit))
        cells.append(Text(_percent(row.error, row.unit), "red" if row.unconverged else ""))
        grid.add_row(*cells)
        before = row.stage
    return grid


def _title(result: Comparison) -> str:
    return result.scene.title or result.scene.folder.name


def _number(value: float | None) -> str:
    if value is None:
        return ""
    return "none" if math.isnan(value) else f"{value:.5g}"


def _percent(value: float | None, unit: str) -> str:
    """In %, but pure numbers that should vanish as they are."""
    if value is None or math.isnan(value):
        return ""
    return f"{value:.1e}" if unit == "1" else f"{100.0 * value:.3g} %"


def _costs(result: Comparison) -> Grid:
    grid = Grid(title="Run time [s of the processor]", title_justify="left", title_style="bold")
    grid.add_column("model")
    grid.add_column("coordinates", justify="right")
    stages = _timed(result)
    for stage in stages:
        grid.add_column("building" if stage == "mass" else stage, justify="right")
    for model in _all(result):
        spent = [_number(model.seconds.get(stage)) for stage in stages]
        grid.add_row(model.name, str(model.dof), *spent)
    if CONTINUUM in result.models:
        beams, solid = (result.models[name] for name in (ANCF, CONTINUUM))
        times = [_ratio(solid.seconds.get(s), beams.seconds.get(s)) for s in stages]
        grid.add_row("continuum / ancf", f"{solid.dof / beams.dof:.3g}", *times, style="bold")
    return grid


def _timed(result: Comparison) -> list[str]:
    """Stages that take time of their own."""
    found = dict.fromkeys(stage for model in _all(result) for stage in model.seconds)
    return [*found]


def _all(result: Comparison) -> Iterator[Measured]:
    yield result.models[ANCF]
    yield from result.meshes
    yield from (result.models[name] for name in OUTSIDE if name in result.models)


def _ratio(solid: float | None, beams: float | None) -> str:
    return "" if not solid or not beams else f"{solid / beams:.3g}"


def total_ratio(result: Comparison) -> float:
    """Run time of all stages by the finest continuum over that of beams; nan without continuum."""
    if CONTINUUM not in result.models:
        return math.nan
    beams, solid = (
        sum(s for stage, s in result.models[name].seconds.items() if stage != "mass")
        for name in (ANCF, CONTINUUM)
    )
    return solid / beams if beams > 0.0 else math.inf


def notes(result: Comparison) -> list[str]:
    """What the tables mean, in sentences."""
    found = [f"{name} is not there: {why}" for name, why in result.absent.items()]
    for model in (result.models[name] for name in OUTSIDE if name in result.models):
        found += [f"{model.name} has no {stage}: {why}" for stage, why in model.why.items()]
    if CONTINUUM in result.models:
        ratio = total_ratio(result)
        worst = max((abs(r.deviations[ANCF]) for r in result.rows if _counts(r)), default=0.0)
        verdict = "as wanted" if ratio >= TARGET else f"less than the {TARGET:g} wanted"
        found.append(
            f"beams are at most {worst:.2%} from the continuum and take 1/{ratio:.0f} of its run "
            f"time without building: {verdict}"
        )
        found.append("continuum ±: what its meshes show it may still be wrong by (Richardson)")
    if result.scene.overrides and asked(result.scene).exact:
        found.append("exact values are left out: they hold for the case as it is written")
    return found


def _counts(row: Row) -> bool:
    return row.reference == CONTINUUM and ANCF in row.deviations


# ----------------------------------------------------------------------------------- files


def written(result: Comparison, folder: Path) -> list[Path]:
    """crosscheck.csv, times.csv and crosscheck.md in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    names = participants(result)
    table: list[list[Any]] = [
        ["stage", "quantity", "unit", *names, *(f"deviation of {n}" for n in names),
         *(f"tolerance of {n}" for n in names), "error of continuum"],
        *([row.stage, row.quantity, row.unit,
           *(row.values.get(n, "") for n in names), *(row.deviations.get(n, "") for n in names),
           *(row.tolerances.get(n, "") for n in names), row.error] for row in result.rows),
    ]  # fmt: skip
    stages = _timed(result)
    times: list[list[Any]] = [["model", "coordinates", *stages]]
    times += [
        [m.name, str(m.dof), *(str(m.seconds.get(s, "")) for s in stages)] for m in _all(result)
    ]
    files = [folder / name for name in ("crosscheck.csv", "times.csv", "crosscheck.md")]
    for file, rows in zip(files, (table, times), strict=False):
        with file.open("w", newline="", encoding="utf-8") as there:
            csv.writer(there).writerows(rows)
    files[2].write_text(_markdown(result), encoding="utf-8")
    return files


def _markdown(result: Comparison) -> str:
    lines = [f"# Cross-check: {_title(result)}"]
    for grid in (_quantities(result), _costs(result)):
        heads = [str(column.header) for column in grid.columns]
        lines += ["", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
        cells = zip(*(column.cells for column in grid.columns), strict=True)
        lines += [f"| {' | '.join(map(str, row))} |" for row in cells]
    return "\n".join([*lines, "", *(f"{note}  " for note in notes(result))]) + "\n"
