"""Shear-deformable ANCF beam with three nodes of 9 coordinates: r, r_y, r_z; for verification.

The element of Nachbagauer, Pechstein, Irschik & Gerstmayr (2011) and Nachbagauer, Gruber &
Gerstmayr (2013) in its structural mechanics form: axis and directors d2 = r_y, d3 = r_z are
quadratic, the strains are those of Reissner (1981) and Simo & Vu-Quoc (1986) about a section
whose normal is n = d2 x d3/|d2 x d3|,

- axial t.n - 1, shear t.d_k/|d_k|, bending -n.d_k'/|d_k| and torsion
  (d2'.d3 - d3'.d2)/(2 |d2| |d3|), with t = dr/dx, all at two Gauss points (reduced), which
  keeps a quadratic element from locking;
- stretch and shear of the section, (d_k.d_k - 1)/2 and d2.d3, at the three nodes (Lobatto).

2 x 6 + 3 x 3 strains are the 27 coordinates less six rigid motions. One deviation from the
papers: shear is measured along d2 and d3 themselves, made of unit length, rather than along an
orthonormal triad built from them, so that neither is preferred; the difference is the product of
shear and of the section's own shear, which is stiff.

A body has 2 n_e + 1 points; the middle node of an element is between its ends. The strain is
counted from the reference, thermally expanded: see ``beam3243``. Material properties follow the
temperature at the points of integration, interpolated quadratically from the nodes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechanics import beam3333_kernels as kernels
from mechanics import line_elements as line
from mechanics.beam3333_kernels import GAUSS, STRAINS
from mechanics.description import Beam
from mechanics.layout import Layout
from mechanics.prediction import shifted
from meshes.materials import Material

Array = NDArray[np.float64]

STATIONS = np.concatenate([GAUSS, [-1.0, 0.0, 1.0]])
"""Points of integration in -1 to 1: two Gauss points, three nodes."""
WEIGHTS = np.array([1.0, 1.0, 1.0 / 3.0, 4.0 / 3.0, 1.0 / 3.0])


class Beam3333:
    """All elements of this family in a scene: a term, see ``mechanics.kernels``.

    Attributes
    ----------
    names : name of the body of each element
    dofs : (n_e, 27) intp
    nodes : (n_e, 3) intp  rows of the section temperatures
    length : (n_e,) float [m]  arc length in the reference configuration
    ints, floats : see ``beam3333_kernels``
    """

    name = "beam3333"

    def __init__(self, beams: Sequence[Beam], layout: Layout):
        self.names = [str(name) for name in _spread(beams, [b.name for b in beams])]
        self.ints = _triples([layout.node_dofs[b.name] for b in beams]).astype(np.int64)
        self.dofs = (self.ints[:, :, None] + np.arange(9)).reshape(-1, 27).astype(np.intp)
        self.nodes = _triples([layout.point_index[b.name] for b in beams])
        self._unheated = _spread(beams, [float(b.reference_temperature) for b in beams])
        self._groups = _materials(beams)
        self._sections = _spread(beams, [_section_row(b) for b in beams])
        self._density = _spread(beams, [b.material.density for b in beams])
        axis = layout.q0[self.dofs].reshape(-1, 3, 3, 3)[:, :, 0]
        self._slope = _slopes(axis, STATIONS)
        self._mass_slope = _slopes(axis, line.XI3 * 2.0 - 1.0)
        self.length = self._mass_slope @ (2.0 * line.WEIGHT3)
        tau = _spread(beams, [float(b.damping_time) for b in beams])
        derivatives = shape_slopes(GAUSS) / self._slope[:, :2, None]
        self.floats = np.column_stack([tau, derivatives.reshape(-1, 6)])
        self._reference = self._strains(layout.q0, np.zeros_like(layout.q0))[0]
        self.symmetric = not tau.any()
        self.signals: list = []
        self.force, self.tangent = kernels.add_force, kernels.add_tangent
        self.energy = kernels.add_energies

    def coefficients(self, T: Array) -> Array:
        """Stiffness, free strain and its rate (zero) of each strain, (n_e, 63), smooth in T."""
        at = np.einsum("pn,enk->epk", shapes(STATIONS), T[self.nodes])
        E, G, stretch, expansion = np.empty((4, *at.shape[:2]))
        for material, e in self._groups:
            mean = at[e, :, 0]
            E[e], G[e] = material.youngs_modulus(mean), material.shear_modulus(mean)
            stretch[e] = 1.0 + material.thermal_strain(mean, self._unheated[e, None])
            expansion[e] = material.expansion(mean)
        free = self._free_strains(stretch, expansion[:, :2, None] * at[:, :2, 1:])
        return np.hstack([self._stiffness(E, G, stretch), free, np.zeros_like(free)])

    def _stiffness(self, E: Array, G: Array, stretch: Array) -> Array:
        """(n_e, 21) stiffness times the weight of the points; powers of the stretch: beam3243."""
        A, I2, I3, J, k2, k3 = self._sections.T[:, :, None]
        size = self._slope * WEIGHTS
        E, G = E * size * stretch, G * size * stretch
        turned = stretch[:, :2] ** 2
        tension, slide = E[:, :2] * A, G[:, :2] * A
        bending, twist = E[:, :2] * turned, G[:, :2] * J * turned
        gauss = [tension, k2 * slide, k3 * slide, bending * I2, bending * I3, twist]
        nodal = [E[:, 2:] * A, E[:, 2:] * A, G[:, 2:] * A]
        return np.hstack([
            np.stack(gauss, axis=2).reshape(len(A), -1),
            (np.stack(nodal, axis=2) / stretch[:, 2:, None] ** 2).reshape(len(A), -1),
        ])  # fmt: skip

    def _free_strains(self, stretch: Array, curvature: Array) -> Array:
        """(n_e, 21): axial and shear grow with the stretch, the section with its square; bending
        changes by ``curvature`` (n_e, 2 points, 2), the gradients of the thermal strain."""
        free = self._reference.copy()
        gauss, nodal = free[:, :12].reshape(-1, 2, 6), free[:, 12:].reshape(-1, 3, 3)
        gauss[:, :, :3] *= stretch[:, :2, None]
        gauss[:, :, 3:5] -= curvature
        nodal *= stretch[:, 2:, None] ** 2
        return free

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """Coefficients at both ends of ``h`` [s] with the rate of the free strains between."""
        return line.with_rates(c0, c1, h, slice(STRAINS, 2 * STRAINS), slice(2 * STRAINS, None))

    def predicted(self, coef: Array, y: Array, step: Array, new: Array) -> Array:
        """Coefficients with the stress that is predicted, see ``mechanics.prediction``."""
        return shifted(coef, slice(STRAINS, 2 * STRAINS), self._strains, y, step, new)

    def resultants(self, y: Array, v: Array, coef: Array) -> Array:
        """Section resultants N, Q2, Q3, Mt, M2, M3 of each element, (n_e, 6) [N, N m].

        Means over the element, damping included; signs as in ``beam3243``.
        """
        strains, rates = self._strains(y, v)
        stiffness, free, heated = np.split(coef, 3, axis=1)
        S = stiffness * (strains - free + self.floats[:, :1] * (rates - heated))
        mean = S[:, :12].reshape(-1, 2, 6).sum(axis=1) / self.length[:, None]
        return mean[:, [0, 1, 2, 5, 3, 4]]

    def mass_blocks(self) -> Array:
        """(n_e, 27, 27) consistent mass."""
        N = shapes(line.XI3 * 2.0 - 1.0)
        shape = np.einsum("eg,gi,gj->eij", self._mass_slope * 2.0 * line.WEIGHT3, N, N)
        inertia = self._density[:, None] * self._sections[:, :3]
        scalar = np.zeros((len(shape), 9, 9))
        for k in range(3):
            scalar[:, k::3, k::3] = inertia[:, k, None, None] * shape
        return line.in_space(scalar)

    def _strains(self, y: Array, v: Array) -> tuple[Array, Array]:
        """Strains and their rates, both (n_e, 21)."""
        strains, rates = np.empty((2, len(self.names), STRAINS))
        kernels.evaluate(y, v, self.ints, self.floats, strains, rates)
        return strains, rates


def build(beams: Sequence[Beam], layout: Layout) -> Beam3333:
    """One term for all ``beams``."""
    for beam in beams:
        if len(beam.points) < 3 or len(beam.points) % 2 == 0:
            raise ValueError(
                f"beam {beam.name!r}: three-node elements need an odd number of points, "
                f"2 for each element and 1 more, got {len(beam.points)}"
            )
    return Beam3333(beams, layout)


def shapes(z: Array) -> Array:
    """(n, 3) Lagrange polynomials of the three nodes at z (n,) in -1 to 1."""
    return np.stack([0.5 * z * (z - 1.0), 1.0 - z * z, 0.5 * z * (z + 1.0)], axis=-1)


def shape_slopes(z: Array) -> Array:
    """(n, 3) their derivatives."""
    return np.stack([z - 0.5, -2.0 * z, z + 0.5], axis=-1)


def _slopes(axis: Array, z: Array) -> Array:
    """(n_e, n) |dr/dz| [m] of the axis (n_e, 3, 3)."""
    return np.linalg.norm(np.einsum("pn,eni->epi", shape_slopes(z), axis), axis=2)


def _spread(beams: Sequence[Beam], values: Sequence) -> NDArray:
    """(n_e, ...) the value of each beam for each of its elements."""
    return np.repeat(values, [len(b.points) // 2 for b in beams], axis=0)


def _triples(node_arrays: Sequence[NDArray]) -> NDArray:
    """(n_e, 3) entries at the nodes of each element, from one array (n,) per beam."""
    return np.concatenate([np.stack([a[:-2:2], a[1::2], a[2::2]], axis=1) for a in node_arrays])


def _materials(beams: Sequence[Beam]) -> list[tuple[Material, NDArray[np.intp]]]:
    """Each distinct material and its elements."""
    owner = _spread(beams, [id(b.material) for b in beams])
    distinct = {id(b.material): b.material for b in beams}
    return [(m, np.flatnonzero(owner == key)) for key, m in distinct.items()]


def _section_row(beam: Beam) -> list[float]:
    s = beam.section
    moments = [s.area, s.second_moment_2, s.second_moment_3, s.torsion_constant]
    return [*moments, s.shear_factor_2, s.shear_factor_3]
