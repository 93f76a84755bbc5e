"""Buckling, snapping, and what comes after."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from operator import mul

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from coupling.verify.models import ROOM, Model, clamp, elastic, model, sections, straight
from coupling.verify.registry import Check, Convergence, Result, problem
from mechanics.arclength import BIFURCATION, LIMIT, Event, Path, Point, branch, follow
from mechanics.buckling import buckling
from mechanics.description import (
    Beam,
    Clamp,
    Description,
    Fixing,
    Force,
    Guide,
    Joint,
    Load,
    Particle,
    Revolute,
    Shell,
    Site,
    Spring,
    Traction,
)
from mechanics.statics import Allowed, newton
from mechanics.system import System
from meshes import surfaces
from meshes.generate import arc, line
from meshes.sections import Section, general, rectangle

Array = NDArray[np.float64]
Held = tuple[NDArray[np.intp], tuple[str, ...], tuple[int, ...]]
"""Nodes, their vectors, and the directions 0, 1, 2 along which these stay."""

X, Y, Z = np.eye(3)
RIGID_IN_SHEAR = 1e3
"""Shear factor of a beam that has no shear deformation to speak of."""


def slim(area: float, second_moment: float, torsion: float | None = None) -> Section:
    """A section with equal second moments and no shear deformation."""
    J = 2.0 * second_moment if torsion is None else torsion
    shear = RIGID_IN_SHEAR
    return general(
        area, second_moment, second_moment, J, shear_factor_2=shear, shear_factor_3=shear
    )


def first(path: Path, kind: str) -> Event:
    """The first event of a kind; an error if there is none."""
    for event in path.events:
        if event.kind == kind:
            return event
    raise RuntimeError(path.why or f"no {kind} up to load {path.loads.max():.6g}")


def followed(made: Model, until: Callable[[Point], bool], **more) -> Path:
    path = follow(made.system, made.coef, made.coef, until=until, **more)
    if path.why:
        raise RuntimeError(path.why)
    return path


# ------------------------------------------------------------------------------------- snapping


@problem("stability", "snap-through of a roof of two bars", "von Mises 1923, closed form")
def roof() -> list[Result]:
    """Springs from (-1, 0) and (1, 0) to a top at height h: P = 2 k w (L0/L - 1)."""
    height, k = 0.2, 1e3
    free = np.hypot(1.0, height)
    joints: list[Joint] = [
        Guide("plane", Site("top"), np.array([X, Z])),
        Spring("left", Site("top"), Site(None, position=-X), k),
        Spring("right", Site("top"), Site(None, position=X), k),
    ]
    push = Force("push", Site("top"), -Y, lambda s: s)
    made = model(Particle("top", height * Y, 1.0), joints, [push])
    path = followed(made, lambda p: bool(p.y[1] < -1.2 * height), arc=5e-3, largest=2e-2)
    # dP/dw = 0 where L^3 = L0
    w = np.sqrt(free ** (2.0 / 3.0) - 1.0)
    limit = 2.0 * k * w * (free / np.hypot(1.0, w) - 1.0)
    top, bottom = (e.point for e in path.events)
    last = path.points[-1]
    height_then = float(last.y[1])
    carried = 2.0 * k * height_then * (free / np.hypot(1.0, height_then) - 1.0)
    return [
        Check("limit load", top.load, limit, 1e-8, "N"),
        Check("height at the limit", float(top.y[1]), w, 1e-3, "m"),
        Check("load after the snap", bottom.load, -limit, 1e-8, "N"),
        Check("on the way up again", last.load, carried, 1e-6, "N"),
    ]


def _shallow(steepness: float, elements: int) -> tuple[Model, float]:
    """Arch y = a sin(pi x/L) on hinges under a load of the same shape; unit of load EI k^4 r."""
    L, E, area = 1.0, 1e9, 1e-4
    r = 1e-3
    bending, a, k = E * area * r * r, steepness * r, np.pi / L
    x = np.linspace(0.0, L, elements + 1)
    points = np.stack([x, a * np.sin(k * x), 0.0 * x], axis=1)
    e1 = np.stack([np.ones_like(x), a * k * np.cos(k * x), 0.0 * x], axis=1)
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    axes = np.stack([e1, np.cross(Z, e1), np.broadcast_to(Z, e1.shape)], axis=1)
    beam = Beam("beam", points, axes, slim(area, bending / E), elastic(E), ROOM)
    far = Site(None, position=L * X)
    joints: list[Joint] = [
        Revolute("left", Site("beam", 0), Site(None), Z),
        Revolute("right", Site("beam", elements), far, Z),
    ]
    unit = bending * k**4 * r * L / elements
    loads: list[Load] = [
        Force(f"f{i}", Site("beam", i), -Y, partial(mul, unit * np.sin(k * x[i])))
        for i in range(1, elements)
    ]
    return model(beam, joints, loads), r


@problem("stability", "shallow sinusoidal arch", "Fung & Kaplan 1952, in closed form")
def shallow_arch() -> list[Result]:
    """With b the remaining rise, all in radii of gyration: q = a - b + b (a^2 - b^2)/4.

    The load turns where dq/db = 0; before that, for a > sqrt(22), the arch sways where its
    thrust reaches the second Euler load: b = sqrt(a^2 - 16), q = a + 3 b.
    """
    checks: list[Result] = []
    made, r = _shallow(4.0, 16)
    event = first(followed(made, _turned, arc=5e-4, largest=1e-3), LIMIT)
    b = np.sqrt((16.0 - 4.0) / 3.0)
    checks.append(
        Check("limit load, a = 4 r", event.point.load, 4 - b + b * (16 - b * b) / 4, 1e-3)
    )
    made, r = _shallow(7.0, 16)
    event = first(followed(made, _turned, arc=5e-4, largest=1e-3), BIFURCATION)
    b = np.sqrt(49.0 - 16.0)
    checks.append(Check("it sways, a = 7 r", event.point.load, 7 + 3 * b, 1e-3))
    height = made.position(event.point.y, "beam", 8)[1] / r
    checks.append(Check("its rise then", float(height), b, 2e-3, "r"))
    return checks


def _turned(p: Point) -> bool:
    """Past the limit load, or too far."""
    return p.slope < 0.0 or p.load > 100.0


@problem("stability", "frame of two bars on hinges", "Lee, Manuel & Rossow 1968")
def lee_frame() -> list[Result]:
    """Bars of 120 cm, 3 x 2 cm, E = 720 kN/cm^2, loaded 24 cm from the corner: lengths in cm, kN.

    A published load, not computed otherwise here.
    """
    path = followed(lee(10), _turned_down, arc=2e-2, largest=4e-2)
    return [Check("limit load", first(path, LIMIT).point.load, 1.855, 3e-3, "kN")]


def lee(elements: int, load: float = 1.0) -> Model:
    """The frame under ``load`` [kN]."""
    section, material = rectangle(2.0, 3.0), elastic(720.0, 0.3)
    parts = []
    for name, start, end in (("column", 0.0 * Y, 120 * Y), ("girder", 120 * Y, 120 * (X + Y))):
        points, axes = line(start, end, elements, Z)
        axes = axes[:, [0, 2, 1]] * np.array([1.0, -1.0, 1.0])[:, None]
        parts.append(Beam(name, points, axes, section, material, ROOM))
    joints: list[Joint] = [
        Revolute("foot", Site("column", 0), Site(None), Z),
        Clamp("corner", Site("column", elements), Site("girder", 0)),
        Revolute("end", Site("girder", elements), Site(None, position=120 * (X + Y)), Z),
    ]
    push = Force("push", Site("girder", elements // 5), -Y, partial(mul, load))
    return model(parts, joints, [push])


@problem("stability", "deep arch, one end clamped", "DaDeppo & Schmidt 1975")
def deep_arch() -> list[Result]:
    """Radius 100 over 215 degrees, EI = 1e6, EA = 1e8, loaded at the crown: it falls aside.

    A published load, not computed otherwise here.
    """
    path = followed(_deep_arch(64), _turned_down, arc=5e-2, largest=0.1)
    return [Check("limit load", first(path, LIMIT).point.load, 897.0, 1e-3)]


def _turned_down(p: Point) -> bool:
    return p.slope < 0.0


def _deep_arch(elements: int) -> Model:
    half = np.radians(215.0) / 2.0
    start = 100.0 * np.array([-np.sin(half), np.cos(half), 0.0])
    points, axes = arc(np.zeros(3), start, -Z, 2.0 * half, elements)
    beam = Beam("beam", points, axes, slim(1.0, 1e-2), elastic(1e8), ROOM)
    joints: list[Joint] = [
        clamp_at("clamp", points[0], 0),
        Revolute("hinge", Site("beam", elements), Site(None, position=points[-1]), Z),
    ]
    push = Force("push", Site("beam", elements // 2), -Y, lambda s: s)
    return model(beam, joints, [push])


def clamp_at(name: str, position: Array, node: int) -> Clamp:
    """A node of "beam" clamped where it is."""
    return Clamp(name, Site("beam", node), Site(None, position=position))


@problem("stability", "hinged cylindrical roof, 12.7 mm", "Sze, Liu & Lo 2004, tables; in N, mm")
def thick_roof() -> list[Check]:
    """It snaps. Without shear deformation the point under the force stays behind by 1 to 2 %."""
    made, crown = cylindrical_roof(8, 12.7)
    path = followed(made, _turned_down, arc=2e-3, largest=2e-2)
    top = first(path, LIMIT).point
    checks = [Check("limit load", ROOF_LOAD * top.load, 0.7421 * ROOF_LOAD, 2e-3, "N")]
    for part, reference in {0.3473: 3.087, 0.5647: 5.802, 0.7246: 9.339}.items():
        before = [p for p in path.points if p.load < part and p.slope > 0.0]
        exact = newton(made.system, before[-1].y, part, made.coef, Allowed(1e-10, 30, np.inf))
        depth = _deflection(made, crown, exact.y)
        checks.append(Check(f"deflection at {part} of 3 kN", depth, reference, 0.025, "mm"))
    return checks


@problem("stability", "hinged cylindrical roof, 6.35 mm", "Sze, Liu & Lo 2004, tables; in N, mm")
def thin_roof() -> list[Check]:
    """It snaps back: the crown rises again before the force, which must pull by then, turns.

    What is stored at the end is the work of the force on the whole path there.
    """
    made, crown = cylindrical_roof(6, 6.35)
    path = followed(made, _snapped, arc=2e-3, largest=1e-2)
    top, bottom = (e.point for e in path.events)
    depths = np.array([_deflection(made, crown, p.y) for p in path.points])
    if not _deflection(made, crown, bottom.y) < depths.max() - 1.0:
        raise RuntimeError("it did not snap back")
    end = path.points[-1].y
    stored = float(made.system.energies(end, np.zeros_like(end), made.coef)[0])
    work = 0.25 * ROOF_LOAD * _integral(path.loads, depths)
    return [
        Check("limit load", ROOF_LOAD * top.load, 0.1953 * ROOF_LOAD, 3e-3, "N"),
        Check("stored at the end", stored, work, 5e-3, "N mm"),
    ]


def _integral(y: Array, x: Array) -> float:
    """Of y dx along a curve through points, by splines of its length."""
    chords = np.hypot(np.diff(x) / np.ptp(x), np.diff(y) / np.ptp(y))
    length = np.concatenate([[0.0], np.cumsum(chords)])
    fine = np.linspace(0.0, length[-1], 2000)
    along, across = (CubicSpline(length, values)(fine) for values in (x, y))
    return float(np.trapezoid(across, along))


def _snapped(p: Point) -> bool:
    """On the far side: no limit load comes near this one."""
    return p.load > 0.5


ROOF_LOAD = 3000.0
"""Force in the middle of the whole roof at load factor 1 [N]."""


def cylindrical_roof(elements: int, thickness: float) -> tuple[Model, int]:
    """A quarter of a shallow cylinder on hinges along its straight edges, and the loaded node."""
    surface = surfaces.tube(2540.0, 254.0, elements, elements, (0.5 * np.pi - 0.1, 0.5 * np.pi))
    grid = np.arange(len(surface.points)).reshape(elements + 1, -1)
    shell = Shell("shell", surface, thickness, elastic(3102.75, 0.3), ROOM)
    rows: list[Held] = [
        (grid[0], ("position", "r_v"), (0, 1, 2)),
        (grid[-1], ("position", "r_v"), (0,)), (grid[-1], ("r_u", "r_uv"), (1, 2)),
        (grid[:, 0], ("position", "r_u"), (2,)), (grid[:, 0], ("r_v", "r_uv"), (0, 1)),
    ]  # fmt: skip
    crown = int(grid[-1, 0])
    push = Force("push", Site("shell", crown), -Y, partial(mul, 0.25 * ROOF_LOAD))
    return _shell_model(shell, rows, [push]), crown


def _shell_model(shell: Shell, rows: Sequence[Held], loads: Sequence[Load]) -> Model:
    """A shell some of whose nodes do not move."""
    held = defaultdict[tuple[int, str], set[int]](set)
    for nodes, vectors, axes in rows:
        for node, vector in product(nodes, vectors):
            held[int(node), vector].update(axes)
    joints = [
        Fixing(f"{vector} of {node}", "shell", node, vector, np.eye(3)[sorted(axes)])
        for (node, vector), axes in held.items()
    ]
    system = System(Description([shell], joints, loads))
    return Model(system, system.coefficients(sections(system)))


def _deflection(made: Model, node: int, y: Array) -> float:
    moved = made.position(y, "shell", node) - made.position(made.system.layout.q0, "shell", node)
    return -float(moved[1])


# ------------------------------------------------------------------------------------- buckling


@problem("stability", "thermal buckling, h = 10 mm, L = 1 m", "Euler: α ΔT = (β π)² I/(A L²)")
def thermal_buckling() -> list[Result]:
    """The heated bar is thicker, too, which raises the load by about 3 α ΔT."""
    expansion, height = 23.1e-6, 0.01
    unit = (np.pi * height) ** 2 / 12.0 / expansion
    ends: dict[str, tuple[Callable[[int], list[Joint]], float]] = {
        "clamped": (lambda n: [clamp(), clamp_at("far", X, n)], 14.241853),
        "pinned": (lambda n: [_pin("a", 0, 0.0 * X), _pin("b", n, X)], 3.560463),
        "clamped and pinned": (lambda n: [clamp(), _pin("far", n, X)], 7.283812),
    }
    found: list[Result] = []
    for name, (joints, reference) in ends.items():
        critical = _critical_heating(joints(16), 16, unit)
        found.append(Check(f"ΔT_cr, {name}", critical, reference, 1e-3, "K"))
    return found


@problem("stability", "Euler column, linear buckling", "Euler: P = π² EI/(4 L²)")
def euler() -> list[Result]:
    sizes, found = (2, 4, 8), []
    for n in sizes:
        made = _column(n, 10.0)
        found.append(float(buckling(made.system, made.coef, made.coef).factors[0]))
    errors = [abs(p - 1.0) for p in found]
    return [
        Check("critical load, 8 elements", found[-1], 1.0, 1e-5, "P_cr"),
        Convergence("critical load", sizes, errors, 4.0, 0.2),
    ]


def _pin(name: str, node: int, position: Array) -> Joint:
    return Revolute(name, Site("beam", node), Site(None, position=position), Z)


def _critical_heating(joints: list[Joint], elements: int, unit: float) -> float:
    """Heating [K] at which a bar between walls buckles in the plane of its hinges."""
    height = 0.01
    section = general(
        height**2, height**4 / 12.0, height**4 / 3.0, height**4,
        shear_factor_2=RIGID_IN_SHEAR, shear_factor_3=RIGID_IN_SHEAR,
    )  # fmt: skip
    made = model(straight(1.0, elements, section, elastic(69e9, 0.0, 1.0, 23.1e-6)), joints)
    hot = made.system.coefficients(sections(made.system, ROOM + unit))
    return float(buckling(made.system, made.coef, hot).factors[0]) * unit


@problem("stability", "square plate in compression", "Bryan 1891: N = 4 π² D/b²")
def plate() -> list[Result]:
    """Shell, supported on all edges, pressed from two sides."""
    sizes = (2, 4, 8)
    found = [_plate(n) for n in sizes]
    return [
        Check("critical load, 8 × 8", found[-1], 1.0, 1e-4, "N_cr"),
        Convergence("critical load", sizes, [abs(p - 1.0) for p in found], 4.0, 0.3),
    ]


def _plate(elements: int) -> float:
    thickness, E, nu = 1e-2, 70e9, 0.3
    surface = surfaces.plate(1.0, 1.0, elements, elements)
    grid = np.arange(len(surface.points)).reshape(elements + 1, -1)
    shell = Shell("shell", surface, thickness, elastic(E, nu), ROOM)
    sides = (grid[0], "r_v"), (grid[-1], "r_v"), (grid[:, 0], "r_u"), (grid[:, -1], "r_u")
    rows: list[Held] = [(side, ("position", along), (2,)) for side, along in sides]
    middle = grid[:, elements // 2]
    rows += [(middle[[elements // 2]], ("position",), (0, 1)), (middle[[-1]], ("position",), (1,))]
    unit = 4.0 * np.pi**2 * E * thickness**3 / (12.0 * (1.0 - nu**2))
    loads = [
        Traction(name, "shell", way * X, partial(mul, unit), tuple(side))
        for name, way, side in (("left", 1.0, grid[0]), ("right", -1.0, grid[-1]))
    ]
    made = _shell_model(shell, rows, loads)
    return float(buckling(made.system, made.coef, made.coef).factors[0])


@problem("stability", "lateral buckling of a thin cantilever", "Prandtl 1899, Michell 1899")
def lateral_torsional() -> list[Result]:
    """Dead load at the tip: 4.0126 sqrt(EI GJ)/L^2, infinitely stiff in its own plane."""
    found = [_lateral(n) for n in (4, 8, 16)]
    errors = [abs(value / LATERAL - 1.0) for value in found]
    return [
        Check("P L²/√(EI GJ), 16 elements", found[-1], LATERAL, 5e-3),
        Convergence("critical load", (4, 8, 16), errors, 2.0, 0.3),
    ]


LATERAL = 4.01259934
"""From J_{-1/4}(P L^2/(2 sqrt(EI GJ))) = 0."""


def _lateral(elements: int) -> float:
    E, weak, torsion = 1e9, 1e-10, 1e-10
    section = general(
        1e-4, 1e-5, weak, torsion, shear_factor_2=RIGID_IN_SHEAR, shear_factor_3=RIGID_IN_SHEAR
    )
    unit = np.sqrt(E * weak * 0.5 * E * torsion)
    push = Force("push", Site("beam", elements), Y, partial(mul, unit))
    made = model(straight(1.0, elements, section, elastic(E)), [clamp()], [push])
    return float(buckling(made.system, made.coef, made.coef).factors[0])


@problem("stability", "lateral buckling of a right-angle frame", "Argyris et al. 1979")
def right_angle_frame() -> list[Result]:
    """L = 240, h = 30, t = 0.6 mm, E = 71240 N/mm^2, nu = 0.31; lengths in mm.

    The load pulls the free end away from the wall, along the leg that is held there. A published
    load, not computed otherwise here.
    """
    return [Check("critical load", _right_angle(16, X), 1.088, 1e-2, "N")]


def _right_angle(elements: int, direction: Array) -> float:
    section = rectangle(30.0, 0.6, 0.31)
    parts = []
    for name, start, end in (("first", 0 * X, 240 * X), ("second", 240 * X, 240 * (X - Y))):
        along = (end - start) / 240.0
        points, axes = line(start, end, elements, np.cross(Z, along))
        parts.append(Beam(name, points, axes, section, elastic(71240.0, 0.31), ROOM))
    joints: list[Joint] = [
        Clamp("wall", Site("first", 0), Site(None)),
        Clamp("corner", Site("first", elements), Site("second", 0)),
    ]
    push = Force("push", Site("second", elements), direction, lambda s: s)
    made = model(parts, joints, [push])
    return float(buckling(made.system, made.coef, made.coef).factors[0])


@problem("stability", "column that leaves the straight path", "Euler elastica, clamped and free")
def column_branch() -> list[Result]:
    """The bifurcation on the path, and the bent column reached from it without a side load."""
    elements, made = 16, _column(16)
    straight_path = followed(made, lambda p: p.load > 1.1, arc=1e-8, largest=3e-8)
    event = first(straight_path, BIFURCATION)
    checks: list[Result] = [Check("critical load", event.point.load, 1.0, 1e-3, "P_cr")]
    left = branch(made.system, made.coef, made.coef, event, 0.02)
    if left is None:
        raise RuntimeError("no branch")
    point, way = left
    bent = followed(made, _doubled, arc=2e-2, largest=0.1, start=point, direction=way)
    for load, (x, y) in {1.151720: (0.741020, 0.593208), 1.884801: (0.123160, 0.803171)}.items():
        near = min(bent.points, key=lambda p: abs(p.load - load))
        exact = newton(made.system, near.y, load, made.coef, Allowed(1e-10, 30, np.inf))
        tip = made.position(exact.y, "beam", elements)
        checks.append(Check(f"x/L at P/P_cr = {load:.4g}", float(tip[0]), x, 1e-3, "", True))
        size = float(np.hypot(tip[1], tip[2]))
        checks.append(Check(f"y/L at P/P_cr = {load:.4g}", size, y, 1e-3, "", True))
    return checks


def _doubled(p: Point) -> bool:
    return p.load > 1.9


def _column(elements: int, shear: float = RIGID_IN_SHEAR) -> Model:
    """Weak in one plane, so that it is known where it goes; load in units of the critical one."""
    E, weak = 1e9, 1e-13
    section = general(1e-6, weak, 4.0 * weak, weak, shear_factor_2=shear, shear_factor_3=shear)
    unit = 0.25 * np.pi**2 * E * weak
    press = Force("press", Site("beam", elements), -X, partial(mul, unit))
    return model(straight(1.0, elements, section, elastic(E)), [clamp()], [press])
