"""Bodies of every flexible family, and dense algebra on their terms."""

from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechanics import kernels
from mechanics.description import Beam, Continuum, Shell
from mechanics.elements import FAMILIES
from mechanics.layout import Layout
from meshes.materials import constant_material, library_material
from meshes.sections import circle, rectangle
from meshes.solids import box
from meshes.surfaces import patch

COLD = 293.15
PAPER = library_material("al6061-paper")
PLAIN = constant_material("plain", 2700.0, 70e9, 0.3, 23e-6, 160.0, 900.0)
POISSONLESS = constant_material("no contraction", 2700.0, 70e9, 0.0, 23e-6, 160.0, 900.0)
RECTANGLE, ROD = rectangle(0.10, 0.06), circle(0.05)

SOLIDS = [name for name in FAMILIES if name.startswith("hexahedron")]
FLEXIBLE = [name for name in FAMILIES if name not in ("rigid", "particle", "reference", *SOLIDS)]
SHELLS = [name for name in FLEXIBLE if name.startswith("shell")]
LINES = [name for name in FLEXIBLE if name not in SHELLS]
BEAMS = [name for name in LINES if name != "cable"]
ROOT = Path(__file__).parent.parent


class Case(NamedTuple):
    """A term with its layout."""

    term: object
    layout: Layout

    @property
    def q(self):
        return self.layout.q0.copy()

    @property
    def vectors(self):
        """Vectors of a node."""
        return next(iter(self.layout.kinds.values())) // 3

    def temperatures(self, mean=COLD, gradient=(0.0, 0.0)):
        return np.tile([mean, *gradient], (len(self.layout.x), 1)).astype(float)

    def uneven(self, rng):
        m = len(self.layout.x)
        return np.column_stack([COLD + 80 * rng.random(m), 300 * rng.standard_normal((m, 2))])

    def coefficients(self, *temperature):
        return self.term.coefficients(self.temperatures(*temperature))

    def force(self, q, v, coef):
        out = np.zeros_like(q)
        kernels.add_force(self.term, q, v, coef, out)
        return out

    def matrix(self, q, v, coef, cK=1.0, cC=0.0):
        return self.assembled(kernels.tangent_blocks(self.term, q, v, coef, cK, cC))

    def mass(self):
        return self.assembled(self.term.mass_blocks())

    def assembled(self, blocks):
        K = np.zeros((self.layout.ndof,) * 2)
        for dofs, block in zip(self.term.dofs, blocks, strict=True):
            K[np.ix_(dofs, dofs)] += block
        return K

    def energies(self, q, v, coef):
        return kernels.energies(self.term, q, v, coef)

    def turned(self, q, rotation, shift=(0.0, 0.0, 0.0)):
        """All vectors rotated, positions shifted as well."""
        x = rotation.apply(q.reshape(-1, 3)).reshape(-1, self.vectors, 3)
        x[:, 0] += shift
        return x.ravel()

    def stiff(self, coef):
        """Size of the forces of a unit displacement of a coordinate [N]."""
        return np.abs(self.matrix(self.q, 0 * self.q, coef)).max()


def build(bodies):
    """One term of bodies that are all of one family."""
    module, function = FAMILIES[bodies[0].element].build.split(":")
    if not (ROOT / (module.replace(".", "/") + ".py")).exists():
        pytest.skip(f"{module} is not written yet")
    layout = Layout.of(bodies)
    return Case(getattr(import_module(module), function)(bodies, layout), layout)


def straight_line(family, n, length=1.0, spacing=lambda s: s):
    """Points and axes of n elements along x."""
    count = FAMILIES[family].stride * n + 1
    points = np.zeros((count, 3))
    points[:, 0] = length * spacing(np.linspace(0.0, 1.0, count))
    return points, np.tile(np.eye(3), (count, 1, 1))


