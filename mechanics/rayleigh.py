"""Rayleigh damping, f = (alpha_M M + alpha_K K0) v, an option.

The pair of Hua et al. (2026), C = alpha_M M + alpha_K K, with the tangent stiffness K0 of the
reference configuration, free of stress. Two properties to know before it is chosen: alpha_M M
slows rigid motion down, with the time constant 1/alpha_M; and K0 belongs to the directions of the
reference, so that a body that has turned is also damped in its rigid rotation. The default of
this project, Kelvin-Voigt damping of strains (``damping_time``), does neither. Of a vibration
with the angular frequency w about the reference the damping ratio is alpha_M/(2 w) + alpha_K w/2.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics import kernels
from mechanics.description import Flexible
from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel
from mechanics.layout import Layout

Array = NDArray[np.float64]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    k = ints.shape[1]
    for e in range(len(ints)):
        for i in range(k):
            for j in range(k):
                out[ints[e, i]] += floats[e, k * i + j] * v[ints[e, j]]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    for e in range(len(ints)):
        for i in range(slots.shape[1]):
            data[slots[e, i]] += cC * floats[e, i]


@kernel(ENERGY)
def add_energies(y, v, coef, ints, floats, out):
    k = ints.shape[1]
    for e in range(len(ints)):
        for i in range(k):
            for j in range(k):
                out[1] += v[ints[e, i]] * floats[e, k * i + j] * v[ints[e, j]]


class Rayleigh:
    """Damping of the elements of one other term: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    dofs : (n_e, k) intp, as in the other term; ints : the same, int64
    floats : (n_e, k k) float  damping matrix of each element, in the units of its coordinates
    """

    symmetric = True

    def __init__(self, term: Any, layout: Layout, alpha_m: float, alpha_k: float):
        self.name, self.names, self.dofs = f"rayleigh of {term.name}", term.names, term.dofs
        self.ints = np.ascontiguousarray(term.dofs, dtype=np.int64)
        damping = alpha_m * term.mass_blocks()
        if alpha_k:
            damping = damping + alpha_k * _reference_stiffness(term, layout)
        self.floats = np.ascontiguousarray(damping.reshape(len(self.ints), -1))
        self.signals: list = []
        self.force, self.tangent, self.energy = add_force, add_tangent, add_energies

    def coefficients(self, T: Array) -> Array:
        """Nothing here depends on temperature: (n_e, 0)."""
        return np.zeros((len(self.ints), 0))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The same: there are no free strains."""
        return c0, c1

    def mass_blocks(self) -> None:
        """No mass of its own."""


def build(terms: Sequence[Any], layout: Layout, alpha_m: float, alpha_k: float) -> list[Rayleigh]:
    """Damping of each term that holds flexible bodies; rigid bodies and joints have none.

    Parameters
    ----------
    alpha_m : float [1/s];  alpha_k : float [s]
    """
    if alpha_m < 0.0 or alpha_k < 0.0:
        raise ValueError(f"Rayleigh factors must not be negative, got {alpha_m:g} and {alpha_k:g}")
    return [Rayleigh(t, layout, alpha_m, alpha_k) for t in terms if _flexible(t, layout)]


def _flexible(term: Any, layout: Layout) -> bool:
    bodies = [layout.bodies.get(name) for name in set(term.names)]
    held = getattr(term, "mass_blocks", lambda: None)() is not None
    return held and all(isinstance(body, Flexible) for body in bodies)


def _reference_stiffness(term: Any, layout: Layout) -> Array:
    """(n_e, k, k) at the reference configuration and temperatures, where there is no stress."""
    rest = np.zeros(layout.ndof)
    coef = term.coefficients(reference_temperatures(layout))
    return kernels.tangent_blocks(term, layout.q0, rest, coef, 1.0, 0.0)


def reference_temperatures(layout: Layout) -> Array:
    """(m, 3) section temperatures at which no body has thermal strain."""
    T = np.zeros((len(layout.x), 3))
    for name, body in layout.bodies.items():
        if isinstance(body, Flexible):
            T[layout.point_index[name], 0] = body.reference_temperature
    return T
