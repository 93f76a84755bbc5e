"""Modes of a beam for linear elasticity in a floating frame (Craig & Bampton 1968).

The frame is that of the first section. Six static modes are what moving and turning the last
section does, so that forces and moments at both ends, a uniform thermal stretch and a thermal bow
of a curvature that is linear along the beam are exact in linear theory; further ones are the
lowest vibrations with both end sections held. Stiffness and mass are those of the beam's own mesh
in the reference, at the reference temperature.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, coo_array, csc_array
from scipy.sparse.linalg import splu

from mechanics import beam3243, kernels
from mechanics.beam3243 import Beam3243
from mechanics.beam3243_kernels import evaluate
from mechanics.beam3243_tables import STRAINS
from mechanics.description import Beam
from mechanics.eigen import lowest
from mechanics.layout import Layout

Array = NDArray[np.float64]


class Modes(NamedTuple):
    """Shapes of the n_m = 6 + N modes of a beam of n nodes and n_e elements.

    places : (n, 4, 3) float [m], [1]  r, r_x, r_y, r_z of the nodes in the frame
    shapes : (n, 4, 3, n_m) float [1], [1/m]  what an amplitude [m] adds to them
    reference : (n_e, 18) float  strains of the reference
    strains : (n_e, 18, n_m) float [1/m]  what an amplitude adds to them, linear
    """

    places: Array
    shapes: Array
    reference: Array
    strains: Array


def modes_of(beam: Beam) -> tuple[Beam3243, Modes]:
    """Elements of the beam alone, from whose coefficients its stresses follow, and its modes.

    An amplitude is the largest deflection of its mode or, if that is more, turn times length.
    """
    still = np.zeros(3)
    layout = Layout.of([replace(beam, modes=None, velocity=still, spin=still)])
    term = beam3243.build([layout.bodies[beam.name]], layout)  # type: ignore[list-item]
    shapes = _shapes(term, layout, beam, beam.modes or 0)
    axes = np.asarray(beam.axes, float)[0]
    vectors = layout.q0.reshape(-1, 4, 3).copy()
    vectors[:, 0] -= vectors[0, 0]
    turned = np.einsum("ij,nvjm->nvim", axes, shapes.reshape(len(vectors), 4, 3, -1))
    found = [_strains(term, layout, shape) for shape in shapes.T]
    reference = _strains(term, layout, np.zeros(layout.ndof))[0]
    return term, Modes(vectors @ axes.T, turned, reference, np.stack([r for _, r in found], axis=2))


def _shapes(term: Beam3243, layout: Layout, beam: Beam, count: int) -> Array:
    """(12 n, 6 + count) static modes and vibrations, normalised."""
    T = np.tile([beam.reference_temperature, 0.0, 0.0], (len(layout.x), 1))
    rest, coef = np.zeros(layout.ndof), term.coefficients(T)
    K = _assembled(term, kernels.tangent_blocks(term, layout.q0, rest, coef, 1.0, 0.0))
    held = _sections(layout, beam)
    matrix = csc_array(block_array([[K, held.T], [held, None]]))
    ends = np.zeros((matrix.shape[0], 6))
    ends[-6:] = np.diag([layout.scale[0]] * 3 + [1.0] * 3)
    shapes = splu(matrix).solve(ends)[: layout.ndof]
    if count:
        M = _assembled(term, term.mass_blocks())
        shapes = np.hstack([shapes, lowest(K, M, held, count, layout.scale)[1]])
    sizes = np.abs(shapes) * (layout.scale[0] / layout.scale)[:, None]
    return shapes / sizes.max(axis=0)


def _assembled(term: Beam3243, blocks: Array) -> csc_array:
    rows, columns = np.repeat(term.dofs, 24, axis=1).ravel(), np.tile(term.dofs, (1, 24)).ravel()
    size = int(term.dofs.max()) + 1
    return csc_array(coo_array((blocks.ravel(), (rows, columns)), shape=(size, size)))


def _sections(layout: Layout, beam: Beam) -> csc_array:
    """(12, 12 n) displacements and turns of the first and the last section."""
    rows = np.zeros((12, layout.ndof))
    for end, at in ((0, 0), (6, layout.ndof - 12)):
        e1, e2, e3 = np.asarray(beam.axes, float)[end // 6 - (end > 0) * 2]
        rows[end : end + 3, at : at + 3] = np.eye(3)
        rows[end + 3, at + 6 : at + 12] = 0.5 * np.concatenate([e3, -e2])
        rows[end + 4, at + 9 : at + 12] = e1
        rows[end + 5, at + 6 : at + 9] = -e1
    return csc_array(rows)


def _strains(term: Beam3243, layout: Layout, rate: Array) -> tuple[Array, Array]:
    """Strains of the reference, and their rates with the velocities ``rate``: linear strains."""
    strains, rates = np.empty((2, len(term.names), STRAINS))
    evaluate(layout.q0, np.ascontiguousarray(rate), term.ints, term.floats, strains, rates)
    return strains, rates
