"""Integrals over the volume of thick shell elements, of which the whole element is made.

With assumed covariant strains that are sums of products of nodal vectors, enhanced strains, and
Green's strains that enter the energy squared, quadrature gives two symmetric matrices for each
element once and for all: those that lambda and 2 mu multiply.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""xi, eta of the four nodes."""
SHEAR_FACTOR = 5.0 / 6.0
"""Of transverse shear stress, by E. Reissner (1945) [-]."""
SPHERICAL = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
DEVIATORIC = np.array([1.0, 1.0, 1.0, 0.5, 0.5 * SHEAR_FACTOR, 0.5 * SHEAR_FACTOR])
"""Stress = lambda (1.E) 1 + 2 mu E, on strains 11, 22, 33, 2x12, 2x13, 2x23."""
IJ = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]])
"""Directions of these strains."""
TOGETHER = 128
"""Elements that are integrated together, for the sake of memory."""


class Scheme(NamedTuple):
    """What distinguishes one family from another, on the square -1 <= xi, eta <= 1.

    Slopes are by xi and eta, that is half the size of the element times those of the nodes.

    vectors : of a node: 2 (r, n) or 4 (r, r_u, r_v, n)
    shape : (xi, eta) -> (3, k)  weights of all vectors in r, dr/dxi, dr/deta
    strains : (xi, eta) -> (3, 6, k (k - 1)/2)  covariant strains 11, 22, 33, 2x12, 2x13, 2x23 as
        sums of products: their parts without zeta, with zeta, with zeta^2
    membrane, thickness : (xi, eta) -> (n, 3), (m,)  enhanced strains 11, 22, 2x12 of the membrane,
        and 33, to be multiplied by zeta
    points : along each direction of the surface, and through the thickness
    """

    vectors: int
    shape: Callable[[float, float], Array]
    strains: Callable[[float, float], Array]
    membrane: Callable[[float, float], Array]
    thickness: Callable[[float, float], Array]
    points: tuple[int, int]


class Station(NamedTuple):
    """What all elements have in common at one Gauss point.

    depth : zeta over half the thickness;  weight : of the cube of side 2
    r, n : (3, k) weights of all vectors in them and their slopes;  nodal : (4,) bilinear
    strains, membrane, thickness : see ``Scheme``
    """

    depth: float
    weight: float
    r: Array
    n: Array
    nodal: Array
    strains: Array
    membrane: Array
    thickness: Array


class Tables(NamedTuple):
    """Integrals over all elements, of z = (products, -free strains, enhanced strains).

    Index 0 of the first axis: what lambda multiplies; 1: what 2 mu multiplies.

    stiffness : (2, n_e, n_z (n_z + 1)/2)  upper triangles [m^3 by the units of z]
    resultants : (2, n_e, 8, n_z)  means of N, M, Q
    mass : (n_e, k, k)  of unit density
    """

    stiffness: Array
    resultants: Array
    mass: Array


def relative(X: Array, vectors: int) -> Array:
    """(n_e, k - 1, 3) all vectors but the first, positions relative to it."""
    X = X.copy()
    X[:, ::vectors] -= X[:, :1]
    return X[:, 1:]


def products(X: Array) -> Array:
    """(n_e, k (k - 1)/2) X_a.X_b for a < b, half of it for a = b."""
    a, b = np.triu_indices(X.shape[1])
    return np.where(a == b, 0.5, 1.0) * np.einsum("epi,epi->ep", X[:, a], X[:, b])


def product(a: Array, b: Array) -> Array:
    """(k (k - 1)/2,) weights of the products in (sum a_i X_i).(sum b_i X_i); a, b (k,)."""
    i, j = np.triu_indices(len(a) - 1)
    a, b = a[1:], b[1:]
    return a[i] * b[j] + a[j] * b[i]


def bilinear(xi: float, eta: float) -> Array:
    """(3, 4) bilinear functions and their derivatives."""
    x, y = CORNERS.T
    return 0.25 * np.stack([(1 + x * xi) * (1 + y * eta), x * (1 + y * eta), (1 + x * xi) * y])


