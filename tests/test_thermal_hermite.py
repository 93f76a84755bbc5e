"""Heat on members by cubic functions: exactness, order, tangent, balance, behaviour at a shock."""

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest
from heat_cases import everything, member, plain, ramp, still, varying
from slopes import slopes

from meshes.sections import circle, rectangle
from thermal.boundary import STEFAN_BOLTZMANN, Moment
from thermal.description import (
    Description,
    Field,
    Film,
    Fixed,
    Irradiation,
    Place,
    Radiation,
    Settings,
    Side,
    Source,
    Wall,
)
from thermal.hermite_terms import GAUSS, shapes
from thermal.solvers import build

NOW = Moment(0.0, {})
BAR = rectangle(0.002, 0.02)
SEVENTHS = np.linspace(0.0, 1.0, 8)


def uneven(m, power=1.3):
    """The same straight member with stations closer at its start."""
    t = np.linspace(0.0, 1.0, len(m.points)) ** power
    return replace(m, points=m.points[0] + t[:, None] * (m.points[-1] - m.points[0]))


def cubic_at(arm, solver, T, xi=SEVENTHS):
    """Positions (e, x) [m] and temperatures (e, x, N) within the elements of the one member."""
    steps = np.diff(arm.points[:, 0])
    along = shapes(xi, steps / steps.mean())[0]
    dofs = solver.space._dofs(arm)
    return arm.points[:-1, :1] + steps[:, None] * xi, along @ T[dofs]


def settled(solver, outside=None):
    T, _, why = solver.steady(solver.initial(), 0.0, outside)
    assert why == ""
    return T


def both_ends(first, last, name="arm"):
    return (
        Fixed("first", Place(name, "start"), still(first)),
        Fixed("last", Place(name, "end"), still(last)),
    )


def orders(errors):
    return np.log2(np.divide(errors[:-1], errors[1:]))


def test_functions_of_temperatures_sum_to_one_and_of_slopes_rise_by_them():
    """T = B = 1 is constant; B - T = L/3 dT/ds makes a straight line; d/dxi by differences."""
    ratio = np.array([0.6, 1.0, 1.7])
    H, D = shapes(GAUSS, ratio)
    np.testing.assert_allclose(H.sum(axis=-1), 1.0, rtol=1e-14)
    for r, h, d in zip(ratio, H, D, strict=True):
        line = np.array([0.0, 1.0 / 3.0, r, r + 1.0 / 3.0])  # in units of the mean length
        np.testing.assert_allclose(h @ line, r * GAUSS, rtol=1e-13)
        np.testing.assert_allclose(d @ line, r, rtol=1e-13)
    difference = (shapes(GAUSS + 1e-6, ratio)[0] - shapes(GAUSS - 1e-6, ratio)[0]) / 2e-6
    np.testing.assert_allclose(D, difference, atol=1e-8)


@pytest.mark.parametrize("solid", [False, True])
def test_tangent_is_the_derivative(solid):
    """Everything at once, with k(T) and c(T); also with mean and gradients of a bar."""
    d = everything()
    if solid:
        bar = replace(d.members[1], wall_points=3)
        d = replace(d, members=(uneven(d.members[0]), bar))
    solver = build("hermite", d)
    rng = np.random.default_rng(2)
    T, tau, t = solver.initial() + 20.0 * rng.standard_normal(len(solver.x)), 37.0, 2.5

    def balance(T):
        return solver.space.heat(T) - tau * solver.power(T, Moment(t, {}))[0]

    expected = slopes(balance, T, 0.1)[np.ix_(solver.free, solver.free)]
    solve = solver.factorise(T, Moment(t, {}), tau)
    b = rng.standard_normal(len(solver.free))
    np.testing.assert_allclose(expected @ solve(b), b, atol=2e-8)


