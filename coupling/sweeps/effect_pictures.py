"""Pictures of effects: Pareto and half-normal plots, interactions, response surfaces."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coupling.sweeps import effects
from coupling.sweeps.effects import Effect, Surface
from coupling.sweeps.table import Axis, Response, Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SHOWN = 15
"""Effects in a Pareto plot, the largest first."""
ROWS = 4
"""Responses in one picture."""
BLUE, RED, GREY = "#0072B2", "#D55E00", "#8a94a0"


def draw_effects(sweep: Sweep, folder: Path, figure: Callable[..., Path]) -> Iterator[Path]:
    """Effects of each response of a design, four responses in a picture."""
    there = [r for r in sweep.responses if varies(r)]
    for number, first in enumerate(range(0, len(there), ROWS), 1):
        some = there[first : first + ROWS]
        name = "effects.png" if number == 1 else f"effects_{number}.png"
        size = 14.0, 1.2 + 3.4 * len(some)
        fill = partial(_rows, sweep=sweep, responses=some)
        yield figure(folder / name, f"{sweep.title}: effects", size, fill)


def varies(response: Response) -> bool:
    """Whether there is anything that factors could explain."""
    known = response.values[np.isfinite(response.values)]
    return len(known) > 2 and float(np.ptp(known)) > 1e-12 * float(np.abs(known).max())


def _rows(figure: "Figure", sweep: Sweep, responses: Sequence[Response]) -> None:
    assert sweep.coded is not None
    panels = figure.subplots(len(responses), 3, squeeze=False)
    two_level = effects.is_two_level(sweep.coded)
    for row, response in zip(panels, responses, strict=True):
        found = effects.effects(sweep.coded, response.values) if two_level else []
        if found:
            _two_level(row, sweep, response, found)
        else:
            _curved(row, sweep, response)


def _two_level(row: Any, sweep: Sweep, response: Response, found: list[Effect]) -> None:
    names = [axis.name for axis in sweep.axes]
    margin = effects.margin(np.array([e.size for e in found]))
    _pareto(row[0], [(label(e.factors, names), e.size) for e in found], response, margin)
    _half_normal(row[1], found, names, response)
    _interaction(row[2], sweep, response, _strongest(found))


def label(factors: Sequence[int], names: Sequence[str]) -> str:
    """A product of factors in words."""
    if len(factors) == 2 and factors[0] == factors[1]:
        return f"{names[factors[0]]}²"
    return " × ".join(names[i] for i in factors)


def _pareto(
    ax: "Axes", sizes: list[tuple[str, float]], response: Response, margin: float = np.nan
) -> None:
    sizes = sorted(sizes, key=lambda one: -abs(one[1]))[:SHOWN][::-1]
    values = np.array([size for _, size in sizes])
    ax.barh(range(len(sizes)), np.abs(values), color=np.where(values > 0.0, BLUE, RED))
    ax.set_yticks(range(len(sizes)), [text for text, _ in sizes], fontsize=8)
    if np.isfinite(margin):
        ax.axvline(margin, color=GREY, ls="--", lw=1)
    ax.set_title(f"{response.name.replace('_', ' ')}: effects (blue: it rises)", fontsize=10)
    ax.set_xlabel(f"[{response.unit or '-'}]")


def _half_normal(ax: "Axes", found: list[Effect], names: Sequence[str], response: Response) -> None:
    order = sorted(found, key=lambda e: abs(e.size))
    sizes, places = np.abs([e.size for e in order]), effects.half_normal(len(order))
    ax.plot(sizes, places, "o", color=BLUE, ms=5)
    for e, x, y in [*zip(order, sizes, places, strict=True)][-4:]:
        left = x > 0.5 * sizes[-1]
        ax.annotate(label(e.factors, names), (x, y), xytext=(-6 if left else 6, 3), fontsize=8,
                    textcoords="offset points", ha="right" if left else "left")  # fmt: skip
    ax.set_title("half-normal plot", fontsize=10)
    ax.set_xlabel(f"size of the effect [{response.unit or '-'}]")
    ax.set_ylabel("half-normal quantile [-]")
    ax.set_xlim(0.0, 1.08 * float(sizes[-1]))
    ax.margins(y=0.08)


def _strongest(found: Sequence[Effect]) -> tuple[int, int] | None:
    pairs = [e for e in found if len(e.factors) == 2]
    if not pairs:
        return None
    a, b = max(pairs, key=lambda e: abs(e.size)).factors
    return a, b


def _interaction(
    ax: "Axes", sweep: Sweep, response: Response, pair: tuple[int, int] | None
) -> None:
    """Mean response over one factor for each level of another one."""
    if pair is None or sweep.coded is None:
        ax.set_axis_off()
        return
    first, second = (sweep.axes[i] for i in pair)
    corners = np.all(np.abs(sweep.coded) == 1.0, axis=1)
    levels, others, means = effects.cells(
        sweep.coded[corners], response.values[corners], *pair
    )  # fmt: skip
    for level, column, color in zip(others, means.T, (BLUE, RED), strict=False):
        text = _word(second, sweep.coded[:, pair[1]], level)
        ax.plot(levels, column, "o-", color=color, label=f"{second.name} {text}")
    ax.margins(x=0.08)
    ax.set_xticks(levels, [_word(first, sweep.coded[:, pair[0]], level) for level in levels])
    ax.set_title(f"interaction {first.name} × {second.name}", fontsize=10)
    ax.set_xlabel(first.name.replace("_", " "))
    ax.set_ylabel(f"[{response.unit or '-'}]")
    ax.legend(fontsize=8)


def _word(axis: Axis, coded: Array, level: float) -> str:
    return axis.words[int(np.argmin(np.abs(coded - level)))]


# -------------------------------------------------------------------------------- surfaces


def _curved(row: Any, sweep: Sweep, response: Response) -> None:
    """Coefficients of the response surface, how well it fits, its height lines."""
    assert sweep.coded is not None
    made, why = effects.surface(sweep.coded, response.values)
    if made is None:
        for ax in row[1:]:
            ax.set_axis_off()
        row[0].set_axis_off()
        row[0].text(0.0, 0.5, f"{response.name}: no surface: {why}", transform=row[0].transAxes)
        return
    names = [axis.name for axis in sweep.axes]
    terms = [*zip(made.terms, made.coefficients, strict=True)][1:]
    _pareto(row[0], [(label(t, names), 2.0 * c) for t, c in terms], response)
    _fit(row[1], made, sweep.coded, response)
    _heights(row[2], sweep, response, made)


def _fit(ax: "Axes", made: Surface, coded: Array, response: Response) -> None:
    values = made.at(coded)
    ax.plot(response.values, values, "o", color=BLUE, ms=4)
    known = response.values[np.isfinite(response.values)]
    ends = [known.min(), known.max()]
    ax.plot(ends, ends, color=GREY, lw=1)
    ax.margins(x=0.04)
    alone = f", left out one by one {made.q2:.3f}" if np.isfinite(made.q2) else ""
    ax.set_title(f"surface: R² {made.r2:.3f}{alone}", fontsize=10)
    ax.set_xlabel(f"computed [{response.unit or '-'}]")
    ax.set_ylabel(f"by the surface [{response.unit or '-'}]")


def _heights(ax: "Axes", sweep: Sweep, response: Response, made: Surface) -> None:
    """The surface over its two strongest factors, the others in the middle."""
    k = len(sweep.axes)
    if k < 2:
        ax.set_axis_off()
        return
    strength = np.zeros(k)
    for term, c in zip(made.terms, made.coefficients, strict=True):
        strength[list(term)] += abs(c)
    a, b = np.argsort(-strength)[:2]
    u, w = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41))
    coded = np.zeros((u.size, k))
    coded[:, a], coded[:, b] = u.ravel(), w.ravel()
    image = ax.contourf(u, w, made.at(coded).reshape(u.shape), levels=12, cmap="viridis")
    ax.figure.colorbar(image, ax=ax).set_label(f"[{response.unit or '-'}]")
    ax.set_xlabel(f"{sweep.axes[a].name}, -1 low, 1 high")
    ax.set_ylabel(f"{sweep.axes[b].name}, -1 low, 1 high")
    ax.set_title("surface, other factors in the middle", fontsize=10)
    ax.grid(False)
