"""Equilibrium by the same residual as the dynamics: load stepping, Newton, line search.

Newton's matrix takes the stress in the geometric stiffness from the linear prediction of the
step before (``mechanics.prediction``). Its steps are taken in full, but for a limit on their
length: shortened ones do worse with large rotations. A load step that does not converge is
halved. Where that does not help, as beyond a limit load, a line search leads downhill to the
next stable equilibrium (``mechanics.descent``): the structure snaps. So does what is loose until
contacts hold it, as a pin in a bore.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array

from mechanics.descent import downhill
from mechanics.mechanism import free_motions
from mechanics.modes import growing
from mechanics.prediction import predicted
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

STIFFNESS = Factors(0.0, 1.0, 0.0)

LARGEST_CORRECTION = 1.0
"""A longer Newton correction is shortened to this, relative to ``System.scale`` (~ radians)."""

UNHELD = 1e3
"""A first correction beyond this is that of a body which nothing holds, but for round-off."""

LARGEST_STEP = 1.0
"""A load step that moves a coordinate further may end on another branch; it is halved."""

BALANCE = 1e-8
"""Unbalanced force allowed, relative to the largest load or reaction [-]."""

ROUNDING = 1e-12
"""Unbalanced force that rounding of the coordinates may leave, relative to stiffness [-]."""

LAST = 16
"""Load steps this much smaller than the first one that fail are tried downhill."""

PATIENCE = 8
"""Iterations allowed downhill, of those of Newton's method."""

EASY, GROWTH = 6, 4.0
"""Most iterations after which the next load step is doubled; largest step, of the first one."""


class Equilibrium(NamedTuple):
    """Coordinates, multipliers, spent Newton iterations, and the reason if there is none.

    iterations : int  factorisations of the stiffness
    fraction : float  part of the load that is carried by ``q``; 1 when all went well
    """

    q: Array
    lam: Array
    iterations: int
    fraction: float
    why: str


class Allowed(NamedTuple):
    """Bounds for Newton.

    correction : at the end, relative to ``System.scale``
    iterations : with one factorisation each
    first : largest first correction
    """

    correction: float
    iterations: int
    first: float


class Found(NamedTuple):
    """Where Newton ended; ``worst`` is the unknown that moves, or is out of balance, most."""

    y: Array
    iterations: int
    worst: int
    why: str


def equilibrium(
    system: System,
    c0: Coefficients,
    c1: Coefficients,
    steps: int = 10,
    start: Equilibrium | None = None,
    tolerance: float = 1e-10,
    iterations: int = 30,
    observe: Callable[[float, Array], None] | None = None,
    time: float | None = None,
) -> Equilibrium:
    """Static equilibrium at load factor 1.

    Loads and drives follow their histories with the load factor, from 0 to 1, in place of
    time; coefficients go linearly from ``c0`` to ``c1``.

    Parameters
    ----------
    steps : the first load step is 1/steps; easy ones grow up to fourfold, while the states that
        they lead to are stable; one that does not converge is halved, down to 1/1024 of the first
    start : coordinates and multipliers to begin with; the reference
    tolerance : largest remaining correction, relative to ``System.scale``
    iterations : allowed to Newton's method in one load step
    observe : called with the load factor and the unknowns (n + m,) after every accepted load step
    time : float [s]  at which loads and drives stay instead of following the load factor
    """
    y = at_rest(system) if start is None else np.concatenate([start.q, start.lam])
    fraction, increment, spent, bound = 0.0, 1.0 / steps, 0, UNHELD
    largest = GROWTH / steps
    while fraction < 1.0:
        goal = min(1.0, fraction + increment)
        if 1.0 - goal < 1e-9:
            goal = 1.0
        small, grown = increment <= 1.0 / (8 * steps), increment > 1.001 / steps
        coef = between(c0, c1, goal)
        t = goal if time is None else time
        found = newton(system, y, t, coef, Allowed(tolerance, iterations, bound))
        spent += found.iterations
        if found.why and increment <= 1.0 / (LAST * steps):
            found, more = _fallen(system, y, t, coef, Allowed(tolerance, iterations, np.inf))
            spent += more + found.iterations
        moved = float(np.max(np.abs(found.y - y)[: system.n] / system.scale, initial=0.0))
        near = not found.why and (moved <= LARGEST_STEP or small)
        if near and grown and _unstable(system, found.y, t, coef):
            near, largest = False, 1.0 / steps
        if near:
            y, fraction = found.y, goal
            if observe is not None:
                observe(fraction, y)
            if found.iterations <= EASY and moved < 0.5 * LARGEST_STEP:
                increment = min(2.0 * increment, largest)
            continue
        seek = found.why and fraction == 0.0 and bound < np.inf
        loose = free_motions(system, y, c0) if seek else []
        if loose and system.contacts:  # what is loose falls until it touches
            fallen, more = _fallen(system, y, t, coef, Allowed(tolerance, iterations, np.inf))
            spent += more + fallen.iterations
            if not fallen.why:
                y, bound = fallen.y, np.inf
                continue
        if loose or increment <= 1.0 / (1024 * steps):
            why = "nothing holds " + "; ".join(loose) if loose else found.why
            return Equilibrium(y[: system.n], y[system.n :], spent, fraction, why)
        if not found.why or found.iterations > 1 or bound == np.inf:
            increment *= 0.5
        bound = np.inf if found.why else bound
    return Equilibrium(y[: system.n], y[system.n :], spent, 1.0, "")


