"""Shear-deformable ANCF beam with two nodes of 12 coordinates: r, r_x, d2 = r_y, d3 = r_z.

Cubic Hermite axis, directors d2 and d3 linear between the nodes. The 24 coordinates less the
six rigid motions leave 18 strains, each of them objective:

==================  =====================================================  =================
strain              generalised strain (dimensionless)                     stiffness
==================  =====================================================  =================
axial (3)           Legendre coefficients of (r'.r' - 1)/2                 EA L (1, 3, 5 s)
bending (2 x 2)     L r''.n_k/|r'| - (g_k(L) - g_k(0)) at two Gauss pts    EI_k/(2 L)
shear (2 x 2)       g_k = r_x.d_k at the nodes                             k_s GA L/2
torsion (1)         (d3(0).d2(L) - d2(0).d3(L))/2                          GJ/L
section (2 x 3)     (d_k.d_k - 1)/2 and d2.d3 at the nodes                 EA L/2, GA L/2
==================  =====================================================  =================

with n_k = d_k/|d_k|. The measured strain is the difference to the reference configuration,
itself expanded by the thermal strain, so that a free uniform expansion of a curved, twisted
beam is free of stress to round-off. Elastic energy U = 1/2 sum D (strain)^2.

Sources: strains of a beam rather than of a continuum, Gerstmayr & Irschik (2008) and
Nachbagauer, Gruber & Gerstmayr (2013); critique of the continuum beam, Schwab & Meijaard
(2010); shear at the nodes (assumed natural strain), Dvorkin & Bathe (1984). The combination is
this project's own.

- Division by |r'| makes the bending strain the turning of the axis per *reference* length,
  the measure that is conjugate to the bending moment when the axis stretches (Gerstmayr &
  Irschik 2008), and keeps it unchanged by a uniform expansion.
- The quadratic Legendre part of the axial strain is relieved against membrane locking; how
  much is measured in ``line_elements.membrane_slack``.
- The directors' stretch is stiff (EA): the section follows the thermal expansion.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics import line_elements as line
from mechanics.description import Beam

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

STRAINS = 18
STATIONS = np.concatenate([[0.0, 1.0], line.GAUSS2, line.GAUSS3])
"""Where the material is evaluated, as fractions of the length."""

# An element is described by seven vectors X: c = (r_b - r_a)/L, r_x, d2, d3 at node a, then
# r_x, d2, d3 at node b. Only c contains the length.
C, A1, A2, A3, B1, B2, B3 = range(7)
# Rows of the strains.
AXIAL, BENDING, SHEAR, TORSION, SECTION = 0, 3, 7, 11, 12


def _quadratic_terms() -> list[tuple[int, int, int, float]]:
    """Strain row, two vectors, factor: each adds factor X_J.X_K to the strain of the row."""
    terms = []
    axis = (C, A1, B1)
    for g in range(3):
        for i in range(3):
            terms += [(AXIAL + g, axis[i], axis[i], 0.5 * line.AXIAL_FORM[g, i, i])]
            terms += [(AXIAL + g, axis[i], axis[j], line.AXIAL_FORM[g, i, j]) for j in range(i)]
    for k in range(2):
        for g in range(2):
            terms += [
                (BENDING + 2 * k + g, A1, A2 + k, 1.0),
                (BENDING + 2 * k + g, B1, B2 + k, -1.0),
            ]
        terms += [(SHEAR + 2 * k, A1, A2 + k, 1.0), (SHEAR + 2 * k + 1, B1, B2 + k, 1.0)]
        terms += [
            (SECTION + 2 * k, A2 + k, A2 + k, 0.5),
            (SECTION + 2 * k + 1, B2 + k, B2 + k, 0.5),
        ]
    terms += [(TORSION, A3, B2, 0.5), (TORSION, A2, B3, -0.5)]
    return [*terms, (SECTION + 4, A2, A3, 1.0), (SECTION + 5, B2, B3, 1.0)]


_TERMS = _quadratic_terms()
ROW, LEFT, RIGHT = (np.array([t[i] for t in _TERMS], dtype=np.intp) for i in range(3))
FACTOR = np.array([t[3] for t in _TERMS])

# At a bending point: u = L r'', t = r', d2, d3 from the vectors X, as lists of non-zero weights.
POINT_OF = np.array([0, 0, 0, 1, 1, 1, 2, 2, 3, 3], dtype=np.intp)
POINT_FROM = np.array([C, A1, B1, C, A1, B1, A2, B2, A3, B3], dtype=np.intp)
_SPAN = np.stack([1 - line.GAUSS2, line.GAUSS2], axis=-1)
_AXIS = [line.curvature_weights(line.GAUSS2), line.tangent_weights(line.GAUSS2)]
POINT_WEIGHT = np.hstack([*_AXIS, _SPAN, _SPAN])

# The eight vectors of coordinates r, r_x, d2, d3, r, r_x, d2, d3 in terms of X.
NODAL = np.array([C, A1, A2, A3, C, B1, B2, B3], dtype=np.intp)


class Beam3243:
    """All elements of this family in a scene.

    Attributes
    ----------
    names : name of the body of each element
    dofs : (n_e, 24) intp
    nodes : (n_e, 2) intp  rows of the section temperatures
    length : (n_e,) float [m]  arc length in the reference configuration
    damping_time : (n_e,) float [s]
    """

    def __init__(self, beams: Sequence[Beam], node_dofs, point_index):
        self.names = [str(name) for name in line.per_element(beams, [b.name for b in beams])]
        self._start = line.pairs([node_dofs[b.name] for b in beams]).astype(np.intp)
        self.dofs = (self._start[:, :, None] + np.arange(12)).reshape(-1, 24)
        self.nodes = line.pairs([point_index[b.name] for b in beams])
        self.damping_time = line.per_element(beams, [float(b.damping_time) for b in beams])
        self._unheated = line.per_element(beams, [float(b.reference_temperature) for b in beams])
        self._groups = line.groups(beams)
        self._sections = line.per_element(beams, [_section_row(b) for b in beams])
        self._density = line.per_element(beams, [b.material.density for b in beams])
        reference = line.pairs([coordinates(b) for b in beams])
        self.length = line.arc_lengths(reference[:, :, :3], reference[:, :, 3:6])
        self._reference = _reference_strains(reference, self.length)
        slopes = line.tangents(reference[:, :, :3], reference[:, :, 3:6], self.length)
        self._reference_axial = line.half_square(slopes)
        area, I2, I3 = self._sections[:, :3].T
        self._slack = line.membrane_slack(area, np.sqrt(I2 * I3), self.length)

    def coefficients(self, T: Array) -> Array:
        """Stiffness D and free strain of each generalised strain, (n_e, 36), smooth in T."""
        at = line.at_fractions(T[self.nodes], STATIONS)
        E, G, strain, expansion = np.empty((4, len(self.names), len(STATIONS)))
        for material, e in self._groups:
            mean = at[e, :, 0]
            E[e] = material.youngs_modulus(mean)
            G[e] = material.shear_modulus(mean)
            strain[e] = material.thermal_strain(mean, self._unheated[e, None])
            expansion[e] = material.expansion(mean)
        free = self._free_strains((1.0 + strain) ** 2, expansion[:, 2:4, None] * at[:, 2:4, 1:])
        return np.hstack([self._stiffness(E, G), free])

    def _stiffness(self, E: Array, G: Array) -> Array:
        """(n_e, 18) stiffness of each generalised strain."""
        A, I2, I3, J, k2, k3 = self._sections.T[:, :, None]
        half = 0.5 * self.length[:, None]
        E_ends, G_ends, E_bending = E[:, :2], G[:, :2], E[:, 2:4] / (4.0 * half)
        shear, stretch = G_ends * A * half, E_ends * A * half
        torsion = G[:, 5:6] * J / (2.0 * half)
        axial = line.axial_stiffness(E[:, 4:] * A, self.length, self._slack)
        bending = [E_bending * I2, E_bending * I3]
        return np.hstack(
            [axial, *bending, k2 * shear, k3 * shear, torsion, stretch, stretch, shear]
        )

    def _free_strains(self, stretch: Array, curvature: Array) -> Array:
        """(n_e, 18) strains of the unstressed element.

        Quadratic strains grow with the square ``stretch`` (n_e, 7) of the thermal stretch;
        bending only by ``curvature`` (n_e, 2 points, 2), the gradients of the thermal strain:
        the warmer side becomes the outer one.
        """
        free = self._reference.copy()
        free[:, AXIAL:BENDING] = line.axial_coefficients(self._reference_axial * stretch[:, 4:])
        turning = self.length[:, None, None] * curvature
        free[:, BENDING:SHEAR] -= turning.transpose(0, 2, 1).reshape(-1, 4)
        free[:, SHEAR:TORSION] *= np.tile(stretch[:, :2], 2)
        free[:, TORSION] *= stretch[:, 5]
        free[:, SECTION:] *= np.tile(stretch[:, :2], 3)
        return free

    def force(self, q: Array, v: Array, coef: Array, out: Array) -> None:
        """Add elastic and damping forces to ``out``."""
        _force(q, v, coef, self._start, self.length, self.damping_time, out)

    def tangent(self, q, v, coef, cK: float, cC: float, blocks: Array) -> None:
        """Write cK df/dq + cC df/dv to ``blocks`` (n_e, 24, 24)."""
        _tangent(q, v, coef, self._start, self.length, self.damping_time, cK, cC, blocks)

    def energy(self, q: Array, coef: Array) -> float:
        """Elastic energy [J]."""
        strains, _ = self._strains(q, np.zeros_like(q))
        return 0.5 * float(np.sum(coef[:, :STRAINS] * (strains - coef[:, STRAINS:]) ** 2))

    def dissipation(self, q: Array, v: Array, coef: Array) -> float:
        """Power of structural damping [W]."""
        _, rates = self._strains(q, v)
        return float(np.sum(self.damping_time[:, None] * coef[:, :STRAINS] * rates**2))

    def resultants(self, q: Array, v: Array, coef: Array) -> Array:
        """Section resultants N, Q2, Q3, Mt, M2, M3 of each element, (n_e, 6) [N, N m].

        Means over the element, damping included. M_k is positive where the axis bends towards
        e_k: axial stress = N/A - M2 y/I2 - M3 z/I3.
        """
        strains, rates = self._strains(q, v)
        excess = strains - coef[:, STRAINS:] + self.damping_time[:, None] * rates
        S = coef[:, :STRAINS] * excess
        N = S[:, AXIAL] / self.length
        Q = S[:, SHEAR:TORSION].reshape(-1, 2, 2).sum(axis=2) / self.length[:, None]
        M = S[:, BENDING:SHEAR].reshape(-1, 2, 2).sum(axis=2)
        return np.column_stack([N, Q, S[:, TORSION], M])

    def mass_blocks(self) -> Array:
        """(n_e, 24, 24) consistent mass: Hermite for r and r_x, linear for d2 and d3."""
        hermite = line.hermite_mass(self.length)
        A, I2, I3 = self._density * self._sections[:, :3].T
        linear = self.length[:, None, None] / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        scalar = np.zeros((len(self.names), 8, 8))
        scalar[:, [[0], [1], [4], [5]], [0, 1, 4, 5]] = A[:, None, None] * hermite
        scalar[:, [[2], [6]], [2, 6]] = I2[:, None, None] * linear
        scalar[:, [[3], [7]], [3, 7]] = I3[:, None, None] * linear
        return line.in_space(scalar)

    def _strains(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Generalised strains and their rates, both (n_e, 18)."""
        strains, rates = np.empty((2, len(self.names), STRAINS))
        _evaluate(q, v, self._start, self.length, strains, rates)
        return strains, rates


