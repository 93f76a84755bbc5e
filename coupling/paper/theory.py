"""Sec. 2: formulas that are printed, against what they should do."""

from collections.abc import Iterator
from math import cos, radians, sqrt

import numpy as np

from coupling.paper.entries import Entry, number, numbers
from coupling.paper.workshop import Workshop
from coupling.verify.models import bent, clamp, elastic, model, sections, straight
from mechanics.contact import (
    friction_force,
    heat_shares,
    rigid_impact,
    rising_coefficient,
    thermal_clearance,
)
from mechanics.description import Friction
from meshes.materials import library_material
from meshes.sections import tube

TURN = 45.4
"""Of Configuration 2 [deg]."""
MODULUS = 69e9
"""Table 1 [Pa]."""
ROOM = 298.15
"""Reference temperature of the paper [K]."""
DRIFT, REGULARISATION = 2e-6, 1e-4
"""Slip speed that heat drives in the mast, and that of the regularised law (Table 2) [m/s]."""


def entries(work: Workshop) -> Iterator[Entry]:
    """Elements, strains, heat, contact and friction."""
    yield _coordinates()
    yield _joints()
    yield _objectivity()
    yield _moments()
    yield _interpolation(work)
    yield _momentum()
    yield _partition()
    yield _own_clearance()
    yield _seizure(work)
    yield _creep()
    yield _rising()
    yield _back_coupling(work)


def _coordinates() -> Entry:
    made = model(straight(1.0, 1, tube(0.1, 0.002), elastic(MODULUS)))
    return Entry(
        "Sec. 2.1.1",
        "coordinates of a beam element and its shape functions",
        "12 per node, 24 per element, interpolated by 4 cubic Hermite functions",
        "4 functions are those of r and r_x: 12 per element, a cable without shear and torsion; "
        "the printed mass matrix of 12 x 12 is that of the cable",
        f"beam3243 with {made.system.n} per element and 8 functions; the cable with 12 is "
        "an element of its own",
        "does not follow: four functions cannot multiply 24 coordinates",
        (1, 2),
    )


def _joints() -> Entry:
    return Entry(
        "Sec. 2.1.1",
        "what a cylindrical joint leaves free",
        "one rotation",
        "collinearity of two axes leaves one rotation and one travel",
        "spherical 3, cylindrical 4, revolute 5, prismatic 5 equations; see thermobody list",
        "does not follow: wording",
        (8, 9, 10, 11),
    )


def _objectivity() -> Entry:
    beam = model(straight(65.5, 4, tube(0.27, 0.002), elastic(MODULUS, 0.33, 2700.0)))
    q = beam.system.layout.q0.reshape(-1, 3)
    a = radians(TURN)
    turn = np.array([[cos(a), -np.sin(a), 0.0], [np.sin(a), cos(a), 0.0], [0.0, 0.0, 1.0]])
    y = beam.system.unknowns((q @ turn.T).ravel())
    energy = beam.system.energies(y, np.zeros_like(y), beam.coef)[0]
    strain = cos(a) - 1.0
    spurious = 0.5 * MODULUS * 3.393e-3 * 65.5 * strain**2
    return Entry(
        "Sec. 2.3.4",
        f"strain of a boom turned by {TURN:g} deg without deformation",
        "B e, with u = S e: geometric errors are eliminated",
        f"{100 * strain:.1f} %, {1e-9 * MODULUS * strain:.1f} GPa, {spurious:.2g} J",
        f"{energy:.1g} J of strain energy here",
        "does not follow: a strain that is linear in fixed axes feels rotations",
        (2, 7),
    )


def _moments() -> Entry:
    made = model(
        straight(65.5, 4, tube(0.27, 0.002), elastic(MODULUS, 0.33, 2700.0, 23.1e-6)), [clamp()]
    )
    hot = made.system.coefficients(sections(made.system, along_2=50.0))
    w = made.position(bent(made, 5, hot).q, "beam", -1)
    closed = (1.0 - cos(23.1e-6 * 50.0 * 65.5)) / (23.1e-6 * 50.0)
    return Entry(
        "Sec. 2.3.4",
        "thermal strain of axial and bending strains",
        "alpha dT in all three",
        "alpha dT of a curvature has the wrong unit",
        f"alpha dT0, alpha dT/dy, alpha dT/dz: bow of {abs(w[1]):.5f} m, {closed:.5f} m by the "
        "closed form",
        "does not follow: curvatures come from gradients",
        (38, 44),
    )


def _interpolation(work: Workshop) -> Entry:
    orders = work.orders("bar, order in space and time")
    shown = ", ".join(f"{name} {order:.2f}" for name, order, _ in orders)
    return Entry(
        "Sec. 2.1.1",
        "temperature by the shape functions of the beam",
        "one interpolation, no mismatch of meshes",
        "solver hermite does it: cubics overshoot at fronts",
        "heat on meshes of its own, mean and gradients handed over conservatively; orders: "
        f"{shown}",
        "reproduced as an option; not needed for consistency",
        (33, 41),
    )  # fmt: skip


