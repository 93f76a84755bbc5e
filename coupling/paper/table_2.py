"""Table 2 and Sec. 3: numbers of the method."""

from collections.abc import Iterator
from math import pi

import numpy as np
from scipy.optimize import brentq

from coupling.paper.entries import Entry, number, numbers
from coupling.paper.workshop import Workshop
from coupling.verify.restitution import FACTORS, relation
from mechanics.contact import exact_factor

RESTITUTION, REFERENCE_SPEED = 0.85, 0.1
"""Table 2: [-], [m/s]."""
MASS_FACTOR, STIFFNESS_FACTOR, DAMPING = 0.12, 1.5e-4, 0.005
"""Table 2: Rayleigh's factors [1/s, s], the damping ratio that they are to give [-]."""
REGULARISATION = 1e-4
"""Table 2: speed of the regularised friction [m/s]."""
RADIUS, CLEARANCE = 10e-3, 0.1e-3
"""Of a pin, of its bore [m], for the radius of contact."""


def entries(work: Workshop) -> Iterator[Entry]:
    """Integrator, constraints, contact, friction, damping."""
    yield _spectral_radius(work)
    yield from _orders(work)
    yield _restitution(work)
    yield _reference_speed()
    yield _contact_radius()
    yield _elastic_impact(work)
    yield _damping()
    yield _tolerance()
    yield _steps()


def _spectral_radius(work: Workshop) -> Entry:
    found = [value for _, value, *_ in work.checks("spectral radius of HHT at infinity")]
    return Entry(
        "Table 2, Sec. 3.5",
        "spectral radius at high frequencies, alpha = -0.1",
        "0.818 in Table 2, |alpha| = 0.1 in Sec. 3.5",
        f"{found[0]:.4f} observed, (1 + alpha)/(1 - alpha) = {0.9 / 1.1:.4f}",
        f"{found[0]:.4f}; at alpha = -1/3 {found[1]:.4f}",
        "reproduced in Table 2; Sec. 3.5 contradicts it",
        (45, 54),
    )


def _orders(work: Workshop) -> Iterator[Entry]:
    found = work.orders("orders of the schemes in index 3")
    shown = ", ".join(f"{name} {order:.2f}" for name, order, _ in found)
    yield Entry(
        "Sec. 3.2.4, 3.4",
        "constraints and order of the integrator",
        "multipliers and Baumgarte's stabilisation in one system, O(dt^2) throughout",
        f"order in index 3: {shown}",
        "index 3 is the default and keeps positions to round-off; Baumgarte is an option of its "
        "own; friction heat and impacts are of first order locally",
        "reproduced for smooth motion; both at once is redundant, and no scheme is of second "
        "order through an impact",
        (45, 47, 48),
    )


def _restitution(work: Workshop) -> Entry:
    rows = work.once("restitution by law", ("restitution",), lambda: _grid(work))
    at = rows["columns"].index(f"e={RESTITUTION:g}")
    delivered = {name: row[at] for name, row in rows["rows"].items()}
    shown = ", ".join(f"{name} {value:.3f}" for name, value in delivered.items())
    formula = relation(FACTORS["hua2026"](RESTITUTION))
    return Entry(
        "Sec. 2.3.3",
        f"restitution that the damping factor 3(1 - e^2)/(2e) delivers at e = {RESTITUTION:g}",
        f"{RESTITUTION:g}",
        f"{delivered['hua2026']:.3f} in impacts computed here, {formula:.3f} by the energy "
        "balance of the law",
        f"{delivered['exact']:.3f} by the exact factor {exact_factor(RESTITUTION):.4f}; {shown}",
        "does not follow: the law loses more; that of Lankarani & Nikravesh, which is cited, has "
        "3(1 - e^2)/4",
        (21,),
    )


def _grid(work: Workshop) -> dict:
    grid = work.verified("restitution, each law at 1 mm/s to 10 m/s")[0]
    values = np.asarray(grid.values).tolist()
    return {"columns": list(grid.columns), "rows": dict(zip(grid.rows, values, strict=True))}


def _reference_speed() -> Entry:
    factor = FACTORS["hua2026"](RESTITUTION)
    speeds = (1e-3, 1e-2, 0.1, 0.5, 1.0)
    found = [relation(factor * speed / REFERENCE_SPEED) for speed in speeds]
    return Entry(
        "Table 2",
        "fixed reference speed of 0.1 m/s",
        "one number for all impacts",
        f"restitution {numbers(found, digits=3)} at {numbers(speeds, 'm/s', 3)}; a force that "
        f"would pull above {REFERENCE_SPEED / factor:.3f} m/s of separation",
        "0.850 at every speed, with the approach speed of each impact",
        "does not follow: with a fixed speed the restitution depends on the speed",
        (21,),
    )


