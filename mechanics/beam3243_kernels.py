"""Strains, forces and tangents of the beam of ``mechanics.beam3243``.

An element is described by seven vectors X: c = (r_b - r_a)/L, then r_x, d2, d3 at node a, then
r_x, d2, d3 at node b; only c contains the length. Its strains eps are made in four sweeps:

1. sums of products X_J.X_K, by table;
2. u.n_k at four points: u = L r'' at two Gauss points (bending), u = r_x at two nodes (shear);
3. sums of products eps_p eps_q, by table: what axial strain and bending owe to shear and twist;
4. bending divided by Gamma_1, the component of r' along the normal of the section;
5. sums of products again: what torsion owes to bending.

The tangent goes the same way back. The tables are baked into the compiled kernels; they and what
they are made of are pure numbers (Hermite, Gauss, Legendre), not parameters.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel
from mechanics.line_elements import (
    AXIAL_FORM,
    LEGENDRE,
    WEIGHT3,
    XI2,
    XI3,
    curvature_weights,
    tangent_weights,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Table = tuple[Indices, Indices, Indices, Array]

C, A1, A2, A3, B1, B2, B3 = range(7)
"""Vectors X."""
AXIAL, BENDING, SHEAR, TORSION, SECTION, NORMAL, TURN, ONE = 0, 3, 7, 11, 12, 18, 20, 21
"""First row of each kind of strain; bending, shear and section: k = 2 at both places, then k = 3.

