"""Fully parametrised shell with four nodes of 12 coordinates: r, r_u, r_v, r_n.

Incomplete cubics in the surface, linear through the thickness (Mikkola & Shabana 2003). Taken
literally, with the strains of the continuum at many points, it locks (``build_naive``): r_n can
not follow the turn of the surface, and can not vary through the thickness as Poisson's effect asks.

The cure keeps all slopes in play, unlike transverse shear from the sides of the element, which
leaves r_u, r_v of the nodes loose:

- transverse shear and the stretch of r_n from the nodes: g_1 = r_u.r_n and g_2 = r_v.r_n bilinear
  (linear shear as in Gruber, Nachbagauer & Irschik 2013 and Valkeapaa et al. 2015);
- bending from the surface and from this shear, r_u.n_u = g_1,u - r_uu.n, and likewise for v and
  the twist (2 r_uv.n); with g = 0 it is Kirchhoff's plate of Adini & Clough (1961);
- enhanced strain through the thickness, linear in zeta (Buechter, Ramm & Roehl 1994).

All of it is sums of products of nodal vectors: rigid motion stays free of strain.
"""

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from mechanics.description import Shell
from mechanics.layout import Layout
from mechanics.shell_integrals import CORNERS, Scheme, bilinear, normal_squares, product
from mechanics.shell_solid import SolidShell

Array = NDArray[np.float64]

NODE = 4
"""Vectors of a node."""


def build(shells: Sequence[Shell], layout: Layout) -> SolidShell:
    """One term for all ``shells``, cured."""
    return SolidShell("shell3443", SCHEME, shells, layout)


def build_naive(shells: Sequence[Shell], layout: Layout) -> SolidShell:
    """One term for all ``shells``, the continuum taken literally; it locks."""
    return SolidShell("shell3443-continuum", NAIVE, shells, layout)


def shape(xi: float, eta: float) -> Array:
    """(3, 16) weights of all vectors in r and its slopes by xi and eta."""
    return np.stack([_cubic(xi, eta, d) for d in ((0, 0), (1, 0), (0, 1))])


def unit_shapes(x: Array, y: Array, i: int, j: int) -> Array:
    """(n, 12) derivatives, i by x and j by y, of the cubics of r, r_x, r_y on the unit square."""
    points = zip(2.0 * x - 1.0, 2.0 * y - 1.0, strict=True)
    rows = np.array([_cubic(xi, eta, (i, j)) for xi, eta in points]).reshape(-1, 4, NODE)
    return 2.0 ** (i + j) * (rows[:, :, :3] * [1.0, 0.5, 0.5]).reshape(-1, 12)


def naive_strains(xi: float, eta: float) -> Array:
    """(3, 6, 120) covariant strains of the continuum, see ``shell_integrals.Scheme``."""
    _, r1, r2 = shape(xi, eta)
    n, n1, n2 = _normals(xi, eta)
    E = _surface_strains(xi, eta)
    E[1, 0], E[1, 1] = product(r1, n1), product(r2, n2)
    E[1, 3] = product(r1, n2) + product(r2, n1)
    E[0, 2] = 0.5 * product(n, n)
    E[0, 4], E[0, 5] = product(r1, n), product(r2, n)
    E[1, 4], E[1, 5] = product(n1, n), product(n2, n)
    return E


def strains(xi: float, eta: float) -> Array:
    """(3, 6, 120) covariant strains with shear and director from the nodes."""
    n = _normals(xi, eta)[0]
    N = bilinear(xi, eta)
    r11, r22, r12 = (_cubic(xi, eta, d) for d in ((2, 0), (0, 2), (1, 1)))
    g1, g2 = _nodal_shear(1), _nodal_shear(2)
    E = _surface_strains(xi, eta)
    E[1, 0], E[1, 1] = N[1] @ g1 - product(r11, n), N[2] @ g2 - product(r22, n)
    E[1, 3] = N[2] @ g1 + N[1] @ g2 - 2.0 * product(r12, n)
    E[0, 2] = 0.5 * normal_squares(NODE, N[0])
    E[0, 4], E[0, 5] = N[0] @ g1, N[0] @ g2
    E[1, 4], E[1, 5] = 0.5 * normal_squares(NODE, N[1]), 0.5 * normal_squares(NODE, N[2])
    return E


def thickness(xi: float, eta: float) -> Array:
    """(4,) enhanced strains 33, each to be multiplied by zeta."""
    return np.array([1.0, xi, eta, xi * eta])


def _surface_strains(xi: float, eta: float) -> Array:
    _, r1, r2 = shape(xi, eta)
    _, n1, n2 = _normals(xi, eta)
    E = np.zeros((3, 6, 120))
    E[0, 0], E[2, 0] = 0.5 * product(r1, r1), 0.5 * product(n1, n1)
    E[0, 1], E[2, 1] = 0.5 * product(r2, r2), 0.5 * product(n2, n2)
    E[0, 3], E[2, 3] = product(r1, r2), product(n1, n2)
    return E


def _nodal_shear(direction: int) -> Array:
    """(4, 120) slope by xi or eta times normal at each node."""
    unit = np.eye(4 * NODE)
    return np.stack([product(unit[NODE * i + direction], unit[NODE * i + 3]) for i in range(4)])


def _normals(xi: float, eta: float) -> Array:
    rows = np.zeros((3, 4 * NODE))
    rows[:, NODE - 1 :: NODE] = bilinear(xi, eta)
    return rows


def _none(xi: float, eta: float) -> Array:
    return np.zeros((0, 3))


def _rigid(xi: float, eta: float) -> Array:
    return np.zeros(0)


def _cubic(xi: float, eta: float, order: tuple[int, int]) -> Array:
    """(16,) derivative of the incomplete cubics of Mikkola & Shabana (2003), eq. 7.

    With a = x xi, b = y eta at the node (x, y): r carries (1+a)(1+b)(2+a+b-xi^2-eta^2)/8, the
    slopes by xi x(1+a)^2(a-1)(1+b)/8, and by eta likewise.
    """
    rows = np.zeros(4 * NODE)
    for node, (x, y) in enumerate(CORNERS):
        line = Polynomial([1.0, x]), Polynomial([1.0, y])
        # (2 + a + b - xi^2 - eta^2): one part belongs to xi and one to eta
        arch = [p * Polynomial([1.0, s, -1.0]) / 8.0 for p, s in zip(line, (x, y), strict=True)]
        slope = [Polynomial([-s, -1.0, s, 1.0]) / 8.0 for s in (x, y)]
        along, across = (_at((f[0], line[1]), xi, eta, order) for f in (arch, slope))
        rows[NODE * node] = along + _at((line[0], arch[1]), xi, eta, order)
        rows[NODE * node + 1] = across
        rows[NODE * node + 2] = _at((line[0], slope[1]), xi, eta, order)
    return rows


def _at(pair, xi: float, eta: float, order: tuple[int, int]) -> float:
    first, second = pair[0].deriv(order[0]), pair[1].deriv(order[1])
    return float(first(xi) * second(eta))


SCHEME = Scheme(NODE, shape, strains, _none, thickness, (3, 2))
NAIVE = Scheme(NODE, shape, naive_strains, _none, _rigid, (4, 3))
