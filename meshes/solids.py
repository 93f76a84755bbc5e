"""Volume meshes with named regions of their boundary: members, sheets, boxes, pins in bores.

All are made by sweeping a grid of quads: over the section of a member along its axis, over a
surface through its thickness. Nodes are numbered plane by plane in the direction of the sweep;
within a plane as the grid numbers them. Of order 2 there are planes in the middle of the cells too.
Families that lack some of the nodes (hexahedron20) leave these out and close the numbering. Cells
are numbered layer by layer in the same direction. Each mesh has its volume cells and, of the
facets' family, the cells of its regions, which turn outward.

Families: of order 1 "hexahedron" or "tetra", of order 2 "hexahedron20", "hexahedron27" or
"tetra10"; nodes of a cell as in ``meshes.families``.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshes.families import EDGES, FACES, FACET, middles
from meshes.mesh import Mesh
from meshes.sections import Section
from meshes.surfaces import Surface

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DEFAULT = {1: "hexahedron", 2: "hexahedron20"}
ORDER = {"hexahedron": 1, "tetra": 1, "hexahedron20": 2, "hexahedron27": 2, "tetra10": 2}
BULGE = 0.5  # of the core of a circle: 0 square, 1 round


class Grid(NamedTuple):
    """Quads in a plane or on a surface.

    points : (m, 2) float [m]  or as the sweep takes them
    quads : (k, 4) or (k, 9) intp  turning about the direction of the sweep
    sides : name -> (j, 2) intp  quad and its edge, of the boundary
    """

    points: Array
    quads: Indices
    sides: Mapping[str, Indices]


def member_mesh(
    points: ArrayLike,
    axes: ArrayLike,
    section: Section,
    around: int,
    layers: int,
    order: int = 1,
    family: str | None = None,
) -> Mesh:
    """Mesh of a member, with one cell from station to station.

    Its regions are "outer", of a tube "inner", "start" and "end". In each plane the nodes of a tube
    are numbered ring by ring from the inner to the outer one, each ring from e2 towards e3. Chords
    of order 1 do not lie in the circle: the wall has its thickness, and its middle the
    circumference of the tube; of a circle it is the area that is kept.

    Parameters
    ----------
    points : (n, 3) float [m]  stations; of order 2 cubics through them give the planes between
    axes : (n, 3, 3) float  rows e1 (tangent), e2, e3
    around : cells round the section, of a circle a multiple of 4 and at least 8; those of a
        rectangle are alike in size
    layers : cells through the wall of a tube, between core and surface of a circle, and at least
        each way in a rectangle
    order : 1 or 2, for "hexahedron" and "hexahedron20"
    family : another family, whose order counts
    """
    family = _family(order, family)
    grid = _section(
        section, _count("around", around, 4), _count("layers", layers, 1), ORDER[family]
    )
    points, axes = np.asarray(points, dtype=float), np.asarray(axes, dtype=float)
    if ORDER[family] == 2:
        points, axes = _with_middles(points, axes)
    y, z = grid.points[:, 0, None], grid.points[:, 1, None]
    planes = points[:, None] + y * axes[:, None, 1] + z * axes[:, None, 2]
    return _swept(planes, grid, ("start", "end"), family)


def sheet_mesh(
    surface: Surface, thickness: float, layers: int, order: int = 1, family: str | None = None
) -> Mesh:
    """Mesh of a sheet: its surface in the middle of a thickness [m], with ``layers`` of cells.

    Its regions are "top", on the side of the normal d_u x d_v, "bottom", and, of a surface that has
    some, "edges". Planes go from the bottom to the top; in each of them the nodes are those of the
    surface, and of order 2 the middles of its edges and then of its quads, by cubics.
    """
    family = _family(order, family)
    grid, normals = _surface_grid(surface, ORDER[family])
    levels = ORDER[family] * _count("layers", layers, 1) + 1
    heights = thickness * np.linspace(-0.5, 0.5, levels)[:, None, None]
    return _swept(grid.points + heights * normals, grid, ("bottom", "top"), family)


def box(
    size: ArrayLike, counts: tuple[int, int, int], order: int = 1, family: str | None = None
) -> Mesh:
    """Mesh of a box from the origin to ``size`` (3,) [m], of equal cells.

    Its regions are "x0", "x1", "y0", "y1", "z0" and "z1", by coordinate and end. In each plane of
    z the nodes are numbered along y first.
    """
    family = _family(order, family)
    lengths = np.asarray(size, dtype=float)
    steps = [ORDER[family] * _count("counts", n, 1) + 1 for n in counts]
    x, y, z = (np.linspace(0.0, a, n) for a, n in zip(lengths, steps, strict=True))
    grid = _rectangle(x, y, ORDER[family], ("y0", "x1", "y1", "x0"))
    flat = np.column_stack([grid.points, np.zeros(len(grid.points))])
    planes = flat + z[:, None, None] * np.array([0.0, 0.0, 1.0])
    return _swept(planes, grid, ("z0", "z1"), family)


def pin(
    radius: float, length: float, around: int, layers: int, cells: int,
    order: int = 1, family: str | None = None,
) -> Mesh:  # fmt: skip
    """Mesh of a round pin along z from z = 0, nodes of its surface in the circle.

    Its regions are "outer", "start" and "end"; see ``member_mesh`` for the other parameters.
    """
    family = _family(order, family)
    grid = _circle(radius, _count("around", around, 4), _count("layers", layers, 1), ORDER[family])
    return _along_z(grid, length, cells, family)


def bore(
    inner: float, outer: float, length: float, around: int, layers: int, cells: int,
    order: int = 1, family: str | None = None,
) -> Mesh:  # fmt: skip
    """Mesh of a bush along z from z = 0 between two radii [m], nodes in the circles.

    Its regions are "inner", "outer", "start" and "end".
    """
    family = _family(order, family)
    order = ORDER[family]
    radii = np.linspace(inner, outer, order * _count("layers", layers, 1) + 1)
    return _along_z(_annulus(radii, _count("around", around, 3), order), length, cells, family)


def pin_and_bore(
    radius: float, gap: float, outer: float, length: float, around: int, layers: int, cells: int,
    order: int = 1, family: str | None = None,
) -> tuple[Mesh, Mesh]:  # fmt: skip
    """A pin and the bush round it, with a ``gap`` [m] between their radii; facets lie opposite."""
    around = 4 * -(-max(8, around) // 4)
    inside = pin(radius, length, around, layers, cells, order, family)
    return inside, bore(radius + gap, outer, length, around, layers, cells, order, family)


def tetrahedra(mesh: Mesh) -> Mesh:
    """Each hexahedron or hexahedron27 as six tetrahedra or tetra10, on the same nodes.

    Faces are divided from their corner of the smallest number, so that neighbours agree (Dompierre
    et al. 1999). Cells of regions become triangles of the same regions.
    """
    (old,) = [f for f in mesh.cells if f.startswith("hexahedron")]
    facet = FACET[old]
    cells = {{"hexahedron": "tetra", "hexahedron27": "tetra10"}[old]: _divided(mesh.cells[old])}
    if facet in mesh.cells:
        halves = {"quad": "triangle", "quad9": "triangle6"}[facet]
        cells[halves] = _halved(mesh.cells[facet])
        pieces = {old: (next(iter(cells)), 6), facet: (halves, 2)}
    else:
        pieces = {old: (next(iter(cells)), 6)}
    regions = {}
    for name, (of, members) in mesh.regions.items():
        new, n = pieces[of]
        regions[name] = (new, (n * members[:, None] + np.arange(n)).ravel())
    return Mesh(mesh.points, cells, regions)


def _family(order: int, family: str | None) -> str:
    if family is None and order in DEFAULT:
        return DEFAULT[order]
    if family not in ORDER:
        known = ", ".join(ORDER)
        raise ValueError(
            f"order must be 1 or 2, or the family one of {known}, got {family or order}"
        )
    return family


def _count(name: str, n: int, least: int) -> int:
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {n!r}")
    return int(n)


# --- grids --------------------------------------------------------------------------------------


def _quads(index: Indices, order: int) -> Indices:
    """Quads of a patch whose nodes are ``index`` (i, j); they turn from i towards j."""
    if order == 1:
        corners = (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
        return np.stack(corners, axis=-1).reshape(-1, 4)
    a, m, b = slice(0, -1, 2), slice(1, None, 2), slice(2, None, 2)
    places = [(a, a), (b, a), (b, b), (a, b), (m, a), (b, m), (m, b), (a, m), (m, m)]
    return np.stack([index[i, j] for i, j in places], axis=-1).reshape(-1, 9)


def _section(section: Section, around: int, layers: int, order: int) -> Grid:
    if section.kind == "tube":
        mean, wall = section.radius, section.thickness
        if order == 1:  # wall of true thickness on a polygon of true circumference
            half = np.pi / around
            mean, wall = mean * half / np.sin(half), wall / np.cos(half)
        radii = mean + wall * np.linspace(-0.5, 0.5, order * layers + 1)
        return _annulus(radii, around, order)
    if section.kind == "circle":
        angle = 2.0 * np.pi / (4 * -(-max(8, around) // 4))
        scale = np.sqrt(angle / np.sin(angle)) if order == 1 else 1.0
        return _circle(scale * section.radius, around, layers, order)
    if section.kind == "rectangle":
        return _plain_rectangle(section.height, section.width, around, layers, order)
    raise ValueError(f"a section of kind '{section.kind}' has no shape to be meshed")


def _annulus(radii: Array, around: int, order: int) -> Grid:
    """Rings of radii [m] that rise, each from +y towards z."""
    n = order * around
    index = np.arange(len(radii) * n).reshape(len(radii), n)
    quads = _quads(np.hstack([index, index[:, :1]]), order)
    points = (radii[:, None, None] * _turned(2.0 * np.pi * np.arange(n) / n)).reshape(-1, 2)
    first, last = np.arange(around), np.arange(len(quads) - around, len(quads))
    return Grid(points, quads, {"outer": _edges(last, 1), "inner": _edges(first, 3)})


def _circle(radius: float, around: int, layers: int, order: int) -> Grid:
    """A core of squares whose corners point along +-y and +-z, and rings round it."""
    across = max(2, -(-around // 4))
    n, rings = order * across, order * layers
    core = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    loop = np.concatenate([core[:0:-1, n], core[0, :0:-1], core[:n, 0], core[n, :n]])
    centre = radius * across / (across + 2 * layers) * _core(np.linspace(-1.0, 1.0, n + 1))
    rim = radius * _turned(2.0 * np.pi * np.arange(4 * n) / (4 * n))
    share = np.linspace(0.0, 1.0, rings + 1)[1:, None, None]
    round_it = (1.0 - share) * centre[loop] + share * rim
    outside = core.size + np.arange(rings * 4 * n).reshape(rings, 4 * n)
    index = np.vstack([loop, outside])
    quads = [_quads(core, order), _quads(np.hstack([index, index[:, :1]]), order)]
    last = sum(map(len, quads)) - np.arange(4 * across, 0, -1)
    points = np.vstack([centre, round_it.reshape(-1, 2)])
    return Grid(points, np.vstack(quads), {"outer": _edges(last, 1)})


def _core(u: Array) -> Array:
    """((n + 1)^2, 2)  the square -1..1 turned by -45 degrees, its corners on the unit circle."""
    x, y = np.meshgrid(u, u, indexing="ij")
    level = np.maximum(np.abs(x), np.abs(y))
    flat = np.abs(y) >= np.abs(x)
    small, large = np.where(flat, x, y), np.where(flat, y, x)
    slope = np.divide(small, large, out=np.zeros_like(x), where=large != 0.0)
    side = np.where(flat, 0.5 * np.pi - 0.25 * np.pi * slope, 0.25 * np.pi * slope)
    angle = side + np.where(large < 0.0, np.pi, 0.0) - 0.25 * np.pi
    square = np.stack([x + y, y - x], axis=-1) / 2.0
    return ((1.0 - BULGE) * square + BULGE * level[..., None] * _turned(angle)).reshape(-1, 2)


def _plain_rectangle(height: float, width: float, around: int, layers: int, order: int) -> Grid:
    share = height / (height + width)
    counts = [max(layers, round(0.5 * around * part)) for part in (share, 1.0 - share)]
    pairs = zip((height, width), counts, strict=True)
    y, z = (a * np.linspace(-0.5, 0.5, order * n + 1) for a, n in pairs)
    return _rectangle(y, z, order, ("outer",) * 4)


def _rectangle(u: Array, v: Array, order: int, names: tuple[str, ...]) -> Grid:
    """Grid on two axes, numbered along v first; its sides at low v, high u, high v, low u."""
    index = np.arange(u.size * v.size).reshape(u.size, v.size)
    quads = _quads(index, order)
    points = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    cells = np.arange(len(quads)).reshape((u.size - 1) // order, -1)
    rows = (cells[:, 0], cells[-1], cells[:, -1], cells[0])
    sides: dict[str, Indices] = {}
    for edge, (name, row) in enumerate(zip(names, rows, strict=True)):
        found = _edges(row, edge)
        sides[name] = np.vstack([sides[name], found]) if name in sides else found
    return Grid(points, quads, sides)


def _turned(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _edges(quads: Indices, edge: int) -> Indices:
    return np.stack([quads, np.full_like(quads, edge)], axis=1)


# --- surfaces -----------------------------------------------------------------------------------


def _surface_grid(s: Surface, order: int) -> tuple[Grid, Array]:
    """Grid (points in space) of a surface, and its unit normals (m, 3)."""
    points, d_u, d_v, quads = s.points, s.d_u, s.d_v, np.asarray(s.quads)
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    _, first, inverse, uses = np.unique(
        np.sort(edges, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    open_edges = np.flatnonzero(uses[inverse.ravel()] == 1)
    if order == 2:
        middle, centre = _middles(s), len(points) + len(first)
        n, k = divmod(first, 4)
        parts = [(whole, between[n, k], between[:, 4]) for whole, between in
                 zip((points, d_u, d_v), middle, strict=True)]  # fmt: skip
        points, d_u, d_v = (np.vstack(p) for p in parts)
        between = len(s.points) + inverse.reshape(-1, 4)
        quads = np.hstack([quads, between, centre + np.arange(len(quads))[:, None]])
    normals = np.cross(d_u, d_v)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sides = {"edges": np.stack(divmod(open_edges, 4), axis=1)} if len(open_edges) else {}
    return Grid(points, quads, sides), normals


def _middles(s: Surface) -> tuple[Array, Array, Array]:
    """(k, 5, 3) each: points, d_u, d_v in the middles of the four edges and of each quad.

    By the bicubic Hermite interpolation that the derivatives define.
    """
    a, b = s.sizes[:, :1], s.sizes[:, 1:]
    r, u, v, uv = (x[s.quads] for x in (s.points, s.d_u, s.d_v, s.d_uv))

    def edge(size: Array, f: Array, g: Array, i: int, j: int) -> Array:
        return 0.5 * (f[:, i] + f[:, j]) + size / 8.0 * (g[:, i] - g[:, j])

    def slope(size: Array, f: Array, g: Array, i: int, j: int) -> Array:
        return 1.5 * (f[:, j] - f[:, i]) / size - 0.25 * (g[:, i] + g[:, j])

    along = [(0, 1), (3, 2)]  # edges in the direction of u, at low and at high v
    across = [(1, 2), (0, 3)]  # edges in the direction of v, at high and at low u
    low, high = ([edge(a, f, g, *e) for f, g in ((r, u), (v, uv))] for e in along)
    low_u, high_u = ([slope(a, f, g, *e) for f, g in ((r, u), (v, uv))] for e in along)
    right, left = ([edge(b, f, g, *e) for f, g in ((r, v), (u, uv))] for e in across)
    right_v, left_v = (slope(b, r, v, *e) for e in across)
    centre = 0.5 * (low[0] + high[0]) + b / 8.0 * (low[1] - high[1])
    centre_u = 0.5 * (low_u[0] + high_u[0]) + b / 8.0 * (low_u[1] - high_u[1])
    centre_v = 1.5 * (high[0] - low[0]) / b - 0.25 * (low[1] + high[1])
    return (
        np.stack([low[0], right[0], high[0], left[0], centre], axis=1),
        np.stack([low_u[0], right[1], high_u[0], left[1], centre_u], axis=1),
        np.stack([low[1], right_v, high[1], left_v, centre_v], axis=1),
    )


# --- sweeping -----------------------------------------------------------------------------------


def _with_middles(points: Array, axes: Array) -> tuple[Array, Array]:
    """Stations and triads with those in between, on cubics that have the tangents e1."""
    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)[:, None]
    e1 = axes[:, 0]
    middle = 0.5 * (points[:-1] + points[1:]) + chord / 8.0 * (e1[:-1] - e1[1:])
    tangent = 1.5 * np.diff(points, axis=0) / chord - 0.25 * (e1[:-1] + e1[1:])
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    e2 = axes[:-1, 1] + axes[1:, 1]
    e2 -= np.sum(e2 * tangent, axis=1, keepdims=True) * tangent
    e2 /= np.linalg.norm(e2, axis=1, keepdims=True)
    triads = np.stack([tangent, e2, np.cross(tangent, e2)], axis=1)
    return _interleaved(points, middle), _interleaved(axes, triads)


def _interleaved(a: Array, between: Array) -> Array:
    out = np.empty((len(a) + len(between), *a.shape[1:]))
    out[::2], out[1::2] = a, between
    return out


def _along_z(grid: Grid, length: float, cells: int, family: str) -> Mesh:
    flat = np.column_stack([grid.points, np.zeros(len(grid.points))])
    z = np.linspace(0.0, length, ORDER[family] * _count("cells", cells, 1) + 1)
    planes = flat + z[:, None, None] * np.array([0.0, 0.0, 1.0])
    return _swept(planes, grid, ("start", "end"), family)


def _swept(planes: Array, grid: Grid, ends: tuple[str, str], family: str) -> Mesh:
    """Cells between the planes (p, m, 3) of a grid; regions ``ends`` and the grid's sides."""
    order = ORDER[family]
    count, m = planes.shape[:2]
    firsts = m * np.arange(0, count - 1, order)[:, None, None]
    low, middle, high = (firsts + k * m + grid.quads for k in (0, 1, order))
    cells = np.concatenate([low, high], axis=2) if order == 1 else _hexahedra27(low, middle, high)
    near = grid.quads[:, [0, 3, 2, 1] if order == 1 else [0, 3, 2, 1, 7, 6, 5, 4, 8]]
    facets = {ends[0]: near, ends[1]: grid.quads + (count - 1) * m}
    facets |= {n: _walls(low, middle, high, s, order) for n, s in grid.sides.items()}
    last = np.cumsum([0] + [len(f) for f in facets.values()])
    hexahedron, quad = ("hexahedron", "quad") if order == 1 else ("hexahedron27", "quad9")
    spans = zip(facets, last, last[1:], strict=False)
    regions = {name: (quad, np.arange(a, b)) for name, a, b in spans}
    both = {hexahedron: cells.reshape(-1, cells.shape[2]), quad: np.vstack(list(facets.values()))}
    mesh = Mesh(planes.reshape(-1, 3), both, regions)
    if family == "hexahedron20":
        return _without_centres(mesh)
    return tetrahedra(mesh) if family.startswith("tetra") else mesh