def build(
    beams: Sequence[Beam], node_dofs: Mapping[str, Indices], point_index: Mapping[str, Indices]
) -> Beam3243:
    """One term for all ``beams``.

    Parameters
    ----------
    node_dofs : (n,) of each body  first global coordinate of each node
    point_index : (n,) of each body  row of each node in the section temperatures
    """
    return Beam3243(beams, node_dofs, point_index)


def coordinates(beam: Beam) -> Array:
    """(n, 12) reference coordinates r, r_x = e1, d2 = e2, d3 = e3 of each node."""
    n = len(beam.points)
    return np.hstack([beam.points, np.asarray(beam.axes).reshape(n, 9)])


def _section_row(beam: Beam) -> list[float]:
    s = beam.section
    moments = [s.area, s.second_moment_2, s.second_moment_3, s.torsion_constant]
    return [*moments, s.shear_factor_2, s.shear_factor_3]


def _reference_strains(reference: Array, length: Array) -> Array:
    """(n_e, 18) strains at the reference."""
    n = len(reference)
    start = 24 * np.arange(n)[:, None] + np.array([0, 12])
    strains, rates = np.empty((2, n, STRAINS))
    q = reference.ravel()
    _evaluate(q, np.zeros_like(q), start, length, strains, rates)
    return strains


