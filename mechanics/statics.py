"""Equilibrium by the same residual as the dynamics, with load stepping."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

LARGEST_CORRECTION = 0.3
"""A longer Newton correction is shortened to this, relative to ``System.scale`` (~ radians)."""


class Equilibrium(NamedTuple):
    """Coordinates, multipliers, spent Newton iterations, and the reason if there is none.

    fraction : float  part of the load that is carried by ``q``; 1 when all went well
    """

    q: Array
    lam: Array
    iterations: int
    fraction: float
    why: str


def equilibrium(
    system: System,
    c0: Coefficients,
    c1: Coefficients,
    steps: int = 10,
    start: Equilibrium | None = None,
    tolerance: float = 1e-10,
    iterations: int = 30,
) -> Equilibrium:
    """Static equilibrium at load factor 1.

    Loads and drives follow their histories with the load factor, from 0 to 1, in place of
    time; coefficients go linearly from ``c0`` to ``c1``. A load step that does not converge
    is halved, down to 1/1024 of the first one.
    """
    q, lam = (system.layout.q0, np.zeros(system.m)) if start is None else (start.q, start.lam)
    fraction, increment, spent = 0.0, 1.0 / steps, 0
    while fraction < 1.0:
        goal = min(1.0, fraction + increment)
        if 1.0 - goal < 1e-9:
            goal = 1.0
        coef = tuple(a + goal * (b - a) for a, b in zip(c0, c1, strict=True))
        found = _newton(system, q, lam, goal, coef, tolerance, iterations)
        spent += found.iterations
        if not found.why:
            q, lam, fraction = found.q, found.lam, goal
        elif increment > 1.0 / (1024 * steps):
            increment *= 0.5
        else:
            return Equilibrium(q, lam, spent, fraction, found.why)
    return Equilibrium(q, lam, spent, 1.0, "")


def _newton(
    system: System,
    q: Array,
    lam: Array,
    goal: float,
    coef: Coefficients,
    tolerance: float,
    iterations: int,
) -> Equilibrium:
    n, rest = system.n, np.zeros(system.n)
    worst = 0
    for count in range(1, iterations + 1):
        residual = system.force(q, rest, goal, coef, system.apart)
        phi = system.constraints.add_force(q, goal, lam, residual)
        data = system.matrix(q, rest, goal, lam, coef, system.apart, Factors(0.0, 1.0, 0.0))
        solve = system.factorise(data)
        if solve is None:
            return Equilibrium(q, lam, count, goal, "the stiffness matrix is singular")
        x = solve(-np.concatenate([residual, phi]))
        sizes = np.abs(x[:n]) / system.scale
        worst = int(np.argmax(sizes))
        size = float(sizes[worst])
        if not np.isfinite(size):
            break
        shorten = min(1.0, LARGEST_CORRECTION / max(size, 1e-300))
        q, lam = q + shorten * x[:n], lam + shorten * x[n:]
        if size <= tolerance:
            return Equilibrium(q, lam, count, goal, "")
    why = f"statics did not converge at load factor {goal:.6g}, {system.name_of(worst)}"
    return Equilibrium(q, lam, iterations, goal, why)
