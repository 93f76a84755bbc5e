"""Order of elimination of blocks of unknowns that needs no pivoting.

The unknowns of a node are one block. Blocks are eliminated in order of least degree (Tinney &
Walker 1967), but a block without a diagonal of its own, such as the multipliers of a joint, only
after those neighbours that give it one: a constraint after the bodies that it holds, where its
pivot is -B S^-1 B^T with S positive definite; a massless coordinate after the constraints that
tie it (Vanderbei 1995, quasi-definite matrices). Of solids, nodes come in clusters, which are
eliminated in stages (nested dissection), and a face that a reference point ties is one cluster with
what ties it, in which pivots are sought. A postorder of the elimination tree keeps what is needed
together in memory (Liu 1990).

What is made here once, for ``mechanics.block_kernels``, is one array of integers: the order, where
each entry of the matrix goes, and a record for each block.
"""

import heapq
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from mechanics.assembly import Pattern
from mechanics.block_kernels import HEAD, LAST, PEAK, RECORDS, SIZE, WIDEST
from mechanics.lane_products import BEYOND

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


CLUSTER = 24
"""A block with more massive unknowns than that is a cluster of nodes [-]."""


class Blocks(NamedTuple):
    """Blocks of unknowns in order of elimination.

    members : unknowns of each block
    mixed : whether a block holds coordinates and constraints
    later : (k,) int  neighbours of each block that are eliminated after it, ascending
    """

    members: list[Indices]
    mixed: NDArray[np.bool_]
    later: list[Indices]


def ranks(pattern: Pattern, massive: NDArray[np.bool_]) -> Indices:
    """Rank of each unknown: 0 with a mass, otherwise one more than the least of its neighbours'.

    Most multipliers have rank 1, a massless coordinate that they hold has rank 2, a constraint
    between such coordinates rank 3.
    """
    n, indices = pattern.size, pattern.indices
    column = _columns(pattern)
    rank = np.where(massive, 0, n)
    for step in range(1, n):
        fresh = np.zeros(n, bool)
        fresh[column[rank[indices] == step - 1]] = True
        fresh &= rank == n
        if not fresh.any():
            break
        rank[fresh] = step
    return rank


def arrange(
    pattern: Pattern, node_of: Indices, rank: Indices, stage: Indices | None = None
) -> Blocks:
    """Blocks of the unknowns of one node and one rank, and their order of elimination.

    Constraints of one node alone, such as those of a rigid body, join its block: with them its
    mass may be singular, as that of a flat plate or a rod is in directors. Clusters keep all that
    has their number. Blocks of a later ``stage`` of the unknowns (None: all are of one) come later.
    """
    large = np.bincount(node_of, weights=rank == 0) > CLUSTER
    block, rank_of = _numbered(node_of, np.where(large[node_of], 0, rank))
    clustered = np.bincount(block) > CLUSTER
    neighbours = _neighbours(pattern, block)
    owner = np.arange(len(rank_of))
    for i, near in enumerate(neighbours):
        if len(near) == 1 and (rank_of[i] == 1 or (rank_of[i] > 1 and clustered[min(near)])):
            owner[i] = min(near)
    block, rank_of = _numbered(owner[block], rank_of[owner][block])
    neighbours = _neighbours(pattern, block)
    clustered = np.bincount(block) > CLUSTER
    order = np.argsort(block, kind="stable")
    sizes = np.bincount(block)
    members = np.split(order, np.cumsum(sizes)[:-1])
    mixed = np.bincount(block, weights=rank > 0) * np.bincount(block, weights=rank == 0) > 0
    first = _joined(neighbours, rank_of, clustered)
    when = np.zeros(len(sizes), np.int64)
    np.maximum.at(when, block, 0 if stage is None else 1 + stage)
    when[first] = 0
    elimination, later = _least_degree(neighbours, sizes, rank_of, when)
    return _postordered(members, mixed, elimination, later)


def _numbered(node_of: Indices, rank: Indices) -> tuple[Indices, Indices]:
    """Number of the block of each unknown, and rank of each block."""
    key = node_of * (int(rank.max()) + 1) + rank
    _, first, block = np.unique(key, return_index=True, return_inverse=True)
    return block, rank[first]


