"""Reference points: the mean position and orientation of a face of a solid body.

With y, z in the plane of the face, counted from its centroid, and means over its area, the plane
r + y r_y + z r_z that fits the positions x best has

    r = mean of x,    (r_y, r_z) = S^-1 (mean of y x, mean of z x),

with S the second moments. The work of forces on r and on section vectors then spreads them over
the face as tension and bending do in a beam: evenly, and linearly in y and z. Nothing is held
stiff, the face may swell, narrow and warp (a distributing coupling). Means are integrals of the
shape functions; with an area for each node instead, nodes of serendipity elements would be loaded
unevenly: a bar of one cell across, 40 along, with such ends is 4 % too soft.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechanics.continuum_shapes import FULL, STIFFNESS, face_shape
from mechanics.description import Body, Continuum, ReferencePoint
from meshes.families import FACES

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FLAT = 1e-8
"""Smaller second moment of a face, relative to the larger one, that is none [-]."""


def placed(point: ReferencePoint, bodies: Mapping[str, Body]) -> ReferencePoint:
    """The point with shares, positions and motion taken from its body, where it has none."""
    body = bodies.get(point.body)
    if not isinstance(body, Continuum):
        raise ValueError(f"reference point {point.name!r}: {point.body!r} is no solid body")
    nodes = np.asarray(point.nodes, np.intp)
    if not nodes.size or nodes.min() < 0 or nodes.max() >= len(body.points):
        raise ValueError(f"reference point {point.name!r}: {point.body!r} has no such nodes")
    points = np.asarray(body.points, float)[nodes] if point.points is None else point.points
    here = replace(
        point,
        nodes=nodes,
        points=points,
        velocity=body.velocity if point.velocity is None else point.velocity,
        spin=body.spin if point.spin is None else point.spin,
    )
    return replace(here, shares=_shares(here, body) if point.shares is None else point.shares)


def face_weights(point: ReferencePoint) -> Array:
    """(3, k) shares of the nodes in r [-], r_y and r_z [1/m] of a point that is placed."""
    return np.asarray(point.shares, float)


def _shares(point: ReferencePoint, body: Continuum) -> Array:
    products = _products(point, body)
    area = products.sum()
    if not area > 0.0:
        raise ValueError(f"reference point {point.name!r}: its area must be positive")
    mean = products.sum(axis=0) / area
    X = np.asarray(point.points, float)
    plane = (X - mean @ X) @ np.asarray(point.axes, float)[1:].T
    first = plane.T @ products / area
    moments = first @ plane
    sizes = np.linalg.eigvalsh(moments)
    if not sizes[0] > FLAT * sizes[1]:
        raise ValueError(f"reference point {point.name!r}: its nodes lie on a line")
    return np.vstack([mean, np.linalg.solve(moments, first)])


def _products(point: ReferencePoint, body: Continuum) -> Array:
    """(k, k) integrals of products of shape functions over the face [m^2]."""
    family, _ = STIFFNESS[body.element]
    local = np.full(len(body.points), -1)
    local[point.nodes] = np.arange(len(point.nodes))
    faces = local[np.asarray(body.cells, np.intp)[:, FACES[family]]]
    faces = faces.reshape(-1, faces.shape[-1])
    faces = faces[np.all(faces >= 0, axis=1)]
    if not faces.size:
        return np.diag(np.asarray(point.weights, float))
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return _integrated(faces[once], np.asarray(point.points, float), family)


def _integrated(faces: Indices, X: Array, family: str) -> Array:
    form = face_shape(family, FULL)
    tangents = np.einsum("pkr,fki->fpri", form.slopes, X[faces])
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * form.weights
    blocks = np.einsum("fp,pi,pj->fij", area, form.values, form.values)
    products = np.zeros((len(X), len(X)))
    np.add.at(products, (faces[:, :, None], faces[:, None, :]), blocks)
    return products
