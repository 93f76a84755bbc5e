"""Reports by name; each is imported only when it is asked for."""

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import NamedTuple

REPORTS = {
    "work": "coupling.reports.work:report",
    "newton": "coupling.reports.newton:report",
    "levels": "coupling.reports.levels:report",
    "elements": "coupling.reports.elements:report",
    "integrators": "coupling.reports.integrators:report",
    "exudyn": "coupling.reports.exudyn:report",
}
"""Reports that `thermobody report` can make."""

OF_A_CASE = ("work", "newton")
"""Those of them that take any case; the others have their own models."""


OF_MANY_SIZES = ("levels",)
"""Those that take whether large sizes are wanted too."""


class Curve(NamedTuple):
    """A line of a log-log picture: label, x, y."""

    label: str
    x: list[float]
    y: list[float]


class Picture(NamedTuple):
    """A log-log picture: titles of its axes, its curves."""

    x: str
    y: str
    curves: list[Curve]


class Result(NamedTuple):
    """A table, what it says in words, and a picture of it.

    columns : names with units;  rows : numbers and words under them
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str | float | int, ...]]
    notes: list[str]
    picture: Picture | None = None


Make = Callable[..., Iterator[Result]]


def load(name: str) -> Make:
    """The function that makes a report."""
    module, function = REPORTS[name].split(":")
    return getattr(import_module(module), function)
