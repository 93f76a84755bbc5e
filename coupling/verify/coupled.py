"""Schemes of the exchange against heat and motion solved together: orders, rates, balance."""

from collections.abc import Callable, Mapping, Sequence
from math import cos, inf, log, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from coupling.acceleration import KINDS
from coupling.casefile import from_text
from coupling.iteration import Iterated
from coupling.manager import SCHEMES, Coupled, Pair, Result, initial
from coupling.model import build
from coupling.monolithic import Monolithic, Together
from coupling.transfer import Transfer
from coupling.verify.registry import Check, Convergence, problem
from coupling.verify.sliding import ALUMINIUM, STEEL, Sliding

Array = NDArray[np.float64]
Advance = Callable[..., Result]

ORDERS: dict[str, tuple[Advance, float]] = {
    "serial": (SCHEMES["serial"], 1.0),
    "parallel": (SCHEMES["parallel"], 1.0),
    "corrected": (SCHEMES["corrected"], 2.0),
    "iterated": (Iterated(1e-7, 1e-7), 2.0),
}
"""Schemes, and their orders in the window."""


def windows(pair: Pair, scheme: Advance, end: float, count: int) -> Coupled:
    """State after ``count`` windows up to ``end`` [s]."""
    state, h = initial(pair), end / count
    for k in range(count):
        new, why = scheme(pair, state, k * h, h, None)
        if new is None:
            raise RuntimeError(why)
        state = new
    return state


def together(pair: Pair, end: float, count: int) -> Together:
    """State at ``end`` [s] by ``count`` monolithic steps and half as many, extrapolated."""
    solver = Monolithic(pair)
    start = solver.begin(initial(pair))
    fine = solver.run(start, end / count, count)
    rough = solver.run(start, 2.0 * end / count, count // 2)
    return fine._replace(T=fine.T + (fine.T - rough.T) / 3.0, q=fine.q + (fine.q - rough.q) / 3.0)


def _orders(pair: Pair, end: float, counts: Sequence[int], exact: Array) -> list[Convergence]:
    """Errors of the temperatures at the end, scheme by scheme."""
    found = []
    for name, (scheme, theory) in ORDERS.items():
        errors = [float(np.abs(windows(pair, scheme, end, k).T - exact).max()) for k in counts]
        sizes = [end / k for k in counts]
        found.append(Convergence(name, sizes, errors, theory, 0.2, "s"))
    return found


# -- friction ----------------------------------------------------------------------------------

RUBBING = Sliding((STEEL, ALUMINIUM), (0.02, 0.05), 0.3, 2e3, -8e-3, film=0.5, outwards=1.0)
"""A loose journal whose friction falls by 8/1000 of it with every kelvin."""
RUBBED = 40.0  # [s]


@problem("coupling", "order in the window, contact and friction", "monolithic Newton; DOP853")
def rubbing() -> list[Check | Convergence]:
    """Frictional heat of a clearance joint lowers its friction."""
    pair, exact = RUBBING.build(), RUBBING.exact(RUBBED)
    end = together(pair, RUBBED, 160)
    off = float(np.abs(end.T - exact).max())
    checks: list[Check | Convergence] = [Check("monolithic", off, 0.0, 1e-4, "K", True)]
    return checks + _orders(pair, RUBBED, (10, 20, 40), end.T)


# -- heat of deformation -----------------------------------------------------------------------

EXPANSION = 2e-4  # [1/K]
STRENGTH = 69e9 * EXPANSION**2 * 300.0 / (2700.0 * 896.0)
"""E alpha^2 T/(rho c), by which a bar that cannot expand warms more than its heat would make it."""
HELD = f"""
[time]
end = "10 s"
window = "1 s"
[integrator]
tolerance = 1e-8
newton_tolerance = 1e-13
largest_step = "50 ms"
[material.soft]
density = 2700
youngs_modulus = "69 GPa"
poissons_ratio = 0.0
expansion = "{EXPANSION} 1/K"
conductivity = 167
heat_capacity = 896
[section.s]
kind = "rectangle"
height = "10 mm"
width = "10 mm"
[body.bar]
kind = "beam"
start = [0, 0, 0]
end = [0.2, 0, 0]
elements = 2
section = "s"
material = "soft"
reference_temperature = "300 K"
damping = "2 ms"
[joint.left]
kind = "clamp"
a = {{ body = "bar", at = "start" }}
[joint.right]
kind = "clamp"
a = {{ body = "bar", at = "end" }}
[thermal]
solver = "lumped"
initial = "300 K"
tolerance = 1e-9
[thermal.elastic]
bodies = ["bar"]
[thermal.source.heater]
at = {{ body = "bar" }}
power = {{ sine = {{ amplitude = "60 W", period = "20 s", offset = 0 }} }}
"""
HEATED = 4.0  # [s]


def held() -> Pair:
    """A bar between two walls that is heated."""
    return build(from_text(HELD, Path())).pair


@problem(
    "coupling", "order in the window, heat of deformation", "monolithic; Boley & Weiner 1960, 1.12"
)
def squeezed() -> list[Check | Convergence]:
    """A bar that cannot expand; a third of the heat that warms it comes from its own stress.

    That heat follows the temperature at once. One correction of it leaves an error of first order;
    iteration ends it.
    """
    pair = held()
    end = together(pair, HEATED, 16)
    heat = 60.0 * 20.0 / (2.0 * pi) * (1.0 - cos(2.0 * pi * HEATED / 20.0))
    rise = heat / (2700.0 * 896.0 * 0.2 * 1e-4)  # of a bar that expands freely
    # T - T0 - strength (T^2 - T0^2)/(2 T0) = rise, but for the 1 % by which its section grows
    square = STRENGTH / (2.0 * 300.0)
    exact = (1.0 - sqrt(1.0 - 4.0 * square * (300.0 + rise - square * 300.0**2))) / (2.0 * square)
    T = float(end.T.mean())
    checks: list[Check | Convergence] = [
        Check("rise, monolithic", T - 300.0, exact - 300.0, 1e-2, "K"),
    ]
    off = float(np.abs(windows(pair, ORDERS["iterated"][0], HEATED, 4).T - end.T).max())
    checks.append(Check("iterated, windows of 1 s", off, 0.0, 1e-4, "K", True))
    counts = (16, 32, 64)
    for name in ("serial", "parallel", "corrected"):
        scheme = SCHEMES[name]
        errors = [float(np.abs(windows(pair, scheme, HEATED, k).T - end.T).max()) for k in counts]
        sizes = [HEATED / k for k in counts]
        checks.append(Convergence(name, sizes, errors, 1.0, 0.2, "s"))
    return checks


# -- rates of iterations -----------------------------------------------------------------------


REGIONS: Mapping[str, NDArray[np.intp]] = {"wells": np.arange(2)}


class _Wells:
    """Temperatures of 1 J/K that only receive heat."""

    x, regions = np.zeros((2, 3)), REGIONS

    def initial(self) -> Array:
        return np.full(2, 300.0)

    def energy(self, T: Array) -> float:
        return float(T.sum())

    def steady(self, T: Array, t: float, outside: Any = None) -> tuple[Array, dict, str]:
        return T, {}, "nothing holds a temperature"

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Any = None
    ) -> tuple[Array, dict, str]:
        return T + heat, {}, ""


