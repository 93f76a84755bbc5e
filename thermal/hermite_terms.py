"""Terms of heat on members whose temperature is cubic between stations.

At a station live T and B = T + (L/3) dT/ds, with L the mean length of the member's elements: the
temperature that the tangent there reaches a third of an element on, as the control points of
Bézier do (Farin 2002, ch. 7). In T and B the shape functions of Hermite sum to one, so that heat,
powers and flows are sums over all entries of the state; and B is a temperature, in kelvin.

All integrals are by Gauss points, storage included (consistent); over the section they follow
``thermal.profiles``.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)
GAUSS, WEIGHTS = 0.5 * (1.0 + GAUSS), 0.5 * WEIGHTS  # of an element from 0 to 1; sum 1


class Cubic(NamedTuple):
    """Elements of members of one material and one number N of values.

    dofs : (e, 4, N) intp  T and B at the near station, T and B at the far one
    shape, slope : (e, q, 4) float [-], [1/m]  shape functions and d/ds at the q Gauss points
    volume : (e, q) float [m^3]  of a Gauss point and each of M points of the section
    values : (M, N) float  shape functions over the section
    across : (e, D) float [1/m^2]  one over the square of the scale of each coordinate
    turns : (D, M, N) float  derivatives of the shape functions over the section
    conductivities : (D,) Property  along the coordinates of the section
    """

    dofs: Indices
    shape: Array
    slope: Array
    volume: Array
    values: Array
    across: Array
    turns: Array
    conductivities: tuple[Property, ...]
    material: Material


def shapes(xi: Array, ratio: Array) -> tuple[Array, Array]:
    """Functions of T, B, T, B and d/dxi (e, q, 4) at ``xi`` (q,) from 0 to 1.

    ratio : (e,) float  length of the element over the mean length
    """
    x, r = xi, 3.0 * np.asarray(ratio, dtype=float)[:, None]
    near, far = 1.0 - 3.0 * x**2 + 2.0 * x**3, 3.0 * x**2 - 2.0 * x**3
    first, last = r * (x - 2.0 * x**2 + x**3), r * (x**3 - x**2)
    rise = 6.0 * (x - x**2)
    first_rise, last_rise = r * (1.0 - 4.0 * x + 3.0 * x**2), r * (3.0 * x**2 - 2.0 * x)
    return (
        np.stack([near - first, first, far - last, last], axis=-1),
        np.stack([-rise - first_rise, first_rise, rise - last_rise, last_rise], axis=-1),
    )


def add_heat(c: Cubic, T: Array, out: Array) -> None:
    """Stored heat [J], the share of each entry of the state."""
    h = c.material.density * c.material.enthalpy(temperatures(c, T, c.values))
    _give(c, c.volume[..., None] * h, c.shape, c.values, out)


def add_power(c: Cubic, T: Array, out: Array) -> None:
    """Power [W] conducted to each entry of the state."""
    at = temperatures(c, T, c.values)
    flux = c.volume[..., None] * c.material.conductivity(at) * _at(c.slope, T[c.dofs], c.values)
    _give(c, -flux, c.slope, c.values, out)
    for d, k in enumerate(c.conductivities):
        area = (c.across[:, d, None] * c.volume)[..., None]
        flux = area * k(at) * temperatures(c, T, c.turns[d])
        _give(c, -flux, c.shape, c.turns[d], out)


def blocks(c: Cubic, T: Array, tau: float) -> Array:
    """(e, 4 N, 4 N)  derivative of heat minus ``tau`` times power."""
    at, volume = temperatures(c, T, c.values), c.volume[..., None]
    k, stored = c.material.conductivity, c.material.density * c.material.heat_capacity(at)
    found = _block(volume * stored, c.shape, c.shape, c.values, c.values)
    found += _block(tau * volume * k(at), c.slope, c.slope, c.values, c.values)
    if not k.is_constant:
        bend = tau * volume * k.derivative(at) * _at(c.slope, T[c.dofs], c.values)
        found += _block(bend, c.slope, c.shape, c.values, c.values)
    for d, law in enumerate(c.conductivities):
        area = tau * (c.across[:, d, None] * c.volume)[..., None]
        found += _block(area * law(at), c.shape, c.shape, c.turns[d], c.turns[d])
        if not law.is_constant:
            bend = area * law.derivative(at) * temperatures(c, T, c.turns[d])
            found += _block(bend, c.shape, c.shape, c.turns[d], c.values)
    return found


def temperatures(c: Cubic, T: Array, values: Array) -> Array:
    """(e, q, M)  by functions (M, N) over the section at the Gauss points."""
    return _at(c.shape, T[c.dofs], values)


def _at(along: Array, own: Array, values: Array) -> Array:
    return along @ (own @ values.T)


def _give(c: Cubic, given: Array, along: Array, values: Array, out: Array) -> None:
    """Share (e, q, M) out by functions along and over the section."""
    np.add.at(out, c.dofs, along.transpose(0, 2, 1) @ given @ values)


def _block(weight: Array, rows: Array, columns: Array, over: Array, under: Array) -> Array:
    """(e, 4 N, 4 N) of weights (e, q, M), functions along (e, q, 4) and over the section (M, N)."""
    e, n = len(weight), over.shape[1]
    products = (rows[..., :, None] * columns[..., None, :]).reshape(e, -1, 16)
    lengthwise = sum(
        p[..., None] * w[:, None]
        for p, w in zip(products.swapaxes(0, 1), weight.swapaxes(0, 1), strict=True)
    )  # (e, 16, M)
    whole = lengthwise @ (over[:, :, None] * under[:, None, :]).reshape(len(over), -1)
    return whole.reshape(e, 4, 4, n, n).transpose(0, 1, 3, 2, 4).reshape(e, 4 * n, 4 * n)
