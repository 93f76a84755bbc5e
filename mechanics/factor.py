"""Factorisation of the constrained system matrix.

SuperLU runs wherever scipy runs. Systems of up to ``DENSE`` unknowns go to LAPACK: there the
overhead of a sparse call dominates. (A beam of 208 unknowns costs 0.65 ms to factorise and 18 µs
to solve either way, but dense LU of that size wakes the threads of the BLAS, which on a busy
machine wait for one another many times longer than they compute.)
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from mechanics.assembly import Pattern

Array = NDArray[np.float64]
Solve = Callable[[Array], Array]

DENSE = 32


def factorise(shape: Pattern, data: Array) -> Solve | None:
    """Solver for right-hand sides (n,), or None when the matrix is singular or not finite."""
    if not np.all(np.isfinite(data)):
        return None
    return _dense(shape, data) if shape.size <= DENSE else _sparse(shape, data)


def _dense(shape: Pattern, data: Array) -> Solve | None:
    lu, pivots, info = lapack.dgetrf(shape.matrix(data).toarray(order="F"), overwrite_a=True)
    if info != 0:
        return None

    def solve(b: Array) -> Array:
        return lapack.dgetrs(lu, pivots, b)[0]

    return solve


def _sparse(shape: Pattern, data: Array) -> Solve | None:
    try:
        return splu(shape.matrix(data)).solve
    except RuntimeError:  # SuperLU: "Factor is exactly singular"
        return None
