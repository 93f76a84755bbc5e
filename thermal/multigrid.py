"""Large systems of heat: GMRES (Saad & Schultz 1986), preconditioned by algebraic multigrid.

Smoothed aggregation (Vaněk, Mandel & Brezina 1996), whose near-null space is the constant
temperature, serves cells of like sides; classical multigrid (Ruge & Stüben 1987) serves thin ones;
both are PyAMG's, their cycles compiled here. The second is taken where the first is slow. The
hierarchy is kept over iterations, steps and step sizes until it has cost as many iterations as a
new one is worth.

GMRES minimises the preconditioned residual, which is an error in kelvin at every node, be its heat
capacity large or small; it takes the tangent as it is, which k(T) makes slightly unsymmetric.
Everything sums in a fixed order: results do not depend on the number of threads.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, csr_matrix

from thermal.compressed import Array, Compressed, Indices
from thermal.pattern import symmetric_factors
from thermal.vcycle import Coarser, Rows, coarser, cycle, rows_of, separated, with_entries

Operator = Callable[[Array], Array]
Step = Callable[[Array], tuple[Array, Array]]

REDUCTION = 1e-3  # of the error, by one solve
ENOUGH = 10.0 * REDUCTION  # left where the last step, which costs nothing, takes the rest
HONEST = 10.0  # times that: what the residual over the diagonal may leave
ITERATIONS = 150  # of one solve
FEW = 12  # iterations beyond which the other kind of hierarchy is tried
SURPLUS = 15  # iterations in excess that a new hierarchy is worth
COARSEST = 50  # temperatures, about, of the level that is solved directly
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

    accuracy = 1e-10
    refresh = 0.1

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        self._rows = Compressed(n, free, rows, columns)
        self._empty = rows_of(self._rows.matrix(np.ones(len(rows))))
        self._below: Coarser | None = None
        self._made_of = np.empty(0)
        self._fresh = True
        self._least = self._surplus = 0
        self._most: dict[str, float] = dict.fromkeys(KINDS, FEW)
        self.iterations, self.built = 0, list[str]()
        self.fallen_back, self.trouble = False, ""

    def factorise(self, values: Array) -> Operator:
        """Solver of linear systems with the matrix."""
        if self._surplus > SURPLUS:
            self._below = None
        return self.prepared(self._rows.data(values))

    def prepared(self, data: Array) -> "Prepared":
        """The same of the stored entries (nnz,)."""
        A = self._rows.stored(data)
        finest, sums = with_entries(self._empty, data)
        solve = symmetric_factors(A) if self.fallen_back else partial(self._solve, A, finest)
        return Prepared(lambda r: balanced(solve(r), r, sums), data)

    def memory(self) -> dict[str, Any]:
        """What later solutions depend on beside their matrices."""
        found: dict[str, Any] = {
            name: getattr(self, f"_{name}") for name in ("fresh", "least", "surplus")
        }
        found |= {"most": list(self._most.values()), "fallen_back": self.fallen_back}
        if self._below is not None:
            found |= {"kind": self.built[-1], "made_of": self._made_of}
        return found

    def remember(self, memory: Mapping[str, Any]) -> None:
        """Become as the solver was that told its ``memory``."""
        if not memory:
            return
        self.fallen_back, self._below = bool(memory["fallen_back"]), None
        if "kind" in memory:
            data = np.asarray(memory["made_of"], float)
            self._build(self._rows.stored(data), str(memory["kind"]))
        self._fresh = bool(memory["fresh"])
        self._least, self._surplus = int(memory["least"]), int(memory["surplus"])
        self._most = dict(zip(KINDS, map(float, memory["most"]), strict=True))

    def _solve(self, A: csr_array, finest: Rows, r: Array) -> Array:
        """By the hierarchy at hand, by new ones, or directly."""
        if not r.any():
            return np.zeros_like(r)
        while self._below is not None or min(self._most.values()) < inf:
            below = self._below or self._build(A, self._promising())
            x, product, self.iterations, converged = gmres(partial(cycle, finest, below), r)
            if converged and _honest(finest, r - product, x):
                self._count()
                return x
            self._below = None
            if self._fresh:
                self._most[self.built[-1]] = inf
        self.fallen_back = True
        return symmetric_factors(A)(r)

    def _promising(self) -> str:
        """The kind of hierarchy that took the fewer iterations."""
        return min(self._most, key=lambda kind: self._most[kind])

    def _build(self, A: csr_array, kind: str) -> Coarser:
        self._below, self._fresh, self._most[kind] = KINDS[kind](A), True, 0
        self._made_of = A.data
        self.built.append(kind)
        return self._below

    def _count(self) -> None:
        taken, kind = self.iterations, self.built[-1]
        self._least = taken if self._fresh else min(self._least, taken)
        self._surplus = 0 if self._fresh else self._surplus + max(0, taken - self._least - SLACK)
        self._most[kind] = max(self._most[kind], taken)
        self._fresh = False


@dataclass(frozen=True)
class Prepared:
    """Solver of systems with one matrix, and its stored entries (nnz,)."""

    solve: Operator
    data: Array

    def __call__(self, r: Array) -> Array:
        return self.solve(r)


def balanced(x: Array, r: Array, sums: Array) -> Array:
    """``x``, shifted as a whole so that the heat of all temperatures together is balanced.

    sums : 1^T A
    """
    total = float(sums.sum())
    left = float(r.sum()) - float(np.einsum("i,i", sums, x))
    shift = left / total if total > 0.0 else 0.0
    return x + shift if abs(shift) <= ENOUGH * np.abs(x).max(initial=0.0) else x


class _Basis(NamedTuple):
    """Of a Krylov space, A times it, and the triangular system that Givens rotations make of it."""

    vectors: list[Array]
    products: list[Array]
    columns: list[Array]
    turns: list[tuple[float, float]]
    right: list[float]


def gmres(step: Step, r: Array) -> tuple[Array, Array, int, bool]:
    """x with A x = r, A x, the iterations, and whether the error fell by ``REDUCTION``.

    step : about A^-1 r, and A times it, of r
    """
    first, product = step(r)
    size = _norm(first)
    if not np.isfinite(size) or size == 0.0:
        return first, product, 0, size == 0.0
    basis = _Basis([first / size], [product / size], [], [], [size])
    while len(basis.columns) < ITERATIONS:
        _extend(basis, *step(basis.products[-1]))
        if not abs(basis.right[-1]) > ENOUGH * size:
            break
    converged = abs(basis.right[-1]) <= ENOUGH * size
    return *_combined(basis), len(basis.columns), converged


def _extend(basis: _Basis, w: Array, product: Array) -> None:
    """By one vector: Arnoldi with modified Gram-Schmidt, then the rotations."""
    column = np.empty(len(basis.vectors) + 1)
    for i, (v, Av) in enumerate(zip(basis.vectors, basis.products, strict=True)):
        column[i] = separated(v, Av, w, product)
    last = _norm(w)
    for i, (c, s) in enumerate(basis.turns):
        column[i : i + 2] = c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]
    length = np.hypot(column[-2], last)
    c, s = (column[-2] / length, last / length) if length > 0.0 else (1.0, 0.0)
    column[-2] = length
    scale = 1.0 / last if last > 0.0 else 1.0
    basis.vectors.append(scale * w)
    basis.products.append(scale * product)
    basis.columns.append(column[:-1])
    basis.turns.append((c, s))
    basis.right[-1:] = [c * basis.right[-1], -s * basis.right[-1]]


def _combined(basis: _Basis) -> tuple[Array, Array]:
    """The combination of least residual and, for nothing, that residual as a last step."""
    m = len(basis.columns)
    left = np.zeros(m + 1)
    left[m] = basis.right[m]
    for i in range(m - 1, -1, -1):
        c, s = basis.turns[i]
        left[i : i + 2] = c * left[i] - s * left[i + 1], s * left[i] + c * left[i + 1]
    y = np.array(basis.right[:m])
    for i in range(m - 1, -1, -1):
        y[i] /= basis.columns[i][i]
        y[:i] -= basis.columns[i][:i] * y[i]
    left[:m] += y
    x, product = np.zeros_like(basis.vectors[0]), np.zeros_like(basis.vectors[0])
    for factor, v, Av in zip(left, basis.vectors, basis.products, strict=True):
        x += factor * v
        product += factor * Av
    return x, product


def _honest(finest: Rows, left: Array, x: Array) -> bool:
    """Whether the residual itself is small: over the diagonal it is at most twice the error."""
    return _norm(left * finest.inverse) <= HONEST * REDUCTION * _norm(x)


def _norm(v: Array) -> float:
    # not by BLAS, whose threads change the order of the sum
    return float(np.sqrt(np.einsum("i,i", v, v)))


def _aggregation(A: csr_array) -> Coarser:
    """Smoothed aggregation; bounds of the spectrum from row sums, nothing random."""
    from pyamg import smoothed_aggregation_solver

    smooth = ("jacobi", {"omega": 4.0 / 3.0, "weighting": "local"})
    return _levels(smoothed_aggregation_solver(csr_matrix(A), smooth=smooth, max_coarse=COARSEST))


def _classical(A: csr_array) -> Coarser:
    """Coarser only along strong connections, such as through thin cells."""
    from pyamg import ruge_stuben_solver

    strength = ("classical", {"theta": 0.7, "norm": "min"})
    return _levels(ruge_stuben_solver(csr_matrix(A), strength=strength, max_coarse=COARSEST))


def _levels(found: Any) -> Coarser:
    own = [csr_array(level.A) for level in found.levels[1:]]
    for A in own:
        A.sort_indices()
    return coarser(own, [csr_array(level.P) for level in found.levels[:-1]])


KINDS = {"aggregation": _aggregation, "classical": _classical}
