"""Where points of faces are in a pose: carried by line bodies, shells and rigid bodies.

A point keeps its coordinates in the frame of the section, element or body that carries it, so
that the reference pose and rigid motions are exact.
"""

from collections.abc import Mapping, Sequence
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
ALIKE = 10  # decimals of local coordinates that make one section
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
        return LineFrames.of(layout, name, points)
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
    """Axes of line bodies: cubics between nodes, and triads between those of the nodes.

    The derivative at the ends of an element has the length chord / cos(angle / 4)^2 with the
    angle between its tangents (Goldapp 1991).

    position : (n, 3) float [m];  axes : (n, 3, 3) float  rows e1, e2, e3 at the nodes
    ends : (e, 2) int  nodes of each element;  scale : (e,) float [m]  length of the derivative
    """

    position: Array
    axes: Array
    ends: Indices
    scale: Array

    @classmethod
    def through(cls, position: Array, axes: Array, ends: Indices | None = None) -> "Curve":
        """Axes through nodes with triads; without ``ends`` one body, from node to node."""
        if ends is None:
            ends = _chain(len(position))
        a, b = ends.T
        chord = np.linalg.norm(position[b] - position[a], axis=1)
        cosine = np.clip(np.sum(axes[b, 0] * axes[a, 0], axis=1), -1.0, 1.0)
        return cls(position, axes, ends, chord / np.cos(0.25 * np.arccos(cosine)) ** 2)

    def at(self, element: Indices, x: Array) -> tuple[Array, Array]:
        """Points (m, 3) [m] and triads (m, 3, 3) at local coordinates 0 to 1 of elements."""
        a, b = self.ends[element].T
        x = x[:, None, None]
        mixed = (1.0 - x) * self.axes[a, 1:] + x * self.axes[b, 1:]
        e1, e2 = _unit(np.cross(mixed[:, 0], mixed[:, 1])), _unit(mixed[:, 0])
        return self.points(element, x[:, 0, 0]), np.stack([e1, e2, np.cross(e1, e2)], axis=1)

    def points(self, element: Indices, x: Array) -> Array:
        """(m, 3) [m] at local coordinates 0 to 1 of elements."""
        a, b = self.ends[element].T
        x, length = x[:, None], self.scale[element, None]
        return (
            (1.0 - 3.0 * x**2 + 2.0 * x**3) * self.position[a]
            + (x - 2.0 * x**2 + x**3) * length * self.axes[a, 0]
            + (3.0 * x**2 - 2.0 * x**3) * self.position[b]
            + (x**3 - x**2) * length * self.axes[b, 0]
        )

    def feet(self, points: Array) -> tuple[Indices, Array]:
        """Element and local coordinate of the section in which each of the points lies."""
        element, x = _nearest_edges(points, self.position[self.ends])
        for _ in range(ROUNDS):
            at, axes = self.at(element, x)
            step = np.einsum("mc,mc->m", points - at, axes[:, 0]) / self.scale[element]
            x = np.clip(x + step, 0.0, 1.0)
        return element, x

    def lengths(self, element: Indices, x: Array) -> Array:
        """Arc length (m,) [m] by chords from the first node, if this is one body."""
        a, b = self.position[self.ends.T]
        chord = np.linalg.norm(b - a, axis=1)
        return np.concatenate([[0.0], np.cumsum(chord)])[element] + x * chord[element]


def _chain(nodes: int) -> Indices:
    return np.stack([np.arange(nodes - 1), np.arange(1, nodes)], axis=1)


class Lines:
    """Some line bodies as one curve in a pose.

    first : (b,) int  first element of each
    """

    def __init__(self, layout: Layout, names: Sequence[str]) -> None:
        self.layout, self.names = layout, tuple(names)
        nodes = [layout.node_dofs[name] for name in names]
        starts = np.cumsum([0, *map(len, nodes)]).tolist()
        self._ends = np.concatenate(
            [np.empty((0, 2), np.intp), *(a + _chain(b - a) for a, b in pairwise(starts))]
        )
        self.first = np.array(starts[:-1], np.intp) - np.arange(len(nodes))
        self._position = np.concatenate([np.empty(0, np.intp), *nodes])
        has = [family_of(layout.bodies[name]).vectors for name in names]
        own = [slice(a, b) for a, b in pairwise(starts)]
        self._bare = [o for o, v in zip(own, has, strict=True) if "r_z" not in v]
        self._sectioned = np.setdiff1d(
            np.arange(starts[-1]), [i for o in self._bare for i in range(o.start, o.stop)]
        )
        self._section = [
            np.concatenate(
                [np.empty(0, np.intp)]
                + [n + 3 * v.index(r) for n, v in zip(nodes, has, strict=True) if r in v]
            )
            for r in ("r_y", "r_z")
        ]

    def __call__(self, q: Array) -> Curve:
        """The axes of the bodies, one after the other."""
        position, r_y, r_z = (
            q[d[:, None] + np.arange(3)] for d in (self._position, *self._section)
        )
        axes, e2 = np.empty((len(position), 3, 3)), _unit(r_y)
        e1 = _unit(np.cross(e2, r_z))
        axes[self._sectioned] = np.stack([e1, e2, np.cross(e1, e2)], axis=1)
        for own in self._bare:
            axes[own] = carried_frames(position[own])
        return Curve.through(position, axes, self._ends)


class LineFrames:
    """Sections of line bodies; points in the same section share its frame.

    along : (m,) float [m]  their arc lengths in the reference, each from the start of its body
    """

    def __init__(self, lines: Lines, element: Indices, x: Array, along: Array) -> None:
        self.lines, self.element, self.x, self.along = lines, element, x, along
        both = np.stack([element, np.round(x, ALIKE)])
        _, self._first, self._section = np.unique(
            both, axis=1, return_index=True, return_inverse=True
        )

    @classmethod
    def of(cls, layout: Layout, name: str, points: Array) -> "LineFrames":
        """The sections in which reference points of one body lie."""
        lines = Lines(layout, [name])
        curve = lines(layout.q0)
        element, x = curve.feet(points)
        return cls(lines, element, x, curve.lengths(element, x))

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """See Frames."""
        origins, axes = self.lines(q).at(self.element[self._first], self.x[self._first])
        return origins[self._section], axes[self._section]


def together(frames: Sequence[LineFrames]) -> LineFrames:
    """Sections of several bodies, one after the other, as one."""
    layout = frames[0].lines.layout
    names = list(dict.fromkeys(name for f in frames for name in f.lines.names))
    lines = Lines(layout, names)
    first = dict(zip(names, lines.first.tolist(), strict=True))
    return LineFrames(
        lines,
        np.concatenate([first[f.lines.names[0]] + f.element for f in frames]),
        np.concatenate([f.x for f in frames]),
        np.concatenate([f.along for f in frames]),
    )


def _nearest_edges(x: Array, edges: Array) -> tuple[Indices, Array]:
    """Which of the edges (e, 2, 3) is nearest to each of ``x``, and where the foot is: 0 to 1."""
    best = np.full(len(x), np.inf)
    edge, along = np.zeros(len(x), np.intp), np.zeros(len(x))
    for e, (a, b) in enumerate(edges):
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
