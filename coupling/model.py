"""A scene built: solvers, transfer, and what can be read from their states."""

import importlib.metadata
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling import manager, observables
from coupling.descriptions import flexible_bodies, motion_description, shells, sided_joints
from coupling.errors import BadCase, Problem
from coupling.manager import Coupled, Pair
from coupling.places import place_of, point_of
from coupling.plan import plan
from coupling.scene import Scene
from coupling.site_tables import GROUND
from coupling.transfer import transfer
from mechanics.dynamics import Control
from mechanics.layout import Layout
from mechanics.ledger import TERMS
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
        """Name in ``coupling.manager.SCHEMES``."""
        return "isothermal" if self.scene.thermal is None else self.scene.coupling.scheme

    @property
    def window(self) -> float:
        """Coupling window [s]."""
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
        """State at t = 0. Raises BadCase if the joints allow none."""
        try:
            return manager.initial(self.pair)
        except ValueError as error:
            raise BadCase(str(self.scene.folder), [Problem("joint", str(error))]) from None

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
            row |= {f"heat_{name}": value for name, value in state.flows.items()}
            row["heat_defect"] = stored - state.deposited - sum(state.flows.values())
        return row

    @cached_property
    def _heat_at_start(self) -> float:
        solver = self.pair.heat_solver
        return 0.0 if solver is None else solver.energy(solver.initial())

    def probes(self, state: Coupled) -> dict[str, dict[str, Any]]:
        """Position, velocity and temperature at each probe."""
        motion, T = state.motion.motion, self.sections(state)
        return observables.probes(self.scene, self.layout, motion, T)

    def bodies(self, state: Coupled) -> dict[str, dict[str, Array]]:
        """Shape, section temperatures and resultants of each body."""
        T, system = self.sections(state), self.motion_solver.system
        return observables.bodies(system, state.motion.motion, T, system.coefficients(T))

    def body_attributes(self) -> dict[str, dict[str, Any]]:
        """What drawing needs to know of the bodies."""
        return observables.attributes(self.layout)

    def surfaces(self) -> dict[str, dict[str, NDArray]]:
        """Elements of the shells."""
        return observables.surfaces(self.layout)

    # -- clearance joints ----------------------------------------------------------------------

    def joint_names(self) -> list[str]:
        """Clearance joints, in the order of their histories."""
        contact = self.motion_solver.system.contact
        return [] if contact is None else list(contact.names)

    def joint_attributes(self) -> dict[str, dict[str, Any]]:
        """Geometry of the clearance joints; ``directions`` are the axes of the orbit at t = 0."""
        contact, joints = self.motion_solver.system.contact, sided_joints(self.scene)
        rows: dict[str, dict[str, Any]] = {}
        for name, plane in zip(
            self.joint_names(), [] if contact is None else contact.planes, strict=True
        ):
            joint = joints[name]
            rows[name] = {
                "radius": joint.radius, "reference_clearance": joint.clearance,
                "axis": np.array(joint.axis), "directions": plane,
                "position": self.layout.x[self.layout.point_index[f"{name}.bearing"][0]],
                **self._side("journal", joint.journal), **self._side("bearing", joint.bearing),
            }  # fmt: skip
        return rows

    def _side(self, side: str, site: Any) -> dict[str, Any]:
        """Body and node of one side of a joint, and how far from it; nothing for the ground.

        The distance [m] is along e1, e2, e3 of the node.
        """
        if site.body == GROUND:
            return {}
        shape = self.scene.shapes[site.body]
        place = place_of(shape, site)
        away = shape.axes[place.node] @ (point_of(shape, place) - shape.points[place.node])
        return {
            f"{side}_body": site.body, f"{side}_node": place.node, f"{side}_offset": away
        }  # fmt: skip

    def driven_rows(self) -> NDArray[np.intp]:
        """Which of the driven rows drives each clearance joint; -1 where none does."""
        system = self.motion_solver.system
        driven = {system.row_names[row]: i for i, row in enumerate(system.driven)}
        return np.array([driven.get(name, -1) for name in self.joint_names()], np.intp)

    def joint_temperatures(self, before: Coupled, after: Coupled, times: Array) -> Array:
        """(k, n_j, 2) [K] of journal and bearing at times within a window."""
        points = self.motion_solver.system.contact.points
        t0, t1 = before.motion.motion.t, after.motion.motion.t
        s = ((times - t0) / (t1 - t0))[:, None, None]
        T0, T1 = self.sections(before)[points, 0], self.sections(after)[points, 0]
        return (1.0 - s) * T0 + s * T1

    def joint_rows(
        self,
        joint: int,
        times: Array,
        response: Array,
        approach: Array,
        torque: Array,
        temperatures: Array,
    ) -> Mapping[str, Array]:
        """Columns of the history of one clearance joint.

        Parameters
        ----------
        response : (k, columns) of the joint; approach, torque : (k,); temperatures : (k, 2)
        """
        contact = self.motion_solver.system.contact
        column = {name: response[:, i] for i, name in enumerate(contact.columns)}
        table = sided_joints(self.scene)[self.joint_names()[joint]]
        angle = table.angle or (lambda t: 0.0)
        return {
            "time": times,
            "orbit": response[:, :2],
            "clearance": column["clearance"],
            "penetration": column["penetration"],
            "normal_force": column["elastic_force"] + column["dissipative_force"],
            "friction_force": column["friction_force"],
            "slip_speed": column["slip_speed"],
            "angle": np.array([angle(t) for t in times]),
            "torque": torque,
            "regime": self._regimes(joint, response, approach),
            "temperature_journal": temperatures[:, 0],
            "temperature_bearing": temperatures[:, 1],
        }

    def _regimes(self, joint: int, response: Array, approach: Array) -> NDArray[np.int8]:
        from mechanics.contact import classify

        columns = self.motion_solver.system.contact.columns
        depth, rate, slip = (
            response[:, columns.index(c)] for c in ("penetration", "rate", "slip_speed")
        )
        friction = sided_joints(self.scene)[self.joint_names()[joint]].friction
        speed = 0.0 if friction is None else friction.regularisation_speed
        return classify(depth, rate, approach, slip, speed)

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
    pair = Pair(heat_solver, motion_solver, _transfer(scene, motion_solver, heat_solver))
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
    from coupling.heat_descriptions import heat_description
    from thermal.solvers import build as build_heat

    assert scene.thermal is not None
    return build_heat(scene.thermal.solver, heat_description(scene))


