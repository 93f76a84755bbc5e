"""TR-BDF2 for networks of heat capacities: heat E(T), powers that depend on T and t.

Trapezoidal rule to t + gamma h, then the second backward difference formula to t + h, with
gamma = 2 - sqrt(2) (Bank et al. 1985): L-stable, of order 2, one matrix form for both stages.
Written for the stored heat, so that the balance of every step closes to round-off. Steps are
the interval halved as often as the local error asks for, or equal ones.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from thermal.description import Settings
from thermal.integration import Interval
from thermal.stages import Array, Point, Solve, System, evaluate, fault, start

GAMMA = 2.0 - sqrt(2.0)
EARLY = 1.0 / (2.0 * (2.0 - GAMMA))  # weight of the powers at t and at t + gamma h
LATE = 0.5 * GAMMA  # weight of the power at t + h
# Local error, Bank et al. (1985): 2 k h (F0/gamma - F1/(gamma (1 - gamma)) + F2/(1 - gamma))
K = (-3.0 * GAMMA**2 + 4.0 * GAMMA - 2.0) / (12.0 * (2.0 - GAMMA))

HALVINGS, POSITION = 73, 10**12  # smallest step: of the interval, and of the time gone by in it
STEPS = 10_000  # in one interval, tried
ITERATIONS = 30
CAREFUL, COOLED = 8, 0.3  # iterations that lower no temperature below a part of itself
SLOW = 0.01  # contraction of Newton's changes that asks for a new tangent


class _Step(NamedTuple):
    """Its end, heat [J] through boundaries and to given temperatures, estimated error [K]."""

    end: Point
    flows: Array
    reactions: Array
    error: float
    why: str


class _Sum:
    """What an interval has gathered."""

    def __init__(self, system: System, T: Array, t: float, source: Array) -> None:
        self.point = start(system, T, t, source)
        self.flows, self.reactions = np.zeros_like(self.point.flows), np.zeros_like(T)
        self.why, self.steps, self.error = fault(system, self.point, t), 0, 0.0

    def take(self, new: _Step) -> None:
        self.point, self.steps = new.end, self.steps + 1
        self.error += new.error
        self.flows += new.flows
        self.reactions += new.reactions

    def interval(self, why: str) -> Interval:
        done = self.point.T, self.flows, self.reactions
        return Interval(*done, why, self.steps, self.error)


def integrate(
    system: System, T: Array, t: float, h: float, source: Array, settings: Settings
) -> Interval:
    """Temperatures at ``t + h``; ``source`` (n,) [W] is constant."""
    so_far = _Sum(system, T, t, source)
    if so_far.why:
        return so_far.interval(so_far.why)
    if settings.steps is None:
        return _halving(system, so_far, t, h, source, settings.tolerance)
    size = h / settings.steps
    for i in range(settings.steps):
        new = _step(system, so_far.point, t + i * size, size, source)
        if new.why:
            return so_far.interval(new.why)
        so_far.take(new)
    return so_far.interval("")


def _halving(
    system: System, so_far: _Sum, t: float, h: float, source: Array, tolerance: float
) -> Interval:
    level, position = 0, 0  # position counts steps of h / 2**level
    for _ in range(STEPS):
        dt = h / 2**level
        new = _step(system, so_far.point, t + position * dt, dt, source)
        if new.why or new.error > tolerance:
            level, position = level + 1, 2 * position
            if level > HALVINGS or position > POSITION:
                at = t + 0.5 * position * dt
                return so_far.interval(
                    new.why or f"t = {at:g} s: steps cannot be made small enough"
                )
            continue
        so_far.take(new)
        position += 1
        if position == 2**level:
            return so_far.interval("")
        if new.error < tolerance / 16.0 and level > 0 and position % 2 == 0:
            level, position = level - 1, position // 2
    return so_far.interval(f"t = {t:g} s: more than {STEPS} steps within {h:g} s")


def _step(system: System, first: Point, t: float, h: float, source: Array) -> _Step:
    tau = LATE * h
    base = first.heat + tau * first.power
    middle, solve, why = _solve(system, first.T, base, t + GAMMA * h, tau, source, None)
    if why:
        return _failed(first, why)
    base = first.heat + EARLY * h * (first.power + middle.power)
    end, solve, why = _solve(system, middle.T, base, t + h, tau, source, solve)
    if why:
        return _failed(first, why)
    flows = h * (EARLY * (first.flows + middle.flows) + LATE * end.flows)
    reactions = end.heat - base - tau * end.power
    reactions[system.free] = 0.0
    early, late = 1.0 / GAMMA, 1.0 / (1.0 - GAMMA)
    rough = early * first.power - early * late * middle.power + late * end.power
    error = solve((2.0 * K * h * rough)[system.free])
    return _Step(end, flows, reactions, float(np.abs(error).max(initial=0.0)), "")


def _failed(first: Point, why: str) -> _Step:
    return _Step(first, np.empty(0), np.empty(0), inf, why)


def _solve(
    system: System,
    guess: Array,
    base: Array,
    t: float,
    tau: float,
    source: Array,
    solve: Solve | None,
) -> tuple[Point, Solve, str]:
    """Newton's method for E(T) = base + tau F(T, t); both stages share a tangent that serves."""
    free, last = system.free, inf
    T = guess.copy()
    nodes, values = system.given_at(t)
    T[nodes] = values
    solve = solve or system.factorise(T, t, tau)
    slow = max(SLOW, system.refresh)
    for i in range(ITERATIONS):
        point = evaluate(system, T, t, source)
        residual = (point.heat - base - tau * point.power)[free]
        if not np.isfinite(residual).all():
            break
        change = solve(residual)
        size = float(np.abs(change).max(initial=0.0)) / max(1.0, float(np.abs(T).max()))
        if size < 4e-16 or 0.1 * last < size < 1e-10:
            return point, solve, fault(system, point, t)
        lowest = COOLED * T[free] if i < CAREFUL else -inf
        T = T.copy()
        T[free] = np.maximum(T[free] - change, lowest)
        if size <= system.accuracy:
            point = evaluate(system, T, t, source)
            return point, solve, fault(system, point, t)
        if size > slow * last:
            solve = system.factorise(T, t, tau)
        last = size
    why = system.senseless(t) or system.trouble or "the heat network did not converge"
    return point, solve, f"t = {t:g} s: {why}"
