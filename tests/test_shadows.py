"""Shadows and penumbras of tubes and facets against closed forms and rays to the sun's disc."""

from math import asin, cos, pi, radians, sin, sqrt, tan
from time import process_time

import numpy as np
import pytest

from thermal.shadows import NO_FACETS, NO_TUBES, Facets, Patches, Tubes, visible

DISC = 4.65e-3  # [rad]
UP = np.array([0.0, 0.0, 1.0])


def points(at, normal=UP, along=0.0, owner=-1):
    """Patches with one normal."""
    at = np.atleast_2d(np.asarray(at, float))
    m = len(at)
    return Patches(at, np.tile(normal, (m, 1)), np.full(m, along), np.full(m, owner))


def rods(start, end, radius):
    """Cylinders each on its own."""
    start, end = (np.atleast_2d(np.asarray(x, float)) for x in (start, end))
    k = len(start)
    radii = np.broadcast_to(np.asarray(radius, float), k).copy()
    return Tubes(start, end, radii, np.zeros((k, 2)), np.ones((k, 2), np.bool_), np.arange(k))


def chain(through, radius, owner=0):
    """Cylinders of one body through points."""
    x = np.asarray(through, float)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
    k = len(x) - 1
    free = np.zeros((k, 2), np.bool_)
    free[0, 0] = free[-1, 1] = True
    along = np.stack([s[:-1], s[1:]], axis=1)
    return Tubes(x[:-1], x[1:], np.full(k, radius), along, free, np.full(k, owner))


def square(side, z, owner=0):
    """A plate about the z axis, of two triangles."""
    h = 0.5 * side
    a, b, c, d = ([-h, -h, z], [h, -h, z], [h, h, z], [-h, h, z])
    return Facets(np.array([[a, b, c], [a, c, d]]), np.full(2, owner))


def beyond(x):
    """Fraction of the unit disc beyond a chord."""
    x = np.clip(x, -1.0, 1.0)
    return 0.5 - (x * np.sqrt(1.0 - x * x) + np.arcsin(x)) / pi


# -------------------------------------------------------------------------------- closed forms


def test_turned_away_or_alone():
    sun = np.array([0.6, 0.0, 0.8])
    facing = Patches(np.zeros((3, 3)), np.array([UP, -UP, 0.0 * UP]), np.zeros(3), np.full(3, -1))
    assert visible(facing, NO_TUBES, NO_FACETS, sun, DISC).tolist() == [1.0, 0.0, 1.0]
    below = rods([-1.0, 0.0, -2.0], [1.0, 0.0, -2.0], 0.5)
    assert visible(points([0.0, 0.0, 0.0]), below, NO_FACETS, sun, DISC).tolist() == [1.0]


def test_penumbra_behind_the_edge_of_a_plate():
    """Over a width of 2 d alpha the sun comes out by segments of its disc."""
    d = 7.0
    x = 5.0 + d * DISC * np.linspace(-1.2, 1.2, 25)
    at = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    seen = visible(points(at), NO_TUBES, square(10.0, d), UP, DISC)
    assert np.allclose(seen, 1.0 - beyond((x - 5.0) / (d * DISC)), atol=1e-9)


def test_plate_behind_plate_in_slanting_light():
    """The shadow of a square plate 2 m above moves by 2 m tan(40 degrees)."""
    sun = np.array([sin(radians(40.0)), 0.0, cos(radians(40.0))])
    x = np.arange(-4.0, 4.0, 0.02) + 0.003
    at = np.stack([x, 0.0 * x + 0.1, 0.0 * x], axis=1)
    seen = visible(points(at), NO_TUBES, square(1.0, 2.0), sun, 0.0)
    shade = np.abs(x + 2.0 * tan(radians(40.0))) < 0.5
    assert np.array_equal(seen < 1e-12, shade)
    assert np.array_equal(seen > 1.0 - 1e-12, ~shade)


