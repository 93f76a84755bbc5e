"""Bushings: six springs and dampers between two sections.

With b1, b2, b3 the given axes as they move with the second end and a1, a2, a3 the same in the
first, the generalised strains are

    x_k = (r_A - r_B).b_k,        w_k = (a_i.b_j - a_j.b_i)/2,    (k, i, j) cyclic.

The w_k are the components of sin(angle) times the axis of the rotation of the first end relative
to the second: objective, equal to the angle to third order, and growing only up to a right angle.
They are meant for moderate rotations; at 30 degrees a moment is 4.5 % less than stiffness times
angle. Energy 1/2 sum k x^2 + 1/2 sum k w^2.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import bushing_kernels as kernels
from mechanics.description import Bushing
from mechanics.layout import Layout, Side

Array = NDArray[np.float64]

_APART = 1e-6  # distance over body size above which two points do not coincide


class Bushings:
    """All bushings of a scene.

    Attributes
    ----------
    names : name of each
    dofs : (n_e, 6 W) intp  coordinates of W vectors of each end
    """

    name = "bushings"
    force, tangent, energy = kernels.add_force, kernels.add_tangent, kernels.add_energy
    signals: Sequence = ()
    symmetric = True

    def __init__(self, bushings: Sequence[Bushing], layout: Layout):
        self.names = [bushing.name for bushing in bushings]
        ends = [_ends(bushing, layout) for bushing in bushings]
        width = max(side.vectors.size for pair in ends for side in pair)
        self.ints = np.full((len(ends), 2 * width), -1, dtype=np.int64)
        weights = np.zeros((len(ends), 2 * width, 3))
        constant = np.zeros((len(ends), 8, 3))
        form = np.zeros((len(ends), 6, 8, 8))
        for e, (bushing, pair) in enumerate(zip(bushings, ends, strict=True)):
            form[e] = _form(*(_directions(side, bushing) for side in pair))
            for end, side in enumerate(pair):
                at = slice(end * width, end * width + side.vectors.size)
                self.ints[e, at], weights[e, at] = side.vectors, side.weights.T
                constant[e, 4 * end : 4 * end + 4] = [side.position, *np.eye(3)]
        stiffness = np.array([[*b.stiffness, *b.damping] for b in bushings], dtype=float)
        parts = [stiffness, form, constant, weights]
        self.floats = np.hstack([part.reshape(len(ends), -1) for part in parts])
        first = self.ints[:, :, None]
        dofs = np.where(first < 0, -1, first + np.arange(3))
        self.dofs = dofs.reshape(len(ends), -1).astype(np.intp)

    def coefficients(self, T: Array) -> Array:
        """Nothing depends on temperature: (n_e, 0)."""
        return np.zeros((len(self.names), 0))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> None:
        """Bushings have no mass."""


def build(bushings: Sequence[Bushing], layout: Layout) -> Bushings:
    """One term for all ``bushings``; ``ValueError`` with the name of one that cannot be."""
    return Bushings(bushings, layout)


def _ends(bushing: Bushing, layout: Layout) -> tuple[Side, Side]:
    a, b = layout.site(bushing.a), layout.site(bushing.b)
    values = np.array([*bushing.stiffness, *bushing.damping], dtype=float)
    axes = np.asarray(bushing.axes, float)
    problem = ""
    if a.fixed and b.fixed:
        problem = "both ends are on the ground"
    elif values.shape != (12,) or not np.all(np.isfinite(values) & (values >= 0.0)):
        problem = "it needs six stiffnesses and six dampings that are not negative"
    elif axes.shape != (3, 3) or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9):
        problem = "its axes are not orthonormal"
    elif np.linalg.norm(a.position - b.position) > _APART * max(a.size, b.size):
        gap = np.linalg.norm(a.position - b.position)
        problem = f"its two points are {gap:.6g} m apart"
    elif wrong := [side.name for side in (a, b) if not side.fixed and side.directions < 2]:
        problem = f"{wrong[0]!r} has no section that can turn"
    if problem:
        raise ValueError(f"bushing {bushing.name!r}: {problem}")
    return a, b


def _directions(side: Side, bushing: Bushing) -> Array:
    """(3, 3) coefficients of the three axes in g/|g|^1/2, p, s of an end."""
    axes = np.asarray(bushing.axes, float)
    return axes if side.fixed else np.linalg.solve(side.frame.T, axes.T).T


def _form(a: Array, b: Array) -> Array:
    """Q (6, 8, 8) of the strains for axes with coefficients a, b (3, 3)."""
    Q = np.zeros((6, 8, 8))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        Q[k, 0, 5:] = b[k]
        Q[k, 4, 5:] = -b[k]
        Q[3 + k, 1:4, 5:] = 0.5 * (np.outer(a[i], b[j]) - np.outer(a[j], b[i]))
    return Q + Q.swapaxes(1, 2)
