"""ANCF cable with two nodes of 6 coordinates, r and r_x: tension and bending, no twist or shear.

The gradient-deficient element of Gerstmayr & Shabana (2006): a cubic Hermite axis. Its strains
are the first three Legendre coefficients of the axial strain e = (r'.r' - 1)/2, and at two Gauss
points the turning of the axis per reference length,

    kappa = |r' x r''| / |r'|^2,

the *material* measure of curvature (Gerstmayr & Irschik 2008): |r'| once less in the denominator
than the geometric curvature of the paper of 2006, conjugate to the bending moment when the cable
stretches, and unchanged by a uniform expansion.

- Elastic energy EA/2 int (e - e_th)^2 + EI/2 int (kappa - kappa_ref)^2, the quadratic part of e
  being relieved as in ``line_elements.membrane_slack``.
- A cable has no twist, so its bending stiffness is the same in all directions, and a temperature
  gradient across it bends it in none: only the mean temperature acts.
- kappa has a kink where it vanishes. A straight cable never meets it: its energy holds kappa^2.
  For a cable curved by nature it is rounded off below ``ROUNDING`` kappa_ref, and so is the rate
  of kappa in the damping below the angle ``DAMPED`` per element.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics import line_elements as line
from mechanics.description import Beam
from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel
from mechanics.layout import Layout
from mechanics.prediction import shifted

Array = NDArray[np.float64]

ROUNDING = 0.01
"""Curvature, relative to that of the reference, below which the kink at zero is rounded [-].

The rounded curvature (kappa^2 + rho^2)^1/2 changes less than kappa near that of the reference; its
stiffness is raised by 1 + ROUNDING^2, so that small bending meets EI.
"""
DAMPED = 1e-4
"""Turning of the axis per element below which bending is not damped [rad]."""

STRAINS = 5
STATIONS = np.concatenate([line.XI2, line.XI3])
"""Where the material is evaluated, as fractions of the length."""

# An element is described by three vectors X: c = (r_b - r_a)/L and r_x at both nodes.
FORM = line.AXIAL_FORM
POINT = np.stack([line.curvature_weights(line.XI2), line.tangent_weights(line.XI2)], axis=1)
"""(2, 2, 3) weights of X in L r'' and r' at the bending points."""
NODAL = np.array([0, 1, 0, 2], dtype=np.intp)
"""The four vectors of coordinates r, r_x, r, r_x in terms of X."""


