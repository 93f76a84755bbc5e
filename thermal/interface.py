"""Heat through two faces that lie on one another, of meshes that need not match."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from thermal.boundary import STEFAN_BOLTZMANN, Moment
from thermal.description import Interface
from thermal.discretisation import Face
from thermal.samples import Products, Samples, samples

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FACING = -0.5  # product of normals up to which two points face one another
REACH = 1.5  # in-plane distance to the closest point, over the size of its area, of one beside
NEAR = 1e-6  # distance over size of a facet that counts as none


class Pressed:
    """Conductance per area between the closest points of two faces.

    Power is counted at the points of the smaller face (of equal ones, of that with more points);
    what leaves these enters the other face at their projections, whose temperatures follow from
    the points of the facet there, exact where they are linear. Points that face nothing exchange
    nothing.

    Raises ValueError when no points of the two faces lie on one another.
    """

    def __init__(self, interface: Interface, face_a: Face, face_b: Face) -> None:
        self.names: Sequence[str] = ()
        self._interface = interface
        one, other = samples([face_a]), samples([face_b])
        swapped = _rank(other) < _rank(one)
        if swapped:
            one, other = other, one
        closest, lies_on = _projected(one, other)
        if not lies_on.any():
            raise ValueError(
                f"interface '{interface.name}': face '{interface.a.face}' of "
                f"'{interface.a.thing}' does not lie on face '{interface.b.face}' of "
                f"'{interface.b.thing}'"
            )
        self._areas = one.areas[lies_on]
        self._nodes = np.union1d(one.nodes, other.nodes)
        ends = (_among(one, one.at, self._nodes), _among(other, closest, self._nodes))
        self._a, self._b = (end[lies_on] for end in (ends[::-1] if swapped else ends))
        self._into = csr_array((self._a - self._b).T)
        both = abs(self._a) + abs(self._b)
        self._entries = Products(both, both)
        self._by_a = self._entries.factors(self._a - self._b, self._a)
        self._by_b = self._entries.factors(self._a - self._b, self._b)

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        """See Term; nothing comes from outside."""
        Ta, Tb = self._ends(T)
        density = self._coefficient(Ta, Tb) * (Tb - Ta)
        density += self._radiated() * (Tb**4 - Ta**4)
        out[self._nodes] += self._into @ (self._areas * density)
        return ()

    def entries(self) -> tuple[Indices, Indices]:
        """Point by point, the temperatures of both faces."""
        return self._nodes[self._entries.rows], self._nodes[self._entries.columns]

    def slopes(self, T: Array, at: Moment) -> Array:
        """See Term."""
        Ta, Tb = self._ends(T)
        law, plain = self._interface.law, self._coefficient(Ta, Tb)
        bend = np.zeros_like(Ta)
        if law is not None:
            slope = law.derivative(0.5 * (Ta + Tb))
            bend = 0.5 * self._interface.coefficient * slope * (Tb - Ta)
        by_a = plain - bend + 4.0 * self._radiated() * Ta**3
        by_b = -plain - bend - 4.0 * self._radiated() * Tb**3
        points = self._entries.points
        return (self._areas * by_a)[points] * self._by_a + (self._areas * by_b)[points] * self._by_b

    def _ends(self, T: Array) -> tuple[Array, Array]:
        own = T[self._nodes]
        return self._a @ own, self._b @ own

    def _coefficient(self, Ta: Array, Tb: Array) -> Array:
        law = self._interface.law
        factor = np.ones_like(Ta) if law is None else law(0.5 * (Ta + Tb))
        return self._interface.coefficient * factor

    def _radiated(self) -> float:
        return STEFAN_BOLTZMANN * self._interface.radiating


def _rank(found: Samples) -> tuple[float, int]:
    """Smaller faces first, and of faces that are the same to round-off the finer."""
    return float(f"{found.areas.sum():.6g}"), -len(found.areas)


def _among(found: Samples, at: csr_array, nodes: Indices) -> csr_array:
    """Interpolation with its columns counted among ``nodes``."""
    columns = np.searchsorted(nodes, found.nodes)[at.indices]
    return csr_array((at.data, columns, at.indptr), shape=(at.shape[0], len(nodes)))


def _projected(one: Samples, other: Samples) -> tuple[csr_array, NDArray[np.bool_]]:
    """Interpolation from the temperatures of ``other`` to the projections of points of ``one``.

    Of points that face nothing, the second array is false.
    """
    _, nearest = cKDTree(other.points).query(one.points)
    gaps = one.points - other.points[nearest]
    normals = other.normals[nearest]
    beside = gaps - (gaps * normals).sum(1)[:, None] * normals
    facing = (one.normals * normals).sum(1)
    shaped = (np.abs(one.normals).sum(1) > 0.0) & (np.abs(normals).sum(1) > 0.0)
    near = np.linalg.norm(beside, axis=1) <= REACH * np.sqrt(other.areas[nearest])
    weights = _from_points(other, nearest, other.points[nearest] + beside)
    return csr_array(weights @ other.at), ~shaped | ((facing <= FACING) & near)


def _from_points(found: Samples, nearest: Indices, x: Array) -> csr_array:
    """(n, P)  temperatures at ``x`` from those at the points of the facets that are nearest."""
    order = np.argsort(found.facets, kind="stable")
    first = np.searchsorted(found.facets[order], np.arange(found.facets.max() + 2))
    rows, columns, values = [], [], []
    for i, point in enumerate(nearest):
        facet = found.facets[point]
        points = order[first[facet] : first[facet + 1]]
        rows.append(np.full(len(points), i))
        columns.append(points)
        values.append(_linear_weights(found.points[points], x[i]))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(entries, shape=(len(x), len(found.areas)))


def _linear_weights(points: Array, x: Array) -> Array:
    """Weights (p,) of sum 1 that reproduce linear functions at ``x`` from values at points.

    Moving least squares that interpolate (Lancaster & Salkauskas 1981): near points count more,
    and at a point itself its value alone.
    """
    arms = points - x
    square = (arms**2).sum(1)
    size = np.sqrt(square.max())
    if len(points) == 1 or square.min() <= (NEAR * size) ** 2:
        weights = np.zeros(len(points))
        weights[square.argmin()] = 1.0
        return weights
    near = square.min() / square
    moments = np.vstack([np.ones(len(points)), arms.T / size])
    gram = (moments * near) @ moments.T
    return near * (np.linalg.pinv(gram, rcond=1e-10)[0] @ moments)
