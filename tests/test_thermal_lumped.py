"""The heat network on its own, and against the finite elements."""

from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import exp, inf, pi, sqrt

import numpy as np
import pytest
from heat_cases import RADIUS, THICKNESS, everything, member, plain, ramp, still, varying
from scipy.integrate import quad, solve_ivp
from scipy.special import erfc

from meshes import surfaces
from meshes.materials import constant, polynomial, table
from meshes.mesh import Mesh
from meshes.sections import circle, rectangle, tube
from thermal.boundary import Moment
from thermal.description import (
    Description,
    Enclosure,
    Field,
    Film,
    Fixed,
    Flux,
    Interface,
    Irradiation,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
    Sheet,
    Side,
    Solid,
    Source,
    Wall,
)
from thermal.lump_faces import absorbing_arcs
from thermal.lumped import LumpedHeat, NetworkSpace
from thermal.network import cell_lengths
from thermal.solvers import build


def run(solver, end, windows=1, T=None):
    """State at ``end``."""
    T = solver.initial() if T is None else T
    h = end / windows
    for i in range(windows):
        T, _, why = solver.advance(T, i * h, h, np.zeros_like(T))
        assert why == ""
    return T


def orders(errors):
    return np.log2(np.divide(errors[:-1], errors[1:]))


def balance_of(net, tau, t):
    """Stored heat minus tau times the power, at the free temperatures."""
    return lambda T: (net.space.heat(T) - tau * net.power(T, Moment(t, {}))[0])[net.free]


def assert_tangent_is_the_derivative(net, tau=37.0, t=2.5, step=1e-3):
    T = net.initial() + 20.0 * np.random.default_rng(2).standard_normal(len(net.x))
    balance, n = balance_of(net, tau, t), len(net.free)
    unit = np.eye(len(T))[net.free]
    columns = [(balance(T + step * u) - balance(T - step * u)) / (2 * step) for u in unit]
    expected = np.array(columns).T
    solve = net.factorise(T, Moment(t, {}), tau)
    np.testing.assert_allclose(
        np.column_stack([solve(c) for c in expected.T]), np.eye(n), atol=1e-7
    )


def test_tangent_is_the_derivative():
    assert_tangent_is_the_derivative(LumpedHeat(everything()))


@pytest.mark.parametrize("material", [plain(), varying()])
def test_heat_balance_closes_to_round_off(material):
    net = LumpedHeat(everything(material))
    T, rng = net.initial(), np.random.default_rng(4)
    for i in range(20):
        heat = rng.uniform(0.0, 5.0, len(T))
        new, flows, why = net.advance(T, 0.4 * i, 0.4, heat)
        assert why == ""
        stored = net.energy(new) - net.energy(T)
        largest = max(*map(abs, flows.values()), heat.sum())
        assert abs(sum(flows.values()) + heat.sum() - stored) < 1e-11 * largest
        T = new


def test_order_in_time_with_varying_properties_radiation_and_moving_boundary():
    """Against the same network integrated by Radau."""
    fin = member("fin", 0.1, 4, 1, rectangle(0.002, 0.02), varying(), 400.0)
    conditions = (
        Fixed("root", Place("fin", "start"), lambda t: 400.0 + 80.0 * np.sin(0.1 * t)),
        Radiation("space", "fin", 0.9, lambda t: 250.0 + 5.0 * t),
    )
    net = LumpedHeat(Description((fin,), conditions=conditions), Settings(tolerance=inf))
    mass = 2700.0 * fin.section.area * 0.025 * np.array([1, 1, 1, 0.5])

    def rate(t, free):
        T = np.concatenate([[400.0 + 80.0 * np.sin(0.1 * t)], free])
        c = 800 + 1.2 * (free - 300) + 2e-3 * (free - 300) ** 2
        return net.power(T, Moment(t, {}))[0][1:] / (mass * c)

    exact = solve_ivp(rate, (0, 20), np.full(4, 400.0), "Radau", rtol=1e-10, atol=1e-9).y[:, -1]
    errors = [np.abs(run(net, 20.0, n)[1:] - exact).max() for n in (40, 80, 160)]
    assert (orders(errors) > 1.9).all()


