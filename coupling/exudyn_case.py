"""Isothermal mechanics of a scene by Exudyn (Gerstmayr 2023), where it is installed.

Beams become its geometrically exact ones, linear along the axis; its ANCF beam has a defective mass
matrix. It knows no heat: scenes with heat are refused.
"""

from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import mechanics.description as motion
from coupling.deck import beams_of, site_of
from coupling.deck_bodies import line_between, stations_of
from coupling.deck_ties import kind_of
from coupling.descriptions import motion_description
from coupling.errors import BadCase, Problem
from coupling.opinion import Opinion
from coupling.reports.exudyn_models import MISSING, empty, quiet, version
from coupling.scene import Scene
from mechanics.description import Beam, Description, Particle, RigidBody, Site

Array = NDArray[np.float64]

ELEMENTS = 64
"""Elements of a beam at the least: they are linear, with one point of quadrature."""
STEPS = 1000
"""Equal steps of a motion in time, where none are asked for."""
RADIUS = 0.9
"""Spectral radius of generalised-alpha."""
LOAD_STEPS = 10
TOLERANCE, ROUNDING = 1e-8, 1e-13
"""Residual at which Newton ends, relative to the first, and to the largest stiffness EA [-]."""
HELD = {
    motion.Clamp: [1, 1, 1, 1, 1, 1],
    motion.Spherical: [1, 1, 1, 0, 0, 0],
    motion.Revolute: [1, 1, 1, 1, 1, 0],
    motion.Cylindrical: [1, 1, 0, 1, 1, 0],
    motion.Prismatic: [1, 1, 0, 1, 1, 1],
    motion.Planar: [0, 0, 1, 1, 1, 0],
}
"""Displacements along, and turns about, axes of a joint whose third is its own."""


class Options(NamedTuple):
    """elements : of each beam at the least;  steps : equal ones of a motion in time"""

    elements: int = ELEMENTS
    steps: int = STEPS


class Placed(NamedTuple):
    """A body of the scene in Exudyn.

    number : of its object;  nodes : of a beam, at ``stations`` (m,) in its own elements
    """

    number: int
    nodes: list[int]
    stations: Array


DEFAULT = Options()


def opinion(scene: Scene, stage: str, options: Options = DEFAULT) -> Opinion:
    """A stage of a scene by Exudyn.

    Parameters
    ----------
    stage : in ``STAGES``

    Raises
    ------
    BadCase : Exudyn is missing, cannot express the scene, or did not finish
    """
    d = motion_description(beams_of(scene))
    problems = list(refusals(scene, d))
    if stage not in STAGES:
        problems.append(f"it has no stage '{stage}', only {', '.join(STAGES)}")
    if version() is None:
        problems = [MISSING]
    if problems:
        raise BadCase(str(scene.folder), [Problem("", f"Exudyn: {p}") for p in problems])
    try:
        with quiet():
            return STAGES[stage](_Written(scene, d, options, stage == "transient"))
    except (ValueError, RuntimeError) as error:
        raise BadCase(str(scene.folder), [Problem("", f"Exudyn: {error}")]) from None


def refusals(scene: Scene, d: Description) -> Iterator[str]:
    """One sentence for each thing that is not written."""
    if scene.thermal is not None:
        yield "thermal: it knows no heat and no expansion"
    if scene.damping is not None:
        yield "damping: Rayleigh's is not written; give [body.NAME] damping instead"
    for body in d.bodies:
        if not isinstance(body, Beam | RigidBody | Particle) or _is_cable(body):
            what = "cable" if _is_cable(body) else kind_of(body)
            yield f"body '{body.name}': a {what} is not written"
    for joint in d.joints:
        if type(joint) not in HELD:
            yield f"joint '{joint.name}': a {kind_of(joint)} is not written"
        elif getattr(joint, "angle", None) or getattr(joint, "travel", None):
            yield f"joint '{joint.name}': it is driven"
    for load in d.loads:
        if not isinstance(load, motion.Force | motion.Moment):
            yield f"load '{load.name}': a {kind_of(load)} is not written"
    beams = {b.name for b in d.bodies if isinstance(b, Beam)}
    for site in [*_sites(d), *(site_of(scene, name) for name in scene.probe)]:
        if site.body in beams and np.any(site.offset):
            yield f"body '{site.body}': a point beside the axis is not written"


def _is_cable(body: motion.Body) -> bool:
    return isinstance(body, Beam) and body.element == "cable"


