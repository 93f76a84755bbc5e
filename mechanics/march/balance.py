"""Energies at both ends of a step, and what it adds to the ledger."""

from math import sqrt

import numpy as np

from mechanics.march.program import (
    ALPHA_F,
    ALPHA_M,
    AXIS,
    BETA,
    CENTRE,
    CONSTRAINT,
    DAMPING,
    DEFECT,
    DEPTH,
    DISSIPATIVE,
    ELASTIC,
    FORM,
    FRICTION,
    GAMMA,
    GAP,
    HYSTERESIS,
    KIND,
    LOAD,
    MOMENT,
    NEWMARK,
    NUMERICAL,
    P_DRIVEN,
    PROJECTED,
    RUBBED,
    SIDE,
    SLIP,
    WORK_DRIVE,
    WORK_LOADS,
    WORK_THERMAL,
)
from mechanics.march.store import (
    A1_,
    BEGUN,
    C1,
    COEF,
    FORCE0,
    FORCE1,
    INERTIA,
    LEDGER,
    LOST,
    MOMENTUM,
    OTHER,
    SCRATCH,
    SETTINGS,
    THIRD,
    V1_,
    Y1_,
    A,
    V,
    Y,
    copy,
    fill,
    inner,
    looked,
    reals,
    wholes,
)
from mechanics.march.terms import energies, forces, half_product, inertia


@inner
def look(p, w, y, v, coef, which):
    """Fill a balance: kinetic, strain, contact energy, powers lost and on free strains; forces of
    loads and of driven constraints. The response of contacts is there already, see ``locate``.
    """
    n, out, inertial = p.ints[0], reals(w, SCRATCH), reals(w, THIRD)[: p.ints[0]]
    real, external, drive, _ = looked(p, w, which)
    inertia(p, v, inertial)
    real[0] = half_product(v, inertial)
    energies(p, y, v, coef, real[1:])
    fill(out, 0.0)
    forces(p, y, v, coef, LOAD, out)
    for i in range(n):
        external[i] = -out[i]
    driven, masked = wholes(p, P_DRIVEN), reals(w, OTHER)
    if driven.size:
        copy(y[:n], masked)
        fill(masked[n:], 0.0)
        fill(out, 0.0)
        for row in driven:
            masked[n + row] = y[n + row]
        forces(p, masked, v, coef, CONSTRAINT, out)
        copy(out[:n], drive)


@inner
def _rubbed(r0, r1, h):
    """Work of friction [J]: mean force and moment times the way and the turn of the journal.

    The turn of a step is known to ± pi. Where the pose is not known, mean force times mean slip.
    """
    work, known = 0.0, r1[AXIS] != 0.0 or r1[AXIS + 1] != 0.0 or r1[AXIS + 2] != 0.0
    if not known:
        for i in range(3):
            mean = r0[FRICTION + i] + r1[FRICTION + i]
            work -= 0.25 * h * mean * (r0[SLIP + i] + r1[SLIP + i])
        return work
    sine, square, trace = np.zeros(3), 0.0, 0.0
    for first in (AXIS, SIDE, -1):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            a, b = _direction(r0, first, j), _direction(r0, first, k)
            c, d = _direction(r1, first, j), _direction(r1, first, k)
            sine[i] += 0.5 * (a * d - b * c)
            trace += a * c
    for i in range(3):
        square += sine[i] ** 2
    turn = np.arctan2(sqrt(square), 0.5 * (trace - 1.0)) / sqrt(square) if square > 0.0 else 1.0
    for i in range(3):
        work -= 0.5 * (r0[FRICTION + i] + r1[FRICTION + i]) * (r1[CENTRE + i] - r0[CENTRE + i])
        work -= 0.5 * (r0[MOMENT + i] + r1[MOMENT + i]) * turn * sine[i]
    return work


@inner
def _direction(r, first, i):
    """Component i of a direction of the journal; -1: the one across the other two."""
    if first >= 0:
        return r[first + i]
    j, k = (i + 1) % 3, (i + 2) % 3
    return r[AXIS + j] * r[SIDE + k] - r[AXIS + k] * r[SIDE + j]


@inner
def _contact_losses(p, w, h, old, new):
    """Add what each contact lost over the step to ``LOST``; sums of hysteresis and friction.

    Mean forces times ways: of the normal force along the gap, of friction see ``_rubbed``.
    """
    lost, hysteresis, friction = reals(w, LOST), 0.0, 0.0
    response0, response1 = looked(p, w, old)[3], looked(p, w, new)[3]
    for j in range(len(response0)):
        r0, r1 = response0[j], response1[j]
        if r0[ELASTIC] == 0.0 and r1[ELASTIC] == 0.0:
            continue
        way = r1[DEPTH] + r1[GAP] - r0[DEPTH] - r0[GAP]
        pressed, rubbed = 0.5 * (r0[DISSIPATIVE] + r1[DISSIPATIVE]) * way, _rubbed(r0, r1, h)
        lost[2 * j] += pressed
        lost[2 * j + 1] += rubbed
        hysteresis += pressed
        friction += rubbed
    return hysteresis, friction


