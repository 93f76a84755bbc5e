"""Compiled response, force and tangent of the joints of ``mechanics.clearance``.

Local coordinates x (18,) are r, p, s of journal and bearing; z are y1, y2 and the cosine and sine
of the turn (``mechanics.relative``), Y their change (y1, y2, theta) by x.
"""

import numpy as np
from numba import njit

from mechanics.kernels import ENERGY, FORCE, RESPOND, TANGENT, kernel
from mechanics.relative import DIRECTION, OFFSET, evaluate, expand, gather, scratch, spread

ORIGIN, TURNING, PLANE, WEIGHTS = 0, 3, 10, 24
"""Columns of ``floats``: origin (3), direction of the journal that turns (7), two directions of
the bearing (7 each), weights of the K vectors of both ends."""
VECTORS = 2
"""Column of ``ints`` where the K vectors of both ends begin, after their numbers."""


@njit(cache=True, error_model="numpy")
def _local(y, v, ints, floats, x, u):
    """Local coordinates and velocities."""
    K = (ints.size - VECTORS) // 2
    for side in range(2):
        vectors = ints[VECTORS + K * side :]
        weights = floats[WEIGHTS + 3 * K * side :]
        gather(y, vectors, weights, ints[side], x, 9 * side)
        gather(v, vectors, weights, ints[side], u, 9 * side)


@njit(cache=True, error_model="numpy")
def _measure(x, floats, z, Z, H, work):
    """z (4,), its gradients Z (4, 18) and, where H has rows, second derivatives H (4, 18, 18)."""
    none = np.empty((0, 18))
    Z[:] = 0.0
    H[:] = 0.0
    for k in range(4):
        kind = OFFSET if k < 2 else DIRECTION
        w = floats[PLANE + 7 * (k % 2) :]
        bend = H[k] if H.shape[0] > 0 else none
        z[k] = evaluate(kind, x, floats[ORIGIN:], floats[TURNING:], w, 1.0, Z[k], bend, work)


@njit(cache=True, error_model="numpy")
def _respond(z, Z, u, coef, r, f, Y):
    """Response r (13,), forces f (3, 3) on (y1, y2, theta): elastic, dissipative, friction."""
    c, s = z[2], z[3]
    size = c**2 + s**2 if c != 0.0 or s != 0.0 else 1.0
    r[0], r[1], r[2] = z[0], z[1], np.arctan2(s, c)
    r[3] = r[4] = r[5] = 0.0
    for i in range(18):
        Y[0, i], Y[1, i] = Z[0, i], Z[1, i]
        Y[2, i] = (c * Z[3, i] - s * Z[2, i]) / size
        for k in range(3):
            r[3 + k] += Y[k, i] * u[i]
    K, clearance, mu, D = coef[0], coef[1], coef[2], coef[3]
    R, p, eps = coef[4], coef[5], coef[6]
    speed = coef[7] if coef[7] > 0.0 else coef[9]
    rho = np.sqrt(r[0] ** 2 + r[1] ** 2 + coef[8] ** 2)
    n1, n2 = r[0] / rho, r[1] / rho
    r[6], r[7], r[8] = clearance, rho - clearance, n1 * r[3] + n2 * r[4]
    r[12] = n1 * r[4] - n2 * r[3] + R * r[5]
    elastic = K * r[7] ** p if r[7] > 0.0 else 0.0
    normal = elastic * max(0.0, 1.0 + D * r[8] / speed) if speed > 0.0 else elastic
    r[9], r[10] = elastic, normal - elastic
    r[11] = -mu * normal * r[12] / (abs(r[12]) + eps)
    for k in range(2):
        f[k, 0], f[k, 1], f[k, 2] = -r[9 + k] * n1, -r[9 + k] * n2, 0.0
    f[2, 0], f[2, 1], f[2, 2] = -r[11] * n2, r[11] * n1, r[11] * R


