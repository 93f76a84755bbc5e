"""Joints with clearance under load: depths, tilted pins, flanges, seizure, heat, spinning balls."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from coupling.verify import contact_references as references
from coupling.verify.contact import AXIS, CLEARANCE, STEEL, X, Y, ball, joint
from coupling.verify.mechanisms import mechanism
from coupling.verify.models import ROOM, Model, elastic, model, sections
from coupling.verify.motion import run
from coupling.verify.registry import Check, problem
from mechanics.contact_laws import CLEARANCE as GAP
from mechanics.description import (
    Beam,
    Clamp,
    ClearanceCylindrical,
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    Description,
    Fixing,
    Force,
    Friction,
    Guide,
    History,
    Joint,
    Load,
    NormalContact,
    Particle,
    RigidBody,
    Site,
    Spring,
    Telescope,
)
from mechanics.dynamics import Control
from mechanics.march import DEPTH, ELASTIC, FRICTION, PATH
from mechanics.solver import Mechanics
from mechanics.statics import equilibrium
from meshes.generate import line
from meshes.materials import constant_material
from meshes.sections import tube

Array = NDArray[np.float64]

ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
STAINLESS = constant_material("steel", 8000.0, 193e9, 0.29, 17e-6, 16.2, 500.0)


def constant(value: float) -> History:
    """A history that does not change."""
    return lambda t: value


def _at_rest(made: Model, steps: int = 10) -> tuple[Array, Array]:
    """Coordinates of the static equilibrium, and the responses of the contacts there."""
    found = equilibrium(made.system, made.coef, made.coef, steps)
    if found.why:
        raise RuntimeError(found.why)
    y = made.system.unknowns(found.q)
    return found.q, made.system.respond(y, np.zeros_like(y), made.coef)


@problem("contact", "ball on a plane", "Johnson 1985, sec. 4.2: R = 10 mm, aluminium, 100 N")
def hertz_at_rest() -> list[Check]:
    """Two rounded corners of a slider on a wall, each with 100 N."""
    metal, radius, force = elastic(69e9, 0.33), 0.01, 100.0
    guide = ClearanceTranslational(
        "guide", Site("ball"), Site(None), X, Y, 0.1, 0.02, CLEARANCE, metal, metal, ROOM,
        NormalContact("hertz-external"), corner_radius=radius,
    )  # fmt: skip
    springs = Guide("held", Site("ball"), np.array([X]))
    start = Particle("ball", -(CLEARANCE + 5e-6) * Y, 1.0)
    push = Force("push", Site("ball"), -Y, lambda t: 2.0 * force)
    _, response = _at_rest(mechanism([start], [guide, springs], [push]))
    depth, modulus = response[:, DEPTH].max(), 69e9 / (2.0 * (1.0 - 0.33**2))
    a = np.sqrt(radius * depth)
    return [
        Check("depth", depth, 7.212941e-6, 1e-6, "m"),
        Check("radius of contact", a, 2.685692e-4, 1e-6, "m"),
        Check("largest pressure", 2.0 * modulus * a / (np.pi * radius), 6.619558e8, 1e-6, "N/m²"),
    ]


@problem("contact", "pin in a conforming bore", "Johnson 1985, sec. 5.6: δ = F/πE*L (ln(..) - 1)")
def conforming() -> list[Check]:
    """Each end of the bore carries half of the load, 27 N and more."""
    length, radius, checks = 0.02, 0.01, []
    modulus = 69e9 / (2.0 * (1.0 - 0.33**2))
    metal = elastic(69e9, 0.33)
    for force in (27.0, 1e3, 1e4):
        bush = ClearanceCylindrical(
            "bush", Site("rod"), Site(None), AXIS, radius, CLEARANCE, length, metal, metal, ROOM,
            NormalContact("cylinder"),
        )  # fmt: skip
        push = Force("push", Site("rod"), X, constant(force))
        found = _pin([bush], [push], CLEARANCE + 1e-8)
        line = np.pi * modulus * length
        depth = force / line * (np.log(4.0 * line * CLEARANCE / force) - 1.0)
        checks.append(Check(f"depth at {force:g} N", found[1][0, DEPTH], depth, 1e-6, "m"))
    return checks


WEAK = 1.0
"""Stiffness [N/m] of springs that hold what a joint leaves free."""


def _pin(joints: Sequence[Joint], loads: Sequence[Load], place: float) -> tuple[Array, Array]:
    """A rigid rod along z at rest in a bush under loads; weakly held where it is free."""
    rod = RigidBody("rod", place * X, 1.0, np.eye(3))
    held = [(np.zeros(3), X), (np.zeros(3), Y)]
    held += [(0.1 * AXIS, X), (0.1 * AXIS, Y), (0.1 * X, Y)]
    weak = [
        Spring(f"weak {i}", Site("rod", offset=o), Site(None, position=place * X + o + d), WEAK)
        for i, (o, d) in enumerate(held)
    ]
    return _at_rest(mechanism([rod], [*joints, *weak], loads), 40)


def _revolute(length: float, axial: float | None, law: NormalContact) -> ClearanceRevolute:
    return ClearanceRevolute(
        "pin", Site("rod"), Site(None), AXIS, 0.01, CLEARANCE, STEEL, STEEL, ROOM, law,
        length=length, axial_clearance=axial,
    )  # fmt: skip


def _tilted(hinge: Joint, length: float, arm: float, force: float, law: NormalContact) -> Array:
    """Forces at both ends of a bore [N] and the tilt of the pin, loaded off the middle."""
    push = Force(
        "push", Site("rod", offset=arm * AXIS), X, lambda s: force * s**4
    )  # fmt: skip
    along = Guide("along", Site("rod"), np.array([AXIS]))
    _, response = _pin([hinge, along], [push], 0.0)
    near, far = response[1], response[0]
    tilt = np.linalg.norm(near[PATH : PATH + 2] - far[PATH : PATH + 2]) / length
    return np.array([near[ELASTIC], far[ELASTIC], tilt])


@problem("contact", "pin and rod tilted by a load", "statics; 2 c/L and what the edges yield")
def tilted() -> list[Check]:
    """A load that is half a length beyond the bore leans the pin on opposite edges.

    Forces differ from those of small angles by some times the tilt squared, 4e-5.
    """
    length, force, checks = 0.04, 1e3, []
    law = NormalContact(value=STIFF)
    for arm in (0.0, 0.25 * length, length):
        rod = ClearanceCylindrical(
            "pin", Site("rod"), Site(None), AXIS, 0.01, CLEARANCE, length, STEEL, STEEL, ROOM, law
        )  # fmt: skip
        known = references.tilted_pin(force, arm, length, CLEARANCE, 0.5 * STIFF)
        for name, hinge in (("revolute", _revolute(length, None, law)), ("cylindrical", rod)):
            near, far, tilt = _tilted(hinge, length, arm, force, law)
            checks += [
                Check(
                    f"{name}, arm {arm / length:g} L, near end", near, -known.forces[0], 2e-4, "N"
                ),
                Check("  far end", far, abs(known.forces[1]), 2e-4, "N"),
                Check("  tilt", tilt, np.tan(known.angle), 1e-4, "", not arm),
            ]
    return checks


STIFF = 1e10  # [N/m^1.5]


@problem("contact", "axial stop of a pin", "three points of a flange, K/3 each")
def axial_stop() -> list[Check]:
    force, axial = 1e3, 2e-4
    hinge = _revolute(0.04, axial, NormalContact(value=STIFF))
    push = Force("push", Site("rod"), AXIS, lambda s: force * s**4)
    along = Spring("along", Site("rod"), Site(None, position=AXIS), WEAK)
    q, response = _pin([hinge, along], [push], 0.0)
    flanges = response[2:, ELASTIC]
    touching = flanges[flanges > 0.0]
    return [
        Check("points that touch", len(touching), 3, 0.0),
        Check("force of each", touching.max(), force / 3.0, 1e-4, "N"),
        Check("travel", q[2], axial + (force / STIFF) ** (2.0 / 3.0), 1e-4, "m"),
    ]


def _tube(name: str, start: float, end: float) -> Beam:
    """A tube along x between two places [m], of two elements, as good as rigid."""
    points, axes = line(start * X, end * X, 2, Y)
    metal = elastic(2e16, 0.3, 1.0)
    return Beam(name, points, axes, tube(0.05, 0.002, 0.3), metal, ROOM)


@problem(
    "contact", "tube in a tube, loaded at its tip", "statics: F L/a, F (L - a)/a, c + 2 c (L - a)/a"
)
def telescope() -> list[Check]:
    length, overlap, force, c = 1.0, 0.3, 100.0, 1e-3
    law = NormalContact("linear", 1e7)
    slide = Telescope("slide", "arm", "boom", 0.045, c, ROOM, contact=law)
    tip, end = Site("arm", -1), Site("arm", 0)
    joints: list[Joint] = [
        Clamp("clamp", Site("boom", 0), Site(None)),
        slide,
        Guide("along", end, np.array([X])),
        Fixing("spin", "arm", 0, "r_y", np.array([AXIS])),
    ]
    for k, (site, x) in enumerate(((end, 0.2), (tip, 1.2))):
        for i, d in enumerate((Y, AXIS)):
            at = Site(None, position=x * X + d)
            joints.append(Spring(f"weak {k}{i}", site, at, WEAK))
    load = Force("load", tip, -Y, lambda s: force * s**4)
    made = model(
        [_tube("arm", 0.2, 0.2 + length), _tube("boom", 0.0, 0.2 + overlap)], joints, [load]
    )
    q, response = _at_rest(made, 40)
    names = made.system.contact_names
    mouth, inner = (response[names.index(f"slide.{at}")] for at in ("mouth", "node_00"))
    droop, beyond = -made.position(q, "arm", -1)[1], length - overlap
    forces = force * length / overlap, force * beyond / overlap
    down, up = (c + one / 1e7 for one in forces)
    return [
        Check("force at the mouth", mouth[ELASTIC], forces[0], 1e-3, "N"),
        Check("force at the inner end", inner[ELASTIC], forces[1], 1e-3, "N"),
        Check("droop of the tip", droop, down + (down + up) / overlap * beyond, 1e-3, "m"),
    ]


@problem("contact", "seizure of a heated pin", "ΔT = c/(α R), 50 µm, 25 mm; F = K (α R ΔT - c)^1.5")
def seizure() -> list[Check]:
    """The journal is warmer than the bearing; beyond, the pin is pressed all around."""
    hinge = joint(NormalContact(value=STIFF), 50e-6)
    system = model(ball(1.0, np.zeros(3)), [hinge]).system
    seized = 50e-6 / (23.1e-6 * 25e-3)

    def coefficients(warmer: float) -> tuple[Array, ...]:
        T = sections(system)
        T[system.layout.point_index["hinge.journal"], 0] += warmer
        return system.coefficients(T)

    gaps = [float(coefficients(dT)[-1][0, GAP]) for dT in (0.0, seized)]
    y = system.unknowns(system.layout.q0)
    pressed = system.respond(y, np.zeros_like(y), coefficients(seized + 20.0))[0]
    depth = 23.1e-6 * 25e-3 * 20.0
    return [
        Check("warmer at seizure", gaps[0] * seized / (gaps[0] - gaps[1]), 86.5801, 1e-5, "K"),
        Check("clearance then", gaps[1], 0.0, 1e-12, "m", True),
        Check("depth 20 K beyond", pressed[DEPTH], depth, 1e-4, "m"),
        Check("press force", pressed[ELASTIC], STIFF * depth**1.5, 1e-4, "N"),
        Check("friction where it does not slip", np.abs(pressed[FRICTION : FRICTION + 3]).max(),
              0.0, 0.0, "N", True),
    ]  # fmt: skip


@problem(
    "contact", "spinning ball hits its socket", "impulses; Stronge 2000, ch. 5: slides throughout"
)
def spinning_ball() -> list[Check]:
    """The socket is the wall, 10 mm away, so that it is as good as plane during the impact."""
    mass, radius, mu, e, speed, spin = 0.1, 0.02, 0.1, 0.8, 1.0, np.array([0.0, 40.0, 300.0])
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    body = RigidBody("ball", np.zeros(3), mass, inertia, velocity=speed * X, spin=spin)
    socket = ClearanceSpherical(
        "socket", Site("ball"), Site(None), radius, 0.01, STEEL, STEEL, ROOM,
        NormalContact(value=1e12, restitution=e), Friction(mu, regularisation_speed=1e-6),
    )  # fmt: skip
    made = mechanism([body], [socket])
    path = run(made, 0.0101 / speed, Control(1e-9, 1e-3, 1e-16))
    known = references.ball_on_wall(mass, radius, speed * X, spin, X, e, mu)
    first = made.system.layout.node_dofs["ball"][0]
    v = path.v[-1, first : first + 3]
    w = spin_of(path.q[-1, first + 3 : first + 12], path.v[-1, first + 3 : first + 12])
    names = [f"{kind} {axis}" for kind in ("velocity", "spin") for axis in "xyz"]
    found = np.concatenate([v, w])
    wanted = np.concatenate([known.velocity, known.spin])
    scale = np.array([*[speed] * 3, *[300.0] * 3])
    return [
        Check(name, one, other, 2e-3 * size, "m/s" if size == speed else "rad/s", True)
        for name, one, other, size in zip(names, found, wanted, scale, strict=True)
    ]


def spin_of(directors: Array, rates: Array) -> Array:
    """Angular velocity (3,) in space of a rigid body with directors and their rates (9,)."""
    return 0.5 * np.cross(directors.reshape(3, 3), rates.reshape(3, 3)).sum(axis=0)


@problem("contact", "heat of friction", "heat = work; shares √(kρc) (Carslaw & Jaeger 1959, 2.15)")
def frictional_heat() -> list[Check]:
    """An aluminium block slides to rest on steel: (m v²/2) is all that there is."""
    mass, speed = 2.0, 3.0
    press = NormalContact("linear", 1e8, restitution=1.0)
    guide = ClearanceTranslational(
        "guide", Site("block"), Site(None, position=(CLEARANCE + mass * 9.81 / 2e8) * Y), X, Y, 0.1,
        0.02, CLEARANCE, ALUMINIUM, STAINLESS, ROOM, press, Friction(0.25, law="stick",
        presliding=1e-6, bristle_damping=400.0),
    )  # fmt: skip
    block = Particle("block", np.zeros(3), mass, speed * X)
    solver = Mechanics(Description([block], [guide], (), -9.81 * Y), Control(1e-4, 1e-3, 1e-10))
    T = np.tile([ROOM, 0.0, 0.0], (len(solver.x), 1))
    state, heat, why = solver.advance(solver.initial(T), 1.4, T, T)
    if why:
        raise RuntimeError(why)
    journal = heat[solver.regions["guide.journal"]].sum()
    return [
        Check("heat", heat.sum(), 0.5 * mass * speed**2, 1e-4, "J"),
        Check("heat / work of friction", heat.sum(), state.ledger[6], 1e-12, "J"),
        Check("share of aluminium", journal / heat.sum(), 0.714035, 1e-6),
    ]
