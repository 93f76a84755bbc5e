"""Where points of faces are in a pose: carried by line bodies, shells and rigid bodies.

A point keeps its coordinates in the frame of the section, element or body that carries it, so
that the reference pose and rigid motions are exact.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Beam, RigidBody, Shell
from mechanics.layout import Layout, family_of
from meshes.generate import frames as carried_frames

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CANDIDATES = 12  # elements of a shell that are tried for a point
ROUNDS = 8  # of Newton's method for the foot of a point


class Frames(Protocol):
    """Origins (m, 3) [m] and axes (m, 3, 3), rows e1, e2, e3, that carry points in a pose."""

    def __call__(self, q: Array) -> tuple[Array, Array]: ...


class Carried:
    """Points and directions fixed in frames that move.

    points, normals : (m, 3) float [m], [-]  in the reference pose ``q``
    """

    def __init__(self, frames: Frames, q: Array, points: Array, normals: Array) -> None:
        origins, axes = frames(q)
        self._frames = frames
        self._points = np.einsum("mij,mj->mi", axes, points - origins)
        self._normals = np.einsum("mij,mj->mi", axes, normals)

    def at(self, q: Array) -> tuple[Array, Array]:
        """Points and normals (m, 3) in a pose."""
        origins, axes = self._frames(q)
        turned = np.einsum("mi,mij->mj", self._normals, axes)
        return origins + np.einsum("mi,mij->mj", self._points, axes), turned


def still(count: int) -> Frames:
    """Frames that do not move."""
    fixed = np.zeros((count, 3)), np.broadcast_to(np.eye(3), (count, 3, 3))
    return lambda q: fixed


def vectors(layout: Layout, name: str, q: Array) -> Mapping[str, Array]:
    """Vectors (n, 3) of the nodes of a body by name, position first."""
    first, kind = layout.node_dofs[name], layout.kinds[name]
    nodes = q[first[:, None] + np.arange(kind)].reshape(len(first), -1, 3)
    return dict(zip(family_of(layout.bodies[name]).vectors, np.moveaxis(nodes, 1, 0), strict=True))


def carrier(layout: Layout, name: str, points: Array) -> Frames:
    """What carries reference points (m, 3) [m] of a mechanical body."""
    body = layout.bodies[name]
    if isinstance(body, Beam):
        return LineFrames(layout, name, points)
    if isinstance(body, Shell):
        return ShellFrames(layout, name, points)
    return BodyFrames(layout, name, len(points))


class BodyFrames(NamedTuple):
    """The one frame of a rigid body, or of a particle, which does not turn."""

    layout: Layout
    name: str
    points: int

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """See Frames."""
        now = vectors(self.layout, self.name, q)
        is_rigid = isinstance(self.layout.bodies[self.name], RigidBody)
        axes = np.concatenate([now[f"e{i}"] for i in (1, 2, 3)]) if is_rigid else np.eye(3)
        shape = (self.points, 3)
        return np.broadcast_to(now["position"], shape), np.broadcast_to(axes, (*shape, 3))


# ---------------------------------------------------------------------------------------- lines


class Curve(NamedTuple):
    """The axis of a line body: cubics through its nodes, and triads between those of the nodes.

    The derivative at the ends of an element has the length chord / cos(angle / 4)^2 with the
    angle between its tangents (Goldapp 1991).

    position : (n, 3) float [m];  axes : (n, 3, 3) float  rows e1, e2, e3;  scale : (n - 1,) [m]
    """

    position: Array
    axes: Array
    scale: Array

    @classmethod
    def of(cls, layout: Layout, name: str, q: Array) -> "Curve":
        """The axis of a line body in a pose."""
        now = vectors(layout, name, q)
        if "r_z" not in now:
            return cls.through(now["position"], carried_frames(now["position"]))
        e2 = _unit(now["r_y"])
        e1 = _unit(np.cross(e2, now["r_z"]))
        return cls.through(now["position"], np.stack([e1, e2, np.cross(e1, e2)], axis=1))

    @classmethod
    def through(cls, position: Array, axes: Array) -> "Curve":
        """The axis through nodes with triads."""
        chord = np.linalg.norm(np.diff(position, axis=0), axis=1)
        cosine = np.clip(np.sum(axes[1:, 0] * axes[:-1, 0], axis=1), -1.0, 1.0)
        return cls(position, axes, chord / np.cos(0.25 * np.arccos(cosine)) ** 2)

    def at(self, element: Indices, x: Array) -> tuple[Array, Array]:
        """Points (m, 3) [m] and triads (m, 3, 3) at local coordinates 0 to 1 of elements."""
        x, length = x[:, None], self.scale[element, None]
        points = (
            (1.0 - 3.0 * x**2 + 2.0 * x**3) * self.position[element]
            + (x - 2.0 * x**2 + x**3) * length * self.axes[element, 0]
            + (3.0 * x**2 - 2.0 * x**3) * self.position[element + 1]
            + (x**3 - x**2) * length * self.axes[element + 1, 0]
        )
        x = x[..., None]
        mixed = (1.0 - x) * self.axes[element] + x * self.axes[element + 1]
        e1, e2 = _unit(np.cross(mixed[:, 1], mixed[:, 2])), _unit(mixed[:, 1])
        return points, np.stack([e1, e2, np.cross(e1, e2)], axis=1)

    def feet(self, points: Array) -> tuple[Indices, Array]:
        """Element and local coordinate of the section in which each of the points lies."""
        element, x = _nearest_edges(points, self.position)
        for _ in range(ROUNDS):
            at, axes = self.at(element, x)
            step = np.einsum("mc,mc->m", points - at, axes[:, 0]) / self.scale[element]
            x = np.clip(x + step, 0.0, 1.0)
        return element, x

    def lengths(self, element: Indices, x: Array) -> Array:
        """Arc length (m,) [m] from the first node, by chords."""
        chord = np.linalg.norm(np.diff(self.position, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(chord)])[element] + x * chord[element]


class LineFrames:
    """Sections of a line body.

    along : (m,) float [m]  their arc lengths in the reference
    """

    def __init__(self, layout: Layout, name: str, points: Array) -> None:
        self._layout, self._name = layout, name
        curve = Curve.of(layout, name, layout.q0)
        self._element, self._x = curve.feet(points)
        self.along = curve.lengths(self._element, self._x)

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """See Frames."""
        return Curve.of(self._layout, self._name, q).at(self._element, self._x)


def _nearest_edges(x: Array, points: Array) -> tuple[Indices, Array]:
    """Edge of a polygon nearest to each of ``x``, and how far along it the foot is: 0 to 1."""
    best = np.full(len(x), np.inf)
    edge, along = np.zeros(len(x), np.intp), np.zeros(len(x))
    for e, (a, b) in enumerate(pairwise(points)):
        s = np.clip((x - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        away = np.linalg.norm(x - a - s[:, None] * (b - a), axis=1)
        nearer = away < best
        best[nearer], edge[nearer], along[nearer] = away[nearer], e, s[nearer]
    return edge, along


# --------------------------------------------------------------------------------------- shells


class ShellFrames:
    """Points of the elements of a shell, as bilinear surfaces through their corners."""

    def __init__(self, layout: Layout, name: str, points: Array) -> None:
        from scipy.spatial import cKDTree

        body = layout.bodies[name]
        assert isinstance(body, Shell)
        self._layout, self._name, quads = layout, name, body.surface.quads
        corners = np.asarray(body.surface.points, float)[quads]
        k = min(CANDIDATES, len(quads))
        _, near = cKDTree(corners.mean(axis=1)).query(points, k)
        near = near.reshape(len(points), k)
        x, away = _inverse(corners[near], points[:, None])
        best = np.arange(len(points)), np.argmin(away, axis=1)
        self._corners, self._x = quads[near[best]], x[best]

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """See Frames."""
        position = vectors(self._layout, self._name, q)["position"]
        at, by_u, by_v = _bilinear(position[self._corners], self._x)
        e1, e3 = _unit(by_u), _unit(np.cross(by_u, by_v))
        return at, np.stack([e1, np.cross(e3, e1), e3], axis=1)


def _bilinear(corners: Array, x: Array) -> tuple[Array, Array, Array]:
    """Points and both derivatives (..., 3) at ``x`` (..., 2) of quads (..., 4, 3)."""
    u, v = x[..., :1], x[..., 1:]
    a, b, c, d = np.moveaxis(corners, -2, 0)
    at = (1.0 - u) * (1.0 - v) * a + u * (1.0 - v) * b + u * v * c + (1.0 - u) * v * d
    return at, (1.0 - v) * (b - a) + v * (c - d), (1.0 - u) * (d - a) + u * (c - b)


def _inverse(corners: Array, points: Array) -> tuple[Array, Array]:
    """Local coordinates (m, k, 2) of the feet of points on quads, within these; distances [m]."""
    x = np.full((*corners.shape[:2], 2), 0.5)
    for _ in range(ROUNDS):
        at, by_u, by_v = _bilinear(corners, x)
        J = np.stack([by_u, by_v], axis=-1)
        square = np.einsum("mkci,mkcj->mkij", J, J)
        slope = np.einsum("mkci,mkc->mki", J, points - at)
        step = np.linalg.solve(square, slope[..., None])[..., 0]
        x = np.clip(x + step, 0.0, 1.0)
    return x, np.linalg.norm(points - _bilinear(corners, x)[0], axis=-1)


def _unit(a: Array) -> Array:
    return a / np.linalg.norm(a, axis=-1, keepdims=True)