@njit(cache=True, error_model="numpy")
def _law(r, coef, fy, fv):
    """Derivatives (3, 3) of F (n, 0) + F S τ by (y1, y2, θ) and by their rates, in contact."""
    fy[:] = 0.0
    fv[:] = 0.0
    rho, normal, mu, R, p, eps = r[7] + r[6], r[9] + r[10], coef[2], coef[4], coef[5], coef[6]
    speed = coef[7] if coef[7] > 0.0 else coef[9]
    n, tau, m = np.empty(3), np.empty(3), np.empty(3)
    n[0], n[1], n[2] = r[0] / rho, r[1] / rho, 0.0
    tau[0], tau[1], tau[2] = -n[1], n[0], R
    m[0], m[1], m[2] = r[4], -r[3], 0.0
    by_depth, by_rate = p * normal / r[7], r[9] * coef[3] / speed if speed > 0.0 else 0.0
    S = mu * r[12] / (abs(r[12]) + eps)
    steep = mu * normal * eps / (abs(r[12]) + eps) ** 2
    turning = n[0] * m[0] + n[1] * m[1]
    for k in range(3):
        for i in range(2):
            rate = (r[3 + i] - n[i] * r[8]) / rho  # ∂δ̇/∂y
            slip = (m[i] - n[i] * turning) / rho  # ∂v_t/∂y
            fy[k, i] = (n[k] + S * tau[k]) * (by_depth * n[i] + by_rate * rate)
            fy[k, i] += steep * tau[k] * slip
        for i in range(3):
            fv[k, i] = (n[k] + S * tau[k]) * by_rate * n[i] + steep * tau[k] * tau[i]
    for k in range(2):
        for i in range(2):
            turn = ((k == i) - n[k] * n[i]) / rho * normal  # F ∂n/∂y
            fy[k, i] += turn
            fy[1 - k, i] += S * turn * (1.0 if k == 0 else -1.0)


@njit(cache=True, error_model="numpy")
def _bend_angle(c, s, Zc, Zs, Hc, Hs):
    """Overwrite Hc with ∂²θ/∂x² for θ = atan2(s, c)."""
    size = c**2 + s**2 if c != 0.0 or s != 0.0 else 1.0
    a, b = 2.0 * c * s / size**2, (s**2 - c**2) / size**2
    for i in range(18):
        for j in range(18):
            Hc[i, j] = (c * Hs[i, j] - s * Hc[i, j]) / size
            Hc[i, j] += a * (Zc[i] * Zc[j] - Zs[i] * Zs[j]) + b * (Zc[i] * Zs[j] + Zs[i] * Zc[j])


