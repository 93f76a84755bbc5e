"""One coupling window: who computes first, and what is handed over.

``serial``     heat with the friction of the last window, then motion (Hua et al. 2026, Sec. 3).
``corrected``  heat with predicted friction, motion, then heat again with the friction that the
               motion released: one more thermal solve, second order in the window, and heat
               that is deposited in the window where it arose.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from coupling.protocols import MechanicalSolver, ThermalSolver
from coupling.transfer import Transfer

Array = NDArray[np.float64]
Observe = Callable[..., None] | None


Outside = Mapping[str, Array]
"""What motion and time decide for the heat, by the name of condition or link, at a time."""


class Surroundings(Protocol):
    """What reaches the heat besides friction."""

    held: frozenset[str]
    """Names whose value is the mean of a window; the others go linearly through it."""

    def at(self, t: float, motion: Any, T: Array) -> Outside:
        """Of a state at the start of the run; ``T`` (n,) [K] nodal temperatures."""
        ...

    def after(
        self, t: float, h: float, before: "Coupled", motion: Any, T: Array, rows: Sequence[Any]
    ) -> Outside:
        """At the end of a window of length ``h`` from ``before`` at ``t`` on, with its ``rows``."""
        ...

    def released(self, before: Any, after: Any, T0: Array, T1: Array) -> Array | None:
        """(n,) [J] of heat that deformation releases; None where that is not asked for."""
        ...


class Pair(NamedTuple):
    """The two solvers and what connects them; ``heat_solver`` None: a scene without heat.

    surroundings : None where nothing but friction passes from motion to heat
    """

    heat_solver: ThermalSolver | None
    motion_solver: MechanicalSolver
    transfer: Transfer
    surroundings: Surroundings | None = None


class Coupled(NamedTuple):
    """State of a coupled run.

    T : (n,) float [K]  nodal temperatures
    motion : the mechanical state
    power : (n,) float [W]  mean frictional heating over the last window
    pending : (n,) float [J]  released, and not yet deposited
    released, deposited : float [J]  frictional heat so far
    flows : mapping  heat [J] that entered through each boundary so far
    outside : mapping  what motion and time decided for the heat, at this time
    elastic : float [J]  heat that deformation released so far
    """

    T: Array
    motion: Any
    power: Array
    pending: Array
    released: float
    deposited: float
    flows: Mapping[str, float]
    outside: Outside
    elastic: float


Result = tuple[Coupled | None, str]


def initial(pair: Pair, steady: bool = False, settle: bool = False) -> Coupled:
    """State of both solvers at t = 0. ValueError with the reason when there is none.

    steady : the temperatures are those that the conditions of t = 0 hold
    settle : the motion begins in equilibrium, at rest unless velocities are given
    """
    T = np.zeros(0) if pair.heat_solver is None else pair.heat_solver.initial()
    rest = pair.transfer.read(T)
    motion = pair.motion_solver.initial(rest)
    if steady:
        T = settled(pair, T, 0.0, motion)
    if steady or settle:
        motion = pair.motion_solver.initial(pair.transfer.read(T), rest if settle else None)
    outside = {} if pair.surroundings is None else pair.surroundings.at(0.0, motion, T)
    none = np.zeros_like(T)
    return Coupled(T, motion, none, none.copy(), 0.0, 0.0, {}, outside, 0.0)


def settled(pair: Pair, T: Array, t: float, motion: Any) -> Array:
    """(n,) [K] that the conditions of time ``t`` hold in the pose of a motion.

    T : (n,) float [K]  first guess
    """
    assert pair.heat_solver is not None
    outside = {} if pair.surroundings is None else pair.surroundings.at(t, motion, T)
    T, _, why = pair.heat_solver.steady(T, t, outside)
    if why:
        raise ValueError(f"heat: {why}")
    return T


def isothermal(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Motion alone at the temperatures of the start."""
    sections = pair.transfer.read(state.T)
    motion, heat, why = pair.motion_solver.advance(state.motion, h, sections, sections, observe)
    if why:
        return None, why
    return state._replace(motion=motion, released=state.released + float(heat.sum())), ""


def serial(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Deposit what the last window released, then move."""
    T, flows, why = _heat(pair, state, t, h, state.pending, state.outside)
    if why:
        return None, why
    moved, why = _move(pair, state, t, h, T, observe)
    if moved is None:
        return None, why
    pending = moved.friction + moved.elastic
    return _next(state, T, moved, flows, h, state.pending, pending), ""


def corrected(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Predict the heat, move, and deposit what the motion released."""
    guess, _, why = _heat(pair, state, t, h, h * state.power, state.outside)
    if why:
        return None, why
    moved, why = _move(pair, state, t, h, guess, observe)
    if moved is None:
        return None, why
    nodal = moved.friction + moved.elastic
    T, flows, why = _heat(pair, state, t, h, nodal, moved.outside)
    if why:
        return None, why
    return _next(state, T, moved, flows, h, nodal, np.zeros_like(nodal)), ""


SCHEMES = {"serial": serial, "corrected": corrected, "isothermal": isothermal}


class _Moved(NamedTuple):
    """What a window's motion left: a state, heat (n,) [J], and what it decided for the heat."""

    motion: Any
    friction: Array
    elastic: Array
    outside: Outside


def _heat(
    pair: Pair, state: Coupled, t: float, h: float, heat: Array, outside: Outside
) -> tuple[Array, Mapping[str, float], str]:
    assert pair.heat_solver is not None
    held = frozenset() if pair.surroundings is None else pair.surroundings.held
    between = {
        name: (value if name in held else state.outside[name], value)
        for name, value in outside.items()
    }
    T, flows, why = pair.heat_solver.advance(state.T, t, h, heat, between)
    return T, flows, why and f"heat: {why}"


def _move(
    pair: Pair, state: Coupled, t: float, h: float, T: Array, observe: Observe
) -> tuple[_Moved | None, str]:
    read, around, rows = pair.transfer.read, pair.surroundings, _Rows(observe)
    motion, heat, why = pair.motion_solver.advance(
        state.motion, h, read(state.T), read(T), observe if around is None else rows
    )
    if why:
        return None, f"motion: {why}"
    friction = pair.transfer.deposit(heat)
    if around is None:
        return _Moved(motion, friction, np.zeros_like(friction), {}), ""
    released = around.released(state.motion, motion, state.T, T)
    elastic = np.zeros_like(friction) if released is None else released
    outside = around.after(t, h, state, motion, T, rows.kept)
    return _Moved(motion, friction, elastic, outside), ""


class _Rows:
    """Observer that keeps what it sees and passes it on."""

    def __init__(self, observe: Observe) -> None:
        self.kept: list[Any] = []
        self._observe = observe

    def __call__(self, rows: Any) -> None:
        self.kept.append(rows)
        if self._observe is not None:
            self._observe(rows)


def _next(
    state: Coupled,
    T: Array,
    moved: _Moved,
    flows: Mapping[str, float],
    h: float,
    deposited: Array,
    pending: Array,
) -> Coupled:
    total = {name: state.flows.get(name, 0.0) + value for name, value in flows.items()}
    nodal = moved.friction + moved.elastic
    return Coupled(
        T, moved.motion, nodal / h, pending,
        state.released + float(moved.friction.sum()),
        state.deposited + float(deposited.sum()), total,
        moved.outside, state.elastic + float(moved.elastic.sum()),
    )  # fmt: skip
