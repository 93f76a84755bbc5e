"""Steady temperatures by pseudo-transient continuation (Kelley & Keyes 1998).

Steps of backward Euler grow until the stored heat no longer matters; they shrink where Newton's
method fails. What has no way to give off its heat is found by its temperature running away.
"""

import numpy as np

from thermal.stages import Array, Point, System, fault, stage, start

FIRST, LAST = 1.0, 1e16  # [s] of the growing steps
GROWTH, RETREAT = 10.0, 0.1
TRIES = 200
SETTLED = 1e-9  # change of temperature in a last step, relative


def settle(system: System, T: Array, t: float) -> tuple[Array, Array, str]:
    """Temperatures [K] that the conditions of time ``t`` hold, power [W] through each boundary.

    T : (n,) float [K]  first guess; of parts that exchange no heat, their stored heat stays

    The third value is "" or the reason why there are none.
    """
    point = start(system, T, t, np.zeros_like(T))
    why, h, solve = fault(system, point, t), FIRST, None
    for _ in range(0 if why else TRIES):
        new = stage(system, point.T, point.heat, t, h, np.zeros_like(T), solve)
        if new.why:
            h *= RETREAT
            why = new.why
            if h < FIRST * RETREAT**8:
                break
            continue
        change = float(np.abs(new.point.T - point.T).max(initial=0.0))
        point, why = new.point, ""
        if h >= LAST and change <= SETTLED * float(np.abs(point.T).max()):
            return point.T, point.flows, ""
        h = min(h * GROWTH, LAST)
    return point.T, point.flows, _unsettled(why, point)


def _unsettled(why: str, point: Point) -> str:
    cause = "heat that flows in has no way out (a sink, a given temperature)"
    return f"there is no steady state: {why or cause}; the hottest point is at {point.T.max():g} K"
