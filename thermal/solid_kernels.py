"""Compiled sums over the cells of solids.

Cells are taken ``BATCH`` at a time: arrays of cells have the cells of a batch as their last axis,
over which the innermost loops run, so that they become vector instructions. Cells that fill up the
last batch have no volume. A property is its ``Curve`` as arrays: knots, origins, coefficients.
"""

import numpy as np
from numba import njit

BATCH = 32

UNROLLED = 20  # nodes of a cell up to which the compiler unrolls loops over them

FUSED = {"contract"}
"""What the compiler may do to sums: multiply and add at once."""


@njit(cache=True, fastmath=FUSED)
def conducted(nodes, dofs, metric, values, slopes, knots, origins, k, T, out):  # pragma: no cover
    """Subtract the integral of k(T) grad N_i . grad T from ``out``.

    dofs : (batches, n, BATCH); metric : (batches, q or 1, 6, BATCH), xx yy zz yz xz xy of
    J^-1 J^-T det J times the weight; values : (q, n); slopes : (q, n, 3) on the reference cell
    """
    n = len(nodes)
    w = np.empty((2 * n + 7, BATCH))  # received, first and differences, metric, temperature
    v, s = values.ravel(), slopes.ravel()
    piece = 0
    for e in range(dofs.shape[0]):
        _load(n, dofs, e, T, w, n)
        w[:n] = 0.0
        for q in range(values.shape[0]):
            for c in range(6):
                for b in range(BATCH):
                    w[2 * n + c, b] = metric[e, min(q, metric.shape[1] - 1), c, b]
            _blend(n, w, n, v, q * n, 2 * n + 6)
            piece = _evaluate(knots, origins, k, w[2 * n + 6], piece)
            _receive(n, w, s, 3 * q * n)
        # what the first node of a cell gets is what the others give, to round-off
        for a in range(1, n):
            for b in range(BATCH):
                w[0, b] -= w[a, b]
        for a in range(n):
            for b in range(BATCH):
                out[dofs[e, a, b]] -= w[a, b]


@njit(inline="always")
def _load(n, dofs, e, T, w, at):  # pragma: no cover
    """Temperatures of the first nodes, and differences of the others to them, in rows ``at``."""
    for b in range(BATCH):
        w[at, b] = T[dofs[e, 0, b]]
    for a in range(1, n):
        for b in range(BATCH):
            w[at + a, b] = T[dofs[e, a, b]] - w[at, b]


@njit(inline="always")
def _blend(n, w, at, v, q, to):  # pragma: no cover
    """Temperatures from rows ``at``, in row ``to``."""
    for b in range(BATCH):
        t = w[at, b]
        for a in range(1, n):
            t += v[q + a] * w[at + a, b]
        w[to, b] = t


@njit(inline="always")
def _receive(n, w, s, q):  # pragma: no cover
    """Add what nodes but the first give at a point where the conductivity is in the last row."""
    m = 2 * n
    for b in range(BATCH):
        x, y, z = 0.0, 0.0, 0.0
        for a in range(1, n):
            x += s[q + 3 * a] * w[n + a, b]
            y += s[q + 3 * a + 1] * w[n + a, b]
            z += s[q + 3 * a + 2] * w[n + a, b]
        k = w[m + 6, b]
        f = k * (w[m, b] * x + w[m + 5, b] * y + w[m + 4, b] * z)
        g = k * (w[m + 5, b] * x + w[m + 1, b] * y + w[m + 3, b] * z)
        h = k * (w[m + 4, b] * x + w[m + 3, b] * y + w[m + 2, b] * z)
        if n <= UNROLLED:
            for a in range(1, n):
                w[a, b] += s[q + 3 * a] * f + s[q + 3 * a + 1] * g + s[q + 3 * a + 2] * h
        else:
            w[m, b], w[m + 1, b], w[m + 2, b] = f, g, h
    if n > UNROLLED:
        for a in range(1, n):
            x, y, z = s[q + 3 * a], s[q + 3 * a + 1], s[q + 3 * a + 2]
            for b in range(BATCH):
                w[a, b] += x * w[m, b] + y * w[m + 1, b] + z * w[m + 2, b]


@njit(inline="always")
def _piece(knots, t, piece):  # pragma: no cover
    """Which piece of a curve holds t, looked for from the last one found."""
    while piece < len(knots) and t >= knots[piece]:
        piece += 1
    while piece > 0 and t < knots[piece - 1]:
        piece -= 1
    return piece


