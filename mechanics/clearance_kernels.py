"""Compiled forces of the joints of ``mechanics.clearance``.

Local coordinates x (18,) are r, p, s of journal and bearing. Nine measures z say how the journal
stands in the bearing (``mechanics.relative``), all along the axes b1, b2, b3 of the bearing:

    y   from the centre of the bearing to that of the journal,
    t   direction of the journal that is along b3 in the reference,   m   the one along b1.

The journal turns with the orthonormal triad of t, then m; its angular velocity in the bearing is

    ω = t × ṫ/t² + τ g·(ṁ − (t × ṫ/t²) × m),    τ = t/|t|,   g = τ × m/|m − (m·τ) τ|²,

whatever the lengths of t and m. A contact point exerts a force f on the journal and a moment M
about its centre; their power f·ẏ + M·ω gives the force φ that belongs to z, and f_x = Zᵀφ.

Derivatives of φ by z and ż are taken by the same code with complex numbers, exact to round-off
(Squire & Trapp 1998), so that they cannot disagree with the forces.
"""

import numpy as np
from numba import njit

from mechanics.clearance_lanes import (
    CONSTANTS,
    LOCAL,
    MORE,
    PRESENT,
    gathered,
    measured,
)
from mechanics.contact_laws import (
    ACTIVE,
    CENTRE,
    CLEARANCE,
    COLUMNS,
    CORE,
    RADIUS,
    SLOT,
    friction,
    normal,
    stored,
)
from mechanics.kernels import ENERGY, FORCE, REMEMBER, RESPOND, TANGENT, kernel
from mechanics.lanes import WIDTH
from mechanics.relative import DIRECTION, OFFSET, evaluate, expand, gather, scratch, spread

ORIGIN, JOURNAL, BEARING, PLACES = 0, 3, 17, 38
"""Columns of ``floats``: origin (3), two directions of the journal (7 each), three of the bearing
(7 each), geometry of the contact points (``POINT`` each), then weights of the K vectors of both
ends."""
VECTORS = 2
"""Column of ``ints`` where the K vectors of both ends begin, after their numbers."""

RING, BALL, VERTEX = range(3)
"""Kinds of contact points: of a pin in the end of a bore, a ball in a socket, a corner at a wall.
"""
POINT = 8
"""Geometry of a contact point: kind; height of the end of the bore along b3, or the corner (3) in
the triad of the journal; normal (3) and distance of the wall."""
_STEP = 1e-30  # of the imaginary parts


@njit(cache=True, error_model="numpy")
def _local(y, v, ints, floats, weights, x, u):
    """Local coordinates and velocities."""
    K = (ints.size - VECTORS) // 2
    for side in range(2):
        vectors = ints[VECTORS + K * side :]
        w = floats[weights + 3 * K * side :]
        gather(y, vectors, w, ints[side], x, 9 * side)
        gather(v, vectors, w, ints[side], u, 9 * side)


