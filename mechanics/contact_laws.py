"""Compiled laws of contact: normal force, its energy, duration of impacts, friction with memory.

Depth, rate, slip velocity and normal may be complex: derivatives by any of them are taken with an
imaginary step (Squire & Trapp 1998), which loses no digits. All else of a contact, the history of
its friction included, is a row of ``SLOT`` real numbers.

Normal force, with the approach speed v of the running impact:

    N = max(0, F_e(δ) (1 + D δ̇/v)),   F_e = K δ^p   or, with K = π E* L and P = 4 π E* L ΔR,
    δ = F_e/K (ln(P/F_e) - 1)   (Johnson 1985 as in Pereira, Ramalho & Ambrosio 2011, internal)

The second rises up to P/e². Beyond ``RANGE`` of that it is continued with its slope there, which
is also what remains of it where no clearance is left (P <= 0).

Friction on the journal that slips with V, T = -N (σ0 z + σ1 ż + σ2 V) for bristles deflected by z:
``LUGRE`` (Canudas de Wit et al. 1995), ``STICK`` and ``RISING`` (z grows with the slip up to a
bound, μ_s after sticking, where it gives way and T falls to μ_k N); ``REGULARISED`` and
``STRIBECK`` have no bristles and creep under any load.
"""

from math import exp, gamma, log, pi, sqrt
from typing import Any

from numba import njit

ACTIVE, APPROACH, STEP, HISTORY = 0, 1, 2, 3
"""Columns that the integrator writes: 1 where the contact may act; approach speed [m/s] of the
running impact (0: none, -1: unknown); size of the step [s] (0: none); history of the friction."""
HISTORIES = 7
"""Bristle deflection (3) [m], slip velocity (3) [m/s], time since sticking began or 0 [s]."""
CLEARANCE, RADIUS = 10, 11
"""Radial clearance, radius of the journal [m]."""
LAW, K, P, FACTOR, REFERENCE = range(12, 17)
"""Normal law; K [N/m^p] and exponent, or π E* L [N/m] and 4 π E* L ΔR [N]; factor D; given v or 0
[m/s]."""
(FRICTION, KINETIC, STATIC, EPS, STRIBECK_SPEED, VISCOUS, BRISTLE, BRISTLE_DAMPING, RISE_RATE,
 RISE_EXPONENT) = range(17, 27)  # fmt: skip
"""Friction law; μ_k, μ_s; regularisation speed, speed of the Stribeck effect [m/s]; σ2 [s/m],
σ0 [1/m], σ1 [s/m], all over normal force; rate [1/s^m] and exponent m of rising friction."""
CORE = 27
"""Distance that the radius keeps at the centre [m]."""
CENTRE = 1e-6
"""The core in clearances: only so that the direction of the radius is smooth at the centre,
rho^2 = e.e + core^2 [-]."""
SEIZED = 1.0 / 3.0
"""The core of a joint without clearance, in its interference: the stiffness sideways is then that
of two opposite contacts, 3 K |c|^1/2 by Hertz [-]."""
SLOT = 28
COLUMNS = 32
"""Columns of the response of a contact, see ``mechanics.march``."""

POWER, CYLINDER = 0, 1
"""Normal laws."""
NONE, REGULARISED, STICK, STRIBECK, LUGRE, RISING = range(6)
"""Friction laws."""

RANGE = 0.9
"""Part of its largest force, P/e², up to which the law of the cylinder is used [-]."""
_STEEP = -log(RANGE)
LAST_FORCE = RANGE * exp(-2.0)
"""Largest force for which the law of the cylinder is used, in P [-]."""
_LAST_DEPTH = LAST_FORCE * (1.0 + _STEEP)  # in P/K
SLIDING = 0.95
"""Part of their steady deflection at which bristles of the LuGre law count as sliding [-]."""
LEAST = 1e-12
"""Keeps the LuGre law defined where a coefficient is zero [-]."""
AT_BOUND = 1e-9
"""Relative distance from the square of the bound that is round-off [-]."""
AT_ONCE = 1e-30
"""Time that marks a contact that sticks since this very moment [s]."""

_OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy"}
_law = njit(**_OPTIONS)