def normal_squares(vectors: int, weights: Array) -> Array:
    """Weights of the products in sum_i weights_i n_i.n_i, n the last vector of each node."""
    total = np.zeros(2 * vectors * (4 * vectors - 1))
    for node, weight in enumerate(weights):
        at = np.eye(4 * vectors)[vectors * node + vectors - 1]
        total += weight * product(at, at)
    return total


def integrate(
    scheme: Scheme, X: Array, sizes: Array, thickness: Array, names: Sequence[str]
) -> Tables:
    """Tables of elements with reference vectors X (n_e, k, 3), sizes (n_e, 2), thickness (n_e,)."""
    stations, centre = list(_stations(scheme)), _station(scheme, 0.0, 0.0, 0.0, 0.0)
    scales, g = _scales(scheme, sizes), products(relative(X, scheme.vectors))
    _check([centre, *stations], X * scales[:, :, None], thickness, names)
    parts = []
    for first in range(0, len(X), TOGETHER):
        e = slice(first, first + TOGETHER)
        rows = [
            _at_station(station, centre, X[e] * scales[e, :, None], scales[e], g[e], thickness[e])
            for station in stations
        ]
        parts.append(_sums(*(np.stack(a, axis=1) for a in zip(*rows, strict=True))))
    joined = zip(zip(*parts, strict=True), (1, 1, 0), strict=True)
    return Tables(*(np.concatenate(part, axis=axis) for part, axis in joined))


