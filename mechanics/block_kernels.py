"""Sparse factorisation by dense blocks, in the order of ``mechanics.blocks``.

The front of a block is its rows of the upper triangle, n x (n + r) numbers: the block itself and
its r later neighbours. Eliminating it is a dense LDL^T of these rows, after which their products
are subtracted from the fronts of the neighbours (right-looking). An unsymmetric matrix has the
columns of the lower triangle beside them, transposed, and an LU with partial pivoting inside the
block.

The integers are: a head; the unknowns in order of elimination; for each entry of the matrix its
place in the work array and in the data; a record for each block. A record is: the place of the
record before; n, r, places of front and lower columns, first unknown; number of runs of later
unknowns, and length and start of each; number of later blocks, and of each its rows, front, width,
lower columns, first unknown, and runs of columns of its front.
"""

from functools import cache

import numpy as np
from numba import njit

from mechanics.kernels import FACTOR, SOLVE, kernel
from mechanics.lane_products import BEYOND, ROWS, combine, combine_two, dots

LOST = 1e-14
"""A pivot smaller than this part of what its diagonal once was is nothing but round-off [-]."""

STRIP, WIDE = 32, 128
"""Columns of a strip, and rows of a block that is eliminated by strips [-]."""

SIZE, WIDEST, RECORDS, LAST, PEAK, HEAD = range(6)
"""Start of ``ints``: unknowns, longest row, first and last record, place of peaks in work."""


@njit(cache=True, error_model="numpy")
def _subtract(out, factors, rows, stride, count):
    """out -= sum over j of factors[j] rows[j stride:]."""
    n, j = len(out), 0
    while j + 4 <= count:
        p, q, r, s = factors[j], factors[j + 1], factors[j + 2], factors[j + 3]
        at = j * stride
        a, b = rows[at : at + n], rows[at + stride : at + stride + n]
        c = rows[at + 2 * stride : at + 2 * stride + n]
        d = rows[at + 3 * stride : at + 3 * stride + n]
        for k in range(n):
            out[k] -= p * a[k] + q * b[k] + r * c[k] + s * d[k]
        j += 4
    while j < count:
        p, at = factors[j], j * stride
        a = rows[at : at + n]
        for k in range(n):
            out[k] -= p * a[k]
        j += 1


@njit(cache=True, error_model="numpy")
def _load(ints, data, work):
    """Put the matrix into the fronts, and note the size of the diagonal."""
    work[: ints[PEAK] + ints[SIZE]] = 0.0
    packed = ints[HEAD + ints[SIZE] : ints[RECORDS]]
    for i in range(len(packed)):
        work[packed[i] >> 32] = data[packed[i] & 0xFFFFFFFF]


@njit(cache=True, error_model="numpy")
def _spread(ints, at, count, skip, values, row):
    """Add ``values`` to the runs of columns of a row, from ``skip`` columns on."""
    k = 0
    for s in range(count):
        length, column = ints[at + 2 * s] - skip, ints[at + 2 * s + 1] + skip
        target, part = row[column : column + length], values[k : k + length]
        for i in range(length):
            target[i] += part[i]
        k += length
        skip = 0


@njit(cache=True, error_model="numpy")
def _note(work, peak, at):
    work[peak] = max(work[peak], abs(work[at]))


@njit(cache=True, error_model="numpy")
def _eliminate(front, n, w, f, inverse, peak):
    """LDL^T of a front in place; True if a pivot is lost."""
    for i in range(n):
        for j in range(i):
            f[j] = front[j * w + i] * inverse[j]
        peak[i] = max(peak[i], abs(front[i * w + i]))
        _subtract(front[i * w + i : i * w + w], f, front[i:], w, i)
        pivot = front[i * w + i]
        if not abs(pivot) > LOST * peak[i]:
            return True
        inverse[i] = 1.0 / pivot
    return False


