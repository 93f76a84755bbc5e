"""The observer that turns states into rows of results.h5."""

from pathlib import Path
from typing import Any

import numpy as np

from coupling import error_estimate
from coupling.contact_history import events, kept_rows, most_rows, summary
from coupling.contacts import driven, history, losses, regimes
from coupling.manager import Coupled
from coupling.model import Model
from coupling.results import Recorder
from coupling.resume import memory
from mechanics.march import Rows


class Recording:
    """Rows of windows, ledger, probes, sky, contacts and frames.

    Histories of contacts have a row for each mechanical substep, of many contacts for some of them
    (``contact_history.kept_rows``); events are as many as happen; other tables have a row per
    window.
    """

    def __init__(self, model: Model, recorder: Recorder):
        self.model = model
        self.recorder = recorder
        self.folder: Path = recorder.path.parent
        self.substeps: list[Rows] = []
        self._most = most_rows(len(model.contacts), model.windows)

    def start(self, state: Coupled, tick: int, size: int) -> None:
        """Describe the groups and record the state at t = 0."""
        for name, attributes in self.model.body_attributes().items():
            self.recorder.describe_group(f"bodies/{name}", attributes)
        for name, attributes in self.model.contact_attributes().items():
            self.recorder.describe_group(f"joints/{name}", attributes)
        for name, elements in self.model.surfaces().items():
            self.recorder.append_many(name, elements)
        self._frame(state)
        self._probes(state)
        self._sky(state)
        self._state(state, tick, size)
        self.recorder.flush()

    def begin(self) -> None:
        """A window is attempted."""
        self.recorder.begin()
        self.substeps.clear()

    def observe(self, rows: Rows) -> None:
        """Mechanical substeps were accepted."""
        self.substeps.append(rows)

    def failed(self) -> None:
        """The attempt failed; nothing of it stays."""
        self.recorder.rollback()

    def commit(self, before: Coupled, window: Any, wall: float) -> None:
        """A window was finished."""
        state = window.state
        self._window(before, window, wall)
        self.recorder.append("ledger", self.model.ledger(state))
        self._probes(state)
        self._sky(state)
        self._contacts(before, state)
        if self._due(window):
            self._frame(state)
        self._state(state, window.tick, window.size)
        self.recorder.commit()

    def close(self, outcome: str, reason: str) -> None:
        """Write everything for the last time."""
        windows = self.recorder.tables.get("windows")
        found = windows and error_estimate.estimate(self.model, windows.rows())
        if found:
            self.recorder.attributes |= error_estimate.attributes(found)
        self.recorder.close(outcome, reason)

    def _due(self, window: Any) -> bool:
        interval = self.model.end / self.model.frames
        passed = np.floor(window.t / interval + 1e-9) > np.floor(
            (window.t - window.h) / interval + 1e-9
        )
        return bool(passed)

    def _window(self, before: Coupled, window: Any, wall: float) -> None:
        steps, refused, corrections, _ = window.state.motion.counts - before.motion.counts
        times = np.concatenate([[before.motion.motion.t], *(rows.t for rows in self.substeps)])
        sizes = np.diff(times)
        self.recorder.append("windows", {
            "time": window.t, "window": window.h,
            "step_min": sizes.min(), "step_max": sizes.max(),
            "steps": steps, "rejected": refused, "iterations": corrections,
            "halvings": window.halvings, "exchanges": window.exchanges,
            "window_error": window.window_error, "wall_time": wall,
            **error_estimate.of_window(self.model, before, window.state),
        })  # fmt: skip

    def _probes(self, state: Coupled) -> None:
        for name, row in self.model.probes(state).items():
            self.recorder.append(f"probes/{name}", row)

    def _sky(self, state: Coupled) -> None:
        row = self.model.sky(state)
        if row:
            self.recorder.append("sky", row)

    def _frame(self, state: Coupled) -> None:
        self.recorder.append("frames", {"time": state.motion.motion.t})
        for name, row in self.model.bodies(state).items():
            self.recorder.append(f"bodies/{name}", row)
        for name, row in self.model.cells(state.motion.motion, self.model.sections(state)).items():
            self.recorder.append(f"solids/{name}", row)
        for name, row in self.model.skins(state).items():
            self.recorder.append(f"skins/{name}", row)

    def _state(self, state: Coupled, tick: int, size: int) -> None:
        heat = memory(self.model.pair.heat_solver)
        self.recorder.state({"coupled": state, "tick": tick, "size": size, "heat": heat})

    def _contacts(self, before: Coupled, state: Coupled) -> None:
        """What happened in the window: events, totals, and the histories of the contacts."""
        contacts = self.model.contacts
        if not contacts or not self.substeps:
            return
        steps = self.model.steps(before, self.substeps)
        found = events(steps)
        regime = regimes(contacts, steps.response[1:], steps.approach[1:])
        self.recorder.append_many("events", {
            "time": found.time, "contact": found.contact, "kind": found.kind, "speed": found.speed,
        })  # fmt: skip
        lost = losses(contacts, self.substeps[-1].lost[-1])
        totals = summary(steps, regime, found, lost)
        self.recorder.append("contacts", {"time": steps.times[-1], **totals})
        drive = np.concatenate([rows.drive for rows in self.substeps])
        for j, rows in enumerate(kept_rows(steps, found, self._most)):
            contact, times = contacts[j], steps.times[1 + rows]
            self.recorder.append_many(f"joints/{contact.name}", {
                **history(contact, times, steps.response[1 + rows, j],
                          steps.approach[1 + rows, j], regime[rows, j]),
                **driven(contact, times, drive[rows]),
                **self.model.contact_temperatures(contact, before, state, times),
            })  # fmt: skip
