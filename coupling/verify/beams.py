"""Beams and cables in statics, and their frequencies."""

from functools import partial
from operator import mul

import numpy as np
from numpy.typing import NDArray

from coupling.verify.models import ROOM, bent, clamp, elastic, model, sections, straight
from coupling.verify.registry import Check, problem
from mechanics.description import Beam, Clamp, Force, Guide, Joint, Load, Moment, Revolute, Site
from mechanics.modes import modes
from meshes.generate import arc
from meshes.materials import Material
from meshes.sections import Section, general, rectangle, tube

Array = NDArray[np.float64]

Y = np.array([0.0, 1.0, 0.0])

ELASTICA = {
    1: (0.30172077, 0.05643324, 0.46135195),
    2: (0.49345748, 0.16064172, 0.78174983),
    5: (0.71379152, 0.38762836, 1.21536812),
    10: (0.81060902, 0.55499560, 1.43028554),
}
"""Load P L^2/EI: deflection w/L, shortening u/L, tip angle [rad]; Bisshopp & Drucker (1945)."""


def _elastica(element: str, elements: int, alpha: float) -> tuple[float, float, float]:
    """Deflection, shortening and tip angle of a rod that is 1000 times longer than high."""
    section, material = rectangle(1e-3, 1e-3), elastic(1e9)
    load = alpha * 1e9 * section.second_moment_2
    beam = straight(1.0, elements, section, material, element)
    push = Force("tip", Site("beam", elements), Y, lambda s: s * load)
    made = model(beam, [clamp()], [push])
    x, slope = made.vectors(bent(made).q, "beam", elements)[:2]
    return x[1], 1.0 - x[0], float(np.arctan2(slope[1], slope[0]))


@problem("beams", "elastica, beam, 32 elements", "Bisshopp & Drucker 1945")
def elastica_beam() -> list[Check]:
    return _elastica_checks("beam3243", 32, 1e-4)


@problem("beams", "elastica, cable, 32 elements", "Bisshopp & Drucker 1945")
def elastica_cable() -> list[Check]:
    return _elastica_checks("cable", 32, 1e-3)


def _elastica_checks(element: str, elements: int, tolerance: float) -> list[Check]:
    names = ("w/L", "u/L", "tip angle")
    checks = []
    for alpha, reference in ELASTICA.items():
        found = _elastica(element, elements, alpha)
        checks += [
            Check(f"{n}, P L²/EI = {alpha}", v, r, tolerance)
            for n, v, r in zip(names, found, reference, strict=True)
        ]
    return checks


@problem("beams", "roll-up into one and two circles", "closed form, k = M L/EI")
def roll_up() -> list[Check]:
    checks = []
    for turns, elements in ((1, 12), (2, 24)):
        section, material = rectangle(1e-2, 1e-2), elastic(1e9)
        moment = 2.0 * np.pi * turns * 1e9 * section.second_moment_2
        bend = Moment("end", Site("beam", elements), np.array([0, 0, 1.0]), partial(mul, moment))
        made = model(straight(1.0, elements, section, material), [clamp()], [bend])
        x = made.position(bent(made, 20 * turns).q, "beam", elements)
        gap = float(np.linalg.norm(x))
        checks.append(Check(f"gap, {turns} turn, {elements} elements", gap, 0.0, 1e-3, "L", True))
    return checks


def _nachbagauer(factor: float, elements: int = 32) -> Array:
    height, width, E, nu = 0.5, 0.1, 2.07e11, 0.3
    shear = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
    bar = rectangle(height, width)
    section = general(
        bar.area, bar.second_moment_2, bar.second_moment_3, bar.torsion_constant,
        shear_factor_2=shear, shear_factor_3=shear,
    )  # fmt: skip
    load = factor * 5e5 * height**3
    push = Force("tip", Site("beam", elements), Y, lambda s: s * load)
    made = model(straight(2.0, elements, section, elastic(E, nu)), [clamp()], [push])
    return made.position(bent(made, 20).q, "beam", elements) - np.array([2.0, 0.0, 0.0])


