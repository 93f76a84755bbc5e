"""Material properties as functions of temperature, with exact derivatives and integrals.

Every property is a piecewise polynomial of the temperature T [K], whatever it was made from: a
polynomial, a table, a fit. Its derivative and its antiderivative are then exact, so that a
thermal strain agrees with the expansion coefficient and an enthalpy with the heat capacity to
round-off. Outside its range a property keeps its end value.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf, isfinite
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]

ZERO_CELSIUS = 273.15  # [K]
ENTHALPY_DATUM = 298.15  # [K] where the enthalpy of every material is zero


class Curve(NamedTuple):
    """A piecewise polynomial with its derivative and antiderivative.

    knots : (m - 1,) float [K]  where one piece ends and the next begins
    origins : (m,) float [K]  each piece is a polynomial in T - origin
    value, slope, primitive : (m, degree + 1) float  coefficients, constant term first
    """

    knots: Array
    origins: Array
    value: Array
    slope: Array
    primitive: Array


@dataclass(frozen=True, eq=False)
class Property:
    """A property as a function of temperature.

    Attributes
    ----------
    name, unit, source : str
    lower, upper : float [K]  range of the data; outside it the end value is kept
    curve : Curve
    """

    name: str
    unit: str
    lower: float
    upper: float
    source: str
    curve: Curve = field(repr=False)

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same at all temperatures."""
        return self.curve.slope.size == 0 or not self.curve.slope.any()

    @overload
    def __call__(self, T: float) -> float: ...
    @overload
    def __call__(self, T: Array) -> Array: ...
    def __call__(self, T):
        """Value at T [K], a number or an array of any shape."""
        return _evaluate(self.curve, self.curve.value, T)

    @overload
    def derivative(self, T: float) -> float: ...
    @overload
    def derivative(self, T: Array) -> Array: ...
    def derivative(self, T):
        """Derivative with respect to temperature at T [K]."""
        return _evaluate(self.curve, self.curve.slope, T)

    def integral(self, T0, T):
        """Exact integral of the value from T0 to T [K], numbers or arrays."""
        primitive = self.curve.primitive
        return _evaluate(self.curve, primitive, T) - _evaluate(self.curve, primitive, T0)


@dataclass(frozen=True, eq=False)
class Material:
    """A linear elastic, isotropic, conducting material.

    Attributes
    ----------
    density : float [kg/m^3]  of the reference configuration; mass does not change with T
    youngs_modulus [Pa], poissons_ratio [1], conductivity [W/(m K)], heat_capacity [J/(kg K)],
    expansion [1/K] : Property  the expansion coefficient is the instantaneous one
    """

    name: str
    density: float
    youngs_modulus: Property
    poissons_ratio: Property
    expansion: Property
    conductivity: Property
    heat_capacity: Property

    def __post_init__(self) -> None:
        problems = _material_problems(self)
        if problems:
            raise ValueError(f"material {self.name}: " + "; ".join(problems))

    @property
    def properties(self) -> tuple[Property, ...]:
        """The five properties that depend on temperature."""
        return (
            self.youngs_modulus,
            self.poissons_ratio,
            self.expansion,
            self.conductivity,
            self.heat_capacity,
        )

    def shear_modulus(self, T):
        """G = E / (2 (1 + nu)) [Pa] at T [K]."""
        return 0.5 * self.youngs_modulus(T) / (1.0 + self.poissons_ratio(T))

    def thermal_strain(self, T, T_ref):
        """Free strain at T [K] of what has none at T_ref: the integral of the expansion."""
        return self.expansion.integral(T_ref, T)

    def enthalpy(self, T):
        """Integral of the heat capacity [J/kg] from ENTHALPY_DATUM to T [K]; it rises with T."""
        return self.heat_capacity.integral(ENTHALPY_DATUM, T)

    def range_problems(self, lower: float, upper: float) -> list[str]:
        """One sentence for each property whose data do not cover ``lower`` to ``upper`` [K]."""
        return [
            f"{p.name}: needed from {lower:g} K to {upper:g} K, its data {ends}"
            for p in self.properties
            for ends in _uncovered(p, lower, upper)
        ]


def _uncovered(p: Property, lower: float, upper: float) -> list[str]:
    ends = [f"begin at {p.lower:g} K"] if lower < p.lower else []
    return ends + ([f"end at {p.upper:g} K"] if upper > p.upper else [])


def _material_problems(material: Material) -> list[str]:
    """What makes a material impossible, looked for on a dense sample of each range."""
    problems = []
    if not (isfinite(material.density) and material.density > 0.0):
        problems.append(f"density must be positive and finite, got {material.density!r}")
    for p in (material.youngs_modulus, material.conductivity, material.heat_capacity):
        if not p(_sample(p)).min() > 0.0:
            problems.append(f"{p.name} must be positive in its whole range")
    nu = material.poissons_ratio(_sample(material.poissons_ratio))
    if not (nu.min() > -1.0 and nu.max() < 0.5):
        problems.append("poissons_ratio must stay between -1 and 0.5")
    return problems


def _sample(p: Property) -> Array:
    lower = p.lower if isfinite(p.lower) else 0.0
    upper = p.upper if isfinite(p.upper) else max(2000.0, lower)
    return np.union1d(np.linspace(lower, upper, 200), p.curve.knots)


def constant(name: str, unit: str, value: float, source: str = "given") -> Property:
    """The same value at all temperatures."""
    return polynomial(name, unit, [value], source=source)


def polynomial(
    name: str,
    unit: str,
    coefficients: Sequence[float],
    reference: float = 0.0,
    lower: float = -inf,
    upper: float = inf,
    source: str = "given",
) -> Property:
    """Sum of ``coefficients[i] * (T - reference)**i`` between ``lower`` and ``upper`` [K]."""
    c = np.atleast_2d(np.asarray(coefficients, dtype=float))
    return _property(name, unit, lower, upper, source, np.empty(0), np.array([reference]), c)


