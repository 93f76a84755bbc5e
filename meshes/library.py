"""The library of materials: numbers, ranges and sources."""

from collections.abc import Callable

from meshes.materials import Material, polynomial

PAPER = "Hua et al. (2026), Table 1, signs as physics asks: E falls, the others rise with T"


def _al6061_paper() -> Material:
    def law(name: str, unit: str, value: float, slope: float, curvature: float = 0.0):
        coefficients = [value, value * slope] + ([value * curvature] if curvature else [])
        return polynomial(name, unit, coefficients, 298.15, 73.15, 473.15, PAPER)

    return Material(
        "al6061-paper",
        2700.0,
        law("youngs_modulus", "Pa", 69e9, -1.5e-4, -5e-7),
        law("poissons_ratio", "1", 0.33, 5e-5),
        law("expansion", "1/K", 23.1e-6, 1e-4),
        law("conductivity", "W/(m K)", 167.0, 0.002),
        law("heat_capacity", "J/(kg K)", 896.0, 0.001),
    )


BUILDERS: dict[str, Callable[[], Material]] = {"al6061-paper": _al6061_paper}