@problem("beams", "shear-deformable cantilever, small and large load", "Nachbagauer et al. 2011")
def nachbagauer() -> list[Check]:
    small, large = _nachbagauer(1.0), _nachbagauer(1000.0)
    return [
        Check("u_y, F", small[1], 8.0990e-4, 1e-4, "m"),
        Check("-u_x, 1000 F", -large[0], 0.1509711442, 1e-3, "m"),
        Check("u_y, 1000 F", large[1], 0.7105685979, 1e-3, "m"),
    ]


@problem(
    "beams", "cantilever under combined moments", "Nachbagauer, Gruber & Gerstmayr 2013, Table 4"
)
def combined_moments() -> list[Check]:
    E, height, width = 2.07e11, 0.2, 0.4
    nu = 0.3
    section = general(height * width, 55.2e6 / E, 220.8e6 / E, 61.2295e6 / (E / (2.0 * (1.0 + nu))))
    loads = [
        Moment("torque", Site("beam", 16), np.array([1.0, 0, 0]), lambda s: 0.5e6 * s),
        Moment("bending", Site("beam", 16), np.array([0, 1.0, 0]), lambda s: 2e6 * s),
    ]
    made = model(straight(2.0, 16, section, elastic(E, nu)), [clamp()], loads)
    moved = np.abs(made.position(bent(made).q, "beam", 16) - np.array([2.0, 0, 0]))
    reference = (1.0944e-4, 1.8644e-4, 1.81174e-2)
    names = ("|u_x|", "|u_y|", "|u_z|")
    return [Check(n, v, r, 1e-3, "m") for n, v, r in zip(names, moved, reference, strict=True)]


@problem("beams", "Princeton beam", "Dowell & Traybar 1975; Obrezkov et al. 2022")
def princeton() -> list[Check]:
    table = {
        (8.896, 15): (0.010613, 0.042082), (8.896, 30): (0.010112, 0.079395),
        (8.896, 45): (0.008837, 0.108988), (8.896, 60): (0.006605, 0.129888),
        (8.896, 75): (0.003539, 0.142194), (8.896, 90): (0.0, 0.146246),
        (13.345, 30): (0.016659, 0.117736), (13.345, 45): (0.015186, 0.156467),
    }  # fmt: skip
    checks = []
    for (load, angle), (stiff, flap) in table.items():
        y, z = _princeton(load, np.radians(angle))
        side = 0.015 if stiff else 1e-9
        checks.append(Check(f"y, {load} N at {angle}°", y, stiff, side, "m", not stiff))
        checks.append(Check(f"z, {load} N at {angle}°", z, flap, 0.01, "m"))
    return checks


def _princeton(load: float, angle: float) -> tuple[float, float]:
    beam = straight(0.508, 16, rectangle(12.3777e-3, 3.2024e-3, 0.31), elastic(71.7e9, 0.31))
    direction = np.array([0.0, np.cos(angle), np.sin(angle)])
    push = Force("tip", Site("beam", 16), direction, lambda s: s * load)
    made = model(beam, [clamp()], [push])
    x = made.position(bent(made).q, "beam", 16)
    return x[1], x[2]


@problem("beams", "45° bend out of its plane", "Bathe & Bolourchi 1979; torsion constant stated")
def bend_45() -> list[Check]:
    checks = []
    references = {
        "J = 1/6": (1.0 / 6.0, (15.6847, 47.1501, 53.4755)),
        "J = 0.1406": (0.140577, (15.5578, 46.8919, 53.6078)),
    }
    for name, (torsion, reference) in references.items():
        x = _bend_45(torsion)
        checks += [
            Check(f"tip {axis}, {name}", v, r, 1e-3)
            for axis, v, r in zip("xyz", x, reference, strict=True)
        ]
    return checks


