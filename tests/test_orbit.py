"""Orbits, the sun's place and eclipses against almanac, closed forms and rays."""

from datetime import UTC, datetime
from math import acos, asin, cos, degrees, pi, radians, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from thermal.orbit import (
    ASTRONOMICAL_UNIT,
    EARTH_RADIUS,
    GEOSTATIONARY,
    GRAVITY,
    SOLAR_CONSTANT,
    SUN_RADIUS,
    DatedSun,
    FixedSun,
    Orbit,
    beta_angle,
    circular,
    eccentric_anomaly,
    julian_date,
    sun_at_beta,
    sun_position,
    visible_sun,
)

GEO = Orbit(GEOSTATIONARY)
MOLNIYA = Orbit(26.6e6, 0.74, radians(63.4), 0.7, radians(270.0), 1.1)


# ---------------------------------------------------------------------------------------- orbits


def test_a_geostationary_orbit_takes_a_sidereal_day():
    assert GEO.period == pytest.approx(86164.09, abs=0.01)


@pytest.mark.parametrize("orbit", [GEO, circular(400e3, 0.9, 0.3, 0.5), MOLNIYA])
def test_an_orbit_solves_the_two_body_problem(orbit):
    def rate(_, y):
        return np.concatenate([y[3:], -GRAVITY * y[:3] / np.linalg.norm(y[:3]) ** 3])

    start, end = np.concatenate(orbit.at(0.0)), 0.8 * orbit.period
    away = solve_ivp(rate, (0.0, end), start, method="DOP853", rtol=1e-12, atol=1e-6).y[:, -1]
    r, v = orbit.at(end)
    assert np.linalg.norm(away[:3] - r) < 1e-8 * np.linalg.norm(r)
    assert np.linalg.norm(away[3:] - v) < 1e-8 * np.linalg.norm(v)


def test_the_phase_counts_from_the_ascending_node():
    turned = Orbit(7e6, 0.2, 0.6, 1.1, 0.4, 0.0)
    r, v = turned.at(0.0)
    assert np.allclose(r / np.linalg.norm(r), [cos(1.1), sin(1.1), 0.0], atol=1e-14)
    assert v[2] > 0.0
    ahead, _ = Orbit(7e6, 0.2, 0.6, 1.1, 0.4, 0.5).at(0.0)
    assert r @ ahead / np.linalg.norm(r) / np.linalg.norm(ahead) == pytest.approx(cos(0.5))
    perigee, _ = Orbit(7e6, 0.2, 0.6, 1.1, 0.4, 0.4).at(0.0)
    assert np.linalg.norm(perigee) == pytest.approx(0.8 * 7e6)


def test_keplers_equation_is_solved_up_to_parabolas():
    for e in (0.0, 0.3, 0.9, 0.999, 0.999999):
        for mean in np.linspace(-3.1, 3.1, 41):
            E = eccentric_anomaly(mean, e)
            assert E - e * sin(E) == pytest.approx(mean, abs=4e-15)


def test_bad_orbits_are_refused_with_all_that_is_wrong():
    with pytest.raises(ValueError, match=r"semi_major_axis.*\n.*eccentricity"):
        Orbit(-1.0, 1.0)
    with pytest.raises(ValueError, match="finite"):
        Orbit(7e6, 0.0, float("nan"))
    with pytest.raises(ValueError, match="direction"):
        FixedSun((0.0, 0.0, 0.0))


# ------------------------------------------------------------------------------------------- sun


def test_the_sun_stands_where_meeus_has_it():
    """Meeus 1998, example 25.a: 1992 October 13.0, right ascension, declination, distance."""
    at = sun_position(2448908.5)
    away = np.linalg.norm(at)
    assert degrees(np.arctan2(at[1], at[0])) % 360.0 == pytest.approx(198.38083, abs=0.01)
    assert degrees(asin(at[2] / away)) == pytest.approx(-7.78507, abs=0.01)
    assert away / ASTRONOMICAL_UNIT == pytest.approx(0.99766, abs=1e-4)


def test_dates_become_julian():
    assert julian_date(datetime(1992, 10, 13)) == 2448908.5
    assert julian_date(datetime(1957, 10, 4, 19, 26, 24, tzinfo=UTC)) == pytest.approx(2436116.31)


def test_equinox_and_solstice():
    equinox = sun_position(julian_date(datetime(2026, 3, 20, 14, 46)))
    assert abs(degrees(asin(equinox[2] / np.linalg.norm(equinox)))) < 0.01
    solstice = sun_position(julian_date(datetime(2026, 6, 21, 8, 25)))
    assert degrees(asin(solstice[2] / np.linalg.norm(solstice))) == pytest.approx(23.436, abs=0.01)


def test_sunlight_over_the_year():
    """From 1407.7 W/m^2 in January to 1316.6 W/m^2 in July."""
    sun = DatedSun(datetime(2026, 1, 1))
    away = [np.linalg.norm(sun.at(86400.0 * day)) for day in range(365)]
    flux = SOLAR_CONSTANT * (ASTRONOMICAL_UNIT / np.array(away)) ** 2
    assert flux.max() == pytest.approx(1407.7, abs=0.3)
    assert flux.min() == pytest.approx(1316.6, abs=0.3)
    assert flux.argmax() in range(1, 5)


