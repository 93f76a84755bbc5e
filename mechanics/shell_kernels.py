"""Force, tangent and energy of elements whose strains are sums of products of nodal vectors.

An element has k vectors, the first of each of its four nodes a position. The positions relative to
the first one and all other vectors are X (k - 1, 3); its products g are, pair by pair a <= b,
X_a.X_b, and half of that where a = b. With linear elasticity in Green's strains, all that is left
of quadrature, assumed and enhanced strains is one symmetric matrix H of

    z = (g - g_ref, -f),    energy = z.H z/2,    stress conjugate to z: H (z + tau dz/dt)

where f are the free strains. Rows: ``ints`` first coordinates of the vectors; ``floats`` the
damping time tau; ``coef`` the upper triangle of H, f, df/dt, g_ref and what kernels do not read.
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

FREE = 8
"""Number of free strains of an element."""


@njit(cache=True, error_model="numpy")
def _pair(a, b, n):
    """Place of the product of vectors a and b among all products."""
    low, high = min(a, b), max(a, b)
    return low * n - low * (low - 1) // 2 + high - low


@njit(cache=True, error_model="numpy")
def _gather(y, ints, e, X):
    """All vectors but the first position, positions relative to that."""
    k = ints.shape[1]
    for a in range(1, k):
        for i in range(3):
            X[a - 1, i] = y[ints[e, a] + i]
            if a % (k // 4) == 0:
                X[a - 1, i] -= y[ints[e, 0] + i]


@njit(cache=True, error_model="numpy")
def _strains(X, V, coef, e, one, tau, z):
    """``one`` z + ``tau`` dz/dt."""
    n = X.shape[0]
    pairs = n * (n + 1) // 2
    free = (pairs + FREE) * (pairs + FREE + 1) // 2
    i = 0
    for a in range(n):
        for b in range(a, n):
            g, rate = 0.0, 0.0
            for x in range(3):
                g += X[a, x] * X[b, x]
                rate += X[a, x] * V[b, x] + V[a, x] * X[b, x]
            if a == b:
                g, rate = 0.5 * g, 0.5 * rate
            z[i] = one * (g - coef[e, free + 2 * FREE + i]) + tau * rate
            i += 1
    for j in range(FREE):
        z[pairs + j] = -one * coef[e, free + j] - tau * coef[e, free + FREE + j]


@njit(cache=True, error_model="numpy")
def _multiply(coef, e, z, p):
    """p = H z."""
    p[:] = 0.0
    first = 0
    for i in range(z.size):
        row = coef[e, first : first + z.size - i]
        s = row[0] * z[i]
        for j in range(1, z.size - i):
            s += row[j] * z[i + j]
        for j in range(1, z.size - i):
            p[i + j] += row[j] * z[i]
        p[i] += s
        first += z.size - i


@njit(cache=True, error_model="numpy")
def _unpack(coef, e, H):
    """The part of H that belongs to the products, full."""
    n, first = H.shape[0], 0
    for i in range(n):
        for j in range(i, n):
            H[i, j] = H[j, i] = coef[e, first + j - i]
        first += n + FREE - i


@njit(cache=True, error_model="numpy")
def _push(ints, e, a, factor, x, out):
    """Add the force ``factor`` x on vector a, and the reaction where it is a relative position."""
    k = ints.shape[1]
    for i in range(3):
        out[ints[e, a + 1] + i] += factor * x[i]
        if (a + 1) % (k // 4) == 0:
            out[ints[e, 0] + i] -= factor * x[i]


@njit(cache=True, error_model="numpy")
def _column(X, w, K):
    """K_a = sum_b w_ab X_b."""
    n, m = X.shape[0], 0
    K[:] = 0.0
    for a in range(n):
        for b in range(a, n):
            for i in range(3):
                K[a, i] += w[m] * X[b, i]
                if b > a:
                    K[b, i] += w[m] * X[a, i]
            m += 1


@njit(cache=True, error_model="numpy")
def _place(K, c, j, k, slots, data):
    """Add the column of component j of vector c, and those of the first position."""
    relative = (c + 1) % (k // 4) == 0
    column = 3 * (c + 1) + j
    for a in range(k - 1):
        for i in range(3):
            row = 3 * k * (3 * (a + 1) + i)
            data[slots[row + column]] += K[a, i]
            if relative:
                data[slots[row + j]] -= K[a, i]
            if (a + 1) % (k // 4) == 0:
                data[slots[3 * k * i + column]] -= K[a, i]
                if relative:
                    data[slots[3 * k * i + j]] += K[a, i]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    k = ints.shape[1]
    pairs = k * (k - 1) // 2
    X, V = np.empty((k - 1, 3)), np.empty((k - 1, 3))
    z, p = np.empty(pairs + FREE), np.empty(pairs + FREE)
    for e in range(ints.shape[0]):
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        _strains(X, V, coef, e, 1.0, floats[e, 0], z)
        _multiply(coef, e, z, p)
        i = 0
        for a in range(k - 1):
            for b in range(a, k - 1):
                _push(ints, e, a, p[i], X[b], out)
                if b > a:
                    _push(ints, e, b, p[i], X[a], out)
                i += 1


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """With f_a = sum_b p_ab X_b and p = H (z + tau dz/dt):
    df_a/dX_c = p_ac 1 + sum_bd X_b H_ab,cd (X_d + tau V_d)^T, df_a/dV_c likewise with tau X_d.
    """
    k = ints.shape[1]
    n, pairs = k - 1, k * (k - 1) // 2
    X, V, Y = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    z, p = np.empty(pairs + FREE), np.empty(pairs + FREE)
    H, W, K = np.empty((pairs, pairs)), np.empty((3, pairs)), np.empty((n, 3))
    for e in range(ints.shape[0]):
        tau = floats[e, 0]
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        _strains(X, V, coef, e, 1.0, tau, z)
        _multiply(coef, e, z, p)
        _unpack(coef, e, H)
        for d in range(n):
            for j in range(3):
                Y[d, j] = cK * (X[d, j] + tau * V[d, j]) + cC * tau * X[d, j]
        for c in range(n):
            W[:] = 0.0
            for d in range(n):
                row = H[_pair(c, d, n)]
                for j in range(3):
                    for i in range(pairs):
                        W[j, i] += Y[d, j] * row[i]
            for j in range(3):
                _column(X, W[j], K)
                for a in range(n):
                    K[a, j] += cK * p[_pair(a, c, n)]
                _place(K, c, j, k, slots[e], data)


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    k = ints.shape[1]
    pairs = k * (k - 1) // 2
    X, V = np.empty((k - 1, 3)), np.empty((k - 1, 3))
    z, p = np.empty(pairs + FREE), np.empty(pairs + FREE)
    for e in range(ints.shape[0]):
        _gather(y, ints, e, X)
        _gather(v, ints, e, V)
        _strains(X, V, coef, e, 1.0, 0.0, z)
        _multiply(coef, e, z, p)
        for i in range(z.size):
            out[0] += 0.5 * z[i] * p[i]
        _strains(X, V, coef, e, 0.0, 1.0, z)
        _multiply(coef, e, z, p)
        for i in range(z.size):
            out[1] += floats[e, 0] * z[i] * p[i]
            if i >= pairs:
                out[2] -= floats[e, 0] * z[i] * p[i]
