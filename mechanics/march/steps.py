"""One step: predict, correct with a Jacobian that may be old, measure the local error."""

import numpy as np

from mechanics.contact_laws import ACTIVE
from mechanics.kernels import kernel
from mechanics.march.contacts import let_act
from mechanics.march.jacobians import in_use, renew, serves, solve
from mechanics.march.program import (
    ALPHA_F,
    ALPHA_M,
    BDF2,
    BETA,
    BEYOND,
    DONE,
    EULER,
    INACCURATE,
    INFINITE,
    ITERATIONS,
    KIND,
    NEWTON,
    P_CONTACT_AT,
    P_LIMITED,
    P_LIMITS,
    P_SCALE,
    SINGULAR,
    SMALLEST,
    TOLERANCE,
    UNCONVERGED,
)
from mechanics.march.store import (
    A1_,
    AGE,
    ATTEMPT,
    CLOCK,
    CONTRACTION,
    FAILED,
    FORCE0,
    FORCE1,
    INERTIA,
    MEASURED,
    MEASURED_FOR,
    MOMENTUM,
    PROJECT_AT,
    ROWS_AT,
    SETTINGS,
    SPAN,
    TAKEN,
    TOTAL,
    TRIED,
    USED,
    V1_,
    WASTED,
    WORST,
    Y1_,
    A,
    X,
    Y,
    acting,
    copy,
    demand_at,
    fill,
    inner,
    reals,
    wholes,
)
from mechanics.march.terms import coefficients, forces, inertia
from mechanics.march.trial import begin, correct, predict

REFRESH = 0.5
"""A contraction of the Newton corrections above this calls for a new Jacobian [-]."""
ACCELERATION, LOOSENESS = 1e-6, 1e6
"""Part of the accelerations that may remain uncorrected: since a correction of q divided by B is
one of a, this keeps forces and multipliers converged when steps are short [-]; it is so many times
the tolerance of the coordinates where that is more."""
ROUND_OFF = 8.0 * 2.220446049250313e-16
"""Corrections below this part of the coordinates mean nothing [-]."""
STALLED = 16.0
"""Corrections that no longer shrink are round-off up to this many of its units [-]."""
ENOUGH = 2
"""Corrections that a step takes with an exact Jacobian; more are held against it [-]."""
TRUST = 32
"""Steps of one size in which a measured contraction of the corrections is relied upon, at most, and
no more than had been taken with the same factors before [-]."""
SUDDEN = 0.03
"""Least contraction that is relied upon while contacts act [-]."""
CAUTION = 4.0
"""By how much the contraction may have grown since [-]."""


@inner
def _mean_inertia(p, w):
    """Overwrite ``INERTIA`` with M ((1 - alpha_m) a1 + alpha_m a0)."""
    s, a1, momentum, inertial = (
        reals(w, SETTINGS), reals(w, A1_), reals(w, MOMENTUM), reals(w, INERTIA)
    )  # fmt: skip
    inertia(p, a1, inertial)
    if s[ALPHA_M] != 0.0:
        for i in range(a1.size):
            inertial[i] = (1.0 - s[ALPHA_M]) * inertial[i] + s[ALPHA_M] * momentum[i]


@inner
def _residual(p, w, h):
    """Forces and rows of the trial, and right-hand side of its correction."""
    s, step, total, x = reals(w, SETTINGS), reals(w, TRIED), reals(w, TOTAL), reals(w, X)
    a1, force, inertial = reals(w, A1_), reals(w, FORCE0), reals(w, INERTIA)
    n, B, weight = a1.size, step[1], 1.0 - s[ALPHA_F]
    fill(total, 0.0)
    forces(p, reals(w, Y1_), reals(w, V1_), acting(p, w), -1, total)
    if w.whole[ROWS_AT] != 0:
        demand_at(w.whole[ROWS_AT])(p, w, h)
    _mean_inertia(p, w)
    for i in range(n):
        x[i] = -B * (inertial[i] + weight * total[i] + s[ALPHA_F] * force[i])
    for i in range(n, total.size):
        x[i] = -total[i]


