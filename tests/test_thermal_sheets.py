"""Heat in shells: orders, closed forms on plates, annuli and spheres, through the thickness."""

from dataclasses import replace
from math import atanh, log, pi, sin

import numpy as np
import pytest
from heat_cases import member, plain, ramp, still, varying

from meshes.materials import constant
from meshes.sections import tube as tube_section
from meshes.surfaces import Surface, annulus, patch, plate, sphere, tube
from thermal.boundary import STEFAN_BOLTZMANN
from thermal.description import (
    Description,
    Faces,
    Field,
    Film,
    Fixed,
    Flux,
    Irradiation,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
    Sheet,
    Side,
    Source,
)
from thermal.solvers import build
from thermal.wall import WallSpace

SIGMA = STEFAN_BOLTZMANN


def orders(errors):
    return np.log2(np.divide(errors[:-1], errors[1:]))


def sheet(surface, thickness=0.004, material=None, initial=300.0, name="panel"):
    return Sheet(name, surface, thickness, material or plain(), initial)


def heat(surface, conditions=(), order=1, **more):
    """Solver of one sheet, and of settings by name."""
    own = {key: more.pop(key) for key in ("thickness", "material", "initial") if key in more}
    d = Description((), conditions=conditions, sheets=[sheet(surface, **own)])
    return build("wall", d, Settings(order=order, **more))


def steady(solver, outside=None):
    T, flows, why = solver.steady(solver.initial(), 0.0, outside)
    assert why == ""
    return T, flows


def held(solver, T, among):
    """T at given temperatures ``among`` (a mask), conducted to all others; constant properties."""
    rows, columns = solver.space.entries()
    K = np.zeros((len(T), len(T)))
    zero = solver.space.tangent(T, 0.0)  # what is stored
    np.add.at(K, (rows, columns), solver.space.tangent(T, 1.0) - zero)
    T, inside = T.copy(), ~among
    T[inside] = np.linalg.solve(K[np.ix_(inside, inside)], -K[np.ix_(inside, among)] @ T[among])
    return T


def skewed(shear, n):
    """A unit parallelogram; u along x, v sheared."""

    def shape(u, v):
        o = np.zeros_like(u)
        x, y = np.stack([o + 1.0, o, o], 1), np.stack([o + shear, o + 1.0, o], 1)
        return np.stack([u + shear * v, v, o], 1), x, y, np.zeros((len(u), 3))

    lines = np.linspace(0.0, 1.0, n + 1) ** 1.2
    return patch(shape, lines, lines)


# ------------------------------------------------------------------------- manufactured field


def fields(x, y, t):
    """Temperatures of both faces of a unit plate, insulated at its edges."""
    wave = np.cos(pi * x) * np.cos(pi * y)
    return 330.0 + (10.0 + 0.5 * t) * wave, 310.0 + 8.0 * np.cos(pi * x) - 0.3 * t * wave


def densities(material, thickness, x, y, t, sink):
    """Flux densities on both faces that make ``fields`` the temperatures."""
    cx, cy, sx, sy = np.cos(pi * x), np.cos(pi * y), np.sin(pi * x), np.sin(pi * y)
    a = 10.0 + 0.5 * t
    rates = 0.5 * cx * cy, -0.3 * cx * cy
    by_x = -pi * a * sx * cy, -pi * (8.0 * sx - 0.3 * t * sx * cy)
    by_y = -pi * a * cx * sy, 0.3 * t * pi * cx * sy
    flat = -2.0 * pi**2 * a * cx * cy, -(pi**2) * 8.0 * cx + 2.0 * pi**2 * 0.3 * t * cx * cy
    T = fields(x, y, t)
    k = material.conductivity
    through = k.integral(T[1], T[0]) / thickness
    found = []
    for i, sign in ((0, 1.0), (1, -1.0)):
        stored = material.density * material.heat_capacity(T[i]) * rates[i]
        conducted = k(T[i]) * flat[i] + k.derivative(T[i]) * (by_x[i] ** 2 + by_y[i] ** 2)
        radiated = 0.7 * SIGMA * (T[i] ** 4 - sink**4)
        found.append(0.5 * thickness * (stored - conducted) + sign * through + radiated)
    return found


