"""Clusters of neighbouring nodes, which the linear solver eliminates at once."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mechanics.description import ReferencePoint
from mechanics.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NODES = 24
"""Most nodes of a cluster."""


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
