"""Thick shells: Green's strains in three dimensions, integrated once and for all.

Position r(xi, eta) + zeta n(xi, eta), zeta in metres from the middle surface. With assumed strains
and a stress linear in Green's strain (St. Venant-Kirchhoff), quadrature over an element gives one
matrix for good (``shell_integrals``, ``shell_kernels``); the moduli are taken at the mean
temperature of the element:

    H = lambda H_1 + 2 mu H_2, enhanced strains eliminated (Simo & Rifai 1990).

Transverse shear stress is reduced by 5/6 (Reissner 1945).

Free strains: with the thermal stretch s = 1 + e(T) of the middle surface and a gradient G of the
temperature along the normal, E_free = (f + zeta f') g with f = (s^2 - 1)/2, f' = s^2 alpha G and
the *assumed* metric g of the reference; so a uniform expansion is free of stress to round-off on
any mesh, and the warmer side becomes the outer one. f and f' are bilinear between the nodes. The
elastic strain is that from the expanded body, whose energy is 1/s of the one formed with the
strains of the reference (Lubarda 2004; see ``beam3243``).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import shell_kernels as kernels
from mechanics.description import Shell
from mechanics.layout import Layout
from mechanics.shell_integrals import Scheme, integrate, products, relative
from mechanics.shell_kernels import FREE

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class SolidShell:
    """All elements of one family in a scene.

    Attributes
    ----------
    name : of the family
    names : name of the body of each element
    dofs : (n_e, 3 k) intp
    nodes : (n_e, 4) intp  rows of the section temperatures
    damping_time : (n_e,) float [s]
    symmetric : bool  without damping, whose forces turn with the element
    """

    signals: tuple = ()
    force, tangent, energy = kernels.add_force, kernels.add_tangent, kernels.add_energy

    def __init__(self, name: str, scheme: Scheme, shells: Sequence[Shell], layout: Layout):
        self.name = name
        quads = [np.asarray(s.surface.quads, np.intp) for s in shells]
        counts = [len(q) for q in quads]
        self.names = [s.name for s, n in zip(shells, counts, strict=True) for _ in range(n)]
        pairs = list(zip(shells, quads, strict=True))
        first = np.concatenate([layout.node_dofs[s.name][q] for s, q in pairs])
        self.nodes = np.concatenate([layout.point_index[s.name][q] for s, q in pairs])
        starts = first[:, :, None] + 3 * np.arange(scheme.vectors)
        self.dofs = (starts[..., None] + np.arange(3)).reshape(len(first), -1).astype(np.intp)
        self.ints = np.ascontiguousarray(starts.reshape(len(first), -1), np.int64)
        self.damping_time = np.repeat([float(s.damping_time) for s in shells], counts)
        self.symmetric = not self.damping_time.any()
        self._density = np.repeat([s.material.density for s in shells], counts)
        ends = np.cumsum([0, *counts])
        self._groups = [
            (s.material, float(s.reference_temperature), slice(a, b))
            for s, a, b in zip(shells, ends[:-1], ends[1:], strict=True)
        ]
        X = layout.q0[self.ints[:, :, None] + np.arange(3)]
        sizes = np.concatenate([np.asarray(s.surface.sizes, float) for s in shells])
        thickness = np.repeat([float(s.thickness) for s in shells], counts)
        self._tables = integrate(scheme, X, sizes, thickness, self.names)
        self._reference = products(relative(X, scheme.vectors))
        self.floats = np.ascontiguousarray(self.damping_time[:, None])
        self._stored = self._reference.shape[1] + FREE

    def coefficients(self, T: Array) -> Array:
        """(n_e, n_c) upper triangle of H, free strains (8), their rates (8, zero), products of the
        vectors in the reference, lambda, 2 mu; smooth in T.
        """
        mean, gradient = T[self.nodes, 0], T[self.nodes, 2]
        E, nu, strain, expansion = np.empty((4, *mean.shape))
        for material, unheated, e in self._groups:
            E[e], nu[e] = material.youngs_modulus(mean[e]), material.poissons_ratio(mean[e])
            strain[e] = material.thermal_strain(mean[e], unheated)
            expansion[e] = material.expansion(mean[e])
        stretch = 1.0 + strain
        f, slope = 0.5 * (stretch**2 - 1.0), stretch**2 * expansion * gradient
        E, nu = np.mean(E / stretch, axis=1), np.mean(nu, axis=1)
        moduli = np.column_stack([E * nu / (1.0 + nu) / (1.0 - 2.0 * nu), E / (1.0 + nu)])
        H, still = self._condensed(moduli)[0], np.zeros((len(E), FREE))
        return np.ascontiguousarray(np.hstack([H, f, slope, still, self._reference, moduli]))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        c0, c1 = c0.copy(), c1.copy()
        free, rates, _ = self._columns()
        c0[:, rates] = c1[:, rates] = (c1[:, free] - c0[:, free]) / h
        return c0, c1

    def predicted(self, coef: Array, y: Array, step: Array, new: Array) -> Array:
        """Coefficients whose stresses at ``new`` are those predicted at ``y`` for ``step``.

        The mixed integration point Newton method, see ``prediction``.
        """
        before, change, after = (self._vectors(x) for x in (y, step, new))
        linear = products(before + change) - products(change)
        shifted = coef.copy()
        shifted[:, self._columns()[2]] += products(after) - linear
        return shifted

    def mass_blocks(self) -> Array:
        """(n_e, 3 k, 3 k) consistent mass."""
        n, k = self.ints.shape
        scalar = self._density[:, None, None] * self._tables.mass
        return np.einsum("eab,ij->eaibj", scalar, np.eye(3)).reshape(n, 3 * k, 3 * k)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """(n_e, 8) N11 N22 N12 [N/m], M11 M22 M12 [N m/m], Q1 Q2 [N/m], damping included.

        Means over each element of the stress (second of Piola and Kirchhoff); direction 1 is that
        of the first parameter line, 2 is across it. M is positive where the surface bends towards
        its normal (stress = N/h - 12 M z/h^3), Q where the far side is pushed along the normal.
        """
        z, moduli = self._strains(y, v, coef), coef[:, -2:]
        enhanced = -np.einsum("eij,ej->ei", self._condensed(moduli)[1], z)
        strains = np.hstack([z, enhanced])
        return np.einsum("em,meij,ej->ei", moduli, self._tables.resultants, strains, optimize=True)

    def _columns(self) -> tuple[slice, slice, slice]:
        """Of the coefficients: free strains, their rates, products in the reference."""
        first = self._stored * (self._stored + 1) // 2
        ends = first, first + FREE, first + 2 * FREE, first + FREE + self._stored
        return slice(*ends[:2]), slice(*ends[1:3]), slice(*ends[2:])

    def _vectors(self, y: Array) -> Array:
        """(n_e, k - 1, 3) all vectors but the first, positions relative to it."""
        return relative(y[self.ints[:, :, None] + np.arange(3)], self.ints.shape[1] // 4)

    def _strains(self, y: Array, v: Array, coef: Array) -> Array:
        """(n_e, n_z - enhanced) z + tau dz/dt."""
        free, rates, reference = (coef[:, columns] for columns in self._columns())
        X, V = self._vectors(y), self._vectors(v)
        tau = self.damping_time[:, None]
        changing = products(X + V) - products(X) - products(V)
        return np.hstack([products(X) - reference + tau * changing, -free - tau * rates])

    def _condensed(self, moduli: Array) -> tuple[Array, Array]:
        """Upper triangle of H without the enhanced strains; minus the matrix that gives those."""
        n, m = self._stored, self._tables.resultants.shape[-1]
        first, second = self._tables.stiffness
        packed = moduli[:, :1] * first + moduli[:, 1:] * second
        place, (i, j) = np.zeros((m, m), np.intp), np.triu_indices(m)
        place[i, j] = place[j, i] = np.arange(i.size)
        cross, own = packed[:, place[n:, :n]], packed[:, place[n:, n:]]
        enhanced = np.linalg.solve(own, cross)
        i, j = np.triu_indices(n)
        H = packed[:, place[i, j]]
        for a, b in zip(cross.swapaxes(0, 1), enhanced.swapaxes(0, 1), strict=True):
            H -= a[:, i] * b[:, j]
        return H, enhanced
