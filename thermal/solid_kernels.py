"""Compiled sums over the cells of solids.

Cells are taken ``BATCH`` at a time: arrays of cells have the cells of a batch as their last axis,
over which the innermost loops run, so that they become vector instructions. Cells that fill up the
last batch have no volume. A property is its ``Curve`` as arrays: knots, origins, coefficients.
"""

import numpy as np
from numba import njit

BATCH = 32


@njit(cache=True)
def conducted(dofs, metric, values, slopes, knots, origins, k, T, out):  # pragma: no cover
    """Subtract the integral of k(T) grad N_i . grad T from ``out``.

    dofs : (batches, n, BATCH); metric : (batches, q, 6, BATCH), xx yy zz yz xz xy of
    J^-1 J^-T det J times the weight; values : (q, n); slopes : (q, n, 3) on the reference cell
    """
    batches, n = dofs.shape[:2]
    d, p = np.empty((n, BATCH)), np.empty((n, BATCH))
    first, at, total = np.empty(BATCH), np.empty(BATCH), np.empty(BATCH)
    g, f = np.empty((3, BATCH)), np.empty((3, BATCH))
    piece = 0
    for e in range(batches):
        _load(dofs, e, T, first, d)
        p[:] = 0.0
        for q in range(len(values)):
            _interpolate(d, first, values[q], slopes[q], at, g)
            piece = _evaluate(knots, origins, k, at, piece)
            _flux(metric[e, q], g, at, f)
            for a in range(1, n):
                x, y, z = slopes[q, a, 0], slopes[q, a, 1], slopes[q, a, 2]
                for b in range(BATCH):
                    p[a, b] += x * f[0, b] + y * f[1, b] + z * f[2, b]
        # what the first node of a cell gets is what the others give, to round-off
        total[:] = 0.0
        for a in range(1, n):
            for b in range(BATCH):
                total[b] += p[a, b]
                out[dofs[e, a, b]] -= p[a, b]
        for b in range(BATCH):
            out[dofs[e, 0, b]] += total[b]


@njit(inline="always")
def _load(dofs, e, T, first, d):  # pragma: no cover
    """Temperatures of the first nodes, and differences of the others to them."""
    for b in range(BATCH):
        first[b] = T[dofs[e, 0, b]]
    for a in range(d.shape[0]):
        for b in range(BATCH):
            d[a, b] = T[dofs[e, a, b]] - first[b]


@njit(inline="always")
def _interpolate(d, first, values, slopes, at, g):  # pragma: no cover
    for b in range(BATCH):
        at[b] = first[b]
        g[0, b] = 0.0
        g[1, b] = 0.0
        g[2, b] = 0.0
    for a in range(1, d.shape[0]):
        v, x, y, z = values[a], slopes[a, 0], slopes[a, 1], slopes[a, 2]
        for b in range(BATCH):
            at[b] += v * d[a, b]
            g[0, b] += x * d[a, b]
            g[1, b] += y * d[a, b]
            g[2, b] += z * d[a, b]


@njit(inline="always")
def _flux(m, g, k, f):  # pragma: no cover
    for b in range(BATCH):
        f[0, b] = k[b] * (m[0, b] * g[0, b] + m[5, b] * g[1, b] + m[4, b] * g[2, b])
        f[1, b] = k[b] * (m[5, b] * g[0, b] + m[1, b] * g[1, b] + m[3, b] * g[2, b])
        f[2, b] = k[b] * (m[4, b] * g[0, b] + m[3, b] * g[1, b] + m[2, b] * g[2, b])


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
    """Replace temperatures by the value of a property."""
    for b in range(at.size):
        piece = _piece(knots, at[b], piece)
        at[b] = _horner(c[piece], at[b] - origins[piece])
    return piece


@njit(cache=True)
def property_at(knots, origins, c, T):  # pragma: no cover
    """(n,) values of a property, or of its slope or primitive by the coefficients c."""
    out = np.empty(len(T))
    piece = 0
    for i in range(len(T)):
        piece = _piece(knots, T[i], piece)
        out[i] = _horner(c[piece], T[i] - origins[piece])
    return out


@njit(cache=True)
def stored(dofs, mass, values, knots, origins, h, T, out):  # pragma: no cover
    """Add the integral of N_i h(T) to ``out``.

    mass : (batches, q, BATCH) float [kg]; h : primitive of the heat capacity
    """
    batches, n = dofs.shape[:2]
    d, p = np.empty((n, BATCH)), np.empty((n, BATCH))
    first, at = np.empty(BATCH), np.empty(BATCH)
    piece = 0
    for e in range(batches):
        _load(dofs, e, T, first, d)
        p[:] = 0.0
        for q in range(len(values)):
            _blend(d, first, values[q], at)
            piece = _evaluate(knots, origins, h, at, piece)
            for a in range(n):
                for b in range(BATCH):
                    p[a, b] += values[q, a] * mass[e, q, b] * at[b]
        for a in range(n):
            for b in range(BATCH):
                out[dofs[e, a, b]] += p[a, b]


@njit(inline="always")
def _blend(d, first, values, at):  # pragma: no cover
    for b in range(BATCH):
        at[b] = first[b]
    for a in range(1, d.shape[0]):
        for b in range(BATCH):
            at[b] += values[a] * d[a, b]


