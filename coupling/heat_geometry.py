"""Meshes of solids and fields of temperature, from tables and files of a case."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from coupling import heat_tables
from coupling.places import Shape
from meshes.mesh import Mesh


def solid_mesh(folder: Path, solid: heat_tables.SolidTable, order: int) -> Mesh:
    """The mesh of a solid. Raises ValueError with what is wrong with its file."""
    if solid.box is not None:
        from meshes.solids import box

        a, b, c = solid.box.elements
        mesh = box(solid.box.size, (a, b, c), order)
        return replace(mesh, points=mesh.points + np.array(solid.box.origin))
    from meshes.io import read

    mesh = read(folder / str(solid.mesh))
    return replace(mesh, points=solid.unit * mesh.points)


def field_of(folder: Path, shapes: Mapping[str, Shape], table: heat_tables.FieldTable):
    """T(x, t) of a table or a file. Raises ValueError with what is wrong with the file."""
    from meshes.fields import Units, read_field, table_field

    if table.file is not None:
        return read_field(folder / table.file, Units(table.length_unit, table.unit), table.name)
    assert table.times and table.distances and table.temperatures
    line = shapes[table.body].points
    return table_field(table.times, table.distances, table.temperatures, line)