def _fallen(
    system: System, y: Array, t: float, coef: Coefficients, allowed: Allowed
) -> tuple[Found, int]:
    """Where bodies that only contacts can hold come to rest, and factorisations spent falling."""
    lower, spent = downhill(system, y, t, coef, PATIENCE * allowed.iterations)
    return newton(system, lower, t, coef, allowed), spent


def at_rest(system: System) -> Array:
    """Reference coordinates and no multipliers, (n + m,)."""
    return np.concatenate([system.layout.q0, np.zeros(system.m)])


def between(c0: Coefficients, c1: Coefficients, fraction: float) -> Coefficients:
    """Coefficients at a load factor."""
    return tuple(a + fraction * (b - a) for a, b in zip(c0, c1, strict=True))


def _unstable(system: System, y: Array, t: float, coef: Coefficients) -> bool:
    """Whether the equilibrium is one that a real body would leave."""
    return growing(system, y, t, coef) > 0


def load_change(
    system: System, y: Array, c0: Coefficients, c1: Coefficients, fraction: float
) -> Array:
    """(n + m,) change of the residual with the load factor, coordinates held."""
    h, still = 1e-4, np.zeros_like(y)
    ahead, behind = (
        system.residual(y, still, p, between(c0, c1, p)) for p in (fraction + h, fraction - h)
    )
    return (ahead - behind) / (2.0 * h)


def newton(system: System, y: Array, t: float, coef: Coefficients, allowed: Allowed) -> Found:
    """Solve for the equilibrium at load factor ``t``, starting from ``y`` (n + m,)."""
    n, still, worst, stressed = system.n, np.zeros_like(y), 0, coef
    system = system.following(y[:n])
    for count in range(1, allowed.iterations + 1):
        residual = system.residual(y, still, t, coef)
        data = system.matrix(y, still, t, stressed, STIFFNESS)
        solve = system.factorise(data)
        if solve is None:
            return Found(y, count, worst, f"the stiffness is singular at load factor {t:.6g}")
        step = solve(-residual)
        size = np.abs(step[:n]) / system.scale
        worst = int(np.argmax(size))
        if not size[worst] <= (allowed.first if count == 1 else np.inf):
            break
        if size[worst] <= allowed.correction:
            y = y + step
            heavy = unbalanced(system, y, t, coef, data, system.residual(y, still, t, coef))
            if heavy is None:
                return Found(y, count, worst, "")
            worst, stressed = heavy, coef
            continue
        step *= min(1.0, LARGEST_CORRECTION / float(size[worst]))
        stressed = predicted(system, coef, y, step, y + step)
        y = y + step
    why = f"statics did not converge at load factor {t:.6g}, {system.name_of(worst)}"
    return Found(y, count, worst, why)


def unbalanced(
    system: System, y: Array, t: float, coef: Coefficients, data: Array, residual: Array
) -> int | None:
    """The unknown that is most out of balance, or None if all are within bounds.

    Forces are compared with the largest load or reaction, both times the size of their
    coordinate, and with what rounding of the coordinates leaves; constraints with their slope. On a
    coordinate without a stiffness of its own, such as that of a reference point, it is left by the
    multipliers, as those of what they tie.
    """
    n, scale = system.n, system.scale
    matrix = system.pattern.matrix(data)
    slope = abs(matrix[:, :n]) @ np.maximum(scale, np.abs(y[:n]))
    loads = np.abs(system.external(y, t, coef)), np.abs(matrix[:n, n:] @ y[n:])
    largest = max(float(np.max(load * scale, initial=0.0)) for load in loads)
    slope[:n] += np.where(slope[:n] == 0.0, _passed_on(matrix[n:, :n], slope[:n], scale), 0.0)
    allowed = ROUNDING * slope
    allowed[:n] += BALANCE * largest / scale
    excess = np.abs(residual) / np.maximum(allowed, 1e-300)
    worst = int(np.argmax(excess))
    return worst if not excess[worst] <= 1.0 else None


def _passed_on(B: csc_array, forces: Array, scale: Array) -> Array:
    """(n,) forces by the multipliers that ``forces`` (n,) on what the constraints hold need."""
    held = abs(B) @ diags_array(scale)
    squares = np.maximum(held.multiply(held).sum(axis=1), 1e-300)
    return (held.T @ ((held @ (scale * forces)) / squares)) / scale
