"""Orders of convergence of the thermal solvers, on solutions that are made up.

Conductivity and heat capacity depend on temperature, and faces radiate. The light that a chosen
field needs to be a solution is computed here from the differential equations (Roache 2002) and
arrives as irradiation from outside. Errors are root mean squares over the outer face,
of temperatures interpolated as the solver itself does.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import pi

import numpy as np
from numpy.typing import NDArray

from coupling.verify.heat import SIGMA, bar, conductor, still
from coupling.verify.registry import Convergence, problem
from meshes.materials import Material, polynomial
from meshes.sections import Section, rectangle, tube
from meshes.solids import box
from thermal import solvers
from thermal.description import (
    DEFAULT,
    Description,
    Irradiation,
    Member,
    Radiation,
    Settings,
    Side,
    Solid,
)
from thermal.discretisation import Face, at_points

Array = NDArray[np.float64]

LENGTH, EMISSIVITY, SINK = 1.0, 0.8, 200.0
TUBE, BAR = tube(0.1, 0.001), rectangle(0.02, 0.01)
TIME = 200.0  # [s]


def _varying(conductivity: float, heat_capacity: float, slope: float) -> Material:
    """k and c both proportional to 1 + slope (T - 300 K)."""
    k = polynomial("conductivity", "W/(m K)", [conductivity, slope * conductivity], 300.0)
    c = polynomial("heat_capacity", "J/(kg K)", [heat_capacity, slope * heat_capacity], 300.0)
    plain = conductor(conductivity, 2700.0, heat_capacity)
    return replace(plain, conductivity=k, heat_capacity=c)


ALLOY = _varying(120.0, 800.0, 4e-3)
CERAMIC = _varying(1.0, 800.0, 4e-3)


# ------------------------------------------------------------------------------------ members


def _temperature(section: Section, s: Array, phi: Array, t: float) -> tuple[Array, ...]:
    """T, its derivative by time, and first and second ones along and around.

    The ends are insulated; what differs round the section is a first harmonic.
    """
    wave, bend = np.cos(pi * s / LENGTH), pi / LENGTH
    # even at 300 K at the start, so that no solver errs there
    fade = np.sin(1.5 * t / TIME)
    rate = 1.5 / TIME * np.cos(1.5 * t / TIME)
    side = 20.0 * np.cos(phi) if section.kind == "tube" else 0.0 * phi
    turned = 20.0 * np.sin(phi) if section.kind == "tube" else 0.0 * phi
    along = (30.0 + 0.5 * side) * wave
    change = along + side
    return (
        300.0 + fade * change,
        rate * change,
        -fade * bend * (30.0 + 0.5 * side) * np.sin(pi * s / LENGTH),
        -fade * bend**2 * along,
        -fade * (turned + 0.5 * turned * wave),
        -fade * (side + 0.5 * side * wave),
    )


def _light(section: Section, s: Array, phi: Array, t: float, moving: bool) -> Array:
    """Irradiation [W/m^2] of the outer face under which the field is a solution."""
    T, rate, Ts, Tss, Tp, Tpp = _temperature(section, s, phi, t)
    k, slope = ALLOY.conductivity(T), ALLOY.conductivity.derivative(T)
    taken = -(k * Tss + slope * Ts**2)
    if section.kind == "tube":
        taken -= (k * Tpp + slope * Tp**2) / section.radius**2
    if moving:
        taken += ALLOY.density * ALLOY.heat_capacity(T) * rate
    lost = EMISSIVITY * SIGMA * (T**4 - SINK**4)
    return section.area / section.outer_perimeter * taken + lost


def _member(section: Section, elements: int, wall_points: int) -> Description:
    conditions = (Irradiation("light", "bar"), Radiation("space", "bar", EMISSIVITY, still(SINK)))
    m: Member = bar(LENGTH, elements, 300.0, section, ALLOY, wall_points)
    return Description((m,), conditions=conditions)


def _round(face: Face) -> tuple[Array, Array]:
    """Arclength and angle of the points of a face."""
    x = np.concatenate([block.points.reshape(-1, 3) for block in face])
    return x[:, 0], np.arctan2(x[:, 2], x[:, 1])


def _distance(face: Face, T: Array, exact: Array) -> float:
    """Root mean square [K] over a face."""
    found = np.concatenate([at_points(block, T).ravel() for block in face])
    areas = np.concatenate([block.areas.ravel() for block in face])
    return float(np.sqrt(areas @ (found - exact) ** 2 / areas.sum()))


def _settled(name: str, d: Description, settings: Settings, section: Section) -> float:
    """Error of steady temperatures under the light of the end."""
    solver = solvers.build(name, d, settings)
    lit, face = solver.irradiated["light"], solver.space.face(Side("bar"))
    light = {"light": _light(section, *_round(lit), TIME, False)}
    T, _, why = solver.steady(solver.initial(), 0.0, light)
    if why:
        raise RuntimeError(why)
    return _distance(face, T, _temperature(section, *_round(face), TIME)[0])


def _marched(name: str, d: Description, settings: Settings, section: Section, steps: int) -> float:
    """Error at the end of equal steps, each an interval of its own."""
    solver = solvers.build(name, d, replace(settings, steps=1))
    lit, face, h = _round(solver.irradiated["light"]), solver.space.face(Side("bar")), TIME / steps
    T = solver.initial()
    for i in range(steps):
        ends = [_light(section, *lit, t, True) for t in (i * h, (i + 1) * h)]
        T, _, why = solver.advance(T, i * h, h, np.zeros_like(T), {"light": (ends[0], ends[1])})
        if why:
            raise RuntimeError(why)
    return _distance(face, T, _temperature(section, *_round(face), TIME)[0])


QUADRATIC = Settings(order=2)
MEMBERS: Mapping[str, Sequence[tuple[str, Settings, Section, Sequence[int], int, float]]] = {
    "bar": [
        ("line", DEFAULT, BAR, (8, 16, 32), 0, 2.0),
        ("hermite", DEFAULT, BAR, (8, 16, 32), 0, 4.0),
        ("lumped", DEFAULT, BAR, (8, 16, 32), 0, 2.0),
    ],
    "tube": [
        ("line", DEFAULT, TUBE, (8, 16, 32), 0, 2.0),
        ("hermite", DEFAULT, TUBE, (8, 16, 32), 0, 4.0),
        ("lumped", DEFAULT, TUBE, (4, 8, 16), 2, 2.0),
    ],
    "wall": [
        ("wall", DEFAULT, TUBE, (4, 8, 16), 2, 2.0),
        ("wall", QUADRATIC, TUBE, (4, 8, 16), 2, 4.0),
    ],
}
"""Solver, settings, section, elements, wall points for each element (0: 12), order of theory.

