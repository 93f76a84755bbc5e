"""Heated beams at rest and in motion, frictional heat, and the coupling of heat and motion."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

from coupling.verify import small_arm
from coupling.verify.models import ROOM, Model, bent, clamp, elastic, model, sections, straight
from coupling.verify.motion import fixed, order, run
from coupling.verify.registry import Check, problem
from coupling.verify.sliding import ALUMINIUM, RADIUS, RATE, STEEL, Sliding
from mechanics.description import Guide, Joint, Revolute, Site
from mechanics.ledger import TERMS
from mechanics.modes import modes
from mechanics.system import Coefficients
from meshes.materials import Material, library_material
from meshes.sections import rectangle, tube

Array = NDArray[np.float64]
History = Callable[[float], float]

ZERO_CELSIUS = 273.15  # [K]
EXPANSION = 23.1e-6  # [1/K]
SLENDER = rectangle(0.01, 0.02)


def alloy() -> Material:
    """Aluminium with constant properties."""
    return elastic(69e9, 0.0, 2700.0, EXPANSION)


def heated(made: Model, mean: float, along_2: float = 0.0) -> Coefficients:
    """Coefficients at a uniform temperature [K] with a transverse gradient [K/m]."""
    return made.system.coefficients(sections(made.system, mean, along_2))


# -- statics -----------------------------------------------------------------------------------


@problem("thermoelastic", "free bow of the 65.5 m boom", "x = sin(κL)/κ, w = (1 − cos κL)/κ")
def free_bow() -> list[Check]:
    """4 elements; κ = α G with G = 50 K/m, hot on the side that the bow turns away from."""
    length, curvature = 65.5, EXPANSION * 50.0
    made = model(straight(length, 4, tube(0.27, 0.002), alloy()), [clamp()])
    x = made.position(bent(made, 5, heated(made, ROOM, 50.0)).q, "beam", 4)
    closed = (1.0 - np.cos(curvature * length)) / curvature
    return [
        Check("tip, along", x[0], np.sin(curvature * length) / curvature, 1e-8, "m"),
        Check("tip, across", -x[1], 2.4764, 2e-5, "m"),
        Check("tip, across, closed form", -x[1], closed, 1e-8, "m"),
    ]


@problem("thermoelastic", "free expansion at −200 °C", "∫ α(T) dT by quadrature")
def free_expansion() -> list[Check]:
    """Cantilever of the paper's alloy; its section breathes at the clamp."""
    metal, cold = library_material("al6061-paper"), ZERO_CELSIUS - 200.0
    made = model(straight(2.0, 4, SLENDER, metal), [clamp()])
    hot = heated(made, cold)
    found = bent(made, 2, hot)
    strain = quad(metal.expansion, ROOM, cold, epsabs=0.0, epsrel=1e-12)[0]
    r, _, r_y, _ = made.vectors(found.q, "beam", 4)
    held = metal.youngs_modulus(cold) * SLENDER.area * strain
    return [
        Check("axial strain", r[0] / 2.0 - 1.0, strain, 1e-9),
        Check("strain of the section", r_y[1] - 1.0, strain, 1e-9),
        Check("force / (EA strain)", _axial_force(made, found.q, hot) / held, 0.0, 1e-9, "", True),
    ]


def _axial_force(made: Model, q: Array, hot: Coefficients) -> float:
    """Of the first element [N]."""
    return float(made.system.elements[0].resultants(q, np.zeros_like(q), hot[0])[0, 0])


@problem("thermoelastic", "force between two clamps", "N = −E A α ΔT, ΔT = 5 K")
def clamped_force() -> list[Check]:
    made = model(straight(1.0, 8, SLENDER, alloy()), [clamp(), clamp(8)])
    hot = heated(made, ROOM + 5.0)
    found = bent(made, 2, hot)
    reference = -69e9 * SLENDER.area * EXPANSION * 5.0
    # the strains are Green's: N = -E A (α ΔT + (α ΔT)²/2)
    return [Check("N", _axial_force(made, found.q, hot), reference, 1e-4, "N")]


@problem("thermoelastic", "thermal buckling", "ΔT where the lowest frequency vanishes; h/L = 1/100")
def buckling() -> list[Check]:
    """Shear makes the critical temperature lower by up to 2 (1 + ν) α ΔT / k_s = 0.08 %."""
    n = 12
    pin, other = Revolute("pin", Site("beam"), Site(None), np.array([0, 0, 1.0])), Site("beam", n)
    across, all_ways = Guide("roll", other, np.eye(3)[:2]), Guide("other", other, np.eye(3))
    supports: dict[str, tuple[list[Joint], float]] = {
        "clamped": ([clamp(), clamp(n)], 14.241853),
        "pinned": ([pin, across], 3.560463),
        "clamped and pinned": ([clamp(), all_ways], 7.283812),
    }
    return [
        Check(name, _critical(joints, n, reference), reference, 1.5e-3, "K")
        for name, (joints, reference) in supports.items()
    ]


