"""What ties reference points to their faces: nine rows each, sum of w_i x_i - vector = 0.

An element is one coordinate in one row, so that the nodes of a face do not know one another in
the pattern of the system.
"""

import numpy as np
from numpy.typing import NDArray

from mechanics.description import ReferencePoint
from mechanics.kernels import FORCE, TANGENT, kernel
from mechanics.layout import Layout
from mechanics.reference_point import face_weights

Array = NDArray[np.float64]

ROWS = 9


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    for e in range(len(ints)):
        at, row = ints[e, 0], ints[e, 1]
        out[at] += floats[e, 0] * y[row]
        out[row] += floats[e, 0] * y[at]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    for e in range(len(ints)):
        data[slots[e, 1]] += floats[e, 0]
        data[slots[e, 2]] += floats[e, 0]


class Ties:
    """The ties of all reference points: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    names : reference point of each element
    dofs, ints : (n_e, 2)  coordinate and multiplier
    floats : (n_e, 1) float  weight [-] of a position in r, [1/m] in r_y and r_z; -1 of these
    rows : number of multipliers, nine for each point: x, y, z of r, r_y, r_z
    """

    name = "reference points"
    energy = 0
    symmetric = True

    def __init__(self, points: list[ReferencePoint], layout: Layout, first_row: int):
        self.rows = ROWS * len(points)
        parts = [_tie(p, layout, first_row + ROWS * i) for i, p in enumerate(points)]
        self.names = [p.name for p, (at, _) in zip(points, parts, strict=True) for _ in at]
        self.dofs = np.concatenate([at for at, _ in parts])
        self.ints = np.ascontiguousarray(self.dofs, np.int64)
        self.floats = np.concatenate([weights for _, weights in parts])[:, None]
        self.signals: list = []
        self.force, self.tangent = add_force, add_tangent

    def coefficients(self, T: Array) -> Array:
        """Nothing here depends on temperature: (n_e, 0)."""
        return np.zeros((len(self.ints), 0))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The same: there are no free strains."""
        return c0, c1

    def mass_blocks(self) -> None:
        """A reference point has no mass."""


def build(layout: Layout, first_row: int) -> Ties:
    """One term for all reference points of a layout."""
    points = [b for b in layout.bodies.values() if isinstance(b, ReferencePoint)]
    return Ties(points, layout, first_row)


def _tie(point: ReferencePoint, layout: Layout, first: int) -> tuple[NDArray[np.intp], Array]:
    """Pairs (n, 2) of coordinate and row, and weights (n,)."""
    weights = face_weights(point)
    nodes = layout.node_dofs[point.body][point.nodes]
    own = layout.node_dofs[point.name][0] + np.arange(ROWS)
    rows = first + np.arange(ROWS).reshape(3, 3)
    at = np.broadcast_to(nodes[None, :, None] + np.arange(3), (3, nodes.size, 3))
    into = np.broadcast_to(rows[:, None], at.shape)
    pairs = np.stack([at.ravel(), into.ravel()], axis=1)
    many = np.broadcast_to(weights[:, :, None], at.shape).ravel()
    pairs = np.concatenate([pairs, np.stack([own, rows.ravel()], axis=1)])
    return pairs.astype(np.intp), np.concatenate([many, -np.ones(ROWS)])
