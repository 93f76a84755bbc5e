"""Pictures of a sweep: quantities over what is varied, portraits, their regularity, effects."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import ceil, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coupling.report_quantities import unit_of
from coupling.sweep_tables import Portrait, SweepTable
from coupling.sweeps.points import DONE, Point
from coupling.sweeps.table import Axis, Response, Sweep, regular

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#1d2733", "#999999")
PRINTED = "#B00020"
MARKS = "os^Dv<>p"
MOST_PANELS = 30
"""Portraits in one picture."""
MOST_SAMPLES = 20_000
"""Of a portrait that is drawn."""
SHOWN = ("chaos", "spread", "entropy")
"""Numbers of regularity that are drawn; the table has all."""
MANY = 4
"""Panels in one column."""
WIDE = 20.0
"""Quotient of largest and smallest value from which an axis is logarithmic [-]."""


def draw(sweep: Sweep, table: SweepTable, folder: Path) -> list[Path]:
    """Write all pictures of a sweep; their files."""
    import matplotlib

    from coupling.plot import STYLE

    with matplotlib.rc_context(STYLE):
        return [*_all(sweep, table, folder)]


def _all(sweep: Sweep, table: SweepTable, folder: Path) -> Iterator[Path]:
    quantities = [r for r in sweep.responses if r.name in table.quantity]
    measures = [r for r in sweep.responses if r.name.split(" ")[-1] in SHOWN and known(r)]
    together = table.combine == "together"
    for name, some in (("quantities", quantities), ("regularity", measures)):
        if some and sweep.axes:
            fill = partial(_over, sweep=sweep, responses=some, together=together)
            yield _figure(folder / f"{name}.png", sweep.title, _sizes(sweep, len(some)), fill)
    for name, one in table.portrait.items():
        suffix = f"_{name}" if len(table.portrait) > 1 else ""
        yield from _portraits(sweep, one, folder / f"portraits{suffix}.png")
    if sweep.coded is not None:
        from coupling.sweeps.effect_pictures import draw_effects

        yield from draw_effects(sweep, folder, _figure)


def known(response: Response) -> bool:
    """Whether there is any number."""
    return bool(np.isfinite(response.values).any())


def _figure(
    path: Path, title: str, size: tuple[float, float], fill: Callable[["Figure"], None]
) -> Path:
    from matplotlib.figure import Figure

    from coupling.pictures import fitting_size

    figure = Figure(figsize=size, dpi=110, layout="constrained")
    fill(figure)
    text = fitting_size(title, 0.97 * size[0], 13.0)
    figure.suptitle(title, x=0.01, ha="left", weight="bold", fontsize=text)
    figure.savefig(path)
    return path


# ------------------------------------------------------------------- over what is varied


def _has_factors(sweep: Sweep) -> bool:
    """Whether responses stand in a row of panels, one for each factor."""
    return sweep.coded is not None and len(sweep.axes) > 1


def _sizes(sweep: Sweep, rows: int) -> tuple[float, float]:
    if not _has_factors(sweep):
        wide = _columns(rows)
        return max(7.5, 5.0 * wide), 1.0 + 2.6 * -(-rows // wide)
    return max(7.5, 3.2 * len(sweep.axes)), 1.0 + 2.6 * rows


def _over(figure: "Figure", sweep: Sweep, responses: Sequence[Response], together: bool) -> None:
    """Responses over the varied entry, a curve for each combination of the others."""
    if _has_factors(sweep):
        _over_factors(figure, sweep, responses)
        return
    axes = sweep.axes[:1] if together else sweep.axes
    wide = _columns(len(responses))
    panels = figure.subplots(-(-len(responses) // wide), wide, squeeze=False, sharex=True)
    for ax in panels.flat[len(responses) :]:
        ax.set_axis_off()
    for ax, response in zip(panels.flat, responses, strict=False):
        for k, (label, rows) in enumerate(_groups(axes)):
            color, mark = COLORS[k % len(COLORS)], MARKS[k % len(MARKS)]
            _curve(ax, axes[-1], response, rows, color, mark, label)
        _vertical(ax, response)
        if ax.get_legend_handles_labels()[1]:
            ax.legend(fontsize=8)
    for ax in panels.flat[max(len(responses) - wide, 0) : len(responses)]:
        ax.tick_params(labelbottom=True)
        _horizontal(ax, axes[-1])


def _columns(panels: int) -> int:
    """Of a picture with so many panels one below the other."""
    return 1 if panels <= MANY else 2 if panels <= MANY**2 else 4


def _groups(axes: Sequence[Axis]) -> list[tuple[str, list[int]]]:
    """Rows with the same values of all axes but the last one, by those values."""
    found: dict[str, list[int]] = {}
    for row in range(len(axes[0].values)):
        label = ", ".join(f"{axis.name} {axis.words[row]}" for axis in axes[:-1])
        found.setdefault(label, []).append(row)
    return [*found.items()]


def _curve(
    ax: "Axes", axis: Axis, response: Response, rows: list[int], color: str, mark: str, label: str
) -> None:
    rows = sorted(rows, key=lambda row: axis.values[row])
    x = axis.values[rows]
    printed = response.printed
    own = label or ("computed" if printed is not None else "")
    ax.plot(x, response.values[rows], f"-{mark}", color=color, ms=5, lw=1.4, label=own or None)
    _missing(ax, x, response.values[rows])
    if printed is not None and np.isfinite(printed[rows]).any():
        text = f"{label} printed".strip()
        ax.plot(x, printed[rows], f"--{mark}", color=PRINTED if not label else color, ms=7, lw=1.0,
                mfc="none", label=text)  # fmt: skip


def _missing(ax: "Axes", x: Array, y: Array) -> None:
    """Marks at the lower edge where a point has failed."""
    gone = ~np.isfinite(y)
    if gone.any():
        ax.plot(x[gone], np.full(gone.sum(), 0.03), "x", color=PRINTED, ms=7, mew=2,
                transform=ax.get_xaxis_transform(), label="no number", clip_on=False)  # fmt: skip


def _vertical(ax: "Axes", response: Response) -> None:
    ax.set_ylabel(f"[{response.unit or '-'}]")
    ax.set_title(response.name.replace("_", " "))
    values = response.values[np.isfinite(response.values)]
    if len(values) and values.min() > 0.0 and values.max() > 100.0 * values.min():
        ax.set_yscale("log")


def _horizontal(ax: "Axes", axis: Axis) -> None:
    ax.set_xlabel(axis.label.replace("_", " "))
    ax.margins(x=0.04)
    if axis.numeric and axis.values.min() > 0.0 and np.ptp(axis.values):
        if axis.values.max() > WIDE * axis.values.min():
            ax.set_xscale("log")
    elif not axis.numeric:
        places, first = np.unique(axis.values, return_index=True)
        ax.set_xticks(places, [axis.words[i] for i in first], fontsize=8)


def _over_factors(figure: "Figure", sweep: Sweep, responses: Sequence[Response]) -> None:
    """Responses over each factor: every point, and the mean at each of few levels."""
    shape = len(responses), len(sweep.axes)
    panels = figure.subplots(*shape, squeeze=False, sharey="row", sharex="col")
    for row, response in zip(panels, responses, strict=True):
        for ax, axis in zip(row, sweep.axes, strict=True):
            ax.plot(axis.values, response.values, "o", color=COLORS[0], ms=4, alpha=0.5)
            _missing(ax, axis.values, response.values)
            _means(ax, axis.values, response.values)
        row[0].set_ylabel(f"{response.name.replace('_', ' ')} [{response.unit or '-'}]")
    for ax, axis in zip(panels[-1], sweep.axes, strict=True):
        _horizontal(ax, axis)


def _means(ax: "Axes", x: Array, y: Array) -> None:
    levels = np.unique(x)
    there = np.isfinite(y)
    if len(levels) > 0.5 * len(x):
        return
    groups = [(level, y[there & (x == level)]) for level in levels]
    means = [(level, group.mean()) for level, group in groups if len(group) > 1]
    ax.plot(*np.array(means).reshape(-1, 2).T, "-", color=COLORS[1], lw=2)


# ------------------------------------------------------------------------------- portraits


def _portraits(sweep: Sweep, one: Portrait, path: Path) -> Iterator[Path]:
    """A portrait of each point, thirty in a picture."""
    rows = range(len(sweep.points))
    for number, first in enumerate(range(0, len(rows), MOST_PANELS), 1):
        some = rows[first : first + MOST_PANELS]
        file = path if number == 1 else path.with_stem(f"{path.stem}_{number}")
        columns = min(len(some), ceil(sqrt(1.6 * len(some))))
        size = 0.6 + 3.0 * columns, 1.1 + 2.7 * ceil(len(some) / columns)
        title = f"{sweep.title}: {one.y} over {one.x}"
        fill = partial(_grid, sweep=sweep, one=one, rows=some, columns=columns)
        yield _figure(file, title, (max(size[0], 6.0), size[1]), fill)


def _grid(figure: "Figure", sweep: Sweep, one: Portrait, rows: Sequence[int], columns: int) -> None:
    panels = figure.subplots(ceil(len(rows) / columns), columns, squeeze=False).ravel()
    for ax, row in zip(panels, rows, strict=False):
        point = sweep.points[row]
        found = regular(one, point)
        ax.set_title(f"{sweep.point(row)}\n{_figures(found, point)}", fontsize=8)
        if point.outcome == DONE:
            _portrait(ax, one, point)
        ax.tick_params(labelsize=7)
        ax.ticklabel_format(style="sci", scilimits=(-2, 3), axis="both", useMathText=True)
        for text in (ax.xaxis.get_offset_text(), ax.yaxis.get_offset_text()):
            text.set_fontsize(7)
    for ax in panels[len(rows) :]:
        ax.set_axis_off()
    figure.supxlabel(f"{one.x} [{unit_of(one.x) or '-'}]", fontsize=9)
    figure.supylabel(f"{one.y} [{unit_of(one.y) or '-'}]", fontsize=9)


def _figures(found: Any, point: Point) -> str:
    """What is said of the regularity of a portrait."""
    if point.outcome != DONE:
        return point.outcome
    if found is None:
        return "too short to judge"
    parts = [found.word]
    if np.isfinite(found.chaos):
        parts.append(f"K {found.chaos:.2f}")
    if np.isfinite(found.spread):
        parts.append(f"spread {found.spread:.2g}")
    return ", ".join(parts)


def _portrait(ax: "Axes", one: Portrait, point: Point) -> None:
    x, y = point.courses[one.x], point.courses[one.y]
    late = np.flatnonzero(point.times >= one.after)
    begin = int(late[0]) if len(late) else 0
    step = max(1, len(x) // MOST_SAMPLES)
    ax.plot(x[: begin + 1 : step], y[: begin + 1 : step], color="#b9c2cc", lw=0.5)
    ax.plot(x[begin::step], y[begin::step], color=COLORS[0], lw=0.6)
    ax.plot(x[0], y[0], "o", color=COLORS[2], ms=5, mec="white", zorder=4)
    if one.period is not None:
        times = np.arange(np.ceil(one.after / one.period) * one.period, point.times[-1], one.period)
        ax.plot(np.interp(times, point.times, x), np.interp(times, point.times, y), "o",
                color=COLORS[1], ms=2.5, zorder=3)  # fmt: skip
