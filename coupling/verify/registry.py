"""The list of verification problems; each area is one or more modules that register their own."""

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
from numpy.typing import ArrayLike

GROUPS = {
    "mechanics": (
        "beams", "elements", "dynamics", "multibody", "flexible", "shells", "thick_shells",
        "stability",
    ),
}  # fmt: skip
"""Names under which several areas are solved."""
AREAS = (*GROUPS["mechanics"], "continuum", "contact", "heat", "thermoelastic", "coupling")
MODULES = {
    "heat": ("heat", "manufactured", "exchange", "environment", "shock", "thermoelastic_heat"),
    "coupling": ("coupled", "seizure", "flutter"),
    "contact": ("restitution", "impacts", "play", "friction", "slider_crank"),
}
"""Modules of the areas that are not one of the same name."""


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
class Convergence:
    """Errors on finer and finer meshes or steps, whose order must be that of the theory.

    sizes : (k,) from coarse to fine, k >= 3: numbers of elements (growing) or steps (falling)
    errors : (k,) against an answer known otherwise, all positive; rows at round-off left out
    theory : order p of error ~ steps^p, or ~ elements^-p
    tolerance : largest deviation of the observed order from it, to either side
    unit : of the sizes

    Examples
    --------
    >>> rows = Convergence("tip", (4, 8, 16), (1.6e-2, 1e-3, 6.3e-5), 4.0, 0.2)
    >>> round(rows.order, 2), rows.passed
    (3.99, True)
    >>> Convergence("HHT", (0.02, 0.01, 0.005), (4e-3, 1e-3, 2.5e-4), 2.0, 0.1, "s").passed
    True
    """

    name: str
    sizes: Sequence[float]
    errors: Sequence[float]
    theory: float
    tolerance: float
    unit: str = "elements"

    @property
    def order(self) -> float:
        """Slope of all rows, log error against log size, least squares."""
        sizes, errors = np.asarray(self.sizes, float), np.asarray(self.errors, float)
        if len(sizes) < 3 or not np.all(np.isfinite(errors) & (errors > 0.0)):
            return -inf
        slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
        return float(-slope if sizes[-1] > sizes[0] else slope)

    @property
    def orders(self) -> list[float]:
        """Order from each row to the next, (k - 1,)."""
        with np.errstate(all="ignore"):
            finer = np.abs(np.diff(np.log(np.asarray(self.sizes, float))))
            return list(-np.diff(np.log(np.asarray(self.errors, float))) / finer)

    @property
    def passed(self) -> bool:
        return isfinite(self.order) and abs(self.order - self.theory) <= self.tolerance


@dataclass(frozen=True)
class Grid:
    """A table of one quantity over two parameters, against references.

    columns : (c,) headings
    rows : (r,) names
    values, references : (r, c)
    tolerance : of each value, absolute

    Examples
    --------
    >>> grid = Grid("rebound", ("1 m/s", "2 m/s"), ("steel",), [[0.5, 0.501]], [[0.5, 0.5]], 1e-2)
    >>> grid.passed, [round(error, 6) for error in grid.errors]
    (True, [0.001])
    """

    name: str
    columns: Sequence[str]
    rows: Sequence[str]
    values: ArrayLike
    references: ArrayLike
    tolerance: float

    @property
    def errors(self) -> list[float]:
        """Largest deviation of each row; infinite where a value is no number."""
        deviation = np.abs(np.asarray(self.values, float) - np.asarray(self.references, float))
        return [float(worst) for worst in np.where(np.isfinite(deviation), deviation, inf).max(1)]

    @property
    def passed(self) -> bool:
        return all(error <= self.tolerance for error in self.errors)


Result = Check | Convergence | Grid


@dataclass(frozen=True)
class Problem:
    """A named problem of an area; ``solve`` returns its checks and convergence tables."""

    area: str
    name: str
    source: str
    solve: Callable[[], Sequence[Result]]


PROBLEMS: list[Problem] = []


def problem(area: str, name: str, source: str) -> Callable:
    """Register the decorated function, which takes nothing and returns results."""

    def register(solve: Callable[[], Sequence[Result]]) -> Callable[[], Sequence[Result]]:
        PROBLEMS.append(Problem(area, name, source, solve))
        return solve

    return register


def problems(area: str | None = None) -> list[Problem]:
    """All problems, or those of an area or a group of areas, in their order of registration."""
    areas = AREAS if area is None else GROUPS.get(area, (area,))
    for name in areas:
        for module in MODULES.get(name, (name,)):
            importlib.import_module(f"coupling.verify.{module}")
    return [p for p in PROBLEMS if p.area in areas]
