"""Time series of meshes in one VTKHDF file (VTKHDF specification 2.1, Kitware).

A collection of unstructured grids, each with its steps. What does not change is written once: the
cells, since offsets of all steps point at the same; points and fields follow each other, step by
step.
"""

import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import meshio
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Values = NDArray[Any]

VERSION = (2, 1)
TYPES = {"vertex": 1, "quad": 9, "hexahedron": 12, "hexahedron20": 25, "hexahedron27": 29}
"""Numbers of VTK's cells by the names of meshio."""
FIELDS = {"PointData": "PointDataOffsets", "CellData": "CellDataOffsets"}


def write(path: Path, times: Array, blocks: Sequence[Any]) -> None:
    """Write the file, complete or not at all.

    Parameters
    ----------
    times : (f,) float [s]
    blocks : with ``name`` and ``mesh(frame)``, whose cells are the same in all frames
    """
    image = io.BytesIO()  # HDF5 itself does not bear a disk that is full
    with h5py.File(image, "w") as file:
        root = _group(file, "VTKHDF", "PartitionedDataSetCollection")
        assembly = root.create_group("Assembly", track_order=True)
        for index, block in enumerate(blocks):
            grid = _group(root, block.name, "UnstructuredGrid")
            grid.attrs["Index"] = index
            _write_grid(grid, times, [block.mesh(frame) for frame in range(len(times))])
            leaf = assembly.create_group(block.name, track_order=True)
            leaf[block.name] = h5py.SoftLink(grid.name)
    temporary = path.with_name(path.name + ".part")
    try:
        temporary.write_bytes(image.getbuffer())
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _group(parent: h5py.Group, name: str, kind: str) -> h5py.Group:
    group = parent.create_group(name, track_order=True)
    group.attrs["Version"] = VERSION
    group.attrs.create("Type", kind.encode("ascii"), dtype=h5py.string_dtype("ascii", len(kind)))
    return group


def _write_grid(grid: h5py.Group, times: Array, meshes: list[meshio.Mesh]) -> None:
    first = meshes[0]
    steps = grid.create_group("Steps")
    steps.attrs["NSteps"] = len(times)
    steps["Values"] = times
    for name in ("PartOffsets", "NumberOfParts"):
        steps[name] = np.full(len(times), int(name == "NumberOfParts"))
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((len(times), 1), int)
    steps["PointOffsets"] = len(first.points) * np.arange(len(times))
    _write_cells(grid, first)
    _write_series(grid, "Points", [mesh.points for mesh in meshes])
    at_cells = [{k: np.concatenate(v) for k, v in mesh.cell_data.items()} for mesh in meshes]
    for kind, rows in zip(FIELDS, ([mesh.point_data for mesh in meshes], at_cells), strict=True):
        _write_fields(grid, kind, rows)


def _write_cells(grid: h5py.Group, mesh: meshio.Mesh) -> None:
    blocks = mesh.cells
    sizes = np.concatenate([np.full(len(b.data), b.data.shape[1]) for b in blocks])
    types = [np.full(len(b.data), TYPES[b.type], np.uint8) for b in blocks]
    grid["NumberOfPoints"] = [len(mesh.points)]
    grid["NumberOfCells"] = [len(sizes)]
    grid["NumberOfConnectivityIds"] = [sizes.sum()]
    grid["Offsets"] = np.concatenate([[0], np.cumsum(sizes)])
    grid["Connectivity"] = np.concatenate([b.data.ravel() for b in blocks])
    grid["Types"] = np.concatenate(types)


def _write_fields(grid: h5py.Group, kind: str, rows: list[dict[str, Values]]) -> None:
    """What some frames lack is no number there."""
    values, offsets = grid.create_group(kind), grid["Steps"].create_group(FIELDS[kind])
    for name in dict.fromkeys(name for row in rows for name in row):
        one = next(row[name] for row in rows if name in row)
        missing = np.full(one.shape, np.nan)
        _write_series(values, name, [row.get(name, missing) for row in rows])
        offsets[name] = len(one) * np.arange(len(rows))


def _write_series(group: h5py.Group, name: str, values: list[Values]) -> None:
    data = np.concatenate(values)
    group.create_dataset(name, data=data, chunks=values[0].shape, compression="gzip", shuffle=True)
