"""View factors against closed forms (numbers as in Howell's catalogue), hidden ones among them."""

from itertools import pairwise
from math import atan, log, pi, sqrt

import numpy as np
import pytest

from thermal.view_factors import (
    adjusted,
    arc_factors,
    exchange_areas,
    polygon_areas,
    view_factors,
)


def rectangle(origin, u, v):
    """Seen from the side of u x v."""
    o, u, v = (np.asarray(x, float) for x in (origin, u, v))
    return np.array([o, o + u, o + u + v, o + v])


def split(quad, n, m):
    """A parallelogram in n x m."""
    u, v = (quad[1] - quad[0]) / n, (quad[3] - quad[0]) / m
    return [rectangle(quad[0] + i * u + j * v, u, v) for i in range(n) for j in range(m)]


def box(a, b, c, inside=True):
    x, y, z = a * np.eye(3)[0], b * np.eye(3)[1], c * np.eye(3)[2]
    far = x + y + z
    quads = [
        rectangle(0 * x, x, y), rectangle(0 * x, y, z), rectangle(0 * x, z, x),
        rectangle(far, -y, -x), rectangle(far, -z, -y), rectangle(far, -x, -z),
    ]  # fmt: skip
    return quads if inside else [q[::-1] for q in quads]


def disc(radius, z, up, n=256):
    """A polygon of the area of a circle."""
    phi = 2 * pi / n * np.arange(n)
    r = radius * sqrt(2 * pi / n / np.sin(2 * pi / n))
    corners = np.stack([r * np.cos(phi), r * np.sin(phi), np.full(n, z)], axis=1)
    return corners if up else corners[::-1]


def tube(radius, heights, n, inward):
    phi = 2 * pi / n * np.arange(n + 1)
    ring = radius * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    quads = []
    for low, high in pairwise(heights):
        for p, q in pairwise(ring):
            quad = np.array([[*p, low], [*q, low], [*q, high], [*p, high]])
            quads.append(quad[::-1] if inward else quad)
    return quads


def sphere(radius, n, m, inward):
    theta, phi = np.linspace(0, pi, n + 1), np.linspace(0, 2 * pi, m + 1)
    t, f = np.meshgrid(theta, phi, indexing="ij")
    x = radius * np.stack([np.sin(t) * np.cos(f), np.sin(t) * np.sin(f), np.cos(t)], axis=-1)
    quads = [
        np.array([x[i, j], x[i + 1, j], x[i + 1, j + 1], x[i, j + 1]])
        for i in range(n)
        for j in range(m)
    ]
    return [q[::-1] for q in quads] if inward else quads


# ------------------------------------------------------------------------------- closed forms


def opposite(x, y):
    """C-11: equal parallel rectangles, sides over distance x, y."""
    xs, ys = sqrt(1 + x * x), sqrt(1 + y * y)
    return (
        2 / (pi * x * y)
        * (
            log(xs * ys / sqrt(1 + x * x + y * y))
            + x * ys * atan(x / ys) + y * xs * atan(y / xs) - x * atan(x) - y * atan(y)
        )
    )  # fmt: skip


def cornered(h, w):
    """C-14: perpendicular rectangles with a common edge l; h, w over l; from w."""
    hh, ww = h * h, w * w
    s = hh + ww
    logs = (
        log((1 + ww) * (1 + hh) / (1 + s))
        + ww * log(ww * (1 + s) / ((1 + ww) * s))
        + hh * log(hh * (1 + s) / ((1 + hh) * s))
    )
    arcs = w * atan(1 / w) + h * atan(1 / h) - sqrt(s) * atan(1 / sqrt(s))
    return (arcs + 0.25 * logs) / (pi * w)


def coaxial_discs(r1, r2):
    """C-41: radii over distance."""
    x = 1 + (1 + r2 * r2) / (r1 * r1)
    return 0.5 * (x - sqrt(x * x - 4 * (r2 / r1) ** 2))


@pytest.mark.parametrize(("a", "b", "c"), [(1, 1, 1), (2, 0.5, 0.1), (1, 1, 30), (1, 1, 1e-3)])
def test_opposite_rectangles(a, b, c):
    one = rectangle([0, 0, 0], [a, 0, 0], [0, b, 0])
    other = one[::-1] + np.array([0, 0, c])
    factors = view_factors([one, other])
    assert factors[0, 1] == pytest.approx(opposite(a / c, b / c), rel=1e-6, abs=1e-9)
    assert factors[0, 0] == 0.0


def test_known_values():
    assert opposite(1, 1) == pytest.approx(0.199825, abs=1e-6)
    assert cornered(1, 1) == pytest.approx(0.200044, abs=1e-6)


