"""Pictures of many contacts: where they touch along a body and around it; all joints of a scene."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.contact_pictures import REGIME_COLORS, label_of, regime_handles
from coupling.contact_places import TUBE, contact_groups, form_of, lengths
from coupling.pictures import heading, scaled
from coupling.reading import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MOST_LABELS = 40
DECADES = 4
"""Range of forces that colours tell apart."""


class Touch(NamedTuple):
    """When a contact carried force, and where.

    time : (k,) float [s];  place : (k,) float  along the body [m], or the number of the contact
    angle : (k,) float [deg]  around the body, from e2 to e3; force : (k,) float [N]
    regime : (k,) int
    """

    time: Array
    place: Array
    angle: Array
    force: Array
    regime: NDArray[np.int8]


# ------------------------------------------------------------------------------ one joint


def draw_map(results: Results, figure: "Figure", joint: str) -> None:
    """Places of contact over time by regime and by force; in a tube also their directions."""
    contacts = contact_groups(results)[joint]
    tubes = form_of(results, contacts[0]) == TUBE
    heading(results, figure, f"contacts of {joint}")
    touches = [_touch(results, name, number, tubes) for number, name in enumerate(contacts)]
    touch = Touch(*(np.concatenate(parts) for parts in zip(*touches, strict=True)))
    axes = figure.subplots(3 if tubes else 2, 1, sharex=True)
    _scatter(axes[0], touch, touch.place)
    _forces(figure, axes[1], touch)
    for ax in axes[:2]:
        _place_axis(ax, results, contacts, tubes)
    if tubes:
        _scatter(axes[2], touch, touch.angle)
        axes[2].set_ylim(-180.0, 180.0)
        axes[2].set_yticks(np.arange(-180, 181, 90))
        axes[2].set_ylabel("[deg]")
        axes[2].set_title("direction of the contact around the outer tube, from e2 to e3")
    axes[0].set_title("where it touches, by regime")
    axes[1].set_title("where it touches, by normal force")
    axes[-1].set_xlabel("time [s]")
    time = results[f"joints/{contacts[0]}/time"]
    axes[-1].set_xlim(time[0], time[-1])
    handles = regime_handles(np.unique(touch.regime))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def _touch(results: Results, contact: str, number: int, tubes: bool) -> Touch:
    """The rows of a history at which there was force."""
    table = results.table(f"joints/{contact}")
    here = table["normal_force"] > 0.0
    table = {column: values[here] for column, values in table.items()}
    place, angle = np.full(here.sum(), float(number)), np.zeros(here.sum())
    if tubes:
        attributes = results.attributes(f"joints/{contact}")
        place = np.full_like(place, attributes.get("mouth", np.nan))
        place = np.where(np.isnan(place), table["place"], place)
        angle = _around(results, str(attributes["bearing_body"]), table, place)
    return Touch(table["time"], place, angle, table["normal_force"], table["regime"])


def _around(results: Results, outer: str, table: dict[str, Array], place: Array) -> Array:
    """(k,) [deg]  direction of the gap in the section of the outer tube in the nearest frame."""
    if f"bodies/{outer}/axes" not in results or not len(place):
        return np.zeros(len(place))
    frame = _nearest(results["frames/time"], table["time"])
    node = _nearest(lengths(results[f"bodies/{outer}/position"][0]), place)
    axes = results[f"bodies/{outer}/axes"][frame, node]
    gap = np.einsum("kij,kj->ki", axes, table["orbit"])
    return np.degrees(np.arctan2(gap[:, 2], gap[:, 1]))


def _nearest(grid: Array, values: Array) -> NDArray[np.intp]:
    """Indices of the members of a rising ``grid`` that are nearest to values."""
    middle = 0.5 * (grid[1:] + grid[:-1])
    return np.searchsorted(middle, values)


def _scatter(ax: "Axes", touch: Touch, values: Array) -> None:
    for code in np.unique(touch.regime):
        here = touch.regime == code
        color = REGIME_COLORS[code]
        ax.scatter(touch.time[here], values[here], s=5, color=color, lw=0, rasterized=True)


def _forces(figure: "Figure", ax: "Axes", touch: Touch) -> None:
    from matplotlib.colors import LogNorm

    largest = float(touch.force.max(initial=0.0)) or 1.0
    factor, unit = scaled(np.array([largest]), "N")
    order = np.argsort(touch.force)  # the largest on top
    points = ax.scatter(
        touch.time[order], touch.place[order], s=5, lw=0, rasterized=True, cmap="viridis_r",
        c=factor * touch.force[order],
        norm=LogNorm(factor * largest * 10.0**-DECADES, factor * largest, clip=True),
    )  # fmt: skip
    bar = figure.colorbar(points, ax=ax, pad=0.01, aspect=18)
    bar.set_label(f"[{unit}]")
    bar.outline.set_visible(False)


def _place_axis(ax: "Axes", results: Results, contacts: list[str], tubes: bool) -> None:
    """Length of the outer tube, or the names of the contacts, along the vertical axis."""
    if not tubes:
        _names(ax, [label_of(results, name) for name in contacts])
        return
    outer = str(results.attributes(f"joints/{contacts[0]}")["bearing_body"])
    if f"bodies/{outer}/position" in results:
        end = lengths(results[f"bodies/{outer}/position"][0])[-1]
        ax.set_ylim(-0.05 * end, 1.05 * end)
        ax.axhspan(0.0, end, color="#eef1f4", zorder=0)
    ax.set_ylabel(f"along {outer} [m]")


def _names(ax: "Axes", names: list[str]) -> None:
    """Names at the vertical axis where there is room for them, otherwise numbers."""
    ax.set_ylim(len(names) - 0.5, -0.5)
    if len(names) <= MOST_LABELS:
        size = 10 if len(names) <= MOST_LABELS // 2 else 7
        ax.set_yticks(np.arange(len(names)), names, fontsize=size)
    else:
        ax.set_ylabel("number of the contact")


# ----------------------------------------------------------------------------- all joints


def regime_rows(results: Results) -> int:
    """Contacts that ``draw_regimes`` shows."""
    return results["contacts/shares"].shape[1] if "contacts/shares" in results else 0


def draw_regimes(results: Results, figure: "Figure") -> None:
    """All contacts over time: their regimes as colours mixed by shares of time, and forces."""
    from matplotlib.colors import to_rgb

    heading(results, figure, "regimes and forces of all contacts")
    table = results.table("contacts")
    names = [name for group in contact_groups(results).values() for name in group]
    order = [int(results.attributes(f"joints/{name}")["number"]) for name in names]
    edges = np.concatenate([[0.0], table["time"]])
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    colors = np.array([to_rgb(color) for color in REGIME_COLORS])
    mixed = np.clip(table["shares"][:, order] @ colors, 0.0, 1.0)
    rows: Any = np.arange(len(names) + 1) - 0.5
    style: dict[str, Any] = {"shading": "flat", "rasterized": True}
    left.pcolormesh(edges, rows, mixed.transpose(1, 0, 2), **style)
    _peaks(figure, right, edges, rows, table["peak_force"][:, order].T, style)
    _names(left, names)
    left.set_title("share of time in each regime, mixed")
    right.set_title("largest normal force")
    for ax in (left, right):
        ax.set_xlabel("time [s]")
        ax.grid(False)
    handles = regime_handles(range(len(REGIME_COLORS)))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def _peaks(
    figure: "Figure", ax: "Axes", edges: Array, rows: Array, peaks: Array, style: dict[str, Any]
) -> None:
    from matplotlib.colors import LogNorm

    largest = float(peaks.max(initial=0.0)) or 1.0
    factor, unit = scaled(np.array([largest]), "N")
    least = factor * largest * 10.0**-DECADES
    norm, shown = LogNorm(least, factor * largest), np.ma.masked_less(factor * peaks, least)
    image = ax.pcolormesh(edges, rows, shown, cmap="viridis_r", norm=norm, **style)
    bar = figure.colorbar(image, ax=ax, pad=0.02, aspect=30)
    bar.set_label(f"[{unit}]")
    bar.outline.set_visible(False)
