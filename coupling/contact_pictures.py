"""Pictures of a joint with clearance: orbits of its journal, its forces, its regimes."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from coupling.contact_places import contact_groups
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
    """Journal centre in its clearance circle; of one contact also unrolled, over its angle."""
    contacts = round_contacts(results, joint)
    heading(results, figure, f"orbit of the journal in {joint}")
    axes = figure.subplots(1, max(2, len(contacts)))
    codes: set[int] = set()
    for ax, contact in zip(axes, contacts, strict=False):
        table, names = flat_orbit(results, contact)
        factor, unit = scaled(table["clearance"], "m")
        plot_orbit(ax, table, factor)
        ax.set_xlabel(f"{names[0]}[{unit}]")
        ax.set_ylabel(f"{names[1]}[{unit}]")
        ax.set_title(label_of(results, contact) or "centre of the journal")
        codes |= set(np.unique(table["regime"]).tolist())
    if len(contacts) == 1:
        _unrolled(axes[1], table)
    handles = regime_handles(sorted(codes))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles) + 1)


def round_contacts(results: Results, joint: str) -> list[str]:
    """The contacts of a joint that have an orbit."""
    contacts = contact_groups(results)[joint]
    return [name for name in contacts if f"joints/{name}/orbit" in results]


def label_of(results: Results, contact: str) -> str:
    """Which contact of its joint it is, in words; "" for the only one."""
    return str(results.attributes(f"joints/{contact}").get("label", "")).replace("_", " ")


def flat_orbit(results: Results, contact: str) -> tuple[dict[str, Array], list[str]]:
    """The history with an orbit (k, 2), in space in the plane of the largest motion; its axes.

    A column ``distance`` (k,) [m] from the centre is added.
    """
    table = results.table(f"joints/{contact}")
    table["distance"] = np.linalg.norm(table["orbit"], axis=1)
    directions = results.attributes(f"joints/{contact}").get("directions", np.empty((0, 3)))
    names = [f"along {direction_name(d)} " for d in directions] or ["", ""]
    if table["orbit"].shape[1] == 3:
        least = int(np.argmin(np.ptp(table["orbit"], axis=0)))
        table["orbit"] = np.delete(table["orbit"], least, axis=1)
        del names[least]
    return table, names


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
    depth = table["distance"] - table["clearance"]
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


def regime_handles(codes: Iterable[int]) -> list[object]:
    """Entries of a legend."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], ls="", marker="o", ms=7, color=REGIME_COLORS[c], label=REGIMES[c])
        for c in codes
    ]


PANELS = (
    ("normal_force", "N", "#0072B2"),
    ("friction_force", "N", "#D55E00"),
    ("slip_speed", "m/s", "#009E73"),
)
"""Histories of a contact that are drawn, their units, and colours for a single contact."""


def draw_contact(results: Results, figure: "Figure", joint: str) -> None:
    """Contact forces over time, over a strip for each contact that shows its regimes."""
    contacts = contact_groups(results)[joint]
    tables = {name: results.table(f"joints/{name}") for name in contacts}
    labels = {name: label_of(results, name) for name in contacts}
    heading(results, figure, f"contact in {joint}")
    walls = [name for name in contacts if "towards_wall" in tables[name]]
    shown = [p for p in PANELS if p == PANELS[0] or any(t[p[0]].any() for t in tables.values())]
    panels, strips = len(shown) + bool(walls), len(contacts)
    ratios = [3.0] + [2.2] * (panels - 1) + [0.8 if strips == 1 else 0.45] * strips
    axes = figure.subplots(panels + strips, 1, sharex=True, height_ratios=ratios)
    if walls:
        _draw_walls(axes[panels - 1], {name: tables[name] for name in walls}, labels)
    for ax, (column, unit, color) in zip(axes, shown, strict=False):
        factor, prefixed = scaled(np.concatenate([t[column] for t in tables.values()]), unit)
        for name, table in tables.items():
            style = {"color": color} if strips == 1 else {"label": labels[name]}
            ax.plot(table["time"], factor * table[column], lw=0.8, **style)
        ax.set_ylabel(f"[{prefixed}]")
        ax.set_title(column.replace("_", " "))
    if strips > 1:
        axes[0].legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), handlelength=1.4)
    _draw_strips(axes[panels:], tables, labels)
    figure.align_ylabels(axes[:panels])
    codes = sorted({int(c) for t in tables.values() for c in np.unique(t["regime"])})
    figure.legend(handles=regime_handles(codes), loc="outside lower center", ncols=len(codes) + 1)


def _draw_walls(ax: "Axes", tables: dict[str, dict[str, Array]], labels: dict[str, str]) -> None:
    """Way of each corner to its wall: below zero it is in contact."""
    gaps = {name: t["clearance"] - t["towards_wall"] for name, t in tables.items()}
    factor, unit = scaled(np.concatenate([t["clearance"] for t in tables.values()]), "m")
    for number, name in enumerate(labels):
        if name in gaps:
            color = f"C{number}"  # as in the other panels
            ax.plot(tables[name]["time"], factor * gaps[name], lw=0.8, color=color)
    ax.axhline(0.0, color="black", lw=0.8)
    ax.set_ylabel(f"[{unit}]")
    ax.set_title("way to the wall")


def _draw_strips(
    axes: Sequence["Axes"], tables: dict[str, dict[str, Array]], labels: dict[str, str]
) -> None:
    for ax, (name, table) in zip(axes, tables.items(), strict=True):
        _draw_strip(ax, table["time"], table["regime"])
        if len(tables) > 1:
            ax.set_ylabel(labels[name], rotation=0, ha="right", va="center", fontsize=10)
    axes[0].set_title("share of time in each regime, and where impacts begin")
    axes[-1].set_xlabel("time [s]")


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


def regime_shares(time: Array, regime: Array, edges: Array) -> Array:
    """Share of time (b, 4) spent in each regime between ``edges`` (b + 1,).

    A recorded regime is that of the step that ends at its time.
    """
    step = np.diff(time, prepend=time[0])
    spent = [np.cumsum(step * (regime == code)) for code in range(len(REGIMES))]
    shares = [np.diff(np.interp(edges, time, total)) / np.diff(edges) for total in spent]
    return np.stack(shares, axis=1)
