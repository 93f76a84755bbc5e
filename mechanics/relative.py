"""Scalars that say how two ends of a joint stand to each other, with first and second derivatives.

Each end has nine local coordinates: its position r and two vectors p, s that say how it stands,
constant combinations of vectors of the coordinates (``mechanics.layout.Side``). A direction that
moves with the end is

    u = c1 g/√|g| + c2 p + c3 s + constant,      g = p × s,

optionally divided by its length. g/√|g| grows like p and s, so a section that breathes evenly
changes the length of u and not its direction. A product is z = a·w, where w is a direction of
the second end and a is
    OFFSET     r_A − r_B + origin
    DIRECTION  a direction of the first end
or, for DISTANCE, z = |r_A − r_B + origin|²/(2 d).

A row is Φ = Σ weight z − constant, one of
    SHIFTED    Φ less x,
    STRETCHED  Φ less x + x²/(2 d): a DISTANCE becomes d + x,
    TURNED     w of its first product turned by the angle x: cos(x) w − sin(x) sine,
with x = coef[0] + own: what drives the row, and a coordinate of its own if it has one.
"""

import numpy as np
from numba import njit

from mechanics.kernels import FORCE, TANGENT, kernel

OFFSET, DIRECTION, DISTANCE = 0, 1, 2
SHIFTED, TURNED, STRETCHED = 0, 1, 2

VECTORS = 8
"""Column of ``ints`` where the K vectors of the first end begin, after: multiplier, own
coordinate, SHIFTED, TURNED or STRETCHED, products, vectors of both ends, kinds of two products."""
SINE, PRODUCT, WIDTH, WEIGHTS = 4, 11, 15, 41
"""Columns of ``floats``: constant, origin (3), sine (7), two products of weight, u (7) and w (7),
then weights of the K vectors of both ends in r, p, s (3 K each)."""


@njit(cache=True, error_model="numpy")
def gather(y, vectors, weights, count, x, o):
    """x[o:o + 9] = r, p, s of an end with ``count`` vectors; ``weights`` (3 k) vector by vector."""
    for i in range(9):
        x[o + i] = 0.0
    for k in range(count):
        for m in range(3):
            f = weights[3 * k + m]
            if f != 0.0:
                for i in range(3):
                    x[o + 3 * m + i] += f * y[vectors[k] + i]


@njit(cache=True, error_model="numpy")
def expand(gradient, o, weights, count, out, to):
    """Add to out[to:to + 3 count] what gradient[o:o + 9] by r, p, s is by the vectors."""
    for k in range(count):
        for m in range(3):
            f = weights[3 * k + m]
            if f != 0.0:
                for i in range(3):
                    out[to + 3 * k + i] += f * gradient[o + 3 * m + i]


@njit(cache=True, error_model="numpy")
def scratch():
    """Work space of ``evaluate``: a, w, ∂z/∂w, g; then A, W, G (3, 6)."""
    return np.zeros((13, 6))


@njit(cache=True, error_model="numpy")
def _normal(x, o):
    """g = p × s, where p and s begin at x[o], and |g|."""
    g0 = x[o + 1] * x[o + 5] - x[o + 2] * x[o + 4]
    g1 = x[o + 2] * x[o + 3] - x[o] * x[o + 5]
    g2 = x[o] * x[o + 4] - x[o + 1] * x[o + 3]
    return g0, g1, g2, np.sqrt(g0 * g0 + g1 * g1 + g2 * g2)


@njit(cache=True, error_model="numpy")
def _point(x, o, c, u):
    """Direction u, not divided by its length, of the end whose p and s begin at x[o]."""
    for i in range(3):
        u[i] = c[3 + i] + c[1] * x[o + i] + c[2] * x[o + 3 + i]
    if c[0] != 0.0:
        g0, g1, g2, size = _normal(x, o)
        f = c[0] / np.sqrt(size)
        u[0] += f * g0
        u[1] += f * g1
        u[2] += f * g2


