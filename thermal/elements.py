"""From a description to the finite element terms of ``thermal.line``."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.circumference import cardinal, half_cosine_loads
from thermal.description import Description, Member, Part
from thermal.discretisation import Block
from thermal.layout import arclength
from thermal.terms import Along, Around, Storage

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Regions = Mapping[str, Indices]


class Line(NamedTuple):
    """Linear elements along one member.

    shape : (2, n_e, q) float  shape functions at Gauss points
    stiffness : (n_e, q) float [1/m]  Gauss weight times squared slope of the shape functions
    lengths : (n_s,) float [m]  length of member that belongs to each station
    """

    shape: Array
    stiffness: Array
    lengths: Array


def discretise(members: Sequence[Member]) -> dict[str, Line]:
    """Linear elements of each member, from one scikit-fem mesh of all of them."""
    if not members:
        return {}
    from skfem import Basis, ElementLineP1, LinearForm, MeshLine

    vertices, elements, last = _chain(members)
    mesh = MeshLine(vertices[None, :], elements)
    basis = Basis(mesh, ElementLineP1(), intorder=3)
    shape = np.stack([np.broadcast_to(b[0], basis.dx.shape) for b in basis.basis])
    stiffness = basis.dx * np.asarray(basis.basis[1][0].grad[0]) ** 2
    at_stations = (np.array([[0.0, 1.0]]), np.array([0.5, 0.5]))
    trapezoids = Basis(mesh, ElementLineP1(), quadrature=at_stations)
    lengths = np.split(LinearForm(lambda v, _: v).assemble(trapezoids), last[:-1])
    bounds = (last - np.arange(1, len(last) + 1))[:-1]  # a member has one element less
    shapes, stiffnesses = np.split(shape, bounds, axis=1), np.split(stiffness, bounds)
    lines = zip(shapes, stiffnesses, lengths, strict=True)
    return {m.name: Line(*line) for m, line in zip(members, lines, strict=True)}


def _chain(members: Sequence[Member]) -> tuple[Array, Indices, Indices]:
    """Stations on one axis with gaps between members, elements (2, n_e), ends of members."""
    along = [arclength(m.points) for m in members]
    offsets = np.cumsum([0.0] + [1.001 * s[-1] for s in along[:-1]])
    last = np.cumsum([len(s) for s in along])
    near = np.setdiff1d(np.arange(last[-1]), last - 1)
    vertices = np.concatenate([s + o for s, o in zip(along, offsets, strict=True)])
    return vertices, np.stack([near, near + 1]), last


def bulk_terms(
    description: Description, lines: Mapping[str, Line], regions: Regions
) -> tuple[list[Storage], list[Around], list[Along]]:
    """Storage and conduction; members with the same material and wall points are one term."""
    stored = _parts_storage(description.parts, regions)
    around, along = [], []
    for members in _alike(description.members):
        own = [lines[m.name] for m in members]
        stored.append(_storage(members, own, regions))
        along.append(_along(members, own, regions))
        if members[0].wall_points > 1:
            around.append(_around(members, own, regions))
    return stored, around, along


def _alike(members: Sequence[Member]) -> list[list[Member]]:
    groups: dict[tuple[int, int], list[Member]] = {}
    for m in members:
        groups.setdefault((id(m.material), m.wall_points), []).append(m)
    return list(groups.values())


def _parts_storage(parts: Sequence[Part], regions: Regions) -> list[Storage]:
    groups: dict[int, list[Part]] = {}
    for p in parts:
        groups.setdefault(id(p.material), []).append(p)
    return [
        Storage(
            np.stack([regions[p.name] for p in group]),
            np.array([p.mass for p in group], dtype=float),
            np.ones((1, 1)),
            group[0].material,
            (group[0].material.heat_capacity,),
        )
        for group in groups.values()
    ]


def _storage(members: Sequence[Member], lines: Sequence[Line], regions: Regions) -> Storage:
    material = members[0].material
    return Storage(
        np.concatenate([_stations(m, regions) for m in members]),
        material.density * np.concatenate(_volumes(members, lines)),
        cardinal(members[0].wall_points).values,
        material,
        (material.heat_capacity, material.conductivity),
    )


def _around(members: Sequence[Member], lines: Sequence[Line], regions: Regions) -> Around:
    volumes = zip(_volumes(members, lines), members, strict=True)
    return Around(
        np.concatenate([_stations(m, regions) for m in members]),
        np.concatenate([volume / m.section.radius**2 for volume, m in volumes]),
        *cardinal(members[0].wall_points),
        members[0].material,
    )


def _along(members: Sequence[Member], lines: Sequence[Line], regions: Regions) -> Along:
    stations = [_stations(m, regions) for m in members]
    areas = [m.section.area / _angles(m) for m in members]
    stiffness = [a * line.stiffness for a, line in zip(areas, lines, strict=True)]
    return Along(
        np.concatenate([np.hstack([dofs[:-1], dofs[1:]]) for dofs in stations]),
        np.concatenate([line.shape for line in lines], axis=1),
        np.concatenate(stiffness),
        cardinal(members[0].wall_points).values,
        members[0].material,
    )


def _stations(m: Member, regions: Regions) -> Indices:
    return regions[m.name].reshape(-1, m.wall_points)


def _angles(m: Member) -> int:
    return len(cardinal(m.wall_points).values)


def _volumes(members: Sequence[Member], lines: Sequence[Line]) -> list[Array]:
    """Volume [m^3] that belongs to each angle of each station, per member."""
    pairs = zip(members, lines, strict=True)
    return [m.section.area / _angles(m) * line.lengths for m, line in pairs]


def outer_face(m: Member, line: Line, regions: Regions) -> Block:
    """The outer face of a member, at angles round each station."""
    values = cardinal(m.wall_points).values
    angles, stations = len(values), len(m.points)
    share = m.section.outer_perimeter / angles
    phi = 2.0 * np.pi / angles * np.arange(angles)
    axes = np.asarray(m.axes, dtype=float)
    normals = np.cos(phi)[:, None] * axes[:, None, 1] + np.sin(phi)[:, None] * axes[:, None, 2]
    points = np.asarray(m.points, dtype=float)[:, None] + 0.5 * m.section.height * normals
    return Block(
        _stations(m, regions),
        values,
        np.repeat(share * line.lengths[:, None], angles, axis=1),
        points,
        normals,
        np.empty((stations, 0, 3)),
    )


def absorbing_loads(m: Member, line: Line, regions: Regions, direction: Array | None) -> Array:
    """(n,) [m^2]  by which a flux density is absorbed."""
    loads = np.zeros(_size(regions))
    widths = absorbing_widths(m, direction)
    loads[regions[m.name]] = (widths * line.lengths[:, None]).ravel()
    return loads


def _size(regions: Regions) -> int:
    return sum(len(nodes) for nodes in regions.values())


def absorbing_widths(member: Member, direction: Array | None) -> Array:
    """(stations, wall_points) [m]  absorbing width of the outer contour, each point's share.

    Parallel rays see a round contour by its diameter and others by the rectangle of their height
    and width, times the sine of the angle between rays and member.
    """
    n, section = member.wall_points, member.section
    if direction is None:
        return np.full((len(member.points), n), section.outer_perimeter / n)
    rays = np.asarray(direction, dtype=float)
    facing = -np.asarray(member.axes, dtype=float)[:, 1:] @ (rays / np.linalg.norm(rays))
    across = np.hypot(facing[:, 0], facing[:, 1])[:, None]
    if n > 1:
        phase = np.arctan2(facing[:, 1], facing[:, 0])
        return 0.5 * section.height * across * half_cosine_loads(n, phase)
    if section.kind in ("tube", "circle"):
        return section.height * across
    return np.abs(facing) @ np.array([[section.width], [section.height]])
