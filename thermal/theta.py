"""Backward Euler and Crank-Nicolson (Crank & Nicolson 1947), on the stored heat."""

from functools import partial

from thermal.stages import (
    Array,
    Point,
    Solve,
    Step,
    System,
    balance,
    damped,
    evaluate,
    failed,
    stage,
)

EULER_ORDER, CRANK_NICOLSON_ORDER = 1, 2


def step(
    theta: float, system: System, start: Point, t: float, h: float, source: Array, control: bool
) -> Step:
    """E1 = E0 + h ((1 - theta) F0 + theta F1), from ``start`` at ``t``."""
    tau, early = theta * h, (1.0 - theta) * h
    base = start.heat + early * start.power
    only = stage(system, start.T, base, t + h, tau, source, None)
    if only.why or only.solve is None:
        return failed(start, only.why)
    end = only.point
    error = 0.0
    if control:
        estimate = _first_order if theta == 1.0 else _second_order
        error = estimate(system, start, end, t, h, source, only.solve)
    flows = early * start.flows + tau * end.flows
    return Step(end, flows, balance(system, end, base + tau * end.power), error, "")


def _first_order(
    system: System, start: Point, end: Point, t: float, h: float, source: Array, solve: Solve
) -> float:
    """h^2/2 y'' by the difference of the powers."""
    return damped(solve, system, 0.5 * h * (end.power - start.power))


def _second_order(
    system: System, start: Point, end: Point, t: float, h: float, source: Array, solve: Solve
) -> float:
    """Trapezoidal rule against Simpson's, h^3/12 y''', with a middle that Hermite's cubic gives."""
    middle = 0.5 * (start.T + end.T)
    middle[system.free] += solve(0.125 * h * (start.power - end.power)[system.free])
    nodes, values = system.given_at(t + 0.5 * h)
    middle[nodes] = values
    power = evaluate(system, middle, t + 0.5 * h, source).power
    return damped(solve, system, h / 3.0 * (start.power + end.power - 2.0 * power))


backward_euler = partial(step, 1.0)
crank_nicolson = partial(step, 0.5)