def _momentum() -> Entry:
    found = [float(value) for value in rigid_impact(2.0, 1.0, 3.0, -1.0, 0.6)]
    return Entry(
        "Sec. 2.3.3",
        "speeds after a rigid impact, 2 and 1 kg, 3 and -1 m/s, e = 0.6",
        "formulas",
        f"{numbers(found[:2], 'm/s')}, loss {number(found[2], 'J')}",
        "the same: momentum and restitution hold",
        "reproduced",
        (22,),
    )


def _partition() -> Entry:
    metals = [library_material("al6061"), library_material("steel-304")]
    shares = {
        how: heat_shares(Friction(0.1, partition=how), metals, (ROOM, ROOM))[0]
        for how in ("product", "effusivity")
    }
    return Entry(
        "Sec. 2.3.3",
        "share of frictional heat of aluminium on steel",
        "k rho c over the sum (roots, if there were any, are lost)",
        f"{shares['product']:.3f}",
        f"{shares['effusivity']:.3f} by effusivity sqrt(k rho c), which gives both faces the same "
        "temperature",
        "not determined: with roots it is right",
        (32, 36),
    )


def _own_clearance() -> Entry:
    rise, radius, gap = 175.0, 10e-3, 0.1e-3
    alu, steel = library_material("al6061-paper"), library_material("steel-304")
    strains = [float(m.expansion.integral(ROOM, ROOM + rise)) for m in (alu, steel)]
    same = thermal_clearance(gap, radius, strains[0], strains[0]) - gap
    other = thermal_clearance(gap, 25e-3, strains[1], strains[0]) - gap
    return Entry(
        "Sec. 2.3.3, 4.3.1",
        "change of a clearance of 0.1 mm by 175 K",
        "expansion maximises the clearance",
        f"{1e6 * same:.2f} um: pin and bore of one alloy",
        f"{1e6 * other:+.1f} um for a steel pin of 25 mm in aluminium; pin and bore have "
        "temperatures and materials of their own",
        "does not follow for one alloy at one temperature",
        (27,),
    )


def _seizure(work: Workshop) -> Entry:
    found = work.checks("seizure of a heated pin")
    name, value, reference, unit = found[0]
    return Entry(
        "Sec. 2.3.3",
        "a heated pin closes its clearance",
        "clearance changes with temperature",
        "",
        f"{name}: {number(value, unit, 6)}, c/(alpha R) = {number(reference, unit, 6)}",
        "trend reproduced, where pin and bore differ",
        (27,),
    )


def _creep() -> Entry:
    part = abs(float(friction_force(1.0, 1.0, DRIFT, REGULARISATION)))
    return Entry(
        "Eq. 19",
        "friction of the regularised law at the speed of thermal drift, 2e-6 m/s",
        "stick-slip",
        f"{100 * part:.1f} % of mu N: it creeps and never sticks",
        "bristles that stick truly up to mu_s N (law stick), or rise while they stick (rising)",
        "does not follow: the law of Sec. 2 has no stick; Sec. 4.1.4 uses another",
        (28, 29),
    )


def _rising() -> Entry:
    times = np.array([0.0, 1.365, 9.20, 27.7])
    found = np.asarray(rising_coefficient(times, 0.0623, 0.0859, 0.570, 0.629))
    shares = (found - 0.0623) / (0.0859 - 0.0623)
    return Entry(
        "Sec. 4.1.4",
        "static friction after sticking for 0, 1.365, 9.20, 27.7 s",
        "mu_s - (mu_s - mu_k) exp(-gamma tau^m)",
        f"{numbers(found)}; {numbers(100 * shares, '%', 3)} of the rise",
        "the same, with a clock in every contact that starts where it sticks",
        "reproduced",
        (31,),
    )


def _back_coupling(work: Workshop) -> Entry:
    found = work.checks("stretched metal cools")
    name, value, reference, unit = found[0]
    alloy = library_material("al6061")
    E, alpha = float(alloy.youngs_modulus(ROOM)), float(alloy.expansion(ROOM))
    zener = E * alpha**2 * ROOM / (alloy.density * float(alloy.heat_capacity(ROOM)))
    return Entry(
        "Sec. 2.3.4",
        "heat of deformation",
        "left out, without saying how much it is",
        f"E alpha^2 T/(rho c) = {zener:.4f}; damping up to {zener / 2:.4f} of it at one frequency",
        f"an option of the exchange; {name}: {number(value, unit)}, {number(reference, unit)} "
        f"by Kelvin's formula; waves are {100 * (sqrt(1 + zener) - 1):.2g} % faster adiabatically",
        "reproduced: negligible for the motion",
        (50,),
    )
