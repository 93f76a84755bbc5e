"""A case as one model computes it: built once, solved stage by stage, with the time each takes.

Models of beams and of solids go through the same functions, since both are systems of terms.
"""

from collections.abc import Callable
from functools import cached_property
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.analyses import Place, temperatures
from coupling.crosscheck.samples import Samples, Section, samples, sections
from coupling.crosscheck_tables import Crosscheck
from coupling.manager import Coupled
from coupling.model import Model, build
from coupling.observables import Probed, probed
from coupling.scene import Scene

Array = NDArray[np.float64]


def asked(scene: Scene) -> Crosscheck:
    """The [crosscheck] of a case that has one."""
    assert scene.crosscheck is not None  # the command has looked
    return scene.crosscheck


class Failed(Exception):  # noqa: N818 (says it in the language of its reader)
    """A model cannot do a stage, or did not come to its end; with the reason."""


class Vibrations(NamedTuple):
    """frequencies : (k,) float [Hz];  shapes : (k, 3 n) float  of the material points"""

    frequencies: Array
    shapes: Array


class Course(NamedTuple):
    """A run in time.

    places : probe -> (w + 1, 3) [m];  turns : probe -> (w + 1, 3) [rad]
    steps : contacts of each window, see ``coupling.contact_history.Steps``
    final : the state at the end;  peak : coordinates where the first probe is farthest away
    """

    places: dict[str, Array]
    turns: dict[str, Array]
    steps: list[Any]
    initial: Coupled
    final: Coupled
    peak: Array


class Solved:
    """A model with what has been computed of it.

    Attributes
    ----------
    name : of the participant
    seconds : stage -> float [s]  of the processor, of what is solved there
    """

    def __init__(self, name: str, scene: Scene):
        self.name = name
        self.scene = scene
        self.seconds: dict[str, float] = {}
        self.model: Model = self.timed("mass", lambda: build(scene))

    def timed(self, stage: str, compute: Callable[[], Any]) -> Any:
        """What is computed; its time is added to a stage."""
        begun = process_time()
        try:
            return compute()
        finally:
            spent = process_time() - begun
            self.seconds[stage] = self.seconds.get(stage, 0.0) + spent

    @property
    def dof(self) -> int:
        """Number of coordinates."""
        return int(self.model.motion_solver.system.n)

    # -- rest ----------------------------------------------------------------------------------

    @cached_property
    def temperatures(self) -> tuple[Array, Array]:
        """Section temperatures at the start, and those that the conditions of the end hold."""
        return temperatures(self.model)

    @cached_property
    def equilibrium(self) -> Place:
        """At rest under the loads and temperatures of the end."""
        return self.timed("static", lambda: self._equilibrium(self.model))

    @cached_property
    def expanded(self) -> Place:
        """At rest under the temperatures of the end alone."""
        scene = self.scene.model_copy(update={"load": {}, "gravity": None})
        model = build(scene)
        return self.timed("thermal_load", lambda: self._equilibrium(model))

    def _equilibrium(self, model: Model) -> Place:
        from mechanics.statics import equilibrium

        system, (T0, T1) = model.motion_solver.system, self.temperatures
        c0, c1 = system.coefficients(T0), system.coefficients(T1)
        moving = self.scene.analysis.kind == "dynamics"
        found = equilibrium(
            system, c0, c1, self.scene.analysis.steps, time=model.end if moving else None
        )
        if found.why:
            raise Failed(found.why)
        return Place(model.end if moving else 1.0, found.q, found.lam, np.zeros(system.n))

    def stress(self, place: Place) -> float:
        """Greatest equivalent stress [Pa] in a solid; of beams, which know none, nan."""
        from mechanics.continuum import von_mises

        system = self.model.motion_solver.system
        y, coef = system.unknowns(place.q, place.lam), system.coefficients(self.temperatures[1])
        found = [
            float(von_mises(term.stresses(y, c)).max())
            for term, c in zip(system.terms, coef, strict=True)
            if hasattr(term, "stresses")
        ]
        return max(found, default=float("nan"))

    # -- vibration -----------------------------------------------------------------------------

    def vibrations(self, count: int, points: dict[str, Array]) -> Vibrations:
        """The lowest modes about the equilibrium, seen at material points."""
        from mechanics.modes import modes

        place, system = self.equilibrium, self.model.motion_solver.system
        coef = system.coefficients(self.temperatures[1])
        found = self.timed(
            "frequencies", lambda: modes(system, place.q, place.lam, coef, count, place.t)
        )
        return Vibrations(found.frequencies, (self.samples(points).matrix @ found.shapes).T)

    def samples(self, points: dict[str, Array]) -> Samples:
        """Material points in the coordinates of this model."""
        return samples(self.model, points)

    @cached_property
    def sections(self) -> dict[str, Section]:
        """Of the probes."""
        return sections(self.model)

    def probed(self, q: Array) -> dict[str, Array]:
        """(3,) [m]  where each probe is at coordinates (n,)."""
        return {
            name: side.weights[0] @ q[side.vectors[:, None] + np.arange(3)]
            for name, (_, side, _) in self._probes.items()
        }

    @cached_property
    def _probes(self) -> dict[str, Probed]:
        return probed(self.scene, self.model.layout)

    # -- motion --------------------------------------------------------------------------------

    @cached_property
    def course(self) -> Course:
        """The run in time, window by window."""
        initial = self.model.initial()
        return self.timed("transient", lambda: self._run(initial))

    def _run(self, initial: Coupled) -> Course:
        from coupling.simulation import Attempts, Stopped, windows

        model, rows = self.model, list[Any]()
        kept, states = list[Any](), [initial]
        attempts = Attempts(rows.clear, rows.append, rows.clear)
        for window in windows(model, initial, attempts=attempts):
            if isinstance(window, Stopped):
                raise Failed(f"stopped at {window.t:g} s: {window.why}")
            if model.contacts and rows:
                kept.append(model.steps(states[-1], rows))
            states.append(window.state)
        found = [self.probed(state.motion.motion.q) for state in states]
        places = {name: np.array([row[name] for row in found]) for name in self.scene.probe}
        turns = {
            name: np.array([section.rotation(s.motion.motion.q) for s in states])
            for name, section in self.sections.items()
        }
        first = next(iter(places.values()), np.zeros((len(states), 3)))
        far = int(np.argmax(np.linalg.norm(first - first[0], axis=1)))
        return Course(places, turns, kept, initial, states[-1], states[far].motion.motion.q)
