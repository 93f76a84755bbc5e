"""Compiled forces of a tube in a tube, see ``mechanics.telescope``.

A station has its own section (position p and gradient p', p_y, p_z of one tube, with constant
weights) and the axis x(s) of the other tube, on which its foot is: D = p - x(s) with D.x' = 0. The
normal force belongs to the depth

    δ = ρ - core - c(s) - φ(s),   ρ² = D.D + core²,   φ = (distance beyond the end)²/(2 rim),

and does work on all that changes δ, s among it. A seized tube, c < 0, is pressed from all sides:
core = -c/3 gives it the lateral stiffness 3 K |c|^1/2 of two opposite contacts with K |c|^3/2 each.
A ring of sprung pads has core = -c and F = K δ: K sideways, and N² = (c K)² + (K |D|)².

Friction acts at the place r_i + R n of the wall: as material of both tubes it has the weights W
that the section's gradient F gives it, 1 + ξ, η, ζ with F (ξ, η, ζ) the way there from the axis.
Its velocities, and hence slip, are sums with these weights, and so are the forces that belong to
it: their power is T.V, and they have no resultant.

Derivatives are taken by the same code with complex numbers, exact to round-off (Squire & Trapp
1998).
"""

import numpy as np
from numba import njit

from mechanics.contact_laws import (
    ACTIVE,
    BRISTLE,
    CLEARANCE,
    CORE,
    CYLINDER,
    KINETIC,
    LAW,
    RADIUS,
    SEIZED,
    SLOT,
    STATIC,
    K,
    P,
    friction,
    normal,
    stored,
)
from mechanics.kernels import ENERGY, FORCE, REMEMBER, RESPOND, TANGENT, kernel

COUNT, FIRST, STRIDE, NODES, PAIR, BAND, WIDE, OWN = range(8)
"""Columns of ``ints``: own vectors; first coordinate of the other tube, from node to node, nodes;
first row of slots, one for each element of its band; first element of that, and how many there are;
own vectors. A tangent outside of the band has no place in the matrix and is left out."""
SIGN, RIM, WEIGHTS, LENGTHS = 0, 1, 2, 34
"""Columns of ``floats``: 1 where the station is of the inner tube, -1 where it is of the outer one;
radius of the rims; weights (4, 8) of own vectors in p, p', p_y, p_z; arc length at nodes."""
PLACED = 5
"""Coefficients that follow the place on the other tube, after those of a slot: for each of its
nodes clearance, stiffness, kinetic and static friction, stiffness of bristles."""
VECTORS = 8
"""Vectors of an element of the other tube, and the most that a section has."""
FAR = 2.0
"""Radii of the tube beyond an end where no station touches [-]."""
LOCAL = 12
"""Local vectors: the own section, two nodes of the other tube."""
_STEP = 1e-30  # of the imaginary parts
_CLOSE = 1e-9  # of the length of a tube: the last correction of a foot leaves its square


# -- the axis ------------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def axis_weights(s, a, b, h):
    """h (3, 4): weights of r_a, r_x,a, r_b, r_x,b in r, r', r'' at s; straight beyond the ends."""
    L, x = b - a, (s - a) / (b - a)
    h[:] = 0.0
    if x.real < 0.0:
        h[0, 0], h[0, 1], h[1, 1] = 1.0, s - a, 1.0
    elif x.real > 1.0:
        h[0, 2], h[0, 3], h[1, 3] = 1.0, s - b, 1.0
    else:
        y = 1.0 - x
        h[0, 0], h[0, 2] = y * y * (1.0 + 2.0 * x), x * x * (3.0 - 2.0 * x)
        h[0, 1], h[0, 3] = L * x * y * y, -L * x * x * y
        h[1, 2], h[1, 1], h[1, 3] = 6.0 * x * y / L, y * (1.0 - 3.0 * x), x * (3.0 * x - 2.0)
        h[2, 2], h[2, 1], h[2, 3] = 6.0 * (y - x) / L**2, (6 * x - 4) / L, (6 * x - 2) / L
        h[1, 0], h[2, 0] = -h[1, 2], -h[2, 2]


