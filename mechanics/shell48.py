"""Thin shell of Kirchhoff and Love on bicubic quadrilaterals; nodes carry r, r_u, r_v, r_uv.

Total Lagrangian. With a_ij = r_i.r_j and b_ij = n.r_ij the first and second fundamental form of
the surface, measured in orthonormal directions of the reference (so that a = I there), stretch
s = 1 + integral of alpha dT, and temperature gradient G along the normal n:

    membrane  e_ij = (a_ij - s^2 I_ij)/2                         stiffness  C/s
    bending   k_ij = b_ij - s (b_ij of the reference - alpha G I_ij)        s C h^2/12
    C = E h/(1 - nu^2) [[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu)/2]]

The energy is that of a St. Venant-Kirchhoff plate in plane stress, integrated over the thickness
to the second order (Koiter 1966; Ciarlet 2005). It is measured from the thermally expanded
surface: its form grows by s, the first fundamental form by s^2, the second by s, thickness and
area with it (multiplicative split: Stojanovic, Djuric & Vujosevic 1964; Lubarda 2004). A uniform
expansion of any curved shell is free of stress to round-off; so is any reference shape. The warmer
side becomes the outer one.

Bicubic elements cannot bend without membrane strain of high order, which would lock thin curved
shells: 20 % of the pinched hemisphere is missing on 4 x 4 elements. So the membrane energy is
that of 2 x 2 Gauss points, but for parts f of the stiffness (1 - nu) C diag(f1, f2, f12/2) that
see all strain (4 x 4 points), and keep the rank. The order of convergence stays that of bending,
h^4; on coarse meshes of very thin strips that bend far, 2 to 3 is observed. As in
beams (``line_elements``) f is in a fixed ratio to bending, in each direction:
f1 = ``MEMBRANE`` h^2/(12 a^2) <= 1, f2 the same with b, f12^2 = f1 f2.

The surface is continuously differentiable (bicubic Hermite functions: Bogner, Fox & Schmit 1965),
so that no rotations are needed. Shear deformation and rotary inertia are left out: both matter in
(h/wavelength)^2. Mass is constant. Damping is S = C (strain + time * strain rate): objective.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import line_elements as line
from mechanics import shell48_kernels as kernels
from mechanics.description import Shell
from mechanics.layout import Layout
from mechanics.prediction import shifted
from mechanics.shell48_kernels import (
    BENT,
    COLUMNS,
    ETA,
    MORE,
    PLACE,
    POINTS,
    STRETCH,
    STRETCHING,
    TABLE,
    WEIGHTS,
    WIDTH,
    XI,
    shapes,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

MEMBRANE = 64.0
"""Stiffness of membrane strain that reduced points do not see, relative to that of bending [-].

It must exceed pi^2/(1 - nu), or a strip would buckle inside its elements before it does as a
whole; where it is small, false modes in the plane come near those of bending of one element.
Errors of the cantilever under end shear (8 elements), the hemisphere (4 x 4, outward), the free
ring (16 elements, two waves), and the first axial frequency of a strip (4 elements of 25 h):

