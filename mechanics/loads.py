"""Dead nodal forces, moments fixed in space on beam sections, and gravity.

A moment m turns with nothing: it keeps its direction in space. It acts on the section vectors
d2, d3 of a beam node with forces f_k = w x d_k, where w solves J w = m with
J = sum_k |d_k|^2 I - d_k d_k^T. For a turn dtheta of the section their virtual work is
sum f_k.(dtheta x d_k) = w.(J dtheta) = m.dtheta, whatever the stretch of the section.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics.description import Force, Load, Moment
from mechanics.layout import BEAM, Layout

Array = NDArray[np.float64]


class Loads:
    """External generalised forces.

    Attributes
    ----------
    dofs : (n_m, 6) int  coordinates of d2, d3 on which each moment acts
    """

    def __init__(self, loads: Sequence[Load], gravity: Array, layout: Layout, mass: csr_array):
        self._forces = [load for load in loads if isinstance(load, Force)]
        self._moments = [load for load in loads if isinstance(load, Moment)]
        self._force_dofs = _rows([_force_dofs(f, layout) for f in self._forces], 3)
        self._directions = _rows([f.direction for f in self._forces], 3, float)
        self.dofs = _rows([_moment_dofs(m, layout) for m in self._moments], 6)
        self._axes = _rows([m.direction for m in self._moments], 3, float)
        self._weight = _weight(gravity, layout, mass)

    def external(self, q: Array, t: float, out: Array) -> None:
        """Add the generalised force (n,) to ``out``."""
        out += self._weight
        forces = _amplitudes(self._forces, t) * self._directions
        np.add.at(out, self._force_dofs, forces)
        if self._moments:
            d = q[self.dofs].reshape(-1, 2, 3)
            forces = np.cross(self._turning(d, t)[:, None], d)
            np.add.at(out, self.dofs, forces.reshape(-1, 6))

    def tangent(self, q: Array, t: float, cK: float, blocks: Array) -> None:
        """Write cK dQ/dq to ``blocks`` (n_m, 6, 6).

        df_k = [w] dd_k - [d_k] dw with J dw = -dJ w = -sum_l G_l dd_l and
        G_l = 2 w d_l^T - (d_l.w) I - d_l w^T, where [a] b = a x b.
        """
        d = q[self.dofs].reshape(-1, 2, 3)
        w = self._turning(d, t)
        outer = np.einsum("mi,mlj->mlij", w, d)
        along = np.einsum("mli,mi->ml", d, w)[:, :, None, None] * np.eye(3)
        G = 2.0 * outer - along - outer.swapaxes(2, 3)
        minus_dw = np.linalg.solve(_inertia(d)[:, None], G)
        parts = np.einsum("mkij,mljn->mkiln", _skew(d), minus_dw)
        for k in range(2):
            parts[:, k, :, k] += _skew(w)
        blocks[:] = cK * parts.reshape(-1, 6, 6)

    def _turning(self, d: Array, t: float) -> Array:
        """w (n_m, 3) [N m]."""
        m = _amplitudes(self._moments, t) * self._axes
        return np.linalg.solve(_inertia(d), m[:, :, None])[:, :, 0]


def build(loads: Sequence[Load], gravity: Array, layout: Layout, mass: csr_array) -> Loads:
    """One term for all loads and the weight of everything.

    Parameters
    ----------
    gravity : (3,) float [m/s^2]
    mass : (n, n) csr  constant mass matrix
    """
    return Loads(loads, gravity, layout, mass)


def _amplitudes(loads: Sequence[Load], t: float) -> Array:
    return np.array([load.amplitude(t) for load in loads]).reshape(-1, 1)


def _rows(rows: Sequence, width: int, dtype: type = np.intp) -> NDArray:
    return np.array(rows, dtype=dtype).reshape(-1, width)


def _force_dofs(force: Force, layout: Layout) -> NDArray[np.intp]:
    if force.site.body is None:
        raise ValueError(f"force {force.name!r}: it must act on a body, not on the ground")
    return layout.site(force.site).dofs[:3]


def _moment_dofs(moment: Moment, layout: Layout) -> NDArray[np.intp]:
    side = layout.site(moment.site)
    if side.kind != BEAM:
        raise ValueError(
            f"moment {moment.name!r}: only nodes of beams with sections take moments, "
            f"{side.name!r} has none"
        )
    return side.dofs[3:]


def _weight(gravity: Array, layout: Layout, mass: csr_array) -> Array:
    """Generalised force (n,) of a uniform acceleration: M times a rigid translation."""
    field = np.zeros(layout.ndof)
    for nodes in layout.node_dofs.values():
        field[nodes[:, None] + np.arange(3)] = gravity
    return mass @ field


def _inertia(d: Array) -> Array:
    """J (n_m, 3, 3) of the section vectors d (n_m, 2, 3)."""
    square = np.einsum("mki,mki->m", d, d)[:, None, None] * np.eye(3)
    return square - np.einsum("mki,mkj->mij", d, d)


def _skew(a: Array) -> Array:
    """Matrices (..., 3, 3) of the products a x b."""
    return np.cross(a[..., None, :], np.eye(3)).swapaxes(-1, -2)
