"""What the families of line elements share: a cubic Hermite axis, quadrature, data per element.

An element of length L runs from node a to node b; positions on it are fractions xi of its length.
Its axis depends on the three vectors c = (r_b - r_a)/L, r_x(0) and r_x(L), and on L through c
alone: r' and L r'' are sums of the three with weights that depend on xi only.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Beam
from meshes.materials import Material

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

MEMBRANE = 32.0
"""Stiffness of the quadratic axial strain of the cable relative to that of bending [-].

It must exceed pi^2, or the axis of a strut would buckle within its elements before the strut
does. Measured on a beam with the same axis, radius of gyration 1e-3 L: errors of the elastica (tip
load 10 EI/L^2, 4 and 8 elements) and gap of the roll-up to a full circle (4 and 8 elements):

====  ==============  =================
8     .13 %, .018 %   fails, .13 %
32    .22 %, .042 %   7 %, .15 %
64    .32 %, .069 %   2.3 %, .20 %
256   .68 %, .16 %    .14 %, .23 %
inf   1.0 %, .29 %    .45 %, .24 %
====  ==============  =================
"""

XI2 = np.array([0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)])
"""Two Gauss points as fractions of the length."""
XI3 = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)])
WEIGHT3 = np.array([5.0, 8.0, 5.0]) / 18.0
"""Three Gauss points and their weights, whose sum is 1."""


def tangent_weights(xi: Array) -> Array:
    """(n, 3) weights of c, r_x(0), r_x(L) in r' at fractions ``xi`` (n,)."""
    return np.stack([6 * xi * (1 - xi), 1 - 4 * xi + 3 * xi**2, 3 * xi**2 - 2 * xi], axis=-1)


def curvature_weights(xi: Array) -> Array:
    """(n, 3) weights of c, r_x(0), r_x(L) in L r'' at fractions ``xi`` (n,)."""
    return np.stack([6 - 12 * xi, -4 + 6 * xi, 6 * xi - 2], axis=-1)


_Z = 2.0 * XI3 - 1.0
LEGENDRE = np.stack([np.ones(3), _Z, 1.5 * _Z**2 - 0.5])
"""(3, 3) Legendre polynomials 0 to 2 at the three Gauss points."""

_WEIGHTS = tangent_weights(XI3)
AXIAL_FORM = np.einsum("kg,gi,gj->kij", LEGENDRE * WEIGHT3, _WEIGHTS, _WEIGHTS)
"""(3, 3, 3): Legendre coefficient k of r'.r' is the sum over i, j of [k, i, j] X_i.X_j."""


def axial_coefficients(values: Array) -> Array:
    """(n_e, 3) Legendre coefficients of what has the given values at the three Gauss points."""
    return values @ (LEGENDRE * WEIGHT3).T


def axial_stiffness(EA: Array, length: Array, slack: Array) -> Array:
    """(n_e, 3) stiffness of the Legendre coefficients of the axial strain.

    For uniform EA: EA L (1, 3, 5 slack); otherwise with the mean of EA that each shape sees.
    """
    order = np.array([1.0, 3.0, 5.0])
    stiffness = length[:, None] * (EA @ (LEGENDRE**2 * WEIGHT3).T) * order**2
    stiffness[:, 2] *= slack
    return stiffness


def membrane_slack(area: Array, second_moment: Array, length: Array) -> Array:
    """(n_e,) part of EA that acts on the quadratic Legendre part of the axial strain.

    A cubic axis cannot bend without such strain, and its full stiffness would lock a slender
    element. The remaining stiffness keeps the ratio ``MEMBRANE`` to that of bending, so that
    accuracy does not depend on slenderness; stocky elements keep all of it.
    """
    return np.minimum(1.0, MEMBRANE * second_moment / (area * length**2))


class Group(NamedTuple):
    """Elements (n_g,) of one material."""

    material: Material
    elements: Indices


def groups(beams: Sequence[Beam]) -> list[Group]:
    """The elements of each distinct material."""
    owner = per_element(beams, [id(b.material) for b in beams])
    distinct = {id(b.material): b.material for b in beams}
    return [Group(m, np.flatnonzero(owner == key)) for key, m in distinct.items()]


