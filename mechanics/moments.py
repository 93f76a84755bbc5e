"""Moments fixed in space and torques between bodies.

A moment m acts on the two directions p, s of a section with forces f_k = w x d_k, where w solves
J w = m with J = sum_k |d_k|^2 I - d_k d_k^T. For a turn dtheta of the section their virtual work
is sum f_k.(dtheta x d_k) = w.(J dtheta) = m.dtheta, whatever the stretch of the section, and none
for a stretch. The point at which it acts moves by nothing of this.

A moment keeps its direction in space. A torque keeps that of a direction of its second end, on
which the reaction -m acts in the same way; its stiffness matrix is not symmetric.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import moment_kernels as kernels
from mechanics.description import Moment, Site, Torque
from mechanics.layout import Layout, Side
from mechanics.loads import coordinates_of, on_body, padded

Array = NDArray[np.float64]

_GROUND = Site(None)


class Turning:
    """Moments on sections, and torques between two of them.

    Attributes
    ----------
    dofs : (n_e, 6 k) intp  coordinates of up to k vectors of each end
    ints : (n_e, 2 k) int  their first coordinates; -1 where absent
    floats : (n_e, 6 + 4 k)  c (3,) of the direction in the second end, or the direction (3,)
        itself where that end is absent; weights of each vector in p and s
    """

    name = "loads"
    external = True
    force, tangent, energy = kernels.add_moment, kernels.add_moment_tangent, 0
    columns = 1
    symmetric = False

    def __init__(self, loads: Sequence[Moment | Torque], layout: Layout):
        self.names = [load.name for load in loads]
        ends = [_ends(load, layout) for load in loads]
        width = max(side.vectors.size for pair in ends for side in pair)
        self.ints = np.array(
            [np.concatenate([padded(s.vectors, width) for s in pair]) for pair in ends], np.int64
        )
        self.floats = np.array(
            [_direction(load, b) + _weights(a, width) + _weights(b, width)
             for load, (a, b) in zip(loads, ends, strict=True)]
        )  # fmt: skip
        self.dofs = coordinates_of(self.ints)
        self.signals = [(i, 0, load.amplitude) for i, load in enumerate(loads)]

    def coefficients(self, T: Array) -> Array:
        """(n_e, 1) amplitude [N m], a signal."""
        return np.zeros((len(self.names), 1))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> None:
        """Loads have no mass."""


def _ends(load: Moment | Torque, layout: Layout) -> tuple[Side, Side]:
    """Both ends of a torque; a moment has its second on the ground."""
    ground = layout.site(_GROUND)
    if isinstance(load, Moment):
        pair, kind = (on_body("moment", load, layout), ground), "moment"
    else:
        pair, kind = (layout.site(load.a), layout.site(load.b)), "torque"
    if pair[0].fixed and pair[1].fixed:
        raise ValueError(f"torque {load.name!r}: both ends are on the ground")
    for side in pair:
        if not side.fixed and side.directions < 2:
            raise ValueError(
                f"{kind} {load.name!r}: only sections that can turn take moments, "
                f"{side.name!r} has none"
            )
    return pair


def _direction(load: Moment | Torque, second: Side) -> list[float]:
    """c (3,) of the unit direction in the second end, direction (3,) in space, with its size."""
    direction = np.asarray(load.direction, float)
    size = float(np.linalg.norm(direction))
    if isinstance(load, Moment):
        return [0.0, 0.0, 0.0, *direction]
    if size == 0.0:
        raise ValueError(f"torque {load.name!r}: its direction has no length")
    if second.fixed:
        return [0.0, 0.0, 0.0, *direction]
    return [*np.linalg.solve(second.frame.T, direction), size, 0.0, 0.0]


def _weights(side: Side, width: int) -> list[float]:
    """Weights in p and s of each vector, (2 width,)."""
    weights = np.zeros((width, 2))
    weights[: side.vectors.size] = side.weights[1:].T
    return list(weights.ravel())
