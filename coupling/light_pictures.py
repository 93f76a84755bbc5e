"""Light on a structure in space, and what sun and planet do to it over time."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.clocks import clock_of, named
from coupling.insets import INK, SKY
from coupling.painting import Camera, camera_for, palette
from coupling.pictures import fitting_size, heading, scaled
from coupling.reading import Results
from coupling.skin_shapes import Skin, light_of, parted, read_skins, telling_frames, thickened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Box = tuple[float, float, float, float]

SHOWN = 6
"""Times in one picture."""
SUN, PLANET = "#F9C74F", "#6CB4EE"
SLENDER = 40.0
"""Length over diameter of tubes from which they are drawn thicker, to half of it."""
ASIDE, ALONG = 0.5, 0.2
"""Of the eye from the plane of sun and structure, and along the structure; 1 towards the sun."""
STRIP, COMPASS, GAP = 1.0, 0.33, 0.17
"""Width beside the structure for directions to sun and planet, their length, their names [inch]."""
SLIM = 0.1
"""Ratio of extents of what is slender."""
END_ON = 0.1
"""Sine of the angle between sun and structure below which nothing shows its lit side."""
STEEP = 0.9
"""Height of the eye above which z does not point upwards in the picture."""
MOST_LINES = 7
FEW = 3  # skins whose ranges can be told apart
LITTLE = 0.02
"""Of all light: surfaces that never take more have no line of their own."""
ROUND = (1, 2, 5, 10)
SHADE = "#c9ced6"


# --------------------------------------------------------------------------------- light in space


Span = tuple[float, float]


class Sun(NamedTuple):
    """Directions to sun and planet at a time, and how much of the sun is seen."""

    sun: Array
    planet: Array
    visible: float


class Colouring(NamedTuple):
    """What facets are coloured by.

    skins : of results
    values : (n,) or (n, p) of facets, or of p parts of each, of a skin at a frame
    from_zero : whether the scale begins there
    """

    title: str
    unit: str
    skins: Callable[[Results], list[Skin]]
    values: Callable[[Results, Skin, int], Array]
    from_zero: bool


def lit_skins(results: Results) -> list[Skin]:
    """Recorded faces whose light is known."""
    return [skin for skin in read_skins(results) if skin.light]


def bulky_skins(results: Results) -> list[Skin]:
    """Recorded faces of solids, which cannot be laid out flat."""
    return [skin for skin in read_skins(results) if skin.body is None]


def _celsius(results: Results, skin: Skin, frame: int) -> Array:
    return results[f"skins/{skin.name}/temperature"][frame] - 273.15


LIGHT = Colouring("absorbed light", "W/m²", lit_skins, light_of, True)
TEMPERATURE = Colouring("temperature", "°C", bulky_skins, _celsius, False)


def sun_at(results: Results, time: float) -> Sun | None:
    """What was overhead at a time; None where it was not recorded."""
    if "sky/time" not in results:
        return None
    row = int(np.argmin(np.abs(results["sky/time"] - time)))
    sky = {name: results[f"sky/{name}"][row] for name in ("sun", "planet", "visible")}
    return Sun(sky["sun"], sky["planet"], float(sky["visible"]))


def draw_facets(results: Results, figure: "Figure", by: Colouring) -> None:
    """The structure at some times, coloured by the light that it absorbs or its temperature."""
    figure.set_facecolor(SKY)
    figure.set_layout_engine("none")
    skins, frames = by.skins(results), telling_frames(results, SHOWN)
    factor = thickening(skins)
    shapes = [_facets(results, skins, by, frame, factor) for frame in frames]
    suns = [sun_at(results, results["frames/time"][frame]) for frame in frames]
    camera = looking(np.concatenate([c for c, _ in shapes]), suns[0])
    scale = _scale(by, [values for _, values in shapes])
    extent = _extent(camera, shapes)
    panels = zip(
        _boxes(extent, len(frames), figure), shapes, suns, named(results, frames), strict=True
    )
    for box, shape, sun, name in panels:
        ax = figure.add_axes(box)
        _paint(ax, camera, shape, scale)
        place = _frame(ax, extent)
        if sun is not None:
            _mark_sky(ax, camera, sun, place)
        dark = sun is not None and sun.visible == 0.0
        label = f"{name}{', in the shadow of the planet' if dark else ''}"
        ax.text(0.01, 0.98, label, color=INK, fontsize=11, transform=ax.transAxes, va="top")
    _say(results, figure, factor, by, scale)


def _scale(by: Colouring, values: list[Array]) -> Span:
    """Least and greatest value of the colours."""
    least, most = (float(f([f(v) for v in values])) for f in (np.min, np.max))
    least = 0.0 if by.from_zero else least
    return least, max(most, least + 1e-3 * max(1.0, abs(least)))


def thickening(skins: list[Skin]) -> float:
    """A round factor by which tubes are drawn thicker; 1 where they can be seen."""
    slender = 0.0
    for skin in skins:
        if skin.is_tube:
            assert skin.body is not None and skin.body.section is not None
            length = np.linalg.norm(np.diff(skin.body.position[0], axis=0), axis=1).sum()
            slender = max(slender, length / max(skin.body.section.height, 1e-9))
    wanted = 2.0 * slender / SLENDER
    if wanted <= 2.0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(decade * max(n for n in ROUND if n * decade <= wanted))


def looking(facets: Array, sun: Sun | None) -> Camera:
    """Looks at the lit sides from beside the sun; z upwards where that can be.

    Of a slender structure the length goes to the right instead.

    facets : (n, 4, 3) float [m]
    """
    middles = facets.mean(axis=1)
    sides = facets[:, 2] - facets[:, 0], facets[:, 3] - facets[:, 1]
    areas = np.linalg.norm(np.cross(*sides), axis=1)[:, None]
    spread = middles - (areas * middles).sum(axis=0) / areas.sum()
    _, sizes, axes = np.linalg.svd(np.sqrt(areas) * spread, full_matrices=False)
    longest = axes[0] * np.sign(axes[0][np.argmax(np.abs(axes[0]))])
    if sun is None or np.linalg.norm(np.cross(longest, sun.sun)) < END_ON:
        return camera_for(facets.reshape(-1, 3))
    front = _unit(sun.sun - (longest @ sun.sun) * longest)
    side = np.cross(longest, front)
    side *= np.sign(side[np.argmax(np.abs(side))])
    eye = _unit(front + ASIDE * side + ALONG * longest)
    upright = np.eye(3)[2 if abs(eye[2]) < STEEP else 1]
    slender = sizes[1] < SLIM * sizes[0]
    right = _unit(longest - (longest @ eye) * eye if slender else np.cross(upright, eye))
    return Camera(np.stack([right, np.cross(eye, right), eye]))


def _unit(a: Array) -> Array:
    return a / np.linalg.norm(a)


def _facets(
    results: Results, skins: list[Skin], by: Colouring, frame: int, factor: float
) -> tuple[Array, Array]:
    """Corners (n, 4, 3) [m] of all facets, and what they are coloured by (n,)."""
    corners, values = [], []
    for skin in skins:
        whole = thickened(skin, results[f"skins/{skin.name}/corners"][frame], frame, factor)
        small, found = parted(whole, by.values(results, skin, frame))
        corners.append(small)
        values.append(found)
    return np.concatenate(corners), np.concatenate(values)


class Extent(NamedTuple):
    """Lower and upper corner (2,) [m] of all that is drawn, as the camera sees it."""

    lower: Array
    upper: Array


def _extent(camera: Camera, shapes: list[tuple[Array, Array]]) -> Extent:
    flat = np.concatenate([camera.project(c.reshape(-1, 3))[:, :2] for c, _ in shapes])
    return Extent(flat.min(axis=0), flat.max(axis=0))


def _boxes(extent: Extent, n: int, figure: "Figure") -> list[Box]:
    """(left, bottom, width, height) of each panel: as many columns as make it largest."""
    page = np.array([0.97, 0.80]) * figure.get_size_inches()
    wanted = np.maximum(extent.upper - extent.lower, 1e-9)

    def size(columns: int) -> float:
        panel = page / [columns, -(-n // columns)]
        return float(np.min((panel - [STRIP, 0.0]) / wanted))

    columns = max(range(1, n + 1), key=size)
    w, h = 0.97 / columns, 0.80 / -(-n // columns)
    return [(0.015 + (i % columns) * w, 0.86 - (i // columns + 1) * h, w, h) for i in range(n)]


def _paint(ax: "Axes", camera: Camera, shape: tuple[Array, Array], scale: Span) -> None:
    """Facets that face the eye, farthest first."""
    from matplotlib.collections import PolyCollection

    quads, values = camera.project(shape[0]), shape[1]
    normal = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])[:, 2]
    seen = np.flatnonzero(normal > 0.0)
    order = seen[np.argsort(quads[seen, :, 2].mean(axis=1))]
    colors = palette()((values[order] - scale[0]) / (scale[1] - scale[0]))
    polygons: Any = quads[order, :, :2]
    ax.add_collection(
        PolyCollection(polygons, facecolors=colors, edgecolors=colors, linewidths=0.3)
    )


def _frame(ax: "Axes", extent: Extent) -> Array:
    """Limits at equal scale, the same in all panels; middle of a free strip, and [m] of an inch."""
    ax.set_axis_off()
    assert ax.figure is not None
    box = np.array(ax.get_position().size) * ax.figure.get_size_inches()  # type: ignore[union-attr]
    inch = 1.1 * float(np.max((extent.upper - extent.lower) / (box - [STRIP, 0.0])))
    middle = 0.5 * (extent.lower + extent.upper)
    low = middle - 0.5 * inch * (box - [STRIP, 0.0])
    ax.set_xlim(low[0], low[0] + inch * box[0])
    ax.set_ylim(low[1], low[1] + inch * box[1])
    return np.array([low[0] + inch * (box[0] - 0.55 * STRIP), middle[1], inch])


def _mark_sky(ax: "Axes", camera: Camera, sun: Sun, place: Array) -> None:
    """Directions to sun and planet in the free strip, as long as they are seen."""
    centre, inch = place[:2], float(place[2])
    marks = [(sun.planet, "planet", PLANET, 1.0), (sun.sun, "sun", SUN, 0.3 + 0.7 * sun.visible)]
    for direction, name, color, strength in marks:
        if direction.any():
            way = COMPASS * inch * camera.project(direction)[:2]
            tip, text = centre + way, centre + way + GAP * inch * _unit(way)
            style = {"arrowstyle": "-|>", "color": color, "lw": 1.6, "alpha": strength}
            style |= {"shrinkA": 0.0, "shrinkB": 0.0}
            ax.annotate("", (tip[0], tip[1]), (centre[0], centre[1]), arrowprops=style)
            _write(ax, text, name, color, strength)
    ax.plot(*centre, "o", color=INK, ms=3)


def _write(ax: "Axes", place: Array, text: str, color: str, strength: float) -> None:
    x, y = place
    ax.text(x, y, text, color=color, alpha=strength, ha="center", va="center", fontsize=9)


def _say(results: Results, figure: "Figure", factor: float, by: Colouring, span: Span) -> None:
    """Title, colours, scale, and what is not to scale."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    title = f"{results.attributes().get('title', '')}: {by.title}".removeprefix(": ")
    size = fitting_size(title, 0.60 * figure.get_figwidth(), 15.0)
    figure.text(0.015, 0.93, title, color=INK, fontsize=size, weight="bold")
    ax = figure.add_axes((0.70, 0.945, 0.27, 0.018))
    bar = figure.colorbar(
        ScalarMappable(Normalize(*span), palette()), cax=ax, orientation="horizontal"
    )
    bar.outline.set_visible(False)
    bar.set_label(f"[{by.unit}]", color=INK, fontsize=10)
    ax.tick_params(colors=INK, labelsize=9)
    ax.grid(False)
    panel = figure.axes[0]
    length = _round_length(0.2 * float(np.ptp(panel.get_xlim())))
    share = length / float(np.ptp(panel.get_xlim())) * panel.get_position().width
    figure.add_artist(_line(figure, share))
    scale, unit = scaled(np.array([length]), "m") if length < 1.0 else (1.0, "m")
    text = f"{scale * length:g} {unit}"
    if factor != 1.0:
        text += f"    tubes drawn {factor:g} times as thick"
    figure.text(0.03 + share, 0.022, text, color=INK, fontsize=10)


