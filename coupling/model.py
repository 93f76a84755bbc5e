"""A scene built: solvers, transfer, and what can be read from their states."""

import importlib.metadata
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling import manager, observables
from coupling.contact_history import Steps
from coupling.contacts import Contact, attributes, contacts_of
from coupling.descriptions import (
    flexible_bodies,
    motion_description,
    shells,
    sided_joints,
)
from coupling.errors import BadCase, Problem
from coupling.manager import Coupled, Pair
from coupling.plan import plan
from coupling.scene import Scene
from coupling.shares import shares
from coupling.transfer import transfer
from mechanics.dynamics import Control
from mechanics.layout import Layout
from mechanics.ledger import TERMS
from mechanics.march import Rows
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics

Array = NDArray[np.float64]

SMALLEST_STEP = 1e-9
"""Smallest mechanical step, in windows, where the case names none [-]."""


@dataclass(frozen=True)
class Model:
    """Everything that a run needs and that does not change while it runs."""

    scene: Scene
    pair: Pair
    plan: str

    def __str__(self) -> str:
        return self.plan

    # -- time ----------------------------------------------------------------------------------

    @property
    def scheme(self) -> str:
        """Name in ``coupling.manager.SCHEMES``, or iterated."""
        return "isothermal" if self.scene.thermal is None else self.scene.coupling.scheme

    @cached_property
    def advance(self) -> Callable[..., manager.Result]:
        """The scheme: takes pair, state, time, length of the window and an observer."""
        if self.scheme != "iterated":
            return manager.SCHEMES[self.scheme]
        from coupling.iteration import Iterated

        return Iterated(**self.scene.coupling.iteration)

    @cached_property
    def pace(self) -> Any:
        """Limits of windows (``coupling.pace.Pace``); None: all are of one length."""
        table = self.scene.coupling.adaptive
        if table is None or self.scene.thermal is None:
            return None
        from coupling.pace import Coefficients, Pace

        coefficients = Coefficients(self.motion_solver.system, self.pair.transfer.read)
        return Pace(coefficients, table.change, table.tolerance, table.iterations)

    @property
    def window(self) -> float:
        """Coupling window [s], the largest where they adapt."""
        return self.scene.time.window

    @property
    def windows(self) -> int:
        return self.scene.time.windows

    @property
    def end(self) -> float:
        """End of the run [s]."""
        return self.scene.time.end

    @property
    def smallest_window(self) -> float:
        return self.scene.coupling.smallest_window or 0.0

    @property
    def frames(self) -> int:
        return self.scene.output.frames

    @property
    def motion_solver(self) -> Mechanics:
        solver = self.pair.motion_solver
        assert isinstance(solver, Mechanics)
        return solver

    @property
    def layout(self) -> Layout:
        return self.motion_solver.system.layout

    # -- states --------------------------------------------------------------------------------

    def initial(self) -> Coupled:
        """State at t = 0. Raises BadCase if joints or heat allow none."""
        table = self.scene.thermal
        try:
            return manager.initial(
                self.pair,
                table is not None and table.start == "steady",
                self.scene.analysis.start == "equilibrium",
            )
        except ValueError as error:
            place, text = "joint", str(error)
            if text.startswith("heat: "):
                place, text = "thermal", text.removeprefix("heat: ")
            raise BadCase(str(self.scene.folder), [Problem(place, text)]) from None

    def sections(self, state: Coupled) -> Array:
        """Section temperatures (m, 3) [K, K/m, K/m]."""
        return self.pair.transfer.read(state.T)

    def ledger(self, state: Coupled) -> dict[str, float]:
        """Energies and works so far [J], mechanical and thermal."""
        row = dict(zip(TERMS, map(float, state.motion.ledger), strict=True))
        solver = self.pair.heat_solver
        if solver is not None:
            stored = solver.energy(state.T) - self._heat_at_start
            row |= {"heat_stored": stored, "heat_exchanged": state.deposited}
            if self.scene.thermal is not None and self.scene.thermal.elastic is not None:
                row["heat_of_deformation"] = state.elastic
            row |= {f"heat_{name}": value for name, value in state.flows.items()}
            row["heat_defect"] = stored - state.deposited - sum(state.flows.values())
        return row

    @cached_property
    def _heat_at_start(self) -> float:
        solver = self.pair.heat_solver
        return 0.0 if solver is None else solver.energy(solver.initial())

    def probes(self, state: Coupled) -> dict[str, dict[str, Any]]:
        """Position, velocity, acceleration and temperature at each probe."""
        motion, T = state.motion.motion, self.sections(state)
        return observables.probes(self.probed, self.layout, motion, T)

    @cached_property
    def probed(self) -> Mapping[str, observables.Probed]:
        """Where the probes are."""
        return observables.probed(self.scene, self.layout)

    def bodies(self, state: Coupled) -> dict[str, dict[str, Array]]:
        """Shape, section temperatures and resultants of each body."""
        return self.shapes(state.motion.motion, self.sections(state))

    def shapes(self, motion: Any, T: Array) -> dict[str, dict[str, Array]]:
        """The same of a motion at section temperatures (m, 3); of solids as beams."""
        system = self.motion_solver.system
        found = observables.bodies(system, motion, T, system.coefficients(T))
        return found | (self._solids.bodies(motion.q, T) if self._solids else {})

    @cached_property
    def _solids(self) -> Any:
        if not self.scene.mechanics.is_continuum:
            return None
        from coupling.continuum_rows import SolidRows

        return SolidRows(self.scene, self.motion_solver.system)

    def cells(self, motion: Any, T: Array) -> dict[str, dict[str, Array]]:
        """Positions, temperatures and stress of solids, by name."""
        if not self._solids:
            return {}
        return self._solids.cells(motion, T, self.motion_solver.system.coefficients(T))

    def body_attributes(self) -> dict[str, dict[str, Any]]:
        """What drawing needs to know of the bodies."""
        found = observables.attributes(self.layout)
        return found | (self._solids.attributes() if self._solids else {})

    def surfaces(self) -> dict[str, dict[str, NDArray]]:
        """Elements of the shells and cells of the solids, by group."""
        shells = observables.surfaces(self.layout).items()
        found = {f"surfaces/{name}": elements for name, elements in shells}
        return found | (self._solids.elements() if self._solids else {})

    @cached_property
    def _skins(self) -> Sequence[Any]:
        if not self.scene.output.skins:
            return ()
        from coupling.skins import skins

        return skins(self.scene, self.pair.heat_solver, self.layout)

    def skins(self, state: Coupled) -> dict[str, dict[str, Array]]:
        """Corners, temperature and light of the faces that are recorded."""
        q = state.motion.motion.q
        return {skin.name: skin.row(state.T, state.outside, q) for skin in self._skins}

    @cached_property
    def _environment(self) -> Any:
        table = None if self.scene.thermal is None else self.scene.thermal.environment
        if table is None:
            return None
        from coupling.environments import environment

        return environment(table)

    def sky(self, state: Coupled) -> dict[str, Any]:
        """Sun and planet at the time of a state; empty without [thermal.environment]."""
        if self._environment is None:
            return {}
        from coupling.skies import row

        return row(self._environment, state.motion.motion.t)

    # -- contacts ------------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> list[Contact]:
        """Contacts of the joints with clearance, in the order of their histories."""
        return contacts_of(self.scene, self.motion_solver.system)

    def contact_attributes(self) -> dict[str, dict[str, Any]]:
        """What drawing needs to know of the contacts, by name."""
        return {
            contact.name: attributes(self.scene, contact, number, self._centre(contact))
            for number, contact in enumerate(self.contacts)
        }

    def _centre(self, contact: Contact) -> Array | None:
        """(3,) [m]  of the bearing at the start."""
        return None if contact.points is None else self.layout.x[contact.points[1:]].mean(axis=0)

    def steps(self, before: Coupled, rows: Sequence[Rows]) -> Steps:
        """The accepted steps of a window that began in a state, with what contacts did in them."""
        system, motion = self.motion_solver.system, before.motion.motion
        y = system.unknowns(motion.q, motion.lam)
        v = np.concatenate([motion.v, np.zeros(system.m)])
        response = system.respond(y, v, system.coefficients(self.sections(before)))
        whole = [contact.row for contact in self.contacts]
        return Steps(
            np.concatenate([[motion.t], *(r.t for r in rows)]),
            np.concatenate([response[None], *(r.response for r in rows)])[:, whole],
            np.concatenate([motion.approach[None], *(r.approach for r in rows)])[:, whole],
        )

    def contact_temperatures(
        self, contact: Contact, before: Coupled, after: Coupled, times: Array
    ) -> dict[str, Array]:
        """Temperatures (k,) [K] of journal and bearing at times within a window."""
        if contact.points is None:
            return {}
        t0, t1 = before.motion.motion.t, after.motion.motion.t
        s = ((times - t0) / (t1 - t0))[:, None]
        T0, T1 = (self.sections(state)[contact.points, 0] for state in (before, after))
        T = (1.0 - s) * T0 + s * T1
        return {"temperature_journal": T[:, 0], "temperature_bearing": T[:, 1:].mean(axis=1)}

    # -- for people ----------------------------------------------------------------------------

    def progress_text(self, window: Any) -> str:
        """What a person wants to know of a window: steps, corrections, contact, balance."""
        motion = window.state.motion
        accepted, refused, corrections, _ = motion.counts
        parts = [f"step {self._rung(motion):.2g} s",
                 f"{corrections / max(accepted, 1):.1f} Newton/step",
                 f"{refused} refused"]  # fmt: skip
        if len(motion.motion.approach):
            parts.append(f"{np.count_nonzero(motion.motion.approach)} in contact")
        if window.exchanges > 1:
            parts.append(f"{window.exchanges} exchanges")
        if len(window.state.T):
            parts.append(f"{window.state.T.min():.0f}…{window.state.T.max():.0f} K")
        parts.append(f"energy defect {motion.ledger[-1]:.1e} J")
        return ", ".join(parts)

    def _rung(self, motion: Any) -> float:
        return self.motion_solver.control.largest_step / 2**motion.rung

    def meta(self, scene: Scene) -> dict[str, Any]:
        """Root attributes of the results."""
        return {"title": scene.title, "analysis": scene.analysis.kind, "scene": scene.text,
                "plan": self.plan, "versions": _versions()}  # fmt: skip


