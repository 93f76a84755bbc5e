"""Clusters of neighbouring nodes, which the linear solver eliminates at once, and their stages.

Bodies are cut in halves, these in halves again, down to the size of a cluster. What both halves
share, a separator, is eliminated after them (nested dissection, George 1973).
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import ReferencePoint
from mechanics.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NODES = 24
"""Most nodes of a cluster."""


EVEN = 1e-6
"""Distance of two cells along a body, relative to its size, that is none [-]."""


class Dissection(NamedTuple):
    """Of the n nodes of a body.

    cluster : (n,) int  number of the cluster of each node
    stage : (n,) int  later stages are eliminated later, 0 first
    """

    cluster: Indices
    stage: Indices


def dissected(points: Array, cells: Indices, most: int = NODES) -> Dissection:
    """Clusters of up to ``most`` of the nodes at ``points`` (n, 3) of ``cells`` (n_c, k)."""
    centres, free = points[cells].mean(axis=1), np.ones(len(points), bool)
    cluster, depth = np.zeros(len(points), np.intp), np.zeros(len(points), np.intp)
    ahead, count, whole = [(np.arange(len(cells)), 0)], 0, len(cells)
    while ahead:
        members, level = ahead.pop()
        nodes = np.unique(cells[members])
        nodes, level_of = nodes[free[nodes]], whole
        if len(nodes) > most and len(members) > 1:
            halves = _halves(members, centres)
            nodes, level_of = np.intersect1d(cells[halves[0]], cells[halves[1]]), level
            nodes = nodes[free[nodes]]
            ahead += [(half, level + 1) for half in halves]
        if nodes.size:
            pieces = clusters(points[nodes], most)
            cluster[nodes], depth[nodes], free[nodes] = count + pieces, level_of, False
            count += int(pieces.max()) + 1
    deepest = int(np.max(depth, initial=-1, where=depth < whole)) + 1
    return Dissection(cluster, deepest - np.minimum(depth, deepest))


def _halves(members: Indices, centres: Array) -> tuple[Indices, Indices]:
    """Cells on both sides of a plane across their longest side, between cells where it can be."""
    place = centres[members]
    sides = np.ptp(place, axis=0)
    along = place[:, int(np.argmax(sides))]
    order = np.argsort(along, kind="stable")
    gaps = 1 + np.flatnonzero(np.diff(along[order]) > EVEN * sides.max())
    middle = len(members) // 2
    if gaps.size:
        middle = int(gaps[np.argmin(np.abs(gaps - middle))])
    return members[order[:middle]], members[order[middle:]]


def clusters(points: Array, most: int = NODES) -> Indices:
    """(n,) number of the cluster of each point (n, 3): halves, by the longest side, of halves."""
    found, ahead, count = np.zeros(len(points), np.intp), [np.arange(len(points))], 0
    while ahead:
        members = ahead.pop()
        if len(members) <= most:
            found[members] = count
            count += 1
            continue
        place = points[members]
        along = place[:, int(np.argmax(np.ptp(place, axis=0)))]
        order = np.argsort(along, kind="stable")
        middle = len(members) // 2
        ahead += [members[order[middle:]], members[order[:middle]]]
    return found


def gather(block: Indices, layout: Layout, tie: Mapping[str, int]) -> None:
    """Make the nodes of each tied face, its reference point and its ties one block.

    Parameters
    ----------
    block : (n + m,) int  block of each unknown, changed in place
    tie : block of the ties of each reference point
    """
    for point in layout.bodies.values():
        if isinstance(point, ReferencePoint):
            face = layout.node_dofs[point.body][point.nodes]
            own = layout.node_dofs[point.name][0] + np.arange(layout.kinds[point.name])
            shared = np.isin(block, block[face][block[face] >= min(tie.values())])
            block[shared | (block == tie[point.name])] = tie[point.name]
            block[(face[:, None] + np.arange(3)).ravel()] = tie[point.name]
            block[own] = tie[point.name]
