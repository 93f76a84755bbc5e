"""Faces of members: strips of the outline between half stations, and end sections."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshes.sections import Section
from thermal.description import Member
from thermal.discretisation import Block, Face
from thermal.profiles import (
    GRADIENTS,
    Contour,
    inner_contour,
    outer_contour,
    profile,
    values_at,
    wall_offsets,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CORNERS = 24  # of the polygon that stands for a round section; a multiple of 4


def contour(m: Member, face: str, fine: bool) -> Contour:
    """Outline of the face "outer" or "inner"."""
    make = inner_contour if face == "inner" else outer_contour
    return make(m.section, m.wall_points, fine)


def lengthwise_face(m: Member, face: str, fine: bool, dofs: Indices, lengths: Array) -> Face:
    """Faces "outer" and "inner": for each point of the outline a block with one strip a station.

    dofs : (stations, N) intp
    lengths : (stations,) float [m]  of each strip
    """
    outline = contour(m, face, fine)
    points, normals = section_points(m, outline.offsets), directions(m, outline.normals)
    corners = polygons(_halfway(section_points(m, outline.first)),
                       _halfway(section_points(m, outline.last)), face)  # fmt: skip
    values = values_at(m.section, m.wall_points, outline.offsets)
    return [
        Block(
            dofs, values[p : p + 1], width * lengths[:, None],
            points[:, p : p + 1], normals[:, p : p + 1], corners[:, p],
        )
        for p, width in enumerate(outline.lengths)
    ]  # fmt: skip


def end_face(m: Member, face: str, dofs: Indices) -> Face:
    """Faces "start" and "end"; ``dofs`` (1, N) of that station."""
    station = 0 if face == "start" else len(m.points) - 1
    frame = np.asarray(m.axes, dtype=float)[station]
    pieces = _sectors(m.section, m.wall_points) if m.section.kind == "tube" else [_whole(m)]
    turn, normal = (-1, -frame[0]) if face == "start" else (1, frame[0])
    origin = np.asarray(m.points, dtype=float)[station]
    return [
        Block(
            dofs, values_at(m.section, m.wall_points, points), area[None],
            (origin + points @ frame[1:])[None], np.tile(normal, (1, len(points), 1)),
            (origin + corners[::turn] @ frame[1:])[None],
        )
        for points, area, corners in pieces
    ]  # fmt: skip


def section_points(m: Member, offsets: Array) -> Array:
    """(stations, P, 3) [m]  of points (P, 2) of the section."""
    return np.asarray(m.points, dtype=float)[:, None] + directions(m, offsets)


def directions(m: Member, components: Array) -> Array:
    """(stations, P, 3)  of components (P, 2) along e2 and e3."""
    return np.einsum("pk,skc->spc", components, np.asarray(m.axes, dtype=float)[:, 1:])


def polygons(first: Array, last: Array, face: str) -> Array:
    """(n, P, 4, 3)  between neighbours of (n + 1, P, 3), turning about the outward normal."""
    corners = np.stack([first[:-1], last[:-1], last[1:], first[1:]], axis=2)
    return corners[:, :, ::-1] if face == "inner" else corners


def _halfway(x: Array) -> Array:
    return np.concatenate([x[:1], 0.5 * (x[:-1] + x[1:]), x[-1:]])


Piece = tuple[Array, Array, Array]
"""Points (p, 2), their areas (p,) and the corners (c, 2) of a part of a section."""


def _sectors(section: Section, n: int) -> Sequence[Piece]:
    """Of a tube's section; the points are on the mean surface."""
    outer, inner = outer_contour(section, n), inner_contour(section, n)
    middle = 0.5 * (outer.offsets + inner.offsets)
    area = np.array([section.area / len(middle)])
    corners = np.stack([inner.first, outer.first, outer.last, inner.last], axis=1)
    return [(middle[p : p + 1], area, corners[p]) for p in range(len(middle))]


def _whole(m: Member) -> Piece:
    section, n = m.section, GRADIENTS if m.wall_points == GRADIENTS else 1
    corners = section.outline(CORNERS if section.kind == "circle" else 4)
    points = wall_offsets(section, n)
    return points, np.full(len(points), section.area / len(profile(n).values)), corners
