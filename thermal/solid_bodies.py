"""Members, sheets and solids as bodies of volume cells with materials and named regions."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from meshes.families import CORNERS, SOLID
from meshes.generate import line
from meshes.materials import Material, Property
from meshes.mesh import Mesh
from meshes.solids import member_mesh, sheet_mesh
from thermal.description import Member, Settings, Sheet, Solid
from thermal.layout import arclength
from thermal.solid_elements import FLAT, STORAGE, flatness, geometry, shape
from thermal.solid_skin import Skin, skin

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Cells = Mapping[str, Indices]

AROUND = 24  # cells round a section at the least: chords of true length, radius 0.3 % too large
CHUNK = 8192  # cells whose geometry is looked at together


class Filling(NamedTuple):
    """Cells of one family and one material.

    cells : (m, n) intp
    directions : "along", "plane" or (3, 3) float  those of conductivities: by the cells of a member
        or of a sheet, or rows
    regular : whether the cells come closer to boxes as they get smaller
    """

    family: str
    cells: Indices
    material: Material
    directions: str | Array
    regular: bool = False


class Body(NamedTuple):
    """A connected body.

    points : (m, 3) float [m]
    volumes : region -> family -> cells (k, n); "" is all of it
    named : region of the boundary -> facet family -> nodes, as the mesh has them
    local : (m, 3) float  of members [m]: arclength and coordinates in the section; of sheets the
        last is the height, 0 at the bottom to 1 at the top; of solids nothing
    listed : (k,) intp  nodes that others know under its name: of a sheet those over the nodes of
        its surface, node by node from top to bottom; of others all
    """

    thing: Member | Sheet | Solid
    points: Array
    fillings: Sequence[Filling]
    volumes: Mapping[str, Cells]
    named: Mapping[str, Cells]
    skin: Skin
    local: Array
    listed: Indices

    @property
    def name(self) -> str:
        """Of the thing."""
        return self.thing.name


def member_body(m: Member, settings: Settings) -> Body:
    """A member meshed in 3D."""
    _require_directions(m)
    around, layers, order = max(AROUND, m.wall_points), settings.layers, settings.order
    mesh = member_mesh(m.points, m.axes, m.section, around, layers, order)
    s = arclength(m.points)
    # the same mesh along x has arclength and section coordinates as positions
    points, axes = line((0, 0, 0), (s[-1], 0, 0), len(s) - 1, normal=(0, 1, 0))
    points[:, 0] = s
    straight = member_mesh(points, axes, m.section, around, layers, order)
    return _swept_body(m, mesh, "along", straight.points)


def sheet_body(s: Sheet, settings: Settings) -> Body:
    """A sheet meshed in 3D."""
    mesh = sheet_mesh(s.surface, s.thickness, settings.layers, settings.order)
    (family,) = _solid_families(mesh)
    cells, local = mesh.cells[family], np.zeros((len(mesh.points), 3))
    layer = np.arange(len(cells)) // len(s.surface.quads)
    for corner, up in enumerate(shape_heights(family)):
        local[cells[:, corner], 2] = (layer + up) / settings.layers
    return _swept_body(s, mesh, "plane", local)._replace(listed=_over_nodes(s, cells))


def _over_nodes(s: Sheet, cells: Indices) -> Indices:
    quads = s.surface.quads
    layers = cells.reshape(-1, len(quads), cells.shape[1])
    table = np.empty((len(layers) + 1, len(s.surface.points)), np.intp)
    for level, layer in enumerate(layers):
        table[level, quads], table[level + 1, quads] = layer[:, :4], layer[:, 4:8]
    return table[::-1].T.ravel()


def shape_heights(family: str) -> Array:
    """(n,)  third coordinate of the nodes of a reference cell."""
    from thermal.solid_elements import reference

    return reference(family)[:, 2]


def solid_body(s: Solid) -> Body:
    """A solid with the nodes that its cells use, checked."""
    families, problems = _solid_families(s.mesh), _unsupported(s.mesh)
    if problems:
        raise ValueError(_lines(s, problems))
    used = np.unique(np.concatenate([s.mesh.cells[f].ravel() for f in families]))
    place = np.full(len(s.mesh.points), -1)
    place[used] = np.arange(len(used))
    mesh = Mesh(s.mesh.points[used], {f: place[s.mesh.cells[f]] for f in families})
    problems = [*_shapes(mesh, s.mesh), *_pieces(mesh, s.mesh)]
    axes = np.eye(3) if s.axes is None else np.asarray(s.axes, dtype=float)
    if axes.shape != (3, 3) or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6):
        problems.append("its axes must be three orthonormal rows")
    owners = {f: np.full(len(c), "", dtype=object) for f, c in mesh.cells.items()}
    problems += _materials(s, owners)
    if problems:
        raise ValueError(_lines(s, problems))
    try:
        boundary = skin(mesh.cells, len(used))
    except ValueError as error:
        raise ValueError(_lines(s, [str(error)])) from None
    return Body(
        s, mesh.points, _fillings(s, mesh, owners, axes), _volumes(s.mesh, mesh),
        _surfaces(s.mesh, place), boundary, np.zeros((len(used), 3)), np.arange(len(used)),
    )  # fmt: skip


def _swept_body(thing: Member | Sheet, mesh: Mesh, directions: str, local: Array) -> Body:
    (family,) = _solid_families(mesh)
    cells = {family: mesh.cells[family]}
    problems = _shapes(mesh, mesh)
    if problems:
        raise ValueError(_lines(thing, problems))
    every = np.arange(len(mesh.points))
    regular = isinstance(thing, Sheet) or thing.section.kind != "circle"
    filling = Filling(family, mesh.cells[family], thing.material, directions, regular)
    return Body(
        thing, mesh.points, [filling], {"": cells}, _surfaces(mesh, every),
        skin(cells, len(every)), local, every,
    )  # fmt: skip


def _lines(thing: Member | Sheet | Solid, problems: Sequence[str]) -> str:
    kind = type(thing).__name__.lower()
    return "\n  ".join(f"{kind} '{thing.name}': {p}" for p in problems)


def _require_directions(m: Member) -> None:
    _, around, through = m.material.conductivities
    if m.section.kind != "tube" and around is not through:
        kinds = f"a section of kind '{m.section.kind}' has no directions around and through"
        raise ValueError(_lines(m, [f"{kinds} for its conductivities"]))


# --- solids: what they need, and what is wrong with them ------------------------------------------


def _solid_families(mesh: Mesh) -> list[str]:
    return [f for f in mesh.cells if f in SOLID and len(mesh.cells[f])]


def _unsupported(mesh: Mesh) -> list[str]:
    plain = ("vertex", "line", "triangle", "quad")
    others = [f for f, c in mesh.cells.items() if len(c) and not f.startswith((*plain, *SOLID))]
    others += [f for f in mesh.cells if f.startswith(SOLID) and f not in SOLID]
    known = ", ".join(SOLID)
    found = [f"cells of family {f} are not known, only {known}" for f in dict.fromkeys(others)]
    if not _solid_families(mesh) and not found:
        found = [f"its mesh has no volume cells ({known})"]
    return found


def _shapes(mesh: Mesh, source: Mesh) -> list[str]:
    """Inverted and degenerate cells, numbered as in the mesh."""
    found = []
    for family, cells in mesh.cells.items():
        if family not in SOLID:
            continue
        form = shape(family, STORAGE[family])
        parts = [
            flatness(geometry(mesh.points[cells[i : i + CHUNK]], form))
            for i in range(0, len(cells), CHUNK)
        ]
        least = np.concatenate(parts)
        bad = np.flatnonzero(~(least > FLAT))
        if len(bad):
            worst = int(bad[np.argmin(least[bad])])
            what = "inverted" if least[worst] < -FLAT else "degenerate"
            where = _place(mesh.points[cells[worst]].mean(axis=0))
            count = f"{len(bad)} of {len(cells)} {family} cells have no volume or a negative one"
            one = f"{family} {worst} at {where} is {what}{_inside(source, family, worst)}"
            found.append(f"{count}; {one}")
    return found


def _inside(mesh: Mesh, family: str, cell: int) -> str:
    """Which regions a cell is in, in words."""
    names = [n for n in mesh.regions if cell in mesh.cells_of(n).get(family, ())]
    return f", in region '{names[0]}'" if names else ""


def _pieces(mesh: Mesh, source: Mesh) -> list[str]:
    """Parts that hang together with nothing else."""
    rows = [np.repeat(c[:, 0], c.shape[1] - 1) for c in mesh.cells.values()]
    columns = [c[:, 1:].ravel() for c in mesh.cells.values()]
    i, j = np.concatenate(rows), np.concatenate(columns)
    n = len(mesh.points)
    graph = coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(n, n))
    count, piece = connected_components(graph, directed=False)
    sizes = np.bincount(piece)
    found = []
    for k in np.argsort(-sizes)[1:4] if count > 1 else ():
        family, cell = next(
            (f, int(np.flatnonzero(piece[c[:, 0]] == k)[0]))
            for f, c in mesh.cells.items()
            if (piece[c[:, 0]] == k).any()
        )
        where = _place(mesh.points[mesh.cells[family][cell]].mean(axis=0))
        found.append(
            f"it is in {count} pieces; one of {sizes[k]} nodes, with {family} {cell} at {where}"
            f"{_inside(source, family, cell)}, is isolated: merge nodes, or make it a solid"
        )
    return found


def _place(x: Array) -> str:
    return f"({x[0]:.4g}, {x[1]:.4g}, {x[2]:.4g})"


def _materials(s: Solid, owners: dict[str, NDArray[np.object_]]) -> list[str]:
    """Enter the region that gives each cell its material; what is wrong with that."""
    found = []
    for name in filter(None, s.materials):
        rows = {f: r for f, r in s.mesh.cells_of(name).items() if f in owners and len(r)}
        if not rows:
            found.append(f"material of region '{name}': it has no volume cells")
        for family, members in rows.items():
            before = owners[family][members]
            twice = next(filter(None, before), None)
            if twice is not None:
                found.append(f"regions '{twice}' and '{name}' both give cells their material")
            owners[family][members] = name
    bare = sum(int((o == "").sum()) for o in owners.values())
    if bare and "" not in s.materials:
        found.append(f"{bare} of its cells have no material; the material of region '' is theirs")
    return found


def _fillings(
    s: Solid, mesh: Mesh, owners: Mapping[str, NDArray[np.object_]], axes: Array
) -> list[Filling]:
    return [
        Filling(family, cells[owners[family] == name], material, axes)
        for family, cells in mesh.cells.items()
        for name, material in s.materials.items()
        if (owners[family] == name).any()
    ]


def _volumes(source: Mesh, mesh: Mesh) -> dict[str, Cells]:
    found: dict[str, Cells] = {"": mesh.cells}
    for name in source.regions:
        own = {f: mesh.cells[f][r] for f, r in source.cells_of(name).items() if f in mesh.cells}
        if own:
            found[name] = own
    return found


def _surfaces(mesh: Mesh, place: Indices) -> dict[str, Cells]:
    found: dict[str, Cells] = {}
    for name in mesh.regions:
        parts = {f: r for f, r in mesh.cells_of(name).items() if f.startswith(("tri", "quad"))}
        if parts:
            found[name] = {f: place[mesh.cells[f][r][:, : CORNERS[f]]] for f, r in parts.items()}
    return found


def conductivities(filling: Filling) -> dict[Property, list[int]]:
    """Distinct conductivities of a filling, and for which of its three directions each is."""
    found: dict[Property, list[int]] = {}
    for direction, p in enumerate(filling.material.conductivities):
        found.setdefault(p, []).append(direction)
    return found
