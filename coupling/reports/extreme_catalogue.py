"""The extreme catalogue of all areas in one table: what came out, and what was due."""

from collections.abc import Callable, Iterator, Mapping

from coupling.reports import coupling_extremes, extremes, heat_extremes, mechanics_extremes
from coupling.reports.heat_extremes import OUTSIDE
from coupling.reports.registry import Result, Row

COLUMNS = ("area", "what", "outcome", "due", "error", "reason")
RIGHT, REASON = "right", "reason"


def report() -> Iterator[Result]:
    """All areas."""
    rows = [row for area in AREAS for row in rows_of(area)]
    counted = [r for r in rows if r[0] != OUTSIDE]
    good = sum(r[2] == r[3] for r in counted)
    notes = [f"{good} of {len(counted)} correct or stopped with the due reason"]
    for area in dict.fromkeys(str(r[0]) for r in rows):
        own = [r for r in rows if r[0] == area]
        bad = [f"{r[1]}: {r[2]}" for r in own if r[2] != r[3]]
        count = len(own) - len(bad)
        notes.append(f"{area}: {count} of {len(own)}; others: {'; '.join(bad) or 'none'}")
    yield Result("extreme_catalogue", "Extremes of all areas", COLUMNS, rows, notes)


def rows_of(area: str) -> Iterator[Row]:
    """Rows of an area's own catalogue; what another program does is an area of its own."""
    make, turned = AREAS[area]
    for result in make():
        for values in result.rows:
            row = dict(zip(result.columns, values, strict=True))
            yield (OUTSIDE if row.get("solver") == OUTSIDE else area, *turned(row))


def _of_contact(row: Mapping[str, str | float | int]) -> Row:
    """Every row has an answer; another outcome than it, or its error, is a reason."""
    return (row["what"], row["outcome"], RIGHT, row["error"], "")


def _of_heat(row: Mapping[str, str | float | int]) -> Row:
    """An expected reason shows in what came out: that, another one, or silence."""
    outcome = RIGHT if row["outcome"] == "correct" else row["outcome"]
    due = REASON if outcome in (REASON, "other reason", "silent") else RIGHT
    return (f"{row['what']}, {row['solver']}", outcome, due, row["error"], row["reason"])


def _of_cases(row: Mapping[str, str | float | int]) -> Row:
    return (row["what"], row["outcome"], row["due"], row["error"], row["reason"])


Make = Callable[[], Iterator[Result]]
Turned = Callable[[Mapping[str, str | float | int]], Row]
AREAS: dict[str, tuple[Make, Turned]] = {
    "mechanics": (mechanics_extremes.report, _of_cases),
    "contact": (extremes.report, _of_contact),
    "heat": (heat_extremes.report, _of_heat),
    "coupling": (coupling_extremes.report, _of_cases),
}
"""Catalogues, and how their rows are read."""
