"""Loads: dead forces at material points and gravity here, moments and torques in ``moments``.

Terms add minus the load, since they are resisting forces.
"""

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import load_kernels as kernels
from mechanics.description import Force, History, Load, Moment, Torque, Traction
from mechanics.layout import Layout, Side

Array = NDArray[np.float64]

Signal = tuple[int, int, History]


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


def build(loads: Sequence[Load], gravity: Array, layout: Layout, mass: csr_array) -> list[Any]:
    """Terms of all loads and of the weight of everything; none for what is absent.

    Parameters
    ----------
    gravity : (3,) float [m/s^2]
    mass : (n, n) csr  constant mass matrix
    """
    forces = [load for load in loads if isinstance(load, Force)]
    moments = [load for load in loads if isinstance(load, Moment | Torque)]
    terms: list[Any] = [_forces(forces, layout)] if forces else []
    if moments:
        terms.append(import_module("mechanics.moments").Turning(moments, layout))
    if tractions := [load for load in loads if isinstance(load, Traction)]:
        terms.append(import_module("mechanics.traction").build(tractions, layout))
    if np.any(gravity) and layout.ndof:
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
    sides = [on_body("force", force, layout) for force in forces]
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


def on_body(kind: str, load: Force | Moment, layout: Layout) -> Side:
    side = layout.site(load.site)
    if side.fixed:
        raise ValueError(f"{kind} {load.name!r}: it must act on a body, not on the ground")
    return side
