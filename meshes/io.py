"""Meshes from and to files, by meshio. Every problem is a ``ValueError`` that names the file."""

import contextlib
import io
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshes.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

COINCIDENT = 1e-9  # distance, relative to the size of the line, below which nodes coincide


def read(path: str | PathLike[str]) -> Mesh:
    """Read a mesh with its named regions (cell sets; physical groups of Gmsh files).

    Where a region has cells of several families, ``Mesh.regions`` has those of the first.
    """
    raw = load(Path(path))
    if raw.points.ndim != 2 or not len(raw.points):
        raise ValueError(f"{path}: has no points")
    points = np.zeros((len(raw.points), 3))
    points[:, : raw.points.shape[1]] = raw.points
    cells = {family: block.astype(np.intp) for family, block in raw.cells_dict.items()}
    try:
        found = _regions(raw)
        regions = {name: next(iter(members.items())) for name, members in found.items()}
        others = {name: dict(list(m.items())[1:]) for name, m in found.items() if len(m) > 1}
        return Mesh(points, cells, regions, others)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def write(path: str | PathLike[str], mesh: Mesh) -> None:
    """Write a mesh in the format that the file's ending names.

    Regions can be kept in Abaqus files (.inp, cell sets) and in Gmsh files (.msh, physical
    groups; those with cells of several families here only); for other endings the mesh must have
    none.
    """
    import meshio

    ending = Path(path).suffix
    if mesh.regions and ending not in (".inp", ".msh"):
        raise ValueError(f"{path}: regions can be kept in .inp and .msh files only")
    if mesh.others and ending != ".msh":
        raise ValueError(f"{path}: regions of several families can be kept in .msh files only")
    raw = meshio.Mesh(mesh.points, dict(mesh.cells))
    if ending == ".msh":
        _add_physical_groups(raw, mesh)
    else:
        raw.cell_sets = _cell_sets(mesh)
    try:
        raw.write(path, file_format="gmsh22" if ending == ".msh" else None)
    except (OSError, meshio.ReadError, meshio.WriteError) as error:
        raise ValueError(f"{path}: cannot be written: {_reason(error)}") from None


def read_line(path: str | PathLike[str], region: str | None = None) -> Array:
    """Read the two-node line cells of a file, or of one of its regions, as one polyline.

    Returns
    -------
    (n, 3) float [m]  from the end with the smaller node number to the other
    """
    mesh = read(path)
    try:
        return mesh.points[_ordered(_line_cells(mesh, region), mesh.points)]
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def load(path: Path):
    """The mesh as meshio gives it; whatever it does about a bad file becomes a ValueError."""
    if not path.exists():
        raise ValueError(f"{path}: there is no such file")
    if path.is_dir():
        raise ValueError(f"{path}: is a directory, not a mesh file")
    import meshio

    silence = io.StringIO()  # meshio prints on its own, and may end the process
    try:
        with contextlib.redirect_stdout(silence), contextlib.redirect_stderr(silence):
            return meshio.read(path)
    except SystemExit:
        raise ValueError(f"{path}: cannot be read as a mesh in the format of its ending") from None
    except Exception as error:
        raise ValueError(f"{path}: cannot be read as a mesh: {_reason(error)}") from None


def _reason(error: BaseException) -> str:
    return str(error) or type(error).__name__


def _regions(raw) -> dict[str, dict[str, Indices]]:
    """Name -> family -> cells, of cell sets and physical groups."""
    regions: dict[str, dict[str, Indices]] = {}
    for name, members in raw.cell_sets_dict.items():
        if not name.startswith("gmsh:"):
            _add(regions, name, members)
    groups = raw.cell_data_dict.get("gmsh:physical", {})
    sets = set(regions)
    for name, (tag, dimension) in raw.field_data.items():
        if name not in sets:
            own = {
                f: np.flatnonzero(t == tag) for f, t in groups.items() if _dim(raw, f) == dimension
            }
            _add(regions, name, own)
    return regions


def _add(regions: dict[str, dict[str, Indices]], name: str, members) -> None:
    kept = {f: np.asarray(rows, dtype=np.intp) for f, rows in members.items() if len(rows)}
    if kept:
        regions.setdefault(name, {}).update(kept)


