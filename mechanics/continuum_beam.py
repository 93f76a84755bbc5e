"""Continuum ANCF beams with two nodes of 12 coordinates: r, r_x, r_y, r_z.

The beam as a small solid, in the shape functions of Yakoub & Shabana (2001): position
r(x) + y d2(x) + z d3(x), r a cubic Hermite polynomial, d2 = r_y and d3 = r_z linear, and Green's
strain of all six components, E = (F^T F - 1)/2, F from the curved reference. Two ways to make
an energy of it:

``beam3243-continuum``
    Naive, as it is usually printed (Hua et al. 2026): the full law of Hooke at every point of
    the volume. It locks, and no mesh helps: a section of straight, stiff directors cannot become
    narrow on its stretched side, so that bending meets lambda + 2 mu in place of E (Poisson
    thickness locking; Schwab & Meijaard 2010), 1.35 times too stiff at nu = 0.3. A temperature
    gradient bends it (1 + nu)/(1 - nu) times too far for the same reason.
``beam3243-enhanced``
    Enhanced continuum mechanics (Gerstmayr, Matikainen & Mikkola 2008): without Poisson's ratio
    in the volume, E diag(1, 1, 1) and shear moduli k2 G, k3 G, G, and what Poisson's ratio adds
    to the normal stresses on the axis only, times the area. It converges, with the square of the
    element, but slender and curved bodies need many: of the elastica (tip load 10 EI/L^2, 8
    elements) 1 % is missing at L/h = 10, 8 % at 100, 53 % at 1000; a quarter circle of R/h = 50
    moves by 17 % with 4 elements, by 98 % with 16. Two Gauss points along the length, which would
    cure this, leave motions without stiffness.

Both resist torsion with the polar moment, not the torsion constant of the section. They stand
beside ``beam3243``, which cures all this, for comparison.

Quadrature: five Gauss points along the length times the points of ``section_points``: exact for
a straight element of uniform temperature. A general section has the fourth moments of a rectangle.

Thermal strain: the strain is that from the thermally expanded body, (F^T F/s^2 - 1)/2 with the
stretch s (multiplicative split, see ``beam3243``), so moduli are divided by s. In the naive beam s
follows the temperature of each point in all directions; in the enhanced one the gradient acts
along the fibres only, for the section cannot follow it across.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import continuum_beam_kernels as kernels
from mechanics import line_elements as line
from mechanics.continuum_beam_kernels import FREE, PAIR, POINT
from mechanics.description import Beam
from mechanics.layout import Layout
from mechanics.section_points import section_points

Array = NDArray[np.float64]

_Z, _W = np.polynomial.legendre.leggauss(5)
XI, WEIGHT = 0.5 + 0.5 * _Z, 0.5 * _W
"""Gauss points along the length as fractions of it, and weights whose sum is 1."""

NORMAL = np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
TRACE = np.pad(np.ones((3, 3)), ((0, 3), (0, 3)))
SHEAR = np.diag([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
"""Laws (6, 6) for strains 11, 22, 33, 2 x 12, 2 x 13, 2 x 23."""


class ContinuumBeam:
    """All elements of one of the two families: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    names : name of the body of each element
    dofs : (n_e, 24) intp
    nodes : (n_e, 2) intp  rows of the section temperatures
    length : (n_e,) float [m]  arc length in the reference configuration
    ints, floats : see ``continuum_beam_kernels``
    """

    def __init__(self, beams: Sequence[Beam], layout: Layout, enhanced: bool):
        self.name = "beam3243-enhanced" if enhanced else "beam3243-continuum"
        self._enhanced = enhanced
        self.names = [str(name) for name in line.per_element(beams, [b.name for b in beams])]
        self.ints = line.pairs([layout.node_dofs[b.name] for b in beams]).astype(np.int64)
        self.dofs = (self.ints[:, :, None] + np.arange(12)).reshape(-1, 24).astype(np.intp)
        self.nodes = line.pairs([layout.point_index[b.name] for b in beams])
        self._unheated = line.per_element(beams, [float(b.reference_temperature) for b in beams])
        self._groups = line.groups(beams)
        self._density = line.per_element(beams, [b.material.density for b in beams])
        X = layout.q0[self.dofs].reshape(-1, 8, 3)
        self.length = line.arc_lengths(X[:, [0, 4]], X[:, [1, 5]])
        self._points = line.per_element(beams, list(_points(beams, enhanced)))
        self._on_axis = line.per_element(beams, list(_on_axis(beams, enhanced)))
        tau = line.per_element(beams, [float(b.damping_time) for b in beams])
        factors = [(b.section.shear_factor_2, b.section.shear_factor_3) for b in beams]
        laws = _laws(np.asarray(line.per_element(beams, factors)), self._on_axis, enhanced)
        self._volume, constants = _constants(X, self.length, self._points, laws)
        self.floats = np.column_stack([tau, constants.reshape(len(X), -1)])
        self.symmetric = not tau.any()
        self.signals: list = []
        self.force, self.tangent = kernels.add_force, kernels.add_tangent
        self.energy = kernels.add_energies

    def coefficients(self, T: Array) -> Array:
        """Moduli, free squares and their rates (zero) of all points, (n_e, 8 k), smooth in T."""
        xi, y, z = self._points[:, :, 0], self._points[:, :, 1], self._points[:, :, 2]
        ends = T[self.nodes]
        at = ends[:, :1] + xi[:, :, None] * (ends[:, 1:] - ends[:, :1])
        away = y * at[:, :, 1] + z * at[:, :, 2]
        E, nu, section, fibre = np.empty((4, *xi.shape))
        for material, e in self._groups:
            local, mean = at[e, :, 0] + away[e], at[e, :, 0]
            E[e], nu[e] = material.youngs_modulus(local), material.poissons_ratio(local)
            fibre[e] = 1.0 + material.thermal_strain(local, self._unheated[e, None])
            if self._enhanced:
                section[e] = 1.0 + material.thermal_strain(mean, self._unheated[e, None])
                fibre[e] = section[e] + material.expansion(mean) * away[e]
        section = section if self._enhanced else fibre
        moduli = [m / fibre for m in self._moduli(E, nu)]
        free = np.stack([fibre**2, section**2, fibre * section], axis=-1).reshape(len(E), -1)
        return np.hstack([*moduli, free, np.zeros_like(free)])

    def _moduli(self, E: Array, nu: Array) -> list[Array]:
        """The two moduli of each point, both (n_e, k) [Pa]."""
        G = 0.5 * E / (1.0 + nu)
        lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        if not self._enhanced:
            return [lame, G]
        return [np.where(self._on_axis, lame, E), np.where(self._on_axis, 2.0 * nu * lame, G)]

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        k = self._points.shape[1]
        return line.with_rates(c0, c1, h, slice(2 * k, 5 * k), slice(5 * k, 8 * k))

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """Section resultants N, Q2, Q3, Mt, M2, M3 of each element, (n_e, 6) [N, N m].

        Means over the element, damping included; signs as in ``beam3243``.
        """
        count, k = self._points.shape[:2]
        row = self.floats[:, 1:].reshape(count, k, POINT)
        weights = row[:, :, :24].reshape(count, k, 3, 8)
        u, w = (
            np.einsum("epmk,eki->epmi", weights, q[self.dofs].reshape(-1, 8, 3)) for q in (y, v)
        )
        free = coef[:, 2 * k :].reshape(count, 2, k, 3)[:, :, :, FREE] * row[:, None, :, 24:30]
        viscous = _products(u, w) + _products(w, u) - free[:, 1]
        excess = _products(u, u) - free[:, 0] + self.floats[:, :1, None] * viscous
        law = np.einsum("emp,epmij->epij", coef[:, : 2 * k].reshape(count, 2, k),
                        row[:, :, 30:].reshape(count, k, 2, 6, 6))  # fmt: skip
        S = np.einsum("epij,epj->epi", law, excess)
        y2, y3 = self._points[:, :, 1], self._points[:, :, 2]
        turning = [y2 * S[:, :, 4] - y3 * S[:, :, 3], -y2 * S[:, :, 0], -y3 * S[:, :, 0]]
        parts = [S[:, :, 0], S[:, :, 3], S[:, :, 4], *turning]
        return np.stack([part.sum(axis=1) for part in parts], axis=1) / self.length[:, None]

    def mass_blocks(self) -> Array:
        """(n_e, 24, 24) consistent mass of the volume."""
        N = _position_weights(self._points, self.length)
        volume = np.where(self._on_axis, 0.0, self._volume) * self._density[:, None]
        return line.in_space(np.einsum("ep,epi,epj->eij", volume, N, N))


def build_naive(beams: Sequence[Beam], layout: Layout) -> ContinuumBeam:
    """One term for all ``beams``: full law in the volume."""
    return ContinuumBeam(beams, layout, False)


def build_enhanced(beams: Sequence[Beam], layout: Layout) -> ContinuumBeam:
    """One term for all ``beams``: enhanced continuum mechanics."""
    return ContinuumBeam(beams, layout, True)


def _products(a: Array, b: Array) -> Array:
    """(n_e, k, 6) products of vectors (n_e, k, 3, 3) in the order of g, half for equal ones."""
    left = np.einsum("epki,epki->epk", a[:, :, PAIR[:, 0]], b[:, :, PAIR[:, 1]])
    right = np.einsum("epki,epki->epk", a[:, :, PAIR[:, 1]], b[:, :, PAIR[:, 0]])
    return np.array([0.25, 0.25, 0.25, 0.5, 0.5, 0.5]) * (left + right)


def _points(beams: Sequence[Beam], enhanced: bool) -> Array:
    """(n_b, k, 4) fraction of the length, y, z [m], weight [m^2]; unused ones weigh nothing."""
    lists: list[Array] = []
    for beam in beams:
        places, areas = section_points(beam.section)
        if enhanced:  # last, for each fraction of the length, a point on the axis
            places = np.vstack([places, np.zeros((1, 2))])
            areas = np.append(areas, beam.section.area)
        rows = [np.column_stack([np.full(len(areas), x), places, w * areas])
                for x, w in zip(XI, WEIGHT, strict=True)]  # fmt: skip
        lists.append(np.concatenate(rows))
    points = np.zeros((len(beams), max(map(len, lists), default=0), 4))
    for i, part in enumerate(lists):
        points[i, : len(part)] = part
    return points


def _on_axis(beams: Sequence[Beam], enhanced: bool) -> NDArray[np.bool_]:
    """(n_b, k) whether a point of the enhanced beam carries what Poisson's ratio adds."""
    which = np.zeros(_points(beams, enhanced).shape[:2], bool)
    for i, beam in enumerate(beams if enhanced else ()):
        period = len(section_points(beam.section)[1]) + 1
        which[i, period - 1 : len(XI) * period : period] = True
    return which


