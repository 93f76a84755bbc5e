"""Forces and tangents of a body whose strain at a point is the change of a metric.

At each of its points an element has three vectors u = (t, d2, d3), sums of its eight nodal
vectors with constant weights. What is strained is half their metric,

    g = (t.t/2, d2.d2/2, d3.d3/2, t.d2, t.d3, d2.d3),

less the free one: g0 times the squares and products of free stretches. The energy of a point is
half the excess times (m_1 P_1 + m_2 P_2) times the excess, with two moduli m that depend on
temperature and constant 6 x 6 matrices P. g is of second degree in the coordinates, so the
second derivatives are constant.

floats, by element: damping time [s], then POINT numbers for each point: weights (3, 8), g0 (6),
P_1 (6, 6) and P_2 (6, 6). coef, by element with k points: m_1 (k), m_2 (k), free squares (k, 3) of
axis, of section and of both, and their rates (k, 3). ints: first coordinates of both nodes.
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

POINT = 24 + 6 + 36 + 36
"""Numbers of a point in ``floats``."""
COEF = 8
"""Numbers of a point in ``coef``."""
FREE = np.array([0, 1, 1, 2, 2, 1], dtype=np.int64)
"""Which of the free squares belongs to each component of g."""
PAIR = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]], dtype=np.int64)
"""The two vectors in each component of g."""


@njit(cache=True, error_model="numpy")
def _gather(y, ints, x):
    """Nodal vectors (8, 3)."""
    for k in range(8):
        first = ints[k // 4] + 3 * (k % 4)
        for i in range(3):
            x[k, i] = y[first + i]


@njit(cache=True, error_model="numpy")
def _vectors(row, x, u):
    """The three vectors u (3, 3) at a point; ``row`` holds its constants."""
    for m in range(3):
        for i in range(3):
            total = 0.0
            for k in range(8):
                total += row[8 * m + k] * x[k, i]
            u[m, i] = total


@njit(cache=True, error_model="numpy")
def _excess(row, c, count, p, u, w, eps, rate, free):
    """Strains, their rates less the free ones, and the free rates at point p; w: rates of u."""
    for k in range(6):
        a, b = PAIR[k, 0], PAIR[k, 1]
        half = 0.5 if a == b else 1.0
        metric, changing = 0.0, 0.0
        for i in range(3):
            metric += half * u[a, i] * u[b, i]
            changing += half * (w[a, i] * u[b, i] + u[a, i] * w[b, i])
        at = 2 * count + 3 * p + FREE[k]
        free[k] = c[at + 3 * count] * row[24 + k]
        eps[k] = metric - c[at] * row[24 + k]
        rate[k] = changing - free[k]


@njit(cache=True, error_model="numpy")
def _stiffness(row, c, count, p, D):
    for k in range(36):
        D[k // 6, k % 6] = c[p] * row[30 + k] + c[count + p] * row[66 + k]


@njit(cache=True, error_model="numpy")
def _stress(D, eps, rate, tau, S):
    """Stresses as the symmetric matrix (3, 3) that multiplies the vectors u."""
    for k in range(6):
        total = 0.0
        for m in range(6):
            total += D[k, m] * (eps[m] + tau * rate[m])
        S[PAIR[k, 0], PAIR[k, 1]] = S[PAIR[k, 1], PAIR[k, 0]] = total


@njit(cache=True, error_model="numpy")
def _gradients(u, B):
    """Gradients (6, 9) of g with respect to u; linear in u."""
    B[:] = 0.0
    for k in range(6):
        a, b = PAIR[k, 0], PAIR[k, 1]
        for i in range(3):
            B[k, 3 * a + i] = u[b, i]
            B[k, 3 * b + i] = u[a, i]


@njit(cache=True, error_model="numpy")
def _quadratic(B, D, W, own, moving, K):
    """K = B^T D (own B + moving W)."""
    K[:] = 0.0
    for k in range(6):
        for j in range(9):
            turned = 0.0
            for m in range(6):
                turned += D[k, m] * (own * B[m, j] + moving * W[m, j])
            for i in range(9):
                K[i, j] += B[k, i] * turned


@njit(cache=True, error_model="numpy")
def _spread(row, K, slots, data):
    """Add the matrix (9, 9) of the vectors u of a point to that of the coordinates."""
    for m in range(3):
        for k in range(8):
            for o in range(3):
                for h in range(8):
                    weight = row[8 * m + k] * row[8 * o + h]
                    if weight != 0.0:
                        for i in range(3):
                            for j in range(3):
                                at = 24 * (3 * k + i) + 3 * h + j
                                data[slots[at]] += weight * K[3 * m + i, 3 * o + j]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    x, xv, S = np.empty((8, 3)), np.empty((8, 3)), np.empty((3, 3))
    u, w = np.empty((3, 3)), np.empty((3, 3))
    eps, rate, free, D = np.empty(6), np.empty(6), np.empty(6), np.empty((6, 6))
    count = coef.shape[1] // COEF
    for e in range(len(ints)):
        _gather(y, ints[e], x)
        _gather(v, ints[e], xv)
        for p in range(count):
            row = floats[e, 1 + POINT * p : 1 + POINT * (p + 1)]
            _vectors(row, x, u)
            _vectors(row, xv, w)
            _excess(row, coef[e], count, p, u, w, eps, rate, free)
            _stiffness(row, coef[e], count, p, D)
            _stress(D, eps, rate, floats[e, 0], S)
            for m in range(3):
                for i in range(3):
                    f = S[m, 0] * u[0, i] + S[m, 1] * u[1, i] + S[m, 2] * u[2, i]
                    for k in range(8):
                        out[ints[e, k // 4] + 3 * (k % 4) + i] += row[8 * m + k] * f


@kernel(ENERGY)
def add_energies(y, v, coef, ints, floats, out):
    x, xv, u, w = np.empty((8, 3)), np.empty((8, 3)), np.empty((3, 3)), np.empty((3, 3))
    eps, rate, free, D = np.empty(6), np.empty(6), np.empty(6), np.empty((6, 6))
    count = coef.shape[1] // COEF
    for e in range(len(ints)):
        _gather(y, ints[e], x)
        _gather(v, ints[e], xv)
        for p in range(count):
            row = floats[e, 1 + POINT * p : 1 + POINT * (p + 1)]
            _vectors(row, x, u)
            _vectors(row, xv, w)
            _excess(row, coef[e], count, p, u, w, eps, rate, free)
            _stiffness(row, coef[e], count, p, D)
            for k in range(6):
                for m in range(6):
                    out[0] += 0.5 * eps[k] * D[k, m] * eps[m]
                    out[1] += floats[e, 0] * rate[k] * D[k, m] * rate[m]
                    out[2] += floats[e, 0] * free[k] * D[k, m] * rate[m]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """By points: S (x) 1 and B^T D (B + tau dB/dt) for the stiffness, B^T D tau B for damping."""
    x, xv, S = np.empty((8, 3)), np.empty((8, 3)), np.empty((3, 3))
    u, w = np.empty((3, 3)), np.empty((3, 3))
    eps, rate, free, D = np.empty(6), np.empty(6), np.empty(6), np.empty((6, 6))
    B, W, K = np.empty((6, 9)), np.empty((6, 9)), np.empty((9, 9))
    count = coef.shape[1] // COEF
    for e in range(len(ints)):
        tau = floats[e, 0]
        _gather(y, ints[e], x)
        _gather(v, ints[e], xv)
        for p in range(count):
            row = floats[e, 1 + POINT * p : 1 + POINT * (p + 1)]
            _vectors(row, x, u)
            _vectors(row, xv, w)
            _excess(row, coef[e], count, p, u, w, eps, rate, free)
            _stiffness(row, coef[e], count, p, D)
            _stress(D, eps, rate, tau, S)
            _gradients(w, W)
            _gradients(u, B)
            _quadratic(B, D, W, cK + cC * tau, cK * tau, K)
            for m in range(3):
                for o in range(3):
                    for i in range(3):
                        K[3 * m + i, 3 * o + i] += cK * S[m, o]
            _spread(row, K, slots[e], data)
