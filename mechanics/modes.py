"""Eigenfrequencies about any state, heated and constrained."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from mechanics.eigen import lowest, negatives, noise
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

SMALL = 1e-9
"""Square of a frequency that is none, relative to the largest of those sought [-]."""


class Modes(NamedTuple):
    """Vibrations about a state.

    frequencies : (k,) float [Hz], ascending, negative where the state is unstable
    shapes : (n, k) float  with x^T M x = 1
    unstable : int  number of motions that grow, among all
    """

    frequencies: Array
    shapes: Array
    unstable: int


def modes(
    system: System, q: Array, lam: Array, coef: Coefficients, count: int, t: float = 0.0
) -> Modes:
    """The ``count`` lowest modes of the motion that the constraints allow.

    The tangent stiffness about ``q`` holds the geometric stiffness of the stresses and of the
    multipliers ``lam``, hence the effect of thermal loads. Loads and drives are those at ``t``
    (in statics: the load factor).
    """
    K, B = stiffness(system, np.concatenate([q, lam]), t, coef)
    M = csc_array(system.mass)
    squares, shapes = lowest(K, M, B, count, system.scale)
    # rigid motions may be negative by round-off
    small = np.maximum(noise(K, shapes), SMALL * np.max(squares))
    squares = np.where((squares < 0.0) & (squares > -small), 0.0, squares)
    frequencies = np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi)
    unstable = int(np.count_nonzero(squares < 0.0))
    if unstable == len(squares):
        unstable = negatives(K, B)
    return Modes(frequencies, shapes, unstable)


def stiffness(
    system: System, y: Array, t: float, coef: Coefficients
) -> tuple[csc_array, csc_array]:
    """Tangent stiffness K (n, n) and constraint matrix B (m, n) about ``y`` (n + m,)."""
    n, factors = system.n, Factors(0.0, 1.0, 0.0)
    data = system.matrix(y, np.zeros_like(y), t, coef, factors)
    matrix = system.pattern.matrix(data)
    return csc_array(matrix[:n, :n]), csc_array(matrix[n:, :n])