@njit(inline="always")
def _horner(c, x):  # pragma: no cover
    y = c[-1]
    for i in range(len(c) - 2, -1, -1):
        y = y * x + c[i]
    return y


@njit(inline="always")
def _evaluate(knots, origins, c, at, piece):  # pragma: no cover
    """Replace temperatures by the value of a property; cells of one piece of it together."""
    piece = _piece(knots, at[0], piece)
    low = knots[piece - 1] if piece > 0 else -np.inf
    high = knots[piece] if piece < len(knots) else np.inf
    beyond = 0
    for b in range(BATCH):
        beyond += (at[b] < low) | (at[b] >= high)
    if beyond == 0:
        _together(c[piece], origins[piece], at)
        return piece
    for b in range(BATCH):
        piece = _piece(knots, at[b], piece)
        at[b] = _horner(c[piece], at[b] - origins[piece])
    return piece


@njit(inline="always")
def _together(c, origin, at):  # pragma: no cover
    for b in range(BATCH):
        x = at[b] - origin
        y = c[-1]
        for i in range(len(c) - 2, -1, -1):
            y = y * x + c[i]
        at[b] = y


@njit(cache=True)
def property_at(knots, origins, c, T):  # pragma: no cover
    """(n,) values of a property, or of its slope or primitive by the coefficients c."""
    out = np.empty(len(T))
    piece = 0
    for i in range(len(T)):
        piece = _piece(knots, T[i], piece)
        out[i] = _horner(c[piece], T[i] - origins[piece])
    return out


@njit(cache=True, fastmath=FUSED)
def stored(nodes, dofs, mass, values, knots, origins, h, T, out):  # pragma: no cover
    """Add the integral of N_i h(T) to ``out``.

    mass : (batches, q or 1, BATCH) float [kg]; h : primitive of the heat capacity
    """
    n = len(nodes)
    w = np.empty((2 * n + 1, BATCH))
    v, piece = values.ravel(), 0
    for e in range(dofs.shape[0]):
        _load(n, dofs, e, T, w, n)
        w[:n] = 0.0
        for q in range(values.shape[0]):
            _blend(n, w, n, v, q * n, 2 * n)
            piece = _evaluate(knots, origins, h, w[2 * n], piece)
            _weigh(mass, e, q, w[2 * n])
            for b in range(BATCH):
                for a in range(n):
                    w[a, b] += v[q * n + a] * w[2 * n, b]
        for a in range(n):
            for b in range(BATCH):
                out[dofs[e, a, b]] += w[a, b]


@njit(inline="always")
def _weigh(mass, e, q, at):  # pragma: no cover
    for b in range(BATCH):
        at[b] *= mass[e, min(q, mass.shape[1] - 1), b]


@njit(cache=True, fastmath=FUSED)
def add_capacity(nodes, dofs, mass, values, knots, origins, c, slots, T, data):  # pragma: no cover
    """Add the integral of N_i c(T) N_j to the entries ``data``, at ``slots_of`` the cells."""
    n = len(nodes)
    w = np.empty((n * n + n + 1, BATCH))
    v, own, piece = values.ravel(), n * n, 0
    for e in range(dofs.shape[0]):
        _load(n, dofs, e, T, w, own)
        w[:own] = 0.0
        for q in range(values.shape[0]):
            _blend(n, w, own, v, q * n, own + n)
            piece = _evaluate(knots, origins, c, w[own + n], piece)
            _weigh(mass, e, q, w[own + n])
            for i in range(n):
                for b in range(BATCH):
                    u = v[q * n + i] * w[own + n, b]
                    for j in range(n):
                        w[i * n + j, b] += v[q * n + j] * u
        _scatter(n, slots, e, w, data)


