"""Exchange between grey faces: closed forms, balance, tangent, tubes inside."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from heat_cases import member, plain, still

from meshes.sections import tube
from meshes.surfaces import plate as rectangle
from thermal.boundary import Moment
from thermal.description import (
    Description,
    Enclosure,
    Fixed,
    Flux,
    Part,
    Place,
    Radiation,
    Sheet,
    Side,
)
from thermal.discretisation import Block
from thermal.enclosure import enclosure, problems
from thermal.heat import Heat
from thermal.lumps import LumpSpace
from thermal.solvers import build
from thermal.view_factors import exchange_areas, polygon_areas

SIGMA = 5.670374419e-8
NOW = Moment(0.0, {})


def lumps(areas):
    """A face of one point for each area; temperature i is that of face i."""
    return [
        [
            Block(
                np.array([[i]]), np.ones((1, 1)), np.array([[area]]), np.zeros((1, 1, 3)),
                np.zeros((1, 1, 3)), np.empty((1, 0, 3)),
            )
        ]
        for i, area in enumerate(areas)
    ]  # fmt: skip


def given(areas, factors, emissivities, sink=None):
    sides = [Side(f"s{i}") for i in range(len(areas))]
    return enclosure(
        Enclosure("gap", sides, emissivities, np.asarray(factors, float), sink), lumps(areas)
    )


def power(term, T):
    out = np.zeros(len(T))
    flows = term.add(np.asarray(T, float), NOW, out)
    assert len(flows) == len(term.names) == 1
    return out, flows[0]


def dense_slopes(term, T):
    rows, columns = term.entries()
    matrix = np.zeros((len(T), len(T)))
    np.add.at(matrix, (rows, columns), term.slopes(T, NOW))
    return matrix


def assert_tangent(term, T):
    """Slopes are minus the derivative of the power, by central differences."""
    n, step = len(T), 1e-3
    expected = np.zeros((n, n))
    for i, d in enumerate(step * np.eye(n)):
        expected[:, i] = -(power(term, T + d)[0] - power(term, T - d)[0]) / (2.0 * step)
    np.testing.assert_allclose(dense_slopes(term, T), expected, rtol=0, atol=1e-7)


# ------------------------------------------------------------------------------- closed forms


def test_grey_plates():
    out, flow = power(given([1.0, 1.0], [[0, 1], [1, 0]], [0.8, 0.5]), [400.0, 300.0])
    np.testing.assert_allclose(out, [-441.029121, 441.029121], rtol=2e-9)
    assert flow == 0.0


@pytest.mark.parametrize("ratio", [0.25, 0.5])
def test_one_convex_body_inside_another(ratio):
    """Concentric spheres (ratio of areas 1/4) and long cylinders (1/2)."""
    e1, e2, A1 = 0.3, 0.9, 0.7
    factors = [[0, 1], [ratio, 1 - ratio]]
    out, _ = power(given([A1, A1 / ratio], factors, [e1, e2]), [350.0, 120.0])
    q = A1 * SIGMA * (350.0**4 - 120.0**4) / (1 / e1 + ratio * (1 / e2 - 1))
    np.testing.assert_allclose(out, [-q, q], rtol=1e-12)


def test_triangular_duct_with_a_reradiating_side():
    """Equilateral: resistance between black 1 and grey 2 through space and insulated wall 3."""
    half = 0.5 * (1 - np.eye(3))
    e2 = 0.7
    term = given([1.0] * 3, half, [1.0, e2, 0.0])
    out, _ = power(term, [1200.0, 500.0, 300.0])
    resistance = (1 - e2) / e2 + 1 / (0.5 + 1 / (2 + 2))
    q = SIGMA * (1200.0**4 - 500.0**4) / resistance
    np.testing.assert_allclose(out, [-q, q, 0.0], rtol=1e-12, atol=1e-12)


def test_an_opening_is_the_sink():
    """Cavity with a hole: effective emissivity 1/(1 + (1/e - 1) A_hole/A)."""
    e, A, hole = 0.6, 2.0, 0.3
    term = given([A], [[1 - hole / A]], [e], still(100.0))
    out, flow = power(term, [400.0])
    exact = hole * SIGMA * (100.0**4 - 400.0**4) / (1 + (1 / e - 1) * hole / A)
    assert out[0] == pytest.approx(exact, rel=1e-12)
    assert flow == pytest.approx(out[0], rel=1e-14)
    dark, _ = power(given([A], [[1 - hole / A]], [e]), [400.0])
    assert dark[0] == pytest.approx(exact * 400.0**4 / (400.0**4 - 100.0**4), rel=1e-12)


def test_white_and_black_faces():
    white, flow = power(given([1.0, 2.0], [[0, 1], [0.5, 0.5]], [0.0, 0.0]), [400.0, 300.0])
    np.testing.assert_array_equal(white, 0.0)
    assert flow == 0.0
    lost, flow = power(given([1.0, 1.0], [[0, 0.5], [0.5, 0]], [0.0, 1.0]), [400.0, 300.0])
    assert lost[0] == 0.0
    assert lost[1] == pytest.approx(flow) == pytest.approx(-0.75 * SIGMA * 300.0**4)
    black, _ = power(given([1.0, 1.0], [[0, 1], [1, 0]], [1.0, 1.0]), [400.0, 300.0])
    assert black[1] == pytest.approx(SIGMA * (400.0**4 - 300.0**4), rel=1e-14)


# ---------------------------------------------------------------------------- balance, tangent


def random_enclosure(n, seed, sink=None):
    rng = np.random.default_rng(seed)
    exchange = rng.uniform(0.0, 1.0, (n, n))
    exchange += exchange.T
    areas = exchange.sum(1) * (1.0 if sink is None else rng.uniform(1.0, 1.5, n))
    return given(areas, exchange / areas[:, None], rng.uniform(0.0, 1.0, n), sink)


@pytest.mark.parametrize("sink", [None, still(200.0)])
def test_what_faces_exchange_is_the_flow_of_the_sink(sink):
    term, rng = random_enclosure(7, 1, sink), np.random.default_rng(2)
    for _ in range(20):
        out, flow = power(term, rng.uniform(50.0, 900.0, 7))
        assert abs(out.sum() - flow) < 1e-14 * np.abs(out).sum()
    out, _ = power(random_enclosure(7, 1), np.full(7, 300.0))
    np.testing.assert_allclose(out, 0.0, atol=1e-11)


def test_tangent():
    T = np.random.default_rng(3).uniform(200.0, 400.0, 5)
    assert_tangent(random_enclosure(5, 4, still(100.0)), T)


# --------------------------------------------------------------------------------- bad input


def test_problems_say_what_is_wrong():
    sides = [Side("a"), Side("b", "top")]
    grey = Enclosure("gap", sides, [0.5, 0.5], np.array([[0, 1], [1, 0.0]]))
    assert problems(grey, [1.0, 1.0]) == []

    def said(areas=(1.0, 1.0), **changed):
        c = Enclosure(**{**grey.__dict__, **changed})
        return " ".join(problems(c, areas))

    assert "row 1 of the view factors sums to 1.1" in said(
        view_factors=np.array([[0.1, 1], [1, 0]])
    )
    assert "must be the same both ways: 1 m^2 from face 1 to 2, 2 m^2 back" in said((1.0, 2.0))
    assert "positive or zero" in said(view_factors=np.array([[0, -1.0], [-1, 0]]))
    assert "shape (2, 2), got (1, 1)" in said(view_factors=np.eye(1))
    assert "emissivity must be 0 to 1, got 1.2" in said(emissivities=[1.2, 0.5])
    assert "one emissivity for each of 2 faces, got 1" in said(emissivities=[0.5])
    assert "face 'top' of 'b' has no area" in said((1.0, 0.0))
    assert "a face is named twice" in said(sides=[sides[0]] * 2)
    assert "one face or more" in said((), sides=[], emissivities=[], view_factors=None)


def test_enclosure_refuses_what_makes_no_sense():
    with pytest.raises(ValueError, match="same both ways"):
        given([1.0, 2.0], [[0, 1], [1, 0]], [0.5, 0.5])
    sides = [Side("hub"), Side("lid")]
    with pytest.raises(ValueError, match="no facets of face 'outer' of 'hub'"):
        enclosure(Enclosure("gap", sides, [0.5, 0.5]), lumps([1.0, 1.0]))


# ------------------------------------------------------------------------ with time integration


def test_two_lumps_come_to_their_common_temperature_and_keep_their_heat():
    parts = [Part(n, np.zeros(3), plain(), 1.0, T, 1.0) for n, T in (("a", 400.0), ("b", 300.0))]
    factors = np.array([[0.0, 1.0], [1.0, 0.0]])
    c = Enclosure("gap", [Side("a"), Side("b")], [0.8, 0.5], factors)
    d = Description((), parts, (), [c])
    solver = Heat(LumpSpace(d), d)
    T, flows, why = solver.advance(solver.initial(), 0.0, 1e5, np.zeros(2))
    assert why == ""
    np.testing.assert_allclose(T, 350.0, atol=1e-3)
    assert T.sum() == pytest.approx(700.0, rel=1e-13)
    assert flows["gap"] == 0.0
    held = Description((), parts, (), [c, Fixed("hot", Place("a"), still(500.0))])
    solver = Heat(LumpSpace(held), held)
    T, flows, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    np.testing.assert_allclose(T, 500.0, rtol=1e-9)


# ----------------------------------------------------------------------- facets seeing facets


def plate(n, z, up, first, size=1.0):
    """A face of n x n squares, one temperature each; polygons turn about the normal."""
    s = size * (np.arange(n) / n - 0.5)
    low = np.stack(np.meshgrid(s, s, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    flat = low + size / n * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])[:: 1 if up else -1]
    corners = np.concatenate([flat, np.full((n * n, 4, 1), z)], axis=2)
    normals = np.tile([0.0, 0.0, 1.0 if up else -1.0], (n * n, 1, 1))
    areas = np.full((n * n, 1), (size / n) ** 2)
    dofs = first + np.arange(n * n)[:, None]
    return [Block(dofs, np.ones((1, 1)), areas, corners.mean(1)[:, None], normals, corners)]


def facing(n, gap, emissivities, sink=None):
    sides = [Side("low", "top"), Side("high", "bottom")]
    faces = [plate(n, 0.0, True, 0), plate(n, gap, False, n * n)]
    return enclosure(Enclosure("gap", sides, emissivities, None, sink), faces)


def test_black_squares_one_apart_and_the_sink():
    """F = 0.199825 of equal opposite squares one apart (Howell C-11); the rest goes to the sink."""
    n = 3
    term = facing(n, 1.0, [1.0, 1.0], still(150.0))
    T = np.repeat([400.0, 300.0], n * n)
    out, flow = power(term, T)
    factor, e = 0.19982489569838744, SIGMA * np.array([400.0, 300.0, 150.0]) ** 4
    low = factor * (e[1] - e[0]) + (1 - factor) * (e[2] - e[0])
    high = factor * (e[0] - e[1]) + (1 - factor) * (e[2] - e[1])
    assert out[: n * n].sum() == pytest.approx(low, rel=1e-8)
    assert out[n * n :].sum() == pytest.approx(high, rel=1e-8)
    assert flow == pytest.approx(low + high, rel=1e-8)
    assert_tangent(facing(2, 1.0, [0.7, 0.2]), np.linspace(250.0, 350.0, 8))


def test_close_plates_are_grey_plates():
    term = facing(4, 1e-4, [0.8, 0.5])
    out, _ = power(term, np.repeat([400.0, 300.0], 16))
    assert out[16:].sum() == pytest.approx(441.029121, rel=1e-3)


def test_many_facets_without_the_coupling_in_the_tangent():
    """1152 facets: a step of Newton's method knows own emission only, and ends where it must."""
    n = 24
    term = facing(n, 0.2, [0.8, 0.5], still(200.0))
    assert not term.coupled
    area, heat_capacity, h = (1.0 / n) ** 2, 4838.0, 60.0  # 2 mm of aluminium
    start, changes = np.repeat([400.0, 300.0], n * n), []
    T = start.copy()
    for _ in range(12):
        residual = area * heat_capacity * (T - start) - h * power(term, T)[0]
        rows, columns = term.entries()
        np.testing.assert_array_equal(rows, columns)
        slopes = np.bincount(rows, term.slopes(T, NOW), len(T))
        change = residual / (area * heat_capacity + h * slopes)
        changes.append(np.abs(change).max())
        T -= change
    assert changes[-1] < 1e-11
    assert changes[4] / changes[3] < 0.1
    stored = area * heat_capacity * (T - start).sum()
    assert stored == pytest.approx(h * power(term, T)[1], rel=1e-12)