def _critical(joints: Sequence[Joint], elements: int, near: float) -> float:
    """Temperature rise [K] at which the lowest squared frequency vanishes."""
    made = model(straight(1.0, elements, SLENDER, alloy()), joints)

    def square(rise: float) -> float:
        hot = heated(made, ROOM + rise)
        found = bent(made, 1, hot)
        f = modes(made.system, found.q, found.lam, hot, 1).frequencies[0]
        return float(f * abs(f))

    return brentq(square, 0.8 * near, 1.2 * near, xtol=1e-6 * near)


@problem(
    "thermoelastic", "frequency against temperature", "√(E(T)/E(25 °C)); CalculiX 2.20, linear"
)
def frequency_of_tube() -> list[Check]:
    """Cantilever tube of the paper's alloy, with no thermal strain but in the last line.

    There the tube grows by ε in all directions, so that f² ~ EI/(m l³) gains a factor 1 + ε.
    """
    cold = _tube_frequency(25.0, 25.0)
    ratios = {-200.0: 1.00420, -100.0: 1.00545, 100.0: 0.99295, 200.0: 0.97900}
    checks = [Check("f1 at 25 °C", cold, 25.01, 1e-3, "Hz")]
    for T, ratio in ratios.items():
        checks.append(Check(f"f1 ratio at {T:g} °C", _tube_frequency(T, T) / cold, ratio, 2e-5))
    metal = library_material("al6061-paper")
    strain = metal.thermal_strain(200.0 + ZERO_CELSIUS, 25.0 + ZERO_CELSIUS)
    grown = _tube_frequency(200.0, 25.0) / cold
    return [*checks, Check("the same, expanded", grown, 0.97900 * np.sqrt(1.0 + strain), 2e-4)]


def _tube_frequency(celsius: float, reference: float) -> float:
    """First frequency [Hz] at a temperature, free of thermal strain at ``reference`` [°C]."""
    section, metal = tube(0.0125, 0.001, 0.33), library_material("al6061-paper")
    body = straight(1.0, 16, section, metal)
    made = model(replace(body, reference_temperature=reference + ZERO_CELSIUS), [clamp()])
    hot = heated(made, celsius + ZERO_CELSIUS)
    found = bent(made, 1, hot)
    return float(modes(made.system, found.q, found.lam, hot, 1).frequencies[0])


# -- thermally induced vibration ---------------------------------------------------------------


def _vibration(history: History, periods: float) -> tuple[Array, Array]:
    """First mode of a cantilever under a transverse gradient that follows ``history``.

    Undamped, 60 steps per period (α = 0); the temperature is linear within each step.

    Parameters
    ----------
    history : share of the final gradient at a time in units of 1/ω

    Returns
    -------
    t : (k,) float [-]  in units of 1/ω
    q : (k,) float [-]  relative to the static deflection under the final gradient
    """
    made = model(straight(1.0, 2, rectangle(0.01, 0.01), alloy()), [clamp()])
    q0, rest = made.system.layout.q0, np.zeros(made.system.m)
    found = modes(made.system, q0, rest, made.coef, 1)
    omega = 2.0 * np.pi * found.frequencies[0]
    measure = made.system.mass @ found.shapes[:, 0]
    static = measure @ (bent(made, 1, heated(made, ROOM, 10.0)).q - q0)
    steps, end = round(60 * periods), 2.0 * np.pi * periods / omega
    path = run(
        made, end, fixed(end / steps, 0.0, 1e-12), steps,
        lambda t: heated(made, ROOM, 10.0 * history(omega * t)),
    )  # fmt: skip
    return omega * path.t, (path.q - q0) @ measure / static


@problem("thermoelastic", "Boley's ratio", "1 + 1/√(1 + B²) for 1 − exp(−t/τ), B = ωτ")
def boley() -> list[Check]:
    """Observed for one period after 14 τ, when the exponential has died out."""
    checks = []
    for B in (0.5, 1.0, 2.0, 5.0):
        _, q = _vibration(_relaxing(B), 14.0 * B / (2.0 * np.pi) + 1.2)
        checks.append(Check(f"peak / static, B = {B:g}", q.max(), 1 + 1 / np.sqrt(1 + B * B), 2e-3))
    return checks


