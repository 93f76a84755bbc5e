"""Error against time for types of elements and their number: a cantilever bent far by its tip.

A dead tip load with P L^2 / (E I) = 2. The reference is the exact rod that stretches and shears
(Reissner 1972), integrated as an initial value problem; for the cable one that does not shear.
"""

from collections.abc import Iterator
from time import perf_counter

import numpy as np

from coupling.reports.measure import room
from coupling.reports.registry import Curve, Picture, Result
from mechanics.description import Beam, Clamp, Description, Force, Site
from mechanics.elements import FAMILIES
from mechanics.statics import equilibrium
from mechanics.system import System
from meshes.generate import frames
from meshes.materials import constant_material
from meshes.sections import rectangle

TYPES = ("beam3243", "beam3243-enhanced", "beam3243-continuum", "beam3333", "cable")
COUNTS = (1, 2, 4, 8, 16, 32, 64)
LENGTH, SIDE, LOAD = 1.0, 0.01, 2.0
"""Length and side of the section [m]; P L^2 / (E I) [-]."""
MODULUS, GOAL = 69e9, 1e-3
"""Young's modulus [Pa]; error that the note compares at [-]."""


def report() -> Iterator[Result]:
    """Error of the place of the tip, and time of the solution."""
    rows: list[tuple[str | float | int, ...]] = []
    curves = []
    for kind in TYPES:
        exact = reference(shears=kind != "cable")
        tips = [_tip(kind, count) for count in COUNTS]
        errors = [float(np.linalg.norm(tip - exact)) / LENGTH for tip, _ in tips]
        times = [1e3 * seconds for _, seconds in tips]
        rows += [(kind, *row) for row in zip(COUNTS, errors, times, strict=True)]
        curves.append(Curve(kind, times, errors))
    columns = ("element", "elements", "error of the tip / L [-]", "time [ms]")
    title = "Cantilever, tip load 2 E I / L^2: error against time of the statics"
    picture = Picture("time [ms]", "error of the tip / length [-]", curves)
    yield Result("elements", title, columns, rows, [_said(rows)], [picture])


def _said(rows: list) -> str:
    """How long each type takes to an error of 1e-3."""
    words = []
    for kind in TYPES:
        good = [row for row in rows if row[0] == kind and row[2] <= GOAL]
        text = f"{good[0][1]} elements, {good[0][3]:.0f} ms" if good else "not reached"
        words.append(f"{kind} {text}")
    return f"error of {GOAL:g} L by: {'; '.join(words)}"


def reference(shears: bool) -> np.ndarray:
    """(2,) [m]  place of the tip of the exact rod, by shooting for the moment at the clamp."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    section = rectangle(SIDE, SIDE, 0.0)
    EA, EI = MODULUS * section.area, MODULUS * section.second_moment_3
    GA = section.shear_factor_3 * 0.5 * EA if shears else np.inf
    load = LOAD * EI / LENGTH**2

    def slope(s, state):
        _, _, turn, moment = state
        stretch, shear = load * np.sin(turn) / EA, load * np.cos(turn) / GA
        x = (1.0 + stretch) * np.cos(turn) - shear * np.sin(turn)
        z = (1.0 + stretch) * np.sin(turn) + shear * np.cos(turn)
        return [x, z, moment / EI, -load * x]

    def end(moment):
        start = [0.0, 0.0, 0.0, moment]
        return solve_ivp(slope, (0.0, LENGTH), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]

    moment = brentq(lambda m: end(m)[3], 0.5 * load * LENGTH, load * LENGTH, xtol=1e-14 * load)
    return end(moment)[:2]


def _tip(kind: str, count: int) -> tuple[np.ndarray, float]:
    """Place of the tip in the plane of the load (2,) [m], time [s] of the solution."""
    system = cantilever(kind, count)
    coef = room(system)
    equilibrium(system, coef, coef)
    begun = perf_counter()
    found = equilibrium(system, coef, coef)
    seconds = perf_counter() - begun
    if found.why:
        return np.full(2, np.nan), seconds
    r = found.q[system.layout.node_dofs["beam"][-1] + np.arange(3)]
    return r[[0, 2]], seconds


def cantilever(kind: str, count: int) -> System:
    """A clamped beam or cable along x with a dead load along z at its tip."""
    nodes = FAMILIES[kind].stride * count + 1
    points = np.column_stack([np.linspace(0.0, LENGTH, nodes), np.zeros((nodes, 2))])
    section = rectangle(SIDE, SIDE, 0.0)
    material = constant_material("m", 2700.0, MODULUS, 0.0, 0.0, 1.0, 1.0)
    axes = frames(points, [0.0, 1.0, 0.0])
    beam = Beam("beam", points, axes, section, material, 293.15, 0.0, kind)
    clamp = Clamp("clamp", Site("beam", 0), Site(None))
    load = LOAD * MODULUS * section.second_moment_3 / LENGTH**2
    force = Force("load", Site("beam", -1), np.array([0.0, 0.0, 1.0]), lambda s: load * s)
    return System(Description([beam], [clamp], [force]))