# ------------------------------------------------------------------------- inside of long tubes


def tube_face(stations, n, radius=0.05, kind="rings"):
    """Inner face of a straight tube along x: rows of points, or facets of one point each."""
    phi = 2.0 * np.pi / n * np.arange(n)
    normals = -np.stack([0 * phi, np.cos(phi), np.sin(phi)], axis=1)
    points = np.zeros((stations, n, 3)) - radius * normals
    points[..., 0] += 0.1 * np.arange(stations)[:, None]
    areas = np.full((stations, n), 0.1 * 2.0 * np.pi * radius / n)
    normals = np.broadcast_to(normals, points.shape)
    dofs = np.arange(stations * n)
    if kind == "rings":
        return [Block(dofs.reshape(-1, n), np.eye(n), areas, points, normals, np.empty((1, 0, 3)))]
    return [
        Block(
            dofs[:, None], np.ones((1, 1)), areas.reshape(-1, 1), points.reshape(-1, 1, 3),
            normals.reshape(-1, 1, 3), np.empty((1, 0, 3)),
        )
    ]  # fmt: skip


def inner(emissivity, face):
    return enclosure(Enclosure("inside", [Side("tube", "inner")], [emissivity]), [face])


def wave_loss(order, emissivity):
    """Emitted less absorbed, over sigma d(T^4), of harmonic ``order`` round a long grey tube.

    The kernel |sin(x/2)|/4 is summed here by a rule of its own.
    """
    x = (np.arange(200_000) + 0.5) * 2.0 * np.pi / 200_000
    seen = (0.25 * np.sin(0.5 * x) * np.cos(order * x)).mean() * 2.0 * np.pi
    assert seen == pytest.approx(1.0 / (1.0 - 4.0 * order**2), rel=1e-9)
    return emissivity * (1.0 - seen) / (1.0 - (1.0 - emissivity) * seen)