def _control(scene: Scene) -> Control:
    i, window = scene.integrator, scene.time.window
    own: dict[str, Any] = {"alpha": i.alpha, "spectral_radius": i.spectral_radius}
    scheme = Scheme(
        i.scheme,
        newton_tolerance=i.newton_tolerance,
        constraints=i.constraints,
        baumgarte_rate=i.baumgarte_rate,
        **{key: value for key, value in own.items() if value is not None},
    )
    smallest = i.smallest_step or SMALLEST_STEP * window
    return Control(i.tolerance, i.largest_step or window, smallest, scheme)


def _transfer(scene: Scene, motion_solver: Mechanics, heat_solver: Any) -> manager.Transfer:
    owners: dict[str, Any] = {**sided_joints(scene), **flexible_bodies(scene)}
    rest = np.zeros(len(motion_solver.x))
    for name, rows in motion_solver.regions.items():
        owner = owners.get(name) or owners[name.split(".")[0]]
        rest[rows] = owner.reference_temperature
    x, regions = (
        (np.zeros((0, 3)), {}) if heat_solver is None else (heat_solver.x, heat_solver.regions)
    )
    return transfer(
        x, regions, motion_solver.x, motion_solver.axes, motion_solver.regions, rest, shells(scene)
    )


def _versions() -> dict[str, str]:
    names = ("thermobody", "numpy", "scipy", "numba", "scikit-fem", "h5py")
    found = {"python": platform.python_version()}
    for name in names:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