class Cable:
    """All elements of this family in a scene: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    names : name of the body of each element
    dofs : (n_e, 12) intp
    nodes : (n_e, 2) intp  rows of the section temperatures
    length : (n_e,) float [m]  arc length in the reference configuration
    ints : (n_e, 2) int64  first coordinate of both nodes
    floats : (n_e, 2) float  length [m], damping time [s]
    """

    name = "cable"

    def __init__(self, beams: Sequence[Beam], layout: Layout):
        self.names = [str(name) for name in line.per_element(beams, [b.name for b in beams])]
        self.ints = line.pairs([layout.node_dofs[b.name] for b in beams]).astype(np.int64)
        self.dofs = (self.ints[:, :, None] + np.arange(6)).reshape(-1, 12).astype(np.intp)
        self.nodes = line.pairs([layout.point_index[b.name] for b in beams])
        self._unheated = line.per_element(beams, [float(b.reference_temperature) for b in beams])
        self._groups = line.groups(beams)
        self._area = line.per_element(beams, [b.section.area for b in beams])
        self._moment = line.per_element(beams, [_second_moment(b) for b in beams])
        self._density = line.per_element(beams, [b.material.density for b in beams])
        r, r_x = np.moveaxis(layout.q0[self.dofs].reshape(-1, 2, 2, 3), 2, 0)
        self.length = line.arc_lengths(r, r_x)
        tau = line.per_element(beams, [float(b.damping_time) for b in beams])
        self.floats = np.column_stack([self.length, tau])
        self._slack = line.membrane_slack(self._area, self._moment, self.length)
        self._axial = line.half_square(line.tangents(r, r_x, self.length))
        self._turning = self._reference_turning(layout.q0)
        self.symmetric = not tau.any()
        self.signals: list = []
        self.force, self.tangent, self.energy = add_force, add_tangent, add_energies

    def coefficients(self, T: Array) -> Array:
        """Stiffnesses (5), free axial strains (3), free turning (2), rates of the free axial
        strains (3, zero): (n_e, 13), smooth in T.
        """
        mean = line.at_fractions(T[self.nodes, 0], STATIONS)
        E, strain = np.empty((2, *mean.shape))
        for material, e in self._groups:
            E[e] = material.youngs_modulus(mean[e])
            strain[e] = material.thermal_strain(mean[e], self._unheated[e, None])
        # strains are elastic from the expanded body: see Beam3243 on the powers of the stretch
        stretch = 1.0 + strain
        EA = E[:, 2:] * self._area[:, None] / stretch[:, 2:]
        axial = line.axial_stiffness(EA, self.length, self._slack)
        bending = E[:, :2] * stretch[:, :2] ** 3 * (self._moment / (2.0 * self.length))[:, None]
        bending *= np.where(self._turning > 0.0, 1.0 + ROUNDING**2, 1.0)
        free = line.axial_coefficients(self._axial * stretch[:, 2:] ** 2)
        return np.hstack([axial, bending, free, self._turning, np.zeros_like(free)])

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        return line.with_rates(c0, c1, h, slice(5, 8), slice(10, 13))

    def predicted(self, coef: Array, y: Array, step: Array, new: Array) -> Array:
        """Coefficients with the tension that is predicted, see ``mechanics.prediction``.

        What acts on half (L kappa)^2 does not change where the cable is straight by nature.
        """

        def axial(y: Array, v: Array) -> tuple[Array, Array]:
            strains, rates = self._strains(y, v)
            return strains[:, :3], rates[:, :3]

        return shifted(coef, slice(5, 8), axial, y, step, new)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """Section resultants, (n_e, 6) [N, N m]: tension N in column 0, moment in column 4.

        Means over the element, damping included in N. The moment is a magnitude: a cable does
        not know its section's directions.
        """
        strains, rates = self._strains(y, v)
        mean = strains[:, 0] - coef[:, 5] + self.floats[:, 1] * (rates[:, 0] - coef[:, 10])
        resultants = np.zeros((len(self.names), 6))
        resultants[:, 0] = coef[:, 0] * mean / self.length
        resultants[:, 4] = np.abs(np.sum(coef[:, 3:5] * _turning_excess(strains, coef), axis=1))
        return resultants

    def mass_blocks(self) -> Array:
        """(n_e, 12, 12) consistent mass of the axis; no rotary inertia."""
        scalar = line.hermite_mass(self.length) * (self._density * self._area)[:, None, None]
        return line.in_space(scalar)

    def _strains(self, y: Array, v: Array) -> tuple[Array, Array]:
        """Strains and their rates, both (n_e, 5)."""
        strains, rates = np.empty((2, len(self.names), STRAINS))
        _evaluate(y, v, self.ints, self.floats, strains, rates)
        return strains, rates

    def _reference_turning(self, q0: Array) -> Array:
        """(n_e, 2) L kappa at the bending points; straight to round-off counts as straight."""
        turning = np.sqrt(2.0 * self._strains(q0, np.zeros_like(q0))[0][:, 3:])
        return np.where(turning > 1e-10, turning, 0.0)


def build(beams: Sequence[Beam], layout: Layout) -> Cable:
    """One term for all ``beams``."""
    return Cable(beams, layout)


def _second_moment(beam: Beam) -> float:
    I2, I3 = beam.section.second_moment_2, beam.section.second_moment_3
    if abs(I2 - I3) > 1e-6 * I2:
        raise ValueError(
            f"cable {beam.name!r} bends alike in all directions; "
            f"its second moments must be equal, got {I2:g} and {I3:g} m^4"
        )
    return I2


def _turning_excess(strains: Array, coef: Array) -> Array:
    """(n_e, 2) rounded L (kappa - kappa_ref)."""
    free = coef[:, 8:10]
    rounding = (ROUNDING * free) ** 2
    return np.sqrt(2.0 * strains[:, 3:] + rounding) - np.sqrt(free**2 + rounding)


@njit(cache=True, error_model="numpy")
def _gather(y, start, L, X):
    a, b = start[0], start[1]
    for i in range(3):
        X[0, i] = (y[b + i] - y[a + i]) / L
        X[1, i] = y[a + 3 + i]
        X[2, i] = y[b + 3 + i]


@njit(cache=True, error_model="numpy")
def _axial(X, B):
    """Gradients (3, 3, 3) of the axial strains, linear in X."""
    B[:3] = 0.0
    for k in range(3):
        for i in range(3):
            for j in range(3):
                for x in range(3):
                    B[k, i, x] += FORM[k, i, j] * X[j, x]


