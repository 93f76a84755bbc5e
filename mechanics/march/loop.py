"""The loop over the steps of a window: try, land on events, take, keep."""

from math import ceil

import numpy as np
from numba import njit

from mechanics.kernels import kernel
from mechanics.march.balance import book, changing, look
from mechanics.march.contacts import get_ready, next_rung, note_approach, rung_below, write_contacts
from mechanics.march.demands import demands
from mechanics.march.events import catching
from mechanics.march.program import (
    ALPHA_M,
    COLUMNS,
    DONE,
    FORM,
    FULL,
    LARGEST,
    LATCHED,
    P_CONTACT_AT,
    P_DRIVEN,
    P_MOBILITY,
    P_SOLVER,
    SMALLEST,
    TERMS,
    WORK_THERMAL,
    Array,
    Program,
)
from mechanics.march.store import (
    A1_,
    APPROACH0,
    BEFORE,
    BEGUN,
    C0,
    CLOCK,
    COEF,
    FORCE0,
    FORCE1,
    INERTIA,
    JACOBIANS,
    KNOWN,
    LEDGER,
    LOST,
    MOMENTUM,
    ROW_APPROACH,
    ROW_DRIVE,
    ROW_LEDGER,
    ROW_LOST,
    ROW_RESPONSE,
    ROW_T,
    ROW_V,
    ROW_Y,
    SETTINGS,
    SPAN,
    TAKE,
    TRIED,
    V1_,
    WORST,
    Y1_,
    A,
    Carried,
    Memory,
    V,
    Window,
    Y,
    attempt_at,
    copy,
    inner,
    locate_at,
    looked,
    reals,
    take_at,
    wholes,
)
from mechanics.march.terms import coefficients, inertia, remember, respond
from mechanics.march.trial import note_trend

LARGE = 1000
"""Unknowns above which it is worth keeping what bodies add to a Jacobian, where contacts call for
new ones [-]."""


def memory(
    program: Program,
    settings: Array,
    window: Window,
    carried: Carried,
    factors: int,
    kept: int,
    full: bool,
) -> Memory:
    """Copies of what is carried and of the window, and room for ``kept`` rows and the work."""
    n, m, joints = map(int, program.sizes[:3])
    y, looks = n + m, 5 + 2 * n + joints * COLUMNS
    driven, some = len(program.driven), kept if full else 0
    given = [*carried[:-1], settings, *window]
    rows = [kept, kept * joints * COLUMNS, kept * joints, kept * driven, 2 * kept * joints,
            some * y, some * y, some * TERMS]  # fmt: skip
    tried = [y, y, n, n, n, n, n, y, y, program.mass_data.size, JACOBIANS * factors]
    tried += [window.c0.size] * 3 + [program.signals.size]
    tried += [y, y, y, 3 * m, 5, JACOBIANS * KNOWN, 2 * joints, 2 * looks, 64 * 9, y, 3, n]
    tried += [2 * program.mass_data.size + n if joints and y > LARGE else 0]
    sizes = [part.size for part in given] + rows + tried
    ends = np.cumsum(sizes)
    room = np.zeros(ends[-1])
    np.concatenate([part.ravel() for part in given], out=room[: ends[len(given) - 1]])
    places = np.stack([ends - sizes, ends], axis=1).astype(np.int64)
    whole = [*carried.whole, 0, *demands(int(settings[FORM])), 0, 0, 0]
    return Memory(places, room, np.array(whole, np.int64))


@kernel(TAKE)
def take(p, w, h, old):
    """Book the step, update the running impacts and choose the next rung."""
    y, v, clock, before = reals(w, Y), reals(w, V), reals(w, CLOCK), reals(w, BEFORE)
    coef, new = reals(w, COEF), 1 - old
    look(p, w, reals(w, Y1_), reals(w, V1_), coef, new)
    book(p, w, h, old, new)
    if before.size:
        copy(y, before)
        copy(v, before[y.size :])
    note_trend(p, w, h)
    copy(reals(w, Y1_), y)
    copy(reals(w, V1_), v)
    copy(reals(w, A1_), reals(w, A))
    copy(reals(w, FORCE1), reals(w, FORCE0))
    if reals(w, SETTINGS)[ALPHA_M] == 0.0:
        copy(reals(w, INERTIA), reals(w, MOMENTUM))
    else:
        inertia(p, reals(w, A), reals(w, MOMENTUM))
    error = reals(w, TRIED)[4]
    clock[0], clock[1] = reals(w, TRIED)[0], h
    clock[2], clock[3] = clock[2] + error, max(clock[3], error)
    response = looked(p, w, new)[3]
    if p.ints[2]:
        remember(p, w)
        mobility = reals(p, P_MOBILITY)
        note_approach(wholes(p, P_CONTACT_AT), coef, mobility, response, reals(w, APPROACH0))
        get_ready(p, w, response)
    w.whole[2] += 1
    next_rung(p, w, response, reals(w, TRIED)[3])


