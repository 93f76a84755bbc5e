"""Sun and planet as a structure in orbit sees them, in the coordinates of its case."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import acos, asin, inf, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thermal.orbit import (
    ASTRONOMICAL_UNIT,
    SOLAR_CONSTANT,
    SUN_RADIUS,
    Orbit,
    Sun,
    visible_sun,
)
from thermal.planet import Glow, Planet, irradiance, mean_view_factor, reflected, view_factor

Array = NDArray[np.float64]

FRAMES = ("inertial", "nadir", "sun")


def _start() -> Array:
    return np.zeros(1)


def _upright() -> Array:
    return np.array([[0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Attitude:
    """How the coordinates of the case stand, over time, in one of three frames.

    "inertial"  equator and equinox, z to the north pole
    "nadir"     z to the centre of the planet, y against the orbit's normal, x ahead
    "sun"       x towards the sun, z as near to the orbit's normal as that allows (without an
                orbit to the north pole)

    Attributes
    ----------
    frame : str
    times : (n,) float [s]  rising; before the first and after the last the attitude is held
    quaternions : (n, 4) float  x, y, z, w of the rotation that takes vectors of the case into the
        frame; between two times it turns at a constant rate about a fixed axis, the short way
    """

    frame: str = "inertial"
    times: ArrayLike = field(default_factory=_start)
    quaternions: ArrayLike = field(default_factory=_upright)

    def __post_init__(self) -> None:
        t, q = np.asarray(self.times, float), np.asarray(self.quaternions, float)
        wrong = []
        if self.frame not in FRAMES:
            wrong.append(f"attitude: no frame {self.frame!r}; there are {', '.join(FRAMES)}")
        if t.ndim != 1 or not t.size or not np.isfinite(t).all() or (np.diff(t) <= 0.0).any():
            wrong.append("attitude: times must be finite and rise")
        if q.shape != (t.size, 4):
            wrong.append(f"attitude: {t.size} times need as many quaternions, got {q.shape}")
        elif not np.isfinite(q).all() or not (np.linalg.norm(q, axis=1) > 0.0).all():
            wrong.append("attitude: quaternions must be finite and not zero")
        if wrong:
            raise ValueError("\n".join(wrong))

    def within(self, t: float) -> Array:
        """(3, 3)  that takes vectors of the case into the frame at ``t`` [s]."""
        from scipy.spatial.transform import Rotation

        times, turns = np.asarray(self.times, float), Rotation.from_quat(self.quaternions)
        last = int(np.searchsorted(times, t))
        if last in (0, len(times)):
            return turns[min(last, len(times) - 1)].as_matrix()
        a, b = turns[last - 1], turns[last]
        s = (t - times[last - 1]) / (times[last] - times[last - 1])
        return (a * Rotation.from_rotvec(s * (a.inv() * b).as_rotvec())).as_matrix()


def quaternions(angles: ArrayLike, sequence: str = "ZYX") -> Array:
    """(n, 4)  x, y, z, w from Euler angles (n, 3) [rad].

    sequence : axes one after the other; capitals: as they turn along (intrinsic)
    """
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler(sequence, np.atleast_2d(angles)).as_quat()


@dataclass(frozen=True)
class Environment:
    """What surrounds a structure in space.

    Attributes
    ----------
    sun : FixedSun or DatedSun
    attitude : Attitude
    orbit : Orbit | None  None: far from any planet
    planet : Planet | None  None: neither eclipses nor heat from it
    flux : float [W/m^2]  of sunlight at one astronomical unit
    """

    sun: Sun
    attitude: Attitude = field(default_factory=Attitude)
    orbit: Orbit | None = None
    planet: Planet | None = None
    flux: float = SOLAR_CONSTANT

    def __post_init__(self) -> None:
        wrong = []
        if not 0.0 <= self.flux < inf:
            wrong.append(f"environment: flux must be at least 0, got {self.flux:g} W/m^2")
        if self.orbit is None and self.planet is not None:
            wrong.append("environment: a planet needs an orbit about it")
        if self.orbit is None and self.attitude.frame == "nadir":
            wrong.append("environment: the frame 'nadir' needs an orbit")
        if self.orbit and self.planet and self.orbit.lowest <= self.planet.radius:
            wrong.append(
                f"environment: the orbit comes to {self.orbit.lowest / 1e3:g} km from the centre "
                f"of a planet with a radius of {self.planet.radius / 1e3:g} km"
            )
        if wrong:
            raise ValueError("\n".join(wrong))


@dataclass(frozen=True)
class Coating:
    """How a face takes up light.

    Attributes
    ----------
    condition : name of the irradiation that it feeds
    body, face : what is coated
    absorptivity : float [-]  of sunlight, direct and reflected by the planet
    emissivity : float [-]  of infrared, which is its absorptivity for that of the planet
    """

    condition: str
    body: str
    face: str = "outer"
    absorptivity: float = 1.0
    emissivity: float = 1.0

    def __post_init__(self) -> None:
        given = {"absorptivity": self.absorptivity, "emissivity": self.emissivity}
        wrong = [
            f"coating '{self.condition}': {name} must be in [0, 1], got {value:g}"
            for name, value in given.items()
            if not 0.0 <= value <= 1.0
        ]
        if wrong:
            raise ValueError("\n".join(wrong))


class Sky(NamedTuple):
    """What is overhead, in the coordinates of the case.

    sun : (3,) unit vector towards it
    flux : float [W/m^2]  of sunlight that the planet leaves
    radius : float [rad]  of the sun's disc
    visible : float [-]  fraction of the disc beside the planet
    nadir : (3,) unit vector to the centre of the planet; zeros without one
    height : float [-]  distance from the centre of the planet over its radius
    infrared : float [W/m^2]  emitted by the planet
    glow : Glow | None  sunlight that it reflects; None: there is none
    """

    sun: Array
    flux: float
    radius: float
    visible: float
    nadir: Array
    height: float
    infrared: float
    glow: Glow | None


def sky(environment: Environment, t: float) -> Sky:
    """Sun and planet at a time [s]."""
    sun = environment.sun.at(t)
    none = np.zeros(3), np.zeros(3)
    r, v = none if environment.orbit is None else environment.orbit.at(t)
    into_case = (_frame(environment, r, v, sun) @ environment.attitude.within(t)).T
    towards = sun - r
    distance = float(np.linalg.norm(towards))
    ray, planet = into_case @ (towards / distance), environment.planet
    flux = environment.flux * (ASTRONOMICAL_UNIT / distance) ** 2
    radius = asin(min(1.0, SUN_RADIUS / distance))
    if planet is None:
        return Sky(ray, flux, radius, 1.0, np.zeros(3), inf, 0.0, None)
    visible = visible_sun(r, sun, planet.radius)
    far = float(np.linalg.norm(r))
    nadir, height = into_case @ (-r / far), far / planet.radius
    there = environment.flux * (ASTRONOMICAL_UNIT / float(np.linalg.norm(sun))) ** 2
    glow = _glow(planet, height, nadir, into_case @ (sun / np.linalg.norm(sun)), there)
    return Sky(ray, visible * flux, radius, visible, nadir, height, planet.infrared, glow)


def _glow(planet: Planet, height: float, nadir: Array, sun: Array, flux: float) -> Glow | None:
    """None where all of the ground that is seen lies in the dark."""
    below = acos(max(-1.0, min(1.0, -float(nadir @ sun))))
    if planet.albedo * flux == 0.0 or below >= 0.5 * np.pi + acos(1.0 / height):
        return None
    return reflected(planet, height, nadir, sun, flux)


def _frame(environment: Environment, r: Array, v: Array, sun: Array) -> Array:
    """(3, 3) columns: axes of the frame of an attitude in inertial ones."""
    name = environment.attitude.frame
    if name == "inertial":
        return np.eye(3)
    if name == "nadir":
        z, y = -_unit(r), -_unit(np.cross(r, v))
        return np.stack([np.cross(y, z), y, z], axis=1)
    x, orbit = _unit(sun - r), environment.orbit
    up = np.array([0.0, 0.0, 1.0]) if orbit is None else orbit.normal
    if np.linalg.norm(np.cross(up, x)) < sin(1e-6):  # it stands over the plane of the orbit
        up = np.array([1.0, 0.0, 0.0]) if abs(x[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = _unit(np.cross(up, x))
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _unit(a: Array) -> Array:
    return a / np.linalg.norm(a)


def sunlight(now: Sky, normals: Array, seen: Array) -> Array:
    """Direct and reflected sunlight (m,) [W/m^2] on plates; normals of zeros: mean of attitudes.

    seen : (m,) float  fraction of the disc that other things leave visible
    """
    mean = ~normals.any(axis=1)
    facing = np.where(mean, 0.25, np.maximum(0.0, normals @ now.sun))
    direct = now.flux * facing * seen
    return direct if now.glow is None else direct + irradiance(now.glow, normals)


def infrared(now: Sky, normals: Array) -> Array:
    """Infrared of the planet (m,) [W/m^2] on plates; normals of zeros: mean of all attitudes."""
    if now.infrared == 0.0:
        return np.zeros(len(normals))
    factors = view_factor(now.height, normals @ now.nadir)
    mean = ~normals.any(axis=1)
    return now.infrared * np.where(mean, mean_view_factor(now.height), factors)


def coating_problems(coatings: Sequence[Coating]) -> list[str]:
    """Conditions that two coatings feed."""
    names = [c.condition for c in coatings]
    return [f"two coatings feed '{n}'" for n in dict.fromkeys(names) if names.count(n) > 1]