def _dim(raw, family: str) -> int:
    return next(block.dim for block in raw.cells if block.type == family)


def _cell_sets(mesh: Mesh) -> dict[str, list[Indices]]:
    none = np.empty(0, dtype=np.intp)
    return {
        name: [mesh.cells_of(name).get(family, none) for family in mesh.cells]
        for name in mesh.regions
    }


def _add_physical_groups(raw, mesh: Mesh) -> None:
    """Gmsh gives each cell one tag, 0 where it belongs to no region, and groups one dimension."""
    tags = {family: np.zeros(len(cells), dtype=int) for family, cells in mesh.cells.items()}
    for tag, name in enumerate(mesh.regions, start=1):
        dimensions = set()
        for family, indices in mesh.cells_of(name).items():
            if tags[family][indices].any():
                raise ValueError(
                    f"region '{name}' shares cells with another: no place for it in .msh"
                )
            tags[family][indices] = tag
            dimensions.add(_dim(raw, family))
        if len(dimensions) > 1:
            raise ValueError(f"region '{name}' mixes surface and volume: no place for it in .msh")
        raw.field_data[name] = np.array([tag, *dimensions])
    raw.cell_data = {"gmsh:physical": list(tags.values()), "gmsh:geometrical": list(tags.values())}


def _line_cells(mesh: Mesh, region: str | None) -> Indices:
    if "line" not in mesh.cells or not len(mesh.cells["line"]):
        raise ValueError(f"has no line cells, only {', '.join(mesh.cells) or 'points'}")
    if region is None:
        return mesh.cells["line"]
    if region not in mesh.regions:
        names = ", ".join(f"'{name}'" for name in mesh.regions) or "none"
        raise ValueError(f"has no region '{region}'; its regions are: {names}")
    family, members = mesh.regions[region]
    if family != "line":
        raise ValueError(f"region '{region}' consists of {family} cells, not of lines")
    return mesh.cells["line"][members]


def _ordered(cells: Indices, points: Array) -> Indices:
    """Nodes of one open line in order; a ValueError if the cells are anything else."""
    _require_distinct(np.unique(cells), points)
    _require_simple(cells)
    neighbours: dict[int, list[int]] = {}
    for a, b in cells.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    forks = [node for node, others in neighbours.items() if len(others) > 2]
    if forks:
        raise ValueError(f"the line branches at node {min(forks)}{_at(points, min(forks))}")
    ends = sorted(node for node, others in neighbours.items() if len(others) == 1)
    if not ends:
        raise ValueError("the line is closed: it has no ends")
    order = _walk(ends[0], neighbours)
    if len(order) < len(neighbours):
        raise ValueError(
            f"the line is in several pieces: from node {ends[0]}{_at(points, ends[0])} only "
            f"{len(order)} of {len(neighbours)} nodes are reached"
        )
    return np.array(order, dtype=np.intp)


def _walk(start: int, neighbours: dict[int, list[int]]) -> list[int]:
    order, previous = [start], -1
    while onward := [n for n in neighbours[order[-1]] if n != previous]:
        previous = order[-1]
        order.append(onward[0])
    return order


def _require_distinct(nodes: Indices, points: Array) -> None:
    """No two nodes at one place: that is a line of no length, or pieces not merged."""
    used = points[nodes]
    size = float(np.ptp(used, axis=0).max())
    pairs = cKDTree(used).query_pairs(COINCIDENT * size)
    if pairs:
        a, b = (int(nodes[i]) for i in min(pairs))
        raise ValueError(f"nodes {a} and {b} coincide{_at(points, a)}: merge them")


def _require_simple(cells: Indices) -> None:
    loops = cells[cells[:, 0] == cells[:, 1]]
    if len(loops):
        raise ValueError(f"node {loops[0, 0]} is joined to itself")
    pairs, counts = np.unique(np.sort(cells, axis=1), axis=0, return_counts=True)
    if (counts > 1).any():
        a, b = pairs[counts.argmax()]
        raise ValueError(f"nodes {a} and {b} are joined twice")


def _at(points: Array, node: int) -> str:
    x, y, z = points[node]
    return f" at ({x:g}, {y:g}, {z:g})"