def test_order_in_space_after_a_step():
    """erfc in a bar too long for its end to matter."""
    diffusivity, errors = 167.0 / (2700.0 * 896.0), []
    for elements in (20, 40, 80):
        bar = member("bar", 0.1, elements)
        face = Fixed("face", Place("bar", "start"), still(400.0))
        net = LumpedHeat(Description((bar,), conditions=(face,)), Settings(1e-5))
        exact = 300 + 100 * erfc(net.x[:, 0] / (2 * sqrt(diffusivity * 3.0)))
        errors.append(np.abs(run(net, 3.0) - exact).max())
    assert (orders(errors) > 1.9).all()


def test_error_estimate_is_the_error_of_a_linear_decay():
    """Half the interval is taken as soon as the tolerance forbids the whole."""
    block = Part("block", np.zeros(3), plain(), 1.0, 400.0)
    air = Link("air", Place("block"), still(300.0), 8.96)  # rate 0.01 1/s
    d = Description((), (block,), (air,))
    whole = run(LumpedHeat(d, Settings(inf)), 10.0)[0]
    error = abs(whole - 300.0 - 100.0 * exp(-0.1))
    assert run(LumpedHeat(d, Settings(1.25 * error)), 10.0)[0] == whole
    assert (
        run(LumpedHeat(d, Settings(0.8 * error)), 10.0)[0]
        == run(LumpedHeat(d, Settings(inf)), 10.0, 2)[0]
    )


def test_huge_step_of_a_decay_leaves_nothing():
    block = Part("block", np.zeros(3), plain(), 1.0, 400.0)
    air = Link("air", Place("block"), still(300.0), 8.96e12)
    T = run(LumpedHeat(Description((), (block,), (air,)), Settings(inf)), 1.0)
    assert T[0] == pytest.approx(300.0, abs=1e-6)


@pytest.mark.parametrize("n", [4, 8, 12])
@pytest.mark.parametrize("direction", [(0, -1, 0), (1, -2, 0.7), (0, 0.2, 3)])
def test_each_cell_absorbs_what_its_arc_sees(n, direction):
    arm = member(wall_points=n)
    unit, outer = np.divide(direction, np.linalg.norm(direction)), RADIUS + THICKNESS / 2

    def lit(phi):
        return outer * max(0.0, -unit @ [0.0, np.cos(phi), np.sin(phi)])

    edges = 2 * pi * (np.arange(n + 1) - 0.5) / n
    exact = [quad(lit, a, b, limit=200)[0] for a, b in pairwise(edges)]
    loads = absorbing_arcs(arm, "outer", np.array(direction)).reshape(-1, n)
    widths = (loads / cell_lengths(arm)[:, None])[0]
    np.testing.assert_allclose(widths, exact, atol=1e-9)
    assert widths.sum() == pytest.approx(2 * outer * np.hypot(unit[1], unit[2]), rel=1e-13)


def test_solid_members_absorb_their_shadow():
    rays = np.array([1.0, -1.0, 2.0])
    y, z = rays[1:] / sqrt(6.0)
    bar = member("bar", section=rectangle(0.04, 0.01))
    rod = member("rod", section=circle(0.03))
    net = NetworkSpace(Description((bar, rod)))
    for name, width in (("bar", 0.01 * abs(y) + 0.04 * abs(z)), ("rod", 0.06 * np.hypot(y, z))):
        assert net.absorbing(Side(name), rays).sum() == pytest.approx(width, rel=1e-13)


def test_harmonics_of_the_circumference_converge_with_the_square_of_the_angle():
    """exp(-k m^2 t / (rho c R^2)) for m = 1 as the points become more."""
    t, errors = RADIUS**2 * 2700.0 * 896.0 / 167.0, []
    for n in (8, 16, 32):
        net = LumpedHeat(Description((member(wall_points=n, elements=1),)), Settings(1e-6))
        wave = np.tile(np.cos(2 * pi * np.arange(n) / n), 2)
        errors.append(abs(run(net, t, T=300.0 + 10.0 * wave)[0] - 300.0 - 10.0 * exp(-1)))
    assert (orders(errors) > 1.95).all()


