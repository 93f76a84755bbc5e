"""Values between two that are written with their units: "10 um" to "0.1 mm", or plain numbers."""

import re
from functools import lru_cache
from math import exp, isfinite, log
from typing import Any, Literal, NamedTuple

from coupling.errors import shown

Written = float | str
"""A plain number in SI units, or a number with a unit."""
Course = Literal["linear", "logarithmic"]

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)


class Scale(NamedTuple):
    """From ``low`` to ``high`` in one unit, "" for plain numbers."""

    low: float
    high: float
    unit: str
    course: Course

    def number(self, place: float) -> float:
        """Value in the unit at a place from 0, low, to 1, high; beyond by the same law."""
        if self.course == "logarithmic":
            return exp(log(self.low) + place * (log(self.high) - log(self.low)))
        return self.low + place * (self.high - self.low)

    def written(self, place: float) -> Written:
        """The same as an entry of a case file, to twelve digits; the ends as they are."""
        ends = {0.0: self.low, 1.0: self.high}
        number = ends.get(place, float(f"{self.number(place):.12g}"))
        return f"{number!r} {self.unit}" if self.unit else number


def scale(low: Written, high: Written, course: Course) -> Scale:
    """What lies between two values.

    Raises
    ------
    ValueError : one of them is no number with a unit, the units do not fit, or logarithms do not
        exist
    """
    (a, unit), (b, other) = parts(low), parts(high)
    if bool(unit) != bool(other):
        raise ValueError(f"one of {shown(low)} and {shown(high)} has a unit, the other none")
    if unit != other:
        b = _converted(b, other, unit)
    if a == b:
        raise ValueError(f"low and high are the same, {shown(low)}")
    if course == "logarithmic" and min(a, b) <= 0.0:
        raise ValueError(f"scale = 'logarithmic' takes positive values, got {shown(min(a, b))}")
    return Scale(a, b, unit, course)


def parts(value: Written) -> tuple[float, str]:
    """Number and unit of a value. Raises ValueError where it is no number."""
    if isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value):
        return float(value), ""
    match = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    if match is None or not match[2]:
        raise ValueError(
            f"expected a number or one with a unit such as '10 um', got {shown(value)}"
        )
    return float(match[1]), match[2]


@lru_cache(maxsize=256)
def _converted(number: float, unit: str, target: str) -> float:
    import pint

    try:
        return float(f"{_registry().Quantity(number, unit).m_as(target):.12g}")
    except (pint.errors.PintError, ValueError, TypeError, AttributeError):
        raise ValueError(f"the units '{target}' and '{unit}' do not fit each other") from None


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()