@inner
def _trusted(p, w, h):
    """The contraction of corrections with the factors there are; infinite if it is not known.

    It grows with the age of the factors, from nothing when they are new. A contact may begin to
    stick or let go in any step, which no contraction of steps before tells: then only a correction
    that is small itself is relied upon.
    """
    jacobian = in_use(w)
    since = jacobian[AGE] - jacobian[MEASURED]
    if (
        not 0 < since <= min(TRUST, jacobian[MEASURED])
        or abs(h / jacobian[MEASURED_FOR] - 1.0) > 1e-6
    ):
        return np.inf
    known, coef = CAUTION * jacobian[CONTRACTION], acting(p, w)
    for at_ in wholes(p, P_CONTACT_AT):
        if coef[at_ + ACTIVE] != 0.0:
            return max(known, SUDDEN)
    return known


@inner
def _in_balance(p, w):
    """Forces of the trial as its accelerations say: the real ones but for what Newton left.

    With them a step shows no defect in the ledger; steps that measure the contraction evaluate
    their forces, and do.
    """
    s, force, force0, inertial = (
        reals(w, SETTINGS), reals(w, FORCE1), reals(w, FORCE0), reals(w, INERTIA)
    )  # fmt: skip
    _mean_inertia(p, w)
    for i in range(force.size):
        force[i] = -(inertial[i] + s[ALPHA_F] * force0[i]) / (1.0 - s[ALPHA_F])


@inner
def _floor(p, w):
    """Corrections below this mean nothing [-]."""
    y, scale, n, largest = reals(w, Y), reals(p, P_SCALE), reals(w, A1_).size, 0.0
    for i in range(n):
        largest = max(largest, abs(y[i]) / scale[i])
    return ROUND_OFF * largest


@inner
def _size_of_correction(p, w):
    """Size of a correction, of the accelerations, and the worst unknown; NaN if there is one."""
    a, x, scale = reals(w, A1_), reals(w, X), reals(p, P_SCALE)
    size, moved, worst = 0.0, 0.0, 0
    for i in range(a.size):
        one = abs(x[i]) / scale[i]
        if not one <= size:
            size, worst = one, i
        if np.isnan(one):
            break
        moved = max(moved, abs(a[i]) / scale[i])
    return size, moved, worst


@inner
def _newton(p, w, h):
    """Correct until the estimated remaining correction is below the tolerance.

    A step takes the contraction of its corrections from earlier ones of the same size with the
    same factors, except every ``TRUST``-th, which measures it.
    Returns the reason (DONE: converged), the number of corrections, the worst unknown.
    """
    s, B, jacobian = reals(w, SETTINGS), reals(w, TRIED)[1], in_use(w)
    n, trusted, floor = reals(w, A1_).size, _trusted(p, w, h), _floor(p, w)
    begin(w, h)
    before, contraction, worst = np.inf, trusted, 0
    part = max(ACCELERATION, LOOSENESS * s[NEWTON])
    for count in range(1, int(s[ITERATIONS]) + 2):
        _residual(p, w, h)
        solve(p, w)
        size, moved, worst = _size_of_correction(p, w)
        tolerance = max(floor, min(s[NEWTON], part * B * moved))
        if not np.isfinite(size):
            return INFINITE, count, _first_infinite(reals(w, TOTAL), worst)
        if count > 1:
            contraction = size / before
            if contraction > REFRESH and size > max(tolerance, STALLED * floor):
                return UNCONVERGED, count, worst
            if count == 2 or contraction > jacobian[CONTRACTION]:
                jacobian[CONTRACTION] = contraction
            jacobian[MEASURED], jacobian[MEASURED_FOR] = jacobian[AGE], h
        correct(w)
        done = size == 0.0 or contraction * size <= tolerance
        if done or (count > 1 and contraction > REFRESH):
            jacobian[AGE] += 1.0
            if trusted < np.inf:
                _in_balance(p, w)
            else:
                _residual(p, w, h)
                copy(reals(w, TOTAL)[:n], reals(w, FORCE1))
            return DONE, count, worst
        before = size
    return UNCONVERGED, int(s[ITERATIONS]) + 1, worst


