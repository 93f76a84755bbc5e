"""The list of verification problems; each area is a module that registers its own."""

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite

AREAS = ("beams", "dynamics", "contact", "heat", "thermoelastic")


@dataclass(frozen=True)
class Check:
    """One number against its reference.

    tolerance : relative to ``reference`` unless ``absolute``
    """

    name: str
    value: float
    reference: float
    tolerance: float
    unit: str = ""
    absolute: bool = False

    @property
    def error(self) -> float:
        """Deviation, relative unless ``absolute``; infinite relative to zero."""
        deviation = abs(self.value - self.reference)
        if self.absolute:
            return deviation
        return deviation / abs(self.reference) if self.reference else inf

    @property
    def passed(self) -> bool:
        return isfinite(self.value) and self.error <= self.tolerance


@dataclass(frozen=True)
class Problem:
    """A named problem of an area; ``solve`` returns its checks."""

    area: str
    name: str
    source: str
    solve: Callable[[], Sequence[Check]]


PROBLEMS: list[Problem] = []


def problem(area: str, name: str, source: str) -> Callable:
    """Register the decorated function, which takes nothing and returns checks."""

    def register(solve: Callable[[], Sequence[Check]]) -> Callable[[], Sequence[Check]]:
        PROBLEMS.append(Problem(area, name, source, solve))
        return solve

    return register


def problems(area: str | None = None) -> list[Problem]:
    """All problems, or those of one area, in their order of registration."""
    for name in AREAS if area is None else (area,):
        importlib.import_module(f"coupling.verify.{name}")
    return [p for p in PROBLEMS if area is None or p.area == area]