=====  ======  ======  =====  ======
32     .028 %  2.3 %   .38 %  1.8 %
64     .042 %  2.6 %   .60 %  .27 %
128    .059 %  3.0 %   .93 %  .10 %
full   .080 %  20 %    2.3 %  0
=====  ======  ======  =====  ======
"""

CORNERS = np.stack([(1 - XI) * (1 - ETA), XI * (1 - ETA), XI * ETA, (1 - XI) * ETA], axis=1)
"""(20, 4) bilinear weights of the corners at the points."""


class Shell48:
    """All elements of this family in a scene; see ``mechanics.kernels`` for what a term is.

    Attributes
    ----------
    names : name of the body of each element
    dofs : (n_e, 48) intp
    nodes : (n_e, 4) intp  rows of the section temperatures
    """

    name = "shell48"
    force, tangent, energy = kernels.add_force, kernels.tangent, kernels.energy
    signals: tuple = ()

    def __init__(self, shells: Sequence[Shell], layout: Layout):
        _check(shells)
        quads = [len(s.surface.quads) for s in shells]
        self.names = [s.name for s, count in zip(shells, quads, strict=True) for _ in range(count)]
        self.ints = np.concatenate([layout.node_dofs[s.name][s.surface.quads] for s in shells])
        self.ints = np.ascontiguousarray(self.ints, np.int64)
        self.dofs = (self.ints[:, :, None] + np.arange(12)).reshape(-1, 48).astype(np.intp)
        self.nodes = np.concatenate([layout.point_index[s.name][s.surface.quads] for s in shells])
        self.symmetric = all(s.damping_time == 0.0 for s in shells)
        own = [[s.thickness, s.damping_time, s.reference_temperature] for s in shells]
        self._thickness, time, self._unheated = np.repeat(own, quads, axis=0).T
        sizes = np.concatenate([s.surface.sizes for s in shells])
        self._density = np.repeat([s.material.density for s in shells], quads)
        self._groups = _groups(shells, quads)
        table = _reference(layout.q0[self.dofs].reshape(-1, 16, 3), sizes, self.names)
        slenderness = self._thickness[:, None] ** 2 / (12.0 * sizes**2)
        shares = np.minimum(1.0, MEMBRANE * slenderness)
        shares = np.column_stack([shares, np.sqrt(shares.prod(axis=1))])
        points = table.reshape(len(sizes), -1)
        self.floats = np.hstack([sizes, time[:, None], shares, points])

    def coefficients(self, T: Array) -> Array:
        """Stiffness, Poisson's ratio, thermal stretch, free bending at all points, (n_e, 260).

        The other columns, rates of the free strains and further ones (``MORE``), are zero.
        Temperatures are interpolated bilinearly inside the element. Smooth in T.
        """
        at = np.einsum("gc,eci->egi", CORNERS, T[self.nodes])
        E, nu, strain, expansion = np.empty((4, len(self.names), POINTS))
        for material, e in self._groups:
            mean = at[e, :, 0]
            E[e], nu[e] = material.youngs_modulus(mean), material.poissons_ratio(mean)
            strain[e] = material.thermal_strain(mean, self._unheated[e, None])
            expansion[e] = material.expansion(mean)
        s, h = 1.0 + strain, self._thickness[:, None]
        C = E * h / (1.0 - nu**2)
        free = s * expansion * at[:, :, 2]
        bending = C * s * h**2 / 12.0
        bending[:, BENT:] = 0.0
        parts = C / s, bending, nu, s, free
        return np.hstack([*parts, np.zeros((len(s), 8 * POINTS))])

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        strains, rates = (STRETCH, STRETCHING), (STRETCHING, COLUMNS)
        cut = [slice(a * POINTS, b * POINTS) for a, b in (strains, rates)]
        return line.with_rates(c0, c1, h, *cut)

    def predicted(self, coef: Array, y: Array, step: Array, new: Array) -> Array:
        """Coefficients with the stress that is predicted, see ``mechanics.prediction``."""
        return shifted(coef, slice(MORE, None), self._strains, y, step, new)

    def mass_blocks(self) -> Array:
        """(n_e, 48, 48) consistent mass."""
        a, b = self.floats[:, :2].T
        nodal = np.tile(np.stack([np.ones_like(a), a, b, a * b], axis=1), 4)
        N = shapes(XI, ETA, 0, 0)[:BENT]
        weight = (self._density * self._thickness)[:, None] * self._points()[:, :BENT, 0]
        scalar = np.einsum("eg,gi,gj->eij", weight, N, N) * nodal[:, :, None] * nodal[:, None]
        return line.in_space(scalar)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """N11 N22 N12 [N/m], M11 M22 M12 [N m/m], Q1 Q2 [N/m] of each element, (n_e, 8).

        Means over the element, damping included. Direction 1 is that of r_u, 2 is across it. M is
        positive where the surface bends towards its normal: stress = N/h - 12 M z/h^3. Q follows
        from equilibrium, Q_i = -M_ij,j, with the mean slopes of M.
        """
        S = np.empty((len(self.names), POINTS, 6))
        kernels.stresses(y, v, coef, self.ints, self.floats, S)
        mean = np.einsum("g,egr->er", WEIGHTS, S)
        slopes = [12.0 * np.einsum("g,egr->er", WEIGHTS * (x - 0.5), S) for x in (XI, ETA)]
        T, U, V = 0.5 * np.einsum("g,egk->ke", WEIGHTS, self._points()[:, :, 1:4])[:, :, None]
        along, across = T * slopes[0], U * slopes[0] + V * slopes[1]
        Q = -along[:, [3, 5]] - across[:, [5, 4]]
        return np.hstack([mean, Q])

    def _strains(self, y: Array, v: Array) -> tuple[Array, Array]:
        """Strains at all points, free ones included, and their rates, both (n_e, 120)."""
        strains, rates = np.empty((2, len(self.names), 6 * POINTS))
        kernels.evaluate(y, v, self.ints, self.floats, strains, rates)
        return strains, rates

    def _points(self) -> Array:
        """(n_e, 20, 7) what each point needs."""
        return self.floats[:, PLACE:].reshape(len(self.names), POINTS, WIDTH)


def build(shells: Sequence[Shell], layout: Layout) -> Shell48:
    """One term for all ``shells``."""
    return Shell48(shells, layout)


def _check(shells: Sequence[Shell]) -> None:
    for shell in shells:
        if not (np.isfinite(shell.thickness) and shell.thickness > 0.0):
            raise ValueError(f"shell {shell.name!r}: its thickness must be positive")


def _groups(shells: Sequence[Shell], quads: Sequence[int]) -> list[line.Group]:
    """The elements of each distinct material."""
    owner = np.repeat([id(s.material) for s in shells], quads)
    distinct = {id(s.material): s.material for s in shells}
    return [line.Group(m, np.flatnonzero(owner == key)) for key, m in distinct.items()]


def _reference(X: Array, sizes: Array, names: Sequence[str]) -> Array:
    """(n_e, 20, 7) weight [m^2], T, U, V, curvatures [1/m] at all points of the reference.

    With x, y the parameters as fractions of the element, r_1 = T r_x and r_2 = U r_x + V r_y are
    orthonormal, r_1 along r_x.
    """
    a, b = sizes.T
    nodal = np.tile(np.stack([np.ones_like(a), a, b, a * b], axis=1), 4)
    x, y, xx, yy, xy = np.einsum("gpi,eik->pegk", TABLE, nodal[:, :, None] * X)
    m = np.cross(x, y)
    upright = np.einsum("egk,ek->eg", m, m.mean(axis=1)) > 0.0
    if not upright.all():
        bad = names[int(np.argmin(upright.all(axis=1)))]
        raise ValueError(f"shell {bad!r}: an element has no area or is folded")
    area, length = np.linalg.norm(m, axis=2), np.linalg.norm(x, axis=2)
    n = m / area[:, :, None]
    T, V = 1.0 / length, length / area
    U = -V * np.einsum("egk,egk->eg", x, y) / length**2
    bxx, byy, bxy = (np.einsum("egk,egk->eg", n, c) for c in (xx, yy, xy))
    b22 = U * U * bxx + 2.0 * U * V * bxy + V * V * byy
    bending = [T * T * bxx, b22, 2.0 * T * (U * bxx + V * bxy)]
    return np.stack([area * WEIGHTS, T, U, V, *bending], axis=2)