def _laws(factors: Array, on_axis: NDArray[np.bool_], enhanced: bool) -> Array:
    """(n_e, k, 2, 6, 6) matrices that multiply the two moduli, in local Cartesian directions."""
    laws = np.empty((*on_axis.shape, 2, 6, 6))
    if not enhanced:
        laws[:] = TRACE, 2.0 * NORMAL + SHEAR
        return laws
    laws[:, :, 0] = np.where(on_axis[:, :, None, None], TRACE - NORMAL, NORMAL)
    shear = np.zeros((len(factors), 1, 6, 6))
    shear[:, 0, [3, 4], [3, 4]] = factors
    shear[:, 0, 5, 5] = 1.0
    laws[:, :, 1] = np.where(on_axis[:, :, None, None], NORMAL, shear)
    return laws


def _position_weights(points: Array, length: Array) -> Array:
    """(n_e, k, 8) weights of the nodal vectors in the position of a point."""
    x, y, z = points[:, :, 0], points[:, :, 1], points[:, :, 2]
    L, far = length[:, None], x * x * (3.0 - 2.0 * x)
    first = [1.0 - far, L * x * (1.0 - x) ** 2, y * (1.0 - x), z * (1.0 - x)]
    return np.stack([*first, far, L * x * x * (x - 1.0), y * x, z * x], axis=-1)


