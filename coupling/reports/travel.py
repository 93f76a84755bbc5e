"""Motions of small models, with what they took and how they ended, whether well or not."""

from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.verify.models import Model
from mechanics.dynamics import Control, State, Window, advance, initial_state
from mechanics.march import Rows
from mechanics.march.program import (
    CONTACT_ELASTIC,
    KINETIC,
    NUMERICAL,
    STRAIN,
    WORK_DRIVE,
    WORK_LOADS,
    WORK_THERMAL,
)
from mechanics.system import Coefficients

Array = NDArray[np.float64]


class Travel(NamedTuple):
    """A motion, step by step.

    t : (k,) [s]  ends of the steps, the start first
    q, v : (k, n);  ledger : (k, terms) [J]
    response : (k - 1, n_c, columns), approach : (k - 1, n_c) [m/s]  after each step
    steps, refused : int;  seconds : [s]  that it took
    why : reason why it stopped; "" if it did not
    """

    t: Array
    q: Array
    v: Array
    ledger: Array
    response: Array
    approach: Array
    steps: int
    refused: int
    seconds: float
    why: str

    @property
    def gained(self) -> float:
        """Most energy beyond that at the start and the work of loads, over the most stored [-]."""
        stored = self.ledger[:, [KINETIC, STRAIN, CONTACT_ELASTIC]].sum(axis=1)
        return float((stored - self.ledger[:, WORK_LOADS] - stored[0]).max() / stored.max())

    @property
    def excess(self) -> float:
        """Most energy beyond that at the start and the work of loads, drives and heat [J]."""
        stored = self.ledger[:, [KINETIC, STRAIN, CONTACT_ELASTIC]].sum(axis=1)
        works = self.ledger[:, [WORK_LOADS, WORK_DRIVE, WORK_THERMAL]].sum(axis=1)
        return float((stored - works - stored[0]).max())

    @property
    def made(self) -> float:
        """Energy that the scheme has made, or (negative) lost, over the most stored [-]."""
        stored = self.ledger[:, [KINETIC, STRAIN, CONTACT_ELASTIC]].sum(axis=1)
        return float(-self.ledger[-1, NUMERICAL] / stored.max())

    def onsets(self, contact: int = 0) -> Array:
        """Times [s] at which impacts begin."""
        running = self.approach[:, contact] != 0.0
        return self.t[1:][running & ~np.append(False, running[:-1])]


def travel(made: Model, end: float, control: Control, heated: Coefficients | None = None) -> Travel:
    """Move to ``end`` [s], or as far as it goes.

    heated : coefficients at the end, which change evenly; None: they stay
    """
    begun = perf_counter()
    state, why = initial_state(made.system, control, made.coef)
    if state is None:
        raise RuntimeError(why)
    kept: list[Rows] = []
    window = Window.between(made.system, 0.0, end, made.coef, heated)
    after, _, why = advance(made.system, control, state, window, kept.append, full=True)
    seconds = perf_counter() - begun
    n, m = made.system.n, state.motion
    if not kept:
        return _nowhere(state, why, seconds)
    rows = Rows._make(np.concatenate(parts) for parts in zip(*kept, strict=True))
    return Travel(
        np.append(0.0, rows.t), np.concatenate([m.q[None], rows.y[:, :n]]),
        np.concatenate([m.v[None], rows.v[:, :n]]),
        np.concatenate([state.ledger[None], rows.ledger]), rows.response, rows.approach,
        len(rows.t), int(after.counts[1]), seconds, why,
    )  # fmt: skip


def _nowhere(state: State, why: str, seconds: float) -> Travel:
    """Not one step was possible."""
    m, none = state.motion, np.zeros((0, len(state.motion.approach)))
    return Travel(
        np.zeros(1), m.q[None], m.v[None], state.ledger[None], none[..., None], none, 0, 0, seconds,
        why,
    )  # fmt: skip