@pytest.mark.parametrize("emissivity", [1.0, 0.3])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_harmonic_round_a_tube_loses_what_the_integral_equation_says(order, emissivity):
    n = 96
    term, face = inner(emissivity, tube_face(2, n)), tube_face(2, n)[0]
    wave = np.tile(np.cos(order * 2.0 * np.pi / n * np.arange(n)), 2)
    T = (300.0**4 + 1e8 * wave) ** 0.25
    out, flow = power(term, T)
    loss = -(out @ wave) / (wave @ wave) / (SIGMA * 1e8 * face.areas[0, 0])
    assert loss == pytest.approx(wave_loss(order, emissivity), rel=4e-3)
    assert flow == 0.0
    assert abs(out.sum()) < 1e-12 * np.abs(out).sum()


def test_rings_are_found_by_temperatures_or_by_height():
    rows, single = tube_face(3, 16), tube_face(3, 16, kind="single")
    T = np.random.default_rng(5).uniform(250.0, 350.0, 48)
    np.testing.assert_allclose(
        power(inner(0.7, rows), T)[0], power(inner(0.7, single), T)[0], rtol=1e-11
    )
    out, _ = power(inner(0.7, rows), T)
    np.testing.assert_allclose(out.reshape(3, 16).sum(1), 0.0, atol=1e-12)
    assert_tangent(inner(0.7, single), T)
    np.testing.assert_array_equal(power(inner(0.0, rows), T)[0], 0.0)


