"""Where a spacecraft is over time, where the sun stands, and how much of it the planet hides.

Inertial coordinates are those of the equator and equinox: z to the north pole, x to the equinox.
Two bodies alone: the orbit keeps its plane (no flattening of the planet, no drag).
"""

from dataclasses import dataclass
from datetime import UTC, datetime
from math import acos, asin, atan2, cos, inf, isfinite, pi, radians, sin, sqrt, tan

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

GRAVITY = 3.986004418e14  # [m^3/s^2]  gravitational parameter of the earth
EARTH_RADIUS = 6378137.0  # [m]
SUN_RADIUS = 6.957e8  # [m]
ASTRONOMICAL_UNIT = 1.495978707e11  # [m]
SOLAR_CONSTANT = 1361.0  # [W/m^2]  at one astronomical unit (Kopp & Lean 2011)
GEOSTATIONARY = 42164170.0  # [m]  semi-major axis
DAY = 86400.0  # [s]
J2000 = 2451545.0  # [d]  Julian date


@dataclass(frozen=True)
class Orbit:
    """A Kepler ellipse about the earth.

    Attributes
    ----------
    semi_major_axis : float [m]
    eccentricity : float [-]  0 <= e < 1
    inclination, node : float [rad]  to the equator; right ascension of the ascending node
    perigee : float [rad]  from the ascending node to the perigee
    phase : float [rad]  from the ascending node to the spacecraft at t = 0
    gravity : float [m^3/s^2]
    """

    semi_major_axis: float
    eccentricity: float = 0.0
    inclination: float = 0.0
    node: float = 0.0
    perigee: float = 0.0
    phase: float = 0.0
    gravity: float = GRAVITY

    def __post_init__(self) -> None:
        wrong = [f"orbit: {k} must be finite" for k, v in vars(self).items() if not isfinite(v)]
        if not self.semi_major_axis > 0.0:
            wrong.append(f"orbit: semi_major_axis must be positive, got {self.semi_major_axis:g} m")
        if not 0.0 <= self.eccentricity < 1.0:
            wrong.append(f"orbit: eccentricity must be in [0, 1), got {self.eccentricity:g}")
        if not self.gravity > 0.0:
            wrong.append(f"orbit: gravity must be positive, got {self.gravity:g} m^3/s^2")
        if wrong:
            raise ValueError("\n".join(wrong))

    @property
    def mean_motion(self) -> float:
        """[rad/s]"""
        return sqrt(self.gravity / self.semi_major_axis**3)

    @property
    def period(self) -> float:
        """[s]"""
        return 2.0 * pi / self.mean_motion

    @property
    def lowest(self) -> float:
        """Distance of the perigee from the centre of the planet [m]."""
        return self.semi_major_axis * (1.0 - self.eccentricity)

    @property
    def normal(self) -> Array:
        """(3,) unit, along the angular momentum."""
        return self._plane()[2]

    def at(self, t: float) -> tuple[Array, Array]:
        """Position (3,) [m] from the centre of the planet and velocity (3,) [m/s]."""
        e, n, a = self.eccentricity, self.mean_motion, self.semi_major_axis
        E = eccentric_anomaly(self._mean_anomaly_at_start() + n * t, e)
        root, slow = sqrt(1.0 - e * e), 1.0 - e * cos(E)
        p, q, _ = self._plane()
        r = a * ((cos(E) - e) * p + root * sin(E) * q)
        return r, n * a / slow * (-sin(E) * p + root * cos(E) * q)

    def _mean_anomaly_at_start(self) -> float:
        e, half = self.eccentricity, 0.5 * (self.phase - self.perigee)
        E = 2.0 * atan2(sqrt(1.0 - e) * sin(half), sqrt(1.0 + e) * cos(half))
        return E - e * sin(E)

    def _plane(self) -> Array:
        """(3, 3) rows: to the perigee, a quarter turn ahead of it, normal."""
        return _turn(2, self.perigee) @ _turn(0, self.inclination) @ _turn(2, self.node)


def circular(
    altitude: float,
    inclination: float = 0.0,
    node: float = 0.0,
    phase: float = 0.0,
    radius: float = EARTH_RADIUS,
) -> Orbit:
    """A circular orbit at an altitude [m] above a planet of the earth's mass."""
    return Orbit(radius + altitude, 0.0, inclination, node, 0.0, phase)


def eccentric_anomaly(mean: float, e: float) -> float:
    """E of Kepler's equation M = E - e sin E [rad], by Newton's method held within bounds."""
    mean = (mean + pi) % (2.0 * pi) - pi
    low, high, E = mean - e, mean + e, mean + e * sin(mean)
    for _ in range(60):
        defect = E - e * sin(E) - mean
        low, high = (low, E) if defect > 0.0 else (E, high)
        step = E - defect / (1.0 - e * cos(E))
        following = step if low <= step <= high else 0.5 * (low + high)
        if abs(following - E) <= 1e-15 * max(1.0, abs(E)):
            return following
        E = following
    return E


