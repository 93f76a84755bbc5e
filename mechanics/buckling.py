"""Loads at which a structure buckles, linearised about a state."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import csc_array
from scipy.sparse.linalg import LinearOperator, eigsh

from mechanics.eigen import basis, negatives, saddle_solve
from mechanics.modes import stiffness
from mechanics.prediction import separated
from mechanics.statics import between, load_change
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

STEP = 1e-4
"""Change of the coordinates, relative to ``System.scale``, over which the tangent changes [-]."""


class Buckling(NamedTuple):
    """factors : (k,) float  load factors, ascending;  shapes : (n, k) float  largest change 1"""

    factors: Array
    shapes: Array


def buckling(
    system: System,
    c0: Coefficients,
    c1: Coefficients,
    count: int = 1,
    q: Array | None = None,
    lam: Array | None = None,
    fraction: float = 0.0,
) -> Buckling:
    """Lowest load factors above ``fraction`` at which the stiffness becomes singular.

    The equilibrium ``q``, ``lam`` at ``fraction`` (default: the reference, without load) is
    continued linearly: K + (p - fraction) dK/dp has no inverse, where dK/dp is what stresses,
    multipliers, loads and temperatures change along the path. The change of shape of beams,
    cables and shells is left out, as is classical (of springs it is included): in the square it
    matters as much, and alone it would soften what is stiff. Coefficients go from ``c0`` to
    ``c1``. Good for structures that change their shape little before they buckle.

    Raises
    ------
    ValueError : the state is unstable, or holds no stiffness at all
    """
    n = system.n
    y = system.unknowns(system.layout.q0 if q is None else q, lam)
    K, B = stiffness(system, y, fraction, between(c0, c1, fraction))
    if negatives(K, B):
        raise ValueError("buckling is sought from a stable state, and this one is not")
    slope = _slope(system, y, c0, c1, fraction)
    if n - B.shape[0] < 4 * _krylov(count):
        theta, shapes = _dense(K, slope, B, count)
    else:
        theta, shapes = _lanczos(K, slope, B, count)
    critical = theta > 0.0
    order = np.argsort(1.0 / theta[critical])
    shapes = shapes[:, critical][:, order]
    largest = np.max(np.abs(shapes / system.scale[:, None]), axis=0)
    return Buckling(fraction + 1.0 / theta[critical][order], shapes / largest)


def _slope(
    system: System, y: Array, c0: Coefficients, c1: Coefficients, fraction: float
) -> csc_array:
    """dK/dp (n, n) along the path."""
    n, still = system.n, np.zeros_like(y)
    system, coef = system.following(y[:n]), between(c0, c1, fraction)
    solve = system.factorise(system.matrix(y, still, fraction, coef, Factors(0.0, 1.0, 0.0)))
    if solve is None:
        raise ValueError("buckling is sought from a stable state, and this one is not")
    tangent = solve(-load_change(system, y, c0, c1, fraction))
    fast = float(np.max(np.abs(tangent[:n]) / system.scale, initial=0.0))
    h = STEP / fast if fast > 0.0 else STEP
    change = csc_array((n, n))
    for s in (h, -h):
        at, moved = fraction + s, y + s * tangent
        stressed, rest = separated(system, between(c0, c1, at), coef, y, s * tangent)
        change = change + stiffness(system, y, fraction, stressed)[0] / (2.0 * s)
        change = change + stiffness(system, moved, at, rest)[0] / (2.0 * s)
    return csc_array(0.5 * (change + change.T))


def _krylov(count: int) -> int:
    """Vectors of the Lanczos method; it needs a larger space of motions than that."""
    return max(2 * count + 20, 40)


def _dense(K: csc_array, slope: csc_array, B: csc_array, count: int) -> tuple[Array, Array]:
    free = basis(B)
    grown, held = (free.T @ (A @ free) for A in (-slope, K))
    theta, shapes = eigh(0.5 * (grown + grown.T), 0.5 * (held + held.T))
    return theta[-count:], free @ shapes[:, -count:]


def _lanczos(K: csc_array, slope: csc_array, B: csc_array, count: int) -> tuple[Array, Array]:
    """-dK/dp x = theta K x with theta = 1/(p - fraction), the largest theta."""
    n = K.shape[0]
    inverse = saddle_solve(K, B)
    operator = LinearOperator((n, n), matvec=inverse, dtype=float)
    first = inverse(np.random.default_rng(0).standard_normal(n))
    held = csc_array(0.5 * (K + K.T))
    return eigsh(-slope, count, held, Minv=operator, which="LA", v0=first, ncv=_krylov(count))