@pytest.mark.parametrize("beta", [-1.2, 0.0, 0.3, pi / 2])
def test_a_sun_at_a_beta_angle(beta):
    orbit = circular(500e3, 0.9, 2.0)
    assert beta_angle(orbit, sun_at_beta(orbit, beta, 0.7).at(0.0)) == pytest.approx(beta)


def test_noon_is_where_it_was_asked_for():
    for phase, nearest in ((0.7, True), (0.8, False)):
        orbit = circular(500e3, 0.9, 2.0, phase)
        sun, (r, v) = sun_at_beta(orbit, 0.3, 0.7).at(0.0), orbit.at(0.0)
        assert (abs(v @ sun) < 1e-6 * abs(r @ sun)) == nearest


# --------------------------------------------------------------------------------------- eclipse


def times_of(orbit, sun, radius=EARTH_RADIUS):
    """Seconds from the middle of the eclipse to the end of its umbra and of its penumbra."""

    def at(t):
        return visible_sun(orbit.at(t)[0], sun.at(t), radius)

    half = orbit.period / 4.0
    umbra = brentq(lambda t: (at(t) > 0.0) - 0.5, 0.0, half, xtol=1e-6)
    return umbra, brentq(lambda t: (at(t) >= 1.0) - 0.5, 0.0, half, xtol=1e-6)


def test_longest_eclipse_of_a_geostationary_orbit():
    """Cones of shadow about the line from the sun: exact angles at the centre of the earth."""
    umbra, penumbra = times_of(GEO, FixedSun((-1.0, 0.0, 0.0)))
    earth = asin(EARTH_RADIUS / GEOSTATIONARY)
    for time, rim in ((umbra, EARTH_RADIUS - SUN_RADIUS), (penumbra, EARTH_RADIUS + SUN_RADIUS)):
        angle = earth + asin(rim / ASTRONOMICAL_UNIT)
        assert time == pytest.approx(angle * GEO.period / (2.0 * pi), abs=0.02)
    assert 2.0 * umbra / 60.0 == pytest.approx(67.29, rel=5e-4)
    assert 2.0 * penumbra / 60.0 == pytest.approx(71.54, rel=5e-4)
    assert penumbra - umbra == pytest.approx(128.0, abs=0.6)


def test_a_geostationary_orbit_sees_no_eclipse_at_solstice():
    sun = DatedSun(datetime(2026, 6, 21, 8, 25))
    times = np.linspace(0.0, GEO.period, 400)
    assert all(visible_sun(GEO.at(t)[0], sun.at(t)) == 1.0 for t in times)


@pytest.mark.parametrize("beta", [0.0, 20.0, 45.0, 65.0, 69.0, 75.0])
def test_low_orbit_in_a_cylindrical_shadow(beta):
    """acos(sqrt(h^2 + 2 R h)/((R + h) cos beta))/pi of the orbit, for a sun far away."""
    orbit = circular(400e3, 0.9, 2.0)
    sun = sun_at_beta(orbit, radians(beta), distance=1e6 * ASTRONOMICAL_UNIT).at(0.0)
    times = (np.arange(20000) + 0.5) / 20000 * orbit.period
    dark = np.mean([visible_sun(orbit.at(t)[0], sun) < 0.5 for t in times])
    r = orbit.semi_major_axis
    reach = sqrt(r**2 - EARTH_RADIUS**2) / (r * cos(radians(beta)))
    assert dark == pytest.approx(acos(reach) / pi if reach < 1.0 else 0.0, abs=1.1e-4)


def seen_by_rays(position, sun, radius, n=40000):
    """Fraction of rays to the sun's disc that pass the planet."""
    towards = sun - position
    far = np.linalg.norm(towards)
    axis = towards / far
    across = np.linalg.svd(axis[None])[2][1:]
    k = np.arange(n) + 0.5
    turn, out = pi * (1.0 + sqrt(5.0)) * k, SUN_RADIUS / sqrt(far**2 - SUN_RADIUS**2)
    rim = np.sqrt(k / n) * out
    rays = (
        axis + (rim * np.cos(turn))[:, None] * across[0] + (rim * np.sin(turn))[:, None] * across[1]
    )
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    along = -rays @ position
    near = np.linalg.norm(position + along[:, None] * rays, axis=1)
    return float(np.mean((along < 0.0) | (near > radius)))


@pytest.mark.parametrize("altitude", [200e3, 700e3, 35786e3, 2e9])
def test_penumbra_against_rays(altitude):
    """Down to a low orbit, where the limb of the planet is nearly straight; and beyond its umbra,
    where it leaves a ring of the sun."""
    r, sun = EARTH_RADIUS + altitude, np.array([-ASTRONOMICAL_UNIT, 0.0, 0.0])
    a, b = SUN_RADIUS / (ASTRONOMICAL_UNIT + r), asin(EARTH_RADIUS / r)
    for share in (-1.2, -0.8, -0.3, 0.0, 0.4, 0.9, 1.1):
        angle = max(0.0, b + share * a)
        position = r * np.array([cos(angle), 0.0, sin(angle)])
        exact = seen_by_rays(position, sun, EARTH_RADIUS)
        assert visible_sun(position, sun) == pytest.approx(exact, abs=1.5e-3)


def test_on_the_ground_the_sun_sets_behind_a_straight_limb():
    position = np.array([0.0, 0.0, EARTH_RADIUS])
    assert visible_sun(position, ASTRONOMICAL_UNIT * np.array([1.0, 0.0, 1e-5])) == pytest.approx(
        0.5, abs=0.02
    )
