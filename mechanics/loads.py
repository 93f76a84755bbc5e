"""Dead forces at material points, moments fixed in space, torques between bodies, and gravity.

A moment m acts on the two directions p, s of a section with forces f_k = w x d_k, where w solves
J w = m with J = sum_k |d_k|^2 I - d_k d_k^T. For a turn dtheta of the section their virtual work
is sum f_k.(dtheta x d_k) = w.(J dtheta) = m.dtheta, whatever the stretch of the section, and none
for a stretch. The point at which it acts moves by nothing of this.

A moment keeps its direction in space. A torque keeps that of a direction of its second end, on
which the reaction -m acts in the same way; its stiffness matrix is not symmetric.

Terms add minus the load, since they are resisting forces.
"""

from collections.abc import Sequence
from importlib import import_module

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import load_kernels as kernels
from mechanics.description import Force, History, Load, Moment, Site, Torque, Traction
from mechanics.layout import Layout, Side

Array = NDArray[np.float64]

Signal = tuple[int, int, History]

_GROUND = Site(None)


class Dead:
    """Generalised forces that depend on nothing but time: dead forces, or the weight.

    Attributes
    ----------
    dofs : (n_e, 3 k) intp  coordinates of up to k vectors
    ints : (n_e, k) int  their first coordinates; -1 where absent
    floats : (n_e, 3 k) float [N] or [N m]  forces on them at amplitude one
    """

    name = "loads"
    external = True
    force, tangent, energy = kernels.add_dead, kernels.add_nothing, 0
    columns = 1
    symmetric = True

    def __init__(self, names: list[str], ints: NDArray, floats: Array, signals: list[Signal]):
        self.names, self.signals = names, signals
        self.ints, self.floats = np.asarray(ints, np.int64), np.ascontiguousarray(floats, float)
        self.dofs = coordinates_of(self.ints)

    def coefficients(self, T: Array) -> Array:
        """(n_e, 1) amplitude; one where it is no function of time."""
        return np.ones((len(self.names), 1))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> None:
        """Loads have no mass."""


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


def build(
    loads: Sequence[Load], gravity: Array, layout: Layout, mass: csr_array
) -> list[Dead | Turning]:
    """Terms of all loads and of the weight of everything; none for what is absent.

    Parameters
    ----------
    gravity : (3,) float [m/s^2]
    mass : (n, n) csr  constant mass matrix
    """
    forces = [load for load in loads if isinstance(load, Force)]
    moments = [load for load in loads if isinstance(load, Moment | Torque)]
    terms: list[Dead | Turning] = [_forces(forces, layout)] if forces else []
    if moments:
        terms.append(Turning(moments, layout))
    if tractions := [load for load in loads if isinstance(load, Traction)]:
        terms.append(import_module("mechanics.traction").build(tractions, layout))
    if np.any(gravity):
        terms.append(_weight(gravity, layout, mass))
    return terms


def coordinates_of(first: NDArray) -> NDArray[np.intp]:
    """(n, 3 k) coordinates of vectors that begin at ``first`` (n, k); -1 stays -1."""
    all_three = first[:, :, None] + np.where(first[:, :, None] < 0, 0, np.arange(3))
    return all_three.reshape(len(first), 3 * first.shape[1]).astype(np.intp)


def padded(vectors: NDArray, width: int) -> NDArray:
    """``vectors`` (k,) filled with -1 up to ``width``."""
    return np.concatenate([vectors, np.full(width - vectors.size, -1)])


def _forces(forces: Sequence[Force], layout: Layout) -> Dead:
    sides = [_on_body("force", force, layout) for force in forces]
    width = max(side.vectors.size for side in sides)
    floats = np.zeros((len(forces), width, 3))
    for i, (force, side) in enumerate(zip(forces, sides, strict=True)):
        floats[i, : side.vectors.size] = np.outer(side.weights[0], force.direction)
    return Dead(
        [force.name for force in forces],
        np.array([padded(side.vectors, width) for side in sides]),
        floats.reshape(len(forces), -1),
        [(i, 0, force.amplitude) for i, force in enumerate(forces)],
    )


def _weight(gravity: Array, layout: Layout, mass: csr_array) -> Dead:
    """Weight of everything: the mass times a rigid translation, vector by vector."""
    field = np.zeros(layout.ndof)
    for nodes in layout.node_dofs.values():
        field[nodes[:, None] + np.arange(3)] = gravity
    vectors = np.concatenate([_vectors(name, layout) for name in layout.node_dofs])
    weight = (mass @ field)[vectors[:, None] + np.arange(3)]
    heavy = np.any(weight != 0.0, axis=1)
    names = ["gravity"] * int(heavy.sum())
    return Dead(names, vectors[heavy, None], weight[heavy], [])


def _vectors(name: str, layout: Layout) -> NDArray:
    """First coordinates of all vectors of a body."""
    step = np.arange(0, layout.kinds[name], 3)
    return (layout.node_dofs[name][:, None] + step).ravel()


def _on_body(kind: str, load: Force | Moment, layout: Layout) -> Side:
    side = layout.site(load.site)
    if side.fixed:
        raise ValueError(f"{kind} {load.name!r}: it must act on a body, not on the ground")
    return side


def _ends(load: Moment | Torque, layout: Layout) -> tuple[Side, Side]:
    """Both ends of a torque; a moment has its second on the ground."""
    ground = layout.site(_GROUND)
    if isinstance(load, Moment):
        pair, kind = (_on_body("moment", load, layout), ground), "moment"
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
