"""Materials: a density and five properties that depend on temperature."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import isfinite

import numpy as np

from meshes.properties import DATUM, Array, Property, constant, polynomial, table

__all__ = [
    "Material",
    "Property",
    "constant",
    "constant_material",
    "library",
    "library_material",
    "polynomial",
    "table",
]


@dataclass(frozen=True, eq=False)
class Material:
    """A linear elastic, isotropic, conducting material.

    Attributes
    ----------
    density : float [kg/m^3]  of the reference configuration, in which mass is counted: it does
        not change with T
    youngs_modulus [Pa], poissons_ratio [1], conductivity [W/(m K)], heat_capacity [J/(kg K)],
    expansion [1/K] : Property  the expansion coefficient is the instantaneous one
    density_law : Property | None [kg/m^3]  density for models in which mass follows the
        temperature; None: constant
    conductivity_around, conductivity_through : Property | None [W/(m K)]  round a tube or across
        a sheet's u, and through the wall; ``conductivity`` is that along. None: the same
    """

    name: str
    density: float
    youngs_modulus: Property
    poissons_ratio: Property
    expansion: Property
    conductivity: Property
    heat_capacity: Property
    density_law: Property | None = None
    conductivity_around: Property | None = None
    conductivity_through: Property | None = None

    def __post_init__(self) -> None:
        problems = _problems(self)
        if problems:
            raise ValueError(f"material {self.name}: " + "; ".join(problems))

    @property
    def properties(self) -> tuple[Property, ...]:
        """The properties that depend on temperature."""
        return (
            self.youngs_modulus,
            self.poissons_ratio,
            self.expansion,
            *dict.fromkeys(self.conductivities),
            self.heat_capacity,
        )

    @property
    def conductivities(self) -> tuple[Property, Property, Property]:
        """Along, around, through [W/(m K)]."""
        along = self.conductivity
        return along, self.conductivity_around or along, self.conductivity_through or along

    def shear_modulus(self, T):
        """G = E / (2 (1 + nu)) [Pa] at T [K]."""
        return 0.5 * self.youngs_modulus(T) / (1.0 + self.poissons_ratio(T))

    def thermal_strain(self, T, T_ref):
        """Free strain at T [K] of what has none at T_ref: the integral of the expansion."""
        return self.expansion.integral(T_ref, T)

    def density_factor(self, T):
        """Density at T [K] relative to ``density``; 1 without a law."""
        return np.ones_like(T) if self.density_law is None else self.density_law(T) / self.density

    def enthalpy(self, T):
        """Heat content [J/kg] at T [K], zero at 298.15 K; it rises with T."""
        return self.heat_capacity.integral(DATUM, T)

    def range_problems(self, lower: float, upper: float) -> list[str]:
        """One sentence for each property whose data do not cover ``lower`` to ``upper`` [K]."""
        return [
            f"{p.name}: needed from {lower:g} K to {upper:g} K, its data {ends}"
            for p in self.properties
            if (ends := _shortfall(p, lower, upper))
        ]


def constant_material(
    name: str,
    density: float,
    youngs_modulus: float,
    poissons_ratio: float,
    expansion: float,
    conductivity: float,
    heat_capacity: float,
) -> Material:
    """A material whose properties do not depend on temperature (SI units)."""
    return Material(
        name,
        density,
        constant("youngs_modulus", "Pa", youngs_modulus),
        constant("poissons_ratio", "1", poissons_ratio),
        constant("expansion", "1/K", expansion),
        constant("conductivity", "W/(m K)", conductivity),
        constant("heat_capacity", "J/(kg K)", heat_capacity),
    )


@cache
def library_material(name: str) -> Material:
    """A material of the library by name; see ``meshes.library`` for data and sources."""
    builders = library()
    if name not in builders:
        raise ValueError(f"no material '{name}' in the library; it has {', '.join(builders)}")
    return builders[name]()


def library() -> dict[str, Callable[[], Material]]:
    """Names of the library's materials and what builds each."""
    from meshes.library import BUILDERS

    return BUILDERS


def _shortfall(p: Property, lower: float, upper: float) -> str:
    begin = f"begin at {p.lower:g} K" if lower < p.lower else ""
    end = f"end at {p.upper:g} K" if upper > p.upper else ""
    return " and ".join(filter(None, (begin, end)))


def _problems(material: Material) -> list[str]:
    """What makes a material impossible, looked for on a dense sample of each range."""
    problems = []
    if not (isfinite(material.density) and material.density > 0.0):
        problems.append(f"density must be positive and finite, got {material.density!r}")
    positive = [material.youngs_modulus, material.heat_capacity, *material.conductivities]
    for p in positive + ([material.density_law] if material.density_law else []):
        if not p(_sample(p)).min() > 0.0:
            problems.append(f"{p.name} must be positive in its whole range")
    nu = material.poissons_ratio(_sample(material.poissons_ratio))
    if not (nu.min() > -1.0 and nu.max() < 0.5):
        problems.append("poissons_ratio must stay between -1 and 0.5")
    return problems


def _sample(p: Property) -> Array:
    """Temperatures all over the range; an open end is looked at as far as 200 K or 400 K."""
    lower = p.lower if isfinite(p.lower) else min(200.0, p.upper)
    upper = p.upper if isfinite(p.upper) else max(400.0, lower)
    return np.union1d(np.linspace(lower, upper, 200), p.curve.knots)
