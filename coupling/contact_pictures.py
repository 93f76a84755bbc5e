"""Pictures of a clearance joint: the orbit of its journal, its forces, its regimes."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from coupling.pictures import heading, scaled
from coupling.reading import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

REGIMES = ("free flight", "impact", "slip", "stick")
REGIME_COLORS = ("#9fb3c8", "#D55E00", "#F0B429", "#0072B2")
BINS = 1200  # columns of the strip of regimes


def draw_orbit(results: Results, figure: "Figure", joint: str) -> None:
    """Journal centre in its clearance circle, and unrolled: indentation over contact angle."""
    table = results.table(f"joints/{joint}")
    heading(results, figure, f"orbit of the journal in {joint}")
    left, right = figure.subplots(1, 2)
    factor, unit = scaled(table["clearance"], "m")
    plot_orbit(left, table, factor)
    directions = results.attributes(f"joints/{joint}").get("directions", np.empty((0, 3)))
    along = [f"along {direction_name(d)} " for d in directions] or ["", ""]
    left.set_xlabel(f"{along[0]}[{unit}]")
    left.set_ylabel(f"{along[1]}[{unit}]")
    left.set_title("centre of the journal")
    _unrolled(right, table)
    handles = regime_handles(np.unique(table["regime"]))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles) + 1)


def direction_name(direction: Array) -> str:
    """ "x" or "-y" for a coordinate axis, otherwise the components."""
    largest = int(np.argmax(np.abs(direction)))
    rounded = np.round(direction, 2) + 0.0  # no -0
    if np.count_nonzero(rounded) == 1:
        return ("-" if direction[largest] < 0 else "") + "xyz"[largest]
    return "(" + ", ".join(f"{component:g}" for component in rounded) + ")"


def plot_orbit(ax: "Axes", table: dict[str, Array], factor: float, circle: str = "black") -> None:
    """Orbit coloured by regime, with the clearance circle at first and at last."""
    x, y = factor * table["orbit"].T
    ax.plot(x, y, color="#9fb3c8", lw=0.4, alpha=0.6, zorder=1)
    regime = table["regime"]
    for code in np.unique(regime):  # flight below, the rarer regimes above
        here = regime == code
        ax.scatter(
            x[here], y[here], s=3, color=REGIME_COLORS[code], lw=0, zorder=2, rasterized=True
        )
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    for radius, style in ((table["clearance"][0], ":"), (table["clearance"][-1], "-")):
        r = factor * radius
        ax.plot(r * np.cos(turn), r * np.sin(turn), color=circle, lw=1.2, ls=style, zorder=3)
    ax.set_aspect("equal")


def _unrolled(ax: "Axes", table: dict[str, Array]) -> None:
    """How far the centre is beyond the clearance, over the direction of the contact."""
    depth = np.hypot(*table["orbit"].T) - table["clearance"]
    angle = np.degrees(np.arctan2(table["orbit"][:, 1], table["orbit"][:, 0]))
    factor, unit = scaled(depth[depth > 0] if (depth > 0).any() else depth, "m")
    for code in np.unique(table["regime"]):
        here = table["regime"] == code
        ax.scatter(
            angle[here], factor * depth[here], s=3, color=REGIME_COLORS[code], lw=0, rasterized=True
        )
    reach = factor * max(float(depth.max()), 1e-3 * float(table["clearance"][0]))
    ax.set_ylim(-1.5 * reach, 1.15 * reach)
    ax.axhline(0.0, color="black", lw=1.2)
    ax.set_xlim(-180.0, 180.0)
    ax.set_xticks(np.arange(-180, 181, 90))
    ax.set_xlabel("direction of the contact [deg]")
    ax.set_ylabel(f"[{unit}]")
    ax.set_title("distance beyond the clearance circle")


def regime_handles(codes: Array) -> list[object]:
    """Entries of a legend."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], ls="", marker="o", ms=7, color=REGIME_COLORS[c], label=REGIMES[c])
        for c in codes
    ]


def draw_contact(results: Results, figure: "Figure", joint: str) -> None:
    """Contact forces over time, over a strip that shows the regimes."""
    table = results.table(f"joints/{joint}")
    heading(results, figure, f"contact in {joint}")
    normal, friction, slip, strip = figure.subplots(
        4, 1, sharex=True, height_ratios=[3.0, 2.2, 2.2, 0.8]
    )
    time = table["time"]
    for ax, name, unit, color in (
        (normal, "normal_force", "N", "#0072B2"),
        (friction, "friction_force", "N", "#D55E00"),
        (slip, "slip_speed", "m/s", "#009E73"),
    ):
        factor, label = scaled(table[name], unit)
        ax.plot(time, factor * table[name], lw=0.8, color=color)
        ax.set_ylabel(f"[{label}]")
        ax.set_title(name.replace("_", " "))
    _draw_strip(strip, time, table["regime"])
    strip.set_xlabel("time [s]")
    figure.align_ylabels([normal, friction, slip])
    handles = regime_handles(np.unique(table["regime"]))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles) + 1)


def _draw_strip(ax: "Axes", time: Array, regime: Array) -> None:
    """Share of time spent in each regime, from the bottom: stick, slip, impact, free flight."""
    edges = np.linspace(time[0], time[-1], BINS + 1)
    order = (3, 2, 1, 0)
    share = np.array([regime_shares(time, regime, edges)[:, code] for code in order])
    top = np.cumsum(share, axis=0)
    for code, upper, part in zip(order, top, share, strict=True):
        color = REGIME_COLORS[code]
        ax.fill_between(edges[:-1], upper - part, upper, step="post", color=color, lw=0)
    begins = time[1:][(regime[1:] == 1) & (regime[:-1] != 1)]  # often too short to be seen
    ax.plot(begins, np.full(len(begins), 1.1), "v", ms=5, color=REGIME_COLORS[1], mew=0)
    ax.set_ylim(0.0, 1.25)
    ax.set_yticks([])
    ax.grid(False)
    ax.set_title("share of time in each regime, and where impacts begin")


def regime_shares(time: Array, regime: Array, edges: Array) -> Array:
    """Share of time (b, 4) spent in each regime between ``edges`` (b + 1,).

    A recorded regime is that of the step that ends at its time.
    """
    step = np.diff(time, prepend=time[0])
    spent = [np.cumsum(step * (regime == code)) for code in range(len(REGIMES))]
    shares = [np.diff(np.interp(edges, time, total)) / np.diff(edges) for total in spent]
    return np.stack(shares, axis=1)
