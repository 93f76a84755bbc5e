"""A scene run for its own sake: quantities once, and times without anything that watches.

Building, and a first window in which kernels are compiled, are over before anything is timed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from os import times as spent_by
from time import perf_counter, process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling import analyses
from coupling.contact_history import ONSET, events
from coupling.errors import BadCase
from coupling.manager import Coupled
from coupling.model import Model, build
from coupling.report_quantities import Moment, course, needs_contacts, read
from coupling.report_tables import Sought
from coupling.scene import Scene
from coupling.simulation import Attempts, Stopped, windows

Array = NDArray[np.float64]
DONE, STOPPED, REFUSED, GIVEN_UP = "done", "stopped", "refused", "given up"


class Ran(NamedTuple):
    """What became of a scene.

    outcome : done; stopped before its end; refused when it was built; given up, since it takes
        too long
    reason : "" or why it is not done
    start : float [s]  of building it and its first window, in which kernels are compiled
    wall, processor : float [s]  of each timed run, without ``start``
    counts : windows, steps, ... of one run
    times : (w,) float [s]  0 and the ends of the windows; in statics load factors
    values : (w, k) float  of each quantity by name
    """

    outcome: str
    reason: str
    start: float = np.nan
    wall: tuple[float, ...] = ()
    processor: tuple[float, ...] = ()
    counts: Mapping[str, int] = {}
    times: Array = np.zeros(0)
    values: Mapping[str, Array] = {}

    @property
    def least(self) -> float:
        """Least wall time [s]; nan where there is none."""
        return min(self.wall, default=np.nan)

    @property
    def work(self) -> float:
        """Least processor time [s]; nan where there is none."""
        return min(self.processor, default=np.nan)


def timed(
    scene: Scene,
    sought: Mapping[str, Sought],
    repeat: int = 1,
    budget: float = 0.0,
    limit: float = np.inf,
) -> Ran:
    """Run a scene, measure what is sought, and time it.

    Parameters
    ----------
    repeat : timed runs; 0: only the run in which quantities are read
    budget : float [s]  of the timed runs; after it no more begin
    limit : float [s]  a run that takes longer is given up
    """
    begun = perf_counter()
    try:
        model = build(scene)
        if scene.analysis.kind != "dynamics":
            return _still(model, sought, repeat, begun)
        _first(model)
    except BadCase as error:
        return Ran(REFUSED, "; ".join(problem.text for problem in error.problems))
    start = perf_counter() - begun
    ran = _watched(model, sought, limit)._replace(start=start)
    while ran.outcome == DONE and _more(ran.wall, repeat, budget):
        wall, processor = _bare(model)
        ran = ran._replace(wall=(*ran.wall, wall), processor=(*ran.processor, processor))
    return ran


def _processor() -> float:
    """Time [s] that processors worked for this program and for those that it started and ended."""
    spent = spent_by()
    return process_time() + spent.children_user + spent.children_system


def _more(wall: tuple[float, ...], repeat: int, budget: float) -> bool:
    return bool(repeat) and (not wall or (len(wall) < repeat and sum(wall) < budget))


def _first(model: Model) -> None:
    """The first window; a run that cannot do it will say so."""
    next(windows(model, model.initial()))


def _bare(model: Model) -> tuple[float, float]:
    """Wall and processor time [s] of a run that nothing watches."""
    wall, processor = perf_counter(), _processor()
    for _ in windows(model, model.initial()):
        pass
    return perf_counter() - wall, _processor() - processor


# --------------------------------------------------------------------------------- watched


class _Counted:
    """A thermal solver whose solutions and steps are counted."""

    def __init__(self, solver: Any) -> None:
        self.solver, self.solutions, self.steps = solver, 0, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.solver, name)

    def advance(self, *given: Any) -> Any:
        """As the solver does."""
        result = self.solver.advance(*given)
        self.solutions += 1
        self.steps += getattr(self.solver, "taken", 1)
        return result


class _Clock:
    """Wall and processor time of the steps of an iterator, without what is done between them."""

    def __init__(self) -> None:
        self.wall = self.processor = 0.0

    def over(self, steps: Iterator[Any]) -> Iterator[Any]:
        """The steps, timed."""
        while True:
            wall, processor = perf_counter(), _processor()
            step = next(steps, None)
            self.wall += perf_counter() - wall
            self.processor += _processor() - processor
            if step is None:
                return
            yield step


def _watched(model: Model, sought: Mapping[str, Sought], limit: float) -> Ran:
    """A run in which quantities are read between the windows: timed if nothing is within them."""
    counted = None if model.pair.heat_solver is None else _Counted(model.pair.heat_solver)
    own: Any = counted
    model = replace(model, pair=model.pair._replace(heat_solver=own))
    watch = _Watch(model, sought)
    clock, state, found, outcome, reason = _Clock(), model.initial(), 0, DONE, ""
    watch.keep(state)
    for window in clock.over(windows(model, state, attempts=watch.attempts)):
        if isinstance(window, Stopped):
            outcome, reason = STOPPED, f"at t = {window.t:.6g} s: {window.why}"
            break
        watch.keep(window.state, state)
        state, found = window.state, found + 1
        if clock.wall > limit and window.t < model.end:
            outcome, reason = GIVEN_UP, f"at t = {window.t:.6g} s, after {clock.wall:.3g} s"
            break
    names = ("steps", "refused", "corrections", "factorisations")
    counts = {"windows": found, **dict(zip(names, map(int, state.motion.counts), strict=True))}
    counts["motions"] = getattr(getattr(state, "exchange", None), "total", 0) or found
    counts |= {"heat solutions": 0, "heat steps": 0}
    if counted is not None:
        counts |= {"heat solutions": counted.solutions, "heat steps": counted.steps}
    spent = () if reason or watch.within else (clock.wall,)
    processor = () if reason or watch.within else (clock.processor,)
    times, values = watch.kept()
    return Ran(outcome, reason, np.nan, spent, processor, counts, times, values)


class _Watch:
    """Reads quantities from the states between windows, and from the steps within them."""

    def __init__(self, model: Model, sought: Mapping[str, Sought]) -> None:
        self.model, self.sought = model, sought
        self.within = needs_contacts(sought.values())
        self._rows: list[Any] = []
        self._contacts = {
            contact.name: {"peak_force": 0.0, "impacts": 0, "friction_work": 0.0, "hysteresis": 0.0}
            for contact in (model.contacts if self.within else ())
        }
        self._times: list[float] = []
        self._values: dict[str, list[Array]] = {name: [] for name in sought}

    @property
    def attempts(self) -> Attempts:
        """What is called around and in the windows."""
        clear, keep = self._rows.clear, self._rows.append if self.within else None
        return Attempts(clear, keep, clear)

    def keep(self, state: Coupled, before: Coupled | None = None) -> None:
        """Quantities of a state, and of the window before it."""
        if self._rows and before is not None:
            self._count(before)
        model, motion = self.model, state.motion.motion
        last = self._rows[-1].response[-1] if self._rows else None
        at = Moment(
            motion, model.sections(state), state.T, lambda: model.ledger(state), self._contacts,
            last,
        )  # fmt: skip
        self._times.append(motion.t)
        for name, sought in self.sought.items():
            self._values[name].append(read(model, sought.of, at))

    def _count(self, before: Coupled) -> None:
        """Add what contacts did in a window."""
        steps = self.model.steps(before, self._rows)
        found, lost = events(steps), self._rows[-1].lost[-1]
        onsets = np.bincount(
            found.contact[found.kind == ONSET], minlength=len(self._contacts)
        ).tolist()
        peaks = steps.force.max(axis=0)
        for k, row in enumerate(self._contacts.values()):
            row["peak_force"] = max(row["peak_force"], float(peaks[k]))
            row["impacts"] += onsets[k]
            row["hysteresis"] += float(lost[k, 0])
            row["friction_work"] += float(lost[k, 1])

    def kept(self) -> tuple[Array, dict[str, Array]]:
        """Times (w,), and values (w, k) of each quantity."""
        times = np.array(self._times)
        rows = {name: np.array(v) for name, v in self._values.items()}
        return times, {name: course(one.of, rows[name]) for name, one in self.sought.items()}


# ------------------------------------------------------------------------- statics and modes


class _Frequencies:
    """Takes the place of a recorder and keeps the frequencies of modes."""

    def __init__(self) -> None:
        self.found: list[float] = []

    def declare(self, *_: Any) -> None:
        """Units are known."""

    def append(self, _: str, row: Mapping[str, float]) -> None:
        """A mode."""
        self.found.append(float(row["frequency"]))


def _still(model: Model, sought: Mapping[str, Sought], repeat: int, begun: float) -> Ran:
    """Statics or modes: quantities at each equilibrium, or the frequencies."""
    spent: list[tuple[float, float]] = []
    frames, why, modes = _analysed(model)
    start = perf_counter() - begun
    for _ in range(repeat):
        wall, processor = perf_counter(), _processor()
        frames, why, modes = _analysed(model)
        spent.append((perf_counter() - wall, _processor() - processor))
    times = np.array([place.t for place, _ in frames])
    values = {name: _values(model, one.of, frames, modes) for name, one in sought.items()}
    wall_, processor_ = tuple(zip(*spent, strict=True)) or ((), ())
    outcome = STOPPED if why else DONE
    return Ran(outcome, why, start, wall_, processor_, {"steps": len(frames)}, times, values)


def _analysed(model: Model) -> tuple[analyses.Frames, str, list[float]]:
    modes = _Frequencies()
    frames, why = analyses.analyse(model, modes, None)
    return frames, why, modes.found


def _values(model: Model, of: str, frames: analyses.Frames, modes: list[float]) -> Array:
    if of.startswith("mode."):
        number = int(of.split(".")[1])
        return np.array([[modes[number - 1] if number <= len(modes) else np.nan]])
    none: Any = None
    moments = (Moment(place, T, T[:, 0], none, {}) for place, T in frames)
    return course(of, np.array([read(model, of, at) for at in moments]))
