"""Numbers with units: read as written, returned in SI units and kelvin.

A plain number is already in SI units. A string is a number with a unit; only then is pint
imported. Angles are kept apart from plain numbers, and temperatures from their differences.
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import Any

from coupling.errors import shown, suggestion


@dataclass(frozen=True)
class Kind:
    """What a number measures.

    name : with its article, as used in messages
    unit : its SI unit; "" for a plain number
    example : how one may write it
    absolute : a temperature on its scale, to which degC and degF apply with their offsets
    """

    name: str
    unit: str
    example: str
    absolute: bool = False


NUMBER = Kind("a number", "", "0.85")
LENGTH = Kind("a length", "m", "25 mm")
TIME = Kind("a time", "s", "0.1 s")
MASS = Kind("a mass", "kg", "1.5 kg")
TEMPERATURE = Kind("a temperature", "K", "25 degC", absolute=True)
DIFFERENCE = Kind("a temperature difference", "K", "20 K")
TEMPERATURE_RATE = Kind("a temperature rate", "K/s", "15 K/s")
ANGLE = Kind("an angle", "rad", "45 deg")
ANGULAR_SPEED = Kind("an angular speed", "rad/s", "0.08 deg/s")
FREQUENCY = Kind("a frequency", "Hz", "2 Hz")
RATE = Kind("a rate", "1/s", "100 1/s")
SPEED = Kind("a speed", "m/s", "0.1 m/s")
PER_SPEED = Kind("an inverse speed", "s/m", "0.4 s/m")
ACCELERATION = Kind("an acceleration", "m/s^2", "-9.81 m/s^2")
FORCE = Kind("a force", "N", "10 N")
FORCE_RATE = Kind("a force rate", "N/s", "1 N/s")
MOMENT = Kind("a moment", "N m", "10 N m")
MOMENT_RATE = Kind("a moment rate", "N m/s", "1 N m/s")
AREA = Kind("an area", "m^2", "5 cm^2")
SECOND_MOMENT = Kind("a second moment of area", "m^4", "12 cm^4")
DENSITY = Kind("a density", "kg/m^3", "2700 kg/m^3")
PRESSURE = Kind("a modulus", "Pa", "69 GPa")
STRESS = Kind("a pressure", "Pa", "100 Pa")
STRESS_RATE = Kind("a pressure rate", "Pa/s", "1 kPa/s")
PER_KELVIN = Kind("a number per kelvin", "1/K", "23.1e-6 1/K")
CONDUCTIVITY = Kind("a conductivity", "W/m/K", "167 W/m/K")
HEAT_CAPACITY = Kind("a heat capacity", "J/kg/K", "896 J/kg/K")
HEAT_FLUX = Kind("a heat flux", "W/m^2", "1361 W/m^2")
HEAT_FLUX_RATE = Kind("a heat flux rate", "W/m^2/s", "10 W/m^2/s")
POWER = Kind("a power", "W", "5 W")
POWER_RATE = Kind("a power rate", "W/s", "1 W/s")
CONDUCTANCE = Kind("a conductance", "W/K", "2 W/K")
FILM = Kind("a heat transfer coefficient", "W/m^2/K", "10 W/m^2/K")
FILM_RATE = Kind("a rate of a heat transfer coefficient", "W/m^2/K/s", "1 W/m^2/K/s")
SURFACE_STIFFNESS = Kind("a stiffness per area", "N/m^3", "1e13 N/m^3")
HERTZ_STIFFNESS = Kind("a Hertz stiffness", "N/m^1.5", "5e9 N/m^1.5")
STIFFNESS = Kind("a stiffness", "N/m", "1e6 N/m")
DAMPING = Kind("a damping", "N s/m", "5 N s/m")
TURN_STIFFNESS = Kind("a torsional stiffness", "N m/rad", "10 N m/rad")
TURN_DAMPING = Kind("a torsional damping", "N m s/rad", "0.1 N m s/rad")
IMPULSE = Kind("an impulse", "N s", "10 N s")
LINE_LOAD = Kind("a line load", "N/m", "5 N/m")
LINE_LOAD_RATE = Kind("a rate of a line load", "N/m/s", "1 N/m/s")
INERTIA = Kind("a moment of inertia", "kg m^2", "0.2 kg m^2")
_KINDS = [kind for kind in tuple(globals().values()) if isinstance(kind, Kind) and kind.unit]

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
# names and small powers only: nothing that takes pint long to work out
_UNIT = re.compile(r"[^\W\d]*(?:(?:\*\*|\^)-?\d{1,2}(?:\.\d+)?|[^\W\d]+|[\s*/·()°%]|1(?=\s*/))*")
_POWERS = re.compile(r"(\)|[\d.])\s*(\*\*|\^)")
_DIGIT = re.compile(r"(?<=[^\W\d_])(?=\d)")
_ANGLES = ("radian", "degree", "turn", "arcminute", "arcsecond", "revolutions_per_minute", "grade")
_MEANT = {
    "C": "degC",
    "deg C": "degC",
    "° C": "degC",
    "oC": "degC",
    "Celsius": "degC",
    "F": "degF",
    "deg F": "degF",
    "Fahrenheit": "degF",
    "k": "K",
    "deg K": "K",
    "degK": "K",
    "Nm": "N m",
    "sec": "s",
    "MPA": "MPa",
    "Gpa": "GPa",
    "Mpa": "MPa",
}
_COMMON = (
    *("m", "mm", "cm", "um", "km", "meter", "inch", "ft", "s", "ms", "min", "h", "second"),
    *("minute", "hour", "kg", "g", "gram", "K", "degC", "degF", "kelvin", "rad", "deg"),
    *("rad/s", "deg/s", "rpm", "Hz", "N", "kN", "newton", "Pa", "kPa", "MPa", "GPa", "pascal"),
    *("J", "kJ", "W", "kW", "watt", "m/s", "mm/s"),
)

SMALLEST, LARGEST = 1e-30, 1e30
"""Beyond these, in SI units, squares and quotients of numbers would leave what a float holds."""


def read(value: Any, kind: Kind) -> float:
    """The number that ``value`` says, in the SI unit of ``kind``.

    Raises
    ------
    ValueError : with one sentence of what was expected and what was got
    """
    if isinstance(value, str) and kind.unit:
        number = _with_unit(value, kind)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        number = _plain(value)
    else:
        raise ValueError(f"expected {expected(kind)}, got {shown(value)}")
    if not isfinite(number):
        raise ValueError(f"expected {kind.name} that is finite, got {shown(value)}")
    if number and not SMALLEST < abs(number) < LARGEST:
        size = "large" if abs(number) > 1.0 else "small"
        raise ValueError(f"expected {kind.name} of sensible size, got {shown(value)}: too {size}")
    return number


def expected(kind: Kind) -> str:
    """How a number of this kind may be written."""
    if not kind.unit:
        return kind.name
    return f"{kind.name} such as '{kind.example}' (a plain number is in {kind.unit})"


def _plain(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf")


def _with_unit(text: str, kind: Kind) -> float:
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"expected {expected(kind)}, got {shown(text)}")
    if not match[2]:
        raise ValueError(f"{shown(text)} has no unit; write it as in '{kind.example}'")
    unit = _checked(match[2], kind)
    number = float(_registry().Quantity(float(match[1]), unit).m_as(kind.unit))
    # an offset costs digits: -200 degC is to be 73.15 K, not a last bit less
    return float(f"{number:.12g}") if kind.absolute else number


@lru_cache(maxsize=1024)
def _checked(text: str, kind: Kind):
    """The unit written as ``text``, which measures what ``kind`` measures."""
    unit = _parsed(text)
    target = _registry().parse_units(kind.unit)
    if unit.dimensionality != target.dimensionality or _angle(unit) != _angle(target):
        got = f"but '{text}' is the unit of {_meaning(unit)}"
        if text in _MEANT:
            got = f"but '{text}' means {unit}; did you mean '{_MEANT[text]}'?"
        raise ValueError(f"expected {expected(kind)}, {got}")
    if kind.absolute and str(unit).startswith("delta_"):
        raise ValueError(f"'{text}' is for differences; a temperature is written '{kind.example}'")
    if not kind.absolute and _registry().Quantity(0.0, unit).m_as(target) != 0.0:
        raise ValueError(f"'{text}' counts from a zero of its own; write it as '{kind.example}'")
    return unit


@lru_cache(maxsize=1)
def _registry():
    import pint

    return pint.UnitRegistry()


def _parsed(unit: str):
    """The unit as pint reads it; differences of temperature in products such as W/m/degC."""
    import pint

    wild = len(unit) > 60 or not _UNIT.fullmatch(unit) or _POWERS.search(unit)
    if not wild:
        try:
            return _registry().parse_units(unit)
        except (pint.errors.PintError, ValueError, TypeError, AssertionError, AttributeError):
            pass
    raise ValueError(f"unknown unit {shown(unit)}{_nearest(unit)}")


def _nearest(unit: str) -> str:
    if unit in _MEANT:
        return f"; did you mean '{_MEANT[unit]}'?"
    if _DIGIT.search(unit):
        return f"; did you mean '{_DIGIT.sub('^', unit)}'?"
    return suggestion(unit, _COMMON)


def _angle(unit: Any) -> float:
    """Power of the angle in a unit: pint takes angles for plain numbers, here they are not."""
    from pint.util import to_units_container

    powers: dict[str, Any] = dict(to_units_container(unit))
    return sum(power for name, power in powers.items() if name.endswith(_ANGLES))


def _meaning(unit) -> str:
    """What a unit measures, in words, or its dimensions."""
    for kind in _KINDS:
        other = _registry().parse_units(kind.unit)
        if other.dimensionality == unit.dimensionality and _angle(other) == _angle(unit):
            return kind.name
    return f"{unit.dimensionality}" if unit.dimensionality else "a plain number"
