"""Statics and modes of a case: equilibria over a load factor, vibrations about an equilibrium.

Results have the form of a run: frames are load factors, or numbers of modes, in place of time.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling import observables
from coupling.clocks import CLOCKS, Clock
from coupling.errors import BadCase, Problem
from coupling.manager import settled
from coupling.model import Model, build
from coupling.results import Recorder, new_run_folder
from coupling.scene import Scene
from coupling.simulation import Outcome
from mechanics.system import System

Array = NDArray[np.float64]

SHOWN = 0.1
"""Largest change of a coordinate in the frame of a mode, relative to its size [-]."""


class Place(NamedTuple):
    """Coordinates and multipliers at rest; ``t`` is the load factor or the number of a mode."""

    t: float
    q: Array
    lam: Array
    v: Array


def run(scene: Scene, folder: Path | None = None, console: Any = None) -> Outcome:
    """Run the [analysis] of a case and record it; exit code 3 where there is no equilibrium."""
    model = build(scene)
    recorder = Recorder(new_run_folder(folder or scene.folder / "results"), model.meta(scene))
    frames, reason = analyse(model, recorder, console)
    _record(model, recorder, frames)
    recorder.close("stopped" if reason else "done", reason)
    return Outcome(3 if reason else 0, recorder.path.parent, reason)


def temperatures(model: Model) -> tuple[Array, Array]:
    """Section temperatures at load factor 0 and 1: of the start, and of the end.

    At the end those that the conditions hold: as they are prescribed, or steady.
    """
    solver, read = model.pair.heat_solver, model.pair.transfer.read
    if solver is None:
        return read(np.zeros(0)), read(np.zeros(0))
    start = solver.initial()
    try:
        end = settled(model.pair, start, model.end, None)
    except ValueError as error:
        text = str(error).removeprefix("heat: ")
        raise BadCase(str(model.scene.folder), [Problem("thermal", text)]) from None
    return read(start), read(end)


# ------------------------------------------------------------------------------------ analyses


Frames = list[tuple[Place, Array]]


def analyse(model: Model, recorder: Any, console: Any) -> tuple[Frames, str]:
    """Equilibria, or modes, of a model; "" or the reason why there are no more.

    recorder : takes the frequencies of modes
    """
    kind = {"statics": _statics, "modes": _modes}[model.scene.analysis.kind]
    return kind(model, recorder, console)


def _statics(model: Model, recorder: Any, console: Any) -> tuple[Frames, str]:
    """Equilibria and the section temperatures at them; "" or the reason why there are no more."""
    from mechanics.arclength import follow
    from mechanics.statics import equilibrium

    system, (T0, T1) = model.motion_solver.system, temperatures(model)
    c0, c1 = system.coefficients(T0), system.coefficients(T1)
    table = model.scene.analysis
    rest = Place(0.0, system.layout.q0, np.zeros(system.m), np.zeros(system.n))
    if not table.arc_length:
        places = [rest]

        def keep(load: float, y: Array) -> None:
            places.append(rest._replace(t=load, q=y[: system.n], lam=y[system.n :]))

        found = equilibrium(system, c0, c1, table.steps, observe=keep)
        why, spent = found.why, found.iterations
    else:
        path = follow(system, c0, c1, count=table.most_points)
        places = [
            rest._replace(t=p.load, q=p.y[: system.n], lam=p.y[system.n :]) for p in path.points
        ]
        why, spent = path.why, path.iterations
        for event in path.events:
            _say(console, f"{event.kind} at load factor {event.point.load:.6g}")
    _say(console, f"load factor {places[-1].t:.6g} after {spent} iterations")
    return [(place, T0 + place.t * (T1 - T0)) for place in places], why


def _modes(model: Model, recorder: Any, console: Any) -> tuple[Frames, str]:
    """Equilibrium at load factor 1, then one frame for each mode about it."""
    from mechanics.modes import modes

    frames, why = _statics(model, recorder, console)
    if why:
        return frames, why
    system, (place, T) = model.motion_solver.system, frames[-1]
    found = modes(
        system, place.q, place.lam, system.coefficients(T), model.scene.analysis.count, 1.0
    )
    recorder.declare("modes", "number", "", "of the mode")
    recorder.declare("modes", "frequency", "Hz", "negative where the equilibrium is unstable")
    shown = [(place._replace(t=0.0), T)]
    for k, (frequency, shape) in enumerate(zip(found.frequencies, found.shapes.T, strict=True), 1):
        recorder.append("modes", {"number": k, "frequency": frequency})
        _say(console, f"mode {k}: {frequency:.6g} Hz")
        change = SHOWN * shape / np.max(np.abs(shape) / system.scale)
        shown.append((place._replace(t=float(k), q=place.q + change), T))
    if found.unstable:
        _say(console, f"the equilibrium is unstable: {found.unstable} motions grow")
    return shown, ""


def _say(console: Any, text: str) -> None:
    if console is not None:
        console.print(text, markup=False)


# ------------------------------------------------------------------------------------- results


def _record(model: Model, recorder: Recorder, frames: Iterable[tuple[Place, Array]]) -> None:
    system = model.motion_solver.system
    for name, attributes in model.body_attributes().items():
        recorder.describe_group(f"bodies/{name}", attributes)
    for name, elements in model.surfaces().items():
        recorder.append_many(name, elements)
    clock = CLOCKS[model.scene.analysis.kind]
    for group in ("frames", *(f"probes/{name}" for name in model.scene.probe)):
        recorder.declare(group, "time", "", clock.name)
    statics = model.scene.analysis.kind == "statics"
    for place, T in frames:
        recorder.append("frames", {"time": place.t})
        coef = system.coefficients(T)
        if statics:
            _ledger(recorder, system, place, coef, clock)
        for name, row in model.shapes(place, T).items():
            recorder.append(f"bodies/{name}", row)
        for name, row in model.cells(place, T).items():
            recorder.append(f"solids/{name}", row)
        for name, row in observables.probes(model.probed, model.layout, place, T).items():
            recorder.append(f"probes/{name}", row)


def _ledger(recorder: Recorder, system: System, place: Place, coef: Any, clock: Clock) -> None:
    """Energy stored at an equilibrium; works along the path are not summed up."""
    recorder.declare("windows", "time", "", clock.name)
    recorder.append("windows", {"time": place.t})
    y, v = system.unknowns(place.q, place.lam), np.zeros(system.n + system.m)
    bodies, contacts = system.energies(y, v, system.timed(coef, place.t))[:2]
    recorder.append("ledger", {"strain": bodies, "contact_elastic": contacts})
