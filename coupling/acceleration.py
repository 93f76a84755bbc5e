"""Acceleration of the fixed point x = F(x) that an implicit exchange is.

``Relaxed``      x + w (F(x) - x), a constant factor; w = 1: none.
``Aitken``       the factor of the secant through the last two residuals (Irons & Tuck 1969;
                 Küttler & Wall 2008, eq. 44).
``QuasiNewton``  IQN-ILS: the least residual that the changes seen so far can make (Degroote, Bathe
                 & Vierendeels 2009, eqs. 16-20), with those of earlier windows, and without those
                 that others make nearly already (QR; Haelterman et al. 2016).
"""

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DEPENDENT = 1e-7
"""Part of a change of the residual that others do not make, below which it is left out [-]."""
LARGEST_FACTOR = 1e3
"""Of Aitken's; larger ones are made by residuals that differ by round-off only [-]."""


class Columns(NamedTuple):
    """Changes from iteration to iteration, the newest first.

    residuals, results : (k, n) float  of F(x) - x, and of F(x)
    ages : (k,) int  windows since they were seen
    length : float [s]  of the windows in which they were
    """

    residuals: Array
    results: Array
    ages: Indices
    length: float

    @classmethod
    def none(cls, n: int = 0) -> "Columns":
        """Nothing seen yet, of ``n`` unknowns."""
        return cls(np.zeros((0, n)), np.zeros((0, n)), np.zeros(0, np.intp), 0.0)

    def with_newest(self, residual: Array, result: Array) -> "Columns":
        """With one more change of this window."""
        residuals = np.vstack([residual, self.residuals.reshape(-1, len(residual))])
        results = np.vstack([result, self.results.reshape(-1, len(result))])
        return Columns(residuals, results, np.concatenate([[0], self.ages]), self.length)

    def only(self, kept: NDArray) -> "Columns":
        """Those that a mask or indices name."""
        return Columns(self.residuals[kept], self.results[kept], self.ages[kept], self.length)

    def for_window(self, length: float, reused: int, n: int) -> "Columns":
        """What a window of this length begins with: changes of up to ``reused`` windows before."""
        if self.length != length or self.residuals.shape[1] != n:
            return Columns.none(n)._replace(length=length)
        older = self._replace(ages=self.ages + 1)
        return older.only(older.ages <= reused)


class Acceleration(Protocol):
    """What the iterations of one window go through."""

    columns: Columns

    def next(self, x: Array, found: Array) -> Array:
        """(n,) the next x, after F(x) was ``found``."""
        ...


@dataclass
class Relaxed:
    """The same part of every residual."""

    factor: float = 1.0
    columns: Columns = field(default_factory=Columns.none)

    def next(self, x: Array, found: Array) -> Array:
        """See ``Acceleration``."""
        return x + self.factor * (found - x)


@dataclass
class Aitken:
    """A factor that follows from the last two residuals; ``factor`` is the first."""

    factor: float = 1.0
    columns: Columns = field(default_factory=Columns.none)
    _before: Array | None = None

    def next(self, x: Array, found: Array) -> Array:
        """See ``Acceleration``."""
        residual = found - x
        if self._before is not None:
            change = residual - self._before
            square = float(change @ change)
            factor = -self.factor * float(self._before @ change) / square if square > 0.0 else 1.0
            self.factor = min(LARGEST_FACTOR, max(-LARGEST_FACTOR, factor)) or 1.0
        self._before = residual
        return x + self.factor * residual


@dataclass
class QuasiNewton:
    """The inverse Jacobian that changes seen so far tell; ``factor`` is for when there are none."""

    factor: float = 1.0
    columns: Columns = field(default_factory=Columns.none)
    _before: tuple[Array, Array] | None = None

    def next(self, x: Array, found: Array) -> Array:
        """See ``Acceleration``."""
        residual = found - x
        if self._before is not None:
            r, result = self._before
            self.columns = self.columns.with_newest(residual - r, found - result)
        self._before = residual, found
        self.columns = filtered(self.columns)
        if not len(self.columns.ages):
            return x + self.factor * residual
        q, r = np.linalg.qr(self.columns.residuals.T)
        shares = np.linalg.solve(r, -(q.T @ residual))
        return found + self.columns.results.T @ shares


def filtered(columns: Columns) -> Columns:
    """Columns that do not depend on newer ones, by the diagonal of R (QR, newest first)."""
    columns = columns.only(np.any(columns.residuals != 0.0, axis=1))
    columns = columns.only(np.arange(len(columns.ages)) < columns.residuals.shape[1])
    while len(columns.ages):
        lengths = np.linalg.norm(columns.residuals, axis=1)
        r = np.linalg.qr((columns.residuals / lengths[:, None]).T, mode="r")
        bad = np.flatnonzero(~(np.abs(np.diag(r)) >= DEPENDENT))
        if not bad.size:
            break
        columns = columns.only(np.arange(len(lengths)) != bad[0])
    return columns


KINDS: dict[str, type[Relaxed] | type[Aitken] | type[QuasiNewton]] = {
    "none": Relaxed,
    "relaxation": Relaxed,
    "aitken": Aitken,
    "quasi-newton": QuasiNewton,
}
"""Accelerations by name; ``none`` has the factor 1."""
