"""Shells of both thick families, dense or sparse, for their tests."""

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from mechanics import kernels, shell24, shell3443
from mechanics.description import Shell
from mechanics.layout import Layout
from meshes.materials import constant_material
from meshes.surfaces import Surface, patch

COLD = 300.0
BUILDERS = {
    "shell24": ("shell24", shell24.build),
    "shell3443": ("shell3443", shell3443.build),
    "naive": ("shell3443", shell3443.build_naive),
}
PLAIN = constant_material("plain", 2700.0, 70e9, 0.3, 23e-6, 1.0, 1.0)


class Case(NamedTuple):
    """A term, its reference coordinates, temperatures and layout."""

    term: Any
    q: np.ndarray
    T: np.ndarray
    layout: Layout

    @property
    def coef(self):
        """Coefficients at the reference temperature."""
        return self.term.coefficients(self.T)

    def at(self, nodes, vector, *components):
        """Coordinates of a vector of some nodes; -1 is the normal."""
        first = self.layout.node_dofs["s"][np.ravel(nodes)]
        k = self.layout.kinds["s"] // 3
        return (first[:, None] + 3 * (vector % k) + np.array(components or (0, 1, 2))).ravel()

    def vectors(self, q):
        return q.reshape(len(self.T), -1, 3)


def case(family, surface, thickness=0.05, material=PLAIN, damping=0.0):
    element, build = BUILDERS[family]
    shell = Shell("s", surface, thickness, material, COLD, damping, element)
    layout = Layout.of([shell])
    T = np.tile([COLD, 0.0, 0.0], (len(surface.points), 1))
    return Case(build([shell], layout), layout.q0, T, layout)


def curved(n_u=2, n_v=2, sizes=(1.2, 0.9)):
    """A doubly curved patch whose grid lines are curved too."""

    def shape(u, v):
        o = np.zeros_like(u)
        r = np.stack([u + 0.1 * v**2, v - 0.1 * u * v, 0.3 * u**2 - 0.2 * v**2], axis=1)
        r_u = np.stack([o + 1.0, -0.1 * v, 0.6 * u], axis=1)
        r_v = np.stack([0.2 * v, 1.0 - 0.1 * u, -0.4 * v], axis=1)
        return r, r_u, r_v, np.stack([o, o - 0.1, o], axis=1)

    return patch(shape, np.linspace(0, sizes[0], n_u + 1), np.linspace(0, sizes[1], n_v + 1))


def distorted():
    """Patch of MacNeal & Harder (1985): five quadrilaterals on 1.2 x 0.6, of no grid."""
    outer = [[0.0, 0.0], [1.2, 0.0], [1.2, 0.6], [0.0, 0.6]]
    inner = [[0.2, 0.1], [0.9, 0.15], [0.8, 0.4], [0.4, 0.4]]
    points = np.column_stack([[*outer, *inner], np.zeros(8)])
    corners = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]])
    x, y = (np.tile(row, (8, 1)) for row in np.eye(3)[:2])
    return Surface(points, corners, np.ones((5, 2)), x, y, 0.0 * x)


def force(c, q, coef, v=None):
    out = np.zeros_like(q)
    kernels.add_force(c.term, q, 0.0 * q if v is None else v, coef, out)
    return out


def stiffness(c, q, coef):
    """Sparse tangent stiffness (n, n)."""
    return _assembled(c, kernels.tangent_blocks(c.term, q, 0.0 * q, coef, 1.0, 0.0))


def mass(c):
    """Sparse mass matrix (n, n)."""
    return _assembled(c, c.term.mass_blocks())


def _assembled(c, blocks):
    k = c.term.dofs.shape[1]
    rows = np.repeat(c.term.dofs, k, axis=1).ravel(), np.tile(c.term.dofs, (1, k)).ravel()
    return sp.csr_array((blocks.ravel(), rows), shape=(c.q.size, c.q.size))


def relax(c, coef, load, fixed, steps=1, tolerance=1e-9):
    """Newton's method with load steps."""
    free = np.setdiff1d(np.arange(c.q.size), fixed)
    q = c.q.copy()
    for step in range(1, steps + 1):
        for _ in range(30):
            residual = (step / steps * load - force(c, q, coef))[free]
            dq = splu(stiffness(c, q, coef)[free][:, free].tocsc()).solve(residual)
            q[free] += dq
            if np.abs(dq).max() < tolerance:
                break
        else:
            raise AssertionError(f"no equilibrium in load step {step}")
    return q