@njit(cache=True, error_model="numpy")
def _pull(x, o, c, P, weight, gradient):
    """Add the gradient of weight P·u by p and s: with P' = c1 (P − (P·g) g/(2 |g|²))/√|g| it is
    c2 P + s × P' and c3 P + P' × p."""
    for i in range(3):
        gradient[o + i] += weight * c[1] * P[i]
        gradient[o + 3 + i] += weight * c[2] * P[i]
    if c[0] != 0.0:
        g0, g1, g2, size = _normal(x, o)
        f, along = weight * c[0] / np.sqrt(size), (P[0] * g0 + P[1] * g1 + P[2] * g2)
        along *= 0.5 / (size * size)
        a0, a1, a2 = f * (P[0] - along * g0), f * (P[1] - along * g1), f * (P[2] - along * g2)
        p0, p1, p2, s0, s1, s2 = x[o], x[o + 1], x[o + 2], x[o + 3], x[o + 4], x[o + 5]
        gradient[o] += s1 * a2 - s2 * a1
        gradient[o + 1] += s2 * a0 - s0 * a2
        gradient[o + 2] += s0 * a1 - s1 * a0
        gradient[o + 3] += a1 * p2 - a2 * p1
        gradient[o + 4] += a2 * p0 - a0 * p2
        gradient[o + 5] += a0 * p1 - a1 * p0


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
def _turns(x, o, c, D, g, G):
    """D (3, 6) = ∂u/∂(p, s) of the end whose p and s begin at x[o]."""
    for i in range(3):
        for j in range(6):
            D[i, j] = 0.0
        D[i, i] = c[1]
        D[i, 3 + i] = c[2]
    if c[0] != 0.0:
        s = _cross(x, o, g, G)
        f = c[0] / np.sqrt(s)
        for j in range(6):
            along = 0.5 * (g[0] * G[0, j] + g[1] * G[1, j] + g[2] * G[2, j]) / s**2
            for i in range(3):
                D[i, j] += f * (G[i, j] - along * g[i])


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
    for i in range(6):
        wi = w[0] * W[0, i] + w[1] * W[1, i] + w[2] * W[2, i]
        ai = a[0] * W[0, i] + a[1] * W[1, i] + a[2] * W[2, i]
        for j in range(6):
            wj = w[0] * W[0, j] + w[1] * W[1, j] + w[2] * W[2, j]
            aj = a[0] * W[0, j] + a[1] * W[1, j] + a[2] * W[2, j]
            both = W[0, i] * W[0, j] + W[1, i] * W[1, j] + W[2, i] * W[2, j]
            H[12 + i, 12 + j] += f * (along * (3.0 * wi * wj - both) - ai * wj - wi * aj)
    for i in range(6):
        wi = w[0] * W[0, i] + w[1] * W[1, i] + w[2] * W[2, i]
        for k in range(3):
            W[k, i] = (W[k, i] - wi * w[k]) / length


@njit(cache=True, error_model="numpy")
def _distance(a, d, weight, gradient, bend):
    """|a|²/(2 d), a = r_A − r_B + origin, with its derivatives."""
    value, f = 0.0, weight / d
    for i in range(3):
        value += 0.5 * f * a[i] ** 2
        gradient[i] += f * a[i]
        gradient[9 + i] -= f * a[i]
        if bend.shape[0] > 0:
            bend[i, i] += f
            bend[9 + i, 9 + i] += f
            bend[i, 9 + i] -= f
            bend[9 + i, i] -= f
    return value


@njit(cache=True, error_model="numpy")
def _across(kind, A, B, weight, H):
    """H += weight (Aᵀ B + Bᵀ A): a by its own end, w by the second."""
    for j in range(6):
        for i in range(6 if kind == DIRECTION else 3):
            if kind == DIRECTION:
                t = weight * (A[0, i] * B[0, j] + A[1, i] * B[1, j] + A[2, i] * B[2, j])
                H[3 + i, 12 + j] += t
                H[12 + j, 3 + i] += t
            else:
                t = weight * B[i, j]
                H[i, 12 + j] += t
                H[12 + j, i] += t
                H[9 + i, 12 + j] -= t
                H[12 + j, 9 + i] -= t


