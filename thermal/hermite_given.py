"""Prescribed temperatures of members with slopes: slopes are held where an element is."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.discretisation import GivenTemperatures

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

THIRDS = np.array([[-11.0, 18.0, -9.0, 2.0], [-2.0, 9.0, -18.0, 11.0]]) / 2.0
"""d/dxi at both ends of the cubic through values at 0, 1/3, 2/3 and 1."""


class Elements(NamedTuple):
    """Elements that one condition holds at both stations, one row for each of their values.

    near, far : (k,) intp  places in the list of the condition's temperatures
    slopes : (k, 2) intp  entries B of the state at both ends
    reach : (k,) float  a third of the mean length over the length of the element
    """

    near: Indices
    far: Indices
    slopes: Indices
    reach: Array


class Straight(NamedTuple):
    """Temperatures that are linear along what a condition holds."""

    own: GivenTemperatures
    held: Elements

    @property
    def name(self) -> str:
        return self.own.name

    @property
    def nodes(self) -> Indices:
        return np.concatenate([self.own.nodes, self.held.slopes.ravel()])

    def at(self, t: float) -> Array:
        """(k,) [K]"""
        T, (near, far, _, reach) = self.own.at(t), self.held
        rise = reach * (T[far] - T[near])
        return np.concatenate([T, np.stack([T[near] + rise, T[far] + rise], axis=1).ravel()])


class Curved(NamedTuple):
    """A field along elements: the cubic through its values at their ends and thirds.

    x : (4, k, 3) float [m]  ends and thirds
    """

    own: GivenTemperatures
    held: Elements
    x: Array
    field: Callable[[Array, float], Array]

    @property
    def name(self) -> str:
        return self.own.name

    @property
    def nodes(self) -> Indices:
        return np.concatenate([self.own.nodes, self.held.slopes.ravel()])

    def at(self, t: float) -> Array:
        """(k,) [K]"""
        T = self.own.at(t)
        values = self.field(self.x.reshape(-1, 3), t).reshape(4, -1)
        rise = self.held.reach * (THIRDS @ values)
        return np.concatenate([T, (values[[0, 3]] + rise).T.ravel()])


def curved(own: GivenTemperatures, held: Elements, x: Array, field: Callable) -> Curved:
    """From positions ``x`` (n, 3) of all temperatures."""
    near, far = x[own.nodes[held.near]], x[own.nodes[held.far]]
    return Curved(own, held, np.stack([near + i / 3.0 * (far - near) for i in range(4)]), field)
