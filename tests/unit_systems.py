"""A case in another system of units: every number of it is scaled by what its unit asks for.

So is the one constant of the program that has a unit, that of Stefan and Boltzmann.
"""

from contextlib import ExitStack, contextmanager
from dataclasses import fields, replace
from functools import cache
from importlib import import_module
from unittest.mock import patch

from coupling import materials_used, quantities
from meshes.materials import Property

CONSTANT = "STEFAN_BOLTZMANN"
RADIATING = ("boundary", "interface", "enclosure", "rings", "planet")


class Units:
    """So many units of length are a metre, so many of mass a kilogram; seconds and kelvin stay."""

    def __init__(self, length, mass):
        self.length, self.mass = length, mass

    @property
    def energy(self):
        """So many are a joule."""
        return self.mass * self.length**2

    def of(self, unit):
        """So many are one of an SI unit such as "W/(m K)"."""
        powers = dimensions(unit)
        return self.length ** powers.get("[length]", 0.0) * self.mass ** powers.get("[mass]", 0.0)

    def property(self, p):
        """A property of a material, in these units."""
        factor = self.of(p.unit)
        names = ("value", "slope", "primitive")
        curve = p.curve._replace(**{name: factor * getattr(p.curve, name) for name in names})
        return replace(p, curve=curve)

    def material(self, m):
        """A material, in these units."""
        found = {f.name: getattr(m, f.name) for f in fields(m)}
        laws = {name: self.property(p) for name, p in found.items() if isinstance(p, Property)}
        return replace(m, density=m.density * self.of("kg/m^3"), **laws)

    @contextmanager
    def spoken(self):
        """Cases that are read and built here are in these units."""
        read, library = quantities.read, materials_used.library_material
        with ExitStack() as stack:

            def put(module, name, value):
                stack.enter_context(patch.object(module, name, value))

            put(quantities, "read", lambda value, kind: read(value, kind) * self.of(kind.unit))
            put(materials_used, "library_material", lambda name: self.material(library(name)))
            for name in RADIATING:
                module = import_module(f"thermal.{name}")
                constant = getattr(module, CONSTANT) * self.of("W/(m^2 K^4)")
                put(module, CONSTANT, constant)
            yield


@cache
def dimensions(unit):
    """Powers of length and mass in a unit; temperatures and plain numbers have none."""
    if unit in ("", "1"):
        return {}
    return dict(quantities._registry().parse_units(unit).dimensionality)


SI = Units(1.0, 1.0)
MM_T_S = Units(1e3, 1e-3)
BINARY = Units(2.0**10, 2.0**-10)
"""Between these and SI nothing is rounded: what differs is no physics."""