@pytest.mark.parametrize(("h", "w"), [(1, 1), (3, 0.2), (0.01, 1)])
def test_rectangles_with_a_common_edge(h, w):
    floor = rectangle([0, 0, 0], [w, 0, 0], [0, 1, 0])
    wall = rectangle([0, 0, 0], [0, 1, 0], [0, 0, h])
    assert view_factors([floor, wall])[0, 1] == pytest.approx(cornered(h, w), rel=1e-9)


def test_a_facet_behind_the_plane_of_another_is_seen_in_part():
    """A wall that goes through the floor: only what is above counts."""
    floor = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0])
    through = rectangle([0, 0, -2], [0, 1, 0], [0, 0, 3])
    exchange = exchange_areas([floor, through])
    assert exchange[0, 1] == pytest.approx(cornered(1, 1), rel=1e-9)
    assert exchange_areas([floor, rectangle([0, 0, -2], [0, 1, 0], [0, 0, 2])])[0, 1] == 0.0
    assert exchange_areas([floor, through[::-1]])[0, 1] == 0.0


@pytest.mark.parametrize(("r1", "r2"), [(1.0, 1.0), (0.3, 2.0)])
def test_coaxial_discs(r1, r2):
    factors = view_factors([disc(r1, 0.0, True), disc(r2, 1.0, False)])
    assert factors[0, 1] == pytest.approx(coaxial_discs(r1, r2), rel=2e-4)


def test_rings_inside_a_cylinder():
    """From discs and their differences: F of ring 1 to rings further along."""
    heights, radius, width = [0.0, 0.5, 1.0, 1.5], 1.0, 0.5
    facets = tube(radius, heights, 64, inward=True)
    exchange = exchange_areas(facets)
    rings = exchange.reshape(3, 64, 3, 64).sum((1, 3)) / polygon_areas(facets).reshape(3, 64).sum(1)

    def between(gap):  # of end discs at a distance
        return coaxial_discs(radius / gap, radius / gap) if gap else 1.0

    def along(gap):  # exchange area with a ring of the same width after a gap, by four discs
        discs = between(gap) - 2 * between(gap + width) + between(gap + 2 * width)
        return pi * radius**2 * discs

    area = 2 * pi * radius * width
    own = 1 - 2 * pi * (1 - between(width)) / area
    np.testing.assert_allclose(rings[0], [own, along(0) / area, along(width) / area], atol=1e-3)
    closed = view_factors([*facets, disc(radius * 0.9996, 0, True, 64)])
    assert closed.sum(1).max() < 1.0 + 1e-9


# ------------------------------------------------------------------- closure, reciprocity, hidden


@pytest.mark.parametrize("n", [1, 3])
def test_rows_of_a_closed_box_sum_to_one(n):
    facets = [x for quad in box(1.0, 2.0, 0.3) for x in split(quad, n, 2 * n)]
    exchange = exchange_areas(facets)
    np.testing.assert_array_equal(exchange, exchange.T)
    np.testing.assert_allclose(exchange.sum(1) / polygon_areas(facets), 1.0, atol=1e-8)


def test_concentric_spheres():
    inner, outer = sphere(0.5, 6, 12, inward=False), sphere(1.0, 6, 12, inward=True)
    areas, factors = polygon_areas(inner + outer), view_factors(inner + outer)
    ratio = areas[:72].sum() / areas[72:].sum()
    np.testing.assert_allclose(factors[:72, 72:].sum(1), 1.0, atol=1e-9)
    back = areas[72:] @ factors[72:, 72:].sum(1) / areas[72:].sum()
    assert back == pytest.approx(1.0 - ratio, abs=3e-3)
    assert ratio == pytest.approx(0.25, abs=1e-12)


def test_a_box_in_a_box():
    facets = [x for quad in box(1.0, 1.0, 1.0) for x in split(quad, 3, 3)]
    body = [q / 2 + 0.25 for q in box(1.0, 1.0, 1.0, inside=False)]
    factors = view_factors([*facets, *body], rays=1024)
    np.testing.assert_allclose(factors[-6:].sum(1), 1.0, atol=1e-8)
    np.testing.assert_allclose(factors.sum(1), 1.0, atol=1.5e-2)
    areas = polygon_areas([*facets, *body])
    assert areas @ factors.sum(1) / areas.sum() == pytest.approx(1.0, abs=1e-3)


def screened(n):
    """Unit squares one apart, a screen over x < 1/2 halfway; from points, which see of the
    other square what the shadow of the screen leaves, by the closed form of a point."""

    def corner(x, y):  # point to a rectangle x by y over it at distance 1, one corner above it
        return (
            x / sqrt(1 + x * x) * atan(y / sqrt(1 + x * x))
            + y / sqrt(1 + y * y) * atan(x / sqrt(1 + y * y))
        ) / (2 * pi)

    def patch(x0, x1, y0, y1):
        return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)

    s, w = np.polynomial.legendre.leggauss(n)
    s, w, total = (s + 1) / 2, w / 2, 0.0
    for x, wx in zip(s, w, strict=True):
        for y, wy in zip(s, w, strict=True):
            # twice as large on the other square: x' from -x to 1 - x, y' from -y to 2 - y
            lit = patch(1.0 - 2.0 * x, 1.0 - x, -y, 1.0 - y)
            total += wx * wy * lit
    return total


