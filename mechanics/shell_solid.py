"""Thick shells: Green's strains in three dimensions, integrated once and for all.

Position r(xi, eta) + zeta n(xi, eta), zeta in metres from the middle surface. With assumed
covariant strains that are sums of products of nodal vectors, enhanced strains, and a stress that
is linear in Green's strain (St. Venant-Kirchhoff), quadrature over an element gives one matrix for
good (``shell_kernels``); the moduli are taken at the mean temperature of the element:

    H = lambda H_1 + 2 mu H_2, enhanced strains eliminated (Simo & Rifai 1990).

Transverse shear stress is reduced by 5/6 (Reissner 1945).

Free strains: with the thermal stretch s = 1 + e(T) of the middle surface and a gradient T' along
the normal, E_free = (f + zeta f') G with f = (s^2 - 1)/2, f' = s alpha T', G the *assumed*
reference metric; so a uniform expansion is free of stress to round-off on any mesh. f and f' are
bilinear between the nodes. The elastic strain is that from the expanded body, whose energy is
1/s of the one formed with the strains of the reference (Lubarda 2004; see ``beam3243``).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics import shell_kernels as kernels
from mechanics.description import Shell
from mechanics.layout import Layout
from mechanics.shell_kernels import FREE

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""xi, eta of the four nodes."""
SHEAR_FACTOR = 5.0 / 6.0
"""Of transverse shear stress, by E. Reissner (1945) [-]."""
SPHERICAL = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
DEVIATORIC = np.array([1.0, 1.0, 1.0, 0.5, 0.5 * SHEAR_FACTOR, 0.5 * SHEAR_FACTOR])
"""Stress = lambda (1.E) 1 + 2 mu E, on strains 11, 22, 33, 2x12, 2x13, 2x23."""
IJ = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]])


class Scheme(NamedTuple):
    """What distinguishes one family from another, on the square -1 <= xi, eta <= 1.

    Slopes are by xi and eta, that is half the size of the element times those of the nodes.

    vectors : of a node: 2 (r, n) or 4 (r, r_u, r_v, n)
    shape : (xi, eta) -> (3, k)  weights of all vectors in r, dr/dxi, dr/deta
    strains : (xi, eta) -> (3, 6, k (k - 1)/2)  covariant strains 11, 22, 33, 2x12, 2x13, 2x23 as
        sums of products: their parts without zeta, with zeta, with zeta^2
    membrane, thickness : (xi, eta) -> (n, 3), (m,)  enhanced strains 11, 22, 2x12 of the membrane,
        and 33, to be multiplied by zeta
    points : along each direction of the surface, and through the thickness
    """

    vectors: int
    shape: Callable[[float, float], Array]
    strains: Callable[[float, float], Array]
    membrane: Callable[[float, float], Array]
    thickness: Callable[[float, float], Array]
    points: tuple[int, int]


class Tables(NamedTuple):
    """Integrals over all elements, of z = (products, -free strains, enhanced strains).

    spherical, deviatoric : (n_e, n_z, n_z)  H_1 and H_2 [m^3 by the units of z]
    resultants : two (n_e, 8, n_z)  means of N, M, Q per lambda and per 2 mu
    mass : (n_e, k, k)  of unit density
    """

    spherical: Array
    deviatoric: Array
    resultants: tuple[Array, Array]
    mass: Array


