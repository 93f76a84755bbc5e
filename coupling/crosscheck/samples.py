"""Material points by which models of different kinds are compared: the same in each of them."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from coupling.descriptions import line_bodies
from coupling.model import Model
from coupling.places import place_of
from coupling.scene import Scene
from coupling.transfer import section_coordinates
from mechanics.description import Beam, Site

Array = NDArray[np.float64]

MOST = 400
"""Material points of a body by which shapes of vibration are compared, about."""
RING = 8
"""Points of the rim of a section whose rotation is wanted."""
PLANE = 1e-6
"""How near to a section a node is in it, per length of the body [-]."""


class Samples(NamedTuple):
    """points : (k, 3) float [m]  in the reference;  matrix : (3 k, n)  places from coordinates"""

    points: Array
    matrix: csr_array

    def places(self, q: Array) -> Array:
        """(k, 3) [m]  where the points are at coordinates (n,)."""
        return (self.matrix @ q).reshape(-1, 3)


def material_points(model: Model) -> dict[str, Array]:
    """(k, 3) [m]  nodes of each solid that stands for a beam, at most about ``MOST``."""
    found = {}
    for name in line_bodies(model.scene):
        points = nodes_of(model, name)
        found[name] = points[:: max(1, len(points) // MOST)]
    return found


def nodes_of(model: Model, name: str) -> Array:
    """(n, 3) [m]  nodes of a flexible body in the reference."""
    return model.layout.q0[model.layout.node_dofs[name][:, None] + np.arange(3)]


def is_beam(model: Model, name: str) -> bool:
    """Whether a body is made of beams, not of a solid."""
    return isinstance(model.layout.bodies[name], Beam)


def samples(model: Model, points: Mapping[str, Array]) -> Samples:
    """The material points of bodies, in the coordinates of a model of beams or of solids."""
    rows = [
        row
        for name, at in points.items()
        for row in (
            _in_beam(model, name, at) if is_beam(model, name) else _in_solid(model, name, at)
        )
    ]
    return Samples(np.concatenate([np.zeros((0, 3)), *points.values()]), _matrix(model, rows))


Row = tuple[NDArray[np.intp], Array]


def _matrix(model: Model, rows: list[Row]) -> csr_array:
    """(3 k, n) of vectors (first coordinates) and their weights for each point."""
    i, j, v = [], [], []
    for k, (vectors, weights) in enumerate(rows):
        for c in range(3):
            i.append(np.full(len(vectors), 3 * k + c))
            j.append(vectors + c)
            v.append(weights)
    parts = [np.concatenate(part) if part else np.zeros(0) for part in (v, i, j)]
    at = parts[1].astype(np.intp), parts[2].astype(np.intp)
    return csr_array((parts[0], at), shape=(3 * len(rows), model.layout.ndof))


def _in_beam(model: Model, name: str, points: Array) -> list[Row]:
    shape = model.scene.shapes[name]
    s, y, z = section_coordinates(points, shape.points, shape.axes)
    rows = []
    for at in zip(s, y, z, strict=True):
        place = place_of(shape, _Along(min(at[0], shape.along[-1]), (0.0, at[1], at[2])))
        side = model.layout.site(
            Site(name, place.node, fraction=place.fraction, offset=place.offset)
        )
        rows.append((side.vectors, side.weights[0]))
    return rows


class _Along(NamedTuple):
    """A site on a line body."""

    at: float
    offset: tuple[float, float, float]
    position: None = None


def _in_solid(model: Model, name: str, points: Array) -> list[Row]:
    """Nodes of the mesh; a point that is no node is the mean of the nearest ones."""
    from scipy.spatial import cKDTree

    nodes, first = nodes_of(model, name), model.layout.node_dofs[name]
    gaps, near = cKDTree(nodes).query(points, k=4)
    gaps = np.maximum(gaps, 1e-12 * np.ptp(nodes, axis=0).max())
    weights = np.where(gaps[:, :1] <= 1e-9, [1.0, 0.0, 0.0, 0.0], 1.0 / gaps)
    weights /= weights.sum(axis=1, keepdims=True)
    return [(first[index], weight) for index, weight in zip(near, weights, strict=True)]


# ------------------------------------------------------------------------------- sections


class Section(NamedTuple):
    """Points of one section and how it stands: ``samples``, ``axis`` (3, 3) rows e1, e2, e3."""

    samples: Samples
    axes: Array

    def rotation(self, q: Array) -> Array:
        """(3,) [rad]  by which the section has turned, in the least-squares sense (Kabsch 1976)."""
        from scipy.spatial.transform import Rotation

        before, after = self._about_centre(q)
        return Rotation.align_vectors(after, before)[0].as_rotvec()

    def flat(self, q: Array) -> tuple[Array, Array]:
        """(k, 2) [m] each: points in the plane of the section at rest, and turned back into it."""
        from scipy.spatial.transform import Rotation

        before, after = self._about_centre(q)
        back = Rotation.align_vectors(before, after)[0].apply(after)
        return before @ self.axes[1:].T, back @ self.axes[1:].T

    def distortion(self, q: Array) -> float:
        """[m]  how far, at most, a point is from where even swelling of the section takes it."""
        before, after = self.flat(q)
        even = float(np.sum(after * before) / np.sum(before * before))
        return float(np.linalg.norm(after - even * before, axis=1).max())

    def _about_centre(self, q: Array) -> tuple[Array, Array]:
        before, after = self.samples.points, self.samples.places(q)
        return before - before.mean(axis=0), after - after.mean(axis=0)


def sections(model: Model) -> dict[str, Section]:
    """The section at each probe on a beam, or on the solid that stands for it."""
    found = {}
    for name, probe in model.scene.probe.items():
        if probe.body in line_bodies(model.scene):
            points, axes = _section_points(model, probe)
            found[name] = Section(samples(model, {probe.body: points}), axes)
    return found


def _section_points(model: Model, probe: Any) -> tuple[Array, Array]:
    """(k, 3) [m] in the section, and its axes: nodes of a solid, a ring on a beam."""
    shape = model.scene.shapes[probe.body]
    node, fraction, _ = place_of(shape, probe)
    nodes = nodes_of(model, probe.body)
    axes = shape.axes[node]
    if is_beam(model, probe.body):
        angle = 2.0 * np.pi * np.arange(RING) / RING
        radius = 1e-3 * shape.along[-1]
        ring = radius * (np.outer(np.cos(angle), axes[1]) + np.outer(np.sin(angle), axes[2]))
        return nodes_on_axis(model.scene, probe.body, node, fraction) + ring, axes
    s, _, _ = section_coordinates(nodes, shape.points, shape.axes)
    ends = shape.along[node], shape.along[min(node + 1, len(shape.along) - 1)]
    at = (1.0 - fraction) * ends[0] + fraction * ends[1]
    stations = np.unique(np.round(s / shape.along[-1], 9)) * shape.along[-1]
    nearest = stations[np.argmin(np.abs(stations - at))]
    return nodes[np.abs(s - nearest) <= PLANE * shape.along[-1]], axes


def nodes_on_axis(scene: Scene, body: str, node: int, fraction: float) -> Array:
    """(3,) [m]  a point of the axis of a line body."""
    points = scene.shapes[body].points
    return (1.0 - fraction) * points[node] + fraction * points[min(node + 1, len(points) - 1)]
