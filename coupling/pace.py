"""How long the next window may be, and whether one was too long.

Coefficients that follow temperature (stiffness, free strains, clearance, friction ...) are
interpolated between the ends of a window: neither their change in it nor the error of their
prediction may be large. Both are relative: to the size of the coefficient, or, for those that are
zero in the reference, to what they would be if the absolute temperature doubled at the present
slope, and with gradients of that over the size of the scene. Free strains are measured by their
rates, in the latter way only.
"""

from collections.abc import Callable
from dataclasses import dataclass

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

    def apart(self, T0: Array, T1: Array) -> float:
        """Largest relative difference between the coefficients at ``T0`` and ``T1`` (n,) [K]."""
        if np.array_equal(T0, T1):
            return 0.0
        sections = self._read(T0)
        probed = sections + PROBE * sections[:, :1] * self._slopes
        first = self._system.coefficients(sections)
        second, beyond = (
            self._system.with_rates(first, self._system.coefficients(T), 1.0)[1]
            for T in (self._read(T1), probed)
        )
        parts = zip(first, second, beyond, strict=True)
        return max((_apart(*part) for part in parts), default=0.0)


def _apart(first: Array, second: Array, beyond: Array) -> float:
    """Of one term, columns measured one by one."""
    if not first.size:
        return 0.0
    difference, slope = (np.abs(c - first).max(axis=0) for c in (second, beyond))
    whole = np.maximum(np.abs(first).max(axis=0), slope / PROBE)
    told = difference > 0.0
    return float((difference[told] / np.maximum(whole[told], 1e-300)).max(initial=0.0))


@dataclass(frozen=True)
class Pace:
    """Limits of a window; called after each.

    change : float [-]  of coefficients in a window
    tolerance : float [-]  of coefficients, from predicted to found temperatures
    iterations : int  of the exchange; a window that takes more is followed by a shorter one
    """

    coefficients: Coefficients
    change: float
    tolerance: float
    iterations: int

    def judged(self, before: Coupled, after: Coupled) -> tuple[Coupled, str]:
        """The state with the growth that the next window may have; "" or why to repeat this one."""
        change = self.coefficients.apart(before.T, after.T)
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
