"""Kernels of points that slide on flexible bodies, see ``mechanics.sliding``."""

import numpy as np
from numba import njit

from mechanics.kernels import FORCE, TANGENT, kernel
from mechanics.relative import (
    DIRECTION,
    PRODUCT,
    WIDTH,
    evaluate,
    expand,
    gather,
    scratch,
    spread,
)

NODES, ENDS = 2, 5
"""Columns of ``ints``: multiplier, place; first coordinate of the body, from node to node, nodes;
vectors of the other end, nodes that arc lengths in ``floats`` have room for; in rows of position
then vectors of the other end, in rows of orientation the end that is on the body, products, offsets
of two vectors in a node, 1 for a cable, vectors of the other end."""
A_WEIGHTS = PRODUCT + 2 * WIDTH
"""Column of ``floats`` of rows of orientation where weights of the other end begin."""


@njit(cache=True, error_model="numpy")
def _element(s, floats, at, nodes):
    """Element that s is in: 0 to nodes − 2, also for s beyond the ends."""
    e = 0
    while e < nodes - 2 and s > floats[at + e + 1]:
        e += 1
    return e


@njit(cache=True, error_model="numpy")
def _hermite(s, a, b, h):
    """h (4, 4): weights of r_a, r_x,a, r_b, r_x,b in r, r', r'', r''' at s; straight beyond."""
    L, x = b - a, (s - a) / (b - a)
    h[:] = 0.0
    if x < 0.0:
        h[0, 0], h[0, 1], h[1, 1] = 1.0, s - a, 1.0
    elif x > 1.0:
        h[0, 2], h[0, 3], h[1, 3] = 1.0, s - b, 1.0
    else:
        h[0, 0], h[0, 2] = (1.0 - x) ** 2 * (1.0 + 2.0 * x), x * x * (3.0 - 2.0 * x)
        h[0, 1], h[0, 3] = L * x * (1.0 - x) ** 2, L * x * x * (x - 1.0)
        h[1, 2], h[1, 1], h[1, 3] = 6.0 * x * (1.0 - x) / L, (1 - x) * (1 - 3 * x), x * (3 * x - 2)
        h[2, 2], h[2, 1], h[2, 3] = (6 - 12 * x) / L**2, (6 * x - 4) / L, (6 * x - 2) / L
        h[3, 2], h[3, 1], h[3, 3] = -12.0 / L**3, 6.0 / L**2, 6.0 / L**2
        for k in range(1, 4):
            h[k, 0] = -h[k, 2]


# -- position: one row for each direction of space ---------------------------------------------


