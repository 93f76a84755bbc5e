"""Extremes of heat by every solver: what comes out where input leaves the usual range.

Each row has an answer that is known otherwise, or no sensible one: then a reason is due.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import erfc, exp, inf, isfinite, pi, sqrt
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

from coupling.reports.heat_extreme_meshes import INVERTED, PIECES, layered
from coupling.reports.registry import Result, Row
from coupling.verify.heat import SIGMA, at, bar, calculix_is_there, conductor, still, suited
from meshes.fields import table_field
from meshes.materials import Material, Property, library_material, polynomial, table
from meshes.mesh import Mesh
from meshes.sections import tube
from meshes.solids import box
from thermal import solvers
from thermal.description import (
    Condition,
    Description,
    Enclosure,
    Field,
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
    Side,
    Solid,
    Source,
)

Array = NDArray[np.float64]

MEMBERS = ("line", "hermite", "wall", "solid", "lumped")
MESHED = ("line", "solid")
"""Solvers of meshes of their own; ``line`` takes them in 3D beside its members."""
OUTSIDE = "calculix"
PATIENCE = 10.0  # [s] that CalculiX has for a window
STEPS, ALLOWED = 60, 5.0
"""Equal steps of CalculiX in a window, and factor of tolerances for its order 1 in time."""
ALUMINIUM = conductor(167.0, 2700.0, 896.0)
DIFFUSIVITY = 167.0 / 2700.0 / 896.0  # [m^2/s]
BAR = 0.027  # [kg]  of a bar of 10 x 10 x 100 mm
LENGTH, ELEMENTS, START = 0.1, 10, 300.0
SLOW = 60.0  # [s]  what takes longer counts as hanging


class Case(NamedTuple):
    """Something extreme and what it must come to.

    make : solver's name -> description, which may be refused
    found : of the built solver, the quantity
    expected : closed form
    unit : of the error; 0: the expected number
    said : words of the reason that is due, others behind " | "; "": an answer is
    settings : but for CalculiX
    """

    what: str
    quantity: str
    make: Callable[[str], Description]
    found: Callable[[Any], float]
    expected: float = 0.0
    tolerance: float = 1e-3
    unit: float = 0.0
    said: str = ""
    solvers: Sequence[str] = MEMBERS
    outside: bool = True
    settings: Settings = Settings()


class NoResultError(Exception):
    """A step that cannot be done; its reason."""


COLUMNS = (
    "what", "solver", "outcome", "quantity", "delivered", "expected", "error", "reason", "time [s]",
)  # fmt: skip


def report() -> Iterator[Result]:
    """All cases by all solvers."""
    rows = [row(case, name) for case in cases() for name in named(case)]
    bad = [f"{r[0]}, {r[1]}: {r[2]}" for r in rows if r[2] not in ("correct", "reason")]
    slowest = max(rows, key=lambda r: float(r[-1]))
    notes = [
        f"{len(rows)} rows; neither correct nor with the reason that is due: "
        f"{'; '.join(bad) or 'none'}",
        f"longest: {slowest[0]}, {slowest[1]}, {slowest[-1]:.2g} s",
    ]
    if not calculix_is_there():
        notes.append("CalculiX is not installed and left out")
    else:
        notes.append(f"CalculiX has {PATIENCE:g} s for a window, then it counts as without result")
    yield Result("heat_extremes", "Extremes of heat", COLUMNS, rows, notes)


def named(case: Case) -> list[str]:
    """Solvers of a case that are there."""
    own = list(case.solvers)
    return [*own, OUTSIDE] if case.outside and calculix_is_there() else own


def row(case: Case, name: str) -> Row:
    """A case by a solver, whatever happens."""
    begun = perf_counter()
    outcome, delivered, error, reason = _outcome(case, name)
    seconds = perf_counter() - begun
    if seconds > SLOW:
        outcome = f"{outcome}, after {seconds:.0f} s"
    return (
        case.what, name, outcome, case.quantity, delivered, case.expected, error, reason, seconds,
    )  # fmt: skip


def _outcome(case: Case, name: str) -> tuple[str, float, float, str]:
    """Outcome, number, its error, reason."""
    nothing = float("nan")
    try:
        with np.errstate(all="ignore"):
            delivered = case.found(_built(case, name))
    except (ValueError, NoResultError) as error:
        reason = " ".join(str(error).split())
        if not case.said:
            return "no result", nothing, nothing, reason
        right = any(words in reason for words in case.said.split(" | "))
        return ("reason" if right else "other reason"), nothing, nothing, reason
    except Exception as error:  # a crash is an outcome of its own
        return f"crash: {type(error).__name__}", nothing, nothing, str(error)
    if case.said:
        return "silent", delivered, nothing, ""
    off = (delivered - case.expected) / (case.unit or abs(case.expected))
    allowed = case.tolerance * (ALLOWED if name == OUTSIDE else 1.0)
    right = isfinite(delivered) and abs(off) <= allowed
    return ("correct" if right else f"off by {100.0 * abs(off):.2g} %"), delivered, off, ""


def _built(case: Case, name: str) -> Any:
    settings = replace(case.settings, steps=STEPS) if name == OUTSIDE else case.settings
    solver = solvers.build(name, case.make(name), settings)
    if name == OUTSIDE:
        solver.patience = PATIENCE
    return solver


# ---------------------------------------------------------------------------------- quantities


def after(times: Sequence[float], value: Callable[[Any, Array], float], solver: Any) -> float:
    """A value at the last of ``times``, one window from each to the next."""
    T, t = solver.initial(), 0.0
    for end in times:
        T, _, why = solver.advance(T, t, end - t, np.zeros_like(T))
        if why:
            raise NoResultError(why)
        t = end
    return value(solver, T)


def flowing(name: str, h: float, solver: Any) -> float:
    """Heat [J] through a boundary within a window."""
    T = solver.initial()
    _, flows, why = solver.advance(T, 0.0, h, np.zeros_like(T))
    if why:
        raise NoResultError(why)
    return float(flows[name])


def settled(value: Callable[[Any, Array], float], solver: Any) -> float:
    """A value in the steady state."""
    T, _, why = solver.steady(solver.initial(), 0.0)
    if why:
        raise NoResultError(why)
    return value(solver, T)


def steady_power(name: str, solver: Any) -> float:
    """[W] through a boundary in the steady state."""
    _, flows, why = solver.steady(solver.initial(), 0.0)
    if why:
        raise NoResultError(why)
    return float(flows[name])


def temperature(x: float, solver: Any, T: Array) -> float:
    """[K] of the bar at x [m]."""
    return at(solver, T, x)


def of(name: str, solver: Any, T: Array) -> float:
    """Mean [K] of what belongs to a name."""
    return float(T[solver.regions[name]].mean())


def rise(name: str, solver: Any, T: Array) -> float:
    """Change of the mean [K] since the start."""
    return float((T - solver.initial())[solver.regions[name]].mean())


def gained(solver: Any, T: Array) -> float:
    """[J] stored since the start."""
    return float(solver.energy(T) - solver.energy(solver.initial()))


def nothing(solver: Any) -> float:
    """Of what should not have been built."""
    return 0.0


# -------------------------------------------------------------------------------- descriptions


def under(*conditions: Condition, member: Member | None = None) -> Callable[[str], Description]:
    """A bar under conditions."""
    rod = member or bar(LENGTH, ELEMENTS, START)
    return lambda name: Description((_suited(name, rod),), conditions=conditions)


def _suited(name: str, member: Member) -> Member:
    return member if member.section.kind == "tube" else suited(name, member)


def lump(initial: float = START, material: Material = ALUMINIUM, area: float = 0.0) -> Part:
    """1 kg."""
    return Part("lump", np.zeros(3), material, 1.0, initial, area)


def lumps(*conditions: Condition, part: Part | None = None) -> Callable[[str], Description]:
    """A lump under conditions."""
    return lambda name: Description(parts=(part or lump(),), conditions=conditions)


def meshed(mesh: Mesh, *conditions: Condition) -> Callable[[str], Description]:
    """A solid under conditions."""
    return lambda name: Description(
        solids=(Solid("block", mesh, {"": ALUMINIUM}, START),), conditions=conditions
    )


def jump(t0: float, before: float, later: float) -> History:
    """One value until ``t0`` [s], another after."""
    return lambda t: before if t < t0 else later


END, TIP = Place("bar", "start"), Place("bar", "end")
FIRST = partial(after, [1.0])
PAPER, NIST = library_material("al6061-paper"), library_material("al6061")


def emissivity(lower: float = 50.0, upper: float = 500.0, at_300: float = 0.5) -> Property:
    """Proportional to temperature."""
    return polynomial("emissivity", "-", [0.0, at_300 / 300.0], 0.0, lower, upper)


# --------------------------------------------------------------------------------------- cases


def cases() -> Iterator[Case]:
    """All of them."""
    yield from refused()
    yield from senseless()
    yield from unbalanced()
    yield from small_and_large()
    yield from of_time()
    yield from of_few_temperatures()
    yield from cryogenic()


def _refused(
    what: str,
    make: Callable[[str], Description],
    said: str,
    among: Sequence[str] = (*MEMBERS, "prescribed"),
) -> Case:
    return Case(what, "", make, nothing, said=said, solvers=among)


def refused() -> Iterator[Case]:
    """What is told before anything is solved."""
    paper = partial(bar, LENGTH, ELEMENTS, material=PAPER)
    room = still(300.0)
    yield _refused(
        "starts at -20 K", under(member=bar(LENGTH, ELEMENTS, -20.0)), "initial temperature must be"
    )
    yield _refused(
        "20 degC given as 20 K", under(member=paper(initial=20.0)),
        "initial temperature 20 K is outside the range of conductivity, 73.15 K to 473.15 K",
    )  # fmt: skip
    yield _refused(
        "emissivity 1.2", under(Radiation("space", "bar", 1.2, room)), "emissivity must be 0 to 1"
    )
    bright = Radiation("space", "bar", emissivity(upper=700.0), room)
    yield _refused("emissivity(T) beyond 1", under(bright), "emissivity must be 0 to 1, got 1.00")
    yield _refused("film of a lump without area", lumps(Film("air", "lump", room, room)), "no area")
    yield _refused(
        "wall of thickness 0", lambda name: under(member=bar(1.0, 4, START, tube(0.1, 0.0)))(name),
        "thickness",
    )  # fmt: skip
    point = bar(LENGTH, 4, START)
    point = replace(point, points=0.0 * point.points)
    yield _refused("length 0", under(member=point), "neighbouring points coincide")
    yield _refused(
        "no heat capacity", lambda name: lumps(part=lump(material=conductor(1.0, 1.0, 0.0)))(name),
        "heat_capacity must be positive",
    )  # fmt: skip
    rays = Flux("sun", "lump", still(1.0), np.array([0.0, 0.0, -1.0]))
    yield _refused("parallel rays on a lump", lumps(rays, part=lump(area=1.0)), "has no shape")
    yield _refused("inverted cells", meshed(INVERTED), "is inverted", MESHED)
    yield _refused("two pieces that do not touch", meshed(PIECES), "is isolated", MESHED)
    flat = box((0.1, 0.1, 0.0), (2, 2, 1))
    yield _refused("mesh without volume", meshed(flat), "is degenerate", MESHED)
    twice = [Fixed(n, Place("block", "x0"), room) for n in "ab"]
    mesh = box((0.1, 0.1, 0.1), (2, 2, 2))
    yield _refused(
        "a face prescribed twice", meshed(mesh, *twice), "both prescribe", (*MESHED, "prescribed")
    )


def senseless() -> Iterator[Case]:
    """What is told when its time comes."""

    def told(what: str, c: Condition, said: str, member: Member | None = None) -> Case:
        found = partial(after, [10.0, 20.0], lambda solver, T: 0.0)
        return Case(what, "", under(c, member=member), found, said=said)

    minus, room = still(-20.0), still(START)
    yield told(
        "sink at -20 K", Radiation("space", "bar", 0.5, minus),
        "radiation 'space': its temperature is below 0 K: -20 K",
    )  # fmt: skip
    yield told(
        "air at -20 K", Film("air", "bar", still(5.0), minus),
        "film 'air': its temperature is below 0 K: -20 K",
    )  # fmt: skip
    yield told(
        "history that falls below 0 K", Fixed("cold", END, jump(15.0, START, -5.0)),
        "fixed 'cold': its temperature is below 0 K: -5 K",
    )  # fmt: skip
    yield told(
        "coefficient that falls below 0", Film("air", "bar", jump(15.0, 1.0, -5.0), room),
        "film 'air': its coefficient is below 0",
    )  # fmt: skip
    yield told(
        "power that is no number", Source("heater", Place("bar"), still(float("nan"))),
        "source 'heater': its power is not a number",
    )  # fmt: skip
    yield told("cooled below 0 K", Source("cooler", Place("bar"), still(-1e3)), "fell below 0 K")
    paper = bar(LENGTH, ELEMENTS, START, material=PAPER)
    yield told(
        "heated beyond its data", Source("heater", Place("bar"), still(500.0)),
        "'bar' left the range of", paper,
    )  # fmt: skip
    known = table_field([0.0, 15.0], [0.0, 1.0], [[START, START], [320.0, 320.0]],
                        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])  # fmt: skip
    field = told(
        "field beyond its times", Field("given", "bar", known),
        "field 'given' is known from 0 s to 15 s only",
    )  # fmt: skip
    # without error control, as steps that shrink end at the last known time
    once = field._replace(settings=Settings(steps=1), outside=False)
    yield once._replace(solvers=(*MEMBERS, "prescribed"))
    narrow = Radiation("space", "bar", table("emissivity", "-", [250, 310], [0.5, 0.6]), still(4.0))
    yield told(
        "emissivity(T) beyond its data", narrow,
        "radiation 'space': 'bar' left the range of emissivity (250 K to 310 K)",
        bar(LENGTH, ELEMENTS, START, material=conductor(167.0, 1.0, 896.0)),
    )._replace(outside=False)  # fmt: skip
    hot = Field("given", "bar", lambda x, t: np.full(len(x), 600.0 if t > 15.0 else START))
    yield told(
        "field beyond the data of a material", hot, "'bar' left the range of", paper
    )._replace(solvers=(*MEMBERS, "prescribed"))


def unbalanced() -> Iterator[Case]:
    """Nothing to exchange heat with, or no way out for it."""
    heater = Source("heater", Place("bar"), still(1.0))
    pipe = bar(LENGTH, ELEMENTS, START, tube(0.02, 0.001), wall_points=8)
    inside = Enclosure("inside", (Side("bar", "inner"),), (0.8,))
    mean = partial(of, "bar")
    yield Case("isolated, 1e6 s", "mean [K]", under(), partial(after, [1e6], mean), START, 1e-12)
    yield Case("isolated, steady", "mean [K]", under(), partial(settled, mean), START, 1e-9)
    yield Case(
        "isolated and heated, steady", "", under(heater), partial(settled, mean),
        said="there is no steady state",
    )  # fmt: skip
    yield Case(
        "isolated and heated, 1000 s", "rise [K]",
        lambda name: Description((bar(LENGTH, ELEMENTS, START),), conditions=(heater,)),
        partial(after, [1e3], partial(rise, "bar")), 1e3 / (BAR * 896.0), 1e-6,
        solvers=("line", "hermite", "solid", "lumped"),
    )  # fmt: skip
    yield Case(
        "radiates into itself alone, 1e4 s", "mean [K]", under(inside, member=pipe),
        partial(after, [1e4], mean), START, 1e-9, outside=False,
    )  # fmt: skip  # CalculiX looks for view factors at every increment: minutes
    yield Case(
        "radiates into itself alone and heated, steady", "", under(inside, heater, member=pipe),
        partial(settled, mean), said="there is no steady state", outside=False,
    )  # fmt: skip
    space = Radiation("space", "bar", 0.8, still(0.0), face="end")
    area = 1e-4
    hot = (10.0 / (0.8 * SIGMA * area)) ** 0.25
    ten = Source("heater", TIP, still(10.0))
    yield Case(
        "heated, radiates to 0 K by one end, steady", "end [K]",
        lambda name: Description((bar(LENGTH, ELEMENTS, START),), conditions=(space, ten)),
        partial(settled, partial(temperature, LENGTH)), hot, 1e-6,
        solvers=("line", "hermite", "solid", "lumped"),
    )  # fmt: skip


def small_and_large() -> Iterator[Case]:
    """Walls, conductivities, conductances and fluxes over many powers of ten."""
    radius, thin, t = 0.05, 1e-6, 0.1
    foil = bar(LENGTH, 4, 400.0, tube(radius, thin), wall_points=8)
    space = Radiation("space", "bar", 0.8, still(0.0))
    outer = 1.0 + 0.5 * thin / radius
    fallen = (400.0**-3 + 3.0 * 0.8 * SIGMA * t * outer / (2700.0 * 896.0 * thin)) ** (-1 / 3)
    yield Case(
        "wall of 1 um radiates", "after 0.1 s [K]", under(space, member=foil),
        partial(after, [t], partial(of, "bar")), fallen, 1e-4,
    )  # fmt: skip
    for ratio in (1e3, 1e6, 1e9):
        yield _neighbours(ratio)
    yield _regions()
    for G in (1e12, 1e-12):
        yield _linked(G)
    q, time, depth = 1e9, 1e-3, 1.5e-3
    flux = Flux("flux", "bar", still(q), face="start")
    yield Case(
        "1e9 W/m^2", "surface rise after 1 ms [K]", under(flux, member=bar(depth, 100, START)),
        partial(after, [time], lambda s, T: at(s, T, 0.0) - START),
        2.0 * q * sqrt(DIFFUSIVITY * time / pi) / 167.0, 3e-3,
    )  # fmt: skip
    yield Case(
        "1e9 W/m^2 for 1 s, data end at 473 K", "", under(
            flux, member=bar(LENGTH, ELEMENTS, START, material=PAPER)
        ), partial(after, [1.0], lambda s, T: 0.0),
        said="'bar' left the range of | a temperature rose over 3000 K",
    )  # fmt: skip
    yield _ramp()


def _neighbours(ratio: float) -> Case:
    """Two bars in a row, of which one conducts so much better, to a film."""
    good, bad = conductor(1e3, 2700.0, 896.0), conductor(1e3 / ratio, 2700.0, 896.0)
    first = bar(LENGTH, ELEMENTS, START, material=good)
    second = bar(LENGTH, ELEMENTS, START, material=bad, name="other")
    h, G, joined = 1e3, 1e6, Link("joined", TIP, Place("other", "start"), 1e6)
    conditions = (
        Fixed("hot", END, still(400.0)), Film("air", "other", still(h), still(300.0), "end"),
    )  # fmt: skip

    def make(name: str) -> Description:
        pair = (suited(name, first), suited(name, second))
        return Description(pair, (), (joined,), conditions)

    area = 1e-4
    one = LENGTH / (1e3 * area)
    power = 100.0 / (one + one * ratio + 1.0 / G + 1.0 / (h * area))
    return Case(
        f"conductivities 1 : {ratio:g}, joined by 1e6 W/K", "power to a film [W]", make,
        partial(steady_power, "air"), -power, 1e-6, solvers=("line", "hermite", "solid", "lumped"),
    )  # fmt: skip


def _regions() -> Case:
    """A solid of two regions."""
    mesh = layered()
    materials = {"good": conductor(1e3, 1.0, 1.0), "bad": conductor(1e-3, 1.0, 1.0)}
    block = Solid("bar", mesh, materials, START)
    conditions = (
        Fixed("hot", Place("bar", "x0"), still(400.0)),
        Film("air", "bar", still(1e3), still(300.0), "x1"),
    )
    power = 100.0 / (0.05 / 1e3 + 0.05 / 1e-3 + 1e-3) * 0.01**2
    return Case(
        "regions of a mesh with conductivities 1 : 1e6", "power to a film [W]",
        lambda name: Description(solids=(block,), conditions=conditions),
        partial(steady_power, "air"), -power, 1e-6, solvers=MESHED,
    )  # fmt: skip


def _linked(G: float) -> Case:
    """Two lumps of 1 kg, 100 K apart, for 1e9 s."""
    pair = (lump(400.0), replace(lump(), name="other"))
    link = Link("link", Place("lump"), Place("other"), G)
    change = -50.0 * (1.0 - exp(-2.0 * G * 1e9 / 896.0))
    if G < 1.0:  # of first order, as differences of exponentials lose their digits
        change = -100.0 * G * 1e9 / 896.0 * (1.0 - G * 1e9 / 896.0)
    return Case(
        f"conductance {G:g} W/K for 1e9 s", "change [K]",
        lambda name: Description(parts=pair, links=(link,)),
        partial(after, [1e9], partial(rise, "lump")), change, 1e-6,
    )  # fmt: skip


def _ramp() -> Case:
    """From 200 to -50 degC at 25 K/s, on 4 elements in one window (Hua et al. 2026)."""
    hot, cold, seconds, x = 473.15, 223.15, 10.0, LENGTH
    face = Fixed("face", END, lambda t: hot - 25.0 * min(t, seconds))
    rod = bar(LENGTH, 4, hot, material=ALUMINIUM)
    return Case(
        "25 K/s from 200 to -50 degC, 4 elements", "far end after 10 s [K]",
        under(face, member=rod), partial(after, [seconds], partial(temperature, x)),
        hot - 25.0 * ramp_response(seconds), 2e-2, hot - cold,
    )  # fmt: skip


def ramp_response(t: float) -> float:
    """Fall [K] of the insulated end of a bar whose other end falls by 1 K/s.

    Carslaw & Jaeger 1959, sec. 3.5: by Duhamel's theorem from the step response.
    """
    terms = np.arange(200)
    m = (terms + 0.5) * pi
    rates = DIFFUSIVITY * (m / LENGTH) ** 2
    weights = 2.0 * (-1.0) ** terms / m
    return float(t - (weights * (1.0 - np.exp(-rates * t)) / rates).sum())


def of_time() -> Iterator[Case]:
    """Windows of all lengths, and histories that jump inside them."""
    iron = bar(LENGTH, ELEMENTS, 1000.0, material=conductor(55.6, 7850.0, 460.0))
    ends = (
        Fixed("hot", END, still(1000.0)), Radiation("space", "bar", 0.98, still(300.0), face="end")
    )  # fmt: skip
    yield Case(
        "one window of 1e9 s (NAFEMS T2)", "end [K]", under(*ends, member=iron),
        partial(after, [1e9], partial(temperature, LENGTH)), 927.004, 1e-5,
    )  # fmt: skip
    yield Case(
        "windows of 1e-9 s, 1 MW", "stored after two [J]",
        under(Source("heater", Place("bar"), still(1e6))), partial(after, [1e-9, 2e-9], gained),
        2e-3, 1e-6,
    )  # fmt: skip
    C = 896.0
    cooling = Film("air", "lump", still(C / 100.0), still(300.0))
    times = np.cumsum([1e-6, 1e2, 1e-3, 30.0, 1e-9, 1.0, 50.0]).tolist()
    yield Case(
        "windows from 1e-9 s to 100 s in turn", "excess [K]",
        lumps(cooling, part=lump(400.0, area=1.0)),
        partial(after, times, lambda s, T: of("lump", s, T) - 300.0),
        100.0 * exp(-times[-1] / 100.0), 1e-4, settings=Settings(tolerance=1e-5),
    )  # fmt: skip
    yield Case(
        "power that jumps inside a window", "rise [K]",
        lumps(Source("heater", Place("lump"), jump(3.7, 0.0, 1e4))),
        partial(after, [10.0], partial(rise, "lump")), 1e4 * 6.3 / C, 1e-3,
    )  # fmt: skip
    x, t = 0.01, 1.3
    step = Fixed("face", END, jump(0.37, START, 400.0))
    depth = erfc(x / sqrt(4.0 * DIFFUSIVITY * (t - 0.37)))
    yield Case(
        "temperature that jumps inside a window", "rise 10 mm deep [K]",
        under(step, member=bar(LENGTH, 100, START)),
        partial(after, [t], lambda s, T: at(s, T, x) - START), 100.0 * depth, 3e-3,
    )  # fmt: skip


def of_few_temperatures() -> Iterator[Case]:
    """One temperature, or none that is free; emissivities that change."""
    space = Radiation("space", "lump", 0.8, still(0.0))
    t, C = 3600.0, 896.0
    cooled = (500.0**-3 + 3.0 * 0.8 * SIGMA * t / C) ** (-1.0 / 3.0)
    end = partial(after, [t], partial(of, "lump"))
    yield Case(
        "one temperature, radiates", "after 1 h [K]", lumps(space, part=lump(500.0, area=1.0)),
        end, cooled, 1e-4, outside=False,
    )  # fmt: skip  # 60 equal steps of order 1 are 1.5 % off
    rate = SIGMA * 0.5 / 300.0 / C
    varying = replace(space, emissivity=emissivity())
    yield Case(
        "emissivity proportional to T", "after 1 h [K]", lumps(varying, part=lump(500.0, area=1.0)),
        end, (500.0**-4 + 4.0 * rate * t) ** -0.25, 1e-4, outside=False,
    )  # fmt: skip
    every = Field("given", "bar", lambda x, t: START + 10.0 * t + 0.0 * x[:, 0])
    yield Case(
        "all temperatures prescribed", "stored after 10 s [J]",
        lambda name: Description((bar(LENGTH, ELEMENTS, START),), conditions=(every,)),
        partial(after, [10.0], gained), BAR * C * 100.0, 1e-9,
        solvers=("line", "hermite", "solid", "lumped", "prescribed"),
    )  # fmt: skip
    held = Fixed("given", Place("lump"), lambda t: START + 10.0 * t)
    yield Case(
        "the only temperature prescribed", "after 10 s [K]", lumps(held),
        partial(after, [10.0], partial(of, "lump")), START + 100.0, 1e-12,
        solvers=(*MEMBERS, "prescribed"),
    )  # fmt: skip


def cryogenic() -> Iterator[Case]:
    """6061 from 4 K on, where its heat capacity all but vanishes (0.29 J/(kg K))."""
    c, power, t = NIST.heat_capacity, 1.0, 10.0
    given = power * t / BAR

    def missing(T: float) -> float:
        return quad(lambda x: float(c(x)), 4.0, T, limit=200, epsrel=1e-10)[0] - given

    cold = bar(LENGTH, ELEMENTS, 4.0, material=NIST)
    heater = Source("heater", Place("bar"), still(power))
    yield Case(
        "heated from 4 K", "mean after 10 s [K]",
        lambda name: Description((cold,), conditions=(heater,)),
        partial(after, [t], partial(of, "bar")), brentq(missing, 4.0, 290.0), 1e-4,
        solvers=("line", "hermite", "solid", "lumped"),
    )  # fmt: skip
    yield Case(
        "from 20 K in surroundings of 4 K", "after 1 h [K]",
        under(Film("air", "bar", still(10.0), still(4.0)), member=replace(cold, initial=20.0)),
        partial(after, [3600.0], partial(of, "bar")), 4.0, 1e-6,
    )  # fmt: skip
    yield Case(
        "end from 77 K to 4 K in no time, 10 elements", "lowest after 1 ms, 1 s [K]",
        under(Fixed("cold", END, still(4.0)), member=replace(cold, initial=77.0)),
        partial(after, [1e-3, 1.0], lambda s, T: float(min(T[s.regions["bar"]].min(), inf))),
        4.0, 1e-9,
    )  # fmt: skip