def _hexahedra27(low: Indices, middle: Indices, high: Indices) -> Indices:
    """(layers, k, 27) from the quad9 of three planes."""
    corners = [low[..., :4], high[..., :4]]
    edges = [low[..., 4:8], high[..., 4:8], middle[..., :4]]
    faces = [middle[..., [7, 5, 4, 6]], low[..., 8:], high[..., 8:]]
    return np.concatenate([*corners, *edges, *faces, middle[..., 8:]], axis=-1)


def _walls(low: Indices, middle: Indices, high: Indices, side: Indices, order: int) -> Indices:
    """Facets over edges of the grid, layer by layer."""
    quads, edges = side.T
    a, b, m = edges, (edges + 1) % 4, edges + 4
    corners = [low[:, quads, a], low[:, quads, b], high[:, quads, b], high[:, quads, a]]
    if order == 1:
        return np.stack(corners, axis=-1).reshape(-1, 4)
    between = [low[:, quads, m], middle[:, quads, b], high[:, quads, m], middle[:, quads, a]]
    return np.stack([*corners, *between, middle[:, quads, m]], axis=-1).reshape(-1, 9)


def _without_centres(mesh: Mesh) -> Mesh:
    """hexahedron20 and quad8 of a mesh of hexahedron27 and quad9."""
    cells, facets = mesh.cells["hexahedron27"][:, :20], mesh.cells["quad9"][:, :8]
    used, inverse = np.unique(cells, return_inverse=True)
    place = np.full(len(mesh.points), -1)
    place[used] = np.arange(len(used))
    kept = {"hexahedron20": inverse.reshape(cells.shape), "quad8": place[facets]}
    regions = {name: ("quad8", rows) for name, (_, rows) in mesh.regions.items()}
    return Mesh(mesh.points[used], kept, regions)


