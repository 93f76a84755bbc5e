"""Jacobians that are kept for several step sizes: which one serves, factors and solutions."""

import numpy as np

from mechanics.kernels import factor_at, solve_at
from mechanics.march.program import ALPHA_F, ALPHA_M, P_SOLVER, P_SOLVER_INTS
from mechanics.march.store import (
    DATA,
    FACTORS,
    IN_USE,
    JACOBIAN,
    JACOBIANS,
    KNOWN,
    MADE_FOR,
    MEASURED,
    SETTINGS,
    TRIED,
    USED,
    V1_,
    WASTED,
    Y1_,
    X,
    acting,
    fill,
    inner,
    reals,
    wholes,
)
from mechanics.march.terms import matrix

FROZEN = 0.35
"""A Jacobian serves step sizes within this fraction of its own [-]."""


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
def renew(p, w, h):
    """Factorise where the trial is; False if singular."""
    s, step, data, jacobian = reals(w, SETTINGS), reals(w, TRIED), reals(w, DATA), in_use(w)
    weight = 1.0 - s[ALPHA_F]
    matrix(
        p, reals(w, Y1_), reals(w, V1_), acting(p, w), 1.0 - s[ALPHA_M], weight * step[1],
        weight * step[2], data,
    )  # fmt: skip
    total = 0.0
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