@njit(cache=True, error_model="numpy", forceinline=True)  # arrays cost at calls
def evaluate(kind, x, origin, u, w, weight, gradient, bend, work):
    """Value of weight z at local coordinates ``x`` (18,): r, p, s of the first and second end.

    Adds its derivatives to ``gradient`` (18,) and ``bend`` (18, 18); without rows in ``bend``
    there are no second derivatives. ``work`` is from ``scratch``. Only w is divided by its length.

    u, w : (7,) c1, c2, c3, constant (3), 1 to divide by the length; DISTANCE: w[3] = d
    """
    a, b, p = work[0], work[1], work[2]
    if kind != DIRECTION:
        for i in range(3):
            a[i] = x[i] - x[9 + i] + origin[i]
    if kind == DISTANCE:
        return _distance(a, w[3], weight, gradient, bend)
    for end in range(2):
        if end == 1 or kind == DIRECTION:
            _point(x, 3 + 9 * end, w if end else u, b if end else a)
    length, along = 1.0, 0.0
    if w[6] != 0.0:
        length = np.sqrt(b[0] ** 2 + b[1] ** 2 + b[2] ** 2)
        along = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / length
    for k in range(3):
        b[k] /= length
        p[k] = (a[k] - along * b[k]) / length  # derivative by the w that was
        if kind == OFFSET:
            gradient[k] += weight * b[k]
            gradient[9 + k] -= weight * b[k]
    for end in range(2):
        if end == 1 or kind == DIRECTION:
            _pull(x, 3 + 9 * end, w if end else u, p if end else b, weight, gradient)
    if bend.shape[0] > 0:
        _bend_all(kind, x, u, w, weight, length, bend, work)
    return weight * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@njit(cache=True, error_model="numpy")
def _bend_all(kind, x, u, w, weight, length, bend, work):
    """Second derivatives of weight a·w, where ``evaluate`` has left a, w and ∂z/∂w in ``work``."""
    a, b, p, g, A, B, G = work[0], work[1], work[2], work[3], work[4:7], work[7:10], work[10:13]
    for end in range(2):
        if end == 1 or kind == DIRECTION:
            o, c = 3 + 9 * end, w if end else u
            _turns(x, o, c, B if end else A, g, G)
            _bend(x, o, c, p if end else b, weight, g, G, bend)
    if w[6] != 0.0:
        _bend_unit(a, b, B, length, weight, bend)
    _across(kind, A, B, weight, bend)


@njit(cache=True, error_model="numpy", forceinline=True)  # arrays cost at calls
def _row(y, c, ints, floats, x, w, gradient, bend, work):
    """Φ of one row; ``gradient`` and ``bend`` by r, p, s of both ends are overwritten."""
    K = (ints.size - VECTORS) // 2
    for end in range(2):
        vectors, weights = ints[VECTORS + K * end :], floats[WEIGHTS + 3 * K * end :]
        gather(y, vectors, weights, ints[4 + end], x, 9 * end)
    own = c + y[ints[1]] if ints[1] >= 0 else c
    gradient[:] = 0.0
    bend[:] = 0.0
    value = -floats[0] if ints[2] == TURNED else -floats[0] - own
    if ints[2] == STRETCHED:
        value -= 0.5 * own * own / floats[PRODUCT + 8 + 3]
    for k in range(ints[3]):
        at = PRODUCT + WIDTH * k
        for i in range(7):
            w[i] = floats[at + 8 + i]
        if k == 0 and ints[2] == TURNED:
            for i in range(6):
                w[i] = np.cos(own) * w[i] - np.sin(own) * floats[SINE + i]
        u, origin = floats[at + 1 :], floats[1:]
        value += evaluate(ints[6 + k], x, origin, u, w, floats[at], gradient, bend, work)
    return value


