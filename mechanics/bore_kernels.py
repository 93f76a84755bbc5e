"""Compiled forces of the contacts of ``mechanics.bore``.

A point X of the bore's surface stands at d = X − r to the pin, whose axis goes through r along the
unit vector τ. With z = d·τ, e = d − z τ and n = e/|e| it is pressed by

    δ = R(z) − |e|,   R(z) = R − (|z| − l/2)²/(2 rim) beyond the ends of the pin, R between them,

and pushes the pin with −N ν + T at X, ν = n − R′ τ, where N is the pressure law times the area of
the point in the reference and T the friction. The pin turns as a triad of τ and of a second
direction m across it does,

    ω = τ × ȧ/|a| + τ g·(ṁ − (τ × ȧ/|a|) × m),   τ = a/|a|,   g = τ × m/|m − (m·τ) τ|²,

where a and m are combinations of the vectors p, s of its section and of p × s. The point is left
behind with the velocity V = ω × d − ḋ of the pin there, and δ̇ = ν·V. The moment M = d × F of a
force on the pin acts on a and m so that M·ω is its power: what acts on the bore and on the pin is
then opposite, its moment included.

Derivatives are taken by the same code with complex numbers, exact to round-off (Squire & Trapp
1998), in the direction cK by position and cC by velocity at once.
"""

import numpy as np
from numba import njit

from mechanics.contact_laws import (
    ACTIVE,
    APPROACH,
    COLUMNS,
    RADIUS,
    SLOT,
    friction,
    normal,
    stored,
)
from mechanics.kernels import ENERGY, FORCE, REMEMBER, RESPOND, TANGENT, kernel
from mechanics.relative import expand, gather

COUNT, FACETS, POINTS, NODES, VECTORS = range(5)
"""Columns of ``ints``: vectors of the pin, facets, points and nodes of a facet; then the first
coordinates of the vectors, and those of the nodes of each facet."""
ORIGIN, TOWARDS, TURNING, HALF, RIM, SPAN, SHAPES = 0, 3, 10, 17, 18, 19, 20
"""Columns of ``floats``: part of r that the ground contributes (3); directions a and m of the pin
(7 each, see ``mechanics.relative``); half of its length, radius of its rims, distance from which
depth is counted on the way into contact [m]; shape functions at the points of a facet, then weights
of the vectors in r, p, s."""
_STEP = 1e-30  # of the imaginary parts


@njit(cache=True, error_model="numpy")
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def _plus(a, f, b):
    """a + f b."""
    return a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]


@njit(cache=True, error_model="numpy")
def _normal(x, u):
    """g = p × s, its rate, and its length, 0 for a pin without a section."""
    p, s = (x[3], x[4], x[5]), (x[6], x[7], x[8])
    g = _cross(p, s)
    rate = _plus(_cross((u[3], u[4], u[5]), s), 1.0, _cross(p, (u[6], u[7], u[8])))
    return g, rate, np.sqrt(_dot(g, g))


@njit(cache=True, error_model="numpy")
def _direction(c, x, u, g, rate, size):
    """A direction of the pin and its rate."""
    a = _plus(_plus((c[3], c[4], c[5]), c[1], (x[3], x[4], x[5])), c[2], (x[6], x[7], x[8]))
    b = _plus(_plus((0.0, 0.0, 0.0), c[1], (u[3], u[4], u[5])), c[2], (u[6], u[7], u[8]))
    f = 0.0 * size
    growth = 0.0 * size
    if c[0] != 0.0:
        f = c[0] / np.sqrt(size)
        growth = 0.5 * f * _dot(g, rate) / (size * size)
    return _plus(a, f, g), _plus(_plus(b, f, rate), -growth, g)


@njit(cache=True, error_model="numpy")
def _pull(c, P, x, g, size, phi):
    """Add the force by p and s of P on a direction to phi[3:9], see ``mechanics.relative``."""
    p, s = (x[3], x[4], x[5]), (x[6], x[7], x[8])
    by_p, by_s = (c[1] * P[0], c[1] * P[1], c[1] * P[2]), (c[2] * P[0], c[2] * P[1], c[2] * P[2])
    if c[0] != 0.0:
        f = c[0] / np.sqrt(size)
        along = -0.5 * f * _dot(P, g) / (size * size)
        across = _plus((f * P[0], f * P[1], f * P[2]), along, g)
        by_p, by_s = _plus(by_p, 1.0, _cross(s, across)), _plus(by_s, 1.0, _cross(across, p))
    for i in range(3):
        phi[3 + i] += by_p[i]
        phi[6 + i] += by_s[i]