class _Answers:
    """Motion that answers a rise of temperature with heat; it is all its state."""

    x, axes = np.zeros((2, 3)), np.zeros((2, 3, 3))
    regions = REGIONS

    def __init__(self, gains: Array) -> None:
        self.gains = gains

    def initial(self, T: Array, rest: Array | None = None) -> float:
        return 0.0

    def advance(
        self, state: float, h: float, T0: Array, T1: Array, observe: Any = None
    ) -> tuple[float, Array, str]:
        return state + h, np.array([1.0, 2.0]) + self.gains @ (T1[:, 0] - T0[:, 0]), ""


def answering(radius: float) -> Pair:
    """A pair whose exchange has the eigenvalues -radius and 0.3 radius."""
    basis = np.array([[1.0, 0.4], [-0.3, 1.0]])
    gains = basis @ np.diag([-radius, 0.3 * radius]) @ np.linalg.inv(basis)
    read = np.zeros((6, 2))
    read[0, 0] = read[3, 1] = 1.0
    return Pair(_Wells(), _Answers(gains), Transfer(csr_array(read), np.zeros((2, 3))))


@problem("coupling", "iterations of a linear exchange", "log(1e-4)/log(spectral radius)")
def rates() -> list[Check]:
    """Plain iteration needs what its radius says, and diverges beyond 1; the others hold."""
    checks = []
    for radius in (0.25, 0.5, 0.9):
        more = _taken("none", radius, 1e-10) - _taken("none", radius, 1e-6)
        theory = log(1e-4) / log(radius)
        checks.append(Check(f"from 1e-6 to 1e-10, radius {radius:g}", more, theory, 1.0, "", True))
    checks.append(Check("plain, radius 1.5: refused", _taken("none", 1.5), 0.0, 0.0, "", True))
    for kind in ("aitken", "quasi-newton"):
        for radius in (0.9, 3.0):
            most = {"aitken": 40.0, "quasi-newton": 5.0}[kind]
            needed = _taken(kind, radius)
            over = max(0.0, needed - most) if needed else inf
            checks.append(Check(f"{kind}, radius {radius:g}, above {most:g}", over, 0.0, 0.0,
                                "", True))  # fmt: skip
    return checks


def _taken(acceleration: str, radius: float, tolerance: float = 1e-8) -> float:
    """Iterations of the first window; 0 if there is no end."""
    assert acceleration in KINDS
    pair = answering(radius)
    scheme = Iterated(tolerance, tolerance, most=400, acceleration=acceleration)
    new, why = scheme(pair, initial(pair), 0.0, 0.1, None)
    return 0.0 if new is None or why else float(new.exchange.iterations)


# -- balance -----------------------------------------------------------------------------------


@problem("coupling", "balance of heat, scheme by scheme", "stored = deposited + through boundaries")
def balances() -> list[Check]:
    """Defect over the heat exchanged; what motion released and heat has not yet received."""
    pair, checks = RUBBING.build(), []
    solver: Any = pair.heat_solver
    for name, (scheme, _) in ORDERS.items():
        state = windows(pair, scheme, RUBBED, 12)
        stored = solver.energy(state.T) - solver.energy(solver.initial())
        whole = state.deposited + sum(abs(q) for q in state.flows.values())
        defect = stored - state.deposited - sum(state.flows.values())
        checks.append(Check(f"{name}: stored", defect / whole, 0.0, 1e-12, "", True))
        lost = state.released - state.deposited - float(state.pending.sum())
        checks.append(Check(f"{name}: released", lost / whole, 0.0, 1e-12, "", True))
    return checks