@njit(cache=True, fastmath=FUSED)
def add_conductance(
    nodes, dofs, metric, values, slopes, knots, origins, k, dk, slots, tau, T, data
):  # pragma: no cover
    """Add tau times the derivative of the integral of k(T) grad N_i . grad T to ``data``.

    What belongs to the first node of a cell follows from the others: gradients sum to 0 over the
    nodes, and values to 1.
    """
    n = len(nodes)
    own = n * n
    w = np.empty((own + n + 11, BATCH))  # entries, temperatures, metric, k, dk, flux
    v, s, piece = values.ravel(), slopes.ravel(), 0
    at, bend = own + n + 6, own + n + 7
    for e in range(dofs.shape[0]):
        _load(n, dofs, e, T, w, own)
        w[:own] = 0.0
        for q in range(values.shape[0]):
            _blend(n, w, own, v, q * n, at)
            w[bend] = w[at]
            piece = _evaluate(knots, origins, dk, w[bend], piece)
            piece = _evaluate(knots, origins, k, w[at], piece)
            for c in range(6):
                for b in range(BATCH):
                    w[own + n + c, b] = tau * metric[e, min(q, metric.shape[1] - 1), c, b]
            _bent(n, w, s, 3 * q * n)
            for i in range(1, n):
                _row(n, w, i, v, s, q * n)
        _complete(n, w)
        _scatter(n, slots, e, w, data)


@njit(inline="always")
def _bent(n, w, s, q):  # pragma: no cover
    """Flux of the slope of k, and k times the metric in its place."""
    own = n * n
    m = own + n
    for b in range(BATCH):
        x, y, z = 0.0, 0.0, 0.0
        for a in range(1, n):
            x += s[q + 3 * a] * w[own + a, b]
            y += s[q + 3 * a + 1] * w[own + a, b]
            z += s[q + 3 * a + 2] * w[own + a, b]
        k, bend = w[m + 6, b], w[m + 7, b]
        w[m + 8, b] = bend * (w[m, b] * x + w[m + 5, b] * y + w[m + 4, b] * z)
        w[m + 9, b] = bend * (w[m + 5, b] * x + w[m + 1, b] * y + w[m + 3, b] * z)
        w[m + 10, b] = bend * (w[m + 4, b] * x + w[m + 3, b] * y + w[m + 2, b] * z)
        for c in range(6):
            w[m + c, b] *= k


@njit(inline="always")
def _row(n, w, i, v, s, q):  # pragma: no cover
    """Add a row of a point's entries; of the first column only what values sum up to."""
    m = n * n + n
    x, y, z = s[3 * (q + i)], s[3 * (q + i) + 1], s[3 * (q + i) + 2]
    for b in range(BATCH):
        f = w[m, b] * x + w[m + 5, b] * y + w[m + 4, b] * z
        g = w[m + 5, b] * x + w[m + 1, b] * y + w[m + 3, b] * z
        h = w[m + 4, b] * x + w[m + 3, b] * y + w[m + 2, b] * z
        u = x * w[m + 8, b] + y * w[m + 9, b] + z * w[m + 10, b]
        w[i * n, b] += u
        for j in range(1, n):
            p = 3 * (q + j)
            w[i * n + j, b] += s[p] * f + s[p + 1] * g + s[p + 2] * h + v[q + j] * u


@njit(inline="always")
def _complete(n, w):  # pragma: no cover
    """First column and row, such that columns sum to 0."""
    for i in range(1, n):
        for j in range(1, n):
            for b in range(BATCH):
                w[i * n, b] -= w[i * n + j, b]
    for i in range(1, n):
        for j in range(n):
            for b in range(BATCH):
                w[j, b] -= w[i * n + j, b]


@njit(inline="always")
def _scatter(n, slots, e, w, data):  # pragma: no cover
    for i in range(n):
        for j in range(n):
            for b in range(BATCH):
                data[slots[e, i, j, b]] += w[i * n + j, b]


@njit(cache=True)
def slots_of(dofs, starts, columns):  # pragma: no cover
    """(batches, n, n, BATCH) uint32  where the pairs of nodes of each cell are in rows of a matrix.

    starts, columns : of the matrix, compressed by rows, columns rising
    """
    batches, n = dofs.shape[:2]
    slots = np.empty((batches, n, n, BATCH), np.uint32)
    for e in range(batches):
        for i in range(n):
            for b in range(BATCH):
                row = dofs[e, i, b]
                first, last = starts[row], starts[row + 1]
                for j in range(n):
                    at = np.searchsorted(columns[first:last], dofs[e, j, b])
                    slots[e, i, j, b] = first + at
    return slots


@njit(cache=True)
def passed_on(starts, columns, data, T, out):  # pragma: no cover
    """Add the sum over j of data_ij (T_i - T_j) to ``out``: of a matrix with rows of sum 0."""
    for i in range(len(starts) - 1):
        total = 0.0
        for s in range(starts[i], starts[i + 1]):
            total += data[s] * (T[i] - T[columns[s]])
        out[i] += total