def _line(figure: "Figure", share: float) -> Any:
    from matplotlib.lines import Line2D

    return Line2D(
        [0.02, 0.02 + share], [0.028, 0.028], color=INK, lw=2.0, transform=figure.transFigure
    )


def _round_length(value: float) -> float:
    decade = 10.0 ** np.floor(np.log10(value))
    return float(decade * max(n for n in ROUND if n * decade <= value))


# ----------------------------------------------------------------------------------- over time


def draw_sky(results: Results, figure: "Figure") -> None:
    """Sunlight, heat by surface, and temperatures of the skins over time; eclipses shaded."""
    heading(results, figure, "sunlight, heat and temperature")
    panels = [draw for draw, drawn in _panels(results) if drawn]
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, draw in zip(axes, panels, strict=True):
        draw(results, ax)
        for start, end in eclipses(results["sky/time"], results["sky/visible"]):
            ax.axvspan(start, end, color=SHADE, alpha=0.45, lw=0, zorder=0)
    axes[-1].set_xlabel(clock_of(results).label)
    figure.align_ylabels(axes)


def sky_rows(results: Results) -> int:
    """Number of panels that ``draw_sky`` makes."""
    return sum(drawn for _, drawn in _panels(results))


def _panels(results: Results) -> list[tuple[Any, bool]]:
    """Functions that draw, and whether there is something to draw."""
    flux = results["sky/flux"]
    return [
        (_draw_sun, bool(np.ptp(flux) > 1e-3 * flux.max())),
        (_draw_powers, bool(powers(results))),
        (_draw_temperatures, bool(results.names("skins"))),
    ]