@njit(cache=True, error_model="numpy")
def _section_weight(s, a, b):
    """Weight of the second node in directions of the section."""
    x = (s - a) / (b - a)
    if x.real < 0.0:
        return 0.0 * x
    return 0.0 * x + 1.0 if x.real > 1.0 else x


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def _axis(h, Y, x):
    """x (3, 3): position and two derivatives; Y (8, 3): vectors of both nodes."""
    for k in range(3):
        for i in range(3):
            x[k, i] = h[k, 0] * Y[0, i] + h[k, 1] * Y[1, i] + h[k, 2] * Y[4, i] + h[k, 3] * Y[5, i]


@njit(cache=True, error_model="numpy")
def _ahead(y, p, at):
    """(p - r).r_x at a node: positive where p is ahead of it; and r_x.r_x."""
    along, size = 0.0, 0.0
    for i in range(3):
        along += (p[i] - y[at + i]) * y[at + 3 + i]
        size += y[at + 3 + i] ** 2
    return along, size


@njit(cache=True, error_model="numpy")
def _foot(y, p, line, lengths, Y, h, x):
    """Element and arc length of the foot of p, bisecting for the element.

    A point on a plane curve that turns by less than 180 degrees is ahead of all nodes behind it.
    """
    first, stride, last = line[FIRST], line[STRIDE], line[NODES] - 1
    ahead, size = _ahead(y, p, first)
    if ahead <= 0.0:
        return 0, ahead / size
    behind, size = _ahead(y, p, first + stride * last)
    if behind >= 0.0:
        return last - 1, lengths[last] + behind / size
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        value, _ = _ahead(y, p, first + stride * middle)
        if value > 0.0:
            low, ahead = middle, value
        else:
            high, behind = middle, value
    part = ahead / (ahead - behind)
    _take(y, line, low, Y)
    return low, _closest(p, lengths[low], lengths[high], part, lengths[last], Y, h, x)


@njit(cache=True, error_model="numpy")
def _closest(p, a, b, part, length, Y, h, x):
    """Newton's method, kept between bounds, for (p - x).x' = 0 in an element."""
    low, high, s = a, b, a + part * (b - a)
    for _ in range(100):
        axis_weights(s, a, b, h)
        _axis(h, Y, x)
        value, slope = 0.0, 0.0
        for i in range(3):
            value += (p[i] - x[0, i]) * x[1, i]
            slope += (p[i] - x[0, i]) * x[2, i] - x[1, i] * x[1, i]
        if value > 0.0:
            low = s
        else:
            high = s
        step = -value / slope
        if abs(step) <= _CLOSE * length:
            return s + step
        s = s + step if low <= s + step <= high else 0.5 * (low + high)
    return s


