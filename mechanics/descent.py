"""Downhill to a stable equilibrium where Newton's method finds none: beyond a limit load.

A structure that snaps moves far, through places where its stiffness is indefinite; there Newton's
steps lead to where the unbalanced forces push nothing, up as well as down. Here the mass, times a
drag, is added to the stiffness: implicit Euler steps of (drag) M dq/dt = unbalanced force, a heavy
body in thick oil (pseudo-transient continuation; Kelley & Keyes 1998, SIAM J. Numer. Anal.
35:508). The drag grows where a step would lead far or against the force, and fades otherwise: the
end is Newton's method. Constraints are part of each step.

The line search is that of Matthies & Strang (1979, Int. J. Numer. Meth. Engng 14:1613): a step
ends where the unbalanced force, multipliers included, does little work along it. It needs no
energy, so it holds for any load, and falls below it where forces have one.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from mechanics.eigen import ratio
from mechanics.modes import stiffness
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

FIRST = 1e-8
"""Drag to begin with, relative to that of the stiffest motions [-]."""
MORE, LESS = 4.0, 0.25
"""Factors of the drag after a bad and after a good step."""
FAR, CLOSE = 0.3, 1e-6
"""Largest step, and the step at the end, relative to ``System.scale``."""
SLACK, SEARCHES = 0.5, 8
"""Work per length against a step that is accepted at its end, relative to that which drives it."""
HUGE = 1e100
"""Forces that nothing balances [N]."""
GOOD, BAD = 0.5, 0.2
"""Parts of a step beyond which the drag fades, below which it grows."""


def downhill(
    system: System, y: Array, t: float, coef: Coefficients, iterations: int = 240
) -> tuple[Array, int]:
    """Unknowns (n + m,) near a stable equilibrium at load factor ``t``, and factorisations spent.

    Newton's method is to follow. After ``iterations`` they are those reached by then.
    """
    still, n, spent = np.zeros_like(y), system.n, 0
    drag = FIRST * _hardest(system, y, t, coef)
    while spent < iterations:
        spent += 1
        system = system.following(y[:n])
        residual = system.residual(y, still, t, coef)
        if not np.all(np.abs(residual) < HUGE):
            break
        solve = system.factorise(system.matrix(y, still, t, coef, Factors(drag, 1.0, 0.0)))
        step = y * np.nan if solve is None else solve(-residual)
        size = float(np.max(np.abs(step[:n]) / system.scale, initial=0.0))
        ahead = _driving(system, y, t, coef, step, 0.0)
        if not (size < FAR and ahead > 0.0):
            if size <= CLOSE:
                break
            drag *= MORE
            continue
        part = _part(system, y, t, coef, step)
        y = np.concatenate([y[:n] + part * step[:n], y[n:] + step[n:]])
        drag *= LESS if part > GOOD else (MORE if part < BAD else 1.0)
        if size <= CLOSE and part == 1.0:
            break
    return y, spent


def _hardest(system: System, y: Array, t: float, coef: Coefficients) -> float:
    """Stiffness over mass of the stiffest motions [1/s^2]."""
    K, _ = stiffness(system, y, t, coef)
    return ratio(K, csc_array(system.mass), system.scale)


def _part(system: System, y: Array, t: float, coef: Coefficients, step: Array) -> float:
    """Part of a step at whose end the unbalanced force does not push back much."""
    part, driving = 1.0, _driving(system, y, t, coef, step, 0.0)
    for _ in range(SEARCHES):
        there = _driving(system, y, t, coef, step, part)
        if there >= -SLACK * driving:
            break
        secant = driving / (driving - there)
        part *= min(0.7, max(0.2, secant)) if secant == secant else 0.2
    return part


def _driving(
    system: System, y: Array, t: float, coef: Coefficients, step: Array, part: float
) -> float:
    """Work of the unbalanced force along a step, per part of it, at ``part`` of it."""
    n = system.n
    place = np.concatenate([y[:n] + part * step[:n], y[n:] + step[n:]])
    return -float(step[:n] @ system.residual(place, np.zeros_like(y), t, coef)[:n])
