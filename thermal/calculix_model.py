"""A heat problem as elements of CalculiX: bodies meshed in 3D, lumps and links as bricks.

A lump is a brick of its mass whose corners have one temperature. A link is a brick without mass,
whose two ends have the mean temperatures of the places it connects; what it conducts enters them
by the same weights. CalculiX takes the conductivity of a C3D8 at its mean temperature, as a link
does. Of a C3D20R it takes it at 2 x 2 x 2 points; with 4 sigma A T^3 and a linear temperature this
gives sigma A (Ta^4 - Tb^4) exactly.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, polynomial
from thermal.calculix_deck import STEFAN_BOLTZMANN, Elements, Model, Substance, Table, table
from thermal.description import (
    Description,
    Enclosure,
    History,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
)
from thermal.discretisation import Block, Discretisation, Mean

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

KINDS = {
    "tetra": "C3D4",
    "tetra10": "C3D10",
    "hexahedron": "C3D8",
    "hexahedron20": "C3D20",
}
"""Families of cells that CalculiX has; their nodes are ordered as in meshio."""

BRICK = np.array(
    [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
)
TETRA = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
"""Corners of the faces in the order of CalculiX's numbers, from 1 on."""

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
    dtype=float,
)
_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
)
_NEAR, _FAR = [0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]
_BETWEEN = [16, 17, 18, 19]
NO_MASS = 1e-20  # density times heat capacity [J/(m^3 K)] of links


class Held(NamedTuple):
    """Nodes at a temperature that a link leads to."""

    nodes: Indices
    temperature: History


class Assembled(NamedTuple):
    """A model, its held nodes, and the faces of its elements."""

    model: Model
    held: Sequence[Held]
    faces: "Faces"


class Faces:
    """The faces of elements, found by their corners; a lump's by its single temperature."""

    def __init__(self, elements: Sequence[Elements], lumps: dict[int, int]) -> None:
        self._lumps = lumps
        corners, numbers, first = [], [], 1
        for e in elements:
            local = TETRA if e.kind in ("C3D4", "C3D10") else BRICK
            faces = np.sort(e.nodes[:, local], axis=2).reshape(-1, local.shape[1])
            corners.append(np.pad(faces, ((0, 0), (0, 4 - faces.shape[1])), constant_values=-1))
            number = first + np.repeat(np.arange(len(e.nodes)), len(local))
            side = np.tile(np.arange(1, len(local) + 1), len(e.nodes))
            numbers.append(np.stack([number, side], axis=1))
            first += len(e.nodes)
        rows = np.vstack([np.empty((0, 4), np.intp), *corners])
        self._numbers = np.vstack([np.empty((0, 2), np.intp), *numbers])
        self._order = np.lexsort(rows.T[::-1])
        self._rows = _keys(rows[self._order])
        self._is_corner = np.zeros(1 + rows.max(initial=0), dtype=bool)
        self._is_corner[rows[rows >= 0]] = True

    def find(self, block: Block) -> list[tuple[int, int]]:
        """Number of the element and of its face, of each facet of a block."""
        if block.dofs.shape[1] == 1:
            return [(self._lumps[node], 1) for node in block.dofs[:, 0].tolist()]
        g = len(block.dofs)
        corners = np.sort(block.dofs[self._is_corner[block.dofs]].reshape(g, -1), axis=1)
        wanted = _keys(np.pad(corners, ((0, 0), (0, 4 - corners.shape[1])), constant_values=-1))
        places = np.searchsorted(self._rows, wanted)
        return [tuple(pair) for pair in self._numbers[self._order[places]].tolist()]


def _keys(rows: Indices) -> NDArray:
    """Rows (m, 4) as single values that sort as the rows do."""
    kind = np.dtype([(f"f{i}", np.intp) for i in range(4)])
    return np.ascontiguousarray(rows, dtype=np.intp).view(kind).ravel()


def substance(material: Material) -> Substance:
    """Density, heat capacity and one conductivity, or three where they differ."""
    kinds = material.conductivities
    tables = tuple(map(table, kinds if len(set(kinds)) > 1 else kinds[:1]))
    return Substance(material.density, table(material.heat_capacity), tables)


def refusals(d: Description, settings: Settings) -> list[str]:
    """One sentence for each thing that CalculiX cannot express."""
    found = []
    if settings.capacity == "lumped":
        found.append("capacity: CalculiX stores heat by integrals, not at nodes")
    found += [
        f"radiation '{c.name}': its emissivity depends on temperature; CalculiX takes a constant"
        for c in d.conditions
        if isinstance(c, Radiation) and not isinstance(c.emissivity, float | int)
    ]
    found += [
        f"enclosure '{c.name}': CalculiX computes view factors itself and takes no given ones"
        for c in d.conditions
        if isinstance(c, Enclosure) and c.view_factors is not None
    ]
    found += [f"interface '{i.name}': faces that lie on one another are not written"
              for i in d.interfaces]  # fmt: skip
    for s in d.solids:
        found += [
            f"solid '{s.name}': CalculiX has no cells of the family {family}"
            for family in s.mesh.cells
            if family.startswith(("hexahedron", "tetra", "wedge")) and family not in KINDS
        ]
    return found


