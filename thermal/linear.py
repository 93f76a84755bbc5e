"""Linear systems of heat: a matrix of fixed pattern, and who solves it."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from thermal.pattern import Pattern

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SMALL = 2000  # unknowns up to which systems are solved directly
# Work up to which they are too: unknowns times the square of the bandwidth. Measured at it, for a
# step of four iterations: SuperLU .1 to 1 s, multigrid .06 to .2 s on cells of like sides; but
# thin cells take multigrid several times as many iterations, and SuperLU no more.
WORK = 2e9


class Linear(Protocol):
    """Solver of systems whose matrix has entries at fixed rows and columns.

    accuracy : float  relative change of temperature that may be the last; 0: Newton's method ends
        at round-off
    refresh : float  a slower contraction of Newton's method asks for a new tangent
    trouble : str  why the last system has no solution, of which x = nan; or ""
    """

    accuracy: float
    refresh: float
    trouble: str

    def factorise(self, values: Array) -> Callable[[Array], Array]:
        """Solver x = A^-1 r of the free unknowns, from the entries (k,) of the matrix."""
        ...


@runtime_checkable
class Recalling(Protocol):
    """Of those whose solutions depend on earlier ones: so that a resumed run finds the same.

    What ``prepared`` gives has the stored entries of its matrix as ``data``.
    """

    def memory(self) -> dict[str, Any]:
        """What later solutions depend on beside their matrices: arrays, numbers, texts."""
        ...

    def remember(self, memory: Mapping[str, Any]) -> None:
        """Become as the solver was that told its ``memory``."""
        ...

    def prepared(self, data: Array) -> Any:
        """Solver of systems with the matrix of the stored entries ``data``."""
        ...


class Direct:
    """LAPACK, an envelope, or SuperLU; see ``thermal.pattern``. Equal matrices share factors."""

    accuracy = 0.0
    refresh = 1e-4
    trouble = ""

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        self._pattern = Pattern(n, free, rows, columns)
        self._last: tuple[Array, Callable[[Array], Array]] | None = None

    def factorise(self, values: Array) -> Callable[[Array], Array]:
        """Solver of linear systems with the matrix."""
        if self._last is None or not np.array_equal(values, self._last[0]):
            self._last = values, self._pattern.factorise(values)
        return self._last[1]


def linear_solver(name: str, n: int, free: Indices, rows: Indices, columns: Indices) -> Linear:
    """The solver ``name`` of ``Settings.linear`` for a pattern.

    name : "direct", "multigrid", "petsc", or "auto": directly where that is little work
    """
    if name == "auto":
        name = "direct" if _is_little(n, free, rows, columns) else "multigrid"
    if name == "multigrid":
        from thermal.multigrid import Multigrid

        return Multigrid(n, free, rows, columns)
    if name == "petsc":
        from thermal.petsc import Petsc

        return Petsc(n, free, rows, columns)
    if name != "direct":
        raise ValueError(f"linear: 'auto', 'direct', 'multigrid' or 'petsc', got '{name}'")
    return Direct(n, free, rows, columns)


def _is_little(n: int, free: Indices, rows: Indices, columns: Indices) -> bool:
    """Whether little work is expected of a direct solution."""
    if len(free) <= SMALL:
        return True
    from thermal.compressed import Compressed

    matrix = Compressed(n, free, rows, columns)
    return len(free) * matrix.bandwidth() ** 2 <= WORK
