"""Matrix with a fixed pattern: entries of many blocks are summed through precomputed slots."""

from collections.abc import Callable, Sequence
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csc_array, sparray
from scipy.sparse.linalg import splu

from thermal.band import Banded, ordering, summed

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DENSE = 48  # unknowns up to which LAPACK serves; beyond, its threads cost more than they bring

WORTH = 2000.0  # multiplications for each entry at which SuperLU begins to be faster (measured)


LEFT = 1e-13  # of a row of a right side, relative to what is summed there, with pivots kept
SYMMETRIC = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}


class Pattern:
    """Where entries (row, column) of a list land in the matrix of the free unknowns.

    Parameters
    ----------
    n : int  unknowns in all
    free : (f,) intp  those of the matrix; entries of others are dropped
    rows, columns : (k,) intp  in the numbering of all
    """

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        place = np.full(n, -1)
        place[free] = np.arange(len(free))
        i, j = place[rows], place[columns]
        kept = (i >= 0) & (j >= 0)
        key = np.where(kept, j * len(free) + i, len(free) ** 2)
        self.size = len(free)
        # of a small matrix every entry is stored, of a large one those that occur
        stored = np.arange(self.size**2) if self.size <= DENSE else np.unique(key[kept])
        self.slots = np.searchsorted(stored, key)
        self.rows = stored % max(self.size, 1)
        counts = np.bincount(stored // max(self.size, 1), minlength=self.size)
        self.starts = np.concatenate([[0], np.cumsum(counts)])

    def data(self, values: Array) -> Array:
        """Stored entries, column by column, from the ``values`` (k,) of the list."""
        sums = np.bincount(self.slots, weights=values, minlength=len(self.rows) + 1)
        return sums[: len(self.rows)].astype(np.float64, copy=False)

    def matrix(self, values: Array) -> csc_array:
        """The sparse matrix."""
        return csc_array((self.data(values), self.rows, self.starts), shape=(self.size,) * 2)

    def factorise(self, values: Array) -> Callable[[Array], Array]:
        """Solver of linear systems with the matrix; of one that has none it gives nan."""
        if self.size == 0:
            return np.copy
        if self.size <= DENSE:
            return self._dense(values)
        return self._within_band(values) or self._sparse(values)

    def _dense(self, values: Array) -> Callable[[Array], Array]:
        dense = self.data(values).reshape(self.size, self.size).T
        factors = lu_factor(dense, overwrite_a=True, check_finite=False)
        return lambda r: lu_solve(factors, r, check_finite=False)

    def _within_band(self, values: Array) -> Callable[[Array], Array] | None:
        """None where the pattern has no narrow band, or elimination without pivots fails."""
        if self._banded is None:
            return None
        banded, slots = self._banded
        return banded.factorise(summed(slots, values, banded.size))

    def _sparse(self, values: Array) -> Callable[[Array], Array]:
        return symmetric_factors(self.matrix(values))

    @cached_property
    def _banded(self) -> tuple[Banded, NDArray[np.int32]] | None:
        """Solver within a band and, for each entry of the list, its place there."""
        columns = np.repeat(np.arange(self.size), np.diff(self.starts))
        both = np.concatenate([self.rows, columns]), np.concatenate([columns, self.rows])
        order = ordering(self.size, *both, WORTH * len(self.rows))
        if order is None:
            return None
        banded = Banded(order, self.rows, columns)
        return banded, np.append(banded.slots, banded.size).astype(np.int32)[self.slots]


def symmetric_factors(A: sparray) -> Callable[[Array], Array]:
    """Solver by SuperLU (Demmel et al. 1999), in the way of matrices symmetric about.

    Pivots stay on the diagonal, which keeps the order that spares fill-in; where that leaves too
    much of a right side, the factors are those with pivots. Of a singular matrix it gives nan.
    """
    A = A.tocsc()
    kept = _kept_pivots(A)
    if kept is None:
        return _pivoted(A)
    size = np.abs(A) @ np.ones(A.shape[0])
    other = cache(lambda: _pivoted(A))

    def solve(r: Array) -> Array:
        x = kept(r)
        left, worst = np.abs(A @ x - r), np.abs(x).max(initial=0.0)
        return x if (left <= LEFT * (size * worst + np.abs(r))).all() else other()(r)

    return solve


def _kept_pivots(A: csc_array) -> Callable[[Array], Array] | None:
    try:
        return splu(A, **SYMMETRIC).solve
    except RuntimeError:  # a pivot is 0
        return None


def _pivoted(A: csc_array) -> Callable[[Array], Array]:
    try:
        return splu(A).solve
    except RuntimeError:  # exactly singular
        return lambda r: np.full_like(r, np.nan)


def block_entries(dofs: Sequence[Indices]) -> tuple[Indices, Indices]:
    """Rows and columns of the entries of blocks on ``dofs`` (n, k), one array per term."""
    rows = [np.broadcast_to(d[:, :, None], (*d.shape, d.shape[1])).ravel() for d in dofs]
    columns = [np.broadcast_to(d[:, None, :], (*d.shape, d.shape[1])).ravel() for d in dofs]
    empty = [np.empty(0, np.intp)]
    return np.concatenate(empty + rows), np.concatenate(empty + columns)