@_law
def _root(x):
    """Square root of a number with a small imaginary part; 0 with no derivative at 0."""
    if x.real <= 0.0:
        return x - x
    real = sqrt(x.real)
    return real + (x - x.real) * (0.5 / real)


@_law
def _exponential(x):
    """exp of a number with a small imaginary part."""
    return exp(x.real) * (1.0 + (x - x.real))


@_law
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_law
def _larger_root(eta):
    """Root y > 1 of y - ln y = 1 + eta, eta > 0: -W_{-1}(-e^(-1 - eta)) of Lambert's function.

    Newton's method from the lower bound of Chatzigeorgiou (2013): the function is convex, so that
    the first correction leads beyond the root and all others fall towards it.
    """
    y = 1.0 + sqrt(2.0 * eta) + eta * (2.0 / 3.0)
    for _ in range(20):
        correction = (1.0 + eta - y + log(y)) * y / (y - 1.0)
        y += correction
        if abs(correction) < 1e-8 * y:  # the next one would be the square of this
            break
    return y


@_law
def _cylinder(depth, stiffness, limit):
    """Force [N] and its slope [N/m] by the law of the cylinder: F = K δ/y, dF/dδ = K/(y - 1)."""
    reach = stiffness * depth
    bound = max(limit, 0.0)
    if reach >= _LAST_DEPTH * bound:
        return LAST_FORCE * bound + (reach - _LAST_DEPTH * bound) / _STEEP, stiffness / _STEEP
    y = _larger_root(log(min(limit / reach, 1e300)) - 2.0)
    return reach / y, stiffness / (y - 1.0)


@_law
def _elastic(depth, c):
    """Elastic force [N] and its slope [N/m] at a real, positive depth."""
    if c[LAW] == CYLINDER:
        return _cylinder(depth, c[K], c[P])
    p = c[P]
    if p == 1.0:
        slope = c[K]
    elif p == 1.5:
        slope = 1.5 * c[K] * sqrt(depth)
    else:
        slope = p * c[K] * depth ** (p - 1.0)
    return slope * depth / p, slope


@_law
def normal(depth, rate, c):
    """Elastic and dissipative part of the normal force [N]; their sum is never negative.

    Parameters
    ----------
    depth, rate : float or complex  penetration [m] and its rate [m/s]
    c : (SLOT,) float
    """
    nothing = (depth - depth) + (rate - rate)
    if depth.real <= 0.0 or c[ACTIVE] == 0.0:
        return nothing, nothing
    force, slope = _elastic(depth.real, c)
    elastic = force + slope * (depth - depth.real) + nothing
    speed = c[REFERENCE] if c[REFERENCE] > 0.0 else c[APPROACH]
    if speed <= 0.0:
        return elastic, nothing
    ratio = c[FACTOR] * rate / speed
    if ratio.real < -1.0:
        return elastic, -elastic
    return elastic, elastic * ratio


@_law
def _cylinder_energy(depth, stiffness, limit):
    """Elastic energy [J] by the law of the cylinder, F²/(2 K) (y - 1/2)."""
    bound = max(limit, 0.0)
    last = min(depth, _LAST_DEPTH * bound / stiffness)
    beyond = depth - last
    energy = 0.0
    if last > 0.0:
        force = _cylinder(last, stiffness, limit)[0]
        energy = 0.5 * force * (last - 0.5 * force / stiffness) + force * beyond
    return energy + 0.5 * stiffness / _STEEP * beyond**2


@_law
def stored(depth, c):
    """Elastic energy [J] at a real depth [m]."""
    if depth <= 0.0 or c[ACTIVE] == 0.0:
        return 0.0
    if c[LAW] == CYLINDER:
        return _cylinder_energy(depth, c[K], c[P])
    return _elastic(depth, c)[0] * depth / (c[P] + 1.0)


