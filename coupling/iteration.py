"""The implicit exchange: heat and motion of a window repeated until they agree.

The unknown is the temperature at the end of the window: motion from the saved state with it, heat
from the saved state with what that motion released, and the temperature found is accelerated
(``coupling.acceleration``). What is kept is the temperature that the heat of the last motion made:
the balance of heat closes to round-off however loose the tolerances are.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.acceleration import KINDS, Acceleration
from coupling.manager import (
    Coupled,
    Left,
    Moved,
    Observe,
    Outside,
    Pair,
    Result,
    Rows,
    following,
    heated,
    moving,
    onward,
)

Array = NDArray[np.float64]

LEAST = 1e-6
"""Changes are measured against those of the window, but not less than this part of the temperature,
or of the heat that was turned over [-]."""

UNSEEN = 1e-9
"""Of the stored heat: what is released beneath this is measured against it, lest rounding of the
temperatures, which changes what comes to rest, is taken for disagreement [-]."""


class _Given(NamedTuple):
    """The exchanged fields: temperatures (n,) [K] to motion, heat (n,) [J] and more to heat."""

    T: Array
    heat: Array
    outside: Outside


class _Pass(NamedTuple):
    """One iteration: what motion left, and what heat made of it."""

    moved: Moved
    T: Array
    flows: Mapping[str, float]


class _Apart(NamedTuple):
    """Relative changes from iteration to iteration [-]."""

    temperature: float
    heat: float


@dataclass(frozen=True)
class Iterated:
    """The scheme ``iterated``; called like the others.

    temperature_tolerance, heat_tolerance : float [-]  change between iterations of what motion is
        given, over that in the window; of what heat is given, over all of it
    most : int  iterations, before the window is refused
    acceleration : in ``coupling.acceleration.KINDS``
    factor : float [-]  of the relaxation; the others begin with it
    reused : int  windows whose changes the quasi-Newton iteration knows
    """

    temperature_tolerance: float = 1e-4
    heat_tolerance: float = 1e-4
    most: int = 50
    acceleration: str = "quasi-newton"
    factor: float = 1.0
    reused: int = 2

    def __call__(self, pair: Pair, state: Coupled, t: float, h: float, observe: Observe) -> Result:
        """Iterate over one window; rows of the last iteration only are observed."""
        given = _guess(pair, state, t, h)
        columns = state.exchange.columns.for_window(h, self.reused, len(state.T))
        acceleration = KINDS[self.acceleration](self.factor, columns)
        expected, apart, count = given.T, _Apart(np.inf, np.inf), 0
        for count in range(1, self.most + 1):
            rows = Rows()
            now, why = _pass(pair, state, t, h, given.T, rows)
            if now is None:
                return None, why
            apart = _apart(pair, state, now, given)
            if self._agree(apart):
                _tell(observe, rows)
                left = Left(now.T, now.flows, now.moved.nodal, np.zeros_like(now.T), expected)
                return _counted(following(state, h, now.moved, left), count, acceleration), ""
            T = acceleration.next(given.T, now.T)
            if not np.all(np.isfinite(T)):
                break
            given = _Given(T, now.moved.nodal, now.moved.outside)
        return None, self._reason(apart, count)

    def _agree(self, apart: _Apart) -> bool:
        return apart.temperature <= self.temperature_tolerance and apart.heat <= self.heat_tolerance

    def _reason(self, apart: _Apart, count: int) -> str:
        return (
            f"heat and motion do not agree after {count} iterations: temperatures still "
            f"change by {apart.temperature:.2g} of what they change in the window "
            f"(temperature_tolerance {self.temperature_tolerance:g}), heat by {apart.heat:.2g} "
            f"(heat_tolerance {self.heat_tolerance:g})"
        )


def _guess(pair: Pair, state: Coupled, t: float, h: float) -> _Given:
    """To begin with: heat as in the window before."""
    heat = h * state.power
    T, _, why = heated(pair, state, t, h, heat, state.outside)
    return _Given(onward(state, h) if why else T, heat, state.outside)


def _counted(new: Coupled, count: int, acceleration: Acceleration) -> Coupled:
    """The state with the iterations that it took, and what they showed."""
    more = count - new.exchange.iterations
    exchange = new.exchange._replace(
        iterations=count, total=new.exchange.total + more, columns=acceleration.columns
    )
    return new._replace(exchange=exchange)


def _pass(
    pair: Pair, state: Coupled, t: float, h: float, given: Array, rows: Rows
) -> tuple[_Pass | None, str]:
    moved, why = moving(pair, state, t, h, given, rows)
    if moved is None:
        return None, why
    T, flows, why = heated(pair, state, t, h, moved.nodal, moved.outside)
    return (None, why) if why else (_Pass(moved, T, flows), "")


def _apart(pair: Pair, state: Coupled, now: _Pass, given: _Given) -> _Apart:
    """How far what both sides were given is from what they would be given next."""
    assert pair.heat_solver is not None
    change = float(np.abs(now.T - state.T).max(initial=0.0))
    least = LEAST * float(np.abs(now.T).max(initial=0.0))
    temperature = _share(float(np.abs(now.T - given.T).max(initial=0.0)), change, least)
    stored = pair.heat_solver.energy(now.T) - pair.heat_solver.energy(state.T)
    turned = abs(stored) + sum(map(abs, now.flows.values()))
    nodal = now.moved.nodal
    unseen = max(LEAST * turned, UNSEEN * abs(pair.heat_solver.energy(now.T)))
    heat = _share(float(np.abs(nodal - given.heat).sum()), float(np.abs(nodal).sum()), unseen)
    fields = [
        _share(_size(value - given.outside[name]), _size(value), LEAST * _size(given.outside[name]))
        for name, value in now.moved.outside.items()
    ]
    return _Apart(temperature, max([heat, *fields]))


def _share(part: float, whole: float, least: float) -> float:
    """``part`` of a whole; nothing is zero of it, and something infinitely much of nothing."""
    size = max(whole, least)
    if part == 0.0:
        return 0.0
    return part / size if size > 0.0 else np.inf


def _size(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _tell(observe: Observe, rows: Rows) -> None:
    """Pass on what the last iteration's motion showed."""
    if observe is not None:
        for row in rows.kept:
            observe(row)