def build(scene: Scene) -> Model:
    """Build the solvers of a scene. Raises BadCase with what they refuse."""
    problems: list[Problem] = []
    motion_solver = _tried(problems, lambda: _motion(scene))
    heat_solver = None
    if scene.thermal is not None:
        heat_solver = _tried(problems, lambda: _heat(scene))
    if problems:
        raise BadCase(str(scene.folder), problems)
    reading = _transfer(scene, motion_solver, heat_solver)
    around = _tried(problems, lambda: _surroundings(scene, motion_solver, heat_solver, reading))
    if problems:
        raise BadCase(str(scene.folder), problems)
    pair = Pair(heat_solver, motion_solver, reading, around)
    return Model(scene, pair, plan(scene, motion_solver.system, heat_solver))


def _tried(problems: list[Problem], make: Any) -> Any:
    """What ``make`` makes, or its complaints line by line among the problems."""
    try:
        return make()
    except ValueError as error:
        problems += [Problem("", line) for line in str(error).splitlines()]
        return None


def _motion(scene: Scene) -> Mechanics:
    return Mechanics(motion_description(scene), _control(scene), scene.integrator.solver)


def _heat(scene: Scene) -> Any:
    from coupling.heat_descriptions import heat_description, settings
    from thermal.solvers import build as build_heat

    assert scene.thermal is not None
    if scene.thermal.participant is not None:
        from coupling.external_heat import ExternalHeat

        there = scene.thermal.participant
        return ExternalHeat(there.address, there.patience, scene.text)
    return build_heat(scene.thermal.solver, heat_description(scene), settings(scene.thermal))