def table(
    name: str,
    unit: str,
    temperatures: ArrayLike,
    values: ArrayLike,
    source: str = "given",
    smooth: bool = False,
) -> Property:
    """Interpolation of ``values`` at ``temperatures`` [K].

    Straight lines, or with ``smooth`` the monotone cubic of Fritsch & Carlson (1980) with the
    slopes of Fritsch & Butland (1984), which has a continuous derivative and never overshoots.
    """
    T, y = np.array(temperatures, dtype=float), np.array(values, dtype=float)
    if T.ndim != 1 or T.shape != y.shape or T.size < 2:
        raise ValueError(f"{name}: a table needs two or more temperatures and as many values")
    if not (np.isfinite(T).all() and (np.diff(T) > 0.0).all()):
        raise ValueError(f"{name}: the temperatures of a table must be finite and increase")
    if smooth:
        c = PchipInterpolator(T, y).c[::-1].T
    else:
        c = np.column_stack([y[:-1], np.diff(y) / np.diff(T)])
    return _property(name, unit, T[0], T[-1], source, T[1:-1], T[:-1], c)


def hermite(
    name: str,
    unit: str,
    temperatures: ArrayLike,
    values: ArrayLike,
    slopes: ArrayLike,
    source: str = "given",
) -> Property:
    """Piecewise cubic with given ``values`` and ``slopes`` at ``temperatures`` [K]."""
    T, y, s = (np.array(a, dtype=float) for a in (temperatures, values, slopes))
    h = np.diff(T)
    secant = np.diff(y) / h
    c = np.column_stack(
        [
            y[:-1],
            s[:-1],
            (3.0 * secant - 2.0 * s[:-1] - s[1:]) / h,
            (s[:-1] + s[1:] - 2.0 * secant) / h**2,
        ]
    )
    return _property(name, unit, T[0], T[-1], source, T[1:-1], T[:-1], c)


def constant_material(
    name: str,
    density: float,
    youngs_modulus: float,
    poissons_ratio: float,
    expansion: float,
    conductivity: float,
    heat_capacity: float,
) -> Material:
    """A material whose properties do not depend on temperature (SI units)."""
    return Material(
        name,
        density,
        constant("youngs_modulus", "Pa", youngs_modulus),
        constant("poissons_ratio", "1", poissons_ratio),
        constant("expansion", "1/K", expansion),
        constant("conductivity", "W/(m K)", conductivity),
        constant("heat_capacity", "J/(kg K)", heat_capacity),
    )


@lru_cache(maxsize=None)
def library_material(name: str) -> Material:
    """A material of the library by name; see ``meshes.library`` for data and sources."""
    builders = library()
    if name not in builders:
        raise ValueError(f"no material '{name}' in the library; it has {', '.join(builders)}")
    return builders[name]()


def library() -> dict[str, Callable[[], Material]]:
    """Names of the library's materials and what builds each."""
    from meshes.library import BUILDERS

    return BUILDERS


def _property(
    name: str,
    unit: str,
    lower: float,
    upper: float,
    source: str,
    knots: Array,
    origins: Array,
    coefficients: Array,
) -> Property:
    if not np.isfinite(coefficients).all():
        raise ValueError(f"{name}: the data must be finite numbers")
    if not lower < upper:
        raise ValueError(f"{name}: its range must have lower < upper, got {lower!r} and {upper!r}")
    curve = _held(knots, origins, coefficients, lower, upper)
    return Property(name, unit, float(lower), float(upper), source, curve)


def _held(knots: Array, origins: Array, c: Array, lower: float, upper: float) -> Curve:
    """Curve with a constant piece beyond each finite end of the range."""
    bare = Curve(knots, origins, c, c, c)
    for end, place in ((lower, 0), (upper, None)):
        if isfinite(end):
            piece = np.zeros((1, c.shape[1]))
            piece[0, 0] = _evaluate(bare, bare.value, end)
            at = (0, 0, 0) if place == 0 else (len(knots), len(origins), len(c))
            knots = np.insert(knots, at[0], end)
            origins = np.insert(origins, at[1], end)
            c = np.insert(c, at[2], piece, axis=0)
    return _curve(knots, origins, c)


def _curve(knots: Array, origins: Array, c: Array) -> Curve:
    powers = np.arange(1, c.shape[1] + 1)
    slope = c[:, 1:] * powers[:-1] if c.shape[1] > 1 else np.zeros((len(c), 1))
    primitive = np.hstack([np.zeros((len(c), 1)), c / powers])
    for i, T in enumerate(knots):  # each piece starts where the one before it ends
        jump = _horner(primitive[i], T - origins[i]) - _horner(primitive[i + 1], T - origins[i + 1])
        primitive[i + 1, 0] += jump
    curve = Curve(knots, origins, np.ascontiguousarray(c), np.ascontiguousarray(slope), primitive)
    primitive[:, 0] -= _evaluate(curve, primitive, ENTHALPY_DATUM)
    return curve


def _evaluate(curve: Curve, coefficients: Array, T):
    if len(coefficients) == 1:
        return _horner(coefficients[0], np.asarray(T) - curve.origins[0])
    T = np.asarray(T)
    piece = np.searchsorted(curve.knots, T, side="right")
    return _horner(coefficients[piece], T - curve.origins[piece])


def _horner(c: Array, x):
    """Polynomial with coefficients c (..., degree + 1) at x (...), always of the shape of x."""
    y = c[..., -1] + 0.0 * x
    for i in range(c.shape[-1] - 2, -1, -1):
        y = y * x + c[..., i]
    return y
