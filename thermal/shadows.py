"""Which part of the sun's disc each point of a surface sees past tubes and facets.

The sun is an evenly bright disc of a given angular radius, so that shadows have penumbras. What
one body covers of it is exact for the two edges of a tube, as the planes through the point that
touch its cylinder, and for facets; the round ends of tubes are half ellipses, and tubes that
point nearly to the sun are met by single rays, to one percent. What several pieces of one body
cover adds up, as they lie side by side (of facets those turned to the sun and those turned away
from it are two layers, of which the larger counts); different bodies are taken as independent, so
the visible fractions multiply: exact where one of them covers all or nothing.

To find the few pieces before each point, all are entered into a grid across the rays: the cost
grows with points and pieces, not with their product. What a point's own body covers close to
it is left to the cosine of incidence.
"""

from math import asin, atan2, floor, hypot, pi, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NEAR_TUBE = 4.0  # radii along its axis within which a tube casts no shadow on itself
NEAR_FACET = 1.5  # longest edges within which facets cast none on their own body
POINT_SUN = 1e-9  # [rad]  least radius of the disc
CAP_STRIPS = 12  # of the quadrature over the half ellipse at the end of a tube
STEEP = 10.0  # radii of the disc within which a tube points to the sun, and is met by rays
RAYS, GOLDEN = 127, pi * (3.0 - sqrt(5.0))
CELLS_PER_PIECE, MOST_CELLS = 4, 4_000_000


def _spiral(n: int) -> Array:
    """(n, 2)  points spread evenly over the unit disc (Vogel 1979)."""
    out, turn = np.sqrt((np.arange(n) + 0.5) / n), GOLDEN * np.arange(n)
    return np.stack([out * np.cos(turn), out * np.sin(turn)], axis=1)


SPIRAL = _spiral(RAYS)


class Tubes(NamedTuple):
    """Cylinders, one after the other along their bodies.

    start, end : (k, 3) float [m]
    radius : (k,) float [m]
    along : (k, 2) float [m]  arc length of both ends along the body
    free : (k, 2) bool  whether no other cylinder of the body joins on at the end
    owner : (k,) int  number of the body
    """

    start: Array
    end: Array
    radius: Array
    along: Array
    free: NDArray[np.bool_]
    owner: Indices


class Facets(NamedTuple):
    """corners : (k, 3, 3) float [m]  of triangles; owner : (k,) int  number of the body"""

    corners: Array
    owner: Indices


class Patches(NamedTuple):
    """Points on which the sun may shine.

    points, normals : (m, 3) float [m], [-]  a normal of zeros faces everywhere
    along : (m,) float [m]  arc length along the body, of points on tubes
    owner : (m,) int  number of the body; -1: none that casts shadows
    """

    points: Array
    normals: Array
    along: Array
    owner: Indices


NO_TUBES = Tubes(
    np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 2)),
    np.empty((0, 2), np.bool_), np.empty(0, np.intp),
)  # fmt: skip
NO_FACETS = Facets(np.empty((0, 3, 3)), np.empty(0, np.intp))


def visible(patches: Patches, tubes: Tubes, facets: Facets, sun: Array, radius: float) -> Array:
    """Visible fraction (m,) of the sun's disc; 0 where a patch is turned away from it.

    Pieces of one body must stand together in ``tubes`` and ``facets``.

    Parameters
    ----------
    sun : (3,) unit vector towards it
    radius : float [rad]  of its disc
    """
    axes = _view(np.asarray(sun, dtype=float))
    at = patches.points @ axes.T
    normals = patches.normals @ axes.T
    out = np.where((normals[:, 2] > 0.0) | ~normals.any(axis=1), 1.0, 0.0)
    lit = np.flatnonzero(out)
    if not len(lit) or not len(tubes.owner) + len(facets.owner):
        return out
    pieces = _pieces(tubes, facets, axes)
    alpha = max(radius, POINT_SUN)
    grid = _grid(at[lit], len(pieces.owner))
    starts = np.zeros(grid.rows * grid.columns + 1, np.intp)
    _enter(pieces.corners, pieces.thick, alpha, *grid, starts, np.empty(0, np.intp))
    starts[1:] = np.cumsum(starts[1:])
    entries = np.empty(starts[-1], np.intp)
    _enter(pieces.corners, pieces.thick, alpha, *grid, starts.copy(), entries)
    facing = normals.any(axis=1)
    who = (at, facing, patches.along, patches.owner, lit)
    _look(*who, *pieces, tubes.along, tubes.free, alpha, *grid, starts, entries, out)
    return out