@njit(cache=True, error_model="numpy")
def _surface(z, radius, floats):
    """R(z) and R′(z)."""
    far = z if z.real > 0.0 else -z
    over = far - floats[HALF]
    if not over.real > 0.0:
        return radius + 0.0 * z, 0.0 * z
    slope = -over / floats[RIM]
    return radius + 0.5 * over * slope, slope if z.real > 0.0 else -slope


@njit(cache=True, error_model="numpy")
def _point(c, floats, x, u, r, phi, V, n, T, new):
    """Force ``phi`` (9,) by d, p, s that a point applies; whether it is pressed.

    c : (SLOT,) coefficients, with activity and approach speed of the whole contact
    x, u : (9,) float or complex  d, p, s and their rates
    r : (8,) written: depth, its rate, elastic and dissipative force, place along the axis, friction
        on the pin about its axis [N m], 1 where it sticks, size of the friction
    V, n, T : (3,) slip of the pin, normal of the surface and friction on the pin;  new : (7,)
    """
    a_of, m_of = floats[TOWARDS : TOWARDS + 7], floats[TURNING : TURNING + 7]
    g, g_rate, size = _normal(x, u)
    a, a_rate = _direction(a_of, x, u, g, g_rate, size)
    m, m_rate = _direction(m_of, x, u, g, g_rate, size)
    f = 1.0 / np.sqrt(_dot(a, a))
    tau = f * a[0], f * a[1], f * a[2]
    d = x[0], x[1], x[2]
    z = _dot(d, tau)
    e = _plus(d, -z, tau)
    away = np.sqrt(_dot(e, e))
    radius, slope = _surface(z, c[RADIUS], floats)
    for i in range(8):
        r[i] = 0.0 * away
    r[0], r[4] = radius - away, z
    nu = _plus((e[0] / away, e[1] / away, e[2] / away), -slope, tau)
    tilting = _cross(tau, (f * a_rate[0], f * a_rate[1], f * a_rate[2]))
    side = _plus(m, -_dot(m, tau), tau)
    w, square = _cross(tau, side), _dot(side, side)
    w = w[0] / square, w[1] / square, w[2] / square
    spin = _dot(w, _plus(m_rate, -1.0, _cross(tilting, m)))
    omega = _plus(tilting, spin, tau)
    relative = _plus(_cross(omega, d), -1.0, (u[0], u[1], u[2]))
    r[1] = _dot(nu, relative)
    for i in range(9):
        phi[i] = 0.0 * away
    if r[0].real <= 0.0 or c[ACTIVE] == 0.0:
        for i in range(3):
            V[i], T[i] = 0.0 * away, 0.0 * away
        new[:] = 0.0
        return False
    long = np.sqrt(_dot(nu, nu))
    for i in range(3):
        n[i] = nu[i] / long
        V[i] = relative[i] - r[1] / long * n[i]
    r[2], r[3] = normal(r[0], r[1], c)
    force = r[2] + r[3]
    r[6] = friction(V, n, force, c, T, new)
    push = _plus((T[0], T[1], T[2]), -force, nu)
    M = _cross(d, push)
    r[5] = _dot(_cross(d, (T[0], T[1], T[2])), tau)
    r[7] = np.sqrt(T[0].real ** 2 + T[1].real ** 2 + T[2].real ** 2) + 0.0 * away
    along = _dot(M, tau)
    rest = _cross(_plus(M, -along, _cross(m, w)), tau)
    for i in range(3):
        phi[i] = -push[i]
    _pull(a_of, (f * rest[0], f * rest[1], f * rest[2]), x, g, size, phi)
    _pull(m_of, (along * w[0], along * w[1], along * w[2]), x, g, size, phi)
    return True


@njit(cache=True, error_model="numpy")
def _pin(y, ints, floats, origin, x):
    """r, p, s (9,) of the pin; without ``origin`` their rates."""
    count, k = ints[COUNT], ints[POINTS] * ints[NODES]
    gather(y, ints[VECTORS:], floats[SHAPES + k :], count, x, 0)
    if origin:
        for i in range(3):
            x[i] += floats[ORIGIN + i]


@njit(cache=True, error_model="numpy")
def _place(y, nodes, values, x):
    """x (3,) of a point of a facet."""
    for i in range(3):
        x[i] = 0.0
    for k in range(values.size):
        for i in range(3):
            x[i] += values[k] * y[nodes[k] + i]


@njit(cache=True, error_model="numpy")
def _facet(ints, f):
    """First coordinates of the nodes of a facet."""
    start = VECTORS + ints[COUNT] + ints[NODES] * f
    return ints[start : start + ints[NODES]]


