"""Sequences of impacts: their times, peak forces, energies, and the chatter before rest."""

import numpy as np
from numpy.typing import NDArray

from coupling.verify.contact import (
    CLEARANCE,
    GRAVITY,
    STIFFNESS,
    X,
    ball,
    joint,
    onsets,
)
from coupling.verify.models import model
from coupling.verify.motion import run
from coupling.verify.registry import Check, Grid, Result, problem
from mechanics.description import Force, Friction, NormalContact, Site
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.ledger import TERMS
from mechanics.march import DEPTH, ELASTIC, Rows
from mechanics.schemes import Scheme

Array = NDArray[np.float64]

FINE = 1e-8
"""Local error over the clearance, so that errors of restitution add up to less than 1e-3."""
WALLS = (2.0, 4.35294, 7.12111, 10.37777, 14.20915)  # [ms]


def _between_walls(largest: float) -> Array:
    """Times [ms] of five impacts, from the middle and hence 1 ms later than from the wall."""
    law = NormalContact("linear", 1e12, "exact", 0.85)
    made = model(ball(1e-3, 0.1 * X), [joint(law, CLEARANCE)])
    return 1e3 * onsets(run(made, 13.5e-3, Control(FINE, largest, 1e-16))) + 1.0


@problem("contact", "journal between walls", "gap 0.2 mm, 0.1 m/s, e = 0.85: t + g/(v e^n)")
def between_walls() -> list[Result]:
    """The same whatever the largest step; impacts last about 0.1 µs, which is in the tolerance."""
    largest = (1e-3, 1e-4, 1e-5)
    times = [_between_walls(step) for step in largest]
    rows = [f"steps of {step:g} s" for step in largest]
    headings = [f"{i + 1} [ms]" for i in range(len(WALLS))]
    return [Grid("impact", headings, rows, times, [WALLS] * len(rows), 5e-4)]


def _bounce(restitution: float, fall: float, stiffness: float) -> tuple[Array, float]:
    """Times of impacts of a ball that falls 0.1 mm in the bearing, scaled to a fall of 1 m.

    And how deep it lies in the end, over the depth m g/K of rest.
    """
    mass, law = 1e-3, NormalContact("linear", stiffness, "exact", restitution)
    made = model(ball(mass, 0.0 * X), [joint(law, CLEARANCE)], gravity=GRAVITY * X)
    scaled = np.sqrt(1.0 / CLEARANCE)
    path = run(made, 1.1 * fall / scaled, Control(10.0 * FINE, 0.1 / scaled, 1e-16))
    depth = path.response[-1, 0, DEPTH]
    return scaled * onsets(path), float(depth / (mass * GRAVITY / stiffness))


@problem("contact", "bouncing ball until it rests", "h = 1 m: (1 + e)/(1 - e) √(2 h/g)")
def bouncing_ball() -> list[Check]:
    """Rests on m g/K. A restitution that is off by d changes the time by 2 d/(1 - e²).

    The last impact comes 1.3e-3 before the limit of the sequence: impacts last as long as the
    flights between them then, and the weight keeps the ball where it is.
    """
    fall, checks = np.sqrt(2.0 / GRAVITY), []
    cases = (0.5, 1.354571, 1e10), (0.9, 8.578949, 1e10), (0.5, 1.354571, 1e12)
    for e, total, stiffness in cases:
        times, depth = _bounce(e, total, stiffness)
        checks += [
            Check(f"e = {e}, K = {stiffness:g}, second impact", times[1], (1.0 + 2.0 * e) * fall,
                  1e-3, "s"),
            Check("  third", times[2], (1.0 + 2.0 * e + 2.0 * e * e) * fall, 1e-3, "s"),
            Check("  last", times[-1], total, 2e-3, "s"),
            Check("  depth at rest", depth, 1.0, 1e-3, "m g/K"),
        ]  # fmt: skip
    return checks


