"""One coupling window: who computes first, and what is handed over.

``serial``     heat with the friction of the last window, then motion (Hua et al. 2026, Sec. 3).
``parallel``   both from what the last window left: heat with its friction, motion with
               temperatures that go on changing as they did. Neither waits for the other.
``corrected``  heat with predicted friction, motion, then heat again with the friction that the
               motion released: one more thermal solve, second order in the window, and heat
               that is deposited in the window where it arose. Heat of deformation of a body that
               cannot expand follows the temperature at once: there one correction leaves an error
               of first order, E alpha^2 T/(rho c) times the prediction's (aluminium: .01).
``iterated``   the last two of these again and again, until neither temperatures nor heat change
               any more: ``coupling.iteration``.

Both sides may take as many steps of their own in a window as they like (sub-cycling): motion sees
temperatures that change linearly through it, heat sees the mean power of it. Work and heat are
counted in joules, so that what one side gives is what the other receives, whatever their steps.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from coupling.acceleration import Columns
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


class Exchange(NamedTuple):
    """How heat and motion agreed in the last window, and what the next one needs to know of it.

    expected : (n,) float [K]  temperatures that were predicted for its end: see ``window_error``
    rate : (n,) float [K/s]  mean rate of the temperatures
    heat_error : float [J]  heat received less heat released, summed over the temperatures
    iterations : int  times that motion was computed in it: 1 unless iterated
    total : int  and in all windows so far
    growth : int  the next window may be 2**growth times as long
    columns : changes seen by the quasi-Newton iteration
    """

    expected: Array = np.zeros(0)
    rate: Array = np.zeros(0)
    heat_error: float = 0.0
    iterations: int = 0
    total: int = 0
    growth: int = 1
    columns: Columns = Columns.none()

    @classmethod
    def none(cls, T: Array) -> "Exchange":
        """Before the first window."""
        return cls(T.copy(), np.zeros_like(T), columns=Columns.none(len(T)))


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
    exchange : how both sides agreed in the last window
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
    exchange: Exchange = Exchange()

    @property
    def window_error(self) -> float:
        """[K] largest difference between temperatures at the end of the last window and those
        that were predicted for it.

        It estimates the error of the prediction, which is of second order in the window, and so
        is larger than that of ``corrected`` and ``iterated``, whose temperatures it corrects.

        The prediction is what the motion was computed with (``corrected``, ``parallel``), the first
        of all that it was computed with (``iterated``), or, where both are the same (``serial``),
        the temperatures going on as before.
        """
        return float(np.abs(self.T - self.exchange.expected).max(initial=0.0))


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
    return Coupled(T, motion, none, none.copy(), 0.0, 0.0, {}, outside, 0.0, Exchange.none(T))


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
    T, flows, why = heated(pair, state, t, h, state.pending, state.outside)
    if why:
        return None, why
    moved, why = moving(pair, state, t, h, T, observe)
    if moved is None:
        return None, why
    left = Left(T, flows, state.pending, moved.nodal, onward(state, h))
    return following(state, h, moved, left), ""


def parallel(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Deposit what the last window released; move as if temperatures went on as they did."""
    expected = onward(state, h)
    T, flows, why = heated(pair, state, t, h, state.pending, state.outside)
    if why:
        return None, why
    moved, why = moving(pair, state, t, h, expected, observe)
    if moved is None:
        return None, why
    left = Left(T, flows, state.pending, moved.nodal, expected)
    return following(state, h, moved, left), ""


def corrected(pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
    """Predict the heat, move, and deposit what the motion released."""
    guess, _, why = heated(pair, state, t, h, h * state.power, state.outside)
    if why:
        return None, why
    moved, why = moving(pair, state, t, h, guess, observe)
    if moved is None:
        return None, why
    T, flows, why = heated(pair, state, t, h, moved.nodal, moved.outside)
    if why:
        return None, why
    left = Left(T, flows, moved.nodal, np.zeros_like(T), guess)
    return following(state, h, moved, left), ""


SCHEMES: dict[str, Callable[[Pair, Coupled, float, float, Observe], Result]] = {
    "serial": serial,
    "parallel": parallel,
    "corrected": corrected,
    "isothermal": isothermal,
}
"""Schemes without settings, by name; ``coupling.iteration`` has the other."""


# -- what schemes are made of ------------------------------------------------------------------


class Moved(NamedTuple):
    """What a window's motion left: a state, heat (n,) [J], and what it decided for the heat."""

    motion: Any
    friction: Array
    elastic: Array
    outside: Outside

    @property
    def nodal(self) -> Array:
        """(n,) [J] released in all."""
        return self.friction + self.elastic


class Left(NamedTuple):
    """What the heat of a window leaves.

    T : (n,) [K]; flows [J] through boundaries
    deposited, pending : (n,) [J]
    expected : (n,) [K]  temperatures as they were predicted
    """

    T: Array
    flows: Mapping[str, float]
    deposited: Array
    pending: Array
    expected: Array


def onward(state: Coupled, h: float) -> Array:
    """(n,) [K] after ``h``, if temperatures go on as in the last window."""
    return state.T + h * state.exchange.rate


def heated(
    pair: Pair, state: Coupled, t: float, h: float, heat: Array, outside: Outside
) -> tuple[Array, Mapping[str, float], str]:
    """Temperatures after the window, flows [J], "" or the reason; ``heat`` (n,) [J] deposited."""
    assert pair.heat_solver is not None
    held = frozenset() if pair.surroundings is None else pair.surroundings.held
    between = {
        name: (value if name in held else state.outside[name], value)
        for name, value in outside.items()
    }
    T, flows, why = pair.heat_solver.advance(state.T, t, h, heat, between)
    return T, flows, why and f"heat: {why}"


def moving(
    pair: Pair, state: Coupled, t: float, h: float, T: Array, observe: Observe
) -> tuple[Moved | None, str]:
    """Motion through the window, at whose end temperatures are ``T`` (n,); "" or the reason."""
    read, around, rows = pair.transfer.read, pair.surroundings, Rows(observe)
    motion, heat, why = pair.motion_solver.advance(
        state.motion, h, read(state.T), read(T), observe if around is None else rows
    )
    if why:
        return None, f"motion: {why}"
    friction = pair.transfer.deposit(heat)
    if around is None:
        return Moved(motion, friction, np.zeros_like(friction), {}), ""
    released = around.released(state.motion, motion, state.T, T)
    elastic = np.zeros_like(friction) if released is None else released
    outside = around.after(t, h, state, motion, T, rows.kept)
    return Moved(motion, friction, elastic, outside), ""


class Rows:
    """Observer that keeps what it sees and passes it on."""

    def __init__(self, observe: Observe = None) -> None:
        self.kept: list[Any] = []
        self._observe = observe

    def __call__(self, rows: Any) -> None:
        self.kept.append(rows)
        if self._observe is not None:
            self._observe(rows)


def following(state: Coupled, h: float, moved: Moved, left: Left) -> Coupled:
    """State after a window of length ``h`` that began in ``state``."""
    flows = {name: state.flows.get(name, 0.0) + value for name, value in left.flows.items()}
    before = state.exchange
    exchange = Exchange(
        left.expected, (left.T - state.T) / h,
        float(np.abs(left.deposited - moved.nodal).sum()), 1, before.total + 1, 1, before.columns,
    )  # fmt: skip
    return Coupled(
        left.T, moved.motion, moved.nodal / h, left.pending,
        state.released + float(moved.friction.sum()),
        state.deposited + float(left.deposited.sum()), flows,
        moved.outside, state.elastic + float(moved.elastic.sum()), exchange,
    )  # fmt: skip
