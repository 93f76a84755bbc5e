"""Table 1: laws of the material, against measured ones.

The signs of the printed coefficients are lost in some renderings; read as physics asks, E and the
density fall with temperature, the other properties rise (material ``al6061-paper``). Measured:
NIST for 73 K to 293 K (material ``al6061``).
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from coupling.paper.entries import Entry, away, number, numbers
from coupling.paper.workshop import Workshop
from meshes.materials import Material, library_material

Array = NDArray[np.float64]

PLACES = np.array([-200.0, 25.0, 200.0]) + 273.15
"""Ends of the range of the table and its reference temperature [K]."""
MEASURED = np.linspace(73.15, 293.15, 45)
"""Where the law is compared with measured values [K]."""
LAWS: dict[str, tuple[str, float]] = {
    "youngs_modulus": ("Young's modulus E [GPa]", 1e9),
    "conductivity": ("conductivity k [W/(m K)]", 1.0),
    "heat_capacity": ("heat capacity c [J/(kg K)]", 1.0),
    "expansion": ("expansion coefficient [1e-6/K]", 1e-6),
}
PRINTED = "R^2 > 0.99 between -200 and 200 degC"


def entries(work: Workshop) -> Iterator[Entry]:
    """Laws one by one, and what the text says of them."""
    paper, physical = library_material("al6061-paper"), library_material("al6061")
    for key, (name, unit) in LAWS.items():
        yield _law(key, name, unit, paper, physical)
    yield _softening(paper, physical)
    yield _density(paper)
    yield _secant(paper, physical)


def _law(key: str, name: str, unit: float, paper: Material, physical: Material) -> Entry:
    law, measured = getattr(paper, key)(MEASURED) / unit, getattr(physical, key)(MEASURED) / unit
    fit = determination(law, measured)
    worst = int(np.argmax(np.abs(law / measured - 1.0)))
    return Entry(
        "Table 1",
        f"{name} at -200, 25, 200 degC",
        PRINTED,
        f"{numbers(getattr(paper, key)(PLACES) / unit)}; R^2 = {fit:.2f} against NIST, "
        f"73-293 K",
        f"{numbers(getattr(physical, key)(PLACES) / unit)} (NIST, EN 1999-1-2)",
        f"does not follow: {away(law[worst], measured[worst])} at {MEASURED[worst]:.0f} K; "
        f"R^2 is {fit:.2f}, not above 0.99",
        (42, 43),
    )  # fmt: skip


def determination(law: Array, measured: Array) -> float:
    """R^2 of a law: 1 less the mean square of what is left over the variance [-]."""
    return float(1.0 - np.sum((law - measured) ** 2) / np.sum((measured - measured.mean()) ** 2))


def _softening(paper: Material, physical: Material) -> Entry:
    drops = [1.0 - m.youngs_modulus(PLACES[2]) / m.youngs_modulus(PLACES[0])
             for m in (paper, physical)]  # fmt: skip
    return Entry(
        "Sec. 4.3.1",
        "fall of E from -200 to 200 degC",
        "9-12 %; a frequency that falls by 10.8 %",
        f"{100 * drops[0]:.2f} %, so that frequencies fall by "
        f"{100 * (1 - np.sqrt(1 - drops[0])):.2f} %",
        f"{100 * drops[1]:.1f} %, frequencies by {100 * (1 - np.sqrt(1 - drops[1])):.1f} %",
        "does not follow from Table 1; the measured modulus falls by more than the text says",
        (42,),
    )


def _density(paper: Material) -> Entry:
    assert paper.density_law is not None
    ratios = paper.density_law(PLACES) / paper.density - 1.0
    alpha = float(paper.expansion(298.15))
    return Entry(
        "Table 1",
        "density over temperature, coefficient -2e-5 1/K",
        "-2e-5 1/K",
        f"a mass matrix with it makes {100 * ratios[0]:+.2f} % of mass at -200 degC and "
        f"{100 * ratios[2]:+.2f} % at 200 degC",
        f"-3 alpha = {-3 * alpha:.3g} 1/K; mass of a reference volume is constant",
        "does not follow: the coefficient is not that of the expansion, and no mass is made by "
        "heat; masses are constant here, the law is an option of [body.NAME]",
        (42,),
    )


def _secant(paper: Material, physical: Material) -> Entry:
    T0, T = PLACES[1], PLACES[0]
    secant = float(paper.expansion(T)) * (T - T0)
    integral = float(paper.expansion.integral(T0, T))
    measured = float(physical.expansion.integral(T0, T))
    return Entry(
        "Sec. 2.3.2",
        "thermal strain from 25 to -200 degC",
        "alpha dT, without saying whether alpha is a secant",
        f"{number(secant)} as a secant, {number(integral)} as the tangent, integrated",
        number(measured),
        f"not determined: {away(secant, integral)} between both readings; the integral is taken",
        (42, 44),
    )
