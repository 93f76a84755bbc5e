"""Forces and tangents of solid elements, total Lagrangian.

At each point F is the sum of x_a (x) dN_a over the nodes and e = F^T F/2 - e_0; of a free stretch s
e_0 is s^2/2 times the identity. The stress is S = D (e + tau de/dt), D of Hooke with two moduli,
the force on a node F S dN_a times the volume of the point, and the tangent of two nodes, with the
gradients B of e and C of its rate,

    B_a^T D ((cK + tau cC) B_b + tau cK C_b) + cK (dN_a . S dN_b) 1.

floats, by element with k nodes and p points: damping time [s], then for each point its volume
[m^3] and the gradients (k, 3) [1/m]. coef, by element: lambda (p), mu (p) [Pa], rates of s^2/2 (p)
[1/s], e_0 (p, 6) with components 11, 22, 33, 23, 13, 12. ints: first coordinates of the nodes.
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

COEF = 9
"""Numbers of a point in ``coef``."""
PLACE = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]], dtype=np.int64)
"""Number of each component of a strain."""


@njit(cache=True, error_model="numpy")
def _gather(y, ints, x):
    for a in range(len(ints)):
        for i in range(3):
            x[a, i] = y[ints[a] + i]


@njit(cache=True, error_model="numpy")
def _gradient(row, x, F):
    """F (3, 3) at a point; ``row`` holds its volume and the gradients."""
    F[:] = 0.0
    for a in range(len(x)):
        for i in range(3):
            for j in range(3):
                F[i, j] += x[a, i] * row[1 + 3 * a + j]


@njit(cache=True, error_model="numpy")
def _strain(F, W, c, count, p, e, d):
    """Strain less the free one, and its rate less the free one; W: rates of F."""
    for i in range(3):
        for j in range(3):
            metric, change = 0.0, 0.0
            for k in range(3):
                metric += F[k, i] * F[k, j]
                change += F[k, i] * W[k, j] + W[k, i] * F[k, j]
            e[i, j] = 0.5 * metric - c[3 * count + 6 * p + PLACE[i, j]]
            d[i, j] = 0.5 * change
        d[i, i] -= c[2 * count + p]


@njit(cache=True, error_model="numpy")
def _stress(lame, mu, e, d, tau, S):
    trace = 0.0
    for i in range(3):
        trace += e[i, i] + tau * d[i, i]
    for i in range(3):
        for j in range(3):
            S[i, j] = 2.0 * mu * (e[i, j] + tau * d[i, j])
        S[i, i] += lame * trace


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    count, k = coef.shape[1] // COEF, ints.shape[1]
    x, xv = np.empty((k, 3)), np.empty((k, 3))
    F, W, e, d = np.empty((3, 3)), np.zeros((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    S, P, width = np.empty((3, 3)), np.empty((3, 3)), 1 + 3 * k
    for c in range(len(ints)):
        tau = floats[c, 0]
        _gather(y, ints[c], x)
        _gather(v, ints[c], xv)
        for p in range(count):
            row = floats[c, 1 + width * p : 1 + width * (p + 1)]
            _gradient(row, x, F)
            if tau > 0.0:
                _gradient(row, xv, W)
            _strain(F, W, coef[c], count, p, e, d)
            _stress(coef[c, p], coef[c, count + p], e, d, tau, S)
            for i in range(3):
                for j in range(3):
                    P[i, j] = row[0] * (F[i, 0] * S[0, j] + F[i, 1] * S[1, j] + F[i, 2] * S[2, j])
            for a in range(k):
                at, g = ints[c, a], 1 + 3 * a
                for i in range(3):
                    out[at + i] += P[i, 0] * row[g] + P[i, 1] * row[g + 1] + P[i, 2] * row[g + 2]


@kernel(ENERGY)
def add_energies(y, v, coef, ints, floats, out):
    count, k = coef.shape[1] // COEF, ints.shape[1]
    x, xv = np.empty((k, 3)), np.empty((k, 3))
    F, W, e, d = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    S, width = np.empty((3, 3)), 1 + 3 * k
    for c in range(len(ints)):
        tau = floats[c, 0]
        _gather(y, ints[c], x)
        _gather(v, ints[c], xv)
        for p in range(count):
            row = floats[c, 1 + width * p : 1 + width * (p + 1)]
            free = coef[c, 2 * count + p]
            _gradient(row, x, F)
            _gradient(row, xv, W)
            _strain(F, W, coef[c], count, p, e, d)
            _stress(coef[c, p], coef[c, count + p], e, e, 0.0, S)
            for i in range(3):
                for j in range(3):
                    out[0] += 0.5 * row[0] * S[i, j] * e[i, j]
            if tau > 0.0:
                _stress(coef[c, p], coef[c, count + p], d, d, 0.0, S)
                for i in range(3):
                    for j in range(3):
                        out[1] += tau * row[0] * S[i, j] * d[i, j]
                    out[2] += tau * row[0] * S[i, i] * free


@njit(cache=True, error_model="numpy")
def _rows(row, F, B):
    """Gradients (6, 3 k) of the strains 11, 22, 33, 2 x 23, 2 x 13, 2 x 12."""
    for a in range(B.shape[1] // 3):
        x, y, z = row[1 + 3 * a], row[2 + 3 * a], row[3 + 3 * a]
        for i in range(3):
            B[0, 3 * a + i] = F[i, 0] * x
            B[1, 3 * a + i] = F[i, 1] * y
            B[2, 3 * a + i] = F[i, 2] * z
            B[3, 3 * a + i] = F[i, 1] * z + F[i, 2] * y
            B[4, 3 * a + i] = F[i, 0] * z + F[i, 2] * x
            B[5, 3 * a + i] = F[i, 0] * y + F[i, 1] * x


@njit(cache=True, error_model="numpy")
def _add_products(B, C, lame, mu, half, K):
    """K += B^T D C; where ``half``, only on and above the diagonal."""
    n = B.shape[1]
    for i in range(n):
        trace = lame * (B[0, i] + B[1, i] + B[2, i])
        p, q, r = trace + 2.0 * mu * B[0, i], trace + 2.0 * mu * B[1, i], trace + 2.0 * mu * B[2, i]
        s, t, u = mu * B[3, i], mu * B[4, i], mu * B[5, i]
        start = i if half else 0
        out, a, b, c = K[i, start:], C[0, start:], C[1, start:], C[2, start:]
        f, g, h = C[3, start:], C[4, start:], C[5, start:]
        for j in range(n - start):
            out[j] += p * a[j] + q * b[j] + r * c[j] + s * f[j] + t * g[j] + u * h[j]


@njit(cache=True, error_model="numpy")
def _add_geometric(row, S, factor, K):
    """On and above the diagonal."""
    k = K.shape[0] // 3
    for a in range(k):
        x, y, z = row[1 + 3 * a], row[2 + 3 * a], row[3 + 3 * a]
        p = factor * (S[0, 0] * x + S[0, 1] * y + S[0, 2] * z)
        q = factor * (S[1, 0] * x + S[1, 1] * y + S[1, 2] * z)
        r = factor * (S[2, 0] * x + S[2, 1] * y + S[2, 2] * z)
        for b in range(a, k):
            part = p * row[1 + 3 * b] + q * row[2 + 3 * b] + r * row[3 + 3 * b]
            for i in range(3):
                K[3 * a + i, 3 * b + i] += part


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    count, k = coef.shape[1] // COEF, ints.shape[1]
    n, width = 3 * k, 1 + 3 * k
    x, xv = np.empty((k, 3)), np.empty((k, 3))
    F, W, e, d = np.empty((3, 3)), np.zeros((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    S = np.empty((3, 3))
    B, C, K, U = np.empty((6, n)), np.empty((6, n)), np.empty((n, n)), np.empty((n, n))
    for c in range(len(ints)):
        tau = floats[c, 0]
        _gather(y, ints[c], x)
        _gather(v, ints[c], xv)
        K[:] = 0.0
        U[:] = 0.0
        for p in range(count):
            row = floats[c, 1 + width * p : 1 + width * (p + 1)]
            lame, mu = row[0] * coef[c, p], row[0] * coef[c, count + p]
            _gradient(row, x, F)
            if tau > 0.0:
                _gradient(row, xv, W)
            _strain(F, W, coef[c], count, p, e, d)
            _stress(lame, mu, e, d, tau, S)
            _rows(row, F, B)
            own = cK + cC * tau
            _add_products(B, B, own * lame, own * mu, True, U)
            _add_geometric(row, S, cK, U)
            if tau > 0.0 and cK != 0.0:
                _rows(row, W, C)
                _add_products(B, C, cK * tau * lame, cK * tau * mu, False, K)
        for i in range(n):
            for j in range(n):
                data[slots[c, n * i + j]] += K[i, j] + (U[i, j] if i <= j else U[j, i])