def _vector_weights(points: Array, length: Array) -> Array:
    """(n_e, k, 3, 8) weights of the nodal vectors in t = dr/dx + y d2' + z d3', d2 and d3."""
    x, y, z = points[:, :, 0], points[:, :, 1], points[:, :, 2]
    L, weights = length[:, None], np.zeros((*x.shape, 3, 8))
    chord, first, last = np.moveaxis(line.tangent_weights(x), -1, 0)
    axis = [-chord / L, first, -y / L, -z / L, chord / L, last, y / L, z / L]
    weights[:, :, 0] = np.stack(axis, axis=-1)
    for m, k in ((1, 2), (2, 3)):
        weights[:, :, m, k], weights[:, :, m, k + 4] = 1.0 - x, x
    return weights


def _constants(X: Array, length: Array, points: Array, laws: Array) -> tuple[Array, Array]:
    """Volumes (n_e, k) [m^3] and the rows (n_e, k, POINT) of the points."""
    weights = _vector_weights(points, length)
    u = np.einsum("epmk,eki->epmi", weights, X)
    metric = _products(u, u)
    volume = points[:, :, 3] * length[:, None] * np.linalg.det(u)
    # strains in Cartesian directions: e1 normal to the section, e2 along d2
    e2 = u[:, :, 1] / np.linalg.norm(u[:, :, 1], axis=-1, keepdims=True)
    e1 = np.cross(u[:, :, 1], u[:, :, 2])
    e1 /= np.linalg.norm(e1, axis=-1, keepdims=True)
    frame = np.stack([e1, e2, np.cross(e1, e2)], axis=-2)
    A = np.linalg.inv(np.einsum("epai,epmi->epam", frame, u))
    turn = _strain_transform(A)
    P = np.einsum("ep,epki,epmkl,eplj->epmij", volume, turn, laws, turn)
    rows = [weights.reshape(*volume.shape, 24), metric, P.reshape(*volume.shape, 72)]
    return volume, np.concatenate(rows, axis=-1)


def _strain_transform(A: Array) -> Array:
    """(n_e, k, 6, 6): components (11, 22, 33, 2 x 12, ...) of A^T M A from those of M."""
    unit = np.zeros((6, 3, 3))
    for k, (a, b) in enumerate(PAIR):
        unit[k, a, b] = unit[k, b, a] = 1.0 if a == b else 0.5
    turned = np.einsum("epia,kij,epjb->epkab", A, unit, A)
    twice = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    return twice[:, None] * np.swapaxes(turned[:, :, :, PAIR[:, 0], PAIR[:, 1]], -1, -2)