def _sites(d: Description) -> Iterator[Site]:
    for thing in (*d.joints, *d.loads):
        for side in ("a", "b", "site"):
            if isinstance(getattr(thing, side, None), Site):
                yield getattr(thing, side)


class _Written:
    """A scene in the words of Exudyn.

    moving : whether loads follow their histories
    """

    def __init__(self, scene: Scene, d: Description, options: Options, moving: bool) -> None:
        self.scene, self.d, self.options, self.moving = scene, d, options, moving
        self.probes = {name: site_of(scene, name) for name in scene.probe}
        self.container, self.mbs = empty()
        self.ground = self._ground()
        wanted: dict[str, list[float]] = {}
        for site in [*_sites(d), *self.probes.values()]:
            if site.body is not None:
                wanted.setdefault(site.body, []).append(site.node + site.fraction)
        self.bodies = {b.name: self._body(b, wanted.get(b.name, [])) for b in d.bodies}
        for joint in d.joints:
            self._joint(joint)
        for load in d.loads:
            self._load(load)
        self.seen = {name: self._marker(site) for name, site in self.probes.items()}
        self.mbs.Assemble()

    @property
    def coordinates(self) -> int:
        return int(self.mbs.systemData.ODE2Size())

    @property
    def mass(self) -> float:
        """[kg]"""
        total = 0.0
        for body in self.d.bodies:
            if isinstance(body, Beam):
                lengths = np.linalg.norm(np.diff(body.points, axis=0), axis=1)
                total += body.material.density * body.section.area * float(lengths.sum())
            elif isinstance(body, RigidBody | Particle):
                total += body.mass
        return total

    # -- bodies ----------------------------------------------------------------------------

    def _ground(self) -> int:
        import exudyn.utilities as eu

        return self.mbs.AddObject(eu.ObjectGround())

    def _body(self, body: motion.Body, places: list[float]) -> Placed:
        if isinstance(body, Beam):
            return self._beam(body, places)
        assert isinstance(body, RigidBody | Particle)
        placed = self._rigid(body) if isinstance(body, RigidBody) else self._particle(body)
        self._weight(placed.number)
        return placed

    def _beam(self, body: Beam, places: list[float]) -> Placed:
        import exudyn.utilities as eu

        refine = -(-self.options.elements // (len(body.points) - 1))
        stations = stations_of(len(body.points) - 1, refine, places)
        points, axes = line_between(
            np.asarray(body.points, float), np.asarray(body.axes, float), stations
        )
        v = np.asarray(body.velocity) + np.cross(body.spin, points)
        nodes = [
            self._node(p, a, speed, np.asarray(body.spin, float))
            for p, a, speed in zip(points, axes, v, strict=True)
        ]
        section = _section(body)
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        for pair, length in zip(pairwise(nodes), lengths.tolist(), strict=True):
            self.mbs.AddObject(
                eu.ObjectBeamGeometricallyExact(
                    nodeNumbers=list(pair), length=length, sectionData=section
                )
            )
        self._heavy(body, nodes, 0.5 * (np.append(lengths, 0.0) + np.append(0.0, lengths)))
        return Placed(-1, nodes, stations)

    def _heavy(self, body: Beam, nodes: list[int], lengths: Array) -> None:
        """Weight of a beam at its nodes, each with half of the elements beside it."""
        import exudyn.utilities as eu

        if not np.any(self.d.gravity):
            return
        line = body.material.density * body.section.area * np.asarray(self.d.gravity)
        for node, length in zip(nodes, lengths.tolist(), strict=True):
            marker = self.mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=node))
            self.mbs.AddLoad(eu.Force(markerNumber=marker, loadVector=(length * line).tolist()))

    def _node(self, point: Array, axes: Array, v: Array, spin: Array) -> int:
        import exudyn.utilities as eu

        turn = eu.RotationMatrix2EulerParameters(axes.T)
        rates = eu.AngularVelocity2EulerParameters_t(spin, turn)
        return self.mbs.AddNode(
            eu.NodeRigidBodyEP(referenceCoordinates=[*point, *turn], initialVelocities=[*v, *rates])
        )

    def _rigid(self, body: RigidBody) -> Placed:
        import exudyn.utilities as eu

        axes = np.asarray(body.axes, float)
        node = self._node(np.asarray(body.position), axes, np.asarray(body.velocity),
                          np.asarray(body.spin, float))  # fmt: skip
        own = axes @ body.inertia @ axes.T
        tensor = [own[0, 0], own[1, 1], own[2, 2], own[1, 2], own[0, 2], own[0, 1]]
        made = self.mbs.AddObject(
            eu.ObjectRigidBody(physicsMass=body.mass, physicsInertia=tensor, nodeNumber=node)
        )
        return Placed(made, [node], np.zeros(1))

    def _particle(self, body: Particle) -> Placed:
        import exudyn.utilities as eu

        node = self.mbs.AddNode(
            eu.NodePoint(
                referenceCoordinates=list(body.position), initialVelocities=list(body.velocity)
            )
        )
        made = self.mbs.AddObject(eu.ObjectMassPoint(physicsMass=body.mass, nodeNumber=node))
        return Placed(made, [node], np.zeros(1))

    def _weight(self, number: int) -> None:
        import exudyn.utilities as eu

        if np.any(self.d.gravity):
            marker = self.mbs.AddMarker(eu.MarkerBodyMass(bodyNumber=number))
            self.mbs.AddLoad(eu.Gravity(markerNumber=marker, loadVector=list(self.d.gravity)))

    # -- joints and loads ------------------------------------------------------------------

    def _marker(self, site: Site) -> int:
        """Of a point, with an orientation where it has one."""
        import exudyn.utilities as eu

        if site.body is None:
            return self.mbs.AddMarker(
                eu.MarkerBodyRigid(bodyNumber=self.ground, localPosition=list(site.position))
            )
        placed, body = self.bodies[site.body], self._described(site)
        if isinstance(body, RigidBody):
            return self.mbs.AddMarker(
                eu.MarkerBodyRigid(bodyNumber=placed.number, localPosition=list(site.offset))
            )
        if isinstance(body, Particle):
            return self.mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=placed.nodes[0]))
        return self.mbs.AddMarker(eu.MarkerNodeRigid(nodeNumber=placed.nodes[self._station(site)]))

    def _described(self, site: Site) -> motion.Body:
        return next(b for b in self.d.bodies if b.name == site.body)

    def _station(self, site: Site) -> int:
        stations = self.bodies[str(site.body)].stations
        where = site.node + site.fraction
        return int(np.argmin(np.abs(stations - (where + stations[-1] + 1 if where < 0 else where))))

    def _axes(self, site: Site) -> Array:
        """(3, 3)  rows e1, e2, e3 of the marker of a site."""
        body = None if site.body is None else self._described(site)
        if isinstance(body, RigidBody):
            return np.asarray(body.axes, float)
        if isinstance(body, Beam):
            placed = self.bodies[body.name]
            every = line_between(
                np.asarray(body.points, float), np.asarray(body.axes, float), placed.stations
            )[1]
            return every[self._station(site)]
        return np.eye(3)

    def _joint(self, joint: Any) -> None:
        import exudyn.utilities as eu

        markers = [self._marker(joint.b), self._marker(joint.a)]
        if isinstance(joint, motion.Spherical):
            self.mbs.AddObject(eu.SphericalJoint(markerNumbers=markers))
            return
        frame = _frame(getattr(joint, "axis", getattr(joint, "normal", np.array([0.0, 0.0, 1.0]))))
        self.mbs.AddObject(
            eu.GenericJoint(
                markerNumbers=markers, constrainedAxes=HELD[type(joint)],
                rotationMarker0=self._axes(joint.b) @ frame,
                rotationMarker1=self._axes(joint.a) @ frame,
            )
        )  # fmt: skip

    def _load(self, load: motion.Load) -> None:
        import exudyn.utilities as eu

        assert isinstance(load, motion.Force | motion.Moment)
        kind = eu.Force if isinstance(load, motion.Force) else eu.Torque
        direction = np.asarray(load.direction, float)
        moment = self.scene.time.end if self.scene.analysis.kind == "dynamics" else 1.0
        own: dict[str, Any] = {"loadVector": (load.amplitude(moment) * direction).tolist()}
        if self.moving:

            def at(mbs: Any, t: float, vector: Any) -> list[float]:
                return (load.amplitude(t) * direction).tolist()

            own["loadVectorUserFunction"] = at
        self.mbs.AddLoad(kind(markerNumber=self._marker(load.site), **own))

    # -- solving ---------------------------------------------------------------------------

    def places(self) -> dict[str, Array]:
        """Where the probes are now (3,) [m]."""
        import exudyn

        kind = exudyn.OutputVariableType.Position
        return {
            name: np.array(self.mbs.GetMarkerOutput(marker, kind))
            for name, marker in self.seen.items()
        }

    def opinion(self, seconds: float) -> Opinion:
        return Opinion(f"Exudyn {version()}", self.coordinates, seconds, self.mass)