@njit(cache=True, error_model="numpy")
def _load(coef, at, c):
    """Coefficients of a point, which acts when the contact does, with its approach speed."""
    for i in range(SLOT):
        c[i] = coef[SLOT * at + i]
    c[ACTIVE], c[APPROACH] = coef[ACTIVE], coef[APPROACH]


@njit(cache=True, error_model="numpy")
def _stand(y, v, nodes, values, pin, moving, x, u):
    """d, p, s of a point and their rates."""
    _place(y, nodes, values, x)
    _place(v, nodes, values, u)
    for i in range(3):
        x[i] -= pin[i]
        u[i] -= moving[i]
    for i in range(3, 9):
        x[i], u[i] = pin[i], moving[i]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Resisting force of a contact."""
    if coef[0, ACTIVE] == 0.0:
        return
    ints, floats, coef = ints[0], floats[0], coef[0]
    pin, moving, x, u = np.empty(9), np.empty(9), np.empty(9), np.empty(9)
    phi, r, total, c = np.empty(9), np.empty(8), np.zeros(9), np.empty(SLOT)
    V, n, T, new = np.empty(3), np.empty(3), np.empty(3), np.empty(7)
    count, q, size = ints[COUNT], ints[POINTS], ints[NODES]
    _pin(y, ints, floats, True, pin)
    _pin(v, ints, floats, False, moving)
    for f in range(ints[FACETS]):
        nodes = _facet(ints, f)
        for j in range(q):
            values = floats[SHAPES + size * j : SHAPES + size * (j + 1)]
            _stand(y, v, nodes, values, pin, moving, x, u)
            _load(coef, 1 + q * f + j, c)
            if not _point(c, floats, x, u, r, phi, V, n, T, new):
                continue
            for i in range(3):
                total[i] += phi[i]
                total[3 + i] -= phi[3 + i]
                total[6 + i] -= phi[6 + i]
                for k in range(size):
                    out[nodes[k] + i] -= values[k] * phi[i]
    spread = np.zeros(3 * count)
    expand(total, 0, floats[SHAPES + q * size :], count, spread, 0)
    for k in range(count):
        for i in range(3):
            out[ints[VECTORS + k] + i] += spread[3 * k + i]


@njit(cache=True, error_model="numpy")
def _slopes(c, floats, x, u, cK, cC, J, xc, uc, phi, r, V, n, T, new):
    """J (9, 9) = cK ∂/∂x + cC ∂/∂u of the resisting force −φ by d, p, s."""
    for k in range(9):
        xc[k], uc[k] = x[k], u[k]
    for k in range(9):
        xc[k] += 1j * _STEP * cK
        uc[k] += 1j * _STEP * cC
        _point(c, floats, xc, uc, r, phi, V, n, T, new)
        xc[k], uc[k] = x[k], u[k]
        for i in range(9):
            J[i, k] = -phi[i].imag / _STEP


@njit(cache=True, error_model="numpy")
def _carry(J, values, weights, count, B, A, block):
    """Add Bᵀ J B to ``block``, where B is d, p, s by the nodes of the facet and the pin's vectors.

    B : (9, k) of numbers, each for x, y and z;  A : (3, k) the same by r, p, s of d, p, s
    """
    size = values.size
    A[:] = 0.0
    for k in range(size):
        A[0, k] = values[k]
    for k in range(count):
        A[0, size + k] = -weights[3 * k]
        A[1, size + k], A[2, size + k] = weights[3 * k + 1], weights[3 * k + 2]
    for b in range(size + count):  # J B
        for i in range(9):
            for t in range(3):
                total = 0.0
                for m in range(3):
                    total += J[i, 3 * m + t] * A[m, b]
                B[i, 3 * b + t] = total
    for a in range(size + count):
        for m in range(3):
            w = A[m, a]
            if w != 0.0:
                for i in range(3):
                    for j in range(3 * (size + count)):
                        block[3 * a + i, j] += w * B[3 * m + i, j]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Tangent of a contact."""
    if coef[0, ACTIVE] == 0.0:
        return
    ints, floats, coef = ints[0], floats[0], coef[0]
    pin, moving, x, u = np.empty(9), np.empty(9), np.empty(9), np.empty(9)
    phi, r, c, J = np.empty(9), np.empty(8), np.empty(SLOT), np.empty((9, 9))
    V, n, T, new = np.empty(3), np.empty(3), np.empty(3), np.empty(7)
    bent, others = np.empty((4, 9), np.complex128), np.empty((3, 3), np.complex128)
    newc = np.empty(7, np.complex128)
    count, q, size = ints[COUNT], ints[POINTS], ints[NODES]
    width = 3 * (size + count)
    A, B, block = np.empty((3, size + count)), np.empty((9, width)), np.empty((width, width))
    _pin(y, ints, floats, True, pin)
    _pin(v, ints, floats, False, moving)
    for f in range(ints[FACETS]):
        nodes, found = _facet(ints, f), False
        for j in range(q):
            values = floats[SHAPES + size * j : SHAPES + size * (j + 1)]
            _stand(y, v, nodes, values, pin, moving, x, u)
            _load(coef, 1 + q * f + j, c)
            if not _point(c, floats, x, u, r, phi, V, n, T, new):
                continue
            if not found:
                block[:] = 0.0
                found = True
            _slopes(
                c, floats, x, u, cK, cC, J, bent[0], bent[1], bent[2], bent[3],
                others[0], others[1], others[2], newc,
            )  # fmt: skip
            _carry(J, values, floats[SHAPES + q * size :], count, B, A, block)
        if found:
            for i in range(width):
                for j in range(width):
                    data[slots[f, width * i + j]] += block[i, j]


