"""Light in space: orbit, eclipse, planet and shadows against closed forms."""

from dataclasses import replace
from datetime import datetime
from math import acos, asin, atan, cos, degrees, pi, radians, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from coupling.exposure import Exposure
from coupling.verify.heat import SIGMA, bar, conductor, still
from coupling.verify.registry import Check, Convergence, Result, problem
from mechanics.description import Beam
from mechanics.layout import Layout
from meshes.sections import Section, tube
from thermal import solvers
from thermal.description import Description, Irradiation, Member, Radiation
from thermal.illumination import Attitude, Coating, Environment, infrared, sky, sunlight
from thermal.orbit import (
    ASTRONOMICAL_UNIT,
    EARTH_RADIUS,
    GEOSTATIONARY,
    SOLAR_CONSTANT,
    SUN_RADIUS,
    DatedSun,
    FixedSun,
    Orbit,
    circular,
    sun_at_beta,
    sun_position,
    visible_sun,
)
from thermal.planet import Planet, irradiance, mean_view_factor, reflected, view_factor
from thermal.shadows import NO_FACETS, NO_TUBES, Facets, Patches, Tubes, visible

Array = NDArray[np.float64]

DISC = 4.65e-3  # [rad]  radius of the sun's disc
UP = np.array([0.0, 0.0, 1.0])
BOOM: Section = tube(0.05, 0.002)
WHITE = Planet(albedo=1.0)


@problem("heat", "orbit and sun", "Kepler; Meeus 1998, example 25.a; 1 au/distance squared")
def orbit_and_sun() -> list[Result]:
    at = sun_position(2448908.5)
    year = DatedSun(datetime(2026, 1, 1))
    away = np.array([np.linalg.norm(year.at(86400.0 * day)) for day in range(365)])
    flux = SOLAR_CONSTANT * (ASTRONOMICAL_UNIT / away) ** 2
    declination = degrees(asin(at[2] / float(np.linalg.norm(at))))
    ascension = degrees(np.arctan2(at[1], at[0])) % 360.0
    return [
        Check("geostationary period", Orbit(GEOSTATIONARY).period, 86164.09, 1e-7, "s"),
        Check("right ascension 1992-10-13", ascension, 198.38083, 0.01, "deg", absolute=True),
        Check("declination 1992-10-13", declination, -7.78507, 0.01, "deg", absolute=True),
        Check("sunlight in January", float(flux.max()), 1407.7, 3e-4, "W/m^2"),
        Check("sunlight in July", float(flux.min()), 1316.6, 3e-4, "W/m^2"),
    ]


@problem("heat", "longest eclipse of GEO", "cones that touch sun and earth; 67.29 and 71.54 min")
def geostationary_eclipse() -> list[Result]:
    """Exact angles at the earth's centre; the round numbers take the sun to be far away."""
    orbit, sun = Orbit(GEOSTATIONARY), FixedSun((-1.0, 0.0, 0.0)).at(0.0)
    umbra = 2.0 * _until(orbit, sun, 1e-12)
    whole = 2.0 * _until(orbit, sun, 1.0 - 1e-12)
    rims = EARTH_RADIUS - SUN_RADIUS, EARTH_RADIUS + SUN_RADIUS
    exact = [
        (asin(EARTH_RADIUS / GEOSTATIONARY) + asin(rim / ASTRONOMICAL_UNIT)) / pi * orbit.period
        for rim in rims
    ]
    return [
        Check("umbra, cones", umbra, exact[0], 1e-5, "s"),
        Check("with penumbra, cones", whole, exact[1], 1e-5, "s"),
        Check("umbra", umbra / 60.0, 67.29, 5e-4, "min"),
        Check("with penumbra", whole / 60.0, 71.54, 5e-4, "min"),
        Check("crossing of the penumbra", 0.5 * (whole - umbra), 128.0, 5e-3, "s"),
    ]


