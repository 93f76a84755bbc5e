"""Strains, forces and tangents of the thin shell of ``mechanics.shell48``.

At a point the shell is described by five vectors x, sums of the 16 nodal vectors: the derivatives
r_1, r_2, r_11, r_22 and 2 r_12 in two orthonormal directions of the reference. From them follow
six strains and, with n = m/|m|, m = r_1 x r_2, their first and second derivatives in closed form:

    membrane  (r_1.r_1 - s^2)/2, (r_2.r_2 - s^2)/2, r_1.r_2
    bending   n.r_11 - free, n.r_22 - free, 2 n.r_12 - free

Stress S, conjugate to these, acts on r_1, r_2 with S_1 r_1 + S_3 r_2 + r_2 x p and
S_2 r_2 + S_3 r_1 + p x r_1, on the second derivatives with S_k n, where
p = (c - (c.n) n)/|m| and c = S_4 r_11 + S_5 r_22 + S_6 2 r_12.
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

FULL, REDUCED = 4, 2
"""Gauss points each way. Four make the bending of a bicubic plate exact, and leave a single
element without strain in rigid motion only; three would not. Most of the membrane stiffness is at
two: see ``mechanics.shell48``."""
BENT, POINTS = FULL**2, FULL**2 + REDUCED**2
"""Points where the shell resists bending too, and all points: the reduced ones come last."""
SIZES, TIME, SHARES, PLACE, WIDTH = 0, 2, 3, 6, 7
"""Columns of floats: a, b [m], damping time [s], parts of the membrane stiffness of strains 11, 22,
12 that all points share, then for each point weight [m^2], three numbers
that make the orthonormal directions from the parameters, three curvatures [1/m] of the reference.
"""
MEMBRANE, BENDING, POISSON, STRETCH, BEND, STRETCHING, TURNING, COLUMNS = range(8)
"""Groups of ``POINTS`` columns of coef: stiffness [N/m] and [N m], Poisson's ratio, thermal
stretch s [-], free bending k [1/m], and the rates of the last two."""
MORE = COLUMNS * POINTS
"""First of 6 ``POINTS`` columns of coef: further free strains of each point, which are zero but
where a stress is predicted (``mechanics.prediction``)."""


def _hermite(x):
    """(3, 4, n): values, first and second derivatives of the cubics of value and slope at 0, 1."""
    o = np.ones_like(x)
    values = [(1 - x) ** 2 * (1 + 2 * x), x * (1 - x) ** 2, x * x * (3 - 2 * x), x * x * (x - 1)]
    slopes = [6 * x * (x - 1), 1 - 4 * x + 3 * x * x, 6 * x * (1 - x), 3 * x * x - 2 * x]
    return np.array([values, slopes, [12 * x - 6, 6 * x - 4, 6 - 12 * x, 6 * x - 2 * o]])


def shapes(x, y, i, j):
    """(n, 16) derivatives, i by x and j by y, of the shapes of r, r_x, r_y, r_xy of four nodes."""
    X, Y = _hermite(x)[i], _hermite(y)[j]
    first, second = (0, 1, 0, 1), (0, 0, 1, 1)
    corners = ((0, 0), (2, 0), (2, 2), (0, 2))
    nodal = [X[a + f] * Y[b + s] for a, b in corners for f, s in zip(first, second, strict=True)]
    return np.stack(nodal, axis=-1)


def _points(order):
    """(3, order^2) x, y as fractions of the element, and weights, whose sum is 1."""
    x, w = np.polynomial.legendre.leggauss(order)
    X, Y = np.meshgrid(0.5 + 0.5 * x, 0.5 + 0.5 * x, indexing="ij")
    return np.stack([X.ravel(), Y.ravel(), 0.25 * np.outer(w, w).ravel()])


XI, ETA, WEIGHTS = np.hstack([_points(FULL), _points(REDUCED)])
"""(20,) each."""
TABLE = np.stack(
    [shapes(XI, ETA, i, j) for i, j in ((1, 0), (0, 1), (2, 0), (0, 2), (1, 1))], axis=1
)
"""(20, 5, 16) derivatives by x, y, xx, yy, xy of all shapes at all points."""


@njit(cache=True, error_model="numpy")
def _gather(y, ints, e, X):
    """The 16 nodal vectors (16, 3) of an element."""
    for c in range(4):
        for i in range(4):
            for k in range(3):
                X[4 * c + i, k] = y[ints[e, c] + 3 * i + k]


@njit(cache=True, error_model="numpy")
def _weigh(floats, e, g, N):
    """(5, 16) weights of the nodal vectors in the vectors of a point."""
    a, b, c = floats[e, SIZES], floats[e, SIZES + 1], PLACE + WIDTH * g
    T, U, V = floats[e, c + 1], floats[e, c + 2], floats[e, c + 3]
    for i in range(16):
        size = (a if i % 2 == 1 else 1.0) * (b if i % 4 > 1 else 1.0)
        xx, xy = size * TABLE[g, 2, i], size * TABLE[g, 4, i]
        N[0, i] = size * T * TABLE[g, 0, i]
        N[1, i] = size * (U * TABLE[g, 0, i] + V * TABLE[g, 1, i])
        N[2, i] = T * T * xx
        N[3, i] = U * U * xx + 2.0 * U * V * xy + size * V * V * TABLE[g, 3, i]
        N[4, i] = 2.0 * T * (U * xx + V * xy)


@njit(cache=True, error_model="numpy")
def _at_point(N, X, x):
    """The five vectors (5, 3) of a point."""
    for p in range(5):
        x[p, 0], x[p, 1], x[p, 2] = 0.0, 0.0, 0.0
        for i in range(16):
            for k in range(3):
                x[p, k] += N[p, i] * X[i, k]


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def _add_cross(a, b, factor, out):
    """out += factor a x b"""
    out[0] += factor * (a[1] * b[2] - a[2] * b[1])
    out[1] += factor * (a[2] * b[0] - a[0] * b[2])
    out[2] += factor * (a[0] * b[1] - a[1] * b[0])


@njit(cache=True, error_model="numpy")
def _normal(x, n):
    """Unit normal; returns |m|."""
    n[:] = 0.0
    _add_cross(x[0], x[1], 1.0, n)
    m = np.sqrt(_dot(n, n))
    for k in range(3):
        n[k] /= m
    return m


@njit(cache=True, error_model="numpy")
def _strains(x, n, E):
    """Strains (6,), free ones included."""
    E[0], E[1], E[2] = 0.5 * _dot(x[0], x[0]), 0.5 * _dot(x[1], x[1]), _dot(x[0], x[1])
    E[3], E[4], E[5] = _dot(n, x[2]), _dot(n, x[3]), _dot(n, x[4])


@njit(cache=True, error_model="numpy")
def _excess(coef, floats, e, g, x, n, E):
    """Elastic strains (6,)."""
    s, k = coef[e, STRETCH * POINTS + g], coef[e, BEND * POINTS + g]
    c = PLACE + WIDTH * g + 4
    _strains(x, n, E)
    E[0] -= 0.5 * s * s
    E[1] -= 0.5 * s * s
    E[3] -= s * floats[e, c] - k
    E[4] -= s * floats[e, c + 1] - k
    E[5] -= s * floats[e, c + 2]
    for r in range(6):
        E[r] -= coef[e, MORE + 6 * g + r]


@njit(cache=True, error_model="numpy")
def _free_rates(coef, floats, e, g, F):
    """Rates (6,) of the strains of the unstressed shell."""
    s, rate = coef[e, STRETCH * POINTS + g], coef[e, STRETCHING * POINTS + g]
    turn, c = coef[e, TURNING * POINTS + g], PLACE + WIDTH * g + 4
    F[0] = F[1] = s * rate
    F[2] = 0.0
    F[3] = rate * floats[e, c] - turn
    F[4] = rate * floats[e, c + 1] - turn
    F[5] = rate * floats[e, c + 2]


@njit(cache=True, error_model="numpy")
def _rates(x, v, n, m, w, R):
    """Rates (6,) of the strains; w becomes the rate of m."""
    w[:] = 0.0
    _add_cross(v[0], x[1], 1.0, w)
    _add_cross(x[0], v[1], 1.0, w)
    R[0], R[1] = _dot(x[0], v[0]), _dot(x[1], v[1])
    R[2] = _dot(x[0], v[1]) + _dot(x[1], v[0])
    for k in range(3):
        c = x[2 + k]
        R[3 + k] = _dot(n, v[2 + k]) + (_dot(c, w) - _dot(c, n) * _dot(n, w)) / m


@njit(cache=True, error_model="numpy")
def _elastic(coef, floats, e, g, E, S):
    """S (6,) = weight times stiffness times E, plane stress.

    Of the membrane the points that bend have a part (1 - nu) C diag(f1, f2, f12/2), the reduced
    ones what is left of C, which is positive for f <= 1.
    """
    weight, nu = floats[e, PLACE + WIDTH * g], coef[e, POISSON * POINTS + g]
    C, D = weight * coef[e, MEMBRANE * POINTS + g], weight * coef[e, BENDING * POINTS + g]
    part = (1.0 - nu) * C
    S[0], S[1] = part * floats[e, SHARES] * E[0], part * floats[e, SHARES + 1] * E[1]
    S[2] = 0.5 * part * floats[e, SHARES + 2] * E[2]
    if g >= BENT:
        S[0] = C * (E[0] + nu * E[1]) - S[0]
        S[1] = C * (E[1] + nu * E[0]) - S[1]
        S[2] = 0.5 * part * E[2] - S[2]
    S[3], S[4] = D * (E[3] + nu * E[4]), D * (E[4] + nu * E[3])
    S[5] = 0.5 * D * (1.0 - nu) * E[5]


@njit(cache=True, error_model="numpy")
def _stress(coef, floats, e, g, x, v, n, m, work, S):
    """Weighted stress (6,) with damping; work (4, 6)."""
    E, R, F, w = work[0], work[1], work[2], work[3, :3]
    tau = floats[e, TIME]
    _excess(coef, floats, e, g, x, n, E)
    if tau > 0.0:
        _rates(x, v, n, m, w, R)
        _free_rates(coef, floats, e, g, F)
        for r in range(6):
            E[r] += tau * (R[r] - F[r])
    _elastic(coef, floats, e, g, E, S)


@njit(cache=True, error_model="numpy")
def _moment(x, S, n, m, c, p):
    """c (3,) and p (3,) of the bending stresses; returns c.n."""
    for k in range(3):
        c[k] = S[3] * x[2, k] + S[4] * x[3, k] + S[5] * x[4, k]
    along = _dot(c, n)
    for k in range(3):
        p[k] = (c[k] - along * n[k]) / m
    return along


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Elastic and damping forces."""
    X, V, F, N = np.empty((16, 3)), np.empty((16, 3)), np.empty((16, 3)), np.empty((5, 16))
    x, xv, f, work = np.empty((5, 3)), np.zeros((5, 3)), np.empty((5, 3)), np.empty((4, 6))
    S, n, c, p = np.empty(6), np.empty(3), np.empty(3), np.empty(3)
    for e in range(ints.shape[0]):
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        F[:] = 0.0
        for g in range(POINTS):
            _weigh(floats, e, g, N)
            _at_point(N, X, x)
            if floats[e, TIME] > 0.0:
                _at_point(N, V, xv)
            m = _normal(x, n)
            _stress(coef, floats, e, g, x, xv, n, m, work, S)
            _moment(x, S, n, m, c, p)
            for k in range(3):
                f[0, k] = S[0] * x[0, k] + S[2] * x[1, k]
                f[1, k] = S[1] * x[1, k] + S[2] * x[0, k]
                f[2, k], f[3, k], f[4, k] = S[3] * n[k], S[4] * n[k], S[5] * n[k]
            _add_cross(x[1], p, 1.0, f[0])
            _add_cross(p, x[0], 1.0, f[1])
            for q in range(5):
                for i in range(16):
                    for k in range(3):
                        F[i, k] += N[q, i] * f[q, k]
        for i in range(16):
            for k in range(3):
                out[ints[e, i // 4] + 3 * (i % 4) + k] += F[i, k]


@kernel(ENERGY)
def energy(y, v, coef, ints, floats, out):
    """Elastic energy, power lost in damping, power done by it on changing free strains."""
    X, V, N = np.empty((16, 3)), np.empty((16, 3)), np.empty((5, 16))
    x, xv, n, w = np.empty((5, 3)), np.empty((5, 3)), np.empty(3), np.empty(3)
    E, R, F, S = np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    for e in range(ints.shape[0]):
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        for g in range(POINTS):
            _weigh(floats, e, g, N)
            _at_point(N, X, x)
            _at_point(N, V, xv)
            m = _normal(x, n)
            _excess(coef, floats, e, g, x, n, E)
            _elastic(coef, floats, e, g, E, S)
            for r in range(6):
                out[0] += 0.5 * S[r] * E[r]
            _rates(x, xv, n, m, w, R)
            _free_rates(coef, floats, e, g, F)
            for r in range(6):
                R[r] -= F[r]
            _elastic(coef, floats, e, g, R, S)
            for r in range(6):
                out[1] += floats[e, TIME] * S[r] * R[r]
                out[2] += floats[e, TIME] * S[r] * F[r]


@njit(cache=True, error_model="numpy")
def stresses(y, v, coef, ints, floats, out):
    """Membrane forces and moments (n_e, POINTS, 6) in the directions of each point."""
    X, V, N = np.empty((16, 3)), np.empty((16, 3)), np.empty((5, 16))
    x, xv, work, n = np.empty((5, 3)), np.empty((5, 3)), np.empty((4, 6)), np.empty(3)
    for e in range(ints.shape[0]):
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        for g in range(POINTS):
            _weigh(floats, e, g, N)
            _at_point(N, X, x)
            _at_point(N, V, xv)
            m = _normal(x, n)
            _stress(coef, floats, e, g, x, xv, n, m, work, out[e, g])
            for r in range(6):
                out[e, g, r] /= floats[e, PLACE + WIDTH * g]


@njit(cache=True, error_model="numpy")
def evaluate(y, v, ints, floats, strains, rates):
    """Strains, free ones included, and their rates (n_e, 6 POINTS)."""
    X, V, N = np.empty((16, 3)), np.empty((16, 3)), np.empty((5, 16))
    x, xv, n, w = np.empty((5, 3)), np.empty((5, 3)), np.empty(3), np.empty(3)
    for e in range(ints.shape[0]):
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        for g in range(POINTS):
            _weigh(floats, e, g, N)
            _at_point(N, X, x)
            _at_point(N, V, xv)
            m = _normal(x, n)
            _strains(x, n, strains[e, 6 * g : 6 * g + 6])
            _rates(x, xv, n, m, w, rates[e, 6 * g : 6 * g + 6])


@njit(cache=True, error_model="numpy")
def _gradients(x, n, m, p, B):
    """(6, 15) derivatives of the strains by the vectors of the point."""
    B[:] = 0.0
    for k in range(3):
        B[0, k], B[1, 3 + k], B[2, k], B[2, 3 + k] = x[0, k], x[1, k], x[1, k], x[0, k]
    for r in range(3, 6):
        c = x[r - 1]
        along = _dot(c, n)
        for k in range(3):
            p[k] = (c[k] - along * n[k]) / m
            B[r, 3 * (r - 1) + k] = n[k]
        _add_cross(x[1], p, 1.0, B[r, :3])
        _add_cross(p, x[0], 1.0, B[r, 3:6])


@njit(cache=True, error_model="numpy")
def _gradient_rates(x, v, n, m, w, p, dp, B):
    """(6, 15) rates of the same derivatives, which are those of the strain rates by x."""
    w[:] = 0.0
    _add_cross(v[0], x[1], 1.0, w)
    _add_cross(x[0], v[1], 1.0, w)
    nw = _dot(n, w)
    B[:] = 0.0
    for k in range(3):
        B[0, k], B[1, 3 + k], B[2, k], B[2, 3 + k] = v[0, k], v[1, k], v[1, k], v[0, k]
    for r in range(3, 6):
        c, cv = x[r - 1], v[r - 1]
        cn, vn, cw = _dot(c, n), _dot(cv, n), _dot(c, w)
        for k in range(3):
            turned = (3.0 * cn * nw - cw) * n[k] - cn * w[k] - nw * c[k]
            p[k] = (c[k] - cn * n[k]) / m
            dp[k] = (cv[k] - vn * n[k]) / m + turned / (m * m)
            B[r, 3 * (r - 1) + k] = (w[k] - nw * n[k]) / m
        _add_cross(v[1], p, 1.0, B[r, :3])
        _add_cross(x[1], dp, 1.0, B[r, :3])
        _add_cross(dp, x[0], 1.0, B[r, 3:6])
        _add_cross(p, v[0], 1.0, B[r, 3:6])


@njit(cache=True, error_model="numpy")
def _bend(x, S, n, m, c, p, J, f, G):
    """G (15, 15) = f times the second derivatives of the strains, weighted with S.

    J (6, 3) are the derivatives of m. With c fixed those of c.n are J Q J^T and the product of
    p with dr_1 x dr_2; Q = (3 c.n n n^T - c.n I - c n^T - n c^T)/|m|^2.
    """
    G[:] = 0.0
    J[:] = 0.0
    along = _moment(x, S, n, m, c, p)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        J[i, j], J[i, k], J[3 + i, j], J[3 + i, k] = -x[1, k], x[1, j], x[0, k], -x[0, j]
        G[i, i], G[3 + i, 3 + i] = f * S[0], f * S[1]
        G[i, 3 + i] = G[3 + i, i] = f * S[2]
        G[i, 3 + j] = G[3 + j, i] = f * p[k]
        G[j, 3 + i] = G[3 + i, j] = -f * p[k]
    for i in range(6):
        ni, ci = _dot(n, J[i]), _dot(c, J[i])
        for j in range(6):
            nj = _dot(n, J[j])
            both = along * (3.0 * ni * nj - _dot(J[i], J[j])) - ci * nj - ni * _dot(c, J[j])
            G[i, j] += f * both / (m * m)
        for r in range(3):
            for k in range(3):
                a = f * S[3 + r] * (J[i, k] - ni * n[k]) / m
                G[i, 6 + 3 * r + k] += a
                G[6 + 3 * r + k, i] += a


@njit(cache=True, error_model="numpy")
def _spread(N, G, first, H, K):
    """K (48, 48), component by component, += N^T G N; columns from ``first`` component on only."""
    for a in range(15):
        for k in range(3):
            for i in range(16):
                H[a, 16 * k + i] = (
                    N[0, i] * G[a, k] + N[1, i] * G[a, 3 + k] + N[2, i] * G[a, 6 + k]
                    + N[3, i] * G[a, 9 + k] + N[4, i] * G[a, 12 + k]
                )  # fmt: skip
    for k in range(3):
        A, B, C, D, E = H[k], H[3 + k], H[6 + k], H[9 + k], H[12 + k]
        for i in range(16):
            a, b, c, d, h = N[0, i], N[1, i], N[2, i], N[3, i], N[4, i]
            row = K[16 * k + i]
            for j in range(16 * k * first, 48):
                row[j] += a * A[j] + b * B[j] + c * C[j] + d * D[j] + h * E[j]


@kernel(TANGENT)
def tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Stiffness and damping of all elements."""
    X, V, N = np.empty((16, 3)), np.empty((16, 3)), np.empty((5, 16))
    x, xv, work, S = np.empty((5, 3)), np.zeros((5, 3)), np.empty((4, 6)), np.empty(6)
    n, c, p, J = np.empty(3), np.empty(3), np.empty(3), np.empty((6, 3))
    B, Bv, W, E = np.empty((6, 15)), np.zeros((6, 15)), np.empty((6, 15)), np.empty(6)
    G, H, K = np.empty((15, 15)), np.empty((15, 48)), np.empty((48, 48))
    for e in range(ints.shape[0]):
        tau = floats[e, TIME]
        damped = tau > 0.0
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        K[:] = 0.0
        for g in range(POINTS):
            _weigh(floats, e, g, N)
            _at_point(N, X, x)
            if damped:
                _at_point(N, V, xv)
            m = _normal(x, n)
            _stress(coef, floats, e, g, x, xv, n, m, work, S)
            _bend(x, S, n, m, c, p, J, cK, G)
            _gradients(x, n, m, p, B)
            if damped:
                _gradient_rates(x, xv, n, m, c, p, work[0, :3], Bv)
            for a in range(15):
                for r in range(6):
                    E[r] = (cK + tau * cC) * B[r, a]
                    if damped:
                        E[r] += cK * tau * Bv[r, a]
                _elastic(coef, floats, e, g, E, S)
                for r in range(6):
                    W[r, a] = S[r]
            for r in range(6):
                for a in range(15):
                    for b in range(15):
                        G[a, b] += B[r, a] * W[r, b]
            _spread(N, G, 0 if damped else 1, H, K)
        for i in range(48):
            for j in range(48):
                row, col = 16 * (i % 3) + i // 3, 16 * (j % 3) + j // 3
                upper = damped or i % 3 <= j % 3
                data[slots[e, 48 * i + j]] += K[row, col] if upper else K[col, row]
