"""The shipped cases of sun, eclipse and moving shadow against balances and rays of their own."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from coupling import casefile
from coupling.reading import Results
from coupling.simulation import run
from coupling.skin_shapes import small_facets

CASES = Path(__file__).parent.parent / "cases"
SIGMA, SOLAR = 5.670374419e-8, 1361.0


def result(case, folder, *settings):
    scene = casefile.read(CASES / case, [*settings, "output.export=[]"])
    outcome = run(scene, folder)
    assert outcome.code == 0, outcome.reason
    return Results.open(outcome.folder)


# ---------------------------------------------------------------------------- tube in the eclipse

RADIUS, THICKNESS, LENGTH = 20e-3, 0.25e-3, 15.0
OUTER = RADIUS + 0.5 * THICKNESS
ABSORPTIVITY, EMISSIVITY = 0.85, 0.8
ENTRY = 20.0  # about [s]


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    """From a little sunlight into the dark, beside a planet that only casts a shadow."""
    environment = "thermal.environment"
    settings = ["time.end='240 s'", "body.boom.elements=3", "output.frames=60",
                f"{environment}.orbit.phase='112.9 deg'", f"{environment}.planet.albedo=0.0",
                f"{environment}.planet.infrared='0 W/m^2'", "thermal.wall_points=32",
                "integrator.tolerance=1e-3"]  # fmt: skip
    with result("sunlit_tube", tmp_path_factory.mktemp("tube"), *settings) as results:
        yield results


def test_sunlight_falls_on_the_outline_and_not_in_the_shadow(tube):
    power = np.diff(tube["ledger/heat_light.skin"], prepend=0.0) / tube["windows/window"]
    visible = tube["sky/visible"]
    sunny, dark = visible == 1.0, visible == 0.0
    assert 2 < sunny.sum() < 10 and dark.sum() > 40
    whole = ABSORPTIVITY * SOLAR * 2.0 * OUTER * LENGTH
    # the bent tube turns away by a little
    assert_allclose(power[sunny[1:]], whole, rtol=2e-3)
    assert np.all(power[dark[:-1] & dark[1:]] == 0.0)
    light = tube["skins/boom.outer/light"]
    after = np.searchsorted(tube["sky/time"][dark], tube["frames/time"])
    assert np.all(light[after > 0] == 0.0)


def ring(times, flux, n=128):
    """(times, n) [K] of a ring of a long tube: conduction, radiation out and across it."""
    phi = 2.0 * np.pi * np.arange(n) / n
    facing = np.maximum(0.0, np.cos(phi))
    apart = np.abs(phi[:, None] - phi)
    factors = 0.5 * np.sin(0.5 * apart) * np.pi / n * 2.0  # of an infinite cylinder
    factors /= factors.sum(axis=1, keepdims=True)
    inside = 0.8
    exchange = np.linalg.inv(np.eye(n) - (1.0 - inside) * factors)
    capacity, conduction = 1600.0 * 900.0 * THICKNESS, 2.0 * THICKNESS / (RADIUS * phi[1]) ** 2
    out, within = OUTER / RADIUS, (RADIUS - 0.5 * THICKNESS) / RADIUS

    def rate(t, T):
        emitted = inside * SIGMA * T**4
        across = inside * factors @ (exchange @ emitted) - emitted
        sun = ABSORPTIVITY * np.interp(t, *flux) * facing
        along = conduction * (np.roll(T, 1) - 2.0 * T + np.roll(T, -1))
        radiated = EMISSIVITY * SIGMA * (T**4 - 2.725**4)
        return (along + out * (sun - radiated) + within * across) / capacity

    start = np.full(n, 293.15)
    solution = solve_ivp(rate, (0.0, times[-1]), start, "BDF", times, rtol=1e-8, max_step=1.0)
    return solution.y.T


def test_the_tube_cools_as_a_ring_that_radiates(tube):
    times = tube["frames/time"]
    T = ring(times, (tube["sky/time"], tube["sky/flux"]))
    seen = tube["skins/boom.outer/temperature"].reshape(len(times), 3, -1)
    for found in (seen.mean(axis=(1, 2)) - T.mean(axis=1), seen.max(axis=(1, 2)) - T.max(axis=1),
                  seen.min(axis=(1, 2)) - T.min(axis=1)):  # fmt: skip
        assert np.abs(found).max() < 0.5
    assert T.mean(axis=1)[-1] < 293.15 - 60.0
    assert np.ptp(T, axis=1).max() > 30.0


def test_the_tube_bends_away_from_the_sun_as_far_as_its_gradient_bends_it(tube):
    gradient = tube["bodies/boom/temperature"][:, :, 1].mean(axis=1)
    straight = 2e-6 * gradient * LENGTH**2 / 2.0
    tip = -tube["bodies/boom/position"][:, -1, 0]
    # it swings about its equilibrium; over the whole time the mean is the same
    assert tip[1:].mean() == pytest.approx(straight[1:].mean(), rel=0.1)


# ------------------------------------------------------------------------------------ array

PANELS = ("inner", "middle", "outer")
MAST, MAST_RADIUS = np.array([2.5, -1.2, 0.0]), 0.1005
MAST_SPAN = (-0.2, 2.4)
SUN = np.array([0.35, -0.85, 0.40]) / np.linalg.norm([0.35, -0.85, 0.40])
MARGIN = 0.03
"""Distance from an edge of a shadow within which nothing is said [m]."""


@pytest.fixture(scope="module")
def array(tmp_path_factory):
    coarse = [f"body.{name}.surface.elements=[2,2]" for name in PANELS]
    settings = [*coarse, "body.mast.elements=2", "time.window='5 s'", "time.end='240 s'",
                "integrator.tolerance=1e-2", "output.frames=24"]  # fmt: skip
    with result("folding_array", tmp_path_factory.mktemp("array"), *settings) as results:
        yield results


def shaded_by_mast(points):
    """(n,) float [m]  how far within the mast rays to the sun pass; negative: beside it."""
    away, flat = MAST - points, SUN[:2] / np.linalg.norm(SUN[:2])
    along = away[:, :2] @ flat
    beside = np.abs(away[:, 0] * flat[1] - away[:, 1] * flat[0])
    height = points[:, 2] + along * SUN[2] / np.linalg.norm(SUN[:2])
    ends = np.minimum(height - MAST_SPAN[0], MAST_SPAN[1] - height)
    ends = np.sign(ends) * np.maximum(0.0, np.abs(ends) - MAST_RADIUS)  # it has a width there
    return np.where(along > 0.0, np.minimum(MAST_RADIUS - beside, ends), -1.0)


def shaded_by_panel(points, corners):
    """(n,) float [m]  the same for a plane panel with corners (4, 3), as the sun sees it."""
    u, v = corners[1] - corners[0], corners[3] - corners[0]
    matrix = np.stack([u / np.linalg.norm(u), v / np.linalg.norm(v), -SUN], axis=1)
    x, y, way = np.linalg.solve(matrix, (points - corners[0]).T)
    inside = np.minimum.reduce([x, np.linalg.norm(u) - x, y, np.linalg.norm(v) - y])
    tilt = abs(float(np.cross(u, v) @ SUN)) / np.linalg.norm(np.cross(u, v))
    return np.where(way > MARGIN, tilt * inside, -1.0)


def outline(results, name, frame):
    """(4, 3) [m]  corners of a panel."""
    return results[f"bodies/{name}/position"][frame][[0, 2, 8, 6]]


def predicted(results, name, frame):
    """Points of the lit side of a panel: how deep in shadow (n,) [m], and light without any."""
    corners = small_facets(results[f"skins/{name}.top/corners"][frame], 16).reshape(-1, 4, 3)
    points = corners.mean(axis=1)
    normal = np.cross(corners[0, 2] - corners[0, 0], corners[0, 3] - corners[0, 1])
    others = [shaded_by_panel(points, outline(results, o, frame)) for o in PANELS if o != name]
    depth = np.maximum.reduce([shaded_by_mast(points), *others])
    facing = max(0.0, float(normal @ SUN / np.linalg.norm(normal)))
    return depth, 0.8 * SOLAR * facing


def test_shadows_of_mast_and_panels_are_where_rays_say(array):
    checked = dark = 0
    for frame in range(len(array["frames/time"])):
        for name in PANELS:
            depth, light = predicted(array, name, frame)
            found = array[f"skins/{name}.top/parts"][frame].reshape(-1)
            sure = np.abs(depth) > MARGIN
            assert_allclose(found[sure & (depth > 0.0)], 0.0, atol=1e-3 * SOLAR)
            assert_allclose(found[sure & (depth < 0.0)], light, atol=0.01 * SOLAR)
            checked, dark = (
                checked + sure.sum(),
                dark + (sure & (depth > 0.0) & (light > 0.0)).sum(),
            )
    assert checked > 3000 and dark > 100


def test_the_shadow_of_the_mast_passes_from_panel_to_panel(array):
    shaded = {}
    for name in PANELS:
        light = array[f"skins/{name}.top/parts"].reshape(len(array["frames/time"]), -1)
        lit = light.max(axis=1) > 100.0
        shaded[name] = lit & (light.min(axis=1) < 1.0)
    assert shaded["outer"].any() and shaded["inner"].any()
    first = {name: int(np.argmax(flags)) for name, flags in shaded.items()}
    last = len(shaded["outer"]) - int(np.argmax(shaded["outer"][::-1]))
    assert last < len(shaded["outer"]) - 5  # the shadow has left it
    assert first["outer"] < last


def test_the_array_ends_unfolded_and_bent_by_its_gradient(array):
    """Each panel is an arc; the hinges hold their angles, the root holds the direction."""
    tip = array["probes/tip/position"][-1]
    assert tip[0] == pytest.approx(6.0, abs=5e-3)
    bow = 0.0
    for number, name in enumerate(PANELS):
        top, bottom = (array[f"skins/{name}.{side}/temperature"][-1] for side in ("top", "bottom"))
        curvature = 5e-6 * (top - bottom).mean() / 12e-3
        bow += curvature * 2.0 * (6.0 - 2.0 * number - 1.0)
    assert bow > 0.03
    assert tip[1] == pytest.approx(bow, rel=0.03)


def test_what_was_in_the_shade_warms_and_the_heat_is_accounted_for(array):
    middle = array["skins/middle.top/temperature"].mean(axis=1)
    assert middle.min() < 293.15 - 15.0
    assert middle[-1] > middle.min() + 10.0
    assert abs(array["ledger/heat_defect"][-1]) < 1e-9 * array["ledger/heat_light.outer_top"][-1]