@njit(cache=True, error_model="numpy")
def _take(y, line, element, Y):
    """Vectors of both nodes of an element of the other tube."""
    for k in range(VECTORS):
        at = line[FIRST] + (element + k // 4) * line[STRIDE] + 3 * (k % 4)
        for i in range(3):
            Y[k, i] = y[at + i]


@njit(cache=True, error_model="numpy")
def _own(y, line, floats, first, last, Q):
    """Those of p, p', p_y, p_z from ``first`` to before ``last``."""
    for m in range(first, last):
        Q[m] = 0.0
        for k in range(line[COUNT]):
            weight = floats[WEIGHTS + VECTORS * m + k]
            if weight != 0.0:
                for i in range(3):
                    Q[m, i] += weight * y[line[OWN + k] + i]


# -- a station in contact ------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _flare(s, rim, length):
    """By how much the bore is wider at s, and the slope of that: its rims are round."""
    beyond = s if s.real < 0.0 else (s - length if s.real > length else 0.0 * s)
    return beyond * beyond / (2.0 * rim), beyond / rim


@njit(cache=True, error_model="numpy")
def _here(coef, element, part, length, c):
    """Coefficients c (SLOT,) at a place of the other tube, and the slope of the clearance."""
    c[:] = coef[:SLOT]
    a = SLOT + PLACED * element
    b = a + PLACED
    c[CLEARANCE] = (1.0 - part) * coef[a] + part * coef[b]
    c[K] = (1.0 - part) * coef[a + 1] + part * coef[b + 1]
    c[KINETIC] = (1.0 - part) * coef[a + 2] + part * coef[b + 2]
    c[STATIC] = (1.0 - part) * coef[a + 3] + part * coef[b + 3]
    c[BRISTLE] = (1.0 - part) * coef[a + 4] + part * coef[b + 4]
    c[P] = coef[P] * c[K] / coef[K] if c[LAW] == CYLINDER else coef[P]
    c[CORE] = max(abs(c[CORE]), -(SEIZED if c[CORE] >= 0.0 else 1.0) * c[CLEARANCE])
    return (coef[b] - coef[a]) / length if 0.0 < part < 1.0 else 0.0


@njit(cache=True, error_model="numpy")
def _depth(Q, place, slope, c, room):
    """Depth, foot, gap, ∂(D.x')/∂s; in the room D and the gradient G (12, 3) of depth, G[12] = D/ρ.

    ``place`` (6,): foot, ends of the element, length of the tube, rim, sign. The foot makes one
    step of Newton's method, with which complex numbers carry its derivative.
    """
    h, x, D, G = room[0], room[1], room[2], room[3]
    s0, a, b, length, rim = place[0], place[1], place[2], place[3], place[4]
    Y, s, bend = Q[4:], s0 + 0.0 * Q[0, 0], 0.0 * Q[0, 0]
    for correcting in range(2):
        axis_weights(s, a, b, h)
        _axis(h, Y, x)
        for i in range(3):
            D[i] = Q[0, i] - x[0, i]
        bend = _dot(D, x[2]) - _dot(x[1], x[1])
        if correcting == 0:
            s = s - _dot(D, x[1]) / bend
    flare, steeper = _flare(s, rim, length)
    rho = np.sqrt(_dot(D, D) + c[CORE] ** 2)
    gap = c[CLEARANCE] + slope * (s - s0) + flare
    wider = (slope + steeper) / bend
    G[:] = 0.0
    for i in range(3):
        u = D[i] / rho
        G[12, i] = u
        G[0, i] = u + wider * x[1, i]
        for j in range(4):
            k = 4 + 4 * (j // 2) + j % 2
            G[k, i] = -h[0, j] * u - wider * (h[0, j] * x[1, i] - h[1, j] * D[i])
    return rho - c[CORE] - gap, s, gap, bend


@njit(cache=True, error_model="numpy")
def _parts(F, way, parts):
    """Solve F0 parts0 + F1 parts1 + F2 parts2 = way for three vectors."""
    det = 0.0 * way[0]
    parts[:] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        det += F[0, i] * (F[1, j] * F[2, k] - F[1, k] * F[2, j])
        for m in range(3):
            u, w = F[(m + 1) % 3], F[(m + 2) % 3]
            parts[m] += way[i] * (u[j] * w[k] - u[k] * w[j])
    for m in range(3):
        parts[m] /= det


@njit(cache=True, error_model="numpy")
def _wall(Q, place, s, c, room, W):
    """Weights W (12,) of the local vectors in the velocity of the inner against the outer wall.

    They leave the gradient (3, 3) of the outer section in the room.
    """
    h, x, D, G, F, way, parts, _ = room
    sign, part = place[5], _section_weight(s, place[1], place[2])
    for turn in range(2):  # the outer tube last
        searched = (turn == 1) == (sign > 0.0)
        for i in range(3):
            F[0, i] = x[1, i] if searched else Q[1, i]
            F[1, i] = (1.0 - part) * Q[6, i] + part * Q[10, i] if searched else Q[2, i]
            F[2, i] = (1.0 - part) * Q[7, i] + part * Q[11, i] if searched else Q[3, i]
            way[i] = sign * c[RADIUS] * G[12, i]
            if turn == 1:
                way[i] += sign * D[i]
        _parts(F, way, parts)
        if searched:
            for j in range(4):
                W[4 + 4 * (j // 2) + j % 2] = -sign * (h[0, j] + parts[0] * h[1, j])
            for m in range(2):
                W[6 + m] = -sign * (1.0 - part) * parts[1 + m]
                W[10 + m] = -sign * part * parts[1 + m]
        else:
            W[0] = sign + 0.0 * part
            for m in range(3):
                W[1 + m] = sign * parts[m]


@njit(cache=True, error_model="numpy")
def _upright(F, B):
    """Orthonormal rows B: the first vector of F, the part of the second across it, the third."""
    size = np.sqrt(_dot(F[0], F[0]))
    for i in range(3):
        B[0, i] = F[0, i] / size
    along = _dot(F[1], B[0])
    for i in range(3):
        B[1, i] = F[1, i] - along * B[0, i]
    size = np.sqrt(_dot(B[1], B[1]))
    for i in range(3):
        B[1, i] /= size
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        B[2, i] = B[0, j] * B[1, k] - B[0, k] * B[1, j]


@njit(cache=True, error_model="numpy")
def _rub(Q, V, place, s, c, force, room, f, r, new):
    """Add friction of a normal ``force`` to f; its columns of the response, its history."""
    G, F, parts, B = room[3], room[4], room[6], room[7]
    slip, n, T, W = B[3], B[4], B[5], B[6:10].reshape(12)
    _wall(Q, place, s, c, room, W)
    _upright(F, B)
    slip[:] = 0.0
    for k in range(LOCAL):
        for i in range(3):
            slip[i] += W[k] * V[k, i]
    normal_speed = _dot(slip, G[12])
    for i in range(3):
        parts[i] = slip[i] - G[12, i] * normal_speed
    for i in range(3):
        slip[i], n[i], T[i] = _dot(B[i], parts), place[5] * _dot(B[i], G[12]), 0.0
    r[17] = friction(slip, n, force, c, T, new)
    for i in range(3):
        r[11 + i], r[14 + i] = T[i], slip[i]
    for i in range(3):
        pull = B[0, i] * T[0] + B[1, i] * T[1] + B[2, i] * T[2]
        for k in range(LOCAL):
            f[k, i] -= W[k] * pull


@njit(cache=True, error_model="numpy")
def _contact(Q, V, place, slope, c, room, f, r, new):
    """Resisting force f (12, 3) on the local vectors, response r (20,), history new (7,)."""
    h, x, D, G = room[0], room[1], room[2], room[3]
    r[:], new[:] = 0.0, 0.0
    depth, s, gap, bend = _depth(Q, place, slope, c, room)
    rate, passing = 0.0 * depth, -_dot(x[1], V[0]) / bend
    for k in range(LOCAL):
        rate += _dot(G[k], V[k])
    for j in range(4):
        k = 4 + 4 * (j // 2) + j % 2
        passing += (h[0, j] * _dot(x[1], V[k]) - h[1, j] * _dot(D, V[k])) / bend
    for i in range(3):
        speed = V[0, i] - x[1, i] * passing
        for j in range(4):
            speed -= h[0, j] * V[4 + 4 * (j // 2) + j % 2, i]
        r[i], r[3 + i] = place[5] * D[i], place[5] * speed
    r[6], r[7], r[8], r[19] = gap, depth, rate, s
    r[9], r[10] = normal(depth, rate, c)
    force = r[9] + r[10]
    for k in range(LOCAL):
        for i in range(3):
            f[k, i] = force * G[k, i]
    _rub(Q, V, place, s, c, force, room, f, r, new)


@njit(cache=True, error_model="numpy")
def _room(like):
    """Room to work, numbers as ``like``: h, x, D, G, F, two vectors, B with what follows it."""
    kind = like.dtype
    return (
        np.zeros((3, 4), kind), np.zeros((3, 3), kind), np.zeros(3, kind), np.zeros((13, 3), kind),
        np.zeros((3, 3), kind), np.zeros(3, kind), np.zeros(3, kind), np.zeros((10, 3), kind),
    )  # fmt: skip


# -- all stations --------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _found(y, line, floats, Q, place, room):
    """Element of the foot and distance; the ``place``; of Q the position and the element."""
    h, x, lengths, last = room[0], room[1], floats[LENGTHS:], line[NODES] - 1
    _own(y, line, floats, 0, 1, Q)
    element, s = _foot(y, Q[0], line, lengths, Q[4:], h, x)
    place[0], place[1], place[2] = s, lengths[element], lengths[element + 1]
    place[3], place[4], place[5] = lengths[last], floats[RIM], floats[SIGN]
    _take(y, line, element, Q[4:])
    axis_weights(s, place[1], place[2], h)
    _axis(h, Q[4:], x)
    size = 0.0
    for i in range(3):
        size += (Q[0, i] - x[0, i]) ** 2
    return element, np.sqrt(size)


@njit(cache=True, error_model="numpy")
def feet(y, ints, floats):
    """(E, 2) arc length [m] of the foot of every station, and its distance [m]."""
    found, Q, place = np.zeros((ints.shape[0], 2)), np.zeros((LOCAL, 3)), np.zeros(6)
    room = _room(Q)
    for e in range(ints.shape[0]):
        _, found[e, 1] = _found(y, ints[e], floats[e], Q, place, room)
        found[e, 0] = place[0]
    return found


@njit(cache=True, error_model="numpy")
def _station(y, line, floats, coef, Q, place, c, room):
    """Element of the foot, slope of the clearance there, depth: not a number where far off."""
    element, distance = _found(y, line, floats, Q, place, room)
    part = _section_weight(place[0], place[1], place[2])
    slope = _here(coef, element, part, place[2] - place[1], c)
    if max(-place[0], place[0] - place[3]) > FAR * c[RADIUS]:
        return element, 0.0, np.nan
    flare, _ = _flare(place[0], place[4], place[3])
    return element, slope, np.sqrt(distance**2 + c[CORE] ** 2) - c[CORE] - c[CLEARANCE] - flare


@njit(cache=True, error_model="numpy")
def _gather(y, v, line, floats, element, Q, V):
    """All local vectors and their velocities, where Q has position and element already."""
    _own(y, line, floats, 1, 4, Q)
    _own(v, line, floats, 0, 4, V)
    _take(v, line, element, V[4:])


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Resisting force of every station in contact."""
    Q, V, f = np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3))
    place, c, room, r, new = np.zeros(6), np.zeros(SLOT), _room(Q), np.zeros(20), np.zeros(7)
    for e in range(ints.shape[0]):
        if coef[e, ACTIVE] == 0.0:
            continue
        line = ints[e]
        element, slope, depth = _station(y, line, floats[e], coef[e], Q, place, c, room)
        if not depth > 0.0:
            continue
        _gather(y, v, line, floats[e], element, Q, V)
        _contact(Q, V, place, slope, c, room, f, r, new)
        for k in range(line[COUNT]):
            for m in range(4):
                weight = floats[e, WEIGHTS + VECTORS * m + k]
                for i in range(3):
                    out[line[OWN + k] + i] += weight * f[m, i]
        for k in range(VECTORS):
            at = line[FIRST] + (element + k // 4) * line[STRIDE] + 3 * (k % 4)
            for i in range(3):
                out[at + i] += f[4 + k, i]


@njit(cache=True, error_model="numpy")
def _local_tangent(Q, V, place, slope, c, cK, cC, complex_room, T):
    """T (36, 36) = cK ∂f/∂q + cC ∂f/∂v of the local vectors."""
    room, q, w, f, r, new = complex_room
    for i in range(3 * LOCAL):
        for k in range(LOCAL):
            for m in range(3):
                here = 1.0 if 3 * k + m == i else 0.0
                q[k, m] = complex(Q[k, m], _STEP * cK * here)
                w[k, m] = complex(V[k, m], _STEP * cC * here)
        _contact(q, w, place, slope, c, room, f, r, new)
        for k in range(LOCAL):
            for m in range(3):
                T[3 * k + m, i] = f[k, m].imag / _STEP


@njit(cache=True, error_model="numpy")
def _spread(T, floats, count, places, half, wide):
    """T, with the own section as what its vectors weigh; ``places`` own vectors have room."""
    own = 3 * places
    half[:] = 0.0
    wide[:] = 0.0
    for j in range(36):
        for i in range(24):
            half[own + i, j] = T[12 + i, j]
        for k in range(count):
            for m in range(4):
                weight = floats[WEIGHTS + VECTORS * m + k]
                if weight != 0.0:
                    for i in range(3):
                        half[3 * k + i, j] += weight * T[3 * m + i, j]
    for j in range(own + 24):
        for i in range(24):
            wide[j, own + i] = half[j, 12 + i]
        for k in range(count):
            for m in range(4):
                weight = floats[WEIGHTS + VECTORS * m + k]
                if weight != 0.0:
                    for i in range(3):
                        wide[j, 3 * k + i] += weight * half[j, 3 * m + i]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Tangent of every station in contact."""
    Q, V, T = np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3)), np.zeros((36, 36))
    place, c, room = np.zeros(6), np.zeros(SLOT), _room(Q)
    z = np.zeros((LOCAL, 3), np.complex128)
    complex_room = (
        _room(z), z, np.zeros_like(z), np.zeros_like(z), np.zeros(20, z.dtype), np.zeros(7, z.dtype)
    )  # fmt: skip
    size = int(np.sqrt(slots.shape[1]) + 0.5)
    half, wide, places = np.zeros((size, 36)), np.zeros((size, size)), ints.shape[1] - OWN
    for e in range(ints.shape[0]):
        if coef[e, ACTIVE] == 0.0:
            continue
        element, slope, depth = _station(y, ints[e], floats[e], coef[e], Q, place, c, room)
        if not depth > 0.0:
            continue
        beyond = element - ints[e, BAND]
        if beyond < 0 or beyond >= ints[e, WIDE]:
            continue
        _gather(y, v, ints[e], floats[e], element, Q, V)
        _local_tangent(Q, V, place, slope, c, cK, cC, complex_room, T)
        _spread(T, floats[e], ints[e, COUNT], places, half, wide)
        slot = slots[ints[e, PAIR] + beyond]
        for i in range(size):
            for j in range(size):
                data[slot[size * i + j]] += wide[i, j]


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    """Elastic energy of every station in contact."""
    Q, place, c = np.zeros((LOCAL, 3)), np.zeros(6), np.zeros(SLOT)
    room = _room(Q)
    for e in range(ints.shape[0]):
        _, _, depth = _station(y, ints[e], floats[e], coef[e], Q, place, c, room)
        if depth > 0.0 and c[ACTIVE] != 0.0:
            out[0] += stored(depth, c)


@kernel(RESPOND)
def respond(y, v, coef, ints, floats, response):
    """Response of every station; far from the other tube it is in the middle of a wide bore."""
    Q, V, f = np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3))
    place, c, room, new = np.zeros(6), np.zeros(SLOT), _room(Q), np.zeros(7)
    for e in range(ints.shape[0]):
        element, slope, depth = _station(y, ints[e], floats[e], coef[e], Q, place, c, room)
        if np.isnan(depth):
            response[e] = 0.0
            response[e, 6] = c[CLEARANCE] + (FAR * c[RADIUS]) ** 2 / (2.0 * place[4])
            response[e, 7], response[e, 19] = -response[e, 6], place[0]
        else:
            _gather(y, v, ints[e], floats[e], element, Q, V)
            _contact(Q, V, place, slope, c, room, f, response[e], new)


@kernel(REMEMBER)
def remember(y, v, coef, ints, floats, history):
    """History of friction of every station at the end of a step."""
    Q, V, f = np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3)), np.zeros((LOCAL, 3))
    place, c, room, r = np.zeros(6), np.zeros(SLOT), _room(Q), np.zeros(20)
    for e in range(ints.shape[0]):
        element, slope, depth = _station(y, ints[e], floats[e], coef[e], Q, place, c, room)
        history[e] = 0.0
        if depth > 0.0:
            _gather(y, v, ints[e], floats[e], element, Q, V)
            _contact(Q, V, place, slope, c, room, f, r, history[e])
