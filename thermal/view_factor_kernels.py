"""View factors between flat convex polygons: compiled loops of ``thermal.view_factors``.

The exchange area of two polygons, area times view factor, is a double integral along their edges
(Sparrow 1963), A F = 1/(2 pi) sum over pairs of edges of (d_p . d_q) int int ln r ds dt. The inner
integral is taken in closed form (Mitalas & Stephenson 1966), the outer by Gauss points in
intervals halved until they agree, so that polygons may share edges and corners.
"""

from math import atan2, log, pi, sqrt

import numpy as np
from numba import njit

FRONT, BACK = 1, 2
DEPTH = 40  # of halved intervals
FAR = 2.5  # distance over size of polygons from which one set of Gauss points serves
HALVINGS = 60  # of polygons that may be hidden in part, pending
HARDLY = 0.02  # area of a piece over the exchange area that is not halved further
FEW = 8  # rays between pieces, at least
PROBES = 64  # rays after which pieces that are all clear or all hidden are left

_x, _w = np.polynomial.legendre.leggauss(4)
NODES, WEIGHTS = 0.5 * (1.0 + _x), 0.5 * _w

# Generalised golden ratio, the root of x^5 = x + 1: a lattice of four dimensions (Roberts 2018)
_PHI = 1.1673039782614187
LATTICE = np.array([_PHI**-1, _PHI**-2, _PHI**-3, _PHI**-4])


@njit(cache=True)
def _along(u, h):
    """Primitive of ln sqrt(u^2 + h^2)."""
    square = u * u + h * h
    return 0.5 * u * log(square) - u + h * atan2(u, h) if square > 0.0 else 0.0


@njit(cache=True)
def _to_line(p, d, s, q, e, length):
    """Integral of ln |p + s d - q - t e| over t from 0 to length."""
    x, y, z = q[0] - p[0] - s * d[0], q[1] - p[1] - s * d[1], q[2] - p[2] - s * d[2]
    u = x * e[0] + y * e[1] + z * e[2]
    x, y, z = x - u * e[0], y - u * e[1], z - u * e[2]
    h = sqrt(x * x + y * y + z * z)
    return _along(u + length, h) - _along(u, h)


@njit(cache=True)
def _gauss(p, d, first, size, q, e, length):
    total = 0.0
    for i in range(len(NODES)):
        total += WEIGHTS[i] * _to_line(p, d, first + NODES[i] * size, q, e, length)
    return total * size


@njit(cache=True)
def _edges(p, d, extent, q, e, length, tolerance, far):
    """Double integral of ln r along two edges."""
    whole = _gauss(p, d, 0.0, extent, q, e, length)
    if far:
        return whole
    firsts, sizes, values = np.empty(DEPTH + 2), np.empty(DEPTH + 2), np.empty(DEPTH + 2)
    firsts[0], sizes[0], values[0] = 0.0, extent, whole
    count, total = 1, 0.0
    while count:
        count -= 1
        first, size, value = firsts[count], sizes[count], values[count]
        half = 0.5 * size
        left = _gauss(p, d, first, half, q, e, length)
        right = _gauss(p, d, first + half, half, q, e, length)
        if abs(left + right - value) <= tolerance or count + 2 > DEPTH:
            total += left + right
            continue
        firsts[count], sizes[count], values[count] = first, half, left
        firsts[count + 1], sizes[count + 1], values[count + 1] = first + half, half, right
        count += 2
    return total


@njit(cache=True)
def _directions(corners, n):
    """Unit edge vectors and lengths."""
    units, lengths = np.zeros((n, 3)), np.zeros(n)
    for i in range(n):
        edge = corners[(i + 1) % n] - corners[i]
        lengths[i] = sqrt(edge[0] ** 2 + edge[1] ** 2 + edge[2] ** 2)
        if lengths[i] > 0.0:
            units[i] = edge / lengths[i]
    return units, lengths


@njit(cache=True)
def contour(one, n, other, m, tolerance, far):
    """Exchange area of two polygons that wholly see one another."""
    d, ds = _directions(one, n)
    e, es = _directions(other, m)
    total = 0.0
    for i in range(n):
        for j in range(m):
            cosine = d[i, 0] * e[j, 0] + d[i, 1] * e[j, 1] + d[i, 2] * e[j, 2]
            if abs(cosine) > 1e-15 and ds[i] > 0.0 and es[j] > 0.0:
                total += cosine * _edges(one[i], d[i], ds[i], other[j], e[j], es[j], tolerance, far)
    return max(0.0, total / (2.0 * pi))


@njit(cache=True)
def _height(plane, x):
    return plane[0] * x[0] + plane[1] * x[1] + plane[2] * x[2] - plane[3]


