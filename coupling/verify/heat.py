"""Heat: conduction, radiation, sunlight, balances; each by every solver that can express it.

Aluminium here has k = 167 W/(m K), rho = 2700 kg/m^3, c = 896 J/(kg K).
"""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import exp, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.verify.registry import Check, problem
from meshes.generate import line
from meshes.materials import Material, constant_material, library_material
from meshes.sections import Section, circle, general, rectangle, tube
from meshes.solids import box
from thermal import solvers
from thermal.description import (
    Description,
    Film,
    Fixed,
    Flux,
    History,
    Link,
    Member,
    Part,
    Place,
    Radiation,
    Settings,
    Solid,
    Source,
    Wall,
)

Array = NDArray[np.float64]

BOTH = ("line", "lumped")
LINES = ("line", "hermite", "lumped", "solid", "wall")
"""Solvers that take bars, ``wall`` as a tube; and CalculiX where it is installed."""
SIGMA = 5.670374419e-8  # [W/(m^2 K^4)]
ZERO_CELSIUS = 273.15  # [K]
SMALL_BAR = rectangle(0.01, 0.01)
SMALL_TUBE = tube(0.01, 0.002)
OUTSIDE_WORK = 8000  # elements times equal steps of CalculiX's backward Euler in each window
OUTSIDE_STEPS = (30, 1200)  # of them, least and most
OUTSIDE_FACTOR = 5.0  # of tolerances, for its order 1 in time


def conductor(conductivity: float, density: float, heat_capacity: float) -> Material:
    """A material of which only the heat matters."""
    return constant_material("verification", density, 1.0, 0.3, 0.0, conductivity, heat_capacity)


ALUMINIUM = conductor(167.0, 2700.0, 896.0)


def bar(
    length: float,
    elements: int,
    initial: float,
    section: Section = SMALL_BAR,
    material: Material = ALUMINIUM,
    wall_points: int = 1,
    name: str = "bar",
) -> Member:
    """A straight member along x."""
    points, axes = line((0.0, 0.0, 0.0), (length, 0.0, 0.0), elements, (0.0, 1.0, 0.0))
    return Member(name, points, axes, section, material, wall_points, initial)


def still(value: float) -> History:
    """A history that does not change."""
    return lambda t: value


def suited(solver: str, member: Member) -> Member:
    """The member as a solver takes it: for ``wall`` a tube."""
    if solver != "wall":
        return member
    return replace(member, section=SMALL_TUBE, wall_points=4)


def bars() -> tuple[str, ...]:
    """Solvers of bars that are there."""
    return (*LINES, "calculix") if calculix_is_there() else LINES


def calculix_is_there() -> bool:
    """Whether CalculiX can be run here."""
    return shutil.which(os.environ.get("THERMOBODY_CCX", "ccx")) is not None