Quadratic walls are compared at their nodes, which are better than what lies between.
"""


def _points(section: Section, elements: int, each: int) -> int:
    if section.kind != "tube":
        return 1
    return each * elements if each else 12


def _steady(what: str) -> list[Convergence]:
    found = []
    for name, settings, section, sizes, each, theory in MEMBERS[what]:
        errors = [
            _settled(name, _member(section, n, _points(section, n, each)), settings, section)
            for n in sizes
        ]
        found.append(Convergence(_label(name, settings), sizes, errors, theory, 0.3))
    return found


def _moving(what: str) -> list[Convergence]:
    """Twice the elements and twice the steps: of order 2, as the scheme."""
    found, sizes = [], (4, 8, 16)
    for name, settings, section, _, each, _ in MEMBERS[what]:
        errors = [
            _marched(name, _member(section, n, _points(section, n, each)), settings, section, n)
            for n in sizes
        ]
        found.append(Convergence(_label(name, settings), sizes, errors, 2.0, 0.3))
    return found


def _label(name: str, settings: Settings) -> str:
    return f"{name} of order {settings.order}" if name == "wall" else name


@problem("heat", "steady bar, order in space", "manufactured solution: k(T), radiation")
def steady_bar() -> list[Convergence]:
    return _steady("bar")


@problem("heat", "steady tube, order in space", "manufactured solution: k(T), radiation")
def steady_tube() -> list[Convergence]:
    return _steady("tube")


@problem("heat", "steady wall of a tube, order in space", "manufactured solution: k(T), radiation")
def steady_wall() -> list[Convergence]:
    return _steady("wall")


@problem("heat", "bar, order in space and time", "manufactured solution: k(T), c(T), radiation")
def moving_bar() -> list[Convergence]:
    return _moving("bar")


@problem("heat", "tube, order in space and time", "manufactured solution: k(T), c(T), radiation")
def moving_tube() -> list[Convergence]:
    return _moving("tube")


@problem("heat", "wall, order in space and time", "manufactured solution: k(T), c(T), radiation")
def moving_wall() -> list[Convergence]:
    return _moving("wall")


SCHEMES = {"sdirk2": 2.0, "crank-nicolson": 2.0, "backward-euler": 1.0}


@problem("heat", "schemes, order in time", "manufactured solution: k(T), c(T), radiation")
def schemes() -> list[Convergence]:
    """On a bar of cubic elements, whose error in space is out of sight."""
    found = []
    for scheme, theory in SCHEMES.items():
        steps = (8, 16, 32)
        d, settings = _member(BAR, 24, 1), Settings(scheme=scheme)
        errors = [_marched("hermite", d, settings, BAR, n) for n in steps]
        h = [TIME / n for n in steps]
        found.append(Convergence(scheme, h, errors, theory, 0.2, "s"))
    return found


# -------------------------------------------------------------------------------------- solids

SIZE = 0.1  # [m] of a cube


def _kirchhoff(theta: Array) -> Array:
    """T from theta = int k dT / k(300 K), which obeys a linear equation as k and c are alike."""
    slope = CERAMIC.conductivity.derivative(300.0) / CERAMIC.conductivity(300.0)
    return 300.0 + (np.sqrt(1.0 + 2.0 * slope * theta) - 1.0) / slope


def _potential(x: Array, t: float, moving: bool) -> tuple[Array, Array]:
    """theta [K] and its gradient (n, 3) [K/m]: harmonic, or one that fades."""
    a, k = 8.0, 1.0 / (2700.0 * 800.0)
    cx, cy, sx, sy = (
        np.cos(a * x[:, 0]),
        np.cos(a * x[:, 1]),
        np.sin(a * x[:, 0]),
        np.sin(a * x[:, 1]),
    )
    if moving:
        scale = 60.0 * np.exp(-3.0 * a**2 * k * t)
        cz, sz = np.cos(a * x[:, 2]), -np.sin(a * x[:, 2])
    else:
        scale, b = 20.0, np.sqrt(2.0)
        cz, sz = np.cosh(a * b * x[:, 2]), b * np.sinh(a * b * x[:, 2])
    gradient = a * np.stack([-sx * cy * cz, -cx * sy * cz, cx * cy * sz], axis=1)
    return scale * cx * cy * cz, scale * gradient


def _glow(face: Face, t: float, moving: bool) -> Array:
    """Irradiation [W/m^2] that brings what the solid conducts inwards and radiates."""
    x, normals = (
        np.concatenate([own.reshape(-1, 3) for own in parts])
        for parts in ([b.points for b in face], [b.normals for b in face])
    )
    theta, gradient = _potential(x, t, moving)
    conducted = CERAMIC.conductivity(300.0) * (normals * gradient).sum(1)
    return conducted + EMISSIVITY * SIGMA * (_kirchhoff(theta) ** 4 - SINK**4)


def _cube(family: str, n: int) -> Description:
    mesh = box((SIZE,) * 3, (n, n, n), 1 if family in ("tetra", "hexahedron") else 2, family)
    conditions = (Irradiation("light", "cube"), Radiation("space", "cube", EMISSIVITY, still(SINK)))
    cube = Solid("cube", mesh, {"": CERAMIC}, 300.0)
    return Description(conditions=conditions, solids=(cube,))


def _cube_error(family: str, n: int, steps: int) -> float:
    """Root mean square over the surface; steady for no steps."""
    solver = solvers.build("solid", _cube(family, n), Settings(steps=1))
    face, moving, end = solver.irradiated["light"], steps > 0, 2000.0
    if not moving:
        T, _, why = solver.steady(solver.initial(), 0.0, {"light": _glow(face, 0.0, False)})
    else:
        T, h, why = _kirchhoff(_potential(solver.x, 0.0, True)[0]), end / steps, ""
        for i in range(steps):
            ends = [_glow(face, t, True) for t in (i * h, (i + 1) * h)]
            T, _, why = solver.advance(T, i * h, h, np.zeros_like(T), {"light": (ends[0], ends[1])})
            if why:
                break
    if why:
        raise RuntimeError(why)
    x = np.concatenate([block.points.reshape(-1, 3) for block in face])
    return _distance(face, T, _kirchhoff(_potential(x, end, moving)[0]))


LINEAR = {"hexahedron": 2.0, "tetra": 2.0}
QUADRATICS = {"hexahedron20": 3.0, "hexahedron27": 3.0, "tetra10": 3.0}
"""Families of cells and their order in theory."""


@problem("heat", "steady linear solids, order in space", "Kirchhoff transform, harmonic")
def steady_linear_solids() -> list[Convergence]:
    return _steady_solids(LINEAR, (3, 5, 8))


@problem("heat", "steady quadratic solids, order in space", "Kirchhoff transform, harmonic")
def steady_quadratic_solids() -> list[Convergence]:
    return _steady_solids(QUADRATICS, (2, 3, 4))


def _steady_solids(families: Mapping[str, float], sizes: Sequence[int]) -> list[Convergence]:
    return [
        Convergence(family, sizes, [_cube_error(family, n, 0) for n in sizes], theory, 0.3)
        for family, theory in families.items()
    ]


@problem("heat", "solids, order in space and time", "Kirchhoff transform of a fading wave")
def moving_solids() -> list[Convergence]:
    """k(T) and c(T) alike, radiation; twice the cells and twice the steps."""
    sizes = (2, 4, 8)
    return [
        Convergence(family, sizes, [_cube_error(family, n, n) for n in sizes], theory, 0.3)
        for family, theory in LINEAR.items()
    ]
