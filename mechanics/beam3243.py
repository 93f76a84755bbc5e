"""Shear-deformable ANCF beam with two nodes of 12 coordinates: r, r_x, d2 = r_y, d3 = r_z.

Cubic Hermite axis, directors d2 and d3 linear between the nodes. The 24 coordinates less the
six rigid motions leave 18 strains, each of them objective:

==================  ====================================================  =================
strain              generalised strain (dimensionless)                    stiffness
==================  ====================================================  =================
axial (3)           Legendre coefficients of                              EA L (1, 3, 5 s)
                    (r'.r' - 1 - G_2^2 - G_3^2)/2; of the linear one
                    also sqrt(3)/240 (c_2^2 + c_3^2 - b_2^2 - b_3^2)
bending (2 x 2)     B_k = b_k + m_2 m_3 b_m/12 at two Gauss points,       EI_k/(2 L)
                    b_k = (L r''.n_k - G_k(L) + G_k(0) +- turn G_m)/G_1
                    k, m = 2, 3 (+) and 3, 2 (-); m_k mean of b_k
shear (2 x 2)       G_k = r_x.n_k at the nodes, linear between            k_s GA L/2
torsion (1)         turn (1 + (turn^2 + m_2^2 + m_3^2)/6)                 GJ/L
                    - sqrt(3)/12 (B_2 C_3 - B_3 C_2), with
                    turn = (d3(0).d2(L) - d2(0).d3(L))/2
section (2 x 3)     (d_k.d_k - 1)/2 and d2.d3 at the nodes                EA L/2, GA L/2
==================  ====================================================  =================

with n_k = d_k/|d_k|, G_1 = (r'.r' - G_2^2 - G_3^2)^1/2, and b and c (B and C) the bending at the
first and second point. The measured strain is the difference to the reference configuration,
itself expanded by the thermal strain, so that a free uniform expansion of a curved, twisted beam
is free of stress to round-off. The elastic energy is
1/2 sum stiffness (strain)^2, at the turn phi of the section between the nodes where it is least:
B_2 + phi B_3 and B_3 - phi B_2 replace the bending, and 6 GJ/L phi^2 is added.

Sources: strains of a beam rather than of a continuum, Gerstmayr & Irschik (2008) and
Nachbagauer, Gruber & Gerstmayr (2013); critique of the continuum beam, Schwab & Meijaard
(2010); shear at the nodes (assumed natural strain), Dvorkin & Bathe (1984). The combination is
this project's own. It converges to the rod of Reissner (1981) and Simo (1985), but for the axial
strain, which is Green's Gamma_1 + Gamma_1^2/2:

- The section turns by -n_1.n_k' = (r''.n_k - (r'.n_k)' +- tau r'.n_m)/(r'.n_1), exactly; b_k is
  this, with r'.n_k interpolated between the nodes. The division makes it a turn per *reference*
  length, conjugate to the moment when the axis stretches, and leaves it unchanged by a uniform
  expansion. Without the term in tau a moment on a twisted beam would make a shear force;
  without n_k of unit length the reaction at a clamp would stretch the section.
- Directors between the nodes are linear, hence at right angles only where bending is in one
  plane: d_2.d_3 = -m_2 m_3/6 at both points. B_k is the bending of n_k + m_2 m_3 n_m/12, made
  orthonormal symmetrically (Loewdin 1950), but for terms of fourth order.
- ``turn`` is the sine of a turn whose size also bending makes: theta/sin(theta), to fourth order.
- The turn of one end against the other is not the integral of the torsion when the direction of
  bending changes along the element (Magnus 1954); the difference makes torsion of fourth order.
- Where bending stiffness differs, two moments twist the beam between the nodes,
  Mt' = kappa_2 M_3 - kappa_3 M_2. This turn, a parabola, is the internal coordinate phi: an error
  of second order without it.
- The cubic through points of an inextensible curve stretches, linearly by - kappa kappa' L^3/120.
  Taken out of the axial strain, it leaves tangents at the nodes of unit length; with it they
  would lock or grow along the beam. The quadratic part, of fourth order, is relieved: ``MEMBRANE``.
- The directors' stretch is stiff (EA): the section follows the thermal expansion.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import beam3243_kernels as kernels
from mechanics import line_elements as line
from mechanics.beam3243_tables import AXIAL, BENDING, MAGNUS, SECTION, SHEAR, STRAINS, TORSION
from mechanics.description import Beam
from mechanics.layout import Layout
from mechanics.prediction import shifted

Array = NDArray[np.float64]

STATIONS = np.concatenate([[0.0, 1.0], line.XI2, line.XI3])
"""Where the material is evaluated, as fractions of the length."""

MEMBRANE = 1024.0
"""Stiffness of the quadratic axial strain relative to that of bending [-].

