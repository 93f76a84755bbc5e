"""Error against number of elements, for each family of beams."""

from collections.abc import Callable
from functools import cache, partial
from operator import mul

import numpy as np
from numpy.typing import NDArray

from coupling.verify.models import ROOM, Model, bent, clamp, elastic, model, sections, straight
from coupling.verify.registry import Check, Convergence, Result, problem
from coupling.verify.rods import Rod, rod_tip, timoshenko
from mechanics.description import Beam, Force, Moment, Site
from mechanics.elements import FAMILIES
from mechanics.modes import modes
from meshes.generate import arc
from meshes.materials import Material, constant_material
from meshes.sections import Section, rectangle

Array = NDArray[np.float64]
Errors = Callable[[str, int], float]

NU = 0.3
LOCKED = (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
"""(lambda + 2 mu)/E: what bending meets where a section cannot contract on one side only."""
SPATIAL = {"beam3243": 4.0, "beam3333": 4.0}
"""Order where the plane of bending is not a principal one, or turns."""
NAIVE, ENHANCED = "beam3243-continuum", "beam3243-enhanced"
Y, Z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def made_of(family: str, elements: int, section: Section, material: Material, loads=()) -> Model:
    """Cantilever of 1 m along x."""
    nodes = FAMILIES[family].stride * elements
    return model(straight(1.0, nodes, section, material, family), [clamp()], list(loads))


def tip(family: str, elements: int) -> Site:
    return Site("beam", FAMILIES[family].stride * elements)


def position(made: Model, q: Array) -> Array:
    """Of the last node, (3,) [m]."""
    nodes = made.system.layout.node_dofs["beam"].size
    return made.position(q, "beam", nodes - 1)


def table(
    what: str, family: str, sizes: tuple[int, ...], error: Errors, order: float, slack: float = 0.4
) -> Convergence:
    """Errors of a family on meshes of the given numbers of elements."""
    errors = [error(family, n) for n in sizes]
    return Convergence(f"{what}, {family}", sizes, errors, order, slack)


# ------------------------------------------------------------------------------ small tip load


def _deflection(family: str, elements: int, height: float = 0.1) -> tuple[float, float, float]:
    """Tip deflection under a small load, and its parts from bending and shear by theory."""
    E, section = 70e9, rectangle(height, height, NU)
    load = 1e-6 * E * section.second_moment_2
    push = Force("tip", tip(family, elements), Y, partial(mul, load))
    made = made_of(family, elements, section, elastic(E, NU), [push])
    bending = load / (3.0 * E * section.second_moment_2)
    shear = load / (E / (2.0 * (1.0 + NU)) * section.area)
    return float(position(made, bent(made, 1).q)[1]), bending, shear


def _small(family: str, elements: int) -> float:
    w, bending, shear = _deflection(family, elements)
    if family == NAIVE:
        return abs(w / (bending / LOCKED + shear) - 1.0)
    return abs(w / (bending + shear / rectangle(0.1, 0.1, NU).shear_factor_2) - 1.0)


@problem("elements", "small tip load", "Timoshenko; at nu = 0.3 with λ + 2µ where it locks")
def small_load() -> list[Result]:
    """Exact at the nodes for strains of a beam; second order for those of a solid."""
    found: list[Result] = []
    for family in ("beam3243", "beam3333"):
        w, bending, shear = _deflection(family, 1)
        expected = bending + shear / rectangle(0.1, 0.1, NU).shear_factor_2
        found.append(Check(f"deflection, {family}, 1 element", w, expected, 1e-6, "m"))
    for family, what in ((ENHANCED, "deflection"), (NAIVE, "deflection of a locked section")):
        found.append(table(what, family, (4, 8, 16, 32), _small, 2.0, 0.1))
    return found


@problem("elements", "locking of the naive continuum beam", "1 − E/(λ + 2µ) of bending is missing")
def locking() -> list[Result]:
    """No mesh helps: what is missing tends to what theory says."""
    missing = 1.0 - 1.0 / LOCKED
    found: list[Result] = []
    for elements in (8, 32, 128):
        w, bending, _ = _deflection(NAIVE, elements, 0.01)
        name = f"missing part of the deflection, {elements} elements"
        found.append(Check(name, 1.0 - w / bending, missing, 0.05))
    return found


# ------------------------------------------------------------------------------- large motion


SLENDER = rectangle(0.01, 0.01, 0.0)
PULL = 10.0 * 1e9 * SLENDER.second_moment_2
"""Tip load 10 EI/L^2 [N]."""


@cache
def _elastica(shear: bool, stiffer: float = 1.0) -> tuple[float, ...]:
    """Tip of the rod; ``stiffer``: factor of its bending."""
    rod = Rod.of(SLENDER, 1e9, 0.0, shear)
    rod = rod._replace(bending_2=stiffer * rod.bending_2, bending_3=stiffer * rod.bending_3)
    return tuple(rod_tip(rod, 1.0, PULL * Y))


def _away(family: str, elements: int, nu: float = 0.0) -> float:
    """Distance of the tip from that of the rod [L]."""
    push = Force("tip", tip(family, elements), Y, partial(mul, PULL))
    made = made_of(family, elements, SLENDER, elastic(1e9, nu), [push])
    expected = _elastica(family != "cable")
    return float(np.linalg.norm(position(made, bent(made).q) - expected))


@problem("elements", "elastica, P L²/EI = 10, L/h = 100", "rod of Reissner 1981, by shooting")
def elastica() -> list[Result]:
    """Distance of the tip [L]. Continuum beams lock, the naive one for good."""
    sizes = (8, 16, 32, 64)
    found: list[Result] = [
        table("tip", family, sizes, _away, 4.0) for family in ("beam3243", "beam3333", "cable")
    ]
    for elements, error in ((8, 0.12), (32, 2e-3)):
        name = f"tip, {ENHANCED}, {elements} elements"
        found.append(Check(name, _away(ENHANCED, elements), 0.0, error, "L", True))
    limit = float(np.linalg.norm(np.subtract(_elastica(True, LOCKED), _elastica(True))))
    for elements in (16, 32):
        name = f"distance that remains, {NAIVE}, {elements} elements"
        found.append(Check(name, _away(NAIVE, elements, NU), limit, 0.2, "L"))
    return found


def _gap(family: str, elements: int) -> float:
    section = rectangle(0.01, 0.01, 0.0)
    moment = 2.0 * np.pi * 1e9 * section.second_moment_2
    bend = Moment("end", tip(family, elements), Z, partial(mul, moment))
    made = made_of(family, elements, section, elastic(1e9), [bend])
    return float(np.linalg.norm(position(made, bent(made, 20).q)))


@problem("elements", "roll-up into a circle, L/h = 100", "closed form, k = 2 pi/L")
def roll_up() -> list[Result]:
    """Gap [L] between both ends."""
    found: list[Result] = [
        table("gap", family, (16, 32, 64), _gap, 4.0) for family in ("beam3243", "beam3333")
    ]
    away = _gap(ENHANCED, 32)
    return [*found, Check(f"gap, {ENHANCED}, 32 elements", away, 0.0, 0.02, "L", True)]


@problem("elements", "Princeton beam, 13.345 N at 45°", "rod of Reissner 1981, by shooting")
def princeton() -> list[Result]:
    """Distance of the tip [m], bent about both axes and twisted."""
    E, nu, length = 71.7e9, 0.31, 0.508
    section = rectangle(12.3777e-3, 3.2024e-3, nu)
    direction = np.array([0.0, 1.0, 1.0]) / np.sqrt(2.0)
    expected = rod_tip(Rod.of(section, E, nu), length, 13.345 * direction)

    def error(family: str, elements: int) -> float:
        nodes = FAMILIES[family].stride * elements
        push = Force("tip", Site("beam", nodes), direction, partial(mul, 13.345))
        made = model(straight(length, nodes, section, elastic(E, nu), family), [clamp()], [push])
        return float(np.linalg.norm(position(made, bent(made).q) - expected))

    y, z = expected[1:]
    return [
        Check("rod, y (Obrezkov et al. 2022)", y, 0.015186, 0.015, "m"),
        Check("rod, z (Obrezkov et al. 2022)", z, 0.156467, 0.01, "m"),
        *(table("tip", family, (2, 4, 8), error, order) for family, order in SPATIAL.items()),
    ]


# ---------------------------------------------------------------------------- curved reference


def _curved(family: str, elements: int) -> float:
    """Relative error of a small tip displacement: quarter circle of radius 1, loaded along y."""
    E, section, nodes = 70e9, rectangle(0.02, 0.02, NU), FAMILIES[family].stride * elements
    load = 1e-8 * E * section.second_moment_2
    points, axes = arc(Y, np.zeros(3), Z, 0.5 * np.pi, nodes)
    beam = Beam("beam", points, axes, section, elastic(E, NU), ROOM, element=family)
    push = Force("tip", tip(family, elements), Y, partial(mul, load))
    made = model(beam, [clamp()], [push])
    rod = Rod.of(section, E, NU, family != "cable")
    bending, axial, shear = 1.0 / rod.bending_2, 1.0 / rod.axial, 1.0 / rod.shear_2
    x = 0.5 * load * (axial - bending - shear)
    y = load * ((0.75 * np.pi - 2.0) * bending + 0.25 * np.pi * (axial + shear))
    moved = position(made, bent(made, 1).q) - points[-1]
    return float(np.hypot(moved[0] - x, moved[1] - y) / np.hypot(x, y))


@problem("elements", "quarter circle, R/h = 50, load along its end", "Castigliano")
def quarter_circle() -> list[Result]:
    """Relative error of the displacement. A curved continuum beam locks most."""
    found: list[Result] = [
        table("tip", family, (4, 8, 16, 32), _curved, 4.0)
        for family in ("beam3243", "beam3333", "cable")
    ]
    name = f"error, {ENHANCED}, 32 elements"
    return [*found, Check(name, _curved(ENHANCED, 32), 0.0, 2e-3, "", True)]


# -------------------------------------------------------------------------------- temperature


def _bow(family: str, elements: int, direction: Array = Y) -> float:
    turn, alpha = 0.5 * np.pi, 1e-4
    material = constant_material("warm", 1.0, 1e9, 0.0, alpha, 1.0, 1.0)
    made = made_of(family, elements, rectangle(0.01, 0.01, 0.0), material)
    gradient = turn / alpha * direction[1:]
    hot = made.system.coefficients(sections(made.system, ROOM, *gradient))
    expected = (np.array([np.sin(turn), 0.0, 0.0]) - (1.0 - np.cos(turn)) * direction) / turn
    return float(np.linalg.norm(position(made, bent(made, 10, hot).q) - expected))


@problem("elements", "bow to a quarter of a circle by a temperature gradient", "κ = α ∂T/∂y")
def bow() -> list[Result]:
    """Distance of the tip [L]; nothing resists, so nothing is stressed."""
    found: list[Result] = []
    oblique = partial(_bow, direction=(Y + Z) / np.sqrt(2.0))
    for family, order in SPATIAL.items():
        found.append(table("tip", family, (4, 8, 16), _bow, 4.0, 0.2))
        found.append(table("tip, oblique gradient", family, (4, 8, 16), oblique, order, 0.2))
    away = _bow(ENHANCED, 32)
    return [*found, Check(f"tip, {ENHANCED}, 32 elements", away, 0.0, 1e-3, "L", True)]


@problem("elements", "bow of the naive continuum beam", "(1 + ν)/(1 − ν) times too far")
def naive_bow() -> list[Result]:
    """The section resists its own expansion across, and that bends the beam further."""
    gradient, alpha = 1.0, 1e-5
    material = constant_material("warm", 1.0, 1e9, NU, alpha, 1.0, 1.0)
    found: list[Result] = []
    for elements in (4, 32):
        made = made_of(NAIVE, elements, rectangle(0.05, 0.05, NU), material)
        hot = made.system.coefficients(sections(made.system, ROOM, gradient))
        w = -float(position(made, bent(made, 1, hot).q)[1]) / (0.5 * alpha * gradient)
        name = f"deflection over α G L²/2, {elements} elements"
        found.append(Check(name, w, (1.0 + NU) / (1.0 - NU), 1e-3))
    return found


# -------------------------------------------------------------------------------- frequencies


def _expected_frequency(family: str, height: float) -> float:
    E, G, rho, section = 70e9, 70e9 / (2.0 * (1.0 + NU)), 2700.0, rectangle(height, height, NU)
    A, moment = section.area, section.second_moment_2
    if family == "cable":
        return timoshenko(E * moment, np.inf, rho * A, 0.0)
    if family == NAIVE:
        return timoshenko(LOCKED * E * moment, G * A, rho * A, rho * moment)
    shear = section.shear_factor_2 * G * A
    return timoshenko(E * moment, shear, rho * A, rho * moment)


def _frequency(family: str, elements: int, height: float = 0.005) -> float:
    """Relative error of the first frequency of a cantilever."""
    made = made_of(family, elements, rectangle(height, height, NU), elastic(70e9, NU, 2700.0))
    system = made.system
    found = modes(system, system.layout.q0, np.zeros(system.m), made.coef, 1).frequencies[0]
    return abs(2.0 * np.pi * found / _expected_frequency(family, height) - 1.0)


@problem("elements", "first frequency of a cantilever", "Timoshenko; with λ + 2µ where it locks")
def first_frequency() -> list[Result]:
    found: list[Result] = [
        table("frequency", family, (2, 4, 8), _frequency, 4.0, 0.3)
        for family in ("beam3243", "beam3333", "cable")
    ]
    found.append(table("frequency", ENHANCED, (8, 16, 32), _frequency, 2.0, 0.1))
    locked = table("frequency of a locked section", NAIVE, (8, 16, 32), _frequency, 2.0, 0.1)
    return [*found, locked]