class SolidShell:
    """All elements of one family in a scene.

    Attributes
    ----------
    name : of the family
    names : name of the body of each element
    dofs : (n_e, 3 k) intp
    nodes : (n_e, 4) intp  rows of the section temperatures
    damping_time : (n_e,) float [s]
    """

    symmetric = True
    signals: list = []
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
        reference = products(relative(X, scheme.vectors))
        self.floats = np.ascontiguousarray(np.column_stack([reference, self.damping_time]))
        self._stored = reference.shape[1] + FREE

    def coefficients(self, T: Array) -> Array:
        """Upper triangle of H, free strains (8), their rates (8, zero), lambda, 2 mu: (n_e, n_c).

        Smooth in T.
        """
        mean, gradient = T[self.nodes, 0], T[self.nodes, 2]
        E, nu, strain, expansion = np.empty((4, *mean.shape))
        for material, unheated, e in self._groups:
            E[e], nu[e] = material.youngs_modulus(mean[e]), material.poissons_ratio(mean[e])
            strain[e] = material.thermal_strain(mean[e], unheated)
            expansion[e] = material.expansion(mean[e])
        stretch = 1.0 + strain
        f, slope = 0.5 * (stretch**2 - 1.0), stretch * expansion * gradient
        E, nu = np.mean(E / stretch, axis=1), np.mean(nu, axis=1)
        moduli = np.column_stack([E * nu / (1.0 + nu) / (1.0 - 2.0 * nu), E / (1.0 + nu)])
        H = self._condensed(moduli)[0][:, *np.triu_indices(self._stored)]
        return np.ascontiguousarray(np.hstack([H, f, slope, np.zeros_like(f), 0.0 * f, moduli]))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        c0, c1 = c0.copy(), c1.copy()
        free, rates = slice(-2 - 2 * FREE, -2 - FREE), slice(-2 - FREE, -2)
        c0[:, rates] = c1[:, rates] = (c1[:, free] - c0[:, free]) / h
        return c0, c1

    def mass_blocks(self) -> Array:
        """(n_e, 3 k, 3 k) consistent mass."""
        n, k = self.ints.shape
        scalar = self._density[:, None, None] * self._tables.mass
        return np.einsum("eab,ij->eaibj", scalar, np.eye(3)).reshape(n, 3 * k, 3 * k)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """(n_e, 8) N11 N22 N12 [N/m], M11 M22 M12 [N], Q1 Q2 [N/m], damping included.

        Means over each element of the stress (second of Piola and Kirchhoff) and of zeta times it
        [M], in the frame e1 along the first parameter line, e3 along the normal.
        """
        z = self._strains(y, v, coef)
        moduli = coef[:, -2:]
        first, second = self._tables.resultants
        R = moduli[:, :1, None] * first + moduli[:, 1:, None] * second
        enhanced = -np.einsum("eij,ej->ei", self._condensed(moduli)[1], z)
        return np.einsum("eij,ej->ei", R, np.hstack([z, enhanced]))

    def _strains(self, y: Array, v: Array, coef: Array) -> Array:
        """(n_e, n_z - enhanced) z + tau dz/dt."""
        w = self.ints.shape[1] // 4
        tau = self.damping_time[:, None]
        X, V = (relative(a[self.ints[:, :, None] + np.arange(3)], w) for a in (y, v))
        g = products(X) - self.floats[:, :-1]
        rates = products(X + V) - products(X) - products(V)
        free, freed = coef[:, -2 - 2 * FREE : -2 - FREE], coef[:, -2 - FREE : -2]
        return np.hstack([g + tau * rates, -free - tau * freed])

    def _condensed(self, moduli: Array) -> tuple[Array, Array]:
        """H without the enhanced strains, and the matrix that gives them (but for the sign)."""
        t, n = self._tables, self._stored
        H = moduli[:, :1, None] * t.spherical + moduli[:, 1:, None] * t.deviatoric
        if H.shape[1] == n:
            return H, np.zeros((len(H), 0, n))
        enhanced = np.linalg.solve(H[:, n:, n:], H[:, n:, :n])
        return H[:, :n, :n] - H[:, :n, n:] @ enhanced, enhanced


def relative(X: Array, vectors: int) -> Array:
    """(n_e, k - 1, 3) all vectors but the first, positions relative to it."""
    X = X.copy()
    X[:, ::vectors] -= X[:, :1]
    return X[:, 1:]


def products(X: Array) -> Array:
    """(n_e, k (k - 1)/2) X_a.X_b for a < b, half of it for a = b."""
    a, b = np.triu_indices(X.shape[1])
    return np.where(a == b, 0.5, 1.0) * np.einsum("epi,epi->ep", X[:, a], X[:, b])


