"""Heat by a participant in another process: the run's side of the words.

The words are preCICE's (Chourdakis et al. 2022): a participant *initialises* its mesh and data; in
each coupling *window* it is told to *write a checkpoint*, data are *written* to it, it *advances*,
data are *read* from it; where the window is repeated (halved, corrected, iterated) it is told to
*read its checkpoint* first. A message is described in ``coupling.wire``; each is answered before
the next is sent. The run speaks, the participant answers:

``initialize``  fields ``format`` (1), ``case`` (text of the case file, TOML, with its changes);
    answer ``mesh``: fields ``name``, ``regions`` (body or part -> numbers of its temperatures),
    ``problems`` (a sentence for each thing in the case that it cannot do; with any, the run does
    not begin), arrays ``x`` (n, 3) [m], ``T`` (n,) [K] at the start, ``shares.REGION`` (k,) area
    or volume of the temperatures of a region, where it has them.
``set_state``  fields ``t`` [s], array ``T``: go on from there (a resumed run).
``write_checkpoint``  keep the present state;  ``read_checkpoint``  return to it.
``write_data``  array ``heat`` (n,) [J] that friction deposits in the window, evenly; arrays
    ``start.NAME`` and ``end.NAME``: what motion decides for a condition or link, such as the
    conductance (1,) [W/K] of a joint, at both ends of the window.
``advance``  fields ``t``, ``h`` [s]; answer: fields ``why`` ("" or the reason it could not),
    ``flows`` [J] that entered through each condition.
``read_data``  answer: array ``T`` (n,) [K] at the end.
``steady``  fields ``t``, array ``T`` (first guess), arrays ``start.NAME``; answer: ``why``,
    ``flows`` [W], array ``T``.
``energy``  array ``T``; answer: fields ``energy`` [J].
``finalize``  the run has ended; no answer.
"""

import weakref
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling import wire
from coupling.wire import Message

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FORMAT = 1
"""Of the words above."""


class Instant(NamedTuple):
    """A state that the participant knows: a time [s] and its temperatures (n,) [K]."""

    t: float
    T: Array

    def is_at(self, t: float, T: Array) -> bool:
        """Whether it is that state, to the last bit."""
        return self.t == t and np.array_equal(self.T, T)


