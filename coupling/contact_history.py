"""What becomes of the accepted steps of a window: histories of contacts, onsets and releases."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics import march

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

RELEASE, ONSET = 0, 1
"""Kinds of events."""
REGIMES = 4
MANY = 8
"""Contacts of a scene up to which each step of each of them is kept."""
KEPT = 200_000
"""Rows that are kept of more contacts, of all together over a run, about."""
HALVINGS = 60


class Steps(NamedTuple):
    """The accepted steps of a window.

    times : (k + 1,) float [s]  beginning of the window, then the end of each step
    response : (k + 1, n_c, columns) float  see ``mechanics.march``, that of the beginning first
    approach : (k + 1, n_c) float [m/s]  approach speed of running impacts; 0 where there is none
    """

    times: Array
    response: Array
    approach: Array

    @property
    def force(self) -> Array:
        """(k + 1, n_c) float [N]  normal forces."""
        return self.response[..., march.ELASTIC] + self.response[..., march.DISSIPATIVE]


class Events(NamedTuple):
    """Onsets and releases in the order of time.

    time : (e,) float [s];  contact : (e,) int;  kind : (e,) int  ONSET or RELEASE
    speed : (e,) float [m/s]  of approach or separation, not negative
    row : (e,) int  the step at whose end, or in which, it happened
    """

    time: Array
    contact: Indices
    kind: NDArray[np.int8]
    speed: Array
    row: Indices


NONE = Events(
    np.zeros(0), np.zeros(0, np.intp), np.zeros(0, np.int8), np.zeros(0), np.zeros(0, np.intp)
)
"""No events."""


def events(steps: Steps) -> Events:
    """Onsets and releases, located where a cubic through both ends of a step passes zero.

    The integrator ends long steps where an impact begins; short ones contain it.
    """
    runs = steps.approach != 0.0
    row, contact = np.nonzero(runs[1:] != runs[:-1])
    if not row.size:
        return NONE
    begins = runs[row + 1, contact]
    time, rate = _passing(steps, row, contact, np.where(begins, -1.0, 1.0))
    speed = np.where(begins, steps.approach[row + 1, contact], -rate)
    order = np.lexsort((contact, time))
    speed, kind = np.maximum(speed, 0.0), begins.astype(np.int8)
    return Events(time[order], contact[order], kind[order], speed[order], row[order])


def _passing(steps: Steps, row: Indices, contact: Indices, sign: Array) -> tuple[Array, Array]:
    """Time [s] and rate [m/s] where depth times sign falls through zero within the given steps.

    A depth that has passed before counts at the beginning of its step, one that does not pass at
    the end.
    """
    t0, t1 = steps.times[row], steps.times[row + 1]
    d0, d1 = (sign * steps.response[row + i, contact, march.DEPTH] for i in (0, 1))
    h = t1 - t0
    v0, v1 = (sign * h * steps.response[row + i, contact, march.DEPTH_RATE] for i in (0, 1))
    lower, upper = np.zeros(len(row)), np.ones(len(row))
    for _ in range(HALVINGS):
        s = 0.5 * (lower + upper)
        deep = _cubic(s, d0, d1, v0, v1) > 0.0
        lower, upper = np.where(deep, s, lower), np.where(deep, upper, s)
    s = np.where(d0 <= 0.0, 0.0, np.where(d1 > 0.0, 1.0, upper))
    slope = 6.0 * (d1 - d0) * s * (1.0 - s)
    slope += v0 * (1.0 - s) * (1.0 - 3.0 * s) + v1 * s * (3.0 * s - 2.0)
    return t0 + s * h, sign * slope / h


def _cubic(s: Array, d0: Array, d1: Array, v0: Array, v1: Array) -> Array:
    """Hermite's interpolation between values d and slopes v, 0 <= s <= 1."""
    r = 1.0 - s
    return r * r * ((1.0 + 2.0 * s) * d0 + s * v0) + s * s * ((1.0 + 2.0 * r) * d1 - r * v1)


def summary(
    steps: Steps, regime: NDArray[np.int8], found: Events, lost: Array
) -> dict[str, NDArray]:
    """Counts and totals of a window, (n_c,) each.

    regime : (k, n_c)  of the steps, each of which it holds for
    lost : (n_c, 2) float [J]  normal dissipation and frictional work
    """
    contacts = steps.approach.shape[1]
    sizes = np.diff(steps.times)
    shares = np.stack([sizes @ (regime == code) for code in range(REGIMES)], axis=1)
    onsets = found.contact[found.kind == ONSET]
    return {
        "impacts": np.bincount(onsets, minlength=contacts),
        "peak_force": steps.force[1:].max(axis=0, initial=0.0),
        "shares": shares / sizes.sum(),
        "friction_work": lost[:, 1],
        "hysteresis": lost[:, 0],
    }


def kept_rows(steps: Steps, found: Events, most: int | None) -> list[Indices]:
    """Steps of each contact that are recorded: all, or about ``most``.

    Those are the ones of largest force in as many parts of the window, and all with an event.
    """
    contacts, count = steps.approach.shape[1], len(steps.times) - 1
    if most is None or count <= most:
        return [np.arange(count)] * contacts
    edges = np.arange(most + 1) * count // most
    force = steps.force[1:]
    strongest = np.array([a + force[a:b].argmax(axis=0) for a, b in pairwise(edges)])
    return [
        np.union1d(strongest[:, j], found.row[found.contact == j]).astype(np.intp)
        for j in range(contacts)
    ]


def most_rows(contacts: int, windows: int) -> int | None:
    """Steps of each contact and window that are recorded; None: all."""
    return None if contacts <= MANY else max(1, KEPT // (contacts * windows))
