"""Opinions of other programs as quantities of the stages that a crosscheck compares."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.quantities import Quantity
from coupling.descriptions import line_bodies
from coupling.errors import BadCase
from coupling.opinion import Opinion
from coupling.scene import Scene

Array = NDArray[np.float64]

STEPS = 200
"""Equal steps of a motion in time that a program takes at the least."""


class Told(NamedTuple):
    """What a program told of all stages it was asked for.

    dof : of the last of them;  quantities : stage -> all of it
    seconds : stage -> run time [s];  why : stage -> why it yields nothing
    """

    dof: int
    quantities: dict[str, list[Quantity]]
    seconds: dict[str, float]
    why: dict[str, str]


def told(name: str, scene: Scene) -> Told:
    """What "calculix" or "exudyn" makes of the stages of a scene's [crosscheck]."""
    ask = {"calculix": _by_calculix, "exudyn": _by_exudyn}[name]
    dof, found, seconds, why = 0, {}, {}, {}
    for stage in scene.crosscheck.stages:  # type: ignore[union-attr]
        if stage not in YIELDS:
            why[stage] = "it is not asked for this"
            continue
        try:
            said = ask(_counted(scene), stage)
        except BadCase as error:
            why[stage] = "; ".join(problem.text for problem in error.problems)
            continue
        dof, seconds[stage] = said.dof, said.seconds
        found[stage] = list(YIELDS[stage](scene, said))
    return Told(dof, found, seconds, why)


def _counted(scene: Scene) -> Scene:
    """With as many modes as are compared."""
    count = scene.crosscheck.modes  # type: ignore[union-attr]
    analysis = scene.analysis.model_copy(update={"count": count})
    return scene.model_copy(update={"analysis": analysis})


def _steps(scene: Scene) -> int:
    """Of a motion: whole numbers in each window."""
    windows = scene.time.windows
    return windows * -(-STEPS // windows)


def _by_calculix(scene: Scene, stage: str) -> Opinion:
    from coupling.deck import Options, fineness_of
    from coupling.deck_run import opinion

    steps = _steps(scene) if stage == "transient" else None
    return opinion(scene, stage, Options(fineness_of(scene), steps=steps))


def _by_exudyn(scene: Scene, stage: str) -> Opinion:
    from coupling.exudyn_case import Options, opinion

    return opinion(scene, stage, Options(steps=_steps(scene)))


# ----------------------------------------------------------------------------------- stages


def _mass(scene: Scene, said: Opinion) -> Iterator[Quantity]:
    yield Quantity("mass", "kg", np.array(said.mass))


def _thermal_load(scene: Scene, said: Opinion) -> Iterator[Quantity]:
    for name, moved in said.displacements.items():
        body = scene.probe[name].body
        if body in line_bodies(scene):
            e1 = scene.shapes[body].axes[0, 0]
            along = float(moved @ e1)
            yield Quantity(f"{name}: along", "m", np.array(along))
            yield Quantity(f"{name}: across", "m", moved - along * e1)


def _static(scene: Scene, said: Opinion) -> Iterator[Quantity]:
    for name, moved in said.displacements.items():
        yield Quantity(f"{name}: displacement", "m", moved)


def _frequencies(scene: Scene, said: Opinion) -> Iterator[Quantity]:
    """In their order, not paired by shapes."""
    for k, frequency in enumerate(said.frequencies.tolist(), 1):
        yield Quantity(f"mode {k}", "Hz", np.array(frequency))


def _transient(scene: Scene, said: Opinion) -> Iterator[Quantity]:
    times = scene.time.window * np.arange(scene.time.windows + 1, dtype=np.float64)
    for name, course in said.courses.items():
        moved = _at(times, said.times, course)
        yield Quantity(f"{name}: farthest", "m", np.array(np.linalg.norm(moved, axis=1).max()))
        yield Quantity(f"{name}: displacement, rms", "m", moved, "rms")
        yield Quantity(f"{name}: displacement, most", "m", moved, "most")


def _at(times: Array, own: Array, course: Array) -> Array:
    """(w, 3)  a course that begins at rest, at other times."""
    if not len(own) or own[0] > 0.0:
        own, course = np.append(0.0, own), np.vstack([np.zeros(3), course])
    return np.column_stack([np.interp(times, own, column) for column in course.T])


YIELDS: dict[str, Callable[[Scene, Any], Iterator[Quantity]]] = {
    "mass": _mass,
    "thermal_load": _thermal_load,
    "static": _static,
    "frequencies": _frequencies,
    "transient": _transient,
}