@inner
def changing(p, w):
    """Whether energies depend on time by their coefficients."""
    return reals(w, C1).size > 0 or p.ints[3] != 0


@inner
def _heating(p, w, before, after):
    """Energy [J] that a change of coefficients brings, mean over both ends of a step.

    They change with temperature, or by functions of time such as the rope that a winch pays out.
    """
    if not changing(p, w):
        return 0.0
    out = np.zeros(4)
    energies(p, reals(w, Y), reals(w, V), reals(w, COEF), out)
    first = out[0] + out[1] - before[1] - before[2]
    energies(p, reals(w, Y1_), reals(w, V1_), reals(w, BEGUN), out)
    return 0.5 * (first + after[1] + after[2] - out[0] - out[1])


@inner
def _scheme_work(p, w, h):
    """Energy that a scheme itself adds over a step beyond -dq.(F0 + F1)/2 [J].

    Newmark's update makes the change of kinetic energy exactly

        dK = dq.M(a0 + a1)/2 + (g - 1/2) dq.M da - h^2 (b - g/2) da.M((a0 + a1)/2 + (g - 1/2) da)

    and M a1 follows from the forces by the balance of the step (Krenk & Hogsberg 2005 give the
    linear case of HHT). BDF and projected positions have no such relation: there the kinetic
    energies themselves are taken, (v0 + v1).M(v1 - v0)/2.
    """
    s, y0, y1, v0, v1 = reals(w, SETTINGS), reals(w, Y), reals(w, Y1_), reals(w, V), reals(w, V1_)
    a0, a1, F0, F1 = reals(w, A), reals(w, A1_), reals(w, FORCE0), reals(w, FORCE1)
    M0, mean, total, n = reals(w, MOMENTUM), reals(w, INERTIA), 0.0, a0.size
    if s[KIND] != NEWMARK or s[FORM] == PROJECTED:
        other, Ma = reals(w, OTHER), reals(w, THIRD)
        for i in range(n):
            other[i] = v1[i] - v0[i]
        inertia(p, other, Ma[:n])
        for i in range(n):
            total += 0.5 * ((v1[i] + v0[i]) * Ma[i] + (y1[i] - y0[i]) * (F0[i] + F1[i]))
        return total
    excess, drift = s[GAMMA] - 0.5, h * h * (s[BETA] - 0.5 * s[GAMMA])
    for i in range(n):
        by_force = (1.0 - s[ALPHA_F]) * F1[i] + s[ALPHA_F] * F0[i]
        made = -(by_force + s[ALPHA_M] * M0[i]) / (1.0 - s[ALPHA_M])  # M a1 by the forces
        more = (mean[i] - M0[i]) / (1.0 - s[ALPHA_M])  # M (a1 - a0)
        dq = y1[i] - y0[i]
        half = 0.5 * (a0[i] + a1[i]) + excess * (a1[i] - a0[i])
        total += 0.5 * dq * (M0[i] + made + F0[i] + F1[i]) + more * (excess * dq - drift * half)
    return total


@inner
def book(p, w, h, old, new):
    """Add the step to the ledger; see ``mechanics.ledger``."""
    y0, y1, F0, F1 = reals(w, Y), reals(w, Y1_), reals(w, FORCE0), reals(w, FORCE1)
    before, external0, drive0 = looked(p, w, old)[:3]
    after, external1, drive1 = looked(p, w, new)[:3]
    hysteresis, friction = _contact_losses(p, w, h, old, new)
    loads, drive, by_forces = 0.0, 0.0, 0.0
    for i in range(F0.size):
        dq = 0.5 * (y1[i] - y0[i])
        loads += dq * (external0[i] + external1[i])
        drive -= dq * (drive0[i] + drive1[i])
        by_forces -= dq * (F0[i] + F1[i])
    damping = 0.5 * h * (before[3] + after[3])
    heating = _heating(p, w, before, after) - 0.5 * h * (before[4] + after[4])
    known = loads + drive + heating - hysteresis - friction - damping
    stored = after[1] + after[2] - before[1] - before[2]
    numerical = known - stored - by_forces - _scheme_work(p, w, h)
    defect = after[0] - before[0] + stored - (known - numerical)
    ledger = reals(w, LEDGER)
    copy(after[:3], ledger)
    ledger[WORK_LOADS] += loads
    ledger[WORK_DRIVE] += drive
    ledger[WORK_THERMAL] += heating
    ledger[RUBBED] += friction
    ledger[HYSTERESIS] += hysteresis
    ledger[DAMPING] += damping
    ledger[NUMERICAL] += numerical
    ledger[DEFECT] += defect