@njit(cache=True, error_model="numpy")
def _point(X, g, Y):
    """u = L r'' and t = r' at bending point g; returns t.t, u.t/t.t and |u - (u.t/t.t) t|^2."""
    Y[:] = 0.0
    for k in range(2):
        for j in range(3):
            for x in range(3):
                Y[k, x] += POINT[g, k, j] * X[j, x]
    u, t = Y[0], Y[1]
    tt = t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
    s = (u[0] * t[0] + u[1] * t[1] + u[2] * t[2]) / tt
    square = 0.0
    for x in range(3):
        square += (u[x] - s * t[x]) ** 2
    return tt, s, square


@njit(cache=True, error_model="numpy")
def _strains(X, Y, eps, B):
    """Strains (5,), the last two half (L kappa)^2, and their gradients (5, 3, 3)."""
    _axial(X, B)
    for k in range(3):
        eps[k] = 0.0
        for j in range(3):
            for x in range(3):
                eps[k] += 0.5 * B[k, j, x] * X[j, x]
    for g in range(2):
        tt, s, square = _point(X, g, Y)
        eps[3 + g] = 0.5 * square / tt
        for x in range(3):
            p = Y[0, x] - s * Y[1, x]
            gu, gt = p / tt, -(square / tt * Y[1, x] + s * p) / tt
            for j in range(3):
                B[3 + g, j, x] = POINT[g, 0, j] * gu + POINT[g, 1, j] * gt


@njit(cache=True, error_model="numpy")
def _rates(B, V, rate):
    for k in range(STRAINS):
        rate[k] = 0.0
        for j in range(3):
            for x in range(3):
                rate[k] += B[k, j, x] * V[j, x]


@njit(cache=True, error_model="numpy")
def _evaluate(y, v, ints, floats, strains, rates):
    X, V, Y, B = np.empty((3, 3)), np.empty((3, 3)), np.empty((2, 3)), np.empty((STRAINS, 3, 3))
    for e in range(len(ints)):
        _gather(y, ints[e], floats[e, 0], X)
        _gather(v, ints[e], floats[e, 0], V)
        _strains(X, Y, strains[e], B)
        _rates(B, V, rates[e])


@njit(cache=True, error_model="numpy")
def _stress(c, tau, eps, rate, S, slope, viscous):
    """Stresses S (5,) and their derivatives with respect to the strains and to their rates."""
    for k in range(3):
        S[k] = c[k] * (eps[k] - c[5 + k] + tau * (rate[k] - c[10 + k]))
        slope[k], viscous[k] = c[k], c[k] * tau
    for k in range(3, 5):
        free = c[5 + k]
        S[k], slope[k] = c[k], 0.0
        if free > 0.0:
            rounding = (ROUNDING * free) ** 2
            root = np.sqrt((free * free + rounding) / (2.0 * eps[k] + rounding))
            S[k] -= c[k] * root
            slope[k] = c[k] * root / (2.0 * eps[k] + rounding)
        d = 2.0 * eps[k] + DAMPED**2
        viscous[k] = c[k] * tau / d
        S[k] += viscous[k] * rate[k]
        slope[k] -= 2.0 * viscous[k] * rate[k] / d


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    X, V, Y, B = np.empty((3, 3)), np.empty((3, 3)), np.empty((2, 3)), np.empty((STRAINS, 3, 3))
    eps, rate, S = np.empty(STRAINS), np.empty(STRAINS), np.empty(STRAINS)
    slope, viscous = np.empty(STRAINS), np.empty(STRAINS)
    for e in range(len(ints)):
        L = floats[e, 0]
        _gather(y, ints[e], L, X)
        _gather(v, ints[e], L, V)
        _strains(X, Y, eps, B)
        _rates(B, V, rate)
        _stress(coef[e], floats[e, 1], eps, rate, S, slope, viscous)
        a, b = ints[e, 0], ints[e, 1]
        for k in range(STRAINS):
            for x in range(3):
                out[a + x] -= S[k] * B[k, 0, x] / L
                out[b + x] += S[k] * B[k, 0, x] / L
                out[a + 3 + x] += S[k] * B[k, 1, x]
                out[b + 3 + x] += S[k] * B[k, 2, x]


