"""Events inside a step: where an impact begins or ends, and where a latch catches."""

from functools import cache
from math import sqrt

import numpy as np
from numba import njit

from mechanics.contact_laws import ACTIVE, FACTOR
from mechanics.kernels import kernel
from mechanics.march.contacts import LANDING, meeting_mass
from mechanics.march.program import (
    DEPTH,
    DEPTH_RATE,
    DISSIPATIVE,
    ELASTIC,
    FLAT,
    GAP,
    P_CONTACT_AT,
    P_LATCH_AT,
    P_LATCH_VALUE,
    P_MOBILITY,
    PATH,
    PATH_RATE,
    TOLERANCE,
)
from mechanics.march.store import (
    ACTING,
    COEF,
    LOCATE,
    SETTINGS,
    STACK,
    V1_,
    Y1_,
    Y,
    inner,
    looked,
    reals,
    wholes,
)
from mechanics.march.terms import respond

RELEASED, KEPT_LOSS = 1e3, 0.1
"""Speed that the end of an impact inside a step may add, in that of separation: so many tolerances,
and this part of the factor of hysteresis, which is about 3/2 of what is lost [-]."""


@inner
def _crossing(b, stack):
    """First s in (0, 1) where the polynomial of Bernstein coefficients b (7,) turns positive.

    Bisection by de Casteljau; an interval whose coefficients have one sign holds no root. -1: none.
    """
    depth = 0
    stack[0, :7], stack[0, 7], stack[0, 8] = b, 0.0, 1.0
    now = np.empty(7)
    while depth >= 0:
        low, width = stack[depth, 7], stack[depth, 8]
        now[:] = stack[depth, :7]
        depth -= 1
        if now.min() > 0.0 or now.max() <= 0.0:
            continue
        if width < 1e-15 or depth + 2 >= stack.shape[0]:
            if now[0] <= 0.0 < now[6]:
                return low
            continue
        left, right = stack[depth + 2], stack[depth + 1]
        for k in range(7):
            left[k], right[6 - k] = now[0], now[6 - k]
            for i in range(6 - k):
                now[i] = 0.5 * (now[i] + now[i + 1])
        left[7], left[8] = low, 0.5 * width
        right[7], right[8] = low + 0.5 * width, 0.5 * width
        depth += 2
    return -1.0


@inner
def _leaving(path, ratio, radius, flat, stack):
    """First s where e leaves the sphere, or passes the plane, at ``radius`` + (``ratio`` - 1) s.

    path : (4, 3)  control points of e, in clearances
    """
    b = np.zeros(7)
    choose, six = (1.0, 3.0, 3.0, 1.0), (1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0)
    for i in range(4):
        ri = radius + (ratio - 1.0) * i / 3.0
        for j in range(4):
            rj = radius + (ratio - 1.0) * j / 3.0
            product = 0.5 * (path[i, 0] + path[j, 0] - ri - rj)
            if not flat:
                product = -ri * rj
                for k in range(3):
                    product += path[i, k] * path[j, k]
            b[i + j] += choose[i] * choose[j] / six[i + j] * product
    return _crossing(b, stack)


@njit(cache=True, error_model="numpy")
def onset(path, c0, c1, flat, stack):
    """Where in (0, 1) a journal is about to touch; -1 if it does not.

    It stops ``LANDING``/2 before. A flight that begins closer than ``LANDING``, as only one from
    the initial state can, may go ``LANDING`` too far.

    Parameters
    ----------
    path : (4, 3) float [m]  control points of e
    c0, c1 : float [m]  clearance at both ends
    flat : whether contact is e[0] > c, otherwise |e| > c
    stack : (64, 9) float  scratch
    """
    path = path / c0
    start = path[0, 0]
    if not flat:
        start = sqrt(path[0, 0] ** 2 + path[0, 1] ** 2 + path[0, 2] ** 2)
    limit = 1.0 if start < 1.0 - LANDING else 1.0 + LANDING
    outside = _leaving(path, c1 / c0, limit, flat, stack)
    if outside < 0.0:
        return -1.0
    before = _leaving(path, c1 / c0, limit - 0.5 * LANDING, flat, stack)
    return min(before, outside) if before > 0.0 else outside