def sunlit(n, elements=4):
    """A radiating tube in slanting light, its root held, a fitting at its tip."""
    arm = member("arm", 0.6, elements, n, material=varying())
    conditions = (
        Flux("sun", "arm", lambda t: 1361.0 * 0.3, np.array([0.3, -1.0, 0.4])),
        Radiation("space", "arm", 0.8, still(4.0)),
        Fixed("root", Place("arm", "start"), still(300.0)),
        Source("heater", Place("fitting"), still(3.0)),
    )
    fitting = Part("fitting", np.zeros(3), plain(16.0, 500.0, 8000.0), 0.1, 300.0)
    link = Link("glue", Place("fitting"), Place("arm", "end"), 0.7)
    return Description((arm,), (fitting,), (link,), conditions)


def test_network_and_finite_elements_meet_as_the_mesh_is_refined():
    """Mean and gradient of a sunlit radiating tube in transient and steady state."""
    for end in (200.0, 1e6):
        gaps = []
        for n, elements in ((4, 8), (8, 16), (16, 32)):
            a, b = (
                run(s(sunlit(n, elements)), end)[:-1] for s in (partial(build, "line"), LumpedHeat)
            )
            gaps.append(np.abs(a - b).max())
        assert (orders(gaps) > 1.6).all()
        assert gaps[-1] < 0.05


def test_network_and_finite_elements_agree_where_walls_are_given():
    """The main use: everything but the last stations is prescribed."""
    hot, cold = (lambda t: 300 + 4 * t, lambda t: 300 + t), (still(300.0), still(280.0))
    wall = Wall("sun", "arm", 0.2, 1.0, np.array([0, 1, 0]), hot, cold)
    d = Description((member(wall_points=4, material=varying()),), conditions=(wall,))
    a, b = run(build("line", d), 10.0, 10), run(LumpedHeat(d), 10.0, 10)
    assert np.abs(a - b).max() < 0.02


# ----------------------------------------------------------------------------- time integration


def test_equal_steps_are_of_order_two_and_those_of_a_named_scheme_of_its_order():
    block = Part("block", np.zeros(3), plain(), 1.0, 400.0)
    d = Description((), (block,), (Link("air", Place("block"), still(300.0), 8.96),))
    exact = 300.0 + 100.0 * exp(-1.0)
    for scheme, order in (("sdirk2", 2.0), ("crank-nicolson", 2.0), ("backward-euler", 1.0)):
        errors = []
        for n in (8, 16, 32):
            net = LumpedHeat(d, Settings(scheme=scheme, steps=n))
            errors.append(abs(run(net, 100.0)[0] - exact))
            assert net.taken == n
        assert orders(errors) == pytest.approx([order] * 2, abs=0.1)


def test_default_scheme_is_another_than_that_of_the_finite_elements():
    """One step of y' = -y by the stability functions of TR-BDF2 and of SDIRK2."""
    block = Part("block", np.zeros(3), plain(), 1.0, 400.0)
    d = Description((), (block,), (Link("air", Place("block"), still(300.0), 8.96),))
    once, g = Settings(steps=1), 2.0 - sqrt(2.0)
    middle = (1.0 - 0.5 * g) / (1.0 + 0.5 * g)
    end = (middle - (1.0 - g) ** 2) / (g * (2.0 - g)) / (1.0 + (1.0 - g) / (2.0 - g))
    assert run(LumpedHeat(d, once), 100.0)[0] == pytest.approx(300.0 + 100.0 * end, rel=1e-13)
    a = 1.0 - sqrt(0.5)
    sdirk = (1.0 - (1.0 - 2.0 * a)) / (1.0 + a) ** 2
    assert run(build("line", d, once), 100.0)[0] == pytest.approx(300.0 + 100.0 * sdirk, rel=1e-13)


def test_steady_state_is_where_a_long_transient_ends():
    net = LumpedHeat(sunlit(8))
    T, flows, why = net.steady(net.initial(), 0.0)
    assert why == ""
    np.testing.assert_allclose(T, run(net, 1e6), atol=1e-5)
    assert abs(flows["sun"] + flows["space"] + flows["heater"]) > 1.0  # the root takes the rest
    assert flows["heater"] == pytest.approx(3.0)


# --------------------------------------------------------------------------------------- faces


def all_of(net, name, faces):
    """Areas, points and normals of all facets of some faces."""
    blocks = [block for face in faces for block in net.face(Side(name, face))]
    return (
        np.concatenate([b.areas.ravel() for b in blocks]),
        np.concatenate([b.points.reshape(-1, 3) for b in blocks]),
        np.concatenate([b.normals.reshape(-1, 3) for b in blocks]),
    )


