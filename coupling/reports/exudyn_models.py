"""The models of the reports in the words of Exudyn (Gerstmayr 2023), where it is installed.

Everything is set to what is fastest there: one thread, sparse factorisation, no output, constant
mass matrices kept.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any, NamedTuple
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from meshes.generate import frames
from meshes.sections import Section
from meshes.truss import START, Hinge, Member, Truss, loaded_corners

Array = NDArray[np.float64]

TOLERANCE = 1e-6, 1e-6
"""Residual at which Newton ends, relative to the first [-], and absolute [N]."""
SAID = "residual {:g} of the first or {:g} N".format(*TOLERANCE)
MISSING = "exudyn is not installed: pip install 'thermobody[exudyn]'"


def version() -> str | None:
    """Version of the installed Exudyn; None: there is none."""
    try:
        import exudyn
    except ImportError:
        return None
    return str(exudyn.__version__)


class Stiffness(NamedTuple):
    """Young's and shear modulus [Pa], density [kg/m^3], Kelvin-Voigt time [s]."""

    youngs: float
    shear: float
    density: float
    damping: float = 0.0


class Model(NamedTuple):
    """A system of Exudyn, and the node whose place is compared.

    container : keeps the system alive
    settled : it starts without accelerations, and they need not be computed
    """

    container: Any
    mbs: Any
    node: int
    settled: bool = False

    @property
    def coordinates(self) -> int:
        """Number of second-order coordinates."""
        return int(self.mbs.systemData.ODE2Size())

    def place(self) -> Array:
        """(3,) [m]  of the node, after a run."""
        import exudyn

        return np.array(self.mbs.GetNodeOutput(self.node, exudyn.OutputVariableType.Position))


@contextmanager
def quiet() -> Iterator[None]:
    """Without warnings of names that newer versions of Exudyn call otherwise."""
    with catch_warnings():
        simplefilter("ignore", DeprecationWarning)
        yield


def empty() -> tuple[Any, Any]:
    """A container and a system in it."""
    import exudyn

    container = exudyn.SystemContainer()
    return container, container.AddSystem()


# ------------------------------------------------------------------------------------ solving


def settings(h: float, steps: int, modified: bool, dense: bool = False) -> Any:
    """Settings for ``steps`` of ``h`` [s] with generalised-alpha, spectral radius 0.8, index 3.

    The tolerance is wider than the default, 1e-8: rounding in large systems does not allow it.
    """
    import exudyn

    found: Any = exudyn.SimulationSettings()
    time = found.timeIntegration
    time.endTime, time.numberOfSteps, time.verboseMode = h * steps, steps, 0
    time.generalizedAlpha.spectralRadius = 0.8
    time.newton.useModifiedNewton, time.adaptiveStep = modified, False
    time.newton.relativeTolerance, time.newton.absoluteTolerance = TOLERANCE
    time.reuseConstantMassMatrix = True
    kind = exudyn.LinearSolverType
    found.linearSolverType = kind.EXUdense if dense else kind.EigenSparse
    found.parallel.numberOfThreads = 1
    written = found.solution.file if hasattr(found, "solution") else found.solutionSettings
    setattr(written, "write" if hasattr(found, "solution") else "writeSolutionToFile", False)
    return found


def size(make: Callable[[], Model]) -> int:
    """Number of second-order coordinates of a model."""
    with quiet():
        return make().coordinates


def solved(make: Callable[[], Model], h: float, steps: int, modified: bool, dense: bool = False):
    """The model after ``steps`` of ``h`` [s], and the time [s] that they took.

    Raises
    ------
    RuntimeError : Exudyn could not finish
    """
    with quiet():
        model, chosen = make(), settings(h, steps, modified, dense)
        chosen.timeIntegration.generalizedAlpha.computeInitialAccelerations = not model.settled
        begun = perf_counter()
        ok = model.mbs.SolveDynamic(chosen, showHints=False)
        seconds = perf_counter() - begun
    if not ok:
        raise RuntimeError("Exudyn could not finish the steps")
    return model, seconds