@problem("contact", "peak force over clearance, F ∝ c^p", "constant acceleration from the middle")
def clearance_exponent() -> list[Check]:
    """1/2 for a linear law, 3/5 for Hertz, and K ∝ c^(-1/2) of a pin in its bore leaves 2/5."""
    laws = (("linear", 1e7, 0.5), ("hertz-external", STIFFNESS, 0.6), ("hertz-internal", None, 0.4))
    checks = []
    for name, stiffness, exponent in laws:
        law = NormalContact(name, stiffness, "exact", 1.0)
        peaks = [_peak(law, c) for c in (1e-6, 1e-5, 1e-4)]
        p = float(np.polyfit(np.log([1e-6, 1e-5, 1e-4]), np.log(peaks), 1)[0])
        checks.append(Check(f"p, {name}", p, exponent, 5e-3))
    return checks


def _peak(law: NormalContact, clearance: float) -> float:
    """Largest force [N] in the first impact of 10 g, so slow that it is short against the fall."""
    made = model(ball(0.01, 0.0 * X), [joint(law, clearance)], gravity=0.01 * X)
    fall = np.sqrt(2.0 * clearance / 0.01)
    path = run(made, 1.2 * fall, Control(1e-6, 0.1 * fall, 1e-16))
    return float(path.response[:, 0, ELASTIC].max())


class _Driven:
    """A ball with friction and hysteresis, pushed to and fro by an oscillating force.

    What it lost is computed from the speeds and the work of the force alone.
    """

    mass, start, rate = 0.1, np.array([0.8, 0.1, 0.0]), 3000.0

    def __init__(self, stiffness: float, restitution: float, friction: float, largest: float):
        law, rubs = NormalContact(value=stiffness, restitution=restitution), Friction(friction)
        self.largest = largest
        push = Force("push", Site("ball"), X, self.force)
        self.made = model(ball(self.mass, self.start), [joint(law, CLEARANCE, rubs)], [push])
        self.work, self.impacts, self.last = 0.0, 0, (0.0, 0.0, True)

    def force(self, t: float) -> float:
        return self.largest * np.sin(self.rate * t)

    def observe(self, rows: Rows) -> None:
        t, x, running = rows.t, rows.y[:, 0], rows.approach[:, 0] != 0.0
        force = self.largest * np.sin(self.rate * t)
        begin_force, begin_x, was_running = self.last
        forces, places = np.append(begin_force, force), np.append(begin_x, x)
        self.work += float(np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(places)))
        self.impacts += int(np.count_nonzero(running & ~np.append(was_running, running[:-1])))
        self.last = float(force[-1]), float(x[-1]), bool(running[-1])

    def checks(self, end: float, tolerance: float, numerical: float) -> list[Check]:
        control = Control(tolerance, 1e-3, 1e-16, Scheme(newton_tolerance=1e-15))
        state, why = initial_state(self.made.system, control, self.made.coef)
        if state is None:
            raise RuntimeError(why)
        window = Window.between(self.made.system, 0.0, end, self.made.coef, None)
        state, _, why = advance(
            self.made.system, control, state, window, self.observe, full=True
        )  # fmt: skip
        if why:
            raise RuntimeError(why)
        row = dict(zip(TERMS, state.ledger, strict=True))
        kinetic = 0.5 * self.mass * (self.start @ self.start - state.motion.v @ state.motion.v)
        lost = kinetic + self.work - row["contact_elastic"]
        accounted = row["friction"] + row["hysteresis"] + row["numerical"]
        defect = row["defect"] / max(map(abs, row.values()))
        part = row["numerical"] / lost
        return [
            Check("friction + hysteresis + numerical", accounted, lost, 1e-6, "J"),
            Check("  defect / largest term", defect, 0.0, 1e-6, "", True),
            Check("  numerical / lost", part, 0.0, numerical, "", True),
        ]


@problem("contact", "energy over fifty and more impacts", "exact identity of the scheme")
def ledger_of_impacts() -> list[Check]:
    driven = _Driven(STIFFNESS, 0.97, 0.02, 10.0)
    checks = driven.checks(0.04, 1e-6, 2e-3)
    return [*checks, Check("  more than 50 impacts", min(driven.impacts, 50), 50, 0.0)]


@problem("contact", "energy over ten thousand impacts", "exact identity of the scheme")
def ledger_of_many_impacts() -> list[Check]:
    """With errors of steps that are four times as large, which shows in their part of the loss."""
    driven = _Driven(1e12, 0.99, 0.005, 1000.0)
    checks = driven.checks(2.0, 4e-6, 0.1)
    return [*checks, Check("  more than 10000 impacts", min(driven.impacts, 10000), 10000, 0.0)]
