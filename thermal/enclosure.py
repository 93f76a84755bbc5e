"""Grey diffuse exchange between faces that see one another (Siegel & Howell 2002, ch. 6-7).

Of surfaces of uniform radiosity J and irradiation H, emissive power e = sigma T^4 (its mean over
the surface) and emissivity eps, H = F J + f s and J = eps e + (1 - eps) H, where f is what the
rows of F lack to one and s the emissive power of the sink. So a surface absorbs R e + S s with

    R = A eps (I - F (1 - eps))^-1 F eps,   S = A eps (I - F (1 - eps))^-1 f,

R symmetric, and emits the sum of its rows of R and S times e: what surfaces give one another
sums to zero. Within a surface each point emits by its own temperature, and all absorb alike.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from thermal.boundary import STEFAN_BOLTZMANN, Moment, Term
from thermal.description import Enclosure, History
from thermal.discretisation import Face
from thermal.rings import Rings, rings
from thermal.samples import Products, Samples, averaging, grouped, samples
from thermal.view_factors import adjusted, exchange_areas, polygon_areas

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

RECIPROCITY = 1e-3  # allowed defect of A_i F_ij = A_j F_ji, over the smaller area
ROUNDING = 1e-6  # by which a row of given view factors may exceed one
CLOSED = 5e-3  # an enclosure whose computed rows lack no more than this has no openings
COUPLED = 1000  # temperatures up to which the tangent knows who exchanges with whom


def enclosure(condition: Enclosure, faces: Sequence[Face]) -> Term:
    """Exchange between faces, by their view factors, those of their facets, or round a tube.

    Computed view factors whose rows lack at most ``CLOSED`` of one are taken as those of a closed
    enclosure, and adjusted to be so.

    Raises ValueError when the condition makes no sense, or a face has no facets to see with.
    """
    found = samples(faces)
    areas = grouped(found.areas, found.faces, len(faces))
    wrong = problems(condition, areas)
    if wrong:
        raise ValueError("\n".join(wrong))
    if condition.view_factors is not None:
        exchange = _symmetric(areas[:, None] * np.asarray(condition.view_factors, float))
        return _cavity(condition, found, found.faces, exchange)
    if len(faces) == 1 and condition.sides[0].face == "inner":
        around = rings(found)
        if around is not None:
            return Rings(condition.name, condition.emissivities[0], found, around)
    polygons = _polygons(condition, faces)
    return _cavity(condition, found, found.facets, _exchange_of_facets(found, polygons))


def problems(condition: Enclosure, areas: Sequence[float] | Array) -> list[str]:
    """What makes an enclosure of faces of these areas [m^2] senseless, a sentence each."""
    owner, n = f"enclosure '{condition.name}'", len(condition.sides)
    found = [] if n else [f"{owner}: it needs one face or more"]
    if len(set(condition.sides)) != n:
        found.append(f"{owner}: a face is named twice")
    if len(condition.emissivities) != n:
        count = len(condition.emissivities)
        found.append(f"{owner}: needs one emissivity for each of {n} faces, got {count}")
    found += [
        f"{owner}: emissivity must be 0 to 1, got {emissivity}"
        for emissivity in condition.emissivities
        if not 0.0 <= emissivity <= 1.0
    ]
    found += [
        f"{owner}: face '{side.face}' of '{side.thing}' has no area"
        for side, area in zip(condition.sides, areas, strict=False)
        if not area > 0.0
    ]
    if condition.view_factors is None:
        return found
    return found + _factor_problems(owner, np.asarray(condition.view_factors), np.asarray(areas))


def _factor_problems(owner: str, factors: Array, areas: Array) -> list[str]:
    n = len(areas)
    if factors.shape != (n, n):
        return [f"{owner}: view factors must have the shape {(n, n)}, got {factors.shape}"]
    if not (np.isfinite(factors).all() and factors.min(initial=0.0) >= 0.0):
        return [f"{owner}: view factors must be positive or zero"]
    found = [
        f"{owner}: row {i + 1} of the view factors sums to {total:g}, more than 1"
        for i, total in enumerate(factors.sum(1))
        if total > 1.0 + ROUNDING
    ]
    exchange = areas[:, None] * factors
    allowed = RECIPROCITY * np.minimum(areas[:, None], areas[None, :])
    for i, j in np.argwhere(np.triu(np.abs(exchange - exchange.T) > allowed)):
        found.append(
            f"{owner}: area times view factor must be the same both ways: {exchange[i, j]:g} m^2 "
            f"from face {i + 1} to {j + 1}, {exchange[j, i]:g} m^2 back"
        )
    return found


def _symmetric(exchange: Array) -> Array:
    return 0.5 * (exchange + exchange.T)


def _polygons(condition: Enclosure, faces: Sequence[Face]) -> list[Array]:
    for side, face in zip(condition.sides, faces, strict=True):
        if any(block.polygons.shape[1] < 3 for block in face):
            raise ValueError(
                f"enclosure '{condition.name}': this solver knows no facets of face "
                f"'{side.face}' of '{side.thing}'; give view factors"
            )
    return [polygon for face in faces for block in face for polygon in block.polygons]


def _exchange_of_facets(found: Samples, polygons: Sequence[Array]) -> Array:
    """Exchange areas of facets that stand for the areas of their points, such as of arcs."""
    areas = grouped(found.areas, found.facets, len(polygons))
    flat = polygon_areas(polygons)
    ratio = np.sqrt(areas / flat)
    geometric = exchange_areas(polygons)
    sums = geometric.sum(1) / flat
    closed = sums.min() >= 1.0 - CLOSED
    target = areas * (1.0 if closed else np.minimum(1.0, sums))
    return adjusted(geometric * ratio[:, None] * ratio[None, :], target)


class Transfer(NamedTuple):
    """What surfaces absorb of one another and of the sink, and emit.

    mutual : (m, m) float [m^2]  R, symmetric
    sink : (m,) float [m^2]  S
    emitting : (m,) float [m^2]  sums of their rows
    """

    mutual: Array
    sink: Array
    emitting: Array


def transfer(exchange: Array, areas: Array, emissivities: Array) -> Transfer:
    """R and S of surfaces, from exchange areas (m, m) [m^2], areas (m,) and emissivities (m,)."""
    openings = areas - exchange.sum(1)
    openings[openings < ROUNDING * areas] = 0.0
    areas = exchange.sum(1) + openings
    reflecting = np.where(_all_white(exchange, openings, emissivities), 0.0, 1.0 - emissivities)
    system = np.diag(areas) - exchange * reflecting
    sent = np.column_stack([exchange * emissivities, openings])
    absorbed = (areas * emissivities)[:, None] * np.linalg.solve(system, sent)
    mutual, sink = _symmetric(absorbed[:, :-1]), absorbed[:, -1]
    return Transfer(mutual, sink, mutual.sum(1) + sink)


def _all_white(exchange: Array, openings: Array, emissivities: Array) -> NDArray[np.bool_]:
    """Surfaces that see only such as absorb nothing, whose radiosity nothing decides."""
    count, part = connected_components(csr_array(exchange))
    absorbing = np.bincount(part, (emissivities > 0.0) | (openings > 0.0), count) > 0.0
    return ~absorbing[part]


def _cavity(condition: Enclosure, found: Samples, surfaces: Indices, exchange: Array) -> "Cavity":
    areas = grouped(found.areas, surfaces, len(exchange))
    emissivities = np.zeros(len(exchange))
    emissivities[surfaces] = np.asarray(condition.emissivities, float)[found.faces]
    exchanged = transfer(exchange, areas, emissivities)
    return Cavity(condition.name, found, surfaces, exchanged, condition.sink)


class Cavity:
    """Exchange between surfaces, each a group of points.

    The tangent knows how the emission of each point follows its temperature. Who absorbs it is
    known, too, up to ``COUPLED`` temperatures; as each depends on every other, more would fill
    the matrix. Without it Newton's method contracts by the share that exchange has in the heat
    balance over a step, and still ends at the same temperatures.
    """

    def __init__(
        self,
        name: str,
        found: Samples,
        surfaces: Indices,
        exchanged: Transfer,
        sink: History | None,
    ) -> None:
        self.names = (name,)
        self._nodes, self._at, self._exchanged = found.nodes, found.at, exchanged
        self._sink = sink or (lambda t: 0.0)
        self._mean = averaging(found.areas, surfaces, len(exchanged.sink))
        totals = grouped(found.areas, surfaces, len(exchanged.sink))
        self._emitting = (exchanged.emitting / totals)[surfaces] * found.areas
        self._back = csr_array(found.at.T)
        self._shares = csr_array((self._mean @ found.at).T)
        self._own = Products(found.at, found.at)
        self._own_factors = self._own.factors(found.at, found.at)
        self.coupled = len(found.nodes) <= COUPLED
        if self.coupled:
            self._absorbing = self._shares @ exchanged.mutual

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        """See Term; what comes from the sink is the flow."""
        local = STEFAN_BOLTZMANN * (self._at @ T[self._nodes]) ** 4
        emissive = self._mean @ local
        space = STEFAN_BOLTZMANN * self._sink(at.t) ** 4
        absorbed = self._exchanged.mutual @ emissive + self._exchanged.sink * space
        out[self._nodes] += self._shares @ absorbed - self._back @ (self._emitting * local)
        return (float(self._exchanged.sink @ (space - emissive)),)

    def entries(self) -> tuple[Indices, Indices]:
        """Own emission, point by point, and then all with all."""
        rows, columns = self._nodes[self._own.rows], self._nodes[self._own.columns]
        if not self.coupled:
            return rows, columns
        n = len(self._nodes)
        return (
            np.concatenate([rows, np.repeat(self._nodes, n)]),
            np.concatenate([columns, np.tile(self._nodes, n)]),
        )

    def slopes(self, T: Array, at: Moment) -> Array:
        """See Term."""
        slope = 4.0 * STEFAN_BOLTZMANN * (self._at @ T[self._nodes]) ** 3
        own = (self._emitting * slope)[self._own.points] * self._own_factors
        if not self.coupled:
            return own
        emitted = self._mean @ diags_array(slope) @ self._at
        return np.concatenate([own, -(self._absorbing @ emitted).ravel()])