def _draw_sun(results: Results, ax: "Axes") -> None:
    ax.plot(results["sky/time"], results["sky/flux"], color="#E69F00")
    ax.set_ylabel("[W/m²]")
    ax.set_ylim(bottom=0.0)
    ax.set_title("sunlight; shaded: the planet hides all or part of the sun")


def eclipses(time: Array, visible: Array) -> list[tuple[float, float]]:
    """Spans of time in which not all of the sun is seen."""
    dark = np.concatenate([[0], np.asarray(visible < 1.0, int), [0]])
    starts, ends = np.flatnonzero(np.diff(dark) > 0), np.flatnonzero(np.diff(dark) < 0)
    last = len(time) - 1
    return [
        (float(time[max(int(a) - 1, 0)]), float(time[min(int(b), last)]))
        for a, b in zip(starts, ends, strict=True)
    ]


def powers(results: Results) -> dict[str, Array]:
    """(windows,) [W]  mean heat over each window through the boundaries of surfaces."""
    sizes = results["windows/window"]
    found = {}
    for kind in ("light", "surface"):
        for column in results.names("ledger"):
            if column.startswith(f"heat_{kind}."):
                heat = results[f"ledger/{column}"]
                found[column.removeprefix("heat_")] = np.diff(heat, prepend=0.0) / sizes
    return found


