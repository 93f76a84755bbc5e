"""Quadrilaterals of order 1 and 2 with nodal quadrature, and the surfaces they lie on.

Integrals are sums over the nodes of an element: trapezoids at order 1, Simpson's rule at order 2,
in both directions (Gauss-Lobatto points; optimal in order, Ciarlet 1978, sect. 4.1; Maday & Patera
1989). Storage is then diagonal, and on orthogonal lines conduction couples neighbours on one line
only, with conductances that at order 1 are positive whatever the ratio of the sides.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.surfaces import Surface

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

WEIGHTS = {1: np.array([0.5, 0.5]), 2: np.array([1.0, 4.0, 1.0]) / 6.0}
"""Of the nodes of an interval of length 1, by order."""
CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
SIDE = np.polynomial.legendre.leggauss(4)
FINE = len(SIDE[0])  # points of irradiation along each side of an element
FRACTIONS = 0.5 * (1.0 + SIDE[0])
PORTIONS = np.outer(0.5 * SIDE[1], 0.5 * SIDE[1]).ravel()
"""Of an element's area, of the points of irradiation, row by row."""
INSIDE = np.stack([np.repeat(FRACTIONS, FINE), np.tile(FRACTIONS, FINE)], axis=1)
"""(FINE^2, 2) points of irradiation."""
ORTHOGONAL = 1e-12  # cosine of an angle that is a right one


class Shape(NamedTuple):
    """Lagrange functions of a unit square in the numbering of scikit-fem, at its own k nodes.

    nodes : (k, 2) float
    weights : (k,) float  of the nodal quadrature, of sum 1
    slopes : (k, k, 2) float  at node q, of function i, along each side
    """

    order: int
    nodes: Array
    weights: Array
    slopes: Array

    @property
    def steps(self) -> Indices:
        """(k, 2) intp  nodes as steps of a grid."""
        return np.rint(self.order * self.nodes).astype(np.intp)


def shape(order: int) -> Shape:
    """The element of an order."""
    element = _element(order)
    nodes = np.asarray(element.doflocs, dtype=float)
    slopes = np.stack([element.lbasis(nodes.T, i)[1].T for i in range(len(nodes))], axis=1)
    along, across = np.rint(order * nodes).astype(int).T
    return Shape(order, nodes, WEIGHTS[order][along] * WEIGHTS[order][across], slopes)


def _element(order: int):
    from skfem import ElementQuad1, ElementQuad2

    return ElementQuad1() if order == 1 else ElementQuad2()


def sharing(order: int, points: Array) -> Array:
    """(p, k) shares of the nodes in what falls on points (p, 2) of the unit square."""
    steps = shape(order).steps
    along, across = (side_sharing(order, x) for x in points.T)
    return along[:, steps[:, 0]] * across[:, steps[:, 1]]


def side_sharing(order: int, x: Array) -> Array:
    """(..., order + 1) shares of nodes in what falls on x (...) of the unit interval.

    At order 1 the hat functions, which are positive. At order 2 their like would bring an error of
    h^2 between nodes of different weight; in its place come the functions whose integrals with
    the Lagrange functions are the weights of the nodal quadrature, or zero.
    """
    if order == 1:
        return np.stack([1.0 - x, x], axis=-1)
    square = x * x
    return np.stack(
        [1.5 - 6.0 * x + 5.0 * square, 10.0 * (x - square) - 1.0, 0.5 - 4.0 * x + 5.0 * square],
        axis=-1,
    )


class Bonds(NamedTuple):
    """Conductances per conductivity between pairs of nodes: what flows is c k (T_b - T_a).

    a, b : (m,) intp
    c : (m,) float [m]
    """

    a: Indices
    b: Indices
    c: Array


