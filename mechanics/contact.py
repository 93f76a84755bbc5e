"""Laws of contact with clearance, as plain functions of numbers or arrays.

Normal force F = F_e(δ) (1 + D δ̇/v), never attractive, with the approach speed v of the impact;
coefficients of friction; shares of the frictional heat; change of the clearance with temperature;
and what the compiled laws (``mechanics.contact_laws``) are told of a description.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import beta, lambertw

from mechanics import contact_laws as laws
from mechanics.description import Friction, NormalContact
from meshes.materials import Material

Array = NDArray[np.float64]
Value = float | Array  # functions work element by element

EXPONENT = {"hertz-external": 1.5, "hertz-internal": 1.5, "linear": 1.0}
"""Exponent p of the normal laws that are powers."""

STIFFNESS = dict.fromkeys(EXPONENT, laws.POWER) | {"cylinder": laws.CYLINDER}
"""Compiled normal law of each name."""

FRICTION = {
    "regularised": laws.REGULARISED,
    "stick": laws.STICK,
    "stribeck": laws.STRIBECK,
    "lugre": laws.LUGRE,
    "rising": laws.RISING,
}
"""Compiled friction law of each name."""

FREE_FLIGHT, IMPACT, SLIP, STICK = 0, 1, 2, 3
IMPACT_RATE = 0.1
"""An indentation speed above this part of the approach speed counts as impact [-]."""


def hertz_radius(name: str, journal_radius: Value, bearing_radius: Value) -> Value:
    """Effective radius [m] of two spheres; of one on a plane where the bearing radius is infinite.

    "hertz-external", R1 R2/(R1 + R2): side by side (Hua et al. 2026 use it for hinges);
    "hertz-internal", R1 R2/(R2 - R1): one inside the other (Johnson 1985, sec. 4.2, with one
    radius negative; Flores & Ambrosio 2004).
    """
    sign = {"hertz-external": 1.0, "hertz-internal": -1.0}[name]
    return journal_radius / (1.0 + sign * journal_radius / bearing_radius)


def hertz_stiffness(radius: Value, E1: Value, nu1: Value, E2: Value, nu2: Value) -> Value:
    """K = 4/3 sqrt(R) E* [N/m^1.5], 1/E* = (1 - nu1²)/E1 + (1 - nu2²)/E2.

    Johnson, Contact Mechanics (1985), eq. 4.23.
    """
    return 4.0 / 3.0 * np.sqrt(radius) * effective_modulus(E1, nu1, E2, nu2)


def effective_modulus(E1: Value, nu1: Value, E2: Value, nu2: Value) -> Value:
    """E* [N/m^2], 1/E* = (1 - nu1²)/E1 + (1 - nu2²)/E2."""
    return 1.0 / ((1.0 - nu1**2) / E1 + (1.0 - nu2**2) / E2)


def cylinder_indentation(force: Value, stiffness: Value, limit: Value) -> Value:
    """δ = F/K (ln(P/F) - 1) [m] of a cylinder in a bore, with K = π E* L and P = 4 π E* L ΔR.

    Johnson 1985, sec. 5.6, as Pereira, Ramalho & Ambrosio (2011, Nonlinear Dyn. 63, 681) write it
    for internal contact, ΔR > 0 being the clearance. Up to F = P/e², where δ = 4 ΔR/e² = 0.541 ΔR,
    the force rises with δ; beyond, the law has no meaning.
    """
    F = np.asarray(force, dtype=float)
    some = np.where(F > 0.0, F, limit)
    return np.where(F > 0.0, F / stiffness * (np.log(limit / some) - 1.0), 0.0)[()]


def cylinder_force(depth: Value, stiffness: Value, limit: Value) -> Value:
    """Inverse [N] of ``cylinder_indentation``, continued with its slope beyond RANGE P/e²."""
    last_force = laws.RANGE * np.exp(-2.0) * limit
    last = cylinder_indentation(last_force, stiffness, limit)
    inside = np.clip(depth, 0.0, last)
    part = np.where(inside > 0.0, inside, last) * stiffness / limit
    force = stiffness * inside / -lambertw(-np.e * part, -1).real
    return (force - np.maximum(depth - last, 0.0) * stiffness / np.log(laws.RANGE))[()]


def law_columns(
    contact: NormalContact,
    radius: float,
    clearance: float,
    length: float | None,
    share: Value,
    E1: Value,
    nu1: Value,
    E2: Value,
    nu2: Value,
) -> tuple[float, Value, Value]:
    """Columns LAW, K, P of ``mechanics.contact_laws`` for one point of contact.

    Parameters
    ----------
    radius : float [m]  of the journal
    clearance : float [m]  at the reference temperature: the radii behind the stiffness are those of
        the reference, so that it stays defined where the joint has seized; infinite for a plane
    length : float | None [m]  of the cylinder; a given value of its law is π E* L
    share : part of the load that the point carries, or of the length (array: of several points)
    E1, nu1, E2, nu2 : elastic constants [N/m^2], [-] of journal and bearing, float or (n,)
    """
    cylinder = contact.stiffness == "cylinder"
    K: Value
    if contact.value is not None:
        K = share * contact.value
    else:
        elastic = E1, nu1, E2, nu2
        K = share * _stiffness(contact.stiffness, radius, clearance, length, *elastic)
    P = 4.0 * K * clearance if cylinder else EXPONENT[contact.stiffness]
    return float(STIFFNESS[contact.stiffness]), K, P


def normal_columns(contact: NormalContact, *geometry: Any) -> tuple[Value, ...]:
    """Columns LAW to REFERENCE of ``mechanics.contact_laws``: ``law_columns``, factor, speed."""
    factor = DISSIPATION[contact.dissipation](contact.restitution)
    return (*law_columns(contact, *geometry), factor, contact.reference_speed or 0.0)


def refusal(contact: NormalContact, friction: Friction | None) -> str:
    """What is wrong with the laws of a joint, wherever it touches; "" if nothing."""
    if contact.stiffness not in STIFFNESS or contact.dissipation not in DISSIPATION:
        return f"unknown law {contact.stiffness}, {contact.dissipation}"
    if friction is not None and friction.law not in FRICTION:
        return f"unknown friction {friction.law!r}"
    if contact.stiffness == "linear" and contact.value is None:
        return "a linear contact needs its stiffness"
    return ""


def _stiffness(
    name: str,
    radius: float,
    clearance: float,
    length: float | None,
    *elastic: Value,
) -> Value:
    """K [N/m^1.5] of spheres, π E* L [N/m] of a cylinder."""
    if name == "linear":
        raise ValueError("a linear contact needs its stiffness")
    if name == "cylinder":
        if not length:
            raise ValueError("the law of the cylinder needs a length")
        return np.pi * length * effective_modulus(*elastic)
    if name == "hertz-internal" and clearance <= 0.0:
        raise ValueError("a sphere inside another one needs a clearance")
    return hertz_stiffness(hertz_radius(name, radius, radius + clearance), *elastic)


def normal_force(
    stiffness: Value,
    exponent: Value,
    penetration: Value,
    rate: Value,
    factor: Value,
    approach: Value,
) -> Value:
    """K δ^p (1 + D δ̇/v) [N]; zero when open or when it would pull; elastic where v <= 0."""
    elastic = stiffness * np.maximum(penetration, 0.0) ** exponent
    running = np.asarray(approach) > 0.0
    ratio = np.where(running, rate / np.where(running, approach, 1.0), 0.0)
    return np.maximum(elastic * (1.0 + factor * ratio), 0.0)


def exact_factor(restitution: Value) -> Value:
    """Factor D that delivers the restitution e exactly, for 0.01 <= e <= 1 and any exponent.

    The impact m δ̈ = -K δ^p (1 + D δ̇/v) from speed v to -e v integrates to
    D (1 + e) = ln((1 + D)/(1 - D e)) (Gonthier et al. 2004, who write d for D e; Zhang &
    Sharf 2009). D = 0 always solves it; the other root lies below 1/e and is bisected here in
    z = -ln(1 - D e), because 1 - D e is as small as exp(-1/e).
    """
    e = np.asarray(restitution, dtype=float)
    if np.any((e < 0.01) | (e > 1.0)):
        raise ValueError("the exact factor needs a restitution from 0.01 to 1")
    lower, upper = np.zeros_like(e), (1.0 + e) / e
    for _ in range(100):
        z = 0.5 * (lower + upper)
        above = _impact_balance(-np.expm1(-z) / e, z, e) > 0.0
        lower, upper = np.where(above, z, lower), np.where(above, upper, z)
    return np.where(e < 1.0, -np.expm1(-lower) / e, 0.0)[()]


@lru_cache(maxsize=1024)
def _known_factor(restitution: float) -> float:
    """``exact_factor`` of one number: every coupling window asks for it again."""
    return float(exact_factor(restitution))


def _impact_balance(D: Array, z: Array, e: Array) -> Array:
    """D (1 + e) - ln(1 + D) - z over D², with z = -ln(1 - D e); as a series where D is small."""
    powers = np.arange(2, 24)[(...,) + (None,) * np.ndim(D)]
    small = np.minimum(D, 0.1)
    series = (((-small) ** (powers - 2)) * (1.0 - (-e) ** powers) / powers).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        closed = (D * (1.0 + e) - np.log1p(D) - z) / D**2
    return np.where(D < 0.1, series, closed)


def delivered_restitution(factor: Value) -> Value:
    """Restitution e [-] that a factor D >= 0 delivers: the inverse of ``exact_factor``."""
    D = np.asarray(factor, dtype=float)
    lower, upper = np.zeros_like(D), 1.0 / np.maximum(D, 1.0)
    for _ in range(60):
        e = 0.5 * (lower + upper)
        with np.errstate(divide="ignore"):
            z = -np.log1p(-np.minimum(D * e, 1.0))
        too_low = np.where(D < 1e-8, True, _impact_balance(np.maximum(D, 1e-8), z, e) > 0.0)
        lower, upper = np.where(too_low, e, lower), np.where(too_low, upper, e)
    return (0.5 * (lower + upper))[()]


DISSIPATION: dict[str, Callable] = {
    "hua2026": lambda e: 1.5 * (1.0 - e**2) / e,
    "hunt-crossley": lambda e: 1.5 * (1.0 - e),
    "lankarani-nikravesh": lambda e: 0.75 * (1.0 - e**2),
    "gonthier": lambda e: (1.0 - e**2) / e,
    "flores": lambda e: 1.6 * (1.0 - e) / e,
    "hu-guo": lambda e: 1.5 * (1.0 - e) / e,
    "exact": lambda e: exact_factor(e) if np.ndim(e) else _known_factor(float(e)),
}
"""Factor D of restitution e: Hua et al. 2026; Hunt & Crossley 1975; Lankarani & Nikravesh 1990;
Gonthier et al. 2004; Flores et al. 2011; Hu & Guo 2015; and what delivers e exactly."""


class Impact(NamedTuple):
    """Largest penetration [m], largest force [N] and duration [s] of an impact."""

    penetration: Value
    force: Value
    duration: Value


def elastic_impact(mass: Value, stiffness: Value, speed: Value, exponent: Value = 1.5) -> Impact:
    """Impact of ``mass`` at ``speed`` on F = K δ^p without loss (Johnson 1985, sec. 11.4).

    m v²/2 = K δ^(p+1)/(p + 1); the duration is 2 δ/v times the integral of
    1/sqrt(1 - x^(p+1)) from 0 to 1: 2.94328 δ/v for Hertz, π sqrt(m/K) for a linear spring.
    """
    n = exponent + 1.0
    deepest = (n * mass * speed**2 / (2.0 * stiffness)) ** (1.0 / n)
    duration = 2.0 * deepest / speed * beta(1.0 / n, 0.5) / n
    return Impact(deepest, stiffness * deepest**exponent, duration)


class Rebound(NamedTuple):
    """Velocities [m/s] of two bodies after a central impact, and lost energy [J]."""

    first: Value
    second: Value
    loss: Value


def rigid_impact(m1: Value, m2: Value, v1: Value, v2: Value, restitution: Value) -> Rebound:
    """Central impact of rigid bodies, e (v1 - v2) = v2' - v1' (Hua et al. 2026)."""
    meeting = m1 * m2 / (m1 + m2)
    impulse = (1.0 + restitution) * meeting * (v1 - v2)
    loss = 0.5 * (1.0 - restitution**2) * meeting * (v1 - v2) ** 2
    return Rebound(v1 - impulse / m1, v2 + impulse / m2, loss)


def thermal_clearance(
    clearance: Value, journal_radius: Value, journal_strain: Value, bearing_strain: Value
) -> Value:
    """Radial clearance [m] after free thermal strains of journal and bearing; may be negative."""
    bearing_radius = journal_radius + clearance
    return clearance + bearing_radius * bearing_strain - journal_radius * journal_strain


def friction_coefficient(T: Value, coefficient: float, slope: float, reference: float) -> Value:
    """mu(T) = mu0 (1 + slope (T - reference)), not below zero (Hua et al. 2026)."""
    return np.maximum(coefficient * (1.0 + slope * (T - reference)), 0.0)


def rising_coefficient(
    time: Value, kinetic: float, static: float, rate: float, exponent: float
) -> Value:
    """mu_s - (mu_s - mu_k) exp(-rate τ^m) [-] after sticking for τ [s] (Hua et al. 2026)."""
    return static - (static - kinetic) * np.exp(-rate * np.asarray(time) ** exponent)


def friction_columns(friction: Friction | None, T: float) -> Array:
    """(10,) columns FRICTION..RISE_EXPONENT of ``mechanics.contact_laws`` at temperature T [K]."""
    if friction is None:
        return np.array([laws.NONE, *[0.0] * 9])
    static = friction.static_coefficient
    static = friction.coefficient if static is None else static
    factor = friction_factor(friction, T)
    return np.array([
        FRICTION[friction.law],
        factor * friction.coefficient,
        factor * static,
        friction.regularisation_speed,
        friction.stribeck_speed,
        friction.viscous,
        factor * static / friction.presliding,
        friction.bristle_damping,
        friction.rise_rate,
        friction.rise_exponent,
    ])  # fmt: skip


def friction_factor(friction: Friction, T: Value) -> Value:
    """Coefficients at T [K] over those at the reference temperature, by table or slope."""
    if friction.table is not None:
        return np.interp(T, *np.transpose(friction.table))
    return friction_coefficient(T, 1.0, friction.temperature_slope, friction.reference_temperature)


def friction_force(
    coefficient: Value, normal: Value, slip_speed: Value, regularisation_speed: Value
) -> Value:
    """-mu F v/(|v| + eps) [N] along the slip speed v (Hua et al. 2026)."""
    return -coefficient * normal * slip_speed / (np.abs(slip_speed) + regularisation_speed)


PARTITION: dict[str, Callable] = {
    "effusivity": lambda k, density, c: np.sqrt(k * density * c),
    "product": lambda k, density, c: k * density * c,
}
"""Weight of a body in the partition of frictional heat: equal temperatures of the two faces
(Carslaw & Jaeger 1959, sec. 2.15), and the product as Hua et al. 2026 print it."""


def heat_shares(
    friction: Friction | None, materials: Sequence[Material], temperatures: Sequence[float]
) -> Array:
    """(2,) [-]  shares of the frictional heat of two bodies at their temperatures [K]."""
    weight = PARTITION[friction.partition if friction else "effusivity"]
    each = zip(materials, temperatures, strict=True)
    weights = np.array([
        float(weight(m.conductivity(T), m.density, m.heat_capacity(T))) for m, T in each
    ])  # fmt: skip
    return weights / weights.sum()


def classify(
    penetration: Value,
    rate: Value,
    approach: Value,
    slip_speed: Value,
    regularisation_speed: Value,
    stuck: Value = 0.0,
    law: int = laws.REGULARISED,
) -> NDArray[np.int8]:
    """Regime of motion, int8: 0 free flight, 1 impact, 2 slip, 3 stick.

    Impact: in contact while |δ̇| exceeds ``IMPACT_RATE`` times the approach speed of the running
    impact. (At the turning point of an impact, for about 6 % of its duration, this is not so.)
    Stick: in contact, no impact, and ``stuck`` by friction ``law`` (column FRICTION of the compiled
    laws) with bristles; by one without, slower than the regularisation speed.
    """
    if law in (laws.STICK, laws.LUGRE, laws.RISING):
        holds = np.asarray(stuck) > 0.0
    else:
        holds = np.abs(slip_speed) < regularisation_speed
    violent = np.abs(rate) > IMPACT_RATE * np.maximum(approach, 0.0)
    impact = violent & (np.asarray(approach) > 0.0)
    regime = np.where(impact, IMPACT, np.where(holds, STICK, SLIP))
    return np.where(np.asarray(penetration) > 0.0, regime, FREE_FLIGHT).astype(np.int8)
