"""What constraints ask of a step beyond Phi = 0: velocities, projection, a decaying violation."""

from functools import cache

import numpy as np

from mechanics.kernels import kernel
from mechanics.march.jacobians import solve
from mechanics.march.program import BAUMGARTE, CONSTRAINT, NEWTON, P_SCALE, PROJECTED, RATE
from mechanics.march.steps import ROUND_OFF, STALLED
from mechanics.march.store import (
    A1_,
    DEMAND,
    FORCE1,
    OTHER,
    RATES,
    SCRATCH,
    SETTINGS,
    TOTAL,
    TRIED,
    V1_,
    VALUES,
    WORST,
    Y1_,
    X,
    acting,
    copy,
    fill,
    inner,
    reals,
)
from mechanics.march.terms import forces, instant, write_signals

PROJECTIONS = 4
"""Corrections of the positions of a projected step, at most."""


@inner
def _violation(p, w, eps, curved, phi):
    """Overwrite ``phi`` (m,) with Phi at t + eps along the motion of the trial."""
    y, v, a = reals(w, Y1_), reals(w, V1_), reals(w, A1_)
    moved, out, coef = reals(w, OTHER), reals(w, SCRATCH), acting(p, w)
    n = a.size
    for i in range(n):
        moved[i] = y[i] + eps * v[i] + curved * 0.5 * eps * eps * a[i]
    fill(moved[n:], 0.0)
    write_signals(p, reals(w, TRIED)[0] + eps, reals(w, VALUES), coef)
    fill(out, 0.0)
    forces(p, moved, v, coef, CONSTRAINT, out)
    copy(out[n:], phi)


def decay(p, w, h):
    """Rows of Baumgarte (1972) in place of Phi: Phi'' + 2 w Phi' + w^2 Phi, scaled like Phi.

    Derivatives by central differences along the motion, exact for quadratic constraints.
    """
    s, step, total, n = reals(w, SETTINGS), reals(w, TRIED), reals(w, TOTAL), reals(w, A1_).size
    m = total.size - n
    rates = reals(w, RATES).reshape((3, m))
    eps = instant(reals(w, Y1_), reals(w, V1_), reals(p, P_SCALE))
    for k in range(3):
        _violation(p, w, (k - 1) * eps, 1.0, rates[k])
    write_signals(p, step[0], reals(w, VALUES), acting(p, w))
    rate = s[RATE] if s[RATE] > 0.0 else 2.0 / h
    scale = step[1] / (1.0 + 2.0 * rate * step[2] + rate * rate * step[1])
    for i in range(m):
        bend = (rates[0, i] - 2.0 * rates[1, i] + rates[2, i]) / eps**2
        slope = (rates[2, i] - rates[0, i]) / (2.0 * eps)
        total[n + i] = scale * (bend + 2.0 * rate * slope + rate * rate * rates[1, i])


def velocity_rows(p, w, h):
    """Rows Phi' in place of Phi, scaled like Phi (index 2)."""
    step, total, n = reals(w, TRIED), reals(w, TOTAL), reals(w, A1_).size
    m = total.size - n
    rates = reals(w, RATES).reshape((3, m))
    eps = instant(reals(w, Y1_), reals(w, V1_), reals(p, P_SCALE))
    for k in range(2):
        _violation(p, w, (2 * k - 1) * eps, 0.0, rates[k])
    write_signals(p, step[0], reals(w, VALUES), acting(p, w))
    for i in range(m):
        total[n + i] = step[1] / step[2] * (rates[1, i] - rates[0, i]) / (2.0 * eps)


def project(p, w, h):
    """Positions that obey the constraints, nearest in the metric of the system matrix.

    Where none are found the error of the step becomes infinite.

    The step has made the velocities obey them (index 2); what the positions lack is of third
    order (stabilised index 2; Lunk & Simeon 2006; Jay & Negrut 2007).
    """
    y, x, total, n = reals(w, Y1_), reals(w, X), reals(w, TOTAL), reals(w, A1_).size
    v, coef, scale = reals(w, V1_), acting(p, w), reals(p, P_SCALE)
    floor, size = 0.0, 0.0
    for i in range(n):
        floor = max(floor, abs(y[i]) / scale[i])
    tolerance = max(reals(w, SETTINGS)[NEWTON], STALLED * ROUND_OFF * floor)
    for _ in range(PROJECTIONS):
        fill(total, 0.0)
        forces(p, y, v, coef, CONSTRAINT, total)
        fill(x[:n], 0.0)
        for i in range(n, x.size):
            x[i] = -total[i]
        solve(p, w)
        size = 0.0
        for i in range(n):
            y[i] += x[i]
            one = abs(x[i]) / scale[i]
            if not one <= size:
                size, w.whole[WORST] = one, i
            if np.isnan(one):
                break
        if not size > tolerance:
            break
    if not size <= tolerance:
        reals(w, TRIED)[3] = np.inf
    fill(total, 0.0)
    forces(p, y, v, coef, -1, total)
    copy(total[:n], reals(w, FORCE1))


@cache
def demands(form: int) -> tuple[int, int]:
    """Addresses of what makes the rows other than Phi, and of what ends a step; 0: nothing."""
    if form == BAUMGARTE:
        return kernel(DEMAND)(decay), 0
    if form == PROJECTED:
        return kernel(DEMAND)(velocity_rows), kernel(DEMAND)(project)
    return 0, 0