@njit(cache=True)
def _gather(q, start, e, L, X):
    """The seven vectors of an element, flat (21,)."""
    a, b = start[e, 0], start[e, 1]
    for i in range(3):
        X[i] = (q[b + i] - q[a + i]) / L
    for i in range(9):
        X[3 + i] = q[a + 3 + i]
        X[12 + i] = q[b + 3 + i]


@njit(cache=True)
def _points(X, g, Y):
    """u, t, d2, d3 (4, 3) at bending point g."""
    Y[:] = 0.0
    for m in range(10):
        for i in range(3):
            Y[POINT_OF[m], i] += POINT_WEIGHT[g, m] * X[3 * POINT_FROM[m] + i]


@njit(cache=True)
def _quadratic(X, B):
    """Gradients (18, 21) of the quadratic strains, linear in X."""
    B[:] = 0.0
    for m in range(FACTOR.size):
        for i in range(3):
            j, k = 3 * LEFT[m] + i, 3 * RIGHT[m] + i
            B[ROW[m], j] += FACTOR[m] * X[k]
            B[ROW[m], k] += FACTOR[m] * X[j]


@njit(cache=True)
def _add_bending(X, Y, eps, B):
    """Add u.n/|t| at the bending points to strains and gradients."""
    for g in range(2):
        _points(X, g, Y)
        u, t = Y[0], Y[1]
        tt = t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
        for k in range(2):
            d = Y[2 + k]
            dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
            f = 1.0 / np.sqrt(tt * dd)
            b = f * (u[0] * d[0] + u[1] * d[1] + u[2] * d[2])
            row = BENDING + 2 * k + g
            eps[row] += b
            for i in range(3):
                gu, gt, gd = f * d[i], -b * t[i] / tt, f * u[i] - b * d[i] / dd
                for j in range(3):
                    J = 3 * POINT_FROM[j] + i
                    B[row, J] += POINT_WEIGHT[g, j] * gu + POINT_WEIGHT[g, 3 + j] * gt
                B[row, 3 * (A2 + k) + i] += POINT_WEIGHT[g, 6] * gd
                B[row, 3 * (B2 + k) + i] += POINT_WEIGHT[g, 7] * gd


