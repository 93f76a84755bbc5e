"""Heat in developed walls of tubes: elements, orders, closed forms, shocks, faces, balance."""

from dataclasses import replace
from functools import partial
from math import cos, exp, pi, sin, sinh
from time import perf_counter

import numpy as np
import pytest
from heat_cases import RADIUS, THICKNESS, member, plain, ramp, still, varying
from scipy.integrate import quad, solve_ivp

from meshes.materials import constant, table
from meshes.sections import rectangle, tube
from thermal.boundary import STEFAN_BOLTZMANN, Moment
from thermal.description import (
    Description,
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
    Side,
    Source,
    Wall,
)
from thermal.solvers import build
from thermal.wall import WallSpace
from thermal.wall_elements import conduct, shape
from thermal.wall_tube import lit

SIGMA = STEFAN_BOLTZMANN
OUTER = RADIUS + 0.5 * THICKNESS


def orders(errors):
    return np.log2(np.divide(errors[:-1], errors[1:]))


def matrix(bonds, n):
    """Conductances per conductivity as a matrix."""
    K = np.zeros((n, n))
    for a, b, c in zip(*bonds, strict=True):
        K[[a, a, b, b], [a, b, b, a]] += [c, -c, c, -c]
    return K


def developed(space):
    """Axial coordinate and angle of all temperatures of a member along x."""
    return space.x[:, 0], np.arctan2(space.x[:, 2], space.x[:, 1])


# ---------------------------------------------------------------------------------- elements


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shear", [0.0, 0.3])
def test_elements_agree_with_scikit_fem(order, shear):
    """A patch of parallelograms, conductivities 2 along and 3 at right angles to the first side."""
    from skfem import Basis, BilinearForm, ElementQuad1, ElementQuad2, MeshQuad

    mesh = MeshQuad.init_tensor(np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.5, 0.7]))
    skewed = MeshQuad(np.stack([mesh.p[0] + shear * mesh.p[1], mesh.p[1]]), mesh.t)
    form = shape(order)
    element = ElementQuad1() if order == 1 else ElementQuad2()
    basis = Basis(skewed, element, quadrature=(form.nodes.T, form.weights))
    corners = skewed.p.T[skewed.t.T]
    sides = [np.pad(corners[:, i] - corners[:, 0], ((0, 0), (0, 1))) for i in (1, 3)]
    along, across = (np.repeat(side[:, None], len(form.nodes), axis=1) for side in sides)
    cells = basis.element_dofs.T
    areas, (first, second) = conduct(cells, along, across, form)
    turn = along[0, 0, :2] / np.linalg.norm(along[0, 0])
    normal = np.array([-turn[1], turn[0]])
    D = 2.0 * np.outer(turn, turn) + 3.0 * np.outer(normal, normal)
    exact = BilinearForm(
        lambda u, v, _: sum(D[i, j] * u.grad[i] * v.grad[j] for i in (0, 1) for j in (0, 1))
    ).assemble(basis)
    ours = 2.0 * matrix(first, basis.N) + 3.0 * matrix(second, basis.N)
    np.testing.assert_allclose(ours, exact.toarray(), atol=1e-13)
    masses = BilinearForm(lambda u, v, _: u * v).assemble(basis).diagonal()
    np.testing.assert_allclose(np.bincount(cells.ravel(), areas.ravel()), masses, rtol=1e-13)


@pytest.mark.parametrize("order", [1, 2])
def test_tangent_is_the_derivative(order):
    material = replace(
        varying(), conductivity_around=table("k", "W/(m K)", [200.0, 400.0], [2.0, 9.0])
    )
    arm = member(elements=3, wall_points=4, material=material)
    space = WallSpace(Description([arm]), Settings(order=order))
    T = 300.0 + 40.0 * np.random.default_rng(1).random(len(space.x))
    rows, columns = space.entries()
    n, tau, e = len(T), 3.0, 1e-3
    K = np.zeros((n, n))
    np.add.at(K, (rows, columns), space.tangent(T, tau))
    change = [
        space.heat(T + s * d) - tau * space.power(T + s * d) for d in np.eye(n) for s in (e, -e)
    ]
    numeric = (np.array(change[::2]) - np.array(change[1::2])).T / (2.0 * e)
    np.testing.assert_allclose(K, numeric, atol=1e-6 * np.abs(K).max())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("n", [4, 6, 16])
