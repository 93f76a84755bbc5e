"""What falls from a planet on a plate: its infrared, and sunlight that it reflects.

The planet is a sphere that emits and reflects diffusely, everywhere alike. Nothing of the
structure hides it.
"""

from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from thermal.boundary import STEFAN_BOLTZMANN
from thermal.orbit import EARTH_RADIUS

Array = NDArray[np.float64]

RINGS, AZIMUTHS = 12, 48  # of the quadrature over what is seen of the planet


@dataclass(frozen=True)
class Planet:
    """The earth, unless said otherwise.

    Attributes
    ----------
    radius : float [m]
    albedo : float [-]  fraction of sunlight reflected
    infrared : float [W/m^2]  emitted at its surface
    """

    radius: float = EARTH_RADIUS
    albedo: float = 0.30
    infrared: float = 238.0

    def __post_init__(self) -> None:
        wrong = []
        if not 0.0 < self.radius < inf:
            wrong.append(f"planet: radius must be positive and finite, got {self.radius:g} m")
        if not 0.0 <= self.albedo <= 1.0:
            wrong.append(f"planet: albedo must be in [0, 1], got {self.albedo:g}")
        if not 0.0 <= self.infrared < inf:
            wrong.append(f"planet: infrared must be at least 0, got {self.infrared:g} W/m^2")
        if wrong:
            raise ValueError("\n".join(wrong))


def emitted(temperature: float) -> float:
    """Infrared [W/m^2] of a black surface at a temperature [K]."""
    if not temperature >= 0.0:
        raise ValueError(f"planet: a temperature of {temperature:g} K is below 0 K")
    return STEFAN_BOLTZMANN * temperature**4


def view_factor(height: float, cosine: ArrayLike) -> Array:
    """View factor from a small plate to a sphere (Juul 1979; Cunningham 1961).

    Parameters
    ----------
    height : float [-]  distance from the centre over the radius of the sphere, > 1
    cosine : (...,) float  of the angle between the normal of the plate and nadir

    Returns
    -------
    (...,) float  where the horizon cuts the plane of the plate, the part before the plate alone
    """
    c = np.asarray(cosine, dtype=float)
    square, rise = height**2, sqrt(max(0.0, height**2 - 1.0))
    cut = np.clip(c, -1.0 / height, 1.0 / height)
    sine = np.sqrt(1.0 - cut**2)
    inner = np.arccos(np.clip(-rise * cut / sine, -1.0, 1.0))
    partly = 0.5 - np.arcsin(np.clip(rise / (height * sine), -1.0, 1.0)) / pi
    partly += (cut * inner - rise * np.sqrt(np.maximum(0.0, 1.0 - square * cut**2))) / (pi * square)
    return np.where(c >= 1.0 / height, c / square, np.where(c <= -1.0 / height, 0.0, partly))


def mean_view_factor(height: float) -> float:
    """View factor from a small sphere, or the mean over plates of all attitudes."""
    return 0.5 * (1.0 - sqrt(max(0.0, 1.0 - height**-2)))


class Glow(NamedTuple):
    """Light from all directions, as sums over some of them.

    directions : (k, 3) float  where it comes from
    weights : (k,) float [W/m^2]  on a plate that faces each
    axis : (3,) float, sine : float  all directions are within an angle of this sine around it
    """

    directions: Array
    weights: Array
    axis: Array
    sine: float


def reflected(
    planet: Planet, height: float, nadir: Array, sun: Array, flux: float,
    rings: int = RINGS, azimuths: int = AZIMUTHS,
) -> Glow:  # fmt: skip
    """Sunlight that comes from the planet.

    Rings about nadir (Gauss points in the square of the sine) times evenly spaced azimuths; each
    direction brings what the sun's height above the ground there allows.

    Parameters
    ----------
    height : float [-]  distance from the centre over the radius
    nadir, sun : (3,) unit vectors to the centre of the planet and to the sun
    flux : float [W/m^2]  of sunlight at the planet
    """
    x, w = np.polynomial.legendre.leggauss(rings)
    sine2 = 0.5 * (1.0 + x) / height**2
    sine, cosine = np.sqrt(sine2), np.sqrt(1.0 - sine2)
    across = _across(nadir)
    phi = 2.0 * pi / azimuths * (np.arange(azimuths) + 0.5)
    around = np.cos(phi)[:, None] * across[0] + np.sin(phi)[:, None] * across[1]
    directions = cosine[:, None, None] * nadir + sine[:, None, None] * around
    distance = height * cosine - np.sqrt(1.0 - height**2 * sine2)
    ground = distance[:, None, None] * directions - height * nadir
    lit = np.maximum(0.0, ground @ sun)
    solid = 0.5 * w / height**2 * pi / azimuths / cosine  # sums to 2 pi (1 - cos) of the disc
    weights = planet.albedo * flux / pi * solid[:, None] * lit
    seen = weights.ravel() > 0.0
    return Glow(directions.reshape(-1, 3)[seen], weights.ravel()[seen], nadir, 1.0 / height)


def irradiance(glow: Glow, normals: Array) -> Array:
    """(m,) [W/m^2]  on plates with normals (m, 3); zeros for a normal: the mean of all attitudes.

    A mean attitude takes a quarter of what a plate takes that faces the light.
    """
    out = np.empty(len(normals))
    _sum(glow.directions, glow.weights, glow.axis, glow.sine, np.ascontiguousarray(normals), out)
    return out


@njit(cache=True)
def _sum(d, w, axis, sine, n, out):
    sx = sy = sz = total = 0.0
    for k in range(len(w)):
        sx, sy, sz = sx + w[k] * d[k, 0], sy + w[k] * d[k, 1], sz + w[k] * d[k, 2]
        total += w[k]
    for i in range(len(n)):
        x, y, z = n[i, 0], n[i, 1], n[i, 2]
        facing = x * axis[0] + y * axis[1] + z * axis[2]
        if x == 0.0 and y == 0.0 and z == 0.0:
            out[i] = 0.25 * total
        elif facing >= sine:  # all of the planet is before the plate
            out[i] = x * sx + y * sy + z * sz
        else:
            e = 0.0
            if facing > -sine:
                for k in range(len(w)):
                    e += w[k] * max(0.0, x * d[k, 0] + y * d[k, 1] + z * d[k, 2])
            out[i] = e


def _across(axis: Array) -> Array:
    """(2, 3)  two unit vectors at right angles to ``axis`` and to one another."""
    other = np.zeros(3)
    other[int(np.argmin(np.abs(axis)))] = 1.0
    first = np.cross(axis, other)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])
