"""One V-cycle of multigrid, compiled: Gauss-Seidel forward before, backward after coarser levels.

Of the finest level the product of the matrix with the result comes for half its price: backward
Gauss-Seidel knows the sums over one triangle, and those over the other with old values. Entries
are of single precision, which halves what is read; sums and vectors are of double precision.
Everything sums in a fixed order: results do not depend on the number of threads.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
Places = NDArray[np.uint32]

REORDER = {"reassoc", "contract", "nsz"}
"""What the compiler may do to sums, so that they become vector instructions."""


class Rows(NamedTuple):
    """A sparse matrix by rows, columns rising.

    middle : (n,)  place of the diagonal entry in each row
    inverse : (n,) float  of the diagonal
    """

    starts: Places
    middle: Places
    columns: Places
    data: NDArray[np.float32]
    inverse: Array


class Transfer(NamedTuple):
    """A sparse matrix by rows: what a level gets from the next coarser one."""

    starts: Places
    columns: Places
    data: NDArray[np.float32]


class Coarser(NamedTuple):
    """Levels below the finest: their matrices, and how each level gets from the next."""

    rows: Sequence[Rows]
    transfers: Sequence[Transfer]
    sizes: Sequence[int]
    last: Callable[[Array], Array]


def rows_of(A: csr_array) -> Rows:
    """For the kernels."""
    starts, columns = A.indptr.astype(np.uint32), A.indices.astype(np.uint32)
    middle = diagonal_places(starts, columns)
    return Rows(starts, middle, columns, A.data.astype(np.float32), 1.0 / A.data[middle])


def with_entries(rows: Rows, data: Array) -> tuple[Rows, Array]:
    """Other entries at the same places, and the sums of the columns."""
    sums = np.zeros(len(rows.inverse))
    short = shortened(rows.columns, data, sums)
    return rows._replace(data=short, inverse=1.0 / data[rows.middle]), sums


def diagonal_places(starts: Places, columns: Places) -> Places:
    """(n,) of a matrix that has all entries on its diagonal."""
    rows = np.repeat(np.arange(len(starts) - 1, dtype=np.uint32), np.diff(starts))
    return np.flatnonzero(rows == columns).astype(np.uint32)


def coarser(matrices: Sequence[csr_array], transfers: Sequence[csr_array]) -> Coarser:
    """From the matrices of all levels but the finest, the last of which is solved directly."""
    sizes = [A.shape[0] for A in matrices]
    last = splu(matrices[-1].tocsc()).solve if matrices else np.copy
    return Coarser(
        [rows_of(A) for A in matrices[:-1]], [_transfer(P) for P in transfers], sizes, last
    )


def _transfer(P: csr_array) -> Transfer:
    return Transfer(
        P.indptr.astype(np.uint32), P.indices.astype(np.uint32), P.data.astype(np.float32)
    )


def cycle(finest: Rows, below: Coarser, r: Array) -> tuple[Array, Array]:
    """x, about A^-1 r, and A x."""
    x, known = _level(finest, below, 0, r)
    return x, finished(*finest[:4], x, known)


def _level(own: Rows, below: Coarser, depth: int, r: Array) -> tuple[Array, Array]:
    x, known = np.empty_like(r), np.empty_like(r)
    relaxed(*own, r, x)
    if depth < len(below.transfers):
        way, coarse = below.transfers[depth], np.zeros(below.sizes[depth])
        restricted(*own[:4], x, *way, coarse)
        deepest = depth + 1 == len(below.transfers)
        found = (
            below.last(coarse)
            if deepest
            else _level(below.rows[depth], below, depth + 1, coarse)[0]
        )
        prolonged(*way, found, x)
    relaxed_back(*own, r, x, known)
    return x, known


@njit(cache=True)
def shortened(columns, data, sums):  # pragma: no cover
    """Entries in single precision; the sums of columns are of the double ones."""
    out = np.empty(len(data), np.float32)
    for s in range(len(data)):
        out[s] = data[s]
        sums[columns[s]] += data[s]
    return out


@njit(cache=True, fastmath=REORDER)
def relaxed(starts, middle, columns, data, inverse, r, x):  # pragma: no cover
    """Gauss-Seidel forward, from 0."""
    for i in range(len(r)):
        total = 0.0
        for s in range(starts[i], middle[i]):
            total += data[s] * x[columns[s]]
        x[i] = (r[i] - total) * inverse[i]


@njit(cache=True, fastmath=REORDER)
def restricted(starts, middle, columns, data, x, ways, to, shares, out):  # pragma: no cover
    """Add what ``relaxed`` has left to the coarser level."""
    for i in range(len(x)):
        total = 0.0
        for s in range(middle[i] + np.uint32(1), starts[i + 1]):
            total += data[s] * x[columns[s]]
        for s in range(ways[i], ways[i + 1]):
            out[to[s]] -= shares[s] * total


@njit(cache=True, fastmath=REORDER)
def prolonged(ways, to, shares, coarse, x):  # pragma: no cover
    """Add what the coarser level has found."""
    for i in range(len(x)):
        for s in range(ways[i], ways[i + 1]):
            x[i] += shares[s] * coarse[to[s]]


@njit(cache=True, fastmath=REORDER)
def relaxed_back(starts, middle, columns, data, inverse, r, x, known):  # pragma: no cover
    """Gauss-Seidel backward; ``known``: A x but for the lower triangle."""
    for i in range(len(r) - 1, -1, -1):
        low, high = 0.0, 0.0
        for s in range(starts[i], middle[i]):
            low += data[s] * x[columns[s]]
        for s in range(middle[i] + np.uint32(1), starts[i + 1]):
            high += data[s] * x[columns[s]]
        known[i] = r[i] - low
        x[i] = (known[i] - high) * inverse[i]


@njit(cache=True, fastmath=REORDER)
def finished(starts, middle, columns, data, x, known):  # pragma: no cover
    """A x, of the result of ``relaxed_back``."""
    out = np.empty_like(x)
    for i in range(len(x)):
        total = 0.0
        for s in range(starts[i], middle[i]):
            total += data[s] * x[columns[s]]
        out[i] = known[i] + total
    return out


@njit(cache=True, fastmath=REORDER)
def separated(v, Av, w, product):  # pragma: no cover
    """Take from w what is along v, from A w as much of A v; returns how much."""
    along = 0.0
    for i in range(len(v)):
        along += v[i] * w[i]
    for i in range(len(v)):
        w[i] -= along * v[i]
        product[i] -= along * Av[i]
    return along