@njit(cache=True, error_model="numpy")
def _slope(y, c, ints, floats, x, w, gradient, none, work):
    """∂Φ/∂own of a row with a coordinate of its own; ``gradient``: its derivative by r, p, s."""
    gradient[:] = 0.0
    if ints[2] == SHIFTED:
        return -1.0
    own = c + y[ints[1]]
    for i in range(6):
        w[i] = -np.sin(own) * floats[PRODUCT + 8 + i] - np.cos(own) * floats[SINE + i]
    w[6] = floats[PRODUCT + 14]
    u, f = floats[PRODUCT + 1 :], floats[PRODUCT]
    return evaluate(ints[6], x, floats[1:], u, w, f, gradient, none, work)


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """λ Φ_q and Φ of every row."""
    K = (ints.shape[1] - VECTORS) // 2
    x, w, gradient = np.empty(18), np.empty(7), np.empty(18)
    none, work = np.empty((0, 18)), scratch()
    for e in range(ints.shape[0]):
        line, lam = ints[e], y[ints[e, 0]]
        out[line[0]] += _row(y, coef[e, 0], line, floats[e], x, w, gradient, none, work)
        for side in range(2):
            start, first = WEIGHTS + 3 * K * side, VECTORS + K * side
            for k in range(line[4 + side]):
                for m in range(3):
                    f = lam * floats[e, start + 3 * k + m]
                    if f != 0.0:
                        for i in range(3):
                            out[line[first + k] + i] += f * gradient[9 * side + 3 * m + i]
        if line[1] >= 0:
            slope = _slope(y, coef[e, 0], line, floats[e], x, w, gradient, none, work)
            out[line[1]] += lam * slope


@njit(cache=True, error_model="numpy")
def spread(bend, weights, counts, K, half, H):
    """H (6 K, 6 K) = Wᵀ bend W for the vectors of both ends; ``half`` is work space (18, 6 K)."""
    half[:] = 0.0
    H[:] = 0.0
    for side in range(2):
        for k in range(counts[side]):
            for m in range(3):
                f = weights[3 * K * side + 3 * k + m]
                if f != 0.0:
                    for j in range(3):
                        for i in range(18):
                            half[i, 3 * (K * side + k) + j] += f * bend[i, 9 * side + 3 * m + j]
    for side in range(2):
        for k in range(counts[side]):
            for m in range(3):
                f = weights[3 * K * side + 3 * k + m]
                if f != 0.0:
                    for i in range(3):
                        for j in range(6 * K):
                            H[3 * (K * side + k) + i, j] += f * half[9 * side + 3 * m + i, j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """cK λ Φ_qq of every row, and Φ_q as row and as column."""
    K = (ints.shape[1] - VECTORS) // 2
    n = 6 * K + 2  # vectors of both ends, own coordinate, multiplier
    x, w, gradient, work = np.empty(18), np.empty(7), np.empty(18), scratch()
    bend, mixed, none = np.empty((18, 18)), np.empty(n), np.empty((0, 18))
    row, half, H = np.empty(n), np.empty((18, 6 * K)), np.empty((6 * K, 6 * K))
    for e in range(ints.shape[0]):
        line, f, c, at = ints[e], cK * y[ints[e, 0]], coef[e, 0], slots[e]
        own = line[1] >= 0
        value = _row(y, c, line, floats[e], x, w, gradient, bend if f != 0.0 else none, work)
        row[:] = 0.0
        for side in range(2):
            to = 3 * K * side
            expand(gradient, 9 * side, floats[e, WEIGHTS + to :], line[4 + side], row, to)
        if own:
            row[6 * K] = _slope(y, c, line, floats[e], x, w, gradient, none, work)
        for i in range(n - 1):
            data[at[i * n + n - 1]] += row[i]
            data[at[(n - 1) * n + i]] += row[i]
        if f == 0.0:
            continue
        spread(bend, floats[e, WEIGHTS:], line[4:], K, half, H)
        for i in range(6 * K):
            for j in range(6 * K):
                data[at[i * n + j]] += f * H[i, j]
        if own and line[2] == TURNED:
            mixed[:] = 0.0
            for side in range(2):
                to = 3 * K * side
                expand(gradient, 9 * side, floats[e, WEIGHTS + to :], line[4 + side], mixed, to)
            for i in range(6 * K):
                data[at[i * n + n - 2]] += f * mixed[i]
                data[at[(n - 2) * n + i]] += f * mixed[i]
            data[at[(n - 2) * n + n - 2]] -= f * (value + floats[e, 0])