def error_of_manufactured(order, n):
    material, thickness = varying(), 0.2
    faces = ("top", "bottom")
    conditions = [Irradiation(face, "panel", face) for face in faces]
    conditions += [Radiation(f"space {f}", "panel", 0.7, still(250.0), f) for f in faces]
    fractions = (np.arange(n + 1) / n) ** 1.1
    solver = heat(plate(1.0, 1.0, fractions, fractions), conditions, order, material=material,
                  thickness=thickness, steps=1)  # fmt: skip
    x, y, z = solver.x.T

    def exact(t):
        above, below = fields(x, y, t)
        return np.where(z > 0.0, above, below)

    T = exact(0.0)
    for t in range(4):
        outside = {}
        for i, face in enumerate(faces):
            (block,) = solver.irradiated[face]
            x0, y0, _ = block.points.reshape(-1, 3).T
            outside[face] = tuple(
                densities(material, thickness, x0, y0, now, 250.0)[i] for now in (t, t + 1.0)
            )
        T, _, why = solver.advance(T, float(t), 1.0, np.zeros_like(T), outside)
        assert why == ""
    return np.abs(T - exact(4.0)).max()


@pytest.mark.parametrize("order", [1, 2])
def test_manufactured_solution_shows_the_order_in_space(order):
    """k(T), c(T), radiation on both faces, uneven elements."""
    found = orders([error_of_manufactured(order, n) for n in (4, 8, 16)])
    assert found[-1] > order + 0.85, found


# ------------------------------------------------------------------------------ closed forms


@pytest.mark.parametrize("order", [1, 2])
def test_heat_through_the_thickness(order):
    """T_top - T_bottom = q t / k; with k(T) the integral of k is q t."""
    q, t = 1e5, 0.01
    through = constant("k", "W/(m K)", 20.0)
    for material in (plain(), replace(plain(), conductivity_through=through), varying()):
        conditions = [Flux("lamp", "panel", still(q), face="top"),
                      Fixed("plate", Place("panel", "bottom"), still(300.0))]  # fmt: skip
        solver = heat(plate(1.0, 0.5, 3, 2), conditions, order, material=material, thickness=t)
        T, flows = steady(solver)
        k = material.conductivities[2]
        top, bottom = (solver.space.place(Place("panel", face)) for face in ("top", "bottom"))
        np.testing.assert_allclose(T[bottom.nodes], 300.0, rtol=1e-14)
        np.testing.assert_allclose(k.integral(300.0, T[top.nodes]), q * t, rtol=1e-9)
        assert flows["lamp"] == pytest.approx(q * 0.5)


def test_a_plate_that_cools_by_radiation():
    """1/T^3 rises evenly; 1 mm of aluminium, one side, whose drop across the plate is 14 mK."""
    space = Radiation("space", "panel", 0.8, still(0.0), "top")
    solver = heat(plate(1.0, 0.5, 2, 2), [space], thickness=1e-3, initial=473.15)
    T, t = solver.initial(), 0.0
    for end, exact in ((60.0, 427.317046), (600.0, 285.011578), (3600.0, 167.720477)):
        T, _, why = solver.advance(T, t, end - t, np.zeros_like(T))
        assert why == ""
        np.testing.assert_allclose(T, exact, atol=0.03)
        t = end


@pytest.mark.parametrize(("order", "least"), [(1, 1.9), (2, 2.9)])
def test_steady_flow_in_an_annulus(order, least):
    """T = a + b ln r."""
    errors = []
    for n in (4, 8, 16):
        solver = heat(annulus(0.5, 1.5, n, n, (0.0, 1.0)), order=order)
        r = np.hypot(solver.x[:, 0], solver.x[:, 1])
        exact = 300.0 + 50.0 * np.log(r / 0.5) / log(3.0)
        rim = np.isclose(r, 0.5, atol=1e-3) | np.isclose(r, 1.5, atol=1e-3)
        errors.append(np.abs(held(solver, exact, rim) - exact).max())
    assert (orders(errors) > least).all(), orders(errors)


