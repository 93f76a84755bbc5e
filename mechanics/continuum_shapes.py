"""Shape functions and quadrature of the solid elements, by scikit-fem."""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.families import EDGES, FACES

Array = NDArray[np.float64]

ELEMENTS = {"hexahedron20": "ElementHexS2", "hexahedron27": "ElementHex2"}
FACE_ELEMENTS = {"hexahedron20": "ElementQuadS2", "hexahedron27": "ElementQuad2"}
NODES = {"hexahedron20": 20, "hexahedron27": 27}
REDUCED, FULL = 3, 5
"""Degrees of quadrature: 2 x 2 x 2 and 3 x 3 x 3 points of Gauss."""
STIFFNESS = {
    "hexahedron20": ("hexahedron20", REDUCED),
    "hexahedron20-full": ("hexahedron20", FULL),
    "hexahedron27": ("hexahedron27", FULL),
}
"""Cells of each element, and the degree with which its strain is integrated."""


class Shape(NamedTuple):
    """Functions of k nodes at p points of the reference cell, or of a face of it.

    values : (p, k) float
    slopes : (p, k, d) float  by reference coordinates
    weights : (p,) float
    """

    values: Array
    slopes: Array
    weights: Array


@cache
def shape(family: str, degree: int) -> Shape:
    """Functions of the nodes of a cell, in the order of ``meshes.families``."""
    return _shape(ELEMENTS[family], degree, nodes(family))


@cache
def face_shape(family: str, degree: int) -> Shape:
    """Functions of the nodes of a face of a cell."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
    places = np.vstack([corners, middles, corners.mean(axis=0)])
    return _shape(FACE_ELEMENTS[family], degree, places[: FACES[family].shape[1]])


def _shape(name: str, degree: int, places: Array) -> Shape:
    import skfem
    from skfem.quadrature import get_quadrature

    element = getattr(skfem, name)()
    X, weights = get_quadrature(element.refdom, degree)
    far = np.linalg.norm(element.doflocs[None] - places[:, None], axis=2)
    pairs = [element.lbasis(X, int(i)) for i in far.argmin(axis=1)]
    values = np.stack([np.broadcast_to(v, X.shape[1:]) for v, _ in pairs], axis=-1)
    slopes = [np.stack([np.broadcast_to(g, X.shape[1:]) for g in G]) for _, G in pairs]
    ordered = np.stack(slopes, axis=-1).transpose(1, 2, 0)
    return Shape(np.ascontiguousarray(values), np.ascontiguousarray(ordered), weights)


def nodes(family: str) -> Array:
    """(k, 3) nodes of the reference cell from 0 to 1."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    corners = np.vstack([square, square + np.array([0.0, 0.0, 1.0])])
    edges = [corners[list(edge)].mean(axis=0) for edge in EDGES["hexahedron"]]
    faces = [corners[face].mean(axis=0) for face in FACES["hexahedron"]]
    return np.vstack([corners, edges, faces, corners.mean(axis=0)])[: NODES[family]]


class Points(NamedTuple):
    """Of m cells with k nodes at p points.

    gradients : (m, p, k, 3) float [1/m]  of shape functions by reference position
    volumes : (m, p) float [m^3]
    """

    gradients: Array
    volumes: Array


def points(X: Array, form: Shape) -> Points:
    """Of cells whose nodes are at ``X`` (m, k, 3) [m]."""
    tangents = np.einsum("pkr,mki->mpri", form.slopes, X)
    inverse = np.linalg.inv(tangents)
    gradients = np.einsum("mpir,pkr->mpki", inverse, form.slopes)
    return Points(gradients, np.linalg.det(tangents) * form.weights)
