"""Rods and beams solved by other means than finite elements, as references."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, root

from meshes.sections import Section

Array = NDArray[np.float64]


class Rod(NamedTuple):
    """Stiffness of a rod: axial, shear (2), torsion and bending towards e2, e3 (SI units)."""

    axial: float
    shear_2: float
    shear_3: float
    torsion: float
    bending_2: float
    bending_3: float

    @classmethod
    def of(cls, section: Section, E: float, nu: float, shear: bool = True) -> "Rod":
        G, A = E / (2.0 * (1.0 + nu)), section.area
        factors = (section.shear_factor_2, section.shear_factor_3) if shear else (np.inf, np.inf)
        moments = section.second_moment_2, section.second_moment_3
        turning = G * section.torsion_constant, E * moments[0], E * moments[1]
        return cls(E * A, factors[0] * G * A, factors[1] * G * A, *turning)


def rod_tip(rod: Rod, length: float, force: Array, steps: int = 4) -> Array:
    """Tip (3,) [m] of a clamped rod under a dead force: Reissner (1981), by shooting.

    Unknown is the moment at the clamp, for which the moment at the tip vanishes.
    """
    stretching = np.array([rod.axial, rod.shear_2, rod.shear_3])
    turning = np.array([rod.torsion, rod.bending_3, rod.bending_2])

    def slopes(_: float, y: Array, F: Array) -> Array:
        R = y[3:12].reshape(3, 3)
        axis = R @ (np.array([1.0, 0.0, 0.0]) + R.T @ F / stretching)
        turned = np.cross(R, np.broadcast_to(R.T @ y[12:] / turning, (3, 3)))
        return np.concatenate([axis, turned.ravel(), -np.cross(axis, F)])

    def end(moment: Array, F: Array) -> Array:
        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])
        found = solve_ivp(slopes, (0.0, length), start, "DOP853", args=(F,), rtol=1e-10, atol=1e-13)
        return found.y[:, -1]

    moment = np.zeros(3)
    size = length * float(np.linalg.norm(force))
    for part in np.arange(1, steps + 1) / steps:
        F = part * force
        moment = size * root(lambda m, F=F: end(size * m, F)[12:] / size, moment / size).x
    return end(moment, force)[:3]


def timoshenko(EI: float, kGA: float, mass: float, inertia: float) -> float:
    """First angular frequency [1/s] of a cantilever of length 1 m, from its state equations."""

    def missing(omega: float) -> float:
        slope = np.zeros((4, 4))  # of deflection, rotation, moment, shear force
        slope[0, 1], slope[0, 3], slope[1, 2] = 1.0, 1.0 / kGA, 1.0 / EI
        slope[2, 1], slope[2, 3], slope[3, 0] = -inertia * omega**2, -1.0, -mass * omega**2
        return float(np.linalg.det(expm(slope)[2:, 2:]))

    guess = 1.8751041**2 * np.sqrt(EI / mass)
    return float(brentq(missing, 0.8 * guess, 1.05 * guess, xtol=1e-13 * guess))
