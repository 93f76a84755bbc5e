"""Heat between faces: view factors, enclosures, tubes inside, faces pressed on one another."""

from collections.abc import Sequence
from dataclasses import replace
from math import atan, exp, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from coupling.verify.heat import ALUMINIUM, SIGMA, bar, still
from coupling.verify.registry import Check, problem
from meshes.sections import tube
from meshes.solids import box
from thermal import solvers
from thermal.description import (
    Description,
    Enclosure,
    Fixed,
    Flux,
    Interface,
    Part,
    Place,
    Radiation,
    Side,
    Solid,
    Source,
)
from thermal.view_factors import polygon_areas, view_factors

Array = NDArray[np.float64]


def parallelogram(origin: Sequence[float], u: Sequence[float], v: Sequence[float]) -> Array:
    """Corners (4, 3), seen from the side of u x v."""
    o, a, b = (np.asarray(x, dtype=float) for x in (origin, u, v))
    return np.array([o, o + a, o + a + b, o + b])


@problem("heat", "view factors of rectangles", "Howell, catalogue of configuration factors")
def rectangles() -> list[Check]:
    """C-11, equal and opposite, and C-14, at a right angle with a common edge; all sides 1."""
    floor = parallelogram([0, 0, 0], [1, 0, 0], [0, 1, 0])
    lid = floor[::-1] + np.array([0.0, 0.0, 1.0])
    wall = parallelogram([0, 0, 0], [0, 1, 0], [0, 0, 1])
    factors = view_factors([floor, lid, wall])
    opposite = 2 / pi * (log(2 / sqrt(3)) + 2 * sqrt(2) * atan(1 / sqrt(2)) - 2 * atan(1))
    cornered = (2 * atan(1) - sqrt(2) * atan(1 / sqrt(2)) + 0.25 * log(0.75)) / pi
    return [
        Check("opposite (C-11)", factors[0, 1], opposite, 1e-9),
        Check("with a common edge (C-14)", factors[0, 2], cornered, 1e-9),
    ]


@problem("heat", "view factors with one body inside another", "F21 = A1/A2, F22 = 1 - A1/A2")
def sphere_in_sphere() -> list[Check]:
    """Facets of two spheres of radius 1/2 and 1; the inner one hides parts of the outer."""
    inner, outer = _sphere(0.5), [quad[::-1] for quad in _sphere(1.0)]
    areas, factors = polygon_areas(inner + outer), view_factors(inner + outer)
    n = len(inner)
    own = areas[n:] @ factors[n:, n:].sum(1) / areas[n:].sum()
    rows = float(np.abs(factors.sum(1) - 1.0).max())
    return [
        Check("inner to outer", factors[:n, n:].sum(1).mean(), 1.0, 1e-9),
        Check("outer to itself", own, 0.75, 3e-3),
        Check("largest defect of a row", rows, 0.0, 2e-2, absolute=True),
    ]


def _sphere(radius: float, rings: int = 6) -> list[Array]:
    theta, phi = np.meshgrid(
        np.linspace(0.0, pi, rings + 1), np.linspace(0.0, 2.0 * pi, 2 * rings + 1), indexing="ij"
    )
    x = radius * np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    corners = np.stack([x[:-1, :-1], x[1:, :-1], x[1:, 1:], x[:-1, 1:]], axis=2)
    return list(corners.reshape(-1, 4, 3))


def _exchanged(
    areas: Sequence[float],
    factors: Sequence[Sequence[float]],
    emissivities: Sequence[float],
    given: Sequence[float],
) -> list[float]:
    """Powers [W] that hold lumps at given temperatures [K] against their exchange."""
    names = [f"face {i + 1}" for i in range(len(areas))]
    parts = [
        Part(n, np.zeros(3), ALUMINIUM, 1.0, given[0], a) for n, a in zip(names, areas, strict=True)
    ]
    held = [Fixed(f"hold {n}", Place(n), still(T)) for n, T in zip(names, given, strict=False)]
    gap = Enclosure("gap", [Side(n) for n in names], emissivities, np.asarray(factors, float))
    solver = solvers.build("lumped", Description((), parts, conditions=(gap, *held)))
    T, _, why = solver.steady(solver.initial(), 0.0)
    if not why:
        _, flows, why = solver.advance(T, 0.0, 1.0, np.zeros(len(T)))
    if why:
        raise RuntimeError(why)
    return [flows[f"hold {n}"] for n, _ in zip(names, given, strict=False)]


