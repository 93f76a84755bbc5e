"""Directions that move with an end of a joint, as coefficients for ``mechanics.relative``."""

import numpy as np
from numpy.typing import NDArray

from mechanics.layout import Side

Array = NDArray[np.float64]

ALIGNED = 1e-9
"""Sine or cosine below which two reference directions count as aligned or at right angles."""
_ROUNDING = 1e-14


def origin(a: Side, b: Side) -> Array:
    """(3,) float [m]  part of r_A − r_B that the ground contributes."""
    absent = [side.position * side.fixed for side in (a, b)]
    return absent[0] - absent[1]


def fixed(vector: Array) -> Array:
    """(7,) coefficients of a direction of the ground."""
    return np.array([0.0, 0.0, 0.0, *vector, 0.0])


def direction(side: Side, vector: Array) -> Array:
    """(7,) coefficients of the direction that is ``vector`` in the reference and moves with it.

    c solves c1 g/√|g| + c2 p + c3 s = vector with the reference values of the three, which need
    be neither of unit length nor at right angles.
    """
    if side.fixed:
        return fixed(vector)
    if side.directions == 0:
        raise ValueError(f"{side.name!r} has no orientation")
    if side.directions == 1:
        along = only_direction(side)
        if np.linalg.norm(vector - (along @ vector) * along) > 1e-6:
            raise ValueError(f"{side.name!r} has no direction but its tangent or director")
        c = np.array([0.0, (along @ vector) / np.linalg.norm(side.frame[1]), 0.0])
    else:
        c = np.linalg.solve(side.frame.T, np.asarray(vector, float))
    c[np.abs(c) < _ROUNDING * np.abs(c).max()] = 0.0
    return np.array([*c, 0.0, 0.0, 0.0, 0.0])


def unit_direction(side: Side, vector: Array) -> Array:
    """As ``direction``, divided by its length at all times."""
    coefficients = direction(side, vector)
    coefficients[6] = float(not side.fixed)
    return coefficients


def only_direction(side: Side) -> Array:
    """(3,) unit tangent of a cable, or director of a thick shell, in the reference."""
    return unit(side.frame[1])


def section_axes(side: Side) -> Array:
    """(3, 3) orthonormal rows: normal of the plane of p and s, then two directions in it.

    For a beam e1, e2, e3; for a shell its normal and its tangents; for a rigid body as a beam.
    """
    if side.directions < 2:
        return side.triad
    along = np.abs(side.triad @ side.frame[0])
    return np.roll(side.triad, -int(np.argmax(along)), axis=0)


def normal_to(axis: Array, triad: Array) -> Array:
    """Unit vector across ``axis``: e2, e3 or e1 of the triad, projected where none is across."""
    e2, e3, e1 = (triad[i] - (triad[i] @ axis) * axis for i in (1, 2, 0))
    best = max((e2, e3, e1), key=lambda e: np.round(np.linalg.norm(e), 6))
    return best / np.linalg.norm(best)


def unit(vector: Array) -> Array:
    """``vector`` (3,) divided by its length."""
    length = np.linalg.norm(vector)
    if length == 0.0:
        raise ValueError("a direction has no length")
    return np.asarray(vector, float) / length