class _Pieces(NamedTuple):
    """Tubes, then facets, seen along the rays; a tube has its end as second and third corner."""

    corners: Array
    thick: Array
    owner: Indices


def _pieces(tubes: Tubes, facets: Facets, axes: Array) -> _Pieces:
    ends = np.stack([tubes.start, tubes.end, tubes.end], axis=1)
    return _Pieces(
        np.concatenate([ends, facets.corners]) @ axes.T,
        np.concatenate([tubes.radius, np.zeros(len(facets.owner))]),
        np.concatenate([tubes.owner, facets.owner]),
    )


def _view(sun: Array) -> Array:
    """(3, 3) rows: two directions across the rays, and the one to the sun."""
    other = np.zeros(3)
    other[int(np.argmin(np.abs(sun)))] = 1.0
    first = np.cross(other, sun)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(sun, first), sun])


class _Grid(NamedTuple):
    """Square cells across the rays, over all lit patches; ``lowest``: farthest from the sun."""

    u: float
    v: float
    cell: float
    columns: int
    rows: int
    lowest: float


def _grid(at: Array, pieces: int) -> _Grid:
    low, high = at.min(axis=0), at.max(axis=0)
    wide, tall = (high - low)[:2]
    cells = min(CELLS_PER_PIECE * pieces + 16, MOST_CELLS)
    cell = max(sqrt(wide * tall / cells), (wide + tall) / cells, 1e-12 * (1.0 + abs(at).max()))
    return _Grid(low[0], low[1], cell, int(wide / cell) + 1, int(tall / cell) + 1, low[2])


# ------------------------------------------------------------------------------------ the grid


@njit(cache=True)
def _enter(corners, thick, alpha, u0, v0, cell, columns, rows, lowest, starts, entries):
    """Count the pieces of each cell in ``starts`` [1:], or with ``entries`` given enter them."""
    counting = len(entries) == 0
    for k in range(len(corners)):
        c = corners[k]
        deep = max(c[0, 2], c[1, 2], c[2, 2]) + thick[k] - lowest
        if deep <= 0.0:
            continue
        margin = 1.001 * (thick[k] + alpha * deep)
        v_low, v_high = min(c[0, 1], c[1, 1], c[2, 1]), max(c[0, 1], c[1, 1], c[2, 1])
        first = max(0, floor((v_low - margin - v0) / cell))
        last = min(rows - 1, floor((v_high + margin - v0) / cell))
        for row in range(first, last + 1):
            low = v0 + row * cell - margin
            left, right = _span(c, low, low + cell + 2.0 * margin)
            a = max(0, floor((left - margin - u0) / cell))
            b = min(columns - 1, floor((right + margin - u0) / cell))
            for column in range(a, b + 1):
                i = row * columns + column
                if counting:
                    starts[i + 1] += 1
                else:
                    entries[starts[i]] = k
                    starts[i] += 1


@njit(cache=True)
def _span(c, low, high):
    """Least and largest u of the edges of a triangle between two values of v."""
    left, right = np.inf, -np.inf
    for i in range(3):
        j = (i + 1) % 3
        a, b = c[i, 1], c[j, 1]
        if max(a, b) < low or min(a, b) > high:
            continue
        s, t = 0.0, 1.0
        if a != b:
            x, y = (low - a) / (b - a), (high - a) / (b - a)
            s, t = max(0.0, min(x, y)), min(1.0, max(x, y))
        p, q = c[i, 0] + s * (c[j, 0] - c[i, 0]), c[i, 0] + t * (c[j, 0] - c[i, 0])
        left, right = min(left, p, q), max(right, p, q)
    return left, right