@njit(cache=True, error_model="numpy")
def _note(r, c, V, T, out):
    """Response of a point. It has no events of its own: its depth is its gap less a radius."""
    out[:] = 0.0
    out[6], out[7], out[8] = c[RADIUS] + r[0], -c[RADIUS], 0.0
    out[9], out[10], out[17], out[19] = r[2], r[3], r[6], r[4]
    for i in range(3):
        out[11 + i], out[14 + i] = T[i], V[i]


@njit(cache=True, error_model="numpy")
def _respond(y, v, coef, ints, floats, response, history):
    """Overwrite response (1 + n, 32) and history (1 + n, 7) of the contact and its points."""
    pin, moving, x, u = np.empty(9), np.empty(9), np.empty(9), np.empty(9)
    phi, r, c, push = np.empty(9), np.empty(8), np.empty(SLOT), np.zeros(3)
    V, n, T = np.empty(3), np.empty(3), np.empty(3)
    q, size = ints[POINTS], ints[NODES]
    whole = response[0]
    whole[:] = 0.0
    history[0, :] = 0.0
    deepest, rate, pressed, place, turning, power, rubbing = -np.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    stuck = True
    _pin(y, ints, floats, True, pin)
    _pin(v, ints, floats, False, moving)
    for f in range(ints[FACETS]):
        nodes = _facet(ints, f)
        for j in range(q):
            at, values = 1 + q * f + j, floats[SHAPES + size * j : SHAPES + size * (j + 1)]
            _stand(y, v, nodes, values, pin, moving, x, u)
            _load(coef, at, c)
            acts = _point(c, floats, x, u, r, phi, V, n, T, history[at])
            _note(r, c, V, T, response[at])
            if r[0] > deepest:
                deepest, rate = r[0], r[1]
            if acts:
                force = r[2] + r[3]
                pressed, place, turning = pressed + force, place + force * r[4], turning + r[5]
                power, rubbing = power + r[7] * np.sqrt(_dot(V, V)), rubbing + r[7]
                stuck = stuck and r[6] > 0.0
                for i in range(3):
                    push[i] -= phi[i]
                    whole[11 + i] += T[i]
    span = floats[SPAN]
    whole[0], whole[1], whole[3], whole[20] = span + deepest, pressed, rate, turning
    whole[6], whole[7], whole[8], whole[18] = span, deepest, rate, 1.0
    for i in range(3):
        push[i] -= whole[11 + i]
    whole[9] = np.sqrt(_dot(push, push))
    whole[14] = power / rubbing if rubbing > 0.0 else 0.0
    whole[17] = 1.0 if stuck and pressed > 0.0 else 0.0
    whole[19] = place / pressed if pressed > 0.0 else 0.0
    whole[26], whole[30] = 1.0, 1.0  # a pose that does not change: the points have the work


@kernel(RESPOND)
def respond(y, v, coef, ints, floats, response):
    """Response (1 + n, 32) of a contact and its points."""
    _respond(y, v, coef[0], ints[0], floats[0], response, np.empty((len(response), 7)))


@kernel(REMEMBER)
def remember(y, v, coef, ints, floats, history):
    """History (1 + n, 7) of a contact and its points at the end of a step."""
    _respond(y, v, coef[0], ints[0], floats[0], np.empty((len(history), COLUMNS)), history)


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    """Elastic energy of a contact."""
    slots = coef.shape[1] // SLOT
    response, history = np.empty((slots, COLUMNS)), np.empty((slots, 7))
    _respond(y, v, coef[0], ints[0], floats[0], response, history)
    c = np.empty(SLOT)
    for k in range(1, slots):
        _load(coef[0], k, c)
        out[0] += stored(response[k, 6] - c[RADIUS], c)
