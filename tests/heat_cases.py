"""Small thermal descriptions that several tests build on."""

from math import inf

import numpy as np

from meshes.generate import line
from meshes.materials import Material, constant, constant_material, polynomial
from meshes.sections import circle, rectangle, tube
from thermal.description import (
    Description,
    Fixed,
    Flux,
    Link,
    Member,
    Part,
    Place,
    Radiation,
    Source,
    Wall,
)

RADIUS, THICKNESS = 0.05, 0.002


def still(value):
    """A history that does not change."""
    return lambda t: value


def ramp(first, last, rise):
    """From ``first`` to ``last`` within ``rise`` seconds."""
    return lambda t: first + (last - first) * min(max(t / rise, 0.0), 1.0)


def plain(conductivity=167.0, heat_capacity=896.0, density=2700.0):
    """Constant properties, of aluminium unless said."""
    return constant_material("plain", density, 69e9, 0.33, 23.1e-6, conductivity, heat_capacity)


def varying(lower=-inf, upper=inf):
    """k = 120 + 0.5 (T - 300), c = 800 + 1.2 (T - 300) + 2e-3 (T - 300)^2."""
    k = polynomial("conductivity", "W/(m K)", [120.0, 0.5], 300.0, lower, upper)
    c = polynomial("heat_capacity", "J/(kg K)", [800.0, 1.2, 2e-3], 300.0, lower, upper)
    young, poisson = constant("youngs_modulus", "Pa", 69e9), constant("poissons_ratio", "1", 0.33)
    expansion = constant("expansion", "1/K", 23.1e-6)
    return Material("varying", 2700.0, young, poisson, expansion, k, c)


def member(
    name="arm",
    length=1.0,
    elements=8,
    wall_points=1,
    section=None,
    material=None,
    initial=300.0,
    start=(0.0, 0.0, 0.0),
    along=(1.0, 0.0, 0.0),
    normal=(0.0, 1.0, 0.0),
):
    """A straight member; a tube when it has wall points, else a square bar."""
    points, axes = line(start, np.add(start, np.multiply(along, length)), elements, normal)
    default = tube(RADIUS, THICKNESS) if wall_points > 1 else rectangle(0.01, 0.01)
    return Member(name, points, axes, section or default, material or plain(), wall_points, initial)


def everything(material=None):
    """Members of both kinds, parts, all conditions, links inside and to the outside."""
    material = material or varying()
    boom = member("boom", 2.0, 6, 4, material=material, initial=310.0)
    bar = member("bar", 0.5, 3, material=material, section=circle(0.02), start=(2.0, 0.0, 0.0))
    steel = plain(16.0, 500.0, 8000.0)
    parts = (
        Part("hub", np.zeros(3), steel, 0.7, 290.0),
        Part("pin", np.ones(3), material, 0.2, 305.0),
    )
    links = (
        Link("fitting", Place("hub"), Place("boom", "start"), 3.0),
        Link("joint", Place("boom", "end"), Place("bar", "start"), 1.5),
        Link("press", Place("hub"), Place("pin"), 0.4),
        Link("mount", Place("hub"), still(280.0), 0.8),
        Link("air", Place("bar", "end"), ramp(300.0, 320.0, 5.0), 0.3),
    )
    hot = (ramp(310.0, 350.0, 8.0), ramp(310.0, 340.0, 8.0))
    cold = (ramp(310.0, 320.0, 8.0), ramp(310.0, 300.0, 8.0))
    conditions = (
        Wall("sun", "boom", 0.9, 1.5, np.array([0.3, 1.0, 0.4]), hot, cold),
        Flux("light", "boom", ramp(0.0, 900.0, 3.0), np.array([0.2, -1.0, 0.5])),
        Flux("glow", "bar", still(50.0)),
        Radiation("space", "boom", 0.8, still(4.0)),
        Radiation("walls", "bar", 0.3, still(290.0)),
        Fixed("anchor", Place("pin"), ramp(305.0, 330.0, 4.0)),
        Source("heater", Place("hub"), still(12.0)),
        Source("motor", Place("boom", "start"), ramp(0.0, 6.0, 2.0)),
    )
    return Description((boom, bar), parts, links, conditions)
