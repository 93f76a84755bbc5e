"""Strains, forces and tangents of the beam of ``mechanics.beam3333``.

At a point the element has five vectors u = (t, d2, d3, d2', d3'), t = dr/dx. Each strain is a
product x h: x is a dot product or a triple product of the vectors, and h = w^p a^q b^s a power of
a = d2.d2, b = d3.d3 and w = a b - c^2, c = d2.d3, that makes the directors of unit length:

====  =========================  ==================================
row   strain                     x, and powers of w, a, b in h
====  =========================  ==================================
0     axial  t.n                 [t, d2, d3], -1/2, 0, 0
1, 2  shear  t.d_k/|d_k|         t.d_k, and -1/2 of a or b
3, 4  bending  -n.d_k'/|d_k|     -[d_k', d2, d3], -1/2, -1/2 of a or b
5     torsion                    (d2'.d3 - d3'.d2)/2, 0, -1/2, -1/2
6-8   section                    a/2, b/2, c, without powers
====  =========================  ==================================

Rows 0 to 5 live at two Gauss points, rows 6 to 8 at the three nodes: 21 strains, in this order.
floats, by element: damping time [s], then dN/dx (3) [1/m] at both Gauss points. coef: stiffness,
free strain and its rate of each strain (3 x 21). ints: first coordinates of the three nodes.
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

STRAINS, POINTS, AT_GAUSS = 21, 5, 6
GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)
"""Two Gauss points in -1 to 1."""
KIND = np.array([0, 1, 2, 1, 2], dtype=np.int64)
"""The nodal vector, r, d2 or d3, from which each vector u is interpolated."""
POWERS = np.array([
    [-0.5, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, -0.5],
    [-0.5, -0.5, 0.0], [-0.5, 0.0, -0.5], [0.0, -0.5, -0.5],
    [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0],
])  # fmt: skip
"""(9, 3) powers of w, a and b."""
TRIPLE = np.array([0, -1, -1, 3, 4, -1, -1, -1, -1], dtype=np.int64)
"""First vector of the triple product of a row; -1 where x is made of dot products."""
DOT = np.array([
    [0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 2.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 0.0], [3.0, 2.0, 0.5, -0.5], [1.0, 1.0, 0.5, 0.0], [2.0, 2.0, 0.5, 0.0],
    [1.0, 2.0, 1.0, 0.0],
])  # fmt: skip
"""(9, 4) vectors m and o and factor of m.o, and factor of d3'.d2."""


@njit(cache=True, error_model="numpy")
def _shape(z, N):
    N[0], N[1], N[2] = 0.5 * z * (z - 1.0), 1.0 - z * z, 0.5 * z * (z + 1.0)


@njit(cache=True, error_model="numpy")
def _weights(floats, p, W):
    """(5, 3) weights of the three nodes in the vectors u at point p; no slopes at the nodes."""
    W[:] = 0.0
    _shape(GAUSS[p] if p < 2 else p - 3.0, W[1])
    W[2] = W[1]
    if p < 2:
        for i in range(3):
            W[0, i] = W[3, i] = W[4, i] = floats[1 + 3 * p + i]


@njit(cache=True, error_model="numpy")
def _vectors(y, ints, W, u):
    """The five vectors u (15,) at a point."""
    u[:] = 0.0
    for m in range(5):
        for n in range(3):
            for i in range(3):
                u[3 * m + i] += W[m, n] * y[ints[n] + 3 * KIND[m] + i]


@njit(cache=True, error_model="numpy")
def _cross(u, m, o, i):
    """Component i of u_m x u_o."""
    j, k = (i + 1) % 3, (i + 2) % 3
    return u[3 * m + j] * u[3 * o + k] - u[3 * m + k] * u[3 * o + j]


@njit(cache=True, error_model="numpy")
def _numerator(u, r, g):
    """x of a row and its gradient g (15,)."""
    g[:] = 0.0
    m, x = TRIPLE[r], 0.0
    if m >= 0:
        sign = 1.0 if m == 0 else -1.0
        for i in range(3):
            g[3 * m + i] += sign * _cross(u, 1, 2, i)
            g[3 + i] += sign * _cross(u, 2, m, i)
            g[6 + i] += sign * _cross(u, m, 1, i)
            x += sign * u[3 * m + i] * _cross(u, 1, 2, i)
        return x
    a, b, f, back = int(DOT[r, 0]), int(DOT[r, 1]), DOT[r, 2], DOT[r, 3]
    for i in range(3):
        g[3 * a + i] += f * u[3 * b + i]
        g[3 * b + i] += f * u[3 * a + i]
        g[12 + i] += back * u[3 + i]
        g[3 + i] += back * u[12 + i]
        x += f * u[3 * a + i] * u[3 * b + i] + back * u[12 + i] * u[3 + i]
    return x


