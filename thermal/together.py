"""Two thermal models that exchange no heat as one: ``SideBySide``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermal.heat import NOTHING, Outside

Array = NDArray[np.float64]


class SideBySide:
    """Temperatures of the first solver, then those of the second; see ThermalSolver."""

    def __init__(self, first: Any, second: Any) -> None:
        self.solvers = first, second
        self.count = len(first.x)
        self.x = np.vstack([first.x, second.x])
        moved = {name: nodes + self.count for name, nodes in second.regions.items()}
        self.regions = {**first.regions, **moved}

    def initial(self) -> Array:
        """(n,) [K]"""
        return np.concatenate([solver.initial() for solver in self.solvers])

    def energy(self, T: Array) -> float:
        """Stored heat [J]."""
        return float(
            sum(s.energy(part) for s, part in zip(self.solvers, self._parts(T), strict=True))
        )

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside = NOTHING
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] through each boundary, reason."""
        parts = zip(self.solvers, self._parts(T), self._parts(heat), strict=True)
        ends, flows, why = zip(*(s.advance(x, t, h, q, outside) for s, x, q in parts), strict=True)
        return np.concatenate(ends), {**flows[0], **flows[1]}, next(filter(None, why), "")

    def _parts(self, values: Array) -> tuple[Array, Array]:
        return values[: self.count], values[self.count :]
