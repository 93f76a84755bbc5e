"""Choice of a linear solver for the constrained system matrix.

Few unknowns go to a dense LU with partial pivoting, many to the factorisation by blocks of
``mechanics.block_kernels``; both are compiled. Where blocks lose a pivot, or a solution does not
fulfil its equations, the same matrix goes to SuperLU, which pivots freely.
"""

import ctypes
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics import block_kernels, blocks, libraries, signs
from mechanics.assembly import Pattern
from mechanics.kernels import (
    FACTOR,
    SOLVE,
    callback,
    factor_at,
    kernel,
    outside_at,
    solve_at,
    uninterrupted,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Solve = Callable[[Array], Array]

DENSE = 100
"""Systems of up to this many unknowns are dense."""


class Solver(NamedTuple):
    """A solver for matrices of one pattern, as compiled code sees it.

    name : of what solves
    ints : (k,) int64, work_size : what ``factor(ints, data, work)`` and ``solve(ints, work, b)``
        need
    factor, solve : addresses of kernels (``kernels.FACTOR``, ``SOLVE``)
    library : makes a library of its own for each factorisation from Python, where one is needed
    kept : what the addresses in ``ints`` belong to
    """

    name: str
    ints: Indices
    work_size: int
    factor: int
    solve: int
    library: Callable[[], libraries.Library] | None = None
    kept: Sequence[Any] = ()

    def factorise(self, data: Array) -> Solve | None:
        """Solver for right-hand sides (n,), or None when the matrix is singular or not finite."""
        data = np.array(data, float)
        work = uninterrupted(self._factors, data)
        if work is None:
            return None
        if self.library is not None and work[0] != 0.0:
            return _by_library(self.library(), data)

        def solve(b: Array) -> Array:
            x = np.array(b, float)
            _solve(self.solve, self.ints, work, x)
            return x

        return solve

    def counted(self, data: Array) -> tuple[Solve, int] | None:
        """Solver for right-hand sides (n, k), and number of negative eigenvalues of a symmetric
        matrix; None where its own factors do not tell, as where pivots were sought in all of it.
        """
        if self.name != "blocks" or not self.ints[SYMMETRIC]:
            return None
        work = self._factors(np.array(data, float))
        if work is None or work[0] != 0.0:
            return None
        own, factors = self.ints[_inner(self.ints) :], work[1 + self.ints[UNKNOWNS] :]

        def solve(b: Array) -> Array:
            x = np.array(b.T, float, order="C")
            block_kernels.solve_many(own, factors, x)
            return x.T

        return solve, signs.negatives(own, factors)

    def _factors(self, data: Array) -> Array | None:
        work = np.zeros(self.work_size)
        if not np.isfinite(data).all() or _factor(self.factor, self.ints, data, work) != 0:
            return None
        return work


def _by_library(library: libraries.Library, data: Array) -> Solve | None:
    if library.factor(data) != 0:
        return None

    def solve(b: Array) -> Array:
        x = np.array(b, float)
        library.solve(x)
        return x

    return solve


def choose(
    pattern: Pattern,
    node_of: Indices,
    symmetric: bool | None,
    prefer: str | None = None,
    rank: Indices | None = None,
    stage: Indices | None = None,
) -> Solver:
    """The solver for a pattern.

    Parameters
    ----------
    node_of : (n + m,) int  block of each unknown: its node, or its joint
    symmetric : whether matrices are symmetric; None: nearly so, and blocks may take their
        symmetric part instead, with half the numbers, as Newton's method needs no exact matrix
    prefer : "dense", "blocks", or a library of ``libraries.MAKERS``; None or "auto": by size
    rank : (n + m,) int  0 for coordinates with a mass, more for others; by default guessed:
        multipliers come last and do not know one another, and a coordinate that is alone in its
        block has no mass
    stage : (n + m,) int  later stages are eliminated later where they can be; None: all the same
    """
    if prefer in (None, "auto"):
        prefer = "dense" if pattern.size <= DENSE else "blocks"
    if prefer == "dense":
        return _dense(pattern)
    if prefer == "blocks":
        massive = _guessed(pattern, node_of) if rank is None else np.asarray(rank) == 0
        stages = np.zeros(pattern.size, np.int64) if stage is None else stage
        return _blocks(pattern, np.asarray(node_of, np.int64), symmetric, massive, stages)
    return _outside(partial(libraries.find, str(prefer), pattern, bool(symmetric)), pattern)


def _guessed(pattern: Pattern, node_of: Indices) -> NDArray[np.bool_]:
    column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))
    row = pattern.indices
    apart = node_of[row] != node_of[column]
    start = int(np.minimum(row, column)[apart].max(initial=-1)) + 1
    alone = np.bincount(node_of)[node_of] == 1
    return (np.arange(pattern.size) < start) & ~alone


