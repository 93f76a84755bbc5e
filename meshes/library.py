"""The library of materials: numbers, ranges and sources.

``al6061-paper``  the linear and quadratic laws of Hua et al. (2026), Table 1
``al6061``        6061-T6: NIST cryogenic fits joined to the aluminium rules of EN 1999-1-2
``steel-304``     austenitic stainless steel: NIST fits joined to EN 1993-1-2
``titanium-6al4v``  annealed Ti-6Al-4V: NIST fits joined to handbook values
``invar``         Fe-36Ni: NIST fits and handbook values

A join is one cubic with the value and slope of both sources at its ends (``properties.joined``).
Where the sources disagree at room temperature (20 °C), colder source first:

    al6061     E 70.4 | 70 GPa, k 154 | 191 W/(m K), c 943 | 911 J/(kg K), alpha 22.6 | 22.9e-6/K
    steel-304  E 199.5 | 200, k 15.1 | 14.9, c 470.5 | 455.5, alpha 15.4 | 16.1e-6/K
    titanium   k 7.4 | 7.0, alpha 7.7 | 8.4e-6/K

The large one, k of al6061, is real: NIST measured the T6 temper, EN 1999-1-2 gives one line for
the whole 6000 series. (The Aluminum Association lists 167 W/(m K) for 6061-T6 at 25 °C.)

Not yet compared with the text of their source: E of EN 1999-1-2 at 50 °C and above 200 °C, all of
EN 1993-1-2, and the heat capacity of titanium above 298 K.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.polynomial import polynomial as power_series

from meshes.materials import Material, Property, polynomial, table
from meshes.properties import joined, log10_polynomial

ZERO_CELSIUS = 273.15  # [K]

PAPER = "Hua et al. (2026), Table 1, signs as physics asks: E and density fall, the others rise"
NIST = "NIST cryogenic material properties (Marquardt, Le & Radebaugh 2000)"
EN_ALUMINIUM = "EN 1999-1-2:2007, 3.2 and 3.3"
EN_STAINLESS = "EN 1993-1-2:2005, Annex C, grade 1.4301"
MILLS = "Mills (2002), Recommended values of thermophysical properties"


def _al6061_paper() -> Material:
    def law(name: str, unit: str, value: float, *coefficients: float) -> Property:
        scaled = [value, *(value * c for c in coefficients)]
        return polynomial(name, unit, scaled, 298.15, 73.15, 473.15, PAPER)

    return Material(
        "al6061-paper",
        2700.0,
        law("youngs_modulus", "Pa", 69e9, -1.5e-4, -5e-7),
        law("poissons_ratio", "1", 0.33, 5e-5),
        law("expansion", "1/K", 23.1e-6, 1e-4),
        law("conductivity", "W/(m K)", 167.0, 0.002),
        law("heat_capacity", "J/(kg K)", 896.0, 0.001),
        law("density", "kg/m^3", 2700.0, -2e-5),
    )


def _al6061() -> Material:
    cold_E = (77.71221, 0.01030646, -2.9241e-4, 8.9936e-7, -1.0709e-9)
    warm_E = _celsius_table(
        "youngs_modulus",
        "Pa",
        (50, 100, 150, 200, 250, 300, 350, 400),
        1e9 * np.array([69.3, 67.9, 65.1, 60.2, 54.6, 47.6, 37.8, 28.0]),
        EN_ALUMINIUM,
    )
    cold_strain = (-412.77, -0.30389, 8.7696e-3, -9.9821e-6)
    warm_strain = (-4.5e-4, 22.5e-6, 1e-8)
    cold_k = (0.07918, 1.0957, -0.07277, 0.08084, 0.02803, -0.09464, 0.04179, -0.00571)
    cold_c = (
        *(46.6467, -314.292, 866.662, -1298.3, 1162.27),
        *(-637.795, 210.351, -38.3094, 2.96344),
    )
    return Material(
        "al6061",
        2700.0,
        joined(_nist_modulus(cold_E, 2.0, 295.0), warm_E, 290.0, 323.15),
        _assumed("poissons_ratio", "1", 0.33, 2.0, 773.15, "Aluminum Association, 6061-T6"),
        joined(
            _nist_expansion(cold_strain, 18.0),
            _celsius_expansion(warm_strain, 20.0, 500.0, EN_ALUMINIUM),
            290.0,
            323.15,
        ),
        joined(
            _nist_conductivity(cold_k, 4.0),
            _celsius_polynomial(
                "conductivity", "W/(m K)", (190.0, 0.07), 20.0, 500.0, EN_ALUMINIUM
            ),
            290.0,
            373.15,
        ),
        joined(
            _nist_heat_capacity(cold_c, 4.0),
            _celsius_polynomial(
                "heat_capacity", "J/(kg K)", (903.0, 0.41), 20.0, 500.0, EN_ALUMINIUM
            ),
            250.0,
            373.15,
        ),
    )


def _steel_304() -> Material:
    cold_E = (210.0593, 0.1534883, -1.61739e-3, 5.11706e-6, -6.1546e-9)
    warm_E = _celsius_table(
        "youngs_modulus",
        "Pa",
        (20, 100, 200, 300, 400, 500, 600),
        200e9 * np.array([1.0, 0.96, 0.92, 0.88, 0.84, 0.80, 0.76]),
        EN_STAINLESS,
    )
    cold_strain = (-295.54, -0.39811, 9.2683e-3, -2.0261e-5, 1.7127e-8)
    warm_strain = 1e-6 * power_series.polymul([16.0, 4.79e-3, -1.243e-6], [-20.0, 1.0])
    cold_k = (-1.4087, 1.3982, 0.2543, -0.6260, 0.2334, 0.4256, -0.4658, 0.1650, -0.0199)
    cold_c = (22.0061, -127.5528, 303.647, -381.0098, 274.0328, -112.9212, 24.7593, -2.239153)
    warm_k = (14.6, 1.27e-2)
    warm_c = (450.0, 0.28, -2.91e-4, 1.34e-7)
    return Material(
        "steel-304",
        7900.0,
        joined(_nist_modulus(cold_E, 57.0, 293.0), warm_E, 273.15, 373.15),
        _assumed("poissons_ratio", "1", 0.29, 57.0, 873.15, "ASM data sheet, AISI 304"),
        joined(
            _nist_expansion(cold_strain, 23.0),
            _celsius_expansion(warm_strain, 20.0, 600.0, EN_STAINLESS),
            273.15,
            373.15,
        ),
        joined(
            _nist_conductivity(cold_k, 4.0),
            _celsius_polynomial("conductivity", "W/(m K)", warm_k, 20.0, 600.0, EN_STAINLESS),
            273.15,
            373.15,
        ),
        joined(
            _nist_heat_capacity(cold_c, 4.0),
            _celsius_polynomial("heat_capacity", "J/(kg K)", warm_c, 20.0, 600.0, EN_STAINLESS),
            273.15,
            473.15,
        ),
    )


def _titanium_6al4v() -> Material:
    cold_k = (
        *(-5107.8774, 19240.422, -30789.064, 27134.756),
        *(-14226.379, 4438.2154, -763.07767, 55.796592),
    )
    warm_k = _celsius_table(
        "conductivity",
        "W/(m K)",
        (25, 100, 200, 300, 400),
        np.array([7.0, 7.45, 8.75, 10.15, 11.35]),
        MILLS,
    )
    c = table(
        "heat_capacity",
        "J/(kg K)",
        [100.0, 200.0, 298.15, 373.15, 473.15, 573.15, 673.15],
        [309.0, 485.0, 546.0, 562.0, 584.0, 606.0, 629.0],
        "below 298 K Kopp's rule, 90 % Ti + 6 % Al + 4 % V by mass, element values of the JANAF "
        f"tables (Chase 1998); from 298 K {MILLS}",
        smooth=True,
    )
    # mean expansion from 20 °C: 8.6e-6/K to 100 °C, 9.2e-6/K to 315 °C, so alpha = a + b T
    warm_alpha = _celsius_polynomial(
        "expansion",
        "1/K",
        (8.265e-6, 5.58e-9),
        60.0,
        400.0,
        "ASM data sheet, mean expansion from 20 °C to 100 °C and to 315 °C, taken as linear in T",
    )
    modulus = polynomial(
        "youngs_modulus",
        "Pa",
        [113.8e9, -113.8e9 * 4.2e-4],
        296.0,
        100.0,
        673.15,
        "ASM data sheet at 296 K; relative slope of Fukuhara & Sanpei (1993), measured from "
        "296 K to 1100 K, continued below",
    )
    return Material(
        "titanium-6al4v",
        4430.0,
        modulus,
        _assumed("poissons_ratio", "1", 0.342, 100.0, 673.15, "ASM data sheet, Ti-6Al-4V"),
        joined(
            _nist_expansion((-171.1, -0.214, 4.807e-3, -7.111e-6), 24.0),
            warm_alpha,
            200.0,
            333.15,
        ),
        joined(_nist_conductivity(cold_k, 23.0), warm_k, 250.0, 373.15),
        c,
    )


def _invar() -> Material:
    modulus = _nist_modulus((141.565, 2.54435e-2, -1.00842e-3, 6.72797e-6, -1.0823e-8), 3.0, 298.0)
    cold_k = (-2.7064, 8.5191, -15.923, 18.276, -11.9116, 4.40318, -0.86018, 0.068508)
    # mean expansion from 20 °C: 1.5e-6/K to 100 °C and 2.6e-6/K to 200 °C
    warm_alpha = _celsius_table(
        "expansion",
        "1/K",
        (60, 150, 200),
        np.array([1.5e-6, 3.48e-6, 4.6e-6]),
        "Nilo 36 data sheet, mean expansion from 20 °C; lots differ by half as much again",
    )
    return Material(
        "invar",
        8110.0,
        _kept(modulus, 473.15),
        _assumed("poissons_ratio", "1", 0.29, 80.0, 473.15, "handbook value at room temperature"),
        joined(
            _nist_expansion((-52.65, 0.1009, 8.395e-4, -1.973e-6, 8.794e-11), 80.0),
            warm_alpha,
            250.0,
            333.15,
        ),
        _kept(_nist_conductivity(cold_k, 4.0), 473.15),
        _assumed(
            "heat_capacity", "J/(kg K)", 515.0, 250.0, 473.15, "Carpenter Invar 36 data sheet"
        ),
    )


def _nist_modulus(coefficients: tuple[float, ...], lower: float, upper: float) -> Property:
    """E from a polynomial in T giving GPa."""
    pascal = 1e9 * np.array(coefficients)
    return polynomial("youngs_modulus", "Pa", pascal.tolist(), 0.0, lower, upper, NIST)


def _nist_expansion(coefficients: tuple[float, ...], lower: float) -> Property:
    """Expansion coefficient: the derivative of the polynomial for 1e5 (L - L293) / L293."""
    alpha = 1e-5 * power_series.polyder(coefficients)
    return polynomial("expansion", "1/K", alpha.tolist(), 0.0, lower, 300.0, NIST)


def _nist_conductivity(coefficients: tuple[float, ...], lower: float) -> Property:
    return log10_polynomial("conductivity", "W/(m K)", coefficients, lower, 300.0, NIST)


def _nist_heat_capacity(coefficients: tuple[float, ...], lower: float) -> Property:
    return log10_polynomial("heat_capacity", "J/(kg K)", coefficients, lower, 300.0, NIST)


def _celsius_polynomial(
    name: str, unit: str, coefficients, lower: float, upper: float, source: str
) -> Property:
    """Polynomial in °C between two temperatures in °C."""
    ends = lower + ZERO_CELSIUS, upper + ZERO_CELSIUS
    return polynomial(name, unit, coefficients, ZERO_CELSIUS, *ends, source)


def _celsius_expansion(strain, lower: float, upper: float, source: str) -> Property:
    """Expansion coefficient: the derivative of the strain, a polynomial in °C."""
    alpha = power_series.polyder(strain)
    return _celsius_polynomial("expansion", "1/K", alpha, lower, upper, source)


def _celsius_table(
    name: str, unit: str, celsius: tuple[float, ...], values: np.ndarray, source: str
) -> Property:
    return table(name, unit, np.add(celsius, ZERO_CELSIUS), values, source, smooth=True)


def _assumed(
    name: str, unit: str, value: float, lower: float, upper: float, source: str
) -> Property:
    """A value at room temperature, assumed to hold in a whole range."""
    return polynomial(
        name, unit, [value], 0.0, lower, upper, f"{source}; assumed constant in this range"
    )


def _kept(p: Property, upper: float) -> Property:
    """The property with its last value assumed to hold up to ``upper`` [K]."""
    return replace(p, upper=upper, source=f"{p.source}; assumed constant above {p.upper:g} K")


BUILDERS: dict[str, Callable[[], Material]] = {
    "al6061-paper": _al6061_paper,
    "al6061": _al6061,
    "steel-304": _steel_304,
    "titanium-6al4v": _titanium_6al4v,
    "invar": _invar,
}