Three kinds of rows are no strains: ``NORMAL``, Gamma_1^2 at the bending points; ``TURN``, the
turn of one end against the other; ``ONE``, the number 1, so that products hold linear terms too.
"""
MAGNUS = np.sqrt(3.0) / 12.0
"""Turn of the ends about the axis for bending (b_2, b_3) at one Gauss point, (c_2, c_3) at the
other: MAGNUS (b_2 c_3 - b_3 c_2), the second term of the expansion of Magnus (1954) for a
curvature that is linear in x."""
STRAINS, ROWS = 18, 22
AXIS = np.array([C, A1, B1], dtype=np.intp)
"""Vectors on which the axis depends."""


def _products_of_vectors() -> Table:
    """Row, J, K, factor."""
    slopes = tangent_weights(XI2)
    forms = [*AXIAL_FORM, *(2.0 * slopes[:, :, None] * slopes[:, None, :])]
    terms = []
    for row, form in zip((*range(AXIAL, BENDING), NORMAL, NORMAL + 1), forms, strict=True):
        for i, j in zip(*np.triu_indices(3), strict=True):
            terms += [(row, AXIS[i], AXIS[j], form[i, j] * (0.5 if i == j else 1.0))]
    for k in range(2):
        row = SECTION + 2 * k
        terms += [(row, A2 + k, A2 + k, 0.5), (row + 1, B2 + k, B2 + k, 0.5)]
    terms += [(SECTION + 4, A2, A3, 1.0), (SECTION + 5, B2, B3, 1.0)]
    return _columns([*terms, (TURN, A3, B2, 0.5), (TURN, A2, B3, -0.5)])


def _products_of_strains() -> Table:
    """Row, p, q, factor: the third sweep, then the three terms of the last."""
    ends = [1 - XI3, XI3]
    forms = np.einsum("kg,ig,jg->kij", LEGENDRE * WEIGHT3, ends, ends)
    forms = [*forms, *(2.0 * ENDS[:2, :, None] * ENDS[:2, None, :])]
    terms = []
    for k in range(2):
        a, b = SHEAR + 2 * k, SHEAR + 2 * k + 1
        for row, form in zip((*range(AXIAL, BENDING), NORMAL, NORMAL + 1), forms, strict=True):
            terms += [(row, a, b, -form[0, 1])]
            terms += [(row, a, a, -0.5 * form[0, 0]), (row, b, b, -0.5 * form[1, 1])]
        for g in range(2):
            own, other, sign = BENDING + 2 * k + g, BENDING + 2 * (1 - k) + g, 2.0 * k - 1.0
            terms += [(own, a, ONE, 1.0), (own, b, ONE, -1.0)]
            terms += [(other, TURN, p, sign * ENDS[g, i]) for i, p in enumerate((a, b))]
    return _columns([*terms, *_twist()])


def _twist() -> list[tuple[int, int, int, float]]:
    terms = [(TORSION, TURN, ONE, 1.0), (TORSION, BENDING, BENDING + 3, -MAGNUS)]
    return [*terms, (TORSION, BENDING + 2, BENDING + 1, MAGNUS)]


def _columns(terms: list[tuple[int, int, int, float]]) -> Table:
    rows, left, right = (np.array([t[i] for t in terms], dtype=np.intp) for i in range(3))
    return rows, left, right, np.array([t[3] for t in terms])


AHEAD = np.vstack([curvature_weights(XI2), [[0, 1, 0], [0, 0, 1]]])
"""(4, 3) weights of the vectors AXIS in u at the four points."""
ENDS = np.vstack([np.stack([1 - XI2, XI2], axis=-1), np.eye(2)])
"""(4, 2) weights of the directors of both nodes in d_k at the four points."""
POINT_ROW = np.array([[3, 5], [4, 6], [7, 9], [8, 10]], dtype=np.intp)
"""(4, 2) row of the strain of each point and k."""
ROW, LEFT, RIGHT, FACTOR = _products_of_vectors()
MIX_ROW, MIX_P, MIX_Q, MIX_FACTOR = _products_of_strains()
SWEEP = np.array([0, MIX_FACTOR.size - 3, MIX_FACTOR.size], dtype=np.intp)
"""Where the third sweep begins, and the last, and where it ends."""
NODAL = np.array([C, A1, A2, A3, C, B1, B2, B3], dtype=np.intp)
"""The eight vectors of coordinates r, r_x, d2, d3, r, r_x, d2, d3 in terms of X."""


@njit(cache=True, error_model="numpy")
def _gather(q, ints, e, L, X):
    """The seven vectors of an element, flat (21,)."""
    a, b = ints[e, 0], ints[e, 1]
    for i in range(3):
        X[i] = (q[b + i] - q[a + i]) / L
    for i in range(9):
        X[3 + i] = q[a + 3 + i]
        X[12 + i] = q[b + 3 + i]


@njit(cache=True, error_model="numpy")
def _strains(X, eps, B):
    """Strains (22,) and their gradients (22, 21) with respect to X."""
    Y = np.empty((2, 3))
    _products(X, B)
    eps[:] = 0.0
    for m in range(FACTOR.size):
        j, k = 3 * LEFT[m], 3 * RIGHT[m]
        dot = X[j] * X[k] + X[j + 1] * X[k + 1] + X[j + 2] * X[k + 2]
        eps[ROW[m]] += FACTOR[m] * dot
    for g in range(4):
        for k in range(2):
            _point(X, g, k, Y)
            N, un = _normal(Y)
            row = POINT_ROW[g, k]
            eps[row] = un
            for i in range(3):
                n = Y[1, i] / N
                for m in range(3):
                    B[row, 3 * AXIS[m] + i] += AHEAD[g, m] * n
                for m in range(2):
                    B[row, 9 * m + 6 + 3 * k + i] += ENDS[g, m] * (Y[0, i] - un * n) / N
    eps[ONE] = 1.0
    _mix(eps, B, SWEEP[0], SWEEP[1])
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        s = 1.0 / np.sqrt(eps[z])
        eps[r] *= s
        for j in range(21):
            B[r, j] = s * B[r, j] - 0.5 * eps[r] / eps[z] * B[z, j]
    _mix(eps, B, SWEEP[1], SWEEP[2])


@njit(cache=True, error_model="numpy")
def _rates(B, V, rate):
    for r in range(ROWS):
        rate[r] = 0.0
        for j in range(21):
            rate[r] += B[r, j] * V[j]


@njit(cache=True, error_model="numpy")
def _products(X, B):
    """Gradients (22, 21) of the sums of products of vectors; linear in X."""
    B[:] = 0.0
    for m in range(FACTOR.size):
        for i in range(3):
            j, k = 3 * LEFT[m] + i, 3 * RIGHT[m] + i
            B[ROW[m], j] += FACTOR[m] * X[k]
            B[ROW[m], k] += FACTOR[m] * X[j]


@njit(cache=True, error_model="numpy")
def _point(X, g, k, Y):
    """u and d_k (2, 3) at point g."""
    for i in range(3):
        Y[0, i] = AHEAD[g, 0] * X[i] + AHEAD[g, 1] * X[3 + i] + AHEAD[g, 2] * X[12 + i]
        Y[1, i] = ENDS[g, 0] * X[6 + 3 * k + i] + ENDS[g, 1] * X[15 + 3 * k + i]


@njit(cache=True, error_model="numpy")
def _normal(Y):
    """|d| and u.n."""
    dd, ud = 0.0, 0.0
    for i in range(3):
        dd += Y[1, i] * Y[1, i]
        ud += Y[0, i] * Y[1, i]
    N = np.sqrt(dd)
    return N, ud / N


@njit(cache=True, error_model="numpy")
def _mix(eps, B, first, end):
    """Add products of strains to strains and their gradients."""
    for m in range(first, end):
        r, p, q = MIX_ROW[m], MIX_P[m], MIX_Q[m]
        a, b = MIX_FACTOR[m] * eps[p], MIX_FACTOR[m] * eps[q]
        eps[r] += a * eps[q]
        for j in range(21):
            B[r, j] += a * B[q, j] + b * B[p, j]


@njit(cache=True, error_model="numpy")
def _mix_rates(eps, rate, B, Bv, first, end):
    """Add the rates of the same gradients to Bv."""
    for m in range(first, end):
        r, p, q, f = MIX_ROW[m], MIX_P[m], MIX_Q[m], MIX_FACTOR[m]
        a, b, c, d = f * eps[p], f * eps[q], f * rate[p], f * rate[q]
        for j in range(21):
            Bv[r, j] += a * Bv[q, j] + b * Bv[p, j] + c * B[q, j] + d * B[p, j]


@njit(cache=True, error_model="numpy")
def _unmix(eps, B, S, W, first, end):
    """Pass the stresses of the products on to their factors, and their curvature to W."""
    for m in range(first, end):
        p, q = MIX_P[m], MIX_Q[m]
        s = S[MIX_ROW[m]] * MIX_FACTOR[m]
        S[p] += s * eps[q]
        S[q] += s * eps[p]
        for j in range(21):
            W[p, j] += s * B[q, j]
            W[q, j] += s * B[p, j]


@njit(cache=True, error_model="numpy")
def _undivide(eps, B, S, W):
    """Pass the bending moments on to numerator and denominator, and their curvature to W.

    b = eta z^-1/2 has the second derivative z^-1/2 eta'' - b/(2 z) z'' - (b' z' + z' b')/(2 z)
    + b/(4 z^2) z' z'.
    """
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        half = 0.5 / eps[z]
        for j in range(21):
            W[r, j] -= half * S[r] * B[z, j]
            W[z, j] -= half * S[r] * (B[r, j] - half * eps[r] * B[z, j])
        S[z] -= half * eps[r] * S[r]
        S[r] /= np.sqrt(eps[z])


@njit(cache=True, error_model="numpy")
def _divide_rates(eps, rate, B, Bv):
    """Rates of the gradients of bending, from those of numerator and denominator."""
    for r in range(BENDING, SHEAR):
        z = NORMAL + (r - BENDING) % 2
        s, half = 1.0 / np.sqrt(eps[z]), 0.5 / eps[z]
        a = half * (half * eps[r] * rate[z] - rate[r])
        for j in range(21):
            Bv[r, j] = s * Bv[r, j] - half * (eps[r] * Bv[z, j] + rate[z] * B[r, j]) + a * B[z, j]


@njit(cache=True, error_model="numpy")
def _bend_points(X, V, S, damped, Bv, K):
    """Add the second derivatives of u.n_k at the four points: times S to K, times V to Bv."""
    Y, Yv, H, Hv = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3, 2, 3)), np.empty((2, 3))
    for g in range(4):
        for k in range(2):
            row = POINT_ROW[g, k]
            _point(X, g, k, Y)
            _second(Y, H)
            if damped:
                _point(V, g, k, Yv)
                for a in range(6):
                    Hv[a // 3, a % 3] = 0.0
                    for b in range(6):
                        Hv[a // 3, a % 3] += H[a // 3, a % 3, b // 3, b % 3] * Yv[b // 3, b % 3]
            for m in range(5):
                M, P, w = _weight(g, k, m)
                if damped:
                    for i in range(3):
                        Bv[row, M + i] += w * Hv[P, i]
                for o in range(5):
                    L, Q, x = _weight(g, k, o)
                    if w * x != 0.0:
                        for i in range(3):
                            for j in range(3):
                                K[M + i, L + j] += S[row] * w * x * H[P, i, Q, j]


@njit(cache=True, error_model="numpy")
def _weight(g, k, m):
    """The m-th of five vectors at a point: its place in X, whether in u or in d, its weight."""
    if m < 3:
        return 3 * AXIS[m], 0, AHEAD[g, m]
    return 9 * (m - 3) + 6 + 3 * k, 1, ENDS[g, m - 3]


@njit(cache=True, error_model="numpy")
def _second(Y, H):
    """Second derivatives (2, 3, 2, 3) of u.n in u and d."""
    N, un = _normal(Y)
    for i in range(3):
        for j in range(3):
            one = 1.0 if i == j else 0.0
            ni, nj = Y[1, i] / N, Y[1, j] / N
            H[0, i, 0, j] = 0.0
            H[0, i, 1, j] = H[1, j, 0, i] = (one - ni * nj) / N
            bent = Y[0, i] * nj + ni * Y[0, j]
            H[1, i, 1, j] = (un * (3.0 * ni * nj - one) - bent) / (N * N)


@njit(cache=True, error_model="numpy")
def evaluate(q, v, ints, floats, strains, rates):
    """Strains and their rates (n_e, 18) of all elements."""
    X, V, B = np.empty(21), np.empty(21), np.empty((ROWS, 21))
    eps, rate = np.empty(ROWS), np.empty(ROWS)
    for e in range(len(floats)):
        _gather(q, ints, e, floats[e, 0], X)
        _gather(v, ints, e, floats[e, 0], V)
        _strains(X, eps, B)
        _rates(B, V, rate)
        strains[e], rates[e] = eps[:STRAINS], rate[:STRAINS]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Add the sum over strains of stress times gradient to ``out``."""
    X, V, B = np.empty(21), np.empty(21), np.empty((ROWS, 21))
    eps, rate, f = np.empty(ROWS), np.empty(ROWS), np.empty(21)
    for e in range(len(floats)):
        L, tau = floats[e, 0], floats[e, 1]
        _gather(y, ints, e, L, X)
        _strains(X, eps, B)
        rate[:] = 0.0
        if tau > 0.0:
            _gather(v, ints, e, L, V)
            _rates(B, V, rate)
        f[:] = 0.0
        for r in range(STRAINS):
            viscous = tau * (rate[r] - coef[e, 2 * STRAINS + r])
            S = coef[e, r] * (eps[r] - coef[e, STRAINS + r] + viscous)
            for j in range(21):
                f[j] += S * B[r, j]
        a, b = ints[e, 0], ints[e, 1]
        for i in range(3):
            out[a + i] -= f[i] / L
            out[b + i] += f[i] / L
        for i in range(9):
            out[a + 3 + i] += f[3 + i]
            out[b + 3 + i] += f[12 + i]


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    """Add elastic energy, and powers lost in damping and done by it on changing free strains."""
    strains = np.empty((len(floats), STRAINS))
    rates = np.empty((len(floats), STRAINS))
    evaluate(y, v, ints, floats, strains, rates)
    for e in range(len(floats)):
        for r in range(STRAINS):
            stiffness, free, heated = coef[e, r], coef[e, STRAINS + r], coef[e, 2 * STRAINS + r]
            viscous = floats[e, 1] * stiffness * (rates[e, r] - heated)
            out[0] += 0.5 * stiffness * (strains[e, r] - free) ** 2
            out[1] += viscous * (rates[e, r] - heated)
            out[2] += viscous * heated


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Add cK df/dq + cC df/dv to ``data``.

    f = sum S B with S = D (eps - free + tau B.v); hence df/dq = sum D B (B + tau dB/dt)^T + S dB/dq
    and df/dv = sum D tau B B^T. Rows of W hold the second factors of the outer products.
    """
    X, V, K = np.empty(21), np.zeros(21), np.empty((21, 21))
    B, Bv, W = np.empty((ROWS, 21)), np.zeros((ROWS, 21)), np.empty((ROWS, 21))
    eps, rate, S = np.empty(ROWS), np.empty(ROWS), np.empty(ROWS)
    for e in range(len(floats)):
        L, tau = floats[e, 0], floats[e, 1]
        _gather(y, ints, e, L, X)
        _strains(X, eps, B)
        rate[:] = 0.0
        if tau > 0.0:
            _gather(v, ints, e, L, V)
            _rates(B, V, rate)
            _products(V, Bv)
        S[:], W[:], K[:] = 0.0, 0.0, 0.0
        for r in range(STRAINS):
            viscous = tau * (rate[r] - coef[e, 2 * STRAINS + r])
            S[r] = cK * coef[e, r] * (eps[r] - coef[e, STRAINS + r] + viscous)
        _unmix(eps, B, S, W, SWEEP[1], SWEEP[2])
        _undivide(eps, B, S, W)
        _unmix(eps, B, S, W, SWEEP[0], SWEEP[1])
        _bend_points(X, V, S, tau > 0.0, Bv, K)
        for m in range(FACTOR.size):
            for i in range(3):
                j, k = 3 * LEFT[m] + i, 3 * RIGHT[m] + i
                K[j, k] += FACTOR[m] * S[ROW[m]]
                K[k, j] += FACTOR[m] * S[ROW[m]]
        for r in range(STRAINS):
            for j in range(21):
                W[r, j] += coef[e, r] * (cK + cC * tau) * B[r, j]
        if tau > 0.0:
            _mix_rates(eps, rate, B, Bv, SWEEP[0], SWEEP[1])
            _divide_rates(eps, rate, B, Bv)
            _mix_rates(eps, rate, B, Bv, SWEEP[1], SWEEP[2])
            for r in range(STRAINS):
                for j in range(21):
                    W[r, j] += coef[e, r] * cK * tau * Bv[r, j]
        for r in range(ONE):
            for i in range(21):
                if B[r, i] != 0.0:
                    for j in range(21):
                        K[i, j] += B[r, i] * W[r, j]
        for i in range(24):
            si = -1.0 / L if i < 3 else (1.0 / L if 12 <= i < 15 else 1.0)
            for j in range(24):
                sj = -1.0 / L if j < 3 else (1.0 / L if 12 <= j < 15 else 1.0)
                k = K[3 * NODAL[i // 3] + i % 3, 3 * NODAL[j // 3] + j % 3]
                data[slots[e, 24 * i + j]] += si * sj * k
