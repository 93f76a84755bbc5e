"""Jacobians that are kept for several step sizes: which one serves, factors and solutions."""

import numpy as np

from mechanics.kernels import factor_at, solve_at
from mechanics.march.program import (
    ALPHA_F,
    ALPHA_M,
    BODY,
    CONSTRAINT,
    CONTACT,
    LOAD,
    P_MASS_DATA,
    P_SCALE,
    P_SOLVER,
    P_SOLVER_INTS,
)
from mechanics.march.store import (
    A1_,
    BODIES,
    DATA,
    FACTORS,
    IN_USE,
    JACOBIAN,
    JACOBIANS,
    KNOWN,
    MADE_FOR,
    MEASURED,
    SETTINGS,
    TAKEN,
    TRIED,
    USED,
    V1_,
    WASTED,
    Y1_,
    X,
    acting,
    copy,
    fill,
    inner,
    reals,
    wholes,
)
from mechanics.march.terms import matrix, tangents

FROZEN = 0.35
"""A Jacobian serves step sizes within this fraction of its own [-]."""
NEAR = 0.02
"""What bodies add is kept while no coordinate has moved by more of its size [-]."""


@inner
def _factorise(p, w):
    """0 if the matrix could be factorised."""
    ints, data = wholes(p, P_SOLVER_INTS), reals(w, DATA)
    return factor_at(wholes(p, P_SOLVER)[0])(ints, data, _factors(w))


@inner
def solve(p, w):
    """The right-hand side becomes the solution."""
    ints, b = wholes(p, P_SOLVER_INTS), reals(w, X)
    solve_at(wholes(p, P_SOLVER)[1])(ints, _factors(w), b)


@inner
def _factors(w):
    """Factors of the Jacobian in use."""
    whole = reals(w, FACTORS)
    size = whole.size // JACOBIANS
    return whole[size * w.whole[IN_USE] : size * (w.whole[IN_USE] + 1)]


@inner
def in_use(w):
    """What is known of the Jacobian in use."""
    return reals(w, JACOBIAN)[KNOWN * w.whole[IN_USE] : KNOWN * (w.whole[IN_USE] + 1)]


@inner
def _near(p, w):
    """Whether the trial is near the place where the bodies were taken."""
    y, at, scale = reals(w, Y1_), reals(w, BODIES)[2 * reals(w, DATA).size :], reals(p, P_SCALE)
    far = 0.0
    for i in range(at.size):
        far = max(far, abs(y[i] - at[i]) / scale[i])
    return far <= NEAR


@inner
def _take_bodies(p, w):
    """K and C of the bodies where the trial is."""
    bodies = reals(w, BODIES)
    y, v, coef, half = reals(w, Y1_), reals(w, V1_), acting(p, w), reals(w, DATA).size
    fill(bodies, 0.0)
    tangents(p, y, v, coef, BODY, 1.0, 0.0, bodies[:half])
    tangents(p, y, v, coef, BODY, 0.0, 1.0, bodies[half : 2 * half])
    copy(y[: reals(w, A1_).size], bodies[2 * half :])
    w.whole[TAKEN] = w.whole[2] + w.whole[3] + 1


@inner
def _refill(p, w, cM, cK, cC):
    """The matrix where the trial is, with bodies as they were taken: in the time between two
    impacts they hardly change, and are what costs most."""
    if w.whole[TAKEN] == 0 or not _near(p, w):
        _take_bodies(p, w)
    bodies, mass, data = reals(w, BODIES), reals(p, P_MASS_DATA), reals(w, DATA)
    half = data.size
    for i in range(half):
        data[i] = cM * mass[i] + (cK * bodies[i] + cC * bodies[half + i])
    for role in (CONSTRAINT, LOAD, CONTACT):
        tangents(p, reals(w, Y1_), reals(w, V1_), acting(p, w), role, cK, cC, data)


@inner
def renew(p, w, h):
    """Factorise where the trial is, but for bodies that have been kept; False if singular."""
    s, step, data, jacobian = reals(w, SETTINGS), reals(w, TRIED), reals(w, DATA), in_use(w)
    weight, total = 1.0 - s[ALPHA_F], 0.0
    cM, cK, cC = 1.0 - s[ALPHA_M], weight * step[1], weight * step[2]
    if reals(w, BODIES).size:
        _refill(p, w, cM, cK, cC)
    else:
        matrix(p, reals(w, Y1_), reals(w, V1_), acting(p, w), cM, cK, cC, data)
    for i in range(data.size - 1):
        total += data[i]
    fill(jacobian, 0.0)
    w.whole[5] += 1
    if not np.isfinite(total) or _factorise(p, w) != 0:
        return False
    jacobian[MADE_FOR] = h
    return True


@inner
def serves(p, w, h):
    """Whether the Jacobian of an earlier step will do; put the one for this step size into use.

    Not where the corrections that an exact one would have saved have cost as much as it costs.
    Where there is none, the one that has waited longest makes room.
    """
    jacobians, nearest, oldest = reals(w, JACOBIAN), -1, 0
    for k in range(JACOBIANS):
        known = jacobians[KNOWN * k : KNOWN * (k + 1)]
        if known[USED] < jacobians[KNOWN * oldest + USED]:
            oldest = k
        far = abs(h / known[MADE_FOR] - 1.0) if known[MADE_FOR] > 0.0 else np.inf
        if far <= FROZEN and (
            nearest < 0 or far < abs(h / jacobians[KNOWN * nearest + MADE_FOR] - 1.0)
        ):
            nearest = k
    w.whole[IN_USE] = nearest if nearest >= 0 else oldest
    known = in_use(w)
    if known[USED] != w.whole[2] + w.whole[3]:  # what was measured before others were in use is old
        known[MEASURED] = 0.0
    return nearest >= 0 and jacobians[KNOWN * nearest + WASTED] <= wholes(p, P_SOLVER)[2]