@problem("heat", "grey faces that see one another", "Siegel & Howell 2002, ch. 7")
def grey_faces() -> list[Check]:
    """Heat that keeps the first face at 400 K, the second at 300 K."""
    step = SIGMA * (400.0**4 - 300.0**4)
    plates, _ = _exchanged([1.0, 1.0], [[0, 1], [1, 0]], [0.8, 0.5], [400.0, 300.0])
    checks = [Check("parallel plates", plates, 441.029121, 1e-8, "W/m^2")]
    for name, ratio in (("concentric spheres", 0.25), ("long coaxial cylinders", 0.5)):
        factors = [[0.0, 1.0], [ratio, 1.0 - ratio]]
        hot, _ = _exchanged([1.0, 1.0 / ratio], factors, [0.3, 0.9], [400.0, 300.0])
        exact = step / (1.0 / 0.3 + ratio * (1.0 / 0.9 - 1.0))
        checks.append(Check(f"{name}, areas 1:{1.0 / ratio:g}", hot, exact, 1e-8, "W/m^2"))
    return checks


@problem("heat", "triangular furnace, one side insulated", "Incropera & DeWitt, 13.3: network")
def furnace() -> list[Check]:
    """Sides of 1 m: one black at 1200 K, one of emissivity 0.7 at 500 K, one that reradiates."""
    half = [[0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]]
    step = SIGMA * (1200.0**4 - 500.0**4)
    exact = step / (0.3 / 0.7 + 1.0 / (0.5 + 1.0 / (2.0 + 2.0)))
    hot, _ = _exchanged([1.0] * 3, half, [1.0, 0.7, 0.8], [1200.0, 500.0])
    return [Check("heat of the hot side", hot, exact, 1e-7, "W/m")]


@problem("heat", "tube that radiates inside", "kernel |sin(dphi/2)|/4: harmonic 1 times -1/3")
def inside_a_tube() -> list[Check]:
    """Weak light on a thin tube in surroundings of 300 K; emissivity e inside, 0.8 outside.

    First harmonic (q Ro/2)/(k t/R + h (0.8 Ro + 4 e/(4 - e) Ri)), h = 4 sigma T^3.
    """
    radius, thickness, q, n = 0.5, 5e-5, 1.0, 24
    outer, inner = radius + 0.5 * thickness, radius - 0.5 * thickness
    h, checks = 4.0 * SIGMA * 300.0**3, []
    for name in ("line", "hermite", "wall", "lumped"):
        for e in (1.0, 0.3):
            conditions = (
                Flux("sun", "bar", still(q), np.array([0.0, -1.0, 0.0])),
                Radiation("space", "bar", 0.8, still(300.0)),
                Enclosure("inside", [Side("bar", "inner")], [e]),
            )
            boom = bar(5.0, 2, 300.0, tube(radius, thickness), wall_points=n)
            solver = solvers.build(name, Description((boom,), conditions=conditions))
            T, _, why = solver.steady(solver.initial(), 0.0)
            if why:
                raise RuntimeError(why)
            wave = 2.0 / n * (T[:n] - 300.0) @ np.cos(2.0 * pi / n * np.arange(n))
            lost = 167.0 * thickness / radius + h * (0.8 * outer + 4.0 * e / (4.0 - e) * inner)
            exact = 0.5 * q * outer / lost
            checks.append(Check(f"first harmonic, e = {e:g}, {name}", wave, exact, 1e-2, "K"))
    return checks


