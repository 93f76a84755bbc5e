"""Times of the parts of a step, each the least of several repeats.

The least is the time without disturbance; what a busy machine adds is no property of the program.
Compiling and building are over before anything is timed.
"""

from collections.abc import Callable
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.dynamics import Control, State, Window, advance, initial_state
from mechanics.schemes import Scheme
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

ROOM = 293.15
"""Temperature of all sections [K]."""


def least(work: Callable[[], Any], repeats: int = 7, budget: float = 3.0) -> float:
    """Least time [s] of up to ``repeats`` calls within a ``budget`` [s], after one to warm up."""
    work()
    best, begun = np.inf, perf_counter()
    for _ in range(repeats):
        start = perf_counter()
        work()
        best = min(best, perf_counter() - start)
        if perf_counter() - begun > budget:
            break
    return float(best)


class Parts(NamedTuple):
    """Times [s] of one evaluation each."""

    residual: float
    tangent: float
    refactor: float
    solve: float

    @property
    def floor(self) -> float:
        """Least time that an implicit step can take [s]: one residual and one solution."""
        return self.residual + self.solve


def room(system: System) -> Coefficients:
    """Coefficients at room temperature."""
    return system.coefficients(np.tile([ROOM, 0.0, 0.0], (len(system.layout.x), 1)))


def factors(h: float, scheme: Scheme) -> Factors:
    """Factors of the matrix of a step ``h`` [s] (Chung & Hulbert 1993)."""
    alpha_m, alpha_f = scheme.alphas
    mass = (1.0 - alpha_m) / (scheme.beta * h * h)
    return Factors(mass, 1.0 - alpha_f, (1.0 - alpha_f) * scheme.gamma / (scheme.beta * h))


def parts(system: System, h: float, repeats: int = 7) -> Parts:
    """Times of the parts of a step of ``h`` [s]."""
    coef, y = room(system), system.unknowns(system.layout.q0)
    v, of_step = np.zeros_like(y), factors(h, Scheme())
    data = system.matrix(y, v, 0.0, coef, of_step)
    solve = system.factorise(data)
    assert solve is not None
    b = np.ones(len(y))
    return Parts(
        least(lambda: system.residual(y, v, 0.0, coef), repeats),
        least(lambda: system.matrix(y, v, 0.0, coef, of_step), repeats),
        least(lambda: system.factorise(data), repeats),
        least(lambda: solve(b), repeats),
    )


class Run(NamedTuple):
    """What a stretch of steps took.

    seconds : [s]  per step;  corrections : per step;  state : at its end
    """

    seconds: float
    steps: int
    corrections: float
    state: State


def fixed(h: float, scheme: Scheme | None = None) -> Control:
    """Control that keeps the step at ``h`` [s]."""
    return Control(np.inf, h, h, scheme or Scheme())


def march(system: System, control: Control, end: float, repeats: int = 3, warm: float = 0.0) -> Run:
    """Time of the steps up to ``end`` [s], after ``warm`` [s] of motion that do not count.

    Raises
    ------
    RuntimeError : with the reason why the motion cannot go on
    """
    coef = room(system)
    start, why = initial_state(system, control, coef)
    if start is None:
        raise RuntimeError(why)
    start = _went(system, control, start, warm, coef) if warm else start
    best, state = np.inf, start
    for _ in range(repeats):
        begun = perf_counter()
        state = _went(system, control, start, end, coef)
        best = min(best, perf_counter() - begun)
    accepted, _, corrections = (state.counts - start.counts)[:3]
    return Run(best / accepted, int(accepted), corrections / accepted, state)


def _went(system: System, control: Control, state: State, h: float, coef: Coefficients) -> State:
    window = Window.between(system, state.motion.t, h, coef, None)
    state, _, why = advance(system, control, state, window)
    if why:
        raise RuntimeError(why)
    return state


def exponent(sizes: list[float], times: list[float]) -> float:
    """Power with which times grow with sizes, by least squares of the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
