"""What a person sees while a run goes on: one line per window, time left."""

import time
from typing import Any

from coupling.simulation import Done

PLAIN_INTERVAL = 5.0
"""Least time between two lines where output is not a terminal [s]."""


class Progress:
    """Progress on a rich console; None: silent."""

    def __init__(self, console: Any):
        self.console = console
        self.bar: Any = None
        self.task: Any = None
        self.first: tuple[float, float] | None = None  # clock and time of the first window
        self.said = time.monotonic()

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def say(self, text: str) -> None:
        """One line about a stage of the work."""
        if self.console is not None:
            self.console.print(f"[dim]{text}[/dim]")

    def window(self, model: Any, window: Done) -> None:
        """A coupling window is done."""
        if self.console is None:
            return
        if self.first is None:
            self.first = time.monotonic(), window.t
        text = model.progress_text(window)
        if self.console.is_terminal:
            self._advance_bar(model, window, text)
        elif time.monotonic() - self.said > PLAIN_INTERVAL or window.t >= model.end:
            self.said = time.monotonic()
            self.console.print(
                f"t = {window.t:.6g} s of {model.end:.6g} s, "
                f"{self._left(model, window)} left · {text}",
                highlight=False,
            )

    def _left(self, model: Any, window: Done) -> str:
        """Time left at the mean pace since the first window, which alone compiles kernels."""
        assert self.first is not None
        clock, t = self.first
        if window.t <= t:
            return "?"
        pace = (time.monotonic() - clock) / (window.t - t)
        minutes, seconds = divmod(round(pace * (model.end - window.t)), 60)
        return f"{minutes}:{seconds:02d}"

    def _advance_bar(self, model: Any, window: Done, text: str) -> None:
        if self.bar is None:
            self._start_bar(model)
        self.bar.update(self.task, completed=window.t, text=text)

    def _start_bar(self, model: Any) -> None:
        from rich import progress

        self.bar = progress.Progress(
            progress.TextColumn("t = {task.completed:.4g} of {task.total:.4g} s"),
            progress.BarColumn(bar_width=24),
            progress.TimeRemainingColumn(),
            progress.TextColumn("left · {task.fields[text]}"),
            console=self.console,
        )
        self.task = self.bar.add_task("run", total=model.end, text="")
        self.bar.start()