def per_element(beams: Sequence[Beam], values: Sequence) -> NDArray:
    """(n_e, ...) the value of each beam for each of its elements."""
    return np.repeat(values, [len(b.points) - 1 for b in beams], axis=0)


def pairs(node_arrays: Sequence[NDArray]) -> NDArray:
    """(n_e, 2, ...) entries at both ends of each element, from one array (n, ...) per beam."""
    return np.concatenate([np.stack([a[:-1], a[1:]], axis=1) for a in map(np.asarray, node_arrays)])


def arc_lengths(r: Array, r_x: Array) -> Array:
    """(n_e,) arc lengths [m] of cubics with end points (n_e, 2, 3) and unit end tangents.

    The parameter of each cubic runs over its own length: a fixed point, started at the chord.
    """
    chord = r[:, 1] - r[:, 0]
    z, w = np.polynomial.legendre.leggauss(12)
    weights = tangent_weights(0.5 + 0.5 * z)
    ends = np.einsum("gk,eki->egi", weights[:, 1:], r_x)
    L = np.linalg.norm(chord, axis=1)
    for _ in range(30):
        slope = weights[:, :1] * chord[:, None] + L[:, None, None] * ends
        L = np.linalg.norm(slope, axis=2) @ (0.5 * w)
    return L


def node_places(points: Array, axes: Array) -> Array:
    """(n,) arc lengths [m] from the first node of a line body with section triads (n, 3, 3)."""
    lengths = arc_lengths(pairs([points]), pairs([np.asarray(axes, float)[:, 0]]))
    return np.concatenate([[0.0], np.cumsum(lengths)])


def tangents(r: Array, r_x: Array, length: Array) -> Array:
    """(n_e, 3, 3) r' at the three Gauss points."""
    c = (r[:, 1] - r[:, 0]) / length[:, None]
    return np.einsum("gk,eki->egi", _WEIGHTS, np.stack([c, r_x[:, 0], r_x[:, 1]], axis=1))


def half_square(vectors: Array) -> Array:
    """(n_e, k) half the squares of vectors (n_e, k, 3)."""
    return 0.5 * np.einsum("egi,egi->eg", vectors, vectors)


def at_fractions(ends: Array, xi: Array) -> Array:
    """(n_e, len(xi), ...) linear interpolation of values (n_e, 2, ...) at both ends."""
    x = xi.reshape(-1, *[1] * (ends.ndim - 2))
    return ends[:, :1] + x * (ends[:, 1:] - ends[:, :1])


def hermite_mass(L: Array) -> Array:
    """(n_e, 4, 4) mass of r, r_x, r, r_x of a cubic with 1 kg/m.

    L/420 [[156, 22 L, 54, -13 L], [., 4 L^2, 13 L, -3 L^2], [., ., 156, -22 L], [., ., ., 4 L^2]]
    """
    o = np.ones_like(L)
    upper = [156 * o, 22 * L, 54 * o, -13 * L, 4 * L**2, 13 * L, -3 * L**2]
    upper += [156 * o, -22 * L, 4 * L**2]
    m = np.empty((len(L), 4, 4))
    i, j = np.triu_indices(4)
    m[:, i, j] = m[:, j, i] = np.stack(upper, axis=1)
    return m * L[:, None, None] / 420.0


def in_space(scalar: Array) -> Array:
    """(n_e, 3 k, 3 k) the scalar matrices (n_e, k, k) times the identity of space."""
    n, k, _ = scalar.shape
    return np.einsum("eij,kl->eikjl", scalar, np.eye(3)).reshape(n, 3 * k, 3 * k)


def with_rates(c0: Array, c1: Array, h: float, strains: slice, rates: slice) -> tuple[Array, Array]:
    """Coefficients whose ``rates`` columns hold the mean rate of the ``strains`` columns."""
    first, last = c0.copy(), c1.copy()
    first[:, rates] = last[:, rates] = (c1[:, strains] - c0[:, strains]) / h
    return first, last