@pytest.mark.parametrize("phase", [0.0, 0.4, -2.9, 3.1])
def test_loads_of_parallel_rays_are_the_integrals(order, n, phase):
    loads = lit(order, n, np.array([phase]))[0]
    assert loads.sum() == pytest.approx(2.0, rel=1e-13)
    turn = 2 * pi / n

    def function(x):  # of the node at three elements from e2
        away = abs(x / turn - 3.0)
        return 1.0 - away if order == 1 else 1.5 - 6.0 * away + 5.0 * away**2

    exact = quad(
        lambda x: function(x) * max(0.0, cos(x - phase)),
        2 * turn,
        4 * turn,
        points=[3 * turn],
        limit=200,
        epsabs=1e-12,
    )[0]
    assert loads[3 * order] == pytest.approx(exact, abs=1e-8)


# ------------------------------------------------------------------------------------- faces


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("face", ["outer", "inner", "start", "end"])
def test_faces_have_their_areas_normals_and_facets(order, face):
    along, normal = np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])
    arm = member(length=2.0, elements=3, wall_points=16, along=along, normal=normal)
    space = WallSpace(Description([arm]), Settings(order=order))
    inner = RADIUS - 0.5 * THICKNESS
    exact = {
        "outer": 2 * pi * OUTER * 2.0,
        "inner": 2 * pi * inner * 2.0,
        "start": pi * (OUTER**2 - inner**2),
        "end": pi * (OUTER**2 - inner**2),
    }[face]
    for (block,) in (space.face(Side("arm", face)), space.irradiated(Side("arm", face))):
        assert block.areas.sum() == pytest.approx(exact, rel=1e-12)
        np.testing.assert_allclose(block.values.sum(1), 1.0, rtol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(block.normals, axis=2), 1.0, rtol=1e-12)
        x, polygons = block.points, block.polygons
        axial = x @ along
        out = (x - axial[..., None] * along) / RADIUS
        if face in ("outer", "inner"):
            np.testing.assert_allclose(block.normals, out / np.linalg.norm(out, axis=2)[..., None]
                                       * (1 if face == "outer" else -1), atol=1e-12)  # fmt: skip
        else:
            np.testing.assert_allclose(block.normals @ along, 1 if face == "end" else -1)
        turning = 0.5 * np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1])
        facing = np.einsum("gx,gx->g", turning, block.normals.mean(axis=1))
        assert (facing > 0.0).all()
        assert np.linalg.norm(turning, axis=1).sum() == pytest.approx(exact, rel=0.03)


def test_order_two_has_its_further_nodes_in_no_region():
    arm = member(elements=5, wall_points=8)
    line_heat = build("line", Description([arm]))
    for order, count in ((1, 48), (2, 11 * 16)):
        space = WallSpace(Description([arm]), Settings(order=order))
        assert len(space.x) == count
        np.testing.assert_allclose(space.x[space.regions["arm"]], line_heat.x, atol=1e-15)
        assert space.place(Place("arm")).weights.sum() == pytest.approx(1.0)
        end = space.place(Place("arm", "end"))
        np.testing.assert_allclose(space.x[end.nodes, 0], 1.0)
        assert len(end.nodes) == (8 if order == 1 else 16)


# ------------------------------------------------------------------------- manufactured field


def field(s, phi, t):
    return 320.0 + (15.0 + 0.4 * t) * np.cos(pi * s) * (1.0 + 0.5 * np.sin(2.0 * phi))


def density(material, s, phi, t, sink):
    """Flux density on the outer face that makes ``field`` the temperature."""
    a, shape_phi = 15.0 + 0.4 * t, 1.0 + 0.5 * np.sin(2.0 * phi)
    T = field(s, phi, t)
    by_s = -pi * a * np.sin(pi * s) * shape_phi
    by_phi = a * np.cos(pi * s) * np.cos(2.0 * phi)
    rate = 0.4 * np.cos(pi * s) * shape_phi
    k, dk = material.conductivity(T), material.conductivity.derivative(T)
    flat = -(pi**2) * a * np.cos(pi * s) * shape_phi
    flat -= 2.0 * a * np.cos(pi * s) * np.sin(2.0 * phi) / RADIUS**2
    conducted = k * flat + dk * (by_s**2 + by_phi**2 / RADIUS**2)
    stored = material.density * material.heat_capacity(T) * rate
    radiated = 0.7 * SIGMA * (T**4 - sink**4)
    return THICKNESS * (stored - conducted) * RADIUS / OUTER + radiated