@njit(cache=True, error_model="numpy")
def _local_tangent(H, u, r, coef, parts, Y, cK, cC, T):
    """T (18, 18) = cK ∂f/∂x + cC ∂f/∂u of the resisting force f = Yᵀ(F (n, 0) + F S τ)."""
    fy, fv, B, C = np.empty((3, 3)), np.empty((3, 3)), np.zeros((3, 18)), np.zeros((3, 18))
    _law(r, coef, fy, fv)
    for k in range(3):  # ∂ẏ/∂x
        for j in range(18):
            for i in range(18):
                B[k, i] += H[k, i, j] * u[j]
    for k in range(3):  # cK ∂f_y/∂x + cC ∂f_y/∂u
        for m in range(3):
            for i in range(18):
                C[k, i] += (cK * fy[k, m] + cC * fv[k, m]) * Y[m, i] + cK * fv[k, m] * B[m, i]
    T[:] = 0.0
    for k in range(3):
        f = -cK * (parts[0, k] + parts[1, k] + parts[2, k])
        for i in range(18):
            for j in range(18):
                T[i, j] += Y[k, i] * C[k, j] + f * H[k, i, j]


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    """Resisting force of every joint."""
    K, work, none = (ints.shape[1] - VECTORS) // 2, scratch(), np.empty((0, 18, 18))
    x, u, z, Z, r = np.empty(18), np.empty(18), np.empty(4), np.empty((4, 18)), np.empty(13)
    parts, Y, local, spreading = np.empty((3, 3)), np.empty((3, 18)), np.empty(18), np.empty(3 * K)
    for e in range(ints.shape[0]):
        if coef[e, 0] == 0.0:  # in flight
            continue
        _local(y, v, ints[e], floats[e], x, u)
        _measure(x, floats[e], z, Z, none, work)
        _respond(z, Z, u, coef[e], r, parts, Y)
        if r[9] <= 0.0:
            continue
        for i in range(18):
            local[i] = 0.0
            for k in range(3):
                local[i] -= (parts[0, k] + parts[1, k] + parts[2, k]) * Y[k, i]
        for side in range(2):
            spreading[:] = 0.0
            weights = floats[e, WEIGHTS + 3 * K * side :]
            expand(local, 9 * side, weights, ints[e, side], spreading, 0)
            for k in range(ints[e, side]):
                for i in range(3):
                    out[ints[e, VECTORS + K * side + k] + i] += spreading[3 * k + i]


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    """Tangent of every joint in contact."""
    K, work = (ints.shape[1] - VECTORS) // 2, scratch()
    x, u, z, Z, r = np.empty(18), np.empty(18), np.empty(4), np.empty((4, 18)), np.empty(13)
    none, H = np.empty((0, 18, 18)), np.empty((4, 18, 18))
    parts, Y, T = np.empty((3, 3)), np.empty((3, 18)), np.empty((18, 18))
    half, wide = np.empty((18, 6 * K)), np.empty((6 * K, 6 * K))
    for e in range(ints.shape[0]):
        if coef[e, 0] == 0.0:
            continue
        _local(y, v, ints[e], floats[e], x, u)
        _measure(x, floats[e], z, Z, none, work)
        _respond(z, Z, u, coef[e], r, parts, Y)
        if r[9] + r[10] <= 0.0:
            continue
        _measure(x, floats[e], z, Z, H, work)
        _bend_angle(z[2], z[3], Z[2], Z[3], H[2], H[3])
        _local_tangent(H, u, r, coef[e], parts, Y, cK, cC, T)
        spread(T, floats[e, WEIGHTS:], ints[e], K, half, wide)
        for i in range(6 * K):
            for j in range(6 * K):
                data[slots[e, 6 * K * i + j]] += wide[i, j]


@kernel(ENERGY)
def add_energy(y, v, coef, ints, floats, out):
    """Elastic energy K δ^(p+1)/(p+1) of all contacts."""
    work, none = scratch(), np.empty((0, 18, 18))
    x, u, z, Z = np.empty(18), np.empty(18), np.empty(4), np.empty((4, 18))
    for e in range(ints.shape[0]):
        _local(y, v, ints[e], floats[e], x, u)
        _measure(x, floats[e], z, Z, none, work)
        depth = np.sqrt(z[0] ** 2 + z[1] ** 2 + coef[e, 8] ** 2) - coef[e, 1]
        if depth > 0.0:
            out[0] += coef[e, 0] * depth ** (coef[e, 5] + 1.0) / (coef[e, 5] + 1.0)


@kernel(RESPOND)
def respond(y, v, coef, ints, floats, response, split):
    """Response (n_j, 13) and forces (n_j, 6) on (y1, y2, theta): dissipative normal, friction."""
    work, none = scratch(), np.empty((0, 18, 18))
    x, u, z, Z = np.empty(18), np.empty(18), np.empty(4), np.empty((4, 18))
    parts, Y = np.empty((3, 3)), np.empty((3, 18))
    for e in range(ints.shape[0]):
        _local(y, v, ints[e], floats[e], x, u)
        _measure(x, floats[e], z, Z, none, work)
        _respond(z, Z, u, coef[e], response[e], parts, Y)
        for i in range(3):
            split[e, i], split[e, 3 + i] = parts[1, i], parts[2, i]
