"""Friction of joints with clearance: blocks that slide, stick, creep and break away.

A block is the slider of a guide: a point mass that two of its corners press on one wall, with
the wall where it is at rest under its load. All motion is along x then.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from coupling.verify.contact import GRAVITY, STEEL, X, Y
from coupling.verify.mechanisms import mechanism
from coupling.verify.models import ROOM, Model
from coupling.verify.motion import Path, run
from coupling.verify.registry import Check, Grid, Result, problem
from mechanics.contact import rising_coefficient
from mechanics.description import (
    Body,
    ClearanceTranslational,
    Force,
    Friction,
    History,
    Joint,
    Load,
    NormalContact,
    Particle,
    Prismatic,
    RigidBody,
    Site,
    Spring,
)
from mechanics.dynamics import Control
from mechanics.ledger import TERMS
from mechanics.march import FRICTION, STUCK

Array = NDArray[np.float64]

DAMPED = 400.0
"""Damping of bristles [s/m], about critical, without which a block rings where it comes to rest."""
PLAY, STIFF = 1e-3, 1e8  # [m], [N/m] of each corner


class Block(NamedTuple):
    """What lies on a wall at the beginning.

    mass [kg], pressed by ``load`` [N]; speed [m/s]; where the wall is driven to [m], if it is
    """

    mass: float
    load: float
    speed: float = 0.0
    travel: History | None = None

    def on_wall(
        self,
        friction: Friction,
        joints: tuple[Joint, ...] = (),
        loads: tuple[Load, ...] = (),
        gravity: Array = 0.0 * X,
        more: tuple[Body, ...] = (),
    ) -> Model:
        """The block at the origin, on a wall below it."""
        middle = (PLAY + 0.5 * self.load / STIFF) * Y
        belt = RigidBody("belt", middle, 1.0, np.eye(3))
        driven = Prismatic("drive", Site("belt"), Site(None, position=middle), X, self.travel)
        guide = ClearanceTranslational(
            "guide", Site("block"), Site("belt"), X, Y, 0.1, 0.02, PLAY, STEEL, STEEL, ROOM,
            NormalContact("linear", STIFF, restitution=0.5), friction,
        )  # fmt: skip
        body = Particle("block", np.zeros(3), self.mass, self.speed * X)
        return mechanism([body, belt, *more], [driven, guide, *joints], loads, gravity)

    def pressed(self, friction: Friction, *joints: Joint, more: tuple[Body, ...] = ()) -> Model:
        """Pressed by a dead force."""
        press = Force("press", Site("block"), -Y, lambda t: self.load)
        return self.on_wall(friction, joints, (press,), more=more)


def still(t: float) -> float:
    return 0.0


def _stuck(path: Path) -> Array:
    """(k,) bool: every contact that touches sticks."""
    return path.response[..., STUCK].sum(axis=1) > 1.5


def _changes(path: Path, after: float) -> Array:
    """Times [s] at which it begins or ends to stick."""
    stuck = _stuck(path)
    times = path.t[1:][stuck[1:] != stuck[:-1]]
    return times[times > after]


@problem("contact", "mass on a belt", "m = 1, k = 100, N = 10, µ = 0.4/0.3, v = 0.1: closed form")
def mass_on_belt() -> list[Result]:
    """Sticks until k x = µs N, slides by three quarters of a period, sticks again.

    It is known to a step when it gives way; in the longer one the belt moves by 0.1 mm.
    """
    law = Friction(
        0.3, law="stick", static_coefficient=0.4, presliding=1e-6, bristle_damping=DAMPED
    )
    spring = Spring("spring", Site("block"), Site(None, position=-X), 100.0)
    made = Block(1.0, 10.0, 0.1, lambda t: 0.1 * t).pressed(law, spring)
    steps, times, places = (1e-3, 2e-4), [], []
    for step in steps:
        path = run(made, 1.6, Control(1e-4, step, 1e-10))
        changes, x = _changes(path, 0.2), path.q[path.t > 0.5, 0]
        first = [*changes, *[np.nan] * 3][:3]
        times.append([first[0], *np.diff(first)])
        places.append([1e3 * x.min(), 1e3 * x.max()])
    rows = [f"steps of {step:g} s" for step in steps]
    known = [0.4, 0.471239, 0.2]
    return [
        Grid("durations [s]", ["first", "slips", "sticks"], rows, times, [known] * 2, 2e-3),
        Grid("places [mm]", ["least", "largest"], rows, places, [[15.858, 44.142]] * 2, 0.05),
    ]


@problem("contact", "LuGre friction, stick and slip", "Canudas de Wit et al. 1995, sec. IV-B")
def lugre() -> list[Check]:
    """A mass of 1 kg is pulled at 0.1 m/s by a spring of 2 N/m; what it does in the first slip."""
    law = Friction(
        1.0, law="lugre", static_coefficient=1.5, presliding=1.5e-5, stribeck_speed=1e-3,
        bristle_damping=float(np.sqrt(1e5)), viscous=0.4,
    )  # fmt: skip
    end = RigidBody("end", X, 1.0, np.eye(3), velocity=0.1 * X)
    pull = Prismatic("pull", Site("end"), Site(None, position=X), X, lambda t: 0.1 * t)
    spring = Spring("spring", Site("block"), Site("end"), 2.0)
    made = Block(1.0, 1.0, travel=still).pressed(law, pull, spring, more=(end,))
    path = run(made, 12.0, Control(1e-4, 2e-3, 1e-10))
    t, x, v = path.t, path.q[:, 0], path.v[:, 0]
    exact = _lugre(12.0)
    reference, at = exact.sol(t), np.linspace(0.0, 12.0, 200001)
    begin, end_ = _first(at, exact.sol(at)[1]), _last(at, exact.sol(at)[1])
    return [
        Check("first slip begins", _first(t, v), begin, 1e-3, "s"),
        Check("first slip ends", _last(t, v), end_, 1e-3, "s"),
        Check("  begin, known", begin, 7.458, 1e-4, "s"),
        Check("  end, known", end_, 10.2235, 1e-4, "s"),
        Check("largest speed", v.max(), reference[1].max(), 1e-3, "m/s"),
        Check("position at 12 s", x[-1], reference[0, -1], 1e-3, "m"),
    ]


def _first(t: Array, v: Array) -> float:
    """When it is first faster than 0.01 m/s."""
    return float(t[np.flatnonzero(v > 0.01)[0]])


def _last(t: Array, v: Array) -> float:
    """When it is last faster than 0.01 m/s."""
    return float(t[np.flatnonzero(v > 0.01)[-1]])


def _lugre(end: float):
    """Equations of motion and of the bristles, by a stiff solver; their dense output."""

    def rate(t: float, y: Array) -> list[float]:
        x, v, z = y
        g = (1.0 + 0.5 * np.exp(-((v / 1e-3) ** 2))) / 1e5
        dz = v - abs(v) / g * z
        return [v, 2.0 * (0.1 * t - x) - 1e5 * z - np.sqrt(1e5) * dz - 0.4 * v, dz]

    return solve_ivp(
        rate, (0.0, end), np.zeros(3), "Radau", dense_output=True, rtol=1e-8, atol=1e-12,
        max_step=0.05,
    )  # fmt: skip


@problem("contact", "static friction that grows", "Hua et al. 2026: µs - (µs - µk) exp(-a τ^m)")
def rising_friction() -> list[Check]:
    """The force at which a block breaks away after resting; it grows by 1 N/s."""
    checks = []
    for wait in (1.365, 9.2, 27.7):
        known, found = _break_away(wait)
        checks.append(Check(f"after {wait} s", found, known, 5e-3, "N"))
    return checks


def _break_away(wait: float) -> tuple[float, float]:
    """Force [N] at which 10 N give way that have lain for ``wait`` [s]: known, and found."""
    load, kinetic, static, rate, exponent = 10.0, 0.0623, 0.0859, 0.570, 0.629
    law = Friction(
        kinetic, law="rising", static_coefficient=static, presliding=1e-6,
        bristle_damping=DAMPED, rise_rate=rate, rise_exponent=exponent,
    )  # fmt: skip

    def pull(t: float) -> float:
        return max(0.0, t - wait)

    def excess(t: float) -> float:
        return pull(t) - load * float(rising_coefficient(t, kinetic, static, rate, exponent))

    push = Force("push", Site("block"), X, pull)
    press = Force("press", Site("block"), -Y, lambda t: load)
    made = Block(1.0, load, travel=still).on_wall(law, (), (push, press))
    path = run(made, wait + 1.0, Control(1e-4, 2e-3, 1e-10))
    held = float(path.t[np.flatnonzero(_stuck(path))[-1]])
    return pull(float(brentq(excess, wait, wait + 1.0))), pull(held)


@problem("contact", "sliding block", "t = v/(µ g), x = v²/(2 µ g); v = 3 m/s, µ = 0.25")
def sliding_block() -> list[Check]:
    mass = 2.0
    law = Friction(0.25, law="stick", presliding=1e-6, bristle_damping=DAMPED)
    made = Block(mass, mass * GRAVITY, 3.0, still).on_wall(law, gravity=-GRAVITY * Y)
    path = run(made, 1.4, Control(1e-4, 1e-4, 1e-10))
    lost = path.ledger[-1, TERMS.index("friction")]
    stops = path.t[np.flatnonzero(_stuck(path))]
    return [
        Check("stops at", stops[0], 1.223242, 2e-3, "s"),
        Check("stays there", float(np.abs(path.v[-1, 0])), 0.0, 1e-5, "m/s", True),
        Check("way", path.q[-1, 0], 1.834862, 1e-4, "m"),
        Check("frictional work", lost / mass, 4.5, 1e-4, "J/kg"),
        Check("energy defect / work", path.ledger[-1, -1] / lost, 0.0, 1e-6, "", True),
    ]


@problem("contact", "block on an incline", "g (sin 20° - µ cos 20°); µ = 0.3 slides, 0.5 holds")
def incline() -> list[Check]:
    mass, angle = 2.0, np.deg2rad(20.0)
    gravity = GRAVITY * (np.sin(angle) * X - np.cos(angle) * Y)
    block, found = Block(mass, mass * GRAVITY * np.cos(angle), 0.0, still), []
    for mu in (0.3, 0.5):
        law = Friction(mu, law="stick", presliding=1e-6, bristle_damping=DAMPED)
        found.append(run(block.on_wall(law, gravity=gravity), 1.0, Control(1e-4, 1e-4, 1e-10)))
    slides, holds = found
    half = len(slides.t) // 2
    a = (slides.v[-1, 0] - slides.v[half, 0]) / (slides.t[-1] - slides.t[half])
    bound = 1e-6 * np.tan(angle) / 0.5
    return [
        Check("acceleration", a, 0.589702, 1e-5, "m/s²"),
        Check("bristles when it holds", holds.q[-1, 0], bound, 1e-2, "m"),
        Check("friction then", -holds.response[-1, :, FRICTION + 2].sum(),
              mass * GRAVITY * np.sin(angle), 1e-4, "N"),
    ]  # fmt: skip
