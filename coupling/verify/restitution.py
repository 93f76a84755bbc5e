"""Restitution that each law of dissipation delivers in an impact of the solver."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from coupling.verify.contact import STIFFNESS, impact
from coupling.verify.registry import Check, Grid, Result, problem
from mechanics.contact import DISSIPATION
from mechanics.description import NormalContact

Array = NDArray[np.float64]

REQUESTED = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.85, 0.9, 0.95, 0.99)
SPEEDS = (1e-3, 1e-2, 0.1, 1.0, 10.0)  # [m/s]
FACTORS = {
    "hua2026": lambda e: 1.5 * (1.0 - e**2) / e,
    "hunt-crossley": lambda e: 1.5 * (1.0 - e),
    "lankarani-nikravesh": lambda e: 0.75 * (1.0 - e**2),
    "gonthier": lambda e: (1.0 - e**2) / e,
    "flores": lambda e: 8.0 * (1.0 - e) / (5.0 * e),
    "hu-guo": lambda e: 1.5 * (1.0 - e) / e,
}
"""D [-] as published; that of "exact" is whatever delivers e."""
HEADINGS = tuple(f"e={e:g}" for e in REQUESTED)
RELATION = "D(1+e) = ln((1+D)/(1-De))"


@problem("contact", "Hertz impact of a steel ball", "Johnson 1985, sec. 11.4: R = 10 mm, 1 m/s")
def hertz_impact() -> list[Check]:
    found = impact(0.032673, 1.0, NormalContact(value=1.53846e10, restitution=1.0))
    return [
        Check("largest penetration", found.penetration, 2.342085e-5, 5e-3, "m"),
        Check("largest force", found.force, 1743.776, 5e-3, "N"),
        Check("duration", found.duration, 6.8934e-5, 5e-3, "s"),
        Check("restitution", found.restitution, 1.0, 2e-3),
    ]


def relation(factor: float) -> float:
    """Restitution that a factor D delivers: D (1 + e) = ln((1 + D)/(1 - D e)).

    Solved for z = -ln(1 - D e), since 1 - D e may be as small as exp(-D).
    """
    if factor < 1e-6:
        return 1.0 - 2.0 * factor / 3.0
    z = brentq(
        lambda z: factor - np.expm1(-z) - np.log1p(factor) - z, 1e-3 * factor, 4.0 + 2.0 * factor,
        xtol=1e-14,
    )  # fmt: skip
    return -np.expm1(-z) / factor


def _delivered(law: NormalContact, speed: float, expected: float) -> tuple[float, float]:
    """Rebound over approach speed, and the least force [N]."""
    found = impact(0.01, speed, law, 1.0 + 0.15 / expected)
    return found.restitution, found.pull


def _worst(values: Array, references: Array) -> Array:
    """Of each row the value that is farthest from its reference."""
    return values[np.arange(len(values)), np.abs(values - references[:, None]).argmax(axis=1)]


@problem("contact", "restitution, each law at 1 mm/s to 10 m/s", RELATION)
def delivered() -> list[Result]:
    """Delivered against requested restitution; of the five speeds, what is farthest from it."""
    rows, values, references, pull = [], [], [], 0.0
    assert set(FACTORS) | {"exact"} == set(DISSIPATION)
    for name in DISSIPATION:
        wanted = np.array([relation(FACTORS[name](e)) if name in FACTORS else e for e in REQUESTED])
        found = np.empty((len(REQUESTED), len(SPEEDS), 2))
        for i, e in enumerate(REQUESTED):
            law = NormalContact(value=STIFFNESS, dissipation=name, restitution=e)
            for j, speed in enumerate(SPEEDS):
                found[i, j] = _delivered(law, speed, wanted[i])
        rows.append(name)
        values.append(_worst(found[..., 0], wanted))
        references.append(wanted)
        pull = min(pull, found[..., 1].min())
    return [
        Grid("delivered, requested", HEADINGS, rows, values, references, 2e-3),
        Check("least force", pull, 0.0, 0.0, "N", True),
    ]


@problem("contact", "fixed reference speed 0.1 m/s", f"Hua et al. 2026; {RELATION}, D v/(0.1 m/s)")
def reference_speed() -> list[Result]:
    """The force is never attractive here, the printed one is above 0.204 m/s of separation.

    That changes nothing: 1/D times 0.1 m/s = 0.204 m/s is a speed at which the force vanishes,
    so that an impact approaches it but never exceeds it while separating.
    """
    values, references = np.empty((2, len(SPEEDS), len(REQUESTED)))
    pull = 0.0
    for j, e in enumerate(REQUESTED):
        law = NormalContact(
            value=STIFFNESS, dissipation="hua2026", restitution=e, reference_speed=0.1
        )
        for i, speed in enumerate(SPEEDS):
            references[i, j] = relation(FACTORS["hua2026"](e) * speed / 0.1)
            values[i, j], least = _delivered(law, speed, references[i, j])
            pull = min(pull, least)
    return [
        Grid("delivered, requested", HEADINGS, [f"{v:g} m/s" for v in SPEEDS], values.tolist(),
             references.tolist(), 2e-3),
        Check("least force", pull, 0.0, 0.0, "N", True),
    ]  # fmt: skip
