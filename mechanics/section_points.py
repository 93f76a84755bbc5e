"""Points and weights that integrate over the cross-section of a beam.

All rules are exact for polynomials of degree 5 in y and z, hence for the energy of strains of
degree 2, whose highest moments are of order four.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from meshes.sections import Section

Array = NDArray[np.float64]


def section_points(section: Section) -> tuple[Array, Array]:
    """Points (k, 2) [m] along e2 and e3, and weights (k,) [m^2] whose sum is the area.

    A section given by its numbers only is taken as the rectangle of the same radii of gyration
    with the density that makes its area right: its area and second moments are exact, its
    fourth moments those of that rectangle.
    """
    return RULES[section.kind](section)


def _rectangle(section: Section) -> tuple[Array, Array]:
    """Gauss points, 3 by 3."""
    z, w = np.polynomial.legendre.leggauss(3)
    radii = np.sqrt(3.0 * np.array([section.second_moment_2, section.second_moment_3]))
    y2, y3 = np.meshgrid(*(z[None] * radii[:, None] / np.sqrt(section.area)), indexing="ij")
    weights = 0.25 * section.area * np.multiply.outer(w, w)
    return np.stack([y2.ravel(), y3.ravel()], axis=1), weights.ravel()


def _disc(section: Section) -> tuple[Array, Array]:
    """The centre, and six points at sqrt(2/3) of the radius (Stroud 1971, S2 5-1)."""
    around = _around(np.sqrt(2.0 / 3.0) * section.radius)
    weights = section.area / 8.0 * np.array([2.0, *np.ones(6)])
    return np.vstack([np.zeros((1, 2)), around]), weights


def _ring(section: Section) -> tuple[Array, Array]:
    """Two Gauss points in the square of the radius, times six in angle."""
    outer, inner = (section.radius + side * section.thickness for side in (0.5, -0.5))
    mean, half = 0.5 * (outer**2 + inner**2), 0.5 * (outer**2 - inner**2)
    radii = np.sqrt(mean + half * np.array([-1.0, 1.0]) / np.sqrt(3.0))
    return np.vstack([_around(r) for r in radii]), np.full(12, section.area / 12.0)


def _around(radius: float) -> Array:
    """Six points, exact for harmonics up to the fifth."""
    angle = np.pi / 3.0 * np.arange(6)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


RULES: dict[str, Callable[[Section], tuple[Array, Array]]] = {
    "rectangle": _rectangle,
    "general": _rectangle,
    "circle": _disc,
    "tube": _ring,
}
