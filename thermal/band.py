"""LU factors within an envelope, for matrices whose unknowns can be ordered along a line.

Rows are stored from their first entry to the last column that elimination reaches. A few unknowns
that many others depend on (a hub, a mean) may stand apart as a border: the last rows and columns,
kept dense. There are no pivots: the matrices of heat have a positive definite symmetric part or
dominant columns, of which elimination in any order is stable (Golub & Van Loan 2013, secs. 4.1,
4.3); ``eliminate`` tells when a pivot has all but vanished all the same.
"""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

BORDER = 64  # unknowns that may stand apart
U = np.uint64  # indices known not to be negative: their checks would keep loops from vectors
VANISHED = 1e-13  # of the diagonal entry: a pivot below it is round-off


class Envelope(NamedTuple):
    """Where rows of the band begin and end.

    first, reach : (n,) intp  first and last column of each row, fill included
    offsets : (n + 1,) intp  where the rows begin in the storage
    work : float  multiplications of an elimination, of the band alone
    """

    first: Indices
    reach: Indices
    offsets: Indices
    work: float


def envelope(n: int, rows: Indices, columns: Indices) -> Envelope:
    """Envelope of a symmetric pattern with entries at ``rows`` and ``columns``."""
    first, reach = np.arange(n), np.arange(n)
    np.minimum.at(first, rows, columns)
    np.maximum.at(reach, rows, columns)
    work = fill(first, reach)
    return Envelope(first, reach, np.concatenate([[0], np.cumsum(reach - first + 1)]), work)


@njit(cache=True, error_model="numpy")
def fill(first, reach):
    """Extend the rows by their fill; the multiplications that elimination takes."""
    work = 0.0
    for i in range(first.size):
        for k in range(first[i], i):
            reach[i] = max(reach[i], reach[k])
            work += reach[k] - k
    return work


@njit(cache=True, error_model="numpy")
def summed(slots, values, size):
    """(size,) sums of the values with the same slot; slots from ``size`` on are dropped."""
    out = np.zeros(size + 1)
    for i in range(slots.size):
        out[slots[i]] += values[i]
    return out[:size]


@njit(cache=True, error_model="numpy")
def eliminate(first, reach, offsets, a, inverse, right, below, corner):
    """Factors in place, and one over each pivot; False where a pivot vanished.

    a : (offsets[-1],) the band; right : (n, b) last columns; below : (b, n) last rows;
    corner : (b, b), of which the Schur complement is left
    """
    n, b = right.shape
    sound = True
    for i in range(n):
        size = abs(a[offsets[i] + i - first[i]])
        reduce_row(i, first, reach, offsets, a, inverse, right)
        pivot = a[offsets[i] + i - first[i]]
        inverse[i] = 1.0 / pivot
        sound = sound and abs(pivot) > VANISHED * size
    for r in range(b):
        for k in range(n):
            factor = below[r, k]
            if factor != 0.0:
                above = offsets[k] - first[k]
                factor *= inverse[k]
                below[r, k] = factor
                for j in range(k + 1, reach[k] + 1):
                    below[r, j] -= factor * a[U(above + j)]
                for j in range(b):
                    corner[r, j] -= factor * right[k, j]
    return sound


@njit(cache=True, error_model="numpy")
def reduce_row(i, first, reach, offsets, a, inverse, right):
    """Take from row i the multiples of the rows above, four at a time to spare memory traffic."""
    row = offsets[i] - first[i]
    k = first[i]
    while k < i:
        end = reach[k]
        k0 = offsets[k] - first[k]
        f0 = a[row + k] * inverse[k]
        a[row + k] = f0
        if k + 3 < i and reach[k + 3] == end:
            k1 = offsets[k + 1] - first[k + 1]
            k2 = offsets[k + 2] - first[k + 2]
            k3 = offsets[k + 3] - first[k + 3]
            f1 = (a[row + k + 1] - f0 * a[k0 + k + 1]) * inverse[k + 1]
            f2 = (a[row + k + 2] - f0 * a[k0 + k + 2] - f1 * a[k1 + k + 2]) * inverse[k + 2]
            f3 = a[row + k + 3] - f0 * a[k0 + k + 3] - f1 * a[k1 + k + 3] - f2 * a[k2 + k + 3]
            f3 *= inverse[k + 3]
            a[row + k + 1], a[row + k + 2], a[row + k + 3] = f1, f2, f3
            for j in range(k + 4, end + 1):
                near = f0 * a[U(k0 + j)] + f1 * a[U(k1 + j)]
                a[U(row + j)] -= near + f2 * a[U(k2 + j)] + f3 * a[U(k3 + j)]
            for j in range(right.shape[1]):
                right[i, j] -= f0 * right[k, j] + f1 * right[k + 1, j]
                right[i, j] -= f2 * right[k + 2, j] + f3 * right[k + 3, j]
            k += 4
        else:
            for j in range(k + 1, end + 1):
                a[U(row + j)] -= f0 * a[U(k0 + j)]
            for j in range(right.shape[1]):
                right[i, j] -= f0 * right[k, j]
            k += 1