def error_of_manufactured(order, n):
    material = varying()
    arm = member(elements=n, wall_points=2 * n, material=material)
    conditions = [Irradiation("lamp", "arm"), Radiation("space", "arm", 0.7, still(250.0))]
    solver = build(
        "wall", Description([arm], conditions=conditions), Settings(order=order, steps=1)
    )
    s, phi = developed(solver)
    (block,) = solver.irradiated["lamp"]
    at = (
        block.points[..., 0].ravel(),
        np.arctan2(block.points[..., 2], block.points[..., 1]).ravel(),
    )
    T, times = field(s, phi, 0.0), np.linspace(0.0, 5.0, 6)
    for t, h in zip(times[:-1], np.diff(times), strict=True):
        given = tuple(density(material, *at, now, 250.0) for now in (t, t + h))
        T, _, why = solver.advance(T, t, h, np.zeros_like(T), {"lamp": given})
        assert why == ""
    return np.abs(T - field(s, phi, 5.0)).max()


@pytest.mark.parametrize("order", [1, 2])
def test_manufactured_solution_shows_the_order_in_space(order):
    """k(T), c(T) and radiation; elements of order 1 converge by h^2, of order 2 by h^3."""
    found = orders(
        [error_of_manufactured(order, n) for n in ((8, 16, 32) if order == 1 else (4, 8, 16))]
    )
    assert found.mean() > order + 0.9, found
    assert found[-1] > order + 0.9, found


@pytest.mark.parametrize(
    ("scheme", "order"), [("sdirk2", 2), ("crank-nicolson", 2), ("backward-euler", 1)]
)
def test_order_in_time(scheme, order):
    """Against Radau of high accuracy on the same elements."""
    arm = member(elements=4, wall_points=8, material=varying())
    conditions = [Radiation("space", "arm", 0.7, still(4.0)), Flux("sun", "arm", still(1361.0),
                  np.array([0.1, -1.0, 0.4]))]  # fmt: skip
    d = Description([arm], conditions=conditions)
    space = build("wall", d)
    start, now = space.initial() + 30.0 * np.sin(np.arange(40)), Moment(0.0, {})

    def rate(t, T):
        e = 1e-3
        capacity = (space.space.heat(T + e) - space.space.heat(T - e)) / (2.0 * e)
        return space.power(T, now)[0] / capacity

    exact = solve_ivp(rate, (0.0, 20.0), start, "Radau", rtol=1e-10, atol=1e-10).y[:, -1]
    errors = []
    for steps in (20, 40, 80):
        T, _, why = build("wall", d, Settings(scheme=scheme, steps=steps)).advance(
            start, 0.0, 20.0, np.zeros(40)
        )
        assert why == ""
        errors.append(np.abs(T - exact).max())
    assert (np.abs(orders(errors) - order) < 0.25).all(), orders(errors)


# ------------------------------------------------------------------------------ closed forms


def decayed(order, n, harmonic, material=None, time=10.0):
    arm = member(elements=2, wall_points=n, material=material or plain())
    solver = build("wall", Description([arm]), Settings(order=order, steps=200))
    _, phi = developed(solver)
    T, _, why = solver.advance(300.0 + 10.0 * np.cos(harmonic * phi), 0.0, time, np.zeros(len(phi)))
    assert why == ""
    return np.abs((T - 300.0)[np.argmin(np.abs(phi))] / 10.0)


@pytest.mark.parametrize(("order", "least"), [(1, 1.9), (2, 3.5)])
def test_waves_round_the_circumference_decay_as_they_should(order, least):
    """T = cos(m phi) exp(-m^2 k t / (rho c R^2))."""
    exact = exp(-4.0 * 167.0 / (2700.0 * 896.0) / RADIUS**2 * 10.0)
    errors = [abs(decayed(order, n, 2) - exact) for n in (8, 16, 32)]
    assert (orders(errors) > least).all(), orders(errors)


def test_waves_of_order_one_decay_by_their_discrete_rate():
    """lambda = (2 sin(m d/2) / d)^2 k / (rho c R^2) for elements of the angle d."""
    d = 2 * pi / 16
    rate = (2.0 * sin(1.5 * d) / d) ** 2 * 167.0 / (2700.0 * 896.0 * RADIUS**2)
    assert decayed(1, 16, 3) == pytest.approx(exp(-10.0 * rate), rel=2e-4)


