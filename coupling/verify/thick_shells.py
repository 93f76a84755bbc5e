"""Thick shells: large deflections and thick plates, by families and meshes.

``shell24`` carries directors, ``shell3443`` all slopes; ``LITERAL`` is the latter as a continuum,
without its cure against locking: its errors are there to be compared. References are those of Sze,
Liu & Lo (2004) unless another source is named; they are good to half a percent or so.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from coupling.verify.models import ROOM, Model, bent, elastic, sections
from coupling.verify.registry import Check, Convergence, problem
from mechanics.description import Description, Fixing, Force, Joint, Load, Shell, Site
from mechanics.elements import FAMILIES
from mechanics.modes import modes
from mechanics.system import System
from meshes import surfaces
from meshes.surfaces import Surface

Array = NDArray[np.float64]
Grid = NDArray[np.intp]
Held = tuple[int, str, int]
"""A node, the name of its vector, and the direction 0, 1, 2 along which it stays."""

SZE = "Sze, Liu & Lo 2004"
DIRECTOR, SLOPES, LITERAL = "shell24", "shell3443", "shell3443-continuum"
X, Y, Z = np.eye(3)


def _shell(element: str, surface: Surface, thickness: float, E: float, nu: float) -> Shell:
    return Shell("shell", surface, thickness, elastic(E, nu), ROOM, element=element)


def _grid(surface: Surface, lines: int) -> Grid:
    """Numbers of the nodes, (grid lines of u, ``lines`` of v)."""
    return np.arange(len(surface.points)).reshape(-1, lines)


def _fixings(shell: Shell, held: Iterable[Held]) -> list[Joint]:
    """One joint for each vector that the family has."""
    names = FAMILIES[shell.element].vectors
    directions: dict[tuple[int, str], set[int]] = {}
    for node, vector, axis in held:
        if vector in names:
            directions.setdefault((int(node), vector), set()).add(axis)
    return [
        Fixing(f"{vector} of {node}", "shell", node, vector, np.eye(3)[sorted(axes)])
        for (node, vector), axes in directions.items()
    ]


def _clamped(nodes: Iterable[int]) -> list[Held]:
    vectors = ("position", "r_u", "r_v", "r_n")
    return [(n, vector, i) for n in nodes for vector in vectors for i in range(3)]


def _mirror(nodes: Iterable[int], across: str, axis: int) -> list[Held]:
    """Symmetry about a plane normal to ``axis`` that grid lines ``across`` meet at right angles."""
    within = ("position", "r_n", "r_v" if across == "r_u" else "r_u")
    held = [(n, vector, axis) for n in nodes for vector in within]
    return held + [(n, across, i) for n in nodes for i in range(3) if i != axis]


def _model(shell: Shell, held: Iterable[Held], loads: Sequence[Load]) -> Model:
    system = System(Description([shell], _fixings(shell, held), loads))
    return Model(system, system.coefficients(sections(system)))


def _moved(shell: Shell, held: Iterable[Held], loads: Sequence[Load], steps: int) -> Callable:
    """Displacement (3,) [m] of a node under the full load, as a function."""
    made = _model(shell, held, loads)
    q0, q = made.system.layout.q0, bent(made, steps).q
    return lambda node: made.position(q, "shell", node) - made.position(q0, "shell", node)


def _ramp(size: float) -> Callable[[float], float]:
    return lambda s: s * size


def _push(node: int, direction: Array, size: float) -> Force:
    return Force(f"push {node}", Site("shell", int(node)), direction, _ramp(size))


def _checks(
    found: Sequence[float], names: Sequence[str], references: Sequence[float], mesh: str,
    error: float,
) -> list[Check]:  # fmt: skip
    rows = zip(names, found, references, strict=True)
    return [Check(f"{n}, {mesh}", v, r, error, "m") for n, v, r in rows]


def _edge(surface: Surface, nodes: Grid, per_length: float) -> list[Force]:
    """Forces [N] along z on the nodes of an edge with a load [N/m], half a side to each end."""
    sides = np.linalg.norm(np.diff(surface.points[nodes], axis=0), axis=1)
    halves = 0.5 * per_length * np.append(sides, 0.0)
    sizes = halves + np.roll(halves, 1)
    return [_push(node, Z, size) for node, size in zip(nodes, sizes, strict=True)]


# -- cantilever --------------------------------------------------------------------------------


def cantilever(element: str, elements: int) -> tuple[float, float]:
    """Deflection W and shortening -U of a strip under end shear."""
    surface = surfaces.plate(10.0, 1.0, elements, 1)
    grid = _grid(surface, 2)
    shell = _shell(element, surface, 0.1, 1.2e6, 0.0)
    u = _moved(shell, _clamped(grid[0]), _edge(surface, grid[-1], 4.0), 4)(grid[-1, 0])
    return u[2], -u[0]


@problem("thick_shells", "cantilever under end shear, by families", SZE)
def end_shear() -> list[Check]:
    checks = []
    for element, errors in (
        (DIRECTOR, {8: 6e-3, 16: 3e-3, 32: 2e-3}),
        (SLOPES, {8: 2e-2, 16: 6e-3, 32: 3e-3}),
        (LITERAL, {8: 0.21, 16: 2.2e-2, 32: 1e-3}),
    ):
        for n, error in errors.items():
            found = cantilever(element, n)
            checks += _checks(found, ("W", "-U"), (6.698, 3.286), f"{n} × 1 {element}", error)
    return checks


# -- large deflections of surfaces -------------------------------------------------------------


def annulus(element: str, n_u: int, n_v: int) -> tuple[float, float]:
    """Deflections W_A (inside), W_B [m] of a slit ring lifted along one edge of the slit."""
    surface = surfaces.annulus(6.0, 10.0, n_u, n_v)
    grid = _grid(surface, n_v + 1)
    shell = _shell(element, surface, 0.03, 21e6, 0.0)
    u = _moved(shell, _clamped(grid[:, -1]), _edge(surface, grid[:, 0], 0.8), 10)
    return u(grid[0, 0])[2], u(grid[-1, 0])[2]


def _annulus(element: str, errors: dict[tuple[int, int], float]) -> list[Check]:
    checks = []
    for (n_u, n_v), error in errors.items():
        found = annulus(element, n_u, n_v)
        mesh = f"{n_u} × {n_v}"
        checks += _checks(found, ("W_A", "W_B"), (13.891, 17.528), mesh, error)
    return checks


@problem("thick_shells", "slit annular plate, shell24", SZE)
def annulus_director() -> list[Check]:
    return _annulus(DIRECTOR, {(4, 20): 0.05, (6, 40): 0.02})


@problem("thick_shells", "slit annular plate, shell3443", SZE)
def annulus_slopes() -> list[Check]:
    return _annulus(SLOPES, {(2, 16): 0.05, (4, 20): 0.012})


@problem("thick_shells", "slit annular plate, shell3443 as a continuum: locks", SZE)
def annulus_literal() -> list[Check]:
    return _annulus(LITERAL, {(3, 18): 0.5})


def hemisphere(element: str, n: int) -> tuple[float, float]:
    """Displacements [m] under outward and inward forces on the rim of a hemisphere with a hole."""
    quarter, top = (0.0, 0.5 * np.pi), np.radians(72.0)
    surface = surfaces.sphere(10.0, n, n, (0.0, top), quarter)
    grid = _grid(surface, n + 1)
    held = [*_mirror(grid[0], "r_u", 1), *_mirror(grid[-1], "r_u", 0), (grid[0, 0], "position", 2)]
    out, inward = grid[0, 0], grid[-1, 0]
    loads = [_push(out, X, 200.0), _push(inward, -Y, 200.0)]
    u = _moved(_shell(element, surface, 0.04, 6.825e7, 0.3), held, loads, 4)
    return u(out)[0], u(inward)[1]


def _hemisphere(element: str, errors: dict[int, float]) -> list[Check]:
    checks = []
    for n, error in errors.items():
        found, names = hemisphere(element, n), ("outward", "inward")
        checks += _checks(found, names, (4.07, -8.15), f"{n} × {n}", error)
    return checks


@problem("thick_shells", "pinched hemisphere, shell24", SZE)
def hemisphere_director() -> list[Check]:
    return _hemisphere(DIRECTOR, {8: 0.12, 16: 0.01})


@problem("thick_shells", "pinched hemisphere, shell3443", SZE)
def hemisphere_slopes() -> list[Check]:
    return _hemisphere(SLOPES, {8: 0.13, 10: 0.06})


@problem("thick_shells", "pinched hemisphere, shell3443 as a continuum: locks", SZE)
def hemisphere_literal() -> list[Check]:
    return _hemisphere(LITERAL, {8: 0.7})


def pulled(element: str, n_u: int, n_v: int) -> tuple[float, float, float]:
    """W_A under the force, U_B at its side, U_C at the free end [m] of a cylinder pulled open."""
    surface = surfaces.tube(4.953, 0.5 * 10.35, n_u, n_v, (0.0, 0.5 * np.pi))
    grid = _grid(surface, n_v + 1)
    held = [
        *_mirror(grid[0], "r_u", 1),
        *_mirror(grid[-1], "r_u", 0),
        *_mirror(grid[:, 0], "r_v", 2),
    ]
    shell = _shell(element, surface, 0.094, 10.5e6, 0.3125)
    u = _moved(shell, held, [_push(grid[0, 0], X, 10e3)], 5)
    return u(grid[0, 0])[0], -u(grid[-1, 0])[1], -u(grid[-1, -1])[1]


def _pulled(element: str, errors: dict[tuple[int, int], float]) -> list[Check]:
    names, references, checks = ("W_A", "-U_B", "-U_C"), (2.768, 4.551, 3.269), []
    for (n_u, n_v), error in errors.items():
        found = pulled(element, n_u, n_v)
        checks += _checks(found, names, references, f"{n_u} × {n_v}", error)
    return checks


@problem("thick_shells", "pull-out of an open cylinder, shell24", SZE)
def pull_out_director() -> list[Check]:
    return _pulled(DIRECTOR, {(8, 6): 0.07, (16, 10): 0.015, (24, 16): 0.012})


@problem("thick_shells", "pull-out of an open cylinder, shell3443", SZE)
def pull_out_slopes() -> list[Check]:
    return _pulled(SLOPES, {(8, 6): 0.055, (12, 8): 0.022})


# -- thick plates ------------------------------------------------------------------------------

E, NU, DENSITY = 70e9, 0.3, 2700.0


def _supports(surface: Surface) -> list[Held]:
    """Edges of a square of side 1: they stay in place and their normals do not turn along them.

    No node moves in the plane, for the plate only bends.
    """
    held = [(node, "position", i) for node in range(len(surface.points)) for i in (0, 1)]
    for node, (x, y, _) in enumerate(surface.points):
        if x in (0.0, 1.0):
            held += [(node, "position", 2), (node, "r_v", 2), (node, "r_n", 1)]
        if y in (0.0, 1.0):
            held += [(node, "position", 2), (node, "r_u", 2), (node, "r_n", 0)]
    return held


def first_frequency(element: str, n: int, thickness: float) -> float:
    """Of the simply supported square plate [rad/s]: the lowest mode that bends."""
    surface = surfaces.plate(1.0, 1.0, n, n)
    shell = Shell(
        "shell", surface, thickness, elastic(E, NU, DENSITY), ROOM, element=element
    )  # fmt: skip
    made = _model(shell, _supports(surface), [])
    q0, lam = made.system.layout.q0, np.zeros(made.system.m)
    return 2.0 * np.pi * float(modes(made.system, q0, lam, made.coef, 1).frequencies[0])


def mindlin(thickness: float) -> float:
    """The same by the theory of Mindlin (1951): smaller root of its quadratic in omega^2."""
    h, wave = thickness, 2.0 * np.pi**2
    D, S = E * h**3 / 12.0 / (1.0 - NU**2), 5.0 / 6.0 * E / 2.0 / (1.0 + NU) * h
    m, J = DENSITY * h, DENSITY * h**3 / 12.0
    # m J w^4 - (m (S + D k) + J S k) w^2 + S D k^2 = 0, k the square of the wave number
    roots = np.roots([m * J, -(m * (S + D * wave) + J * S * wave), S * D * wave**2])
    return float(np.sqrt(roots.min()))


@problem("thick_shells", "first frequency of a square plate, a tenth as thick", "Mindlin 1951")
def plate_frequency() -> list[Convergence]:
    sizes, exact = (4, 8, 16), mindlin(0.1)
    return [
        Convergence(
            f"{element}, relative", sizes,
            [abs(first_frequency(element, n, 0.1) / exact - 1.0) for n in sizes], 2.0, 0.25,
        )
        for element in (DIRECTOR, SLOPES)
    ]  # fmt: skip
