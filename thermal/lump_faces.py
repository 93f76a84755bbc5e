"""Faces of the lumps of ``thermal.lumped``: to each lump its own piece of a face."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from thermal.description import Member, Part, Sheet
from thermal.discretisation import Block, Face
from thermal.layout import face_positions, wall_positions
from thermal.network import cell_lengths
from thermal.profiles import (
    GRADIENTS,
    Contour,
    inner_contour,
    outer_contour,
    values_at,
    wall_angles,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Regions = Mapping[str, Indices]

PIECES = 12  # of the end of a tube of one temperature


def member_face(m: Member, nodes: Indices, face: str) -> Face:
    """The face "outer", "inner", "start" or "end" of a member."""
    if face in ("start", "end"):
        return _end(m, nodes, face)
    n = m.wall_points
    if n > GRADIENTS:
        middle, half = m.section.radius, 0.5 * m.section.thickness
        radius, sign = (middle + half, 1.0) if face == "outer" else (middle - half, -1.0)
        return [_along(m, _arcs(radius, sign, n), nodes.reshape(-1, 1), np.ones((1, 1)))]
    contour = (outer_contour if face == "outer" else inner_contour)(m.section, n)
    if n == 1:
        dofs = np.repeat(nodes, len(contour.lengths))[:, None]
        return [_along(m, contour, dofs, np.ones((1, 1)))]
    values = values_at(m.section, n, contour.offsets)
    dofs = nodes.reshape(-1, n)
    return [
        _along(m, Contour(*(x[i : i + 1] for x in contour)), dofs, values[i : i + 1])
        for i in range(len(values))
    ]


def part_face(p: Part, nodes: Indices) -> Face:
    """The area of a part; as a lump has no shape, its normal is zero."""
    point = np.reshape(np.asarray(p.position, dtype=float), (1, 1, 3))
    area, none = np.array([[float(p.area)]]), np.zeros((1, 1, 3))
    return [Block(nodes[:, None], np.ones((1, 1)), area, point, none, np.empty((1, 0, 3)))]


def sheet_face(s: Sheet, nodes: Indices, face: str) -> Face:
    """The face "top" or "bottom" of a sheet, a quarter of each element to each of its corners.

    As all of a thin shell, it has the areas of the middle surface.
    """
    side, sign = (0, 1.0) if face == "top" else (1, -1.0)
    quads, surface = s.surface.quads, s.surface
    crossed = np.cross(surface.d_u, surface.d_v)
    density = np.linalg.norm(crossed, axis=1)
    polygons = _quarters(face_positions(s).reshape(-1, 2, 3)[:, side], quads)
    shares = 0.25 * np.prod(surface.sizes, axis=1)[:, None] * density[quads]
    if sign < 0.0:
        polygons = polygons[:, ::-1]
    return [
        Block(
            nodes.reshape(-1, 2)[:, side][quads].reshape(-1, 1),
            np.ones((1, 1)),
            shares.reshape(-1, 1),
            polygons.mean(axis=1, keepdims=True),
            (sign * crossed / density[:, None])[quads].reshape(-1, 1, 3),
            polygons,
        )
    ]


def absorbing_arcs(m: Member, face: str, direction: Array) -> Array:
    """(stations * wall_points,) [m^2]  of a round wall as rays see it, arc by arc, exact.

    Rays reach the inner face where it faces them: nothing is in their way.
    """
    n, section = m.wall_points, m.section
    sign = 1.0 if face == "outer" else -1.0
    radius = section.radius + 0.5 * sign * section.thickness
    unit = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    y, z = -sign * np.asarray(m.axes, dtype=float)[:, 1:].transpose(1, 0, 2) @ unit
    centre = wall_angles(n) - np.arctan2(z, y)[:, None]
    lit = _lit_up_to(centre + np.pi / n) - _lit_up_to(centre - np.pi / n)
    widths = radius * np.hypot(y, z)[:, None] * lit
    return (widths * cell_lengths(m)[:, None]).ravel()


def _lit_up_to(psi: Array) -> Array:
    """Integral of max(0, cos) from -pi/2 to psi: 2 for each full turn, sin + 1 within one."""
    turns = np.floor((psi + np.pi) / (2.0 * np.pi))
    within = np.clip(psi - 2.0 * np.pi * turns, -0.5 * np.pi, 0.5 * np.pi)
    return 2.0 * turns + np.sin(within) + 1.0


def _arcs(radius: float, sign: float, n: int) -> Contour:
    """A round wall in arcs, one to each of its points."""
    unit, before, after = (_unit(wall_angles(n) + s * np.pi / n) for s in (0.0, -1.0, 1.0))
    lengths = np.full(n, 2.0 * np.pi * radius / n)
    return Contour(radius * unit, sign * unit, lengths, radius * before, radius * after)


def _unit(phi: Array) -> Array:
    return np.column_stack([np.cos(phi), np.sin(phi)])


def _along(m: Member, contour: Contour, dofs: Indices, values: Array) -> Block:
    """The strips of a contour, at every station as long as what belongs to it."""
    points = np.asarray(m.points, dtype=float)[:, None]
    first, last = _placed(m, contour.first), _placed(m, contour.last)
    outward = _crosswise(contour)
    a, b = (first, last) if outward else (last, first)
    low, high = (_between(points + x) for x in (a, b))
    corners = np.stack([low[:-1], high[:-1], high[1:], low[1:]], axis=2)
    return Block(
        dofs,
        values,
        np.outer(cell_lengths(m), contour.lengths).reshape(-1, 1),
        (points + _placed(m, contour.offsets)).reshape(-1, 1, 3),
        _placed(m, contour.normals).reshape(-1, 1, 3),
        corners.reshape(-1, 4, 3),
    )


def _crosswise(contour: Contour) -> bool:
    """Whether normals point outward, so that corners turn from e2 towards e3."""
    return bool(contour.normals[0] @ contour.offsets[0] > 0.0)


def _placed(m: Member, offsets: Array) -> Array:
    """(stations, P, 3) [m]  offsets (P, 2) in the section at each station."""
    return offsets @ np.asarray(m.axes, dtype=float)[:, 1:]


def _between(x: Array) -> Array:
    """(stations + 1, ...)  the first, the middles between neighbours, the last."""
    return np.concatenate([x[:1], 0.5 * (x[:-1] + x[1:]), x[-1:]])


def _end(m: Member, nodes: Indices, face: str) -> Face:
    """An end section, its area shared by the temperatures there."""
    n = m.wall_points
    own, station, sign = (nodes[:n], 0, -1.0) if face == "start" else (nodes[-n:], -1, 1.0)
    normal = sign * np.asarray(m.axes, dtype=float)[station, 0]
    polygons = _end_polygons(m, station)[:, :: int(sign)]
    points = wall_positions(m).reshape(-1, n, 3)[station]
    if n == GRADIENTS:
        areas, dofs, values = np.full((1, n), m.section.area / n), own[None], np.eye(n)
        points = points[None]
    else:
        pieces = len(polygons)
        areas = np.full((pieces, 1), m.section.area / pieces)
        dofs, values = np.resize(own, (pieces, 1)), np.ones((1, 1))
        points = points[:, None] if n > 1 else polygons.mean(axis=1, keepdims=True)
    return [Block(dofs, values, areas, points, np.broadcast_to(normal, points.shape), polygons)]


def _end_polygons(m: Member, station: int) -> Array:
    """(g, c, 3) [m]  of a tube as many pieces as there are temperatures, else the outline."""
    section, n = m.section, m.wall_points
    if section.kind == "tube":
        inner, outer = (
            _arcs(section.radius + s * section.thickness, 1.0, n if n > 1 else PIECES)
            for s in (-0.5, 0.5)
        )
        corners = np.stack([inner.first, outer.first, outer.last, inner.last], axis=1)
    else:
        corners = section.outline(PIECES if section.kind == "circle" else 4)[None]
    at = np.asarray(m.points, dtype=float)[station]
    return at + corners @ np.asarray(m.axes, dtype=float)[station, 1:]


def _quarters(x: Array, quads: Indices) -> Array:
    """(4 elements, 4, 3) [m]  corner, middle of its edge, of the element, of the edge before."""
    corners = x[quads]
    onward = 0.5 * (corners + np.roll(corners, -1, axis=1))
    centre = np.broadcast_to(corners.mean(axis=1, keepdims=True), corners.shape)
    return np.stack([corners, onward, centre, np.roll(onward, 1, axis=1)], axis=2).reshape(-1, 4, 3)
