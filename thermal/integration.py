"""An interval of time in as many steps of a scheme as its error asks for, or in equal ones."""

from collections.abc import Callable
from math import ceil, inf, nan
from typing import NamedTuple

import numpy as np

from thermal import sdirk, theta
from thermal.description import Settings
from thermal.stages import Array, Point, Step, System, fault, start

SMALLEST, NEXT = 1e-22, 1e-12  # smallest step: of the interval, and of the time gone by in it
STEPS = 10_000  # in one interval, tried

Advance = Callable[[System, Point, float, float, Array, bool], Step]

SCHEMES: dict[str, tuple[Advance, int]] = {
    "sdirk2": (sdirk.step, sdirk.ORDER),
    "crank-nicolson": (theta.crank_nicolson, theta.CRANK_NICOLSON_ORDER),
    "backward-euler": (theta.backward_euler, theta.EULER_ORDER),
}
"""Step of each scheme, and its order."""


class Interval(NamedTuple):
    """Result of an interval.

    T : (n,) float [K]  at its end
    flows : (m,) float [J]  through each boundary
    reactions : (n,) float [J]  that held the given temperatures; zero at the free ones
    why : "" or the reason why there is no result
    steps : how many were taken
    error : float [K]  sum of their estimated local errors; nan where none were estimated
    """

    T: Array
    flows: Array
    reactions: Array
    why: str
    steps: int
    error: float = nan


def integrate(
    system: System, T: Array, t: float, h: float, source: Array, settings: Settings
) -> Interval:
    """From ``T`` at ``t`` to ``t + h`` under the constant ``source`` (n,) [W]."""
    if settings.steps is None:
        return advance(system, T, t, h, source, settings.scheme, settings.tolerance)
    return march(system, T, t, h, source, settings.scheme, settings.steps)


def advance(
    system: System, T: Array, t: float, h: float, source: Array, scheme: str, tolerance: float
) -> Interval:
    """From ``T`` at ``t`` to ``t + h`` in as many steps as the local error asks for.

    source : (n,) float [W]  constant over the interval
    tolerance : float [K]  of the estimated error of a step
    """
    step, order = SCHEMES[scheme]
    point = start(system, T, t, source)
    flows, reactions = np.zeros_like(point.flows), np.zeros_like(T)
    why = fault(system, point, t)
    done, size, taken, error = 0.0, h, 0, 0.0
    for _ in range(0 if why else STEPS):
        count = ceil((h - done) / size * (1.0 - 1e-9))
        length = (h - done) / count
        new = step(system, point, t + done, length, source, True)
        if new.why or new.error > tolerance:
            size = length * (0.25 if new.why else max(0.2, _ratio(new.error, tolerance, order)))
            if size < max(SMALLEST * h, NEXT * done):
                why = new.why or _too_rough(t + done, new.error, tolerance)
                break
            continue
        point, taken, error = new.end, taken + 1, error + new.error
        flows += new.flows
        reactions += new.reactions
        if count == 1:
            return Interval(point.T, flows, reactions, "", taken, error)
        done += length
        size = length * min(5.0, _ratio(new.error, tolerance, order))
    why = why or f"t = {t + done:g} s: more than {STEPS} steps within {h:g} s"
    return Interval(point.T, flows, reactions, why, taken, error)


def march(
    system: System, T: Array, t: float, h: float, source: Array, scheme: str, count: int
) -> Interval:
    """From ``T`` at ``t`` to ``t + h`` in ``count`` equal steps, whatever their error."""
    step, _ = SCHEMES[scheme]
    point = start(system, T, t, source)
    flows, reactions = np.zeros_like(point.flows), np.zeros_like(T)
    why = fault(system, point, t)
    for i in range(0 if why else count):
        new = step(system, point, t + i * h / count, h / count, source, False)
        if new.why:
            return Interval(point.T, flows, reactions, new.why, i)
        point = new.end
        flows += new.flows
        reactions += new.reactions
    return Interval(point.T, flows, reactions, why, count)


def _ratio(error: float, tolerance: float, order: int) -> float:
    """Step that meets the tolerance over the present one, with some care."""
    return 0.9 * (tolerance / error) ** (1.0 / (order + 1.0)) if error > 0.0 else inf


def _too_rough(t: float, error: float, tolerance: float) -> str:
    return f"t = {t:g} s: error of {error:.3g} K per step cannot be brought below {tolerance:g} K"
