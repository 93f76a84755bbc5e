"""Finite element terms of heat on lines: what each stores or conducts, and its tangent.

A term holds arrays made when the model is built. Temperatures between the N wall points of a
station come from the cardinal functions C of ``thermal.circumference`` at M angles. Storage,
exchange over the surface and conduction round the circumference are summed at the stations
(trapezoidal rule along the member, "mass lumping", Thomée 2006, ch. 15), so that a station is
never cooled by heating its neighbour; conduction along the member takes Gauss points.

Each term has ``dofs`` (n, k) intp and functions of the temperatures: heat or power is added into
an array over all temperatures, tangents are returned as blocks (n, k, k).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property
from thermal.discretisation import weighted

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Storage(NamedTuple):
    """Heat capacity at stations of members, or of lumps (one wall point, one angle).

    dofs : (n, N) intp
    mass : (n,) float [kg]  at each of the M angles
    values : (M, N) float  C
    properties : those whose range the temperatures must keep to
    """

    dofs: Indices
    mass: Array
    values: Array
    material: Material
    properties: tuple[Property, ...]


class Around(NamedTuple):
    """Conduction round the circumference of tubes.

    dofs : (n, N) intp
    factor : (n,) float [m]  wall cross-section belonging to a station and an angle, over R^2,
        times the circumference's share of that angle
    values, slopes : (M, N) float  C and dC/dphi
    """

    dofs: Indices
    factor: Array
    values: Array
    slopes: Array
    material: Material


class Along(NamedTuple):
    """Conduction between neighbouring stations, linear elements.

    dofs : (n, 2N) intp  near station, far station
    shape : (2, n, q) float  linear shape functions at the q Gauss points
    factor : (n, q) float [m]  area / M * weight * slope^2
    values : (M, N) float  C
    """

    dofs: Indices
    shape: Array
    factor: Array
    values: Array
    material: Material


def blend(T: Array, dofs: Indices, values: Array) -> Array:
    """(n, M) [K]  temperatures at the angles of each station."""
    return T[dofs] @ values.T


def add_heat(s: Storage, T: Array, out: Array) -> None:
    """Stored heat [J], each wall point's share."""
    h = s.material.enthalpy(blend(T, s.dofs, s.values))
    out[s.dofs] += (s.mass[:, None] * h) @ s.values


def capacity_blocks(s: Storage, T: Array) -> Array:
    """(n, N, N) [J/K]  derivative of the stored heat."""
    c = s.material.heat_capacity(blend(T, s.dofs, s.values))
    return weighted(s.mass[:, None] * c, s.values, s.values)


def add_around(a: Around, T: Array, out: Array) -> None:
    """Power [W] conducted to each wall point round the circumference."""
    k = a.material.conductivity(blend(T, a.dofs, a.values))
    out[a.dofs] -= (a.factor[:, None] * k * blend(T, a.dofs, a.slopes)) @ a.slopes


def around_blocks(a: Around, T: Array) -> Array:
    """(n, N, N) [W/K]  minus the derivative of the power."""
    conductivity = a.material.conductivity
    at = blend(T, a.dofs, a.values)
    k = a.factor[:, None] * conductivity(at)
    blocks = weighted(k, a.slopes, a.slopes)
    if not conductivity.is_constant:
        dk = a.factor[:, None] * conductivity.derivative(at) * blend(T, a.dofs, a.slopes)
        blocks += weighted(dk, a.slopes, a.values)
    return blocks


def add_along(a: Along, T: Array, out: Array) -> None:
    """Power [W] conducted to each wall point along the member."""
    n = a.values.shape[1]
    near, far, between = _along_temperatures(a, T)
    k = a.material.conductivity(between)
    power = (np.einsum("eq,eqm->em", a.factor, k) * (far - near)) @ a.values
    out[a.dofs[:, :n]] += power
    out[a.dofs[:, n:]] -= power


def along_blocks(a: Along, T: Array) -> Array:
    """(n, 2N, 2N) [W/K]  minus the derivative of the power."""
    conductivity = a.material.conductivity
    near, far, between = _along_temperatures(a, T)
    k = np.einsum("eq,eqm->em", a.factor, conductivity(between))
    by_near, by_far = -k, k
    if not conductivity.is_constant:
        dk = conductivity.derivative(between) * (far - near)[:, None, :]
        by_near = by_near + np.einsum("eq,eqm->em", a.factor * a.shape[0], dk)
        by_far = by_far + np.einsum("eq,eqm->em", a.factor * a.shape[1], dk)
    row = np.concatenate([weighted(d, a.values, a.values) for d in (by_near, by_far)], axis=2)
    return np.concatenate([-row, row], axis=1)


def _along_temperatures(a: Along, T: Array) -> tuple[Array, Array, Array]:
    """At the angles of the near and far stations (n, M) and at the Gauss points (n, q, M)."""
    n = a.values.shape[1]
    near, far = blend(T, a.dofs[:, :n], a.values), blend(T, a.dofs[:, n:], a.values)
    between = a.shape[0][..., None] * near[:, None] + a.shape[1][..., None] * far[:, None]
    return near, far, between