@inner
def _first_infinite(total, otherwise):
    for i in range(total.size):
        if not np.isfinite(total[i]):
            return i
    return otherwise


@inner
def _afresh(p, w, h):
    """Corrections with a Jacobian of the prediction, as ``_newton``, or why there is none."""
    begin(w, h)
    if renew(p, w, h):
        return _newton(p, w, h)
    _residual(p, w, h)
    lost = _first_infinite(reals(w, TOTAL), -1)
    return (SINGULAR, 0, 0) if lost < 0 else (INFINITE, 0, lost)


@inner
def _doubtful(w, h):
    """Whether a step may have failed for the bodies that were kept; they will be taken anew.

    Most fail for contacts, with all bodies where they are: so only the second of two in a row is
    held against the bodies, and the last one that there would be.
    """
    number, taken = w.whole[2] + 1, w.whole[TAKEN]
    again = w.whole[FAILED] == number or h <= 2.0 * reals(w, SETTINGS)[SMALLEST]
    w.whole[FAILED] = number
    if taken == 0 or taken == number + w.whole[3] or not again:
        return False
    w.whole[TAKEN] = 0
    return True


@inner
def _step(p, w, h):
    """A converged step with a Jacobian that may be old, else with one of the prediction, where in
    doubt with bodies where they are now.

    Returns reason, corrections, worst unknown.
    """
    predict(w, h)
    spent, old = 0, serves(p, w, h)
    while True:
        why, count, worst = _newton(p, w, h) if old else _afresh(p, w, h)
        spent += count
        if count > 0:
            in_use(w)[USED] = w.whole[2] + w.whole[3] + 1.0
        if why == DONE or not (old or _doubtful(w, h)):
            in_use(w)[WASTED] += max(0, count - ENOUGH)
            return why, spent, worst
        old = False


@inner
def _error(p, w, h):
    """Local error relative to the sizes of the coordinates, and the coordinate where it is.

    Newmark family: (beta - 1/6) h^2 |da| (Zienkiewicz & Xie 1991); BDF2: (2/9) h^2 |da|, backward
    Euler: h^2 |a|/2, their leading terms in q.
    """
    s, a0, a1, scale = reals(w, SETTINGS), reals(w, A), reals(w, A1_), reals(p, P_SCALE)
    factor, kept = abs(s[BETA] - 1.0 / 6.0), 1.0
    if s[KIND] == BDF2:
        factor = 2.0 / 9.0
    elif s[KIND] == EULER:
        factor, kept = 0.5, 0.0
    worst, size = 0, 0.0
    for i in range(a1.size):
        one = abs(a1[i] - kept * a0[i]) / scale[i]
        if not one <= size:
            worst, size = i, one
        if np.isnan(one):
            break
    return factor * h * h * size, worst


@kernel(ATTEMPT)
def attempt(p, w, h):
    """A converged step within the error tolerance, or the reason."""
    span, step, now = reals(w, SPAN), reals(w, TRIED), reals(w, CLOCK)[0]
    last = now + h > span[1] - 1e-9 * span[2]
    step[0] = span[1] if last else now + h
    coefficients(p, w, step[0])
    let_act(p, w, h)
    why, spent, w.whole[WORST] = _step(p, w, h)
    w.whole[4] += spent
    if why != DONE:
        return why
    step[4], at_ = _error(p, w, h)
    step[3] = step[4] / reals(w, SETTINGS)[TOLERANCE]
    if not step[3] <= 1.0:
        w.whole[WORST] = at_
        return INACCURATE
    if w.whole[PROJECT_AT] != 0:
        demand_at(w.whole[PROJECT_AT])(p, w, h)
        if step[3] == np.inf:
            return UNCONVERGED
    limited, limits, y = wholes(p, P_LIMITED), reals(p, P_LIMITS), reals(w, Y1_)
    for i in range(limited.size):
        if not limits[2 * i] <= y[limited[i]] <= limits[2 * i + 1]:
            w.whole[WORST] = i
            return BEYOND
    return DONE