def _draw_powers(results: Results, ax: "Axes") -> None:
    found, time = powers(results), results["windows/time"]
    light = {n.removeprefix("light."): p for n, p in found.items() if n.startswith("light.")}
    lost = [p for n, p in found.items() if n.startswith("surface.")]
    factor, unit = scaled(np.concatenate([np.zeros(1), *light.values(), *lost]), "W")
    total: Array = np.sum([*light.values()], axis=0)
    most = {name: float(power.max()) for name, power in light.items()}
    seen = [n for n in light if most[n] > LITTLE * total.max()] if len(light) > 1 else []
    for name in sorted(seen, key=lambda n: -most[n])[:MOST_LINES]:
        ax.plot(time, factor * light[name], lw=1.0, label=f"light on {name}")
    ax.plot(time, factor * total, color="#000000", label="all light")
    ax.plot(time, -factor * np.sum(lost, axis=0), "--", color="#7a8591", label="radiated to space")
    ax.set_ylabel(f"[{unit}]")
    ax.set_title("heat absorbed and radiated")
    ax.set_ylim(bottom=min(0.0, *ax.get_ylim()))
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _draw_temperatures(results: Results, ax: "Axes") -> None:
    """Mean over the facets of each skin; from the coldest to the hottest of them."""
    time, skins = results["frames/time"], read_skins(results)
    faint = 0.18 if len(skins) <= FEW else 0.07
    for skin in skins[:MOST_LINES]:
        T = results[f"skins/{skin.name}/temperature"] - 273.15
        (line,) = ax.plot(time, T.mean(axis=1), label=skin.name)
        ax.fill_between(
            time, T.min(axis=1), T.max(axis=1), color=line.get_color(), alpha=faint, lw=0
        )
    ax.set_ylabel("[°C]")
    ax.set_title("temperature: mean, and from the coldest to the hottest place")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
