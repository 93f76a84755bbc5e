"""Contacts from step to step: what they carry, approach speeds, and steps that resolve impacts."""

from math import ceil, log2, sqrt

from numba import njit

from mechanics.contact_laws import (
    ACTIVE,
    APPROACH,
    HISTORIES,
    HISTORY,
    SLOT,
    STEP,
    duration,
    stored,
)
from mechanics.march.program import (
    DEPTH,
    DEPTH_RATE,
    FLAT,
    GAP,
    LARGEST,
    P_CONTACT_AT,
    P_MOBILITY,
    PATH,
    SMALLEST,
    TOLERANCE,
)
from mechanics.march.store import (
    ACTING,
    APPROACH0,
    COEF,
    HISTORY0,
    READY,
    SETTINGS,
    copy,
    inner,
    reals,
    wholes,
)

LANDING = 1e-6
"""An impact begins, and ends, within this fraction of the clearance before touching [-]."""
IMPACT_RESOLUTION, IMPACT_TOLERANCE, LEAST_RESOLUTION = 32.0, 1e-6, 6.0
"""Steps into which the estimated duration of an impact is divided at a tolerance, as which the
error in restitution falls, since it falls with their square; and at least, below which an impact
would gain energy [-]."""
PRESSED = 0.05
"""Least approach speed, in that of an impact as deep; far below one since the mass that meets is an
estimate, often too small in a mechanism [-]."""
UNMEASURED = -1.0
"""Marks an impact that runs without a positive approach speed: no dissipation is known for it."""
UNKNOWN = 1e-6
"""Approach speed where it is not known, in speeds of an impact as deep [-]."""
VIOLENT = 0.1
"""Penetration rate, in approach speeds, above which a contact is resolved as an impact [-]."""
CALM = 4
"""Steps between a refusal and the next doubling of the step size."""
DOUBLING_ERROR = 0.1
"""Part of the tolerance below which a local error allows twice the step, eight times the error."""


@inner
def write_contacts(p, w, h):
    """What contacts carry with them, and the step for which it holds, among the coefficients."""
    coef, at, approach = reals(w, COEF), wholes(p, P_CONTACT_AT), reals(w, APPROACH0)
    history = reals(w, HISTORY0)
    for j in range(at.size):
        coef[at[j] + ACTIVE], coef[at[j] + APPROACH], coef[at[j] + STEP] = 1.0, approach[j], h
        for i in range(HISTORIES):
            coef[at[j] + HISTORY + i] = history[HISTORIES * j + i]


@inner
def let_act(p, w, h):
    """No contact acts in a step that begins in free flight: it ends where the impact begins.

    A force at the end of a long step would slow the journal down before it arrives. A step that is
    short enough to resolve the impact may contain its beginning: the approach speed is that with
    which it begins.
    """
    coef, acting, at = reals(w, COEF), reals(w, ACTING), wholes(p, P_CONTACT_AT)
    approach, ready = reals(w, APPROACH0), reals(w, READY).reshape((at.size, 2))
    if at.size == 0:
        return
    write_contacts(p, w, h)
    for j in range(at.size):
        if approach[j] == 0.0 and h <= ready[j, 0]:
            coef[at[j] + APPROACH] = ready[j, 1]
    copy(coef, acting)
    for j in range(at.size):
        if coef[at[j] + APPROACH] == 0.0:
            acting[at[j] + ACTIVE] = 0.0


@inner
def get_ready(p, w, response):
    """Step that would resolve the impact which a journal in flight heads for, and its speed."""
    s, approach, coef = reals(w, SETTINGS), reals(w, APPROACH0), reals(w, COEF)
    mobility, at = reals(p, P_MOBILITY), wholes(p, P_CONTACT_AT)
    ready = reals(w, READY).reshape((at.size, 2))
    for j in range(at.size):
        speed = response[j, DEPTH_RATE]
        ready[j, 0], ready[j, 1] = 0.0, speed
        if approach[j] == 0.0 and speed > 0.0:
            mass = meeting_mass(mobility, j, response[j])
            ready[j, 0] = duration(mass, speed, coef[at[j] : at[j] + SLOT]) / _impact_steps(s)