def _until(orbit: Orbit, sun: Array, seen: float) -> float:
    """Time [s] after the middle of an eclipse at which more than ``seen`` of the disc is seen."""
    low, high = 0.0, 0.25 * orbit.period
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        dark = visible_sun(orbit.at(middle)[0], sun) <= seen
        low, high = (middle, high) if dark else (low, middle)
    return low


@problem("heat", "eclipse of a low orbit over beta", "acos(sqrt(h^2 + 2 R h)/((R + h) cos b))/pi")
def low_eclipse() -> list[Result]:
    """A sun so far that the shadow is a cylinder; above 70 degrees there is none."""
    orbit = circular(400e3, radians(51.6), 0.4)
    r = orbit.semi_major_axis
    times = (np.arange(8000) + 0.5) / 8000 * orbit.period
    checks: list[Result] = []
    for beta in (0.0, 30.0, 60.0, 75.0):
        sun = sun_at_beta(orbit, radians(beta), distance=1e6 * ASTRONOMICAL_UNIT).at(0.0)
        dark = float(np.mean([visible_sun(orbit.at(t)[0], sun) < 0.5 for t in times]))
        reach = sqrt(r**2 - EARTH_RADIUS**2) / (r * cos(radians(beta)))
        exact = acos(min(1.0, reach)) / pi
        checks.append(Check(f"beta {beta:g} deg", dark, exact, 2.6e-4, absolute=True))
    return checks


@problem("heat", "infrared of a planet on a plate", "Howell et al. 2010, C-43; (R/r)^2; sphere")
def planet_view_factors() -> list[Result]:
    height = 1.0 + 400e3 / EARTH_RADIUS
    u = sqrt(height**2 - 1.0)
    cosine = (np.arange(100000) + 0.5) / 50000 - 1.0
    mean = float(view_factor(height, cosine).mean())
    edge = (atan(1.0 / u) - u / height**2) / pi
    return [
        Check("faces nadir", float(view_factor(height, 1.0)), height**-2, 1e-14),
        Check("on edge", float(view_factor(height, 0.0)), edge, 1e-13),
        Check("mean of all attitudes", mean, mean_view_factor(height), 1e-8),
    ]


@problem("heat", "albedo of a distant planet", "2/3 (sin a + (pi - a) cos a)/pi (R/r)^2 by phase")
def albedo_phases() -> list[Result]:
    height, nadir, checks = 1e4, -UP, list[Result]()
    for phase in (0.0, 0.5 * pi, 2.0):
        sun = np.array([sin(phase), 0.0, cos(phase)])
        glow = reflected(WHITE, height, nadir, sun, 1.0)
        value = height**2 * float(irradiance(glow, nadir[None])[0])
        exact = 2.0 / 3.0 * (sin(phase) + (pi - phase) * cos(phase)) / pi
        name = f"phase {degrees(phase):.0f} deg"
        checks.append(Check(name, value, exact, 2e-3, absolute=True))
    return checks


@problem("heat", "albedo in a low orbit", "order of the quadrature over what is seen of the earth")
def albedo_quadrature() -> list[Result]:
    """Plates of all attitudes 400 km above the terminator, against 200 rings."""
    height, sun = 1.0 + 400e3 / EARTH_RADIUS, np.array([1.0, 0.0, 0.0])
    angle, azimuth = np.meshgrid(np.linspace(0.0, 2.8, 15), np.linspace(0.0, pi, 9))
    normals = np.stack(
        [np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), -np.cos(angle)], 2
    ).reshape(-1, 3)

    def light(rings: int) -> Array:
        return irradiance(reflected(WHITE, height, -UP, sun, 1.0, rings, 4 * rings), normals)

    fine, sizes = light(200), (6, 12, 24, 48)
    errors = [float(np.sqrt(np.mean((light(n) - fine) ** 2))) for n in sizes]
    worst = float(abs(light(12) - fine).max())
    return [
        Convergence("root mean square over attitudes", sizes, errors, 2.0, 0.7, "rings"),
        Check("largest with 12 rings", worst, 0.0, 2e-4, absolute=True),
    ]


