"""A sheet with temperatures on both faces, linear through its thickness.

Each face stores and conducts for its half of the thickness; from face to face heat flows through
the thickness. Areas are those of the middle surface.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshes.surfaces import Surface
from thermal.description import Condition, Description, Sheet
from thermal.discretisation import Block, GivenTemperatures, Mean, facing_loads
from thermal.layout import face_positions, given
from thermal.wall_elements import (
    CORNERS,
    INSIDE,
    PORTIONS,
    WEIGHTS,
    Bonds,
    Shape,
    conduct,
    locate,
    sharing,
    summed,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SAME = 1e-6  # of an element's size: how near two elements must see a common node
TOP, BOTTOM = 0, 1


class SheetWall:
    """Elements of a sheet's surface, twice; see ``thermal.wall``.

    Nodes carry their temperatures in pairs, top and bottom. At order 2 there are more nodes on the
    edges and in the middle of elements.

    x : (m, 3) float [m]
    named : (k,) intp  the temperatures of the surface's own nodes
    volumes : (m,) float [m^3]
    bonds : along, across and through
    """

    def __init__(self, sheet: Sheet, form: Shape) -> None:
        self.thing, self.form = sheet, form
        surface = sheet.surface
        self.cells = _cells(surface, form)
        self._spot = locate(surface, form.nodes)
        shares, flat = conduct(self.cells, self._spot.along, self._spot.across, form)
        self._areas = summed(self.cells, shares)
        self.x = self._positions()
        self.named = np.arange(2 * len(surface.points))
        self.volumes = 0.5 * sheet.thickness * np.repeat(self._areas, 2)
        self.bonds = (*(_twice(bonds, 0.5 * sheet.thickness) for bonds in flat), self._through())

    def given(
        self, conditions: Sequence[Condition], nodes: Indices, x: Array
    ) -> list[GivenTemperatures]:
        """What conditions prescribe, of all nodes."""
        d = Description((), conditions=conditions, sheets=[self.thing])
        return given(d, {self.thing.name: nodes}, x)

    def face(self, face: str) -> list[Block]:
        """One facet for each node of each element."""
        cells, weights = self.cells, self.form.weights
        points, normals = self._skin(self.form.nodes, face)
        return [
            Block(
                2 * cells.reshape(-1, 1) + _layer(face),
                np.ones((1, 1)),
                (self._spot.areas * weights).reshape(-1, 1),
                points.reshape(-1, 1, 3),
                normals.reshape(-1, 1, 3),
                self._quads(self.form.steps, _breaks(self.form.order), face),
            )
        ]

    def irradiated(self, face: str) -> list[Block]:
        """Elements with points in rows and columns."""
        points, normals = self._skin(INSIDE, face)
        areas = locate(self.thing.surface, INSIDE).areas * PORTIONS
        corners = self._quads(np.zeros((1, 2), np.intp), np.array([0.0, 1.0]), face)
        shapes = sharing(self.form.order, INSIDE)
        return [Block(2 * self.cells + _layer(face), shapes, areas, points, normals, corners)]

    def absorbing(self, face: str, direction: Array | None) -> Array:
        """(m,) [m^2]; see ``thermal.discretisation``."""
        points = self.face(face) if direction is None else self.irradiated(face)
        return facing_loads(points, direction, len(self.x))

    def place(self, end: str | None) -> Mean:
        """All of the sheet, or one of its faces."""
        areas = np.repeat(self._areas, 2)
        nodes = np.arange(len(areas)) if end is None else np.arange(_layer(end), len(areas), 2)
        return Mean(nodes, areas[nodes] / areas[nodes].sum())

    def _through(self) -> Bonds:
        top = np.arange(0, 2 * len(self._areas), 2)
        return Bonds(top, top + 1, self._areas / self.thing.thickness)

    def _positions(self) -> Array:
        """(m, 3) [m]; of the surface's own nodes as everywhere else."""
        x = np.empty((len(self._areas), 2, 3))
        faces = [self._skin(self.form.nodes, face)[0] for face in ("top", "bottom")]
        seen = np.stack(faces, axis=2)
        x[self.cells] = seen
        size = np.sqrt(self._spot.areas.max())
        if np.abs(x[self.cells] - seen).max() > SAME * size:
            raise ValueError(
                f"sheet '{self.thing.name}': neighbouring elements do not agree where their common "
                "nodes are; a closed turn needs three or more elements at order 2"
            )
        x[: len(self.thing.surface.points)] = face_positions(self.thing).reshape(-1, 2, 3)
        return x.reshape(-1, 3)

    def _skin(self, square: Array, face: str) -> tuple[Array, Array]:
        """Points and normals (e, p, 3) of a face."""
        spot = locate(self.thing.surface, square)
        sign = 1.0 - 2.0 * _layer(face)
        return spot.x + 0.5 * sign * self.thing.thickness * spot.normals, sign * spot.normals

    def _quads(self, steps: Indices, breaks: Array, face: str) -> Array:
        """(e p, 4, 3) [m]  from break to break, turning about the outward normal."""
        n = len(breaks)
        grid = np.stack([np.repeat(breaks, n), np.tile(breaks, n)], axis=1)
        corners = (steps[:, None] + CORNERS) @ np.array([n, 1])
        x = self._skin(grid, face)[0][:, corners]
        return x.reshape(-1, 4, 3)[:, :: 1 - 2 * _layer(face)]


def _layer(face: str) -> int:
    return BOTTOM if face == "bottom" else TOP


def _breaks(order: int) -> Array:
    """Where the shares of an element's nodes begin and end along a side."""
    return np.concatenate([[0.0], np.cumsum(WEIGHTS[order])])


def _twice(bonds: Bonds, thickness: float) -> Bonds:
    """Bonds among the nodes of both faces."""
    a, b = (np.concatenate([2 * i, 2 * i + 1]) for i in (bonds.a, bonds.b))
    return Bonds(a, b, thickness * np.tile(bonds.c, 2))


def _cells(surface: Surface, form: Shape) -> Indices:
    """(e, k) nodes of the elements, the surface's own first."""
    if form.order == 1:
        return np.asarray(surface.quads, np.intp)
    from skfem import ElementQuad2, MeshQuad
    from skfem.assembly import Dofs

    flat = np.ascontiguousarray(surface.points[:, :2].T)
    mesh = MeshQuad(flat, np.ascontiguousarray(surface.quads.T), validate=False)
    return np.asarray(Dofs(mesh, ElementQuad2()).element_dofs.T, np.intp)
