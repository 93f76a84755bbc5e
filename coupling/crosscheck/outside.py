"""Other programs as participants of a crosscheck, where they are installed and able."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.measured import Measured
from coupling.crosscheck.quantities import Quantity
from coupling.crosscheck.solved import asked as crosscheck_of
from coupling.descriptions import flexible_bodies, line_bodies
from coupling.errors import BadCase
from coupling.opinion import Opinion
from coupling.scene import Scene

Array = NDArray[np.float64]

RIGID = 6
"""Motions of a free body without strain."""
STEPS = 200
"""Equal steps of a motion in time that a program takes at the least."""


def measured_by(name: str, scene: Scene) -> Measured | str:
    """What "calculix" or "exudyn" makes of the stages; one sentence where it makes nothing."""
    program = {"calculix": _by_calculix, "exudyn": _by_exudyn}[name]
    asked = _Asked(program, scene)
    for stage in crosscheck_of(scene).stages:
        asked.about(stage)
    if not asked.quantities:
        return "; ".join(dict.fromkeys(asked.why.values()))
    return Measured(name, asked.dof, asked.quantities, asked.seconds, asked.why)


class _Asked:
    """A program that is asked about a scene, stage by stage; no question twice."""

    def __init__(self, program: Callable[[Scene, str], Opinion], scene: Scene) -> None:
        self._program, self._scene = program, scene
        self._known: dict[str, Opinion] = {}
        self.dof = 0
        self.quantities: dict[str, list[Quantity]] = {}
        self.seconds: dict[str, float] = {}
        self.why: dict[str, str] = {}

    def about(self, stage: str) -> None:
        """Ask for the quantities of a stage."""
        if stage not in YIELDS:
            self.why[stage] = "it is not asked for this"
            return
        try:
            self.quantities[stage] = list(YIELDS[stage](self))
        except BadCase as error:
            self.why[stage] = "; ".join(problem.text for problem in error.problems)

    @property
    def scene(self) -> Scene:
        """With its [crosscheck]."""
        return self._scene

    def said(self, stage: str) -> Opinion:
        """What the program makes of a stage; the time counts for the stage that asks first."""
        if stage not in self._known:
            self._known[stage] = self._program(_counted(self._scene), stage)
            self.dof = max(self.dof, self._known[stage].dof)
            self.seconds[stage] = self._known[stage].seconds
        return self._known[stage]

    def alone(self, body: str) -> Opinion:
        """Vibrations of a body that nothing holds."""
        nothing: dict[str, object] = {
            "joint": {},
            "load": {},
            "gravity": None,
            "thermal": None,
            "probe": {},
        }
        analysis = self._scene.analysis.model_copy(update={"count": RIGID + 1, "kind": "modes"})
        own = {"body": {body: self._scene.body[body]}, "analysis": analysis}
        found = self._program(self._scene.model_copy(update=nothing | own), "frequencies")
        self.dof = max(self.dof, found.dof)
        self.seconds["rigid_modes"] = self.seconds.get("rigid_modes", 0.0) + found.seconds
        return found


def _counted(scene: Scene) -> Scene:
    """With as many modes as are compared."""
    count = crosscheck_of(scene).modes
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


Quantities = Iterator[Quantity]


def _mass(asked: _Asked) -> Quantities:
    yield Quantity("mass", "kg", np.array(asked.said("mass").mass))


def _rigid_modes(asked: _Asked) -> Quantities:
    for body in flexible_bodies(asked.scene):
        found = np.sort(np.abs(asked.alone(body).frequencies))
        elastic, rigid = found[RIGID], found[RIGID - 1]
        yield Quantity(f"{body}: first elastic frequency", "Hz", np.array(elastic))
        yield Quantity(
            f"{body}: six rigid frequencies / elastic", "1", np.array(rigid / elastic), "nothing"
        )


def _thermal_load(asked: _Asked) -> Quantities:
    scene = asked.scene
    for name, moved in asked.said("thermal_load").displacements.items():
        body = scene.probe[name].body
        if body in line_bodies(scene):
            e1 = scene.shapes[body].axes[0, 0]
            along = float(moved @ e1)
            yield Quantity(f"{name}: along", "m", np.array(along))
            yield Quantity(f"{name}: across", "m", moved - along * e1)


def _static(asked: _Asked) -> Quantities:
    for name, moved in asked.said("static").displacements.items():
        yield Quantity(f"{name}: displacement", "m", moved)


def _frequencies(asked: _Asked) -> Quantities:
    """In their order, not paired by shapes."""
    for k, frequency in enumerate(asked.said("frequencies").frequencies.tolist(), 1):
        yield Quantity(f"mode {k}", "Hz", np.array(frequency))


def _transient(asked: _Asked) -> Quantities:
    said = asked.said("transient")
    for name, course in said.courses.items():
        moved = _at(asked.scene, said.times, course)
        yield Quantity(f"{name}: farthest", "m", np.array(np.linalg.norm(moved, axis=1).max()))
        yield Quantity(f"{name}: displacement, rms", "m", moved, "rms")
        yield Quantity(f"{name}: displacement, most", "m", moved, "most")


def _pointing(asked: _Asked) -> Quantities:
    moving = "transient" in crosscheck_of(asked.scene).stages
    said = asked.said("transient" if moving else "static")
    for name, turned in said.turns.items():
        if not moving:
            yield Quantity(f"{name}: rotation", "mrad", 1e3 * turned)
            continue
        course = 1e3 * _at(asked.scene, said.times, turned)
        yield Quantity(f"{name}: rotation, rms", "mrad", course, "rms")
        yield Quantity(f"{name}: rotation, most", "mrad", course, "most")


def _at(scene: Scene, own: Array, course: Array) -> Array:
    """(w + 1, 3)  a course that begins at rest, at the ends of the windows."""
    times = scene.time.window * np.arange(scene.time.windows + 1, dtype=np.float64)
    if not len(own) or own[0] > 0.0:
        own, course = np.append(0.0, own), np.vstack([np.zeros(3), course])
    return np.column_stack([np.interp(times, own, column) for column in course.T])


YIELDS: dict[str, Callable[[_Asked], Quantities]] = {
    "mass": _mass,
    "rigid_modes": _rigid_modes,
    "thermal_load": _thermal_load,
    "static": _static,
    "frequencies": _frequencies,
    "transient": _transient,
    "pointing": _pointing,
}
