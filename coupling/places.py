"""Where things are: the nodes of each body, and which material point a site means."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling import surface_tables
from coupling.body_tables import Arc, Body, LineBody, RigidBody, ShellBody
from mechanics.elements import FAMILIES
from mechanics.line_elements import arc_lengths
from meshes import surfaces
from meshes.generate import arc, frames
from meshes.surfaces import Surface

Array = NDArray[np.float64]

NODE_TOLERANCE = 1e-6  # how near to a node a distance along a body must be, per length of the body


class Shape(NamedTuple):
    """A body at the start.

    points : (n, 3) float [m]  nodes; the centre of mass of a rigid body
    axes : (n, 3, 3) float  rows e1, e2, e3 there
    along : (n,) float [m]  distances from the start of a line body
    between : whether points between its nodes are material points too
    surface : of a shell
    """

    points: Array
    axes: Array
    along: Array
    between: bool = False
    surface: Surface | None = None


class Place(NamedTuple):
    """A material point: ``fraction`` of the way from a node to the next, and ``offset`` from it.

    offset : (3,) float [m]  along e1, e2, e3
    """

    node: int
    fraction: float
    offset: Array


# ---------------------------------------------------------------------------------- bodies


def shape_of(body: Body, folder: Path) -> Shape:
    """Nodes of a body, those of a line in the order of their distance from its start.

    Raises
    ------
    ValueError : the mesh file cannot be used
    """
    match body:
        case LineBody():
            return _line(body, folder)
        case ShellBody():
            return _shell(body)
        case RigidBody():
            axes = np.array(body.axes)[None]
            return Shape(np.array([body.position]), axes, np.zeros(1))
    return Shape(np.array([body.position]), np.eye(3)[None], np.zeros(1))


def _line(body: LineBody, folder: Path) -> Shape:
    stride = FAMILIES[body.family].stride
    normal = None if body.normal is None else np.array(body.normal)
    if body.mesh is not None:
        from meshes.io import read_line

        points = read_line(folder / body.mesh, body.region)
        if not np.isfinite(points).all():
            raise ValueError("the line has coordinates that are not finite numbers")
        if (len(points) - 1) % stride:
            raise ValueError(f"elements {body.family} take {stride} pieces of the line each")
        axes, along = frames(points, normal), distances(points)
    elif body.arc is not None:
        points, axes, along = _arc(body, body.arc, stride, normal)
    else:
        points = _straight(body, stride)
        axes, along = frames(points, normal), distances(points)
    return Shape(points, axes, along, "r_x" in FAMILIES[body.family].vectors)


def _straight(body: LineBody, stride: int) -> Array:
    start, end = np.array(body.start), np.array(body.end)
    if body.nodes is None:
        assert body.elements  # the table has them when it has neither mesh nor nodes
        s = np.linspace(0.0, 1.0, stride * body.elements + 1)
    else:
        ends = np.array(body.nodes) / body.nodes[-1]
        s = np.interp(np.arange(stride * (len(ends) - 1) + 1) / stride, np.arange(len(ends)), ends)
    points = start + s[:, None] * (end - start)
    points[-1] = end
    return points


def _arc(
    body: LineBody, turn: Arc, stride: int, normal: Array | None
) -> tuple[Array, Array, Array]:
    assert body.elements and body.start  # the table has them with an arc
    points, axes = arc(turn.center, body.start, turn.axis, turn.angle, stride * body.elements)
    radius = float(np.linalg.norm(np.cross(turn.axis, np.subtract(body.start, turn.center))))
    if normal is not None:
        axes = _about(axes[:, 0], normal[None])
    return points, axes, radius * abs(turn.angle) * np.linspace(0.0, 1.0, len(points))


def _about(e1: Array, others: Array) -> Array:
    """(n, 3, 3) triads with tangents ``e1`` (n, 3), e2 as near as possible to ``others``."""
    e2 = others - np.sum(others * e1, axis=1, keepdims=True) * e1
    length = np.linalg.norm(e2, axis=1, keepdims=True)
    if (length < 1e-6 * np.linalg.norm(others, axis=-1, keepdims=True)).any():
        raise ValueError("the normal is parallel to the body somewhere")
    e2 = e2 / length
    return np.stack([e1, e2, np.cross(e1, e2)], axis=1)


def _shell(body: ShellBody) -> Shape:
    made = surface_of(body.surface)
    e1 = made.d_u / np.linalg.norm(made.d_u, axis=1, keepdims=True)
    return Shape(made.points, _about(e1, made.d_v), np.zeros(len(made.points)), False, made)


def surface_of(table: Any) -> Surface:
    """The middle surface that a table describes."""
    n_u, n_v = table.elements
    match table:
        case surface_tables.Plate():
            made = surfaces.plate(table.length, table.width, n_u, n_v)
        case surface_tables.TubeSurface():
            made = surfaces.tube(table.radius, table.length, n_u, n_v, (table.start, table.end))
        case surface_tables.Annulus():
            span = table.start, table.end
            made = surfaces.annulus(table.inner_radius, table.outer_radius, n_u, n_v, span)
        case _:
            zone, span = (table.south, table.north), (table.start, table.end)
            made = surfaces.sphere(table.radius, n_u, n_v, zone, span)
    return surfaces.placed(made, table.origin, table.axes)


def edge_nodes(body: Any, edge: str) -> Array:
    """Nodes of an edge of a shell, one after the other, as ``meshes.surfaces.patch`` numbers them.

    Raises
    ------
    ValueError : the surface is closed there
    """
    n_u, n_v = body.surface.elements
    grid = np.arange(len(surface_of(body.surface).points)).reshape(-1, n_v + 1)
    if edge.startswith("u") and len(grid) == n_u:
        raise ValueError("the surface is closed: it has no edge where u starts or ends")
    return {"u-start": grid[0], "u-end": grid[-1], "v-start": grid[:, 0], "v-end": grid[:, -1]}[
        edge
    ]


def distances(points: Array) -> Array:
    """(n,) [m]  of the nodes from the start, along the body."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


