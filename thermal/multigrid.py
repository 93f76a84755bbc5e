"""Large systems of heat: GMRES (Saad & Schultz 1986), preconditioned by algebraic multigrid.

Smoothed aggregation (Vaněk, Mandel & Brezina 1996), whose near-null space is the constant
temperature, serves cells of like sides; classical multigrid (Ruge & Stüben 1987) serves thin ones;
both are PyAMG's. The second is taken where the first is slow. The hierarchy is kept over
iterations, steps and step sizes until it has cost as many iterations as a new one is worth.

GMRES minimises the preconditioned residual, which is an error in kelvin at every node, be its heat
capacity large or small; it takes the tangent as it is, which k(T) makes slightly unsymmetric.
Everything sums in a fixed order: results do not depend on the number of threads.
"""

from collections.abc import Callable
from math import inf
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, csr_matrix
from scipy.sparse.linalg import splu

from thermal.compressed import Array, Compressed, Indices

Operator = Callable[[Array], Array]

REDUCTION = 1e-3  # of the error, by one solve
HONEST = 10.0  # times that: what the residual over the diagonal may leave
ITERATIONS = 150  # of one solve
FEW = 12  # iterations beyond which the other kind of hierarchy is tried
SURPLUS = 15  # iterations in excess that a new hierarchy is worth
SLACK = 2  # iterations more than the least so far that are no excess yet


class Multigrid:
    """Inexact solutions by multigrid; direct ones from where multigrid has failed.

    Attributes
    ----------
    accuracy, refresh, trouble : see ``Linear``
    iterations : int  of the last solve
    built : list  kinds of hierarchies so far
    fallen_back : bool  multigrid did not converge; systems are solved directly
    """

    accuracy = 1e-8
    refresh = 0.02

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        self._rows = Compressed(n, free, rows, columns)
        self._cycle: Operator | None = None
        self._fresh = True
        self._least = self._surplus = 0
        self._most: dict[str, float] = dict.fromkeys(KINDS, FEW)
        self.iterations, self.built = 0, list[str]()
        self.fallen_back, self.trouble = False, ""

    def factorise(self, values: Array) -> Operator:
        """Solver of linear systems with the matrix."""
        A = self._rows.matrix(values)
        if self.fallen_back:
            return splu(A.tocsc()).solve
        diagonal, sums = A.diagonal(), A.T @ np.ones(A.shape[0])
        if self._surplus > SURPLUS:
            self._cycle = None
        return lambda r: balanced(self._solve(A, diagonal, r), r, sums)

    def _solve(self, A: csr_array, diagonal: Array, r: Array) -> Array:
        """By the hierarchy at hand, by new ones, or directly."""
        if not r.any():
            return np.zeros_like(r)
        while self._cycle is not None or min(self._most.values()) < inf:
            cycle = self._cycle or self._build(A)
            x, self.iterations, converged = gmres(A, r, cycle)
            if converged and _honest(A, diagonal, r, x):
                self._count()
                return x
            self._cycle = None
            if self._fresh:
                self._most[self.built[-1]] = inf
        self.fallen_back = True
        return splu(A.tocsc()).solve(r)

    def _build(self, A: csr_array) -> Operator:
        """A hierarchy of the kind that took the fewer iterations."""
        kind = min(self._most, key=lambda kind: self._most[kind])
        self._cycle, self._fresh, self._most[kind] = KINDS[kind](A), True, 0
        self.built.append(kind)
        return self._cycle

    def _count(self) -> None:
        taken, kind = self.iterations, self.built[-1]
        self._least = taken if self._fresh else min(self._least, taken)
        self._surplus = 0 if self._fresh else self._surplus + max(0, taken - self._least - SLACK)
        self._most[kind] = max(self._most[kind], taken)
        self._fresh = False