@pytest.mark.parametrize("material", [plain(), varying()])
def test_heat_balance_closes_to_round_off(material):
    d = everything(material)
    bar = replace(d.members[1], wall_points=3)
    solver = build("hermite", replace(d, members=(uneven(d.members[0]), bar)))
    T, rng = solver.initial(), np.random.default_rng(4)
    for i in range(15):
        heat = rng.uniform(0.0, 5.0, len(T))
        new, flows, why = solver.advance(T, 0.4 * i, 0.4, heat)
        assert why == ""
        stored = solver.energy(new) - solver.energy(T)
        largest = max(*map(abs, flows.values()), heat.sum())
        assert abs(sum(flows.values()) + heat.sum() - stored) < 1e-11 * largest
        T = new


def test_steady_cubic_is_exact_on_uneven_elements():
    """Flux density linear along a bar: k A T'' = - p q, T a cubic with both ends given."""
    bar = uneven(member(elements=5, section=BAR))
    light = Irradiation("light", "arm")
    solver = build("hermite", Description((bar,), conditions=(*both_ends(300.0, 340.0), light)))
    q = np.concatenate(
        [(50.0 + 900.0 * block.points[..., 0]).ravel() for block in solver.irradiated["light"]]
    )
    s, T = cubic_at(bar, solver, settled(solver, {"light": q}))
    f = BAR.outer_perimeter / (167.0 * BAR.area)
    particular = -f * (50.0 * s**2 / 2 + 900.0 * s**3 / 6)
    slope = 40.0 + f * (50.0 / 2 + 900.0 / 6)
    np.testing.assert_allclose(T[..., 0], 300.0 + slope * s + particular, rtol=1e-12)


def test_order_four_of_a_cooled_fin():
    """Convection along a fin: cosh; between the stations too."""
    m = np.sqrt(0.5 * BAR.outer_perimeter / (167.0 * BAR.area))
    errors = []
    for elements in (8, 16, 32):
        fin = member(elements=elements, section=BAR)
        air = Film("air", "arm", still(0.5), still(300.0))
        root = Fixed("root", Place("arm", "start"), still(400.0))
        solver = build("hermite", Description((fin,), conditions=(root, air)))
        s, T = cubic_at(fin, solver, settled(solver))
        exact = 300.0 + 100.0 * np.cosh(m * (1.0 - s)) / np.cosh(m)
        errors.append(np.abs(T[..., 0] - exact).max())
    assert (orders(errors) > 3.7).all()
    assert errors[-1] < 1e-5


def test_order_four_with_varying_conductivity_and_radiation():
    """Manufactured: T = 400 + 60 sin(3 s) asks for a flux density through the outline.

    Between the stations, 8 cubics are better than 64 linear elements.
    """

    def exact(s):
        return 400.0 + 60.0 * np.sin(3.0 * s)

    def density(s):
        T, slope, bend = exact(s), 180.0 * np.cos(3.0 * s), -540.0 * np.sin(3.0 * s)
        spread = 0.5 * slope**2 + (120.0 + 0.5 * (T - 300.0)) * bend
        radiated = 0.9 * STEFAN_BOLTZMANN * (T**4 - 250.0**4)
        return radiated - BAR.area / BAR.outer_perimeter * spread

    def error(name, elements):
        arm = member(elements=elements, section=BAR, material=varying(), initial=400.0)
        ends = both_ends(exact(0.0), exact(1.0))
        space, light = Radiation("space", "arm", 0.9, still(250.0)), Irradiation("light", "arm")
        solver = build(name, Description((arm,), conditions=(*ends, space, light)))
        q = [density(block.points[..., 0]).ravel() for block in solver.irradiated["light"]]
        T = settled(solver, {"light": np.concatenate(q)})
        if name == "line":
            middles = 0.5 * (solver.x[1:, 0] + solver.x[:-1, 0])
            return np.abs(0.5 * (T[1:] + T[:-1]) - exact(middles)).max()
        s, found = cubic_at(arm, solver, T)
        return np.abs(found[..., 0] - exact(s)).max()

    errors = [error("hermite", n) for n in (4, 8, 16, 32)]
    assert (orders(errors)[1:] > 3.8).all()
    assert errors[1] < error("line", 64)