# ----------------------------------------------------------------------------------- sites


def place_of(shape: Shape, site: Any) -> Place:
    """The material point that a site (or a probe) on a body means.

    Raises
    ------
    ValueError : the body has no such point
    """
    offset = np.zeros(3) if site.offset is None else np.array(site.offset)
    if site.at is not None:
        return Place(*_along(shape, site.at), offset)
    if site.position is None:
        return Place(0, 0.0, offset)
    gap = np.array(site.position) - shape.points
    node = int(np.argmin(np.linalg.norm(gap, axis=1)))
    if shape.surface is None:
        return Place(node, 0.0, offset + shape.axes[0] @ gap[0])
    size = float(np.linalg.norm(np.ptp(shape.points, axis=0)))
    if np.linalg.norm(gap[node]) > NODE_TOLERANCE * size:
        near = ", ".join(f"{x:.6g}" for x in shape.points[node])
        raise ValueError(f"no node of the shell is there; the nearest is at [{near}] m")
    return Place(node, 0.0, offset)


def _along(shape: Shape, at: str | float) -> tuple[int, float]:
    """Node and fraction at 'start', 'end' or a distance [m] from the start."""
    if isinstance(at, str):
        return (0 if at == "start" else len(shape.points) - 1), 0.0
    along = shape.along
    nearest = int(np.argmin(np.abs(along - at)))
    if abs(along[nearest] - at) <= NODE_TOLERANCE * along[-1]:
        return nearest, 0.0
    if at > along[-1]:
        raise ValueError(f"lies beyond the end: the body is {along[-1]:g} m long, got {at:g} m")
    i = int(np.searchsorted(along, at)) - 1
    if not shape.between:
        text = f"the nearest are at {along[i]:g} m and {along[i + 1]:g} m"
        raise ValueError(f"these elements take points at their nodes only; {text}")
    return i, float((at - along[i]) / (along[i + 1] - along[i]))


def point_of(shape: Shape, place: Place) -> Array:
    """(3,) [m]  where a material point is at the start.

    Between nodes a line body has the cubic axis of its elements.
    """
    i, x = place.node, place.fraction
    axes = shape.axes[i]
    point = shape.points[i]
    if x:
        a, b = shape.points[i : i + 2]
        slopes = shape.axes[i : i + 2, 0]
        L = float(arc_lengths(shape.points[None, i : i + 2], slopes[None])[0])
        point = (1 - x) ** 2 * ((1 + 2 * x) * a + L * x * slopes[0])
        point = point + x * x * ((3 - 2 * x) * b + L * (x - 1) * slopes[1])
        axes = _about(*_mixed(shape, i, x))[0]
    return point + place.offset @ axes


def _mixed(shape: Shape, i: int, x: float) -> tuple[Array, Array]:
    """Tangent and e2 between two nodes, each (1, 3)."""
    p, s = (1 - x) * shape.axes[i, 1:] + x * shape.axes[i + 1, 1:]
    e1 = np.cross(p, s)
    return (e1 / np.linalg.norm(e1))[None], p[None]
