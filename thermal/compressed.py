"""Rows of a sparse matrix of fixed pattern, filled through precomputed slots."""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Compressed:
    """Where entries (row, column) of a list land in the rows of the matrix of the free unknowns.

    Parameters
    ----------
    n : int  unknowns in all
    free : (f,) intp  those of the matrix; entries of others are dropped
    rows, columns : (k,) intp  in the numbering of all

    Attributes
    ----------
    size : int  f
    slots : (k,) int32 or int64  place of each entry in the data; one past the end: dropped
    starts, columns : int32 or int64  rows of the matrix, columns sorted within each
    """

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        place = np.full(n, -1)
        place[free] = np.arange(len(free))
        self.size = len(free)
        kind = np.int32 if len(rows) < 2**31 - 1 else np.int64
        slots, starts, found = _compress(place, self.size, rows, columns, kind(0))
        self.slots, self.starts, self.columns = slots, starts, found[: starts[-1]].copy()

    def data(self, values: Array) -> Array:
        """(nnz,) from the ``values`` (k,) of the list."""
        out = np.zeros(len(self.columns) + 1)
        _gather(self.slots, values, out)
        return out[:-1]

    def matrix(self, values: Array) -> csr_array:
        """The sparse matrix."""
        return self.stored(self.data(values))

    def stored(self, data: Array) -> csr_array:
        """The same of its stored entries (nnz,)."""
        return csr_array((data, self.columns, self.starts), shape=(self.size, self.size))

    def bandwidth(self) -> int:
        """Largest distance of an entry from the diagonal, in Cuthill & McKee's order (1969)."""
        ones = np.ones(len(self.columns), np.int8)
        pattern = csr_array((ones, self.columns, self.starts), shape=(self.size, self.size))
        place = np.empty(self.size, np.int64)
        place[reverse_cuthill_mckee(pattern, symmetric_mode=True)] = np.arange(self.size)
        rows = np.repeat(place, np.diff(self.starts))
        return int(np.abs(rows - place[self.columns]).max(initial=0))


@njit(cache=True)
def _compress(place, size, rows, columns, zero):  # pragma: no cover
    """Slots of the entries, starts of the rows, and columns (of which the first nnz count)."""
    kind = type(zero)
    first, order = _by_row(place, size, rows, columns, kind)
    slots = np.empty(len(rows), kind)
    slots[:] = -1
    starts = np.zeros(size + 1, kind)
    found = np.empty(len(order), kind)
    slot = np.full(size, -1, kind)
    end = zero
    for i in range(size):
        begin = end
        for e in order[first[i] : first[i + 1]]:
            j = place[columns[e]]
            if slot[j] < begin:
                slot[j] = begin
                found[end] = j
                end += 1
        found[begin:end].sort()
        for s in range(begin, end):
            slot[found[s]] = s
        for e in order[first[i] : first[i + 1]]:
            slots[e] = slot[place[columns[e]]]
        starts[i + 1] = end
    for e in range(len(slots)):
        if slots[e] < 0:
            slots[e] = end
    return slots, starts, found


@njit(cache=True)
def _by_row(place, size, rows, columns, kind):  # pragma: no cover
    """Entries among free unknowns row by row: starts (size + 1), and which they are."""
    first = np.zeros(size + 1, np.int64)
    for e in range(len(rows)):
        if place[rows[e]] >= 0 and place[columns[e]] >= 0:
            first[place[rows[e]] + 1] += 1
    first = np.cumsum(first)
    order = np.empty(first[-1], np.int64)
    taken = first[:-1].copy()
    for e in range(len(rows)):
        i = place[rows[e]]
        if i >= 0 and place[columns[e]] >= 0:
            order[taken[i]] = e
            taken[i] += 1
    return first, order


@njit(cache=True)
def _gather(slots, values, out):  # pragma: no cover
    for e in range(len(slots)):
        out[slots[e]] += values[e]
