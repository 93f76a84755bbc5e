"""Stability over clearance and contact stiffness: a ball against the wall of a bore, and one that
falls into it and comes to rest.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np

from coupling.reports.extremes import GRAVITY, SPEED, Case, flight
from coupling.reports.maps import DONE, GROWS, REFUSED, WRONG, Map, Spot, counted, largest, reasons
from coupling.reports.registry import Result, Row
from coupling.reports.travel import Travel, travel
from coupling.verify.contact import X, joint
from coupling.verify.models import model
from mechanics.description import NormalContact, Particle
from mechanics.dynamics import Control

CLEARANCES = tuple(10.0**e for e in np.arange(-6.0, -1.9, 0.5))
STIFFNESSES = tuple(10.0**e for e in range(3, 15))
RIGHT, NO_GAIN = 2e-3, 1e-4
"""Error that counts as right, energy gained that counts as none [-]."""
TOLERANCE, SMALLEST = 1e-6, 1e-18
MASS, BOUNCE = 0.01, 0.3
"""Of the ball [kg]; restitution of the one that comes to rest [-]."""
UNITS = {"hertz-external": "N/m^1.5", "linear": "N/m"}

Make = Callable[[float, float], Case]


def report() -> Iterator[Result]:
    """Impacts under both laws, and rest."""
    yield clearances()


def clearances(
    gaps: Sequence[float] = CLEARANCES, stiffnesses: Sequence[float] = STIFFNESSES
) -> Result:
    """All three motions."""
    rows, maps = list[Row](), list[Map]()
    notes = [
        f"wrong: result off by more than {RIGHT:g}; grows: more than {NO_GAIN:g} of the most "
        "stored energy gained",
        f"local error {TOLERANCE:g}, steps down to {SMALLEST:g} s",
    ]
    for name, make in MOTIONS.items():
        found = [spot(make(c, K), c, K) for c, K in product(gaps, stiffnesses)]
        spots = [s for s, *_ in found]
        outcomes = counted(spots)
        rows.append((
            name, len(spots), *outcomes.values(), largest(spots),
            max(error for _, error, _ in found), max(steps for *_, steps in found),
        ))  # fmt: skip
        notes += [f"{name}: {text}" for text in reasons(spots)]
        law = "linear" if "linear" in name else "hertz-external"
        maps.append(Map(name, "clearance [m]", f"K [{UNITS[law]}]", "energy gained [-]", spots,
                        limits=(1e-12, NO_GAIN)))  # fmt: skip
    columns = ("motion", "runs", *counted([]), "energy gained [-]", "largest error [-]",
               "most steps")  # fmt: skip
    return Result("stability_clearance", "Pin in a bore: clearance and stiffness", columns, rows,
                  notes, maps)  # fmt: skip


def spot(case: Case, clearance: float, stiffness: float) -> tuple[Spot, float, int]:
    """A run, its error [-], its steps."""
    path = travel(case.made, case.end, Control(TOLERANCE, case.largest, SMALLEST))
    gained = max(path.gained, 0.0)
    if path.why:
        return Spot(clearance, stiffness, REFUSED, gained, path.why), 0.0, path.steps
    error = abs(case.delivered(path) - case.expected) / (case.unit or abs(case.expected))
    outcome = WRONG if not error <= RIGHT else GROWS if not gained <= NO_GAIN else DONE
    return Spot(clearance, stiffness, outcome, gained), float(error), path.steps


def resting(clearance: float, stiffness: float) -> Case:
    """A ball that falls onto the wall, bounces less and less, and lies F/K deep in the end."""
    depth = MASS * GRAVITY / stiffness
    contact = NormalContact("linear", stiffness, restitution=BOUNCE)
    fall = float(np.sqrt(2.0 * clearance / GRAVITY))
    swing = float(np.sqrt(MASS / stiffness))
    made = model([Particle("ball", np.zeros(3), MASS)], [joint(contact, clearance)],
                 gravity=GRAVITY * X)  # fmt: skip
    end = fall * (1.0 + BOUNCE) / (1.0 - BOUNCE) + 60.0 * swing

    def place(path: Travel) -> float:
        return float(path.q[-1, 0])

    return Case("rest", "place [m]", made, end, fall, place, clearance + depth)


def impact(clearance: float, law: str, stiffness: float) -> Case:
    """A ball against the wall: speed with which it comes back, over that with which it went.

    It is the largest backwards, whatever the ball meets afterwards.
    """
    case = flight("", clearance, law, stiffness)
    return case._replace(delivered=lambda path: -float(path.v[:, 0].min()) / SPEED)


MOTIONS: dict[str, Make] = {
    "restitution 0.85, Hertz": lambda c, K: impact(c, "hertz-external", K),
    "restitution 0.85, linear": lambda c, K: impact(c, "linear", K),
    "falls and rests, linear": resting,
}