def balanced(x: Array, r: Array, sums: Array) -> Array:
    """``x``, shifted as a whole so that the heat of all temperatures together is balanced.

    sums : 1^T A
    """
    total = float(sums.sum())
    left = float(r.sum()) - float(np.einsum("i,i", sums, x))
    shift = left / total if total > 0.0 else 0.0
    return x + shift if abs(shift) <= REDUCTION * np.abs(x).max(initial=0.0) else x


class _Basis(NamedTuple):
    """Of a Krylov space, and the triangular system that Givens rotations make of it."""

    vectors: list[Array]
    columns: list[Array]
    turns: list[tuple[float, float]]
    right: list[float]


def gmres(A: csr_array, r: Array, cycle: Operator) -> tuple[Array, int, bool]:
    """x with A x = r, the iterations, and whether the error fell by ``REDUCTION``."""
    first = cycle(r)
    size = _norm(first)
    if not np.isfinite(size) or size == 0.0:
        return first, 0, size == 0.0
    basis = _Basis([first / size], [], [], [size])
    while len(basis.columns) < ITERATIONS:
        _extend(basis, cycle(A @ basis.vectors[-1]))
        if not abs(basis.right[-1]) > REDUCTION * size:
            break
    return _combined(basis), len(basis.columns), abs(basis.right[-1]) <= REDUCTION * size


def _extend(basis: _Basis, w: Array) -> None:
    """By one vector: Arnoldi with modified Gram-Schmidt, then the rotations."""
    column = np.empty(len(basis.vectors) + 1)
    for i, v in enumerate(basis.vectors):
        column[i] = np.einsum("i,i", v, w)
        w = w - column[i] * v
    last = _norm(w)
    for i, (c, s) in enumerate(basis.turns):
        column[i : i + 2] = c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]
    length = np.hypot(column[-2], last)
    c, s = (column[-2] / length, last / length) if length > 0.0 else (1.0, 0.0)
    column[-2] = length
    basis.vectors.append(w / last if last > 0.0 else w)
    basis.columns.append(column[:-1])
    basis.turns.append((c, s))
    basis.right[-1:] = [c * basis.right[-1], -s * basis.right[-1]]


def _combined(basis: _Basis) -> Array:
    """The combination of least error."""
    m = len(basis.columns)
    y = np.array(basis.right[:m])
    for i in range(m - 1, -1, -1):
        y[i] /= basis.columns[i][i]
        for k in range(i):
            y[k] -= basis.columns[i][k] * y[i]
    x = np.zeros_like(basis.vectors[0])
    for factor, v in zip(y, basis.vectors, strict=False):
        x += factor * v
    return x


def _honest(A: csr_array, diagonal: Array, r: Array, x: Array) -> bool:
    """Whether the residual itself is small: over the diagonal it is at most twice the error."""
    return _norm((r - A @ x) / diagonal) <= HONEST * REDUCTION * _norm(x)


def _norm(v: Array) -> float:
    # not by BLAS, whose threads change the order of the sum
    return float(np.sqrt(np.einsum("i,i", v, v)))


def _aggregation(A: csr_array) -> Operator:
    """Smoothed aggregation; bounds of the spectrum from row sums, nothing random."""
    from pyamg import smoothed_aggregation_solver

    smooth = ("jacobi", {"omega": 4.0 / 3.0, "weighting": "local"})
    return _cycle(smoothed_aggregation_solver(csr_matrix(A), smooth=smooth, **CYCLE))


def _classical(A: csr_array) -> Operator:
    """Coarser only along strong connections, such as through thin cells."""
    from pyamg import ruge_stuben_solver

    strength = ("classical", {"theta": 0.7, "norm": "min"})
    return _cycle(ruge_stuben_solver(csr_matrix(A), strength=strength, **CYCLE))


def _cycle(levels: Any) -> Operator:
    return levels.aspreconditioner(cycle="V").matvec


CYCLE = {
    "presmoother": ("gauss_seidel", {"sweep": "forward"}),
    "postsmoother": ("gauss_seidel", {"sweep": "backward"}),
    "max_coarse": 50,
    "coarse_solver": "splu",
}
KINDS = {"aggregation": _aggregation, "classical": _classical}
