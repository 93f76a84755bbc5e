"""Lumps: parts with one temperature each."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from thermal.description import DEFAULT, Description, Place, Settings, Side
from thermal.discretisation import Block, Face, GivenTemperatures, Mean, facing_loads
from thermal.layout import given, layout

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class LumpSpace:
    """The parts of a description; see ``thermal.discretisation``."""

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        self._parts = list(description.parts)
        self.x, self.regions, self.start = layout(description)
        self.given: Sequence[GivenTemperatures] = given(description, self.regions, self.x)

    def face(self, side: Side) -> Face:
        """The area of a part; as a lump has no shape, its normal is zero."""
        (node,) = self.regions[side.thing]
        area = self._parts[node].area
        return [
            Block(
                np.array([[node]]), np.ones((1, 1)), np.array([[area]]),
                self.x[node].reshape(1, 1, 3), np.zeros((1, 1, 3)), np.empty((1, 0, 3)),
            )
        ]  # fmt: skip

    irradiated = face

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        return facing_loads(self.face(side), direction, len(self.x))

    def place(self, place: Place) -> Mean:
        """A part."""
        return Mean(self.regions[place.name], np.ones(1))

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored."""
        return np.array(
            [p.mass * p.material.enthalpy(t) for p, t in zip(self._parts, T, strict=True)]
        )

    def power(self, T: Array) -> Array:
        """Nothing is conducted within a lump."""
        return np.zeros_like(T)

    def entries(self) -> tuple[Indices, Indices]:
        """The diagonal."""
        every = np.arange(len(self.x))
        return every, every

    def tangent(self, T: Array, tau: float) -> Array:
        """(n,) [J/K]"""
        pairs = zip(self._parts, T, strict=True)
        return np.array([p.mass * p.material.heat_capacity(t) for p, t in pairs], dtype=float)

    def unusable(self, T: Array) -> str:
        """Which lump has left the range of its heat capacity, or ""."""
        for part, t in zip(self._parts, T, strict=True):
            p = part.material.heat_capacity
            if not p.lower * (1.0 - 1e-9) <= t <= p.upper * (1.0 + 1e-9):
                return (
                    f"'{part.name}' left the range of {p.name} "
                    f"({p.lower:g} K to {p.upper:g} K) with {t:g} K"
                )
        return ""
