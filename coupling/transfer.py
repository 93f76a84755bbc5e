"""One matrix maps both ways between the temperatures of the two sides.

P reads section temperatures (mean and two gradients) from nodal temperatures; the transpose of
its mean rows deposits heat. Reading is consistent (constant and linear fields are exact),
depositing is conservative (the columns of the transpose sum to one), by construction.
"""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SAME_STATION = 1e-7
"""Temperatures this near along a member, relative to its length, are of one section [-]."""


class Transfer(NamedTuple):
    """matrix : (3 m, n) csr; rest : (m, 3) float  sections of points that no temperature reaches"""

    matrix: csr_array
    rest: Array

    def read(self, T: Array) -> Array:
        """Section temperatures (m, 3) [K, K/m, K/m] from nodal temperatures (n,) [K]."""
        return self.rest + (self.matrix @ T).reshape(-1, 3)

    def deposit(self, heat: Array) -> Array:
        """Nodal heat (n,) [J] from heat (m,) [J] at the points."""
        return self.matrix[0::3].T @ heat


def transfer(
    x: Array,
    regions: Mapping[str, Indices],
    points: Array,
    axes: Array,
    point_regions: Mapping[str, Indices],
    rest: Array,
    surfaces: Collection[str] = (),
    shares: Mapping[str, Array] | None = None,
    known: Mapping[str, csr_array] | None = None,
) -> Transfer:
    """Build the transfer from temperatures at ``x`` to sections at ``points``.

    Parameters
    ----------
    x : (n, 3) float [m], regions : which of them belong to which body or part
    points : (m, 3) float [m], axes : (m, 3, 3), point_regions : likewise for the sections
    rest : (m,) float [K]  temperature of points whose region has no temperatures
    surfaces : names of shells: at each of their points there are as many temperatures, one after
        the other, somewhere on the normal e3
    shares : region -> (k,) float  area or volume of its temperatures, whose moments the gradients
        keep; a region that is not there: all the same
    known : region -> (m, k)  how its points without sections read its temperatures, where that is
        known already: rows of one sum
    """
    weighed, known = shares or {}, known or {}
    count = 3 * len(points)
    entries: list[tuple[Indices, Indices, Array]] = []
    base = np.zeros((len(points), 3))
    base[:, 0] = rest
    for name, rows in point_regions.items():
        if name in regions and name in known:
            block = known[name].tocoo()
            base[rows, 0] = 0.0
            entries.append((3 * rows[block.row], regions[name][block.col], block.data))
        elif name in regions:
            own, at = regions[name], (points[rows], axes[rows])
            if name in surfaces:
                block = _surface(x[own], *at)
            else:
                block = _region(x[own], weighed.get(name, np.ones(len(own))), *at)
            base[rows, 0] = 0.0
            k, c = np.nonzero(block)
            entries.append((3 * rows[k // 3] + k % 3, regions[name][c], block[k, c]))
    i, j = (np.concatenate([np.zeros(0, np.intp), *(e[k] for e in entries)]) for k in (0, 1))
    v = np.concatenate([np.zeros(0), *(e[2] for e in entries)])
    return Transfer(csr_array((v, (i, j)), shape=(count, len(x))), base)


def _region(x: Array, shares: Array, points: Array, axes: Array) -> Array:
    """(3 m, n) block of one region."""
    if not axes.any():
        block = np.zeros((3 * len(points), len(x)))
        block[0::3] = shares / shares.sum()
        return block
    s, y, z = section_coordinates(x, points, axes)
    stations, profiles = _profiles(s, y, z, shares)
    arclength = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    weights = _interpolation(stations, arclength)
    return np.einsum("ms,skn->mkn", weights, profiles).reshape(3 * len(points), len(x))


def _surface(x: Array, points: Array, axes: Array) -> Array:
    """(3 m, n) block of a shell: mean, nothing, and the gradient along e3, at every point."""
    layers, odd = divmod(len(x), len(points))
    if odd or not layers:
        raise ValueError(f"a shell of {len(points)} nodes cannot have {len(x)} temperatures")
    away = x.reshape(len(points), layers, 3) - points[:, None]
    heights = np.einsum("nkc,nc->nk", away, axes[:, 2])
    block = np.zeros((len(points), 3, len(x)))
    for i, z in enumerate(heights):
        columns = slice(i * layers, (i + 1) * layers)
        block[i, [0, 2], columns] = _line_fit(z)
    return block.reshape(-1, len(x))


def _line_fit(z: Array) -> Array:
    """(2, k) least-squares map from temperatures at heights ``z`` to that at 0 and the gradient."""
    centred = z - z.mean()
    square = float(centred @ centred)
    slope = centred / square if square > 0.0 else np.zeros_like(z)
    return np.stack([1.0 / len(z) - z.mean() * slope, slope])


def section_coordinates(x: Array, points: Array, axes: Array) -> tuple[Array, Array, Array]:
    """Arclength and section coordinates of ``x`` about the line through ``points``.

    What lies in the section plane of the nearest edge's end belongs to that node, also where
    the line bends and the foot on the edge is elsewhere.
    """
    edge, along, lengths = _nearest_edges(x, points)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    for end in (edge, edge + 1):
        across = np.abs(np.einsum("nc,nc->n", x - points[end], axes[end, 0]))
        at_end = np.where(end == edge, 0.0, lengths[edge])
        along = np.where(across <= SAME_STATION * starts[-1], at_end, along)
    fraction = (along / lengths[edge])[:, None]
    offset = x - (1.0 - fraction) * points[edge] - fraction * points[edge + 1]
    node = edge + (fraction[:, 0] > 0.5)
    y = np.einsum("nc,nc->n", offset, axes[node, 1])
    z = np.einsum("nc,nc->n", offset, axes[node, 2])
    return starts[edge] + along, y, z


def _nearest_edges(x: Array, points: Array) -> tuple[Indices, Array, Array]:
    """Edge nearest to each of ``x``, distance of the foot from its start, lengths of the edges."""
    edges = np.diff(points, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    tangents = edges / lengths[:, None]
    along = np.einsum("nec,ec->ne", x[:, None] - points[None, :-1], tangents)
    along = np.clip(along, 0.0, lengths)
    foot = points[None, :-1] + along[..., None] * tangents
    nearest = np.argmin(np.linalg.norm(x[:, None] - foot, axis=2), axis=1)
    return nearest, along[np.arange(len(x)), nearest], lengths


def _profiles(s: Array, y: Array, z: Array, shares: Array) -> tuple[Array, Array]:
    """Stations (k,) and, for each, the least-squares fit of mean and gradients (k, 3, n)."""
    tolerance = SAME_STATION * max(np.ptp(s), 1e-12)
    order = np.argsort(s, kind="stable")
    breaks = np.flatnonzero(np.diff(s[order]) > tolerance) + 1
    groups = np.split(order, breaks)
    stations = np.array([s[g].mean() for g in groups])
    profiles = np.zeros((len(groups), 3, len(s)))
    for k, g in enumerate(groups):
        profiles[k][:, g] = weighted_fit(y[g], z[g], shares[g])
    return stations, profiles


def weighted_fit(y: Array, z: Array, shares: Array) -> Array:
    """(3, k) weighted least-squares map from k temperatures to the mean and the two gradients.

    Corners of quadratic elements have negative shares and are left out.
    """
    size = max(np.abs(y).max(), np.abs(z).max())
    weights = np.maximum(shares, 0.0)
    weights = weights / weights.sum() if weights.any() else np.full(len(y), 1.0 / len(y))
    if len(y) < 3 or size == 0.0:
        fit = np.zeros((3, len(y)))
        fit[0] = weights
        return fit
    root = np.sqrt(weights)
    basis = np.column_stack([np.ones_like(y), y / size, z / size]) * root[:, None]
    fit = np.linalg.pinv(basis, rcond=1e-9) * root
    return fit / np.array([1.0, size, size])[:, None]


def _interpolation(stations: Array, at: Array) -> Array:
    """(m, k) weights of piecewise linear interpolation, constant outside."""
    return np.array([np.interp(at, stations, unit) for unit in np.eye(len(stations))]).T
