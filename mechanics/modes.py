"""Eigenfrequencies about any state, heated and constrained."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, null_space

from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]


class Modes(NamedTuple):
    """frequencies : (k,) float [Hz], negative where the state is unstable; shapes : (n, k) float"""

    frequencies: Array
    shapes: Array


def modes(system: System, q: Array, lam: Array, coef: Coefficients, count: int) -> Modes:
    """The ``count`` lowest modes of the motion that the constraints allow.

    The tangent stiffness about ``q`` holds the geometric stiffness of the stresses and of the
    multipliers ``lam``, hence the effect of thermal loads. Dense: meant for a few thousand
    coordinates at most.
    """
    rest = np.zeros(system.n)
    data = system.matrix(q, rest, 0.0, lam, coef, system.apart, Factors(0.0, 1.0, 0.0))
    full = system.pattern.matrix(data).toarray()
    n = system.n
    free = null_space(full[n:, :n]) if system.m else np.eye(n)
    stiffness = free.T @ full[:n, :n] @ free
    inertia = free.T @ (system.mass @ free)
    squares, shapes = eigh(0.5 * (stiffness + stiffness.T), inertia, subset_by_index=[0, count - 1])
    return Modes(np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi), free @ shapes)
