"""Reports by name; each is imported only when it is asked for."""

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

RING_TRUSS = {
    "work": "coupling.reports.work:report",
    "newton": "coupling.reports.newton:report",
    "levels": "coupling.reports.levels:report",
    "elements": "coupling.reports.elements:report",
    "integrators": "coupling.reports.integrators:report",
    "exudyn": "coupling.reports.exudyn:report",
    "clearance": "coupling.reports.ring_clearance:report",
}
OF_A_CASE = ("work", "newton")
"""Reports that take any case; the others have their own models."""

OWN = {
    "ring_truss": RING_TRUSS,
    "contact": {
        "extremes": "coupling.reports.extremes:report",
        "impacts": "coupling.reports.impacts:report",
        "response_amplitude": "coupling.reports.response_amplitude:report",
    },
    "heat": {
        "extremes": "coupling.reports.heat_extremes:report",
        "shock": "coupling.reports.heat_shock:report",
        "speed": "coupling.reports.heat_speed:report",
    },
    "mechanics": {"extremes": "coupling.reports.mechanics_extremes:report"},
    "extremes": {"all": "coupling.reports.extreme_catalogue:report"},
    "stability": {
        "steps": "coupling.reports.stability_steps:report",
        "exchange": "coupling.reports.stability_exchange:report",
        "clearance": "coupling.reports.stability_clearance:report",
        "slenderness": "coupling.reports.stability_slenderness:report",
        "heating": "coupling.reports.stability_heating:report",
    },
    "coupling": {
        "extremes": "coupling.reports.coupling_extremes:report",
        "seizure": "coupling.reports.seizure:report",
        "flutter": "coupling.reports.flutter:report",
    },
    "program": {
        "leaving_out": "coupling.reports.leaving_out:report",
    },
}
"""Models that the program itself has for measuring, and the reports of each."""

OF_MANY_SIZES = (("ring_truss", "levels"), ("ring_truss", "clearance"), ("heat", "speed"))
"""Reports that take whether what is large, or long, is wanted too."""


Array = NDArray[np.float64]
Row = tuple[str | float | int, ...]


class Curve(NamedTuple):
    """A line of a picture: label, x, y; how matplotlib is to draw it, "": joined marks.

    names : written beside the points
    """

    label: str
    x: Sequence[float] | Array
    y: Sequence[float] | Array
    style: str = ""
    names: Sequence[str] = ()


class Picture(NamedTuple):
    """A diagram: titles of its axes, its curves, which of its axes "xy" are logarithmic."""

    x: str
    y: str
    curves: list[Curve]
    logarithmic: str = "xy"


class Result(NamedTuple):
    """A table, what it says in words, and pictures of it, one below the other.

    pictures : ``Picture``, or ``coupling.reports.maps.Map``
    columns : names with units;  rows : numbers and words under them
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: Sequence[Row]
    notes: list[str]
    pictures: Sequence[Any] = ()


Make = Callable[..., Iterator[Result]]


def reports_of(what: str) -> tuple[str, ...]:
    """Names of the reports of a model of ``OWN``, or of a case."""
    return tuple(OWN[what]) if what in OWN else OF_A_CASE


def load(what: str, name: str) -> Make:
    """The function that makes a report of a model of ``OWN``, or of a case."""
    module, function = OWN.get(what, RING_TRUSS)[name].split(":")
    return getattr(import_module(module), function)
