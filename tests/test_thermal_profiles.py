"""Profiles over sections and faces of members: closed forms, areas, normals, polygons."""

from dataclasses import replace
from functools import partial
from math import exp, pi

import numpy as np
import pytest
from heat_cases import RADIUS, THICKNESS, member, plain, still, varying
from scipy.integrate import dblquad, quad

from meshes.materials import constant
from meshes.sections import circle, general, rectangle, tube
from thermal.boundary import Moment
from thermal.description import (
    Description,
    Film,
    Fixed,
    Flux,
    Irradiation,
    Place,
    Radiation,
    Settings,
    Side,
    Wall,
)
from thermal.discretisation import at_points, facing_loads, merged
from thermal.line import facing
from thermal.profiles import (
    GRADIENTS,
    absorbing_widths,
    inner_contour,
    outer_contour,
    profile,
    scales,
    values_at,
    wall_offsets,
)
from thermal.solvers import build

SQUARE, PLATE, ROD = rectangle(0.02, 0.02), rectangle(0.03, 0.01), circle(0.015)
TUBE = tube(RADIUS, THICKNESS)
SOLVERS = [partial(build, "line"), partial(build, "hermite")]


def settled(solver, outside=None):
    T, _, why = solver.steady(solver.initial(), 0.0, outside)
    assert why == ""
    return T


def gradients(m, T):
    """(stations, 3) mean and gradients of three values."""
    offsets = wall_offsets(m.section, GRADIENTS)
    plane = np.column_stack([np.ones(3), offsets])
    return np.linalg.solve(plane, T.reshape(-1, 3).T).T


# ---------------------------------------------------------------------------- shape functions