# -- dense -----------------------------------------------------------------------------------------


def _dense(pattern: Pattern) -> Solver:
    n = pattern.size
    column = np.repeat(np.arange(n), np.diff(pattern.indptr))
    ints = np.concatenate([[n], pattern.indices.astype(np.int64) * n + column])
    factor, solve = kernel(FACTOR)(factor_dense), kernel(SOLVE)(solve_dense)
    return Solver("dense", ints, n * n + n, factor, solve)


def factor_dense(ints, data, work):
    """LU by rows with partial pivoting; the choices of pivots stand behind the factors."""
    n = ints[0]
    work[: n * n] = 0.0
    for i in range(1, len(ints)):
        work[ints[i]] = data[i - 1]
    for j in range(n):
        best, size = j, abs(work[j * n + j])
        for i in range(j + 1, n):
            if abs(work[i * n + j]) > size:
                best, size = i, abs(work[i * n + j])
        if not 0.0 < size < np.inf:
            return 1
        work[n * n + j] = best
        row, other = work[j * n : j * n + n], work[best * n : best * n + n]
        if best != j:
            for k in range(n):
                row[k], other[k] = other[k], row[k]
        pivot, ahead = 1.0 / row[j], row[j + 1 :]
        for i in range(j + 1, n):
            f = work[i * n + j] * pivot
            work[i * n + j] = f
            if f != 0.0:
                below = work[i * n + j + 1 : i * n + n]
                for k in range(len(ahead)):
                    below[k] -= f * ahead[k]
    return 0


def solve_dense(ints, work, b):
    """Solution with the factors of ``factor_dense``."""
    n = ints[0]
    for i in range(n):
        k = int(work[n * n + i])
        b[i], b[k] = b[k], b[i]
    for i in range(n):
        row, s = work[i * n : i * n + i], 0.0
        for k in range(i):
            s += row[k] * b[k]
        b[i] -= s
    for i in range(n - 1, -1, -1):
        row, s = work[i * n : i * n + n], 0.0
        for k in range(i + 1, n):
            s += row[k] * b[k]
        b[i] = (b[i] - s) / row[i]


# -- blocks, and libraries behind them -------------------------------------------------------------

UNKNOWNS, ENTRIES, SYMMETRIC, PAIRS, STARTS = 4, 5, 6, 7, 8
"""A guarded solver begins with the addresses of its own factor and solve and of those of a
library; then come sizes and arrays of the pattern, pairs of entries across the diagonal of which
the mean is taken, and the data of its own."""
EXACT = 1e-7
"""Largest error of an equation, relative to its terms, that a factorisation may leave [-]."""


def _blocks(
    pattern: Pattern,
    node_of: Indices,
    given: bool | None,
    massive: NDArray[np.bool_],
    stage: Indices,
) -> Solver:
    symmetric = given is not False
    pairs = np.zeros(0, np.int64) if given is not None else _pairs(pattern)
    parts = blocks.arrange(pattern, node_of, blocks.ranks(pattern, massive), stage)
    inner, size = blocks.lay_out(pattern, parts, symmetric)
    make = partial(libraries.find, "superlu", pattern, symmetric)
    kept: list[Any] = []
    addresses = *block_kernels.kernels(symmetric), *_addresses(make(), pattern, kept)
    head = [*addresses, pattern.size, len(pattern.indices), int(symmetric), len(pairs)]
    ints = np.concatenate([head, pattern.indptr, pattern.indices, pairs, inner]).astype(np.int64)
    factor, solve = kernel(FACTOR)(factor_guarded), kernel(SOLVE)(solve_guarded)
    return Solver("blocks", ints, 1 + pattern.size + size, factor, solve, make, kept)


def _pairs(pattern: Pattern) -> Indices:
    """Entries (i, j), 32 bits to the left, and (j, i) above the diagonal."""
    column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))
    across = np.lexsort((column, pattern.indices))
    upper = np.flatnonzero(pattern.indices < column)
    return (upper << 32) | across[upper]