def per_step(make: Callable[[], Model], h: float, steps: int, modified: bool) -> float:
    """Time of a step [s]: a run less a run of a fifth of its steps, so that the start is left out.

    Raises
    ------
    RuntimeError : Exudyn could not finish
    """
    few = max(steps // 5, 1)
    short = min(solved(make, h, few, modified)[1] for _ in range(2))
    long = min(solved(make, h, steps, modified)[1] for _ in range(2))
    return (long - short) / (steps - few)


# --------------------------------------------------------------------------------------- ring


def ring(truss: Truss, section: Section, stiff: Stiffness, ancf: bool, load: float, rate: float):
    """The ring truss of ANCF beams (9 coordinates per node) or geometrically exact ones (7).

    Parameters
    ----------
    load, rate : amplitude [N] and frequency [Hz] of the 24 forces; Exudyn finds its matrix of
        initial accelerations singular and would warn, then take none, as here from the start
    """
    import exudyn.utilities as eu

    container, mbs = empty()
    beam = _beam_section(section, stiff)
    nodes = {m.name: _member(mbs, m, beam, ancf) for m in truss.members}
    axes = {m.name: frames(m.points, m.normal) for m in truss.members}
    ground = mbs.AddObject(eu.ObjectGround())
    first = truss.members[[m.name for m in truss.members].index(truss.corners[0][0])]
    frame = axes[first.name][0].T
    held = mbs.AddMarker(eu.MarkerBodyRigid(bodyNumber=ground, localPosition=first.points[0]))
    foot = mbs.AddMarker(eu.MarkerNodeRigid(nodeNumber=nodes[first.name][0]))
    mbs.AddObject(
        eu.GenericJoint(markerNumbers=[held, foot], constrainedAxes=[1] * 6, rotationMarker0=frame)
    )
    for hinge in truss.hinges:
        _hinge(mbs, hinge, nodes, axes)
    for i, corner in enumerate(loaded_corners(len(truss.corners), 24)):
        post, at = truss.corners[corner]
        _shake(mbs, nodes[post][0 if at == START else -1], load, rate, 2.0 * np.pi * i / 24)
    mbs.Assemble()
    far = nodes[f"batten_{len(truss.corners) // 4:0{len(first.name) - 7}d}"][-1]
    return Model(container, mbs, far, settled=True)


def _beam_section(section: Section, stiff: Stiffness) -> Any:
    import exudyn

    E, G, A = stiff.youngs, stiff.shear, section.area
    C = np.diag([
        E * A, G * A * section.shear_factor_2, G * A * section.shear_factor_3,
        G * section.torsion_constant, E * section.second_moment_3, E * section.second_moment_2,
    ])  # fmt: skip
    found = exudyn.BeamSection()
    found.stiffnessMatrix, found.dampingMatrix = C, stiff.damping * C
    found.massPerLength = stiff.density * A
    found.inertia = stiff.density * np.diag(
        [section.polar_moment, section.second_moment_3, section.second_moment_2]
    )
    return found


def _member(mbs: Any, member: Member, beam: Any, ancf: bool) -> list[int]:
    """Nodes and elements of a member; the numbers of its nodes."""
    import exudyn.utilities as eu

    nodes = []
    for point, axes in zip(member.points, frames(member.points, member.normal), strict=True):
        if ancf:
            node: Any = eu.NodePointSlope23(referenceCoordinates=[*point, *axes[1], *axes[2]])
        else:
            turn = eu.RotationMatrix2EulerParameters(axes.T)
            node = eu.NodeRigidBodyEP(referenceCoordinates=[*point, *turn])
        nodes.append(mbs.AddNode(node))
    kind = eu.ObjectANCFBeam if ancf else eu.ObjectBeamGeometricallyExact
    lengths = np.linalg.norm(np.diff(member.points, axis=0), axis=1)
    for i, length in enumerate(lengths):
        mbs.AddObject(kind(nodeNumbers=nodes[i : i + 2], length=length, sectionData=beam))
    return nodes


def _hinge(mbs: Any, hinge: Hinge, nodes: dict[str, list[int]], axes: dict[str, Array]) -> None:
    import exudyn.utilities as eu

    ends = [(hinge.base, hinge.base_at), (hinge.a, hinge.at)]
    at = [0 if place == START else -1 for _, place in ends]
    if hinge.axis is None:
        points = [
            mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=nodes[body][k]))
            for (body, _), k in zip(ends, at, strict=True)
        ]
        mbs.AddObject(eu.SphericalJoint(markerNumbers=points))
        return
    markers = [
        mbs.AddMarker(eu.MarkerNodeRigid(nodeNumber=nodes[body][k]))
        for (body, _), k in zip(ends, at, strict=True)
    ]
    z = hinge.axis
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    joint = np.column_stack([x, np.cross(z, x), z])
    turns = [axes[body][k] @ joint for (body, _), k in zip(ends, at, strict=True)]
    mbs.AddObject(
        eu.GenericJoint(
            markerNumbers=markers, constrainedAxes=[1, 1, 1, 1, 1, 0],
            rotationMarker0=turns[0], rotationMarker1=turns[1],
        )
    )  # fmt: skip


