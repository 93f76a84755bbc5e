"""A thermal solver of the program as a participant in a process of its own.

``thermobody participant CASE`` builds the heat of a case and answers the words of
``coupling.external_heat`` until the run ends. A run that is interrupted may call again.
"""

import tomllib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from coupling import wire
from coupling.external_heat import FORMAT, Instant
from coupling.scene import Scene
from coupling.wire import Array, Message

Answer = tuple[str, Mapping[str, Any], Mapping[str, Array]]

APART = (
    "title",
    "description",
    "output",
    "integrator",
    "coupling",
    "probe",
    "report",
    "crosscheck",
)
"""Tables in which the case of the run may differ from that of the participant."""


class Hosted:
    """A thermal solver that answers.

    solver : ThermalSolver
    shares : region -> (k,) float  area or volume of its temperatures
    scene : what it was built from
    """

    def __init__(self, solver: Any, shares: Mapping[str, Array], scene: Scene) -> None:
        self._solver, self._shares, self._scene = solver, shares, scene
        self._state = Instant(0.0, solver.initial())
        self._kept = self._state
        self._written: Mapping[str, Array] = {}
        self._answers: dict[str, Callable[[Message], Answer]] = {
            "initialize": self._initialize,
            "set_state": self._set_state,
            "write_checkpoint": self._write_checkpoint,
            "read_checkpoint": self._read_checkpoint,
            "write_data": self._write_data,
            "advance": self._advance,
            "read_data": self._read_data,
            "steady": self._steady,
            "energy": self._energy,
        }

    def answer(self, message: Message) -> Answer:
        """What to say to a message."""
        if message.word not in self._answers:
            return "error", {"why": f"unknown word '{message.word}'"}, {}
        try:
            return self._answers[message.word](message)
        except (KeyError, ValueError, TypeError) as error:
            return "error", {"why": f"{message.word}: {error}"}, {}

    def _initialize(self, message: Message) -> Answer:
        self._state = self._kept = Instant(0.0, self._solver.initial())
        fields = {
            "name": f"thermobody {self._scene.thermal.solver}" if self._scene.thermal else "",
            "regions": {name: rows.tolist() for name, rows in self._solver.regions.items()},
            "problems": _differences(message, self._scene),
        }
        shares = {f"shares.{name}": values for name, values in self._shares.items()}
        return "mesh", fields, {"x": self._solver.x, "T": self._state.T, **shares}

    def _set_state(self, message: Message) -> Answer:
        self._state = Instant(float(message.fields["t"]), message.arrays["T"])
        return "done", {}, {}

    def _write_checkpoint(self, message: Message) -> Answer:
        self._kept = self._state
        return "done", {}, {}

    def _read_checkpoint(self, message: Message) -> Answer:
        self._state = self._kept
        return "done", {}, {}

    def _write_data(self, message: Message) -> Answer:
        self._written = message.arrays
        return "done", {}, {}

    def _advance(self, message: Message) -> Answer:
        t, h = float(message.fields["t"]), float(message.fields["h"])
        outside = {
            name: (value, self._written[f"end.{name}"])
            for name, value in _prefixed(self._written, "start.").items()
        }
        T, flows, why = self._solver.advance(self._state.T, t, h, self._written["heat"], outside)
        self._state = Instant(t + h, np.asarray(T))
        return "done", {"why": why, "flows": dict(flows)}, {}

    def _read_data(self, message: Message) -> Answer:
        return "data", {}, {"T": self._state.T}

    def _steady(self, message: Message) -> Answer:
        outside = _prefixed(message.arrays, "start.")
        T, flows, why = self._solver.steady(
            message.arrays["T"], float(message.fields["t"]), outside
        )
        self._state = Instant(float(message.fields["t"]), T)
        return "done", {"why": why, "flows": dict(flows)}, {"T": T}

    def _energy(self, message: Message) -> Answer:
        return "done", {"energy": self._solver.energy(message.arrays["T"])}, {}


def serve(hosted: Hosted, here: Any) -> None:
    """Answer whoever calls at a listening socket, until one says that the run has ended."""
    ended = False
    while not ended:
        line, _ = here.accept()
        with line, line.makefile("rwb") as stream:
            ended = _talk(hosted, stream)


def _talk(hosted: Hosted, stream: Any) -> bool:
    """Whether the run has ended; no: the line is dead, and it may call again."""
    while True:
        try:
            message = wire.receive(stream)
            if message.word == "finalize":
                return True
            wire.send(stream, *hosted.answer(message))
        except OSError:
            return False


def _prefixed(arrays: Mapping[str, Array], prefix: str) -> dict[str, Array]:
    return {k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)}


def _differences(message: Message, scene: Scene) -> list[str]:
    """What the run's case says that the participant's does not, in sentences."""
    if message.fields.get("format") != FORMAT:
        return [f"it speaks format {FORMAT}, the run {message.fields.get('format')}"]
    mine, its = _essence(scene.text), _essence(str(message.fields.get("case", "")))
    odd = [name for name in mine | its if mine.get(name) != its.get(name)]
    return [f"its case has another [{name}] than the run" for name in odd]


def _essence(text: str) -> dict[str, Any]:
    """What heat depends upon."""
    tables = tomllib.loads(text)
    for name in APART:
        tables.pop(name, None)
    for table, keys in (("thermal", ("solver", "participant")), ("time", ("end",))):
        for key in keys:
            tables.get(table, {}).pop(key, None)
    return tables