@njit(cache=True, error_model="numpy")
def _pivoted_wide(front, n, w, inverse, peak, swap):
    """What ``_pivoted`` does for a wide block, strip by strip of its columns."""
    for start in range(0, n, STRIP):
        end = min(start + STRIP, n)
        for i in range(start, end):
            best = i
            for k in range(i + 1, n):
                if abs(front[k * w + i]) > abs(front[best * w + i]):
                    best = k
            swap[i] = best
            if best != i:
                for k in range(w):
                    front[i * w + k], front[best * w + k] = front[best * w + k], front[i * w + k]
            pivot = front[i * w + i]
            if not abs(pivot) > LOST * peak[i]:
                return True
            inverse[i] = 1.0 / pivot
            row = front[i * w + i + 1 : i * w + end]
            for k in range(i + 1, n):
                f = front[k * w + i] * inverse[i]
                front[k * w + i] = f
                below = front[k * w + i + 1 : k * w + end]
                for c in range(len(row)):
                    below[c] -= f * row[c]
        for i in range(start + 1, n):
            known = front[i * w + start : i * w + end]
            rest, count = front[i * w + end : i * w + w], min(i, end) - start
            _subtract(rest, known, front[start * w + end :], w, count)
    return False


@njit(cache=True, error_model="numpy")
def _pivoted(front, n, w, inverse, peak, swap):
    """LU of a front in place with partial pivoting inside its block; True if a pivot is lost."""
    if n > WIDE:
        return _pivoted_wide(front, n, w, inverse, peak, swap)
    for i in range(n):
        best = i
        for k in range(i + 1, n):
            if abs(front[k * w + i]) > abs(front[best * w + i]):
                best = k
        swap[i] = best
        if best != i:
            for k in range(w):
                front[i * w + k], front[best * w + k] = front[best * w + k], front[i * w + k]
        pivot = front[i * w + i]
        if not abs(pivot) > LOST * peak[i]:
            return True
        inverse[i] = 1.0 / pivot
        row = front[i * w + i + 1 : i * w + w]
        for k in range(i + 1, n):
            f = front[k * w + i] * inverse[i]
            front[k * w + i] = f
            below = front[k * w + i + 1 : k * w + w]
            for c in range(len(row)):
                below[c] -= f * row[c]
    return False


@njit(cache=True, error_model="numpy")
def _columns(lower, front, n, w, f, inverse):
    """Columns of L below a block: A U^-1, transposed."""
    r = w - n
    for i in range(n):
        for j in range(i):
            f[j] = front[j * w + i]
        row = lower[i * r : i * r + r]
        _subtract(row, f, lower, r, i)
        for k in range(r):
            row[k] *= inverse[i]


@njit(cache=True, error_model="numpy")
def _pivoted_symmetric(front, lower, n, w, f, inverse, peak, swap):
    """LU of a block that holds constraints: its lower half is that of the upper one."""
    r = w - n
    for i in range(n):
        peak[i] = max(peak[i], abs(front[i * w + i]))
        for k in range(i):
            front[i * w + k] = front[k * w + i]
        lower[i * r : i * r + r] = front[i * w + n : i * w + w]
    if _pivoted(front, n, w, inverse, peak, swap):
        return True
    _columns(lower, front, n, w, f, inverse)
    return False


@njit(cache=True, error_model="numpy")
def _multipliers(front, lower, n, w, i, below, inverse, f):
    """Column i of L below a block."""
    for j in range(n):
        f[j] = front[j * w + n + i] * inverse[j] if below < 0 else lower[j * (w - n) + i]


