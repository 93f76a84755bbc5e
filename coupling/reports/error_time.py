"""Error against run time: a case under many settings, compared with a finer run or known numbers.

Times are of the bare computation: recording takes none, building and compiling are apart.
"""

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling import casefile
from coupling.errors import BadCase, Problem
from coupling.overrides import override, toml
from coupling.report_quantities import unit_of
from coupling.report_tables import Measure, Overrides, ReportTable, Sought, Variant
from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.reports.timed_runs import DONE, Ran, timed
from coupling.scene import Scene

Array = NDArray[np.float64]
COUNTS = ("windows", "steps", "refused", "corrections", "factorisations", "motions",
          "heat solutions", "heat steps")  # fmt: skip
SAME_TIME = 1e-9
"""Distance of two times that are the same, relative to the last [-]."""
ALONE = 0.9
"""Part of the run time in which the processor works when nothing else runs [-]."""
RESOLVED = 3.0
"""Errors above so many times that of the reference are told from it [-]."""


class Point(NamedTuple):
    """A setting, what became of it, and its error in each quantity."""

    variant: Variant
    ran: Ran
    errors: Mapping[str, float]


def report(
    scene: Scene, name: str, console: Any = None, wanted: float | None = None
) -> Iterator[Result]:
    """Run the settings of [report.NAME] and compare them.

    Parameters
    ----------
    console : where progress is told; None: nowhere
    wanted : error under which the cheapest setting is sought; None: as the table says

    Raises
    ------
    BadCase : a setting makes the case a faulty one, or the reference does not run
    """
    table = scene.report[name]
    variants = table.variants()
    scenes = _scenes(scene, name, table, variants)
    told = _Progress(console, len(scenes))
    standard, check = _references(scenes, table, told)
    points = []
    for variant, changed in zip(variants, scenes[-len(variants) :], strict=True):
        ran = timed(changed, table.quantity, table.repeat, table.budget, table.limit)
        errors = {key: error(key, s, ran, standard) for key, s in table.quantity.items()}
        points.append(Point(variant, ran, errors))
        told.told(variant.label, ran, errors)
    between = {}
    if standard is not None and check is not None:
        between = {key: error(key, s, check, standard) for key, s in table.quantity.items()}
    yield _result(scene, name, points, _Seen(standard, check, between, wanted, busy(points)))


class _Seen(NamedTuple):
    """Reference and second one, the distance of both in each quantity, and the error wanted.

    busy : the machine had other work, so that processor time stands for run time
    """

    standard: Ran | None
    check: Ran | None
    between: Mapping[str, float]
    wanted: float | None
    busy: bool

    def cost(self, point: Point) -> float:
        """Time [s] by which settings are compared."""
        return point.ran.work if self.busy else point.ran.least


def _scenes(
    scene: Scene, name: str, table: ReportTable, variants: Sequence[Variant]
) -> list[Scene]:
    """Of the reference, of the second one, and of all settings, as far as there are any."""
    asked = [(what, own) for what in ("reference", "check") if (own := getattr(table, what))
             is not None]  # fmt: skip
    asked += [(variant.label, variant.overrides) for variant in variants]
    found, scenes = [], []
    for label, own in asked:
        try:
            scenes.append(changed(scene, {**table.common, **own}))
        except BadCase as refused:
            found += [Problem(f"{label}: {p.path}" if p.path else label, p.text)
                      for p in refused.problems]  # fmt: skip
    if found:
        raise BadCase(f"report {name}", found)
    return scenes


def changed(scene: Scene, overrides: Overrides) -> Scene:
    """The case with other entries, and without its reports."""
    raw = tomllib.loads(scene.text)
    for made_of_it in ("report", "sweep", "variant"):
        raw.pop(made_of_it, None)
    made = [override(path, value) for path, value in overrides.items()]
    return casefile.from_text(toml(raw), scene.folder, made)


def _references(
    scenes: Sequence[Scene], table: ReportTable, told: "_Progress"
) -> tuple[Ran | None, Ran | None]:
    ran: list[Ran | None] = []
    names = ("reference", "check")
    for k, name in enumerate(what for what in names if getattr(table, what) is not None):
        one = timed(scenes[k], table.quantity)
        if one.outcome != DONE:
            raise BadCase(f"the {name}", [Problem("", f"{one.outcome}: {one.reason}")])
        told.told(name, one, {})
        ran.append(one)
    standard, check = [*ran, None, None][:2]
    return standard, check


# ------------------------------------------------------------------------------------ errors


def value(name: str, sought: Sought, ran: Ran) -> Array:
    """(k,) float  what a quantity measures of a run, by all but ``course``."""
    return measured(sought.measure, ran.times, ran.values[name])