@njit(cache=True, error_model="numpy")
def forward(first, offsets, a, below, x):
    """L y = x in place, of the band and of the border; x : (n + b,)"""
    n = first.size
    for i in range(n):
        row = offsets[i] - first[i]
        rest = x[i]
        for k in range(first[i], i):
            rest -= a[row + k] * x[k]
        x[i] = rest
    for r in range(below.shape[0]):
        rest = x[n + r]
        for k in range(n):
            rest -= below[r, k] * x[k]
        x[n + r] = rest


@njit(cache=True, error_model="numpy")
def backward(first, reach, offsets, a, inverse, right, x):
    """U x = y in place, of the band; the border of ``x`` (n + b,) is solved for."""
    n, b = right.shape
    for i in range(n - 1, -1, -1):
        row = offsets[i] - first[i]
        rest = x[i]
        for j in range(i + 1, reach[i] + 1):
            rest -= a[row + j] * x[j]
        for j in range(b):
            rest -= right[i, j] * x[n + j]
        x[i] = rest * inverse[i]


class Ordering(NamedTuple):
    """Unknowns of the band in order, those of the border, and the envelope of the band."""

    band: Indices
    border: Indices
    envelope: Envelope

    @property
    def work(self) -> float:
        """Multiplications of an elimination, about."""
        b = len(self.border)
        return self.envelope.work + b * (self.envelope.offsets[-1] + b * len(self.band))


def ordering(n: int, rows: Indices, columns: Indices, limit: float) -> Ordering | None:
    """The cheapest of a few orderings of a symmetric pattern; None: all take over ``limit``.

    As it is, and reversed Cuthill-McKee (George & Liu 1981, ch. 4); each with nothing apart, and
    with the unknowns apart that far more depend on than usual.
    """
    found = []
    degrees = np.bincount(rows, minlength=n)
    usual = np.median(degrees)
    borders = {tuple(np.flatnonzero(degrees > usual * times)) for times in (inf, 4.0, 2.0, 1.3)}
    for border in sorted(borders, key=len):
        if len(border) <= BORDER:
            apart = np.array(border, dtype=np.intp)
            found += _without(n, rows, columns, apart, limit)
    return min(found, key=lambda o: o.work, default=None)


def _without(
    n: int, rows: Indices, columns: Indices, border: Indices, limit: float
) -> list[Ordering]:
    rest = np.setdiff1d(np.arange(n), border)
    place = np.full(n, -1)
    place[rest] = np.arange(len(rest))
    inside = (place[rows] >= 0) & (place[columns] >= 0)
    i, j = place[rows[inside]], place[columns[inside]]
    graph = csr_array((np.ones(len(i), np.int8), (i, j)), shape=(len(rest),) * 2)
    found = []
    for order in (np.arange(len(rest)), reverse_cuthill_mckee(graph, symmetric_mode=True)):
        rank = np.empty(len(rest), np.intp)
        rank[order] = np.arange(len(rest))
        if _least_work(rank[i], rank[j]) <= limit:
            candidate = Ordering(rest[order], border, envelope(len(rest), rank[i], rank[j]))
            if candidate.work <= limit:
                found.append(candidate)
    return found


def _least_work(rows: Indices, columns: Indices) -> float:
    """A bound from below, quick to find."""
    first = np.arange(rows.max(initial=-1) + 1)
    np.minimum.at(first, rows, columns)
    return 0.5 * float(((np.arange(len(first)) - first).astype(float) ** 2).sum())


class Banded:
    """Solver of systems in an ordering; entries (k,) of the matrix at ``rows``, ``columns``."""

    def __init__(self, order: Ordering, rows: Indices, columns: Indices) -> None:
        self._order, n, b = order, len(order.band), len(order.border)
        self._permutation = np.concatenate([order.band, order.border])
        rank = np.empty(n + b, np.intp)
        rank[self._permutation] = np.arange(n + b)
        i, j = rank[rows], rank[columns]
        first, _, offsets, _ = order.envelope
        self._ends = np.cumsum([offsets[-1], n * b, b * n, b * b])
        start = (offsets[:-1] - first)[np.minimum(i, n - 1)]
        right, below, corner = self._ends[0] + i * b, self._ends[1] + (i - n) * n, self._ends[2]
        in_border = np.where(j < n, below + j, corner + (i - n) * b + j - n)
        self.slots = np.where(i < n, np.where(j < n, start + j, right + j - n), in_border)
        self.size = int(self._ends[-1])

    def factorise(self, store: Array) -> Callable[[Array], Array] | None:
        """Solver from the sums of the entries in their ``slots``; None where a pivot vanished."""
        first, reach, offsets, _ = self._order.envelope
        n, b = len(first), len(self._order.border)
        a, right, below, corner = np.split(store, self._ends[:-1])
        right, below, corner = right.reshape(n, b), below.reshape(b, n), corner.reshape(b, b)
        inverse = np.empty(n)
        if not eliminate(first, reach, offsets, a, inverse, right, below, corner):
            return None

        def solve(r: Array) -> Array:
            x = r[self._permutation]
            forward(first, offsets, a, below, x)
            if b:
                x[n:] = np.linalg.solve(corner, x[n:])
            backward(first, reach, offsets, a, inverse, right, x)
            out = np.empty_like(x)
            out[self._permutation] = x
            return out

        return solve