@njit(cache=True, error_model="numpy")
def _position(y, ints, floats, h, at):
    """Φ and −∂Φ/∂s, −∂²Φ/∂s² of one row; ``at`` (4,): the coordinates that ``h`` weighs."""
    s, nodes = y[ints[1]], ints[NODES + 2]
    S = floats.size - ints[ENDS + 1]
    e = _element(s, floats, S, nodes)
    _hermite(s, floats[S + e], floats[S + e + 1], h)
    for j in range(4):
        at[j] = ints[NODES] + (e + j // 2) * ints[NODES + 1] + 3 * (j % 2)
    value, first, second = floats[0], 0.0, 0.0
    for k in range(ints[ENDS]):
        value += floats[1 + k] * y[ints[ENDS + 2 + k]]
    for j in range(4):
        value -= h[0, j] * y[at[j]]
        first += h[1, j] * y[at[j]]
        second += h[2, j] * y[at[j]]
    return value, first, second, e


@kernel(FORCE)
def add_position_force(y, v, coef, ints, floats, out):
    h, at = np.empty((4, 4)), np.empty(4, np.int64)
    for e in range(ints.shape[0]):
        value, first, _, _ = _position(y, ints[e], floats[e], h, at)
        lam = y[ints[e, 0]]
        out[ints[e, 0]] += value
        out[ints[e, 1]] -= lam * first
        for k in range(ints[e, ENDS]):
            out[ints[e, ENDS + 2 + k]] += lam * floats[e, 1 + k]
        for j in range(4):
            out[at[j]] -= lam * h[0, j]


@kernel(TANGENT)
def add_position_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    h, at = np.empty((4, 4)), np.empty(4, np.int64)
    K = ints.shape[1] - ENDS - 2
    for e in range(ints.shape[0]):
        _, first, second, element = _position(y, ints[e], floats[e], h, at)
        n, f, slot = int(np.sqrt(slots.shape[1]) + 0.5), cK * y[ints[e, 0]], slots[e]
        place, last = n - 2, n - 1
        for k in range(ints[e, ENDS]):
            data[slot[k * n + last]] += floats[e, 1 + k]
            data[slot[last * n + k]] += floats[e, 1 + k]
        for j in range(4):
            i = K + 2 * element + j
            data[slot[i * n + last]] -= h[0, j]
            data[slot[last * n + i]] -= h[0, j]
            data[slot[i * n + place]] -= f * h[1, j]
            data[slot[place * n + i]] -= f * h[1, j]
        data[slot[place * n + last]] -= first
        data[slot[last * n + place]] -= first
        data[slot[place * n + place]] -= f * second


# -- orientation -------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _passing(y, ints, floats, h, V, at):
    """V (3, 4, 2): weights of four vectors in p, s and their first two derivatives by s."""
    s, nodes = y[ints[1]], ints[NODES + 2]
    S = floats.size - ints[ENDS + 1]
    e = _element(s, floats, S, nodes)
    a, b = floats[S + e], floats[S + e + 1]
    _hermite(s, a, b, h)
    x = min(max((s - a) / (b - a), 0.0), 1.0)
    V[:] = 0.0
    for j in range(4):
        node, which = j // 2, j % 2
        at[j] = ints[NODES] + (e + node) * ints[NODES + 1] + ints[ENDS + 4 + which]
        if ints[ENDS + 6] == 1:
            for k in range(3):
                V[k, j, 0] = h[k + 1, j]
        else:
            V[0, j, which] = x if node else 1.0 - x
            if a < s < b:
                V[1, j, which] = (1.0 if node else -1.0) / (b - a)
    return e


@njit(cache=True, error_model="numpy")
def _orientation(y, ints, floats, h, V, at, x, d, gradient, bend, work):
    """Φ, its gradient and bend by r, p, s of both ends; d (2, 18): first and second dx/ds."""
    e, moving, K = _passing(y, ints, floats, h, V, at), ints[ENDS + 2], ints[ENDS]
    vectors = ints[ENDS + 7 :]
    gather(y, vectors, floats[A_WEIGHTS:], K, x, 9 * (1 - moving))
    d[:] = 0.0
    for m in range(3):
        for i in range(3):
            o = 9 * moving + 3 * m + i
            x[o] = 0.0
            if m > 0:
                for j in range(4):
                    x[o] += V[0, j, m - 1] * y[at[j] + i]
                    d[0, o] += V[1, j, m - 1] * y[at[j] + i]
                    d[1, o] += V[2, j, m - 1] * y[at[j] + i]
    gradient[:] = 0.0
    bend[:] = 0.0
    value = -floats[0]
    for k in range(ints[ENDS + 3]):
        o = PRODUCT + WIDTH * k
        u, w = floats[o + 1 :], floats[o + 8 :]
        value += evaluate(DIRECTION, x, floats[1:], u, w, floats[o], gradient, bend, work)
    return value, e


@kernel(FORCE)
def add_orientation_force(y, v, coef, ints, floats, out):
    h, V, at, none = np.empty((4, 4)), np.empty((3, 4, 2)), np.empty(4, np.int64), np.empty((0, 18))
    x, d, gradient, work = np.empty(18), np.empty((2, 18)), np.empty(18), scratch()
    near = np.empty(24)
    for e in range(ints.shape[0]):
        line, lam = ints[e], y[ints[e, 0]]
        value, _ = _orientation(y, line, floats[e], h, V, at, x, d, gradient, none, work)
        out[line[0]] += value
        moving, K = line[ENDS + 2], line[ENDS]
        near[:] = 0.0
        expand(gradient, 9 * (1 - moving), floats[e, A_WEIGHTS:], K, near, 0)
        for k in range(K):
            for i in range(3):
                out[line[ENDS + 7 + k] + i] += lam * near[3 * k + i]
        for o in range(18):
            out[line[1]] += lam * gradient[o] * d[0, o]
        for j in range(4):
            for m in range(2):
                for i in range(3):
                    out[at[j] + i] += lam * V[0, j, m] * gradient[9 * moving + 3 + 3 * m + i]


@kernel(TANGENT)
def add_orientation_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    h, V, at, bend = (
        np.empty((4, 4)),
        np.empty((3, 4, 2)),
        np.empty(4, np.int64),
        np.empty((18, 18)),
    )
    x, d, gradient, work = np.empty(18), np.empty((2, 18)), np.empty(18), scratch()
    A = ints.shape[1] - ENDS - 7  # vectors of the other end
    K = max(A, 4)
    counts, weights, local = np.zeros(2, np.int64), np.zeros(6 * K), np.empty(6 * K, np.int64)
    half, H, row, mixed = (
        np.empty((18, 6 * K)),
        np.empty((6 * K, 6 * K)),
        np.empty(6 * K),
        np.empty(6 * K),
    )
    turned, weights1 = np.empty(18), np.zeros(6 * K)
    for e in range(ints.shape[0]):
        line, f, slot = ints[e], cK * y[ints[e, 0]], slots[e]
        _, element = _orientation(y, line, floats[e], h, V, at, x, d, gradient, bend, work)
        n = int(np.sqrt(slots.shape[1]) + 0.5)
        place, last, moving, other = n - 2, n - 1, line[ENDS + 2], 1 - line[ENDS + 2]
        counts[moving], counts[other] = 4, line[ENDS]
        weights[:] = 0.0
        weights1[:] = 0.0
        for i in range(3 * line[ENDS]):
            weights[3 * K * other + i] = floats[e, A_WEIGHTS + i]
            local[3 * K * other + i] = i
        for j in range(4):
            for m in range(2):
                weights[3 * K * moving + 3 * j + 1 + m] = V[0, j, m]
                weights1[3 * K * moving + 3 * j + 1 + m] = V[1, j, m]
            for i in range(3):
                local[3 * K * moving + 3 * j + i] = 3 * A + 6 * element + 3 * j + i
        for o in range(18):
            turned[o] = 0.0
            for i in range(18):
                turned[o] += bend[o, i] * d[0, i]
        row[:] = 0.0
        mixed[:] = 0.0
        for side in range(2):
            to = 3 * K * side
            expand(gradient, 9 * side, weights[to:], counts[side], row, to)
            expand(turned, 9 * side, weights[to:], counts[side], mixed, to)
            expand(gradient, 9 * side, weights1[to:], counts[side], mixed, to)
        slope, second = 0.0, 0.0
        for o in range(18):
            slope += gradient[o] * d[0, o]
            second += turned[o] * d[0, o] + gradient[o] * d[1, o]
        data[slot[place * n + last]] += slope
        data[slot[last * n + place]] += slope
        data[slot[place * n + place]] += f * second
        spread(bend, weights, counts, K, half, H)
        for side in range(2):
            for i in range(3 * K * side, 3 * (K * side + counts[side])):
                a = local[i]
                data[slot[a * n + last]] += row[i]
                data[slot[last * n + a]] += row[i]
                data[slot[a * n + place]] += f * mixed[i]
                data[slot[place * n + a]] += f * mixed[i]
                for facing in range(2):
                    for j in range(3 * K * facing, 3 * (K * facing + counts[facing])):
                        data[slot[a * n + local[j]]] += f * H[i, j]