@njit(cache=True, error_model="numpy")
def _even_out(pairs, data):
    """Take the symmetric part of a matrix."""
    for i in range(len(pairs)):
        a, b = pairs[i] >> 32, pairs[i] & 0xFFFFFFFF
        data[a] = data[b] = 0.5 * (data[a] + data[b])


@njit(cache=True, error_model="numpy")
def _error(symmetric, indptr, indices, data, x, b):
    """Largest error of an equation relative to the sum of its terms (Oettli & Prager 1964)."""
    left, terms = b.copy(), np.abs(b)
    for j in range(len(x)):
        at, end = indptr[j], indptr[j + 1]
        values, rows = data[at:end], indices[at:end]
        if symmetric:  # a column is also a row
            s, t = 0.0, 0.0
            for i in range(end - at):
                part = values[i] * x[rows[i]]
                s += part
                t += abs(part)
            left[j] -= s
            terms[j] += t
        else:
            for i in range(end - at):
                part = values[i] * x[j]
                left[rows[i]] -= part
                terms[rows[i]] += abs(part)
    worst = 0.0
    for i in range(len(x)):
        if not abs(left[i]) <= worst * terms[i]:
            worst = abs(left[i]) / terms[i]
            if not worst < np.inf:
                return np.inf
    return worst


def factor_guarded(ints, data, work):
    """Own factorisation; if it fails or is inexact, that of a library."""
    n, work[0] = ints[UNKNOWNS], 1.0
    indices = STARTS + n + 1
    pairs = indices + ints[ENTRIES]
    inner = pairs + ints[PAIRS]
    _even_out(ints[pairs:inner], data)
    own, factors, x = ints[inner:], work[1 + n :], work[1 : 1 + n]
    if factor_at(ints[0])(own, data, factors) == 0:
        for i in range(n):
            x[i] = 1.0 - 2.0 * ((i * i + i // 2) % 2)
        b = x.copy()
        solve_at(ints[1])(own, factors, x)
        if (
            _error(ints[SYMMETRIC] > 0, ints[STARTS:indices], ints[indices:pairs], data, x, b)
            <= EXACT
        ):
            work[0] = 0.0
            return 0
    return outside_at(ints[2])(np.int64(data.ctypes.data))


@njit(cache=True)
def _inner(ints):
    """Start of the integers of its own factorisation in those of a guarded solver."""
    return STARTS + ints[UNKNOWNS] + 1 + ints[ENTRIES] + ints[PAIRS]


def solve_guarded(ints, work, b):
    """Solution with the factors of ``factor_guarded``."""
    n = ints[UNKNOWNS]
    if work[0] == 0.0:
        solve_at(ints[1])(ints[_inner(ints) :], work[1 + n :], b)
    else:
        outside_at(ints[3])(np.int64(b.ctypes.data))


def _outside(make: Callable[[], libraries.Library], pattern: Pattern) -> Solver:
    library, kept = make(), list[Any]()
    addresses = _addresses(library, pattern, kept)
    kernels = kernel(FACTOR)(factor_library), kernel(SOLVE)(solve_library)
    return Solver(library.name, np.array(addresses), 1, *kernels, make, kept)


def factor_library(ints, data, work):
    """Factorisation by a library, which keeps its factors."""
    work[0] = 1.0
    return outside_at(ints[0])(np.int64(data.ctypes.data))


def solve_library(ints, work, b):
    """Solution with the last factors of a library."""
    outside_at(ints[1])(np.int64(b.ctypes.data))


def _addresses(library: libraries.Library, pattern: Pattern, keep: list[Any]) -> tuple[int, int]:
    """Addresses under which compiled code calls a library, as long as ``keep`` is there."""
    entries = len(pattern.indices) + 1

    def factor(address: int) -> int:
        return library.factor(_doubles(address, entries))

    def solve(address: int) -> int:
        library.solve(_doubles(address, pattern.size))
        return 0

    kind = ctypes.c_int64
    return tuple(callback(f, kind, returns=kind, keep=keep) for f in (factor, solve))  # type: ignore


def _doubles(address: int, count: int) -> Array:
    return np.ctypeslib.as_array((ctypes.c_double * count).from_address(address))


@njit(cache=True)
def _factor(address, ints, data, work):
    return factor_at(address)(ints, data, work)


@njit(cache=True)
def _solve(address, ints, work, b):
    solve_at(address)(ints, work, b)