def test_conductivity_around_acts_around_and_conductivity_along():
    around_k = constant("k", "W/(m K)", 20.0)
    slow = replace(plain(), conductivity_around=around_k)
    exact = exp(-4.0 * 20.0 / (2700.0 * 896.0) / RADIUS**2 * 10.0)
    assert decayed(2, 16, 2, slow) == pytest.approx(exact, rel=1e-3)
    arm = member(elements=4, wall_points=4, material=slow)
    ends = [Fixed("a", Place("arm", "start"), still(300.0)),
            Fixed("b", Place("arm", "end"), still(320.0))]  # fmt: skip
    solver = build("wall", Description([arm], conditions=ends))
    T, _, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    np.testing.assert_allclose(T, 300.0 + 20.0 * solver.x[:, 0], rtol=1e-12)
    gained = solver.space.power(T)[solver.space.place(Place("arm", "start")).nodes].sum()
    assert gained == pytest.approx(167.0 * 2 * pi * RADIUS * THICKNESS * 20.0, rel=1e-10)


@pytest.mark.parametrize(("order", "least"), [(1, 1.9), (2, 2.9)])
def test_steady_field_in_an_anisotropic_wall(order, least):
    """T = cosh(a s) cos(phi) with a R = sqrt(k_around / k_along), held at the ends."""
    material = replace(plain(100.0), conductivity_around=constant("k", "W/(m K)", 1.0))
    a, errors = 0.1 / RADIUS, []

    def exact(x, t=0.0):
        return 300.0 + 10.0 * np.cosh(a * x[:, 0]) * x[:, 1] / RADIUS

    for n in (4, 8, 16):
        arm = member(elements=n, wall_points=n, material=material)
        solver = build("wall", Description([arm]), Settings(order=order))
        ends = np.flatnonzero(np.isin(np.round(solver.x[:, 0], 9), [0.0, 1.0]))
        inside = np.setdiff1d(np.arange(len(solver.x)), ends)
        rows, columns = solver.space.entries()
        K = np.zeros((len(solver.x),) * 2)
        tangent = solver.space.tangent(solver.initial(), 1.0)
        tangent[: len(K)] = 0.0  # what is stored
        np.add.at(K, (rows, columns), tangent)
        T = exact(solver.x)
        T[inside] = np.linalg.solve(K[np.ix_(inside, inside)], -K[np.ix_(inside, ends)] @ T[ends])
        errors.append(np.abs(T - exact(solver.x)).max())
    assert (orders(errors) > least).all(), orders(errors)


def test_steady_flow_along_a_tube_with_a_conductivity_that_varies_is_exact():
    """The integral of k over T is linear; also on a bent member of uneven stations."""
    points = np.array([[0, 0, 0], [0.1, 0, 0], [0.5, 0, 0], [0.5, 0.3, 0], [0.5, 0.4, 0.2]], float)
    axes = np.broadcast_to(np.eye(3), (5, 3, 3))
    arm = replace(member(wall_points=4, material=varying()), points=points, axes=axes)
    ends = [Fixed("a", Place("arm", "start"), still(250.0)),
            Fixed("b", Place("arm", "end"), still(400.0))]  # fmt: skip
    solver = build("wall", Description([arm], conditions=ends))
    T, _, _ = solver.steady(solver.initial(), 0.0)
    s = np.array([0.0, 0.1, 0.5, 0.8, 0.8 + np.hypot(0.1, 0.2)])
    k = arm.material.conductivity
    U = k.integral(250.0, T.reshape(5, 4))
    np.testing.assert_allclose(U, np.outer(s / s[-1], np.full(4, k.integral(250.0, 400.0))),
                               rtol=1e-9, atol=1e-6)  # fmt: skip


@pytest.mark.parametrize("order", [1, 2])
def test_nafems_t2_a_bar_that_radiates_from_its_end(order):
    bar = member(length=0.1, elements=10, wall_points=4, material=plain(55.6, 460.0, 7850.0))
    conditions = [Fixed("hot", Place("arm", "start"), still(1000.0)),
                  Radiation("space", "arm", 0.98, still(300.0), "end")]  # fmt: skip
    solver = build("wall", Description([bar], conditions=conditions), Settings(order=order))
    T, _, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    np.testing.assert_allclose(T[solver.space.place(Place("arm", "end")).nodes], 927.004, atol=1e-3)


