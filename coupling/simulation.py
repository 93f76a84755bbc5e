"""The window loop: coupling windows one after the other, halved when one cannot be done.

Time is counted in whole ticks of 1/1024 window, so that windows end exactly where they should
and no window of rounding size arises.
"""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from coupling.errors import BadCase, Problem
from coupling.manager import SCHEMES, Coupled
from coupling.model import Model, build
from coupling.recording import Recording
from coupling.results import Recorder, Results, new_run_folder
from coupling.scene import Scene

TICKS = 1024
"""Parts of a window; the finest window that halving can reach."""


class Done(NamedTuple):
    """A coupling window that was finished.

    tick : int  its end
    size : int  its length in ticks
    t, h : float [s]  its end and length
    state : Coupled  at its end
    halvings : int  attempts that failed before
    """

    tick: int
    size: int
    t: float
    h: float
    state: Coupled
    halvings: int


class Start(NamedTuple):
    """Where windows begin: a state, its tick, and the size of the window that ended there."""

    state: Coupled
    tick: int = 0
    size: int = TICKS


class Stopped(NamedTuple):
    """Why the run cannot go on, and when."""

    t: float
    why: str


class Outcome(NamedTuple):
    """Exit code (0 done, 3 stopped), folder of the results, reason."""

    code: int
    folder: Path
    reason: str


class Attempts(NamedTuple):
    """Called around each attempt at a window; what was observed in a failed one is dropped."""

    begin: Callable[[], None]
    observe: Callable[..., None] | None
    failed: Callable[[], None]


def _nothing() -> None:
    return None


BARE = Attempts(_nothing, None, _nothing)


def windows(
    model: Model, state: Coupled, tick: int = 0, size: int = TICKS, attempts: Attempts = BARE
) -> Iterator[Done | Stopped]:
    """Finish window after window from ``tick``, where one of ``size`` ended, to the end."""
    advance = SCHEMES[model.scheme]
    last = model.windows * TICKS
    while tick < last:
        size = _aligned(tick, 2 * size)
        t, halvings = _time(model, tick), 0
        while True:
            h = _time(model, tick + size) - t
            attempts.begin()
            new, why = advance(model.pair, state, t, h, attempts.observe)
            if new is not None:
                break
            attempts.failed()
            halvings += 1
            if size // 2 * model.window < TICKS * model.smallest_window or size == 1:
                yield Stopped(t, why)
                return
            size //= 2
        tick, state = tick + size, new
        yield Done(tick, size, _time(model, tick), h, state, halvings)


def _aligned(tick: int, size: int) -> int:
    """Largest window up to ``size`` that starts on a multiple of itself."""
    size = min(size, TICKS)
    while tick % size:
        size //= 2
    return size


def _time(model: Model, tick: int) -> float:
    whole, part = divmod(tick, TICKS)
    return (whole + part / TICKS) * model.window


def run(
    scene: Scene, folder: Path | None = None, resume: bool = False, console: Any = None
) -> Outcome:
    """Run a case and record it.

    Parameters
    ----------
    folder : parent of the numbered run folders; default ``results`` in the case folder
    resume : go on with the latest run there instead of starting a new one
    console : rich console for progress; None: silent
    """
    from coupling.progress import Progress

    with Progress(console) as progress:
        progress.say("building the model")
        model = build(scene)
        parent = folder or scene.folder / "results"
        recording, start = (_resumed if resume else _begun)(model, parent, scene)
        progress.say("first step (kernels are compiled the first time)")
        return _carry(model, recording, start, progress)


def _begun(model: Model, parent: Path, scene: Scene) -> tuple[Recording, Start]:
    start = Start(model.initial())
    recorder = Recorder(new_run_folder(parent), model.meta(scene))
    recording = Recording(model, recorder)
    recording.start(*start)
    return recording, start


def _resumed(model: Model, parent: Path, scene: Scene) -> tuple[Recording, Start]:
    from coupling.resume import check_same_case, latest, restore

    folder = latest(parent)
    with Results.open(folder) as results:
        check_same_case(str(results.attributes()["scene"]), scene.text)
    recorder = Recorder.reopen(folder)
    recorder.attributes |= {"scene": scene.text}
    saved = recorder.saved_state
    if not saved:
        raise BadCase(str(folder), [Problem("", "the run ended before it began; start it anew")])
    state = restore(model.initial(), saved["coupled"])
    return Recording(model, recorder), Start(state, int(saved["tick"]), int(saved["size"]))


def _carry(model: Model, recording: Recording, start: Start, progress) -> Outcome:
    attempts = Attempts(recording.begin, recording.observe, recording.failed)
    folder = recording.folder
    started = time.monotonic()
    before = start.state
    try:
        for window in windows(model, *start, attempts):
            if isinstance(window, Stopped):
                reason = f"stopped at t = {window.t:.9g} s: {window.why}"
                recording.close("stopped", reason)
                return Outcome(3, folder, reason)
            recording.commit(before, window, time.monotonic() - started)
            before = window.state
            progress.window(model, window)
    except KeyboardInterrupt:
        recording.close("stopped", "interrupted")
        raise
    recording.close("done", "")
    return Outcome(0, folder, "")
