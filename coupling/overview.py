"""The picture that heads a report: the bodies in space at three times, and the hinge."""

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coupling.clocks import analysis_of, named, said
from coupling.contact_places import contact_groups, located, placement
from coupling.insets import FAINT, INK, SKY, draw_insets, find_insets
from coupling.painting import Camera, Colouring, camera_for, colouring_of, paint, palette
from coupling.pictures import fitting_size, scaled
from coupling.reading import Results
from coupling.surfaces import Body, extent, read_bodies, surface
from coupling.turning import Drive, find_drive, turned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SMALL_TRAVEL = 0.04  # of the size of the scene: smaller displacements are enlarged
SHOWN_TRAVEL = 0.3  # up to this
ROUND = (1, 2, 5)
MOST_PATHS = 6
MOST_NAMES = 4
MOST_RINGS = 24  # around joints that are seen from afar


def draw_overview(results: Results, figure: "Figure") -> None:
    """Bodies at the first, middle and last frame; beside them the hinge and the sections."""
    figure.set_facecolor(SKY)
    figure.set_layout_engine("none")
    title = str(results.attributes().get("title", ""))
    size = fitting_size(title, 0.70 * figure.get_figwidth(), 19.0)
    figure.text(0.03, 0.925, title, color=INK, fontsize=size, weight="bold")
    bodies, times = read_bodies(results), results["frames/time"]
    frames = shown_frames(analysis_of(results), len(times))
    factor = enlargement(bodies, frames)
    if factor == 1.0 and analysis_of(results) == "dynamics":
        frames = told_apart(bodies, frames)
    drawn = [_enlarged(body, frames, factor) for body in bodies]
    owners = [body for body in drawn for _ in frames]
    shapes = [surface(body, frame) for body in drawn for frame in range(len(frames))]
    colouring = colouring_of(shapes)
    insets = find_insets(results, bodies, colouring)
    ax = figure.add_axes((0.03, 0.05, 0.68 if insets else 0.94, 0.84))
    seen = bodies if factor == 1.0 else drawn  # all frames when paths are shown
    camera = camera_for(np.concatenate([body.position.reshape(-1, 3) for body in seen]))
    solid = [s.points for s, body in zip(shapes, owners, strict=True) if body.section is None]
    _frame_scene(ax, camera, [body.position.reshape(-1, 3) for body in seen], solid)
    if factor == 1.0 and analysis_of(results) != "modes":
        _draw_paths(ax, camera, results, bodies, times[frames])
    paint(ax, camera, shapes, colouring)
    _mark_particles(ax, camera, drawn)
    _mark_joints(ax, camera, results, drawn)
    if len(bodies) <= MOST_NAMES and any(map(extent, bodies)):
        _label_frames(ax, camera, drawn, named(results, frames))
    _scale_bar(ax, factor, said(results, frames))
    if colouring:
        _colour_bar(figure, colouring)
    draw_insets(figure, insets)


# ---------------------------------------------------------------------------------- scene


