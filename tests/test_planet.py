"""Infrared and albedo of a planet against closed forms and sums over its surface."""

from math import acos, asin, atan, cos, pi, sin, sqrt

import numpy as np
import pytest

from thermal.orbit import EARTH_RADIUS
from thermal.planet import (
    Planet,
    emitted,
    irradiance,
    mean_view_factor,
    reflected,
    view_factor,
)

NADIR = np.array([0.0, 0.0, -1.0])
HEIGHTS = [1.0 + 200e3 / EARTH_RADIUS, 1.0 + 800e3 / EARTH_RADIUS, 2.0, 6.6107]
WHITE = Planet(albedo=1.0)


def tilted(angle, azimuth=0.0):
    """Normal of a plate at an angle from nadir."""
    return np.array([sin(angle) * cos(azimuth), sin(angle) * sin(azimuth), -cos(angle)])


def by_surface(height, normal, brightness, n=700):
    """Irradiance by a sum over the visible cap of the unit sphere, of ``brightness`` [W/m^2]."""
    s = (np.arange(n) + 0.5) / n  # finer below the plate
    z = 1.0 - (1.0 - 1.0 / height) * s**2
    phi = 2.0 * pi * (np.arange(n) + 0.5) / n
    rim = np.sqrt(1.0 - z**2)[:, None]
    ground = np.stack(np.broadcast_arrays(rim * np.cos(phi), rim * np.sin(phi), z[:, None]), 2)
    away = ground - np.array([0.0, 0.0, height])
    distance = np.linalg.norm(away, axis=2)
    up = -np.einsum("ijc,ijc->ij", away, ground) / distance
    plate = np.maximum(0.0, away @ normal) / distance
    area = (1.0 - 1.0 / height) * 2.0 * s[:, None] * 2.0 * pi / n**2
    return float((brightness(ground) / pi * plate * up / distance**2 * area).sum())


@pytest.mark.parametrize("height", HEIGHTS)
def test_a_plate_that_faces_the_planet(height):
    assert view_factor(height, 1.0) == pytest.approx(height**-2, rel=1e-15)
    # it takes all of the planet until its plane touches the sphere
    at = 1.0 / height
    assert view_factor(height, at) == pytest.approx(at**3, rel=1e-7)
    assert view_factor(height, -at) == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("height", HEIGHTS)
def test_a_plate_on_edge(height):
    """1/pi (atan(1/u) - u/H^2), u = sqrt(H^2 - 1)  (Howell et al. 2010, C-43)."""
    u = sqrt(height**2 - 1.0)
    assert view_factor(height, 0.0) == pytest.approx((atan(1.0 / u) - u / height**2) / pi)


@pytest.mark.parametrize("height", HEIGHTS)
def test_the_mean_over_all_attitudes_is_that_of_a_sphere(height):
    cosine = (np.arange(200000) + 0.5) / 100000 - 1.0
    mean = float(view_factor(height, cosine).mean())
    assert mean == pytest.approx(mean_view_factor(height), rel=1e-8)
    assert mean_view_factor(height) == pytest.approx(0.5 * (1.0 - cos(asin(1.0 / height))))


@pytest.mark.parametrize("height", HEIGHTS)
def test_all_attitudes_against_the_surface(height):
    for angle in np.linspace(0.0, 2.9, 9):
        exact = by_surface(height, tilted(angle), lambda ground: 1.0)
        assert view_factor(height, cos(angle)) == pytest.approx(exact, abs=2e-5)  # of the sum


@pytest.mark.parametrize("height", HEIGHTS)
@pytest.mark.parametrize("zenith", [0.0, 1.0, 1.5, 1.9])
def test_albedo_against_the_surface(height, zenith):
    sun = np.array([sin(zenith), 0.0, cos(zenith)])
    glow = reflected(WHITE, height, NADIR, sun, 1.0)
    for angle, azimuth in ((0.0, 0.0), (0.9, 0.4), (1.5, 2.0), (2.0, 0.0), (1.8, 3.0)):
        normal = tilted(angle, azimuth)
        exact = by_surface(height, normal, lambda ground: np.maximum(0.0, ground @ sun))
        assert irradiance(glow, normal[None])[0] == pytest.approx(exact, abs=2e-4)


def test_phases_of_a_distant_planet():
    """2/3 (sin a + (pi - a) cos a)/pi (R/r)^2 of a Lambert sphere at the phase angle a."""
    height = 1e4
    for phase in (0.0, 0.5, 1.5, 2.5):
        sun = np.array([sin(phase), 0.0, cos(phase)])
        glow = reflected(WHITE, height, NADIR, sun, 1.0, 40, 80)
        exact = 2.0 / 3.0 * (sin(phase) + (pi - phase) * cos(phase)) / pi
        assert irradiance(glow, NADIR[None])[0] * height**2 == pytest.approx(exact, abs=5e-4)


def test_a_lump_takes_the_mean_of_all_attitudes():
    sun = np.array([0.6, 0.0, 0.8])
    glow = reflected(WHITE, 1.1, NADIR, sun, 1.0)
    z, w = np.polynomial.legendre.leggauss(40)
    phi = 2.0 * pi * (np.arange(80) + 0.5) / 80
    rim = np.sqrt(1.0 - z**2)[:, None]
    normals = np.stack(np.broadcast_arrays(rim * np.cos(phi), rim * np.sin(phi), z[:, None]), 2)
    plates = irradiance(glow, normals.reshape(-1, 3)).reshape(40, 80)
    mean = float(w @ plates.mean(axis=1)) / 2.0
    assert irradiance(glow, np.zeros((1, 3)))[0] == pytest.approx(mean, rel=2e-3)


def test_the_shortcut_for_plates_that_see_all_of_the_planet():
    """It begins where the plane of the plate touches the sphere, without a step."""
    glow = reflected(WHITE, 1.5, NADIR, np.array([0.8, 0.0, 0.6]), 1.0)
    edge = acos(1.0 / 1.5)
    below, above = irradiance(glow, np.stack([tilted(edge - 1e-6), tilted(edge + 1e-6)]))
    assert below == pytest.approx(above, rel=1e-5)


def test_the_night_side_is_dark():
    glow = reflected(WHITE, 1.1, NADIR, np.array([0.0, 0.0, -1.0]), 1361.0)
    assert len(glow.weights) == 0
    assert irradiance(glow, NADIR[None])[0] == 0.0


def test_infrared_from_a_temperature():
    assert emitted(254.0) == pytest.approx(236.0, abs=0.1)
    with pytest.raises(ValueError, match="below 0 K"):
        emitted(-1.0)


def test_bad_planets_are_refused_with_all_that_is_wrong():
    with pytest.raises(ValueError, match=r"radius.*\n.*albedo.*\n.*infrared"):
        Planet(0.0, 1.5, -1.0)