def measured(measure: Measure, times: Array, rows: Array) -> Array:
    """(k,) float  of a course (w, k) at times (w,)."""
    match measure:
        case "max":
            return rows.max(axis=0)
        case "min":
            return rows.min(axis=0)
        case "mean" if len(times) > 1:
            return np.trapezoid(rows, times, axis=0) / (times[-1] - times[0])
        case "rms" if len(times) > 1:
            mean = np.trapezoid(rows**2, times, axis=0) / (times[-1] - times[0])
            return np.sqrt(mean)
        case "range":
            return np.ptp(rows, axis=0)
        case "amplitude":
            return 0.5 * np.ptp(rows, axis=0)
    return rows[-1]


def error(name: str, sought: Sought, ran: Ran, standard: Ran | None) -> float:
    """Distance from the reference, or from what is exact, relative to the scale; nan: not known."""
    if ran.outcome != DONE:
        return np.nan
    if sought.exact is not None:
        return _relative(sought, value(name, sought, ran), np.atleast_1d(sought.exact))
    assert standard is not None
    if sought.measure != "course":
        return _relative(sought, value(name, sought, ran), value(name, sought, standard))
    own, its = same_times(ran.times, standard.times)
    if len(own) < 2:
        return np.nan
    course = standard.values[name]
    apart = np.linalg.norm(ran.values[name][own] - course[its], axis=1)
    size = float(np.linalg.norm(course - course[0], axis=1).max())
    return float(apart.max()) / (sought.scale or size or 1.0)


def _relative(sought: Sought, found: Array, true: Array) -> float:
    if found.shape != true.shape:
        return np.nan
    return float(np.linalg.norm(found - true)) / (
        sought.scale or float(np.linalg.norm(true)) or 1.0
    )