def _shake(mbs: Any, node: int, load: float, rate: float, phase: float) -> None:
    import exudyn.utilities as eu

    def force(mbs, t, vector):
        return [0.0, 0.0, load * np.sin(2.0 * np.pi * rate * t + phase)]

    marker = mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(
        eu.Force(markerNumber=marker, loadVector=[0.0, 0.0, load], loadVectorUserFunction=force)
    )


# -------------------------------------------------------------------------------- small models


def cable_pendulum(length: float, elements: int, section: Section, stiff: Stiffness, g: float):
    """A cable, horizontal at the start, on a pivot under gravity: ANCF in the plane."""
    import exudyn.utilities as eu

    container, mbs = empty()
    nodes = [
        mbs.AddNode(eu.NodePoint2DSlope1(referenceCoordinates=[x, 0.0, 1.0, 0.0]))
        for x in np.linspace(0.0, length, elements + 1)
    ]
    EA, EI = stiff.youngs * section.area, stiff.youngs * section.second_moment_3
    for i in range(elements):
        cable = mbs.AddObject(
            eu.Cable2D(
                nodeNumbers=nodes[i : i + 2], physicsLength=length / elements,
                physicsMassPerLength=stiff.density * section.area,
                physicsBendingStiffness=EI, physicsAxialStiffness=EA,
                physicsBendingDamping=stiff.damping * EI, physicsAxialDamping=stiff.damping * EA,
            )
        )  # fmt: skip
        marker = mbs.AddMarker(eu.MarkerBodyMass(bodyNumber=cable))
        mbs.AddLoad(eu.Gravity(markerNumber=marker, loadVector=[0.0, -g, 0.0]))
    ground = mbs.AddObject(eu.ObjectGround())
    held = mbs.AddMarker(eu.MarkerBodyPosition(bodyNumber=ground))
    pivot = mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=nodes[0]))
    mbs.AddObject(eu.RevoluteJoint2D(markerNumbers=[held, pivot]))
    mbs.Assemble()
    return Model(container, mbs, nodes[-1])


def slider_crank(crank: Any, rod: Any, slider: float, speed: float):
    """Crank and rod along x at the start, the crank turning; bodies in the plane.

    Parameters
    ----------
    crank, rod : (length [m], mass [kg], inertia [kg m^2])
    slider : [kg];  speed : [rad/s]  of the crank
    """
    import exudyn.utilities as eu

    container, mbs = empty()
    (l1, m1, j1), (l2, m2, j2) = crank, rod
    spin = -speed * l1 / l2
    first = mbs.AddNode(
        eu.NodeRigidBody2D(
            referenceCoordinates=[0.5 * l1, 0.0, 0.0],
            initialVelocities=[0.0, 0.5 * l1 * speed, speed],
        )
    )
    second = mbs.AddNode(
        eu.NodeRigidBody2D(
            referenceCoordinates=[l1 + 0.5 * l2, 0.0, 0.0],
            initialVelocities=[0.0, 0.5 * l1 * speed, spin],
        )
    )
    last = mbs.AddNode(eu.NodePoint2D(referenceCoordinates=[l1 + l2, 0.0]))
    ground = mbs.AddObject(eu.ObjectGround())
    a = mbs.AddObject(eu.RigidBody2D(physicsMass=m1, physicsInertia=j1, nodeNumber=first))
    b = mbs.AddObject(eu.RigidBody2D(physicsMass=m2, physicsInertia=j2, nodeNumber=second))
    mbs.AddObject(eu.MassPoint2D(physicsMass=slider, nodeNumber=last))

    def at(body: int, x: float) -> int:
        return mbs.AddMarker(eu.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0.0, 0.0]))

    pin = mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=last))
    for pair in (
        [at(ground, 0.0), at(a, -0.5 * l1)],
        [at(a, 0.5 * l1), at(b, -0.5 * l2)],
        [at(b, 0.5 * l2), pin],
    ):
        mbs.AddObject(eu.RevoluteJoint2D(markerNumbers=pair))
    fixed = mbs.AddMarker(
        eu.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(eu.NodePointGround()), coordinate=0)
    )
    guided = mbs.AddMarker(eu.MarkerNodeCoordinate(nodeNumber=last, coordinate=1))
    mbs.AddObject(eu.CoordinateConstraint(markerNumbers=[fixed, guided]))
    mbs.Assemble()
    return Model(container, mbs, last)
