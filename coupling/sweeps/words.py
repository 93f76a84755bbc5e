"""A sweep in words: table.csv, and table.md with what the design tells."""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from coupling.sweep_tables import SweepTable
from coupling.sweeps import effects
from coupling.sweeps.effect_pictures import label, varies
from coupling.sweeps.table import Cell, Response, Sweep


def write(sweep: Sweep, table: SweepTable, folder: Path) -> list[Path]:
    """Write the tables; their files."""
    plain, text = folder / "table.csv", folder / "table.md"
    with plain.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([sweep.columns, *sweep.rows])
    text.write_text("\n".join(_lines(sweep, table)) + "\n", encoding="utf-8")
    return [plain, text]


def _lines(sweep: Sweep, table: SweepTable) -> Iterator[str]:
    yield from (f"# {sweep.title}", "", f"{len(sweep.rows)} points: {_kind(table)}.", "")
    columns = [i for i, name in enumerate(sweep.columns) if name != "reason"]
    yield from _table([sweep.columns[i] for i in columns],
                      [[row[i] for i in columns] for row in sweep.rows])  # fmt: skip
    yield from ("", *(f"- {name}: {one.measure} of {one.of}{_late(one.after)}"
                      for name, one in table.quantity.items()))  # fmt: skip
    yield from (f"- {name}: portrait of {one.y} over {one.x}{_late(one.after)}; its numbers: "
                "coupling/regularity.py" for name, one in table.portrait.items())  # fmt: skip
    if sweep.failures:
        yield from ("", "Not done:", "", *(f"- {text}" for text in sweep.failures))
    if sweep.coded is not None:
        for response in filter(varies, sweep.responses):
            yield from ("", f"## {response.label}", "", *_told(sweep, response))


def _late(after: float) -> str:
    return f", from {after:g} s on" if after else ""


def _kind(table: SweepTable) -> str:
    if table.design is None:
        how = "side by side" if table.combine == "together" else "all combinations"
        return f"{', '.join(table.vary)} ({how})" if len(table.vary) > 1 else ", ".join(table.vary)
    factors = [f"{name} ({', '.join(one.entries)})" for name, one in table.factor.items()]
    return f"{table.design.kind} design of {', '.join(factors)}"


def _table(columns: list[str], rows: list[list[Cell]]) -> Iterator[str]:
    yield "| " + " | ".join(columns) + " |"
    yield "|" + "---|" * len(columns)
    yield from ("| " + " | ".join(map(cell, row)) + " |" for row in rows)


def cell(value: Cell) -> str:
    """A number or a word of a table."""
    if isinstance(value, float):
        return f"{value:.4g}" if np.isfinite(value) else "–"
    return str(value).replace("|", "/")


def _told(sweep: Sweep, response: Response) -> Iterator[str]:
    """Effects of a two-level design, or the response surface."""
    assert sweep.coded is not None
    names = [axis.name for axis in sweep.axes]
    if effects.is_two_level(sweep.coded):
        found = effects.effects(sweep.coded, response.values)
        if found:
            yield from _effects(found, names)
            yield from _bent(sweep, response)
            return
        yield "Points are missing: effects cannot be told from each other; a polynomial instead."
        yield ""
    made, why = effects.surface(sweep.coded, response.values)
    if made is None:
        yield f"No response surface: {why}."
        return
    alone = f"points left out one by one {made.q2:.4f}"
    if not np.isfinite(made.q2):
        alone = "without a point left out a term would not be known"
    yield (
        f"Least squares in the coded factors (-1 low, 1 high): R² {made.r2:.4f}, {alone}"
        + (f" ({why})." if why else ".")
    )
    yield ""
    rows: list[list[Cell]] = [
        [label(term, names) or "constant", float(c)]
        for term, c in zip(made.terms, made.coefficients, strict=True)
    ]
    yield from _table(["term", "coefficient"], rows)


def _effects(found: list[effects.Effect], names: list[str]) -> Iterator[str]:
    margin = effects.margin(np.array([e.size for e in found]))
    if np.isfinite(margin):
        yield f"Effects, high less low; those above {margin:.4g} stand out (Lenth 1989)."
        yield ""
    order = sorted(found, key=lambda e: -abs(e.size))
    rows: list[list[Cell]] = [
        [label(e.factors, names), e.size, " ".join(_alias(a, names) for a in e.aliases)]
        for e in order
    ]
    yield from _table(["factors", "effect", "cannot be told from"], rows)


def _alias(alias: tuple[tuple[int, ...], bool], names: list[str]) -> str:
    words, turned = alias
    return f"{'-' if turned else '+'} {label(words, names)}"


def _bent(sweep: Sweep, response: Response) -> Iterator[str]:
    """How far the middle is from the mean of the corners."""
    assert sweep.coded is not None
    middle = ~np.any(sweep.coded, axis=1)
    if middle.any():
        apart = response.values[middle].mean() - response.values[~middle].mean()
        yield from ("", f"The middle is {apart:.4g} {response.unit} from the mean of the corners.")