@njit(cache=True)
def clip(corners, n, plane, out):
    """The part of a polygon in front of a plane (Sutherland & Hodgman 1974); its corners."""
    m = 0
    for i in range(n):
        a, b = corners[i], corners[(i + 1) % n]
        before, after = _height(plane, a), _height(plane, b)
        if before >= 0.0:
            out[m] = a
            m += 1
        if before * after < 0.0:
            out[m] = a + (b - a) * (before / (before - after))
            m += 1
    return m


@njit(cache=True)
def sides(corners, counts, planes, slack):
    """(n, n) FRONT and BACK: where of the plane of the first the second polygon has corners."""
    n = len(counts)
    found = np.zeros((n, n), np.uint8)
    for k in range(n):
        for i in range(n):
            for c in range(counts[i]):
                h = _height(planes[k], corners[i, c])
                if h > slack:
                    found[k, i] |= FRONT
                elif h < -slack:
                    found[k, i] |= BACK
    return found


@njit(cache=True)
def _candidates(i, j, where, centres, radii, out):
    """Polygons that may come between two others; how many."""
    m, d = 0, centres[j] - centres[i]
    square = max((d**2).sum(), 1e-300)
    reach = max(radii[i], radii[j])
    for k in range(len(radii)):
        if k in (i, j) or where[k, i] | where[k, j] != FRONT | BACK:
            continue
        if not (where[i, k] & FRONT and where[j, k] & FRONT):
            continue
        s = min(1.0, max(0.0, ((centres[k] - centres[i]) * d).sum() / square))
        gap = centres[k] - centres[i] - s * d
        if (gap**2).sum() <= (radii[k] + reach) ** 2:
            out[m] = k
            m += 1
    return m


@njit(cache=True)
def _fan(corners, n):
    """Twice the areas of the triangles from the first corner."""
    areas = np.empty(n - 2)
    for i in range(n - 2):
        a, b = corners[i + 1] - corners[0], corners[i + 2] - corners[0]
        x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        areas[i] = sqrt(x * x + y * y + z * z)
    return areas


@njit(cache=True)
def _point(corners, areas, u, v, out):
    """Point of a convex polygon, even by area for even (u, v) in the unit square."""
    u *= areas.sum()
    i = 0
    while i < len(areas) - 1 and u > areas[i]:
        u -= areas[i]
        i += 1
    s = sqrt(min(1.0, u / areas[i])) if areas[i] > 0.0 else 0.0
    for c in range(3):
        far = corners[i + 1, c] * (1.0 - v) + corners[i + 2, c] * v
        out[c] = corners[0, c] * (1.0 - s) + far * s


@njit(cache=True)
def _hit(a, b, k, corners, counts, planes):
    """Whether the ray from a to b passes through polygon k."""
    nx, ny, nz = planes[k, 0], planes[k, 1], planes[k, 2]
    before = nx * a[0] + ny * a[1] + nz * a[2] - planes[k, 3]
    after = nx * b[0] + ny * b[1] + nz * b[2] - planes[k, 3]
    if before * after >= 0.0:
        return False
    s = before / (before - after)
    x, y, z = a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])
    last = counts[k] - 1
    px, py, pz = corners[k, last, 0], corners[k, last, 1], corners[k, last, 2]
    for i in range(counts[k]):
        qx, qy, qz = corners[k, i, 0], corners[k, i, 1], corners[k, i, 2]
        ex, ey, ez, rx, ry, rz = qx - px, qy - py, qz - pz, x - px, y - py, z - pz
        turn = nx * (ey * rz - ez * ry) + ny * (ez * rx - ex * rz) + nz * (ex * ry - ey * rx)
        if turn < 0.0:
            return False
        px, py, pz = qx, qy, qz
    return True


@njit(cache=True)
def _clear(a, b, blockers, m, corners, counts, planes):
    """Whether none is hit; the one that is goes to the front, as the next ray may hit it too."""
    for k in range(m):
        which = blockers[k]
        if _hit(a, b, which, corners, counts, planes):
            blockers[k], blockers[0] = blockers[0], which
            return False
    return True


@njit(cache=True)
def _some(one, n, other, m, normals, blockers, k, corners, counts, planes, first, rays):
    """Exchange area by rays between points of two polygons, and what of it others leave."""
    a, b, clear, total = np.empty(3), np.empty(3), 0.0, 0.0
    one_areas, other_areas = _fan(one, n), _fan(other, m)
    for ray in range(first, first + rays):
        t = ray + 1.0
        u, v = (0.5 + t * LATTICE[0]) % 1.0, (0.5 + t * LATTICE[1]) % 1.0
        _point(one, one_areas, u, v, a)
        u, v = (0.5 + t * LATTICE[2]) % 1.0, (0.5 + t * LATTICE[3]) % 1.0
        _point(other, other_areas, u, v, b)
        from_one, from_other, square = 0.0, 0.0, 0.0
        for c in range(3):
            r = b[c] - a[c]
            from_one += normals[0, c] * r
            from_other -= normals[1, c] * r
            square += r * r
        weight = max(0.0, from_one * from_other / (square * square))
        total += weight
        if _clear(a, b, blockers, k, corners, counts, planes):
            clear += weight
        if ray - first == PROBES - 1 and (clear == 0.0 or clear == total):
            rays = PROBES
            break
    scale = 0.25 * one_areas.sum() * other_areas.sum() / (pi * rays)
    return total * scale, clear * scale


