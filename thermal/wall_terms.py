"""Heat stored at nodes and conducted between them, for ``thermal.wall``.

Conductivities are integrated: between two nodes flows c (U(T_b) - U(T_a)), where U is the integral
of k over T, as if U and not T were the combination of shape functions (product approximation,
Christie et al. 1981). It needs properties at the nodes alone, is exact for steady flow along one
line whatever k(T), and what leaves one node reaches the other to the last bit.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property
from meshes.properties import DATUM
from thermal.wall_elements import Bonds, joined

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Stored:
    """Heat capacity of one material, node by node.

    nodes : (k,) intp
    mass : (k,) float [kg]
    """

    def __init__(self, material: Material, nodes: Indices, mass: Array) -> None:
        self.material, self.nodes, self.mass = material, nodes, mass
        properties = (material.heat_capacity, *material.conductivities)
        self.properties = tuple(dict.fromkeys(properties))

    def heat(self, T: Array) -> Array:
        """(k,) [J]"""
        return self.mass * self.material.enthalpy(T[self.nodes])

    def capacity(self, T: Array) -> Array:
        """(k,) [J/K]"""
        return self.mass * self.material.heat_capacity(T[self.nodes])

    def astray(self, T: Array) -> tuple[int, Property] | None:
        """A node outside the range of a property, and that property."""
        own = T[self.nodes]
        for p in self.properties:
            low, high = int(own.argmin()), int(own.argmax())
            if own[low] < p.lower * (1.0 - 1e-9):
                return int(self.nodes[low]), p
            if own[high] > p.upper * (1.0 + 1e-9):
                return int(self.nodes[high]), p
        return None


class Conducted:
    """Bonds of one conductivity.

    n : int  temperatures in all
    """

    def __init__(self, conductivity: Property, parts: Sequence[Bonds], n: int) -> None:
        a, b, c = joined(Bonds(*(np.concatenate(x) for x in zip(*parts, strict=True))))
        self.nodes = np.unique(np.concatenate([a, b]))
        self.a, self.b = np.searchsorted(self.nodes, a), np.searchsorted(self.nodes, b)
        self.c, self.law, self.n = c, conductivity, n
        self.rows = np.concatenate([self.nodes, a, b])
        self.columns = np.concatenate([self.nodes, b, a])
        if conductivity.is_constant:
            self.c = c * float(conductivity(DATUM))
        self.fixed = self._entries()

    def add(self, T: Array, out: Array) -> None:
        """Add the power [W] that each node receives."""
        U = T[self.nodes]
        if not self.law.is_constant:
            U = self.law.integral(min(max(DATUM, self.law.lower), self.law.upper), U)
        flow, k = self.c * (U[self.b] - U[self.a]), len(self.nodes)
        out[self.nodes] += np.bincount(self.a, flow, k) - np.bincount(self.b, flow, k)

    def slopes(self, T: Array, tau: float) -> Array:
        """Entries at ``rows`` and ``columns``: minus tau times the derivative of the power."""
        if self.law.is_constant:
            return tau * self.fixed
        k = tau * self.law(T[self.nodes])
        return self.fixed * np.concatenate([k, k[self.b], k[self.a]])

    def _entries(self) -> Array:
        k = len(self.nodes)
        diagonal = np.bincount(self.a, self.c, k) + np.bincount(self.b, self.c, k)
        return np.concatenate([diagonal, -self.c, -self.c])
