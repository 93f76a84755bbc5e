"""Meshes that are faulty, or of unlike materials."""

from dataclasses import replace

import numpy as np

from meshes.mesh import Mesh
from meshes.solids import box

SIDE = 0.1


def _inverted() -> Mesh:
    """One cell of eight with its bottom and top exchanged."""
    mesh = box((SIDE,) * 3, (2, 2, 2))
    cells = mesh.cells["hexahedron"].copy()
    cells[3] = cells[3, [4, 5, 6, 7, 0, 1, 2, 3]]
    return replace(mesh, cells={**mesh.cells, "hexahedron": cells})


def _pieces() -> Mesh:
    """Two boxes with a gap."""
    one = box((SIDE,) * 3, (2, 2, 2))
    cells, n = one.cells["hexahedron"], len(one.points)
    aside = one.points + np.array([2.0 * SIDE, 0.0, 0.0])
    points = np.vstack([one.points, aside])
    return Mesh(points, {"hexahedron": np.vstack([cells, cells + n])})


def layered() -> Mesh:
    """A bar of two regions, one behind the other."""
    mesh = box((SIDE, 0.01, 0.01), (10, 1, 1))
    cells = mesh.cells["hexahedron"]
    far = mesh.points[cells].mean(axis=1)[:, 0] > 0.5 * SIDE
    regions = {
        "good": ("hexahedron", np.flatnonzero(~far)),
        "bad": ("hexahedron", np.flatnonzero(far)),
    }
    return replace(mesh, regions={**mesh.regions, **regions})


INVERTED, PIECES = _inverted(), _pieces()
