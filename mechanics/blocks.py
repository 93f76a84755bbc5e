"""Sparse factorisation by dense blocks, on an order of elimination that needs no pivoting.

The unknowns of a node are one block. Blocks are eliminated in order of least degree (Tinney &
Walker 1967), but a block without a diagonal of its own, such as the multipliers of a joint, only
after those neighbours that give it one: a constraint after the bodies that it holds, where its
pivot is -B S^-1 B^T with S positive definite; a massless coordinate after the constraints that
tie it (Vanderbei 1995, quasi-definite matrices). A postorder of the elimination tree keeps what
is needed together in memory (Liu 1990).

The front of a block is its rows of the upper triangle, n x (n + r) numbers: the block itself and
its r later neighbours. Eliminating it is a dense LDL^T of these rows, after which their products
are subtracted from the fronts of the neighbours (right-looking). An unsymmetric matrix has the
columns of the lower triangle beside them, transposed, and an LU with partial pivoting inside the
block.
"""

import heapq
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_array

from mechanics.kernels import FACTOR, SOLVE, kernel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LOST = 1e-14
"""A pivot smaller than this part of what its diagonal once was is nothing but round-off [-]."""

SIZE, WIDEST, RECORDS, LAST, PEAK, HEAD = range(6)
"""Start of ``ints``: unknowns, longest row, first and last record, place of peaks in work."""


class Blocks(NamedTuple):
    """Blocks of unknowns in order of elimination.

    members : unknowns of each block
    later : (k,) int  neighbours of each block that are eliminated after it, ascending
    """

    members: list[Indices]
    later: list[Indices]


# -- once: order and places ------------------------------------------------------------------------


def ranks(indptr: Indices, indices: Indices, massive: NDArray[np.bool_]) -> Indices:
    """Rank of each unknown: 0 with a mass, otherwise one more than the least of its neighbours'.

    Most multipliers have rank 1, a massless coordinate that they hold has rank 2, a constraint
    between such coordinates rank 3.
    """
    n = len(indptr) - 1
    column = np.repeat(np.arange(n), np.diff(indptr))
    rank = np.where(massive, 0, n)
    for step in range(1, n):
        fresh = np.zeros(n, bool)
        fresh[column[rank[indices] == step - 1]] = True
        fresh &= rank == n
        if not fresh.any():
            break
        rank[fresh] = step
    return rank


def arrange(indptr: Indices, indices: Indices, node_of: Indices, rank: Indices) -> Blocks:
    """Blocks of the unknowns of one node and one rank, and their order of elimination."""
    key = node_of * (int(rank.max()) + 1) + rank
    _, first, block = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(block, kind="stable")
    members = np.split(order, np.cumsum(np.bincount(block))[:-1])
    column = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    neighbours = _neighbours(block[indices], block[column], len(members))
    sizes = np.array([len(m) for m in members])
    elimination, later = _least_degree(neighbours, sizes, rank[first])
    return _postordered(members, elimination, later)


def _neighbours(row: Indices, column: Indices, count: int) -> list[set[int]]:
    graph = coo_array((np.ones(row.size, np.int8), (row, column)), shape=(count, count)).tocsr()
    graph = (graph + graph.T).tocsr()
    parts = np.split(graph.indices, graph.indptr[1:-1])
    return [set(part.tolist()) - {i} for i, part in enumerate(parts)]


def _least_degree(
    neighbours: list[set[int]], sizes: Indices, rank: Indices
) -> tuple[list[int], dict[int, set[int]]]:
    """Order of elimination, and the later neighbours of each block."""
    size = sizes.tolist()
    waits = [{j for j in near if rank[j] < rank[i]} for i, near in enumerate(neighbours)]
    release: list[list[int]] = [[] for _ in size]
    for i, held in enumerate(waits):
        for j in held:
            release[j].append(i)
    degree = [sum(size[j] for j in near) for near in neighbours]
    heap = [(degree[i], i) for i in range(len(size)) if not waits[i]]
    heapq.heapify(heap)
    order: list[int] = []
    later: dict[int, set[int]] = {}
    while heap:
        d, i = heapq.heappop(heap)
        if i in later or d != degree[i]:
            continue
        near = neighbours[i]
        order.append(i)
        later[i] = near
        for j in release[i]:
            waits[j].discard(i)
        for j in near:
            neighbours[j] |= near
            neighbours[j] -= {i, j}
            degree[j] = sum([size[k] for k in neighbours[j]])
            if not waits[j]:
                heapq.heappush(heap, (degree[j], j))
    return order, later


