"""The heat network on its own, and against the finite elements."""

from itertools import pairwise
from math import exp, inf, pi, sqrt

import numpy as np
import pytest
from heat_cases import RADIUS, THICKNESS, everything, member, plain, still, varying
from scipy.integrate import quad, solve_ivp
from scipy.special import erfc

from meshes.sections import circle, rectangle
from thermal.boundary import Moment
from thermal.description import (
    Description,
    Fixed,
    Flux,
    Link,
    Part,
    Place,
    Radiation,
    Settings,
    Side,
    Source,
    Wall,
)
from thermal.line import LineHeat
from thermal.lump_faces import absorbing_arcs
from thermal.lumped import LumpedHeat, NetworkSpace
from thermal.network import cell_lengths


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
            a, b = (run(s(sunlit(n, elements)), end)[:-1] for s in (LineHeat, LumpedHeat))
            gaps.append(np.abs(a - b).max())
        assert (orders(gaps) > 1.6).all()
        assert gaps[-1] < 0.05


def test_network_and_finite_elements_agree_where_walls_are_given():
    """The main use: everything but the last stations is prescribed."""
    hot, cold = (lambda t: 300 + 4 * t, lambda t: 300 + t), (still(300.0), still(280.0))
    wall = Wall("sun", "arm", 0.2, 1.0, np.array([0, 1, 0]), hot, cold)
    d = Description((member(wall_points=4, material=varying()),), conditions=(wall,))
    a, b = run(LineHeat(d), 10.0, 10), run(LumpedHeat(d), 10.0, 10)
    assert np.abs(a - b).max() < 0.02
