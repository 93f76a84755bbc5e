"""Heat: conduction, radiation, sunlight, balances; each by both solvers that conduct.

Aluminium here has k = 167 W/(m K), rho = 2700 kg/m^3, c = 896 J/(kg K).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import exp, pi, sin

import numpy as np
from numpy.typing import NDArray

from coupling.verify.registry import Check, problem
from meshes.generate import line
from meshes.materials import Material, constant_material, library_material
from meshes.sections import Section, circle, general, rectangle, tube
from thermal import solvers
from thermal.description import (
    Description,
    Fixed,
    Flux,
    History,
    Link,
    Member,
    Part,
    Place,
    Radiation,
    Source,
    Wall,
)

Array = NDArray[np.float64]

BOTH = ("line", "lumped")
SIGMA = 5.670374419e-8  # [W/(m^2 K^4)]
ZERO_CELSIUS = 273.15  # [K]
SMALL_BAR = rectangle(0.01, 0.01)


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


def run(name: str, description: Description, times: Sequence[float]) -> Iterator[Array]:
    """Temperatures at ``times``, one window from each to the next."""
    solver = solvers.build(name, description)
    T, t = solver.initial(), 0.0
    for end in times:
        T, _, why = solver.advance(T, t, end - t, np.zeros_like(T))
        if why:
            raise RuntimeError(why)
        t = end
        yield T


def by_both(
    what: str,
    description: Description,
    times: Sequence[float],
    value: Callable[[Array], float],
    references: Sequence[float],
    tolerance: float,
) -> list[Check]:
    """One check per solver and time."""
    return [
        Check(f"{what} at {t:g} s, {name}", value(T), reference, tolerance, "K")
        for name in BOTH
        for t, T, reference in zip(times, run(name, description, times), references, strict=True)
    ]


@problem("heat", "semi-infinite aluminium, step", "Carslaw & Jaeger 1959, 2.5: erfc")
def semi_infinite_step() -> list[Check]:
    step = Fixed("face", Place("bar", "start"), still(301.0))
    near = Description((bar(0.15, 150, 300.0),), conditions=(step,))
    far = Description((bar(0.6, 240, 300.0),), conditions=(step,))
    return [
        *by_both("rise 10 mm deep", near, [1.0], lambda T: T[10] - 300.0, [0.39473333], 3e-3),
        *by_both("rise 100 mm deep", far, [60.0], lambda T: T[40] - 300.0, [0.27189022], 3e-3),
    ]


@problem("heat", "semi-infinite aluminium, flux", "Carslaw & Jaeger 1959, 2.9: 2 q sqrt(Dt/pi)/k")
def semi_infinite_flux() -> list[Check]:
    face = Source("face", Place("bar", "start"), still(1e4 * SMALL_BAR.area))
    d = Description((bar(0.6, 600, 300.0),), conditions=(face,))
    rises = [0.561385, 1.775256, 4.348471]
    return by_both("surface rise", d, [1.0, 10.0, 60.0], lambda T: T[0] - 300.0, rises, 3e-3)


@problem("heat", "NAFEMS T2, radiating end", "NAFEMS benchmark T2: 927.0 K")
def nafems_t2() -> list[Check]:
    """The radiating end face is a short superconducting member whose side has its area."""
    steel, face = conductor(55.6, 7850.0, 460.0), conductor(1e6, 7850.0, 460.0)
    area = SMALL_BAR.area
    end = general(area, 1e-9, 1e-9, 1e-9, outer_perimeter=area / 1e-3)
    members = (
        bar(0.1, 10, 1000.0, material=steel),
        bar(1e-3, 1, 1000.0, end, face, name="face"),
    )
    glue = Link("glue", Place("bar", "end"), Place("face", "start"), 1e6)
    conditions = (
        Fixed("hot", Place("bar", "start"), still(1000.0)),
        Radiation("space", "face", 0.98, still(300.0)),
    )
    d = Description(members, (), (glue,), conditions)
    return by_both("end", d, [1e6], lambda T: T[10], [927.004], 1e-5)


@problem("heat", "NAFEMS T3, transient conduction", "NAFEMS benchmark T3: 36.60 degC")
def nafems_t3() -> list[Check]:
    def end(t: float) -> float:
        return ZERO_CELSIUS + 100.0 * sin(pi * t / 40.0)

    rod = bar(0.1, 100, ZERO_CELSIUS, material=conductor(35.0, 7200.0, 440.5))
    conditions = (
        Fixed("cold", Place("bar", "start"), still(ZERO_CELSIUS)),
        Fixed("moving", Place("bar", "end"), end),
    )
    d = Description((rod,), conditions=conditions)
    return by_both("x = 80 mm", d, [32.0], lambda T: T[80] - ZERO_CELSIUS, [36.6031], 1e-3)


@problem("heat", "slab cooled by convection, Bi = 1", "Carslaw & Jaeger 1959, 3.11: Fo = 0.5")
def convecting_slab() -> list[Check]:
    length = 0.1
    film = 167.0 / length * SMALL_BAR.area
    air = Link("air", Place("bar", "end"), still(300.0), film)
    d = Description((bar(length, 40, 400.0),), (), (air,))
    time = [0.5 * length**2 * 2700.0 * 896.0 / 167.0]
    middle = by_both("middle", d, time, lambda T: T[0] / 100.0 - 3.0, [0.77252638], 1e-3)
    face = by_both("face", d, time, lambda T: T[-1] / 100.0 - 3.0, [0.50452193], 1e-3)
    return middle + face


@problem("heat", "1 mm aluminium plate radiates", "T^-3 = T0^-3 + 3 eps sigma t/(rho c h)")
def radiating_plate() -> list[Check]:
    sheet = general(1e-4, 1e-9, 1e-9, 1e-9, outer_perimeter=0.1)  # 100 mm wide, one side
    space = Radiation("space", "bar", 0.8, still(0.0))
    d = Description((bar(0.1, 1, 473.15, sheet),), conditions=(space,))
    exact = [427.317046, 285.011578, 167.720477]
    return by_both("plate", d, [60.0, 600.0, 3600.0], lambda T: T[0], exact, 1e-4)


@problem("heat", "two aluminium slabs heated between them", "mean q t/(2 rho c L), face + qL/(3k)")
def heated_interface() -> list[Check]:
    """100 W on 10 cm^2 between two slabs of 10 mm for 10 s."""
    section = general(1e-3, 1e-9, 1e-9, 1e-9)
    slabs = (bar(0.01, 20, 300.0, section), bar(0.01, 20, 300.0, section, name="other"))
    touch = Link("touch", Place("bar", "start"), Place("other", "start"), 1e6)
    heater = Source("heater", Place("bar", "start"), still(100.0))
    d = Description(slabs, (), (touch,), (heater,))
    weights = np.tile([0.5, *[1.0] * 19, 0.5], 2) / 40.0
    return [
        *by_both("mean rise", d, [10.0], lambda T: float(weights @ T) - 300.0, [20.667989], 1e-6),
        *by_both("interface rise", d, [10.0], lambda T: T[21] - 300.0, [21.665993], 1e-4),
    ]


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
        (T,) = run(name, Description((boom,), conditions=conditions), [1e6])
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
        ends = [next(run(name, d, [t]))[-n:] for name in BOTH]
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