# --------------------------------------------------------------------------------------- shadows


def _points(at: Array) -> Patches:
    m = len(at)
    return Patches(at, np.tile(UP, (m, 1)), np.zeros(m), np.full(m, -1))


def _beyond(x: Array) -> Array:
    """Fraction of the unit disc beyond a chord."""
    x = np.clip(x, -1.0, 1.0)
    return 0.5 - (x * np.sqrt(1.0 - x * x) + np.arcsin(x)) / pi


@problem("heat", "penumbra of a plate", "segments of the sun's disc over a width of 2 d alpha")
def plate_penumbra() -> list[Result]:
    d, across = 20.0, np.linspace(-1.2, 1.2, 49)
    at = np.stack([5.0 + d * DISC * across, 0.0 * across, 0.0 * across], axis=1)
    square = np.array([[-5.0, -5.0, d], [5.0, -5.0, d], [5.0, 5.0, d], [-5.0, 5.0, d]])
    plate = Facets(square[[[0, 1, 2], [0, 2, 3]]], np.zeros(2, np.intp))
    seen = visible(_points(at), NO_TUBES, plate, UP, DISC)
    worst = float(abs(seen - 1.0 + _beyond(across)).max())
    return [Check("largest deviation", worst, 0.0, 1e-9, absolute=True)]


@problem("heat", "umbra and penumbra of a tube", "strip of asin(r/d) to both sides on the disc")
def tube_penumbra() -> list[Result]:
    checks: list[Result] = []
    for d in (1.0, 10.0, 50.0):
        x = np.linspace(-3.0, 3.0, 61) * max(0.05, d * DISC)
        at = np.stack([0.0 * x, x, 0.0 * x - d], axis=1)
        seen = visible(_points(at), _tube(0.05), NO_FACETS, UP, DISC)
        turn, half = np.arctan2(x, d), np.arcsin(0.05 / np.hypot(x, d))
        exact = 1.0 - _beyond((turn - half) / DISC) + _beyond((turn + half) / DISC)
        worst = float(abs(seen - exact).max())
        checks.append(Check(f"{d:g} m behind it", worst, 0.0, 1e-9, absolute=True))
    return checks


def _tube(radius: float) -> Tubes:
    """One of 400 m along x."""
    ends = np.array([[[-200.0, 0.0, 0.0]], [[200.0, 0.0, 0.0]]])
    return Tubes(
        ends[0], ends[1], np.full(1, radius), np.zeros((1, 2)), np.ones((1, 2), np.bool_),
        np.zeros(1, np.intp),
    )  # fmt: skip


@problem("heat", "sunlit tube that turns", "q Do L sin(psi), by the pose of the mechanics")
def turning_tube() -> list[Result]:
    """All vectors of all nodes turned towards the sun."""
    boom = bar(2.0, 8, 300.0, BOOM, wall_points=16)
    layout = Layout.of([Beam("bar", boom.points, boom.axes, BOOM, boom.material, 300.0)])
    exposure, areas = _lit([boom], Environment(FixedSun(UP)), layout)
    checks: list[Result] = []
    for angle in (90.0, 60.0, 20.0):
        turn = radians(90.0 - angle)
        rows = [[cos(turn), 0.0, sin(turn)], [0.0, 1.0, 0.0], [-sin(turn), 0.0, cos(turn)]]
        q = (layout.q0.reshape(-1, 3) @ np.array(rows)).ravel()
        power = float(areas @ exposure.at(0.0, _Pose(q))["sun.bar"])
        exact = SOLAR_CONSTANT * BOOM.height * 2.0 * sin(radians(angle))
        checks.append(Check(f"{angle:g} deg from the axis", power, exact, 2e-3, "W"))
    return checks


