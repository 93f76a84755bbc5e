"""Extremes of mechanics: statics, motion and solids where parameters leave the usual range.

Each row has an answer in closed form, or none: then a reason is due.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import j1, jn_zeros

from coupling.reports.registry import Result, Row
from coupling.verify.models import ROOM, clamp, elastic, sections, straight
from mechanics.description import (
    Beam,
    Body,
    Clamp,
    Continuum,
    Description,
    Fixing,
    Force,
    Gear,
    Guide,
    Joint,
    Latch,
    Load,
    Moment,
    Particle,
    Revolute,
    RigidBody,
    Site,
    Sliding,
    Spherical,
    Spring,
)
from mechanics.dynamics import Control
from mechanics.modes import modes
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from mechanics.statics import equilibrium
from mechanics.system import System
from meshes.sections import general, rectangle
from meshes.solids import box

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)
BAR = rectangle(0.01, 0.02)
THIN = rectangle(1e-5, 1e-5)
METAL = elastic(70e9, 0.3, 2700.0, 23e-6)
GRAVITY = 9.81
RIGHT = 2e-3
"""Error that counts as right where nothing else is said [-]."""


class Case(NamedTuple):
    """Something extreme and what it must come to.

    found : the quantity; ValueError or NoMotionError with a reason
    expected : closed form
    said : words of the reason that is due; "": an answer is
    """

    what: str
    quantity: str
    found: Callable[[], float]
    expected: float = 0.0
    said: str = ""
    tolerance: float = RIGHT
    unit: float = 0.0


class NoMotionError(Exception):
    """What cannot be done; its reason."""


COLUMNS = ("what", "outcome", "due", "quantity", "delivered", "expected", "error", "reason",
           "time [s]")  # fmt: skip


def report() -> Iterator[Result]:
    """All cases."""
    rows = [row(case) for case in cases()]
    bad = [f"{r[0]}: {r[1]}" for r in rows if r[1] != r[2]]
    note = f"{len(rows)} rows; neither right nor with the reason that is due: "
    yield Result("mechanics_extremes", "Extremes of mechanics", COLUMNS, rows,
                 [note + ("; ".join(bad) or "none")])  # fmt: skip


def row(case: Case) -> Row:
    """A case, whatever happens."""
    begun = perf_counter()
    due = "reason" if case.said else "right"
    outcome, delivered, error, reason = outcome_of(case)
    return (case.what, outcome, due, case.quantity, delivered, case.expected, error, reason,
            perf_counter() - begun)  # fmt: skip


def outcome_of(case: Case) -> tuple[str, float, float, str]:
    """Outcome, number, its error, reason."""
    nothing = float("nan")
    try:
        with np.errstate(all="ignore"):
            delivered = case.found()
    except (ValueError, NoMotionError) as error:
        reason = " ".join(str(error).split())
        if not case.said:
            return "no result", nothing, nothing, reason
        return ("reason" if case.said in reason else "other reason"), nothing, nothing, reason
    except Exception as error:  # a crash is an outcome of its own
        return f"crash: {type(error).__name__}", nothing, nothing, str(error)
    if case.said:
        return "silent", delivered, nothing, ""
    off = (delivered - case.expected) / (case.unit or abs(case.expected))
    right = isfinite(off) and abs(off) <= case.tolerance
    return ("right" if right else f"off by {100.0 * abs(off):.2g} %"), delivered, off, ""


def cases() -> Iterator[Case]:
    """One after the other."""
    yield from at_rest()
    yield from impossible()
    yield from moving()
    yield from solid()


# ------------------------------------------------------------------------------------------- rest


def _rest(
    bodies: Sequence[Body],
    joints: Sequence[Joint],
    loads: Sequence[Load] = (),
    gravity: Array | None = None,
    warmer: float = 0.0,
    steps: int = 1,
) -> tuple[System, Array]:
    """A system and its coordinates at rest."""
    weight = np.zeros(3) if gravity is None else gravity
    system = System(Description(list(bodies), list(joints), list(loads), weight))
    cold = system.coefficients(sections(system))
    found = equilibrium(system, cold, system.coefficients(sections(system, ROOM + warmer)), steps)
    if found.why:
        raise NoMotionError(found.why)
    return system, found.q


def _push(node: int, size: float, body: str = "beam") -> Force:
    return Force("push", Site(body, node), Y, lambda s: size * s)


def _at(system: System, q: Array, body: str, node: int) -> Array:
    first = system.layout.node_dofs[body][node]
    return q[first : first + 3]


def at_rest() -> Iterator[Case]:
    """Statics."""
    for ratio in (1e-8, 1e8):
        yield _two_bars(ratio)
    for stiffness in (1e-4, 1e12):
        yield _beside_a_spring(stiffness)
    EI = 1e9 * THIN.second_moment_2
    hair = straight(1.0, 16, THIN, elastic(1e9))
    yield Case(
        "1e5 times longer than high, 10 EI/L^2", "height of the end [L]",
        lambda: float(
            _at(*_rest([hair], [clamp()], [_push(16, 10.0 * EI)], steps=2), "beam", 16)[1]
        ),
        0.81060902,
    )  # fmt: skip
    yield _rolled(2)
    for warmer in (-298.0, 900.0):
        yield _warmed(warmer)
    yield _rope()
    yield _roof()


def _warmed(warmer: float) -> Case:
    """A bar free to expand, almost to 0 K and beyond melting."""
    bar = straight(1.0, 4, BAR, METAL)
    return Case(
        f"free bar taken to {ROOM + warmer:g} K", "elongation [m]",
        lambda: float(_at(*_rest([bar], [clamp()], warmer=warmer), "beam", 4)[0]) - 1.0,
        23e-6 * warmer, tolerance=1e-6,
    )  # fmt: skip


def _two_bars(ratio: float) -> Case:
    """P L^3/3EI of each, and the turn of the first; shear."""
    first = straight(1.0, 4, BAR, METAL)
    second = straight(1.0, 4, BAR, elastic(70e9 * ratio, 0.3))
    second = replace(second, name="second", points=second.points + X)
    joints = [clamp(), Clamp("weld", Site("beam", 4), Site("second", 0))]
    EI = 70e9 * BAR.second_moment_2
    size = 1e-4 * min(1.0, ratio) * EI
    bending = size / EI * (1 / 3 + 1 / 2 + 3 / 2 + 1 / (3 * ratio))
    shear = size / (70e9 / 2.6 * BAR.shear_factor_2 * BAR.area) * (1 + 1 / ratio)
    return Case(
        f"two bars in a row, stiffness 1 : {ratio:g}", "deflection [m]",
        lambda: float(_at(*_rest([first, second], joints, [_push(4, size, "second")]),
                          "second", 4)[1]),
        bending + shear,
    )  # fmt: skip


def _beside_a_spring(stiffness: float) -> Case:
    spring = Spring("spring", Site("beam", 4), Site(None, position=X + Y), stiffness, preload=1e-3)
    beam = 3.0 * 70e9 * BAR.second_moment_2
    return Case(
        f"spring of {stiffness:g} N/m at a beam of {beam:.3g} N/m", "deflection [m]",
        lambda: float(_at(*_rest([straight(1.0, 4, BAR, METAL)], [clamp(), spring]), "beam", 4)[1]),
        1e-3 / (beam + stiffness),
    )  # fmt: skip


def _rolled(turns: int) -> Case:
    """Under 2 pi EI/L for each turn its end comes back to its start."""
    EI = 1e9 * THIN.second_moment_2
    size = 2.0 * np.pi * EI * turns
    roll = Moment("roll", Site("beam", 32), Z, lambda s: size * s)
    hair = straight(1.0, 32, THIN, elastic(1e9))
    return Case(
        f"rolled up {turns} times", "place of the end [L]",
        lambda: float(np.linalg.norm(
            _at(*_rest([hair], [clamp()], [roll], steps=20 * turns), "beam", 32))),
        0.0, unit=1.0, tolerance=1e-2,
    )  # fmt: skip


def _rope() -> Case:
    """Straight, without bending stiffness to speak of: it sags by the cube root of its weight."""
    thin, made = general(1e-4, 1e-14, 1e-14, 1e-14), straight(1.0, 4, BAR, METAL)
    rope = Beam("beam", made.points, made.axes, thin, elastic(1e9, 0.0, 1000.0), ROOM,
                element="cable")  # fmt: skip
    ends = [Spherical("a", Site("beam", 0), Site(None)),
            Spherical("b", Site("beam", 4), Site(None, position=X))]  # fmt: skip
    return Case(
        "straight cable under its weight", "sag [m]",
        lambda: -float(_at(*_rest([rope], ends, gravity=-GRAVITY * Y, steps=10), "beam", 2)[1]),
        (3.0 * 1000.0 * 1e-4 * GRAVITY / (64.0 * 1e9 * 1e-4)) ** (1 / 3), tolerance=2e-2,
    )  # fmt: skip


def _roof() -> Case:
    """Two springs to a top, pushed beyond what they carry: it snaps to the far side."""
    k, height, P = 1e3, 0.2, 5.0
    free = np.hypot(1.0, height)
    joints: list[Joint] = [
        Guide("plane", Site("top"), Z[None]),
        Spring("left", Site("top"), Site(None, position=-X), k),
        Spring("right", Site("top"), Site(None, position=X), k),
    ]
    push = Force("push", Site("top"), -Y, lambda s: P * s)
    # below: 2 k w (1 - L0/L) = P
    w = 0.2
    for _ in range(60):
        w -= (2 * k * w * (1 - free / np.hypot(1, w)) - P) / (
            2 * k * (1 - free / np.hypot(1, w) ** 3)
        )
    top = Particle("top", height * Y, 1.0)
    return Case(
        "roof of two springs snaps through", "depth [m]",
        lambda: -float(_at(*_rest([top], joints, [push], steps=10), "top", 0)[1]), float(w),
        tolerance=1e-6,
    )  # fmt: skip


# ------------------------------------------------------------------------------------- impossible


def impossible() -> Iterator[Case]:
    """What has no answer."""
    good = straight(1.0, 4, BAR, METAL)
    yield Case(
        "load of 1e300 N", "", lambda: float(_rest([good], [clamp()], [_push(4, 1e300)])[1][0]),
        said="at load factor",
    )  # fmt: skip
    yield Case(
        "nothing holds it", "", lambda: float(_rest([good], [], [_push(4, 1.0)])[1][0]),
        said="nothing holds",
    )  # fmt: skip
    yield Case("Poisson's ratio 1/2", "", lambda: float(bool(elastic(70e9, 0.5))), said="between")
    nodes = replace(good, points=good.points * [[1], [1], [0], [0], [1]])
    hub = RigidBody("hub", X, 1.0, np.diag([0.1, 0.2, 0.25]))
    pin = Revolute("pin", Site("hub"), Site(None, position=X), Z)
    flat = replace(hub, inertia=np.diag([0.0, 1.0, 1.0]))
    ball = Particle("ball", X, 1.0)
    told: dict[str, tuple[Sequence[Body], Sequence[Joint], Sequence[Load], str]] = {
        "nodes that coincide": ([nodes], [], [], "coincide"),
        "inertia of a line": ([flat], [], [], "moments of inertia must be positive"),
        "no mass": ([replace(ball, mass=0.0)], [], [], "mass must be positive"),
        "drive that jumps": (
            [hub], [replace(pin, angle=lambda t: 1.0 * (t > 0.495))], [], "Newton did not converge"
        ),
        "load that becomes no number": (
            [ball], [], [Force("f", Site("ball"), Y, lambda t: np.nan if t > 0.495 else 1.0)],
            "forces are not finite",
        ),
        "joint said twice": (
            [hub], [pin, replace(pin, name="again")], [], "repeat"
        ),
        "slider runs off its beam": (
            [good, Particle("bead", 0.5 * X, 1.0, 1.03 * X)],
            [clamp(), Sliding("slider", Site("bead"), "beam")], [], "slides off the end",
        ),
    }  # fmt: skip
    for what, (bodies, joints, loads, said) in told.items():
        yield Case(what, "", partial(_somewhere, bodies, joints, loads), said=said)


def _somewhere(bodies: Sequence[Body], joints: Sequence[Joint], loads: Sequence[Load]) -> float:
    return float(_end(bodies, joints, loads).at[0])


# ----------------------------------------------------------------------------------------- motion


class End(NamedTuple):
    """Where a motion ended: its system, coordinates, velocities."""

    system: System
    at: Array
    speeds: Array

    def position(self, body: str, node: int = 0) -> Array:
        """(3,) [m]."""
        return _at(self.system, self.at, body, node)

    def axis(self, body: str) -> Array:
        """(3,) e1 of a rigid body."""
        first = self.system.layout.node_dofs[body][0]
        return self.at[first + 3 : first + 6]

    def turn(self, joint: str) -> float:
        """[rad]"""
        return float(self.at[self.system.layout.joint_dofs[f"{joint}.turn"]])


def _end(
    bodies: Sequence[Body],
    joints: Sequence[Joint] = (),
    loads: Sequence[Load] = (),
    control: Control | None = None,
    end: float = 1.0,
    gravity: Array | None = None,
) -> End:
    """A motion to its end."""
    weight = np.zeros(3) if gravity is None else gravity
    told = Description(list(bodies), list(joints), list(loads), weight)
    solver = Mechanics(told, control or Control(np.inf, 1e-2, 1e-2))
    T = np.tile([ROOM, 0.0, 0.0], (len(solver.x), 1))
    state, _, why = solver.advance(solver.initial(T), end, T, T)
    if why:
        raise NoMotionError(why)
    return End(solver.system, state.motion.q, state.motion.v)


def moving() -> Iterator[Case]:
    """Motions."""
    for light in (1e-9, 1.0):
        yield _unequal(light, 1e6)
    yield _unequal(1e-9, 1e-9)
    for spin in (1e-3, 1e4):
        yield _spinning(spin)
    yield _driven()
    for radians, controlled in ((1e2, False), (1e4, False), (1e4, True)):
        yield _let_go(radians, controlled)
    yield _hanging()
    for ratio in (1e-6, 1e6):
        yield _geared(ratio)
    yield _latched()


def _spinning(spin: float) -> Case:
    """With the inertia of a plate, the largest that there can be about its normal."""
    plate = RigidBody("plate", X, 1.0, np.diag([1.0, 1.0, 2.0]), spin=spin * Z)
    control = Control(1e-9, 0.1 / spin, 1e-9 / spin)
    return Case(
        f"plate spins at {spin:g} rad/s", "direction after 3 rad",
        lambda: float(_end([plate], control=control, end=3.0 / spin).axis("plate")[1]),
        float(np.sin(3.0)),
    )  # fmt: skip


def _unequal(light: float, heavy: float) -> Case:
    """Two masses on a spring; their distance is L + v/w sin(w t), w^2 = k (1/m + 1/M)."""
    together = light * heavy / (light + heavy)
    w, v = 100.0, 1.0
    bodies = [Particle("light", X, light, v * X), Particle("heavy", 0.0 * X, heavy)]
    spring = Spring("spring", Site("light"), Site("heavy"), together * w * w)
    end = 0.25 * np.pi / w
    control = Control(1e-9, 0.1 * end, 1e-9 * end)

    def stretched() -> float:
        found = _end(bodies, [spring], control=control, end=end)
        return float(found.position("light")[0] - found.position("heavy")[0]) - 1.0

    return Case(f"masses of {light:g} and {heavy:g} kg on a spring", "stretch [m]", stretched,
                v / w * float(np.sin(w * end)))  # fmt: skip


def _driven() -> Case:
    """In a steady turn only the centrifugal stretch is left: rho w^2 L^3/(3 E) = 1e-6."""
    hair = replace(straight(1.0, 16, THIN, METAL), spin=10.0 * Z)
    drive = Revolute("drive", Site("beam", 0), Site(None), Z, angle=lambda t: 10.0 * t)
    control = Control(np.inf, 1e-4, 1e-4)
    return Case(
        "1e5 times longer than high, turns by a radian", "direction of its end",
        lambda: float(_end([hair], [drive], control=control, end=0.1).position("beam", 16)[1]),
        float(np.sin(1.0)), tolerance=1e-4,
    )  # fmt: skip


def _let_go(radians: float, controlled: bool = False) -> Case:
    """A spring of 1e8 N/m let go in steps of many of its radians: what damps finds its rest.

    Longer steps of equal length have another solution, where the spring has turned round.
    """
    spring = Spring("s", Site("ball"), Site(None), 1e8, preload=1e3)
    h = 1e-4 * radians
    control = Control(1e-6, h, 1e-9 * h) if controlled else Control(
        np.inf, h, h, Scheme(name="backward-euler"))  # fmt: skip
    ball = Particle("ball", X, 1.0)
    soft = replace(spring, damping=2e4)
    ways = "step control from" if controlled else "equal steps of"
    return Case(
        f"stiff spring let go, {ways} {radians:g} radians", "way [m]",
        lambda: float(_end([ball], [soft if controlled else spring], control=control,
                           end=10.0 * h).position("ball")[0]) - 1.0,
        -1e-5, unit=1.0, tolerance=1e-5,
    )  # fmt: skip


def _hanging() -> Case:
    """A beam as thin as a hair swings as a chain: sum of Bessel functions (Bernoulli 1738)."""
    tilt, t = 1e-3, 0.5
    hair = straight(1.0, 8, THIN, METAL, direction=-Y, normal=X)
    nail = Spherical("nail", Site("beam", 0), Site(None))
    z = jn_zeros(0, 40)
    exact = tilt * np.sum(8.0 / (z**3 * j1(z)) * (1.0 - np.cos(0.5 * z * np.sqrt(GRAVITY) * t)))
    weight = np.array([tilt * GRAVITY, -GRAVITY, 0.0])
    return Case(
        "1e5 times longer than high, swings as a chain", "way of its end [m]",
        lambda: float(_end([hair], [nail], control=Control(1e-4, 1e-3, 1e-12), end=t,
                           gravity=weight).position("beam", 8)[0]),
        float(exact), tolerance=2e-2,
    )  # fmt: skip


def _geared(ratio: float) -> Case:
    bodies = [RigidBody("one", 0.0 * X, 1.0, np.eye(3)), RigidBody("two", X, 1.0, np.eye(3))]
    joints: list[Joint] = [
        Revolute("first", Site("one"), Site(None), Z),
        Revolute("second", Site("two"), Site(None, position=X), Z),
        Gear("gear", "first", "second", ratio),
    ]
    moment = Moment("m", Site("one"), Z, lambda t: 1.0)
    control = Control(np.inf, 1e-3, 1e-3)
    return Case(
        f"gear of ratio {ratio:g}", "turn [rad]",
        lambda: _end(bodies, joints, [moment], control).turn("first"),
        0.5 / (1.0 + ratio**2), tolerance=1e-4,
    )  # fmt: skip


def _latched() -> Case:
    """A rod that runs into a latch stops there."""
    inertia = np.diag([1e-3, 1.0 / 12.0, 1.0 / 12.0])
    rod = RigidBody("rod", 0.5 * X, 1.0, inertia, velocity=5.0 * Y, spin=10.0 * Z)
    hinge = Revolute("hinge", Site("rod", offset=-0.5 * X), Site(None), Z)
    return Case(
        "rod runs into a latch at 10 rad/s", "where it stays",
        lambda: float(_end([rod], [hinge, Latch("latch", "hinge", 1.0)],
                           control=Control(1e-6, 1e-2, 1e-11)).axis("rod")[1]),
        float(np.sin(1.0)), tolerance=1e-5,
    )  # fmt: skip


# ----------------------------------------------------------------------------------------- solids


def solid() -> Iterator[Case]:
    """Hexahedra of second order."""
    for ratio in (1e2, 1e3):
        yield Case(
            f"solid {ratio:g} times longer than high, 20 cells", "first frequency [Hz]",
            partial(_frequency, ratio), _euler(ratio), tolerance=5e-3,
        )  # fmt: skip
    yield Case("free solid warmed by 900 K", "elongation [m]", _expanded, 23e-6 * 900.0,
               tolerance=1e-6)  # fmt: skip
    bar = _bar(0.1)
    mirrored = replace(bar, points=bar.points * [-1.0, 1.0, 1.0])
    yield Case("solid with cells inside out", "",
               lambda: float(_end([mirrored]).at[0]), said="are inverted")  # fmt: skip


def _bar(height: float, count: int = 20) -> Continuum:
    mesh = box((1.0, height, height), (count, 2, 1), 2, "hexahedron20")
    cells, metal = mesh.cells["hexahedron20"], elastic(70e9, 0.0, 2700.0, 23e-6)
    return Continuum("bar", mesh.points, cells, metal, ROOM)


def _held(bar: Continuum) -> list[Joint]:
    root = np.flatnonzero(bar.points[:, 0] == 0.0)
    return [Fixing(f"held {k}", "bar", int(k), "position", np.eye(3)) for k in root]


def _frequency(ratio: float) -> float:
    bar = _bar(1.0 / ratio)
    system = System(Description([bar], _held(bar)))
    rest = system.coefficients(sections(system))
    found = modes(system, system.layout.q0, np.zeros(system.m), rest, 2)
    return float(found.frequencies[0])


def _euler(ratio: float) -> float:
    return 1.87510407**2 / (2.0 * np.pi * ratio) * float(np.sqrt(70e9 / 12.0 / 2700.0))


def _expanded() -> float:
    bar = _bar(0.1, 4)
    corner = int(np.argmin(np.abs(bar.points).sum(axis=1)))
    far = int(np.argmax(bar.points[:, 0] - bar.points[:, 1] - bar.points[:, 2]))
    side = int(np.argmax(bar.points[:, 1] - bar.points[:, 0] - bar.points[:, 2]))
    joints: list[Joint] = [
        Fixing("corner", "bar", corner, "position", np.eye(3)),
        Fixing("far", "bar", far, "position", np.array([Y, Z])),
        Fixing("side", "bar", side, "position", Z[None]),
    ]
    system, q = _rest([bar], joints, warmer=900.0)
    return float(_at(system, q, "bar", far)[0]) - 1.0
