"""Eigenfrequencies about any state, heated and constrained."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from mechanics.description import Continuum
from mechanics.eigen import Shifted, lowest, negatives, noise, refined
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
    y = np.concatenate([q, lam])
    K, B = stiffness(system, y, t, coef)
    M = csc_array(system.mass)

    def factorised(shift: float) -> Shifted | None:
        return shifted(system, y, t, coef, shift)

    squares, shapes = lowest(K, M, B, count, system.scale, factorised)
    # rigid motions may be negative by round-off
    small = np.maximum(noise(K, shapes), SMALL * np.max(squares))
    squares = np.where((squares < 0.0) & (squares > -small), 0.0, squares)
    frequencies = np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi)
    unstable = int(np.count_nonzero(squares < 0.0))
    if unstable == len(squares):
        unstable = growing(system, y, t, coef)
    return Modes(frequencies, shapes, unstable)


def stiffness(
    system: System, y: Array, t: float, coef: Coefficients
) -> tuple[csc_array, csc_array]:
    """Tangent stiffness K (n, n) and constraint matrix B (m, n) about ``y`` (n + m,)."""
    n, factors = system.n, Factors(0.0, 1.0, 0.0)
    system = system.following(y[:n])
    data = system.matrix(y, np.zeros_like(y), t, coef, factors)
    matrix = system.pattern.matrix(data)
    return csc_array(matrix[:n, :n]), csc_array(matrix[n:, :n])


def growing(system: System, y: Array, t: float, coef: Coefficients) -> int:
    """Number of motions about ``y`` (n + m,) with a negative stiffness."""
    known = shifted(system, y, t, coef, 0.0)
    return negatives(*stiffness(system, y, t, coef)) if known is None else known.below


def shifted(system: System, y: Array, t: float, coef: Coefficients, shift: float) -> Shifted | None:
    """K - ``shift`` M by the factorisation of the system; None where it does not tell signs.

    It pays where solids make the matrix large.
    """
    if not any(isinstance(body, Continuum) for body in system.layout.bodies.values()):
        return None
    system = system.following(y[: system.n])
    data = system.matrix(y, np.zeros_like(y), t, coef, Factors(-shift, 1.0, 0.0))
    found = system.solver.counted(data)
    if found is None:
        return None
    (solve, count), n = found, system.n
    matrix = csc_array(system.pattern.matrix(data))
    return Shifted(count - system.m, lambda: refined(matrix, solve, n))
