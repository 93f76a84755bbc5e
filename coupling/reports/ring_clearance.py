"""The ring truss with play in its 144 revolutes, half of it cooling: what its steps are spent on.

The motion of the case ``ring_clearance`` without its heat: the half y > 0 cools evenly, the other
one keeps its temperature.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.reports.rings import DAMPING, section, truss
from coupling.rings import Play, ring_description
from mechanics.description import Friction, NormalContact
from mechanics.dynamics import Control, State, Window, advance, initial_state
from mechanics.march import HYSTERESIS, RUBBED, Rows
from mechanics.schemes import Scheme
from mechanics.system import Coefficients, System
from meshes.materials import library_material

Array = NDArray[np.float64]

WARM, RATE = 473.15, 25.0
"""Temperature at the start [K], and how fast one half cools [K/s]."""
PIN, CLEARANCE, RESTITUTION, FRICTION = 10e-3, 30e-6, 0.85, 0.1
"""Radius of the pins, radial clearance [m]; restitution, coefficient of friction [-]."""
WINDOW, SHORT, LONG, BRIEF = 0.1, 0.2, 10.0, 1e-6
"""Between two looks at the temperatures; short and whole motion, one to begin with [s]."""
TOLERANCE, FINER, NEWTON, LARGEST = 3e-5, 1e-5, 1e-9, 20e-3
"""Local error, a smaller one to compare with, remaining corrections [-]; largest step [s]."""
FAR = "batten_18"
"""Member opposite to the support, whose upper end is the tip."""
ROWS = 10
"""Rows of the table, at most."""
BINS = 50
"""Parts of the motion in which impacts are counted for the picture."""
COLUMNS = (
    "to [s]", "steps", "refused [%]", "corrections", "factorisations", "least step [us]",
    "median step [us]", "contacts", "impacts", "friction [mJ]", "impacts lose [mJ]",
    "time [s]", "of the processor [s]", "step [ms]",
)  # fmt: skip


class Stretch(NamedTuple):
    """What happened in a window.

    t : (k,) [s]  ends of the steps;  sizes : (k,) [s]  of the steps
    contacts : (k,) int  impacts and other contacts that run
    onsets : [s]  times at which contacts begin
    counts : (4,) int  accepted, refused steps, corrections, factorisations
    wall, processor : [s]  time it took
    """

    state: State
    t: Array
    sizes: Array
    contacts: Array
    onsets: Array
    counts: NDArray[np.int64]
    wall: float
    processor: float


def report(whole: bool = False) -> Iterator[Result]:
    """Steps, contacts and time of the short motion, its error; or of the ``whole`` one."""
    system, end = ring(), LONG if whole else SHORT
    next(motion(system, control(TOLERANCE), BRIEF))  # compiled before anything is timed
    first = list(motion(system, control(TOLERANCE), end))
    yield _course(system, first, end)
    if not whole:
        yield _errors(system, {TOLERANCE: first, FINER: list(motion(system, control(FINER), end))})


def ring() -> System:
    """The ring with play, of level 3."""
    contact = NormalContact(restitution=RESTITUTION)
    play = Play(PIN, CLEARANCE, contact, Friction(FRICTION))
    material = library_material("al6061-paper")
    return System(ring_description(truss(), section(), material, DAMPING, WARM, clearance=play))


def control(tolerance: float) -> Control:
    """Step-size control."""
    return Control(tolerance, LARGEST, scheme=Scheme(newton_tolerance=NEWTON))


def cooling(system: System) -> Callable[[float], Coefficients]:
    """Coefficients at a time [s]: the half y > 0 cools."""
    cold = system.layout.x[:, 1] > 0.0

    def at(t: float) -> Coefficients:
        return system.coefficients(
            np.array([WARM, 0.0, 0.0]) - RATE * t * np.outer(cold, [1, 0, 0])
        )

    return at


def motion(system: System, how: Control, end: float) -> Iterator[Stretch]:
    """The windows up to ``end`` [s]; an error if the motion stops."""
    coefficients = cooling(system)
    state, why = initial_state(system, how, coefficients(0.0))
    if state is None:
        raise RuntimeError(why)
    count = round(end / WINDOW) or 1
    for k in range(count):
        t, h = state.motion.t, (k + 1) * end / count - state.motion.t
        window = Window.between(system, t, h, coefficients(t), coefficients(t + h))
        stretch = _window(system, how, state, window)
        yield stretch
        state = stretch.state


def _window(system: System, how: Control, state: State, window: Window) -> Stretch:
    t, contacts, onsets = [np.array([window.t0])], [], []
    last = state.motion.approach[None] != 0.0

    def observe(rows: Rows) -> None:
        nonlocal last
        running = np.concatenate([last, rows.approach != 0.0])
        begun = (running[1:] & ~running[:-1]).sum(axis=1)
        t.append(rows.t.copy())
        contacts.append(running[1:].sum(axis=1))
        onsets.append(np.repeat(rows.t, begun))
        last = running[-1:]

    wall, processor = perf_counter(), process_time()
    after, _, why = advance(system, how, state, window, observe)
    if why:
        raise RuntimeError(why)
    times = np.concatenate(t)
    return Stretch(
        after, times[1:], np.diff(times), np.concatenate(contacts), np.concatenate(onsets),
        after.counts - state.counts, perf_counter() - wall, process_time() - processor,
    )  # fmt: skip


# ------------------------------------------------------------------------------------ the course


def _course(system: System, all_of: list[Stretch], end: float) -> Result:
    groups = np.array_split(np.arange(len(all_of)), min(ROWS, len(all_of)))
    rows = [_row([all_of[k] for k in group]) for group in groups]
    title = f"Ring truss with play in {len(system.contact_names)} hinges, {end:g} s"
    return Result(
        "clearance", title, COLUMNS, rows, _notes(system, all_of, end), _pictures(all_of)
    )  # fmt: skip


def _row(part: list[Stretch]) -> Row:
    accepted, refused, corrections, factorisations = np.sum([s.counts for s in part], axis=0)
    sizes = np.concatenate([s.sizes for s in part])
    contacts = np.concatenate([s.contacts for s in part])
    state, processor = part[-1].state, sum(s.processor for s in part)
    return (
        round(state.motion.t, 6), int(accepted), 100.0 * float(refused / (accepted + refused)),
        int(corrections), int(factorisations), 1e6 * float(sizes.min()),
        1e6 * float(np.median(sizes)), float(np.average(contacts, weights=sizes)),
        sum(len(s.onsets) for s in part), 1e3 * float(state.ledger[RUBBED]),
        1e3 * float(state.ledger[HYSTERESIS]), sum(s.wall for s in part), processor,
        1e3 * processor / float(accepted),
    )  # fmt: skip


def _notes(system: System, all_of: list[Stretch], end: float) -> list[str]:
    wall, processor = (sum(getattr(s, name) for s in all_of) for name in ("wall", "processor"))
    spent = f"{end:g} s of motion: {wall:.0f} s, of the processor {processor:.0f} s"
    if end < LONG:
        last = all_of[-1].processor / WINDOW * LONG
        spent += (
            f"; {LONG:g} s at the pace of all of it {processor / end * LONG / 60.0:.0f} min, "
            f"of its last {WINDOW:g} s {last / 60.0:.0f} min"
        )
    return [
        f"{system.n} coordinates, {system.m} multipliers; "
        f"local error {TOLERANCE:g}, corrections {NEWTON:g}, steps up to {1e3 * LARGEST:g} ms",
        spent,
        "contacts: mean over time of those that touch; impacts: contacts that begin; "
        "friction, impacts lose: since the start",
    ]


def _pictures(all_of: list[Stretch]) -> list[Picture]:
    t, sizes, contacts, onsets = (
        np.concatenate([getattr(s, name) for s in all_of])
        for name in ("t", "sizes", "contacts", "onsets")
    )
    edges = np.linspace(0.0, t[-1], BINS + 1)
    per_time = np.histogram(onsets, edges)[0] / np.diff(edges)
    middles = 0.5 * (edges[1:] + edges[:-1])
    means = [sizes[(t > a) & (t <= b)] for a, b in pairwise(edges)]
    typical = [1e6 * float(np.median(part)) if part.size else np.nan for part in means]
    return [
        Picture("time [s]", "step [us]",
                [Curve("steps", t, 1e6 * sizes, "."), Curve("median", middles, typical, "-")], "y"),
        Picture("time [s]", "contacts [-]", [Curve("that touch", t, contacts, "-")], ""),
        Picture("time [s]", "impacts that begin [1/s]", [Curve("impacts", middles, per_time)], ""),
    ]  # fmt: skip


# ------------------------------------------------------------------------------------- the error


def _errors(system: System, runs: dict[float, list[Stretch]]) -> Result:
    """Of the larger tolerance against the smaller one."""
    best = _tip(system, list(runs.values())[-1][-1].state)
    rows: list[Row] = []
    for tolerance, run in runs.items():
        state, impacts = run[-1].state, sum(len(s.onsets) for s in run)
        tip = _tip(system, state)
        rows.append((
            f"{tolerance:g}", int(state.counts[0]), sum(s.processor for s in run), impacts,
            1e3 * float(np.linalg.norm(tip - _start(system))),
            1e3 * float(np.linalg.norm(tip - best)), 1e3 * float(state.ledger[RUBBED]),
            1e3 * float(state.ledger[HYSTERESIS]), float(state.ledger[0]),
        ))  # fmt: skip
    columns = (
        "local error", "steps", "of the processor [s]", "impacts", "tip has moved [mm]",
        "tip differs by [mm]", "friction [mJ]", "impacts lose [mJ]", "kinetic energy [J]",
    )  # fmt: skip
    title = f"Error of the ring with play after {SHORT:g} s"
    return Result("clearance_error", title, columns, rows, [])


def _place(system: System) -> NDArray[np.intp]:
    """Coordinates of the tip."""
    return system.layout.node_dofs[FAR][-1] + np.arange(3)


def _tip(system: System, state: State) -> Array:
    return state.motion.q[_place(system)]


def _start(system: System) -> Array:
    return system.layout.q0[_place(system)]
