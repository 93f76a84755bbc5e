"""Flexible bodies in a floating frame of reference: large motion of a frame, linear modes in it.

What multibody programs did before absolute nodal coordinates and many still do (Shabana, Dynamics
of Multibody Systems, ch. 5; modes of Craig & Bampton 1968): every node is where the frame and the
amplitudes p of a few modes put it,

    r_k = r + A (X_k + S_k p),   likewise its r_x, r_y, r_z,

and the elastic energy is that of linear theory, 1/2 (p - p_T)^T K (p - p_T), with the free p_T of
the temperatures. It is written here as a differential-algebraic system: nodes keep the coordinates
and the constant mass of the mesh, so that joints, contacts, loads and temperatures act on them as
on any beam, and multipliers tie them to r, three directors and p. The constrained motion is that of
the classical equations with their mass matrix M(p), Coriolis and centrifugal forces; only the work
of a step is larger. The elastic energy does not see that a bent beam shortens: its axis stretches
instead, by second order of the deflection, and tension does not stiffen it (Kane, Ryan & Banerjee
1987). Sections are rigid; a uniform change of temperature does not swell them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics import floating_kernels as kernels
from mechanics import rigid
from mechanics.beam3243_tables import AXIAL, BENDING, SHEAR, STRAINS, TORSION
from mechanics.blocks import CLUSTER
from mechanics.description import Beam
from mechanics.floating_kernels import DIRECTION, FRAME, OWN, PLACE, USED
from mechanics.floating_modes import Modes, modes_of
from mechanics.layout import Layout, frame_name

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class FloatingBeam:
    """The elements of one beam in a floating frame: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    names : body of each element;  dofs : (n_e, 24) intp  coordinates of its nodes
    pattern_dofs : (1, n) intp  amplitudes of the modes, between which its forces act
    modes : shapes and strains
    """

    name = "beam in a floating frame"
    force, tangent, energy = kernels.add_force, kernels.add_tangent, kernels.add_energy
    symmetric = True

    def __init__(self, beam: Beam, layout: Layout):
        self._own, self.modes = modes_of(beam)
        self._rows = layout.point_index[beam.name]
        self.names, self.signals = self._own.names, list[tuple]()
        self.dofs = self._own.dofs + layout.node_dofs[beam.name][0]
        name = frame_name(beam.name)
        first = int(layout.node_dofs[name][0]) + FRAME
        amplitudes = np.arange(layout.kinds[name] - FRAME, dtype=np.intp)
        self.pattern_dofs = (first + amplitudes)[None]
        self.ints = np.full((len(self.names), 1), first, np.int64)
        damping = np.full((len(self.names), 1), float(beam.damping_time))
        B = self.modes.strains[:, :USED].reshape(len(damping), -1)
        row = [damping, self.modes.reference[:, :USED], B]
        self.floats = np.ascontiguousarray(np.hstack(row))

    def coefficients(self, T: Array) -> Array:
        """Stiffness, free strain and its rate (zero) of each strain, (n_e, 54)."""
        return self._own.coefficients(T[self._rows])

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        return self._own.with_rates(c0, c1, h)

    def mass_blocks(self) -> Array:
        """(n_e, 24, 24) consistent mass of the mesh."""
        return self._own.mass_blocks()

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """Section resultants N, Q2, Q3, Mt, M2, M3 of each element, (n_e, 6) [N, N m]."""
        p, rate = y[self.pattern_dofs[0]], v[self.pattern_dofs[0]]
        B = self.modes.strains
        viscous = self.floats[:, :1] * (B @ rate - coef[:, 2 * STRAINS :])
        free = coef[:, STRAINS : 2 * STRAINS] - self.modes.reference
        S = coef[:, :STRAINS] * (B @ p - free + viscous)
        L = self._own.length[:, None]
        pairs = S[:, BENDING:TORSION].reshape(-1, 4, 2).sum(axis=2)
        bending, shear = pairs[:, :2], pairs[:, (SHEAR - BENDING) // 2 :] / L
        return np.column_stack([S[:, AXIAL] / L[:, 0], shear, S[:, TORSION], bending])


def build(beam: Beam, layout: Layout) -> FloatingBeam:
    """The elements of one beam with ``modes``."""
    return FloatingBeam(beam, layout)


@dataclass(frozen=True, eq=False)
class Held:
    """Constraints of one frame: a term, see ``mechanics.kernels``; elements as its kernels say.

    Attributes
    ----------
    names : (n_e,) what the rows of each element belong to
    dofs : (n_e, k) intp  coordinates and multipliers; -1 where absent
    rows : number of multipliers
    tied : how many elements at the beginning are vectors of nodes with their multipliers
    """

    name: str
    names: list[str]
    dofs: Indices
    ints: NDArray[np.int64]
    floats: Array
    force: int
    tangent: int
    rows: int
    tied: int = 0
    energy: int = 0
    symmetric: bool = True

    @property
    def slaves(self) -> Indices:
        """(k, 6)  coordinates of vectors that are tied, and the multipliers that tie them."""
        return self.dofs[: self.tied, :6]

    @property
    def frame(self) -> Indices:
        """Coordinates of the frame and amplitudes to which they are tied."""
        return self.dofs[-1, :-3]

    def coefficients(self, T: Array) -> Array:
        """Nothing depends on temperature: (n_e, 0)."""
        return np.zeros((len(self.names), 0))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> None:
        """A frame has no mass."""


def holding(terms: Sequence[FloatingBeam], layout: Layout, first_row: int) -> list[Held]:
    """What keeps the directors of the frames orthonormal, and ties the nodes to frames and modes.

    Parameters
    ----------
    first_row : index in y of the first multiplier
    """
    found: list[Held] = []
    for term in terms:
        name = term.names[0]
        found.append(_directors(layout, frame_name(name), first_row))
        found.append(_ties(layout, name, term.modes, first_row + rigid.ROWS))
        first_row += rigid.ROWS + found[-1].rows
    return found


def _directors(layout: Layout, frame: str, row: int) -> Held:
    start = int(layout.node_dofs[frame][0])
    dofs = np.concatenate([start + np.arange(FRAME), row + np.arange(rigid.ROWS)])
    return Held(
        "directors of a frame", [frame], dofs[None].astype(np.intp),
        np.array([[start + 3, row]], np.int64), np.zeros((1, 0)),
        rigid.add_force, rigid.add_tangent, rigid.ROWS,
    )  # fmt: skip


def _ties(layout: Layout, name: str, modes: Modes, first: int) -> Held:
    """Two elements for each vector of each node, each with the same three multipliers."""
    frame = frame_name(name)
    start, kind = int(layout.node_dofs[frame][0]), layout.kinds[frame]
    vectors = modes.places.shape[1]
    at = (layout.node_dofs[name][:, None] + 3 * np.arange(vectors)).ravel()
    row = first + 3 * np.arange(at.size)
    three, count = np.arange(3), at.size
    dofs = np.full((2 * count, kind + 3), -1, np.intp)
    dofs[:count, :6] = np.hstack([at[:, None] + three, row[:, None] + three])
    dofs[count:, :kind] = start + np.arange(kind)
    dofs[count:, kind:] = row[:, None] + three
    part = np.where(np.arange(count) % vectors == 0, PLACE, DIRECTION)
    ints = np.column_stack([
        np.concatenate([np.full(count, OWN), part]), np.tile(row, 2),
        np.concatenate([at, np.full(count, start)]),
    ])  # fmt: skip
    floats = np.hstack([modes.places.reshape(count, 3), modes.shapes.reshape(count, -1)])
    names = [f"{name} node {k}" for k in np.arange(count) // vectors]
    return Held(
        "ties to a frame", [*names, *names], dofs, ints.astype(np.int64),
        np.vstack([np.zeros_like(floats), floats]),
        kernels.add_ties, kernels.add_tie_tangents, 3 * count, count,
    )  # fmt: skip


# -- elimination -----------------------------------------------------------------------------------


def arrange(ties: Sequence[Held], block: Indices, stage: Indices, rank: Indices) -> None:
    """Eliminate each node together with its ties, before all else, then frames as if with a mass.

    A node and its multipliers, [[S, 1], [1, 0]], leave its mass to the frame. Multipliers alone
    would take all of the node, and what holds it besides would have nothing left to act on. Blocks
    stay smaller than clusters of solids, which come first.

    Parameters
    ----------
    block, stage, rank : (n + m,) int  of each unknown, changed in place
    """
    stage += 1
    for term in ties:
        block[term.slaves[:, 3:]] = block[term.slaves[:, :3]]
        stage[term.slaves], rank[term.slaves], rank[term.frame] = 0, 0, 0
        modes = term.frame[FRAME:]
        block[modes] = 1 + block.max() + np.arange(modes.size) // CLUSTER


def reached(ties: Sequence[Held], terms: Sequence[Any], n: int) -> list[tuple[Indices, Indices]]:
    """Multipliers (k, 1) of what holds tied nodes, and coordinates (k, c) of their frames.

    They know one another once the nodes are eliminated; multipliers have to wait for the frames.
    """
    found = []
    for term in ties:
        tied = np.zeros(n, bool)
        tied[term.slaves[:, :3]] = True
        for other in terms:
            if isinstance(other, Held) or not getattr(other, "rows", 0):
                continue
            held = (other.dofs >= 0) & (other.dofs < n) & tied[np.minimum(other.dofs, n - 1)]
            touching = other.dofs[held.any(axis=1)]
            rows = np.unique(touching[touching >= n])[:, None]
            if rows.size:
                found.append((rows, np.tile(term.frame, (len(rows), 1))))
    return found