# --- tetrahedra ---------------------------------------------------------------------------------


def _divided(cells: Indices) -> Indices:
    """(6 m, 4 or 10)  tetrahedra over the three faces away from each cell's smallest corner."""
    apex = cells[:, :8].argmin(axis=1)
    away = np.array([[f for f in FACES["hexahedron"] if v not in f] for v in range(8)])
    halves = _local_halves(cells, away[apex])  # (m, 3, 2, 3), corners within the cell
    tip = np.broadcast_to(apex[:, None, None, None], (*halves.shape[:3], 1))
    # a face turns outward, so that seen from within, from the tip, it turns the other way
    corners = np.concatenate([halves[..., [0, 2, 1]], tip], axis=-1).reshape(len(cells), 6, 4)
    a, b = np.array(EDGES["tetra"]).T
    between = middles()[corners[..., a], corners[..., b]]
    local = corners if cells.shape[1] == 8 else np.concatenate([corners, between], axis=-1)
    return np.take_along_axis(cells[:, None, :], local, axis=2).reshape(-1, local.shape[2])


def _local_halves(cells: Indices, faces: Indices) -> Indices:
    """(m, f, 2, 3)  triangles of faces (m, f, 4), divided from the smallest node."""
    nodes = np.take_along_axis(cells[:, None, :], faces, axis=2)
    turn = (nodes.argmin(axis=2)[..., None] + np.arange(4)) % 4
    turned = np.take_along_axis(faces, turn, axis=2)
    return np.stack([turned[..., [0, 1, 2]], turned[..., [0, 2, 3]]], axis=2)


def _halved(quads: Indices) -> Indices:
    """(2 m, 3 or 6)  triangles of quads or quad9."""
    every = np.broadcast_to(np.arange(4), (len(quads), 1, 4))
    corners = _local_halves(quads, every).reshape(len(quads), 2, 3)
    if quads.shape[1] == 4:
        return np.take_along_axis(quads[:, None, :], corners, axis=2).reshape(-1, 3)
    table = np.array([[-1, 4, 8, 7], [4, -1, 5, 8], [8, 5, -1, 6], [7, 8, 6, -1]])
    between = table[corners, np.roll(corners, -1, axis=2)]
    local = np.concatenate([corners, between], axis=2)
    return np.take_along_axis(quads[:, None, :], local, axis=2).reshape(-1, 6)
