"""Reports by name; each is imported only when it is asked for."""

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

REPORTS = {
    "work": "coupling.reports.work:report",
    "newton": "coupling.reports.newton:report",
    "levels": "coupling.reports.levels:report",
    "elements": "coupling.reports.elements:report",
    "integrators": "coupling.reports.integrators:report",
    "exudyn": "coupling.reports.exudyn:report",
    "clearance": "coupling.reports.ring_clearance:report",
    "extremes": "coupling.reports.extremes:report",
    "impacts": "coupling.reports.impacts:report",
    "response_amplitude": "coupling.reports.response_amplitude:report",
}
"""Reports that `thermobody report` can make."""

OF_A_CASE = ("work", "newton")
"""Those of them that take any case; the others have their own models."""

OF_CONTACT = ("extremes", "impacts", "response_amplitude")
"""Those whose models are journals in bearings with clearance; the rest have the ring truss."""

OF_MANY_SIZES = ("levels", "clearance")
"""Those that take whether what is large, or long, is wanted too."""


Array = NDArray[np.float64]
Row = tuple[str | float | int, ...]


class Curve(NamedTuple):
    """A line of a picture: label, x, y; how matplotlib is to draw it, "": joined marks."""

    label: str
    x: Sequence[float] | Array
    y: Sequence[float] | Array
    style: str = ""


class Picture(NamedTuple):
    """A diagram: titles of its axes, its curves, which of its axes "xy" are logarithmic."""

    x: str
    y: str
    curves: list[Curve]
    logarithmic: str = "xy"


class Result(NamedTuple):
    """A table, what it says in words, and pictures of it, one below the other.

    columns : names with units;  rows : numbers and words under them
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: Sequence[Row]
    notes: list[str]
    pictures: Sequence[Picture] = ()


Make = Callable[..., Iterator[Result]]


def load(name: str) -> Make:
    """The function that makes a report."""
    module, function = REPORTS[name].split(":")
    return getattr(import_module(module), function)