@njit(cache=True, error_model="numpy")
def _measure(x, floats, z, Z, H, work):
    """z (9,), its gradients Z (9, 18) and, where H has rows, second derivatives H (9, 18, 18).

    A direction that the journal lacks is that of the bearing.
    """
    none = np.empty((0, 18))
    Z[:] = 0.0
    H[:] = 0.0
    for k in range(9):
        kind = OFFSET if k < 3 else DIRECTION
        u = floats[JOURNAL + 7 * max(0, k // 3 - 1) :]
        w = floats[BEARING + 7 * (k % 3) :]
        bend = H[k] if H.shape[0] > 0 else none
        if kind == DIRECTION and not np.any(u[:7]):
            z[k] = 1.0 if k == 5 or k == 6 else 0.0
            continue
        z[k] = evaluate(kind, x, floats[ORIGIN:], u, w, 1.0, Z[k], bend, work)


@njit(cache=True, error_model="numpy")
def _rates(Z, u, w):
    """w (9,) = Z u."""
    for k in range(9):
        w[k] = 0.0
        for i in range(18):
            w[k] += Z[k, i] * u[i]


@njit(cache=True, error_model="numpy")
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def _scaled(f, a):
    return f * a[0], f * a[1], f * a[2]


@njit(cache=True, error_model="numpy")
def _sum(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(cache=True, error_model="numpy")
def _turning(z, w):
    """τ, m across τ, g, and the angular velocity of the journal in the bearing."""
    t, m, size = (z[3], z[4], z[5]), (z[6], z[7], z[8]), z[3] ** 2 + z[4] ** 2 + z[5] ** 2
    tau = _scaled(1.0 / np.sqrt(size), t)
    side = _sum(m, _scaled(-_dot(m, tau), tau))
    g = _scaled(1.0 / _dot(side, side), _cross(tau, side))
    tilting = _scaled(1.0 / size, _cross(t, (w[3], w[4], w[5])))
    carried = _cross(tilting, m)
    spin = _dot(g, (w[6] - carried[0], w[7] - carried[1], w[8] - carried[2]))
    return tau, side, g, _sum(tilting, _scaled(spin, tau))


@njit(cache=True, error_model="numpy")
def _seized(c):
    """Core of a joint without clearance, else 0: where the joint presses all round, its depth in
    the middle is −c, and it rubs on one side for all, since the middle has no direction."""
    return c[CORE] if c[CLEARANCE] < 0.0 else 0.0


@njit(cache=True, error_model="numpy")
def _ring(point, c, z, w, tau, omega, r, rubbing):
    """A pin in the end of a bore: direction of −grad δ, lever there, lever of the rim.

    The axis of the pin crosses the plane of the end at e, and δ = |e| − c. That it slides through
    the plane tilts the direction of the force, which is across the pin. ``rubbing`` (3,) becomes
    the normal of the plane of friction, of any length.
    """
    s = (point[1] - z[2]) / tau[2]
    arm = _scaled(s, tau)
    e0, e1 = z[0] + arm[0], z[1] + arm[1]
    rho = np.sqrt(e0 * e0 + e1 * e1 + c[CORE] ** 2)
    n0, n1 = e0 / rho, e1 / rho
    n = (n0, n1, -(n0 * tau[0] + n1 * tau[1]) / tau[2])
    f0 = e0 + _seized(c)
    side = c[RADIUS] / np.sqrt(f0 * f0 + e1 * e1 + CENTRE**2 * c[CORE] ** 2)
    rubbing[0], rubbing[1], rubbing[2] = f0, e1, -(f0 * tau[0] + e1 * tau[1]) / tau[2]
    velocity = _sum((w[0], w[1], w[2]), _cross(omega, arm))
    sliding = velocity[2] / tau[2]
    r[0], r[1], r[2] = e0, e1, 0.0 * e0
    r[3], r[4] = velocity[0] - sliding * tau[0], velocity[1] - sliding * tau[1]
    r[5] = 0.0 * e0
    r[7], r[8] = rho - _seized(c) - c[CLEARANCE], _dot(n, velocity)
    r[18], r[19] = 0.0, point[1]
    return n, arm, (arm[0] + side * f0, arm[1] + side * e1, arm[2])


@njit(cache=True, error_model="numpy")
def _ball(c, z, w, r, rubbing):
    """A ball in a socket, as ``_ring``."""
    y = z[0], z[1], z[2]
    rho = np.sqrt(_dot(y, y) + c[CORE] ** 2)
    n = _scaled(1.0 / rho, y)
    at = (y[0] + _seized(c), y[1], y[2])
    for i in range(6):
        r[i] = z[i] if i < 3 else w[i - 3]
    for i in range(3):
        rubbing[i] = at[i]
    r[7], r[8] = rho - _seized(c) - c[CLEARANCE], _dot(n, (w[0], w[1], w[2]))
    r[18], r[19] = 0.0, 0.0
    side = c[RADIUS] / np.sqrt(_dot(at, at) + CENTRE**2 * c[CORE] ** 2)
    return n, (0.0 * n[0], 0.0 * n[1], 0.0 * n[2]), _scaled(side, at)


@njit(cache=True, error_model="numpy")
def _vertex(point, c, z, w, tau, side, omega, r, rubbing):
    """A corner of the journal at a wall of the bearing, as ``_ring``."""
    first = _scaled(1.0 / np.sqrt(_dot(side, side)), side)
    arm = _sum(_scaled(point[1], first), _scaled(point[2], _cross(tau, first)))
    arm = _sum(arm, _scaled(point[3], tau))
    n = (0.0 * tau[0] + point[4], 0.0 * tau[0] + point[5], 0.0 * tau[0] + point[6])
    at = _sum((z[0], z[1], z[2]), arm)
    velocity = _sum((w[0], w[1], w[2]), _cross(omega, arm))
    for i in range(6):
        r[i] = 0.0 * tau[0]
    for i in range(3):
        rubbing[i] = n[i]
    r[0], r[3] = _dot(n, at) - point[7], _dot(n, velocity)
    r[7], r[8], r[18], r[19] = r[0] - c[CLEARANCE], r[3], 1.0, at[2]
    return n, arm, arm


@njit(cache=True, error_model="numpy")
def _point(point, c, z, w, r, phi, V, n, T, new):
    """Response r (32,) of a contact point; its force (9,) on the journal is added to ``phi``.

    V, n, T (3,) and ``new`` (7,), the history at the end of the step, are overwritten.
    """
    tau, side, g, omega = _turning(z, w)
    if point[0] == RING:
        along, arm, rim = _ring(point, c, z, w, tau, omega, r, n)
    elif point[0] == BALL:
        along, arm, rim = _ball(c, z, w, r, n)
    else:
        along, arm, rim = _vertex(point, c, z, w, tau, side, omega, r, n)
    size = np.sqrt(_dot(n, n) + CENTRE**2 * c[CORE] ** 2)
    n[0], n[1], n[2] = n[0] / size, n[1] / size, n[2] / size
    velocity = _sum((w[0], w[1], w[2]), _cross(omega, rim))
    away = _dot(velocity, n)
    V[0], V[1], V[2] = (
        velocity[0] - away * n[0], velocity[1] - away * n[1], velocity[2] - away * n[2]
    )  # fmt: skip
    r[6] = c[CLEARANCE]
    r[9], r[10] = normal(r[7], r[8], c)
    force = r[9] + r[10]
    r[17] = friction(V, n, force, c, T, new)
    turning, first = _cross(rim, (T[0], T[1], T[2])), _scaled(1.0 / np.sqrt(_dot(side, side)), side)
    for i in range(3):
        r[11 + i], r[14 + i], r[20 + i], r[23 + i] = T[i], V[i], turning[i], z[i]
        r[26 + i], r[29 + i] = tau[i], first[i]
    if force.real > 0.0:
        push, rub = _scaled(-force, along), (T[0], T[1], T[2])
        moment = _sum(_cross(arm, push), turning)
        m, t = (z[6], z[7], z[8]), (z[3], z[4], z[5])
        spin = _dot(moment, tau)
        rest = _sum(moment, _scaled(-spin, _cross(m, g)))
        tilt = _scaled(1.0 / _dot(t, t), _cross(rest, t))
        for i in range(3):
            phi[i] += push[i] + rub[i]
            phi[3 + i] += tilt[i]
            phi[6 + i] += spin * g[i]


@njit(cache=True, error_model="numpy")
def _acts(coef, slots):
    """Whether a contact point of a joint may act."""
    acting = False
    for s in range(slots):
        acting = acting or coef[SLOT * s + ACTIVE] != 0.0
    return acting


@njit(cache=True, error_model="numpy")
def _points(slots, floats, coef, z, w, r, phi, V, n, T, new):
    """Overwrite ``phi`` with the force of all contact points; whether there is any."""
    phi[:] = 0.0
    found = False
    for s in range(slots):
        c = coef[SLOT * s :]
        if c[ACTIVE] != 0.0:
            _point(floats[PLACES + POINT * s :], c, z, w, r, phi, V, n, T, new)
            found = found or r[9] + r[10] > 0.0
    return found


@njit(cache=True, error_model="numpy")
def _derivatives(slots, floats, coef, z, w, by_z, by_w, zc, wc, phi, r, V, n, T, new):
    """Derivatives (9, 9) of the force φ by z and by its rates."""
    for k in range(9):
        zc[k], wc[k] = z[k], w[k]
    for k in range(18):
        moved, j = (zc, k) if k < 9 else (wc, k - 9)
        moved[j] += 1j * _STEP
        phi[:] = 0.0
        for s in range(slots):
            c = coef[SLOT * s :]
            if c[ACTIVE] != 0.0:
                _point(floats[PLACES + POINT * s :], c, zc, wc, r, phi, V, n, T, new)
        moved[j] = moved[j].real
        for i in range(9):
            (by_z if k < 9 else by_w)[i, j] = phi[i].imag / _STEP


@njit(cache=True, error_model="numpy")
def _load(y, v, ints, floats, weights, members, count, source):
    """What ``WIDTH`` joints of ``members`` are measured by; the last stands for those missing."""
    x, u = np.empty(18), np.empty(18)
    for k in range(WIDTH):
        e = members[min(k, count - 1)]
        _local(y, v, ints[e], floats[e], weights, x, u)
        for i in range(18):
            source[(LOCAL + i) * WIDTH + k] = x[i]
            source[(MORE + i) * WIDTH + k] = u[i]
        for i in range(PLACES):
            source[(CONSTANTS + i) * WIDTH + k] = floats[e, i]
        for d in range(2):
            there = np.any(floats[e, JOURNAL + 7 * d : JOURNAL + 7 * d + 7])
            source[(PRESENT + d) * WIDTH + k] = 1.0 if there else 0.0


@njit(cache=True, error_model="numpy")
def _take(found, k, z, w):
    """Measures of one of ``WIDTH`` joints and their rates."""
    for i in range(9):
        z[i], w[i] = found[i * WIDTH + k], found[(9 + i) * WIDTH + k]


@njit(cache=True, error_model="numpy")
def _spread(local, k, ints, floats, weights, spreading, out):
    """Add the force of one of ``WIDTH`` joints to those of the coordinates."""
    K = (ints.size - VECTORS) // 2
    one = np.empty(18)
    for i in range(18):
        one[i] = local[i * WIDTH + k]
    for side in range(2):
        spreading[:] = 0.0
        expand(one, 9 * side, floats[weights + 3 * K * side :], ints[side], spreading, 0)
        for j in range(ints[side]):
            for i in range(3):
                out[ints[VECTORS + K * side + j] + i] += spreading[3 * j + i]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Resisting force of every joint."""
    slots, K = coef.shape[1] // SLOT, (ints.shape[1] - VECTORS) // 2
    weights, z, w = PLACES + POINT * slots, np.empty(9), np.empty(9)
    r, phi, V, n, T, new = (
        np.empty(COLUMNS), np.empty(9), np.empty(3), np.empty(3), np.empty(3), np.empty(7)
    )  # fmt: skip
    source, found = np.empty((MORE + 18) * WIDTH), np.empty(18 * WIDTH)
    members, spreading, e = np.empty(WIDTH, np.int64), np.empty(3 * K), 0
    pressing = np.empty(WIDTH, np.bool_)
    while e < ints.shape[0]:
        count = 0
        while e < ints.shape[0] and count < WIDTH:
            if _acts(coef[e], slots):
                members[count] = e
                count += 1
            e += 1
        if count == 0:
            break
        _load(y, v, ints, floats, weights, members, count, source)
        measured(source, found)
        for k in range(WIDTH):
            phi[:] = 0.0
            if k < count:
                j = members[k]
                _take(found, k, z, w)
                pressing[k] = _points(slots, floats[j], coef[j], z, w, r, phi, V, n, T, new)
            for i in range(9):
                source[(MORE + i) * WIDTH + k] = phi[i]
        gathered(source, found)
        for k in range(count):
            if pressing[k]:
                j = members[k]
                _spread(found, k, ints[j], floats[j], weights, spreading, out)


@njit(cache=True, error_model="numpy")
def _assemble(H, u, phi, Z, by_z, by_w, cK, cC, B, C, T):
    """T (18, 18) = cK ∂f/∂x + cC ∂f/∂u of the resisting force f = −Zᵀφ."""
    for k in range(9):  # ∂ż/∂x
        for i in range(18):
            B[k, i] = 0.0
            for j in range(18):
                B[k, i] += H[k, i, j] * u[j]
    for k in range(9):
        for i in range(18):
            C[k, i] = 0.0
            for m in range(9):
                C[k, i] += (cK * by_z[k, m] + cC * by_w[k, m]) * Z[m, i] + cK * by_w[k, m] * B[m, i]
    T[:] = 0.0
    for k in range(9):
        f = cK * phi[k]
        for i in range(18):
            for j in range(18):
                T[i, j] -= Z[k, i] * C[k, j] + f * H[k, i, j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Tangent of every joint in contact."""
    points, K = coef.shape[1] // SLOT, (ints.shape[1] - VECTORS) // 2
    weights, work, none = PLACES + POINT * points, scratch(), np.empty((0, 18, 18))
    x, u, z, w, Z = np.empty(18), np.empty(18), np.empty(9), np.empty(9), np.empty((9, 18))
    r, phi, V, n, F, new = (
        np.empty(COLUMNS), np.empty(9), np.empty(3), np.empty(3), np.empty(3), np.empty(7)
    )  # fmt: skip
    bent, others = np.empty((3, 9), np.complex128), np.empty((3, 3), np.complex128)
    rc, newc = np.empty(COLUMNS, np.complex128), np.empty(7, np.complex128)
    H, by_z, by_w = np.empty((9, 18, 18)), np.empty((9, 9)), np.empty((9, 9))
    B, C, T = np.empty((9, 18)), np.empty((9, 18)), np.empty((18, 18))
    half, wide = np.empty((18, 6 * K)), np.empty((6 * K, 6 * K))
    for e in range(ints.shape[0]):
        if not _acts(coef[e], points):
            continue
        _local(y, v, ints[e], floats[e], weights, x, u)
        _measure(x, floats[e], z, Z, none, work)
        _rates(Z, u, w)
        if not _points(points, floats[e], coef[e], z, w, r, phi, V, n, F, new):
            continue
        _measure(x, floats[e], z, Z, H, work)
        _derivatives(
            points, floats[e], coef[e], z, w, by_z, by_w, bent[0], bent[1], bent[2], rc,
            others[0], others[1], others[2], newc,
        )  # fmt: skip
        _assemble(H, u, phi, Z, by_z, by_w, cK, cC, B, C, T)
        spread(T, floats[e, weights:], ints[e], K, half, wide)
        for i in range(6 * K):
            for j in range(6 * K):
                data[slots[e, 6 * K * i + j]] += wide[i, j]


@njit(cache=True, error_model="numpy")
def _respond(y, v, coef, ints, floats, response, history):
    """Overwrite response (n_c, 32) and history (n_c, 7) of every contact."""
    slots = coef.shape[1] // SLOT
    weights, z, w = PLACES + POINT * slots, np.empty(9), np.empty(9)
    phi, V, n, T = np.empty(9), np.empty(3), np.empty(3), np.empty(3)
    source, found = np.empty((MORE + 18) * WIDTH), np.empty(18 * WIDTH)
    for first in range(0, ints.shape[0], WIDTH):
        count = min(WIDTH, ints.shape[0] - first)
        _load(y, v, ints, floats, weights, first + np.arange(WIDTH), count, source)
        measured(source, found)
        for k in range(count):
            _take(found, k, z, w)
            for s in range(slots):
                e = first + k
                at, point = slots * e + s, floats[e, PLACES + POINT * s :]
                _point(
                    point, coef[e, SLOT * s :], z, w, response[at], phi, V, n, T, history[at]
                )  # fmt: skip


@kernel(RESPOND)
def respond(y, v, coef, ints, floats, response):
    """Response (n_c, 32) of every contact."""
    _respond(y, v, coef, ints, floats, response, np.empty((len(response), 7)))


@kernel(REMEMBER)
def remember(y, v, coef, ints, floats, history):
    """History (n_c, 7) of every contact at the end of a step."""
    _respond(y, v, coef, ints, floats, np.empty((len(history), COLUMNS)), history)


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    """Elastic energy of all contacts."""
    slots = coef.shape[1] // SLOT
    response, history = np.empty((len(ints) * slots, COLUMNS)), np.empty((len(ints) * slots, 7))
    _respond(y, v, coef, ints, floats, response, history)
    for e in range(ints.shape[0]):
        for s in range(slots):
            out[0] += stored(response[slots * e + s, 7], coef[e, SLOT * s :])
