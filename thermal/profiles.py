"""Temperature over a section, from N values at points of it, and the outline it exchanges over.

A section with one value has it everywhere. A tube has an even number of values round its mean
surface and trigonometric interpolation between them. A solid circle or rectangle has three, which
stand for mean and two gradients: T = Tm + y Gy + z Gz. They sit at

    y_k = sqrt(2) r2 cos(phi_k),  z_k = sqrt(2) r3 sin(phi_k),  phi_k = 0, 120, 240 degrees,

with the radii of gyration r2 = sqrt(I2/A) and r3 = sqrt(I3/A). There the three functions are
orthogonal and the points with weights A/3 integrate polynomials of degree two (Stroud 1957), so
that heat stored at the points gives the mean A and the gradients I2 and I3, and a point is never
cooled by heating its neighbour.

Shape functions are written in coordinates without unit: the angle round a tube; y and z over
sqrt(2) r2 and sqrt(2) r3 of a solid section. ``scales`` holds what they are multiplied by.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.sections import Section
from thermal.circumference import cardinal, cardinal_at, half_cosine_loads

Array = NDArray[np.float64]

GRADIENTS = 3  # values of a section that stand for mean and two gradients
ROUND = 8  # strips of an outline round which temperature is constant or linear
SIDE = 3  # strips of each side of a rectangle
FINE_ROUND, FINE_SIDE = 96, 8  # the same where light and shadow meet within the outline


class Profile(NamedTuple):
    """Shape functions of N values at M points of equal shares of the section.

    values : (M, N) float
    slopes : (D, M, N) float  derivative along each of the D coordinates without unit
    """

    values: Array
    slopes: Array


class Contour(NamedTuple):
    """Points on an outline, turning from e2 towards e3, and the strip that belongs to each.

    offsets : (P, 2) float [m]  y and z
    normals : (P, 2) float  away from the material
    lengths : (P,) float [m]  of the strips
    first, last : (P, 2) float [m]  ends of the strips
    """

    offsets: Array
    normals: Array
    lengths: Array
    first: Array
    last: Array


def wall_angles(n: int) -> Array:
    """(n,) [rad]  from e2 towards e3."""
    return 2.0 * np.pi * np.arange(n) / n


def profile(n: int) -> Profile:
    """Shape functions of ``n`` values: 1, 3, or an even number round a tube."""
    if n == 1:
        return Profile(np.ones((1, 1)), np.zeros((0, 1, 1)))
    if n == GRADIENTS:
        slopes = np.repeat(2.0 / 3.0 * _unit(wall_angles(n)).T[:, None], n, axis=1)
        return Profile(np.eye(n), slopes)
    values, slope = cardinal(n)
    return Profile(values, slope[None])


def scales(section: Section, n: int) -> tuple[float, ...]:
    """Length [m] of a unit of each coordinate of ``profile``."""
    if n == 1:
        return ()
    return _gyration(section) if n == GRADIENTS else (section.radius,)


def wall_offsets(section: Section, n: int) -> Array:
    """(n, 2) [m]  where in the section the values live."""
    if n == 1:
        return np.zeros((1, 2))
    size = _gyration(section) if n == GRADIENTS else section.radius
    return np.multiply(size, _unit(wall_angles(n)))


def values_at(section: Section, n: int, offsets: Array) -> Array:
    """(P, n)  shape functions at points (P, 2) [m] of the section."""
    if n == 1:
        return np.ones((len(offsets), 1))
    if n == GRADIENTS:
        return 1.0 / 3.0 + 2.0 / 3.0 * (offsets / _gyration(section)) @ _unit(wall_angles(n)).T
    return cardinal_at(n, np.arctan2(offsets[:, 1], offsets[:, 0])).values


def extent(section: Section, directions: Array) -> Array:
    """(...,) [m]  how far a section reaches along unit ``directions`` (..., 2).

    Of a tube its mean surface, where its temperatures are.
    """
    if section.kind == "tube" or section.kind == "circle":
        return np.full(np.shape(directions)[:-1], section.radius)
    return np.abs(directions) @ np.array([0.5 * section.height, 0.5 * section.width])


def outer_contour(section: Section, n: int, fine: bool = False) -> Contour:
    """The outer outline of a section with ``n`` values."""
    if section.kind in ("tube", "circle"):
        return _ring(0.5 * section.height, _strips(n, fine))
    flat = _rectangle(section, FINE_SIDE if fine else SIDE)
    return flat._replace(lengths=flat.lengths * (section.outer_perimeter / flat.lengths.sum()))


def inner_contour(section: Section, n: int, fine: bool = False) -> Contour:
    """The outline of the bore of a tube."""
    ring = _ring(section.radius - 0.5 * section.thickness, _strips(n, fine))
    return ring._replace(normals=-ring.normals)


def absorbing_widths(section: Section, n: int, facing: Array | None) -> Array:
    """Absorbing width [m] of the outer contour, the share of each of the ``n`` values, exact.

    Parallel rays see a round contour by its diameter, that of a rectangle with three values by
    the sides that they meet; other sections with one value by the rectangle of height and width.

    facing : (..., 2)  minus the rays' direction along e2 and e3; None: all round
    """
    if facing is None:
        return np.full(n, section.outer_perimeter / n)
    across = np.hypot(facing[..., 0], facing[..., 1])[..., None]
    if section.kind in ("tube", "circle"):
        phase = np.arctan2(facing[..., 1], facing[..., 0])
        return 0.5 * section.height * across * _round_loads(n, phase)
    contour = _rectangle(section, SIDE)
    lit = contour.lengths * np.maximum(0.0, facing @ contour.normals.T)
    return lit @ values_at(section, n, contour.offsets)


def _round_loads(n: int, phase: Array) -> Array:
    if n == 1:
        return np.full((*phase.shape, 1), 2.0)
    if n == GRADIENTS:  # mean 2, first harmonic pi/2; the circle reaches sqrt(2) coordinate units
        return 2.0 / 3.0 + np.pi * sqrt(2.0) / 3.0 * np.cos(wall_angles(n) - phase[..., None])
    return half_cosine_loads(n, phase)


def _strips(n: int, fine: bool) -> int:
    return max(FINE_ROUND if fine else ROUND, (4 if fine else 2) * n)


def _gyration(section: Section) -> tuple[float, float]:
    """sqrt(2) times the radii of gyration [m]."""
    double = 2.0 / section.area
    return sqrt(double * section.second_moment_2), sqrt(double * section.second_moment_3)


def _unit(phi: Array) -> Array:
    return np.stack([np.cos(phi), np.sin(phi)], axis=-1)


def _ring(radius: float, count: int) -> Contour:
    phi, half = wall_angles(count), np.pi / count
    normals, lengths = _unit(phi), np.full(count, 2.0 * half * radius)
    ends = radius * _unit(phi - half), radius * _unit(phi + half)
    return Contour(radius * normals, normals, lengths, *ends)


def _rectangle(section: Section, count: int) -> Contour:
    """Gauss points on each side; strips as long as their weights."""
    x, w = np.polynomial.legendre.leggauss(count)
    along = 0.5 * (1.0 + x)
    edges = np.concatenate([[0.0], 0.5 * np.cumsum(w)])
    half = 0.5 * np.array([section.height, section.width])
    corners = half * np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    sides = list(zip(corners[:-1], np.diff(corners, axis=0), strict=True))

    def at(part: Array) -> Array:
        return np.concatenate([start + part[:, None] * side for start, side in sides])

    normals = np.repeat(np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]), count, axis=0)
    lengths = np.concatenate([0.5 * w * np.linalg.norm(side) for _, side in sides])
    return Contour(at(along), normals, lengths, at(edges[:-1]), at(edges[1:]))