@pytest.mark.parametrize("scheme", ["crank-nicolson", "sdirk2"])
def test_order_four_of_a_transient(scheme):
    """Modes of a bar between given ends decay exp(-D m^2 pi^2 t); space dominates the error."""
    D, errors = 167.0 / (2700.0 * 896.0), []
    t = 0.05 / (D * pi**2)
    for elements in (4, 8, 16):
        arm = member(elements=elements)
        d = Description((arm,), conditions=both_ends(300.0, 300.0))
        solver = build("hermite", d, Settings(scheme=scheme, steps=400))
        x, h = arm.points[:, 0], 1.0 / elements
        B = 300.0 + 20.0 * (np.sin(3 * pi * x) + h * pi * np.cos(3 * pi * x))
        T = np.concatenate([300.0 + 20.0 * np.sin(3 * pi * x), B])
        end, _, why = solver.advance(T, 0.0, t, np.zeros_like(T))
        assert why == ""
        s, found = cubic_at(arm, solver, end)
        exact = 300.0 + 20.0 * np.exp(-9 * 0.05) * np.sin(3 * pi * s)
        errors.append(np.abs(found[..., 0] - exact).max())
    assert (orders(errors) > 3.6).all()


def test_a_stretch_of_wall_is_linear_and_leaves_a_kink_at_its_ends():
    """Bar held in its middle: straight lines of three slopes, exactly, on uneven elements."""
    ends = (still(400.0), still(380.0))
    wall = Wall("belt", "arm", 0.3, 0.7, None, ends, ends)
    bar = member(elements=10)
    points = bar.points.copy()
    points[[1, 5, 8], 0] += [0.02, -0.03, 0.01]
    bar = replace(bar, points=points)
    solver = build("hermite", Description((bar,), conditions=(*both_ends(300.0, 310.0), wall)))
    s, T = cubic_at(bar, solver, settled(solver))
    exact = np.interp(s, [0.0, 0.3, 0.7, 1.0], [300.0, 400.0, 380.0, 310.0])
    np.testing.assert_allclose(T[..., 0], exact, rtol=1e-11)
    _, flows, _ = solver.advance(settled(solver), 0.0, 1.0, np.zeros(len(solver.x)))
    kA = 167.0 * 1e-4
    assert flows["first"] == pytest.approx(-kA * 100.0 / 0.3, rel=1e-8)
    assert flows["belt"] == pytest.approx(kA * (100.0 / 0.3 + 70.0 / 0.3), rel=1e-8)


def test_a_field_that_is_cubic_is_held_as_it_is():
    def field(x, t):
        return 300.0 + t + 40.0 * x[:, 0] ** 3 - 30.0 * x[:, 0] ** 2 + 500.0 * x[:, 1]

    arm = uneven(member(elements=4, wall_points=8))
    solver = build("hermite", Description((arm,), conditions=(Field("file", "arm", field),)))
    T, _, why = solver.advance(solver.initial(), 0.0, 2.0, np.zeros(len(solver.x)))
    assert why == ""
    s, found = cubic_at(arm, solver, T)
    y = solver.x[:8, 1]
    exact = 302.0 + 40.0 * s**3 - 30.0 * s**2
    np.testing.assert_allclose(found, exact[..., None] + 500.0 * y, rtol=1e-12)


def test_agrees_with_fine_lines_on_everything():
    """Members of both kinds, parts, links, radiation: fine lines converge to few cubics."""

    def solve(name, factor):
        d = everything(varying())
        boom = member("boom", 2.0, 20 * factor, 4, material=varying(), initial=310.0)
        bar = member("bar", 0.5, 3 * factor, material=varying(), section=circle(0.02),
                     start=(2.0, 0.0, 0.0))  # fmt: skip
        solver = build(name, replace(d, members=(boom, bar)), Settings(1e-4))
        T, _, why = solver.advance(solver.initial(), 0.0, 600.0, np.zeros(len(solver.x)))
        assert why == ""
        ends = [T[solver.regions["boom"][-4:]], T[solver.regions["bar"][[0, -1]]]]
        return np.concatenate([*ends, T[solver.regions["hub"]]])

    cubic = solve("hermite", 1)
    errors = [np.abs(solve("line", n) - cubic).max() for n in (1, 2, 4)]
    assert (orders(errors) > 1.7).all()
    assert errors[-1] < 0.03


