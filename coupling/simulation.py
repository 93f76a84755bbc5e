"""The window loop: coupling windows one after the other, halved when one cannot be done.

Time is counted in whole ticks of 1/1024 window, so that windows end exactly where they should
and no window of rounding size arises. What the next window may be follows from the state, its tick
and the size of the window that ended there: nothing else has to be kept to go on with a run.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple

from coupling.locks import holding
from coupling.manager import Coupled
from coupling.model import Model, build
from coupling.recording import Recording
from coupling.results import Recorder, new_run_folder
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

    @property
    def window_error(self) -> float:
        """[K]  see ``Coupled.window_error``."""
        return self.state.window_error

    @property
    def exchanges(self) -> int:
        """How often motion was computed for it."""
        return self.state.exchange.iterations


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


Say = Callable[[str], None]

BARE = Attempts(_nothing, None, _nothing)


def windows(
    model: Model, state: Coupled, tick: int = 0, size: int = TICKS, attempts: Attempts = BARE
) -> Iterator[Done | Stopped]:
    """Finish window after window from ``tick``, where one of ``size`` ended, to the end.

    A window that cannot be done, or is too long for its ``pace``, is repeated from its state with
    half the length.
    """
    last = model.windows * TICKS
    while tick < last:
        size = _aligned(tick, _wanted(model, size, state))
        t, halvings = _time(model, tick), 0
        while True:
            h = _time(model, tick + size) - t
            attempts.begin()
            new, why = _tried(model, state, t, h, attempts)
            if new is not None:
                break
            attempts.failed()
            halvings += 1
            if not _divisible(model, size):
                yield Stopped(t, why)
                return
            size //= 2
        tick, state = tick + size, new
        yield Done(tick, size, _time(model, tick), h, state, halvings)


def _tried(
    model: Model, state: Coupled, t: float, h: float, attempts: Attempts
) -> tuple[Coupled | None, str]:
    """State after a window, or the reason why there is none or it may not be kept."""
    new, why = model.advance(model.pair, state, t, h, attempts.observe)
    if new is None or model.pace is None:
        return new, why
    judged, why = model.pace.judged(state, new)
    return (None, why) if why else (judged, "")


def _wanted(model: Model, size: int, state: Coupled) -> int:
    """Ticks of the next window, after one of ``size`` that ended in a state."""
    growth = state.exchange.growth
    if model.pace is not None and not state.exchange.total:
        growth = model.pace.first
    while growth < 0 and _divisible(model, size):
        size, growth = size // 2, growth + 1
    return size << max(growth, 0)


def _divisible(model: Model, size: int) -> bool:
    """Whether half a window is still a window."""
    return size > 1 and size // 2 * model.window >= TICKS * model.smallest_window


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
    from coupling.resume import continuing, latest

    parent = folder or scene.folder / "results"
    with Progress(console) as progress:
        place = latest(parent) if resume else None
        progress.say("building the model")
        model = build(scene)
        start = Start(model.initial())
        with holding(place or new_run_folder(parent)) as place:
            begin = _resumed if resume else _begun
            recording, start = begin(model, place, scene, start, progress.say)
            progress.say("first step (kernels are compiled the first time)")
            with continuing(place) if resume else nullcontext():
                return _carry(model, recording, start, progress)


def _begun(
    model: Model, folder: Path, scene: Scene, start: Start, say: Say
) -> tuple[Recording, Start]:
    recording = Recording(model, Recorder(folder, model.meta(scene)))
    recording.start(*start)
    return recording, start


def _resumed(
    model: Model, folder: Path, scene: Scene, start: Start, say: Say
) -> tuple[Recording, Start]:
    from coupling.resume import reopened, restored

    recorder = reopened(folder, scene.text)
    if recorder.damage:
        say(f"{recorder.damage}; the rest is computed anew")
    saved = recorder.saved_state
    if not saved:
        say("the run ended before its first state; it begins")
        return _begun(model, folder, scene, start, say)
    found = restored(start.state, saved, model.pair.heat_solver, folder)
    return Recording(model, recorder), Start(*found)


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
