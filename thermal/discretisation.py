"""What a discretisation in space offers to conditions and to time integration.

Members, walls and solids become temperatures and shape functions in ways of their own. All that
happens on faces and at places is built on what they offer here, once for all of them, by
``thermal.boundary``.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Property
from thermal.description import Place, Side

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Block(NamedTuple):
    """Facets of one kind with p integration points each.

    dofs : (g, k) intp  temperatures that a facet depends on
    values : (p, k) float  shape functions at the points
    areas : (g, p) float [m^2]  of each point; they sum to the area of the face
    points, normals : (g, p, 3) float [m], [-]  in the reference; normals are outward and unit
    polygons : (g, c, 3) float [m]  corners of the facets, turning about the outward normal
    """

    dofs: Indices
    values: Array
    areas: Array
    points: Array
    normals: Array
    polygons: Array


Face = Sequence[Block]


class Mean(NamedTuple):
    """A mean temperature, weights @ T[nodes]; heat given to it is shared out by the weights.

    nodes : (k,) intp  every temperature of the place, also those of no weight
    weights : (k,) float  of sum 1
    """

    nodes: Indices
    weights: Array


class GivenTemperatures(Protocol):
    """Temperatures that one condition prescribes."""

    @property
    def name(self) -> str: ...
    @property
    def nodes(self) -> Indices: ...
    def at(self, t: float) -> Array:
        """(k,) [K] of ``nodes`` at time ``t`` [s]."""
        ...


class Discretisation(Protocol):
    """Heat stored and conducted, and where conditions act.

    x : (n, 3) float [m]  reference positions of the temperatures
    regions : name of member, part, sheet or solid -> (k,) intp
    start : (n,) float [K]  initial temperatures
    given : what conditions prescribe; their nodes do not overlap
    """

    @property
    def x(self) -> Array: ...
    @property
    def regions(self) -> Mapping[str, Indices]: ...
    @property
    def start(self) -> Array: ...
    @property
    def given(self) -> Sequence[GivenTemperatures]: ...

    def face(self, side: Side) -> Face:
        """Where convection, radiation and uniform flux act."""
        ...

    def irradiated(self, side: Side) -> Face:
        """Where irradiation from outside is asked for; as ``face``, or finer."""
        ...

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed; parallel rays, or the same everywhere."""
        ...

    def place(self, place: Place) -> Mean:
        """Mean over a place; over all of a body by volume."""
        ...

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored, each temperature's share."""
        ...

    def power(self, T: Array) -> Array:
        """(n,) [W] that each temperature receives by conduction."""
        ...

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns (k,) of the entries of ``tangent``."""
        ...

    def tangent(self, T: Array, tau: float) -> Array:
        """(k,) entries of dE/dT - tau dP/dT, of heat E and conducted power P."""
        ...

    def unusable(self, T: Array) -> str:
        """Which property's range ``T`` has left and where, or ""."""
        ...


def at_points(block: Block, T: Array) -> Array:
    """(g, p) [K]  temperatures at the points of a block."""
    return T[block.dofs] @ block.values.T


def merged(face: Face) -> Face:
    """The same areas in fewer blocks, for flux that depends on nothing but temperature.

    Blocks on the same temperatures become one, points of equal shape functions one point;
    positions and polygons are left out.
    """
    groups: dict[tuple[int, bytes], list[Block]] = {}
    for block in face:
        groups.setdefault((len(block.dofs), block.dofs.tobytes()), []).append(block)
    return [_joined(blocks) for blocks in groups.values()]


def _joined(blocks: Sequence[Block]) -> Block:
    values, point = np.unique(np.vstack([b.values for b in blocks]), axis=0, return_inverse=True)
    areas = np.hstack([b.areas for b in blocks])
    sums = np.stack([areas[:, point.ravel() == i].sum(axis=1) for i in range(len(values))], axis=1)
    nowhere = np.empty((len(areas), 0, 3))
    return Block(blocks[0].dofs, values, sums, nowhere, nowhere, nowhere)


def weighted(weight: Array, rows: Array, columns: Array) -> Array:
    """(g, k, k)  sum over points p of weight (g, p) rows (p, i) columns (p, j)."""
    k = rows.shape[1]
    products = (rows[:, :, None] * columns[:, None, :]).reshape(len(rows), -1)
    return (weight @ products).reshape(-1, k, k)


def facing_loads(face: Face, direction: Array | None, n: int) -> Array:
    """(n,) [m^2]  absorbing area of each temperature by the points of a face.

    direction : of parallel rays; None: the same flux everywhere
    """
    loads = np.zeros(n)
    for block in face:
        areas = block.areas
        if direction is not None:
            rays = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
            areas = areas * np.maximum(0.0, -block.normals @ rays)
        np.add.at(loads, block.dofs, areas @ block.values)
    return loads


class Affine(NamedTuple):
    """Entries of dE/dT - tau dP/dT that do not depend on temperature, computed once.

    capacity : (k,) float [J/K];  conductance : (k,) float [W/K]
    """

    capacity: Array
    conductance: Array

    def at(self, tau: float) -> Array:
        """(k,) entries."""
        return self.capacity + tau * self.conductance


def affine(entries: Callable[[float], Array], properties: Sequence[Property]) -> Affine | None:
    """The entries, a function of tau, as constants; None where a property varies."""
    if not all(p.is_constant for p in properties):
        return None
    capacity = entries(0.0)
    return Affine(capacity, entries(1.0) - capacity)
