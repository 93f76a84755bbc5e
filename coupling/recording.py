"""The observer that turns states into rows of results.h5."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.manager import Coupled
from coupling.model import Model
from coupling.results import Recorder
from mechanics.march import Rows

Array = NDArray[np.float64]


class Recording:
    """Rows of windows, ledger, probes, joints and frames.

    Joint histories have a row for each mechanical substep; the other tables one per window.
    """

    def __init__(self, model: Model, recorder: Recorder):
        self.model = model
        self.recorder = recorder
        self.folder: Path = recorder.path.parent
        self.substeps: list[Rows] = []
        self._joints = model.joint_names()
        self._driven = model.driven_rows()

    def start(self, state: Coupled, tick: int, size: int) -> None:
        """Describe the groups and record the state at t = 0."""
        for name, attributes in self.model.body_attributes().items():
            self.recorder.describe_group(f"bodies/{name}", attributes)
        for name, attributes in self.model.joint_attributes().items():
            self.recorder.describe_group(f"joints/{name}", attributes)
        for name, elements in self.model.surfaces().items():
            self.recorder.append_many(f"surfaces/{name}", elements)
        self._frame(state)
        self._probes(state)
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
        self._substeps(before, state)
        if self._due(window):
            self._frame(state)
        self._state(state, window.tick, window.size)
        self.recorder.commit()

    def close(self, outcome: str, reason: str) -> None:
        """Write everything for the last time."""
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
            "halvings": window.halvings, "wall_time": wall,
        })  # fmt: skip

    def _probes(self, state: Coupled) -> None:
        for name, row in self.model.probes(state).items():
            self.recorder.append(f"probes/{name}", row)

    def _frame(self, state: Coupled) -> None:
        self.recorder.append("frames", {"time": state.motion.motion.t})
        for name, row in self.model.bodies(state).items():
            self.recorder.append(f"bodies/{name}", row)

    def _state(self, state: Coupled, tick: int, size: int) -> None:
        self.recorder.state({"coupled": state, "tick": tick, "size": size})

    def _substeps(self, before: Coupled, state: Coupled) -> None:
        if not self._joints or not self.substeps:
            return
        parts = zip(*(rows[:4] for rows in self.substeps), strict=True)
        times, responses, approaches, drive = map(np.concatenate, parts)
        # A driven row is the sine of the angle left to go, so its multiplier is the torque.
        column = np.column_stack([-drive, np.zeros(len(times))])
        torques = column[:, self._driven]
        temperatures = self.model.joint_temperatures(before, state, times)
        for j, name in enumerate(self._joints):
            rows = self.model.joint_rows(
                j, times, responses[:, j], approaches[:, j], torques[:, j], temperatures[:, j]
            )
            self.recorder.append_many(f"joints/{name}", rows)