def product(a: Array, b: Array) -> Array:
    """(k (k - 1)/2,) weights of the products in (sum a_i X_i).(sum b_i X_i); a, b (k,)."""
    i, j = np.triu_indices(len(a) - 1)
    a, b = a[1:], b[1:]
    return a[i] * b[j] + a[j] * b[i]


def bilinear(xi: float, eta: float) -> Array:
    """(3, 4) bilinear functions and their derivatives."""
    x, y = CORNERS.T
    return 0.25 * np.stack([(1 + x * xi) * (1 + y * eta), x * (1 + y * eta), (1 + x * xi) * y])


def normal_squares(vectors: int, weights: Array) -> Array:
    """Weights of the products in sum_i weights_i n_i.n_i, n the last vector of each node."""
    total = np.zeros(2 * vectors * (4 * vectors - 1))
    for node, weight in enumerate(weights):
        at = np.eye(4 * vectors)[vectors * node + vectors - 1]
        total += weight * product(at, at)
    return total


def integrate(
    scheme: Scheme, X: Array, sizes: Array, thickness: Array, names: Sequence[str]
) -> Tables:
    """Tables of all elements with reference vectors X (n_e, k, 3), sizes (n_e, 2), thickness."""
    X, scaled = np.asarray(X, float), _scales(scheme, sizes)
    i, j = np.triu_indices(scaled.shape[1] - 1)
    factors = scaled[:, 1 + i] * scaled[:, 1 + j]
    g_ref = products(relative(X, scheme.vectors))
    centre = _base(scheme, X * scaled[:, :, None], 0.0, 0.0, 0.0 * thickness)
    n, k = scaled.shape
    totals = None
    for xi, eta, depth, weight in _stations(*scheme.points):
        zeta = 0.5 * thickness * depth
        G = _base(scheme, X * scaled[:, :, None], xi, eta, zeta)
        volume = np.linalg.det(G)
        _check(volume, names)
        w = weight * 0.5 * thickness * volume
        to_local = _transform(G)
        parts = scheme.strains(xi, eta)
        A = (parts[0] + zeta[:, None, None] * parts[1] + zeta[:, None, None] ** 2 * parts[2])
        A *= factors[:, None]
        metric = 2.0 * np.einsum("eij,ej->ei", A, g_ref)[:, :, None] * bilinear(xi, eta)[0]
        rows = [to_local @ A, to_local @ metric, to_local @ (zeta[:, None, None] * metric)]
        rows += _enhanced(scheme, xi, eta, zeta, centre, G)
        S = np.concatenate(rows, axis=2)
        N = _weights(scheme, xi, eta, zeta) * scaled
        new = _terms(S, N, w, zeta)
        totals = new if totals is None else [a + b for a, b in zip(totals, new, strict=True)]
    area = totals[5] / thickness
    means = totals[2] / area[:, None, None], totals[3] / area[:, None, None]
    return Tables(totals[0], totals[1], means, totals[4])


def _terms(S: Array, N: Array, w: Array, zeta: Array) -> list[Array]:
    """What one station adds to each integral."""
    w3 = w[:, None, None]
    trace = np.einsum("i,eij->ej", SPHERICAL, S)
    stress = DEVIATORIC[:, None] * S
    pressed = SPHERICAL[:, None] * trace[:, None]
    return [
        w3 * trace[:, :, None] * trace[:, None],
        w3 * (S.transpose(0, 2, 1) @ stress),
        w3 * _resultant(pressed, zeta),
        w3 * _resultant(stress, zeta),
        w3 * N[:, :, None] * N[:, None],
        w,
    ]


def _resultant(stress: Array, zeta: Array) -> Array:
    flat = stress[:, [0, 1, 3]]
    return np.concatenate([flat, zeta[:, None, None] * flat, stress[:, 4:]], axis=1)