def conduct(
    cells: Indices, along: Array, across: Array, form: Shape
) -> tuple[Array, tuple[Bonds, Bonds]]:
    """Areas (e, k) [m^2] of the nodes of cells, and bonds per thickness in both directions.

    cells : (e, k) intp
    along, across : (e, k, 3) float [m]  derivatives of the position by the sides of the unit
        square, at the nodes; the first direction is ``along``, the second at right angles to it
    """
    area = np.linalg.norm(np.cross(along, across), axis=2)
    length = np.linalg.norm(along, axis=2)
    shear = np.einsum("eqx,eqx->eq", along, across) / length
    shear[np.abs(shear) <= ORTHOGONAL * np.linalg.norm(across, axis=2)] = 0.0
    first = form.slopes[..., 0] / length[..., None]
    second = (form.slopes[..., 1] - shear[..., None] * first) / (area / length)[..., None]
    weights = form.weights * area
    return weights, (_bonds(cells, weights, first), _bonds(cells, weights, second))


def _bonds(cells: Indices, weights: Array, slopes: Array) -> Bonds:
    """Of the sum over q of weights (e, q) slopes (e, q, i) slopes (e, q, j): the rows sum to 0."""
    i, j = np.triu_indices(cells.shape[1], 1)
    c = -np.einsum("eq,eqi,eqj->eij", weights, slopes, slopes, optimize=True)[:, i, j].ravel()
    a, b = cells[:, i].ravel(), cells[:, j].ravel()
    kept = (c != 0.0) & (a != b)
    return joined(Bonds(a[kept], b[kept], c[kept]))


def joined(bonds: Bonds) -> Bonds:
    """Bonds of the same pair as one."""
    if not len(bonds.a):
        return bonds
    low, high = np.minimum(bonds.a, bonds.b), np.maximum(bonds.a, bonds.b)
    size = int(high.max()) + 1
    pairs, slots = np.unique(low * size + high, return_inverse=True)
    return Bonds(pairs // size, pairs % size, summed(slots, bonds.c))


def summed(slots: Indices, amounts: Array) -> Array:
    """Sums of what falls into each slot, from 0 on."""
    return np.bincount(slots.ravel(), weights=amounts.ravel()).astype(np.float64, copy=False)


class Spot(NamedTuple):
    """Points of the elements of a surface.

    x : (e, p, 3) float [m]
    along, across : (e, p, 3) float [m]  derivatives by the sides of the unit square
    """

    x: Array
    along: Array
    across: Array

    @property
    def areas(self) -> Array:
        """(e, p) [m^2]  of the elements, if everything were as at the point."""
        return np.linalg.norm(np.cross(self.along, self.across), axis=2)

    @property
    def normals(self) -> Array:
        """(e, p, 3)"""
        across = np.cross(self.along, self.across)
        return across / np.linalg.norm(across, axis=2, keepdims=True)


def locate(surface: Surface, points: Array) -> Spot:
    """A surface at points (p, 2) of the unit square: bicubic between positions and derivatives."""
    a, b = surface.sizes[:, 0, None, None], surface.sizes[:, 1, None, None]
    q = surface.quads
    corners = [surface.points[q], a * surface.d_u[q], b * surface.d_v[q], a * b * surface.d_uv[q]]
    data = np.stack(corners, axis=2).reshape(len(q), 16, 3)
    (u, du), (v, dv) = _cubics(points[:, 0]), _cubics(points[:, 1])
    products = [_products(m, n).reshape(-1, 16) for m, n in ((u, v), (du, v), (u, dv))]
    return Spot(*(np.moveaxis(np.tensordot(f, data, (1, 1)), 0, 1) for f in products))


def _cubics(x: Array) -> tuple[Array, Array]:
    """Hermite's cubics at x (p,) and their slopes, each (p, end, of value or of slope)."""
    rise, bend = x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)
    start, end = x * (1.0 - x) ** 2, x * x * (x - 1.0)
    starting, ending = (1.0 - x) * (1.0 - 3.0 * x), x * (3.0 * x - 2.0)
    values = np.stack([1.0 - rise, start, rise, end], axis=1)
    slopes = np.stack([-bend, starting, bend, ending], axis=1)
    return values.reshape(-1, 2, 2), slopes.reshape(-1, 2, 2)


def _products(u: Array, v: Array) -> Array:
    """(p, 4, 4)  at each corner of value, slope along u, along v, and both."""
    m, n = u[:, CORNERS[:, 0]], v[:, CORNERS[:, 1]]
    kinds = [(0, 0), (1, 0), (0, 1), (1, 1)]
    return np.stack([m[..., i] * n[..., j] for i, j in kinds], axis=2)