def _frame(axis: Array) -> Array:
    """(3, 3)  columns: two directions across an axis, and the axis."""
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _section(body: Beam) -> Any:
    import exudyn

    s, T = body.section, body.reference_temperature
    E, G = float(body.material.youngs_modulus(T)), float(body.material.shear_modulus(T))
    C = np.diag([
        E * s.area, G * s.area * s.shear_factor_2, G * s.area * s.shear_factor_3,
        G * s.torsion_constant, E * s.second_moment_3, E * s.second_moment_2,
    ])  # fmt: skip
    found = exudyn.BeamSection()
    found.stiffnessMatrix, found.dampingMatrix = C, body.damping_time * C
    found.massPerLength = body.material.density * s.area
    moments = [s.polar_moment, s.second_moment_3, s.second_moment_2]
    found.inertia = body.material.density * np.diag(moments)
    return found


def _settings(d: Description) -> Any:
    import exudyn

    stiff = [
        float(b.material.youngs_modulus(b.reference_temperature)) * b.section.area
        for b in d.bodies
        if isinstance(b, Beam)
    ]

    found: Any = exudyn.SimulationSettings()
    found.linearSolverType = exudyn.LinearSolverType.EigenSparse
    found.parallel.numberOfThreads = 1
    found.solution.file.write = False
    for newton in (found.timeIntegration.newton, found.staticSolver.newton):
        newton.relativeTolerance, newton.absoluteTolerance = (
            TOLERANCE,
            ROUNDING * max(stiff, default=1.0),
        )
    return found


