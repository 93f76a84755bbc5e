"""Clearance joints: impacts, rebounds, friction, energy, thermal clearance.

All motions are those of the joint in the solver under step control, which divides the duration
of an impact into about 32 steps; restitution is then within 2e-3.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from coupling.verify.models import ROOM, Model, elastic, model, sections, straight
from coupling.verify.motion import Path, run
from coupling.verify.registry import Check, problem
from mechanics.contact import DISSIPATION, elastic_impact
from mechanics.description import (
    Beam,
    ClearanceRevolute,
    Force,
    Friction,
    Guide,
    NormalContact,
    Particle,
    Site,
)
from mechanics.dynamics import Control
from mechanics.ledger import TERMS
from mechanics.schemes import Scheme
from meshes.sections import circle

Array = NDArray[np.float64]

X = np.array([1.0, 0.0, 0.0])
AXIS = np.array([0.0, 0.0, 1.0])
GRAVITY = 9.81  # [m/s^2]
STIFFNESS = 1e10  # [N/m^1.5]


def joint(
    contact: NormalContact,
    clearance: float,
    friction: Friction | None = None,
    body: str = "ball",
    radius: float = 25e-3,
    bearing: ArrayLike = (0.0, 0.0, 0.0),
) -> ClearanceRevolute:
    """A journal at the start of ``body`` in a bearing of the ground, about z."""
    metal, ground = elastic(2e11, 0.3, 1.0, 23.1e-6), Site(None, position=np.array(bearing))
    return ClearanceRevolute(
        "hinge", Site(body), ground, AXIS, radius, clearance, metal, metal, ROOM, contact, friction
    )  # fmt: skip


def ball(mass: float, velocity: ArrayLike) -> Particle:
    """A point mass in the middle of the bearing."""
    return Particle("ball", np.zeros(3), mass, np.array(velocity))


def column(made: Model, path: Path, name: str) -> Array:
    """A column of the responses of the first clearance joint."""
    assert made.system.contact is not None
    return path.response[:, 0, made.system.contact.columns.index(name)]


class Impact(NamedTuple):
    """Largest penetration [m] and force [N], duration [s], rebound over approach speed [-]."""

    penetration: float
    force: float
    duration: float
    restitution: float


def _impact(mass: float, speed: float, contact: NormalContact, lasting: float = 1.0) -> Impact:
    """First impact of a ball shot from the middle of a bearing with 0.1 mm clearance.

    It may last ``lasting`` times as long as an elastic one.
    """
    clearance = 1e-4
    made = model(ball(mass, speed * X), [joint(contact, clearance)])
    duration = float(elastic_impact(mass, contact.value or STIFFNESS, speed).duration)
    flight = clearance / speed
    path = run(made, flight + 1.5 * lasting * duration, Control(1e-6, 0.3 * flight, 1e-18))
    depth, rate = column(made, path, "penetration"), column(made, path, "rate")
    force = column(made, path, "elastic_force") + column(made, path, "dissipative_force")
    on = np.flatnonzero(depth > 0.0)[0]
    off = on + np.flatnonzero(depth[on:] < 0.0)[0]  # force and rate go on smoothly to zero
    past = depth[off] / rate[off]
    return Impact(
        depth[:off].max(), force[:off].max(), path.t[off] - past - flight, -rate[off] / speed
    )


@problem("contact", "Hertz impact of a steel ball", "Johnson 1985, sec. 11.4: R = 10 mm, 1 m/s")
def hertz_impact() -> list[Check]:
    found = _impact(0.032673, 1.0, NormalContact(value=1.53846e10, restitution=1.0))
    return [
        Check("largest penetration", found.penetration, 2.342085e-5, 5e-3, "m"),
        Check("largest force", found.force, 1743.776, 5e-3, "N"),
        Check("duration", found.duration, 6.8934e-5, 5e-3, "s"),
        Check("restitution", found.restitution, 1.0, 2e-3),
    ]


@problem("contact", "delivered restitution of the exact law", "requested; 1 mm/s to 10 m/s")
def exact_law() -> list[Check]:
    """For each restitution the speed with the largest deviation."""
    checks = []
    for e in (0.05, 0.1, 0.3, 0.5, 0.7, 0.85, 0.95, 0.99):
        law = NormalContact(value=STIFFNESS, dissipation="exact", restitution=e)
        found = [_impact(0.01, v, law, 1.0 + 0.1 / e).restitution for v in (1e-3, 0.1, 1.0, 10.0)]
        worst = found[int(np.argmax(np.abs(np.array(found) - e)))]
        checks.append(Check(f"e = {e}, worst of 4 speeds", worst, e, 2e-3, "", True))
    return checks


def _relation(factor: float) -> float:
    """Restitution that a factor D delivers: D (1 + e) = ln((1 + D)/(1 - D e))."""
    return brentq(
        lambda e: factor * (1.0 + e) - np.log((1.0 + factor) / (1.0 - factor * e)),
        1e-6, (1.0 - 1e-12) / max(factor, 1.0), xtol=1e-13,
    )  # fmt: skip


@problem("contact", "delivered restitution of the other laws", "e = .85; D(1+e) = ln((1+D)/(1-De))")
def other_laws() -> list[Check]:
    factors = {
        "hua2026": 1.5 * (1.0 - 0.85**2) / 0.85,
        "hunt-crossley": 1.5 * 0.15,
        "lankarani-nikravesh": 0.75 * (1.0 - 0.85**2),
        "gonthier": (1.0 - 0.85**2) / 0.85,
        "flores": 8.0 * 0.15 / (5.0 * 0.85),
        "hu-guo": 1.5 * 0.15 / 0.85,
    }
    assert set(factors) | {"exact"} == set(DISSIPATION)
    checks = []
    for name, factor in factors.items():
        law = NormalContact(value=STIFFNESS, dissipation=name, restitution=0.85)
        found = _impact(0.01, 0.1, law, 1.2).restitution
        checks.append(Check(name, found, _relation(factor), 2e-3, "", True))
    return checks


@problem("contact", "fixed reference speed 0.1 m/s", "Hua et al. 2026; relation as above")
def reference_speed() -> list[Check]:
    """The force is never attractive here, the printed one is above 0.204 m/s of separation.

    That changes nothing: 1/D times 0.1 m/s = 0.204 m/s is a speed at which the force vanishes,
    so that an impact approaches it but never exceeds it while separating.
    """
    law = NormalContact(
        value=STIFFNESS, dissipation="hua2026", restitution=0.85, reference_speed=0.1
    )
    factor = 1.5 * (1.0 - 0.85**2) / 0.85
    return [
        Check(
            f"v = {v} m/s", _impact(0.01, v, law, 1.0 + v / 0.1).restitution,
            _relation(factor * v / 0.1), 2e-3, "", True,
        )
        for v in (0.01, 0.1, 0.5, 1.0)
    ]  # fmt: skip


def _onsets(path: Path) -> Array:
    """Times at which impacts begin."""
    running = path.approach[:, 0] != 0.0
    return path.t[np.flatnonzero(running & ~np.append(False, running[:-1]))]


@problem("contact", "journal between walls", "gap 0.2 mm, 0.1 m/s, e = 0.85: t + g/(v e^n)")
def between_walls() -> list[Check]:
    """From the middle, hence 1 ms later than from the wall; impacts last about 0.1 µs."""
    law = NormalContact("linear", 1e12, "exact", 0.85)
    made = model(ball(1e-3, 0.1 * X), [joint(law, 1e-4)])
    times = 1e3 * _onsets(run(made, 13.5e-3, Control(1e-6, 1e-3, 1e-16))) + 1.0
    references = (2.0, 4.35294, 7.12111, 10.37777, 14.20915)
    return [
        Check(f"impact {i + 1}", t, reference, 1e-3, "ms")
        for i, (t, reference) in enumerate(zip(times, references, strict=True))
    ]


@problem("contact", "bouncing ball until it rests", "h = 1 m, e = 0.5: (1 + e)/(1 - e) √(2 h/g)")
def bouncing_ball() -> list[Check]:
    """Falls 0.1 mm in the bearing; times scaled to a fall of 1 m. Rests on m g/K.

    With a restitution that is 1e-3 too large the times are up to 2e-3 too long.
    """
    clearance, mass, stiffness = 1e-4, 1e-3, 1e10
    law = NormalContact("linear", stiffness, "exact", 0.5)
    made = model(ball(mass, 0.0 * X), [joint(law, clearance)], gravity=GRAVITY * X)
    scaled = np.sqrt(1.0 / clearance)
    path = run(made, 1.6 / scaled, Control(1e-6, 0.1 / scaled, 1e-16))
    times = scaled * _onsets(path)
    fall = np.sqrt(2.0 / GRAVITY)
    depth = column(made, path, "penetration")[-1]
    return [
        Check("second impact", times[1], 2.0 * fall, 3e-3, "s"),
        Check("third impact", times[2], 2.5 * fall, 3e-3, "s"),
        Check("last impact", times[-1], 1.354571, 3e-3, "s"),
        Check("depth at rest", depth, mass * GRAVITY / stiffness, 1e-3, "m"),
    ]  # fmt: skip


@problem(
    "contact",
    "peak force over clearance, F ∝ c^p",
    "constant acceleration from the middle",
)
def clearance_exponent() -> list[Check]:
    checks = []
    for name, stiffness, exponent in (("linear", 1e7, 0.5), ("hertz-external", STIFFNESS, 0.6)):
        law = NormalContact(name, stiffness, "exact", 1.0)
        peaks = [_peak(law, c) for c in (1e-5, 1e-4)]
        checks.append(Check(f"p, {name}", float(np.log10(peaks[1] / peaks[0])), exponent, 5e-3))
    return checks


def _peak(law: NormalContact, clearance: float) -> float:
    """Largest force [N] in the first impact of 10 g, so slow that it is short against the fall."""
    made = model(ball(0.01, 0.0 * X), [joint(law, clearance)], gravity=0.01 * X)
    fall = np.sqrt(2.0 * clearance / 0.01)
    path = run(made, 1.2 * fall, Control(1e-6, 0.1 * fall, 1e-16))
    return float(column(made, path, "elastic_force").max())


@problem("contact", "sliding block", "t = v/(mu g), x = v^2/(2 mu g); v = 3 m/s, mu = 0.25")
def sliding_block() -> list[Check]:
    """As a journal whose rim slides in the bearing.

    A cylinder is pressed with the weight of the block J/R^2 that its rim feels; a guide takes
    the reaction to the friction, so that the normal force stays the weight. Its spin dies out
    exponentially below the regularisation speed, 1e-4 m/s; before, it falls linearly.
    """
    radius, friction, speed = 0.1, 0.25, 3.0
    made, block = _spinning(radius, friction, speed)
    path = run(made, 1.3, Control(1e-6, 1e-2, 1e-12, Scheme(newton_tolerance=1e-14)))
    t, rim = np.append(0.0, path.t), np.append(speed, column(made, path, "slip_speed"))
    late = np.flatnonzero(rim < 0.1 * speed)[0]
    lost = path.ledger[-1, TERMS.index("friction")]
    return [
        Check("time of stopping", t[late] + rim[late] / (friction * GRAVITY), 1.223242, 1e-3, "s"),
        Check("way of the rim", np.trapezoid(rim, t), 1.834862, 1e-3, "m"),
        Check("frictional work", lost / block, 4.5, 1e-3, "J/kg"),
        Check("energy defect / work", path.ledger[-1, -1] / lost, 0.0, 1e-6, "", True),
    ]


def _spinning(radius: float, friction: float, speed: float) -> tuple[Model, float]:
    """A cylinder along its axis of rotation, at rest on m g/K, and its mass at the rim [kg]."""
    density, length, clearance = 7800.0, 0.1, 1e-4
    section = circle(radius, 0.3)
    body = straight(
        length, 1, section, elastic(2e11, 0.3, density), direction=AXIS, normal=X
    )  # fmt: skip
    body = Beam(**(body.__dict__ | {"spin": speed / radius * AXIS}))
    block = density * section.polar_moment * length / radius**2
    depth = (block * GRAVITY / STIFFNESS) ** (2.0 / 3.0)
    hinge = joint(
        NormalContact(value=STIFFNESS), clearance, Friction(friction), "beam", radius,
        (-clearance - depth, 0.0, 0.0),
    )  # fmt: skip
    slide = Guide("slide", Site("beam"), np.array([[0.0, 1.0, 0.0]]))
    press = Force("press", Site("beam"), X, lambda t: block * GRAVITY)
    return model(body, [hinge, slide], [press]), block


@problem("contact", "energy over fifty and more impacts", "exact identity of the scheme")
def ledger_of_impacts() -> list[Check]:
    """A ball with friction, hysteresis and an oscillating force.

    What it lost is computed from the speeds and the work of the force alone.
    """
    mass, start = 0.1, np.array([0.8, 0.1, 0.0])
    law, friction = NormalContact(value=STIFFNESS, restitution=0.97), Friction(0.02)
    push = Force("push", Site("ball"), X, lambda t: 10.0 * np.sin(3000.0 * t))
    made = model(ball(mass, start), [joint(law, 1e-4, friction)], [push])
    path = run(made, 0.04, Control(1e-6, 1e-4, 1e-14, Scheme(newton_tolerance=1e-15)))
    force, x = (np.append(0.0, a) for a in (10.0 * np.sin(3000.0 * path.t), path.q[:, 0]))
    row = dict(zip(TERMS, path.ledger[-1], strict=True))
    brought = 0.5 * mass * start @ start + np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x))
    lost = brought - 0.5 * mass * path.v[-1] @ path.v[-1] - row["contact_elastic"]
    accounted = row["friction"] + row["hysteresis"] + row["numerical"]
    defect = row["defect"] / max(map(abs, row.values()))
    if len(_onsets(path)) < 50:
        raise RuntimeError(f"only {len(_onsets(path))} impacts")
    return [
        Check("friction + hysteresis + numerical", accounted, lost, 1e-6, "J"),
        Check("defect / largest term", defect, 0.0, 1e-6, "", True),
        Check("numerical / lost", row["numerical"] / lost, 0.0, 2e-3, "", True),
    ]


@problem("contact", "coefficients of the joint", "seizure c/(alpha R); Flores' slider-crank")
def coefficients() -> list[Check]:
    """Journal heated until the clearance of 50 µm is gone; Hertz stiffness of a pin in a bore."""
    seized = 50e-6 / (23.1e-6 * 25e-3)
    gaps = [_coefficient("clearance", joint(NormalContact(), 50e-6), dT) for dT in (0.0, seized)]
    rate = (gaps[0] - gaps[1]) / seized
    metal = elastic(207e9, 0.3)
    crank = ClearanceRevolute(
        "hinge", Site("ball"), Site(None), AXIS, 9.5e-3, 0.5e-3, metal, metal, ROOM,
        NormalContact("hertz-internal"),
    )  # fmt: skip
    stiffness = _coefficient("stiffness", crank)
    return [
        Check("temperature of seizure", gaps[0] / rate, 86.5801, 1e-5, "K"),
        Check("clearance then", gaps[1], 0.0, 1e-12, "m", True),
        Check("stiffness of pin in bore", stiffness, 6.6102e10, 1e-4, "N/m^1.5"),
    ]


def _coefficient(name: str, hinge: ClearanceRevolute, warmer: float = 0.0) -> float:
    """A coefficient of a joint whose journal is ``warmer`` [K] than the bearing."""
    from mechanics.clearance import COEFFICIENTS

    system = model(ball(1.0, np.zeros(3)), [hinge]).system
    T = sections(system)
    T[system.layout.point_index["hinge.journal"], 0] += warmer
    return float(system.coefficients(T)[-1][0, COEFFICIENTS.index(name)])
