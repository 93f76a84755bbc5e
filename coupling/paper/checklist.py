"""The components that the paper names, each with what shows that it works.

A component is shown by problems of ``thermobody verify``, which compare with answers that are known
otherwise, or by entries of the report, which run the cases of the paper.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from coupling.paper.entries import Section, number
from coupling.paper.workshop import Workshop

COMPONENTS: dict[int, tuple[str, tuple[str, ...]]] = {
    1: (
        "ANCF cable, curved reference",
        ("elastica, cable, 32 elements", "hanging cable, 16 elements"),
    ),
    2: (
        "ANCF beam with torsion and shear, free of locking",
        (
            "shear-deformable cantilever, small and large load",
            "cantilever under combined moments",
            "Princeton beam",
        ),
    ),
    3: (
        "curved reference configuration",
        ("45° bend out of its plane", "quarter circle, R/h = 50, load along its end"),
    ),
    4: (
        "thick shell of four nodes, 12 coordinates each",
        ("pull-out of an open cylinder, shell3443",),
    ),
    5: ("rigid body", ("free rigid body", "heavy top")),
    6: ("hinge connection element", ()),
    7: ("hand-over between configurations without a switch", ()),
    8: ("spherical joint", ("pendulum as point mass, hinged body, body on a ball",)),
    9: ("revolute joint", ("double pendulum from horizontal", "Andrews' squeezer")),
    10: ("cylindrical joint", ()),
    11: (
        "translational joint, beam in beam",
        ("telescoping arm in its sleeve", "tube in a tube, loaded at its tip"),
    ),
    12: ("rotational coupling", ("gear with a motor",)),
    13: ("pulley and rope", ()),
    14: ("lock mechanism", ()),
    15: (
        "drives by motion and by torque",
        ("ideal slider-crank at 5000 rpm", "spin-up of a flexible beam"),
    ),
    16: ("preload", ()),
    17: ("gap of a planar revolute", ("journal between walls",)),
    18: ("clearance of a spherical joint", ("spinning ball hits its socket",)),
    19: (
        "clearance of a slider, and of a tube in a tube",
        ("slider-crank with a loose slider", "tube in a tube, loaded at its tip"),
    ),
    20: ("Hertz stiffness", ("Hertz impact of a steel ball",)),
    21: (
        "restitution: six laws",
        ("restitution, each law at 1 mm/s to 10 m/s", "fixed reference speed 0.1 m/s"),
    ),
    22: ("rigid restitution, momentum", ("bouncing ball until it rests",)),
    23: ("linear contact stiffness", ("peak force over clearance, F ∝ c^p",)),
    24: ("cylinder law", ("pin in a conforming bore",)),
    25: ("free flight, contact, slip and stick told apart", ("mass on a belt",)),
    26: ("analytic tangents of contact", ("energy over fifty and more impacts",)),
    27: ("clearance that changes with temperature", ("seizure of a heated pin",)),
    28: ("regularised Coulomb", ("sliding block", "block on an incline")),
    29: ("true stick", ("mass on a belt", "LuGre friction, stick and slip")),
    30: ("friction over temperature", ()),
    31: ("static friction that rises while it sticks", ("static friction that grows",)),
    32: ("friction heat and its partition", ("heat of friction", "frictional heat of two slabs")),
    33: (
        "transient conduction in 3D, k(T), c(T)",
        ("NAFEMS T3, transient conduction", "solids, order in space and time"),
    ),
    34: ("solar flux", ("sunlit radiating tube",)),
    35: ("radiation", ("NAFEMS T2, radiating end", "1 mm aluminium plate radiates")),
    36: ("heat source of friction", ("two aluminium slabs heated between them",)),
    37: ("prescribed ramps of 15 and 25 K/s", ("shocks without undershoot",)),
    38: (
        "gradients",
        ("free bow of the 65.5 m boom", "bow to a quarter of a circle by a temperature gradient"),
    ),
    39: ("uniform rises by 55, 105, 155 K", ("force between two clamps",)),
    40: (
        "entry into shadow and out of it",
        ("umbra and penumbra of a tube", "a tube flies into the shadow"),
    ),
    41: (
        "one-dimensional closed forms",
        ("steady bar, order in space", "semi-infinite aluminium, step"),
    ),
    42: ("six laws of Table 1", ()),
    43: (
        "physical material (NIST)",
        ("free expansion at −200 °C", "frequency against temperature"),
    ),
    44: (
        "thermal strain, moments and stress in 1D, 2D, 3D",
        ("thermal bow of a tube", "free bow, heated by 50 K and 2000 K/m"),
    ),
    45: ("HHT, alpha = -0.1", ("orders of the schemes in index 3",)),
    46: ("Newton with a consistent tangent", ()),
    47: ("index-3 multipliers", ("orders of the schemes in index 3",)),
    48: ("Baumgarte, as an option", ()),
    49: ("adaptive steps", ("cantilever released, energy ledger closes",)),
    50: (
        "staggered exchange, with iteration",
        ("order of the coupling in the window", "order in the window, contact and friction"),
    ),
    51: ("one-sided contact by penalty", ("ball on a plane",)),
    52: ("Rayleigh and Kelvin-Voigt damping", ("a swinging bar is damped",)),
    53: ("energy balance", ("balances of a small arm, corrected", "heat balance")),
    54: ("spectral radius at infinity", ("spectral radius of HHT at infinity",)),
    55: ("level I: Hertz and thermoelastic joint", ()),
    56: ("level II: mast under thermal cycling", ()),
    57: ("level III: 3D continuum", ()),
    58: ("level IV: mesh", ()),
    59: ("degeneration: no heat, no clearance", ()),
    60: ("thermal hinges", ()),
    61: ("slider-crank with clearance", ("slider-crank with a loose pin, e = 0.9, one turn",)),
    62: ("mast, 600 s of heating and 600 s of cooling", ()),
    63: ("Configuration 1", ()),
    64: ("Configuration 2", ()),
    65: ("Configuration 3", ()),
    66: ("Table 7", ()),
    67: ("Fig. 22", ()),
    68: ("Fig. 23", ()),
    69: ("Table 8", ()),
    70: ("Fig. 24", ()),
    71: ("Fig. 25", ()),
    72: ("Fig. 26", ()),
    73: ("Fig. 27", ()),
    74: ("Fig. 28", ()),
    75: ("Fig. 29", ()),
    76: ("Fig. 30", ()),
    77: ("interactions named as future work", ()),
    78: ("comparison with a floating frame", ()),
    79: ("uniform against non-uniform field", ()),
    80: (
        "heat of the orbit: Sun, albedo, planet",
        ("albedo in a low orbit", "infrared of a planet on a plate", "sunlit tube in a low orbit"),
    ),
}
"""Number, name, and problems of ``thermobody verify``, of each component."""


class Row(NamedTuple):
    """A component: whether it works, and what shows that, with a number."""

    number: int
    text: str
    works: bool
    shown: str


class _Shown(NamedTuple):
    good: bool
    text: str


def rows(work: Workshop, sections: Sequence[Section]) -> list[Row]:
    """Every component with what shows it: solved problems, and entries of the sections."""
    made = []
    for index, (text, problems) in COMPONENTS.items():
        shown = [_solved(work, name) for name in problems]
        shown += [_told(entry) for s in sections for entry in s.entries if index in entry.rows]
        works = bool(shown) and all(one.good for one in shown)
        made.append(Row(index, text, works, "; ".join(one.text for one in shown) or "nothing yet"))
    return made


def _told(entry: Any) -> _Shown:
    return _Shown(True, f"{entry.place}: {entry.corrected or entry.inputs}")


def _solved(work: Workshop, name: str) -> _Shown:
    found = work.once(f"verify {name}", ("verify", name), lambda: _summed_up(work, name))
    return _Shown(found["good"], f"{name}: {found['text']}")


def _summed_up(work: Workshop, name: str) -> dict[str, Any]:
    """The worst of the results of a problem, in words."""
    results = work.verified(name)
    worst = max(results, key=_margin)
    return {"good": all(result.passed for result in results), "text": _said(worst)}


def _margin(result: Any) -> float:
    """How much of its tolerance a result takes."""
    if hasattr(result, "order"):
        return abs(result.order - result.theory) / result.tolerance
    error = max(result.errors) if hasattr(result, "errors") else result.error
    return error / result.tolerance if result.tolerance else float(error > 0.0)


def _said(result: Any) -> str:
    if hasattr(result, "order"):
        return f"{result.name}: order {result.order:.2f}, theory {result.theory:g}"
    if hasattr(result, "errors"):
        return f"{result.name}: errors up to {number(max(result.errors), '', 2)}"
    size = "" if result.absolute else " of it"
    unit = f" {result.unit}" if result.unit else ""
    return (f"{result.name} {number(result.value)}{unit} for {number(result.reference)}{unit}, "
            f"error {number(result.error, '', 2)}{size}")  # fmt: skip
