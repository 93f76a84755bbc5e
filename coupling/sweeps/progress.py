"""What a person sees while a sweep goes on: points done, failed and left, time left."""

import time
from typing import Any

from coupling.sweeps.points import DONE, Point


class Progress:
    """Progress on a rich console; None: silent.

    total : points;  before : of them, those that were there already
    """

    def __init__(self, console: Any, name: str, total: int, before: int) -> None:
        self.console, self.name, self.total, self.before = console, name, total, before
        self.finished = self.failed = 0
        self.begun = time.monotonic()
        self.bar: Any = None
        self.task: Any = None

    def __enter__(self) -> "Progress":
        left = self.total - self.before
        if self.console is not None and left:
            there = f", {self.before} are there already" if self.before else ""
            self._print(f"sweep {self.name}: {left} points to compute{there}")
            if self.console.is_terminal:
                self._start_bar(left)
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def told(self, label: str, point: Point) -> None:
        """A point is over."""
        self.finished += 1
        self.failed += point.outcome != DONE
        if self.console is None:
            return
        became = f"{point.seconds:.3g} s"
        if point.outcome != DONE:
            became = f"{point.outcome}: {point.reason}"
        self._print(f"{self._counts()} · {label}: {became}")
        if self.bar is not None:
            self.bar.update(self.task, completed=self.finished, text=self._counts())

    def _counts(self) -> str:
        left = self.total - self.before - self.finished
        minutes, seconds = divmod(round(self.seconds_left()), 60)
        failed = f", {self.failed} failed" if self.failed else ""
        done = self.before + self.finished - self.failed
        return f"{done} done{failed}, {left} left, {minutes}:{seconds:02d} left"

    def seconds_left(self) -> float:
        """Time [s] for the points that are left, at the mean pace so far."""
        left = self.total - self.before - self.finished
        return (time.monotonic() - self.begun) / max(self.finished, 1) * left

    def _print(self, text: str) -> None:
        console = self.bar.console if self.bar is not None else self.console
        console.print(text, style="dim", markup=False, highlight=False)

    def _start_bar(self, left: int) -> None:
        from rich import progress

        self.bar = progress.Progress(
            progress.BarColumn(bar_width=24),
            progress.TextColumn("{task.fields[text]}"),
            console=self.console,
        )
        self.task = self.bar.add_task("sweep", total=left, text=f"{left} left")
        self.bar.start()
