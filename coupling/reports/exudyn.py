"""This program and Exudyn on the same models, in the same run, on one thread each."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reports import exudyn_models as other
from coupling.reports.measure import ROOM, fixed, march
from coupling.reports.registry import Curve, Picture, Result
from coupling.reports.rings import DAMPING, STEP, ring, section, truss
from mechanics.description import (
    Beam,
    Body,
    Description,
    Guide,
    Joint,
    Particle,
    Revolute,
    RigidBody,
    Site,
    Spherical,
)
from mechanics.schemes import Scheme
from mechanics.system import System
from meshes.generate import frames
from meshes.materials import constant_material, library_material
from meshes.sections import rectangle
from meshes.truss import LEVELS

Array = NDArray[np.float64]

LOAD, RATE = 10.0, 0.5
"""Amplitude [N] and frequency [Hz] of the forces on the ring, as in ``coupling.rings``."""
OTHERS = {
    "geometrically exact": (False, LEVELS[3]),
    "ANCFBeam": (True, LEVELS[3]),
    "geometrically exact, finer": (False, 15),
}
"""Elements of Exudyn: whether ANCF, and how many in the span of a member; one more at its hinge.

With 7 coordinates per node 15 give as many as ``beam3243`` has with 8 and 12 per node.
"""
NOTES = [
    "the first two of Exudyn have the same nodes, with 7 or 9 coordinates where beam3243 has 12; "
    "the last one as many coordinates",
    "its elements are linear along the axis, those of this program cubic: their errors differ",
    "at equal error: the cable pendulum and the slider-crank",
]
STEPS = {"modified": 25, "full": 8}
"""Steps of the ring that are timed with each kind of Newton's method."""
SCHEME = Scheme("generalised-alpha", spectral_radius=0.8)
GRAVITY = 9.81


def report() -> Iterator[Result]:
    """Time of a step of the ring; error against time of a cable pendulum and a slider-crank."""
    version = other.version()
    if version is None:
        yield Result("exudyn", "Exudyn", ("remark",), [(other.MISSING,)], [])
        return
    yield _ring(version)
    yield _small("exudyn_cable", f"Cable pendulum, 16 elements; Exudyn {version}", _cable())
    yield _small("exudyn_slider_crank", f"Slider-crank; Exudyn {version}", _slider_crank())


# --------------------------------------------------------------------------------------- ring


def _ring(version: str) -> Result:
    system = ring()
    own = march(system, fixed(STEP), 100 * STEP, 2).seconds
    material = library_material("al6061-paper")
    E, nu = float(material.youngs_modulus(ROOM)), float(material.poissons_ratio(ROOM))
    stiff = other.Stiffness(E, 0.5 * E / (1.0 + nu), material.density, DAMPING)
    own_said, failed = _tolerance(Scheme()), list[str]()
    rows: list[tuple[str | float | int, ...]] = [
        ("this program", "beam3243", LEVELS[3] + 1, system.n, "frozen", own_said, 1e3 * own, 1.0)
    ]
    for name, (ancf, elements) in OTHERS.items():

        def make(ancf=ancf, elements=elements) -> other.Model:
            return other.ring(truss(elements), section(), stiff, ancf, LOAD, RATE)

        model = ("Exudyn", name, elements + 1, other.size(make))
        for newton, steps in STEPS.items():
            try:
                time = other.per_step(make, STEP, steps, newton == "modified")
            except RuntimeError:
                time = float("nan")
                failed.append(f"{name} with {newton} Newton does not get through {steps} steps")
            rows.append((*model, newton, other.SAID, 1e3 * time, time / own))
    columns = ("program", "element", "per member", "coordinates", "Newton", "Newton ends at",
               "time per step [ms]", "ratio [-]")  # fmt: skip
    title = f"Ring truss, steps of {STEP:g} s, one thread each; Exudyn {version}"
    return Result("exudyn_ring", title, columns, rows, [*NOTES, *failed])


def _tolerance(scheme: Scheme) -> str:
    """When Newton's method of this program ends."""
    return f"correction {scheme.newton_tolerance:g} of size"


# -------------------------------------------------------------------------------- small models


class Race(NamedTuple):
    """Two ways to the same motion.

    own, other : from a step [s] and a number of them to the place (3,) [m] and the time [s]
    size : float [m]  that errors are relative to
    end : float [s];  steps : numbers of steps that are tried, the last one is the reference
    goal : float  error at which times are compared [-]
    """

    own: Callable[[float, int], tuple[Array, float]]
    other: Callable[[float, int], tuple[Array, float]]
    size: float
    end: float
    steps: tuple[int, ...]
    goal: float


