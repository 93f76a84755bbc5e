"""Thin shells: the usual large-deflection problems, linear ones, and tubes against beam theory.

Reference values are those of Sze, Liu & Lo (2004), who used a shear-deformable shell on fine
meshes, unless another source is named.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_bvp
from scipy.linalg import expm
from scipy.optimize import brentq

from coupling.verify.models import ROOM, Model, bent, elastic, sections
from coupling.verify.registry import Check, Convergence, problem
from mechanics.description import (
    Description,
    Fixing,
    Force,
    Joint,
    Load,
    Moment,
    Shell,
    Site,
    Traction,
)
from mechanics.modes import modes
from mechanics.system import System
from meshes import surfaces
from meshes.sections import Section, tube
from meshes.surfaces import Surface

Array = NDArray[np.float64]
Held = tuple[int, str, int]
"""A node, the name of its vector, and the direction 0, 1, 2 along which it stays."""

SZE = "Sze, Liu & Lo 2004"
X, Y, Z = np.eye(3)


def _shell(surface: Surface, thickness: float, E: float, nu: float) -> Shell:
    return Shell("shell", surface, thickness, elastic(E, nu), ROOM)


def _numbers(surface: Surface, lines: int) -> NDArray[np.intp]:
    """Numbers of the nodes, (grid lines of u, ``lines`` of v)."""
    return np.arange(len(surface.points)).reshape(-1, lines)


def _fixings(held: Iterable[Held]) -> list[Joint]:
    """One joint for each vector, whatever is said twice about it."""
    directions: dict[tuple[int, str], set[int]] = {}
    for node, vector, axis in held:
        directions.setdefault((int(node), vector), set()).add(axis)
    return [
        Fixing(f"{vector} of {node}", "shell", node, vector, np.eye(3)[sorted(axes)])
        for (node, vector), axes in directions.items()
    ]


def _mirror(nodes: Iterable[int], across: str, axis: int) -> list[Held]:
    """Symmetry about a plane with normal ``axis`` that grid lines ``across`` pass at right angles.

    The mirror image of r_u, where u goes across the plane, is -r_u: it stays normal to the plane.
    """
    along = "r_v" if across == "r_u" else "r_u"
    others = [i for i in range(3) if i != axis]
    held = [(n, vector, axis) for n in nodes for vector in ("position", along)]
    return held + [(n, vector, i) for n in nodes for vector in (across, "r_uv") for i in others]


def _walled(nodes: Iterable[int], across: str, normal: int) -> list[Held]:
    """A flat clamped edge: it stays in place and does not turn, but may stretch across."""
    along = "r_v" if across == "r_u" else "r_u"
    held = [(n, vector, i) for n in nodes for vector in ("position", along) for i in range(3)]
    return held + [(n, vector, normal) for n in nodes for vector in (across, "r_uv")]


def _diaphragm(nodes: Iterable[int]) -> list[Held]:
    """The edge of a cylinder about z, along u, keeps its shape and may warp."""
    return [(n, vector, i) for n in nodes for vector in ("position", "r_u") for i in (0, 1)]


def _model(shell: Shell, held: Sequence[Held], loads: Sequence[Load] = ()) -> Model:
    system = System(Description([shell], _fixings(held), loads))
    return Model(system, system.coefficients(sections(system)))


def _deflected(
    shell: Shell, held: Sequence[Held], loads: Sequence[Load], steps: int
) -> Callable[[int], Array]:
    """Displacement (3,) [m] of a node under the full load, as a function."""
    made = _model(shell, held, loads)
    return _displacement(made, bent(made, steps).q)


def _displacement(made: Model, q: Array) -> Callable[[int], Array]:
    q0 = made.system.layout.q0
    return lambda node: made.position(q, "shell", node) - made.position(q0, "shell", node)


def _ramp(size: float) -> Callable[[float], float]:
    return lambda s: s * size


def _push(name: str, node: int, direction: ArrayLike, size: float) -> Force:
    return Force(name, Site("shell", int(node)), np.asarray(direction, float), _ramp(size))


def _rows(
    names: Sequence[str], found: Sequence[float], references: Sequence[float],
    tolerances: Sequence[float], mesh: str,
) -> list[Check]:  # fmt: skip
    rows = zip(names, found, references, tolerances, strict=True)
    return [Check(f"{n}, {mesh}", v, r, tol, "m") for n, v, r, tol in rows]


# -- cantilever --------------------------------------------------------------------------------


def cantilever(elements: int, load: float) -> tuple[float, float]:
    """Deflection W and shortening -U of the strip under an end shear ``load`` [N]."""
    surface = surfaces.plate(10.0, 1.0, elements, 1)
    grid = _numbers(surface, 2)
    shear = Traction("shear", "shell", Z, _ramp(load), tuple(grid[-1]))
    held = _walled(grid[0], "r_u", 2)
    u = _deflected(_shell(surface, 0.1, 1.2e6, 0.0), held, [shear], 10)(grid[-1, 0])
    return u[2], -u[0]


@problem("shells", "cantilever under end shear", f"{SZE}; Bisshopp & Drucker 1945")
def end_shear() -> list[Check]:
    checks = []
    for part, reference in ((0.2, (2.493, 0.381)), (0.5, (4.933, 1.604)), (1.0, (6.698, 3.286))):
        names = [f"W, {part} P", f"-U, {part} P"]
        checks += _rows(names, cantilever(8, 4.0 * part), reference, (1e-3, 3e-3), "8 × 1")
    names = ["W, elastic line", "-U, elastic line"]
    return [*checks, *_rows(names, cantilever(16, 4.0), strip_theory(4.0), (1e-4, 1e-4), "16 × 1")]


def strip_theory(load: float) -> tuple[float, float]:
    """The same from the energy EA/8 (s^2 - 1)^2 + EI/2 (s theta')^2 of the elastic line.

    s is its stretch, theta its slope; equilibrium of slope and of stretch:
    (EI s^2 theta')' + P s cos theta = 0,  EA/2 (s^2 - 1) s + EI s theta'^2 = P sin theta.
    """
    EA, EI, length = 1.2e5, 100.0, 10.0

    def stretch(theta: Array, M: Array) -> Array:
        s = np.ones_like(theta)
        for _ in range(20):  # M = EI s^2 theta'
            s = 1.0 + (load * np.sin(theta) - M**2 / (EI * s**3)) / (0.5 * EA * (s + 1.0) * s)
        return s

    def slopes(x: Array, y: Array) -> Array:
        theta, M = y[:2]
        s = stretch(theta, M)
        along = np.stack([s * np.sin(theta), s * np.cos(theta) - 1.0])
        return np.vstack([M / (EI * s**2), -load * s * np.cos(theta), along])

    def ends(a: Array, b: Array) -> Array:
        return np.array([a[0], a[2], a[3], b[1]])

    x = np.linspace(0.0, length, 41)
    found = solve_bvp(slopes, ends, x, np.zeros((4, x.size)), tol=1e-9, max_nodes=20000)
    return float(found.y[2, -1]), -float(found.y[3, -1])


@problem("shells", "roll-up of a strip into a circle", f"{SZE}; closed form")
def roll_up() -> list[Check | Convergence]:
    gaps = {n: rolled(n) for n in (6, 12, 24)}
    exact = rolled_theory()
    errors = [float(np.linalg.norm(end - exact)) for end in gaps.values()]
    gap = float(np.linalg.norm(gaps[12])) / 12.0
    return [
        Check("gap, 12 × 1", gap, 0.0, 1e-3, "L", True),
        Convergence("end of the strip, [m]", tuple(gaps), errors, 4.0, 0.5),
    ]


def rolled(elements: int) -> Array:
    """(2,) [m] place of the end of the strip under the moment that makes a circle of it.

    Held r_uv keeps the end straight, as the moment spread evenly over it would.
    """
    surface = surfaces.plate(12.0, 1.0, elements, 1)
    grid = _numbers(surface, 2)
    loads = [
        Moment(f"end {n}", Site("shell", int(n)), -Y, _ramp(25.0 * np.pi / 3.0)) for n in grid[-1]
    ]
    held = _walled(grid[0], "r_u", 2) + [(n, "r_uv", i) for n in grid[-1] for i in range(3)]
    made = _model(_shell(surface, 0.1, 1.2e6, 0.0), held, loads)
    return made.position(bent(made, 20).q, "shell", int(grid[-1, 0]))[[0, 2]]


def rolled_theory() -> Array:
    """The same: M = EI s^2 theta' is constant, and EA/2 (s^2 - 1) + EI theta'^2 = 0."""
    EA, EI, M, length = 1.2e5, 100.0, 50.0 * np.pi / 3.0, 12.0
    s = 1.0
    for _ in range(50):
        s = np.sqrt(1.0 - 2.0 * M**2 / (EA * EI * s**4))
    turn = M / (EI * s**2)
    return s / turn * np.array([np.sin(turn * length), 1.0 - np.cos(turn * length)])


# -- large deflections of surfaces -------------------------------------------------------------


def annulus(n_u: int, n_v: int, part: float = 1.0) -> tuple[float, float]:
    """Deflections W_A (inside), W_B [m] of a slit ring lifted along one edge of the slit."""
    surface = surfaces.annulus(6.0, 10.0, n_u, n_v)
    grid = _numbers(surface, n_v + 1)
    lift = Traction("lift", "shell", Z, _ramp(0.8 * part), tuple(grid[:, 0]))
    held = _walled(grid[:, -1], "r_v", 2)
    u = _deflected(_shell(surface, 0.03, 21e6, 0.0), held, [lift], 10)
    return u(grid[0, 0])[2], u(grid[-1, 0])[2]


@problem("shells", "slit annular plate lifted at the slit", SZE)
def slit_annulus() -> list[Check]:
    """The references are above the limit of thin shells, 13.85 and 17.49."""
    names, reference = ("W_A", "W_B"), (13.891, 17.528)
    coarse = _rows(names, annulus(3, 18), reference, (0.02, 0.02), "3 × 18")
    fine = _rows(names, annulus(4, 28), reference, (5e-3, 5e-3), "4 × 28")
    return [*coarse, *fine]


def hemisphere(n: int, load: float = 400.0) -> tuple[float, float]:
    """Displacements [m] under outward and inward forces on the rim of a hemisphere with a hole."""
    quarter, top = (0.0, 0.5 * np.pi), np.radians(72.0)
    surface = surfaces.sphere(10.0, n, n, (0.0, top), quarter)
    grid = _numbers(surface, n + 1)
    held = [*_mirror(grid[0], "r_u", 1), *_mirror(grid[-1], "r_u", 0)]
    held.append((grid[0, 0], "position", 2))
    out, inward = (grid[0, 0], grid[-1, 0])
    loads = [_push("out", out, X, 0.5 * load), _push("in", inward, -Y, 0.5 * load)]
    u = _deflected(_shell(surface, 0.04, 6.825e7, 0.3), held, loads, 10)
    return u(out)[0], u(inward)[1]


@problem("shells", "pinched hemisphere with a hole of 18 degrees", SZE)
def pinched_hemisphere() -> list[Check]:
    names, reference = ("outward", "inward"), (4.07, -8.15)
    coarse = _rows(names, hemisphere(4), reference, (0.03, 0.03), "4 × 4")
    return [*coarse, *_rows(names, hemisphere(8), reference, (0.01, 0.01), "8 × 8")]


def pulled(n: int, load: float = 40e3) -> tuple[float, float, float]:
    """W_A under the force, U_B at its side and U_C at the free end [m] of a cylinder pulled open.

    One eighth of it, with smaller elements where the force acts.
    """
    even = np.linspace(0.0, 1.0, n + 1)
    lines = list(0.2 * even + 0.8 * even**3)
    surface = surfaces.tube(4.953, 0.5 * 10.35, lines, lines, (0.0, 0.5 * np.pi))
    grid = _numbers(surface, n + 1)
    held = [
        *_mirror(grid[0], "r_u", 1),
        *_mirror(grid[-1], "r_u", 0),
        *_mirror(grid[:, 0], "r_v", 2),
    ]
    loads = [_push("pull", grid[0, 0], X, 0.25 * load)]
    u = _deflected(_shell(surface, 0.094, 10.5e6, 0.3125), held, loads, 10)
    return u(grid[0, 0])[0], -u(grid[-1, 0])[1], -u(grid[-1, -1])[1]


@problem("shells", "pull-out of an open cylinder", SZE)
def pull_out() -> list[Check]:
    """Without shear deformation the point under the force itself stays 1.3 % behind."""
    names, reference = ("W_A", "-U_B", "-U_C"), (2.768, 4.551, 3.269)
    coarse = _rows(names, pulled(6), reference, (0.03, 0.01, 0.01), "6 × 6")
    return [*coarse, *_rows(names, pulled(10), reference, (0.015, 5e-3, 5e-3), "10 × 10")]


# -- small deflections -------------------------------------------------------------------------

SMALL = 1e-4
"""Part of the load at which a deflection is still linear in it."""


def pressed(n: int) -> float:
    """Deflection [m] in the middle of a supported plate under pressure, n × n elements."""
    surface = surfaces.plate(1.0, 0.6, n, n)
    grid = _numbers(surface, n + 1)
    placed: list[Held] = [(grid[0, 0], "position", i) for i in (0, 1)]
    placed.append((grid[-1, 0], "position", 1))
    rims = ((grid[[0, -1]], "r_v"), (grid[:, [0, -1]], "r_u"))
    rim: list[Held] = [
        (int(k), v, 2) for edge, along in rims for k in edge.ravel() for v in ("position", along)
    ]
    load = Traction("pressure", "shell", Z, _ramp(SMALL))
    u = _deflected(_shell(surface, 0.01, 70e9, 0.3), [*placed, *rim], [load], 1)
    return u(grid[n // 2, n // 2])[2] / SMALL


@problem("shells", "supported plate under pressure", "Navier 1823, double series")
def supported_plate() -> list[Check | Convergence]:
    D, a, b = 70e9 * 0.01**3 / 12.0 / (1.0 - 0.3**2), 1.0, 0.6
    m, n = np.meshgrid(np.arange(1, 400, 2), np.arange(1, 400, 2))
    signs = np.sin(0.5 * np.pi * m) * np.sin(0.5 * np.pi * n)
    exact = 16.0 / (np.pi**6 * D) * np.sum(signs / (m * n * ((m / a) ** 2 + (n / b) ** 2) ** 2))
    sizes = (4, 8, 16)
    found = [pressed(k) for k in sizes]
    errors = [abs(w / exact - 1.0) for w in found]
    return [
        Check("deflection at 1 Pa, 8 × 8", found[1], exact, 1e-4, "m"),
        Convergence("deflection, relative", sizes, errors, 4.0, 0.3),
    ]


def roof(n: int) -> float:
    """Deflection [m] in the middle of the free edge of a barrel roof; one quarter of it."""
    half = np.radians(40.0)
    surface = surfaces.tube(25.0, 25.0, n, n, (0.5 * np.pi - half, 0.5 * np.pi))
    grid = _numbers(surface, n + 1)
    held = [*_mirror(grid[-1], "r_u", 0), *_mirror(grid[:, 0], "r_v", 2), *_diaphragm(grid[:, -1])]
    weight = Traction("weight", "shell", -Y, _ramp(90.0 * SMALL))
    u = _deflected(_shell(surface, 0.25, 4.32e8, 0.0), held, [weight], 1)
    return -u(grid[0, 0])[1] / SMALL


@problem("shells", "Scordelis-Lo roof", "Scordelis & Lo 1964; MacNeal & Harder 1985")
def scordelis_lo() -> list[Check]:
    return [Check(f"deflection, {n} × {n}", roof(n), 0.302, 0.01, "m") for n in (4, 8)]


def pinched(n: int) -> float:
    """Deflection [m] under two opposite unit forces on a cylinder; one eighth of it."""
    surface = surfaces.tube(300.0, 300.0, n, n, (0.0, 0.5 * np.pi))
    grid = _numbers(surface, n + 1)
    held = [*_mirror(grid[0], "r_u", 1), *_mirror(grid[-1], "r_u", 0)]
    held += [*_mirror(grid[:, 0], "r_v", 2), *_diaphragm(grid[:, -1])]
    u = _deflected(_shell(surface, 3.0, 3e6, 0.3), held, [_push("pinch", grid[0, 0], -X, 0.25)], 1)
    return -u(grid[0, 0])[0]


def pinched_theory(count: int) -> float:
    """The same by a double Fourier series of ``count`` terms each way.

    Odd ones along and even ones around satisfy diaphragms and symmetry; the strains are
    u_z, v_s + w/R, u_s + v_z and w_zz, w_ss - 2 v_s/R - w/R^2, 2 (w_sz - v_z/R), which are those
    of Koiter (1966) for small displacements of the cylinder.
    """
    R, length, h, E, nu = 300.0, 600.0, 3.0, 3e6, 0.3
    m, n = np.meshgrid((2 * np.arange(count) + 1) * np.pi / length, 2 * np.arange(count) / R)
    o = np.zeros_like(m)
    membrane = [(-m, o, o), (o, n, o + 1.0 / R), (-n, m, o)]
    bending = [
        (o, o, -m * m),
        (o, -2.0 * n / R, -n * n - 1.0 / R**2),
        (o, -2.0 * m / R, -2.0 * m * n),
    ]
    plane = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    C = E * h / (1.0 - nu**2) * plane
    K = np.zeros((*m.shape, 3, 3))
    for rows, stiffness in ((membrane, C), (bending, h**2 / 12.0 * C)):
        B = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        K += np.swapaxes(B, -1, -2) @ stiffness @ B
    area = 0.5 * np.pi * R * length * np.where(n == 0.0, 2.0, 1.0)
    return float(np.sum(2.0 * np.linalg.inv(K)[..., 2, 2] / area))


@problem(
    "shells", "pinched cylinder with diaphragms", "Lindberg, Olson & Cowper 1969; Fourier series"
)
def pinched_cylinder() -> list[Check | Convergence]:
    """Under a point force the deflection converges with the square of the element size.

    The series does so as well, with the square of its terms. Its limit is 0.2 % above the published
    value, which many others call converged.
    """
    exact = (4.0 * pinched_theory(200) - pinched_theory(100)) / 3.0
    sizes = (6, 12, 24)
    found = [pinched(n) for n in sizes]
    errors = [abs(w / exact - 1.0) for w in found]
    return [
        Check("deflection, 24 × 24, against the published value", found[2], 1.8248e-5, 0.01, "m"),
        Check("deflection, 24 × 24, against the series", found[2], exact, 5e-3, "m"),
        Convergence("deflection, relative", sizes, errors, 2.0, 0.2),
    ]


# -- tubes as beams ----------------------------------------------------------------------------

RADIUS, WALL, LENGTH = 0.0125, 0.001, 1.0
"""Mean radius, thickness and length [m] of the tube."""
ALUMINIUM = elastic(69e9, 0.33, 2700.0, 23.1e-6)


def _tube(n_u: int, n_v: int) -> tuple[Shell, NDArray[np.intp]]:
    surface = surfaces.tube(RADIUS, LENGTH, n_u, n_v)
    return Shell("shell", surface, WALL, ALUMINIUM, ROOM), _numbers(surface, n_v + 1)


def _ring(nodes: Iterable[int]) -> list[Held]:
    """The end of a tube stays in place; its wall may turn there."""
    return [(n, vector, i) for n in nodes for vector in ("position", "r_u") for i in range(3)]


def tube_tip(n_u: int, n_v: int, load: float) -> float:
    """Deflection [m] of the tip of a tube whose root ring stays in place."""
    shell, grid = _tube(n_u, n_v)
    rim = (*grid[:, -1], grid[0, -1])
    shear = Traction("tip", "shell", X, _ramp(load / (2.0 * np.pi * RADIUS)), rim)
    u = _deflected(shell, _ring(grid[:, 0]), [shear], 1)
    return float(np.mean([u(n)[0] for n in grid[:, -1]]))


@problem("shells", "tube as a cantilever", "Timoshenko 1921; Cowper 1966")
def tube_cantilever() -> list[Check]:
    """Deflection P L^3/(3 E I) + P L/(k G A), k = 2 (1 + nu)/(4 + 3 nu)."""
    section, load, nu = tube(RADIUS, WALL, 0.33), 0.1, 0.33
    k, G = 2.0 * (1.0 + nu) / (4.0 + 3.0 * nu), 69e9 / 2.66
    bending = load * LENGTH**3 / (3.0 * 69e9 * section.second_moment_2)
    exact = bending + load * LENGTH / (k * G * section.area)
    rows = ((8, 4, 5e-3), (16, 8, 1e-3))
    return [Check(f"tip, {a} × {b}", tube_tip(a, b, load), exact, tol, "m") for a, b, tol in rows]


def tube_bow(n_u: int, n_v: int, gradient: float) -> float:
    """Sag [m] of a free tube in a temperature that rises by ``gradient`` [K/m] along x."""
    shell, grid = _tube(n_u, n_v)
    root = grid[:, 0]
    held: list[Held] = [(n, vector, 2) for n in root for vector in ("position", "r_u")]
    held += [(root[0], "position", 1), (root[n_u // 2], "position", 1)]
    held.append((root[n_u // 4], "position", 0))
    made = _model(shell, held)
    T = sections(made.system)
    at, x = made.system.layout.point_index["shell"], shell.surface.points[:, 0]
    T[at, 0] += gradient * x
    T[at, 2] = gradient * x / RADIUS
    u = _displacement(made, bent(made, 2, made.system.coefficients(T)).q)
    return -u(int(grid[n_u // 4, -1]))[0]


@problem("shells", "thermal bow of a tube", "closed form, curvature alpha G")
def thermal_bow() -> list[Check | Convergence]:
    """Temperature, linear between N nodes around, bends (sin(pi/N)/(pi/N))^2 times as far."""
    gradient, sizes = 4000.0, (8, 16, 32)
    found = [tube_bow(n, 4, gradient) for n in sizes]
    exact = _sag(23.1e-6 * gradient)
    fewer = _sag(23.1e-6 * gradient * np.sinc(1.0 / 8.0) ** 2)
    errors = [abs(sag / exact - 1.0) for sag in found]
    return [
        Check("sag, 8 nodes around, against theory for 8", found[0], fewer, 1e-3, "m"),
        Check("sag, 32 nodes around", found[-1], exact, 5e-3, "m"),
        Convergence("sag, relative", sizes, errors, 2.0, 0.1, "nodes around"),
    ]


def _sag(curvature: float) -> float:
    return (1.0 - np.cos(curvature * LENGTH)) / curvature


@problem("shells", "first frequency of a cantilever tube", "Timoshenko 1921; Cowper 1966")
def tube_frequency() -> list[Check]:
    exact, rows = _timoshenko(tube(RADIUS, WALL, 0.33)), []
    for n_u, n_v, tolerance in ((8, 4, 5e-3), (16, 8, 1e-3)):
        shell, grid = _tube(n_u, n_v)
        made = _model(shell, _ring(grid[:, 0]))
        system = made.system
        f = modes(system, system.layout.q0, np.zeros(system.m), made.coef, 1).frequencies[0]
        rows.append(Check(f"first, {n_u} × {n_v}", float(f), exact, tolerance, "Hz"))
    return rows


def _timoshenko(section: Section) -> float:
    """First frequency [Hz] of a cantilever, from deflection, rotation, moment, shear force."""
    E, G, rho = 69e9, 69e9 / 2.66, 2700.0
    A, inertia = section.area, section.second_moment_2

    def missing(omega: float) -> float:
        slopes = np.zeros((4, 4))
        slopes[0, 1], slopes[0, 3] = 1.0, 1.0 / (section.shear_factor_2 * G * A)
        slopes[1, 2], slopes[2, 3] = 1.0 / (E * inertia), -1.0
        slopes[2, 1], slopes[3, 0] = -rho * inertia * omega**2, -rho * A * omega**2
        return float(np.linalg.det(expm(slopes * LENGTH)[2:, 2:]))

    slender = 1.8751041**2 / LENGTH**2 * np.sqrt(E * inertia / (rho * A))
    return float(brentq(missing, 0.9 * slender, 1.01 * slender)) / (2.0 * np.pi)