def _bend_45(torsion: float, elements: int = 32) -> Array:
    """Tip of the arc that starts along y and bends towards x, loaded along z."""
    center, axis = np.array([100.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])
    points, axes = arc(center, np.zeros(3), axis, np.pi / 4.0, elements)
    section = general(
        1.0, 1.0 / 12.0, 1.0 / 12.0, torsion, shear_factor_2=5 / 6, shear_factor_3=5 / 6
    )
    beam = Beam("beam", points, axes, section, elastic(1e7), 298.15)
    push = Force("tip", Site("beam", elements), np.array([0, 0, 1.0]), lambda s: 600.0 * s)
    made = model(beam, [clamp()], [push])
    return made.position(bent(made).q, "beam", elements)


@problem("beams", "column after buckling", "Euler elastica, clamped and free end")
def post_buckling() -> list[Check]:
    table = {
        1.151720: (0.741020, 0.593208),
        1.884801: (0.123160, 0.803171),
        9.116218: (-0.577211, 0.421442),
    }
    checks = []
    for load, reference in table.items():
        found = _buckled(load)
        checks += [
            Check(f"{axis}/L at P/P_cr = {load:.4g}", v, r, 1e-3, "", True)
            for axis, v, r in zip("xy", found, reference, strict=True)
        ]
    return checks


def _buckled(factor: float, elements: int = 32) -> tuple[float, float]:
    """Tip of a column that a side load, gone at the end, leads off the straight path."""
    section, material = rectangle(1e-3, 1e-3), elastic(1e9)
    load = factor * np.pi**2 * 1e9 * section.second_moment_2 / 4.0
    tip = Site("beam", elements)
    loads: list[Load] = [
        Force("press", tip, np.array([-1.0, 0.0, 0.0]), partial(mul, load)),
        Force("lead", tip, Y, lambda s: 0.05 * load * s * (1.0 - s)),
    ]
    made = model(straight(1.0, elements, section, material), [clamp()], loads)
    x = made.position(bent(made, 40).q, "beam", elements)
    return x[0], x[1]


@problem("beams", "hanging cable, 16 elements", "catenary of span 100, length 110, unit weight")
def catenary() -> list[Check]:
    """Pulled taut, then let go until the horizontal pull is that of the catenary."""
    pull, area = 65.49639476, 1e-2
    section = general(area, 1e-8, 1e-8, 1e-8)
    cable = straight(110.0, 16, section, elastic(1e9, 0.0, 1.0 / area), "cable")
    joints: list[Joint] = [
        Guide("left", Site("beam", 0), np.eye(3)),
        Guide("right", Site("beam", 16), np.eye(3)[1:]),
    ]
    slack = Force(
        "pull", Site("beam", 16), np.array([1.0, 0, 0]), lambda s: pull * 100.0 ** (1 - s)
    )
    made = model(cable, joints, [slack], gravity=(0.0, -1.0, 0.0))
    q = bent(made, 20).q
    sag = -made.position(q, "beam", 8)[1]
    span = made.position(q, "beam", 16)[0]
    return [Check("span", span, 100.0, 1e-3, "m"), Check("sag", sag, 20.03007907, 1e-3, "m")]


@problem("beams", "free ring in its plane", "Love 1927: n (n² − 1)/√(n² + 1)")
def ring_frequencies() -> list[Check]:
    # stiff out of its plane and in torsion, so that the lowest modes are those in the plane
    section, material, radius = general(5e-4, 4e-9, 4e-6, 4e-6), elastic(70e9, 0.3, 2700.0), 1.0
    halves = [
        _half_ring(name, side * radius, section, material) for name, side in (("a", 1), ("b", -1))
    ]
    joints: list[Joint] = [
        Clamp("top", Site("a", 16), Site("b", 0)),
        Clamp("bottom", Site("b", 16), Site("a", 0)),
    ]
    made = model(halves, joints)
    rest = np.zeros(made.system.m)
    found = modes(made.system, made.system.layout.q0, rest, made.coef, 10).frequencies
    unit = np.sqrt(70e9 * section.second_moment_2 / (2700.0 * section.area * radius**4))
    return [
        Check(
            f"n = {n}",
            found[6 + 2 * (n - 2)],
            unit * n * (n * n - 1) / np.sqrt(n * n + 1) / 2 / np.pi,
            3e-3,
            "Hz",
        )
        for n in (2, 3)
    ]