def factor_symmetric(ints, data, work):
    """LDL^T of a symmetric matrix, of which the upper triangle is read."""
    _load(ints, data, work)
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    spare = peak + 4 * size
    f, values = work[spare : spare + widest], work[spare + widest : spare + 2 * widest]
    g, more = work[spare + 2 * widest : spare + 3 * widest], work[spare + 3 * widest :]
    while at < len(ints):
        n, r, start, below, first = (
            ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 4], ints[at + 5],
        )  # fmt: skip
        w = n + r
        front, inverse = work[start : start + n * w], work[peak + size + first :]
        lower, swap = work[max(below, 0) :], work[peak + 2 * size + first :]
        if below < 0:
            lost = _eliminate(front, n, w, f, inverse, work[peak + first :])
        else:
            peaks = work[peak + first :]
            lost = _pivoted_symmetric(front, lower, n, w, f, inverse, peaks, swap)
        if lost:
            return 1
        at += 7 + 2 * ints[at + 6]
        count, i = ints[at], 0
        at += 1
        for _ in range(count):
            rows, base, width = ints[at], ints[at + 1], ints[at + 2]
            k = 0
            while k < rows:
                pair = k + 1 < rows
                _multipliers(front, lower, n, w, i, below, inverse, f)
                if pair:
                    _multipliers(front, lower, n, w, i + 1, below, inverse, g)
                    combine_two(values, more, f, g, front[n + i :], w, r - i, n)
                else:
                    combine(values, f, front[n + i :], w, r - i, n)
                row = base + k * width
                _note(work, peak + ints[at + 4] + k, row + k)
                _spread(ints, at + 6, ints[at + 5], k, values, work[row : row + width])
                if pair:
                    k, row = k + 1, row + width
                    _note(work, peak + ints[at + 4] + k, row + k)
                    _spread(ints, at + 6, ints[at + 5], k, more[1:], work[row : row + width])
                    i += 1
                i, k = i + 1, k + 1
            at += 6 + 2 * ints[at + 5]
    return 0


def factor_general(ints, data, work):
    """LU of a matrix, pivoting inside blocks only."""
    _load(ints, data, work)
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    spare = peak + 4 * size
    f, values = work[spare : spare + widest], work[spare + widest : spare + 2 * widest]
    while at < len(ints):
        n, r, start, below, first = (
            ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 4], ints[at + 5],
        )  # fmt: skip
        w = n + r
        front, lower = work[start : start + n * w], work[below : below + n * r]
        inverse, swap = work[peak + size + first :], work[peak + 2 * size + first :]
        for i in range(n):
            _note(work, peak + first + i, start + i * w + i)
        if _pivoted(front, n, w, inverse, work[peak + first :], swap):
            return 1
        _columns(lower, front, n, w, f, inverse)
        at += 7 + 2 * ints[at + 6]
        count, i = ints[at], 0
        at += 1
        for _ in range(count):
            rows, begin = ints[at], i
            end = begin + rows
            for k in range(rows):
                for j in range(n):
                    f[j] = lower[j * r + i]
                combine(values, f, front[n + begin :], w, r - begin, n)
                row = ints[at + 1] + k * ints[at + 2]
                _note(work, peak + ints[at + 4] + k, row + k)
                _spread(ints, at + 6, ints[at + 5], 0, values, work[row:])
                for j in range(n):
                    f[j] = front[j * w + n + i]
                combine(values, f, lower[end:], r, r - end, n)
                row = ints[at + 3] + k * (ints[at + 2] - rows) - rows
                _spread(ints, at + 6, ints[at + 5], rows, values, work[row:])
                i += 1
            at += 6 + 2 * ints[at + 5]
    return 0


@njit(cache=True, error_model="numpy")
def _back(front, n, w, inverse, own, values, spare):
    """Unknowns of a block from the later ones, which are values[n:]."""
    r = w - n
    whole = n - n % ROWS
    values[w : w + BEYOND] = 0.0
    for i in range(0, whole, ROWS):
        dots(front[i * w + n :], w, values[n:], r, spare[i:])
    for i in range(whole, n):
        s = 0.0
        for k in range(r):
            s += front[i * w + n + k] * values[n + k]
        spare[i] = s
    for i in range(n):
        own[i] -= spare[i]
    for k in range(n - 1, -1, -1):
        own[k] *= inverse[k]
        for i in range(k):
            own[i] -= front[i * w + k] * own[k]


@njit(cache=True, error_model="numpy")
def _backward(ints, at, work, x, f, values):
    """Second half of a solution, one block."""
    size, peak = ints[SIZE], ints[PEAK]
    n, r, start, first = ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 5]
    k = n
    for s in range(ints[at + 6]):
        length, begin = ints[at + 7 + 2 * s], ints[at + 8 + 2 * s]
        part = x[begin : begin + length]
        for i in range(length):
            values[k + i] = part[i]
        k += length
    inverse = work[peak + size + first :]
    _back(work[start : start + n * (n + r)], n, n + r, inverse, x[first : first + n], values, f)


