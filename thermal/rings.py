"""Exchange round the inside of long tubes, each station with itself.

In a tube that is long against its radius and whose temperature changes little over a diameter,
radiation leaves a station for others as much as it comes from them; what remains is plane
exchange between the arcs of a circle, of kernel |sin(dphi/2)|/4 (Sparrow & Cess 1978, 4-3). It
turns the harmonic n of radiosity into irradiation 1/(1 - 4 n^2) times as large.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.boundary import STEFAN_BOLTZMANN, Moment
from thermal.samples import Samples
from thermal.view_factors import arc_factors

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ROUND = 1e-6  # sum of area times normal of a ring, over its area, at which it closes
LEVEL = 1e-6  # distance of stations over the extent of the face at which they are two


class Ring(NamedTuple):
    """Rings of the same numbers of points and temperatures.

    nodes : (c, u) intp  into those of the samples
    values : (c, P, u) float  interpolation at the points
    areas : (c, P) float [m^2]
    factors : (c, P, P) float  view factors between the arcs of the points
    """

    nodes: Indices
    values: Array
    areas: Array
    factors: Array


def rings(found: Samples) -> list[Ring] | None:
    """The rings of a tube's inner face; None if its points do not lie in rings.

    Points at the same height of an element, which depend on the same temperatures, are a ring;
    else those at the same height of a straight tube. Where there is but one point to a station,
    none has anything to exchange.
    """
    every = np.arange(len(found.areas))
    for groups in (_alike(found), [every]):
        members = [ring for group in groups for ring in _level(found, group)]
        if all(_closes(found, points) for points in members):
            return _stacked([_ring(found, points) for points in members])
    return [] if _without_profile(found) else None


def _alike(found: Samples) -> list[Indices]:
    """Points by the temperatures they depend on."""
    at = found.at.sorted_indices()
    spans = zip(at.indptr[:-1], at.indptr[1:], strict=True)
    keys = [at.indices[a:b].tobytes() for a, b in spans]
    return _split(np.unique(keys, return_inverse=True)[1])


def _split(groups: Indices) -> list[Indices]:
    order = np.argsort(groups, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(groups[order])) + 1)


def _level(found: Samples, group: Indices) -> list[Indices]:
    """Points of a group by their height along the direction that all normals are normal to."""
    axis = np.linalg.svd(found.normals[group], full_matrices=True)[2][-1]
    points = found.points[group]
    height = points @ axis
    order = np.argsort(height, kind="stable")
    steps = np.diff(height[order]) > LEVEL * np.ptp(points, axis=0).max()
    return [group[own] for own in np.split(order, np.flatnonzero(steps) + 1)]


def _closes(found: Samples, points: Indices) -> bool:
    """Whether points lie round a circle."""
    areas, normals = found.areas[points], found.normals[points]
    spread = np.linalg.svd(normals, compute_uv=False)
    flat = len(spread) == 3 and spread[2] <= ROUND * spread[0]
    return bool(flat and np.linalg.norm(areas @ normals) <= ROUND * areas.sum())


def _without_profile(found: Samples) -> bool:
    """Whether points are those of a member with one temperature per station."""
    single = found.at.nnz == len(found.areas) == len(found.nodes)
    one_sided = np.linalg.norm(found.areas @ found.normals) > ROUND * found.areas.sum()
    return bool(single and one_sided)


def _ring(found: Samples, points: Indices) -> Ring:
    points = points[_turning(found.normals[points])]
    at, areas = found.at[points], found.areas[points]
    nodes = np.unique(at.indices)
    values = at[:, nodes].toarray()
    return Ring(nodes[None], values[None], areas[None], arc_factors(areas)[None])


def _turning(normals: Array) -> Indices:
    """Order by angle round the axis."""
    first, second = np.linalg.svd(normals, full_matrices=False)[2][:2]
    return np.argsort(np.arctan2(normals @ second, normals @ first))


def _stacked(found: Sequence[Ring]) -> list[Ring]:
    """Rings of the same shape together."""
    groups: dict[tuple[int, ...], list[Ring]] = {}
    for ring in found:
        groups.setdefault(ring.values.shape, []).append(ring)
    return [Ring(*map(np.concatenate, zip(*group, strict=True))) for group in groups.values()]


class Rings:
    """Grey exchange of each ring with itself; nothing comes from outside, so its flow is zero."""

    def __init__(
        self, name: str, emissivity: float, found: Samples, around: Sequence[Ring]
    ) -> None:
        self.names = (name,)
        self._rings = [r._replace(nodes=found.nodes[r.nodes]) for r in around]
        self._mutual = [_mutual(r, emissivity) for r in around]

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        """See Term."""
        for ring, mutual in zip(self._rings, self._mutual, strict=True):
            emissive = STEFAN_BOLTZMANN * _temperatures(ring, T) ** 4
            power = np.einsum("cpq,cq->cp", mutual, emissive) - mutual.sum(2) * emissive
            np.add.at(out, ring.nodes, np.einsum("cp,cpu->cu", power, ring.values))
        return (0.0,)

    def entries(self) -> tuple[Indices, Indices]:
        """All with all of each ring."""
        rows = [np.repeat(r.nodes, r.nodes.shape[1], axis=1).ravel() for r in self._rings]
        columns = [np.tile(r.nodes, (1, r.nodes.shape[1])).ravel() for r in self._rings]
        none = [np.empty(0, np.intp)]
        return np.concatenate(none + rows), np.concatenate(none + columns)

    def slopes(self, T: Array, at: Moment) -> Array:
        """See Term."""
        found = [np.empty(0)]
        for ring, mutual in zip(self._rings, self._mutual, strict=True):
            slope = 4.0 * STEFAN_BOLTZMANN * _temperatures(ring, T) ** 3
            emitted = slope[:, :, None] * ring.values
            lost = mutual.sum(2)[:, :, None] * emitted - mutual @ emitted
            found.append((ring.values.transpose(0, 2, 1) @ lost).ravel())
        return np.concatenate(found)


def _temperatures(ring: Ring, T: Array) -> Array:
    return np.einsum("cpu,cu->cp", ring.values, T[ring.nodes])


def _mutual(ring: Ring, emissivity: float) -> Array:
    """(c, P, P) [m^2]  A eps (I - (1 - eps) F)^-1 F eps, symmetric."""
    identity = np.eye(ring.factors.shape[1])
    if emissivity == 0.0:
        return np.zeros_like(ring.factors)
    absorbed = np.linalg.solve(identity - (1.0 - emissivity) * ring.factors, ring.factors)
    mutual = emissivity**2 * ring.areas[:, :, None] * absorbed
    return 0.5 * (mutual + mutual.transpose(0, 2, 1))
