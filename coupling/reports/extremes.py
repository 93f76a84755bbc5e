"""Extremes of contact through the solver: what comes out where parameters leave the usual range.

Each row is a motion whose outcome is known in closed form.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from coupling.reports.registry import Result, Row
from coupling.reports.travel import Travel, travel
from coupling.verify.contact import AXIS as Z
from coupling.verify.contact import GRAVITY, STEEL, X, Y, joint
from coupling.verify.models import ROOM, Model, elastic, model, sections
from mechanics.contact import elastic_impact
from mechanics.description import (
    Beam,
    ClearanceTranslational,
    Description,
    Force,
    Friction,
    Joint,
    NormalContact,
    Particle,
    RigidBody,
    Site,
)
from mechanics.dynamics import Control
from mechanics.system import System
from meshes.generate import line
from meshes.sections import circle

SPEED, MASS, CLEARANCE = 0.1, 0.01, 1e-4
"""Of a ball that flies against the wall [m/s], [kg]; from the middle [m]."""
STIFF = {"hertz-external": (1e10, 1.5), "linear": (1e8, 1.0)}
"""Stiffness and exponent of the normal laws where nothing else is said."""
RIGHT, NO_GAIN = 2e-3, 1e-4
"""Error that counts as right, and energy that counts as none [-]."""
TOLERANCE, SMALLEST = 1e-6, 1e-18
"""Local error [-]; smallest step [s]."""
SOFT = 1e-2
"""Stiffness of what bars are thrown against, in their own: few of their vibrations remain."""
CLEARANCES = (2e-6, 1e-5, 1e-4, 1e-3, 5e-3)
STIFFNESSES = (1e4, 1e6, 1e8, 1e10, 1e12)
RESTITUTIONS = (0.01, 0.05, 0.1, 0.5, 0.9, 0.99, 1.0)
COEFFICIENTS = (0.0, 0.01, 0.1, 0.5, 1.0, 2.0)
REGULARISATIONS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
LOADS = (1.0, 1e3, 1e5)
MASSES = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6)
FRICTIONS = ("regularised", "stick", "stribeck", "lugre", "rising")


class Case(NamedTuple):
    """A motion and what it must come to.

    what : in words;  quantity : that is looked at
    unit : of the error; 0: the expected number
    tolerance : local error [-]
    """

    what: str
    quantity: str
    made: Model
    end: float
    largest: float
    delivered: Callable[[Travel], float]
    expected: float
    unit: float = 0.0
    tolerance: float = TOLERANCE


def report() -> Iterator[Result]:
    """All cases."""
    _row(next(cases()))  # what is compiled at first use is not to be timed
    found = [_row(case) for case in cases()]
    columns = (
        "what", "outcome", "quantity", "delivered", "expected", "error", "steps", "refused",
        "energy gained [-]", "made by the scheme [-]", "time [s]",
    )  # fmt: skip
    wrong = [str(row[0]) for row in found if not str(row[1]).startswith("right")]
    gained = [str(row[0]) for row in found if not float(row[8]) <= NO_GAIN]
    notes = [
        f"right: within {RIGHT:g}; of a restitution in parts of the approach speed",
        f"not right: {'; '.join(wrong) or 'none'}",
        f"energy gained beyond {NO_GAIN:g} of the most stored: {'; '.join(gained) or 'none'}",
    ]
    yield Result("extremes", "Extremes of contact", columns, found, notes)


def _row(case: Case) -> Row:
    path = travel(case.made, case.end, Control(case.tolerance, case.largest, SMALLEST))
    numbers = path.steps, path.refused, path.gained, path.made, path.seconds
    if path.why:
        nothing = float("nan")
        return (case.what, path.why, case.quantity, nothing, case.expected, nothing, *numbers)
    delivered = case.delivered(path)
    error = (delivered - case.expected) / (case.unit or abs(case.expected))
    outcome = "right" if abs(error) <= RIGHT else f"off by {100.0 * abs(error):.2g} %"
    return (case.what, outcome, case.quantity, delivered, case.expected, error, *numbers)


def cases() -> Iterator[Case]:
    """One after the other; the first ones are the simplest."""
    for c in CLEARANCES:
        yield flight(f"clearance {1e6 * c:g} um", clearance=c)
    for law in STIFF:
        for K in STIFFNESSES:
            yield flight(f"K = {K:g}, {law}", law=law, stiffness=K)
    for e in RESTITUTIONS:
        for law in STIFF:
            yield flight(f"e = {e:g}, {law}", law=law, restitution=e)
    for m in MASSES:
        yield flight(f"mass {m:g} kg", mass=m)
    for largest in (1e3, 1e-6):
        yield flight(f"largest step {largest:g} s")._replace(largest=largest)
    yield _thin_rod()
    yield _overlap()
    for e in (0.1, 0.5, 0.9, 0.95):
        yield _bouncing(e)
    for e in (0.9, 0.95):
        case = _bouncing(e)
        yield case._replace(what=f"{case.what}, local error 1e-8", tolerance=1e-8)
    yield from (_bar(100.0, elements) for elements in (1, 4, 20, 80))
    yield from (_bar(slenderness, 20, 1.0) for slenderness in (1e3, 1e4))
    yield from (_oblique(mu) for mu in COEFFICIENTS)
    yield from (_block(mu) for mu in COEFFICIENTS[1:])
    for eps in REGULARISATIONS:
        friction = Friction(0.1, regularisation_speed=eps)
        yield _spun(f"regularised from {eps:g} m/s", friction, eps)
    for load in LOADS:
        yield _spun(f"pressed with {load:g} N, stick", Friction(0.1, law="stick"), load=load)
    for name in FRICTIONS:
        eps = 1e-6 if name in ("regularised", "stribeck") else 0.0
        friction = Friction(
            0.1, law=name, regularisation_speed=eps or 1e-4, static_coefficient=0.15
        )
        yield _spun(f"friction {name}", friction, eps)


def _model(
    bodies: Sequence[RigidBody],
    joints: Sequence[Joint],
    loads: Sequence[Force] = (),
    gravity: ArrayLike = (0.0, 0.0, 0.0),
) -> Model:
    """A system of rigid bodies with its coefficients."""
    system = System(Description(bodies, joints, loads, np.asarray(gravity, float)))
    return Model(system, system.coefficients(sections(system)))


# ------------------------------------------------------------------------------- without friction


def flight(
    what: str,
    clearance: float = CLEARANCE,
    law: str = "hertz-external",
    stiffness: float | None = None,
    restitution: float = 0.85,
    mass: float = MASS,
) -> Case:
    """A ball from the middle of the bearing against the wall, and off."""
    usual, exponent = STIFF[law]
    K = stiffness or usual
    contact = NormalContact(law, K, restitution=restitution)
    flight = clearance / SPEED
    duration = float(elastic_impact(mass, K, SPEED, exponent).duration)
    return Case(
        what, "restitution",
        model(Particle("ball", np.zeros(3), mass, SPEED * X), [joint(contact, clearance)]),
        flight + (1.5 + 0.1 / restitution) * duration, flight,
        lambda path: -float(path.v[_off(path), 0]) / SPEED, restitution, 1.0,
    )  # fmt: skip


def _off(path: Travel) -> int:
    """Row in which the first impact is over."""
    running = path.approach[:, 0] != 0.0
    on = int(np.argmax(running))
    return on + int(np.argmin(running[on:])) + 1


def _thin_rod() -> Case:
    """Struck across at one end: three quarters of the mass stay out of it."""
    length, mass, e = 1.0, 0.1, 0.85
    across = mass * length**2 / 12.0
    inertia = np.diag([1e-10, across, across])
    rod = RigidBody("ball", np.array([0.5 * length, 0.0, 0.0]), mass, inertia, velocity=SPEED * Y)
    contact = NormalContact(value=1e10, restitution=e)
    site = Site("ball", offset=np.array([-0.5 * length, 0.0, 0.0]))
    made = _model([rod], [replace(joint(contact, CLEARANCE), journal=site)])
    duration = float(elastic_impact(0.25 * mass, 1e10, SPEED).duration)
    speed = SPEED - 0.25 * (1.0 + e) * SPEED
    return Case(
        "thin rod (inertia 1e-10 kg m^2 about its axis)", "speed of its middle [m/s]", made,
        CLEARANCE / SPEED + 2.0 * duration, CLEARANCE / SPEED,
        lambda path: float(path.v[_off(path), 1]), speed,
    )  # fmt: skip


def _overlap() -> Case:
    """A ball at rest that begins 1 um deep in the wall: speed of its elastic energy."""
    depth, K = 1e-6, 1e10
    contact = NormalContact(value=K, restitution=1.0)
    made = model(Particle("ball", (CLEARANCE + depth) * X, MASS), [joint(contact, CLEARANCE)])
    speed = np.sqrt(0.8 * K * depth**2.5 / MASS)
    duration = float(elastic_impact(MASS, K, speed).duration)
    return Case(
        "begins 1 um deep, e = 1", "speed [m/s]", made, duration, duration,
        lambda path: -float(path.v[-1, 0]), float(speed),
    )  # fmt: skip


def _bouncing(e: float) -> Case:
    """A ball that falls 0.1 mm and bounces for ever, until sqrt(2 h/g) (1 + e)/(1 - e)."""
    mass, K = 1e-3, 1e10
    contact = NormalContact("linear", K, restitution=e)
    made = model([Particle("ball", np.zeros(3), mass)], [joint(contact, CLEARANCE)],
                 gravity=GRAVITY * X)  # fmt: skip
    last = float(np.sqrt(2.0 * CLEARANCE / GRAVITY) * (1.0 + e) / (1.0 - e))
    return Case(
        f"bouncing ball, e = {e:g}, to its end", "time of the last impact [s]", made, 1.2 * last,
        1e-3, lambda path: float(path.onsets()[-1]), last,
    )  # fmt: skip


def _bar(slenderness: float, elements: int, e: float = 0.5) -> Case:
    """A bar thrown along its axis against something soft rebounds as a rigid body."""
    length, speed, E, density = 1.0, 0.01, 7e10, 2700.0
    radius = 0.5 * length / slenderness
    points, axes = line(np.zeros(3), -length * X, elements, Y)
    bar = Beam("ball", points, axes, circle(radius), elastic(E, 0.3, density), ROOM,
               velocity=speed * X)  # fmt: skip
    area = np.pi * radius**2
    contact = NormalContact("linear", SOFT * E * area / length, restitution=e)
    made = model([bar], [joint(contact, CLEARANCE)])
    along = np.zeros(made.system.n)
    along[np.asarray(made.system.layout.node_dofs["ball"])] = 1.0
    momentum = made.system.mass @ along
    duration = np.pi * length * np.sqrt(density / E / SOFT)
    return Case(
        f"bar, slenderness {slenderness:g}, {elements} elements, e = {e:g}",
        "restitution of its middle", made, CLEARANCE / speed + 1.5 * duration,
        0.02 * duration, lambda path: -float(momentum @ path.v[-1] / (momentum @ along)) / speed,
        e, 1.0,
    )  # fmt: skip


# ---------------------------------------------------------------------------------- with friction


def _oblique(mu: float) -> Case:
    """A ball that meets the wall at 45 degrees; what is left along it is 1 - mu (1 + e), or 0.

    The bearing is so wide that its wall is flat.
    """
    e, K, wide = 0.85, 1e10, 0.05
    speed = 1.0
    contact = NormalContact(value=K, restitution=e)
    friction = Friction(mu, regularisation_speed=1e-6) if mu else None
    place, along = wide * np.sqrt(0.5), (X - Y) * np.sqrt(0.5)
    start = Particle("ball", place * Y, MASS, speed * np.sqrt(2.0) * X)
    duration = float(elastic_impact(MASS, K, speed).duration)
    return Case(
        f"mu = {mu:g}, strikes at 45 degrees", "speed along the wall [-]",
        model(start, [joint(contact, wide, friction)]),
        place / (speed * np.sqrt(2.0)) + 2.0 * duration, 1e-2,
        lambda path: float(path.v[_off(path), :3] @ along) / speed,
        max(0.0, 1.0 - mu * (1.0 + e)), 1.0,
    )  # fmt: skip


def _block(mu: float) -> Case:
    """A slider that lies on a wall of its guide and stops after v^2/(2 mu g)."""
    mass, way, K, length = 1.0, 0.05, 1e10, 1.0
    speed = float(np.sqrt(2.0 * mu * GRAVITY * way))
    depth = (0.5 * mass * GRAVITY / K) ** (2.0 / 3.0)
    slider = RigidBody("ball", (CLEARANCE + depth) * X, mass, 0.1 * np.eye(3), velocity=speed * Z)
    guide = ClearanceTranslational(
        "guide", Site("ball"), Site(None), Z, X, length, 0.04, CLEARANCE, STEEL, STEEL, ROOM,
        NormalContact(value=K), Friction(mu, law="stick"),
    )  # fmt: skip
    return Case(
        f"mu = {mu:g}, block that stops", "way until it rests [m]",
        _model([slider], [guide], gravity=GRAVITY * X), 1.2 * speed / (mu * GRAVITY), 1e-3,
        lambda path: float(path.q[-1, 2]), way,
    )  # fmt: skip


class Law(NamedTuple):
    """Friction that slows a pin down: description, and the regularisation and the Stribeck part
    that its steady sliding shows.
    """

    friction: Friction
    eps: float = 0.0

    def coefficient(self, V: float) -> float:
        """While it slides at V [m/s]."""
        f = self.friction
        mu = f.coefficient
        if f.law in ("stribeck", "lugre"):
            more = (f.static_coefficient or mu) - mu
            mu += more * float(np.exp(-((V / f.stribeck_speed) ** 2)))
        return mu * V / (V + self.eps)


PIN, LOAD, SPIN, TURN = 25e-3, 1e3, 50.0, 0.5
"""Radius of a pin that spins [m], what presses it [N], how fast [rad/s]; it turns about so far
until it rests [rad]."""
NARROW, HARD = 1e-5, 1e7
"""Clearance around it [m], stiffness in loads [1/m^1.5]: it is so close that it hardly rolls."""


def _spun(what: str, friction: Friction, eps: float = 0.0, load: float = LOAD) -> Case:
    """A pin that spins, pressed against its bearing, until friction has stopped it.

    It begins where normal force and friction balance the load, and follows while it slows down:
    J w' = -W r sin(phi), tan(phi) = mu(r w).
    """
    law, K, mass = Law(friction, eps), HARD * load, 1.0
    slope = np.arctan(law.coefficient(PIN * SPIN))
    J = 2.0 * TURN * load * PIN * float(np.sin(slope)) / SPIN**2
    depth = (load * np.cos(slope) / K) ** (2.0 / 3.0)
    place = (NARROW + depth) * (np.cos(slope) * X - np.sin(slope) * Y)
    pin = RigidBody("ball", place, mass, J * np.eye(3), spin=SPIN * Z)
    made = _model(
        [pin], [joint(NormalContact(value=K), NARROW, friction, radius=PIN)],
        [Force("load", Site("ball"), X, lambda t: load)],
    )  # fmt: skip
    end = 1.5 * J * SPIN / (load * PIN * float(np.sin(slope)))
    return Case(
        what, "angle until it rests [rad]", made, end, 0.01 * end,
        lambda path: float(np.arctan2(path.q[-1, 4], path.q[-1, 3])),
        J / (load * PIN) * _slowing(law),
    )  # fmt: skip


def _slowing(law: Law) -> float:
    """Integral of w / sin(atan(mu(r w))) from rest to the spin [rad^2/s^2]."""

    def way(w: float) -> float:
        mu = law.coefficient(PIN * w)
        return w * float(np.sqrt(1.0 + mu**2)) / mu

    near = 0.01 * SPIN
    return float(quad(way, 1e-12, near, limit=500)[0] + quad(way, near, SPIN, limit=500)[0])
