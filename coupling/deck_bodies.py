"""Flexible bodies of a scene as cells of a CalculiX deck, with the sections that its sites name.

A site of a beam is a plane of nodes: means over it, by the functions of the cells, stand for the
node of the beam. Beams get a station wherever something holds, loads or watches them.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Beam, Description, Shell, Site
from meshes.families import EDGES, FACES, FACET
from meshes.solids import ORDER, member_mesh, sheet_mesh

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

KINDS = {"hexahedron": "C3D8I", "hexahedron20": "C3D20R"}
"""Cells of CalculiX by family: with incompatible modes, and with reduced integration."""
SAME = 1e-9  # of an element: places this near are one station
STRAIGHT = 1e-9  # of the length, by which a straight beam may bend


class Fineness(NamedTuple):
    """How bodies are meshed.

    around : cells round a section;  layers : through a wall or sheet
    refine : cells along each element of a beam;  family : of the cells, in ``KINDS``
    """

    around: int = 16
    layers: int = 1
    refine: int = 1
    family: str = "hexahedron20"


class Meshed(NamedTuple):
    """A body in cells.

    first : number of its first node, counted from 0
    points : (n, 3) float [m];  cells : (c, k) intp, counted within the body
    stations : (m,) float  places of the planes of a beam in elements; empty of shells
    at : (n,) float  place of each node in elements of a beam; of shells the height [m]
    local : (n, 2) float [m]  coordinates in the section; of shells the two nodes of the surface
        between which it lies
    """

    body: Beam | Shell
    family: str
    first: int
    points: Array
    cells: Indices
    stations: Array
    at: Array
    local: Array


class Section(NamedTuple):
    """A plane of nodes, or a column of them in a shell.

    nodes : (k,) intp  counted from 0 in the whole deck
    place, along_2, along_3 : (k,) float  the mean of position, and of the slopes along e2 and e3,
        are sums over the nodes with these weights [-], [1/m]
    torsion_2, torsion_3 : (k,) float [1/m]  turn about e1: displacements along e3 and e2 with these
    axes : (3, 3) float  rows e1, e2, e3;  point : (3,) float [m]
    """

    nodes: Indices
    place: Array
    along_2: Array
    along_3: Array
    torsion_2: Array
    torsion_3: Array
    axes: Array
    point: Array


def meshed(d: Description, sites: Iterable[Site], fineness: Fineness) -> dict[str, Meshed]:
    """The beams and shells of a description in cells, by name.

    sites : whatever is held, loaded or watched
    """
    found: dict[str, Meshed] = {}
    places: dict[str, list[float]] = {}
    for site in sites:
        if site.body is not None:
            places.setdefault(site.body, []).append(site.node + site.fraction)
    first = 0
    for body in d.bodies:
        if isinstance(body, Beam):
            made = _beam(body, first, places.get(body.name, []), fineness)
        elif isinstance(body, Shell):
            made = _shell(body, first, fineness)
        else:
            continue
        found[body.name] = made
        first += len(made.points)
    return found


# ----------------------------------------------------------------------------------- bodies


def _beam(body: Beam, first: int, places: list[float], fineness: Fineness) -> Meshed:
    count = len(body.points) - 1
    stations = stations_of(count, fineness.refine, places)
    points, axes = line_between(
        np.asarray(body.points, float), np.asarray(body.axes, float), stations
    )
    mesh = member_mesh(points, axes, body.section, fineness.around, fineness.layers,
                       family=fineness.family)  # fmt: skip
    cells = mesh.cells[fineness.family]
    level = _levels(len(mesh.points), cells, len(stations) - 1)
    at = np.interp(level, np.arange(len(stations)), stations)
    # the same mesh along x has section coordinates as positions
    straight = np.column_stack([np.arange(len(stations)), np.zeros((len(stations), 2))])
    flat = member_mesh(straight, np.tile(np.eye(3), (len(stations), 1, 1)), body.section,
                       fineness.around, fineness.layers, family=fineness.family)  # fmt: skip
    return Meshed(
        body, fineness.family, first, mesh.points, cells, stations, at, flat.points[:, 1:]
    )


def stations_of(count: int, refine: int, places: list[float]) -> Array:
    """(m,)  a grid on ``count`` elements, and other places; negative ones count from the end."""
    wanted = np.concatenate([np.linspace(0.0, count, count * refine + 1), places])
    wanted = np.sort(np.where(wanted < 0.0, wanted + count + 1, wanted))
    return wanted[np.diff(wanted, prepend=-1.0) > SAME]


def line_between(points: Array, axes: Array, at: Array) -> tuple[Array, Array]:
    """Points and axes of a beam at places between its nodes."""
    nodes = np.arange(len(points), dtype=float)
    if len(at) == len(nodes):
        return points, axes
    from scipy.interpolate import CubicSpline
    from scipy.spatial.transform import Rotation, Slerp

    span = points[-1] - points[0]
    off = np.linalg.norm(np.cross(points - points[0], span), axis=1).max() / (span @ span)
    if off < STRAIGHT:
        between = np.column_stack([np.interp(at, nodes, column) for column in points.T])
    else:
        between = CubicSpline(nodes, points)(at)
    return between, Slerp(nodes, Rotation.from_matrix(axes))(at).as_matrix()


def _levels(n: int, cells: Indices, layers: int) -> Array:
    """(n,) station of each node, half way between two of them at the middle of an edge."""
    level = np.zeros(n)
    below = np.repeat(np.arange(layers), len(cells) // layers)
    level[cells[:, :4]], level[cells[:, 4:8]] = below[:, None], below[:, None] + 1.0
    return _middles(level, cells)


def _middles(values: Array, cells: Indices) -> Array:
    """Values of the corners of cells, with the means of two of them in the middle of edges."""
    for k, (a, b) in enumerate(EDGES["hexahedron"], 8):
        if k < cells.shape[1]:
            values[cells[:, k]] = 0.5 * (values[cells[:, a]] + values[cells[:, b]])
    return values


def _shell(body: Shell, first: int, fineness: Fineness) -> Meshed:
    mesh = sheet_mesh(body.surface, body.thickness, fineness.layers, family=fineness.family)
    cells, quads = mesh.cells[fineness.family], np.asarray(body.surface.quads)
    corners = np.tile(quads, (fineness.layers, 1))
    level = np.repeat(np.arange(fineness.layers), len(quads))[:, None] / fineness.layers
    height, of = np.zeros(len(mesh.points)), np.zeros((len(mesh.points), 2))
    height[cells[:, :4]] = body.thickness * (level - 0.5)
    height[cells[:, 4:8]] = body.thickness * (level + 1.0 / fineness.layers - 0.5)
    for half in (cells[:, :4], cells[:, 4:8]):
        of[half] = corners[..., None]
    for k, (a, b) in enumerate(EDGES["hexahedron"], 8):
        if k < cells.shape[1]:
            of[cells[:, k], 0], of[cells[:, k], 1] = of[cells[:, a], 0], of[cells[:, b], 0]
    return Meshed(body, fineness.family, first, mesh.points, cells, np.empty(0),
                  _middles(height, cells), of)  # fmt: skip


def temperatures(m: Meshed, sections: Array) -> Array:
    """(n,) [K] of the nodes of a body, from means and gradients (points, 3) at its own nodes."""
    if isinstance(m.body, Shell):
        own = sections[m.local.astype(int)].mean(axis=1)
        return own[:, 0] + m.at * own[:, 2]
    nodes = np.arange(len(sections))
    T, along_2, along_3 = (np.interp(m.at, nodes, column) for column in sections.T)
    return T + m.local[:, 0] * along_2 + m.local[:, 1] * along_3


# --------------------------------------------------------------------------------- sections


def section_of(bodies: Mapping[str, Meshed], site: Site) -> Section:
    """The nodes that stand for a site, without its offset."""
    assert site.body is not None
    m = bodies[site.body]
    if isinstance(m.body, Shell):
        node = site.node % len(m.body.surface.points)
        return column(m, node, node)
    where = site.node + site.fraction
    where += len(m.body.points) if where < 0.0 else 0.0
    return _plane(m, int(np.argmin(np.abs(m.stations - where))))


def _plane(m: Meshed, station: int) -> Section:
    """Means over the faces of the cells at a station."""
    from thermal.solid_elements import SURFACE, shape

    layers = len(m.stations) - 1
    layer = m.cells.reshape(layers, -1, m.cells.shape[1])[min(station, layers - 1)]
    face = layer[:, FACES[m.family][4 if station < layers else 5]]
    own = shape(FACET[m.family], SURFACE["quad8"])
    y = m.local[face]
    tangents = np.einsum("qnd,fnc->fqdc", own.slopes, y)
    areas = np.abs(np.linalg.det(tangents)) * own.weights
    nodes, places = np.unique(face, return_inverse=True)
    at = np.einsum("qn,fnc->fqc", own.values, y)
    assert isinstance(m.body, Beam)
    axes = line_between(np.asarray(m.body.points), np.asarray(m.body.axes), m.stations)[1][station]

    def moment(of: Array) -> Array:
        shares = np.einsum("fq,qn->fn", areas * of, own.values).ravel()
        return np.bincount(places.ravel(), shares, len(nodes)).astype(np.float64)

    return _section(m, nodes, moment(np.ones_like(areas)), moment(at[..., 0]), moment(at[..., 1]),
                    axes)  # fmt: skip


def _section(
    m: Meshed, nodes: Indices, w: Array, first_2: Array, first_3: Array, axes: Array
) -> Section:
    """From the integrals over a plane of the functions of nodes, and of them times y and z."""
    y = m.local[nodes]
    x = m.points[nodes]
    size_2, size_3 = float(first_2 @ y[:, 0]), float(first_3 @ y[:, 1])
    polar = size_2 + size_3
    return Section(nodes + m.first, w / w.sum(), first_2 / size_2, first_3 / size_3,
                   first_2 / polar, first_3 / polar, axes, w @ x / w.sum())  # fmt: skip


def column(m: Meshed, one: int, other: int) -> Section:
    """Nodes over one another in a shell: over a node of its surface, or half way between two.

    They have one slope, along the normal e3.
    """
    assert isinstance(m.body, Shell)
    nodes = np.flatnonzero((np.sort(m.local, axis=1) == sorted((one, other))).all(axis=1))
    nodes = nodes[np.argsort(m.at[nodes])]
    z = m.at[nodes]
    w = _simpson(z) if one == other and ORDER[m.family] == 2 else _trapezoid(z)
    axes = _triad(m.body, [one, other])
    slope = w * z / float(w * z @ z)
    nothing = np.zeros(len(nodes))
    point = np.asarray(m.body.surface.points, float)[[one, other]].mean(axis=0)
    return Section(nodes + m.first, w / w.sum(), nothing, slope, nothing, slope, axes, point)


def _triad(body: Shell, nodes: list[int]) -> Array:
    """(3, 3)  rows: along u, across it, normal."""
    d_u, d_v = (np.asarray(d)[nodes].mean(axis=0) for d in (body.surface.d_u, body.surface.d_v))
    e1, e3 = d_u / np.linalg.norm(d_u), np.cross(d_u, d_v)
    e3 = e3 / np.linalg.norm(e3)
    return np.stack([e1, np.cross(e3, e1), e3])


def _trapezoid(z: Array) -> Array:
    h = np.diff(z)
    return 0.5 * (np.append(h, 0.0) + np.append(0.0, h))


def _simpson(z: Array) -> Array:
    """Of pieces of three places each."""
    h = (z[2::2] - z[:-2:2]) / 6.0
    w = np.zeros(len(z))
    w[:-2:2] += h
    w[1::2] += 4.0 * h
    w[2::2] += h
    return w