def assemble(d: Description, space: Discretisation, bodies: Sequence[Elements]) -> Assembled:
    """The elements of bodies, and bricks for lumps and links."""
    bricks = _Bricks(space.x, sum(len(e.nodes) for e in bodies))
    lumps = {}
    for part in d.parts:
        (node,) = space.regions[part.name].tolist()
        lumps[node] = bricks.lump(part, node)
    for link in d.links:
        bricks.link(link, space)
    elements = [*bodies, *bricks.elements]
    model = Model(np.vstack([space.x, *bricks.x]), elements, bricks.ties)
    return Assembled(model, bricks.held, Faces(elements, lumps))


class _Bricks:
    """Single elements with nodes of their own after those of the bodies."""

    def __init__(self, x: Array, first: int) -> None:
        self._nodes, self._elements = len(x), first
        self.x: list[Array] = []
        self.elements: list[Elements] = []
        self.ties: list[tuple[int, Mean]] = []
        self.held: list[Held] = []

    def lump(self, part: Part, node: int) -> int:
        """A brick whose first face has the area of the part; the number of the element."""
        side = np.sqrt(part.area) if part.area > 0.0 else 0.01
        full = substance(part.material)
        one = Table(np.zeros(1), np.ones(1))
        at = Substance(part.mass / side**3, full.heat_capacity, (one,))
        others = self._new(np.asarray(part.position) + side * CORNERS[1:])
        self.ties += [(other, Mean(np.array([node]), np.ones(1))) for other in others.tolist()]
        return self._add("C3D8", np.append([node], others), at)

    def link(self, link: Link, space: Discretisation) -> None:
        """Bricks of length and section 1: one that conducts, one that radiates."""
        if link.conductance is None or link.conductance > 0.0:
            law = Table(np.zeros(1), np.ones(1)) if link.law is None else table(link.law)
            nodes = self._new(CORNERS)
            self._end(nodes[:4], link.a, space)
            self._end(nodes[4:], link.b, space)
            if link.conductance is None:
                self._add("C3D8", nodes, _massless(law, 1.0), link.name)
            else:
                self._add("C3D8", nodes, _massless(law, link.conductance))
        if link.radiating:
            self._radiating(link, space)

    def _radiating(self, link: Link, space: Discretisation) -> None:
        nodes = self._new(
            np.vstack([CORNERS, 0.5 * (CORNERS[_EDGES[:, 0]] + CORNERS[_EDGES[:, 1]])])
        )
        a = self._end(nodes[_NEAR], link.a, space)
        b = self._end(nodes[_FAR], link.b, space)
        half = np.concatenate([0.5 * a.weights, 0.5 * b.weights])
        self._tie(nodes[_BETWEEN], Mean(np.concatenate([a.nodes, b.nodes]), half))
        self._add("C3D20R", nodes, _massless(_CUBIC, link.radiating))

    def _end(self, nodes: Indices, at: Place | History, space: Discretisation) -> Mean:
        """Give nodes the temperature of a place, or hold them; the mean that is theirs."""
        if isinstance(at, Place):
            mean = space.place(at)
            self._tie(nodes, mean)
            return mean
        self.held.append(Held(nodes, at))
        return Mean(nodes[:1], np.ones(1))

    def _new(self, x: Array) -> Indices:
        self.x.append(x)
        nodes = self._nodes + np.arange(len(x))
        self._nodes += len(x)
        return nodes

    def _tie(self, nodes: Indices, mean: Mean) -> None:
        self.ties += [(node, mean) for node in nodes.tolist()]

    def _add(
        self, kind: str, nodes: Indices, substance: Substance, factor: str | None = None
    ) -> int:
        self.elements.append(Elements(kind, nodes[None], substance, None, factor))
        self._elements += 1
        return self._elements


_CUBIC = table(polynomial("radiation", "W/(m^2 K)", [0.0, 0.0, 0.0, 4.0 * STEFAN_BOLTZMANN]))


def _massless(conductivity: Table, factor: float) -> Substance:
    scaled = Table(conductivity.temperatures, factor * conductivity.values)
    return Substance(1.0, Table(np.zeros(1), np.array([NO_MASS])), (scaled,))