def _relaxing(tau: float) -> History:
    return lambda t: -np.expm1(-t / tau)


@problem("thermoelastic", "vibration left by a ramp", "|sin(ω t_r/2)/(ω t_r/2)|")
def ramp() -> list[Check]:
    checks = []
    for periods in (0.25, 0.5, 1.0, 1.5):
        phase = np.pi * periods
        t, q = _vibration(_rising(2.0 * phase), periods + 1.2)
        left = np.abs(q[t > 2.0 * phase] - 1.0).max()
        reference = abs(np.sin(phase) / phase)
        checks.append(Check(f"t_r = {periods:g} periods", left, reference, 3e-3, "", True))
    return checks


def _rising(duration: float) -> History:
    return lambda t: min(1.0, t / duration)


# -- coupling ----------------------------------------------------------------------------------


@problem("thermoelastic", "frictional heat of two slabs", "100 W for 10 s; partition by √(kρc)")
def friction_heat() -> list[Check]:
    """Two slabs of 10 mm on 1e-3 m² as lumps; then aluminium against steel, unconnected."""
    slab, speed = 2700.0 * 1e-5, RATE * RADIUS
    even = Sliding((ALUMINIUM, ALUMINIUM), (slab, slab), 0.25, 100.0 / (0.25 * speed))
    pair, state = even.run("corrected", 10.0, 4)
    uneven = replace(even, materials=(ALUMINIUM, STEEL))
    _, apart = uneven.run("corrected", 10.0, 4)
    gained = (apart.T - ROOM) * slab * np.array([896.0, 500.0])
    lost = state.motion.ledger[TERMS.index("friction")]
    assert pair.heat_solver is not None
    energy = pair.heat_solver.energy
    return [
        Check("mean rise", float(np.mean(state.T)) - ROOM, 20.667989, 1e-5, "K"),
        Check("frictional work", lost, 1000.0, 1e-5, "J"),
        Check("heat stored", energy(state.T) - energy(ROOM + 0.0 * state.T), lost, 1e-10, "J"),
        Check("share of the aluminium", gained[0] / gained.sum(), 0.714035, 1e-6),
    ]


@problem("thermoelastic", "order of the coupling in the window", "exact: two equations, DOP853")
def coupling_order() -> list[Check]:
    """A journal whose friction falls by 0.8 % per kelvin; error of its temperature after 64 s."""
    scene = Sliding((STEEL, ALUMINIUM), (0.2, 0.3), 0.3, 4e4, -8e-3, 1.5, 0.75)
    exact = scene.exact(64.0)[0]
    checks = []
    for scheme, expected, largest in (("serial", 1.0, 0.2), ("corrected", 2.0, 2e-4)):
        errors = np.abs([scene.run(scheme, 64.0, n)[1].T[0] - exact for n in (8, 16, 32)])
        checks.append(Check(f"order, {scheme}", order(errors), expected, 0.05, "", True))
        checks.append(Check(f"error, {scheme}, 2 s", errors[-1], 0.0, largest, "K", True))
    return checks


@problem("thermoelastic", "balances of a small arm, corrected", "stored = brought; DESIGN §3")
def corrected_balance() -> list[Check]:
    ran = small_arm.run("corrected")
    return [
        *_balances(ran),
        Check("released / deposited", ran.state.released, ran.state.deposited, 1e-14, "J"),
    ]


@problem("thermoelastic", "balances of a small arm, serial", "stored = brought; DESIGN §3")
def serial_balance() -> list[Check]:
    """The heat of the last window is released and not yet deposited."""
    ran = small_arm.run("serial")
    s = ran.state
    return [
        *_balances(ran),
        Check("released − pending", s.released - s.pending.sum(), s.deposited, 1e-12, "J"),
    ]


def _balances(ran: small_arm.Ran) -> list[Check]:
    row = ran.model.ledger(ran.state)
    heat = row["heat_defect"] / ran.exchanged
    energy = row["defect"] / max(abs(row[name]) for name in TERMS)
    numerical = row["numerical"] / row["work_drive"]
    return [
        Check("heat defect / heat exchanged", heat, 0.0, 1e-9, "", True),
        Check("energy defect / largest term", energy, 0.0, 1e-6, "", True),
        Check("frictional heat = work", ran.state.released, row["friction"], 1e-12, "J"),
        Check("numerical / work of drive", numerical, 0.0, 1e-4, "", True),
    ]