def _postordered(members: list[Indices], order: list[int], later: dict[int, set[int]]) -> Blocks:
    """The same elimination, each subtree of the elimination tree in one piece."""
    position = {block: k for k, block in enumerate(order)}
    children: dict[int, list[int]] = {}
    for block in order:
        parent = min(later[block], key=position.__getitem__, default=-1)
        children.setdefault(parent, []).append(block)
    found, stack = [], list(children.get(-1, []))
    while stack:
        block = stack.pop()
        found.append(block)
        stack += children.get(block, [])
    found.reverse()
    place = {block: k for k, block in enumerate(found)}
    return Blocks(
        [members[b] for b in found],
        [np.array(sorted(place[k] for k in later[b]), dtype=np.int64) for b in found],
    )


def lay_out(
    indptr: Indices, indices: Indices, blocks: Blocks, symmetric: bool
) -> tuple[Indices, int]:
    """Everything that the kernels need to know, and the size of their work array."""
    fronts = _Fronts(blocks, symmetric)
    size = len(indptr) - 1
    column = np.repeat(np.arange(size), np.diff(indptr))
    source, target = fronts.targets(np.asarray(indices), column)
    packed = np.sort((target << 32) | source)
    records: list[int] = []
    start, last = HEAD + size + packed.size, 0
    for j in range(len(blocks.members)):
        here = start + len(records)
        records += [last, *fronts.record(j)]
        last = here
    widest = int(fronts.width.max())
    head = np.zeros(HEAD, np.int64)
    head[[SIZE, WIDEST, RECORDS, LAST, PEAK]] = size, widest, start, last, fronts.end
    ints = np.concatenate([head, np.concatenate(blocks.members), packed, records])
    return ints.astype(np.int64), fronts.end + 4 * size + 2 * widest


class _Fronts:
    """Where every entry of every front stands in the work array."""

    def __init__(self, blocks: Blocks, symmetric: bool):
        self.later = blocks.later
        self.size = np.array([len(m) for m in blocks.members])
        self.rest = np.array([int(self.size[later].sum()) for later in blocks.later])
        self.width = self.size + self.rest
        self.first = np.cumsum(self.size) - self.size
        upper = self.size * self.width
        lower = np.zeros_like(upper) if symmetric else self.size * self.rest
        self.upper = np.cumsum(upper + lower) - upper - lower
        self.lower = self.upper + upper
        self.end = int((upper + lower).sum())
        self.symmetric = symmetric
        self.column = [self._columns(j) for j in range(len(self.size))]
        self.place = np.empty(int(self.size.sum()), np.int64)
        self.place[np.concatenate(blocks.members)] = np.arange(self.place.size)

    def _columns(self, j: int) -> dict[int, int]:
        """Column in front j at which each block begins."""
        blocks = [j, *self.later[j].tolist()]
        starts = np.cumsum([0, *self.size[blocks]])
        return dict(zip(blocks, starts.tolist(), strict=False))

    def targets(self, row: Indices, column: Indices) -> tuple[Indices, Indices]:
        """Data entries that are used, and their places in the work array."""
        owner = np.repeat(np.arange(len(self.size)), self.size)
        row, column = self.place[row], self.place[column]
        low, high = np.minimum(row, column), np.maximum(row, column)
        front, other = owner[low], owner[high]
        columns = self._column_of(front, other) + high - self.first[other]
        local = low - self.first[front]
        target = self.upper[front] + local * self.width[front] + columns
        if self.symmetric:
            used = row <= column
            return np.flatnonzero(used), target[used]
        inside, below = front == other, row > column
        target = np.where(
            inside,
            self.upper[front]
            + (row - self.first[front]) * self.width[front]
            + (column - self.first[front]),
            target,
        )
        lower = self.lower[front] + local * self.rest[front] + columns - self.size[front]
        target = np.where(below & ~inside, lower, target)
        return np.arange(row.size), target

    def _column_of(self, front: Indices, other: Indices) -> Indices:
        count = len(self.size)
        keys = [j * count + k for j, columns in enumerate(self.column) for k in columns]
        starts = [c for columns in self.column for c in columns.values()]
        return np.array(starts)[np.searchsorted(keys, front * count + other)]

    def record(self, j: int) -> list[int]:
        """What eliminating block j needs: its front, runs of later unknowns, and where its
        products go: of each later block the rows of its front and runs of their columns.
        """
        later = self.later[j].tolist()
        runs = _runs([(int(self.size[k]), int(self.first[k])) for k in later])
        body = [len(runs), *(x for run in runs for x in run), len(later)]
        for a, block in enumerate(later):
            columns = self.column[block]
            into = _runs([(int(self.size[k]), columns[k]) for k in later[a:]])
            body += [self.size[block], self.upper[block], self.width[block], self.lower[block]]
            body += [self.first[block], len(into), *(x for run in into for x in run)]
        head = [self.size[j], self.rest[j], self.upper[j], self.lower[j], self.first[j]]
        return [int(x) for x in (*head, *body)]