def test_nafems_t3_a_bar_with_an_end_that_swings():
    bar = member(length=0.1, elements=20, wall_points=4, material=plain(35.0, 440.5, 7200.0),
                 initial=273.15)  # fmt: skip
    swing = Fixed("swing", Place("arm", "end"), lambda t: 273.15 + 100.0 * sin(pi * t / 40.0))
    calm = Fixed("calm", Place("arm", "start"), still(273.15))
    settings = Settings(order=2, steps=320)
    solver = build("wall", Description([bar], conditions=[swing, calm]), settings)
    T, _, why = solver.advance(solver.initial(), 0.0, 32.0, np.zeros(len(solver.x)))
    assert why == ""
    np.testing.assert_allclose(T[np.isclose(solver.x[:, 0], 0.08)] - 273.15, 36.6031, atol=2e-3)


def test_a_slab_cooled_by_convection():
    """Bi = 1 at Fo = 0.5: middle and surface of the half-slab by its Fourier series."""
    bar = member(length=1.0, elements=20, wall_points=4, material=plain(1.0, 1.0, 1.0), initial=2.0)
    air = Film("air", "arm", still(1.0), still(1.0), "end")
    settings = Settings(order=2, steps=400)
    solver = build("wall", Description([bar], conditions=[air]), settings)
    T, _, why = solver.advance(solver.initial(), 0.0, 0.5, np.zeros(len(solver.x)))
    assert why == ""
    for end, exact in (("start", 0.77252638), ("end", 0.50452193)):
        np.testing.assert_allclose(T[solver.space.place(Place("arm", end)).nodes], 1.0 + exact,
                                   atol=2e-5)  # fmt: skip


def error_of_a_fin(order, n, edge):
    """Convection, insulated ends, lit up to ``edge``: T and T' are continuous there."""
    film, q, length = 40.0, 3000.0, 1.0
    m = np.sqrt(film * OUTER / (167.0 * THICKNESS * RADIUS))
    arm = member(elements=n, wall_points=8)
    conditions = [Film("air", "arm", still(film), still(290.0)), Irradiation("sun", "arm")]
    solver = build("wall", Description([arm], conditions=conditions), Settings(order=order))
    (block,) = solver.irradiated["sun"]
    flux = np.where(block.points[..., 0] < edge, q, 0.0).ravel()
    T, flows, why = solver.steady(solver.initial(), 0.0, {"sun": flux})
    assert why == ""
    assert flows["sun"] == pytest.approx(-flows["air"], rel=1e-9)
    s = solver.x[:, 0]
    lit_side = 1.0 - sinh(m * (length - edge)) / sinh(m * length) * np.cosh(m * s)
    dark = sinh(m * edge) / sinh(m * length) * np.cosh(m * (length - s))
    return np.abs((T - 290.0) / (q / film) - np.where(s < edge, lit_side, dark)).max(), m


@pytest.mark.parametrize("order", [1, 2])
def test_a_tube_lit_up_to_an_edge_at_a_station(order):
    errors = [error_of_a_fin(order, n, 0.4)[0] for n in (10, 20, 40)]
    assert (orders(errors) > order + 0.7).all(), orders(errors)
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("edge", [0.41, 0.43, 0.4499])
def test_a_tube_lit_up_to_an_edge_between_stations(order, edge):
    """Points of irradiation put the edge off by a sixth of an element at most.

    Heat moved by d along an infinite fin changes its temperature by m d / 2 of what it would be.
    """
    error, m = error_of_a_fin(order, 20, edge)
    assert error < m * (0.05 / 6.0) / 2.0 + 2.5e-3