def _scales(scheme: Scheme, sizes: Array) -> Array:
    """(n_e, k) slopes by xi and eta from those by u and v."""
    node = np.ones((len(sizes), scheme.vectors))
    if scheme.vectors == 4:
        node[:, 1:3] = 0.5 * sizes
    return np.tile(node, (1, 4))


def _stations(across: int, through: int):
    """xi, eta, zeta over half the thickness, weight of each Gauss point."""
    x, wx = np.polynomial.legendre.leggauss(across)
    z, wz = np.polynomial.legendre.leggauss(through)
    for i in range(across):
        for j in range(across):
            for k in range(through):
                yield x[i], x[j], z[k], wx[i] * wx[j] * wz[k]


def _normals(scheme: Scheme, xi: float, eta: float) -> Array:
    """(3, k) weights of all vectors in n, dn/dxi, dn/deta."""
    rows = np.zeros((3, 4 * scheme.vectors))
    rows[:, scheme.vectors - 1 :: scheme.vectors] = bilinear(xi, eta)
    return rows


def _weights(scheme: Scheme, xi: float, eta: float, zeta: Array) -> Array:
    """(n_e, k) of all vectors in the position of a point."""
    r, n = scheme.shape(xi, eta)[0], _normals(scheme, xi, eta)[0]
    return r + zeta[:, None] * n


def _base(scheme: Scheme, X: Array, xi: float, eta: float, zeta: Array) -> Array:
    """(n_e, 3, 3) rows: covariant base vectors."""
    r, n = scheme.shape(xi, eta), _normals(scheme, xi, eta)
    G = np.empty((len(X), 3, 3))
    G[:, :2] = r[1:] @ X + zeta[:, None, None] * (n[1:] @ X)
    G[:, 2] = n[0] @ X
    return G


def _local(G: Array) -> Array:
    """(n_e, 3, 3) rows: e1 along the first parameter line, e3 normal to the surface."""
    e1 = G[:, 0] / np.linalg.norm(G[:, 0], axis=1, keepdims=True)
    e3 = np.cross(G[:, 0], G[:, 1])
    e3 /= np.linalg.norm(e3, axis=1, keepdims=True)
    return np.stack([e1, np.cross(e3, e1), e3], axis=1)


def _voigt(Q: Array) -> Array:
    """(n_e, 6, 6) strains in directions a from those in directions i, Q (n_e, a, i)."""
    a, b = IJ.T
    one = Q[:, a[:, None], a] * Q[:, b[:, None], b]
    two = Q[:, a[:, None], b] * Q[:, b[:, None], a]
    # shear strains count twice in both; a normal strain on the right has one of two equal terms
    left = np.where(a == b, 1.0, 2.0)[:, None]
    right = np.where(a == b, 0.5, 0.5)[None]
    return left * right * (one + two)


def _transform(G: Array) -> Array:
    """(n_e, 6, 6) strains in the local frame from covariant ones."""
    contravariant = np.linalg.inv(G)
    return _voigt(_local(G) @ contravariant)


def _enhanced(
    scheme: Scheme, xi: float, eta: float, zeta: Array, centre: Array, G: Array
) -> list[Array]:
    """Enhanced strains in the local frame, without work on uniform stress (Simo & Rifai 1990)."""
    local, scale = _local(G), np.linalg.det(centre) / np.linalg.det(G)
    membrane, thickness = scheme.membrane(xi, eta), scheme.thickness(xi, eta)
    flat = np.zeros((6, len(membrane)))
    flat[[0, 1, 3]] = membrane.T
    from_centre = _voigt(local @ np.linalg.inv(centre))
    swelling = np.zeros((len(G), 6, len(thickness)))
    swelling[:, 2] = zeta[:, None] * thickness
    return [scale[:, None, None] * (from_centre @ flat), scale[:, None, None] * swelling]


def _check(volume: Array, names: Sequence[str]) -> None:
    bad = np.flatnonzero(~(volume > 0.0))
    if bad.size:
        raise ValueError(
            f"shell {names[bad[0]]!r}: an element has no area, is folded, thicker than its radius "
            "of curvature, or numbered against the normal"
        )