class _Pose:
    """Coordinates of a pose."""

    def __init__(self, q: Array) -> None:
        self.q = q


def _lit(
    members: list[Member], environment: Environment, layout: Layout | None = None
) -> tuple[Exposure, Array]:
    """Exposure of black tubes, and the areas (m,) [m^2] of all of its points."""
    names = [m.name for m in members]
    conditions = [Irradiation(f"sun.{n}", n) for n in names]
    d = Description(members, conditions=conditions)
    irradiated = solvers.build("line", d).irradiated
    coatings = [Coating(f"sun.{n}", n) for n in names]
    faces = [block for n in names for block in irradiated[f"sun.{n}"]]
    areas = np.concatenate([block.areas.ravel() for block in faces])
    return Exposure(environment, coatings, irradiated, d, layout), areas


@problem("heat", "tube behind tube", "what one takes the other lacks: q times the outline of both")
def tube_behind_tube() -> list[Result]:
    """Two parallel tubes 1 m apart, the sun turning about them, the front one longer.

    Seen in line the back one takes of the penumbra what the mean 4/(3 pi) alpha over the disc
    shows of it.
    """
    front, back = (bar(n, 8, 300.0, BOOM, wall_points=32, name=str(n)) for n in (12.0, 10.0))
    back = replace(back, points=back.points + np.array([1.0, 0.0, -1.0]))
    checks: list[Result] = []
    for angle in (0.0, 2.0, 4.0, 10.0):
        sun = np.array([0.0, sin(radians(angle)), cos(radians(angle))])
        exposure, areas = _lit([front, back], Environment(FixedSun(sun)))
        power = float(areas @ np.concatenate(list(exposure.at(0.0).values())))
        aside = max(sin(radians(angle)), 4.0 / (3.0 * pi) * SUN_RADIUS / ASTRONOMICAL_UNIT)
        exact = SOLAR_CONSTANT * (12.0 * BOOM.height + 10.0 * min(BOOM.height, aside))
        checks.append(Check(f"sun at {angle:g} deg", power, exact, 5e-3, "W"))
    return checks


@problem("heat", "sunlit tube in a low orbit", "eps sigma T^4 = a q_sun + eps q_planet, means")
def tube_in_low_orbit() -> list[Result]:
    """A conducting tube across the orbit, steady at noon and at midnight."""
    orbit = circular(400e3)
    environment = Environment(sun_at_beta(orbit, 0.0), Attitude("nadir"), orbit, Planet())
    copper = conductor(1e7, 9000.0, 390.0)
    across = bar(1.0, 4, 300.0, BOOM, copper, wall_points=16)
    turn = np.roll(np.eye(3), 1, axis=1)  # x to y, y to z, z to x
    boom = replace(across, points=across.points @ turn, axes=across.axes @ turn)
    radiation = Radiation("space", "bar", 0.8, still(0.0))
    d = Description((boom,), conditions=(Irradiation("light", "bar"), radiation))
    solver = solvers.build("line", d)
    coating = Coating("light", "bar", "outer", 0.4, 0.8)
    exposure = Exposure(environment, [coating], solver.irradiated, d)
    phi = 2.0 * pi * np.arange(3600) / 3600
    ring = np.stack([np.sin(phi), 0.0 * phi, np.cos(phi)], axis=1)
    checks: list[Result] = []
    for name, t in (("noon", 0.0), ("midnight", 0.5 * orbit.period)):
        T, _, why = solver.steady(np.full(len(solver.x), 280.0), t, exposure.at(t))
        if why:
            raise RuntimeError(why)
        now = sky(environment, t)
        absorbed = 0.4 * sunlight(now, ring, np.ones(3600)) + 0.8 * infrared(now, ring)
        exact = (float(absorbed.mean()) / (0.8 * SIGMA)) ** 0.25
        checks.append(Check(name, float(T.mean()), exact, 1e-3, "K"))
    return checks
