"""Scalars that say how two ends of a joint stand to each other, with first and second derivatives.

Each end has nine local coordinates: its position r and two vectors p, s (beam: d2, d3; cable: r_x
and nothing). A direction that moves with the end is

    u = c1 g/√|g| + c2 p + c3 s + constant,      g = p × s,

optionally divided by its length. g/√|g| grows like p and s, so a section that breathes evenly
changes the length of u and not its direction. A term is z = a·w, where w is a direction of the
second end and a is
    OFFSET     r_A − r_B + origin
    DIRECTION  a direction of the first end
or, for DISTANCE, z = |r_A − r_B + origin|²/(2 d).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

OFFSET, DIRECTION, DISTANCE = 0, 1, 2


class Terms(NamedTuple):
    """Arrays of k terms; ``weight`` times a term is added to its ``row``.

    kind, row : (k,) int;  weight : (k,) float
    dofs : (k, 18) int  coordinates r, p, s of the first and the second end; -1 absent
    origin : (k, 3) float [m]
    u, w : (k, 7) float  c1, c2, c3, constant (3), 1 to divide by the length; DISTANCE: w[3] = d
    """

    kind: NDArray[np.intp]
    row: NDArray[np.intp]
    weight: NDArray[np.float64]
    dofs: NDArray[np.intp]
    origin: NDArray[np.float64]
    u: NDArray[np.float64]
    w: NDArray[np.float64]


@njit(cache=True)
def _cross(x, g, G):
    """g = p × s and its derivative G (3, 6)."""
    G[:] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        g[i] = x[j] * x[3 + k] - x[k] * x[3 + j]
        G[i, j], G[i, k], G[i, 3 + k], G[i, 3 + j] = x[3 + k], -x[3 + j], x[j], -x[k]
    return np.sqrt(g[0] ** 2 + g[1] ** 2 + g[2] ** 2)


@njit(cache=True)
def _direction(x, c, u, D, g, G):
    """Direction u of one end, not yet divided by its length, and its derivative D (3, 6)."""
    D[:] = 0.0
    for i in range(3):
        u[i] = c[3 + i] + c[1] * x[i] + c[2] * x[3 + i]
        D[i, i], D[i, 3 + i] = c[1], c[2]
    if c[0] != 0.0:
        s = _cross(x, g, G)
        for j in range(6):
            along = 0.5 * (g[0] * G[0, j] + g[1] * G[1, j] + g[2] * G[2, j]) / s**2
            for i in range(3):
                D[i, j] += c[0] / np.sqrt(s) * (G[i, j] - along * g[i])
        for i in range(3):
            u[i] += c[0] / np.sqrt(s) * g[i]


@njit(cache=True)
def _unit(u, D):
    """Divide by the length, in place; returns the length."""
    length = np.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
    for i in range(3):
        u[i] /= length
    for j in range(6):
        along = u[0] * D[0, j] + u[1] * D[1, j] + u[2] * D[2, j]
        for i in range(3):
            D[i, j] = (D[i, j] - along * u[i]) / length
    return length


@njit(cache=True)
def _congruence(D, C, scale, H):
    """H += scale Dᵀ C D for C (3, 3)."""
    for k in range(3):
        for m in range(3):
            if C[k, m] != 0.0:
                for i in range(6):
                    for j in range(6):
                        H[i, j] += scale * C[k, m] * D[k, i] * D[m, j]


@njit(cache=True)
def _bend(x, c, p, scale, g, G, C, H):
    """H += scale ∂²(p·u)/∂x² for u not divided by its length."""
    if c[0] == 0.0:
        return
    s = _cross(x, g, G)
    f, pg = c[0] / np.sqrt(s), (p[0] * g[0] + p[1] * g[1] + p[2] * g[2]) / s**2
    for i in range(3):
        for j in range(3):
            C[i, j] = f * (1.25 * pg * g[i] * g[j] - 0.5 * (p[i] * g[j] + g[i] * p[j])) / s**2
        C[i, i] -= 0.5 * f * pg
        t = scale * f * (p[i] - 0.5 * pg * g[i])
        j, k = (i + 1) % 3, (i + 2) % 3
        H[j, 3 + k] += t
        H[3 + k, j] += t
        H[k, 3 + j] -= t
        H[3 + j, k] -= t
    _congruence(G, C, scale, H)


@njit(cache=True)
def _bend_unit(x, c, p, scale, u, D, g, G, C, H):
    """H += scale ∂²(p·u/|u|)/∂x²; overwrites u and D."""
    _direction(x, c, u, D, g, G)
    length = np.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
    a = np.empty(3)
    pu = (p[0] * u[0] + p[1] * u[1] + p[2] * u[2]) / length**2
    for i in range(3):
        a[i] = (p[i] - pu * u[i]) / length
        for j in range(3):
            C[i, j] = (3.0 * pu * u[i] * u[j] - p[i] * u[j] - u[i] * p[j]) / length**3
        C[i, i] -= pu / length
    _congruence(D, C, scale, H)
    _bend(x, c, a, scale, g, G, C, H)


@njit(cache=True)
def _pair(kind, x, origin, cu, cw, a, A, w, W, D, g, G):
    """a and w of one term with their derivatives A, W (3, 18)."""
    A[:] = 0.0
    W[:] = 0.0
    if kind == DIRECTION:
        _direction(x[3:9], cu, a, D, g, G)
        A[:, 3:9] = D
    else:
        for i in range(3):
            a[i] = x[i] - x[9 + i] + origin[i]
            A[i, i], A[i, 9 + i] = 1.0, -1.0
    if kind == DISTANCE:
        for i in range(3):
            w[i] = a[i] / (2.0 * cw[3])
            W[i, i], W[i, 9 + i] = 1.0 / (2.0 * cw[3]), -1.0 / (2.0 * cw[3])
    else:
        _direction(x[12:18], cw, w, D, g, G)
        if cw[6] != 0.0:
            _unit(w, D)
        W[:, 12:18] = D


@njit(cache=True)
def evaluate(kind, row, weight, dofs, origin, u, w, q, values, blocks):
    """Add values (rows,) and gradients (rows, 18) of all terms.

    A first end never divides by its length; only w does.
    """
    x, a, b, g = np.empty(18), np.empty(3), np.empty(3), np.empty(3)
    A, B, D, G = np.empty((3, 18)), np.empty((3, 18)), np.empty((3, 6)), np.empty((3, 6))
    for e in range(kind.size):
        for i in range(18):
            x[i] = q[dofs[e, i]] if dofs[e, i] >= 0 else 0.0
        _pair(kind[e], x, origin[e], u[e], w[e], a, A, b, B, D, g, G)
        for k in range(3):
            values[row[e]] += weight[e] * a[k] * b[k]
            for i in range(18):
                blocks[row[e], i] += weight[e] * (A[k, i] * b[k] + B[k, i] * a[k])


@njit(cache=True)
def bend(kind, row, weight, dofs, origin, u, w, q, blocks):
    """Add second derivatives (rows, 18, 18) of all terms."""
    x, a, b, g = np.empty(18), np.empty(3), np.empty(3), np.empty(3)
    A, B, D, G = np.empty((3, 18)), np.empty((3, 18)), np.empty((3, 6)), np.empty((3, 6))
    C, d = np.empty((3, 3)), np.empty(3)
    for e in range(kind.size):
        for i in range(18):
            x[i] = q[dofs[e, i]] if dofs[e, i] >= 0 else 0.0
        _pair(kind[e], x, origin[e], u[e], w[e], a, A, b, B, D, g, G)
        H = blocks[row[e]]
        for k in range(3):
            for i in range(18):
                for j in range(18):
                    H[i, j] += weight[e] * (A[k, i] * B[k, j] + B[k, i] * A[k, j])
        if kind[e] == DIRECTION:
            _bend(x[3:9], u[e], b, weight[e], g, G, C, H[3:9, 3:9])
        if kind[e] != DISTANCE and w[e, 6] != 0.0:
            _bend_unit(x[12:18], w[e], a, weight[e], d, D, g, G, C, H[12:18, 12:18])
        elif kind[e] != DISTANCE:
            _bend(x[12:18], w[e], a, weight[e], g, G, C, H[12:18, 12:18])