def shown_frames(analysis: str, count: int) -> list[int]:
    """First, middle and last of ``count`` frames; of modes the equilibrium and the first two."""
    return (
        list(range(min(count, 3))) if analysis == "modes" else [*sorted({0, count // 2, count - 1})]
    )


def enlargement(bodies: list[Body], frames: list[int]) -> float:
    """1, or a round factor that makes displacements visible that are small to the scene."""
    whole, size = _travel(bodies, slice(None))
    if whole.max() > SMALL_TRAVEL * size:
        return 1.0
    travel, size = _travel(bodies, frames)
    return _round_down(SHOWN_TRAVEL * size / travel.max()) if travel.any() else 1.0


def told_apart(bodies: list[Body], frames: list[int]) -> list[int]:
    """The frames; of what has returned in all of them the middle one where it was half way out."""
    whole, size = _travel(bodies, slice(None))
    if whole[frames].max() > SMALL_TRAVEL * size:
        return frames
    half = int(np.argmin(np.abs(whole - 0.5 * whole.max())))
    return sorted({frames[0], half, frames[-1]})


def _travel(bodies: list[Body], frames: Any) -> tuple[Array, float]:
    """Largest displacement [m] of any point in each frame, and the size of the scene [m]."""
    points = np.concatenate([body.position[frames] for body in bodies], axis=1)
    away = np.linalg.norm(points - points[0], axis=2).max(axis=1)
    return away, float(np.linalg.norm(np.ptp(points.reshape(-1, 3), axis=0)))


def _round_down(value: float) -> float:
    """The largest of …, 1, 2, 5, 10, 20, … that is not above ``value``."""
    decade = 10.0 ** np.floor(np.log10(value))
    return float(decade * max(n for n in ROUND if n * decade <= value))


def _enlarged(body: Body, frames: list[int], factor: float) -> Body:
    """The chosen frames of a body, its displacements since the first one enlarged."""
    position = body.position[0] + factor * (body.position[frames] - body.position[0])
    axes, patches, facets = body.axes[frames], body.patches, body.facets
    if facets is not None:
        away = facets.position[frames] - facets.position[0]
        facets = facets._replace(
            position=facets.position[0] + factor * away, temperature=facets.temperature[frames]
        )
    if patches is not None and patches.slopes is not None:
        start = patches.slopes[0]
        patches = patches._replace(slopes=start + factor * (patches.slopes[frames] - start))
    if factor != 1.0 and body.section is not None:
        axes = np.stack([_following(p, a) for p, a in zip(position, axes, strict=True)])
    return body._replace(
        position=position,
        axes=axes,
        temperature=None if body.temperature is None else body.temperature[frames],
        resultants=None if body.resultants is None else body.resultants[frames],
        patches=patches,
        facets=facets,
    )


def _following(position: Array, axes: Array) -> Array:
    """Section triads normal to an enlarged line, e2 as near as possible to what it was."""
    e1 = np.gradient(position, axis=0)
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    e2 = axes[:, 1] - np.sum(axes[:, 1] * e1, axis=1, keepdims=True) * e1
    e2 /= np.maximum(np.linalg.norm(e2, axis=1, keepdims=True), 1e-12)
    return np.stack([e1, e2, np.cross(e1, e2)], axis=1)


def _draw_paths(
    ax: "Axes", camera: Camera, results: Results, bodies: list[Body], times: Array
) -> None:
    """Paths of the probes, and for a driven hinge where a rigid body would be."""
    for probe in results.names("probes")[:MOST_PATHS]:
        if f"probes/{probe}/position" in results:
            path = camera.project(results[f"probes/{probe}/position"])
            ax.plot(*path[:, :2].T, color=INK, lw=0.8, alpha=0.45, zorder=0)
    drive = find_drive(results)
    if drive and len(times) > 1:
        _draw_dial(ax, camera, bodies, drive, drive.demanded(times) - drive.angle[0])


def _draw_dial(ax: "Axes", camera: Camera, bodies: list[Body], drive: Drive, shown: Array) -> None:
    """Arcs of the demanded rotation, and rays at the ``shown`` angles."""
    arm = next(body.position[0] for body in bodies if body.name == drive.body)
    reach = arm[-1] - drive.position
    angles = np.linspace(shown.min(), shown.max(), 181)
    style: dict[str, Any] = {"color": FAINT, "lw": 0.8, "zorder": 0}
    for part in (0.25, 0.5, 0.75, 1.0):
        path = turned(np.broadcast_to(part * reach, (181, 3)), drive.axis, angles)
        ax.plot(*camera.project(drive.position + path)[:, :2].T, ls=(0, (5, 4)), **style)
    for end in turned(np.broadcast_to(reach, (len(shown), 3)), drive.axis, shown):
        ray = np.stack([drive.position, drive.position + end])
        ax.plot(*camera.project(ray)[:, :2].T, **style)


def _mark_particles(ax: "Axes", camera: Camera, bodies: list[Body]) -> None:
    for body in bodies:
        if body.is_point:
            flat = camera.project(body.position.reshape(-1, 3))
            ax.scatter(flat[:, 0], flat[:, 1], s=60, color=INK, zorder=3)


def _mark_joints(ax: "Axes", camera: Camera, results: Results, bodies: list[Body]) -> None:
    """A ring around each clearance joint in the last frame, with its name if they are few."""
    by_name = {body.name: body for body in bodies}
    shown = {}
    for joint, contacts in contact_groups(results).items():
        place = placement(results, contacts[-1], by_name)
        if place is not None:
            last = {n: v[-1] for n, v in results.table(f"joints/{contacts[-1]}").items()}
            shown[joint] = located(place, -1, last).centre
    size = 130 if len(shown) <= MOST_RINGS else 20
    for joint, point in shown.items():
        centre = camera.project(point)[:2]
        ax.scatter(
            centre[0],
            centre[1],
            s=size,
            facecolors="none",
            edgecolors=INK,
            linewidths=1.2,
            zorder=3,
        )
        if len(shown) <= MOST_NAMES:
            style: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "va": "top"}
            ax.annotate(
                joint, (centre[0], centre[1]), xytext=(0, -12), color=INK, fontsize=11, **style
            )


def _frame_scene(ax: "Axes", camera: Camera, *points: list[Array]) -> None:
    """Limits around all points (n, 3) [m], with room for labels."""
    ax.set_axis_off()
    flat = camera.project(np.concatenate([part for parts in points for part in parts]))
    lower, upper = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
    margin = 0.08 * max(float(np.max(upper - lower)), 1e-9)
    lower = lower - margin * np.array([1.0, 1.2])
    upper = upper + margin * np.array([1.4, 1.2])
    assert ax.figure is not None
    box = np.array(ax.get_position().size) * ax.figure.get_size_inches()  # type: ignore[union-attr]
    half = 0.5 * box * np.max((upper - lower) / box)
    middle = 0.5 * (lower + upper)
    ax.set_xlim(middle[0] - half[0], middle[0] + half[0])
    ax.set_ylim(middle[1] - half[1], middle[1] + half[1])


def _label_frames(ax: "Axes", camera: Camera, bodies: list[Body], names: list[str]) -> None:
    """Names of the frames beyond the end of a long body that moves, pushed apart."""
    line = max(bodies, key=lambda body: extent(body) + _way(body)).position[:, [0, -1]]
    ends = camera.project(line)[:, :, :2]
    away = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(away, axis=1, keepdims=True)
    away = np.where(length > 0.0, away / np.maximum(length, 1e-300), [0.0, 1.0])
    height = 0.032 * np.ptp(ax.get_ylim())
    places = ends[:, 1] + height * away
    order = np.argsort(places[:, 1])
    for below, above in pairwise(order):
        if abs(places[above, 0] - places[below, 0]) < 4.0 * height:
            places[above, 1] = max(places[above, 1], places[below, 1] + height)
    for (x, y), (right, _), name in zip(places, away, names, strict=True):
        side = "left" if right > 0.3 else "right" if right < -0.3 else "center"
        ax.text(x, y, name, color=INK, fontsize=12, ha=side, va="center")


def _way(body: Body) -> float:
    """How far [m] the end of a body gets around."""
    return float(np.linalg.norm(np.ptp(body.position[:, -1], axis=0)))


def _scale_bar(ax: "Axes", factor: float, frames: str) -> None:
    """A round length, true for what is parallel to the picture; what is shown, and when."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    length = _round_down(0.2 * (right - left))
    prefix, unit = scaled(np.array([length]), "m") if length < 1.0 else (1.0, "m")
    x, y = left + 0.01 * (right - left), bottom + 0.02 * (top - bottom)
    ax.plot([x, x + length], [y, y], color=INK, lw=2.0, solid_capstyle="butt")
    note = "to scale" if factor == 1.0 else f"displacements {factor:g} times enlarged"
    note += f"    {frames}"
    ax.annotate(
        f"{prefix * length:g} {unit}    {note}",
        (x, y),
        xytext=(0, 6),
        textcoords="offset points",
        color=INK,
        fontsize=11,
    )


def _colour_bar(figure: "Figure", colouring: Colouring) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    ax = figure.add_axes((0.03, 0.865, 0.22, 0.018))
    mappable = ScalarMappable(Normalize(colouring.lower, colouring.upper), palette())
    bar = figure.colorbar(mappable, cax=ax, orientation="horizontal")
    ax.grid(False)
    bar.outline.set_visible(False)
    bar.set_label(colouring.label, color=INK, fontsize=11)
    ax.tick_params(colors=INK, labelsize=10)
