"""Solid elements: order of convergence, locking, statics, frequencies, heat and buckling."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from operator import mul
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from coupling.verify.models import ROOM, Model, bent, elastic
from coupling.verify.registry import Check, Convergence, Grid, Result, problem
from coupling.verify.rods import Rod, rod_tip, timoshenko
from mechanics.buckling import buckling
from mechanics.continuum_shapes import FULL, STIFFNESS, nodes, points, shape
from mechanics.description import (
    Clamp,
    Continuum,
    Description,
    Force,
    Joint,
    Load,
    ReferencePoint,
    Site,
)
from mechanics.modes import modes, stiffness
from mechanics.system import Coefficients, System
from meshes.materials import Material
from meshes.mesh import Mesh
from meshes.sections import rectangle
from meshes.solids import box

Array = NDArray[np.float64]
Counts = tuple[int, int, int]

ELEMENTS = tuple(STIFFNESS)
E, NU, RHO, ALPHA = 69e9, 0.33, 2700.0, 23.1e-6
METAL = elastic(E, NU, RHO, ALPHA)
CELLS: dict[str, Counts] = {
    "hexahedron20": (20, 2, 1),
    "hexahedron20-full": (40, 1, 1),
    "hexahedron27": (40, 1, 1),
}
"""Meshes of a bar of 1 m x 10 mm x 10 mm; reduced quadrature needs two cells side by side."""


def solid(mesh: Mesh, element: str, material: Material = METAL) -> Continuum:
    return Continuum(
        "body", mesh.points, mesh.cells[STIFFNESS[element][0]], material, ROOM, element
    )


def bar(size: Sequence[float], counts: Counts, element: str) -> Mesh:
    """A box whose axis is that of x."""
    made = box(size, counts, 2, STIFFNESS[element][0])
    return replace(made, points=made.points - 0.5 * np.array([0.0, size[1], size[2]]))


def skewed(mesh: Mesh, counts: Counts, element: str, part: float) -> Mesh:
    """The planes between the cells of a bar turned by turns, by ``part`` of a cell at the edges."""
    family, X = STIFFNESS[element][0], mesh.points.copy()
    cells, length, width = mesh.cells[family], np.ptp(X[:, 0]), np.ptp(X[:, 1])
    corners = np.unique(cells[:, :8])
    station = np.round(X[corners, 0] / length * counts[0])
    inside = (station > 0) & (station < counts[0])
    way = part * length / counts[0] * np.where(station % 2, 1.0, -1.0)
    X[corners, 0] += np.where(inside, way * 2.0 * X[corners, 1] / width, 0.0)
    at = nodes(family)
    X[cells] = (
        np.prod(np.where(at[:8] > 0.5, at[:, None], 1.0 - at[:, None]), axis=2) @ X[cells[:, :8]]
    )
    return replace(mesh, points=X)


class Bar(NamedTuple):
    """A bar with reference points at both ends, "root" and "tip"."""

    made: Model

    def tip(self, q: Array) -> Array:
        """(3, 3) r, r_y, r_z."""
        return self.made.vectors(q, "tip", 0)

    def heated(self, field: Array) -> Coefficients:
        """Coefficients at temperatures of the nodes (n,) [K]."""
        T = np.zeros((len(self.made.system.layout.x), 3))
        T[:, 0] = field
        return self.made.system.coefficients(T)

    @property
    def x(self) -> Array:
        """(n, 3) of the nodes [m]."""
        return self.made.system.layout.x


def held(
    mesh: Mesh,
    element: str,
    load: Sequence[float] = (),
    both: bool = False,
    material: Material = METAL,
) -> Bar:
    """Clamped at the root, or at both ends; the tip loaded."""
    body, places = solid(mesh, element, material), []
    for name, end in (("root", 0.0), ("tip", float(mesh.points[:, 0].max()))):
        face = np.flatnonzero(np.abs(mesh.points[:, 0] - end) < 1e-9)
        places.append(ReferencePoint(name, "body", face, np.ones(len(face)), np.eye(3)))
    joints: list[Joint] = [Clamp("wall", Site("root"), Site(None))]
    if both:
        far = np.array([float(mesh.points[:, 0].max()), 0.0, 0.0])
        joints.append(Clamp("other wall", Site("tip"), Site(None, position=far)))
    loads: list[Load] = []
    if len(load):
        loads.append(Force("load", Site("tip"), np.asarray(load, float), partial(mul, 1.0)))
    system = System(Description([body, *places], joints, loads))
    bare = Bar(Model(system, ()))
    return Bar(Model(system, bare.heated(np.full(len(bare.x), ROOM))))


# ------------------------------------------------------------------------------------- order


def _exact(X: Array) -> tuple[Array, Array]:
    """Displacements (..., 3) and their gradients (..., 3, 3): of a harmonic potential.

    They are in balance without a load on the volume.
    """
    k = np.sqrt(0.5) * 3.0
    x, y, z = np.moveaxis(X, -1, 0)
    a = 1e-3 * np.exp(3.0 * x)
    sy, cy, sz, cz = np.sin(k * y), np.cos(k * y), np.sin(k * z), np.cos(k * z)
    u = np.stack([3.0 * a * sy * sz, k * a * cy * sz, k * a * sy * cz], axis=-1)
    mixed = 3.0 * k * a * cy * sz, 3.0 * k * a * sy * cz, k * k * a * cy * cz
    bent_ = -k * k * a * sy * sz
    rows = [
        [9.0 * a * sy * sz, mixed[0], mixed[1]],
        [mixed[0], bent_, mixed[2]],
        [mixed[1], mixed[2], bent_],
    ]
    return u, np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


@cache
def _errors(element: str, n: int) -> tuple[float, float]:
    """Of the displacement in the mean square, and of the energy: its root, both relative."""
    family = STIFFNESS[element][0]
    mesh = box((1.0, 1.0, 1.0), (n, n, n), 2, family)
    system = System(Description([solid(mesh, element)]))
    coef = system.coefficients(np.tile([ROOM, 0.0, 0.0], (len(mesh.points), 1)))
    K, _ = stiffness(system, system.layout.q0, 0.0, coef)
    inside = np.all((mesh.points > 1e-9) & (mesh.points < 1.0 - 1e-9), axis=1).repeat(3)
    u = _exact(mesh.points)[0].ravel()
    u[inside] = spsolve(K[inside][:, inside].tocsc(), -(K[inside][:, ~inside] @ u[~inside]))
    form, cells = shape(family, FULL), mesh.cells[family]
    at = points(mesh.points[cells], form)
    exact, slopes = _exact(form.values @ mesh.points[cells])
    local = u.reshape(-1, 3)[cells]
    off = form.values @ local - exact
    gradient = np.einsum("cni,cpnj->cpij", local, at.gradients)
    first = float(np.sum(at.volumes * np.sum(off**2, axis=-1)))
    whole = float(np.sum(at.volumes * np.sum(exact**2, axis=-1)))
    energy = _energy(gradient - slopes, at.volumes) / _energy(slopes, at.volumes)
    return float(np.sqrt(first / whole)), float(np.sqrt(energy))


def _energy(gradient: Array, volumes: Array) -> float:
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    trace = np.trace(strain, axis1=-2, axis2=-1)
    lame = NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
    return float(np.sum(volumes * (np.sum(strain**2, (-2, -1)) / (1.0 + NU) + lame * trace**2)))


@problem("continuum", "order of convergence", "gradient of a harmonic potential, exact")
def order() -> list[Result]:
    """Of second order: displacements with h^3, the root of the energy of the error with h^2."""
    sizes, found = (2, 4, 6), list[Result]()
    for element in ELEMENTS:
        both = np.array([_errors(element, n) for n in sizes]).T
        found.append(Convergence(f"displacement, {element}", sizes, both[0], 3.0, 0.4))
        found.append(Convergence(f"root of energy, {element}", sizes, both[1], 2.0, 0.4))
    return found


@problem("continuum", "patch test on distorted cells", "linear displacements are exact")
def patch() -> list[Result]:
    """Largest error of the stress at the points of quadrature, relative to the stress."""
    found: list[Result] = []
    slope = 1e-9 * np.array([[1.0, 2.0, -0.5], [0.3, -1.0, 0.7], [0.2, 0.4, 1.5]])
    strain = 0.5 * (slope + slope.T)
    lame = E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
    stress = E / (1.0 + NU) * strain + lame * np.trace(strain) * np.eye(3)
    for element in ELEMENTS:
        mesh = skewed(bar((0.4, 0.2, 0.2), (4, 2, 2), element), (4, 2, 2), element, 0.3)
        system = System(Description([solid(mesh, element)]))
        coef = system.coefficients(np.tile([ROOM, 0.0, 0.0], (len(mesh.points), 1)))
        K, _ = stiffness(system, system.layout.q0, 0.0, coef)
        X = np.abs(mesh.points - np.array([0.2, 0.0, 0.0]))
        inside = np.all(np.array([0.2, 0.1, 0.1]) - 1e-9 > X, axis=1).repeat(3)
        u = (mesh.points @ slope.T).ravel()
        u[inside] = spsolve(K[inside][:, inside].tocsc(), -(K[inside][:, ~inside] @ u[~inside]))
        off = system.elements[0].stresses(system.layout.q0 + u, coef[0]) - stress
        error = float(np.abs(off).max() / np.abs(stress).max())
        found.append(Check(f"error of the stress, {element}", error, 0.0, 1e-5, "", True))
    return found


# ----------------------------------------------------------------------------------- locking

THIN = (100, 1000)
STRIP: dict[str, Counts] = {name: (10, 2 if name == "hexahedron20" else 1, 1) for name in ELEMENTS}


def _sag(element: str, slenderness: int, part: float) -> float:
    """Deflection of a strip under a small load at its tip, in that of a beam."""
    height, counts = 1.0 / slenderness, STRIP[element]
    inertia = 0.1 * height**3 / 12.0
    load = 1e-6 * E * inertia
    mesh = skewed(bar((1.0, 0.1, height), counts, element), counts, element, part)
    made = held(mesh, element, (0.0, 0.0, load))
    return float(made.tip(bent(made.made, 1).q)[0, 2] * 3.0 * E * inertia / load)


@problem("continuum", "thin strips, ten cells along, one through", "P L³/(3 E I), width L/10")
def locking() -> list[Result]:
    """Deflection in that of a beam, of even meshes and of cells with edges turned by 17°.

    All points of quadrature in a cell of 20 nodes lock where it is both thin and distorted.
    """
    columns = [f"{n}{word}" for n in THIN for word in ("", "*")]
    free, full = ("hexahedron20", "hexahedron27"), "hexahedron20-full"
    values = [[_sag(name, n, part) for n in THIN for part in (0.0, 0.15)] for name in free]
    found: list[Result] = [Grid("L/h (* skew)", columns, free, values, np.ones_like(values), 0.01)]
    for n, part, lost in ((1000, 0.0, 0.01), (100, 0.15, 0.03), (1000, 0.15, 0.1)):
        name = f"missing, {full}, {n}" + (" skew" if part else "")
        found.append(Check(name, 1.0 - _sag(full, n, part), 0.0, lost, "", True))
    return found


# ------------------------------------------------------------------------- statics and modes


@problem("continuum", "elastica, P L²/(E I) = 3, L/h = 100", "rod of Reissner 1981, by shooting")
def elastica() -> list[Result]:
    """Distance of the tip [L]."""
    section, found = rectangle(0.01, 0.01, NU), list[Result]()
    load = (0.0, 0.0, 3.0 * E * section.second_moment_2)
    expected = rod_tip(Rod.of(section, E, NU), 1.0, np.array(load))
    for element, counts in CELLS.items():
        made = held(bar((1.0, 0.01, 0.01), counts, element), element, load)
        away = float(np.linalg.norm(made.tip(bent(made.made).q)[0] - expected))
        found.append(Check(f"tip, {element}", away, 0.0, 2e-4, "L", True))
    return found


@problem("continuum", "frequencies of a cantilever, L/h = 20", "beam of Timoshenko")
def frequencies() -> list[Result]:
    """The first one, of bending."""
    section, found = rectangle(0.05, 0.05, NU), list[Result]()
    EI, mass = E * section.second_moment_2, RHO * section.area
    shear = section.shear_factor_2 * E / (2.0 * (1.0 + NU)) * section.area
    expected = timoshenko(EI, shear, mass, RHO * section.second_moment_2) / (2.0 * np.pi)
    for element, counts in CELLS.items():
        made = held(bar((1.0, 0.05, 0.05), counts, element), element)
        system = made.made.system
        rest = system.layout.q0, np.zeros(system.m), made.made.coef
        value = float(modes(system, *rest, 2).frequencies[0])
        found.append(Check(f"first frequency, {element}", value, expected, 2e-3, "Hz"))
    return found


# --------------------------------------------------------------------------------------- heat


@problem("continuum", "free bow, heated by 50 K and 2000 K/m", "closed form: an arc, no stress")
def bow() -> list[Result]:
    """A bar of 1 m whose tip turns by 2.6°, and the stress that should be none."""
    gradient, found = 2e3, list[Result]()
    stretch = 1.0 + ALPHA * 50.0
    angle = ALPHA * gradient / stretch
    expected = np.array([np.sin(angle), 0.0, np.cos(angle) - 1.0]) * stretch / angle
    for element, counts in CELLS.items():
        made = held(bar((1.0, 0.01, 0.01), counts, element), element)
        hot = made.heated(ROOM + 50.0 + gradient * made.x[:, 2])
        q = bent(made.made, heated=hot).q
        away = float(np.linalg.norm(made.tip(q)[0] - expected))
        found.append(Check(f"tip, {element}", away, 0.0, 1e-6, "L", True))
        stress = float(np.abs(made.made.system.elements[0].stresses(q, hot[0])).max())
        found.append(Check(f"stress, {element}", stress / (E * ALPHA * 50.0), 0.0, 1e-3, "", True))
    return found


@problem("continuum", "bent by a load and heated across, 200 K", "turned by 57°: rod, curvature αG")
def heated() -> list[Result]:
    """P L²/(E I) = 1.5 and 2e4 K/m, both to the same side; tip of the rod by shooting."""
    found: list[Result] = []
    for element, counts in CELLS.items():
        made = held(bar((1.0, 0.01, 0.01), counts, element), element, (0.0, 0.0, -86.25))
        tip = made.tip(bent(made.made, heated=made.heated(ROOM + 2e4 * made.x[:, 2])).q)
        away = float(np.hypot(tip[0, 0] - 0.79299, tip[0, 2] + 0.54020))
        turned = float(np.arctan2(tip[2, 0], tip[2, 2]))
        found.append(Check(f"tip, {element}", away, 0.0, 2e-4, "L", True))
        found.append(Check(f"turn, {element}", turned, 0.99361, 3e-4, "rad"))
    return found


@problem("continuum", "buckling of a heated bar between walls", "4 π² I/(A α L²), with shear")
def heated_column() -> list[Result]:
    """Temperature rise [K] at which it buckles."""
    section, found = rectangle(0.01, 0.01, NU), list[Result]()
    euler = 4.0 * np.pi**2 * section.second_moment_2 / section.area
    shear = section.shear_factor_2 / (2.0 * (1.0 + NU))
    expected = euler / (1.0 + euler / shear) / ALPHA
    for element, counts in CELLS.items():
        made = held(bar((1.0, 0.01, 0.01), counts, element), element, both=True)
        hot = made.heated(np.full(len(made.x), ROOM + 100.0))
        rise = 100.0 * float(buckling(made.made.system, made.made.coef, hot, 1).factors[0])
        found.append(Check(f"temperature rise, {element}", rise, expected, 5e-3, "K"))
    return found