@njit(cache=True)
def _look(
    at, facing, along, owner, lit, corners, thick, owners, tube_along, tube_free,
    alpha, u0, v0, cell, columns, rows, lowest, starts, entries, out,
):  # fmt: skip
    tubes = len(tube_along)
    for i in lit:
        p = at[i]
        column = min(columns - 1, max(0, floor((p[0] - u0) / cell)))
        row = min(rows - 1, max(0, floor((p[1] - v0) / cell)))
        this, seen, front, back = -1, 1.0, 0.0, 0.0
        for e in range(starts[row * columns + column], starts[row * columns + column + 1]):
            k = entries[e]
            if owners[k] != this:
                seen *= 1.0 - min(1.0, max(front, back))
                this, front, back = owners[k], 0.0, 0.0
            own = owners[k] == owner[i]
            if k < tubes:
                gap = max(tube_along[k, 0] - along[i], along[i] - tube_along[k, 1])
                clear = own and gap <= NEAR_TUBE * thick[k]
                if not clear and not _is_aside(p, corners[k], thick[k], alpha):
                    a, b = tube_free[k]
                    front += _tube(p, facing[i], corners[k], thick[k], a, b, alpha)
            elif not own or not _is_near(p, corners[k]):
                covered = _facet(p, corners[k], alpha)
                front, back = front + max(0.0, covered), back + max(0.0, -covered)
        out[i] = seen * (1.0 - min(1.0, max(front, back)))


@njit(cache=True)
def _is_aside(p, c, r, alpha):
    """Whether the axis of a cylinder passes too far from the ray to touch the disc."""
    x, y = c[0, 0] - p[0], c[0, 1] - p[1]
    dx, dy = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1]
    square = dx * dx + dy * dy
    s = max(0.0, min(1.0, -(x * dx + y * dy) / square)) if square > 0.0 else 0.0
    deep = max(c[0, 2], c[1, 2]) - p[2] + r
    return deep <= 0.0 or hypot(x + s * dx, y + s * dy) > 1.001 * (r + alpha * deep)


@njit(cache=True)
def _is_near(p, c):
    """Whether a point is within some lengths of a facet from its centre."""
    away = longest = 0.0
    for x in range(3):
        away += ((c[0, x] + c[1, x] + c[2, x]) / 3.0 - p[x]) ** 2
    for i in range(3):
        j = (i + 1) % 3
        edge = (c[i, 0] - c[j, 0]) ** 2 + (c[i, 1] - c[j, 1]) ** 2 + (c[i, 2] - c[j, 2]) ** 2
        longest = max(longest, edge)
    return away < NEAR_FACET**2 * longest


# --------------------------------------------------------------------------------------- facets


@njit(cache=True)
def _facet(p, c, alpha):
    """Fraction of the disc that a triangle covers, negative if its corners turn backwards.

    As seen from ``p`` in units of the disc; what is not before ``p`` is cut off.
    """
    reach = depth = 0.0
    for i in range(3):
        depth = max(depth, c[i, 2] - p[2])
        reach = max(reach, abs(c[i, 0] - p[0]), abs(c[i, 1] - p[1]))
    if depth <= 0.0:
        return 0.0
    least = 1e-6 * (depth + reach)
    area, count = 0.0, 0
    x0 = y0 = x1 = y1 = 0.0
    for i in range(3):
        j = (i + 1) % 3
        a, b = c[i, 2] - p[2], c[j, 2] - p[2]
        for end in range(2):  # this corner, then where the edge crosses the cutting plane
            if (a < least) if end == 0 else ((a < least) == (b < least)):
                continue
            s = 0.0 if end == 0 else (least - a) / (b - a)
            w = alpha * (a + s * (b - a))
            x = (c[i, 0] - p[0] + s * (c[j, 0] - c[i, 0])) / w
            y = (c[i, 1] - p[1] + s * (c[j, 1] - c[i, 1])) / w
            if count == 0:
                x0, y0 = x, y
            else:
                area += _wedge(x1, y1, x, y)
            x1, y1, count = x, y, count + 1
    return (area + _wedge(x1, y1, x0, y0)) / pi if count else 0.0


