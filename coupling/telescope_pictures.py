"""Pictures of a tube in a tube: how it stands and where it touches, how its surfaces stick."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.contact_pictures import REGIME_COLORS, REGIMES
from coupling.contact_places import contact_groups, located, nearest_row, placement
from coupling.pictures import heading
from coupling.reading import Results
from coupling.surfaces import Body, read_bodies

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

FREE, IMPACT, SLIP, STICK = range(4)
"""Regimes of contacts, columns of ``contacts/shares``."""
COLUMNS = 150
"""Intervals of time of a map of stick and slip."""
SEEN = 0.02
"""Share of an interval that a regime must have for its mark."""
INNER, OUTER, TOUCH = "#1e9e4a", "#8fb0de", "#E8590C"
"""Colours of the tube inside, of the one around it, of contacts."""


class Standing(NamedTuple):
    """A telescope at one time.

    time : float [s];  frame : of the recorded ones
    travel : float [m]  of the inner tube along the outer one since the start
    overlap : float [m]
    offset : float [m]  largest distance of the axis of either tube from where it was at the start,
        across it
    temperature : float [K]  mean of both tubes; nan where there is none
    points : (k, 3) float [m]  contacts
    counts : (4,) int  contacts of each regime within the coupling window; the last three touch
    inside : elements of the inner tube that are in the outer one, elements of that around it
    """

    time: float
    frame: int
    travel: float
    overlap: float
    offset: float
    temperature: float
    points: Array
    counts: NDArray[np.intp]
    inside: tuple[int, int]

    @property
    def state(self) -> str:
        """What most of the touching contacts do."""
        touching = self.counts[IMPACT:]
        return REGIMES[IMPACT + int(np.argmax(touching))] if touching.any() else "no contact"


class Surfaces(NamedTuple):
    """Contacts on both surfaces over intervals of time.

    edges : (b + 1,) float [s];  shares : (b, c, 4) float  of each interval and contact
    inner, outer : (b, c) float [m]  along the tubes
    """

    edges: Array
    shares: Array
    inner: Array
    outer: Array

    def slipping(self) -> float:
        """Slip over all contact but impacts, by duration [-]; nan without any."""
        stick, slip = (float(self.shares[..., code].sum()) for code in (STICK, SLIP))
        return slip / (stick + slip) if stick + slip else np.nan


# ------------------------------------------------------------------------------- snapshot


def standing(results: Results, joint: str, time: float = np.inf) -> Standing:
    """How a telescope stands in the recorded frame nearest to a time [s], by default the last."""
    contacts = contact_groups(results)[joint]
    times = results["frames/time"]
    frame = int(np.argmin(np.abs(times - min(time, times[-1]))))
    inner, outer = _tubes(results, contacts)
    start, end = _reach(results, contacts, times[frame])
    codes = _codes(results, contacts, times[frame])
    along = _along(outer)
    low, high = max(min(start, end), 0.0), min(max(start, end), along[-1])
    own = start + (end - start) * _along(inner) / _along(inner)[-1]
    return Standing(
        float(times[frame]),
        frame,
        abs(start - _reach(results, contacts, times[0])[0]),
        max(high - low, 0.0),
        max(_offset(tube, frame) for tube in (inner, outer)),
        _temperature((inner, outer), frame),
        _points(results, contacts, codes, frame),
        np.bincount(codes, minlength=4),
        (_between(own, 0.0, along[-1]), _between(along, low, high)),
    )


def draw_snapshot(
    results: Results, figure: "Figure", joint: str, time: float = np.inf
) -> None:  # fmt: skip
    """Three orthogonal projections with the contacts, and a view in space; directions stretched."""
    stands = standing(results, joint, time)
    heading(results, figure, f"{joint} at {stands.time:g} s")
    tubes = _tubes(results, contact_groups(results)[joint])
    halves: Any = figure.subfigures(1, 2, width_ratios=[1.0, 1.25])
    left, right = halves
    for ax, (i, j) in zip(left.subplots(3, 1), ((0, 1), (0, 2), (1, 2)), strict=True):
        _projection(ax, tubes, stands, i, j)
    _in_space(right, tubes, stands)


def _tubes(results: Results, contacts: list[str]) -> tuple[Body, Body]:
    """Inner and outer tube."""
    attributes = results.attributes(f"joints/{contacts[0]}")
    bodies = {body.name: body for body in read_bodies(results)}
    return bodies[str(attributes["journal_body"])], bodies[str(attributes["bearing_body"])]


def _along(body: Body) -> Array:
    """(n,) [m]  of the nodes from the start, in the first frame."""
    steps = np.linalg.norm(np.diff(body.position[0], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _reach(results: Results, contacts: list[str], time: float) -> tuple[float, float]:
    """Places [m] on the outer tube of start and end of the inner one, straight on beyond it."""
    described = {name: results.attributes(f"joints/{name}") for name in contacts}
    own = {n: float(known["station"]) for n, known in described.items() if "mouth" not in known}
    inner, outer = (_along(tube)[-1] for tube in _tubes(results, contacts))
    found = {name: _at(results, name, "place", time) for name in own}
    names = sorted(own, key=lambda name: own[name])
    sign = 1.0 if found[names[-1]] >= found[names[0]] else -1.0
    inside = [name for name in names if 0.0 <= found[name] <= outer] or names
    start = float(found[inside[0]] - sign * own[inside[0]])
    return start, start + sign * inner


def _at(results: Results, contact: str, column: str, time: float) -> float:
    group = f"joints/{contact}"
    return float(np.interp(time, results[f"{group}/time"], results[f"{group}/{column}"]))


def _codes(results: Results, contacts: list[str], time: float) -> NDArray[np.intp]:
    """(c,) regime of each contact in the window that ends at or after a time; one that touches in
    it counts as touching."""
    windows = results["contacts/time"]
    at = min(int(np.searchsorted(windows, time - 1e-9)), len(windows) - 1)
    numbers = [int(results.attributes(f"joints/{name}")["number"]) for name in contacts]
    shares = results["contacts/shares"][at, numbers]
    touching = shares[:, IMPACT:]
    return np.where(touching.any(axis=1), IMPACT + np.argmax(touching, axis=1), FREE)


def _points(
    results: Results, contacts: list[str], codes: NDArray[np.intp], frame: int
) -> Array:  # fmt: skip
    """(k, 3) [m]  where surfaces touch."""
    bodies = {body.name: body for body in read_bodies(results)}
    time = results["frames/time"][frame]
    found = []
    for name, code in zip(contacts, codes, strict=True):
        place = placement(results, name, bodies) if code != FREE else None
        if place is None:
            continue
        where = located(place, frame, nearest_row(results.table(f"joints/{name}"), time))
        radius = float(results.attributes(f"joints/{name}")["radius"])
        size = max(float(np.linalg.norm(where.gap)), 1e-300)
        found.append(where.centre + where.gap * (1.0 + radius / size))
    return np.array(found).reshape(-1, 3)


def _offset(body: Body, frame: int) -> float:
    line = body.position[0, -1] - body.position[0, 0]
    line = line / np.linalg.norm(line)
    away = body.position[frame] - body.position[0, 0]
    return float(np.linalg.norm(away - np.outer(away @ line, line), axis=1).max())


def _temperature(bodies: tuple[Body, Body], frame: int) -> float:
    known = [b.temperature[frame, :, 0].mean() for b in bodies if b.temperature is not None]
    return float(np.mean(known)) if known else np.nan


def _between(places: Array, low: float, high: float) -> int:
    """Intervals between places that lie within two others."""
    inside = (places >= low - 1e-6) & (places <= high + 1e-6)
    return int(np.count_nonzero(inside[1:] & inside[:-1]))


def _projection(
    ax: "Axes", tubes: tuple[Body, Body], stands: Standing, i: int, j: int
) -> None:  # fmt: skip
    """Axes and outlines of both tubes, and the contacts, seen along the third direction."""
    for tube, color, width in _styles(tubes):
        points, radius = tube.position[stands.frame], _radius(tube)
        ax.plot(points[:, i], points[:, j], color=color, lw=width)
        for shift in (-radius, radius):
            ax.plot(points[:, i], points[:, j] + shift, color=color, lw=0.25 * width)
    if len(stands.points):
        ax.plot(stands.points[:, i], stands.points[:, j], "o", color=TOUCH, ms=4, zorder=5)
    reach = _frame_of(tubes, stands)
    middle = tubes[1].position[0, 0]
    if i:
        ax.set_xlim(middle[i] - reach, middle[i] + reach)
    ax.set_ylim(middle[j] - reach, middle[j] + reach)
    ax.set_xlabel(f"{'xyz'[i]} [m]")
    ax.set_ylabel(f"{'xyz'[j]} [m]")


def _radius(tube: Body) -> float:
    """Outer radius [m]."""
    return 0.0 if tube.section is None else 0.5 * float(np.ptp(tube.section.outline(24), axis=0)[1])


def _frame_of(tubes: tuple[Body, Body], stands: Standing) -> float:
    """Half of what is shown across the tubes [m]."""
    return 1.1 * (stands.offset + _radius(tubes[1])) or 1.0


def _styles(tubes: tuple[Body, Body]) -> list[tuple[Body, str, float]]:
    """The outer tube, broad, then the inner one upon it: colours and widths of lines."""
    return [(tubes[1], OUTER, 4.0), (tubes[0], INNER, 1.8)]


def _in_space(figure: Any, tubes: tuple[Body, Body], stands: Standing) -> None:
    ax = figure.add_axes((0.0, 0.02, 0.9, 0.86), projection="3d")
    for tube, color, width in _styles(tubes):
        ax.plot(*tube.position[stands.frame].T, color=color, lw=1.5 * width, label=tube.name)
    if len(stands.points):
        ax.plot(*stands.points.T, "o", color=TOUCH, ms=4, label="contacts")
    reach = _frame_of(tubes, stands)
    middle = tubes[1].position[0, 0]
    ax.set_ylim(middle[1] - reach, middle[1] + reach)
    ax.set_zlim(middle[2] - reach, middle[2] + reach)
    ax.locator_params(axis="y", nbins=5)
    ax.locator_params(axis="z", nbins=5)
    ax.set_box_aspect((2.2, 1.0, 1.0), zoom=1.0)
    for axis in "xyz":
        getattr(ax, f"set_{axis}label")(f"{axis} [m]")
    ax.legend(loc="upper right", fontsize=11)
    figure.text(0.03, 0.97, _words(tubes, stands), va="top", fontsize=11, linespacing=1.5)


def _words(tubes: tuple[Body, Body], stands: Standing) -> str:
    """State, temperature, numbers of contacts and elements."""
    touching = {REGIMES[code]: int(stands.counts[code]) for code in (STICK, SLIP, IMPACT)}
    each = ", ".join(f"{count} {name}" for name, count in touching.items() if count)
    lines = [f"state: {stands.state}", f"contacts: {sum(touching.values())}" + f"   {each}"]
    if np.isfinite(stands.temperature):
        lines.insert(1, f"mean temperature: {stands.temperature - 273.15:.1f} °C")
    lines += [
        f"travel {stands.travel:.2f} m, overlap {stands.overlap:.2f} m",
        f"off the axis: at most {stands.offset:.3g} m",
        f"elements of {tubes[0].name} inside: {stands.inside[0]}, of {tubes[1].name} around it: "
        f"{stands.inside[1]}",
    ]
    return "\n".join(lines).replace("-", "\N{MINUS SIGN}")


# ------------------------------------------------------------------------ stick and slip


def surfaces(results: Results, joint: str, end: float = np.inf) -> Surfaces:
    """Contacts of a telescope on both surfaces up to a time [s]."""
    contacts = contact_groups(results)[joint]
    windows = results["contacts/time"]
    edges = np.concatenate([[0.0], windows[windows <= end + 1e-9]])
    edges = edges[:: max(1, -(-(len(edges) - 1) // COLUMNS))]
    each = [_surface(results, name, edges) for name in contacts]
    shares, inner, outer = (np.stack(parts, axis=1) for parts in zip(*each, strict=True))
    return Surfaces(edges, shares, inner, outer)


def _surface(results: Results, contact: str, edges: Array) -> tuple[Array, Array, Array]:
    """Shares (b, 4), and places (b,) [m] on both tubes."""
    known = results.attributes(f"joints/{contact}")
    windows, number = results["contacts/time"], int(known["number"])
    sizes = np.diff(windows, prepend=0.0)[:, None]
    spent = np.cumsum(results["contacts/shares"][:, number] * sizes, axis=0)
    spent = np.concatenate([np.zeros((1, 4)), spent])
    ends = np.concatenate([[0.0], windows])
    at_edges = np.stack([np.interp(edges, ends, column) for column in spent.T], axis=1)
    shares = np.diff(at_edges, axis=0) / np.diff(edges)[:, None]
    middle = 0.5 * (edges[1:] + edges[:-1])
    table = results.table(f"joints/{contact}")
    place = np.interp(middle, table["time"], table["place"])
    own = np.full_like(place, float(known["station"]))
    return (shares, place, own) if "mouth" in known else (shares, own, place)


def draw_surfaces(results: Results, figure: "Figure", joint: str) -> None:
    """Where the surfaces of both tubes stick (squares) and slip (crosses), and how many contacts
    do."""
    found = surfaces(results, joint)
    inner, outer = _tubes(results, contact_groups(results)[joint])
    share = found.slipping()
    text = "" if np.isnan(share) else f"; slip is {100.0 * share:.0f} % of stick and slip"
    heading(results, figure, f"stick and slip in {joint}{text}")
    axes = figure.subplot_mosaic([["inner", "outer"], ["count", "count"]], height_ratios=[3, 1])
    sides = (
        ("inner", found.inner, f"outer surface of {inner.name}", INNER),
        ("outer", found.outer, f"inner surface of {outer.name}", "#1f4e9c"),
    )
    for key, places, title, color in sides:
        _marks(axes[key], found, places, color)
        axes[key].set_title(title)
        axes[key].set_ylabel("along it [m]")
        axes[key].set_xlabel("time [s]")
        axes[key].legend(loc="lower right", bbox_to_anchor=(1.02, 0.985), ncols=2)
    _count(axes["count"], found)


def _marks(ax: "Axes", found: Surfaces, places: Array, color: str) -> None:
    middle = np.broadcast_to(0.5 * (found.edges[1:] + found.edges[:-1])[:, None], places.shape)
    styles: tuple[tuple[int, dict[str, Any]], ...] = (
        (STICK, {"marker": "s", "facecolors": "none", "edgecolors": color}),
        (SLIP, {"marker": "x", "color": color}),
    )
    for code, style in styles:
        here = found.shares[..., code] > SEEN
        ax.scatter(
            middle[here], places[here], s=14, linewidths=0.7, label=REGIMES[code],
            rasterized=True, **style,
        )  # fmt: skip
    ax.set_xlim(found.edges[0], found.edges[-1])


def _count(ax: "Axes", found: Surfaces) -> None:
    """Mean number of contacts in each interval, by regime."""
    bottom = np.zeros(len(found.edges) - 1)
    for code in (STICK, SLIP, IMPACT):
        top = bottom + found.shares[..., code].sum(axis=1)
        ax.stairs(
            top, found.edges, baseline=bottom, fill=True, color=REGIME_COLORS[code],
            label=REGIMES[code],
        )  # fmt: skip
        bottom = top
    ax.set_xlim(found.edges[0], found.edges[-1])
    ax.set_ylim(bottom=0.0)
    ax.set_title("number of contacts, mean")
    ax.set_xlabel("time [s]")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05))
