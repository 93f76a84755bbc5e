"""Rigid bodies: the centre of mass r and three directors e1, e2, e3 as coordinates.

The directors are kept orthonormal by six constraints

    Phi = ((e1.e1 - 1)/2, (e2.e2 - 1)/2, (e3.e3 - 1)/2, e1.e2, e1.e3, e2.e3),

so that nothing is singular at any orientation, the mass is constant and there are no gyroscopic
forces. The kinetic energy is m |dr/dt|^2/2 + sum E_ij de_i/dt . de_j/dt / 2 with Euler's tensor
E = tr(J)/2 I - J in body axes (Betsch & Steinmann 2001, Constrained integration of rigid body
dynamics, sections 2 and 3). A flat plate or a thin rod has no inertia in some director; the
constraints carry that director along. A rod free to spin about itself has no inertia in a true
motion: a joint must hold that spin.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics.description import RigidBody
from mechanics.kernels import FORCE, TANGENT, kernel
from mechanics.layout import Layout

Array = NDArray[np.float64]

ROUND_OFF = 1e-9
"""Relative error of an inertia tensor that still counts as none [-]."""

ROWS = 6


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    for e in range(ints.shape[0]):
        d, p = ints[e, 0], ints[e, 1]
        a, b, c = out[p : p + 3], y[p : p + 3], y[p + 3 : p + 6]
        for i in range(3):
            e1, e2, e3 = y[d + i], y[d + 3 + i], y[d + 6 + i]
            a[0] += 0.5 * e1 * e1
            a[1] += 0.5 * e2 * e2
            a[2] += 0.5 * e3 * e3
            out[p + 3] += e1 * e2
            out[p + 4] += e1 * e3
            out[p + 5] += e2 * e3
            out[d + i] += b[0] * e1 + c[0] * e2 + c[1] * e3
            out[d + 3 + i] += b[1] * e2 + c[0] * e1 + c[2] * e3
            out[d + 6 + i] += b[2] * e3 + c[1] * e1 + c[2] * e2
        for i in range(3):
            a[i] -= 0.5


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    for e in range(ints.shape[0]):
        d, p, s = ints[e, 0], ints[e, 1], slots[e]
        for i in range(3):
            for k in range(3):  # director k in row k and, with director m, in row 2 + k + m
                at, row = 3 + 3 * k + i, 12 + k
                data[s[18 * at + at]] += cK * y[p + k]
                data[s[18 * at + row]] += y[d + 3 * k + i]
                data[s[18 * row + at]] += y[d + 3 * k + i]
                for m in range(k + 1, 3):
                    other, mixed = 3 + 3 * m + i, 14 + k + m
                    data[s[18 * at + other]] += cK * y[p + 2 + k + m]
                    data[s[18 * other + at]] += cK * y[p + 2 + k + m]
                    data[s[18 * at + mixed]] += y[d + 3 * m + i]
                    data[s[18 * mixed + at]] += y[d + 3 * m + i]
                    data[s[18 * other + mixed]] += y[d + 3 * k + i]
                    data[s[18 * mixed + other]] += y[d + 3 * k + i]


class Rigid:
    """All rigid bodies of a scene with the constraints of their directors.

    Attributes
    ----------
    names : name of each body
    dofs : (n_e, 18) intp  r, e1, e2, e3 and six multipliers
    rows : int  number of multipliers, six for each body
    mass : (n_e,) float [kg]
    euler : (n_e, 3, 3) float [kg m^2]  Euler's tensor in body axes
    """

    name = "rigid"
    force, tangent, energy = add_force, add_tangent, 0
    signals: Sequence = ()
    symmetric = True

    def __init__(self, bodies: Sequence[RigidBody], layout: Layout, first_row: int):
        self.names = [body.name for body in bodies]
        self.rows = ROWS * len(bodies)
        start = np.array([layout.node_dofs[name][0] for name in self.names], dtype=np.intp)
        row = first_row + ROWS * np.arange(len(bodies), dtype=np.intp)
        own = start[:, None] + np.arange(12), row[:, None] + np.arange(ROWS)
        self.dofs = np.concatenate(own, axis=1)
        self.ints = np.stack([start + 3, row], axis=1).astype(np.int64)
        self.floats = np.zeros((len(bodies), 0))
        self.driven = np.zeros(len(bodies), dtype=bool)
        self.mass = np.array([body.mass for body in bodies], dtype=float)
        self.euler = np.array([euler_tensor(body) for body in bodies]).reshape(-1, 3, 3)

    def coefficients(self, T: Array) -> Array:
        """Nothing depends on temperature: (n_e, 0)."""
        return np.zeros((len(self.names), 0))

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """As they are."""
        return c0, c1

    def mass_blocks(self) -> Array:
        """(n_e, 12, 12) mass of r and the directors, [m, E_ij] times the identity of space."""
        scalar = np.zeros((len(self.names), 4, 4))
        scalar[:, 0, 0] = self.mass
        scalar[:, 1:, 1:] = self.euler
        blocks = np.einsum("eij,kl->eikjl", scalar, np.eye(3))
        return blocks.reshape(-1, 12, 12)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """A rigid body has no section resultants: (n_e, 0)."""
        return np.zeros((len(self.names), 0))


def build(bodies: Sequence[RigidBody], layout: Layout, first_row: int) -> Rigid:
    """One term for all rigid ``bodies``.

    Parameters
    ----------
    first_row : index in y of the first multiplier

    Raises
    ------
    ValueError : mass, inertia or axes of no real body, with its name
    """
    return Rigid(bodies, layout, first_row)


def euler_tensor(body: RigidBody) -> Array:
    """(3, 3) float [kg m^2]  E = tr(J)/2 I - J in body axes, of no negative eigenvalue.

    An eigenvalue of E is half the sum of two principal moments less the third: what is integrated
    over the mass is the square of one coordinate.
    """
    J, axes = np.asarray(body.inertia, float), np.asarray(body.axes, float)
    if not (np.isfinite(body.mass) and body.mass > 0.0):
        raise ValueError(f"rigid body {body.name!r}: its mass must be positive")
    if axes.shape != (3, 3) or not np.allclose(axes @ axes.T, np.eye(3), atol=ROUND_OFF):
        raise ValueError(f"rigid body {body.name!r}: its axes are not orthonormal")
    size = float(np.trace(J)) if J.shape == (3, 3) and np.isfinite(J).all() else 0.0
    if size <= 0.0 or np.abs(J - J.T).max() > ROUND_OFF * size:
        raise ValueError(f"rigid body {body.name!r}: its inertia is not symmetric and positive")
    moments, turned = np.linalg.eigh(0.5 * size * np.eye(3) - axes @ (0.5 * (J + J.T)) @ axes.T)
    if moments[0] < -ROUND_OFF * size:
        principal = moments.sum() - moments
        raise ValueError(
            f"rigid body {body.name!r}: no body has the principal moments of inertia "
            f"{', '.join(f'{p:.6g}' for p in principal)} kg m^2; none exceeds the sum of the others"
        )
    found = (turned * np.maximum(moments, 0.0)) @ turned.T
    return 0.5 * (found + found.T)