@njit(cache=True, error_model="numpy")
def _squares(u, s):
    """s = (a, b, c, w), and the gradient (3,) of w = a b - c^2 in a, b, c."""
    s[:] = 0.0
    for i in range(3):
        s[0] += u[3 + i] * u[3 + i]
        s[1] += u[6 + i] * u[6 + i]
        s[2] += u[3 + i] * u[6 + i]
    s[3], s[4], s[5], s[6] = s[0] * s[1] - s[2] * s[2], s[1], s[0], -2.0 * s[2]


@njit(cache=True, error_model="numpy")
def _power(r, s, log):
    """h of a row and the gradient (3,) of its logarithm in a, b, c."""
    p, q, o = POWERS[r, 0], POWERS[r, 1], POWERS[r, 2]
    for i in range(3):
        log[i] = p * s[4 + i] / s[3]
    log[0] += q / s[0]
    log[1] += o / s[1]
    return s[3] ** p * s[0] ** q * s[1] ** o


@njit(cache=True, error_model="numpy")
def _square_gradients(u, g):
    """Gradients (3, 15) of a, b, c."""
    g[:] = 0.0
    for i in range(3):
        g[0, 3 + i], g[1, 6 + i] = 2.0 * u[3 + i], 2.0 * u[6 + i]
        g[2, 3 + i], g[2, 6 + i] = u[6 + i], u[3 + i]


@njit(cache=True, error_model="numpy")
def _strain(u, r, s, gs, log, G):
    """Strain of a row and its gradient G (15,); s and gs as ``_squares`` and their gradients."""
    x = _numerator(u, r, G)
    h = _power(r, s, log)
    for j in range(15):
        G[j] = h * (G[j] + x * (log[0] * gs[0, j] + log[1] * gs[1, j] + log[2] * gs[2, j]))
    return x * h


@njit(cache=True, error_model="numpy")
def _dot(G, w):
    total = 0.0
    for j in range(15):
        total += G[j] * w[j]
    return total


@njit(cache=True, error_model="numpy")
def _numerator_second(u, r, factor, H):
    """Add ``factor`` times the second derivatives of x to H (15, 15)."""
    m = TRIPLE[r]
    if m < 0:
        a, b, f, back = int(DOT[r, 0]), int(DOT[r, 1]), DOT[r, 2], DOT[r, 3]
        for i in range(3):
            H[3 * a + i, 3 * b + i] += factor * f
            H[3 * b + i, 3 * a + i] += factor * f
            H[12 + i, 3 + i] += factor * back
            H[3 + i, 12 + i] += factor * back
        return
    sign = factor if m == 0 else -factor
    for i in range(3):
        for turn in (1, 2):
            j = (i + turn) % 3
            k = 3 - i - j
            e = sign if turn == 1 else -sign
            for a, b, o in ((m, 1, 2), (1, 2, m), (2, m, 1)):
                H[3 * a + i, 3 * b + j] += e * u[3 * o + k]
                H[3 * b + j, 3 * a + i] += e * u[3 * o + k]


@njit(cache=True, error_model="numpy")
def _second(u, r, s, gs, log, g, Q, H):
    """Second derivatives H (15, 15) of the strain of a row; log, g (15,), Q (3, 3): scratch."""
    x = _numerator(u, r, g)
    h = _power(r, s, log)
    p = POWERS[r, 0] / s[3]
    for i in range(3):
        for j in range(3):
            Q[i, j] = x * h * (log[i] * log[j] - p * s[4 + i] * s[4 + j] / s[3])
    Q[0, 0] -= x * h * POWERS[r, 1] / s[0] ** 2
    Q[1, 1] -= x * h * POWERS[r, 2] / s[1] ** 2
    Q[0, 1] += x * h * p
    Q[1, 0] += x * h * p
    Q[2, 2] -= 2.0 * x * h * p
    for a in range(15):
        for b in range(15):
            total = 0.0
            for i in range(3):
                total += h * log[i] * (g[a] * gs[i, b] + gs[i, a] * g[b])
                for j in range(3):
                    total += Q[i, j] * gs[i, a] * gs[j, b]
            H[a, b] = total
    for i in range(3):
        H[3 + i, 3 + i] += 2.0 * x * h * log[0]
        H[6 + i, 6 + i] += 2.0 * x * h * log[1]
        H[3 + i, 6 + i] += x * h * log[2]
        H[6 + i, 3 + i] += x * h * log[2]
    _numerator_second(u, r, h, H)


@njit(cache=True, error_model="numpy")
def _row(k):
    """Point and row of strain k."""
    if k < 2 * AT_GAUSS:
        return k // AT_GAUSS, k % AT_GAUSS
    return 2 + (k - 12) // 3, AT_GAUSS + (k - 12) % 3


