"""Reference points: the mean position and orientation of a face of a solid body.

With coordinates y, z of the nodes of the face in its plane, counted from their weighted mean, the
plane r + y r_y + z r_z that fits the positions x_i best has

    r = sum of w_i x_i / sum of w_i,    (r_y, r_z) = S^-1 sum of w_i (y_i, z_i) x_i,

with S the weighted second moments. The work of forces on r and on section vectors then spreads
them over the face as tension and bending do in a beam: evenly, and linearly in y and z. Nothing is
held stiff, the face may swell, narrow and warp (a distributing coupling).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Body, Continuum, ReferencePoint

Array = NDArray[np.float64]

FLAT = 1e-8
"""Smaller second moment of a face, relative to the larger one, that is none [-]."""


def placed(point: ReferencePoint, bodies: Mapping[str, Body]) -> ReferencePoint:
    """The point with positions and motion taken from its body, where it has none of its own."""
    body = bodies.get(point.body)
    if not isinstance(body, Continuum):
        raise ValueError(f"reference point {point.name!r}: {point.body!r} is no solid body")
    nodes = np.asarray(point.nodes, np.intp)
    if not nodes.size or nodes.min() < 0 or nodes.max() >= len(body.points):
        raise ValueError(f"reference point {point.name!r}: {point.body!r} has no such nodes")
    here = replace(
        point,
        nodes=nodes,
        points=np.asarray(body.points, float)[nodes] if point.points is None else point.points,
        velocity=body.velocity if point.velocity is None else point.velocity,
        spin=body.spin if point.spin is None else point.spin,
    )
    face_weights(here)
    return here


def face_weights(point: ReferencePoint) -> Array:
    """(3, k) weights of the nodes in r [-], r_y and r_z [1/m]."""
    w, axes = np.asarray(point.weights, float), np.asarray(point.axes, float)
    area = w.sum()
    if not area > 0.0:
        raise ValueError(f"reference point {point.name!r}: its area must be positive")
    mean = w / area
    X = np.asarray(point.points, float)
    plane = (X - mean @ X) @ axes[1:].T
    moments = (plane * mean[:, None]).T @ plane
    sizes = np.linalg.eigvalsh(moments)
    if not sizes[0] > FLAT * sizes[1]:
        raise ValueError(f"reference point {point.name!r}: its nodes lie on a line")
    return np.vstack([mean, np.linalg.solve(moments, (plane * mean[:, None]).T)])
