"""Results for ParaView: one .pvd index of .vtu files for each frame, or one .vtkhdf file."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np
from numpy.typing import NDArray

from coupling.contact_places import located, nearest_row, placement
from coupling.reading import BadResults, Results
from coupling.surfaces import Body, Surface, read_bodies, surface

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FOLDER = "vtk"
RESULTANTS = {"membrane_force": [0, 1, 2], "bending_moment": [3, 4, 5], "shear_force": [6, 7]}
"""Columns of the resultants of shells per length: 11, 22, 12 [N/m], [N]; 1, 2 [N/m]."""
SHOWN_JOINT_SIZE = 2.0  # enlarged gap at full clearance, in radii of the widest section


class Block(NamedTuple):
    """What is shown together: its meshes differ from frame to frame in points and fields only.

    part : its number in ParaView
    mesh : of a frame
    """

    name: str
    part: int
    mesh: Callable[[int], meshio.Mesh]


def export(results_path: Path | str, format: str = "pvd") -> list[Path]:
    """Write the recorded frames next to the results and return the files, the index first.

    ``run.pvd`` opens in ParaView as a time series of two blocks: the surfaces of all bodies
    and, when there are joints with clearance, two points for each of their contacts, the centres
    of journal and bearing there; where skins were recorded, their facets are a third; where beams
    were computed as solids, their cells are another. ``run.vtkhdf`` holds the same in one file.
    """
    if format not in FORMATS:
        raise ValueError(f"format '{format}': expected one of {', '.join(FORMATS)}")
    with Results.open(results_path) as results:
        bodies = read_bodies(results)
        times = results["frames/time"] if "frames/time" in results else np.empty(0)
        if not bodies or not len(times):
            raise BadResults(f"{results.path}: no frames of bodies were recorded")
        return FORMATS[format](results.path, times, _blocks(results, bodies, times))


def _blocks(results: Results, bodies: list[Body], times: Array) -> list[Block]:
    found = [Block("bodies", 0, partial(_bodies, bodies))]
    if names := results.names("solids"):
        tables = [results.table(f"solids/{name}") for name in names]
        cells = [results[f"cells/{name}/cells"] for name in names]
        found.append(Block("solids", 3, partial(_solids, tables, cells)))
    if names := results.names("skins"):
        tables = [results.table(f"skins/{name}") for name in names]
        found.append(Block("skins", 2, partial(_skins, tables)))
    joints = _Joints(results, bodies, times)
    if joints.places:
        found.append(Block("joints", 1, joints.mesh))
    return found


def _write_pvd(path: Path, times: Array, blocks: list[Block]) -> list[Path]:
    folder = path.parent / FOLDER
    folder.mkdir(exist_ok=True)
    files = [
        (frame, part, _write(mesh(frame), folder / f"{name}_{frame:05d}.vtu"))
        for name, part, mesh in blocks
        for frame in range(len(times))
    ]
    _remove_others(folder, {path for _, _, path in files})
    index = path.with_name("run.pvd")
    index.write_text(_index(times, files), encoding="utf-8")
    return [index, *(path for _, _, path in files)]


def _write_vtkhdf(path: Path, times: Array, blocks: list[Block]) -> list[Path]:
    file = path.with_name("run.vtkhdf")
    import_module("coupling.vtkhdf").write(file, times, blocks)
    return [file]


def _skins(tables: Sequence[Mapping[str, Any]], frame: int) -> meshio.Mesh:
    """Facets of heated faces with their temperature [K] and the light that they absorb [W/m^2]."""
    corners = np.concatenate([table["corners"][frame] for table in tables])
    fields = {}
    for name in ("temperature", "light"):
        none = [np.full(len(table["corners"][frame]), np.nan) for table in tables]
        pairs = zip(tables, none, strict=True)
        values = np.concatenate([t[name][frame] if name in t else n for t, n in pairs])
        if not np.isnan(values).all():
            fields[name] = [values]
    cells = [("quad", np.arange(4 * len(corners)).reshape(-1, 4))]
    return meshio.Mesh(corners.reshape(-1, 3), cells, cell_data=fields)


def _solids(
    tables: Sequence[Mapping[str, Any]], cells: Sequence[Indices], frame: int
) -> meshio.Mesh:
    """Cells of solids with displacement, temperature [K] and equivalent stress [Pa]."""
    families: dict[str, list[Indices]] = {}
    stress: dict[str, list[Array]] = {}
    start = 0
    for own, table in zip(cells, tables, strict=True):
        family = f"hexahedron{own.shape[1]}".removesuffix("8")
        families.setdefault(family, []).append(start + own)
        stress.setdefault(family, []).append(table["stress"][frame])
        start += table["position"].shape[1]
    points = np.concatenate([table["position"][frame] for table in tables])
    rest = np.concatenate([table["position"][0] for table in tables])
    return meshio.Mesh(
        points,
        [(family, np.concatenate(parts)) for family, parts in families.items()],
        {
            "displacement": points - rest,
            "temperature": np.concatenate([table["temperature"][frame] for table in tables]),
        },
        {"von_mises_stress": [np.concatenate(parts) for parts in stress.values()]},
    )


def _bodies(bodies: list[Body], frame: int) -> meshio.Mesh:
    surfaces = [surface(body, frame) for body in bodies]
    fields = {
        "displacement": np.concatenate([s.displacement for s in surfaces]),
        "temperature": np.concatenate([s.temperature for s in surfaces]),
        "temperature_gradient": np.concatenate([_gradient(s) for s in surfaces]),
        "axial_stress": np.concatenate([s.stress for s in surfaces]),
    }
    resultants = np.concatenate([_resultants(s) for s in surfaces])
    fields |= {name: resultants[:, columns] for name, columns in RESULTANTS.items()}
    cells, owners = _cells(bodies, surfaces)
    return meshio.Mesh(
        np.concatenate([s.points for s in surfaces]),
        cells,
        {name: values for name, values in fields.items() if not np.isnan(values).all()},
        {"body": owners},
    )


def _gradient(shape: Surface) -> Array:
    """(m,) [K/m]  along the normal of a shell."""
    return np.full(len(shape.points), np.nan) if shape.gradient is None else shape.gradient


def _resultants(shape: Surface) -> Array:
    nothing = np.full((len(shape.points), 8), np.nan)
    return nothing if shape.resultants is None else shape.resultants


def _cells(
    bodies: list[Body], surfaces: list[Surface]
) -> tuple[list[tuple[str, Indices]], list[Indices]]:
    """Quads of the surfaces and a vertex for each particle, with the number of their body."""
    found: dict[str, list[Indices]] = {"quad": [], "vertex": []}
    owner: dict[str, list[Indices]] = {"quad": [], "vertex": []}
    start = 0
    for number, (body, shape) in enumerate(zip(bodies, surfaces, strict=True)):
        count = len(shape.points)
        kind = "vertex" if body.is_point else "quad"
        cells = start + (np.arange(count)[:, None] if body.is_point else shape.quads)
        found[kind].append(cells)
        owner[kind].append(np.full(len(cells), number))
        start += count
    kinds = [kind for kind in found if found[kind]]
    return (
        [(kind, np.concatenate(found[kind])) for kind in kinds],
        [np.concatenate(owner[kind]) for kind in kinds],
    )


class _Joints:
    """The contacts of joints with clearance and their histories, read once for all frames."""

    def __init__(self, results: Results, bodies: list[Body], times: Array) -> None:
        self.times = times
        by_name = {body.name: body for body in bodies}
        found = {name: placement(results, name, by_name) for name in results.names("joints")}
        self.places = {name: place for name, place in found.items() if place is not None}
        self.tables = {name: results.table(f"joints/{name}") for name in self.places}
        widths = [max(b.section.height, b.section.width) for b in bodies if b.section]
        self.shown_size = SHOWN_JOINT_SIZE * 0.5 * max(widths, default=1.0)

    def mesh(self, frame: int) -> meshio.Mesh:
        """Two points for each contact: bearing, then journal, with the state nearest in time."""
        rows = [nearest_row(table, self.times[frame]) for table in self.tables.values()]
        places = zip(self.places.values(), rows, strict=True)
        at = [located(place, frame, row) for place, row in places]
        points = [point for centre, gap, _ in at for point in (centre, centre + gap)]
        gap = np.repeat([each.gap for each in at], 2, axis=0)
        clearance = self._field(rows, "clearance")
        fields = {
            "gap": gap,
            "gap_enlarged": gap * (self.shown_size / clearance)[:, None],
            "contact_force": np.repeat([each.force for each in at], 2, axis=0),
            "part": np.tile([0.0, 1.0], len(rows)),
            "contact": np.repeat(np.arange(len(rows), dtype=float), 2),
        }
        for name in ("clearance", "regime", "normal_force", "friction_force"):
            fields[name] = self._field(rows, name)
        cells = [("vertex", np.arange(len(points))[:, None])]
        return meshio.Mesh(np.array(points), cells, fields)

    @staticmethod
    def _field(rows: list[dict[str, Array]], name: str) -> Array:
        return np.repeat([float(row.get(name, np.nan)) for row in rows], 2)


def _write(mesh: meshio.Mesh, path: Path) -> Path:
    mesh.write(path, file_format="vtu", binary=True, compression="zlib")
    return path


def _remove_others(folder: Path, kept: set[Path]) -> None:
    """Delete files of an earlier export that had more frames."""
    for pattern in ("bodies_*.vtu", "joints_*.vtu", "skins_*.vtu", "solids_*.vtu"):
        for path in set(folder.glob(pattern)) - kept:
            path.unlink()


def _index(times: Array, files: list[tuple[int, int, Path]]) -> str:
    names = ("bodies", "joints", "skins", "solids")
    entries = [
        f'    <DataSet timestep="{float(times[frame])!r}" part="{part}" name="{names[part]}" '
        f"file={quoteattr(f'{FOLDER}/{path.name}')}/>"
        for frame, part, path in sorted(files)
    ]
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">',
        "  <Collection>",
        *entries,
        "  </Collection>",
        "</VTKFile>",
    ]
    return "\n".join(lines) + "\n"


FORMATS: dict[str, Callable[[Path, Array, list[Block]], list[Path]]] = {
    "pvd": _write_pvd,
    "vtkhdf": _write_vtkhdf,
}