@_law
def _cylinder_depth(energy, stiffness, limit):
    """Depth [m] at which the law of the cylinder has stored ``energy`` [J]."""
    bound = max(limit, 0.0)
    last = _LAST_DEPTH * bound / stiffness
    missing = energy - _cylinder_energy(last, stiffness, limit)
    if missing >= 0.0:
        force, steep = LAST_FORCE * bound, stiffness / _STEEP
        return last + 2.0 * missing / (force + sqrt(force**2 + 2.0 * steep * missing))
    # with r = 2 y - 1 the energy is P²/(4 K) r e^(-3 - r)
    part = max(4.0 * energy / limit * (stiffness / limit), 1e-300)
    y = 0.5 * (1.0 + _larger_root(-log(part) - 4.0))
    return limit / stiffness * exp(-1.0 - y) * y


@_law
def duration(mass, speed, c):
    """Estimated duration [s] of an impact of ``mass`` [kg] at ``speed`` [m/s], without loss.

    Exact for a power law (Johnson 1985, sec. 11.4); that of the cylinder is taken as the power
    that has its force, depth and energy at the turning point.
    """
    speed = max(speed, 1e-100)
    if c[LAW] == CYLINDER:
        energy = 0.5 * mass * speed**2
        deepest = _cylinder_depth(energy, c[K], c[P])
        n = _elastic(deepest, c)[0] * deepest / energy
    else:
        n = c[P] + 1.0
        deepest = (0.5 * n * mass * speed**2 / c[K]) ** (1.0 / n)
    shape = sqrt(pi) * gamma(1.0 / n) / gamma(1.0 / n + 0.5) / n
    return 2.0 * deepest / speed * shape


@_law
def friction(V, n, force, c, T, new):
    """Friction on the journal and the history of the contact at the end of the step.

    Bristles are carried along with the tangent plane at their length. The deflection grows by the
    mean slip velocity of the step, exactly as the contact moves; in a step so long that it renews
    the deflection, by one closer to that at its end, so that friction lags the direction of the
    slip by as much as the bristles do and not by half a step.

    Parameters
    ----------
    V : (3,) float or complex  slip velocity in the tangent plane [m/s]
    n : (3,) float or complex  unit normal;  force : normal force >= 0 [N];  c : (SLOT,) float
    T : (3,) written: friction [N]
    new : (HISTORIES,) written: history at the end of the step

    Returns
    -------
    1.0 where bristles hold the journal, otherwise 0.0
    """
    for i in range(3):
        T[i] = 0.0
    for i in range(HISTORIES):
        new[i] = 0.0
    law = c[FRICTION]
    if law == NONE or force.real <= 0.0:
        return 0.0
    if law in (REGULARISED, STRIBECK) or c[BRISTLE] <= 0.0:
        _creep(V, force, c, T)
        return 0.0
    stuck = _lugre(V, n, force, c, T, new) if law == LUGRE else _stick(V, n, force, c, T, new)
    for i in range(3):
        new[3 + i] = V[i]
    new[6] = max(c[HISTORY + 6] + c[STEP], AT_ONCE) if stuck else 0.0
    return 1.0 if stuck else 0.0


@_law
def _stribeck(square, c):
    """μ_k + (μ_s - μ_k) exp(-(V/v_s)²) from the square of the slip speed."""
    if c[STATIC] == c[KINETIC] or c[STRIBECK_SPEED] <= 0.0:
        return c[KINETIC] + (square - square)
    return c[KINETIC] + (c[STATIC] - c[KINETIC]) * _exponential(-square / c[STRIBECK_SPEED] ** 2)


@_law
def _creep(V, force, c, T):
    """T = -N (μ/(|V| + ε) + σ2) V."""
    square = _dot(V, V)
    mu = _stribeck(square, c) if c[FRICTION] == STRIBECK else c[KINETIC] + (square - square)
    speed = _root(square) + c[EPS]
    factor = mu / speed if speed.real > 0.0 else mu - mu
    for i in range(3):
        T[i] = -force * (factor + c[VISCOUS]) * V[i]


@_law
def _carry(V, n, c, new):
    """Write deflection and slip velocity V0 at the beginning of the step, both carried to the
    present tangent plane, to new[:6]; how far the contact slips in the step [m].
    """
    z, V0 = c[HISTORY : HISTORY + 3], c[HISTORY + 3 : HISTORY + 6]
    lean, turn = _dot(n, z), _dot(n, V0)
    mean = turn - turn + V[0] - V[0]
    for i in range(3):
        new[i] = z[i] - lean * n[i]
        new[3 + i] = V0[i] - turn * n[i]
        mean = mean + (new[3 + i] + V[i]) ** 2
    before, after = _dot(z, z), _dot(new, new)
    length = _root(before / after) if after.real > 0.25 * before else 1.0 + (after - after)
    for i in range(3):
        new[i] = new[i] * length
    return 0.5 * c[STEP] * _root(mean)