@inner
def _size(w, target):
    """Step size on the ladder that ends the window in a whole number of steps, or the target."""
    if target > 0.0:
        return target
    remaining = reals(w, SPAN)[1] - reals(w, CLOCK)[0]
    rung = reals(w, SETTINGS)[LARGEST] / 2.0 ** w.whole[0]
    return remaining / max(1, ceil(remaining / rung - 1e-6))


@inner
def _substep(p, w, old):
    """One accepted step, whatever number of refused ones it takes: reason, worst unknown."""
    target, s, addresses = -1.0, reals(w, SETTINGS), wholes(p, P_SOLVER)
    while True:
        h = _size(w, target)
        why = attempt_at(addresses[3])(p, w, h)
        worst = w.whole[WORST]
        if why == DONE:
            landing = locate_at(addresses[4])(p, w, h, old) if addresses[4] != 0 else -1.0
            caught = catching(p, w)
            if 0.0 < caught < 1.0 - 1e-6 and (landing < 0.0 or caught < landing):
                landing = min(1.0, caught * (1.0 + 1e-9))
            if landing < 0.0:
                take_at(addresses[5])(p, w, h, old)
                return LATCHED if caught > 0.0 else DONE, worst
            target = landing * h
            continue
        w.whole[3] += 1
        if h <= 2.0 * s[SMALLEST]:
            return why, worst
        if target > 0.0:
            target *= 0.5
        else:
            w.whole[0], w.whole[1] = rung_below(s, 0.5 * h * (1.0 + 1e-9)), 0


@inner
def _enter(p, w):
    """Begin a window; a jump of coefficients or masses since the last one is work of heating."""
    coef, ledger = reals(w, COEF), reals(w, LEDGER)
    copy(reals(w, C0), coef)
    coefficients(p, w, reals(w, CLOCK)[0])
    write_contacts(p, w, 0.0)
    look(p, w, reals(w, Y), reals(w, V), coef, 0)
    respond(p, reals(w, Y), reals(w, V), coef, looked(p, w, 0)[3])
    inertia(p, reals(w, A), reals(w, MOMENTUM))
    now = looked(p, w, 0)[0]
    get_ready(p, w, looked(p, w, 0)[3])
    for k in range(3):
        ledger[WORK_THERMAL] += now[k] - ledger[k]
    copy(now[:3], ledger)


@inner
def _keep(p, w, count, new):
    """Keep a row of what the observer wants."""
    y, response, driven = reals(w, Y), looked(p, w, new)[3], wholes(p, P_DRIVEN)
    joints, size = response.shape[0], y.size
    reals(w, ROW_T)[count] = reals(w, CLOCK)[0]
    at = count * joints
    for j in range(joints):
        copy(response[j], reals(w, ROW_RESPONSE)[(at + j) * COLUMNS :])
    copy(reals(w, APPROACH0), reals(w, ROW_APPROACH)[at:])
    copy(reals(w, LOST), reals(w, ROW_LOST)[2 * at :])
    for i in range(driven.size):
        reals(w, ROW_DRIVE)[count * driven.size + i] = y[p.ints[0] + driven[i]]
    if reals(w, ROW_Y).size:
        copy(y, reals(w, ROW_Y)[count * size :])
        copy(reals(w, V), reals(w, ROW_V)[count * size :])
        copy(reals(w, LEDGER), reals(w, ROW_LEDGER)[count * TERMS :])


@njit(cache=True, error_model="numpy")
def march(p, w):
    """Carry the state in the memory to the end of the window, or as far as it goes.

    Parameters
    ----------
    p : Packed  the program
    w : Memory

    Returns
    -------
    how it ended, number of rows, the worst unknown of a step that was not possible
    """
    _enter(p, w)
    count, old, kept = 0, 0, reals(w, ROW_T).size
    clock, end = reals(w, CLOCK), reals(w, SPAN)[1]
    while clock[0] < end:
        if count == kept:
            return FULL, count, 0
        if changing(p, w):
            copy(reals(w, COEF), reals(w, BEGUN))
        why, worst = _substep(p, w, old)
        if why != DONE and why != LATCHED:
            return why, count, worst
        old = 1 - old
        _keep(p, w, count, old)
        count += 1
        if why == LATCHED:
            return LATCHED, count, worst
    return DONE, count, 0
