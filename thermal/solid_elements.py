"""Shape functions of solid cells and their facets, by scikit-fem, and geometry from them."""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.families import EDGES, FACES

Array = NDArray[np.float64]

CONDUCTION = {"tetra": 1, "tetra10": 2, "hexahedron": 3, "hexahedron20": 5, "hexahedron27": 5}
"""Degree of the quadrature of conduction: enough for the order of convergence of each family."""

STORAGE = {"tetra": 2, "tetra10": 5, "hexahedron": 3, "hexahedron20": 5, "hexahedron27": 5}
"""Degree of the quadrature of stored heat, and of volumes; all weights are positive."""

SURFACE = {"triangle": 2, "triangle6": 5, "quad": 3, "quad8": 5, "quad9": 5}
"""Degree of the quadrature on facets; all weights are positive."""

ELEMENTS = {
    "tetra": "ElementTetP1",
    "tetra10": "ElementTetP2",
    "hexahedron": "ElementHex1",
    "hexahedron20": "ElementHexS2",
    "hexahedron27": "ElementHex2",
    "triangle": "ElementTriP1",
    "triangle6": "ElementTriP2",
    "quad": "ElementQuad1",
    "quad8": "ElementQuadS2",
    "quad9": "ElementQuad2",
}

FLAT = 1e-6  # volume of a cell's Jacobian over the product of its edges: below, it is degenerate

RIGHT = 1e-9  # cosine below which an angle is right


class Shape(NamedTuple):
    """Shape functions at q points of a reference cell of d dimensions.

    values : (q, n) float
    slopes : (q, n, d) float
    weights : (q,) float
    """

    values: Array
    slopes: Array
    weights: Array


@cache
def shape(family: str, degree: int) -> Shape:
    """Functions of the nodes of ``family`` at the points of a quadrature of some degree."""
    from skfem.quadrature import get_quadrature

    X, weights = get_quadrature(_element(family).refdom, degree)
    return Shape(*functions(family, X), weights)


@cache
def at_corners(family: str) -> Shape:
    """Functions of a family of order 1 at its own nodes, with equal weights."""
    nodes = reference(family)
    weights = np.full(len(nodes), 1.0 / len(nodes))
    return Shape(*functions(family, nodes.T), weights)


def _element(family: str):
    import skfem

    return getattr(skfem, ELEMENTS[family])()


def functions(family: str, X: Array) -> tuple[Array, Array]:
    """Values (q, n) and slopes (q, n, d), the nodes in meshio's order, at X (d, q)."""
    element = _element(family)
    far = np.linalg.norm(element.doflocs[None] - reference(family)[:, None], axis=2)
    order = far.argmin(axis=1)
    pairs = [element.lbasis(X, int(i)) for i in order]
    values = np.stack([np.broadcast_to(v, X.shape[1:]) for v, _ in pairs], axis=-1)
    slopes = [np.stack([np.broadcast_to(g, X.shape[1:]) for g in G]) for _, G in pairs]
    ordered = np.stack(slopes, axis=-1).transpose(1, 2, 0)
    return np.ascontiguousarray(values), np.ascontiguousarray(ordered)


def reference(family: str) -> Array:
    """(n, d)  where scikit-fem's reference cell has the nodes of ``family``, in meshio's order."""
    if family.startswith(("tri", "quad")):
        corners = _square()[:, :2] if family.startswith("quad") else np.eye(3)[:, 1:]
        k = len(corners)
        middles = [corners[[i, (i + 1) % k]].mean(axis=0) for i in range(k)]
        nodes = np.vstack([corners, middles, corners.mean(axis=0)])
    else:
        solid = "hexahedron" if family.startswith("hexa") else "tetra"
        low = _square()
        corners = (
            np.vstack([low, low + np.array([0.0, 0.0, 1.0])])
            if solid == "hexahedron"
            else np.eye(4)[:, 1:]
        )
        middles = [corners[list(e)].mean(axis=0) for e in EDGES[solid]]
        faces = [corners[f].mean(axis=0) for f in FACES[solid]] if solid == "hexahedron" else []
        nodes = np.vstack([corners, middles, *faces, corners.mean(axis=0)])
    return nodes[: len(_element(family).doflocs)]


def _square() -> Array:
    return np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])


class Geometry(NamedTuple):
    """Of m cells at q points.

    tangents : (m, q, 3, 3) float [m]  rows: derivatives of position by reference coordinates
    volumes : (m, q) float [m^3]  determinant times weight
    """

    tangents: Array
    volumes: Array


def geometry(points: Array, form: Shape) -> Geometry:
    """Of cells whose nodes are at ``points`` (m, n, 3) [m]."""
    q = len(form.weights)
    flat = form.slopes.transpose(0, 2, 1).reshape(3 * q, -1)
    tangents = np.matmul(flat, points).reshape(len(points), q, 3, 3)
    return Geometry(tangents, form.weights * determinants(tangents))


def determinants(rows: Array) -> Array:
    """Of matrices (..., 3, 3); quicker than by factors."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(rows, (-2, -1), (0, 1))
    return a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)


def metrics(at: Geometry, directions: Array | None) -> Array:
    """(a, m, q, 6) [m]  xx yy zz yz xz xy of sums over q of J^-1 (d d^T) J^-T dV.

    directions : (a, ..., 3) float  unit vectors; None: one sum over all three
    """
    normals = _cofactors(at.tangents)
    # dV = w det; the inverse is cofactors / det, so that w / det remains
    factor = at.volumes / np.sum(at.tangents[..., 0, :] * normals[..., 0, :], axis=-1) ** 2
    if directions is None:
        product = normals @ normals.swapaxes(-1, -2)
        return (factor[..., None] * _six(product))[None]
    parts = []
    for d in directions:
        along = np.sum(normals * d[..., None, :], axis=-1)
        parts.append(factor[..., None] * _six(along[..., :, None] * along[..., None, :]))
    return np.stack(parts)


def _cofactors(tangents: Array) -> Array:
    a, b, c = (tangents[..., i, :] for i in range(3))
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)


def _six(m: Array) -> Array:
    return np.stack([m[..., i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))], -1)


def flatness(at: Geometry) -> Array:
    """(m,)  least determinant over the product of the lengths of tangents; negative: inverted."""
    lengths = np.linalg.norm(at.tangents, axis=-1).prod(axis=-1)
    det = determinants(at.tangents)
    return (det / np.maximum(lengths, 1e-300)).min(axis=1)


def right_angled(at: Geometry) -> NDArray[np.bool_]:
    """(m,)  whether the tangents of a cell are at right angles wherever they are known."""
    unit = at.tangents / np.maximum(np.linalg.norm(at.tangents, axis=-1, keepdims=True), 1e-300)
    products = unit @ unit.swapaxes(-1, -2) - np.eye(3)
    return np.abs(products).max(axis=(1, 2, 3)) < RIGHT