@njit(cache=True, error_model="numpy")
def _drop(ints, at, values, x):
    """Add what a block sends to the right-hand sides of later ones."""
    k = 0
    for s in range(ints[at + 6]):
        length, begin = ints[at + 7 + 2 * s], ints[at + 8 + 2 * s]
        part = x[begin : begin + length]
        for i in range(length):
            part[i] += values[k + i]
        k += length


@njit(cache=True, error_model="numpy")
def _after(ints, at):
    """The record that follows."""
    at += 7 + 2 * ints[at + 6]
    count = ints[at]
    at += 1
    for _ in range(count):
        at += 6 + 2 * ints[at + 5]
    return at


@njit(cache=True, error_model="numpy")
def _swapped(front, lower, n, w, swap, own, values):
    """Forward substitution with the LU of a block."""
    for i in range(n):
        k = int(swap[i])
        own[i], own[k] = own[k], own[i]
    for i in range(1, n):
        s = 0.0
        for k in range(i):
            s += front[i * w + k] * own[k]
        own[i] -= s
    combine(values, own, lower, w - n, w - n, n)


@njit(cache=True, error_model="numpy")
def _scaled(front, n, w, inverse, own, f, values):
    """Forward substitution with the LDL^T of a block."""
    for i in range(n):
        f[i] = own[i] * inverse[i]
        for k in range(i + 1, n):
            own[k] -= front[i * w + k] * f[i]
    combine(values, f, front[n:], w, w - n, n)


@njit(cache=True, error_model="numpy")
def _forward(ints, at, work, x, f, values):
    """First half of a solution, one block."""
    size, peak = ints[SIZE], ints[PEAK]
    n, r, start, below, first = (
        ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 4], ints[at + 5],
    )  # fmt: skip
    w, own, front = n + r, x[first:], work[start : start + n * (n + r)]
    if below < 0:
        _scaled(front, n, w, work[peak + size + first :], own, f, values)
    else:
        _swapped(front, work[below:], n, w, work[peak + 2 * size + first :], own, values)
    _drop(ints, at, values, x)


def solve(ints, work, b):
    """Solution with the factors of ``factor_symmetric`` or ``factor_general``."""
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    x, spare = work[peak + 3 * size : peak + 4 * size], peak + 4 * size
    f, values = work[spare : spare + widest], work[spare + widest : spare + 2 * widest]
    for i in range(size):
        x[i] = b[ints[HEAD + i]]
    while at < len(ints):
        _forward(ints, at, work, x, f, values)
        at = _after(ints, at)
    at = ints[LAST]
    while at > 0:
        _backward(ints, at, work, x, f, values)
        at = ints[at]
    for i in range(size):
        b[ints[HEAD + i]] = x[i]


@njit(cache=True, error_model="numpy")
def solve_many(ints, work, b):
    """Solutions of several right-hand sides (k, n) at once: each front is fetched once for all."""
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    x, spare = np.empty(b.shape), peak + 4 * size
    f, values = work[spare : spare + widest], work[spare + widest : spare + 2 * widest]
    for j in range(len(b)):
        for i in range(size):
            x[j, i] = b[j, ints[HEAD + i]]
    while at < len(ints):
        for j in range(len(b)):
            _forward(ints, at, work, x[j], f, values)
        at = _after(ints, at)
    at = ints[LAST]
    while at > 0:
        for j in range(len(b)):
            _backward(ints, at, work, x[j], f, values)
        at = ints[at]
    for j in range(len(b)):
        for i in range(size):
            b[j, ints[HEAD + i]] = x[j, i]


@cache
def kernels(symmetric: bool) -> tuple[int, int]:
    """Addresses of factor and solve, compiled when they are first asked for."""
    return kernel(FACTOR)(factor_symmetric if symmetric else factor_general), kernel(SOLVE)(solve)
