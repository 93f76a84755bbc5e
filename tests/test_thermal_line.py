"""Heat on lines: basis, assembly, tangent, orders, closed forms, balance."""

from dataclasses import replace
from math import exp, inf, pi, sqrt

import numpy as np
import pytest
from heat_cases import RADIUS, THICKNESS, everything, member, plain, ramp, still, varying
from scipy.integrate import quad, solve_bvp, solve_ivp
from scipy.sparse import coo_array
from scipy.special import erfc
from slopes import slopes

from meshes.sections import circle, rectangle, tube
from thermal.boundary import STEFAN_BOLTZMANN, Moment
from thermal.circumference import cardinal, half_cosine_loads
from thermal.description import (
    Description,
    Film,
    Fixed,
    Flux,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
    Source,
    Wall,
)
from thermal.line import facing
from thermal.pattern import Pattern, block_entries
from thermal.profiles import absorbing_widths
from thermal.sdirk import GAMMA
from thermal.solvers import build

SIGMA = STEFAN_BOLTZMANN
NOW = Moment(0.0, {})


def run(solver, end, windows=1, T=None, start=0.0):
    """State at ``end`` and the sum of each flow."""
    T = solver.initial() if T is None else T
    times = np.linspace(start, end, windows + 1)
    total = {}
    for t, h in zip(times[:-1], np.diff(times), strict=True):
        T, flows, why = solver.advance(T, t, h, np.zeros_like(T))
        assert why == ""
        total = {name: total.get(name, 0.0) + flow for name, flow in flows.items()}
    return T, total


def orders(errors):
    return np.log2(np.divide(errors[:-1], errors[1:]))