@pytest.mark.parametrize(("order", "least"), [(1, 1.9), (2, 2.9)])
def test_steady_flow_on_a_sphere(order, least):
    """T = a + b artanh(sin latitude) between two parallels."""
    errors = []
    for n in (4, 8, 16):
        solver = heat(sphere(1.0, n // 2, n, (-0.3, 1.1), (0.0, 0.5)), order=order)
        sines = solver.x[:, 2] / np.linalg.norm(solver.x, axis=1)
        exact = 300.0 + 50.0 * np.arctanh(sines) / atanh(sin(1.1))
        rim = np.isclose(sines, sin(-0.3), atol=2e-5) | np.isclose(sines, sin(1.1), atol=2e-5)
        errors.append(np.abs(held(solver, exact, rim) - exact).max())
    assert orders(errors)[-1] > least, orders(errors)


@pytest.mark.parametrize("order", [1, 2])
def test_an_anisotropic_plate_conducts_along_u_and_across(order):
    """x^2 / k_u - y^2 / k_v is steady, and reproduced whatever the ratio of k."""
    material = replace(plain(100.0), conductivity_around=constant("k", "W/(m K)", 1e-4))
    solver = heat(plate(1.0, 1e-3, 6, 4), order=order, material=material)
    x, y = solver.x[:, 0], solver.x[:, 1]
    exact = 300.0 + x**2 - y**2 * 1e6
    rim = (np.minimum(x, 1.0 - x) < 1e-9) | (np.minimum(y, 1e-3 - y) < 1e-12)
    np.testing.assert_allclose(held(solver, exact, rim), exact, rtol=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_a_linear_field_on_skewed_elements_is_steady(order):
    """Orthotropic about u, uneven elements that are no rectangles."""
    material = replace(plain(100.0), conductivity_around=constant("k", "W/(m K)", 30.0))
    solver = heat(skewed(0.6, 5), order=order, material=material)
    x, y = solver.x[:, 0], solver.x[:, 1]
    exact = 300.0 + 20.0 * x - 7.0 * y
    u = x - 0.6 * y
    rim = (np.minimum(u, 1.0 - u) < 1e-9) | (np.minimum(y, 1.0 - y) < 1e-9)
    np.testing.assert_allclose(held(solver, exact, rim), exact, rtol=1e-9)


def test_a_shell_like_a_tube_conducts_like_its_wall():
    """The same tube as a sheet and as a member, lit from one side, radiating outward."""
    radius, t, n = 0.05, 1e-4, 16
    direction = np.array([0.0, -1.0, 0.0])
    arm = member(elements=4, wall_points=n, section=tube_section(radius, t), along=(0, 0, 1))
    conditions = [Flux("sun", "arm", still(1361.0), direction),
                  Radiation("space", "arm", 0.8, still(4.0))]  # fmt: skip
    line = build("wall", Description([arm], conditions=conditions), Settings(steps=20))
    shell = heat(tube(radius, 1.0, n, 4),
                 [Flux("sun", "panel", still(1361.0), direction, "top"),
                  Radiation("space", "panel", 0.8, still(4.0), "top")],
                 thickness=t, steps=20)  # fmt: skip
    ends = [s.advance(s.initial(), 0.0, 60.0, np.zeros(len(s.x)))[0] for s in (line, shell)]
    np.testing.assert_allclose(
        ends[0][in_order(line.x)],
        ends[1][::2][in_order(shell.x[::2])],
        atol=0.01 * np.ptp(ends[0]),
    )


def in_order(x):
    """Points on a tube about z, by height and angle."""
    return np.lexsort((np.round(np.arctan2(x[:, 1], x[:, 0]), 6), np.round(x[:, 2], 6)))


# ------------------------------------------------------------------------------------- faces


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("face", ["top", "bottom"])
def test_faces_have_their_areas_normals_and_facets(order, face):
    surfaces: list[tuple[Surface, float]] = [
        (plate(1.0, 0.5, 3, 2), 0.5),
        (tube(0.3, 2.0, 16, 3), 2 * pi * 0.3 * 2.0),
        (annulus(0.5, 1.0, 2, 24), pi * 0.75),
        (sphere(1.0, 24, 12, (-0.5, 1.2)), 2 * pi * (sin(0.5) + sin(1.2))),
    ]
    sign = 1.0 if face == "top" else -1.0
    for surface, exact in surfaces:
        space = WallSpace(Description((), sheets=[sheet(surface)]), Settings(order=order))
        for (block,) in (space.face(Side("panel", face)), space.irradiated(Side("panel", face))):
            assert block.areas.sum() == pytest.approx(exact, rel=3e-3)
            polygons = block.polygons
            turning = np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1])
            facing = np.einsum("gx,gx->g", turning, block.normals.mean(axis=1))
            assert (facing > 0.0).all()
            assert 0.5 * facing.sum() == pytest.approx(exact, rel=0.03)
            np.testing.assert_allclose(np.linalg.norm(block.normals, axis=2), 1.0, rtol=1e-12)
        (block,) = space.face(Side("panel", face))
        np.testing.assert_allclose(block.points[:, 0], space.x[block.dofs[:, 0]], atol=1e-9)
        pairs = space.x[: 2 * len(surface.points)].reshape(-1, 2, 3)
        np.testing.assert_allclose(pairs.mean(axis=1), surface.points, atol=1e-12)
        outward = pairs[:, 0] - pairs[:, 1]
        first = np.flatnonzero(block.dofs[:, 0] < len(pairs) * 2)
        pair = block.dofs[first, 0] // 2
        cosine = np.einsum("nx,nx->n", block.normals[first, 0], outward[pair])
        assert (sign * cosine > 0.0).all()


@pytest.mark.parametrize("order", [1, 2])
def test_the_sun_shines_on_the_side_it_is_on(order):
    direction = np.array([0.0, 0.6, -0.8])
    conditions = [Flux("over", "panel", still(1000.0), direction, "top"),
                  Flux("under", "panel", still(1000.0), direction, "bottom"),
                  Fixed("plate", Place("panel"), still(300.0))]  # fmt: skip
    solver = heat(plate(1.0, 0.5, 3, 2), conditions, order, steps=1)
    _, flows, _ = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert flows["over"] == pytest.approx(400.0)
    assert flows["under"] == 0.0
    assert flows["plate"] == pytest.approx(-400.0)


# ------------------------------------------------------------------------- shocks and balance


@pytest.mark.parametrize("order", [1, 2])
def test_what_flows_in_is_stored(order):
    panel = sheet(sphere(0.5, 6, 4, (-0.5, 1.2)), material=varying())
    floor = sheet(skewed(0.3, 3), name="floor")
    hub = Part("hub", np.zeros(3), plain(16.0, 500.0, 8000.0), 0.7, 290.0)
    links = (Link("bolt", Place("hub"), Place("panel", "bottom"), 3.0),
             Link("mount", Place("hub"), still(280.0), 0.8))  # fmt: skip
    conditions = (
        Flux("sun", "panel", ramp(0.0, 900.0, 3.0), np.array([0.2, -1.0, 0.5]), "top"),
        Radiation("space", "panel", 0.8, still(4.0), "top"),
        Film("air", "panel", still(5.0), still(270.0), "bottom"),
        Source("heater", Place("panel"), still(12.0)),
        Source("patch", Place("panel", "top"), still(2.0)),
        Faces("oven", "floor", ramp(300.0, 350.0, 5.0), still(300.0)),
    )
    d = Description((), (hub,), links, conditions, (panel, floor))
    solver = build("wall", d, Settings(order=order))
    T, total, largest = solver.initial(), 0.0, 0.0
    start = solver.energy(T)
    for i in range(4):
        T, flows, why = solver.advance(T, 2.0 * i, 2.0, np.zeros_like(T))
        assert why == ""
        total += sum(flows.values())
        largest = max(largest, *(abs(f) for f in flows.values()))
    assert solver.energy(T) - start == pytest.approx(total, abs=1e-11 * largest)
    floor_T = T[solver.regions["floor"]]
    np.testing.assert_allclose(floor_T.reshape(-1, 2), [[350.0, 300.0]] * 16)


@pytest.mark.parametrize("thickness", [1e-6, 1e-3, 1.0])
def test_a_shock_never_cools_a_point_below_the_coldest_boundary(thickness):
    """Backward Euler on elements of great and small ratio of sides, on a closed shell."""
    cold = [Fixed("cryogen", Place("panel", "top"), still(210.0)),
            Radiation("space", "panel", 0.9, still(250.0), "bottom")]  # fmt: skip
    solver = heat(tube(0.05, 2.0, 24, 3), cold, material=varying(), thickness=thickness,
                  scheme="backward-euler", steps=3)  # fmt: skip
    T = solver.initial()
    T[solver.regions["panel"][7]] = 380.0
    for h in (1e-6, 1e-3, 1.0, 1e3, 1e6):
        T, _, why = solver.advance(T, 0.0, h, np.zeros_like(T))
        assert why == ""
        assert 210.0 - 1e-9 <= T.min() <= T.max() <= 380.0 + 1e-9


@pytest.mark.parametrize("order", [1, 2])
def test_a_field_holds_every_node(order):
    field = Field("file", "panel", lambda x, t: 300.0 + t * x[:, 0] + 1e3 * x[:, 2])
    solver = heat(plate(1.0, 0.5, 3, 2), [field], order, thickness=0.02)
    T, _, why = solver.advance(solver.initial(), 0.0, 2.0, np.zeros(len(solver.x)))
    assert why == ""
    np.testing.assert_allclose(T, 300.0 + 2.0 * solver.x[:, 0] + 1e3 * solver.x[:, 2])


# ---------------------------------------------------------------------------------- bad input


def test_order_two_on_a_turn_of_two_elements_is_refused():
    for order, n in ((1, 2), (2, 3)):
        heat(tube(1.0, 1.0, n, 2), order=order)
    with pytest.raises(ValueError, match="three or more elements"):
        heat(tube(1.0, 1.0, 2, 2), order=2)


def test_leaving_the_range_of_a_property_is_a_reason():
    heater = [Source("heater", Place("panel"), still(1e5))]
    solver = heat(plate(1.0, 0.5, 3, 2), heater, material=varying(250.0, 350.0))
    _, _, why = solver.advance(solver.initial(), 0.0, 100.0, np.zeros(len(solver.x)))
    assert "'panel' left the range of" in why