@njit(cache=True)
def _strains(X, Y, eps, B):
    """Strains (18,) and their gradients (18, 21)."""
    _quadratic(X, B)
    for r in range(STRAINS):
        s = 0.0
        for j in range(21):
            s += B[r, j] * X[j]
        eps[r] = 0.5 * s
    _add_bending(X, Y, eps, B)


@njit(cache=True)
def _rates(B, V, rate):
    for r in range(STRAINS):
        s = 0.0
        for j in range(21):
            s += B[r, j] * V[j]
        rate[r] = s


@njit(cache=True)
def _evaluate(q, v, start, length, strains, rates):
    X, V, B, Y = np.empty(21), np.empty(21), np.empty((STRAINS, 21)), np.empty((4, 3))
    for e in range(length.size):
        _gather(q, start, e, length[e], X)
        _gather(v, start, e, length[e], V)
        _strains(X, Y, strains[e], B)
        _rates(B, V, rates[e])


@njit(cache=True)
def _force(q, v, coef, start, length, damping_time, out):
    X, V, B, Y = np.empty(21), np.empty(21), np.empty((STRAINS, 21)), np.empty((4, 3))
    eps, rate, f = np.empty(STRAINS), np.zeros(STRAINS), np.empty(21)
    for e in range(length.size):
        _gather(q, start, e, length[e], X)
        _strains(X, Y, eps, B)
        if damping_time[e] > 0.0:
            _gather(v, start, e, length[e], V)
            _rates(B, V, rate)
        else:
            rate[:] = 0.0
        f[:] = 0.0
        for r in range(STRAINS):
            S = coef[e, r] * (eps[r] - coef[e, STRAINS + r] + damping_time[e] * rate[r])
            for j in range(21):
                f[j] += S * B[r, j]
        a, b = start[e, 0], start[e, 1]
        for i in range(3):
            out[a + i] -= f[i] / length[e]
            out[b + i] += f[i] / length[e]
        for i in range(9):
            out[a + 3 + i] += f[3 + i]
            out[b + 3 + i] += f[12 + i]