@njit(cache=True)
def _longest(corners, n, plane):
    """Length of the longest edge, and in ``plane`` that normal to it through the middle."""
    longest, middle = 0.0, np.zeros(3)
    for i in range(n):
        edge = corners[(i + 1) % n] - corners[i]
        length = sqrt((edge**2).sum())
        middle += corners[i] / n
        if length > longest:
            longest = length
            plane[:3] = edge / length
    plane[3] = (plane[:3] * middle).sum()
    return longest


@njit(cache=True)
def visible(one, n, other, m, normals, blockers, k, corners, counts, planes, free, rays, pending):
    """Share of the exchange ``free`` of two polygons that others leave.

    The polygons are halved until they are small against their distance or hardly count; then
    rays go between points of the pieces, as many as the piece has a share.
    """
    ones, others, sizes, p, q = pending
    cut, cut_other = np.empty(4), np.empty(4)
    ones[0, :n], others[0, :m] = one[:n], other[:m]
    sizes[0] = n, m
    count, cast, total, clear = 1, 0, 0.0, 0.0
    while count:
        count -= 1
        n, m = sizes[count]
        p[:n], q[:m] = ones[count, :n], others[count, :m]
        size, size_other = _longest(p, n, cut), _longest(q, m, cut_other)
        areas = 0.5 * _fan(p, n).sum(), 0.5 * _fan(q, m).sum()
        apart = 0.0
        for d in range(3):
            apart += (p[:n, d].mean() - q[:m, d].mean()) ** 2
        small = min(areas) <= HARDLY * free
        if max(size, size_other) ** 2 <= apart or small or count + 2 > HALVINGS:
            part = min(1.0, areas[0] * areas[1] / (pi * apart * free)) if apart > 0.0 else 1.0
            some = max(FEW, int(rays * part))
            whole, left = _some(
                p, n, q, m, normals, blockers, k, corners, counts, planes, cast, some
            )
            total, clear, cast = total + whole, clear + left, cast + some
            continue
        for _ in range(2):
            if size >= size_other:
                sizes[count, 0], sizes[count, 1] = clip(p, n, cut, ones[count]), m
                others[count, :m] = q[:m]
            else:
                sizes[count, 0], sizes[count, 1] = n, clip(q, m, cut_other, others[count])
                ones[count, :n] = p[:n]
            count += sizes[count, 0] >= 3 and sizes[count, 1] >= 3
            cut *= -1.0
            cut_other *= -1.0
    return clear / total if total > 0.0 else 0.0


@njit(cache=True)
def exchange(corners, counts, planes, centres, radii, areas, slack, tolerance, rays):
    """(n, n) exchange areas, symmetric."""
    n, c = corners.shape[0], corners.shape[1]
    where = sides(corners, counts, planes, slack)
    found = np.zeros((n, n))
    one, other = np.empty((c + 2, 3)), np.empty((c + 2, 3))
    blockers, normals = np.empty(n, np.int64), np.empty((2, 3))
    room = c + 2 + HALVINGS
    pending = (
        np.empty((HALVINGS + 2, room, 3)), np.empty((HALVINGS + 2, room, 3)),
        np.empty((HALVINGS + 2, 2), np.int64), np.empty((room, 3)), np.empty((room, 3)),
    )  # fmt: skip
    for i in range(n):
        for j in range(i + 1, n):
            if not (where[i, j] & FRONT and where[j, i] & FRONT):
                continue
            p = clip(corners[i], counts[i], planes[j], one)
            q = clip(corners[j], counts[j], planes[i], other)
            if p < 3 or q < 3:
                continue
            distance = sqrt(((centres[j] - centres[i]) ** 2).sum())
            far = distance > FAR * 2.0 * (radii[i] + radii[j])
            free = contour(one, p, other, q, tolerance * min(areas[i], areas[j]), far)
            k = _candidates(i, j, where, centres, radii, blockers)
            share = 1.0
            if k and free > 0.0:
                normals[0], normals[1] = planes[i, :3], planes[j, :3]
                share = visible(
                    one,
                    p,
                    other,
                    q,
                    normals,
                    blockers,
                    k,
                    corners,
                    counts,
                    planes,
                    free,
                    rays,
                    pending,
                )
            found[i, j] = found[j, i] = share * free
    return found