@njit(cache=True, error_model="numpy")
def _at(y, v, ints, floats, p, W, u, w, s, gs):
    """Weights, vectors, their rates, a, b, c, w and their gradients at point p."""
    _weights(floats, p, W)
    _vectors(y, ints, W, u)
    _vectors(v, ints, W, w)
    _squares(u, s)
    _square_gradients(u, gs)


@njit(cache=True, error_model="numpy")
def evaluate(y, v, ints, floats, strains, rates):
    """Strains and their rates (n_e, 21) of all elements."""
    W, u, w, G = np.empty((5, 3)), np.empty(15), np.empty(15), np.empty(15)
    s, gs, log = np.empty(7), np.empty((3, 15)), np.empty(3)
    for e in range(len(ints)):
        for k in range(STRAINS):
            p, r = _row(k)
            if r == 0 or r == AT_GAUSS:
                _at(y, v, ints[e], floats[e], p, W, u, w, s, gs)
            strains[e, k] = _strain(u, r, s, gs, log, G)
            rates[e, k] = _dot(G, w)


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    W, u, w, G = np.empty((5, 3)), np.empty(15), np.empty(15), np.empty(15)
    s, gs, log = np.empty(7), np.empty((3, 15)), np.empty(3)
    for e in range(len(ints)):
        c, tau = coef[e], floats[e, 0]
        for k in range(STRAINS):
            p, r = _row(k)
            if r == 0 or r == AT_GAUSS:
                _at(y, v, ints[e], floats[e], p, W, u, w, s, gs)
            excess = _strain(u, r, s, gs, log, G) - c[STRAINS + k]
            S = c[k] * (excess + tau * (_dot(G, w) - c[2 * STRAINS + k]))
            for m in range(5):
                for n in range(3):
                    for i in range(3):
                        out[ints[e, n] + 3 * KIND[m] + i] += S * W[m, n] * G[3 * m + i]


@kernel(ENERGY)
def add_energies(y, v, coef, ints, floats, out):
    W, u, w, G = np.empty((5, 3)), np.empty(15), np.empty(15), np.empty(15)
    s, gs, log = np.empty(7), np.empty((3, 15)), np.empty(3)
    for e in range(len(ints)):
        c, tau = coef[e], floats[e, 0]
        for k in range(STRAINS):
            p, r = _row(k)
            if r == 0 or r == AT_GAUSS:
                _at(y, v, ints[e], floats[e], p, W, u, w, s, gs)
            excess, heated = _strain(u, r, s, gs, log, G) - c[STRAINS + k], c[2 * STRAINS + k]
            rate = _dot(G, w) - heated
            out[0] += 0.5 * c[k] * excess * excess
            out[1] += tau * c[k] * rate * rate
            out[2] += tau * c[k] * rate * heated


@njit(cache=True, error_model="numpy")
def _spread(W, K, slots, data):
    """Add the matrix (15, 15) of the vectors u of a point to that of the coordinates."""
    for m in range(5):
        for a in range(3):
            for o in range(5):
                for b in range(3):
                    weight = W[m, a] * W[o, b]
                    if weight != 0.0:
                        row, column = 9 * a + 3 * KIND[m], 9 * b + 3 * KIND[o]
                        for i in range(3):
                            for j in range(3):
                                at = slots[27 * (row + i) + column + j]
                                data[at] += weight * K[3 * m + i, 3 * o + j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Of each strain: D (cK + cC tau) G G^T + cK (S H + D tau G (H w)^T)."""
    W, u, w, G = np.empty((5, 3)), np.empty(15), np.empty(15), np.empty(15)
    s, gs, log = np.empty(7), np.empty((3, 15)), np.empty(3)
    H, K, g, Q = np.empty((15, 15)), np.empty((15, 15)), np.empty(15), np.empty((3, 3))
    for e in range(len(ints)):
        c, tau = coef[e], floats[e, 0]
        for k in range(STRAINS):
            p, r = _row(k)
            if r == 0 or r == AT_GAUSS:
                _at(y, v, ints[e], floats[e], p, W, u, w, s, gs)
                K[:] = 0.0
            excess = _strain(u, r, s, gs, log, G) - c[STRAINS + k]
            S = c[k] * (excess + tau * (_dot(G, w) - c[2 * STRAINS + k]))
            _second(u, r, s, gs, log, g, Q, H)
            for b in range(15):
                turned = 0.0
                for j in range(15):
                    turned += H[b, j] * w[j]
                second = c[k] * ((cK + cC * tau) * G[b] + cK * tau * turned)
                for a in range(15):
                    K[a, b] += G[a] * second + cK * S * H[a, b]
            if r == AT_GAUSS - 1 or r == AT_GAUSS + 2:
                _spread(W, K, slots[e], data)