def same_times(a: Array, b: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of both where times are the same, the beginning left out."""
    near = np.searchsorted(b, a - SAME_TIME * b[-1])
    near = np.minimum(near, len(b) - 1)
    own = np.flatnonzero((np.abs(b[near] - a) <= SAME_TIME * b[-1]) & (a > 0.0))
    return own, near[own]


# ------------------------------------------------------------------------------------ output


def _result(scene: Scene, name: str, points: Sequence[Point], seen: _Seen) -> Result:
    table = scene.report[name]
    columns = ["setting", "outcome", *(f"{key} [-]" for key in table.quantity), "time [s]",
               "median [s]", "processor [s]", "start [s]"]  # fmt: skip
    there = [count for count in COUNTS if any(p.ran.counts.get(count) for p in points)]
    rows = [_row(point.variant.label, point.ran, point.errors, there) for point in points]
    for label, ran in (("reference", seen.standard), ("check", seen.check)):
        if ran is not None:
            errors = seen.between if label == "check" else {}
            own = {key: errors.get(key, np.nan) for key in table.quantity}
            rows.append(_row(label, ran, own, there))
    title = table.title or f"{scene.title or name}: error against run time"
    notes = [*_meanings(table), *_trust(table, points, seen), *_cheapest(table, points, seen)]
    notes += [f"{p.variant.label}: {p.ran.outcome}: {p.ran.reason}" for p in points if p.ran.reason]
    if seen.busy:
        notes.append(
            "the machine was busy with other work: settings are compared by processor time"
        )
    notes.append(
        "time: least of the timed runs, without recording; start: building and a first window, "
        "in which kernels are compiled or read from disk"
    )
    pictures = [_picture(table, key, points, seen) for key in table.quantity]
    return Result(name, title, (*columns, *there), rows, notes, pictures)


def _row(label: str, ran: Ran, errors: Mapping[str, float], counts: Sequence[str]) -> Row:
    median = float(np.median(ran.wall)) if ran.wall else np.nan
    spent = ran.least, median, ran.work, ran.start
    return label, ran.outcome, *errors.values(), *spent, *(ran.counts.get(c, "") for c in counts)


def _meanings(table: ReportTable) -> Iterator[str]:
    """What each column of errors is."""
    for key, sought in table.quantity.items():
        unit = unit_of(sought.of)
        against = "the reference" if sought.exact is None else f"the exact {sought.exact} {unit}"
        size = "its size" if sought.scale is None else f"{sought.scale:g} {unit}"
        if sought.measure == "course" and sought.scale is None:
            size = "its largest change"
        yield f"{key}: {sought.measure} of {sought.of}, distance from {against.strip()} over {size}"


def busy(points: Sequence[Point]) -> bool:
    """Whether something else ran on the machine, so that wall times say little."""
    shares = [p.ran.work / p.ran.least for p in points if p.ran.wall]
    return bool(shares) and float(np.median(shares)) < ALONE


def _trust(table: ReportTable, points: Sequence[Point], seen: _Seen) -> Iterator[str]:
    """How far the reference itself can be trusted."""
    for key, sought in table.quantity.items():
        if sought.exact is not None:
            continue
        if seen.check is not None:
            limit = RESOLVED * seen.between[key]
            below = sum(point.errors[key] < limit for point in points)
            text = f"{key}: the two references differ by {seen.between[key]:.2g}"
            yield text + (f"; {below} errors below {limit:.2g} are not resolved" if below else "")
            continue
        near = _best(points, key)
        if near is not None:
            yield (
                f"{key}: the reference and the nearest setting, {near.variant.label}, differ by "
                f"{near.errors[key]:.2g}; how far both are from the truth is not known"
            )


def _best(points: Sequence[Point], key: str) -> Point | None:
    known = [point for point in points if np.isfinite(point.errors[key])]
    return min(known, key=lambda point: point.errors[key], default=None)


def _wanted(table: ReportTable, key: str, seen: _Seen) -> float | None:
    return seen.wanted or table.quantity[key].wanted or table.wanted


def cheapest(
    points: Sequence[Point], key: str, wanted: float, cost: Callable[[Point], float]
) -> Point | None:
    """The fastest setting whose error is not above ``wanted``."""
    return min((p for p in points if p.errors[key] <= wanted), key=cost, default=None)


def _cheapest(table: ReportTable, points: Sequence[Point], seen: _Seen) -> Iterator[str]:
    for key in table.quantity:
        wanted = _wanted(table, key, seen)
        if wanted is None:
            continue
        found = cheapest(points, key, wanted, seen.cost)
        if found is None:
            yield f"{key}: no setting has an error under {wanted:g}"
        else:
            yield (
                f"{key}: the cheapest under {wanted:g} is {found.variant.label}: "
                f"{seen.cost(found):.3g} s, error {found.errors[key]:.2g}"
            )


def _picture(table: ReportTable, key: str, points: Sequence[Point], seen: _Seen) -> Picture:
    there = [p for p in points if p.errors[key] > 0.0 and seen.cost(p) > 0.0]
    curves = []
    for name in dict.fromkeys(point.variant.curve for point in points):
        of_it = [p for p in there if p.variant.curve == name]
        along, marks = _marks([p.variant.name for p in of_it])
        label = ", ".join(filter(None, (name, along and f"by {along}")))
        x, y = [seen.cost(p) for p in of_it], [p.errors[key] for p in of_it]
        curves.append(Curve(label or "settings", x, y, names=marks))
    front = _front([(seen.cost(p), p.errors[key]) for p in there])
    if len(front) > 2:
        curves.append(Curve("none is better", [t for t, _ in front], [e for _, e in front], "k:"))
    levels = {"wanted": _wanted(table, key, seen), "of the reference": seen.between.get(key)}
    for (label, level), style in zip(levels.items(), ("g-.", "r--"), strict=True):
        if level and there:
            ends = [f(seen.cost(p) for p in there) for f in (min, max)]
            curves.append(Curve(label, ends, [level, level], style))
    axis = "processor time [s]" if seen.busy else "run time [s]"
    return Picture(axis, f"error of {key} [-]", curves)


def _marks(names: Sequence[str]) -> tuple[str, list[str]]:
    """What changes along a curve, if it is one thing, and what is written beside its points."""
    parts = [name.partition(" ") for name in names]
    if len({key for key, *_ in parts}) != 1 or any("," in name for name in names):
        return "", list(names)
    return parts[0][0], [text for *_, text in parts]


def _front(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Stairs of the settings that no other beats in both time and error."""
    stairs: list[tuple[float, float]] = []
    for time, size in sorted(points):
        if not stairs or size < stairs[-1][1]:
            stairs += [(time, stairs[-1][1])] if stairs else []
            stairs.append((time, size))
    return stairs


class _Progress:
    """One line for each run that is over, with the time left at their mean pace."""

    def __init__(self, console: Any, total: int) -> None:
        self.console, self.total, self.done, self.begun = console, total, 0, perf_counter()

    def told(self, label: str, ran: Ran, errors: Mapping[str, float]) -> None:
        """A run is over."""
        self.done += 1
        if self.console is None:
            return
        gone = perf_counter() - self.begun
        minutes, seconds = divmod(round(gone / self.done * (self.total - self.done)), 60)
        parts = [f"{ran.least:.3g} s" if ran.outcome == DONE else f"{ran.outcome}: {ran.reason}"]
        parts += [f"{key} {size:.2g}" for key, size in errors.items()]
        text = f"{self.done} of {self.total}, {minutes}:{seconds:02d} left · {label}: "
        self.console.print(text + ", ".join(parts), style="dim", markup=False, highlight=False)