@inner
def _impact_steps(s):
    """Steps into which the duration of an impact is divided."""
    return max(LEAST_RESOLUTION, IMPACT_RESOLUTION * sqrt(IMPACT_TOLERANCE / s[TOLERANCE]))


@njit(cache=True, error_model="numpy")
def meeting_mass(mobility, j, r):
    """Mass [kg] that meets in contact j along the direction of its gap."""
    W = mobility.reshape((-1, 3, 3))[j]
    square, give = r[PATH] ** 2 + r[PATH + 1] ** 2 + r[PATH + 2] ** 2, 0.0
    if r[FLAT] != 0.0 or square == 0.0:
        return 1.0 / W[0, 0]
    for i in range(3):
        for k in range(3):
            give += r[PATH + i] * W[i, k] * r[PATH + k]
    return square / give


@inner
def _speed_as_deep(mass, depth, row):
    """Approach speed [m/s] of an elastic impact that goes as deep."""
    return sqrt(2.0 * stored(depth, row) / mass)


@njit(cache=True, error_model="numpy")
def note_approach(contact_at, coef, mobility, response, approach):
    """Approach speed of each running impact: the largest since its onset; 0 once it is over.

    Taking the largest keeps the rate ratio of the hysteresis laws below one in contacts that
    are loaded anew without a separation. It is never less than ``PRESSED`` of the speed at which
    an impact would go as deep: pressing slowly is no impact, and what rates a contact at rest has
    are rounding errors. Once begun, an impact is over when the journal is clearly apart, so that
    no flight is too short for its end to be located.
    """
    for j in range(approach.size):
        gap, rate, near = response[j, DEPTH], response[j, DEPTH_RATE], abs(response[j, GAP])
        closing = rate > 0.0 or approach[j] != 0.0
        if gap > 0.0 or (gap > -LANDING * near and closing):
            row = coef[contact_at[j] : contact_at[j] + SLOT]
            largest = max(approach[j], rate, row[APPROACH])
            mass = meeting_mass(mobility, j, response[j])
            largest = max(largest, PRESSED * _speed_as_deep(mass, gap, row))
            approach[j] = largest if largest > 0.0 else UNMEASURED
        else:
            approach[j] = 0.0


@inner
def rung_below(s, h):
    """First rung of the ladder whose step is not longer than ``h``."""
    return max(0, ceil(log2(s[LARGEST] / max(h, s[SMALLEST])) - 1e-9))


@inner
def _impact_rung(p, w, response):
    """Rung that resolves the impacts in which penetration changes noticeably; 0 if none does.

    Noticeably is against the approach speed and against the speed of an impact as deep.
    """
    s, approach, coef = reals(w, SETTINGS), reals(w, APPROACH0), reals(w, COEF)
    mobility, contact_at, rung = reals(p, P_MOBILITY), wholes(p, P_CONTACT_AT), 0
    for j in range(approach.size):
        speed, row = approach[j], coef[contact_at[j] : contact_at[j] + SLOT]
        if speed == 0.0:
            continue
        mass = meeting_mass(mobility, j, response[j])
        as_deep = _speed_as_deep(mass, response[j, DEPTH], row)
        if abs(response[j, DEPTH_RATE]) > VIOLENT * max(speed, as_deep):
            last = duration(mass, max(speed, UNKNOWN * as_deep), row)
            rung = max(rung, rung_below(s, last / _impact_steps(s)))
    return rung


@inner
def next_rung(p, w, response, error):
    """Steps that resolve running impacts; longer ones when the error has been small for long."""
    w.whole[1] += 1
    finest = _impact_rung(p, w, response)
    if finest > 0 and finest >= w.whole[0]:  # calm begins anew: turning points of impacts are short
        w.whole[0], w.whole[1] = finest, 0
    elif w.whole[0] > finest and w.whole[1] >= CALM and error < DOUBLING_ERROR:
        w.whole[0], w.whole[1] = w.whole[0] - 1, 0
