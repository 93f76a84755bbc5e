"""Thick shell with four nodes of 6 coordinates: r and the director r_n.

Bilinear position r + zeta r_n for any quadrilaterals. Locking is removed by

- transverse shear from the middles of the four sides (Dvorkin & Bathe 1984),
- stretch of the director from the nodes (Betsch & Stein 1995),
- seven enhanced strains of the membrane (Simo & Rifai 1990; Andelfinger & Ramm 1993) and four of
  the thickness, linear in zeta (Buechter, Ramm & Roehl 1994), without which a plate in bending
  would be stiffened by Poisson's effect.

What the two have in common stands in ``shell_solid``.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Shell
from mechanics.layout import Layout
from mechanics.shell_integrals import Scheme, bilinear, normal_squares, product
from mechanics.shell_solid import SolidShell

Array = NDArray[np.float64]


def build(shells: Sequence[Shell], layout: Layout) -> SolidShell:
    """One term for all ``shells``."""
    return SolidShell("shell24", SCHEME, shells, layout)


def shape(xi: float, eta: float) -> Array:
    """(3, 8) weights of r, n of the four nodes in r and its slopes by xi and eta."""
    rows = np.zeros((3, 8))
    rows[:, ::2] = bilinear(xi, eta)
    return rows


def strains(xi: float, eta: float) -> Array:
    """(3, 6, 28) covariant strains, see ``shell_integrals.Scheme``."""
    _, r1, r2 = shape(xi, eta)
    _, n1, n2 = _normals(xi, eta)
    N = bilinear(xi, eta)
    E = np.zeros((3, 6, 28))
    E[0, 0], E[1, 0], E[2, 0] = 0.5 * product(r1, r1), product(r1, n1), 0.5 * product(n1, n1)
    E[0, 1], E[1, 1], E[2, 1] = 0.5 * product(r2, r2), product(r2, n2), 0.5 * product(n2, n2)
    E[0, 3], E[1, 3] = product(r1, r2), product(r1, n2) + product(r2, n1)
    E[2, 3] = product(n1, n2)
    E[0, 2] = 0.5 * normal_squares(2, N[0])
    E[0, 4] = 0.5 * (1.0 - eta) * _shear(0.0, -1.0, 1) + 0.5 * (1.0 + eta) * _shear(0.0, 1.0, 1)
    E[0, 5] = 0.5 * (1.0 - xi) * _shear(-1.0, 0.0, 2) + 0.5 * (1.0 + xi) * _shear(1.0, 0.0, 2)
    E[1, 4], E[1, 5] = 0.5 * normal_squares(2, N[1]), 0.5 * normal_squares(2, N[2])
    return E


def membrane(xi: float, eta: float) -> Array:
    """(7, 3) enhanced strains 11, 22, 2x12."""
    both = xi * eta
    first, second, shear = np.eye(3)
    return np.array(
        [xi * first, both * first, eta * second, both * second, xi * shear, eta * shear,
         both * shear]
    )  # fmt: skip


def thickness(xi: float, eta: float) -> Array:
    """(4,) enhanced strains 33, each to be multiplied by zeta."""
    return np.array([1.0, xi, eta, xi * eta])


def _normals(xi: float, eta: float) -> Array:
    rows = np.zeros((3, 8))
    rows[:, 1::2] = bilinear(xi, eta)
    return rows


def _shear(xi: float, eta: float, direction: int) -> Array:
    """Twice the transverse shear strain at a point."""
    return product(shape(xi, eta)[direction], _normals(xi, eta)[0])


SCHEME = Scheme(2, shape, strains, membrane, thickness, (2, 2))
