"""Stability over the rate of temperature: a beam that closes the play of its hinge by expanding,
and a bar that is cooled from its end by every solver.

Schemes of heat and step lengths after a jump: ``thermobody report heat shock``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from coupling.reports.heat_shock import COLD, HOT, KINDS, Kind
from coupling.reports.maps import DONE, GROWS, REFUSED, WRONG, Map, Spot, counted, largest, reasons
from coupling.reports.registry import Curve, Result, Row
from coupling.reports.travel import travel
from coupling.verify.contact import joint
from coupling.verify.models import ROOM, Model, clamp, elastic, model, sections, straight
from mechanics.description import Joint, NormalContact
from mechanics.dynamics import Control
from mechanics.march import DISSIPATIVE, ELASTIC
from meshes.sections import rectangle
from thermal import solvers
from thermal.description import Description, Fixed, Place, Settings, Solid

Array = NDArray[np.float64]
X = np.eye(3)[0]

RATES = tuple(10.0**e for e in range(-2, 5))  # [K/s]
GAPS = tuple(10.0**e for e in np.arange(-6.0, -2.9, 0.5))
"""Play of the hinge [m]; the widest stay open."""
LENGTH, SIDE, ELEMENTS = 0.2, 0.01, 4
E, NU, DENSITY, ALPHA = 70e9, 0.0, 2700.0, 23.1e-6
WARMED = 20.0  # [K]
CONTACT, RESTITUTION, DAMPING = 1e8, 0.5, 1e-5  # [N/m], [-], [s]
STAKE = 0.5 * E * SIDE**2 * LENGTH * (ALPHA * WARMED) ** 2
"""Energy that the same bar would store between rigid walls [J]."""
RIGHT, NO_GAIN = 2e-2, 1e-4
"""Error that counts as right, of the force between walls; energy gained that counts as none [-]."""

WINDOWS = tuple(10.0**e for e in range(-3, 3))  # [s]
COUNT = 20
SOLVERS = ("line", "wall, tube", "lumped", "solid", "hermite")
LEFT = 1e-2
"""How far temperatures may leave their range [% of the cooling]: the local error allowed is 1 mK
of 250 K in each step."""


def report() -> Iterator[Result]:
    """Motion, then heat."""
    yield warmed()
    yield cooled()


# ---------------------------------------------------------------------------------------- motion


def warmed(rates: Sequence[float] = RATES, gaps: Sequence[float] = GAPS) -> Result:
    """Over rates and play; without a hinge as well."""
    rows, maps = list[Row](), list[Map]()
    notes = [
        f"cantilever of {LENGTH:g} m, {1e3 * SIDE:g} mm square, warmed by {WARMED:g} K: its end "
        f"goes {1e6 * ALPHA * WARMED * LENGTH:.3g} um and is stopped by the bore of its hinge",
        f"wrong: force off by more than {RIGHT:g} of that between rigid walls, or the end by as "
        f"much of its way, and what waves of its speed make besides; grows: more than {NO_GAIN:g} "
        "gained of the energy that rigid walls would make it store",
    ]
    for name, places in {"hinge with play": gaps, "free end": (0.0,)}.items():
        spots = [warmed_spot(R, c) for R, c in product(rates, places)]
        rows.append((name, len(spots), *counted(spots).values(), largest(spots)))
        notes += [f"{name}: {text}" for text in reasons(spots)]
        if len(places) > 1:
            maps.append(_map(name, spots))
    columns = ("motion", "runs", *counted([]), "energy gained [-]")
    return Result("stability_heating", "Beam in a hinge with play: rate of heating and clearance",
                  columns, rows, notes, maps)  # fmt: skip


def _map(name: str, spots: Sequence[Spot]) -> Map:
    way, rates = ALPHA * WARMED * LENGTH, np.array(RATES)
    curve = Curve("above: never touches", rates, np.full(rates.size, way), "--")
    return Map(name, "rate [K/s]", "clearance [m]", "energy gained [-]", spots, [curve],
               limits=(1e-12, NO_GAIN))  # fmt: skip


def beam(clearance: float) -> Model:
    """Clamped at one end, the other in a bore; 0: free."""
    bar = straight(LENGTH, ELEMENTS, rectangle(SIDE, SIDE), elastic(E, NU, DENSITY, ALPHA))
    joints: list[Joint] = [clamp()]
    if clearance > 0.0:
        contact = NormalContact("linear", CONTACT, restitution=RESTITUTION)
        hinge = joint(contact, clearance, body="beam", bearing=LENGTH * X)
        joints.append(replace(hinge, journal=replace(hinge.journal, node=ELEMENTS)))
    return model(replace(bar, damping_time=DAMPING), joints)


def warmed_spot(rate: float, clearance: float) -> Spot:
    """Warmed at ``rate`` [K/s]: the force in the end, or where its end is, against rest."""
    made, end = beam(clearance), WARMED / rate
    hot = made.system.coefficients(sections(made.system, ROOM + WARMED))
    path = travel(made, end, Control(1e-6, 0.02 * end, 1e-15), hot)
    gained = max(path.excess, 0.0) / STAKE
    if path.why:
        return Spot(rate, clearance, REFUSED, gained, path.why)
    way = ALPHA * WARMED * LENGTH
    if 0.0 < clearance < way:
        delivered = float(path.response[-1, 0, [ELASTIC, DISSIPATIVE]].sum())
        expected, unit = force(clearance), force(0.0)
    else:
        delivered = float(made.position(path.q[-1], "beam", ELEMENTS)[0]) - LENGTH
        expected = unit = way
    error = abs(delivered - expected) / unit
    outcome = (
        WRONG if not error <= RIGHT + waves(rate) else GROWS if not gained <= NO_GAIN else DONE
    )
    return Spot(rate, clearance, outcome, gained)


def waves(rate: float) -> float:
    """Speed of the end over that of sound, in strains of the bar between walls [-]."""
    return rate * LENGTH * float(np.sqrt(DENSITY / E)) / WARMED


def force(clearance: float) -> float:
    """Between clamp and bore at rest [N]: stiffnesses of bar and contact in a row."""
    bar = E * SIDE**2 / LENGTH
    return (ALPHA * WARMED * LENGTH - clearance) / (1.0 / bar + 1.0 / CONTACT)


# ------------------------------------------------------------------------------------------ heat


def cooled(
    names: Sequence[str] = SOLVERS,
    rates: Sequence[float] = RATES,
    windows: Sequence[float] = WINDOWS,
) -> Result:
    """A bar whose end is cooled, over rates and windows, by solvers as they are by default."""
    rows, maps = list[Row](), list[Map]()
    notes = [
        f"one end falls by {HOT - COLD:g} K at the rate, {COUNT} windows; how far temperatures "
        "leave the range of start and boundary",
        f"wrong: by more than {LEFT:g} % of the {HOT - COLD:g} K; hermite is cubic, and swings "
        "beside steep ends",
        "schemes and single steps: thermobody report heat shock",
    ]
    for name in names:
        spots = [cooled_spot(name, R, h) for R, h in product(rates, windows)]
        rows.append((name, len(spots), *counted(spots).values(), largest(spots)))
        notes += [f"{name}: {text}" for text in reasons(spots)]
        maps.append(Map(name, "rate [K/s]", "window [s]", "range left by [%]", spots,
                        limits=(1e-9, LEFT)))  # fmt: skip
    columns = ("solver", "runs", *counted([]), "range left by [%]")
    return Result("stability_cooling", "Bar cooled from its end: rate and window", columns, rows,
                  notes, maps)  # fmt: skip


def cooled_spot(name: str, rate: float, h: float) -> Spot:
    """How far temperatures leave the range of start and boundary [%]."""
    solver = _cooled(KINDS[name], rate)
    T, beyond = solver.initial(), 0.0
    nodes = np.concatenate(list(solver.regions.values()))
    for k in range(COUNT):
        T, _, why = solver.advance(T, k * h, h, np.zeros_like(T))
        if why:
            return Spot(rate, h, REFUSED, why=why)
        coldest = max(COLD, HOT - rate * (k + 1) * h)
        beyond = max(beyond, coldest - float(T[nodes].min()), float(T[nodes].max()) - HOT)
    left = 100.0 * beyond / (HOT - COLD)
    return Spot(rate, h, DONE if left <= LEFT else WRONG, left)


def _cooled(kind: Kind, rate: float):
    thing = kind.made()
    face = (Fixed("face", Place(thing.name, "start"), lambda t: max(COLD, HOT - rate * t)),)
    if isinstance(thing, Solid):
        told = Description(solids=(thing,), conditions=face)
    else:
        told = Description((thing,), conditions=face)
    return solvers.build(kind.solver, told, Settings(**kind.settings))
