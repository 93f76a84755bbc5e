"""Where the temperatures of a description sit, and which of them are given over time.

All solvers read a description alike, so that one can stand in for another; what they make of
it numerically is their own.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.description import (
    Description,
    Faces,
    Field,
    Fixed,
    History,
    Member,
    Place,
    Sheet,
    Wall,
)
from thermal.discretisation import GivenTemperatures
from thermal.profiles import extent, wall_offsets
from thermal.profiles import wall_angles as wall_angles

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

STATION_TOLERANCE = 1e-9  # of a member's length: how near to a stretch a station belongs to it


class Layout(NamedTuple):
    """Numbering of the temperatures: members in order, then parts, then sheets.

    x : (n, 3) float [m]  reference positions
    regions : name of member, part or sheet -> (k,) its temperatures; a member station by station,
        each station by angle; a sheet node by node, each with the face of its normal first
    initial : (n,) float [K]
    """

    x: Array
    regions: dict[str, Indices]
    initial: Array


class Given(NamedTuple):
    """Temperatures that one condition prescribes: weights @ histories(t).

    nodes : (k,) intp
    weights : (k, n_h) float
    histories : n_h functions of time [K]
    """

    name: str
    nodes: Indices
    weights: Array
    histories: tuple[History, ...]

    def at(self, t: float) -> Array:
        """(k,) [K]"""
        return self.weights @ np.array([history(t) for history in self.histories])


class GivenField(NamedTuple):
    """Temperatures that a field prescribes, at the positions (k, 3) [m] of its nodes."""

    name: str
    nodes: Indices
    x: Array
    temperature: Callable[[Array, float], Array]

    def at(self, t: float) -> Array:
        """(k,) [K]"""
        return self.temperature(self.x, t)


def layout(description: Description) -> Layout:
    """Number the temperatures of a description."""
    things = [(m.name, wall_positions(m), m.initial) for m in description.members]
    things += [(p.name, np.reshape(p.position, (1, 3)), p.initial) for p in description.parts]
    things += [(s.name, face_positions(s), s.initial) for s in description.sheets]
    ends = np.cumsum([0] + [len(x) for _, x, _ in things])
    return Layout(
        np.vstack([np.asarray(x, dtype=float) for _, x, _ in things]),
        {name: np.arange(a, b) for (name, _, _), a, b in zip(things, ends, ends[1:], strict=False)},
        np.concatenate([np.full(len(x), float(T)) for _, x, T in things]),
    )


def wall_positions(member: Member) -> Array:
    """(stations * wall_points, 3) [m]  see ``thermal.profiles``."""
    points, axes = np.asarray(member.points, dtype=float), np.asarray(member.axes, dtype=float)
    offsets = wall_offsets(member.section, member.wall_points)
    across = np.einsum("kp,spc->skc", offsets, axes[:, 1:])
    return (points[:, None] + across).reshape(-1, 3)


def face_positions(sheet: Sheet) -> Array:
    """(2 n, 3) [m]  on both faces at every node, that of the normal first."""
    normals = np.cross(sheet.surface.d_u, sheet.surface.d_v)
    normals *= 0.5 * sheet.thickness / np.linalg.norm(normals, axis=1, keepdims=True)
    points = sheet.surface.points
    return np.stack([points + normals, points - normals], axis=1).reshape(-1, 3)


def node_areas(sheet: Sheet) -> Array:
    """(n,) [m^2]  of the middle surface, by trapezoids over the elements."""
    surface = sheet.surface
    density = np.linalg.norm(np.cross(surface.d_u, surface.d_v), axis=1)
    shares = 0.25 * np.prod(surface.sizes, axis=1, keepdims=True) * density[surface.quads]
    areas = np.zeros(len(surface.points))
    np.add.at(areas, surface.quads, shares)
    return areas


def arclength(points: Array) -> Array:
    """(n,) [m]  along the polygon through ``points``, from its first."""
    steps = np.linalg.norm(np.diff(np.asarray(points, dtype=float), axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def place_nodes(description: Description, regions: Mapping[str, Indices], place: Place) -> Indices:
    """The temperatures at a place: of a part one, of a member's end all round the section."""
    nodes = regions[place.name]
    if place.end is None:
        return nodes
    if place.end in ("top", "bottom"):  # of a sheet, in turn
        return nodes[("top", "bottom").index(place.end) :: 2]
    n = next(m.wall_points for m in description.members if m.name == place.name)
    return nodes[:n] if place.end == "start" else nodes[-n:]


def stations_within(member: Member, wall: Wall) -> NDArray[np.intp]:
    """Stations of a member that lie on the stretch of a wall condition."""
    s = arclength(member.points)
    slack = STATION_TOLERANCE * s[-1]
    return np.flatnonzero((s >= wall.start - slack) & (s <= wall.end + slack))


def given(
    description: Description, regions: Mapping[str, Indices], x: Array
) -> list[GivenTemperatures]:
    """Prescribed temperatures, in the order of the conditions."""
    members = {m.name: m for m in description.members}
    found: list[GivenTemperatures] = []
    for c in description.conditions:
        if isinstance(c, Wall):
            found.append(_given_by_wall(c, members[c.member], regions[c.member]))
        elif isinstance(c, Faces):
            nodes = regions[c.sheet]
            weights = np.tile(np.eye(2), (len(nodes) // 2, 1))
            found.append(Given(c.name, nodes, weights, (c.hot, c.cold)))
        elif isinstance(c, Field):
            nodes = regions[c.body]
            found.append(GivenField(c.name, nodes, x[nodes], c.temperature))
        elif isinstance(c, Fixed):
            nodes = place_nodes(description, regions, c.place)
            found.append(Given(c.name, nodes, np.ones((len(nodes), 1)), (c.temperature,)))
    return found


def given_nodes(conditions: Sequence[GivenTemperatures]) -> Indices:
    """All prescribed temperatures, in the order of the conditions."""
    return np.concatenate([np.empty(0, np.intp), *(g.nodes for g in conditions)])


def _given_by_wall(wall: Wall, member: Member, nodes: Indices) -> Given:
    """(hot + cold)/2 + (hot - cold)/2 n.side, each linear from start to end of the stretch."""
    stations = stations_within(member, wall)
    s = arclength(member.points)[stations]
    length = wall.end - wall.start
    along = np.clip((s - wall.start) / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(s))
    hotness = 0.5 + 0.5 * _facing(member, wall.side)[stations]
    ramps = np.stack([1.0 - along, along], axis=1)[:, None, :]
    weights = np.concatenate([hotness[..., None] * ramps, (1.0 - hotness[..., None]) * ramps], 2)
    return Given(
        wall.name,
        nodes.reshape(len(member.points), member.wall_points)[stations].ravel(),
        weights.reshape(-1, 4),
        (*wall.hot, *wall.cold),
    )


def _facing(member: Member, side: Array | None) -> Array:
    """(stations, wall_points)  how far towards ``side`` of the extent to either side."""
    if side is None or member.wall_points == 1:
        return np.zeros((len(member.points), member.wall_points))
    inplane = np.asarray(member.axes, dtype=float)[:, 1:] @ np.asarray(side, dtype=float)
    inplane /= np.linalg.norm(inplane, axis=1, keepdims=True)
    reached = inplane @ wall_offsets(member.section, member.wall_points).T
    return reached / extent(member.section, inplane)[:, None]