@pytest.mark.parametrize("psi", [90.0, 60.0, 25.0])
def test_penumbra_behind_a_long_tube(psi):
    """A strip between asin(r/h) to both sides of the axis, narrower by sin(psi) than round it."""
    r, h, psi = 0.02, 3.0, radians(psi)
    t = np.array([0.0, sin(psi), cos(psi)])
    k = np.array([0.0, -cos(psi), sin(psi)])  # towards the axis, in the plane of sun and axis
    turn = np.linspace(-2.0, 2.0, 41) * asin(r / h)
    to_axis = np.cos(turn)[:, None] * k + np.sin(turn)[:, None] * np.array([1.0, 0.0, 0.0])
    seen = []
    for away in h * to_axis:
        tube = rods(away - 200.0 * t, away + 200.0 * t, r)
        seen.append(visible(points([0.0, 0.0, 0.0]), tube, NO_FACETS, UP, DISC)[0])
    low, high = (np.arcsin(sin(psi) * np.sin(turn + s * asin(r / h))) / DISC for s in (-1, 1))
    assert np.allclose(seen, 1.0 - (beyond(low) - beyond(high)), atol=1e-9)


def test_a_thin_wire_takes_its_share_of_the_disc():
    """4/pi of half width over the radius of the disc, in the middle of it."""
    wire = rods([-10.0, 0.0, 5.0], [10.0, 0.0, 5.0], 1e-4)
    seen = visible(points([0.0, 0.0, 0.0]), wire, NO_FACETS, UP, DISC)[0]
    assert 1.0 - seen == pytest.approx(4.0 / pi * (1e-4 / 5.0) / DISC, rel=1e-4)