@pytest.mark.parametrize("rays", [256, 16384])
def test_a_screen_between_two_squares(rays):
    one = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0])
    other = one[::-1] + np.array([0, 0, 1])
    screen = rectangle([0, 0, 0.5], [0.5, 0, 0], [0, 1, 0])
    exact = screened(24)
    assert exact < 0.7 * opposite(1, 1)
    assert view_factors([one, other, screen], rays)[0, 1] == pytest.approx(exact, rel=rays**-0.5)
    whole = rectangle([-1, -1, 0.5], [3, 0, 0], [0, 3, 0])
    assert view_factors([one, other, whole])[0, 1] == 0.0


def test_long_strips_with_a_screen():
    """A screen over half of the gap: by symmetry half of the exchange is left."""
    one = rectangle([0, 0, 0], [1, 0, 0], [0, 40, 0])
    other = one[::-1] + np.array([0, 0, 1])
    screen = rectangle([0, 0, 0.5], [0.5, 0, 0], [0, 40, 0])
    factor = view_factors([one, other, screen], rays=1024)[0, 1]
    assert factor == pytest.approx(0.5 * opposite(1, 40), rel=1024**-0.5)


def test_a_warped_facet_is_two_triangles():
    warped = np.array([[0, 0, 0], [1, 0, 0.2], [1, 1, 0], [0, 1, 0.2]])
    lid = rectangle([0, 0, 2], [0, 1, 0], [1, 0, 0])
    both = [warped[[0, 1, 2]], warped[[0, 2, 3]], lid]
    parts, whole = exchange_areas(both), exchange_areas([warped, lid])
    assert whole[0, 1] == pytest.approx(parts[0, 2] + parts[1, 2], rel=1e-12)
    assert whole[0, 0] == pytest.approx(2 * parts[0, 1], abs=1e-15)


def test_facets_without_area_are_refused():
    with pytest.raises(ValueError, match="1 facets have no area, among them 1"):
        view_factors([np.eye(3), np.ones((3, 1)) * np.arange(3.0)])


def test_turning_and_scaling_change_nothing():
    facets = box(1.0, 2.0, 0.3)[:4]
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = [1e-3 * f @ turn.T + 0.7 for f in facets]
    np.testing.assert_allclose(view_factors(moved), view_factors(facets), atol=1e-8)


# ----------------------------------------------------------------------------- arcs, adjusting


def test_arcs_of_a_tube():
    """Two halves: 2/pi to the other; rows sum to one; reciprocity; many arcs: |sin|/4 dphi."""
    other = 2 / pi
    np.testing.assert_allclose(arc_factors(np.ones(2)), [[1 - other, other], [other, 1 - other]])
    widths = np.random.default_rng(1).uniform(0.1, 1.0, 9)
    factors = arc_factors(widths)
    np.testing.assert_allclose(factors.sum(1), 1.0, rtol=1e-13)
    np.testing.assert_allclose(widths[:, None] * factors, (widths[:, None] * factors).T, atol=1e-15)
    fine = arc_factors(np.ones(400))[0]
    angle = 2 * pi / 400 * np.arange(400)
    np.testing.assert_allclose(fine[1:], np.sin(angle[1:] / 2) / 4 * 2 * pi / 400, rtol=1e-4)


def test_adjusted_rows_have_their_sums():
    rng = np.random.default_rng(2)
    exchange = rng.uniform(0, 1, (6, 6))
    exchange += exchange.T
    exchange[0, 1] = exchange[1, 0] = 0.0
    sums = exchange.sum(1) * rng.uniform(0.98, 1.02, 6)
    found = adjusted(exchange, sums)
    np.testing.assert_allclose(found.sum(1), sums, rtol=1e-12)
    np.testing.assert_allclose(found, found.T, rtol=1e-14)
    np.testing.assert_allclose(found, exchange, rtol=0.05)
    assert found[0, 1] == 0.0


@pytest.mark.benchmark
def test_cost():
    from time import perf_counter

    for n in (5, 10, 15):
        facets = [x for quad in box(1.0, 1.0, 1.0) for x in split(quad, n, n)]
        body = [q / 2 + 0.25 for q in box(1.0, 1.0, 1.0, inside=False)]
        for name, every in (("convex", facets), ("with a body inside", facets + body)):
            start = perf_counter()
            view_factors(every)
            print(f"{len(every)} facets, {name}: {perf_counter() - start:.2f} s")
