"""Small pictures beside the overview: the hinge, sections, the departure of a probe."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coupling.contact_pictures import flat_orbit, plot_orbit, regime_handles
from coupling.contact_places import peak_force
from coupling.painting import Colouring
from coupling.pictures import fitting_size, scaled
from coupling.reading import Results
from coupling.surfaces import AROUND, Body, extent, surface
from coupling.turning import departure, find_drive, outermost_probe

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SKY, INK, FAINT, GRID = "#0b1226", "#e8edf5", "#5f6f8c", "#26324d"
SEEN = 0.5
"""Difference of temperatures on one body that is worth a picture of its own [K]."""
TITLE_WIDTH = 3.3
"""Of the insets [inch]."""
LINES = ("#56B4E9", "#F0B429", "#EF767A")


def find_insets(
    results: Results, bodies: list[Body], colouring: Colouring | None
) -> list[tuple[Any, ...]]:
    """What there is to show: shares of the height for all and below it, function, arguments."""
    found: list[tuple[Any, ...]] = []
    joints = [j for j in results.names("joints") if f"joints/{j}/orbit" in results]
    joints = [j for j in joints if len(results[f"joints/{j}/orbit"]) > 1]
    if joints:
        joint = max(joints, key=lambda j: peak_force(results, j))
        found.append((0.47, 0.07, _orbit_inset, joint, flat_orbit(results, joint)[0]))
    heated = [b for b in bodies if b.temperature is not None and b.section is not None]
    if heated and colouring and colouring.field == "temperature":
        longest = max(heated, key=extent)
        last = surface(longest, len(longest.position) - 1).temperature
        if np.ptp(last) > SEEN:
            found.append((0.22, 0.06, _section_inset, longest, colouring))
    drive = find_drive(results)
    probe = outermost_probe(results, drive) if drive else None
    if drive and probe and len(results[f"probes/{probe}/time"]) > 1:
        table = results.table(f"probes/{probe}")
        away = departure(table["time"], table["position"], drive)
        found.append((0.29, 0.095, _departure_inset, probe, table["time"], away))
    return found


def draw_insets(figure: "Figure", insets: list[tuple[Any, ...]]) -> None:
    """One below the other along the right edge."""
    top = 0.98
    for height, below, draw, *arguments in insets:
        ax = figure.add_axes((0.765, top - height + below, 0.21, height - below - 0.04))
        ax.set_facecolor(SKY)
        ax.tick_params(colors=INK, labelsize=9)
        ax.grid(color=GRID, lw=0.6)
        for spine in ax.spines.values():
            spine.set_color(FAINT)
        draw(ax, *arguments)
        top -= height


def _orbit_inset(ax: "Axes", joint: str, table: dict[str, Array]) -> None:
    factor, unit = scaled(table["clearance"], "m")
    plot_orbit(ax, table, factor, circle=INK)
    title = f"{joint}: orbit of the journal [{unit}]"
    size = fitting_size(title, TITLE_WIDTH, 13.0)  # which is for bold letters
    ax.set_title(title, color=INK, fontsize=min(size, 11.0))
    _legend_below(ax, 0.06, handles=regime_handles(np.unique(table["regime"])))


def _section_inset(ax: "Axes", body: Body, colouring: Colouring) -> None:
    """Temperature around the section at both ends and in the middle, in the last frame."""
    assert body.section is not None
    beam = body._replace(facets=None)
    wall = surface(beam, len(body.position) - 1).temperature.reshape(-1, AROUND)
    outline = body.section.outline(AROUND)
    size = float(np.ptp(outline, axis=0).max())
    for k, (name, station) in enumerate((("start", 0), ("middle", len(wall) // 2), ("end", -1))):
        centre = np.array([1.6 * k * size, 0.0])
        _draw_ring(ax, centre, outline, colouring.colors(wall[station]))
        low, high = (round(float(f(wall[station])) - 273.15) for f in (np.min, np.max))
        text = f"{name}\n{low} … {high} °C".replace("-", "\N{MINUS SIGN}")
        ax.text(centre[0], -0.62 * size, text, color=INK, fontsize=9, ha="center", va="top")
    ax.set_axis_off()
    ax.set_xlim(-0.8 * size, 4.0 * size)
    ax.set_ylim(-0.55 * size, 0.55 * size)
    ax.set_aspect("equal")
    ax.set_title(f"{body.name}: around the section, at last", color=INK, fontsize=11)


def _draw_ring(ax: "Axes", centre: Array, outline: Array, colors: Array) -> None:
    """The outline as a band whose pieces lie around the points of the outline."""
    from matplotlib.collections import PolyCollection

    ends = 0.5 * (outline + np.roll(outline, -1, axis=0))
    band = np.stack([np.roll(ends, 1, axis=0), outline, ends], axis=1)
    pieces: Any = centre + np.concatenate([band, 0.72 * band[:, ::-1]], axis=1)
    ax.add_collection(PolyCollection(pieces, facecolors=colors, edgecolors=colors, linewidths=0.3))


def _departure_inset(ax: "Axes", probe: str, time: Array, away: Array) -> None:
    factor, unit = scaled(away, "m")
    for column, label, color in zip(away.T, ("outward", "ahead", "along axis"), LINES, strict=True):
        ax.plot(time, factor * column, color=color, lw=1.2, label=label)
    ax.set_title(f"{probe}: off the rigid turn [{unit}]", color=INK, fontsize=11)
    ax.set_xlabel("time [s]", color=INK, fontsize=9, labelpad=1)
    _legend_below(ax, 0.28)


def _legend_below(ax: "Axes", gap: float, **entries: Any) -> None:
    ax.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, -gap),
        ncols=4,
        labelcolor=INK,
        fontsize=9,
        handlelength=1.0,
        handletextpad=0.3,
        columnspacing=0.8,
        **entries,
    )