TUBE = tube(RADIUS, THICKNESS)
FACED = {
    "tube of points": (member(wall_points=16), ("outer", "inner", "start", "end")),
    "tube of one": (member(section=TUBE), ("outer", "inner", "start", "end")),
    "bar": (member(section=rectangle(0.02, 0.05)), ("outer", "start", "end")),
    "bar of three": (
        member(section=rectangle(0.02, 0.05), wall_points=3),
        ("outer", "start", "end"),
    ),
    "rod of three": (member(section=circle(0.03), wall_points=3), ("outer", "start", "end")),
}


@pytest.mark.parametrize("case", FACED)
def test_faces_close_and_hold_the_volume(case):
    """Sum of A n is zero, of A n.x three times the volume (divergence theorem)."""
    body, faces = FACED[case]
    areas, points, normals = all_of(NetworkSpace(Description((body,))), body.name, faces)
    np.testing.assert_allclose(areas @ normals, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    volume = areas @ np.einsum("nc,nc->n", normals, points - [0.3, -2.0, 1.0]) / 3.0
    assert volume == pytest.approx(body.section.area * 1.0, rel=1e-12)


@pytest.mark.parametrize("case", FACED)
def test_polygons_turn_about_the_outward_normal(case):
    body, faces = FACED[case]
    net = NetworkSpace(Description((body,)))
    for face in faces:
        for block in net.face(Side(body.name, face)):
            a = block.polygons[:, 2] - block.polygons[:, 0]
            b = block.polygons[:, 3] - block.polygons[:, 1]
            area = 0.5 * np.cross(a, b)
            if block.polygons.shape[1] == 4:
                np.testing.assert_allclose(
                    np.linalg.norm(area, axis=1), block.areas.sum(axis=1), rtol=0.06
                )
            turning = np.einsum("gc,gc->g", area, block.normals.mean(axis=1))
            assert (turning > 0.9 * np.linalg.norm(area, axis=1)).all()


def test_faces_of_a_sheet_lie_on_both_sides_of_it():
    skin = Sheet("skin", surfaces.tube(0.5, 2.0, 16, 4), 0.02, plain(), 300.0)
    net = NetworkSpace(Description(sheets=(skin,)))
    for face, sign in (("top", 1.0), ("bottom", -1.0)):
        (block,) = net.face(Side("skin", face))
        assert block.areas.sum() == pytest.approx(2.0 * pi * 0.5 * 2.0, rel=1e-12)
        outward = block.points[:, 0] * [1.0, 1.0, 0.0]
        assert (sign * np.einsum("gc,gc->g", outward, block.normals[:, 0]) > 0.0).all()
        a, b = (block.polygons[:, i + 2] - block.polygons[:, i] for i in (0, 1))
        assert (np.einsum("gc,gc->g", np.cross(a, b), block.normals[:, 0]) > 0.0).all()
        radii = np.hypot(block.polygons[..., 0], block.polygons[..., 1]).max(axis=1)
        np.testing.assert_allclose(radii, 0.5 + sign * 0.01)


@pytest.mark.parametrize("case", FACED)
@pytest.mark.parametrize("rays", [(0.0, -1.0, 0.2), (0.5, 0.3, 1.0)])
def test_light_from_outside_is_that_of_parallel_rays(case, rays):
    """Irradiation by the cosine at each point of the outer face against the exact shadow."""
    body, _ = FACED[case]
    unit = np.divide(rays, np.linalg.norm(rays))
    light = Irradiation("light", body.name)
    net = LumpedHeat(Description((body,), conditions=(light,)))
    seen = [np.maximum(0.0, -b.normals @ unit).ravel() for b in net.irradiated["light"]]
    now = Moment(0.0, {"light": 1000.0 * np.concatenate(seen)})
    power, flows = net.power(np.full(len(net.x), 300.0), now)
    exact = 1000.0 * net.space.absorbing(Side(body.name), unit)
    assert flows[0] == pytest.approx(exact.sum(), rel=0.03)
    np.testing.assert_allclose(power, exact, atol=0.07 * exact.max())


# -------------------------------------------------------------------------------------- sheets


def plate(n=(8, 4), material=None, length=1.0):
    return Sheet("skin", surfaces.plate(length, 0.5, *n), 0.02, material or plain(), 300.0)


def test_steady_flux_through_a_plate():
    """q t / k between the faces, and q / h between the cold one and the air."""
    conditions = (
        Flux("lamp", "skin", still(5000.0), face="top"),
        Film("air", "skin", still(50.0), still(280.0), face="bottom"),
    )
    net = LumpedHeat(Description(sheets=(plate(material=varying()),), conditions=conditions))
    T, flows, why = net.steady(net.initial(), 0.0)
    assert why == ""
    top, bottom = T.reshape(-1, 2).T
    np.testing.assert_allclose(bottom, 380.0, rtol=1e-10)
    mean_k = 120.0 + 0.5 * (0.5 * (top[0] + bottom[0]) - 300.0)
    np.testing.assert_allclose(top - bottom, 5000.0 * 0.02 / mean_k, rtol=1e-9)
    assert flows["lamp"] == pytest.approx(2500.0)
    assert flows["air"] == pytest.approx(-2500.0)


def test_a_plate_under_a_steady_flux_bends_by_half_of_it():
    """q t / 2k between the faces of a plate that warms evenly (Carslaw & Jaeger 1959, sec. 3.8)."""
    lamp = Flux("lamp", "skin", still(5000.0), face="top")
    net = LumpedHeat(Description(sheets=(plate(),), conditions=(lamp,)))
    top, bottom = run(net, 100.0).reshape(-1, 2).T
    np.testing.assert_allclose(top - bottom, 5000.0 * 0.02 / (2.0 * 167.0), rtol=1e-4)


def test_waves_in_a_plate_decay_with_the_square_of_the_distance():
    errors, t = [], 2700.0 * 896.0 / (167.0 * pi**2)
    for n in (8, 16, 32):
        net = LumpedHeat(Description(sheets=(plate((n, 2)),)), Settings(1e-6))
        wave = 10.0 * np.cos(pi * net.x[:, 0])
        errors.append(np.abs(run(net, t, T=300.0 + wave) - 300.0 - exp(-1) * wave).max())
    assert (orders(errors) > 1.95).all()


def test_waves_round_a_shell_decay_with_the_square_of_the_angle():
    errors, t = [], 0.25 * 2700.0 * 896.0 / 167.0
    for n in (8, 16, 32):
        skin = Sheet("skin", surfaces.tube(0.5, 1.0, n, 1), 0.001, plain(), 300.0)
        net = LumpedHeat(Description(sheets=(skin,)), Settings(1e-6))
        wave = 10.0 * np.cos(np.arctan2(net.x[:, 1], net.x[:, 0]))
        errors.append(np.abs(run(net, t, T=300.0 + wave) - 300.0 - exp(-1) * wave).max())
    assert (orders(errors) > 1.95).all()


DIRECTED = replace(
    plain(),
    conductivity_around=constant("conductivity_around", "W/(m K)", 20.0),
    conductivity_through=constant("conductivity_through", "W/(m K)", 3.0),
)


@pytest.mark.parametrize("lean", [0.0, 0.4, -1.2])
def test_a_linear_field_in_a_leaning_plate_dissipates_what_it_must(lean):
    """t A (k1 g1^2 + k2 g2^2), along d_u and across it."""

    def shape(u, v):
        o, one = np.zeros_like(u), np.ones_like(u)
        x, y = np.stack([one, o, o], 1), np.stack([lean * one, 0.8 * one, o], 1)
        return np.stack([u + lean * v, 0.8 * v, o], 1), x, y, np.zeros((len(u), 3))

    surface = surfaces.patch(shape, np.linspace(0, 2, 4), np.linspace(0, 1, 3) ** 1.5)
    net = NetworkSpace(Description(sheets=(Sheet("skin", surface, 0.01, DIRECTED, 300.0),)))
    gx, gy = 7.0, -11.0
    T = 300.0 + gx * net.x[:, 0] + gy * net.x[:, 1]
    expected = 0.01 * (2.0 * 0.8) * (167.0 * gx**2 + 20.0 * gy**2)
    assert -T @ net.power(T) == pytest.approx(expected, rel=1e-10)


def test_conduction_through_a_plate_has_its_own_conductivity():
    net = NetworkSpace(Description(sheets=(plate(material=DIRECTED),)))
    T = np.tile([301.0, 300.0], len(net.x) // 2)
    assert -T @ net.power(T) == pytest.approx(3.0 * 0.5 / 0.02, rel=1e-12)


# ---------------------------------------------------------------------- sections of three points


@pytest.mark.parametrize("section", [rectangle(0.02, 0.05), rectangle(0.04, 0.01), circle(0.03)])
@pytest.mark.parametrize("axis", [0, 1])
def test_gradients_of_a_section_fade_as_in_theory(section, axis):
    """exp(-k A t / (rho c I)), also where a conductor is negative; k of each direction its own."""
    bar = member(section=section, wall_points=3, elements=1, material=DIRECTED)
    net = LumpedHeat(Description((bar,)), Settings(1e-7))
    moment = (section.second_moment_2, section.second_moment_3)[axis]
    t = 2700.0 * 896.0 * moment / ((20.0, 3.0)[axis] * section.area)
    slope = 100.0 * net.x[:, 1 + axis]
    end = run(net, t, T=300.0 + slope)
    np.testing.assert_allclose(end, 300.0 + exp(-1.0) * slope, atol=1e-5)


@pytest.mark.parametrize("section", [rectangle(0.02, 0.05), circle(0.03)])
@pytest.mark.parametrize(("material", "gap"), [(plain(), 1e-4), (varying(), 5e-3)])
def test_sections_of_three_points_agree_with_finite_elements(section, material, gap):
    """Sunlit, radiating, cooled. With constant properties both say the same of a section; else
    the network takes k at the means of pairs of its temperatures, not at all three."""
    bar = member(section=section, wall_points=3, elements=6, material=material, length=0.5)
    conditions = (
        Flux("sun", "arm", still(20e3), np.array([0.2, -1.0, 0.4])),
        Radiation("space", "arm", 0.8, still(4.0)),
        Film("air", "arm", still(5.0), still(280.0)),
        Fixed("root", Place("arm", "start"), still(300.0)),
    )
    d = Description((bar,), conditions=conditions)
    a, b = (run(s(d, Settings(1e-5)), 100.0) for s in (partial(build, "line"), LumpedHeat))
    assert np.ptp(a[-3:]) > 1.0
    assert np.abs(a - b).max() < gap


# -------------------------------------------------------------------------- all that there is


def whole(material=None):
    """``everything`` with the conditions, bodies and links that it lacks."""
    d, material = everything(material), material or varying()
    beam = member(
        "beam", 0.4, 3, 3, rectangle(0.02, 0.05), replace(material), start=(0.0, 3.0, 0.0)
    )
    law = polynomial("law", "1", [1.0, 0.01], 300.0)
    emissivity = polynomial("emissivity", "1", [0.5, 1e-3], 300.0)
    conditions = (
        Film("film", "boom", ramp(5.0, 9.0, 4.0), still(290.0), face="inner"),
        Film("tip", "beam", still(20.0), still(320.0), face="end"),
        Radiation("dull", "skin", emissivity, still(250.0), face="top"),
        Radiation("box", "hub", 0.7, still(200.0)),
        Irradiation("light in", "skin", "bottom"),
        Irradiation("beam light", "beam"),
        Flux("rays", "beam", still(1000.0), np.array([0.0, -1.0, 0.5])),
        Source("warmth", Place("beam"), still(5.0)),
        Field("field", "far", lambda x, t: 300.0 + 3.0 * t + x[:, 0]),
        Enclosure("bore", [Side("boom", "inner")], [0.8]),
    )
    links = (
        Link("touch", Place("beam", "end"), Place("skin"), None, law),
        Link("shine", Place("hub"), Place("beam"), 0.1, radiating=0.2),
        Link("space link", Place("beam", "start"), still(100.0), 0.0, radiating=0.02),
    )
    skin = Sheet("skin", surfaces.plate(0.4, 0.3, 2, 2), 0.01, material, 305.0)
    far = replace(skin, name="far", surface=surfaces.plate(0.4, 0.3, 2, 2))
    parts = (replace(d.parts[0], area=0.05), *d.parts[1:])
    return Description(
        (*d.members, beam),
        parts,
        (*d.links, *links),
        (*d.conditions, *conditions),
        (skin, far),
        interfaces=(Interface("gap", Side("skin", "top"), Side("far", "bottom"), 30.0, law, 0.3),),
    )


def outside_of(net, scale=1.0):
    """What comes from outside, constant."""
    light = {
        name: scale * np.linspace(10.0, 400.0, sum(b.areas.size for b in face))
        for name, face in net.irradiated.items()
    }
    return {**light, "touch": np.array([0.7 * scale])}


def test_tangent_of_all_there_is_is_the_derivative():
    net = LumpedHeat(whole())
    T = net.initial() + 20.0 * np.random.default_rng(2).standard_normal(len(net.x))
    now, tau, step = Moment(2.5, outside_of(net)), 37.0, 1e-3

    def balance(T):
        return (net.space.heat(T) - tau * net.power(T, now)[0])[net.free]

    solve = net.factorise(T, now, tau)
    for direction in np.random.default_rng(3).standard_normal((8, len(net.free))):
        full = np.zeros(len(T))
        full[net.free] = direction
        change = (balance(T + step * full) - balance(T - step * full)) / (2.0 * step)
        np.testing.assert_allclose(solve(change), direction, atol=1e-6)


@pytest.mark.parametrize("material", [plain(), varying()])
def test_balance_of_all_there_is_closes_to_round_off(material):
    net = LumpedHeat(whole(material))
    T, rng = net.initial(), np.random.default_rng(4)
    for i in range(8):
        heat = rng.uniform(0.0, 5.0, len(T))
        outside = {k: (v, 1.5 * v) for k, v in outside_of(net).items()}
        new, flows, why = net.advance(T, 0.4 * i, 0.4, heat, outside)
        assert why == ""
        stored = net.energy(new) - net.energy(T)
        largest = max(*map(abs, flows.values()), heat.sum())
        assert abs(sum(flows.values()) + heat.sum() - stored) < 1e-11 * largest
        T = new


def test_means_of_places_are_by_mass():
    """A source over all of a member or sheet warms it evenly."""
    bar = member("bar", 1.0, 5)
    sources = (
        Source("a", Place("bar"), still(10.0)),
        Source("b", Place("skin"), still(10.0)),
    )
    net = LumpedHeat(Description((bar,), sheets=(plate(),), conditions=sources))
    T = run(net, 100.0)
    for name, mass in (("bar", 2700.0 * 1e-4), ("skin", 2700.0 * 0.5 * 0.02)):
        rise = 1000.0 / (mass * 896.0)
        np.testing.assert_allclose(T[net.regions[name]] - 300.0, rise, rtol=1e-9)


def test_heat_on_one_face_of_a_sheet_stays_there_at_first():
    lamp = Source("lamp", Place("skin", "bottom"), still(10.0))
    space = NetworkSpace(Description(sheets=(plate(),), conditions=(lamp,)))
    mean = space.place(Place("skin", "bottom"))
    np.testing.assert_array_equal(mean.nodes, np.arange(1, len(space.x), 2))
    assert mean.weights.sum() == pytest.approx(1.0)


def test_solids_are_refused_with_a_sentence():
    mesh = Mesh(np.vstack([np.zeros(3), np.eye(3)]), {"tetra": np.array([[0, 1, 2, 3]])})
    with pytest.raises(ValueError, match="the lumped solver has no lumps for solids: 'block'"):
        LumpedHeat(Description(solids=(Solid("block", mesh, {"": plain()}, 300.0),)))


def lit_shell(n):
    """A panel of a cylinder, of varying and directed properties, lit, radiating and cooled."""
    material = replace(varying(), conductivity_around=DIRECTED.conductivity_around)
    surface = surfaces.tube(0.5, 0.8, n, n // 2, (0.0, 2.0))
    skin = Sheet("skin", surface, 0.01, material, 300.0)
    conditions = (
        Flux("sun", "skin", still(8000.0), np.array([-1.0, -0.5, 0.1]), "top"),
        Radiation("space", "skin", 0.9, still(4.0), "top"),
        Film("air", "skin", still(20.0), still(280.0), "bottom"),
    )
    return Description(sheets=(skin,), conditions=conditions)


def lit_tube(n):
    arm = member("arm", 0.5, 2 * n, n, material=varying())
    conditions = (
        Flux("sun", "arm", still(4000.0), np.array([0.3, -1.0, 0.4])),
        Radiation("space", "arm", 0.8, still(4.0)),
        Film("bore", "arm", still(10.0), still(320.0), "inner"),
        Film("tip", "arm", still(100.0), still(250.0), "end"),
        Fixed("root", Place("arm", "start"), still(300.0)),
    )
    return Description((arm,), conditions=conditions)


@pytest.mark.parametrize("make", [lit_shell, lit_tube])
@pytest.mark.parametrize("end", [pytest.param(200.0, marks=pytest.mark.slow), None])
def test_network_and_walls_of_second_order_meet_as_the_mesh_is_refined(make, end):
    gaps = []
    for n in (8, 16, 32):
        reference = build("wall", make(n), Settings(1e-3, order=2))
        net = LumpedHeat(make(n), Settings(1e-3))
        a, b = (
            run(s, end) if end else s.steady(s.initial(), 0.0)[0] for s in (reference, net)
        )  # fmt: skip
        gaps.append(np.abs(a[: len(b)] - b).max())
    assert (orders(gaps) > 1.6).all()
    assert gaps[-1] < 0.3


@pytest.mark.parametrize("linear", ["direct", "multigrid"])
def test_balance_of_a_large_sheet_closes_however_it_is_solved(linear):
    pytest.importorskip("pyamg")
    conditions = (
        Flux("sun", "skin", still(5000.0), np.array([0.3, 0.0, -1.0]), "top"),
        Radiation("space", "skin", 0.8, still(4.0), "bottom"),
    )
    sheet = replace(plate((40, 30), varying()), thickness=0.002)
    net = LumpedHeat(Description(sheets=(sheet,), conditions=conditions), Settings(linear=linear))
    T, flows, why = net.advance(net.initial(), 0.0, 30.0, np.zeros(len(net.x)))
    assert why == ""
    stored = net.energy(T) - net.energy(net.initial())
    assert abs(sum(flows.values()) - stored) < 1e-11 * max(map(abs, flows.values()))


# ------------------------------------------------------------------------------------ extremes


def test_a_wall_of_a_micrometre_at_4_kelvin_warms_through_decades_of_heat_capacity():
    """c rises by six decades; a warm bar of a millionth of the conductivity is glued to its end."""
    cryogenic = replace(
        varying(),
        heat_capacity=table(
            "heat_capacity", "J/(kg K)", [2, 4, 20, 300, 900], [1e-3, 0.01, 10, 900, 1000]
        ),
        conductivity=table("conductivity", "W/(m K)", [2, 900], [1, 200]),
    )
    foil = member("foil", 1.0, 12, 8, tube(0.05, 1e-6), cryogenic, 4.2)
    bar = member("bar", 1.0, 5, 1, rectangle(0.01, 0.01), plain(1e-4), start=(0.0, 1.0, 0.0))
    conditions = (
        Flux("sun", "foil", still(1361.0), np.array([0.0, -1.0, 0.0])),
        Radiation("space", "foil", 0.8, still(4.0)),
    )
    glue = Link("glue", Place("foil", "end"), Place("bar", "start"), 1.0)
    net = LumpedHeat(Description((foil, bar), links=(glue,), conditions=conditions))
    T = net.initial()
    for i in range(3):
        new, flows, why = net.advance(T, 100.0 * i, 100.0, np.zeros(len(T)))
        assert why == ""
        stored = net.energy(new) - net.energy(T)
        assert abs(sum(flows.values()) - stored) < 1e-11 * max(map(abs, flows.values()))
        T = new
    sunny = T[net.regions["foil"]].reshape(-1, 8)[0, 0]
    assert sunny == pytest.approx((1361.0 / (0.8 * 5.670374419e-8)) ** 0.25, rel=0.03)
    assert T.min() > 4.0


def test_cooling_below_absolute_zero_is_a_reason():
    block = Part("block", np.zeros(3), plain(), 1.0, 300.0)
    d = Description((), (block,), conditions=(Source("drain", Place("block"), still(-1e4)),))
    net = LumpedHeat(d)
    assert "'block' fell below 0 K" in net.advance(net.initial(), 0.0, 100.0, np.zeros(1))[2]
