"""Other programs as participants, where they are installed and able."""

from collections.abc import Callable, Iterator
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.measured import Measured
from coupling.crosscheck.quantities import Quantity
from coupling.crosscheck.solved import asked
from coupling.descriptions import line_bodies
from coupling.errors import BadCase
from coupling.opinion import Opinion
from coupling.scene import Scene

Array = NDArray[np.float64]

PROGRAMS = {"calculix": "coupling.deck_run:opinion", "exudyn": "coupling.exudyn_case:opinion"}
"""Functions that ask them, by participant."""
NO_STAGE = "has no stage"
Ask = Callable[[Scene, str], Opinion]


def measured_by(name: str, scene: Scene) -> Measured | str:
    """What a program yields, stage by stage, or one sentence why it yields nothing."""
    module, function = PROGRAMS[name].split(":")
    ask: Ask = getattr(import_module(module), function)
    found = Measured(name, 0, {}, {}, {})
    turning = "transient" if "transient" in asked(scene).stages else "static"
    for stage in asked(scene).stages:
        if stage == "pointing":
            continue
        try:
            opinion = ask(scene, stage)
        except BadCase as error:
            told = [p.text for p in error.problems if NO_STAGE not in p.text]
            found.why[stage] = "; ".join(told) or "it is not asked for that"
            continue
        found.quantities[stage] = list(YIELDS[stage](scene, opinion))
        found.seconds[stage] = opinion.seconds
        found = found._replace(dof=max(found.dof, opinion.dof))
        if "pointing" in asked(scene).stages and stage == turning:
            found.quantities["pointing"] = list(_turned(scene, opinion))
    return found if found.quantities else "; ".join(dict.fromkeys(found.why.values()))


# ------------------------------------------------------------------------------ quantities


def _mass(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    yield Quantity("mass", "kg", np.array(opinion.mass))


def _rigid_modes(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    (name, *others) = line_bodies(scene)
    f = np.asarray(opinion.frequencies)
    if others or len(f) < 7:
        return
    rigid = np.array(np.abs(f[:6]).max() / f[6])
    yield Quantity(f"{name}: first elastic frequency", "Hz", np.array(f[6]))
    yield Quantity(f"{name}: six rigid frequencies / elastic", "1", rigid, "nothing")


def _thermal_load(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    for name, moved in opinion.displacements.items():
        body = scene.probe[name].body
        if body in line_bodies(scene):
            e1 = scene.shapes[body].axes[0, 0]
            along = np.array(moved @ e1)
            yield Quantity(f"{name}: along", "m", along)
            yield Quantity(f"{name}: across", "m", moved - along * e1)


def _static(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    for name, moved in opinion.displacements.items():
        yield Quantity(f"{name}: displacement", "m", np.asarray(moved))


def _frequencies(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    """In their order: their shapes are not known here."""
    for k, frequency in enumerate(opinion.frequencies[: asked(scene).modes], 1):
        yield Quantity(f"mode {k}", "Hz", np.array(frequency))


def _transient(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    for name, course in opinion.courses.items():
        moved = _at_windows(scene, opinion.times, course)
        far = np.array(np.linalg.norm(moved, axis=1).max())
        yield Quantity(f"{name}: farthest", "m", far)
        yield Quantity(f"{name}: displacement, rms", "m", moved, "rms")
        yield Quantity(f"{name}: displacement, most", "m", moved, "most")


def _turned(scene: Scene, opinion: Opinion) -> Iterator[Quantity]:
    for name, turn in opinion.turns.items():
        turn = 1e3 * np.asarray(turn)
        if turn.ndim == 1:
            yield Quantity(f"{name}: rotation", "mrad", turn)
            continue
        turn = _at_windows(scene, opinion.times, turn)
        yield Quantity(f"{name}: rotation, rms", "mrad", turn, "rms")
        yield Quantity(f"{name}: rotation, most", "mrad", turn, "most")


def _at_windows(scene: Scene, times: Array, course: Array) -> Array:
    """(w + 1, 3)  of a course that begins with zero, at the ends of the windows."""
    ends = scene.time.window * np.arange(scene.time.windows + 1)
    times = np.concatenate([[0.0], times])
    course = np.concatenate([np.zeros((1, course.shape[1])), course])
    return np.stack([np.interp(ends, times, column) for column in course.T], axis=1)


YIELDS: dict[str, Callable[[Scene, Opinion], Iterator[Quantity]]] = {
    "mass": _mass,
    "rigid_modes": _rigid_modes,
    "thermal_load": _thermal_load,
    "static": _static,
    "frequencies": _frequencies,
    "transient": _transient,
}