def test_a_member_without_profile_has_nothing_to_exchange():
    face = tube_face(1, 1)[0]
    term = inner(0.5, [face])
    np.testing.assert_array_equal(power(term, [300.0])[0], 0.0)
    assert term.slopes(np.array([300.0]), NOW).size == term.entries()[0].size == 0


@pytest.mark.parametrize("name", ["line", "hermite", "wall", "lumped"])
def test_a_sunlit_tube_is_smoothed_by_exchange_inside(name):
    """Small harmonic q cos(phi): dT (k t/R^2 + h e_out + h e_in (4/(4 - e_in))) = q e1, linearised.

    The inside loses e (1 - l)/(1 - (1 - e) l) with l = -1/3 of what it emits: 4 e/(4 - e).
    """
    radius, thickness, q, e_in, e_out, n = 0.5, 5e-5, 1.0, 0.6, 0.8, 24
    phi = 2 * np.pi / n * np.arange(n)
    skin = member("boom", 5.0, 2, n, tube(radius, thickness), plain(), 300.0)
    conditions = (
        Flux("sun", "boom", still(q), np.array([0.0, -1.0, 0.0])),
        Radiation("space", "boom", e_out, still(300.0)),
        Enclosure("inside", [Side("boom", "inner")], [e_in]),
    )
    solver = build(name, Description((skin,), conditions=conditions))
    T, flows, why = solver.steady(solver.initial(), 0.0)
    assert why == ""
    assert flows["inside"] == 0.0
    h, outer, inner_radius = 4 * SIGMA * 300.0**3, radius + thickness / 2, radius - thickness / 2
    lost = 167.0 * thickness / radius + h * (e_out * outer + 4 * e_in / (4 - e_in) * inner_radius)
    wave = 2 / n * (T[solver.regions["boom"]][:n] - 300.0) @ np.cos(phi)
    assert wave == pytest.approx(0.5 * q * outer / lost, rel=1e-2)


