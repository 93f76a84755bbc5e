"""How long the next window may be, and whether one was too long.

Coefficients that follow temperature (stiffness, free strains, clearance, friction ...) are
interpolated between the ends of a window: neither their change in it nor the error of their
prediction may be large. Both are relative to the size of the coefficient, and to what it would
change if the absolute temperature doubled at the present slope; free strains to the latter only.
Gradients are probed as the temperature over the size of the scene.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.manager import Coupled
from mechanics.system import System

Array = NDArray[np.float64]

PROBE = 1e-2
"""Part of the temperature by which coefficients are probed [-]."""
ROOM = 0.9
"""Part of the limits which a window of twice the length must promise to keep [-]."""


class Coefficients:
    """Relative differences of coefficients between temperatures.

    Parameters
    ----------
    system : whose coefficients they are
    read : sections (m, 3) of nodal temperatures (n,)
    """

    def __init__(self, system: System, read: Callable[[Array], Array]) -> None:
        self._system, self._read = system, read
        x = system.layout.x
        size = float(np.ptp(x, axis=0).max(initial=0.0)) if len(x) else 0.0
        self._slopes = np.array([1.0, *(2 * [1.0 / size if size > 0.0 else 0.0])])
        self._strains = [
            _free_strains(*given) for given in zip(system.terms, system.columns, strict=True)
        ]

    def apart(self, T0: Array, T1: Array) -> float:
        """Largest relative difference between the coefficients at ``T0`` and ``T1`` (n,) [K]."""
        if np.array_equal(T0, T1):
            return 0.0
        sections = self._read(T0)
        probed = sections + PROBE * sections[:, :1] * self._slopes
        given = map(self._system.coefficients, (sections, self._read(T1), probed))
        parts = zip(*given, self._strains, strict=True)
        return max((_apart(*part) for part in parts), default=0.0)


def _free_strains(term: Any, columns: int) -> NDArray[np.bool_]:
    """(k,) which coefficients of a term are free strains: those of which it takes the rates."""
    numbers = np.tile(np.arange(1.0, columns + 1.0), (len(term.dofs), 1))
    rates = term.with_rates(np.zeros_like(numbers), numbers, 1.0)[0]
    return np.isin(np.arange(1.0, columns + 1.0), rates)


def _apart(first: Array, second: Array, beyond: Array, strains: NDArray[np.bool_]) -> float:
    """Of one term, columns measured one by one."""
    if not first.size:
        return 0.0
    difference, slope = (np.abs(c - first).max(axis=0) for c in (second, beyond))
    whole = np.where(strains, 0.0, np.abs(first).max(axis=0))
    free = slope[strains].max(initial=0.0)  # what no change of this kind strains: as the others
    slope[strains & (slope < PROBE * free)] = free
    whole = np.maximum(whole, slope / PROBE)
    told = (difference > 0.0) & (whole > 0.0)
    return float((difference[told] / whole[told]).max(initial=0.0))


@dataclass(frozen=True)
class Pace:
    """Limits of a window.

    The first window has nothing to predict from: it is short, and only its change is judged.

    change : float [-]  of coefficients in a window
    tolerance : float [-]  of coefficients, from predicted to found temperatures
    iterations : int  of the exchange; a window that takes more is followed by a shorter one
    first : int  the first window is 2**first times the longest
    """

    coefficients: Coefficients
    change: float
    tolerance: float
    iterations: int
    first: int = -6

    def judged(self, before: Coupled, after: Coupled) -> tuple[Coupled, str]:
        """The state with the growth that the next window may have; "" or why to repeat this one."""
        change = self.coefficients.apart(before.T, after.T)
        error = 0.0
        if before.exchange.total:
            error = self.coefficients.apart(after.T, after.exchange.expected)
        if change > self.change:
            return after, _reason("change", change, "in the window", self.change)
        if error > self.tolerance:
            return after, _reason("are", error, "from their prediction", self.tolerance)
        growth = self._growth(change, error, after.exchange.iterations)
        return after._replace(exchange=after.exchange._replace(growth=growth)), ""

    def _growth(self, change: float, error: float, count: int) -> int:
        """Change grows with the window, the error of the prediction with its square."""
        if count > self.iterations:
            return -1
        far = max(2.0 * change / self.change, 4.0 * error / self.tolerance)
        return 1 if far <= ROOM and 2 * count <= self.iterations + 1 else 0


def _reason(verb: str, value: float, where: str, limit: float) -> str:
    return f"temperature-dependent coefficients {verb} {value:.2g} {where}, the limit is {limit:g}"