@_law
def _weigh(V, share, new):
    """Overwrite V0 in new[3:6] with V + share (V0 - V)."""
    for i in range(3):
        new[3 + i] = V[i] - share * (V[i] - new[3 + i])


@_law
def _bound(c):
    """Coefficient that bristles bear: static after sticking, kinetic while sliding."""
    if c[HISTORY + 6] <= 0.0:
        return c[KINETIC]
    if c[FRICTION] != RISING:
        return c[STATIC]
    since = c[HISTORY + 6] + c[STEP]
    fallen = exp(-c[RISE_RATE] * since ** c[RISE_EXPONENT])
    return c[STATIC] - (c[STATIC] - c[KINETIC]) * fallen


@_law
def _holds(square, bound, c):
    """Whether bristles bear their load; what slid in the last step is at the bound."""
    if c[STEP] > 0.0:
        return square <= bound**2
    return c[HISTORY + 6] > 0.0 or square <= (1.0 - AT_BOUND) * bound**2


@_law
def _stick(V, n, force, c, T, new):
    """Friction of bristles with a bound; whether they hold.

    The bound is one of spring and damper together. Where it is passed both bear μ_k, in the
    direction in which they were pulled, and the deflection creeps to its value with σ1/σ0.
    """
    bound = _bound(c)
    length, slipped = bound / c[BRISTLE], _carry(V, n, c, new)
    share = 0.5 + (slipped - slipped)
    if slipped.real > 2.0 * length:  # no deflection is left of what was
        share = length / slipped * length / (slipped - length)
    _weigh(V, share, new)
    for i in range(3):
        T[i] = c[BRISTLE] * (new[i] + c[STEP] * new[3 + i]) + c[BRISTLE_DAMPING] * V[i]
    square = _dot(T, T)
    if _holds(square.real, bound, c):
        for i in range(3):
            new[i] = new[i] + c[STEP] * new[3 + i]
            T[i] = -force * (T[i] + c[VISCOUS] * V[i])
        return True
    kept = 0.0
    if c[BRISTLE_DAMPING] > 0.0:
        kept = exp(-c[STEP] * c[BRISTLE] / c[BRISTLE_DAMPING])
    factor = c[KINETIC] / _root(square)
    for i in range(3):
        pull = factor * T[i]
        new[i] = kept * new[i] + (1.0 - kept) * pull / c[BRISTLE]
        T[i] = -force * (pull + c[VISCOUS] * V[i])
    return False


@_law
def _lugre(V, n, force, c, T, new):
    """Friction by ż = V - σ0 |V| z/g(|V|); whether the bristles are far from sliding."""
    stiffness, h = c[BRISTLE], c[STEP]
    length, slipped = c[KINETIC] / stiffness, _carry(V, n, c, new)
    share = length / slipped if slipped.real > 2.0 * length else 0.5 + (slipped - slipped)
    _weigh(V, share, new)
    square = new[3] ** 2 + new[4] ** 2 + new[5] ** 2
    decay = stiffness * h * _root(square) / (_stribeck(square, c) + LEAST)
    kept = _exponential(-decay)
    grown = h * (1.0 - kept) / decay if decay.real > 1e-6 else h * (1.0 - 0.5 * decay)
    for i in range(3):
        new[i] = kept * new[i] + grown * new[3 + i]
    square = _dot(V, V)
    speed, g = _root(square), _stribeck(square, c) + LEAST
    pull = stiffness * _dot(new, V)
    for i in range(3):
        rate = V[i] - stiffness * speed / g * new[i]
        T[i] = -force * (stiffness * new[i] + c[BRISTLE_DAMPING] * rate + c[VISCOUS] * V[i])
    return not pull.real > SLIDING * (g * speed).real
