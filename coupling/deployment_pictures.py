"""Pictures of a ring that deploys: the sequence, paths of corners hot and cold, a hinge's motion.

They are drawn of results whose bodies have the names of [generate.NAME] kind = "deployable_ring".
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.pictures import heading, scaled
from coupling.reading import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

KINDS = ("chord_low", "chord_up", "batten", "outer", "inner")
COLORS = {"chord": "#0072B2", "batten": "#D55E00", "diagonal": "#009E73"}
WORDS = {"chord": "chords", "batten": "battens", "diagonal": "diagonals"}
FRACTIONS = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
MOVED = 0.02
"""Change of diameter, of itself, from which on a ring counts as deploying [-]."""
MOST_PATHS = 6
TURN, RATE = "#0072B2", "#c8321e"


class Members(NamedTuple):
    """Axes of the members of a ring over time, (frames, members, points, 3) [m], by colour."""

    time: Array
    chord: Array
    batten: Array
    diagonal: Array


def ring_of(results: Results) -> Members | None:
    """The members of a deployable ring, if the results are of one."""
    found = {kind: _bodies(results, kind) for kind in KINDS}
    if not all(found.values()) or len({len(names) for names in found.values()}) > 1:
        return None
    lines = {kind: _lines(results, names) for kind, names in found.items()}
    return Members(
        results["frames/time"],
        np.concatenate([lines["chord_low"], lines["chord_up"]], axis=1),
        lines["batten"],
        np.concatenate([lines["outer"], lines["inner"]], axis=1),
    )


def _bodies(results: Results, kind: str) -> list[str]:
    start = f"{kind}_"
    every = results.names("bodies")
    return sorted(name for name in every if name.startswith(start) and name[-1:].isdigit())


def _lines(results: Results, names: list[str]) -> Array:
    return np.stack([results[f"bodies/{name}/position"] for name in names], axis=1)


def diameters(ring: Members) -> Array:
    """(frames,) mean distance between opposite battens, seen from above [m]."""
    foot = ring.batten[:, :, 0, :2]
    opposite = np.roll(foot, foot.shape[1] // 2, axis=1)
    return np.linalg.norm(foot - opposite, axis=2).mean(axis=1)


def deploys(ring: Members) -> bool:
    """Whether the ring becomes wider in the run, as by deploying."""
    width = diameters(ring)
    return bool(np.ptp(width) > MOVED * width.max())


# -- sequence ----------------------------------------------------------------------------------


def draw_deployment(results: Results, figure: "Figure") -> None:
    """The ring from above and from aside at stages of its diameter."""
    ring = ring_of(results)
    assert ring is not None
    heading(results, figure, "deployment")
    width = diameters(ring)
    shown = stages(width)
    views = figure.subplots(2, len(shown))
    reach = 0.53 * width.max()
    for column, frame in enumerate(shown):
        low = ring.batten[frame].reshape(-1, 3)
        centre = 0.5 * (low.min(axis=0) + low.max(axis=0))
        share = 100.0 * width[frame] / width.max()
        views[0, column].set_title(f"{share:.0f} %\n{ring.time[frame]:.4g} s", loc="center")
        _draw_view(views[0, column], ring, frame, centre, np.eye(3)[:2], (reach, reach))
        _draw_view(views[1, column], ring, frame, centre, _aslant(), (reach, 0.62 * reach))
    _bar(views[0, 0], reach)
    handles = [_handle(kind) for kind in COLORS]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def stages(width: Array) -> list[int]:
    """Frames nearest to the shown fractions of the largest diameter, on the way to it."""
    until = int(np.argmax(width)) + 1
    share = width[:until] / width.max()
    return sorted({int(np.argmin(np.abs(share - f))) for f in FRACTIONS})


def _aslant() -> Array:
    """(2, 3) to the right and up, seen from 25 degrees above."""
    up = np.radians(25.0)
    return np.array([[1.0, 0.0, 0.0], [0.0, np.sin(up), np.cos(up)]])


def _draw_view(
    ax: "Axes", ring: Members, frame: int, centre: Array, basis: Array, reach: tuple[float, float]
) -> None:
    from matplotlib.collections import LineCollection

    for kind in ("diagonal", "chord", "batten"):
        flat = (getattr(ring, kind)[frame] - centre) @ basis.T
        ax.add_collection(LineCollection(list(flat), colors=COLORS[kind], linewidths=0.8))
    if basis[1, 2] == 0.0:
        feet = (ring.batten[frame, :, 0] - centre) @ basis.T
        ax.plot(*feet.T, "o", ms=2.0, color=COLORS["batten"])
    ax.set_xlim(-reach[0], reach[0])
    ax.set_ylim(-reach[1], reach[1])
    ax.set_aspect("equal")
    ax.set_axis_off()


def _bar(ax: "Axes", reach: float) -> None:
    length = 10.0 ** np.floor(np.log10(reach))
    x, y = -reach, -0.97 * reach
    ax.plot([x, x + length], [y, y], color="black", lw=2.0, solid_capstyle="butt")
    ax.text(x, y + 0.03 * reach, f"{length:g} m", fontsize=9)


def _handle(kind: str) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=COLORS[kind], label=WORDS[kind])


# -- paths -------------------------------------------------------------------------------------


def warms_or_cools(results: Results) -> bool:
    """Whether probes saw their temperature change."""
    return any(np.ptp(results[f"probes/{p}/temperature"]) > 1.0 for p in _probes(results))


def _probes(results: Results) -> list[str]:
    """Probes that recorded a motion and a temperature."""
    return [
        p
        for p in results.names("probes")
        if f"probes/{p}/position" in results
        and f"probes/{p}/temperature" in results
        and len(results[f"probes/{p}/position"]) > 2
    ][:MOST_PATHS]


def draw_paths(results: Results, figure: "Figure") -> None:
    """Where the probes are in the ring, and their ways from where they stood before the shock."""
    heading(results, figure, "paths of corners, hot to cold")
    ring, probes = ring_of(results), _probes(results)
    assert ring is not None
    columns = max((len(probes) + 1) // 2, 1)
    grid = figure.add_gridspec(2, columns + 1, width_ratios=[1.3, *[1.0] * columns])
    whole = figure.add_subplot(grid[:, 0])
    _draw_ring(whole, results, ring, probes)
    image: Any = None
    warm = [float(T) - 273.15 for p in probes for T in _course(results, p)[2]]
    for i, probe in enumerate(probes):
        place = figure.add_subplot(grid[i % 2, 1 + i // 2])
        image = _draw_path(place, results, probe, (min(warm), max(warm)))
    if image is not None:
        figure.colorbar(
            image, ax=figure.axes[1:], label="temperature of the corner [°C]", aspect=40
        )


def _draw_ring(ax: "Axes", results: Results, ring: Members, probes: list[str]) -> None:
    _, since = _since_shock(results, probes[0])
    frame = int(np.argmin(np.abs(ring.time - since)))
    points = ring.batten[frame].reshape(-1, 3)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = 0.55 * diameters(ring)[frame]
    _draw_view(ax, ring, frame, centre, _aslant(), (reach, 1.2 * reach))
    for i, probe in enumerate(probes):
        place = (_course(results, probe)[1][0] - centre) @ _aslant().T
        ax.plot(*place, "o", ms=6, color="#7b3294")
        ax.annotate(probe, tuple(place), xytext=(4, 6 - 18 * (i % 2)), textcoords="offset points")


def _draw_path(
    ax: "Axes", results: Results, probe: str, span: tuple[float, float]
) -> Any:  # fmt: skip
    """Radial and vertical displacement, coloured by temperature; returns what has the colours."""
    _, position, temperature = _course(results, probe)
    outward, up = _displacement(results, position)
    both = np.concatenate([outward, up])
    factor, unit = scaled(both, "m")
    ax.plot(factor * outward, factor * up, color="#c9ced4", lw=0.8, zorder=1)
    image = ax.scatter(
        factor * outward, factor * up, c=temperature - 273.15, cmap="coolwarm", s=9,
        vmin=span[0], vmax=span[1], zorder=2,
    )  # fmt: skip
    ax.set_title(f"{probe}: at most {factor * np.hypot(outward, up).max():.3g} {unit}")
    ax.set_xlabel(f"outward [{unit}]")
    ax.set_ylabel(f"up [{unit}]")
    return image


def _displacement(results: Results, position: Array) -> tuple[Array, Array]:
    """Outward and upward displacement (n,) [m] of a probe since its first row."""
    ring = ring_of(results)
    assert ring is not None
    middle = ring.batten[-1].reshape(-1, 3)
    centre = 0.5 * (middle.min(axis=0) + middle.max(axis=0))
    outward = position[0, :2] - centre[:2]
    outward = outward / np.linalg.norm(outward)
    away = position - position[0]
    return away[:, :2] @ outward, away[:, 2]


def _since_shock(results: Results, probe: str) -> tuple[int, float]:
    """Row and time [s] of the last temperature that is still the first one, of all probes."""
    time, rows = results[f"probes/{probe}/time"], []
    for name in _probes(results):
        warm = results[f"probes/{name}/temperature"]
        changed = np.flatnonzero(np.abs(warm - warm[0]) > 1e-6)
        rows.append(int(changed[0]) - 1 if changed.size else len(warm) - 1)
    first = max(min(rows), 0)
    return first, float(time[first])


def _course(results: Results, probe: str) -> tuple[Array, Array, Array]:
    """Time, position and temperature of a probe since the shock began."""
    table = results.table(f"probes/{probe}")
    first, _ = _since_shock(results, probe)
    return table["time"][first:], table["position"][first:], table["temperature"][first:]


# -- a hinge -----------------------------------------------------------------------------------


class Turning(NamedTuple):
    """Turn of a hinge since the start [rad] in every frame, and times of its changes of regime."""

    name: str
    time: Array
    angle: Array
    changes: Array


def has_hinges(results: Results) -> bool:
    """Whether hinges of chords have play."""
    return any(name.startswith("chord_") for name in results.names("joints"))


def liveliest_hinge(results: Results) -> Turning:
    """The hinge of a chord that turns most."""
    posts = len(_bodies(results, "batten"))
    found = []
    for chord in (*_bodies(results, "chord_low"), *_bodies(results, "chord_up")):
        for at in ("start", "end"):
            if f"joints/{chord}_{at}/regime" in results:
                found.append((f"{chord}_{at}", _turn(results, chord, at, posts)))
    name, angle = max(found, key=lambda one: float(np.ptp(one[1])))
    return Turning(name, results["frames/time"], angle, _changes(results, name))


def _turn(results: Results, chord: str, at: str, posts: int) -> Array:
    """(frames,) turn of an end of a chord on its post, about the normal of the panel."""
    number = chord.rpartition("_")[2]
    post = (int(number) + (at == "end")) % posts
    end, level = -(at == "end"), -chord.startswith("chord_up")
    journal = results[f"bodies/{chord}/axes"][:, end]
    bearing = results[f"bodies/batten_{post:0{len(number)}d}/axes"][:, level]
    inside = np.einsum("fij,fkj->fki", bearing, journal)  # axes of the chord in those of the post
    along, normal = inside[:, 0], inside[0, 1]
    sine = np.cross(along[0], along) @ normal
    return np.unwrap(np.arctan2(sine, along @ along[0]))


def _changes(results: Results, name: str) -> Array:
    """Times [s] at which a hinge goes between flight and contact, stick and slip."""
    time, regime = results[f"joints/{name}/time"], results[f"joints/{name}/regime"]
    return time[1:][np.diff(regime) != 0]


def draw_hinge(results: Results, figure: "Figure") -> None:
    """Angle and rate of a hinge over time, and its phase portrait with changes of regime."""
    hinge = liveliest_hinge(results)
    heading(results, figure, f"hinge {hinge.name}")
    rate = np.gradient(hinge.angle, hinge.time)
    factor, unit = scaled(hinge.angle, "rad")
    fast, speed = scaled(rate, "rad/s")
    left, right = figure.subplots(1, 2, width_ratios=[1.4, 1.0])
    left.plot(hinge.time, factor * hinge.angle, color=TURN)
    left.set_ylabel(f"turn since the start [{unit}]", color=TURN)
    left.set_xlabel("time [s]")
    beside = left.twinx()
    beside.plot(hinge.time, fast * rate, color=RATE, lw=0.7)
    beside.set_ylabel(f"rate [{speed}]", color=RATE)
    beside.grid(False)
    right.plot(factor * hinge.angle, fast * rate, color=TURN, lw=0.7)
    there = [np.interp(hinge.changes, hinge.time, course) for course in (hinge.angle, rate)]
    right.plot(factor * there[0], fast * there[1], "o", ms=2.5, color=RATE)
    right.set_title(f"{hinge.changes.size} changes between flight, stick and slip")
    right.set_xlabel(f"turn [{unit}]")
    right.set_ylabel(f"rate [{speed}]")