def _turn(axis: int, angle: float) -> Array:
    """(3, 3)  rows: axes turned by ``angle`` about one of them, in the old ones."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rows = np.eye(3)
    rows[i, i] = rows[j, j] = cos(angle)
    rows[i, j], rows[j, i] = sin(angle), -sin(angle)
    return rows


# ------------------------------------------------------------------------------------------ sun


@dataclass(frozen=True)
class FixedSun:
    """A sun that stands still.

    direction : (3,) float  towards it
    distance : float [m]
    """

    direction: ArrayLike
    distance: float = ASTRONOMICAL_UNIT

    def __post_init__(self) -> None:
        d = np.asarray(self.direction, dtype=float)
        wrong = []
        if d.shape != (3,) or not np.isfinite(d).all() or not d.any():
            wrong.append(f"sun: direction must be a vector that is not zero, got {d}")
        if not 0.0 < self.distance < inf:
            wrong.append(f"sun: distance must be positive and finite, got {self.distance:g} m")
        if wrong:
            raise ValueError("\n".join(wrong))

    def at(self, t: float) -> Array:
        """(3,) [m]  from the centre of the planet."""
        d = np.asarray(self.direction, dtype=float)
        return self.distance / float(np.linalg.norm(d)) * d


@dataclass(frozen=True)
class DatedSun:
    """The sun as the earth sees it from a date on.

    start : datetime  universal time at t = 0; taken as UTC where it names no zone
    """

    start: datetime

    def at(self, t: float) -> Array:
        """(3,) [m]  from the centre of the earth."""
        return sun_position(julian_date(self.start) + t / DAY)


Sun = FixedSun | DatedSun


def julian_date(moment: datetime) -> float:
    """Julian date [d]."""
    utc = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
    return J2000 + (utc - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / DAY


def sun_position(date: float) -> Array:
    """(3,) [m]  of the sun from the earth at a Julian date.

    Low-precision formulas of the Astronomical Almanac, page C5: 0.01 degrees between 1950 and
    2050.
    """
    n = date - J2000
    g = radians(357.528 + 0.9856003 * n)
    longitude = radians(280.460 + 0.9856474 * n + 1.915 * sin(g) + 0.020 * sin(2.0 * g))
    tilt = radians(23.439 - 4e-7 * n)
    distance = 1.00014 - 0.01671 * cos(g) - 0.00014 * cos(2.0 * g)
    towards = cos(longitude), cos(tilt) * sin(longitude), sin(tilt) * sin(longitude)
    return ASTRONOMICAL_UNIT * distance * np.array(towards)


def sun_at_beta(
    orbit: Orbit, beta: float, noon: float = 0.0, distance: float = ASTRONOMICAL_UNIT
) -> FixedSun:
    """A sun at the angle ``beta`` [rad] above the plane of an orbit.

    noon : float [rad]  from the ascending node to where the spacecraft is nearest to the sun
    """
    to_node, ahead, normal = _turn(0, orbit.inclination) @ _turn(2, orbit.node)
    inplane = cos(noon) * to_node + sin(noon) * ahead
    return FixedSun(cos(beta) * inplane + sin(beta) * normal, distance)


def beta_angle(orbit: Orbit, sun: Array) -> float:
    """Angle [rad] of the sun at (3,) [m] above the plane of an orbit."""
    return asin(float(orbit.normal @ sun) / float(np.linalg.norm(sun)))


# -------------------------------------------------------------------------------------- eclipse


def visible_sun(position: Array, sun: Array, radius: float = EARTH_RADIUS) -> float:
    """Fraction of the sun's disc that a planet leaves visible: 1 in sunlight, 0 in the umbra.

    Overlap of two discs (Montenbruck & Gill 2000, 3.4.2), the sun evenly bright. The planet, which
    is large for those in low orbits, is a plane disc of the tangent of its angular radius, placed
    so that its limb has its true distance from the sun and its true curvature there.

    Parameters
    ----------
    position, sun : (3,) float [m]  of spacecraft and sun from the centre of the planet
    radius : float [m]  of the planet
    """
    towards = sun - position
    far, r = float(np.linalg.norm(towards)), float(np.linalg.norm(position))
    a, b = asin(SUN_RADIUS / far), asin(min(1.0, radius / r))
    c = acos(max(-1.0, min(1.0, -float(position @ towards) / (r * far))))
    if c >= a + b:
        return 1.0
    if b >= 0.5 * pi - 1e-6:  # on the ground the limb is straight
        return 1.0 - _disc_beyond((c - b) / a)
    return 1.0 - _overlap((tan(b) + c - b) / a, tan(b) / a) / pi


def _disc_beyond(x: float) -> float:
    """Fraction of the unit disc beyond a chord at distance ``x`` from its centre."""
    x = max(-1.0, min(1.0, x))
    return (acos(x) - x * sqrt(1.0 - x * x)) / pi


def _overlap(d: float, R: float) -> float:
    """Area common to a unit disc and a disc of radius ``R`` at the distance ``d``."""
    if d >= 1.0 + R:
        return 0.0
    if d <= abs(R - 1.0):
        return pi * min(1.0, R) ** 2
    x = (d * d + 1.0 - R * R) / (2.0 * d)  # chord, from the centre of the unit disc
    y = d - x
    half = sqrt(max(0.0, 1.0 - x * x))
    return acos(x) - x * half + R * R * atan2(half, y) - y * half