@njit(cache=True)
def _wedge(ax, ay, bx, by):
    """Signed area that the unit disc shares with the triangle of its centre, a and b."""
    dx, dy = bx - ax, by - ay
    A, B = dx * dx + dy * dy, ax * dx + ay * dy
    root = A - (ax * dy - ay * dx) ** 2
    whole = 0.5 * atan2(ax * by - ay * bx, ax * bx + ay * by)
    if root <= 0.0 or A == 0.0:
        return whole
    s, t = (-B - sqrt(root)) / A, (-B + sqrt(root)) / A
    if s >= 1.0 or t <= 0.0:
        return whole
    s, t = max(0.0, s), min(1.0, t)
    px, py, qx, qy = ax + s * dx, ay + s * dy, ax + t * dx, ay + t * dy
    area = 0.5 * (px * qy - py * qx)
    if s > 0.0:
        area += 0.5 * atan2(ax * py - ay * px, ax * px + ay * py)
    if t < 1.0:
        area += 0.5 * atan2(qx * by - qy * bx, qx * bx + qy * by)
    return area


# ---------------------------------------------------------------------------------------- tubes


@njit(cache=True)
def _tube(p, facing, c, r, free_a, free_b, alpha):
    """Fraction of the disc that a cylinder covers.

    The planes through ``p`` that touch the cylinder contain its direction t. The sun stands psi
    from t, and turned about t by theta from the axis: an edge turned by beta = asin(r / h) from
    it, h the distance of the axis, is asin(sin(psi) sin(beta - theta)) away from the sun.
    """
    ax, ay, az = c[0, 0] - p[0], c[0, 1] - p[1], c[0, 2] - p[2]
    tx, ty, tz = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2]
    length = sqrt(tx * tx + ty * ty + tz * tz)
    if length == 0.0 or max(az, az + tz) + r <= 0.0:
        return 0.0
    tx, ty, tz = tx / length, ty / length, tz / length
    foot = -(ax * tx + ay * ty + az * tz)
    kx, ky, kz = ax + foot * tx, ay + foot * ty, az + foot * tz
    h = sqrt(kx * kx + ky * ky + kz * kz)
    across = hypot(tx, ty)
    if h < r * (1.0 - 1e-9) and 0.0 <= foot <= length:  # inside: where tubes meet
        return 1.0 if facing else 0.0
    if across < STEEP * alpha:
        return _by_rays(ax, ay, az, tx, ty, tz, length, r, free_a, free_b, alpha)
    if h < r * (1.0 - 1e-9):
        return _end_disc(ax, ay, az, tx, ty, tz, length, foot, r, free_a, free_b, alpha)
    if max(az, az + length * tz) <= 0.0:
        return 0.0
    # (t x k) . sun and k . sun, of the unit vector k from p to the axis
    theta = atan2((tx * ky - ty * kx) / h, kz / h)
    beta = asin(min(1.0, r / h))
    low, high = _edge(across, -beta - theta) / alpha, _edge(across, beta - theta) / alpha
    if low >= 1.0 or high <= -1.0:
        return 0.0
    ex, ey = tx / across, ty / across
    a, free_a = _end(ax, ay, az, tx, ty, tz, length, ex, ey, free_a, alpha)
    b, free_b = _end(
        ax + length * tx, ay + length * ty, az + length * tz, -tx, -ty, -tz, length,
        ex, ey, free_b, alpha,
    )  # fmt: skip
    if a > b:
        a, b, free_a, free_b = b, a, free_b, free_a
    covered = _corner(b, high) - _corner(a, high) - _corner(b, low) + _corner(a, low)
    if free_a:
        covered += _cap(-a, low, high, abs(tz))
    if free_b:
        covered += _cap(b, low, high, abs(tz))
    return covered


@njit(cache=True)
def _edge(across, turned):
    return asin(across * np.sin(max(-0.5 * pi, min(0.5 * pi, turned))))


@njit(cache=True)
def _end(x, y, z, tx, ty, tz, length, ex, ey, free, alpha):
    """Where an end stands along the strip, in units of the disc; cut off where it is behind."""
    least = 1e-9 * (abs(x) + abs(y) + abs(z) + length)
    if z >= least:
        return (x * ex + y * ey) / (alpha * z), free
    s = (least - z) / tz if tz > 0.0 else 0.0
    return ((x + s * tx) * ex + (y + s * ty) * ey) / (alpha * least), False


