"""Functions of temperature with exact derivatives and integrals.

Every property is a piecewise polynomial of the temperature T [K], whatever it was made from: a
polynomial, a table, a fit. Its derivative and its antiderivative are then exact, so that a
thermal strain agrees with the expansion coefficient and an enthalpy with the heat capacity to
round-off. Outside its range a property keeps its end value.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, inf, isfinite, log
from typing import NamedTuple, overload

import numpy as np
from numpy.polynomial import polynomial as power_series
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]

DATUM = 298.15  # [K] where antiderivatives are zero


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
        return not self.curve.slope.any()

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
    c = np.atleast_2d(np.array(coefficients, dtype=float))
    if not (c.size and isfinite(reference)):
        raise ValueError(f"{name}: a polynomial needs coefficients and a finite reference")
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

    Straight lines, or with ``smooth`` the monotone cubic of Fritsch & Butland (1984) as in
    ``scipy.interpolate.PchipInterpolator``: continuous derivative, no overshoot.
    """
    T, y = np.array(temperatures, dtype=float), np.array(values, dtype=float)
    if T.ndim != 1 or T.shape != y.shape or T.size < 2:
        raise ValueError(f"{name}: a table needs two or more temperatures and as many values")
    if not (np.isfinite(T).all() and (np.diff(T) > 0.0).all()):
        raise ValueError(f"{name}: the temperatures of a table must be finite and increase")
    if not np.isfinite(y).all():
        raise ValueError(f"{name}: the values of a table must be finite")
    if smooth:
        c = PchipInterpolator(T, y).c[::-1].T
    else:
        c = np.column_stack([y[:-1], np.diff(y) / np.diff(T)])
    return _property(name, unit, T[0], T[-1], source, T[1:-1], T[:-1], c)


def log10_polynomial(
    name: str,
    unit: str,
    coefficients: Sequence[float],
    lower: float,
    upper: float,
    source: str = "given",
) -> Property:
    """10 to the power of a polynomial in log10 T, the form of the NIST cryogenic fits.

    Sampled with its exact slope at temperatures 1 % apart and joined by cubics, whose error
    is below 2e-8 of the value for the fits in the library.
    """
    T = np.geomspace(lower, upper, 2 + ceil(100.0 * log(upper / lower)))
    x = np.log10(T)
    y = 10.0 ** power_series.polyval(x, coefficients)
    slope = y * power_series.polyval(x, power_series.polyder(coefficients)) / T
    c = _hermite(T, np.asarray(y, dtype=np.float64), slope)
    return _property(name, unit, lower, upper, source, T[1:-1], T[:-1], c)


def joined(below: Property, above: Property, end: float, start: float) -> Property:
    """``below`` up to T = ``end``, ``above`` from ``start`` on, one cubic in between.

    The cubic takes over value and slope on both sides, so the derivative is continuous.
    """
    ends = np.array([end, start])
    values = np.array([below(end), above(start)])
    slopes = np.array([below.derivative(end), above.derivative(start)])
    first, last = below.curve, above.curve
    n = np.searchsorted(first.knots, end)  # whole pieces of the first below its end
    k = np.searchsorted(last.knots, start, side="right")
    parts = (first.value[: n + 1], _hermite(ends, values, slopes), last.value[k:])
    curve = _curve(
        np.concatenate([first.knots[:n], ends, last.knots[k:]]),
        np.concatenate([first.origins[: n + 1], [end], last.origins[k:]]),
        _stacked(parts),
    )
    source = f"to {end:g} K {below.source}; from {start:g} K {above.source}; a cubic in between"
    return Property(below.name, below.unit, below.lower, above.upper, source, curve)


def _hermite(T: Array, y: Array, slope: Array) -> Array:
    """Coefficients (m, 4) of the cubics with values y and slopes at the ends of m intervals."""
    h = np.diff(T)
    secant = np.diff(y) / h
    curvature = (3.0 * secant - 2.0 * slope[:-1] - slope[1:]) / h
    return np.column_stack(
        [y[:-1], slope[:-1], curvature, (slope[:-1] + slope[1:] - 2.0 * secant) / h**2]
    )


def _stacked(parts: Sequence[Array]) -> Array:
    width = max(c.shape[1] for c in parts)
    return np.vstack([np.pad(c, ((0, 0), (0, width - c.shape[1]))) for c in parts])


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
    curve = _held(_curve(knots, origins, coefficients), lower, upper)
    return Property(name, unit, float(lower), float(upper), source, curve)


def _held(curve: Curve, lower: float, upper: float) -> Curve:
    """The curve with a constant piece beyond each finite end of the range."""
    knots, origins, parts = [curve.knots], [curve.origins], [curve.value]
    for end, place in ((lower, 0), (upper, 3)):
        if isfinite(end):
            knots.insert(place, np.array([end]))
            origins.insert(place, np.array([end]))
            parts.insert(place, np.atleast_2d(_evaluate(curve, curve.value, end)))
    return _curve(np.concatenate(knots), np.concatenate(origins), _stacked(parts))


def _curve(knots: Array, origins: Array, c: Array) -> Curve:
    powers = np.arange(1, c.shape[1] + 1)
    slope = c[:, 1:] * powers[:-1] if c.shape[1] > 1 else np.zeros_like(c)
    primitive = np.hstack([np.zeros((len(c), 1)), c / powers])
    for i, T in enumerate(knots):  # each piece starts where the one before it ends
        jump = _horner(primitive[i], T - origins[i]) - _horner(primitive[i + 1], T - origins[i + 1])
        primitive[i + 1, 0] += jump
    curve = Curve(knots, origins, c, slope, primitive)
    primitive[:, 0] -= _evaluate(curve, primitive, DATUM)
    return curve


def _evaluate(curve: Curve, coefficients: Array, T):
    T = np.asarray(T, dtype=float)
    if len(coefficients) == 1:
        return _horner(coefficients[0], T - curve.origins[0])
    piece = curve.knots.searchsorted(T, side="right")
    return _horner(coefficients.take(piece, axis=0), T - curve.origins.take(piece))


def _horner(c: Array, x):
    """Polynomial with coefficients c (..., degree + 1) at x (...), always of the shape of x."""
    degree = c.shape[-1] - 1
    y = c[..., degree] if degree else c[..., 0] + 0.0 * x
    for i in range(degree - 1, -1, -1):
        y = y * x + c[..., i]
    return y