# ------------------------------------------------------------------- facets of every solver


def boom_over_plate():
    """A warm tube over a cold plate, grey, with surroundings at 300 K."""
    boom = member("boom", 0.4, 3, 12, material=plain(), initial=400.0)
    flat = rectangle(0.4, 0.2, 8, 4)
    surface = replace(flat, points=flat.points + np.array([0.0, -0.1, -0.1]))
    sheet = Sheet("panel", surface, 1e-3, plain(), 300.0)
    sides = [Side("boom"), Side("panel", "top")]
    c = Enclosure("gap", sides, [0.9, 0.6], None, still(300.0))
    return Description((boom,), conditions=(c,), sheets=(sheet,))


def test_tube_over_a_plate_by_every_solver():
    """What is lost to the sink in 100 s, and the rise of the panel, agree; all heat is there."""
    lost, rise = {}, {}
    for name in ("line", "hermite", "wall", "lumped", "solid"):
        solver = build(name, boom_over_plate())
        start = solver.initial()
        T, flows, why = solver.advance(start, 0.0, 100.0, np.zeros(len(start)))
        assert why == ""
        stored = solver.energy(T) - solver.energy(start)
        assert abs(stored - flows["gap"]) < 1e-11 * solver.energy(start)
        lost[name] = flows["gap"]
        rise[name] = T[solver.regions["panel"]].mean() - 300.0
    assert list(lost.values()) == pytest.approx([lost["solid"]] * 5, rel=5e-3)
    assert list(rise.values()) == pytest.approx([rise["solid"]] * 5, rel=0.02), rise
    assert lost["solid"] < -5e3
    assert rise["solid"] > 5.0


def test_a_cylinder_over_a_strip():
    """Long black tube at height a over a strip from 0 to b: F = atan(b/a)/(2 pi) (Howell C-67)."""
    n, length, a, b = 16, 20.0, 0.1, 0.15
    phi = 2.0 * np.pi / n * (np.arange(n + 1) - 0.5)
    ring = 0.05 / np.cos(np.pi / n) ** 0.5 * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    tube_quads = [
        np.array([[0, *p], [0, *q], [length, *q], [length, *p]]) for p, q in pairwise(ring)
    ]
    strip = np.array([[0, 0, -a], [length, 0, -a], [length, b, -a], [0, b, -a]])
    exchange = exchange_areas([*tube_quads, strip])[-1, :-1].sum()
    area = polygon_areas(tube_quads).sum()
    assert exchange / area == pytest.approx(np.arctan(b / a) / (2 * np.pi), rel=1e-2)