def _slabs(counts: Sequence[int], coefficient: float, *conditions: Source | Fixed) -> Description:
    """Two slabs of 10 mm, 10 cm^2, z upwards; face z1 of ``low`` on face z0 of ``high``."""
    side = sqrt(1e-3)
    solids = []
    for name, start, n in zip(("low", "high"), (-0.01, 0.0), counts, strict=True):
        mesh = box((side, side, 0.01), (n, n, 10))
        moved = replace(mesh, points=mesh.points + np.array([0.0, 0.0, start]))
        solids.append(Solid(name, moved, {"": ALUMINIUM}, 300.0))
    touch = Interface("touch", Side("low", "z1"), Side("high", "z0"), coefficient)
    return Description(conditions=conditions, solids=solids, interfaces=(touch,))


def _means(solver, T: Array, places: Sequence[Place]) -> list[float]:
    found = (solver.space.place(place) for place in places)
    return [float(mean.weights @ T[mean.nodes]) for mean in found]


@problem("heat", "two slabs with a contact resistance", "q = dT/(2L/k + 1/h)")
def contact_resistance() -> list[Check]:
    """h = 2 kW/(m^2 K); 400 K and 300 K at the far faces; meshes that match and that do not.

    Points of one mesh do not integrate the functions of another exactly: what is even along the
    faces stays so only nearly.
    """
    hot = Fixed("hot", Place("low", "z0"), still(400.0))
    cold = Fixed("cold", Place("high", "z1"), still(300.0))
    flux, checks = 100.0 / (0.02 / 167.0 + 1.0 / 2e3), []
    for counts, tolerance in (((2, 2), 1e-10), ((3, 2), 1e-4)):
        solver = solvers.build("solid", _slabs(counts, 2e3, hot, cold))
        T, _, why = solver.steady(solver.initial(), 0.0)
        if why:
            raise RuntimeError(why)
        below, above = _means(solver, T, [Place("low", "z1"), Place("high", "z0")])
        meshes = f"{counts[0]} on {counts[1]} cells"
        face = 400.0 - flux * 0.01 / 167.0
        checks.append(Check(f"hot side, {meshes}", below, face, tolerance, "K"))
        checks.append(Check(f"step, {meshes}", below - above, flux / 2e3, tolerance, "K"))
    return checks


@problem("heat", "two aluminium slabs, heated interface", "mean q t/(2 rho c L), face + qL/(3k)")
def heated_contact() -> list[Check]:
    """100 W between two slabs of 10 mm and 10 cm^2 for 10 s, their meshes not matching."""
    heaters = [Source("below", Place("low", "z1"), still(50.0))]
    heaters.append(Source("above", Place("high", "z0"), still(50.0)))
    d = _slabs((3, 2), 1e6, *heaters)
    solver = solvers.build("solid", d)
    T, _, why = solver.advance(solver.initial(), 0.0, 10.0, np.zeros(len(solver.x)))
    if why:
        raise RuntimeError(why)
    places = [Place("low"), Place("high"), Place("low", "z1"), Place("high", "z0")]
    low, high, below, above = _means(solver, T, places)
    return [
        Check("mean rise", 0.5 * (low + high) - 300.0, 20.667989, 1e-6, "K"),
        Check("interface rise", 0.5 * (below + above) - 300.0, 21.665993, 1e-3, "K"),
    ]


@problem(
    "heat", "slabs that even out through a contact", "difference decays by exp(-2 h t/(rho c L))"
)
def evening_out() -> list[Check]:
    """One slab at 320 K, one at 300 K, h = 20 W/(m^2 K): thin, so each stays nearly even."""
    d = _slabs((2, 3), 20.0)
    solver, time = solvers.build("solid", d), 600.0
    T = solver.initial()
    T[solver.regions["low"]] = 320.0
    T, _, why = solver.advance(T, 0.0, time, np.zeros(len(T)))
    if why:
        raise RuntimeError(why)
    low, high = _means(solver, T, [Place("low"), Place("high")])
    # the slabs' own resistance is in series: h -> 1/(1/h + 2 L/(3 k))
    h = 1.0 / (1.0 / 20.0 + 2.0 * 0.01 / (3.0 * 167.0))
    exact = 20.0 * exp(-2.0 * h * time / (2700.0 * 896.0 * 0.01))
    return [
        Check("mean", 0.5 * (low + high), 310.0, 1e-10, "K"),
        Check("difference", low - high, exact, 1e-3, "K"),
    ]
