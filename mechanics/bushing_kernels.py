"""Compiled kernels of ``mechanics.bushing``.

Each strain is 1/2 Z.(Q Z) with constant Q (8, 8) of the vectors Z = (r, g/|g|^1/2, p, s) of the
first and of the second end (g = p x s); Z of the ground is constant.

ints : first coordinate of W vectors of each end (-1 where absent)
floats : stiffness (6,), damping (6,), Q (6, 8, 8), constant Z (8, 3), weights of each of the 2 W
    vectors in r, p, s (2 W, 3)
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

_FORM, _CONSTANT, _WEIGHTS = 12, 12 + 384, 12 + 384 + 24


@njit(cache=True, error_model="numpy")
def _sum(y, ints, floats, x):
    """r, p, s of both ends, (2, 3, 3)."""
    x[:] = 0.0
    width = ints.size // 2
    for j in range(ints.size):
        if ints[j] >= 0:
            for m in range(3):
                weight = floats[_WEIGHTS + 3 * j + m]
                for i in range(3):
                    x[j // width, m, i] += weight * y[ints[j] + i]


@njit(cache=True, error_model="numpy")
def _normal(d, g, G):
    """g = p x s of d = (p, s) (2, 3) and its derivative G (3, 6); returns |g|."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        g[i] = d[0, j] * d[1, k] - d[0, k] * d[1, j]
        G[i, i], G[i, 3 + i] = 0.0, 0.0
        G[i, j], G[i, k] = d[1, k], -d[1, j]
        G[i, 3 + k], G[i, 3 + j] = d[0, j], -d[0, k]
    return np.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])