def solver_of(name: str, description: Description) -> Any:
    """The solver, CalculiX with steps small enough for its order."""
    if name != "calculix":
        return solvers.build(name, description)
    elements = sum(len(m.points) - 1 for m in description.members)
    steps = int(np.clip(OUTSIDE_WORK // elements, *OUTSIDE_STEPS))
    return solvers.build(name, description, Settings(steps=steps))


def run(
    solver: Any, times: Sequence[float], outside: Mapping[str, Any] | None = None
) -> Iterator[Array]:
    """Temperatures at ``times``, one window from each to the next."""
    T, t = solver.initial(), 0.0
    for end in times:
        T, _, why = solver.advance(T, t, end - t, np.zeros_like(T), outside or {})
        if why:
            raise RuntimeError(why)
        t = end
        yield T


def at(solver: Any, T: Array, x: float, name: str = "bar") -> float:
    """Mean temperature [K] of the section of a straight body at x [m]."""
    nodes = solver.regions[name]
    there = np.abs(solver.x[nodes, 0] - x) < 1e-9
    return float(T[nodes[there]].mean())


Make = Callable[[str, Member], Description]


def by_all(
    what: str,
    member: Member,
    make: Make,
    times: Sequence[float],
    x: float,
    scale: Callable[[float], float],
    references: Sequence[float],
    tolerance: float,
    unit: str = "K",
) -> list[Check]:
    """One check per solver and time, of the scaled temperature at x."""
    checks = []
    for name in bars():
        solver = solver_of(name, make(name, suited(name, member)))
        allowed = tolerance * (OUTSIDE_FACTOR if name == "calculix" else 1.0)
        for t, T, reference in zip(times, run(solver, times), references, strict=True):
            found = scale(at(solver, T, x))
            checks.append(Check(f"{what} at {t:g} s, {name}", found, reference, allowed, unit))
    return checks


def rise(T: float) -> float:
    """Above 300 K."""
    return T - 300.0


@problem("heat", "semi-infinite aluminium, step", "Carslaw & Jaeger 1959, 2.5: erfc")
def semi_infinite_step() -> list[Check]:
    def make(solver: str, member: Member) -> Description:
        step = Fixed("face", Place("bar", "start"), still(301.0))
        return Description((member,), conditions=(step,))

    near, far = bar(0.1, 100, 300.0), bar(0.5, 200, 300.0)
    return [
        *by_all("rise 10 mm deep", near, make, [1.0], 0.01, rise, [0.39473333], 3e-3),
        *by_all("rise 100 mm deep", far, make, [60.0], 0.1, rise, [0.27189022], 3e-3),
    ]


@problem("heat", "semi-infinite aluminium, flux", "Carslaw & Jaeger 1959, 2.9: 2 q sqrt(Dt/pi)/k")
def semi_infinite_flux() -> list[Check]:
    """The flux falls on the end section."""

    def make(solver: str, member: Member) -> Description:
        flux = Flux("face", "bar", still(1e4), face="start")
        return Description((member,), conditions=(flux,))

    rises = [0.561385, 1.775256, 4.348471]
    rod = bar(0.5, 400, 300.0)
    return by_all("surface rise", rod, make, [1.0, 10.0, 60.0], 0.0, rise, rises, 3e-3)


@problem("heat", "NAFEMS T2, radiating end", "NAFEMS benchmark T2: 927.0 K")
def nafems_t2() -> list[Check]:
    def make(solver: str, member: Member) -> Description:
        conditions = (
            Fixed("hot", Place("bar", "start"), still(1000.0)),
            Radiation("space", "bar", 0.98, still(300.0), face="end"),
        )
        return Description((member,), conditions=conditions)

    rod = bar(0.1, 10, 1000.0, material=conductor(55.6, 7850.0, 460.0))
    return by_all("end", rod, make, [1e6], 0.1, float, [927.004], 1e-5)


@problem("heat", "NAFEMS T2 without time", "NAFEMS benchmark T2, steady")
def nafems_t2_steady() -> list[Check]:
    checks = []
    for name in bars():
        rod = suited(name, bar(0.1, 10, 1000.0, material=conductor(55.6, 7850.0, 460.0)))
        conditions = (
            Fixed("hot", Place("bar", "start"), still(1000.0)),
            Radiation("space", "bar", 0.98, still(300.0), face="end"),
        )
        solver = solver_of(name, Description((rod,), conditions=conditions))
        T, _, why = solver.steady(solver.initial(), 0.0)
        if why:
            raise RuntimeError(why)
        checks.append(Check(f"end, {name}", at(solver, T, 0.1), 927.004, 1e-5, "K"))
    return checks


@problem("heat", "NAFEMS T3, transient conduction", "NAFEMS benchmark T3: 36.60 degC")
def nafems_t3() -> list[Check]:
    def end(t: float) -> float:
        return ZERO_CELSIUS + 100.0 * sin(pi * t / 40.0)

    def make(solver: str, member: Member) -> Description:
        conditions = (
            Fixed("cold", Place("bar", "start"), still(ZERO_CELSIUS)),
            Fixed("moving", Place("bar", "end"), end),
        )
        return Description((member,), conditions=conditions)

    rod = bar(0.1, 80, ZERO_CELSIUS, material=conductor(35.0, 7200.0, 440.5))
    return by_all("x = 80 mm", rod, make, [32.0], 0.08, lambda T: T - ZERO_CELSIUS, [36.6031], 1e-3)


@problem("heat", "NAFEMS T4, plate with convection", "NAFEMS benchmark T4: 18.25 degC at E")
def nafems_t4() -> list[Check]:
    """0.6 m x 1 m, 100 degC below, 750 W/(m^2 K) to 0 degC at the right and above."""
    mesh = box((0.6, 1.0, 0.05), (24, 40, 1), 2)
    film = still(750.0)
    conditions = (
        Fixed("below", Place("plate", "y0"), still(ZERO_CELSIUS + 100.0)),
        Film("right", "plate", film, still(ZERO_CELSIUS), "x1"),
        Film("above", "plate", film, still(ZERO_CELSIUS), "y1"),
    )
    plate = Solid("plate", mesh, {"": conductor(52.0, 7850.0, 460.0)}, ZERO_CELSIUS + 50.0)
    d = Description(solids=(plate,), conditions=conditions)
    checks = []
    for name in ("solid", "calculix") if calculix_is_there() else ("solid",):
        solver = solvers.build(name, d)
        T, _, why = solver.steady(solver.initial(), 0.0)
        if why:
            raise RuntimeError(why)
        near = np.abs(solver.x[:, :2] - [0.6, 0.2]).max(axis=1) < 1e-9
        found = float(T[near].mean()) - ZERO_CELSIUS
        checks.append(Check(f"E, {name}", found, 18.2538, 2e-3, "degC"))
    return checks


@problem("heat", "slab cooled by convection, Bi = 1", "Carslaw & Jaeger 1959, 3.11: Fo = 0.5")
def convecting_slab() -> list[Check]:
    length = 0.1

    def make(solver: str, member: Member) -> Description:
        film = Film("air", "bar", still(167.0 / length), still(300.0), "end")
        return Description((member,), conditions=(film,))

    def scaled(T: float) -> float:
        return T / 100.0 - 3.0

    slab, time = bar(length, 40, 400.0), [0.5 * length**2 * 2700.0 * 896.0 / 167.0]
    middle = by_all("middle", slab, make, time, 0.0, scaled, [0.77252638], 1e-3, "")
    face = by_all("face", slab, make, time, length, scaled, [0.50452193], 1e-3, "")
    return middle + face


@problem("heat", "1 mm aluminium plate radiates", "T^-3 = T0^-3 + 3 eps sigma t/(rho c h)")
def radiating_plate() -> list[Check]:
    """One end section of a bar of 1 mm, which is a plate; one face of a shell and of a box."""
    exact = [427.317046, 285.011578, 167.720477]
    times = [60.0, 600.0, 3600.0]

    def make(solver: str, member: Member) -> Description:
        space = Radiation("space", "bar", 0.8, still(0.0), face="end")
        return Description((member,), conditions=(space,))

    return by_all("plate", bar(1e-3, 1, 473.15), make, times, 1e-3, float, exact, 1e-4)


@problem("heat", "two aluminium slabs heated between them", "mean q t/(2 rho c L), face + qL/(3k)")
def heated_interface() -> list[Check]:
    """100 W on 10 cm^2 between two slabs of 10 mm for 10 s."""
    section = general(1e-3, 1e-9, 1e-9, 1e-9)
    slabs = (bar(0.01, 20, 300.0, section), bar(0.01, 20, 300.0, section, name="other"))
    touch = Link("touch", Place("bar", "start"), Place("other", "start"), 1e6)
    heater = Source("heater", Place("bar", "start"), still(100.0))
    d = Description(slabs, (), (touch,), (heater,))
    checks = []
    for name in ("line", "hermite", "lumped"):
        solver = solvers.build(name, d)
        (T,) = run(solver, [10.0])
        stored = sum(at(solver, T, 0.01 / 20 * i, n) * (0.5 if i in (0, 20) else 1.0)
                     for i in range(21) for n in ("bar", "other")) / 40.0  # fmt: skip
        mean = solver.energy(T) / (2.0 * 2700.0 * 896.0 * 1e-3 * 0.01)
        rises = mean - solver.energy(solver.initial()) / (2.0 * 2700.0 * 896.0 * 1e-3 * 0.01)
        checks.append(Check(f"mean rise, {name}", rises, 20.667989, 1e-6, "K"))
        if name != "hermite":  # trapezoids are its rule as well
            checks.append(Check(f"of stations, {name}", stored - 300.0, 20.667989, 1e-6, "K"))
        face = at(solver, T, 0.0, "other") - 300.0
        checks.append(Check(f"interface rise, {name}", face, 21.665993, 1e-4, "K"))
    return checks


@problem("heat", "first harmonic round a tube dies out", "exp(-k t/(rho c R^2))")
def harmonic_decay() -> list[Check]:
    """With 4 wall points for ``line``, 32 for ``lumped``, whose error falls with their square."""
    radius, checks = 0.05, []
    time = radius**2 * 2700.0 * 896.0 / 167.0
    for name, n in (("line", 4), ("lumped", 32)):
        tubular = bar(1.0, 2, 300.0, tube(radius, 0.002), wall_points=n)
        solver = solvers.build(name, Description((tubular,)))
        wave = np.tile(np.cos(2.0 * pi * np.arange(n) / n), 3)
        T, _, _ = solver.advance(300.0 + 10.0 * wave, 0.0, time, np.zeros(3 * n))
        checks.append(Check(f"difference, {name}", T[0] - 300.0, 10.0 * exp(-1.0), 4e-3, "K"))
    return checks


@problem("heat", "sunlit radiating tube", "linearised balance of mean and first harmonic")
def sunlit_tube() -> list[Check]:
    """Weak light on a tube in surroundings of 300 K.

    Mean q/(pi h), first harmonic (q Ro/2)/(k t/R + h Ro) with h = 4 eps sigma T^3.
    """
    radius, thickness, q = 0.27, 0.002, 1.0
    outer, h = radius + 0.5 * thickness, 4.0 * 0.8 * SIGMA * 300.0**3
    mean = q / (pi * h)
    first = 0.5 * q * outer / (167.0 * thickness / radius + h * outer)
    checks = []
    for name, n in (("line", 4), ("lumped", 24)):
        boom = bar(5.0, 2, 300.0, tube(radius, thickness), wall_points=n)
        conditions = (
            Flux("sun", "bar", still(q), np.array([0.0, -1.0, 0.0])),
            Radiation("surroundings", "bar", 0.8, still(300.0)),
        )
        (T,) = run(solvers.build(name, Description((boom,), conditions=conditions)), [1e6])
        rise = T[:n] - 300.0
        wave = 2.0 / n * rise @ np.cos(2.0 * pi * np.arange(n) / n)
        checks.append(Check(f"mean rise, {name}", float(rise.mean()), mean, 1e-3, "K"))
        checks.append(Check(f"first harmonic, {name}", float(wave), first, 1e-2, "K"))
    return checks


@problem(
    "heat", "line against lumped", "two discretisations of one sunlit, radiating, varying tube"
)
def line_against_lumped() -> list[Check]:
    """Slanting sunlight on a tube of k(T), c(T), its root held; hot and cold side at the tip."""
    n = 16
    boom = bar(2.0, 20, 300.0, tube(0.05, 0.002), library_material("al6061-paper"), n)
    conditions = (
        Flux("sun", "bar", still(1361.0 * 0.3), np.array([0.5, -1.0, 0.0])),
        Radiation("space", "bar", 0.8, still(4.0)),
        Fixed("root", Place("bar", "start"), still(320.0)),
    )
    d = Description((boom,), conditions=conditions)
    checks = []
    for t in (300.0, 1e6):
        ends = [next(run(solvers.build(name, d), [t]))[-n:] for name in BOTH]
        for side, k in (("hot", 0), ("cold", n // 2)):
            a, b = (float(T[k]) for T in ends)
            checks.append(Check(f"{side} side at {t:g} s", a, b, 0.1, "K", absolute=True))
    return checks


@problem("heat", "heat balance", "flows + heat given = heat stored")
def heat_balance() -> list[Check]:
    """Tube, bar and lump with every kind of condition, k(T), c(T); defect over heat exchanged."""
    return [Check(f"defect, {name}", _defect(name), 0.0, 1e-12, "", absolute=True) for name in BOTH]


def _defect(name: str) -> float:
    solver = solvers.build(name, _composite())
    T = solver.initial()
    first, exchanged, balance = solver.energy(T), 0.0, 0.0
    heat = np.zeros_like(T)
    heat[-1] = 5.0
    for i in range(20):
        T, flows, why = solver.advance(T, 0.5 * i, 0.5, heat)
        if why:
            raise RuntimeError(why)
        exchanged += sum(abs(flow) for flow in flows.values()) + 5.0
        balance += sum(flows.values()) + 5.0
    return (solver.energy(T) - first - balance) / exchanged


def _composite() -> Description:
    alloy = library_material("al6061-paper")
    boom = bar(2.0, 6, 298.15, tube(0.05, 0.002), alloy, 4, "boom")
    strut = bar(0.5, 3, 310.0, circle(0.02), alloy, name="strut")
    warming = partial(_warming, 298.15)
    return Description(
        (boom, strut),
        (Part("hub", np.zeros(3), alloy, 0.7, 298.15),),
        (
            Link("fitting", Place("hub"), Place("boom", "start"), 3.0),
            Link("joint", Place("boom", "end"), Place("strut", "start"), 1.5),
            Link("mount", Place("hub"), still(280.0), 0.8),
        ),
        (
            Wall(
                "wall",
                "boom",
                0.9,
                1.5,
                np.array([0.0, 1.0, 0.3]),
                (warming,) * 2,
                (still(298.15),) * 2,
            ),
            Flux("sun", "boom", still(900.0), np.array([0.2, -1.0, 0.5])),
            Radiation("space", "boom", 0.8, still(4.0)),
            Radiation("room", "strut", 0.3, still(290.0)),
            Fixed("anchor", Place("strut", "end"), warming),
            Source("heater", Place("hub"), still(12.0)),
        ),
    )


def _warming(T: float, t: float) -> float:
    return T + 4.0 * t