@njit(cache=True)
def _hessian(Y, k, H):
    """Second derivatives (4, 3, 4, 3) of u.n_k/|t| in u, t, d2, d3; only what is non-zero."""
    u, t, d = Y[0], Y[1], Y[2 + k]
    T, N, ud = 0.0, 0.0, 0.0
    for i in range(3):
        T, N, ud = T + t[i] * t[i], N + d[i] * d[i], ud + u[i] * d[i]
    f = 1.0 / np.sqrt(T * N)
    b, D = f * ud, 2 + k
    for i in range(3):
        for j in range(3):
            one = 1.0 if i == j else 0.0
            H[0, i, D, j] = f * (one - d[i] * d[j] / N)
            H[0, i, 1, j] = -f * d[i] * t[j] / T
            H[1, i, 1, j] = b * (3.0 * t[i] * t[j] / T - one) / T
            H[1, i, D, j] = -t[i] * (f * u[j] - b * d[j] / N) / T
            H[D, i, D, j] = (
                b * (3.0 * d[i] * d[j] / N - one) - f * (u[i] * d[j] + d[i] * u[j])
            ) / N
            H[D, j, 0, i], H[1, j, 0, i], H[D, j, 1, i] = (
                H[0, i, D, j],
                H[0, i, 1, j],
                H[1, i, D, j],
            )


@njit(cache=True)
def _add_geometric(X, V, Y, H, HM, S, tau, Bv, K):
    """Add the bending strains' second derivatives, times S to K, times V to Bv."""
    for g in range(2):
        _points(X, g, Y)
        for k in range(2):
            row = BENDING + 2 * k + g
            H[:] = 0.0
            _hessian(Y, k, H)
            HM[:] = 0.0
            for m in range(10):
                R, J, w = POINT_OF[m], 3 * POINT_FROM[m], POINT_WEIGHT[g, m]
                for p in range(12):
                    for i in range(3):
                        HM[p, J + i] += w * H[p // 3, p % 3, R, i]
            for m in range(10):
                R, J, w = POINT_OF[m], 3 * POINT_FROM[m], POINT_WEIGHT[g, m]
                for i in range(3):
                    for j in range(21):
                        K[J + i, j] += S[row] * w * HM[3 * R + i, j]
            if tau > 0.0:
                for m in range(10):
                    R, J, w = POINT_OF[m], 3 * POINT_FROM[m], POINT_WEIGHT[g, m]
                    for i in range(3):
                        for j in range(21):
                            Bv[row, J + i] += w * HM[3 * R + i, j] * V[j]


@njit(cache=True)
def _tangent(q, v, coef, start, length, damping_time, cK, cC, blocks):
    X, V, B, Bv = np.empty(21), np.zeros(21), np.empty((STRAINS, 21)), np.zeros((STRAINS, 21))
    Y, H, HM = np.empty((4, 3)), np.empty((4, 3, 4, 3)), np.empty((12, 21))
    eps, S, K = np.empty(STRAINS), np.empty(STRAINS), np.empty((21, 21))
    for e in range(length.size):
        L, tau = length[e], damping_time[e]
        _gather(q, start, e, L, X)
        _strains(X, Y, eps, B)
        if tau > 0.0:
            _gather(v, start, e, L, V)
            _rates(B, V, S)
            _quadratic(V, Bv)
        else:
            S[:] = 0.0
        for r in range(STRAINS):
            S[r] = cK * coef[e, r] * (eps[r] - coef[e, STRAINS + r] + tau * S[r])
        K[:] = 0.0
        _add_geometric(X, V, Y, H, HM, S, tau, Bv, K)
        for m in range(FACTOR.size):
            for i in range(3):
                j, k = 3 * LEFT[m] + i, 3 * RIGHT[m] + i
                K[j, k] += FACTOR[m] * S[ROW[m]]
                K[k, j] += FACTOR[m] * S[ROW[m]]
        for r in range(STRAINS):
            for i in range(21):
                s = coef[e, r] * B[r, i]
                if s != 0.0:
                    for j in range(21):
                        K[i, j] += s * ((cK + cC * tau) * B[r, j] + cK * tau * Bv[r, j])
        for i in range(24):
            si = -1.0 / L if i < 3 else (1.0 / L if 12 <= i < 15 else 1.0)
            for j in range(24):
                sj = -1.0 / L if j < 3 else (1.0 / L if 12 <= j < 15 else 1.0)
                k = K[3 * NODAL[i // 3] + i % 3, 3 * NODAL[j // 3] + j % 3]
                blocks[e, i, j] = si * sj * k