@pytest.mark.parametrize("section", [PLATE, ROD])
def test_three_values_are_a_plane(section):
    """Values at any point of the section, and slopes, of T = a + b y + c z."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.01, 0.01, (20, 2))
    a, b = 300.0, np.array([70.0, -40.0])
    T = a + wall_offsets(section, 3) @ b
    np.testing.assert_allclose(values_at(section, 3, points) @ T, a + points @ b, rtol=1e-13)
    for slope, scale, expected in zip(profile(3).slopes, scales(section, 3), b, strict=True):
        np.testing.assert_allclose(slope @ T / scale, expected, rtol=1e-12)


@pytest.mark.parametrize("section", [PLATE, ROD])
def test_three_functions_are_orthogonal_over_the_section(section):
    """Integrals of C_j C_k over the section by adaptive quadrature: A/3 on the diagonal."""
    half = 0.5 * section.width

    def bound(z):
        round_ = section.kind == "circle"
        return np.sqrt(max(0.0, half**2 - z**2)) if round_ else 0.5 * section.height

    for j in range(3):
        for k in range(j + 1):

            def product(y, z, j=j, k=k):
                values = values_at(section, 3, np.array([[y, z]]))[0]
                return values[j] * values[k]

            found = dblquad(product, -half, half, lambda z: -bound(z), bound, epsabs=1e-12)[0]
            assert found == pytest.approx(section.area / 3 * (j == k), abs=1e-10)


def test_first_value_of_three_sits_on_e2_within_the_section():
    for section in (PLATE, ROD):
        offsets = wall_offsets(section, 3)
        assert offsets[0, 0] > 0.0 and offsets[0, 1] == 0.0
        assert (np.abs(offsets) < 0.5 * np.array([section.height, section.width])).all()
        np.testing.assert_allclose(offsets.sum(axis=0), 0.0, atol=1e-15)


@pytest.mark.parametrize("section", [TUBE, PLATE, ROD, general(1e-4, 1e-9, 2e-9, 1e-9)])
@pytest.mark.parametrize("fine", [False, True])
def test_contours_have_the_perimeter_and_outward_strips(section, fine):
    c = outer_contour(section, 1, fine)
    assert c.lengths.sum() == pytest.approx(section.outer_perimeter, rel=1e-13)
    np.testing.assert_allclose(c.lengths @ c.normals, 0.0, atol=1e-15)
    np.testing.assert_allclose(c.last, np.roll(c.first, -1, axis=0), atol=1e-15)
    turning = c.first[:, 0] * c.last[:, 1] - c.first[:, 1] * c.last[:, 0]
    assert (turning > 0).all()  # from e2 towards e3
    assert (np.einsum("pk,pk->p", c.offsets, c.normals) > 0).all()


def test_the_bore_has_its_own_radius_and_faces_inwards():
    c = inner_contour(TUBE, 8)
    assert c.lengths.sum() == pytest.approx(2 * pi * (RADIUS - THICKNESS / 2), rel=1e-14)
    np.testing.assert_allclose(np.linalg.norm(c.offsets, axis=1), RADIUS - THICKNESS / 2)
    assert (np.einsum("pk,pk->p", c.offsets, c.normals) < 0).all()


@pytest.mark.parametrize("section", [PLATE, ROD])
@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0, -1.3])
def test_rays_give_three_values_their_integrals(section, angle):
    """Loads against quadrature of C_k max(0, cos) over the lit outline."""
    sun = np.array([np.cos(angle), np.sin(angle)])
    widths = absorbing_widths(section, 3, sun)
    expected = np.zeros(3)
    if section.kind == "circle":
        R = section.radius

        def lit(phi, k):
            n = np.array([np.cos(phi), np.sin(phi)])
            return R * values_at(section, 3, R * n[None])[0, k] * max(0.0, n @ sun)

        ends = angle - pi / 2, angle + pi / 2
        expected = [quad(lit, *ends, args=(k,))[0] for k in range(3)]
    else:
        c = outer_contour(section, 3, fine=True)
        weights = c.lengths * np.maximum(0.0, c.normals @ sun)
        expected = weights @ values_at(section, 3, c.offsets)
    np.testing.assert_allclose(widths, expected, rtol=1e-9, atol=1e-12)


# -------------------------------------------------------------------- three values, closed forms


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize(("section", "size"), [(PLATE, 12 / 0.03**2), (ROD, 4 / 0.015**2)])
def test_a_gradient_decays_by_conduction_across(make, section, size):
    """rho c I2 dG/dt = - k A G: rate k A / (rho c I2)."""
    bar = member(elements=3, wall_points=3, section=section)
    solver = make(Description((bar,)), Settings(1e-7))
    t = 2700.0 * 896.0 / (167.0 * size)
    T = solver.initial()
    y = np.tile(wall_offsets(section, 3)[:, 0], 4)
    T[: len(y)] += 1000.0 * y
    T = np.resize(T[: len(y)], len(T))  # no slope along
    end, _, why = solver.advance(T, 0.0, t, np.zeros_like(T))
    assert why == ""
    np.testing.assert_allclose(end[:12], 300.0 + 1000.0 * exp(-1.0) * y, atol=1e-5)


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize("section", [PLATE, ROD])
def test_heat_through_a_section_gives_its_gradient(make, section):
    """Flux q n.d in on one side and out on the other: G = q d / k, exact in three dimensions."""
    bar = member(elements=2, wall_points=3, section=section)
    hold = Film("hold", "arm", still(1e-3), still(300.0))
    light = Irradiation("light", "arm")
    solver = make(Description((bar,), conditions=(light, hold)))
    d = np.array([0.0, 0.6, -0.8])
    density = [1e4 * (block.normals @ d).ravel() for block in solver.irradiated["light"]]
    T = settled(solver, {"light": np.concatenate(density)})
    G = gradients(bar, T[:9])
    np.testing.assert_allclose(G[:, 1:], 1e4 * np.tile(d[1:], (3, 1)) / 167.0, rtol=1e-5)


@pytest.mark.parametrize("make", SOLVERS)
def test_directions_conduct_by_their_own_conductivities(make):
    """Along, across e2 (around), across e3 (through) of a plate; along and around of a tube."""
    around, through = constant("around", "W/(m K)", 30.0), constant("through", "W/(m K)", 7.0)
    mixed = replace(plain(), conductivity_around=around, conductivity_through=through)
    bar = member(elements=2, wall_points=3, section=PLATE, material=mixed)
    light = Irradiation("light", "arm")
    hold = Film("hold", "arm", still(1e-4), still(300.0))
    solver = make(Description((bar,), conditions=(light, hold)))
    d = np.array([0.0, 0.6, -0.8])
    density = [1e3 * (block.normals @ d).ravel() for block in solver.irradiated["light"]]
    G = gradients(bar, settled(solver, {"light": np.concatenate(density)})[:9])
    np.testing.assert_allclose(G[:, 1:], np.tile([600.0 / 30.0, -800.0 / 7.0], (3, 1)), rtol=1e-4)
    ring = member(elements=2, wall_points=8, material=mixed)
    conditions = (Fixed("a", Place("arm", "start"), still(400.0)),
                  Fixed("b", Place("arm", "end"), still(300.0)))  # fmt: skip
    solver = make(Description((ring,), conditions=conditions))
    T = settled(solver)
    power, _ = solver.power(T, Moment(0.0, {}))
    assert -power[:8].sum() == pytest.approx(167.0 * ring.section.area * 100.0, rel=1e-9)
    free = make(Description((ring,)), Settings(1e-7))
    T = free.initial()
    T[:24] += 10.0 * np.tile(np.cos(2 * pi / 8 * np.arange(8)), 3)
    T = np.resize(T[:24], len(T))
    end, _, _ = free.advance(T, 0.0, RADIUS**2 * 2700.0 * 896.0 / 30.0, np.zeros_like(T))
    assert end[0] - 300.0 == pytest.approx(10.0 * exp(-1), abs=1e-5)


@pytest.mark.parametrize("section", [PLATE, ROD])
@pytest.mark.parametrize("make", SOLVERS)
def test_walls_prescribe_the_sides_of_solid_sections(make, section):
    """Hot and cold where the section ends towards the side."""
    side = np.array([0.0, 0.6, 0.8])
    wall = Wall("sun", "arm", 0.0, 1.0, side, (still(350.0),) * 2, (still(310.0),) * 2)
    bar = member(elements=2, wall_points=3, section=section)
    T = make(Description((bar,), conditions=(wall,))).given_at(0.0)[1][:9]
    outline = section.outline(400)
    at = values_at(section, 3, outline) @ T[:3]
    assert at.max() == pytest.approx(350.0, abs=5e-3)
    assert at.min() == pytest.approx(310.0, abs=5e-3)
    reach = outline @ side[1:]
    np.testing.assert_allclose(at, 330.0 + 20.0 * reach / reach.max(), atol=5e-3)


def test_radiation_of_a_bent_profile_is_that_of_its_outline():
    """sigma eps T^4 round a rectangle and a circle against adaptive quadrature."""
    for section in (PLATE, ROD):
        bar = member(elements=1, wall_points=3, section=section)
        solver = build(
            "line", Description((bar,), conditions=(Radiation("r", "arm", 0.7, still(0)),))
        )
        T = np.tile([420.0, 310.0, 350.0], 2)
        fine = outer_contour(replace(section), 360, fine=True)
        at = values_at(section, 3, fine.offsets) @ T[:3]
        expected = -0.7 * 5.670374419e-8 * fine.lengths @ at**4
        _, (flow,) = solver.power(T, Moment(0.0, {}))
        assert flow == pytest.approx(expected, rel=2e-6)


def test_the_range_is_watched_at_the_corners():
    """A plane within the range at its three points, not at the corner of the section."""
    hot, cold = (still(325.0),) * 2, (still(275.0),) * 2
    wall = Wall("sun", "arm", 0.0, 1.0, np.array([0.0, 1.0, 1.0]), hot, cold)
    bar = member(wall_points=3, section=SQUARE, material=varying(200.0, 324.0))
    for make in SOLVERS:
        solver = make(Description((bar,), conditions=(wall,)))
        T = solver.initial()
        assert solver.given_at(0.0)[1].max() < 324.0
        assert "left the range of" in solver.advance(T, 0.0, 1.0, np.zeros_like(T))[2]


# --------------------------------------------------------------------------------------- faces


def bent(wall_points, section):
    """A quarter of a circle in space, with frames that turn along."""
    s = np.linspace(0.0, 1.0, 9) ** 1.2
    angle = 0.5 * pi * s
    points = 2.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle])
    e1 = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    n = np.column_stack([-np.sin(angle), np.cos(angle), 0.0 * angle])
    up = np.broadcast_to([0.0, 0.0, 1.0], n.shape)
    twist = 0.7 * s[:, None]
    e2 = np.cos(twist) * n + np.sin(twist) * up
    axes = np.stack([e1, e2, np.cross(e1, e2)], axis=1)
    return replace(member(wall_points=wall_points, section=section), points=points, axes=axes)


CASES = [(1, TUBE), (8, TUBE), (1, PLATE), (3, PLATE), (3, ROD), (1, ROD)]


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize(("n", "section"), CASES)
def test_faces_have_their_areas_normals_and_polygons(make, n, section):
    arm = bent(n, section)
    solver = make(Description((arm,)))
    length = np.linalg.norm(np.diff(arm.points, axis=0), axis=1).sum()
    bore = 2 * pi * (section.radius - section.thickness / 2) if section.kind == "tube" else None
    expected = {"outer": section.outer_perimeter * length, "start": section.area,
                "end": section.area} | ({"inner": bore * length} if bore else {})  # fmt: skip
    for face, area in expected.items():
        for blocks in (solver.space.face(Side("arm", face)),
                       solver.space.irradiated(Side("arm", face))):  # fmt: skip
            assert sum(b.areas.sum() for b in blocks) == pytest.approx(area, rel=1e-12)
            drawn = sum(polygon_area(b.polygons).sum() for b in blocks)
            assert drawn == pytest.approx(area, rel=0.11)
            for b in blocks:
                assert b.areas.shape == (len(b.dofs), len(b.values))
                np.testing.assert_allclose(np.linalg.norm(b.normals, axis=-1), 1.0, rtol=1e-12)
                np.testing.assert_allclose(b.values.sum(axis=1), 1.0, rtol=1e-12)
                turned = polygon_normal(b.polygons)
                assert (np.einsum("gc,gc->g", turned, b.normals.mean(axis=1)) > 0.98).all()


def polygon_vector(p):
    q = p - p[:, :1]
    return 0.5 * np.cross(q[:, 1:-1], q[:, 2:]).sum(axis=1)


def polygon_area(p):
    return np.linalg.norm(polygon_vector(p), axis=1)


def polygon_normal(p):
    v = polygon_vector(p)
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize(("n", "section"), [(8, TUBE), (3, PLATE), (3, ROD)])
def test_polygons_close_the_surface(make, n, section):
    """Area vectors of all faces of a straight bar sum to nothing; their flux is the volume."""
    arm = member(wall_points=n, section=section, elements=4)
    space = make(Description((arm,))).space
    faces = ["outer", "start", "end"] + (["inner"] if section.kind == "tube" else [])
    total, volume = np.zeros(3), 0.0
    for face in faces:
        for b in space.irradiated(Side("arm", face)):
            total += polygon_vector(b.polygons).sum(axis=0)
            volume += np.einsum("gc,gc->", polygon_vector(b.polygons), b.polygons.mean(axis=1)) / 3
    np.testing.assert_allclose(total, 0.0, atol=1e-12)
    assert volume == pytest.approx(section.area, rel=0.03)


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize(("n", "section"), [(4, TUBE), (8, TUBE), (3, ROD), (3, PLATE), (1, TUBE)])
@pytest.mark.parametrize("angle", [0.1, 1.0, 4.0])
def test_points_of_irradiation_absorb_rays_as_the_exact_loads(make, n, section, angle):
    arm = member(wall_points=n, section=section, elements=3)
    space = make(Description((arm,))).space
    rays = np.array([0.3, np.cos(angle), np.sin(angle)])
    exact = space.absorbing(Side("arm"), rays)
    points = facing_loads(space.irradiated(Side("arm")), rays, len(space.x))
    assert abs(points - exact).max() < 4e-3 * abs(exact).max()
    assert points.sum() == pytest.approx(exact.sum(), rel=4e-3)


@pytest.mark.parametrize("make", SOLVERS)
def test_every_face_takes_and_gives_heat(make):
    """q A of uniform flux on each face; a film draws all of a warm bar to its temperature."""
    arm = bent(8, TUBE)
    names = ("outer", "inner", "start", "end")
    fluxes = [Flux(f"to {face}", "arm", still(10.0), None, face) for face in names]
    films = [Film(f"by {face}", "arm", still(20.0), still(350.0), face) for face in names]
    solver = make(Description((arm,), conditions=(*fluxes, *films)))
    T = solver.initial()
    _, flows = solver.power(T, Moment(0.0, {}))
    faces = [solver.space.face(Side("arm", face)) for face in names]
    areas = np.array([sum(b.areas.sum() for b in face) for face in faces])
    np.testing.assert_allclose(flows[:4], 10.0 * areas, rtol=1e-12)
    np.testing.assert_allclose(flows[4:], 20.0 * 50.0 * areas, rtol=1e-12)
    np.testing.assert_allclose(settled(solver)[:72], 350.5, rtol=1e-12)


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize(("n", "section"), CASES)
def test_the_mean_of_a_member_is_by_volume(make, n, section):
    """Of T linear along and across a member with uneven stations."""
    arm = replace(member(wall_points=n, section=section), points=np.outer(
        np.linspace(0.0, 1.0, 9) ** 1.5, [1.0, 0.0, 0.0]))  # fmt: skip
    space = make(Description((arm,))).space
    mean = space.place(Place("arm"))
    assert mean.weights.sum() == pytest.approx(1.0, rel=1e-13)
    T = 300.0 + 100.0 * space.x[:, 0] + 200.0 * space.x[:, 1]
    steps = np.diff(arm.points[:, 0]).mean()
    T[9 * n :] += 100.0 * steps / 3.0  # the slope along
    assert mean.weights @ T[mean.nodes] == pytest.approx(350.0, rel=1e-12)


def test_merged_faces_hold_the_same_areas_and_temperatures():
    space = build("line", Description((bent(8, TUBE),))).space
    face = space.face(Side("arm"))
    (one,) = merged(face)
    T = 300.0 + np.random.default_rng(1).standard_normal(len(space.x))
    total = sum((b.areas * at_points(b, T) ** 4).sum() for b in face)
    assert (one.areas * at_points(one, T) ** 4).sum() == pytest.approx(total, rel=1e-13)
    (bare,) = merged(build("line", Description((bent(1, TUBE),))).space.face(Side("arm")))
    assert bare.areas.shape == (9, 1)


def test_rays_are_turned_into_the_section():
    arm = bent(1, TUBE)
    rays = np.array([0.2, 1.0, -0.4])
    expected = -arm.axes[:, 1:] @ rays / np.linalg.norm(rays)
    np.testing.assert_allclose(facing(arm, rays), expected, rtol=1e-14)
