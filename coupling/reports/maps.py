"""Maps: what becomes of runs over two parameters, and where theory sees the border."""

import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from coupling.reports.registry import Curve

DONE, REFUSED, GROWS, WRONG = "done", "stopped with a reason", "grows", "wrong"
"""Outcomes: got through; a reason instead of a result; energy or a deviation grew; another answer
than the right one, with nothing said."""
NUMBER = re.compile(r"\b(inf|nan|\d[\d.]*(e[+-]?\d+)?)\b")
MARKS = {REFUSED: ("x", "#3c444d"), GROWS: ("^", "#D55E00"), WRONG: ("s", "#cc0000")}


class Spot(NamedTuple):
    """A run.

    x, y : its parameters
    outcome : one of the above
    value : that colours it where it is done
    why : the reason why it stopped
    """

    x: float
    y: float
    outcome: str
    value: float = float("nan")
    why: str = ""


class Map(NamedTuple):
    """Runs over two parameters: coloured where they are done, marked where not.

    x, y, value : titles of axes and colours
    curves : borders
    limits : colours go from here to there, by decades
    """

    title: str
    x: str
    y: str
    value: str
    spots: Sequence[Spot]
    curves: Sequence[Curve] = ()
    logarithmic: str = "xy"
    limits: tuple[float, float] = (1e-12, 1.0)


def counted(spots: Iterable[Spot]) -> dict[str, int]:
    """How many came to each outcome."""
    found = dict.fromkeys((DONE, REFUSED, GROWS, WRONG), 0)
    for spot in spots:
        found[spot.outcome] += 1
    return found


def largest(spots: Iterable[Spot]) -> float:
    """Largest value of the runs that are done; 0 of none."""
    return max((s.value for s in spots if s.outcome == DONE), default=0.0)


def reasons(spots: Iterable[Spot]) -> list[str]:
    """What was said, without places, times and numbers, and how often."""
    found: dict[str, int] = {}
    for spot in spots:
        if spot.why:
            text = NUMBER.sub("..", spot.why.split(", at t")[0].split(" at ")[0])
            found[text] = found.get(text, 0) + 1
    return [f"{text} ({count})" for text, count in found.items()]


def draw_map(ax: Any, picture: Map) -> None:
    """On the axes of matplotlib."""
    from matplotlib.colors import LogNorm

    low, high = picture.limits
    done = [s for s in picture.spots if s.outcome == DONE]
    values = np.clip([s.value for s in done], low, high)
    shades = ax.scatter(
        [s.x for s in done], [s.y for s in done], 90, values,
        marker="s", cmap="viridis_r", norm=LogNorm(low, high),
    )  # fmt: skip
    ax.figure.colorbar(shades, ax=ax, label=picture.value, pad=0.01, fraction=0.05)
    for outcome, (mark, colour) in MARKS.items():
        there = [s for s in picture.spots if s.outcome == outcome]
        if there:
            at = [s.x for s in there], [s.y for s in there]
            ax.scatter(*at, 45, colour, marker=mark, label=outcome, linewidths=1.5)
    for curve, colour in zip(picture.curves, ("black", "#CC79A7", "#0072B2"), strict=False):
        ax.plot(curve.x, curve.y, curve.style or "-", color=colour, label=curve.label, lw=1.5)
    _frame(ax, picture)


def _frame(ax: Any, picture: Map) -> None:
    for name in picture.logarithmic:
        ax.set(**{f"{name}scale": "log"})
    for name in "xy":
        values = np.array([getattr(s, name) for s in picture.spots])
        low, high = values.min(), values.max()
        edge = 0.04 * (high - low)
        ends = (low - edge, high + edge)
        if name in picture.logarithmic:
            ends = (low / 10.0**0.4, high * 10.0**0.4)
        ax.set(**{f"{name}lim": ends})
    ax.set_xlabel(picture.x)
    ax.set_ylabel(picture.y)
    ax.set_title(picture.title)
    ax.grid(visible=False)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(
            loc="lower right", bbox_to_anchor=(1.01, 0.98), ncols=5, fontsize=8, columnspacing=1.0
        )