@inner
def _release(p, w, h, j, r0, r1):
    """Fraction of the step at which a contact ends; -1 where that may stay inside the step.

    The force at the beginning acts on as if it fell to zero over the whole step, when it has
    already done so on the way. The speed that this adds must be small, and must not make up for
    what the impact loses.
    """
    force = r0[ELASTIC] + r0[DISSIPATIVE]
    if force <= 0.0 or r1[DEPTH] >= 0.0:
        return -1.0
    low, high = 0.0, 1.0
    a, b, c, d = r0[DEPTH], h * r0[DEPTH_RATE] / 3.0, h * r1[DEPTH_RATE] / 3.0, r1[DEPTH]
    for _ in range(40):
        s = 0.5 * (low + high)
        q = 1.0 - s
        deep = q * q * (q * a + 3.0 * s * (a + b)) + s * s * (3.0 * q * (d - c) + s * d) > 0.0
        low, high = (s, high) if deep else (low, s)
    factor = reals(w, COEF)[wholes(p, P_CONTACT_AT)[j] + FACTOR]
    part = max(KEPT_LOSS * factor, LANDING)
    allowed = min(RELEASED * reals(w, SETTINGS)[TOLERANCE], part)
    added = 0.5 * force * h * (1.0 - high) / meeting_mass(reals(p, P_MOBILITY), j, r0)
    return high if added > allowed * abs(r1[DEPTH_RATE]) else -1.0


def locate(p, w, h, old):
    """Fraction of the step at which the first impact begins or ends; -1: none inside.

    The response at the end of the step is kept for the balance there. Journals fly along cubics
    through both ends of the step. One whose control points lie inside the clearance stays there.
    """
    acting, at, first, path = reals(w, ACTING), wholes(p, P_CONTACT_AT), -1.0, np.empty((4, 3))
    joints, stack = at.size, reals(w, STACK)
    response = looked(p, w, 1 - old)[3]
    respond(p, reals(w, Y1_), reals(w, V1_), reals(w, COEF), response)
    started = looked(p, w, old)[3]
    for j in range(joints):
        r0, r1 = started[j], response[j]
        if acting[at[j] + ACTIVE] != 0.0:
            part = _release(p, w, h, j, r0, r1)
            if part > 0.0 and (first < 0.0 or part < first):
                first = part
            continue
        flat = r0[FLAT] != 0.0
        for k in range(3):
            path[0, k], path[1, k] = r0[PATH + k], r0[PATH + k] + h / 3.0 * r0[PATH_RATE + k]
            path[2, k], path[3, k] = r1[PATH + k] - h / 3.0 * r1[PATH_RATE + k], r1[PATH + k]
        reach = path[0, 0]
        for i in range(4):
            one = path[i, 0]
            if not flat:
                one = sqrt(path[i, 0] ** 2 + path[i, 1] ** 2 + path[i, 2] ** 2)
            reach = max(reach, one)
        near = (1.0 - LANDING) * min(r0[GAP], r1[GAP])
        if near <= 0.0 or reach > near:
            at_ = onset(path, r0[GAP], r1[GAP], flat, stack.reshape((64, 9)))
            if at_ > 0.0 and (first < 0.0 or at_ < first):
                first = at_
    return first


@cache
def locating() -> int:
    """Address of ``locate``."""
    return kernel(LOCATE)(locate)


@inner
def catching(p, w):
    """Fraction of the step at which the first latch reaches its place; -1: none does."""
    values, at, coef = reals(p, P_LATCH_VALUE), wholes(p, P_LATCH_AT), reals(w, COEF)
    y0, y1, first = reals(w, Y), reals(w, Y1_), -1.0
    for i in range(values.size):
        k = at[2 * i]
        before, now = y0[k] - values[i], y1[k] - values[i]
        sign = 1.0 if values[i] >= 0.0 else -1.0
        if coef[at[2 * i + 1]] == 0.0 and sign * before < 0.0 <= sign * now:
            part = before / (before - now)
            if first < 0.0 or part < first:
                first = part
    return first
