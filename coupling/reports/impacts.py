"""Impacts of a ball in a bearing: what the largest step, and what the tolerance changes.

The march divides the estimated duration of an impact into max(6, 32 sqrt(1e-6/tolerance)) steps,
whatever the largest step; onsets are located inside the steps of flights.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.reports.travel import Travel, travel
from coupling.verify.contact import CLEARANCE, X, ball, joint
from coupling.verify.models import model
from mechanics.contact import elastic_impact
from mechanics.description import NormalContact
from mechanics.dynamics import Control
from mechanics.march import IMPACT_RESOLUTION, IMPACT_TOLERANCE, LEAST_RESOLUTION

Array = NDArray[np.float64]

MASS, SPEED, FLIGHT = 0.01, 0.1, CLEARANCE / 0.1
"""Of the ball [kg], [m/s]; from the middle to the wall [s]."""
RIGID, RESTITUTION = 1e18, 0.9
"""Stiffness [N/m^1.5] with which 20 impacts last 2e-6 of their flights; restitution [-]."""
STEPS, TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6), (1e-6, 1e-8)
"""Largest steps [s] and local errors [-] of the sequences."""
IMPACTS = (1, 5, 10, 20)
FINENESS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Local errors of single impacts."""
SPEEDS = SPEED * np.geomspace(0.9, 1.1, 9)
"""Worst of these counts, since steps end at different places in the impact."""
LAWS = {"hertz-external": (1e10, 1.5), "linear": (1e7, 1.0)}
"""Stiffness and exponent of the normal laws."""
CASES = [(law, e) for law in LAWS for e in (0.1, 0.5, 0.85, 1.0)]


def report() -> Iterator[Result]:
    """A sequence of impacts against the largest step; single ones against steps per impact."""
    yield _sequences()
    yield _single()


# ---------------------------------------------------------------------------------- sequences


def ballistic(count: int, restitution: float = RESTITUTION) -> Array:
    """Times [s] of impacts without duration between walls, from the middle."""
    return FLIGHT * (1.0 + 2.0 * np.cumsum(np.append(0.0, restitution ** -np.arange(1.0, count))))


def sequence(largest: float, tolerance: float) -> Travel:
    """Twenty impacts."""
    contact = NormalContact(value=RIGID, restitution=RESTITUTION)
    made = model(ball(MASS, SPEED * X), [joint(contact, CLEARANCE)])
    end = float(ballistic(21)[-2:].mean())
    return travel(made, end, Control(tolerance, largest, 1e-18))


def _sequences() -> Result:
    exact, all_errors = ballistic(IMPACTS[-1]), []
    rows: list[Row] = []
    sequence(STEPS[0], TOLERANCES[0])  # what is compiled at first use is not to be timed
    for tolerance in TOLERANCES:
        for largest in STEPS:
            path = sequence(largest, tolerance)
            times = path.onsets()
            errors = [float(times[k - 1] / exact[k - 1] - 1.0) for k in IMPACTS]
            all_errors.append(errors)
            flights = np.diff(times[: IMPACTS[-1]])
            restitution = float((flights[0] / flights[-1]) ** (1.0 / (len(flights) - 1)))
            rows.append((
                f"{tolerance:g}", f"{largest:g} s", *errors, restitution - RESTITUTION,
                path.gained, path.made, path.steps, path.refused, path.seconds,
            ))  # fmt: skip
    columns = (
        "local error", "largest step", *(f"time {k} [rel. error]" for k in IMPACTS),
        "restitution [error]", "energy gained [-]", "made by the scheme [-]", "steps", "refused",
        "time [s]",
    )  # fmt: skip
    title = f"Ball between walls, restitution {RESTITUTION:g}: impacts against the largest step"
    spread = _spread(all_errors)
    note = (
        "a step a thousand times smaller moves impact "
        + ", ".join(f"{k} by {s:.1e}" for k, s in zip(IMPACTS, spread, strict=True))
        + f" of its time at a local error of {TOLERANCES[0]:g}; halving it is not what helps"
    )
    return Result("impacts", title, columns, rows, [note])


def _spread(errors: list[list[float]]) -> Array:
    """Largest less smallest of the errors at the first tolerance."""
    return np.ptp(np.array(errors[: len(STEPS)]), axis=0)


# ------------------------------------------------------------------------------------- single


def steps_per_impact(tolerance: float) -> float:
    """Into which the march divides the duration of an impact."""
    return max(LEAST_RESOLUTION, IMPACT_RESOLUTION * sqrt(IMPACT_TOLERANCE / tolerance))


def single(law: str, restitution: float, speed: float, tolerance: float) -> Travel:
    """One impact and a bit of flight."""
    stiffness, exponent = LAWS[law]
    contact = NormalContact(law, stiffness, restitution=restitution)
    made = model(ball(MASS, speed * X), [joint(contact, CLEARANCE)])
    duration = float(elastic_impact(MASS, stiffness, speed, exponent).duration)
    flight = CLEARANCE / speed
    end = flight + (1.5 + 0.1 / restitution) * duration
    return travel(made, end, Control(tolerance, 0.3 * flight, 1e-18))


def _single() -> Result:
    rows: list[Row] = []
    curves: list[Curve] = []
    timed: list[Curve] = []
    for law, restitution in CASES:
        points = [_worst(law, restitution, tolerance) for tolerance in FINENESS]
        label = f"{law.split('-')[0]}, e = {restitution:g}"
        for tolerance, (error, *rest) in zip(FINENESS, points, strict=True):
            steps = steps_per_impact(tolerance)
            rows.append((law, restitution, f"{tolerance:g}", steps, error, *rest))
        errors = [p[0] for p in points]
        curves.append(Curve(label, [steps_per_impact(t) for t in FINENESS], errors))
        timed.append(Curve(label, [1e3 * p[-1] for p in points], errors))
    columns = (
        "law", "restitution", "local error", "steps per impact", "error of restitution [-]",
        "energy gained [-]", "steps", "time [s]",
    )  # fmt: skip
    title = "One impact: error against steps"
    axis = "error of restitution [-]"
    pictures = [Picture("steps per impact", axis, curves), Picture("time [ms]", axis, timed)]
    note = (
        f"each the worst of {len(SPEEDS)} impacts, with speeds up to 10 % apart; {_orders(curves)}"
    )
    return Result("impacts_single", title, columns, rows, [note], pictures)


def _worst(law: str, restitution: float, tolerance: float) -> tuple[float, float, int, float]:
    """Error of the restitution, energy gained, steps, time [s] of a flight."""
    paths = [single(law, restitution, speed, tolerance) for speed in SPEEDS]
    errors = [
        abs(-path.v[-1, 0] / speed - restitution) for path, speed in zip(paths, SPEEDS, strict=True)
    ]
    return (
        float(max(errors)), max(path.gained for path in paths), max(p.steps for p in paths),
        float(np.median([p.seconds for p in paths])),
    )  # fmt: skip


def _orders(curves: list[Curve]) -> str:
    orders = [-np.polyfit(np.log(c.x[2:]), np.log(c.y[2:]), 1)[0] for c in curves]
    return f"errors fall with the power {min(orders):.1f} to {max(orders):.1f} of the steps"
