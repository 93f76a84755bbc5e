"""SDIRK2 of Alexander (1977): two stages, L-stable, stiffly accurate, of order 2."""

from math import sqrt

from thermal.stages import Array, Point, Step, System, balance, damped, failed, stage

GAMMA = 1.0 - 1.0 / sqrt(2.0)
# The local error of y' = lambda y is (1/3 - gamma) h^3 y'''. The powers at the start and the two
# stages combine to F(gamma) - (1 - gamma) F(0) - gamma F(1) = 3/2 (1/3 - gamma) h^2 y''' there;
# for y' = f(t) the same combination over-estimates the error by 6.8.
ERROR = 2.0 / 3.0
ORDER = 2


def step(system: System, start: Point, t: float, h: float, source: Array, control: bool) -> Step:
    """From ``start`` at ``t`` to ``t + h``; ``control``: the error is estimated."""
    tau = GAMMA * h
    first = stage(system, start.T, start.heat, t + tau, tau, source, None)
    if first.why:
        return failed(start, first.why)
    early = (1.0 - GAMMA) * h
    base = start.heat + early * first.point.power
    second = stage(system, first.point.T, base, t + h, tau, source, first.solve)
    if second.why or second.solve is None:
        return failed(start, second.why)
    middle, end = first.point, second.point
    error = 0.0
    if control:
        defect = middle.power - (1.0 - GAMMA) * start.power - GAMMA * end.power
        error = damped(second.solve, system, ERROR * h * defect)
    flows = early * middle.flows + tau * end.flows
    return Step(end, flows, balance(system, end, base + tau * end.power), error, "")