def _small(name: str, title: str, race: Race) -> Result:
    rows: list[tuple[str | float | int, ...]] = []
    curves, limits, reached = [], [], {}
    for program, run in (("this program", race.own), ("Exudyn", race.other)):
        found = [run(race.end / steps, steps) for steps in race.steps]
        limit = found[-1][0]
        limits.append(limit)
        errors = [float(np.linalg.norm(place - limit)) / race.size for place, _ in found[:-1]]
        times = [seconds for _, seconds in found[:-1]]
        for steps, error, seconds in zip(race.steps, errors, times, strict=False):
            rows.append((program, steps, error, 1e3 * seconds, 1e6 * seconds / steps))
        curves.append(Curve(program, [1e3 * t for t in times], errors))
        reached[program] = float(
            np.exp(np.interp(-np.log(race.goal), -np.log(errors), np.log(times)))
        )
    apart = float(np.linalg.norm(limits[0] - limits[1])) / race.size
    ratio = reached["Exudyn"] / reached["this program"]
    notes = [
        f"at an error of {race.goal:g} this program is {ratio:.2f} times as fast",
        f"errors are against {race.steps[-1]} steps of the same program; these two are {apart:.1e} "
        "apart",
        f"Newton ends at: this program {_tolerance(SCHEME)}; Exudyn {other.SAID}",
    ]
    columns = ("program", "steps", "error [-]", "time of the run [ms]", "time per step [µs]")
    picture = Picture("time of the run [ms]", "error [-]", curves)
    return Result(name, title, columns, rows, notes, [picture])


def _own(system: System, body: str, node: int) -> Callable[[float, int], tuple[Array, float]]:
    at = system.layout.node_dofs[body][node] + np.arange(3)

    def run(h: float, steps: int) -> tuple[Array, float]:
        done = march(system, fixed(h, SCHEME), h * steps, 3)
        return done.state.motion.q[at], done.seconds * done.steps

    return run


def _others(make: Callable[[], other.Model]) -> Callable[[float, int], tuple[Array, float]]:
    """The faster of modified and full Newton, of sparse and dense factors."""

    def run(h: float, steps: int) -> tuple[Array, float]:
        best: tuple[Any, float] = (None, np.inf)
        for modified in (True, False):
            for dense in (True, False):
                model, seconds = other.solved(make, h, steps, modified, dense)
                best = min(best, (model, seconds), key=lambda pair: pair[1])
        return best[0].place(), best[1]

    return run


def _cable() -> Race:
    """A soft cable of 1 m that falls from the horizontal."""
    elements, length, side = 16, 1.0, 0.02
    material = constant_material("rubber", 1100.0, 5e6, 0.0, 0.0, 1.0, 1.0)
    profile, damping = rectangle(side, side, 0.0), 0.0
    points = np.column_stack([np.linspace(0.0, length, elements + 1), np.zeros((elements + 1, 2))])
    cable = Beam("cable", points, frames(points), profile, material, ROOM, damping, "cable")
    pivot = Spherical("pivot", Site("cable", 0), Site(None))
    system = System(Description([cable], [pivot], [], np.array([0.0, -GRAVITY, 0.0])))
    stiff = other.Stiffness(5e6, 2.5e6, 1100.0, damping)
    return Race(
        _own(system, "cable", -1),
        _others(lambda: other.cable_pendulum(length, elements, profile, stiff, GRAVITY)),
        length, 0.5, (250, 500, 1000, 2000, 16000), 1e-4,
    )  # fmt: skip


def _slider_crank() -> Race:
    """The mechanism of Flores et al. (2006) without clearance, set off at 5000 rpm, free."""
    crank, rod, mass, speed = (0.05, 0.3, 1e-4), (0.12, 0.21, 2.5e-4), 0.14, 5000 * np.pi / 30
    z = np.array([0.0, 0.0, 1.0])
    bodies: list[Body] = [
        _bar("crank", 0.0, crank, speed * z, 0.5 * crank[0] * speed),
        _bar("rod", crank[0], rod, -speed * crank[0] / rod[0] * z, 0.5 * crank[0] * speed),
        Particle("slider", np.array([crank[0] + rod[0], 0.0, 0.0]), mass),
    ]
    joints: list[Joint] = [
        Revolute("main", _end("crank", crank, -1), Site(None), z),
        Revolute("pin", _end("crank", crank, 1), _end("rod", rod, -1), z),
        Spherical("wrist", _end("rod", rod, 1), Site("slider")),
        Guide("guide", Site("slider"), np.array([[0.0, 1.0, 0.0]])),
    ]
    system = System(Description(bodies, joints))
    return Race(
        _own(system, "slider", 0),
        _others(lambda: other.slider_crank(crank, rod, mass, speed)),
        crank[0], 0.024, (300, 600, 1200, 2400, 19200), 1e-3,
    )  # fmt: skip


def _bar(name: str, start: float, bar: tuple[float, float, float], spin: Array, speed: float):
    length, mass, inertia = bar
    position = np.array([start + 0.5 * length, 0.0, 0.0])
    J = np.diag([0.1 * inertia, inertia, inertia])  # the first two move nothing in the plane
    return RigidBody(name, position, mass, J, velocity=np.array([0.0, speed, 0.0]), spin=spin)


def _end(name: str, bar: tuple[float, float, float], side: int) -> Site:
    return Site(name, offset=np.array([0.5 * side * bar[0], 0.0, 0.0]))