def _half_ring(name: str, start: float, section: Section, material: Material) -> Beam:
    points, axes = arc(np.zeros(3), np.array([start, 0, 0]), np.array([0, 0, 1.0]), np.pi, 16)
    return Beam(name, points, axes, section, material, ROOM)


@problem("beams", "bending frequencies", "Euler–Bernoulli, λL of each support")
def frequencies() -> list[Check]:
    pinned = Guide("pin", Site("beam", 16), np.eye(3)[1:])
    supports: dict[str, tuple[list[Joint], int, float]] = {
        "cantilever, first": ([clamp()], 0, 1.8751041),
        "cantilever, second": ([clamp()], 2, 4.6940911),
        "clamped and pinned": ([clamp(), pinned], 0, 3.9266023),
        "clamped both ends": ([clamp(), clamp(16)], 0, 4.7300407),
    }
    return [
        Check(name, *_frequency(joints, which, root), 1e-3, "Hz")
        for name, (joints, which, root) in supports.items()
    ]


def _frequency(joints: list[Joint], which: int, root: float) -> tuple[float, float]:
    section, material = rectangle(5e-3, 5e-3), elastic(70e9, 0.3, 2700.0)
    made = model(straight(1.0, 16, section, material), joints)
    rest = np.zeros(made.system.m)
    found = modes(made.system, made.system.layout.q0, rest, made.coef, 4).frequencies[which]
    speed = np.sqrt(70e9 * section.second_moment_2 / (2700.0 * section.area))
    return float(found), float(root**2 * speed / (2.0 * np.pi))


@problem(
    "beams",
    "first frequency of the 65.5 m boom",
    "Euler–Bernoulli thin tube; resonance of Hua et al. 2026, Fig. 30",
)
def boom_frequency() -> list[Check]:
    beam = straight(65.5, 16, tube(0.27, 0.002, 0.33), elastic(69e9, 0.33, 2700.0))
    made = model(beam, [clamp()])
    system = made.system
    found = modes(system, system.layout.q0, np.zeros(system.m), made.coef, 1).frequencies[0]
    return [Check("f1", float(found), 0.12589, 5e-4, "Hz")]


@problem("beams", "frequency under thermal compression", "f/f0 = √(1 − ΔT/ΔT_cr), pinned beam")
def heated_frequency() -> list[Check]:
    height, alpha, E = 0.01, 23.1e-6, 69e9
    across, far = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    pins = [
        Revolute("left", Site("beam", 0), Site(None), across),
        Revolute("right", Site("beam", 16), Site(None, position=far), across),
    ]
    beam = straight(1.0, 16, rectangle(height, 0.02), elastic(E, 0.0, 2700.0, alpha))
    made = model(beam, pins)
    critical = (np.pi * height) ** 2 / (12.0 * alpha)
    checks, cold = [], None
    for part in (0.0, 0.3, 0.6, 0.9):
        hot = made.system.coefficients(sections(made.system, 298.15 + part * critical))
        found = bent(made, 2, hot)
        f = modes(made.system, found.q, found.lam, hot, 1).frequencies[0]
        cold = f if cold is None else cold
        checks.append(Check(f"f/f0 at {part:g} ΔT_cr", f / cold, np.sqrt(1.0 - part), 0.01))
    return checks[1:]