@pytest.mark.parametrize("n", [4, 6, 8, 10])
def test_cardinal_functions_interpolate_harmonics_with_their_slopes(n):
    values, slopes = cardinal(n)
    phi, points = pi / n * np.arange(2 * n), 2 * pi / n * np.arange(n)
    for m in range(n // 2 + 1):
        np.testing.assert_allclose(values @ np.cos(m * points), np.cos(m * phi), atol=1e-13)
        np.testing.assert_allclose(slopes @ np.cos(m * points), -m * np.sin(m * phi), atol=1e-12)
    for m in range(1, n // 2):
        np.testing.assert_allclose(values @ np.sin(m * points), np.sin(m * phi), atol=1e-13)
        np.testing.assert_allclose(slopes @ np.sin(m * points), m * np.cos(m * phi), atol=1e-12)


@pytest.mark.parametrize("n", [4, 6, 8])
@pytest.mark.parametrize("phase", [0.0, 0.4, -2.9])
def test_loads_of_parallel_rays_are_the_integrals(n, phase):
    loads = half_cosine_loads(n, np.array(phase))
    assert loads.sum() == pytest.approx(2.0, rel=1e-14)
    for k, load in enumerate(loads):

        def lit(phi, k=k):
            m = np.arange(1, n // 2)
            x = phi - 2 * pi * k / n
            c = 1 + 2 * np.cos(m * x).sum() + np.cos(n / 2 * phi) * (-1) ** k
            return c / n * max(0.0, np.cos(phi - phase))

        assert load == pytest.approx(quad(lit, phase - pi / 2, phase + pi / 2)[0], abs=1e-10)


def test_conduction_agrees_with_scikit_fem():
    """Powers against forms assembled by scikit-fem, angle by angle, with k(T)."""
    from skfem import Basis, BilinearForm, ElementLineP1, MeshLine, asm

    arm = member(length=0.8, elements=5, wall_points=6, material=varying())
    solver = build("line", Description((arm,)))
    T = 300.0 + 40.0 * np.random.default_rng(1).standard_normal(len(solver.x))
    values, slopes = cardinal(6)
    mesh = MeshLine(np.linspace(0.0, 0.8, 6)[None])
    gauss = Basis(mesh, ElementLineP1(), intorder=3)
    ends = Basis(mesh, ElementLineP1(), quadrature=(np.array([[0.0, 1.0]]), np.array([0.5, 0.5])))
    along = BilinearForm(lambda u, v, w: (120 + 0.5 * (w.T - 300)) * u.grad[0] * v.grad[0])
    around = BilinearForm(lambda u, v, w: (120 + 0.5 * (w.T - 300)) * u * v / RADIUS**2)
    area = arm.section.area / 12
    T_angle, slope_angle = T.reshape(6, 6) @ values.T, T.reshape(6, 6) @ slopes.T
    expected = np.zeros((6, 6))
    for m in range(12):
        K = asm(along, gauss, T=gauss.interpolate(T_angle[:, m]))
        C = asm(around, ends, T=ends.interpolate(T_angle[:, m]))
        expected -= area * np.outer(K @ T_angle[:, m], values[m])
        expected -= area * np.outer(C @ slope_angle[:, m], slopes[m])
    power, _ = solver.power(T, NOW)
    np.testing.assert_allclose(power, expected.ravel(), rtol=1e-11, atol=1e-11 * abs(power).max())


def test_tangent_is_the_derivative():
    solver = build("line", everything())
    T = solver.initial() + 20.0 * np.random.default_rng(2).standard_normal(len(solver.x))
    tau, t, step = 37.0, 2.5, 1e-3

    def balance(T):
        return (solver.space.heat(T) - tau * solver.power(T, Moment(t, {}))[0])[solver.free]

    unit = np.eye(len(T))[solver.free]
    columns = [(balance(T + step * u) - balance(T - step * u)) / (2 * step) for u in unit]
    solve = solver.factorise(T, Moment(t, {}), tau)
    tangent = np.linalg.inv(np.column_stack([solve(u) for u in np.eye(len(solver.free))]))
    np.testing.assert_allclose(tangent, np.array(columns).T, atol=1e-8 * abs(tangent).max())


def everywhere():
    """Everything, with mean and gradients of the bar and conditions on all faces."""
    d = everything()
    bar = replace(d.members[1], wall_points=3)
    conditions = [
        Film("bore", "boom", still(5.0), ramp(300.0, 330.0, 4.0), "inner"),
        Radiation("tip", "bar", 0.5, still(250.0), "end"),
        Flux("lamp", "bar", ramp(0.0, 400.0, 3.0), np.array([-1.0, 0.3, 0.2]), "end"),
        Flux("side", "bar", ramp(0.0, 400.0, 3.0), np.array([0.1, 0.3, 0.2])),
        Film("breeze", "boom", still(3.0), still(290.0), "start"),
        Source("inside", Place("bar"), still(3.0)),
    ]
    link = Link("strap", Place("boom"), Place("bar"), 0.4)
    return replace(d, members=(d.members[0], bar), links=(*d.links, link),
                   conditions=(*d.conditions, *conditions))  # fmt: skip


def test_tangent_with_all_faces_and_gradients_is_the_derivative():
    solver = build("line", everywhere())
    rng = np.random.default_rng(3)
    T, tau, t = solver.initial() + 20.0 * rng.standard_normal(len(solver.x)), 37.0, 2.5

    def balance(T):
        return solver.space.heat(T) - tau * solver.power(T, Moment(t, {}))[0]

    expected = slopes(balance, T, 0.1)[np.ix_(solver.free, solver.free)]
    b = rng.standard_normal(len(solver.free))
    found = solver.factorise(T, Moment(t, {}), tau)(b)
    np.testing.assert_allclose(expected @ found, b, atol=2e-8)


def test_heat_balance_with_all_faces_and_gradients_closes():
    solver = build("line", everywhere())
    T, rng = solver.initial(), np.random.default_rng(4)
    for i in range(10):
        heat = rng.uniform(0.0, 5.0, len(T))
        new, flows, why = solver.advance(T, 0.4 * i, 0.4, heat)
        assert why == ""
        stored = solver.energy(new) - solver.energy(T)
        largest = max(*map(abs, flows.values()), heat.sum())
        assert abs(sum(flows.values()) + heat.sum() - stored) < 1e-11 * largest
        T = new


def pattern_with_hubs(n, hubs, rng):
    """Rows, columns and values of a chain of blocks that hubs and a few links tie together."""
    chain = np.arange(n).reshape(-1, 4)
    blocks = [np.hstack([chain[:-1], chain[1:]])]
    blocks += [
        np.stack([np.full(60, hub), rng.integers(0, n, 60)], 1) for hub in n + np.arange(hubs)
    ]
    rows, columns = block_entries([*blocks, np.arange(n + hubs)[:, None]])
    values = rng.uniform(-1.0, 0.0, len(rows))
    values[-n - hubs :] = 80.0
    return rows, columns, values


@pytest.mark.parametrize("hubs", [0, 1, 5])
def test_solution_within_an_envelope_is_that_of_the_dense_matrix(hubs):
    """Unsymmetric matrices; hubs stand apart, given temperatures are left out."""
    rng = np.random.default_rng(hubs)
    n = 200 + hubs
    rows, columns, values = pattern_with_hubs(200, hubs, rng)
    shuffled = rng.permutation(n)
    rows, columns = shuffled[rows], shuffled[columns]
    free = np.setdiff1d(np.arange(n), shuffled[:13])
    pattern = Pattern(n, free, rows, columns)
    dense = np.zeros((n, n))
    np.add.at(dense, (rows, columns), values)
    dense = dense[np.ix_(free, free)]
    np.testing.assert_allclose(pattern.matrix(values).toarray(), dense, atol=1e-14)
    solve = pattern._within_band(values)
    assert solve is not None
    assert len(pattern._banded[0]._order.border) == hubs
    for _ in range(2):
        b = rng.standard_normal(len(free))
        np.testing.assert_allclose(solve(b), np.linalg.solve(dense, b), rtol=1e-10)


def test_matrices_that_need_pivots_are_left_to_superlu():
    """A zero on the diagonal: no pivot there, yet a solution; none at all gives nan."""
    n = 60
    rows = np.concatenate([np.arange(n), np.arange(n - 1), np.arange(1, n)])
    columns = np.concatenate([np.arange(n), np.arange(1, n), np.arange(n - 1)])
    values = np.concatenate([np.zeros(n), np.ones(n - 1), np.ones(n - 1)])
    pattern, b = Pattern(n, np.arange(n), rows, columns), np.arange(1.0, n + 1)
    matrix = pattern.matrix(values)
    assert pattern._within_band(values) is None
    np.testing.assert_allclose(matrix @ pattern.factorise(values)(b), b, rtol=1e-12)
    assert np.isnan(pattern.factorise(0.0 * values)(b)).all()


def test_large_models_use_the_same_matrix_in_sparse_form():
    arm = member(elements=60, wall_points=4, material=varying())
    solver = build(
        "line", Description((arm,), conditions=(Radiation("space", "arm", 0.9, still(4.0)),))
    )
    T = 300.0 + np.random.default_rng(3).standard_normal(len(solver.x))
    rows, columns = solver.space.entries()
    own = coo_array((solver.space.tangent(T, 10.0), (rows, columns)), shape=(len(T),) * 2)
    assert own.tocsr().nnz < 0.2 * len(T) ** 2
    matrix = own.toarray()
    rows, columns = solver._boundary.entries()
    np.add.at(matrix, (rows, columns), 10.0 * solver._boundary.slopes(T, NOW))
    b = np.ones(len(T))
    x = np.linalg.solve(matrix, b)
    np.testing.assert_allclose(solver.factorise(T, NOW, 10.0)(b), x, rtol=1e-10)


@pytest.mark.parametrize("material", [plain(), varying()])
def test_heat_balance_closes_to_round_off(material):
    """Everything at once: the flows and the heat given are what is stored."""
    solver = build("line", everything(material))
    T, rng = solver.initial(), np.random.default_rng(4)
    for i in range(30):
        heat = rng.uniform(0.0, 5.0, len(T))
        new, flows, why = solver.advance(T, 0.4 * i, 0.4, heat)
        assert why == ""
        stored = solver.energy(new) - solver.energy(T)
        largest = max(*map(abs, flows.values()), heat.sum())
        assert abs(sum(flows.values()) + heat.sum() - stored) < 1e-11 * largest
        T = new


def test_balance_of_a_jump_of_a_prescribed_temperature():
    step = Fixed("base", Place("arm", "start"), lambda t: 300.0 if t < 0 else 500.0)
    solver = build("line", Description((member(material=varying()),), conditions=(step,)))
    T, flows = run(solver, 5.0)
    stored = solver.energy(T) - solver.energy(solver.initial())
    assert flows["base"] == pytest.approx(stored, rel=1e-12)
    assert stored > 0.0


def test_steady_flow_through_a_bar_and_a_wall():
    """k A dT / L through the bar; the same leaves at the other end."""
    conditions = (
        Fixed("hot", Place("arm", "start"), still(400.0)),
        Fixed("cold", Place("arm", "end"), still(300.0)),
    )
    solver = build("line", Description((member(wall_points=4),), conditions=conditions))
    T, _ = run(solver, 1e8)
    _, flows = run(solver, 60.0, T=T)
    expected = 167.0 * 2 * pi * RADIUS * THICKNESS * 100.0 * 60.0
    assert flows["hot"] == pytest.approx(expected, rel=1e-9)
    assert flows["cold"] == pytest.approx(-expected, rel=1e-9)


def test_network_of_resistances():
    """Three bars from a hub to given temperatures: the hub takes their weighted mean."""
    bars = [member(f"bar{i}", 0.1, 2, start=(0, i, 0)) for i in range(3)]
    links = [Link(f"in{i}", Place("hub"), Place(f"bar{i}", "start"), 0.5) for i in range(3)]
    links += [Link("air", Place("bar2", "end"), still(350.0), 0.2)]
    ends = [Fixed(f"end{i}", Place(f"bar{i}", "end"), still(300.0 + 50 * i)) for i in range(2)]
    hub = Part("hub", np.zeros(3), plain(), 0.01, 300.0)
    solver = build("line", Description(bars, (hub,), links, ends))
    T, flows = run(solver, 1e5)
    r = 1 / 0.5 + 0.1 / (167.0 * 1e-4)
    conductances = np.array([1 / r, 1 / r, 1 / (r + 5.0)])
    expected = conductances @ [300.0, 350.0, 350.0] / conductances.sum()
    assert T[-1] == pytest.approx(expected, abs=1e-6)
    assert "in0" not in flows


def test_order_in_space_of_a_radiating_fin_with_varying_conductivity():
    """Steady fin against solve_bvp: order 2 in temperature and in the heat at the root."""
    length, section = 0.4, rectangle(0.002, 0.02)
    loss = 0.9 * SIGMA * section.outer_perimeter / section.area

    def slope(s, y):
        k = 120 + 0.5 * (y[0] - 300)
        return np.vstack([y[1] / k, loss * (y[0] ** 4 - 250.0**4)])

    s = np.linspace(0.0, length, 200)
    guess = np.vstack([np.full(200, 480.0), np.zeros(200)])
    exact = solve_bvp(slope, lambda a, b: [a[0] - 500, b[1]], s, guess, tol=1e-7, max_nodes=20000)
    assert exact.success
    errors, flow_errors = [], []
    for elements in (8, 16, 32):
        fin = member("fin", length, elements, 1, section, varying(), 400.0)
        conditions = (
            Fixed("root", Place("fin", "start"), still(500.0)),
            Radiation("space", "fin", 0.9, still(250.0)),
        )
        solver = build("line", Description((fin,), conditions=conditions))
        T, _ = run(solver, 1e6)
        _, flows = run(solver, 1e6 + 1.0, T=T, start=1e6)
        errors.append(np.abs(T - exact.sol(solver.x[:, 0])[0]).max())
        flow_errors.append(abs(flows["root"] + section.area * exact.sol(0.0)[1]))
    assert (orders(errors) > 1.9).all()
    assert (orders(flow_errors) > 1.8).all()
    assert errors[-1] < 1e-3 * 250.0


def test_order_in_time_with_varying_properties_radiation_and_moving_boundary():
    """Against the same equations in space, integrated by Radau."""
    fin = member("fin", 0.1, 4, 1, rectangle(0.002, 0.02), varying(), 400.0)
    conditions = (
        Fixed("root", Place("fin", "start"), lambda t: 400.0 + 80.0 * np.sin(0.1 * t)),
        Radiation("space", "fin", 0.9, lambda t: 250.0 + 5.0 * t),
        Flux("light", "fin", lambda t: 3e4 * np.sin(0.2 * t) ** 2),
    )
    solver = build("line", Description((fin,), conditions=conditions), Settings(tolerance=inf))
    mass = 2700.0 * fin.section.area * 0.025 * np.array([1, 1, 1, 0.5])

    def rate(t, free):
        T = np.concatenate([[400.0 + 80.0 * np.sin(0.1 * t)], free])
        c = 800 + 1.2 * (free - 300) + 2e-3 * (free - 300) ** 2
        return solver.power(T, Moment(t, {}))[0][1:] / (mass * c)

    exact = solve_ivp(rate, (0, 20), np.full(4, 400.0), "Radau", rtol=1e-10, atol=1e-9).y[:, -1]
    errors = [np.abs(run(solver, 20.0, n)[0][1:] - exact).max() for n in (40, 80, 160)]
    assert (orders(errors) > 1.9).all()
    assert errors[-1] < 0.02


def test_one_window_is_as_accurate_as_its_tolerance():
    """Radiative cooling of a plate (closed form), in one long window and in many."""
    plate = member("plate", 0.1, 1, 1, rectangle(1e-3, 0.1), plain(), 473.15)
    cooling = Radiation("space", "plate", 0.8, still(0.0))
    loss = 3 * 0.8 * SIGMA * plate.section.outer_perimeter / (2700 * 896 * plate.section.area)
    exact = (473.15**-3 + loss * 3600.0) ** (-1 / 3)
    for tolerance in (1e-1, 1e-2, 1e-3):
        solver = build("line", Description((plate,), conditions=(cooling,)), Settings(tolerance))
        assert np.abs(run(solver, 3600.0)[0] - exact).max() < 10 * tolerance
    assert np.abs(run(solver, 3600.0, 50)[0] - exact).max() < 1e-2


def test_error_estimate_is_the_error_of_a_linear_decay():
    """The step that the tolerance just allows makes an error of that size."""
    block = Part("block", np.zeros(3), plain(), 1.0, 400.0)
    air = Link("air", Place("block"), still(300.0), 8.96)  # rate 0.01 1/s
    h = 10.0
    exact = 300.0 + 100.0 * exp(-0.01 * h)
    single = build("line", Description((), (block,), (air,)), Settings(inf))
    error = abs(run(single, h)[0][0] - exact)
    cautious = build("line", Description((), (block,), (air,)), Settings(0.8 * error))
    bold = build("line", Description((), (block,), (air,)), Settings(1.25 * error))
    assert run(bold, h)[0][0] == run(single, h)[0][0]
    assert run(cautious, h)[0][0] != run(single, h)[0][0]


def test_shock_is_damped_and_cools_nobody():
    """L-stability and mass lumping: no ringing after a jump, no station below its start."""
    step = Fixed("base", Place("arm", "start"), still(500.0))
    solver = build("line", Description((member(wall_points=4),), conditions=(step,)), Settings(inf))
    stiff, _ = run(solver, 1e12)
    np.testing.assert_allclose(stiff, 500.0, rtol=0.0, atol=1e-4)
    for h in (1e-3, 1.0, 30.0):
        T, _ = run(build("line", Description((member(wall_points=4),), conditions=(step,))), h)
        assert T.min() > 300.0 - 1e-9
        assert (np.diff(T[::4]) <= 1e-9).all()


def after_cold_shock(n, elements, fourier, settings):
    """Temperatures after 300 K met 200 K at the start, for ``fourier`` h^2 / D per step."""
    cold = Fixed("cold", Place("arm", "start"), still(200.0))
    section = rectangle(0.02, 0.01) if n == 3 else None
    arm = member(elements=elements, wall_points=n, section=section, material=varying())
    solver = build("line", Description((arm,), conditions=(cold,)), settings)
    step = fourier / elements**2 * 2700.0 * 896.0 / 167.0
    T, _, why = solver.advance(
        solver.initial(), 0.0, step * (settings.steps or 1), np.zeros(len(solver.x))
    )
    assert why == ""
    return T


@pytest.mark.parametrize("n", [1, 3, 4, 8])
@pytest.mark.parametrize("elements", [1, 7, 40])
def test_no_cold_shock_undershoots(n, elements):
    """Lumped at stations: backward Euler stays within the boundaries at any step, k(T) and c(T);
    SDIRK2 at any interval by its error control, within the tolerance."""
    for fourier in 10.0 ** np.arange(-6.0, 7.0, 3.0):
        for steps in (1, 3):
            T = after_cold_shock(n, elements, fourier, Settings(inf, "backward-euler", steps))
            assert 200.0 - 1e-10 < T.min() <= T.max() < 300.0 + 1e-10
    for fourier in (1e-6, 0.1, 1e3):
        T = after_cold_shock(n, elements, fourier, Settings(1e-3))
        assert 200.0 - 1e-3 < T.min() <= T.max() < 300.0 + 1e-3


def test_equal_steps_of_sdirk2_undershoot_only_when_they_are_long():
    """Its amplification (1 + (1 - 2 gamma) z) / (1 - gamma z)^2 turns negative below z = -2.41;
    the stiffest mode of a bar has z = -4 Fo. Without error control long steps undershoot."""
    for fourier in (0.01, 0.3, 0.6):
        for steps in (1, 3):
            T = after_cold_shock(1, 20, 0.69 * fourier, Settings(inf, "sdirk2", steps))
            assert 200.0 - 1e-10 < T.min() <= T.max() < 300.0 + 1e-10
    T = after_cold_shock(1, 20, 1e4, Settings(inf, "sdirk2", 1))
    assert 165.0 < T.min() < 190.0


def test_huge_step_of_a_decay_leaves_nothing():
    """Amplification at infinity is zero."""
    block = Part("block", np.zeros(3), plain(), 1.0, 400.0)
    air = Link("air", Place("block"), still(300.0), 8.96e12)
    T, _ = run(build("line", Description((), (block,), (air,)), Settings(inf)), 1.0)
    assert T[0] == pytest.approx(300.0, abs=1e-6)


@pytest.mark.parametrize("n", [4, 8])
def test_harmonics_of_the_circumference_decay_at_their_rate(n):
    """exp(-k m^2 t / (rho c R^2)) for every harmonic that the points can carry."""
    solver = build("line", Description((member(wall_points=n, elements=2),)), Settings(1e-7))
    phi = 2 * pi / n * np.arange(n)
    for m in range(1, n // 2 + 1):
        t = RADIUS**2 * 2700.0 * 896.0 / (167.0 * m**2)
        T, _ = run(solver, t, T=300.0 + 10.0 * np.tile(np.cos(m * phi), 3))
        np.testing.assert_allclose(T[:n], 300.0 + 10.0 * exp(-1) * np.cos(m * phi), atol=1e-5)


@pytest.mark.parametrize("n", [4, 8])
def test_sunlit_tube_reaches_the_closed_form(n):
    """Small flux on a radiating tube: mean and first harmonic of the linearised balance.

    Mean: q Ro / pi = 4 eps sigma T^3 Ro a0; first harmonic: q Ro / 2 = (k t / R + 4 eps sigma
    T^3 Ro) a1, per radian.
    """
    q, emissivity, outer = 1.0, 0.8, RADIUS + THICKNESS / 2
    conditions = (
        Flux("sun", "arm", still(q), np.array([0.0, -1.0, 0.0])),
        Radiation("space", "arm", emissivity, still(300.0)),
    )
    solver = build("line", Description((member(wall_points=n, elements=2),), conditions=conditions))
    T, _ = run(solver, 1e6)
    h = 4 * emissivity * SIGMA * 300.0**3
    mean = q / (pi * h)
    first = q * outer / 2 / (167.0 * THICKNESS / RADIUS + h * outer)
    assert T[:n].mean() - 300.0 == pytest.approx(mean, rel=1e-3)
    gradient = 2 / n * T[:n] @ np.cos(2 * pi / n * np.arange(n))
    assert gradient == pytest.approx(first, rel=1e-3)


def test_hot_spot_of_a_sunlit_tube_against_the_nonlinear_balance():
    """Thick flux, 32 points: temperature round the tube against solve_bvp."""
    q, eps, outer = 1361.0, 0.8, RADIUS + THICKNESS / 2
    factor = RADIUS * outer / (5.0 * THICKNESS)

    def slope(phi, y):
        absorbed = q * np.maximum(0.0, np.cos(phi))
        return np.vstack([y[1], factor * (eps * SIGMA * (y[0] ** 4 - 4.0**4) - absorbed)])

    phi = np.linspace(0.0, pi, 400)
    guess = np.vstack([np.full(400, 300.0), np.zeros(400)])
    exact = solve_bvp(slope, lambda a, b: [a[1], b[1]], phi, guess, tol=1e-8, max_nodes=50000)
    arm = member(wall_points=32, elements=1, material=plain(conductivity=5.0))
    conditions = (
        Flux("sun", "arm", still(q), np.array([0.0, -1.0, 0.0])),
        Radiation("space", "arm", eps, still(4.0)),
    )
    T, flows = run(build("line", Description((arm,), conditions=conditions)), 1e7)
    np.testing.assert_allclose(T[:17], exact.sol(2 * pi / 32 * np.arange(17))[0], atol=0.05)
    assert flows["sun"] == pytest.approx(q * 2 * outer * 1.0 * 1e7, rel=1e-9)


@pytest.mark.parametrize(
    ("section", "n", "width"),
    [
        (tube(RADIUS, THICKNESS), 4, 2 * RADIUS + THICKNESS),
        (tube(RADIUS, THICKNESS), 10, 2 * RADIUS + THICKNESS),
        (tube(RADIUS, THICKNESS), 1, 2 * RADIUS + THICKNESS),
        (circle(0.03), 1, 0.06),
    ],
)
@pytest.mark.parametrize("direction", [(0, 0, 1), (1, -2, 0.7), (3, 1, 1), (1, 0, 0)])
def test_round_members_absorb_their_shadow(section, n, width, direction):
    arm = member(wall_points=n, section=section)
    widths = absorbing_widths(arm.section, n, facing(arm, np.array(direction)))
    sine = np.linalg.norm(np.cross(direction, [1, 0, 0])) / np.linalg.norm(direction)
    np.testing.assert_allclose(widths.sum(axis=1), width * sine, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, 2.5])
def test_rectangles_absorb_their_shadow(angle):
    """The shadow is the extent of the corners across the rays."""
    arm = member(section=rectangle(0.04, 0.01))
    rays = np.array([0.0, np.cos(angle), np.sin(angle)])
    corners = arm.section.outline(4) @ [-np.sin(angle), np.cos(angle)]
    widths = absorbing_widths(arm.section, 1, facing(arm, rays))
    np.testing.assert_allclose(widths, np.ptp(corners), rtol=1e-12)


def test_uniform_flux_enters_over_the_whole_contour():
    solver = build(
        "line", Description((member(wall_points=4),), conditions=(Flux("glow", "arm", still(7.0)),))
    )
    T, flows = run(solver, 10.0)
    assert flows["glow"] == pytest.approx(70.0 * 2 * pi * (RADIUS + THICKNESS / 2), rel=1e-12)
    assert np.ptp(T) < 1e-9


def test_wall_is_linear_across_the_section_and_along_the_stretch():
    hot, cold = (ramp(300, 400, 10), ramp(300, 360, 10)), (ramp(300, 320, 10), ramp(300, 310, 10))
    side = np.array([5.0, 1.0, 1.0])  # its part along the member does not count
    wall = Wall("sun", "arm", 0.25, 1.0, side, hot, cold)
    solver = build("line", Description((member(wall_points=6),), conditions=(wall,)))
    T, _ = run(solver, 5.0)
    x = solver.x[12:]
    along = (x[:, 0] - 0.25) / 0.75
    mean = (1 - along) * 330 + along * 317.5
    half = (1 - along) * 20 + along * 12.5
    across = (x[:, 1] + x[:, 2]) / (np.sqrt(2) * RADIUS)
    np.testing.assert_allclose(T[12:], mean + half * across, atol=1e-10)
    assert np.abs(T[:6] - 300).max() < np.abs(T[12:18] - 300).max()


def test_wall_of_a_bar_gives_its_mean():
    wall = Wall(
        "sun", "arm", 0.5, 0.5, np.array([0, 1, 0]), (still(400), still(0)), (still(300), still(0))
    )
    solver = build("line", Description((member(),), conditions=(wall,)))
    T, _ = run(solver, 1.0)
    assert T[4] == pytest.approx(350.0, abs=1e-10)
    assert T[3] < 350.0


def test_link_spreads_its_heat_evenly_over_the_end_section():
    hub = Part("hub", np.zeros(3), plain(), 1.0, 350.0)
    link = Link("fitting", Place("hub"), Place("arm", "end"), 2.0)
    arm = member(wall_points=4)
    solver = build("line", Description((arm,), (hub,), (link,)))
    T = solver.initial()
    T[-5:-1] = [310.0, 300.0, 290.0, 300.0]
    even = build("line", Description((arm,), (hub,))).power(T, NOW)[0]
    np.testing.assert_allclose(solver.power(T, NOW)[0][-5:-1] - even[-5:-1], 25.0, rtol=1e-10)


def test_heat_given_to_a_node_arrives():
    """100 J on a part of 2 kg; the sum of flows knows nothing of it."""
    hub = Part("hub", np.zeros(3), plain(), 2.0, 300.0)
    solver = build("line", Description((), (hub,)))
    T, flows, why = solver.advance(solver.initial(), 0.0, 1.0, np.array([100.0]))
    assert (why, flows) == ("", {})
    assert T[0] == pytest.approx(300.0 + 100.0 / (2.0 * 896.0), rel=1e-12)


def test_semi_infinite_bar_after_a_step_and_under_a_flux():
    """erfc(x / 2 sqrt(D t)); surface rise 2 q sqrt(D t / pi) / k."""
    diffusivity = 167.0 / (2700.0 * 896.0)
    bar = member("bar", 0.1, 100)
    step = build(
        "line",
        Description((bar,), conditions=(Fixed("face", Place("bar", "start"), still(301.0)),)),
    )
    T, _ = run(step, 1.0)
    assert T[10] - 300.0 == pytest.approx(erfc(0.01 / (2 * sqrt(diffusivity))), rel=3e-3)
    flux = build(
        "line", Description((bar,), conditions=(Source("face", Place("bar", "start"), still(1.0)),))
    )
    T, _ = run(flux, 1.0)
    assert T[0] - 300.0 == pytest.approx(2e4 * sqrt(diffusivity / pi) / 167.0, rel=2e-3)


def test_reason_names_the_member_and_the_property_whose_range_was_left():
    arm = member(wall_points=4, material=varying(200.0, 320.0))
    heater = Source("heater", Place("arm", "end"), still(500.0))
    solver = build("line", Description((arm,), conditions=(heater,)))
    _, _, why = solver.advance(solver.initial(), 0.0, 100.0, np.zeros(len(solver.x)))
    assert "'arm' left the range of" in why
    assert "200 K to 320 K" in why
    assert why.startswith("t = ")


def test_range_is_watched_between_the_wall_points_too():
    """Hot side between two points: they stay below the limit, the wall between them does not."""
    hot, cold = (still(321.0),) * 2, (still(279.0),) * 2
    wall = Wall("sun", "arm", 0.0, 1.0, np.array([0.0, 1.0, 1.0]), hot, cold)
    arm = member(wall_points=4, material=varying(200.0, 320.0))
    solver = build("line", Description((arm,), conditions=(wall,)))
    _, _, why = solver.advance(solver.initial(), 0.0, 1.0, np.zeros(len(solver.x)))
    assert "left the range of" in why


def test_cooling_below_absolute_zero_is_refused():
    cooler = Source("cooler", Place("hub"), still(-1e4))
    hub = Part("hub", np.zeros(3), plain(), 1.0, 300.0)
    solver = build("line", Description((), (hub,), conditions=(cooler,)))
    _, _, why = solver.advance(solver.initial(), 0.0, 100.0, np.zeros(1))
    assert "'hub' fell below 0 K" in why


@pytest.mark.parametrize("start", [-1.0, 1.0])
def test_history_without_a_number_is_a_reason(start):
    source = Source("broken", Place("hub"), lambda t: float("nan") if t > start else 0.0)
    hub = Part("hub", np.zeros(3), plain(), 1.0, 300.0)
    solver = build("line", Description((), (hub,), conditions=(source,)))
    _, _, why = solver.advance(solver.initial(), 0.0, 2.0, np.zeros(1))
    assert "source 'broken': its power is not a number" in why


def test_members_of_one_mesh_do_not_touch_without_a_link():
    near, far = member("near", initial=300.0), member("far", initial=400.0, start=(1, 0, 0))
    solver = build("line", Description((near, far)))
    T, _ = run(solver, 1e4)
    np.testing.assert_allclose(T, solver.initial(), rtol=1e-13)


def test_steps_follow_a_jump_of_a_flux_within_the_window():
    """Energy enters by the history, not by its value at the stages alone."""
    step = Source("heater", Place("hub"), lambda t: 0.0 if t < 0.3 else 1000.0)
    hub = Part("hub", np.zeros(3), plain(), 1.0, 300.0)
    solver = build("line", Description((), (hub,), conditions=(step,)))
    _, flows = run(solver, 1.0)
    assert flows["heater"] == pytest.approx(700.0, abs=5.0)
    assert GAMMA * 1000.0 - 700.0 < -5.0  # which one step would have made of it
