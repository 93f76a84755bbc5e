"""Conservative time integration of dE(T)/dt = F(T, t), some temperatures given over time.

SDIRK2 of Alexander (1977): two stages, gamma = 1 - 1/sqrt(2), L-stable, stiffly accurate, of
order 2. It is applied to the stored heat E, so that what flows in over a step is what is stored
at its end, to round-off, whatever the material. Where temperatures are given, the rest of the
balance of their rows is the heat that holds them there.
"""

from collections.abc import Callable
from math import ceil, inf, isfinite, sqrt
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Solve = Callable[[Array], Array]

GAMMA = 1.0 - 1.0 / sqrt(2.0)
# The local error of y' = lambda y is (1/3 - gamma) h^3 y'''. The powers at the start and the two
# stages combine to F(gamma) - (1 - gamma) F(0) - gamma F(1) = 3/2 (1/3 - gamma) h^2 y''' there;
# for y' = f(t) the same combination over-estimates the error by 6.8.
ERROR = 2.0 / 3.0

ITERATIONS = 20
ROUND_OFF = 3e-16  # change of temperature, relative, at which Newton's method has ended
FLOOR = 1e-10  # below it a change that no longer shrinks is round-off too
REFRESH = 1e-4  # a slower contraction asks for a new tangent
SMALLEST = 1e-9  # of the interval: smallest step
STEPS = 10_000  # in one interval, tried


