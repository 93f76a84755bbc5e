"""Compiled kernels of ``mechanics.moments``; the theory is told there."""

import numpy as np
from numba import njit

from mechanics.kernels import FORCE, TANGENT, kernel


@njit(cache=True, error_model="numpy")
def _section(y, at, weights, d):
    """p and s of one end, as the six components of ``d``."""
    d[:] = 0.0
    for j in range(at.size):
        if at[j] >= 0:
            for i in range(3):
                d[i] += weights[2 * j] * y[at[j] + i]
                d[3 + i] += weights[2 * j + 1] * y[at[j] + i]


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def _cross(a, b, c):
    """c = a x b."""
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy")
def _turning(d, K):
    """K = J^-1, J = sum_k |d_k|^2 I - d_k d_k^T."""
    p, s = d[:3], d[3:]
    pp, ss = _dot(p, p), _dot(s, s)
    g = np.empty(3)
    _cross(p, s, g)
    gg = _dot(g, g)
    # along g = p x s: the value pp + ss; across g: S = p p^T + s s^T with trace pp + ss and
    # determinant gg, so that tr(S) I - S is its adjoint and S/gg the inverse of that
    for i in range(3):
        for j in range(3):
            K[i, j] = (p[i] * p[j] + s[i] * s[j] + g[i] * g[j] / (pp + ss)) / gg


@njit(cache=True, error_model="numpy")
def _direction(d, c, size, m, D):
    """m = size u/|u|, u = c1 g/|g|^1/2 + c2 p + c3 s, and its derivative D (3, 6)."""
    g, G = np.empty(3), np.zeros((3, 6))
    _cross(d[:3], d[3:], g)
    length = np.sqrt(_dot(g, g))
    f = c[0] / np.sqrt(length)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        G[i, j], G[i, k] = d[3 + k], -d[3 + j]
        G[i, 3 + k], G[i, 3 + j] = d[j], -d[k]
        m[i] = f * g[i] + c[1] * d[i] + c[2] * d[3 + i]
    for j in range(6):
        along = 0.5 * (g[0] * G[0, j] + g[1] * G[1, j] + g[2] * G[2, j]) / length**2
        for i in range(3):
            D[i, j] = f * (G[i, j] - along * g[i])
    for i in range(3):
        D[i, i] += c[1]
        D[i, 3 + i] += c[2]
    f = size / np.sqrt(_dot(m, m))
    for j in range(6):
        along = (m[0] * D[0, j] + m[1] * D[1, j] + m[2] * D[2, j]) / _dot(m, m)
        for i in range(3):
            D[i, j] = f * (D[i, j] - along * m[i])
    for i in range(3):
        m[i] *= f


@njit(cache=True, error_model="numpy")
def _moment(y, ints, floats, amplitude, d, m, D):
    """Sections d (2, 6) of both ends; moment m (3,) and its derivative D (3, 6) by the second."""
    n = ints.size // 2
    for end in range(2):
        at = ints[n * end : n * end + n]
        _section(y, at, floats[6 + 2 * n * end : 6 + 2 * n * end + 2 * n], d[end])
    D[:] = 0.0
    if ints[n] >= 0:
        _direction(d[1], floats[:3], floats[3], m, D)
    else:
        m[:] = floats[3:6]
    for i in range(3):
        m[i] *= amplitude
        for j in range(6):
            D[i, j] *= amplitude


@kernel(FORCE)
def add_moment(y, v, coef, ints, floats, out):
    """Moment on the first end, its reaction on the second; each may be absent."""
    n = ints.shape[1] // 2
    d, m, w, f = np.empty((2, 6)), np.empty(3), np.empty(3), np.empty(6)
    D, K = np.empty((3, 6)), np.empty((3, 3))
    for e in range(ints.shape[0]):
        _moment(y, ints[e], floats[e], coef[e, 0], d, m, D)
        for end in range(2):
            if ints[e, n * end] < 0:
                continue
            _turning(d[end], K)
            for i in range(3):
                w[i] = (1 - 2 * end) * (K[i, 0] * m[0] + K[i, 1] * m[1] + K[i, 2] * m[2])
            _cross(w, d[end, :3], f[:3])
            _cross(w, d[end, 3:], f[3:])
            for j in range(n):
                at, weight = ints[e, n * end + j], 6 + 2 * (n * end + j)
                if at >= 0:
                    for i in range(3):
                        p, s = floats[e, weight] * f[i], floats[e, weight + 1] * f[3 + i]
                        out[at + i] -= p + s


@njit(cache=True, error_model="numpy")
def _bend(d, m, D, sign, both, K, B):
    """B (6, 12): derivative of the forces on the section d by d and by that of the second end.

    df_k = [w] dd_k - [d_k] dw, J dw = sign dm - sum_l G_l dd_l, G_l = 2 w d_l^T - (d_l.w) I -
    d_l w^T, where [a] b = a x b. ``both``: where the section of the second end begins in B.
    """
    w, dw, f = np.empty(3), np.empty(3), np.empty(3)
    right = np.zeros((3, 12))
    for i in range(3):
        w[i] = sign * (K[i, 0] * m[0] + K[i, 1] * m[1] + K[i, 2] * m[2])
    for k in range(0, 6, 3):
        along = _dot(d[k : k + 3], w)
        for i in range(3):
            right[i, k + i] += along
            for j in range(3):
                right[i, k + j] += d[k + i] * w[j] - 2.0 * w[i] * d[k + j]
    for i in range(3):
        for j in range(6):
            right[i, both + j] += sign * D[i, j]
    for j in range(12):
        for i in range(3):
            dw[i] = K[i, 0] * right[0, j] + K[i, 1] * right[1, j] + K[i, 2] * right[2, j]
        for k in range(0, 6, 3):
            _cross(dw, d[k : k + 3], f)
            B[k : k + 3, j] = f
    for k in range(0, 6, 3):
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            B[k + a, k + i] += w[b]
            B[k + b, k + i] -= w[a]


@njit(cache=True, error_model="numpy")
def _scatter(factor, B, column, a, b, floats, slots, k, data):
    """Add the block of vectors a and b with their weights in p and s."""
    for i in range(3):
        for j in range(3):
            value = 0.0
            for p in range(2):
                for q in range(2):
                    weight = floats[6 + 2 * a + p] * floats[6 + 2 * b + q]
                    value += weight * B[3 * p + i, column + 3 * q + j]
            data[slots[k * (3 * a + i) + 3 * b + j]] += factor * value


@kernel(TANGENT)
def add_moment_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    n = ints.shape[1] // 2
    d, m, D = np.empty((2, 6)), np.empty(3), np.empty((3, 6))
    K, B = np.empty((3, 3)), np.empty((6, 12))
    for e in range(ints.shape[0]):
        _moment(y, ints[e], floats[e], coef[e, 0], d, m, D)
        for end in range(2):
            if ints[e, n * end] < 0:
                continue
            _turning(d[end], K)
            _bend(d[end], m, D, 1.0 - 2.0 * end, 6 * (1 - end), K, B)
            for a in range(n * end, n * end + n):
                for b in range(2 * n):
                    if ints[e, a] >= 0 and ints[e, b] >= 0:
                        column = 0 if b // n == end else 6
                        _scatter(-cK, B, column, a, b, floats[e], slots[e], 6 * n, data)