def test_a_tube_behind_a_tube_in_line():
    """It lies in the umbra up to the distance r/tan(alpha), and grows lighter beyond."""
    tube = rods([-10.0, 0.0, 0.0], [10.0, 0.0, 0.0], 0.05)
    depth = 0.05 / sin(DISC)
    at = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, -0.999 * depth], [0.0, 0.0, -3.0 * depth]])
    seen = visible(points(at), tube, NO_FACETS, UP, DISC)
    half = asin(sin(DISC) / 3.0) / DISC
    assert seen[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert seen[2] == pytest.approx(1.0 - (beyond(-half) - beyond(half)), abs=1e-9)


def test_a_tube_that_points_to_the_sun_shades_a_disc():
    tube = rods([0.0, 0.0, 4.0], [0.0, 0.0, 6.0], 0.1)
    at = np.array([[x, 0.0, 0.0] for x in (0.0, 0.08, 0.095, 0.1, 0.11, 0.12)])
    seen = visible(points(at), tube, NO_FACETS, UP, DISC)
    exact = [1.0 - hit_cylinder(rays(UP, DISC), *ends(tube, p), 0.1).mean() for p in at]
    assert seen == pytest.approx(exact, abs=0.012)
    assert exact[0] == 0.0 and 0.3 < exact[3] < 0.6 and exact[-1] > 0.9


def ends(tube, p):
    """Of the only cylinder, as seen from ``p``."""
    return tube.start[0] - p, tube.end[0] - p


def test_pieces_of_a_tube_that_points_to_the_sun():
    """Rays that go from piece to piece count once."""
    t = np.array([0.01, 0.0, 1.0])
    through = 3.0 * UP + np.linspace(0.0, 2.0, 9)[:, None] * t
    at = points(np.array([[x, 0.02, 0.0] for x in np.linspace(-0.15, 0.15, 61)]))
    one = visible(at, chain(through[[0, -1]], 0.1), NO_FACETS, UP, DISC)
    assert np.allclose(visible(at, chain(through, 0.1), NO_FACETS, UP, DISC), one, atol=1e-9)
    assert np.mean((one > 0.0) & (one < 1.0)) > 0.1


def test_pieces_of_one_tube_shade_like_one():
    """Also where the disc stands behind a joint between two pieces."""
    t = np.array([0.8, 0.36, 0.48])
    ends = np.array([-6.0 * t, 6.0 * t]) + 5.0 * UP
    at = np.random.default_rng(3).uniform(-0.15, 0.15, (400, 3)) + np.array([1.0, 0.45, 0.0])
    one = visible(points(at), chain(ends, 0.05), NO_FACETS, UP, DISC)
    between = np.linspace(0.0, 1.0, 38)[:, None]
    many = chain(ends[0] + between * (ends[1] - ends[0]), 0.05)
    assert np.allclose(visible(points(at), many, NO_FACETS, UP, DISC), one, atol=1e-9)
    assert np.mean((one > 0.0) & (one < 1.0)) > 0.1


def test_different_bodies_multiply():
    """Two thin wires that cross cover a little less than their sum."""
    x = rods([-10.0, 0.0, 5.0], [10.0, 0.0, 5.0], 2e-3)
    y = rods([0.0, -10.0, 6.0], [0.0, 10.0, 6.0], 2e-3)
    both = Tubes(*(np.concatenate(c) for c in zip(x, y, strict=True)))._replace(owner=np.arange(2))
    at = points([0.0, 0.0, 0.0])
    a, b, ab = (visible(at, t, NO_FACETS, UP, DISC)[0] for t in (x, y, both))
    assert ab == pytest.approx(a * b, abs=1e-12)


def test_a_closed_surface_shades_once():
    """Front and back of a box are two layers of one body."""
    lower, upper = square(1.0, 4.0), square(1.0, 4.0 + 1e-6)
    box = Facets(np.concatenate([lower.corners[:, ::-1], upper.corners]), np.zeros(4, int))
    at = np.array([[x, 0.0, 0.0] for x in 0.5 + 4.0 * DISC * np.linspace(-1.0, 1.0, 9)])
    once = visible(points(at), NO_TUBES, upper, UP, DISC)
    assert np.allclose(visible(points(at), NO_TUBES, box, UP, DISC), once, atol=1e-6)


# ------------------------------------------------------------------------------- own shadows


def ring(t, n=24):
    """Unit normals round a direction."""
    across = np.linalg.svd(np.asarray(t, float)[None])[2][1:]
    phi = 2.0 * pi * np.arange(n) / n
    return np.cos(phi)[:, None] * across[0] + np.sin(phi)[:, None] * across[1]


@pytest.mark.parametrize("angle", [90.0, 30.0, 3.0, 0.3, 0.0])
def test_a_straight_tube_does_not_shade_itself(angle):
    t = np.array([sin(radians(angle)), 0.0, cos(radians(angle))])
    tube, normals = chain(np.linspace(0.0, 1.0, 21)[:, None] * 4.0 * t, 0.05), ring(t)
    for s in np.linspace(0.0, 4.0, 33):
        at = Patches(s * t + 0.05 * normals, normals, np.full(24, s), np.zeros(24, int))
        facing = normals @ UP > 1e-2
        assert np.all(visible(at, tube, NO_FACETS, UP, DISC)[facing] == 1.0)


def test_a_folded_tube_shades_itself_far_away():
    """A hairpin with arms 1 m apart, the sun in its plane: the lower arm lies in the dark."""
    bend = [[3.0 + 0.5 * sin(a), 0.0, 0.5 * cos(a)] for a in np.linspace(0.0, pi, 13)]
    tube = chain([[0.0, 0.0, 0.5], *bend, [0.0, 0.0, -0.5]], 0.05)
    length = tube.along[-1, 1]
    at = Patches(
        np.array([[1.0, 0.0, 0.55], [1.0, 0.0, -0.45]]), np.tile(UP, (2, 1)),
        np.array([1.0, length - 1.0]), np.zeros(2, int),
    )  # fmt: skip
    assert visible(at, tube, NO_FACETS, UP, DISC).tolist() == [1.0, 0.0]


def test_a_bent_tube_does_not_darken_where_it_bends():
    """A boom of 5 m bent to a radius of 10 m, by pieces; points on the true arc."""
    nodes = np.linspace(0.0, 0.5, 21)
    tube = chain(10.0 * np.stack([np.sin(nodes), 0.0 * nodes, 1.0 - np.cos(nodes)], axis=1), 0.05)
    for a in np.linspace(0.0, 0.5, 57):
        t = np.array([cos(a), 0.0, sin(a)])
        normals = ring(t)
        at = 10.0 * np.array([sin(a), 0.0, 1.0 - cos(a)]) + 0.05 * normals
        patches = Patches(at, normals, np.full(24, 10.0 * a), np.zeros(24, int))
        for sun in (UP, -UP, np.array([0.0, 1.0, 0.0])):
            seen = visible(patches, tube, NO_FACETS, sun, DISC)
            assert np.all(seen[normals @ sun > 0.05] == 1.0)


def test_where_tubes_meet_no_light_falls_between():
    tube = rods([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.1)
    inside = [0.0, 0.05, 0.0]
    assert visible(points(inside), tube, NO_FACETS, UP, DISC).tolist() == [0.0]
    lump = points(inside, normal=0.0 * UP)  # a lump stands for itself
    assert visible(lump, tube, NO_FACETS, UP, DISC).tolist() == [1.0]


def test_a_curved_plate_is_lit_all_over():
    """A cylindrical panel of facets, both sides, its points on the true arc above chords."""
    a = np.linspace(-0.6, 0.6, 13)
    x, z = np.sin(a), np.cos(a)
    near, far = (np.stack([x, 0.0 * x + y, z], axis=1) for y in (-1.0, 1.0))
    quads = np.stack([near[:-1], near[1:], far[1:], far[:-1]], axis=1)
    panel = Facets(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), np.zeros(24, int))
    b = np.linspace(-0.58, 0.58, 41)
    normals = np.stack([np.sin(b), 0.0 * b, np.cos(b)], axis=1)
    for side in (1.0, -1.0):
        at = Patches((1.0 + 1e-3 * side) * normals, side * normals, 0.0 * b, np.zeros(41, int))
        assert np.all(visible(at, NO_TUBES, panel, side * UP, DISC) == 1.0)


# ------------------------------------------------------------------------------- against rays


def rays(sun, radius, n=6000):
    """Unit vectors spread evenly over the sun's disc."""
    k = np.arange(n) + 0.5
    out, turn = np.sqrt(k / n) * tan(radius), pi * (1.0 + sqrt(5.0)) * k
    across = np.linalg.svd(sun[None])[2][1:]
    d = sun + (out * np.cos(turn))[:, None] * across[0] + (out * np.sin(turn))[:, None] * across[1]
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def hit_cylinder(d, start, end, r):
    """Which rays from the origin meet the side of a cylinder or its ends."""
    length = np.linalg.norm(end - start)
    t = (end - start) / length
    m = -start
    along, across = d @ t, d - np.outer(d @ t, t)
    off = m - (m @ t) * t
    a, b, c = (across**2).sum(1), across @ off, off @ off - r * r
    met = np.zeros(len(d), bool)
    with np.errstate(all="ignore"):
        for sign in (-1.0, 1.0):
            s = (-b + sign * np.sqrt(b * b - a * c)) / a
            x = m @ t + s * along
            met |= (s > 0.0) & (x >= 0.0) & (x <= length)
        for x in (0.0, length):
            s = (x - m @ t) / along
            met |= (s > 0.0) & (((off + s[:, None] * across) ** 2).sum(1) <= r * r)
    return met


def hit_triangle(d, c):
    """Which rays from the origin meet a triangle: three edges all to one side."""
    n = np.stack([np.cross(c[i], c[(i + 1) % 3]) for i in range(3)])
    side = d @ n.T
    plane = np.cross(c[1] - c[0], c[2] - c[0])
    ahead = (c[0] @ plane) / (d @ plane) > 0.0
    return ahead & ((side >= 0.0).all(1) | (side <= 0.0).all(1))


def cloud(seed, wide):
    """Directions to the sun, and what is near the ray from the origin to it."""
    rng = np.random.default_rng(seed)
    for _ in range(60):
        sun = rng.normal(size=3)
        sun /= np.linalg.norm(sun)
        distance = rng.uniform(3.0, 40.0)
        centre = distance * (sun + wide * DISC * rng.normal(size=3))
        yield rng, sun, distance, centre


def test_slender_tubes_against_rays():
    """Sides, ends and edges in any attitude: half a percent of the disc where they end, if that."""
    errors = []
    for rng, sun, distance, centre in cloud(5, 1.5):
        half = rng.normal(size=3) * rng.choice([0.1, 0.5, 3.0])
        r = min(rng.uniform(0.5, 4.0) * DISC * distance, 0.2 * np.linalg.norm(half))
        tube = rods(centre - half, centre + half, r)
        seen = visible(points(np.zeros(3), sun), tube, NO_FACETS, sun, DISC)[0]
        exact = 1.0 - hit_cylinder(rays(sun, DISC), centre - half, centre + half, r).mean()
        errors.append(abs(seen - exact))
    assert max(errors) < 0.02
    assert np.mean(errors) < 2e-3


def test_facets_against_rays():
    for rng, sun, distance, centre in cloud(6, 1.0):
        c = centre + rng.normal(size=(3, 3)) * rng.choice([0.003, 0.02, 0.8]) * distance
        facet = Facets(c[None], np.zeros(1, int))
        seen = visible(points(np.zeros(3), sun), NO_TUBES, facet, sun, DISC)[0]
        exact = 1.0 - hit_triangle(rays(sun, DISC), c).mean()
        assert seen == pytest.approx(exact, abs=2e-3)


def test_a_facet_that_reaches_behind_the_point():
    """What lies behind is cut off."""
    c = np.array([[-3.0, -2.0, 4.0], [3.0, -2.0, 4.0], [0.0, 9.0, -8.0]])
    facet = Facets(c[None], np.zeros(1, int))
    for sun in (UP, np.array([0.0, 0.6, 0.8]), np.array([0.0, 0.8, 0.6])):
        seen = visible(points(np.zeros(3), sun), NO_TUBES, facet, sun, 0.05)[0]
        assert seen == pytest.approx(1.0 - hit_triangle(rays(sun, 0.05), c).mean(), abs=2e-3)


def many(seed=2):
    """Random tubes and facets, every one a body, and patches among them."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-5.0, 5.0, (150, 3))
    tubes = rods(start, start + 2.0 * rng.normal(size=(150, 3)), rng.uniform(0.02, 0.2, 150))
    corners = rng.uniform(-5.0, 5.0, (80, 1, 3)) + 0.7 * rng.normal(size=(80, 3, 3))
    normals = rng.normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    patches = Patches(rng.uniform(-6.0, 6.0, (400, 3)), normals, np.zeros(400), np.full(400, -1))
    return patches, tubes, Facets(corners, np.arange(80) + 1000)


@pytest.mark.parametrize("sun", [[0.0, 0.0, 1.0], [0.48, -0.6, 0.64]])
def test_the_grid_forgets_nothing(sun):
    patches, tubes, facets = many()
    sun = np.array(sun)
    seen = visible(patches, tubes, facets, sun, DISC)
    one = (patches.normals @ sun > 0.0).astype(float)
    for k in range(150):
        one *= visible(patches, Tubes(*(x[k : k + 1] for x in tubes)), NO_FACETS, sun, DISC)
    for k in range(80):
        one *= visible(patches, NO_TUBES, Facets(*(x[k : k + 1] for x in facets)), sun, DISC)
    assert np.allclose(seen, one, atol=1e-12)


# --------------------------------------------------------------------------------------- time


def truss(members, pieces=9, stations=10, angles=8):
    """A ring of tubes: 10 stations of 8 points and 9 pieces each."""
    at = 2.0 * pi * np.arange(members) / members
    radius = 0.1 * members
    start = np.stack([radius * np.cos(at), radius * np.sin(at), 2.0 * (np.arange(members) % 2)], 1)
    end = np.roll(start, -1, axis=0) + UP
    tubes, patches = [], []
    for owner, (a, b) in enumerate(zip(start, end, strict=True)):
        tubes.append(chain(a + np.linspace(0, 1, pieces + 1)[:, None] * (b - a), 0.025, owner))
        normals, length = ring((b - a) / np.linalg.norm(b - a), angles), np.linalg.norm(b - a)
        for s in np.linspace(0.0, 1.0, stations):
            own = np.full(angles, owner)
            p = a + s * (b - a) + 0.025 * normals
            patches.append(Patches(p, normals, np.full(angles, s * length), own))
    joined = (map(np.concatenate, zip(*many, strict=True)) for many in (patches, tubes))
    patch, tube = joined
    return Patches(*patch), Tubes(*tube)


def duration(members, sun):
    patches, tubes = truss(members)
    times = []
    for _ in range(9):
        start = process_time()
        visible(patches, tubes, NO_FACETS, sun, DISC)
        times.append(process_time() - start)
    return len(patches.points), len(tubes.owner), min(times)


@pytest.mark.benchmark
def test_shadows_of_a_truss_in_milliseconds(capsys):
    """11,520 points and 1,296 cylinders in less than 50 ms, four times as many in some 4 times."""
    sun = np.array([0.5, 0.3, 0.2]) / np.linalg.norm([0.5, 0.3, 0.2])
    small, large = duration(144, sun), duration(576, sun)
    with capsys.disabled():
        for m, k, time in (small, large):
            print(f"\n{m} points, {k} cylinders: {1e3 * time:.1f} ms")
    assert small[:2] == (11520, 1296)
    assert small[2] < 0.05
    assert large[2] < 8.0 * small[2]