class System(Protocol):
    """What is integrated."""

    free: Indices
    """Temperatures to solve for; all others are given."""

    def given_at(self, t: float) -> tuple[Indices, Array]:
        """Given temperatures: which and their values [K]."""
        ...

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored."""
        ...

    def power(self, T: Array, t: float) -> tuple[Array, Array]:
        """(n,) [W] received, and (m,) [W] of it through each boundary."""
        ...

    def factorise(self, T: Array, tau: float) -> Solve:
        """Solver of (dE/dT - tau dF/dT) x = r among the free temperatures."""
        ...

    def unusable(self, T: Array) -> str:
        """Why temperatures cannot be accepted, or ""."""
        ...

    def owner(self, node: int) -> str:
        """What a temperature belongs to, in words."""
        ...


class Interval(NamedTuple):
    """Result of an interval.

    T : (n,) float [K]  at its end
    flows : (m,) float [J]  through each boundary
    reactions : (n,) float [J]  that held the given temperatures; zero at the free ones
    why : "" or the reason why there is no result
    """

    T: Array
    flows: Array
    reactions: Array
    why: str


class _Point(NamedTuple):
    T: Array
    heat: Array
    power: Array
    flows: Array


class _Stage(NamedTuple):
    point: _Point
    solve: Solve | None
    why: str


class _Step(NamedTuple):
    end: _Point
    flows: Array
    reactions: Array
    error: float
    why: str


def advance(
    system: System, T: Array, t: float, h: float, source: Array, tolerance: float
) -> Interval:
    """From ``T`` at ``t`` to ``t + h`` in as many steps as the local error asks for.

    source : (n,) float [W]  constant over the interval
    tolerance : float [K]  of the estimated error of a step
    """
    point = _start(system, T, t, source)
    flows, reactions = np.zeros_like(point.flows), np.zeros_like(T)
    why = _fault(system, point, t)
    done, size = 0.0, h
    for _ in range(0 if why else STEPS):
        count = ceil((h - done) / size * (1.0 - 1e-9))
        length = (h - done) / count
        step = _step(system, point, t + done, length, source)
        if step.why or step.error > tolerance:
            size = length * (0.25 if step.why else max(0.2, _ratio(step.error, tolerance)))
            if size < SMALLEST * h:
                why = step.why or _too_rough(t + done, step.error, tolerance)
                break
            continue
        point = step.end
        flows += step.flows
        reactions += step.reactions
        if count == 1:
            return Interval(point.T, flows, reactions, "")
        done += length
        size = length * min(5.0, _ratio(step.error, tolerance))
    why = why or f"t = {t + done:g} s: more than {STEPS} steps within {h:g} s"
    return Interval(point.T, flows, reactions, why)


def _ratio(error: float, tolerance: float) -> float:
    """Step that meets the tolerance over the present one, with some care."""
    return 0.9 * (tolerance / error) ** (1.0 / 3.0) if error > 0.0 else inf


def _too_rough(t: float, error: float, tolerance: float) -> str:
    return f"t = {t:g} s: error of {error:.3g} K per step cannot be brought below {tolerance:g} K"


def _step(system: System, start: _Point, t: float, h: float, source: Array) -> _Step:
    tau = GAMMA * h
    first = _stage(system, start.T, start.heat, t + tau, tau, source, None)
    if first.why:
        return _failed(start, first.why)
    early = (1.0 - GAMMA) * h
    base = start.heat + early * first.point.power
    second = _stage(system, first.point.T, base, t + h, tau, source, first.solve)
    if second.why or second.solve is None:
        return _failed(start, second.why)
    end = second.point
    reactions = end.heat - base - tau * end.power
    reactions[system.free] = 0.0
    return _Step(
        end,
        early * first.point.flows + tau * end.flows,
        reactions,
        _error(system, start, first.point, end, h, second.solve),
        "",
    )


def _failed(start: _Point, why: str) -> _Step:
    return _Step(start, np.zeros(0), np.zeros(0), inf, why)


def _error(system: System, a: _Point, b: _Point, c: _Point, h: float, solve: Solve) -> float:
    """Estimated local error [K], damped by the tangent as Hosea & Shampine (1996) do."""
    defect = b.power - (1.0 - GAMMA) * a.power - GAMMA * c.power
    return float(np.abs(solve(ERROR * h * defect[system.free])).max(initial=0.0))


def _stage(
    system: System,
    guess: Array,
    base: Array,
    t: float,
    tau: float,
    source: Array,
    solve: Solve | None,
) -> _Stage:
    """Solve E(T) = base + tau F(T, t) by Newton's method; the tangent is kept while it serves."""
    T = _imposed(system, guess, t)
    previous, contraction, worst = inf, 0.0, 0
    for _ in range(ITERATIONS):
        point = _evaluate(system, T, t, source)
        residual = (point.heat - base - tau * point.power)[system.free]
        if not np.isfinite(residual).all():
            break
        if solve is None or contraction > REFRESH:
            solve = system.factorise(T, tau)
        change = solve(residual)
        size = float(np.abs(change).max(initial=0.0) / max(1.0, np.abs(T).max()))
        if size <= ROUND_OFF or 0.1 * previous < size <= FLOOR:
            return _Stage(point, solve, _fault(system, point, t))
        worst = int(np.abs(change).argmax())
        T = T.copy()
        T[system.free] -= change
        contraction, previous = size / previous, size
    owner = system.owner(int(system.free[worst])) if len(system.free) else "a boundary"
    return _Stage(point, None, f"t = {t:g} s: the heat balance of {owner} did not converge")


def _start(system: System, T: Array, t: float, source: Array) -> _Point:
    """The heat stored in ``T``, but powers with the given temperatures of ``t`` in their place."""
    return _evaluate(system, _imposed(system, T, t), t, source)._replace(heat=system.heat(T))


def _imposed(system: System, T: Array, t: float) -> Array:
    T = T.copy()
    nodes, values = system.given_at(t)
    T[nodes] = values
    return T


def _evaluate(system: System, T: Array, t: float, source: Array) -> _Point:
    power, flows = system.power(T, t)
    return _Point(T, system.heat(T), power + source, flows)


def _fault(system: System, point: _Point, t: float) -> str:
    if not isfinite(float(point.T.sum() + point.power.sum())):
        return f"t = {t:g} s: a temperature or a power is not a number"
    why = system.unusable(point.T)
    return f"t = {t:g} s: {why}" if why else ""