def shock(scheme, fourier, count):
    """Highest and lowest temperature, at stations and anywhere, of the jump from 300 K to 200 K.

    count steps of ``fourier`` h^2 / D
    """
    arm, h = member(elements=16), 1.0 / 16
    cold = Fixed("cold", Place("arm", "start"), still(200.0))
    d = Description((arm,), conditions=(cold,))
    solver = build("hermite", d, Settings(scheme=scheme, steps=count))
    end = count * fourier * h**2 * 2700.0 * 896.0 / 167.0
    T, _, why = solver.advance(solver.initial(), 0.0, end, np.zeros(len(solver.x)))
    assert why == ""
    inside, stations = cubic_at(arm, solver, T, np.linspace(0.0, 1.0, 41))[1], T[:17]
    return (stations.max() - 3e2) / 1e2, (inside.max() - 3e2) / 1e2, (2e2 - inside.min()) / 1e2


def test_a_shock_that_the_mesh_does_not_resolve_overshoots():
    """Between the first stations, by 17 % of the jump; at the stations by less than 1 %.

    It is gone once heat has spread over a third of an element (Fourier number 0.1). The lumped
    storage of lines has none of it.
    """
    for scheme in ("backward-euler", "sdirk2"):
        sudden = np.array([shock(scheme, 1e-5, 1), shock(scheme, 1e-3, 1), shock(scheme, 1e-3, 3)])
        assert 0.16 < sudden[0, 1] < 0.17
        assert (sudden[:, 1] < 0.17).all()
        later = np.array([shock(scheme, 0.1, n) for n in (1, 3)])
        assert (later[:, 1] < 0.01).all()
        every = np.concatenate([sudden, later])
        assert (every[:, 0] < 0.01).all()
        assert (every[:, 2] < 1e-9).all()


def test_slopes_are_in_no_region_and_start_level():
    solver = build("hermite", Description((member(elements=4, wall_points=4),)))
    assert list(solver.regions) == ["arm"]
    np.testing.assert_array_equal(solver.regions["arm"], np.arange(20))
    assert len(solver.x) == 40
    np.testing.assert_array_equal(solver.x[20:], solver.x[:20])
    _, T = cubic_at(member(elements=4, wall_points=4), solver, solver.initial())
    np.testing.assert_allclose(T, 300.0, rtol=1e-15)


def test_sources_spread_by_volume_warm_evenly():
    """Heat given to all of a bar by volume leaves no slope."""
    bar = uneven(member(elements=5))
    heater = Source("heater", Place("arm"), ramp(50.0, 50.0, 1.0))
    solver = build("hermite", Description((bar,), conditions=(heater,)), Settings(inf))
    T, flows, _ = solver.advance(solver.initial(), 0.0, 20.0, np.zeros(len(solver.x)))
    rise = 1000.0 / (2700.0 * 896.0 * 1e-4)
    np.testing.assert_allclose(T, 300.0 + rise, rtol=1e-12)
    assert flows["heater"] == pytest.approx(1000.0, rel=1e-13)


def test_uniform_flux_enters_every_element_by_its_length():
    arm = uneven(member(elements=3, wall_points=4))
    space = build("hermite", Description((arm,))).space
    loads = space.absorbing(Side("arm"), None)
    assert loads.sum() == pytest.approx(arm.section.outer_perimeter, rel=1e-13)
    rays = np.array([0.2, 0.5, -1.0])
    lit = space.absorbing(Side("arm"), rays)
    sine = np.hypot(0.5, 1.0) / np.linalg.norm(rays)
    assert lit.sum() == pytest.approx(arm.section.height * sine, rel=1e-13)
