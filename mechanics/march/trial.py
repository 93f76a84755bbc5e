"""The state that a step tries: predicted from the past, corrected, and how well that went on."""

from mechanics.march.program import ALPHA_F, BDF2, BETA, GAMMA, KIND, NEWMARK, P_SCALE
from mechanics.march.store import (
    A1_,
    BEFORE,
    CLOCK,
    EARLIER,
    Q_HAT,
    SETTINGS,
    TREND,
    TRIED,
    V1_,
    V_HAT,
    Y1_,
    A,
    V,
    X,
    Y,
    inner,
    reals,
)


@inner
def predict(w, h):
    """q^, v^ and the factors B, G of the step."""
    s, step, last = reals(w, SETTINGS), reals(w, TRIED), reals(w, CLOCK)[1]
    y, v, a, q_hat, v_hat = (
        reals(w, Y), reals(w, V), reals(w, A), reals(w, Q_HAT), reals(w, V_HAT)
    )  # fmt: skip
    n = a.size
    if s[KIND] == NEWMARK:
        step[1], step[2] = s[BETA] * h * h, s[GAMMA] * h
        for i in range(n):
            v_hat[i] = v[i] + h * (1.0 - s[GAMMA]) * a[i]
            q_hat[i] = y[i] + h * v[i] + h * h * (0.5 - s[BETA]) * a[i]
        return
    before = reals(w, BEFORE)
    r = h / last if s[KIND] == BDF2 and last > 0.0 else 0.0
    g = h * (1.0 + r) / (1.0 + 2.0 * r)
    one, two = (1.0 + r) ** 2 / (1.0 + 2.0 * r), r * r / (1.0 + 2.0 * r)
    step[1], step[2] = g * g, g
    for i in range(n):
        old_q, old_v = one * y[i], one * v[i]
        if r > 0.0:
            old_q -= two * before[i]
            old_v -= two * before[y.size + i]
        v_hat[i] = old_v
        q_hat[i] = old_q + g * old_v


@inner
def _place(w):
    """y, v of the trial from its accelerations."""
    y, v, a, step = reals(w, Y1_), reals(w, V1_), reals(w, A1_), reals(w, TRIED)
    q_hat, v_hat = reals(w, Q_HAT), reals(w, V_HAT)
    for i in range(a.size):
        y[i] = q_hat[i] + step[1] * a[i]
        v[i] = v_hat[i] + step[2] * a[i]


@inner
def begin(w, h):
    """The trial, with accelerations and multipliers that go on as they did, as far as that helped.

    The part of the last change that is added is what would have been best a step before.
    """
    a1, y1, a, y = reals(w, A1_), reals(w, Y1_), reals(w, A), reals(w, Y)
    earlier, trend, n = reals(w, EARLIER), reals(w, TREND), a1.size
    ahead = trend[0] * h / trend[1] if trend[1] > 0.0 else 0.0
    if ahead == 0.0:
        for i in range(n):
            a1[i] = a[i]
        for i in range(n, y.size):
            y1[i] = y[i]
    else:
        for i in range(n):
            a1[i] = a[i] + ahead * (a[i] - earlier[i])
        for i in range(n, y.size):
            y1[i] = y[i] + ahead * (y[i] - earlier[i])
    _place(w)


@inner
def correct(w):
    """Add the correction to the trial: accelerations, multipliers, coordinates, velocities."""
    s, step, y1, v1, a1 = (
        reals(w, SETTINGS), reals(w, TRIED), reals(w, Y1_), reals(w, V1_), reals(w, A1_)
    )  # fmt: skip
    q_hat, v_hat, x, B, G = reals(w, Q_HAT), reals(w, V_HAT), reals(w, X), step[1], step[2]
    for i in range(a1.size):
        a1[i] += x[i] / B
        y1[i] = q_hat[i] + B * a1[i]
        v1[i] = v_hat[i] + G * a1[i]
    for i in range(a1.size, x.size):
        y1[i] += x[i] / ((1.0 - s[ALPHA_F]) * B)


@inner
def note_trend(p, w, h):
    """How well the change of the accelerations in the last step told that in this one."""
    a0, a1, y0 = reals(w, A), reals(w, A1_), reals(w, Y)
    earlier, trend, n, both, square = reals(w, EARLIER), reals(w, TREND), reals(w, A).size, 0.0, 0.0
    scale = reals(p, P_SCALE)
    if trend[1] > 0.0:
        for i in range(n):
            change = (a0[i] - earlier[i]) / scale[i]
            both += change * (a1[i] - a0[i]) / scale[i]
            square += change * change
        part = both / square * trend[1] / h if square > 0.0 else 0.0
        trend[0] = min(max(part, 0.0), 1.0)
    for i in range(n):
        earlier[i] = a0[i]
    for i in range(n, y0.size):
        earlier[i] = y0[i]
    trend[1] = h
