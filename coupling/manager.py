"""One coupling window: who computes first, and what is handed over.

``serial``     heat with the friction of the last window, then motion (Hua et al. 2026, Sec. 3).
``corrected``  heat with predicted friction, motion, then heat again with the friction that the
               motion released: one more thermal solve, second order in the window, and heat
               that is deposited in the window where it arose.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.protocols import MechanicalSolver, ThermalSolver
from coupling.transfer import Transfer

Array = NDArray[np.float64]
Observe = Callable[..., None] | None


class Pair(NamedTuple):
    """The two solvers and what connects them; ``heat_solver`` None: a scene without heat."""

    heat_solver: ThermalSolver | None
    motion_solver: MechanicalSolver
    transfer: Transfer


class Coupled(NamedTuple):
    """State of a coupled run.

    T : (n,) float [K]  nodal temperatures
    motion : the mechanical state
    power : (n,) float [W]  mean frictional heating over the last window
    pending : (n,) float [J]  released, and not yet deposited
    released, deposited : float [J]  frictional heat so far
    flows : mapping  heat [J] that entered through each boundary so far
    """

    T: Array
    motion: Any
    power: Array
    pending: Array
    released: float
    deposited: float
    flows: Mapping[str, float]


Result = tuple[Coupled | None, str]


def initial(pair: Pair) -> Coupled:
    """State of both solvers at t = 0."""
    T = np.zeros(0) if pair.heat_solver is None else pair.heat_solver.initial()
    motion = pair.motion_solver.initial(pair.transfer.read(T))
    return Coupled(T, motion, np.zeros_like(T), np.zeros_like(T), 0.0, 0.0, {})


def isothermal(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Motion alone at the temperatures of the start."""
    sections = pair.transfer.read(state.T)
    motion, heat, why = pair.motion_solver.advance(state.motion, h, sections, sections, observe)
    if why:
        return None, why
    return state._replace(motion=motion, released=state.released + float(heat.sum())), ""


def serial(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Deposit what the last window released, then move."""
    T, flows, why = _heat(pair, state, t, h, state.pending)
    if why:
        return None, why
    motion, nodal, why = _move(pair, state, h, T, observe)
    if why:
        return None, why
    return _next(state, T, motion, flows, h, nodal, state.pending, nodal), ""


def corrected(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Predict the heat, move, and deposit what the motion released."""
    guess, _, why = _heat(pair, state, t, h, h * state.power)
    if why:
        return None, why
    motion, nodal, why = _move(pair, state, h, guess, observe)
    if why:
        return None, why
    T, flows, why = _heat(pair, state, t, h, nodal)
    if why:
        return None, why
    return _next(state, T, motion, flows, h, nodal, nodal, np.zeros_like(nodal)), ""


SCHEMES = {"serial": serial, "corrected": corrected, "isothermal": isothermal}


def _heat(
    pair: Pair, state: Coupled, t: float, h: float, heat: Array
) -> tuple[Array, Mapping[str, float], str]:
    assert pair.heat_solver is not None
    T, flows, why = pair.heat_solver.advance(state.T, t, h, heat)
    return T, flows, why and f"heat: {why}"


def _move(
    pair: Pair, state: Coupled, h: float, T: Array, observe: Observe
) -> tuple[Any, Array, str]:
    read = pair.transfer.read
    motion, heat, why = pair.motion_solver.advance(state.motion, h, read(state.T), read(T), observe)
    return motion, pair.transfer.deposit(heat), why and f"motion: {why}"


def _next(
    state: Coupled,
    T: Array,
    motion: Any,
    flows: Mapping[str, float],
    h: float,
    nodal: Array,
    deposited: Array,
    pending: Array,
) -> Coupled:
    total = {name: state.flows.get(name, 0.0) + value for name, value in flows.items()}
    return Coupled(
        T, motion, nodal / h, pending,
        state.released + float(nodal.sum()), state.deposited + float(deposited.sum()), total,
    )  # fmt: skip
