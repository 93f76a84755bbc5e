"""Finite element terms of heat on lines: what a group of members stores and conducts.

Temperatures between the N values of a station come from the shape functions C of its section
(``thermal.profiles``) at M points. Storage and conduction across the section are summed at the
stations (trapezoidal rule along the member, "mass lumping", Thomée 2006, ch. 15), so that a
station is never cooled by heating its neighbour; conduction along takes Gauss points.

Heat or power is added into an array over all temperatures; tangents are blocks between stations.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Crossing(NamedTuple):
    """Conduction across the sections along one coordinate.

    factor : (n,) float [m]  volume of a station and a point over the square of the scale
    slopes : (M, N) float  dC of the coordinate
    """

    factor: Array
    slopes: Array
    conductivity: Property


class Chain(NamedTuple):
    """Stations of members of one material and one number of values, and elements between them.

    dofs : (n, N) intp  of each station
    near : (e,) intp  stations at the start of each element; its end is the next
    mass : (n,) float [kg]  of a station, at each of the M points
    shape : (2, e, q) float  linear shape functions at the q Gauss points
    factor : (e, q) float [m]  area / M * weight * slope^2
    values : (M, N) float  C
    """

    dofs: Indices
    near: Indices
    mass: Array
    shape: Array
    factor: Array
    values: Array
    crossings: tuple[Crossing, ...]
    material: Material


def add_heat(c: Chain, T: Array, out: Array) -> None:
    """Stored heat [J], the share of each value."""
    h = c.material.enthalpy(T[c.dofs] @ c.values.T)
    out[c.dofs] += (c.mass[:, None] * h) @ c.values


def add_power(c: Chain, T: Array, out: Array) -> None:
    """Power [W] conducted to each value."""
    own = T[c.dofs]
    at = own @ c.values.T
    k, jump, _ = _along(c, at)
    flow = k * jump
    power = np.zeros_like(at)
    power[c.near] += flow
    power[c.near + 1] -= flow
    total = power @ c.values
    for cross in c.crossings:
        flux = cross.factor[:, None] * cross.conductivity(at) * (own @ cross.slopes.T)
        total -= flux @ cross.slopes
    out[c.dofs] += total


def entries(c: Chain) -> tuple[Indices, Indices]:
    """Rows and columns of ``tangent``: stations, then elements near to far and far to near."""
    near, far = c.dofs[c.near], c.dofs[c.near + 1]
    pairs = [_pairs(c.dofs, c.dofs), _pairs(near, far), _pairs(far, near)]
    rows, columns = zip(*pairs, strict=True)
    return np.concatenate(rows), np.concatenate(columns)


def count(c: Chain) -> int:
    """Entries of ``tangent``."""
    return (len(c.dofs) + 2 * len(c.near)) * c.dofs.shape[1] ** 2


def tangent(c: Chain, T: Array, tau: float, out: Array) -> None:
    """Write the entries of the derivative of heat minus ``tau`` times power to ``out``."""
    own = T[c.dofs]
    at = own @ c.values.T
    by_near, by_far = _along_slopes(c, at, tau)
    stations = c.mass[:, None] * c.material.heat_capacity(at)
    stations[c.near] -= by_near
    stations[c.near + 1] += by_far
    squared = _products(c.values, c.values)
    weights, products = [stations], [squared]
    for cross in c.crossings:
        more = _crossing_slopes(cross, c.values, own, at, tau)
        weights += [weight for weight, _ in more]
        products += [product for _, product in more]
    last = squared.shape[1] * np.cumsum([len(c.dofs), len(c.near), len(c.near)])
    blocks = [x.reshape(-1, squared.shape[1]) for x in np.split(out, last[:2])]
    np.matmul(np.hstack(weights), np.vstack(products), out=blocks[0])
    np.matmul(-by_far, squared, out=blocks[1])
    np.matmul(by_near, squared, out=blocks[2])


def _along_slopes(c: Chain, at: Array, tau: float) -> tuple[Array, Array]:
    """(e, M) [J/K]  tau times derivatives of the flow from far to near, by near and by far."""
    k, jump, between = _along(c, at)
    by_near, by_far = -tau * k, tau * k
    if not c.material.conductivity.is_constant:
        dk = c.material.conductivity.derivative(between) * (tau * jump)
        by_near += _at_gauss(c.factor * c.shape[0], dk)
        by_far += _at_gauss(c.factor * c.shape[1], dk)
    return by_near, by_far


def _crossing_slopes(
    cross: Crossing, values: Array, own: Array, at: Array, tau: float
) -> list[tuple[Array, Array]]:
    """Minus the derivative of the power conducted across: weights (n, M), products (M, N N)."""
    k, slopes, factor = cross.conductivity, cross.slopes, tau * cross.factor[:, None]
    found = [(factor * k(at), _products(slopes, slopes))]
    if not k.is_constant:
        flux = factor * k.derivative(at) * (own @ slopes.T)
        found.append((flux, _products(slopes, values)))
    return found


def _products(rows: Array, columns: Array) -> Array:
    """(M, N N)"""
    return (rows[:, :, None] * columns[:, None, :]).reshape(len(rows), -1)


def _along(c: Chain, at: Array) -> tuple[Array, Array, Array]:
    """Conductance (e, M) [W/K], far minus near (e, M), temperatures (q, e, M) at Gauss points."""
    near, far = at[c.near], at[c.near + 1]
    between = c.shape[0].T[..., None] * near + c.shape[1].T[..., None] * far
    return _at_gauss(c.factor, c.material.conductivity(between)), far - near, between


def _at_gauss(weight: Array, values: Array) -> Array:
    """(e, M)  sum over Gauss points of weight (e, q) times values (q, e, M)."""
    return sum(w[:, None] * v for w, v in zip(weight.T, values, strict=True))


def _pairs(rows: Indices, columns: Indices) -> tuple[Indices, Indices]:
    shape = (*rows.shape, columns.shape[1])
    return (
        np.broadcast_to(rows[:, :, None], shape).ravel(),
        np.broadcast_to(columns[:, None, :], shape).ravel(),
    )