Errors of the elastica (tip load 10 EI/L^2; 4 and 8 elements, radius of gyration 3e-3 L, and 8,
1e-4 L) and gap of the roll-up to a full circle (4 and 8 elements); the part s = MEMBRANE r^2/L^2
<= 1 of EA remains:

====  ================  =======  ================
32    1.5e-3, 1.4e-4    1.4e-4   7 %, .15 %
256   1.7e-3, 1.4e-4    1.5e-4   .14 %, .23 %
1024  2.1e-3, 1.4e-4    1.7e-4   .31 %, .24 %
4096  3.0e-3, 1.4e-4    2.5e-4   .42 %, .24 %
inf   3.5e-3, 1.4e-4    4.2e-3   .43 %, .24 %
====  ================  =======  ================
"""


class Beam3243:
    """All elements of this family in a scene.

    Attributes
    ----------
    name : of the family
    names : name of the body of each element
    dofs : (n_e, 24) intp
    ints : (n_e, 2) int64  first coordinates of both nodes
    floats : (n_e, 2) float  arc length in the reference [m], damping time [s]
    force, tangent, energy : addresses of the kernels
    nodes : (n_e, 2) intp  rows of the section temperatures
    length : (n_e,) float [m]  arc length in the reference configuration
    symmetric : bool  without damping, whose forces turn with the element
    """

    name = "beam3243"
    force, tangent, energy = kernels.add_force, kernels.add_tangent, kernels.add_energy

    def __init__(self, beams: Sequence[Beam], layout: Layout):
        self.names = [str(name) for name in line.per_element(beams, [b.name for b in beams])]
        start = line.pairs([layout.node_dofs[b.name] for b in beams])
        self.ints = np.ascontiguousarray(start, dtype=np.int64)
        self.dofs = (start[:, :, None] + np.arange(12)).reshape(-1, 24).astype(np.intp)
        self.nodes = line.pairs([layout.point_index[b.name] for b in beams])
        self.signals: list = []
        self._unheated = line.per_element(beams, [float(b.reference_temperature) for b in beams])
        self._groups = line.groups(beams)
        self._sections = line.per_element(beams, [_section_row(b) for b in beams])
        self._density = line.per_element(beams, [b.material.density for b in beams])
        reference = line.pairs([coordinates(b) for b in beams])
        self.length = line.arc_lengths(reference[:, :, :3], reference[:, :, 3:6])
        damping_time = line.per_element(beams, [float(b.damping_time) for b in beams])
        self.floats = np.column_stack([self.length, damping_time])
        self.symmetric = not damping_time.any()
        self._reference = _reference_strains(reference, self.floats)
        b2, c2, b3, c3 = self._reference[:, BENDING:SHEAR].T
        self._reference_turn = self._reference[:, TORSION] + MAGNUS * (b2 * c3 - b3 * c2)
        self._reference_sine = _sine(reference)
        slopes = line.tangents(reference[:, :, :3], reference[:, :, 3:6], self.length)
        self._reference_axial = line.half_square(slopes)
        area, I2, I3 = self._sections[:, :3].T
        bare = line.axial_coefficients(self._reference_axial)
        self._reference_bent = self._reference[:, AXIAL:BENDING] - bare
        self._slack = np.minimum(1.0, MEMBRANE * np.sqrt(I2 * I3) / (area * self.length**2))

    def coefficients(self, T: Array) -> Array:
        """Stiffness, free strain and its rate (zero) of each generalised strain, (n_e, 54).

        Smooth in T.
        """
        at = line.at_fractions(T[self.nodes], STATIONS)
        E, G, strain, expansion = np.empty((4, len(self.names), len(STATIONS)))
        for material, e in self._groups:
            mean = at[e, :, 0]
            E[e] = material.youngs_modulus(mean)
            G[e] = material.shear_modulus(mean)
            strain[e] = material.thermal_strain(mean, self._unheated[e, None])
            expansion[e] = material.expansion(mean)
        free = self._free_strains((1.0 + strain) ** 2, expansion[:, 2:4, None] * at[:, 2:4, 1:])
        return np.hstack([self._stiffness(E, G, 1.0 + strain), free, np.zeros_like(free)])

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        return line.with_rates(c0, c1, h, slice(STRAINS, 2 * STRAINS), slice(2 * STRAINS, None))

    def _stiffness(self, E: Array, G: Array, stretch: Array) -> Array:
        """(n_e, 18) stiffness of each generalised strain.

        The elastic strain is that from the thermally expanded body, whose length and section
        are the reference ones times powers of the thermal ``stretch`` s (n_e, 7) (multiplicative
        split; Stojanovic, Djuric & Vujosevic 1964; Lubarda 2004). Green's strains are s^2 times
        too large when measured from the reference, shear s times, turns are right; area, second
        moments and length grow with s^2, s^4 and s: energies change by 1/s, s and s^3.
        """
        A, I2, I3, J, k2, k3 = self._sections.T[:, :, None]
        half = 0.5 * self.length[:, None]
        ends, middle = stretch[:, :2], stretch[:, 5:6]
        E_bending = E[:, 2:4] * stretch[:, 2:4] ** 3 / (4.0 * half)
        shear, sliding = G[:, :2] * A * half * ends, G[:, :2] * A * half / ends
        section = E[:, :2] * A * half / ends
        torsion = G[:, 5:6] * J / (2.0 * half * middle)
        axial = line.axial_stiffness(E[:, 4:] * A / stretch[:, 4:], self.length, self._slack)
        bending = [E_bending * I2, E_bending * I3]
        return np.hstack(
            [axial, *bending, k2 * shear, k3 * shear, torsion, section, section, sliding]
        )

    def _free_strains(self, stretch: Array, curvature: Array) -> Array:
        """(n_e, 18) strains of the unstressed element.

        What is a product of vectors grows with the square ``stretch`` (n_e, 7) of the thermal
        stretch; bending changes by ``curvature`` (n_e, 2 points, 2), the gradients of the
        thermal strain: the warmer side becomes the outer one.
        """
        free = self._reference.copy()
        free[:, AXIAL:BENDING] = line.axial_coefficients(self._reference_axial * stretch[:, 4:])
        free[:, AXIAL:BENDING] += self._reference_bent
        turning = self.length[:, None, None] * curvature
        free[:, BENDING:SHEAR] -= turning.transpose(0, 2, 1).reshape(-1, 4)
        middle = stretch[:, 5]
        free[:, TORSION] += (middle - 1.0) * self._reference_turn
        free[:, TORSION] += (middle**3 - middle) * self._reference_sine**3 / 6.0
        free[:, SECTION:] *= np.tile(stretch[:, :2], 3)
        return free

    def predicted(self, coef: Array, y: Array, step: Array, new: Array) -> Array:
        """Coefficients with the stress that is predicted, see ``mechanics.prediction``."""
        return shifted(coef, slice(STRAINS, 2 * STRAINS), self._strains, y, step, new)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """Section resultants N, Q2, Q3, Mt, M2, M3 of each element, (n_e, 6) [N, N m].

        Means over the element, damping included. M_k is positive where the axis bends towards
        e_k: axial stress = N/A - M2 y/I2 - M3 z/I3.
        """
        strains, rates = self._strains(y, v)
        elastic = strains - coef[:, STRAINS : 2 * STRAINS]
        excess = elastic + self.floats[:, 1:] * (rates - coef[:, 2 * STRAINS :])
        S = coef[:, :STRAINS] * excess
        N = S[:, AXIAL] / self.length
        Q = S[:, SHEAR:TORSION].reshape(-1, 2, 2).sum(axis=2) / self.length[:, None]
        bending = S[:, BENDING:SHEAR].reshape(-1, 2, 2)
        B = strains[:, BENDING:SHEAR].reshape(-1, 2, 2)
        k = coef[:, BENDING:SHEAR].reshape(-1, 2, 2)
        phi = _between(k * elastic[:, BENDING:SHEAR].reshape(-1, 2, 2), B, k, coef[:, TORSION])
        M = (bending + phi * k * B[:, ::-1] * np.array([[1.0], [-1.0]])).sum(axis=2)
        return np.column_stack([N, Q, S[:, TORSION], M])

    def mass_blocks(self) -> Array:
        """(n_e, 24, 24) consistent mass: Hermite for r and r_x, linear for d2 and d3."""
        hermite = line.hermite_mass(self.length)
        A, I2, I3 = self._density * self._sections[:, :3].T
        linear = self.length[:, None, None] / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        scalar = np.zeros((len(self.names), 8, 8))
        scalar[:, [[0], [1], [4], [5]], [0, 1, 4, 5]] = A[:, None, None] * hermite
        scalar[:, [[2], [6]], [2, 6]] = I2[:, None, None] * linear
        scalar[:, [[3], [7]], [3, 7]] = I3[:, None, None] * linear
        return line.in_space(scalar)

    def _strains(self, y: Array, v: Array) -> tuple[Array, Array]:
        """Generalised strains and their rates, both (n_e, 18)."""
        strains, rates = np.empty((2, len(self.names), STRAINS))
        kernels.evaluate(y, v, self.ints, self.floats, strains, rates)
        return strains, rates


def build(beams: Sequence[Beam], layout: Layout) -> Beam3243:
    """One term for all ``beams``."""
    return Beam3243(beams, layout)


def coordinates(beam: Beam) -> Array:
    """(n, 12) reference coordinates r, r_x = e1, d2 = e2, d3 = e3 of each node."""
    n = len(beam.points)
    return np.hstack([beam.points, np.asarray(beam.axes).reshape(n, 9)])


def _section_row(beam: Beam) -> list[float]:
    s = beam.section
    moments = [s.area, s.second_moment_2, s.second_moment_3, s.torsion_constant]
    return [*moments, s.shear_factor_2, s.shear_factor_3]


def _reference_strains(reference: Array, floats: Array) -> Array:
    """(n_e, 18) strains at the reference."""
    n = len(reference)
    start = 24 * np.arange(n)[:, None] + np.array([0, 12])
    strains, rates = np.empty((2, n, STRAINS))
    q = reference.ravel()
    kernels.evaluate(q, np.zeros_like(q), start, floats, strains, rates)
    return strains


def _sine(x: Array) -> Array:
    """(n_e,) ``turn`` of elements with node coordinates (n_e, 2, 12)."""
    d2, d3 = x[:, :, 6:9], x[:, :, 9:12]
    return 0.5 * np.sum(d3[:, 0] * d2[:, 1] - d2[:, 0] * d3[:, 1], axis=1)


def _between(M: Array, B: Array, k: Array, torsion: Array) -> Array:
    """(n_e, 1, 1) the turn phi of the section between the nodes.

    M, B, k : (n_e, 2, 2) elastic moments, bending and its stiffness towards e2, e3, at two points
    torsion : (n_e,) GJ/L
    """
    slope = (M[:, 0] * B[:, 1] - M[:, 1] * B[:, 0]).sum(axis=1)
    stiffness = 12.0 * torsion + kernels.TINY + (k * B[:, ::-1] ** 2).sum(axis=(1, 2))
    return -(slope / stiffness)[:, None, None]