def _surroundings(
    scene: Scene, motion_solver: Mechanics, heat_solver: Any, reading: manager.Transfer
) -> manager.Surroundings | None:
    """What passes from motion to heat besides friction; None where nothing does."""
    table = scene.thermal
    if table is None or not (table.contact or table.elastic or table.environment):
        return None
    from coupling.surroundings import Around

    light = None
    if table.environment is not None:
        from coupling.environments import exposure

        light = exposure(scene, heat_solver, motion_solver.system.layout)
    joints = None
    if table.contact:
        from coupling.joint_conductance import joint_conductance

        joints = joint_conductance(scene, motion_solver)
    elastic = None
    if table.elastic is not None:
        from coupling.elastic_heat import ElasticHeat

        elastic = ElasticHeat(scene, motion_solver.system, heat_solver, reading)
    return Around(reading, light, joints, elastic)


def _control(scene: Scene) -> Control:
    i, window = scene.integrator, scene.time.window
    own: dict[str, Any] = {"alpha": i.alpha, "spectral_radius": i.spectral_radius}
    scheme = Scheme(
        i.scheme,
        newton_tolerance=_newton_tolerance(scene),
        constraints=i.constraints,
        baumgarte_rate=i.baumgarte_rate,
        **{key: value for key, value in own.items() if value is not None},
    )
    smallest = i.smallest_step or SMALLEST_STEP * window
    return Control(i.tolerance, i.largest_step or window, smallest, scheme)


def _newton_tolerance(scene: Scene) -> float:
    """That of the case; of solids what rounding lets them reach, unless the case says it."""
    own = scene.integrator.newton_tolerance
    if not scene.mechanics.is_continuum or "newton_tolerance" in scene.integrator.model_fields_set:
        return own
    from coupling.continuum import resolution

    return max(own, resolution(scene))


def _transfer(scene: Scene, motion_solver: Mechanics, heat_solver: Any) -> manager.Transfer:
    owners: dict[str, Any] = {**sided_joints(scene), **flexible_bodies(scene)}
    rest = np.zeros(len(motion_solver.x))
    for name, rows in motion_solver.regions.items():
        owner = owners.get(name) or owners[name.rpartition(".")[0]]
        rest[rows] = owner.reference_temperature
    x, regions = (
        (np.zeros((0, 3)), {}) if heat_solver is None else (heat_solver.x, heat_solver.regions)
    )
    weights = shares(scene, heat_solver)
    return transfer(
        x, regions, motion_solver.x, motion_solver.axes, motion_solver.regions, rest, shells(scene),
        weights, _of_solids(scene, heat_solver, weights),
    )  # fmt: skip


def _of_solids(scene: Scene, heat_solver: Any, weights: dict[str, Array]) -> dict[str, Any]:
    """How the nodes of solids read temperatures."""
    if not scene.mechanics.is_continuum or heat_solver is None:
        return {}
    from coupling.continuum_transfer import readings

    return readings(scene, heat_solver, weights)


def _versions() -> dict[str, str]:
    names = ("thermobody", "numpy", "scipy", "numba", "scikit-fem", "h5py")
    found = {"python": platform.python_version()}
    for name in names:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