def _contact_radius() -> Entry:
    outer = RADIUS + CLEARANCE
    external, internal = RADIUS * outer / (RADIUS + outer), RADIUS * outer / CLEARANCE
    ratio = np.sqrt(internal / external)
    return Entry(
        "Sec. 2.3.3",
        "radius of contact of a pin in its bore, R = 10 mm, c = 0.1 mm",
        "R1 R2/(R1 + R2)",
        number(1e3 * external, "mm") + ": two balls side by side",
        f"R1 R2/(R2 - R1) = {number(1e3 * internal, 'mm')}, a stiffness {ratio:.1f} times as "
        "large; a conforming pin has the cylinder law",
        "does not follow for a joint; both are laws here: hertz-external, hertz-internal",
        (20, 24),
    )


def _elastic_impact(work: Workshop) -> Entry:
    checks = work.checks("Hertz impact of a steel ball")
    printed = (15 / 16) / (5 / 4)
    depth, force = checks[0][1:], checks[1][1:]
    return Entry(
        "Sec. 2.3.3",
        "largest penetration and force of an elastic impact",
        "(15/16 m v^2/K)^(2/5), K^(2/5)(15/16 m v^2)^(3/5)",
        f"{printed**0.4:.3f} and {printed**0.6:.3f} times what its law gives: it stores "
        f"{100 * printed:.0f} % of the kinetic energy",
        f"5/4 in the place of 15/16: penetration {number(depth[0], 'm')} ({number(depth[1], 'm')} "
        f"by Hertz), force {number(force[0], 'N')} ({number(force[1], 'N')}), steel ball at 1 m/s",
        "does not follow: 15/16 belongs to a stiffness without its 4/3",
        (20, 22),
    )


def _damping() -> Entry:
    def ratio(w: float) -> float:
        return 0.5 * (MASS_FACTOR / w + STIFFNESS_FACTOR * w)

    least = np.sqrt(MASS_FACTOR / STIFFNESS_FACTOR)
    low = brentq(lambda w: ratio(w) - DAMPING, 1e-3 * least, least)
    high = brentq(lambda w: ratio(w) - DAMPING, least, 1e3 * least)
    others = {f: 100 * ratio(2 * pi * f) for f in (0.127, 1.6, 16.8)}
    shown = ", ".join(f"{value:.2f} % at {f:g} Hz" for f, value in others.items())
    return Entry(
        "Table 2",
        "Rayleigh damping: 0.12 1/s and 1.5e-4 s are 0.5 % in modes 1 and 2",
        "0.5 %",
        f"0.5 % at {low / (2 * pi):.3f} and {high / (2 * pi):.3f} Hz; {shown}, the first "
        "frequencies that the paper uses elsewhere; rigid motion decays in "
        f"{1 / MASS_FACTOR:.1f} s",
        "Kelvin-Voigt damping of strain rates, which leaves rigid motion alone; Rayleigh's is an "
        "option",
        "not determined: no structure with these two frequencies is described",
        (52,),
    )  # fmt: skip


def _tolerance() -> Entry:
    EA, length, piece = 2.341e8, 65.5, 0.1
    force = EA * np.finfo(float).eps * length / piece
    return Entry(
        "Table 2",
        "force residual of 1e-6 N",
        "1e-6 N",
        f"round-off alone leaves {number(force, 'N', 2)}: EA = {EA:.3g} N, coordinates of "
        f"{length:g} m, elements of {piece:g} m",
        "corrections relative to the size of the bodies, and the error of each step",
        "does not follow: it cannot be reached with these sizes",
        (46, 49),
    )


def _steps() -> Entry:
    stiffness, mass, speed = 5e10, 1.0, 0.06
    lasts = 3.21807 * (mass**2 / (stiffness**2 * speed)) ** 0.2
    return Entry(
        "Table 2",
        "steps between 1e-7 and 5e-4 s, times 1.2 or 0.5",
        "by the convergence of Newton's iteration",
        f"an impact on K = {stiffness:.0e} N/m^1.5 of 1 kg at {speed:g} m/s lasts "
        f"{number(lasts, 's', 2)}: steps of 1e-4 s pass over it and converge",
        "steps by their local error, with events where contacts open and close",
        "does not follow: convergence says nothing of the error of a step",
        (49,),
    )
