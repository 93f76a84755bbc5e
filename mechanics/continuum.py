"""Solid elements: bodies as they are, in three dimensions, without any assumption of a section.

Hexahedra of second order with positions as coordinates, total Lagrangian: any rotation, law of St.
Venant and Kirchhoff. Thermal strain as in the other families: the strain is that from the thermally
expanded body, E = (F^T F/s^2 - 1)/2 with the free stretch s of the local temperature
(multiplicative split), which gives moduli divided by s for e = (F^T F - s^2)/2.

``hexahedron20``
    20 nodes, 2 x 2 x 2 points: does not lock where bodies are thin. A cell has six motions without
    strain beside the rigid ones. They cannot pass from cell to cell in two directions, but three
    of them run along a single row of cells (measured), which is refused.
``hexahedron20-full``
    The same with 3 x 3 x 3 points.
``hexahedron27``
    27 nodes, 3 x 3 x 3 points: the more robust one for distorted cells, at a higher price.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics import continuum_kernels as kernels
from mechanics.continuum_shapes import FULL, NODES, REDUCED, STIFFNESS, points, shape
from mechanics.description import Continuum
from mechanics.layout import Layout
from mechanics.line_elements import in_space, with_rates
from mechanics.prediction import shifted
from meshes.families import FACES
from meshes.materials import Material

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ROW, COLUMN = np.array([[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]])
"""Of the components of a strain."""


class Solid:
    """All cells of one family: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    names : name of the body of each cell
    dofs : (n_e, 3 k) intp
    nodes : (n_e, k) intp  rows of the temperatures
    volumes : (n_e, p) float [m^3]  of the points of quadrature
    ints, floats : see ``continuum_kernels``
    """

    def __init__(self, bodies: Sequence[Continuum], layout: Layout):
        self.name = bodies[0].element
        self._family, degree = STIFFNESS[self.name]
        cells = [_cells(body, NODES[self._family]) for body in bodies]
        if degree == REDUCED:
            _refuse_rows(bodies, cells)
        counts = [len(c) for c in cells]
        self.names = [b.name for b, n in zip(bodies, counts, strict=True) for _ in range(n)]
        pairs = list(zip(bodies, cells, strict=True))
        self.ints = np.concatenate([layout.node_dofs[b.name][c] for b, c in pairs]).astype(np.int64)
        self.dofs = _coordinates(self.ints)
        self.nodes = np.concatenate([layout.point_index[b.name][c] for b, c in pairs])
        self._unheated = np.repeat([float(b.reference_temperature) for b in bodies], counts)
        self._groups = _groups(bodies, counts)
        self._density = np.repeat([b.material.density for b in bodies], counts)
        self._X = layout.q0[self.dofs].reshape(len(self.ints), -1, 3)
        self._shape = shape(self._family, degree)
        at = points(self._X, self._shape)
        _check(bodies, counts, at.volumes)
        self.volumes, self._gradients = at.volumes, at.gradients
        tau = np.repeat([float(b.damping_time) for b in bodies], counts)
        rows = np.concatenate([at.volumes[:, :, None], at.gradients.reshape(*at.volumes.shape, -1)],
                              axis=2)  # fmt: skip
        self.floats = np.column_stack([tau, rows.reshape(len(tau), -1)])
        self.symmetric = not tau.any()
        self.signals: list = []
        self.force, self.tangent = kernels.add_force, kernels.add_tangent
        self.energy = kernels.add_energies

    def coefficients(self, T: Array) -> Array:
        """Moduli, rates of free strains (zero) and free strains, (n_e, 9 p)."""
        local = T[self.nodes, 0] @ self._shape.values.T
        E, nu, stretch = np.empty((3, *local.shape))
        for material, e in self._groups:
            E[e], nu[e] = material.youngs_modulus(local[e]), material.poissons_ratio(local[e])
            stretch[e] = 1.0 + material.thermal_strain(local[e], self._unheated[e, None])
        mu = 0.5 * E / (1.0 + nu) / stretch
        lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) / stretch
        free = np.zeros((*local.shape, 6))
        free[:, :, :3] = 0.5 * stretch[:, :, None] ** 2
        return np.hstack([lame, mu, np.zeros_like(mu), free.reshape(len(local), -1)])

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        p = self.volumes.shape[1]
        return with_rates(c0, c1, h, slice(3 * p, None, 6), slice(2 * p, 3 * p))

    def predicted(self, coef: Array, y: Array, step: Array, new: Array) -> Array:
        """Coefficients with the stress that is predicted, see ``mechanics.prediction``."""
        free = slice(3 * self.volumes.shape[1], None)
        return shifted(coef, free, self._strains, y, step, new)

    def mass_blocks(self) -> Array:
        """(n_e, 3 k, 3 k) consistent mass."""
        form = shape(self._family, FULL)
        heavy = points(self._X, form).volumes * self._density[:, None]
        return in_space(np.einsum("ep,pi,pj->eij", heavy, form.values, form.values))

    def _gradient(self, y: Array) -> Array:
        """(n_e, p, 3, 3) gradients by reference positions of what the coordinates are of."""
        return np.swapaxes(y[self.dofs].reshape(self._X.shape), 1, 2)[:, None] @ self._gradients

    def _strains(self, y: Array, v: Array) -> tuple[Array, Array]:
        """Halves of F^T F and their rates, (n_e, 6 p)."""
        F, W = self._gradient(y), self._gradient(v)
        metric, change = np.swapaxes(F, -1, -2) @ F, np.swapaxes(F, -1, -2) @ W
        change = change + np.swapaxes(change, -1, -2)
        first, second = (0.5 * m[:, :, ROW, COLUMN].reshape(len(F), -1) for m in (metric, change))
        return first, second

    def stresses(self, y: Array, coef: Array) -> Array:
        """(n_e, p, 3, 3) stress of Cauchy [Pa] at the points of quadrature, without damping."""
        p = self.volumes.shape[1]
        F = self._gradient(y)
        lame, mu = coef[:, :p, None, None], coef[:, p : 2 * p, None, None]
        free = coef[:, 3 * p :].reshape(len(F), p, 6)[:, :, kernels.PLACE]
        e = 0.5 * np.swapaxes(F, -1, -2) @ F - free
        S = 2.0 * mu * e + lame * np.trace(e, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        return F @ S @ np.swapaxes(F, -1, -2) / np.linalg.det(F)[..., None, None]


def build(bodies: Sequence[Continuum], layout: Layout) -> Solid:
    """One term for all ``bodies``, which have the same element."""
    return Solid(bodies, layout)


def von_mises(stress: Array) -> Array:
    """(...) equivalent stress [Pa] of stresses (..., 3, 3)."""
    mean = np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0
    deviator = stress - mean * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(-1, -2)))


def _cells(body: Continuum, nodes: int) -> Indices:
    cells = np.asarray(body.cells, np.intp)
    if cells.ndim != 2 or cells.shape[1] != nodes:
        raise ValueError(f"body {body.name!r}: cells of {body.element} have {nodes} nodes")
    return cells


def _refuse_rows(bodies: Sequence[Continuum], cells: Sequence[Indices]) -> None:
    """Bodies in which no cell has neighbours in two directions."""
    for body, own in zip(bodies, cells, strict=True):
        faces = np.sort(own[:, FACES["hexahedron"]], axis=2).reshape(-1, 4)
        _, which, counts = np.unique(faces, axis=0, return_inverse=True, return_counts=True)
        shared = (counts[which.ravel()] > 1).reshape(-1, 3, 2).any(axis=2)
        if not np.any(shared.sum(axis=1) > 1):
            raise ValueError(
                f"body {body.name!r}: a single row of cells with reduced quadrature has motions"
                " without strain; it needs two cells side by side, or 'hexahedron20-full'"
            )


def _check(bodies: Sequence[Continuum], counts: Sequence[int], volumes: Array) -> None:
    """Cells that are turned inside out."""
    starts = np.cumsum([0, *counts])
    for body, first, last in zip(bodies, starts, starts[1:], strict=False):
        bad = np.flatnonzero(~np.all(volumes[first:last] > 0.0, axis=1))
        if bad.size:
            raise ValueError(f"body {body.name!r}: {bad.size} cells are inverted, first {bad[0]}")


def _coordinates(first: NDArray) -> Indices:
    """(n_e, 3 k) coordinates of nodes whose first ones are ``first`` (n_e, k)."""
    return (first[:, :, None] + np.arange(3)).reshape(len(first), -1).astype(np.intp)


def _groups(bodies: Sequence[Continuum], counts: Sequence[int]) -> list[tuple[Material, Indices]]:
    """The cells of each distinct material."""
    owner = np.repeat([id(b.material) for b in bodies], counts)
    distinct: dict[int, Any] = {id(b.material): b.material for b in bodies}
    return [(m, np.flatnonzero(owner == key)) for key, m in distinct.items()]