@kernel(ENERGY)
def add_energies(y, v, coef, ints, floats, out):
    X, V, Y, B = np.empty((3, 3)), np.empty((3, 3)), np.empty((2, 3)), np.empty((STRAINS, 3, 3))
    eps, rate = np.empty(STRAINS), np.empty(STRAINS)
    for e in range(len(ints)):
        _gather(y, ints[e], floats[e, 0], X)
        _gather(v, ints[e], floats[e, 0], V)
        _strains(X, Y, eps, B)
        _rates(B, V, rate)
        c, tau = coef[e], floats[e, 1]
        for k in range(3):
            excess = rate[k] - c[10 + k]
            out[0] += 0.5 * c[k] * (eps[k] - c[5 + k]) ** 2
            out[1] += tau * c[k] * excess * excess
            out[2] += tau * c[k] * excess * c[10 + k]
        for k in range(3, 5):
            free, rounding = c[5 + k], (ROUNDING * c[5 + k]) ** 2
            turned = np.sqrt(2.0 * eps[k] + rounding) - np.sqrt(free * free + rounding)
            out[0] += 0.5 * c[k] * turned * turned
            out[1] += tau * c[k] * rate[k] ** 2 / (2.0 * eps[k] + DAMPED**2)


@njit(cache=True, error_model="numpy")
def _hessian(Y, tt, s, square, H):
    """Second derivatives (2, 3, 2, 3) of half (L kappa)^2 in u and t."""
    for i in range(3):
        for j in range(3):
            one = 1.0 if i == j else 0.0
            ti, tj = Y[1, i], Y[1, j]
            pi, pj = Y[0, i] - s * ti, Y[0, j] - s * tj
            H[0, i, 0, j] = (one - ti * tj / tt) / tt
            ut = (s * ti * tj - 2.0 * pi * tj - ti * pj) / tt - s * one
            H[0, i, 1, j] = H[1, j, 0, i] = ut / tt
            tt_ij = (4.0 * square / tt - s * s) * ti * tj - pi * pj
            tt_ij += 3.0 * s * (pi * tj + ti * pj) + (s * s * tt - square) * one
            H[1, i, 1, j] = tt_ij / (tt * tt)


@njit(cache=True, error_model="numpy")
def _second(X, Y, H, D):
    """Second derivatives (5, 9, 9) of the strains."""
    for k in range(3):
        for a in range(9):
            for b in range(9):
                D[k, a, b] = FORM[k, a // 3, b // 3] if a % 3 == b % 3 else 0.0
    D[3:] = 0.0
    for g in range(2):
        tt, s, square = _point(X, g, Y)
        _hessian(Y, tt, s, square, H)
        for a in range(9):
            for b in range(9):
                for k in range(2):
                    for m in range(2):
                        w = POINT[g, k, a // 3] * POINT[g, m, b // 3]
                        D[3 + g, a, b] += w * H[k, a % 3, m, b % 3]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    X, V, Y, B = np.empty((3, 3)), np.empty((3, 3)), np.empty((2, 3)), np.empty((STRAINS, 3, 3))
    eps, rate, S = np.empty(STRAINS), np.empty(STRAINS), np.empty(STRAINS)
    slope, viscous = np.empty(STRAINS), np.empty(STRAINS)
    H, D, K = np.empty((2, 3, 2, 3)), np.empty((STRAINS, 9, 9)), np.empty((9, 9))
    for e in range(len(ints)):
        L = floats[e, 0]
        _gather(y, ints[e], L, X)
        _gather(v, ints[e], L, V)
        _strains(X, Y, eps, B)
        _rates(B, V, rate)
        _stress(coef[e], floats[e, 1], eps, rate, S, slope, viscous)
        _second(X, Y, H, D)
        K[:] = 0.0
        for k in range(STRAINS):
            for b in range(9):
                turned = 0.0
                for c in range(9):
                    turned += D[k, b, c] * V[c // 3, c % 3]
                w = (cK * slope[k] + cC * viscous[k]) * B[k, b // 3, b % 3]
                w += cK * viscous[k] * turned
                for a in range(9):
                    K[a, b] += B[k, a // 3, a % 3] * w + cK * S[k] * D[k, a, b]
        for i in range(12):
            si = 1.0 if i // 3 % 2 else (-1.0 / L if i < 3 else 1.0 / L)
            for j in range(12):
                sj = 1.0 if j // 3 % 2 else (-1.0 / L if j < 3 else 1.0 / L)
                k = K[3 * NODAL[i // 3] + i % 3, 3 * NODAL[j // 3] + j % 3]
                data[slots[e, 12 * i + j]] += si * sj * k