class ExternalHeat:
    """A ``ThermalSolver`` whose work another process does.

    Attributes
    ----------
    x : (n, 3) float [m]  reference positions
    regions : name -> its temperatures
    shares : region -> (k,) float  area or volume of its temperatures, as far as they are known
    name : what the participant calls itself
    """

    def __init__(self, address: str, patience: float, case: str) -> None:
        """ValueError with a line for each reason that the participant has for not taking part."""
        self._call = _Call(address, patience)
        mesh = self._call.ask("initialize", {"format": FORMAT, "case": case})
        problems = [str(p) for p in mesh.fields.get("problems", [])] or _faults(mesh)
        if problems:
            raise ValueError("\n".join(f"participant at {address}: {p}" for p in problems))
        self.x, self._start = mesh.arrays["x"], mesh.arrays["T"]
        self.name = str(mesh.fields["name"])
        self.regions: Mapping[str, Indices] = {
            str(k): np.asarray(v, np.intp) for k, v in mesh.fields["regions"].items()
        }
        prefix = "shares."
        self.shares: Mapping[str, Array] = {
            k.removeprefix(prefix): v for k, v in mesh.arrays.items() if k.startswith(prefix)
        }
        self._now: Instant | None = None
        self._kept: Instant | None = None

    def initial(self) -> Array:
        """(n,) [K]"""
        return self._start.copy()

    def advance(
        self,
        T: Array,
        t: float,
        h: float,
        heat: Array,
        outside: Mapping[str, tuple[Array, Array]] | None = None,
    ) -> tuple[Array, Mapping[str, float], str]:
        """One window; see ``ThermalSolver``."""
        given = outside or {}
        starts = {f"start.{name}": value for name, (value, _) in given.items()}
        ends = {f"end.{name}": value for name, (_, value) in given.items()}
        try:
            self._go_to(t, T)
            self._call.ask("write_data", {}, {"heat": heat, **starts, **ends})
            done = self._call.ask("advance", {"t": t, "h": h})
            new = self._call.ask("read_data").arrays["T"]
        except (OSError, KeyError) as error:
            self._now = self._kept = None
            return T, {}, f"participant at {self._call.address}: {error}"
        why = str(done.fields.get("why", "")) or _unfit(new, T)
        self._now = None if why else Instant(t + h, new)
        return new, _flows(done), why

    def steady(
        self, T: Array, t: float, outside: Mapping[str, Array] | None = None
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures that the conditions of ``t`` hold; see ``ThermalSolver``."""
        starts = {f"start.{name}": value for name, value in (outside or {}).items()}
        self._now = self._kept = None
        try:
            found = self._call.ask("steady", {"t": t}, {"T": T, **starts})
            new = found.arrays["T"]
        except (OSError, KeyError) as error:
            return T, {}, f"participant at {self._call.address}: {error}"
        return new, _flows(found), str(found.fields.get("why", "")) or _unfit(new, T)

    def energy(self, T: Array) -> float:
        """Stored heat [J]; not a number where the participant has gone."""
        try:
            return float(self._call.ask("energy", {}, {"T": T}).fields["energy"])
        except (OSError, KeyError):
            return np.nan

    def _go_to(self, t: float, T: Array) -> None:
        """Bring the participant to the start of a window, with a checkpoint there."""
        if self._kept is not None and self._kept.is_at(t, T):
            self._call.ask("read_checkpoint")
            return
        if self._now is None or not self._now.is_at(t, T):
            self._call.ask("set_state", {"t": t}, {"T": T})
        self._call.ask("write_checkpoint")
        self._kept = Instant(t, T.copy())


class _Call:
    """A line to the participant, which hears when it ends."""

    def __init__(self, address: str, patience: float) -> None:
        self.address = address
        try:
            self._there = wire.connect(address, patience)
        except OSError as error:
            text = f"nobody answers at {address} ({error.strerror or error})"
            raise ValueError(f"{text}; start the participant first") from None
        self._stream: Any = self._there.makefile("rwb")
        weakref.finalize(self, _finalize, self._there, self._stream)

    def ask(
        self,
        word: str,
        fields: Mapping[str, Any] | None = None,
        arrays: Mapping[str, Array] | None = None,
    ) -> Message:
        """The answer. OSError where there is none."""
        wire.send(self._stream, word, fields, arrays)
        answer = wire.receive(self._stream)
        if answer.word == "error":
            raise OSError(str(answer.fields.get("why", "it failed")))
        return answer


def _finalize(there: Any, stream: Any) -> None:
    """Say that the run has ended, and hang up."""
    with suppress(OSError, ValueError):  # it may have gone before
        wire.send(stream, "finalize")
    for thing in (stream, there):
        with suppress(OSError):
            thing.close()


def _flows(message: Message) -> dict[str, float]:
    return {str(name): float(value) for name, value in message.fields.get("flows", {}).items()}


def _unfit(T: Array, before: Array) -> str:
    """Why temperatures of the participant cannot be taken, or ""."""
    if T.shape != before.shape:
        return f"the participant returned {T.shape} temperatures for {before.shape}"
    return (
        "" if np.isfinite(T).all() else "the participant returned temperatures that are no numbers"
    )


def _faults(mesh: Message) -> list[str]:
    """What is wrong with a mesh."""
    missing = [key for key in ("x", "T") if key not in mesh.arrays]
    missing += [key for key in ("name", "regions") if key not in mesh.fields]
    if missing:
        return [f"its mesh has no {', '.join(missing)}"]
    n = len(mesh.arrays["T"])
    if mesh.arrays["x"].shape != (n, 3):
        return [f"x has shape {mesh.arrays['x'].shape} for {n} temperatures"]
    rows = [i for region in mesh.fields["regions"].values() for i in region]
    if not all(isinstance(i, int) and 0 <= i < n for i in rows):
        return [f"its regions name temperatures that do not exist (there are {n})"]
    return []
