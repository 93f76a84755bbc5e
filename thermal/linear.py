"""Linear systems of heat: a matrix of fixed pattern, and who solves it."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from thermal.pattern import Pattern

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Linear(Protocol):
    """Solver of systems whose matrix has entries at fixed rows and columns.

    accuracy : float  relative change at which Newton's method may end; 0: at round-off
    """

    accuracy: float

    def factorise(self, values: Array) -> Callable[[Array], Array]:
        """Solver x = A^-1 r of the free unknowns, from the entries (k,) of the matrix."""
        ...


class Direct:
    """LAPACK for small, SuperLU for large systems; see ``thermal.pattern``."""

    accuracy = 0.0

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        self._pattern = Pattern(n, free, rows, columns)

    def factorise(self, values: Array) -> Callable[[Array], Array]:
        """Solver of linear systems with the matrix."""
        return self._pattern.factorise(values)


def linear_solver(name: str, n: int, free: Indices, rows: Indices, columns: Indices) -> Linear:
    """The solver ``name`` of ``Settings.linear`` for a pattern."""
    return Direct(n, free, rows, columns)