def helix(family, n, twist=0.3):
    """n elements on a helix whose section turns about the axis as well."""
    s = np.linspace(0.0, 1.5, FAMILIES[family].stride * n + 1)
    points = np.column_stack([np.cos(s), np.sin(s), 0.4 * s])
    e1 = np.column_stack([-np.sin(s), np.cos(s), 0.4 + 0 * s]) / np.hypot(1.0, 0.4)
    e2 = np.column_stack([-np.cos(s), -np.sin(s), 0 * s])
    axes = np.stack([e1, e2, np.cross(e1, e2)], axis=1)
    turn = Rotation.from_rotvec(twist * s[:, None] * e1)
    return points, np.stack([turn.apply(axes[:, i]) for i in range(3)], axis=1)


def flat(u, v):
    """z = 0 as a surface of its parameters."""
    o = np.zeros_like(u)
    x, y = np.stack([o + 1.0, o, o], axis=1), np.stack([o, o + 1.0, o], axis=1)
    return np.stack([u, v, o], axis=1), x, y, np.stack([o, o, o], axis=1)


def saddle(u, v):
    """z = u v + u^2/2: curved and twisted in both directions."""
    o = np.zeros_like(u)
    d_u = np.stack([o + 1.0, o, v + u], axis=1)
    d_v = np.stack([o, o + 1.0, u], axis=1)
    return np.stack([u, v, u * v + 0.5 * u * u], axis=1), d_u, d_v, np.stack([o, o, o + 1], axis=1)


def solid(family, shape, elements, material, damping):
    """A block of two rows of cells, or one that is curved and twisted."""
    mesh = box((1.2, 0.8, 0.3), (max(elements, 2), 2, 1), 2, family.removesuffix("-full"))
    points, cells = mesh.points, mesh.cells[family.removesuffix("-full")]
    if shape == "curved":
        x, y, z = points.T
        points = np.stack([x + 0.2 * y * z, y + 0.2 * x * x, z + 0.15 * x * y], axis=1)
    return Continuum("b", points, cells, material, COLD, family, damping)


def body(family, shape="curved", elements=3, material=PAPER, damping=0.0, **given):
    """A body of the family; beams: ``section``, shells: ``thickness`` and ``width``."""
    if family in SOLIDS:
        return solid(family, shape, elements, material, damping)
    if family in SHELLS:
        width = given.get("width", 0.8)
        u = np.linspace(0.0, given.get("length", 1.2), elements + 1)
        surface = patch(saddle if shape == "curved" else flat, u, [0.0, 0.45 * width, width])
        thick = given.get("thickness", 0.05)
        return Shell("b", surface, thick, material, COLD, damping, family)
    section = given.get("section", ROD if family == "cable" else RECTANGLE)
    line = helix if shape == "curved" else straight_line
    options = {"length": given["length"]} if "length" in given else {}
    points, axes = line(family, elements, **options)
    return Beam("b", points, axes, section, material, COLD, damping, family)


def make(family, *arguments, **given):
    """The case of one body."""
    return build([body(family, *arguments, **given)])


def derivative(f, x, h=2e-3):
    """Jacobian by central differences, extrapolated twice (error h^6)."""

    def central(i, step):
        d = np.zeros_like(x)
        d[i] = step
        return (f(x + d) - f(x - d)) / (2.0 * step)

    columns = []
    for i in range(x.size):
        a, b, c = (central(i, h / 2**k) for k in range(3))
        columns.append((16.0 * (4 * c - b) / 3 - (4 * b - a) / 3) / 15.0)
    return np.stack(columns, axis=-1)


def spun(q, omega):
    """Velocities of a rotation about the origin."""
    return np.cross(omega, q.reshape(-1, 3)).ravel()


def relax(case, q, coef, external, free, steps=1, tolerance=1e-12):
    """Dense Newton with load steps; singular directions (rigid motions) are left alone."""
    q = q.copy()
    rest = np.zeros_like(q)
    for step in range(1, steps + 1):
        for _ in range(60):
            residual = (case.force(q, rest, coef) - step / steps * external)[free]
            K = case.matrix(q, rest, coef)[np.ix_(free, free)]
            dq = np.linalg.lstsq(K, -residual, rcond=1e-13)[0]
            q[free] += dq * min(1.0, 0.3 / max(np.abs(dq).max(), 1e-300))
            if np.abs(dq).max() < tolerance:
                break
        else:
            raise AssertionError("Newton did not converge")
    return q