def _at_station(
    station: Station, centre: Station, X: Array, scales: Array, g: Array, thickness: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Strains (n_e, 6, n_z), shapes (n_e, k), volume, zeta, share of the area (n_e,)."""
    zeta = 0.5 * thickness * station.depth
    z = zeta[:, None, None]
    G = _base(station, X, zeta)
    volume = np.linalg.det(G)
    parts = station.strains
    i, j = np.triu_indices(scales.shape[1] - 1)
    A = (parts[0] + z * parts[1] + z**2 * parts[2]) * (scales[:, 1 + i] * scales[:, 1 + j])[:, None]
    metric = (2.0 * A @ g[:, :, None]) * station.nodal
    covariant = np.concatenate([A, metric, z * metric], axis=2)
    enhanced = _enhanced(station, zeta, _base(centre, X, 0.0 * zeta), G)
    S = np.concatenate([_transform(G) @ covariant, *enhanced], axis=2)
    N = scales * (station.r[0] + zeta[:, None] * station.n[0])
    w = 0.5 * station.weight * thickness * volume
    return S, N, w, zeta, w / thickness


def _sums(S: Array, N: Array, w: Array, zeta: Array, share: Array) -> tuple[Array, Array, Array]:
    """The integrals, from what was found at all stations (axis 1)."""
    n, _, _, m = S.shape
    i, j = np.triu_indices(m)
    weight = w[:, :, None, None]
    stresses = [
        weight * SPHERICAL[:, None] * (SPHERICAL @ S)[:, :, None],
        weight * DEVIATORIC[:, None] * S,
    ]
    flat = S.reshape(n, -1, m).transpose(0, 2, 1)
    work = np.stack([(flat @ stress.reshape(n, -1, m))[:, i, j] for stress in stresses])
    resultants = np.stack([_resultant(stress, zeta).sum(axis=1) for stress in stresses])
    mass = (w[:, :, None] * N).transpose(0, 2, 1) @ N
    mass = 0.5 * (mass + mass.transpose(0, 2, 1))  # symmetric to the last bit
    return work, resultants / share.sum(axis=1)[:, None, None], mass


def _resultant(stress: Array, zeta: Array) -> Array:
    """(n_e, n_g, 8, n_z) N, M, Q."""
    flat = stress[:, :, [0, 1, 3]]
    moments = -zeta[:, :, None, None] * flat
    return np.concatenate([flat, moments, stress[:, :, 4:]], axis=2)


def _scales(scheme: Scheme, sizes: Array) -> Array:
    """(n_e, k) slopes by xi and eta from those by u and v."""
    node = np.ones((len(sizes), scheme.vectors))
    if scheme.vectors == 4:
        node[:, 1:3] = 0.5 * sizes
    return np.tile(node, (1, 4))


def _stations(scheme: Scheme) -> Iterator[Station]:
    """All Gauss points."""
    across, through = scheme.points
    x, wx = np.polynomial.legendre.leggauss(across)
    z, wz = np.polynomial.legendre.leggauss(through)
    for i in range(across):
        for j in range(across):
            for k in range(through):
                yield _station(scheme, x[i], x[j], z[k], wx[i] * wx[j] * wz[k])


def _station(scheme: Scheme, xi: float, eta: float, depth: float, weight: float) -> Station:
    nodal = bilinear(xi, eta)
    n = np.zeros((3, 4 * scheme.vectors))
    n[:, scheme.vectors - 1 :: scheme.vectors] = nodal
    enhanced = scheme.membrane(xi, eta), scheme.thickness(xi, eta)
    strains = scheme.strains(xi, eta)
    return Station(depth, weight, scheme.shape(xi, eta), n, nodal[0], strains, *enhanced)


def _base(station: Station, X: Array, zeta: Array) -> Array:
    """(n_e, 3, 3) rows: covariant base vectors, slopes X by xi and eta."""
    G = np.empty((len(X), 3, 3))
    G[:, :2] = station.r[1:] @ X + zeta[:, None, None] * (station.n[1:] @ X)
    G[:, 2] = station.n[0] @ X
    return G


def _local(G: Array) -> Array:
    """(n_e, 3, 3) rows: e1 along the first parameter line, e3 normal to the surface."""
    e1 = G[:, 0] / np.linalg.norm(G[:, 0], axis=1, keepdims=True)
    e3 = np.cross(G[:, 0], G[:, 1])
    e3 /= np.linalg.norm(e3, axis=1, keepdims=True)
    return np.stack([e1, np.cross(e3, e1), e3], axis=1)


def _voigt(Q: Array) -> Array:
    """(n_e, 6, 6) strains in directions a from those in directions i, Q (n_e, a, i)."""
    a, b = IJ.T
    one = Q[:, a[:, None], a] * Q[:, b[:, None], b]
    two = Q[:, a[:, None], b] * Q[:, b[:, None], a]
    # shear strains count twice on both sides; for a normal one on the right both terms are equal
    return np.where(a == b, 0.5, 1.0)[:, None] * (one + two)


def _transform(G: Array) -> Array:
    """(n_e, 6, 6) strains in the local frame from covariant ones."""
    contravariant = np.linalg.inv(G)
    return _voigt(_local(G) @ contravariant)


def _enhanced(station: Station, zeta: Array, centre: Array, G: Array) -> tuple[Array, Array]:
    """Enhanced strains in the local frame, without work on uniform stress (Simo & Rifai 1990)."""
    scale = (np.linalg.det(centre) / np.linalg.det(G))[:, None, None]
    flat = np.zeros((6, len(station.membrane)))
    flat[[0, 1, 3]] = station.membrane.T
    swelling = np.zeros((len(G), 6, len(station.thickness)))
    swelling[:, 2] = zeta[:, None] * station.thickness
    return scale * (_voigt(_local(G) @ np.linalg.inv(centre)) @ flat), scale * swelling


def _check(stations: Sequence[Station], X: Array, thickness: Array, names: Sequence[str]) -> None:
    good = thickness > 0.0
    for station in stations:
        good &= np.linalg.det(_base(station, X, 0.5 * thickness * station.depth)) > 0.0
    bad = np.flatnonzero(~good)
    if bad.size:
        raise ValueError(
            f"shell {names[bad[0]]!r}: an element has no area or thickness, is folded, thicker "
            "than its radius of curvature, or numbered against the normal"
        )