@njit(cache=True)
def _end_disc(ax, ay, az, tx, ty, tz, length, foot, r, free_a, free_b, alpha):
    """From within its extension only the near end of a cylinder is seen."""
    free = free_a if foot < 0.0 else free_b
    s = 0.0 if foot < 0.0 else length
    x, y, z = ax + s * tx, ay + s * ty, az + s * tz
    if not free or z <= 1e-9 * (abs(x) + abs(y)):
        return 0.0
    across = hypot(tx, ty)
    ex, ey = tx / across, ty / across
    along, aside, half = x * ex + y * ey, y * ex - x * ey, r / z
    low, high = (aside / z - half) / alpha, (aside / z + half) / alpha
    along /= alpha * z
    return _cap(along, low, high, abs(tz)) + _cap(-along, low, high, abs(tz))


@njit(cache=True)
def _by_rays(ax, ay, az, tx, ty, tz, length, r, free_a, free_b, alpha):
    """Fraction of rays, spread evenly over the disc, that enter a cylinder that points to the sun.

    Those that come in from the next piece of the body count there.
    """
    foot, entering = -(ax * tx + ay * ty + az * tz), 0
    ox, oy, oz = -ax - foot * tx, -ay - foot * ty, -az - foot * tz
    c = ox * ox + oy * oy + oz * oz - r * r
    if c >= 0.0 and oz > 1.01 * alpha * sqrt(ox * ox + oy * oy):  # all of the disc leads away
        return 0.0
    for i in range(RAYS):
        dx, dy = alpha * SPIRAL[i, 0], alpha * SPIRAL[i, 1]
        along = dx * tx + dy * ty + tz
        px, py, pz = dx - along * tx, dy - along * ty, 1.0 - along * tz
        a, b = px * px + py * py + pz * pz, px * ox + py * oy + pz * oz
        near, is_free = (0.0, free_a) if along > 0.0 else (length, free_b)
        s = (near - foot) / along
        square = c + (2.0 * b + s * a) * s
        if s > 0.0 and square <= 0.0:  # through the near end
            entering += 1 if is_free else 0
        elif c > 0.0 and b < 0.0 and b * b > a * c:  # through the side
            s = c / (sqrt(b * b - a * c) - b)
            if 0.0 <= foot + s * along <= length:
                entering += 1
    return entering / RAYS


@njit(cache=True)
def _below(x):
    """Fraction of the unit disc below a chord."""
    x = max(-1.0, min(1.0, x))
    return 0.5 + (x * sqrt(1.0 - x * x) + asin(x)) / pi


@njit(cache=True)
def _corner(x, y):
    """Fraction of the unit disc with coordinates less than both x and y."""
    if x <= -1.0 or y <= -1.0:
        return 0.0
    if x * x + y * y < 1.0:
        return x * y / pi + 0.5 * (_below(x) + _below(y)) - 0.25
    if x < 0.0 or y < 0.0:
        return 0.0 if x < 0.0 and y < 0.0 else _below(min(x, y))
    return _below(x) + _below(y) - 1.0


@njit(cache=True)
def _cap(x, low, high, flat):
    """Fraction of the disc under the half ellipse that begins at x, between low and high.

    flat : half axis along x over that across
    """
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    bottom, top = max(-1.0, low), min(1.0, high)
    if x >= 1.0 or top <= bottom or x + flat * half <= -1.0:
        return 0.0
    middle, reach, area = 0.5 * (bottom + top), 0.5 * (top - bottom), 0.0
    for i in range(CAP_STRIPS):
        angle = pi * ((i + 0.5) / CAP_STRIPS - 0.5)
        y = middle + reach * np.sin(angle)
        chord = sqrt(max(0.0, 1.0 - y * y))
        bulge = flat * half * sqrt(max(0.0, 1.0 - ((y - centre) / half) ** 2))
        area += max(0.0, min(chord, x + bulge) - max(-chord, x)) * np.cos(angle)
    return area * reach / CAP_STRIPS