def test_a_tube_in_the_sun_agrees_with_trigonometric_interpolation():
    """A smooth field: differences to line fall by the order of the wall's elements."""
    direction = np.array([0.3, -1.0, 0.5])

    def after(solver):
        T, _, why = solver.advance(solver.initial(), 0.0, 60.0, np.zeros(len(solver.x)))
        assert why == ""
        return T[solver.regions["arm"]]

    def built(n, make, settings):
        arm = member(elements=6, wall_points=n)
        conditions = [Flux("sun", "arm", still(1361.0), direction),
                      Radiation("space", "arm", 0.8, still(4.0))]  # fmt: skip
        return after(make(Description([arm], conditions=conditions), settings)).reshape(7, n)

    exact = built(64, partial(build, "line"), Settings(steps=20))
    for order, least, sizes in ((1, 1.8, (8, 16, 32)), (2, 2.7, (8, 16))):
        errors = []
        for n in sizes:
            T = built(n, partial(build, "wall"), Settings(order=order, steps=20))
            errors.append(np.abs(T - exact[:, :: 64 // n]).max())
        assert (orders(errors) > least).all(), (order, errors)
        assert errors[-1] < 2e-3 * np.ptp(exact)


# ------------------------------------------------------------------------- shocks and balance


@pytest.mark.parametrize("elements", [2, 40])
def test_a_shock_never_cools_a_point_below_the_coldest_boundary(elements):
    """Backward Euler, elements 25 times longer than wide or the other way, k(T), c(T)."""
    arm = member(elements=elements, wall_points=24, material=varying())
    cold = [Fixed("cryogen", Place("arm", "start"), still(210.0))]
    hot = [Wall("sun", "arm", 1.0, 1.0, np.array([0.0, 1.0, 0.0]),
                (still(380.0),) * 2, (still(280.0),) * 2)]  # fmt: skip
    settings = Settings(scheme="backward-euler", steps=4)
    solver = build("wall", Description([arm], conditions=cold + hot), settings)
    T = solver.initial()
    for h in (1e-4, 1e-2, 1.0, 100.0, 1e4):
        T, _, why = solver.advance(T, 0.0, h, np.zeros_like(T))
        assert why == ""
        assert T.min() >= 210.0 - 1e-9
        assert T.max() <= 380.0 + 1e-9


def test_a_shock_under_error_control_falls_short_by_no_more_than_the_tolerance():
    arm = member(elements=20, wall_points=8)
    cold = [Fixed("cryogen", Place("arm", "start"), still(100.0))]
    solver = build("wall", Description([arm], conditions=cold), Settings(tolerance=1e-2))
    T = solver.initial()
    for i in range(20):
        T, _, why = solver.advance(T, 0.5 * i, 0.5, np.zeros_like(T))
        assert why == ""
        assert 100.0 - 1e-2 <= T.min() <= T.max() <= 300.0 + 1e-2


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("scheme", ["sdirk2", "crank-nicolson", "backward-euler"])
def test_what_flows_in_is_stored(order, scheme):
    material = varying()
    boom = member("boom", 2.0, 6, 4, material=material, initial=310.0)
    mast = member("mast", 1.0, 3, 8, initial=300.0, start=(2.0, 0.0, 0.0), along=(0.0, 0.0, 1.0))
    hub = Part("hub", np.zeros(3), plain(16.0, 500.0, 8000.0), 0.7, 290.0, area=0.01)
    links = (
        Link("fitting", Place("hub"), Place("boom", "start"), 3.0),
        Link("joint", Place("boom", "end"), Place("mast", "start"), 1.5),
        Link("mount", Place("hub"), still(280.0), 0.8),
    )
    hot = (ramp(310.0, 350.0, 8.0), ramp(310.0, 340.0, 8.0))
    cold = (ramp(310.0, 320.0, 8.0), ramp(310.0, 300.0, 8.0))
    conditions = (
        Wall("sun", "boom", 0.9, 1.5, np.array([0.3, 1.0, 0.4]), hot, cold),
        Flux("light", "boom", ramp(0.0, 900.0, 3.0), np.array([0.2, -1.0, 0.5])),
        Flux("glow", "mast", still(50.0)),
        Radiation("space", "boom", 0.8, still(4.0)),
        Radiation("bore", "mast", 0.3, still(290.0), "inner"),
        Film("air", "mast", still(5.0), still(270.0), "end"),
        Film("breeze", "hub", still(5.0), still(270.0)),
        Irradiation("lamp", "mast"),
        Source("heater", Place("boom"), still(12.0)),
        Source("motor", Place("mast", "start"), ramp(0.0, 6.0, 2.0)),
    )
    d = Description((boom, mast), (hub,), links, conditions)
    solver = build("wall", d, Settings(order=order, scheme=scheme))
    (block,) = solver.irradiated["lamp"]
    lamp = np.full(block.areas.size, 70.0)
    rubbed = np.zeros(len(solver.x))
    rubbed[solver.regions["hub"]] = 3.0
    T, total = solver.initial(), 0.0
    start = solver.energy(T)
    largest = 0.0
    for i in range(4):
        T, flows, why = solver.advance(T, 2.0 * i, 2.0, rubbed, {"lamp": (0.0 * lamp, lamp)})
        assert why == ""
        assert set(flows) == {"mount", *(c.name for c in conditions)}
        total += sum(flows.values()) + rubbed.sum()
        largest = max(largest, *(abs(f) for f in flows.values()))
    assert solver.energy(T) - start == pytest.approx(total, abs=1e-11 * largest)


@pytest.mark.parametrize("order", [1, 2])
def test_given_temperatures_hold_every_node(order):
    """Wall, Fixed and Field, also at the nodes of order 2."""
    arm = member(elements=8, wall_points=8)
    mast = member("mast", elements=2, wall_points=4, start=(0.0, 5.0, 0.0))
    side = np.array([0.0, 1.0, 0.0])
    conditions = [
        Wall("sun", "arm", 0.5, 1.0, side, (still(400.0),) * 2, (still(200.0),) * 2),
        Fixed("root", Place("arm", "start"), still(280.0)),
        Field("file", "mast", lambda x, t: 300.0 + 5.0 * t * x[:, 0]),
    ]
    solver = build("wall", Description([arm, mast], conditions=conditions), Settings(order=order))
    T, _, why = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert why == ""
    x = solver.x
    of_mast = x[:, 1] > 1.0
    np.testing.assert_allclose(T[of_mast], 300.0 + 5.0 * x[of_mast, 0])
    held = ~of_mast & (x[:, 0] > 0.499)
    np.testing.assert_allclose(T[held], 300.0 + 100.0 * x[held, 1] / RADIUS, rtol=1e-12)
    np.testing.assert_allclose(T[~of_mast & (x[:, 0] < 1e-9)], 280.0)


# ---------------------------------------------------------------------------------- bad input


def test_what_is_no_wall_is_refused_all_at_once():
    bar = member("bar", section=rectangle(0.01, 0.01))
    pipe = member("pipe", section=tube(0.01, 0.001), wall_points=1)
    with pytest.raises(ValueError, match="'bar' is not a wall") as caught:
        WallSpace(Description([bar, pipe]))
    assert "'pipe' is not a wall" in str(caught.value)
    with pytest.raises(ValueError, match="order of walls is 1 or 2, got 3"):
        build("wall", Description([member(wall_points=4)]), Settings(order=3))


def test_leaving_the_range_of_a_property_is_a_reason():
    arm = member(elements=2, wall_points=4, material=varying(250.0, 350.0))
    solver = build(
        "wall", Description([arm], conditions=[Source("heater", Place("arm"), still(1e4))])
    )
    _, _, why = solver.advance(solver.initial(), 0.0, 100.0, np.zeros(12))
    assert "'arm' left the range of conductivity" in why or "heat_capacity" in why


def test_conductivities_a_million_apart_and_a_wall_of_a_micrometre():
    foil = tube(RADIUS, 1e-6)
    material = replace(plain(), conductivity_around=constant("k", "W/(m K)", 167e-6))
    arm = member(elements=10, wall_points=8, section=foil, material=material)
    ends = [Fixed("a", Place("arm", "start"), still(300.0)),
            Fixed("b", Place("arm", "end"), still(320.0))]  # fmt: skip
    solver = build("wall", Description([arm], conditions=ends))
    T, _, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    np.testing.assert_allclose(T, 300.0 + 20.0 * solver.x[:, 0], rtol=1e-10)


# ------------------------------------------------------------------------------------- speed


@pytest.mark.benchmark
@pytest.mark.parametrize("order", [1, 2])
def test_refilling_fifty_thousand_nodes(order):
    """Residual and matrix with k(T), c(T) and radiation: 60 ms at most."""
    arm = member(length=20.0, elements=780 // order, wall_points=64 // order, material=varying())
    solver = build(
        "wall",
        Description([arm], conditions=[Radiation("space", "arm", 0.8, still(4.0))]),
        Settings(order=order),
    )
    space, boundary, now = solver.space, solver._boundary, Moment(0.0, {})
    T, times = solver.initial() + np.linspace(0.0, 50.0, len(solver.x)), []
    for _ in range(10):
        begin = perf_counter()
        space.heat(T)
        solver.power(T, now)
        values = np.concatenate([space.tangent(T, 1.0), boundary.slopes(T, now)])
        solver.linear._pattern.data(values)
        times.append(1e3 * (perf_counter() - begin))
    print(f"order {order}, {len(T)} nodes: {np.median(times):.1f} ms")
    assert np.median(times) < 60.0