def _runs(pieces: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Pieces (length, start) with those that follow one another joined."""
    runs: list[tuple[int, int]] = []
    for length, start in pieces:
        if runs and sum(runs[-1]) == start:
            runs[-1] = runs[-1][0] + length, runs[-1][1]
        else:
            runs.append((length, start))
    return runs


# -- numbers ---------------------------------------------------------------------------------------


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
def _dot(a, b):
    n = len(a)
    s, t, u, v = 0.0, 0.0, 0.0, 0.0
    for k in range(0, n - 3, 4):
        s += a[k] * b[k]
        t += a[k + 1] * b[k + 1]
        u += a[k + 2] * b[k + 2]
        v += a[k + 3] * b[k + 3]
    for k in range(n - n % 4, n):
        s += a[k] * b[k]
    return (s + t) + (u + v)


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


def factor_symmetric(ints, data, work):
    """LDL^T of a symmetric matrix, of which the upper triangle is read."""
    _load(ints, data, work)
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    spare = peak + 4 * size
    f, values = work[spare : spare + widest], work[spare + widest : spare + 2 * widest]
    while at < len(ints):
        n, r, start, first = ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 5]
        w = n + r
        front, inverse = work[start : start + n * w], work[peak + size + first :]
        if _eliminate(front, n, w, f, inverse, work[peak + first :]):
            return 1
        at += 7 + 2 * ints[at + 6]
        count, i = ints[at], 0
        at += 1
        for _ in range(count):
            rows, base, width = ints[at], ints[at + 1], ints[at + 2]
            for k in range(rows):
                for j in range(n):
                    f[j] = front[j * w + n + i] * inverse[j]
                values[: r - i] = 0.0
                _subtract(values[: r - i], f, front[n + i :], w, n)
                row = base + k * width
                _note(work, peak + ints[at + 4] + k, row + k)
                _spread(ints, at + 6, ints[at + 5], k, values, work[row : row + width])
                i += 1
            at += 6 + 2 * ints[at + 5]
    return 0


@njit(cache=True, error_model="numpy")
def _pivoted(front, n, w, inverse, peak, swap):
    """LU of a front in place with partial pivoting inside its block; True if a pivot is lost."""
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
                values[: r - begin] = 0.0
                _subtract(values[: r - begin], f, front[n + begin :], w, n)
                row = ints[at + 1] + k * ints[at + 2]
                _note(work, peak + ints[at + 4] + k, row + k)
                _spread(ints, at + 6, ints[at + 5], 0, values, work[row:])
                for j in range(n):
                    f[j] = front[j * w + n + i]
                values[: r - end] = 0.0
                _subtract(values[: r - end], f, lower[end:], r, n)
                row = ints[at + 3] + k * (ints[at + 2] - rows) - rows
                _spread(ints, at + 6, ints[at + 5], rows, values, work[row:])
                i += 1
            at += 6 + 2 * ints[at + 5]
    return 0


@njit(cache=True, error_model="numpy")
def _back(front, n, w, inverse, own, values):
    """Unknowns of a block from the later ones, which are values[n:]."""
    for i in range(n - 1, -1, -1):
        after = _dot(front[i * w + i + 1 : i * w + w], values[i + 1 : w])
        values[i] = (own[i] - after) * inverse[i]
        own[i] = values[i]


@njit(cache=True, error_model="numpy")
def _backward(ints, work, x, values):
    """Second half of a solution: blocks in reverse order."""
    size, peak, at = ints[SIZE], ints[PEAK], ints[LAST]
    while at > 0:
        n, r, start, first = ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 5]
        k = n
        for s in range(ints[at + 6]):
            length, begin = ints[at + 7 + 2 * s], ints[at + 8 + 2 * s]
            part = x[begin : begin + length]
            for i in range(length):
                values[k + i] = part[i]
            k += length
        inverse = work[peak + size + first :]
        _back(work[start : start + n * (n + r)], n, n + r, inverse, x[first : first + n], values)
        at = ints[at]


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


def solve_symmetric(ints, work, b):
    """Solution with the factors of ``factor_symmetric``."""
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    x, spare = work[peak + 3 * size : peak + 4 * size], peak + 4 * size
    f, values = work[spare : spare + widest], work[spare + widest : spare + 2 * widest]
    for i in range(size):
        x[i] = b[ints[HEAD + i]]
    while at < len(ints):
        n, r, start, first = ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 5]
        w = n + r
        front, inverse, own = work[start : start + n * w], work[peak + size + first :], x[first:]
        for i in range(n):
            f[i] = own[i] * inverse[i]
            for k in range(i + 1, n):
                own[k] -= front[i * w + k] * f[i]
        values[:r] = 0.0
        _subtract(values[:r], f, front[n:], w, n)
        _drop(ints, at, values, x)
        at = _after(ints, at)
    _backward(ints, work, x, values)
    for i in range(size):
        b[ints[HEAD + i]] = x[i]


def solve_general(ints, work, b):
    """Solution with the factors of ``factor_general``."""
    size, widest, at, peak = ints[SIZE], ints[WIDEST], ints[RECORDS], ints[PEAK]
    x, spare = work[peak + 3 * size : peak + 4 * size], peak + 4 * size
    values = work[spare + widest : spare + 2 * widest]
    for i in range(size):
        x[i] = b[ints[HEAD + i]]
    while at < len(ints):
        n, r, start, below, first = (
            ints[at + 1], ints[at + 2], ints[at + 3], ints[at + 4], ints[at + 5],
        )  # fmt: skip
        w, own = n + r, x[first : first + n]
        front, swap = work[start : start + n * w], work[peak + 2 * size + first :]
        for i in range(n):
            k = int(swap[i])
            own[i], own[k] = own[k], own[i]
        for i in range(n):
            own[i] -= _dot(front[i * w : i * w + i], own[:i])
        values[:r] = 0.0
        _subtract(values[:r], own, work[below : below + n * r], r, n)
        _drop(ints, at, values, x)
        at = _after(ints, at)
    _backward(ints, work, x, values)
    for i in range(size):
        b[ints[HEAD + i]] = x[i]


@cache
def kernels(symmetric: bool) -> tuple[int, int]:
    """Addresses of factor and solve, compiled when they are first asked for."""
    if symmetric:
        return kernel(FACTOR)(factor_symmetric), kernel(SOLVE)(solve_symmetric)
    return kernel(FACTOR)(factor_general), kernel(SOLVE)(solve_general)