def _columns(pattern: Pattern) -> Indices:
    """Column of each entry."""
    return np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))


def _neighbours(pattern: Pattern, block: Indices) -> list[set[int]]:
    """Blocks that share an entry with each block."""
    row, column, count = block[pattern.indices], block[_columns(pattern)], int(block.max()) + 1
    graph = coo_array((np.ones(row.size), (row, column)), shape=(count, count)).tocsr()
    graph = (graph + graph.T).tocsr()
    parts = np.split(graph.indices, graph.indptr[1:-1])
    return [set(part.tolist()) - {i} for i, part in enumerate(parts)]


def _joined(
    neighbours: list[set[int]], rank: Indices, clustered: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Clusters that joints hold, and these joints: they come first, as what is left of a body in
    the end has no stiffness in statics but that of what holds it.
    """
    first = np.zeros(rank.size, bool)
    for i, near in enumerate(neighbours):
        if rank[i] > 0 and any(clustered[j] for j in near):
            first[[i, *(j for j in near if clustered[j])]] = True
    return first


def _least_degree(
    neighbours: list[set[int]], sizes: Indices, rank: Indices, when: Indices
) -> tuple[list[int], dict[int, set[int]]]:
    """Order of elimination, and the later neighbours of each block."""
    late = when.tolist()
    size = sizes.tolist()
    waits = [{j for j in near if rank[j] < rank[i]} for i, near in enumerate(neighbours)]
    release: list[list[int]] = [[] for _ in size]
    for i, held in enumerate(waits):
        for j in held:
            release[j].append(i)
    degree = [sum(size[j] for j in near) for near in neighbours]
    heap = [(late[i], degree[i], i) for i in range(len(size)) if not waits[i]]
    heapq.heapify(heap)
    order: list[int] = []
    later: dict[int, set[int]] = {}
    while heap:
        _, d, i = heapq.heappop(heap)
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
                heapq.heappush(heap, (late[j], degree[j], j))
    return order, later


def _postordered(
    members: list[Indices],
    mixed: NDArray[np.bool_],
    order: list[int],
    later: dict[int, set[int]],
) -> Blocks:
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
        mixed[found],
        [np.array(sorted(place[k] for k in later[b]), dtype=np.int64) for b in found],
    )


def lay_out(pattern: Pattern, blocks: Blocks, symmetric: bool) -> tuple[Indices, int]:
    """Everything that the kernels need to know, and the size of their work array."""
    fronts = _Fronts(blocks, symmetric)
    size = pattern.size
    source, target = fronts.targets(pattern.indices.astype(np.int64), _columns(pattern))
    packed = np.sort((target << 32) | source)
    records: list[int] = []
    start, last = HEAD + size + packed.size, 0
    for j in range(len(blocks.members)):
        here = start + len(records)
        records += [last, *fronts.record(j)]
        last = here
    widest = int(fronts.width.max()) + BEYOND
    head = np.zeros(HEAD, np.int64)
    head[[SIZE, WIDEST, RECORDS, LAST, PEAK]] = size, widest, start, last, fronts.end
    ints = np.concatenate([head, np.concatenate(blocks.members), packed, records])
    return ints.astype(np.int64), fronts.end + 4 * size + 4 * widest


class _Fronts:
    """Where every entry of every front stands in the work array."""

    def __init__(self, blocks: Blocks, symmetric: bool):
        self.later = blocks.later
        self.size = np.array([len(m) for m in blocks.members])
        self.rest = np.array([int(self.size[later].sum()) for later in blocks.later])
        self.width = self.size + self.rest
        self.first = np.cumsum(self.size) - self.size
        upper = self.size * self.width
        kept = blocks.mixed if symmetric else np.ones_like(blocks.mixed)
        lower = np.where(kept, self.size * self.rest, 0)
        self.upper = np.cumsum(upper + lower) - upper - lower
        self.lower = np.where(kept, self.upper + upper, -1)
        self.end = int((upper + lower).sum())
        self.symmetric = symmetric
        self.column = [self._starts(j) for j in range(len(self.size))]
        self.place = np.empty(int(self.size.sum()), np.int64)
        self.place[np.concatenate(blocks.members)] = np.arange(self.place.size)

    def _starts(self, j: int) -> dict[int, int]:
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
