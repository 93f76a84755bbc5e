"""Compiled kernels of ``mechanics.springs``: lines through material points, and turns of hinges.

A line runs through points x_p that are sums of vectors of the coordinates and a constant. Its
length l is the sum of those of its segments, with unit vectors n_s. The tension T does the work
T dl, so that the force on x_p is T dl/dx_p = T (n_{p-1} - n_p).

ints : kind (SPRING, ROPE), number of points, first coordinate of W vectors of each point (-1)
floats : stiffness, damping, length free of force, preload, reference length; a constant (3,) of
    each point; W weights of each point
coef : SPRING: force of an actuator [N]; ROPE: rope paid out [m] and its rate [m/s]
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, TANGENT, kernel

SPRING, ROPE = 0, 1
LAW = 5


@njit(cache=True, error_model="numpy")
def _points(y, ints, floats, width, x):
    """Sums of vectors (without the constants) of each point."""
    count = ints[1]
    x[:] = 0.0
    for p in range(count):
        for j in range(width):
            at = ints[2 + width * p + j]
            if at >= 0:
                weight = floats[LAW + 3 * x.shape[0] + width * p + j]
                for i in range(3):
                    x[p, i] += weight * y[at + i]


@njit(cache=True, error_model="numpy")
def _path(y, v, ints, floats, width, x, u, n, size, b):
    """Points x, velocities u, units n and lengths of the segments, b = dl/dx; length and rate."""
    _points(y, ints, floats, width, x)
    _points(v, ints, floats, width, u)
    count, length, rate = ints[1], 0.0, 0.0
    for p in range(count):
        for i in range(3):
            x[p, i] += floats[LAW + 3 * p + i]
            b[p, i] = 0.0
    for s in range(count - 1):
        square = 0.0
        for i in range(3):
            n[s, i] = x[s + 1, i] - x[s, i]
            square += n[s, i] * n[s, i]
        size[s] = np.sqrt(square)
        length += size[s]
        for i in range(3):
            n[s, i] /= size[s]
            b[s, i] -= n[s, i]
            b[s + 1, i] += n[s, i]
            rate += n[s, i] * (u[s + 1, i] - u[s, i])
    return length, rate


@njit(cache=True, error_model="numpy")
def _law(kind, length, rate, floats, coef):
    """Tension, its derivatives by length and rate; stored energy, power lost and on free length."""
    k, c, free, preload, reference = floats[0], floats[1], floats[2], floats[3], floats[4]
    if kind == SPRING:
        stored = 0.5 * k * (length - free) ** 2 + preload * (length - reference)
        tension = k * (length - free) + c * rate + preload + coef[0]
        return tension, k, c, stored, c * rate * rate, 0.0
    free, growth = free + coef[0], coef[1]
    if length <= free:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    elastic = k * (length - free) / free
    stretching = rate - length * growth / free  # strain rate times the free length
    tension = elastic + c * stretching / free
    slope, viscous = (k - c * growth / free) / free, c / free
    if tension <= 0.0:
        tension, slope, viscous = 0.0, 0.0, 0.0
    excess = tension - elastic
    stored = 0.5 * elastic * (length - free)
    return tension, slope, viscous, stored, excess * stretching, excess * length * growth / free


@njit(cache=True, error_model="numpy")
def _counts(ints, floats):
    """Points and vectors of each for which there is room in a row."""
    points = (floats.shape[1] - LAW - ints.shape[1] + 2) // 3
    return points, (ints.shape[1] - 2) // points


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    points, width = _counts(ints, floats)
    work = np.empty((4, points, 3))
    x, u, b, n = work[0], work[1], work[2], work[3]
    size = np.empty(points)
    for e in range(ints.shape[0]):
        length, rate = _path(y, v, ints[e], floats[e], width, x, u, n, size, b)
        tension = _law(ints[e, 0], length, rate, floats[e], coef[e])[0]
        for p in range(ints[e, 1]):
            for j in range(width):
                at = ints[e, 2 + width * p + j]
                if at >= 0:
                    weight = tension * floats[e, LAW + 3 * points + width * p + j]
                    for i in range(3):
                        out[at + i] += weight * b[p, i]


@njit(cache=True, error_model="numpy")
def _turning(count, u, n, size, turning):
    """d(rate)/dx of each point: how the segments turn."""
    turning[:] = 0.0
    for s in range(count - 1):
        along = 0.0
        for i in range(3):
            along += n[s, i] * (u[s + 1, i] - u[s, i])
        for i in range(3):
            across = (u[s + 1, i] - u[s, i] - along * n[s, i]) / size[s]
            turning[s, i] -= across
            turning[s + 1, i] += across


@njit(cache=True, error_model="numpy")
def _bend(count, n, size, p, q, i, j):
    """d2l/dx_p,i dx_q,j."""
    found = 0.0
    for s in range(max(p - 1, 0), min(p + 1, count - 1)):
        if q == s or q == s + 1:
            sign = 1.0 if p == q else -1.0
            found += sign * ((1.0 if i == j else 0.0) - n[s, i] * n[s, j]) / size[s]
    return found


@njit(cache=True, error_model="numpy")
def _scatter(B, p, q, points, width, ints, floats, slots, data):
    """Add the block of points p and q to those of their vectors."""
    k, first = 3 * points * width, LAW + 3 * points
    for a in range(width * p, width * p + width):
        for b in range(width * q, width * q + width):
            if ints[2 + a] >= 0 and ints[2 + b] >= 0:
                weight = floats[first + a] * floats[first + b]
                for i in range(3):
                    for j in range(3):
                        data[slots[k * (3 * a + i) + 3 * b + j]] += weight * B[i, j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    points, width = _counts(ints, floats)
    work = np.empty((4, points, 3))
    x, u, b, n = work[0], work[1], work[2], work[3]
    size, B = np.empty(points), np.empty((3, 3))
    turning = np.empty((points, 3))
    for e in range(ints.shape[0]):
        count = ints[e, 1]
        length, rate = _path(y, v, ints[e], floats[e], width, x, u, n, size, b)
        law = _law(ints[e, 0], length, rate, floats[e], coef[e])
        _turning(count, u, n, size, turning)
        for p in range(count):
            for q in range(count):
                for i in range(3):
                    for j in range(3):
                        B[i, j] = cK * law[0] * _bend(count, n, size, p, q, i, j)
                        slope = (cK * law[1] + cC * law[2]) * b[q, j]
                        B[i, j] += b[p, i] * (slope + cK * law[2] * turning[q, j])
                _scatter(B, p, q, points, width, ints[e], floats[e], slots[e], data)


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    points, width = _counts(ints, floats)
    work = np.empty((4, points, 3))
    x, u, b, n = work[0], work[1], work[2], work[3]
    size = np.empty(points)
    for e in range(ints.shape[0]):
        length, rate = _path(y, v, ints[e], floats[e], width, x, u, n, size, b)
        law = _law(ints[e, 0], length, rate, floats[e], coef[e])
        out[0] += law[3]
        out[1] += law[4]
        out[2] += law[5]


@kernel(FORCE)
def add_turning_force(y, v, coef, ints, floats, out):
    """Stiffness, damping, angle free of moment and preload on the turn ints[:, 0]."""
    for e in range(ints.shape[0]):
        at, k, c = ints[e, 0], floats[e, 0], floats[e, 1]
        out[at] += k * (y[at] - floats[e, 2]) + c * v[at] - floats[e, 3] - coef[e, 0]


@kernel(TANGENT)
def add_turning_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    for e in range(ints.shape[0]):
        data[slots[e, 0]] += cK * floats[e, 0] + cC * floats[e, 1]


@kernel(ENERGY)
def add_turning_energy(y, v, coef, ints, floats, out):
    for e in range(ints.shape[0]):
        turn, rate = y[ints[e, 0]], v[ints[e, 0]]
        out[0] += 0.5 * floats[e, 0] * (turn - floats[e, 2]) ** 2 - floats[e, 3] * turn
        out[1] += floats[e, 1] * rate * rate
