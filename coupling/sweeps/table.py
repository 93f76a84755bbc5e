"""The table of a sweep: varied entries, quantities, regularity of portraits, what became of points.

Everything in SI units, but varied entries in the unit in which the case writes them.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.overrides import literal
from coupling.report_quantities import unit_of
from coupling.report_tables import said
from coupling.scales import parts
from coupling.sweep_tables import Portrait, SweepTable, Swept
from coupling.sweeps.points import DONE, Point

Array = NDArray[np.float64]
Cell = str | float | int

MEASURES = {"chaos": "", "spread": "", "entropy": "", "flatness": "", "lyapunov": "1/s"}
"""Numbers of ``coupling.regularity.Regularity`` in the table, and their units."""
LEAST_SAMPLES = 16
"""Of a portrait, for its regularity."""


class Axis(NamedTuple):
    """An entry, or a factor, that a sweep varies.

    name : short;  unit : "" where the values are plain numbers or words
    values : (n,) float  at each point; of words the number of the word
    words : (n,) str  at each point
    numeric : whether the values are numbers
    """

    name: str
    unit: str
    values: Array
    words: tuple[str, ...]
    numeric: bool

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


class Response(NamedTuple):
    """A number of each point.

    values : (n,) float;  printed : (n,) float  what a source prints; None: nothing
    """

    name: str
    unit: str
    values: Array
    printed: Array | None = None

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else f"{self.name} [-]"


class Sweep(NamedTuple):
    """A sweep that has been run.

    name, title : of it
    columns : names with units;  rows : numbers and words under them, one row for each point
    courses : of each point, by what they are of; "time" [s] among them
    axes : what is varied;  responses : quantities and regularity
    points : outcome, reason, time it took
    coded : (n, k) float  coded values of a design; None: a grid
    files : what has been written
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    courses: tuple[Mapping[str, Array], ...]
    axes: tuple[Axis, ...] = ()
    responses: tuple[Response, ...] = ()
    points: tuple[Point, ...] = ()
    coded: Array | None = None
    files: tuple[Any, ...] = ()

    @property
    def failures(self) -> list[str]:
        """What became of the points that are not done, in words."""
        return [
            f"point {number} ({self.point(number - 1)}): {one.outcome}: {one.reason}"
            for number, one in enumerate(self.points, 1)
            if one.outcome != DONE
        ]

    def point(self, row: int) -> str:
        """Values of the axes at a point, in words."""
        return ", ".join(f"{axis.name} {axis.words[row]}" for axis in self.axes)

    def column(self, name: str) -> list[Cell]:
        """A column by its name, with or without its unit. Raises KeyError."""
        for place, label in enumerate(self.columns):
            if name in (label, label.partition(" [")[0]):
                return [row[place] for row in self.rows]
        raise KeyError(name)


def tabulated(name: str, title: str, table: SweepTable, points: Sequence[Point]) -> Sweep:
    """The table of a sweep from its points."""
    axes = tuple(axes_of(table))
    responses = tuple(
        [quantity(key, one, points) for key, one in table.quantity.items()]
        + [made for key, one in table.portrait.items() for made in portrait(key, one, points)]
    )
    columns: dict[str, Sequence[Cell]] = {"point": range(1, len(points) + 1)}
    for axis in axes:
        columns[axis.label] = _cells(axis)
    for response in responses:
        columns[response.label] = response.values.tolist()
        if response.printed is not None:
            columns[f"{response.name} printed [{response.unit or '-'}]"] = response.printed.tolist()
    columns |= {
        "outcome": [p.outcome for p in points],
        "reason": [p.reason for p in points],
        "took [s]": [round(p.seconds, 3) for p in points],
    }
    rows = tuple(zip(*columns.values(), strict=True))
    courses = tuple({"time": p.times, **p.courses} for p in points)
    coded = None if table.design is None else np.array(table.coded())
    kept = tuple(points)
    return Sweep(name, title, tuple(columns), rows, courses, axes, responses, kept, coded)


def _cells(axis: Axis) -> Sequence[Cell]:
    return axis.values.tolist() if axis.numeric else axis.words


# ------------------------------------------------------------------------------------ axes


def axes_of(table: SweepTable) -> list[Axis]:
    """What a sweep varies."""
    settings = table.settings()
    if table.design is not None:
        factors = table.factor.items()
        return [_axis(name, [row[f.entries[0]] for row in settings]) for name, f in factors]
    paths = [*table.vary]
    return [_axis(_short(paths, path), [row[path] for row in settings]) for path in paths]


def _short(paths: Sequence[str], path: str) -> str:
    """The end of a path that no other has."""
    steps = path.split(".")
    for count in range(1, len(steps) + 1):
        end = ".".join(steps[-count:])
        if sum(other.endswith(end) for other in paths) == 1:
            return end
    return path


def _axis(name: str, values: Sequence[Any]) -> Axis:
    values = differing(values)
    words = tuple(_word(value) for value in values)
    try:
        numbers, units = zip(*map(parts, values), strict=True)
        if len(set(units)) == 1:
            return Axis(name, units[0], np.array(numbers), words, True)
    except ValueError:
        pass
    order = list(dict.fromkeys(words))
    return Axis(name, "", np.array([float(order.index(word)) for word in words]), words, False)


def differing(values: Sequence[Any]) -> Sequence[Any]:
    """Of tables such as ramps that differ in one entry only that entry, else the values.

    Examples
    --------
    >>> differing([{"ramp": {"end": 2, "to": "80 degC"}}, {"ramp": {"end": 2, "to": "9 K"}}])
    ['80 degC', '9 K']
    """
    if not all(isinstance(value, dict) for value in values):
        return values
    keys = list(dict.fromkeys(key for value in values for key in value))
    apart = [key for key in keys if any(v.get(key) != values[0].get(key) for v in values)]
    if len(apart) != 1 or not all(apart[0] in value for value in values):
        return values
    return differing([value[apart[0]] for value in values])


def _word(value: Any) -> str:
    if isinstance(value, dict | list):
        return literal(value)
    return said({"": value}).strip()


# ------------------------------------------------------------------------------- responses


def quantity(name: str, one: Swept, points: Sequence[Point]) -> Response:
    """What a quantity measures at each point; nan where the point is not done."""
    values = np.array([_measured(one, point) for point in points])
    printed = None if one.printed is None else np.array(one.printed)
    return Response(name, unit_of(one.of), values, printed)


def _measured(one: Swept, point: Point) -> float:
    from coupling.reports.error_time import measured

    if point.outcome != DONE or one.of not in point.courses:
        return np.nan
    late = point.times >= one.after
    if not late.any():
        return np.nan
    course = point.courses[one.of]
    if len(course) != len(point.times):  # of modes
        return float(course[-1])
    return float(measured(one.measure, point.times[late], course[late, None])[0])


def portrait(name: str, one: Portrait, points: Sequence[Point]) -> list[Response]:
    """Numbers of the regularity of a portrait at each point."""
    found = [regular(one, point) for point in points]
    return [
        Response(f"{name} {key}", unit, np.array([getattr(r, key, np.nan) for r in found]))
        for key, unit in MEASURES.items()
        if one.period is not None or key != "spread"
    ]


def regular(one: Portrait, point: Point) -> Any:
    """``coupling.regularity.Regularity`` of a portrait; None where there is none."""
    from coupling.regularity import regularity

    if point.outcome != DONE:
        return None
    late = point.times >= one.after
    if late.sum() < LEAST_SAMPLES:
        return None
    t, x, y = point.times[late], point.courses[one.x][late], point.courses[one.y][late]
    return regularity(t, x, y, one.period)