@njit(cache=True, error_model="numpy")
def _extend(x, u, floats, ints, Z, U, R):
    """Z and its rate U (8, 3); R (2, 3, 6): derivative of g/|g|^1/2 by p, s of each end."""
    g, G = np.empty(3), np.empty((3, 6))
    for end in range(2):
        first = 4 * end
        if ints[ints.size // 2 * end] < 0:
            for m in range(4):
                for i in range(3):
                    Z[first + m, i] = floats[_CONSTANT + 3 * (first + m) + i]
                    U[first + m, i] = 0.0
            continue
        s = _normal(x[end, 1:], g, G)
        for i in range(3):
            Z[first, i], U[first, i] = x[end, 0, i], u[end, 0, i]
            Z[first + 2, i], U[first + 2, i] = x[end, 1, i], u[end, 1, i]
            Z[first + 3, i], U[first + 3, i] = x[end, 2, i], u[end, 2, i]
            Z[first + 1, i], U[first + 1, i] = g[i] / np.sqrt(s), 0.0
        for j in range(6):
            along = 0.5 * (g[0] * G[0, j] + g[1] * G[1, j] + g[2] * G[2, j]) / (s * s)
            for i in range(3):
                R[end, i, j] = (G[i, j] - along * g[i]) / np.sqrt(s)
                U[first + 1, i] += R[end, i, j] * u[end, 1 + j // 3, j % 3]


@njit(cache=True, error_model="numpy")
def _strain(k, floats, Z, U, h):
    """Strain k and its rate; h = Q Z (8, 3)."""
    value, rate = 0.0, 0.0
    for a in range(8):
        for i in range(3):
            h[a, i] = 0.0
            for b in range(8):
                h[a, i] += floats[_FORM + 64 * k + 8 * a + b] * Z[b, i]
            value += 0.5 * h[a, i] * Z[a, i]
            rate += h[a, i] * U[a, i]
    return value, rate


@njit(cache=True, error_model="numpy")
def _reduce(h, R, f):
    """f (18,): what h by Z (8, 3) is by r, p, s of both ends."""
    for end in range(2):
        for i in range(3):
            f[9 * end + i] = h[4 * end, i]
            f[9 * end + 3 + i] = h[4 * end + 2, i]
            f[9 * end + 6 + i] = h[4 * end + 3, i]
        for j in range(6):
            for i in range(3):
                f[9 * end + 3 + j] += R[end, i, j] * h[4 * end + 1, i]


@njit(cache=True, error_model="numpy")
def _bend(d, p, H):
    """H (6, 6): second derivative of p.g/|g|^1/2 by d = (p, s) (2, 3)."""
    g, G, t, M = np.empty(3), np.empty((3, 6)), np.empty(3), np.empty((3, 3))
    s = _normal(d, g, G)
    along = (p[0] * g[0] + p[1] * g[1] + p[2] * g[2]) / (s * s)
    for i in range(3):
        t[i] = (p[i] - 0.5 * along * g[i]) / np.sqrt(s)
        for j in range(3):
            mixed = 2.5 * along * g[i] * g[j] / (s * s) - (p[i] * g[j] + g[i] * p[j]) / (s * s)
            M[i, j] = 0.5 * (mixed - along * (1.0 if i == j else 0.0)) / np.sqrt(s)
    for a in range(6):
        for b in range(6):
            H[a, b] = 0.0
            for i in range(3):
                for j in range(3):
                    H[a, b] += G[i, a] * M[i, j] * G[j, b]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        H[j, 3 + k] += t[i]
        H[3 + k, j] += t[i]
        H[k, 3 + j] -= t[i]
        H[3 + j, k] -= t[i]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    x, u, R = np.empty((2, 3, 3)), np.empty((2, 3, 3)), np.zeros((2, 3, 6))
    Z, U, h, f = np.empty((8, 3)), np.empty((8, 3)), np.empty((8, 3)), np.empty(18)
    width = ints.shape[1] // 2
    for e in range(ints.shape[0]):
        _sum(y, ints[e], floats[e], x)
        _sum(v, ints[e], floats[e], u)
        _extend(x, u, floats[e], ints[e], Z, U, R)
        for k in range(6):
            value, rate = _strain(k, floats[e], Z, U, h)
            stress = floats[e, k] * value + floats[e, 6 + k] * rate
            _reduce(h, R, f)
            for j in range(2 * width):
                if ints[e, j] < 0:
                    continue
                for m in range(3):
                    weight = stress * floats[e, _WEIGHTS + 3 * j + m]
                    for i in range(3):
                        out[ints[e, j] + i] += weight * f[9 * (j // width) + 3 * m + i]


@njit(cache=True, error_model="numpy")
def _product(R, end, a, m, other, b, n):
    """Product of two columns: unit vectors, or (m, n) derivatives of g/|g|^1/2."""
    if m and n:
        found = 0.0
        for i in range(3):
            found += R[end, i, a - 3] * R[other, i, b - 3]
        return found
    if m:
        return R[end, b % 3, a - 3]
    if n:
        return R[other, a % 3, b - 3]
    return 1.0 if a % 3 == b % 3 else 0.0


@njit(cache=True, error_model="numpy")
def _curve(k, floats, R, x, ints, h, B, H):
    """B (18, 18) += second derivative of strain k."""
    for a in range(18):
        for b in range(18):
            end, other = a // 9, b // 9
            for m in range(1 if a % 9 < 3 else 2):
                for n in range(1 if b % 9 < 3 else 2):
                    row = 4 * end + (0 if a % 9 < 3 else 1 if m else 1 + a % 9 // 3)
                    column = 4 * other + (0 if b % 9 < 3 else 1 if n else 1 + b % 9 // 3)
                    Q = floats[_FORM + 64 * k + 8 * row + column]
                    if Q != 0.0:
                        B[a, b] += Q * _product(R, end, a % 9, m, other, b % 9, n)
    for end in range(2):
        if ints[ints.size // 2 * end] >= 0:
            _bend(x[end, 1:], h[4 * end + 1], H)
            for a in range(6):
                for b in range(6):
                    B[9 * end + 3 + a, 9 * end + 3 + b] += H[a, b]


@njit(cache=True, error_model="numpy")
def _scatter(B, width, ints, floats, slots, data):
    """Add the block of r, p, s of both ends to those of their vectors."""
    for a in range(2 * width):
        for b in range(2 * width):
            if ints[a] < 0 or ints[b] < 0:
                continue
            for m in range(3):
                for n in range(3):
                    weight = floats[_WEIGHTS + 3 * a + m] * floats[_WEIGHTS + 3 * b + n]
                    row, column = 9 * (a // width) + 3 * m, 9 * (b // width) + 3 * n
                    for i in range(3):
                        for j in range(3):
                            place = slots[6 * width * (3 * a + i) + 3 * b + j]
                            data[place] += weight * B[row + i, column + j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    x, u, R = np.empty((2, 3, 3)), np.empty((2, 3, 3)), np.zeros((2, 3, 6))
    Z, U, h, f = np.empty((8, 3)), np.empty((8, 3)), np.empty((8, 3)), np.empty(18)
    B, C, H, slope = np.empty((18, 18)), np.empty((18, 18)), np.empty((6, 6)), np.empty(18)
    width = ints.shape[1] // 2
    for e in range(ints.shape[0]):
        _sum(y, ints[e], floats[e], x)
        _sum(v, ints[e], floats[e], u)
        _extend(x, u, floats[e], ints[e], Z, U, R)
        B[:] = 0.0
        for k in range(6):
            value, rate = _strain(k, floats[e], Z, U, h)
            _reduce(h, R, f)
            C[:] = 0.0
            _curve(k, floats[e], R, x, ints[e], h, C, H)
            stiffness, damping = floats[e, k], floats[e, 6 + k]
            stress = stiffness * value + damping * rate
            for b in range(18):
                slope[b] = (cK * stiffness + cC * damping) * f[b]
                for a in range(18):
                    slope[b] += cK * damping * C[b, a] * u[a // 9, a % 9 // 3, a % 3]
            for a in range(18):
                for b in range(18):
                    B[a, b] += f[a] * slope[b] + cK * stress * C[a, b]
        _scatter(B, width, ints[e], floats[e], slots[e], data)


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    x, u, R = np.empty((2, 3, 3)), np.empty((2, 3, 3)), np.zeros((2, 3, 6))
    Z, U, h = np.empty((8, 3)), np.empty((8, 3)), np.empty((8, 3))
    for e in range(ints.shape[0]):
        _sum(y, ints[e], floats[e], x)
        _sum(v, ints[e], floats[e], u)
        _extend(x, u, floats[e], ints[e], Z, U, R)
        for k in range(6):
            value, rate = _strain(k, floats[e], Z, U, h)
            out[0] += 0.5 * floats[e, k] * value * value
            out[1] += floats[e, 6 + k] * rate * rate