@njit(cache=True)
def add_capacity(dofs, mass, values, knots, origins, c, slots, T, data):  # pragma: no cover
    """Add the integral of N_i c(T) N_j to the entries ``data``, at ``slots_of`` the cells."""
    batches, n = dofs.shape[:2]
    d, m = np.empty((n, BATCH)), np.empty((n, n, BATCH))
    first, at = np.empty(BATCH), np.empty(BATCH)
    piece = 0
    for e in range(batches):
        _load(dofs, e, T, first, d)
        m[:] = 0.0
        for q in range(len(values)):
            _blend(d, first, values[q], at)
            piece = _evaluate(knots, origins, c, at, piece)
            for b in range(BATCH):
                at[b] *= mass[e, q, b]
            for i in range(n):
                for j in range(n):
                    v = values[q, i] * values[q, j]
                    for b in range(BATCH):
                        m[i, j, b] += v * at[b]
        _scatter(slots, e, m, data)


@njit(cache=True)
def add_conductance(
    dofs, metric, values, slopes, knots, origins, k, dk, slots, tau, T, data
):  # pragma: no cover
    """Add tau times the derivative of the integral of k(T) grad N_i . grad T to ``data``.

    Of the part with k half is summed, as it is symmetric, and of both parts what belongs to the
    first node follows from the others: gradients sum to 0 over the nodes, and values to 1.
    """
    batches, n = dofs.shape[:2]
    d, m, w = np.empty((n, BATCH)), np.empty((n, n, BATCH)), np.empty((n, n, BATCH))
    first, at, bend = np.empty(BATCH), np.empty(BATCH), np.empty(BATCH)
    g, f, r, u = (np.empty((3, BATCH)), np.empty((3, BATCH)), np.empty((3, BATCH)), np.empty(BATCH))
    piece = 0
    for e in range(batches):
        _load(dofs, e, T, first, d)
        m[:] = 0.0
        w[:] = 0.0
        for q in range(len(values)):
            _interpolate(d, first, values[q], slopes[q], at, g)
            bend[:] = at
            piece = _evaluate(knots, origins, dk, bend, piece)
            piece = _evaluate(knots, origins, k, at, piece)
            for b in range(BATCH):
                at[b] *= tau
                bend[b] *= tau
            _flux(metric[e, q], g, bend, f)
            for i in range(1, n):
                _row(slopes[q, i], metric[e, q], at, f, r, u)
                for j in range(i, n):
                    x, y, z = slopes[q, j, 0], slopes[q, j, 1], slopes[q, j, 2]
                    for b in range(BATCH):
                        m[i, j, b] += x * r[0, b] + y * r[1, b] + z * r[2, b]
                for b in range(BATCH):
                    w[i, 0, b] += u[b]
                for j in range(1, n):
                    v = values[q, j]
                    for b in range(BATCH):
                        w[i, j, b] += v * u[b]
        _complete(m, w)
        _scatter(slots, e, m, data)


@njit(inline="always")
def _complete(m, w):  # pragma: no cover
    """Fill up a symmetric matrix of row sums 0, and add w, whose first column is its row sums."""
    n = m.shape[0]
    for i in range(1, n):
        for j in range(1, i):
            m[i, j] = m[j, i]
    for i in range(1, n):
        for j in range(1, n):
            for b in range(BATCH):
                m[i, 0, b] -= m[i, j, b]
                m[0, i, b] -= m[j, i, b]
    for i in range(1, n):
        for b in range(BATCH):
            m[0, 0, b] -= m[i, 0, b]
    for i in range(1, n):
        for j in range(1, n):
            for b in range(BATCH):
                m[i, j, b] += w[i, j, b]
                m[0, j, b] -= w[i, j, b]
                w[i, 0, b] -= w[i, j, b]
        for b in range(BATCH):
            m[i, 0, b] += w[i, 0, b]
            m[0, 0, b] -= w[i, 0, b]


@njit(inline="always")
def _row(slope, m, k, f, r, u):  # pragma: no cover
    """k times the metric on the slope of a function, and its product with f."""
    x, y, z = slope[0], slope[1], slope[2]
    for b in range(BATCH):
        r[0, b] = k[b] * (m[0, b] * x + m[5, b] * y + m[4, b] * z)
        r[1, b] = k[b] * (m[5, b] * x + m[1, b] * y + m[3, b] * z)
        r[2, b] = k[b] * (m[4, b] * x + m[3, b] * y + m[2, b] * z)
        u[b] = x * f[0, b] + y * f[1, b] + z * f[2, b]


@njit(inline="always")
def _scatter(slots, e, m, data):  # pragma: no cover
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            for b in range(BATCH):
                data[slots[e, i, j, b]] += m[i, j, b]


@njit(cache=True)
def slots_of(dofs, starts, columns):  # pragma: no cover
    """(batches, n, n, BATCH) int32  where the pairs of nodes of each cell are in rows of a matrix.

    starts, columns : of the matrix, compressed by rows, columns rising
    """
    batches, n = dofs.shape[:2]
    slots = np.empty((batches, n, n, BATCH), np.int32)
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
