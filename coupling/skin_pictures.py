"""Maps of temperature and light on faces that are laid out flat."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.clocks import named
from coupling.painting import palette
from coupling.pictures import heading
from coupling.reading import Results
from coupling.skin_shapes import Flat, Skin, laid_out, light_of, parted, read_skins, telling_frames

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

TIMES = 5
MOST = 3
"""Faces in one picture, those with the widest range of temperature at a time."""


def mapped_skins(results: Results) -> list[tuple[Skin, Flat]]:
    """Faces that can be laid out, the widest range of temperature first; a few of them.

    It is the range over the face at a time, in the mean over all times. ``light`` of a face that
    never sees any is False.
    """
    found = []
    for skin in read_skins(results):
        flat = laid_out(skin, results[f"skins/{skin.name}/corners"][0])
        if flat is not None:
            T = results[f"skins/{skin.name}/temperature"]
            lit = skin.light and bool(results[f"skins/{skin.name}/light"].any())
            found.append((float(np.ptp(T, axis=1).mean()), skin._replace(light=lit), flat))
    return [(skin, flat) for _, skin, flat in sorted(found, key=lambda x: -x[0])[:MOST]]


def map_rows(results: Results) -> int:
    """Number of rows that ``draw_maps`` makes."""
    return sum(1 + skin.light for skin, _ in mapped_skins(results))


def draw_maps(results: Results, figure: "Figure") -> None:
    """Temperature and absorbed light of faces at some times, each field on one scale."""
    heading(results, figure, "temperature and absorbed light, laid out flat")
    frames = telling_frames(results, TIMES)
    rows = list(_fields(results, frames))
    axes = figure.subplots(len(rows), len(frames), squeeze=False)
    for line, field in zip(axes, rows, strict=True):
        same = [other.values for other in rows if other.unit == field.unit]
        _draw_row(line, field, _limits(same))
    for ax, name in zip(axes[0], named(results, frames), strict=True):
        ax.set_title(name)


class Field(NamedTuple):
    """What a row of maps shows: values at each of some times."""

    flat: Flat
    values: list[Array]
    colors: Any
    face: str
    what: str
    unit: str


def _fields(results: Results, frames: list[int]) -> Iterator[Field]:
    for skin, flat in mapped_skins(results):
        temperature = list(results[f"skins/{skin.name}/temperature"][frames] - 273.15)
        yield Field(flat, temperature, "inferno", skin.name, "temperature", "°C")
        if skin.light:
            light = [light_of(results, skin, frame) for frame in frames]
            yield Field(flat, light, palette(), skin.name, "light", "W/m²")


def _limits(fields: list[list[Array]]) -> tuple[float, float]:
    lower = min(float(v.min()) for values in fields for v in values)
    upper = max(float(v.max()) for values in fields for v in values)
    return lower, max(upper, lower + 1e-9)


def _draw_row(axes: "NDArray[Any]", field: Field, limits: tuple[float, float]) -> None:
    """One field of one face at all times."""
    for ax, value in zip(axes, field.values, strict=True):
        image = _draw_map(ax, field.flat, value, field.colors, limits)
        if field.flat.period:
            ax.set_yticks([-180, -90, 0, 90, 180])
        if ax is not axes[0]:
            ax.set_yticklabels([])
    bar = axes[0].figure.colorbar(image, ax=list(axes), pad=0.01, aspect=12)
    bar.set_label(f"{field.what} [{field.unit}]")
    bar.outline.set_visible(False)
    axes[0].set_ylabel(f"{field.face}\n{field.flat.across}")
    axes[-1].set_xlabel(field.flat.along)


def _draw_map(
    ax: "Axes", flat: Flat, values: Array, colors: Any, limits: tuple[float, float]
) -> Any:
    from matplotlib.collections import PolyCollection

    corners, values = parted(flat.corners, values)
    if flat.period:
        shifts = np.array([-1.0, 0.0, 1.0])[:, None, None, None] * [0.0, flat.period]
        corners = (corners + shifts).reshape(-1, 4, 2)
        values = np.tile(values, 3)
    polygons: Any = corners
    image = PolyCollection(polygons, array=values, cmap=colors, edgecolors="face", linewidths=0.3)
    image.set_clim(*limits)
    image.set_rasterized(True)
    ax.add_collection(image)
    along = flat.corners[..., 0]
    across = np.array([-0.5, 0.5]) * flat.period if flat.period else flat.corners[..., 1]
    ax.set_xlim(along.min(), along.max())
    ax.set_ylim(across.min(), across.max())
    ax.grid(False)
    if not flat.period:
        ax.set_aspect("equal")
    return image
