"""TR-BDF2 for networks of heat capacities: mass h(T) per node, powers that depend on T and t.

Trapezoidal rule to t + gamma h, then the second backward difference formula to t + h, with
gamma = 2 - sqrt(2) (Bank et al. 1985): L-stable, of order 2, one matrix form for both stages.
Written for the stored heat, so that the balance of every step closes to round-off. Steps are
the interval halved as often as the local error asks for.
"""

from math import sqrt
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

GAMMA = 2.0 - sqrt(2.0)
EARLY = 1.0 / (2.0 * (2.0 - GAMMA))  # weight of the powers at t and at t + gamma h
LATE = 0.5 * GAMMA  # weight of the power at t + h
# Local error, Bank et al. (1985): 2 k h (F0/gamma - F1/(gamma (1 - gamma)) + F2/(1 - gamma))
K = (-3.0 * GAMMA**2 + 4.0 * GAMMA - 2.0) / (12.0 * (2.0 - GAMMA))

HALVINGS = 30
STEPS = 10_000  # in one interval, tried
ITERATIONS = 15


class Network(Protocol):
    """What is integrated."""

    free: Indices

    def impose(self, T: Array, t: float) -> Array:
        """Copy of T with the prescribed temperatures of time t."""
        ...

    def heat(self, T: Array) -> Array:
        """(n,) [J]"""
        ...

    def power(self, T: Array, t: float) -> tuple[Array, Array]:
        """(n,) [W] into each node, (m,) [W] through each boundary."""
        ...

    def jacobian(self, T: Array, tau: float) -> csc_array:
        """dE/dT - tau dF/dT of the free nodes."""
        ...

    def fault(self, T: Array) -> str:
        """Why temperatures are of no use, or ""."""
        ...


class State(NamedTuple):
    """Temperatures [K] with the heat [J] they stand for and the powers [W] at their time."""

    T: Array
    heat: Array
    power: Array
    flows: Array


class Result(NamedTuple):
    """End of an interval; heat [J] through boundaries (m,) and to prescribed nodes (n,)."""

    T: Array
    flows: Array
    reactions: Array
    why: str


def integrate(
    network: Network, T: Array, t: float, h: float, source: Array, tolerance: float
) -> Result:
    """Temperatures at ``t + h``; ``source`` (n,) [W] is constant, ``tolerance`` in K per step."""
    state = _state(network, network.impose(T, t), t, source)._replace(heat=network.heat(T))
    flows, reactions = np.zeros_like(state.flows), np.zeros_like(T)
    why = _problem(network, state.T, t)
    level, position = 0, 0  # position counts steps of h / 2**level
    for _ in range(0 if why else STEPS):
        dt = h / 2**level
        new, error, why = _step(network, state, t + position * dt, dt, source)
        if why or error > tolerance:
            level, position = level + 1, 2 * position
            if level > HALVINGS:
                why = why or f"t = {t + position * dt / 2:g} s: steps cannot be made small enough"
                break
            continue
        given = EARLY * (state.power + new.middle.power) + LATE * new.end.power
        flows += dt * (EARLY * (state.flows + new.middle.flows) + LATE * new.end.flows)
        reactions += new.end.heat - state.heat - dt * given
        state, position = new.end, position + 1
        if position == 2**level:
            break
        if error < tolerance / 16.0 and level > 0 and position % 2 == 0:
            level, position = level - 1, position // 2
    else:
        why = why or f"t = {t:g} s: more than {STEPS} steps within {h:g} s"
    reactions[network.free] = 0.0
    return Result(state.T, flows, reactions, why)


class _Stages(NamedTuple):
    middle: State
    end: State


def _step(
    network: Network, start: State, t: float, h: float, source: Array
) -> tuple[_Stages, float, str]:
    tau = LATE * h
    base = start.heat + tau * start.power
    middle, why = _solve(network, start.T, base, t + GAMMA * h, tau, source)
    if why:
        return _Stages(start, start), np.inf, why
    base = start.heat + EARLY * h * (start.power + middle.power)
    end, why = _solve(network, middle.T, base, t + h, tau, source)
    if why:
        return _Stages(start, start), np.inf, why
    rough = start.power / GAMMA - middle.power / (GAMMA * (1.0 - GAMMA)) + end.power / (1.0 - GAMMA)
    free = network.free
    error = spsolve(network.jacobian(end.T, tau), 2.0 * K * h * rough[free]) if len(free) else rough
    return _Stages(middle, end), float(np.abs(error[: len(free)]).max(initial=0.0)), ""


def _solve(
    network: Network, guess: Array, base: Array, t: float, tau: float, source: Array
) -> tuple[State, str]:
    """Newton's method for E(T) = base + tau F(T, t)."""
    free = network.free
    T, last = network.impose(guess, t), np.inf
    for _ in range(ITERATIONS):
        state = _state(network, T, t, source)
        residual = (state.heat - base - tau * state.power)[free]
        if len(free) == 0:
            return state, _problem(network, T, t)
        if not np.isfinite(residual).all():
            break
        change = np.atleast_1d(spsolve(network.jacobian(T, tau), residual))
        size = np.abs(change).max() / max(1.0, np.abs(T).max())
        if size < 4e-16 or 0.1 * last < size < 1e-10:
            return state, _problem(network, T, t)
        T = T.copy()
        T[free] -= change
        last = size
    return state, f"t = {t:g} s: the heat network did not converge"


def _state(network: Network, T: Array, t: float, source: Array) -> State:
    power, flows = network.power(T, t)
    return State(T, network.heat(T), power + source, flows)


def _problem(network: Network, T: Array, t: float) -> str:
    why = network.fault(T) if np.isfinite(T).all() else "a temperature is not a number"
    return f"t = {t:g} s: {why}" if why else ""
