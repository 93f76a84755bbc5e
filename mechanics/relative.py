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


@njit(cache=True, error_model="numpy")
def _cross(x, o, g, G):
    """g = p × s and its derivative G (3, 6), where p and s begin at x[o]; returns |g|."""
    for i in range(3):
        for j in range(6):
            G[i, j] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        g[i] = x[o + j] * x[o + 3 + k] - x[o + k] * x[o + 3 + j]
        G[i, j] = x[o + 3 + k]
        G[i, k] = -x[o + 3 + j]
        G[i, 3 + k] = x[o + j]
        G[i, 3 + j] = -x[o + k]
    return np.sqrt(g[0] ** 2 + g[1] ** 2 + g[2] ** 2)


@njit(cache=True, error_model="numpy")
def _direction(x, o, c, u, D, g, G):
    """Direction u, not yet divided by its length, and its derivative D (3, 18)."""
    for i in range(3):
        u[i] = c[3 + i] + c[1] * x[o + i] + c[2] * x[o + 3 + i]
        D[i, o + i] = c[1]
        D[i, o + 3 + i] = c[2]
    if c[0] != 0.0:
        s = _cross(x, o, g, G)
        f = c[0] / np.sqrt(s)
        for j in range(6):
            along = 0.5 * (g[0] * G[0, j] + g[1] * G[1, j] + g[2] * G[2, j]) / s**2
            for i in range(3):
                D[i, o + j] += f * (G[i, j] - along * g[i])
        for i in range(3):
            u[i] += f * g[i]


@njit(cache=True, error_model="numpy")
def _pair(kind, x, origin, cu, cw, a, A, w, W, g, G):
    """a and w of one term, w not yet divided by its length, and derivatives A, W (3, 18)."""
    for i in range(3):
        for j in range(18):
            A[i, j] = 0.0
            W[i, j] = 0.0
    if kind == DIRECTION:
        _direction(x, 3, cu, a, A, g, G)
    else:
        for i in range(3):
            a[i] = x[i] - x[9 + i] + origin[i]
            A[i, i] = 1.0
            A[i, 9 + i] = -1.0
    if kind == DISTANCE:
        for i in range(3):
            w[i] = a[i] / (2.0 * cw[3])
            W[i, i] = 1.0 / (2.0 * cw[3])
            W[i, 9 + i] = -W[i, i]
    else:
        _direction(x, 12, cw, w, W, g, G)


@njit(cache=True, error_model="numpy")
def _bend(x, o, c, p, weight, g, G, H):
    """H += weight ∂²(p·u)/∂x² for a direction u not divided by its length."""
    if c[0] == 0.0:
        return
    s = _cross(x, o, g, G)
    f, along = weight * c[0] / np.sqrt(s), (p[0] * g[0] + p[1] * g[1] + p[2] * g[2]) / s**2
    for i in range(6):
        gi = (g[0] * G[0, i] + g[1] * G[1, i] + g[2] * G[2, i]) / s**2
        pi = p[0] * G[0, i] + p[1] * G[1, i] + p[2] * G[2, i]
        for j in range(6):
            gj = g[0] * G[0, j] + g[1] * G[1, j] + g[2] * G[2, j]
            pj = p[0] * G[0, j] + p[1] * G[1, j] + p[2] * G[2, j]
            both = G[0, i] * G[0, j] + G[1, i] * G[1, j] + G[2, i] * G[2, j]
            mixed = 2.5 * along * gi * gj - pi * gj / s**2 - gi * pj
            H[o + i, o + j] += 0.5 * f * (mixed - along * both)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        t = f * (p[i] - 0.5 * along * g[i])
        H[o + j, o + 3 + k] += t
        H[o + 3 + k, o + j] += t
        H[o + k, o + 3 + j] -= t
        H[o + 3 + j, o + k] -= t


@njit(cache=True, error_model="numpy")
def _bend_unit(a, w, W, length, weight, H):
    """H += weight Wᵀ C W, C = ∂²(a·u/|u|)/∂u² at u = |u| w; then W becomes that of u/|u|."""
    along = a[0] * w[0] + a[1] * w[1] + a[2] * w[2]
    f = weight / length**2
    for i in range(12, 18):
        wi = w[0] * W[0, i] + w[1] * W[1, i] + w[2] * W[2, i]
        ai = a[0] * W[0, i] + a[1] * W[1, i] + a[2] * W[2, i]
        for j in range(12, 18):
            wj = w[0] * W[0, j] + w[1] * W[1, j] + w[2] * W[2, j]
            aj = a[0] * W[0, j] + a[1] * W[1, j] + a[2] * W[2, j]
            both = W[0, i] * W[0, j] + W[1, i] * W[1, j] + W[2, i] * W[2, j]
            H[i, j] += f * (along * (3.0 * wi * wj - both) - ai * wj - wi * aj)
    for i in range(12, 18):
        wi = w[0] * W[0, i] + w[1] * W[1, i] + w[2] * W[2, i]
        for k in range(3):
            W[k, i] = (W[k, i] - wi * w[k]) / length


@njit(cache=True, error_model="numpy")
def evaluate(kind, row, weight, dofs, origin, u, w, q, values, gradients, bends):
    """Add values (rows,), gradients (rows, 18) and second derivatives (rows, 18, 18).

    Without rows in ``bends`` there are no second derivatives. Only w is divided by its length.
    """
    x, a, b, p, g = np.empty(18), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    A, B, G = np.empty((3, 18)), np.empty((3, 18)), np.empty((3, 6))
    for e in range(kind.size):
        f, r, length, along = weight[e], row[e], 1.0, 0.0
        for i in range(18):
            x[i] = q[dofs[e, i]] if dofs[e, i] >= 0 else 0.0
        _pair(kind[e], x, origin[e], u[e], w[e], a, A, b, B, g, G)
        if kind[e] != DISTANCE and w[e, 6] != 0.0:
            length = np.sqrt(b[0] ** 2 + b[1] ** 2 + b[2] ** 2)
            along = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / length
        for k in range(3):
            b[k] /= length
            p[k] = (a[k] - along * b[k]) / length  # derivative by the w that was
            values[r] += f * a[k] * b[k]
            for i in range(18):
                gradients[r, i] += f * (A[k, i] * b[k] + B[k, i] * p[k])
        if bends.shape[0] == 0:
            continue
        H = bends[r]
        if kind[e] == DIRECTION:
            _bend(x, 3, u[e], b, f, g, G, H)
        if kind[e] != DISTANCE:
            _bend(x, 12, w[e], p, f, g, G, H)
            if w[e, 6] != 0.0:
                _bend_unit(a, b, B, length, f, H)
        for k in range(3):
            for i in range(18):
                for j in range(18):
                    H[i, j] += f * (A[k, i] * B[k, j] + B[k, i] * A[k, j])