def _mass(written: _Written) -> Opinion:
    return written.opinion(0.0)


def _at_rest(written: _Written) -> Opinion:
    before, seconds = written.places(), _settled(written)
    moved = {name: place - before[name] for name, place in written.places().items()}
    return written.opinion(seconds)._replace(displacements=moved)


def _settled(written: _Written) -> float:
    """Equilibrium; the time [s] that it took."""
    chosen = _settings(written.d)
    chosen.staticSolver.numberOfLoadSteps, chosen.staticSolver.verboseMode = LOAD_STEPS, 0
    begun = perf_counter()
    if not written.mbs.SolveStatic(chosen, showHints=False, updateInitialValues=True):
        raise RuntimeError("it found no equilibrium")
    return perf_counter() - begun


def _frequencies(written: _Written) -> Opinion:
    begun = perf_counter()
    if written.d.loads or np.any(written.d.gravity):
        _settled(written)
    values, _ = written.mbs.ComputeODE2Eigenvalues(useAbsoluteValues=False)
    seconds = perf_counter() - begun
    found = np.sort(np.real(np.asarray(values)))
    frequencies = np.sign(found) * np.sqrt(np.abs(found)) / (2.0 * np.pi)
    count = written.scene.analysis.count
    return written.opinion(seconds)._replace(frequencies=frequencies[:count])


def _transient(written: _Written) -> Opinion:
    import exudyn

    scene, steps = written.scene, written.options.steps
    if scene.analysis.kind != "dynamics":
        raise ValueError(f"a transient is of dynamics, and analysis.kind is {scene.analysis.kind}")
    if scene.analysis.start == "equilibrium":
        raise ValueError("a motion from equilibrium is not written")
    before = written.places()
    times: list[float] = []
    courses: dict[str, list[Array]] = {name: [] for name in before}

    def keep(mbs: Any, t: float) -> bool:
        times.append(t)
        for name, marker in written.seen.items():
            at = mbs.GetMarkerOutput(marker, exudyn.OutputVariableType.Position)
            courses[name].append(np.array(at) - before[name])
        return True

    written.mbs.SetPostStepUserFunction(keep)
    chosen = _settings(written.d)
    time = chosen.timeIntegration
    time.endTime, time.numberOfSteps, time.verboseMode = scene.time.end, steps, 0
    time.generalizedAlpha.spectralRadius, time.adaptiveStep = RADIUS, False
    begun = perf_counter()
    if not written.mbs.SolveDynamic(chosen, showHints=False):
        raise RuntimeError("it could not finish the steps")
    seconds = perf_counter() - begun
    moved: Mapping[str, Array] = {name: np.array(rows) for name, rows in courses.items()}
    return written.opinion(seconds)._replace(times=np.array(times), courses=moved)


STAGES: dict[str, Callable[[_Written], Opinion]] = {
    "mass": _mass,
    "static": _at_rest,
    "frequencies": _frequencies,
    "transient": _transient,
}
"""What Exudyn is asked for, by name."""
