"""Frictional thermoelastic instability: a shaft that rubs, warms, grows and presses the harder.

A shaft turns in the bush of a block that a spring presses against it. Friction P divides between
both; each is a lump that is cooled by a conductance G. With the temperatures above the ambient
theta_i = s_i P/G_i of an equilibrium, the heat feeds itself twice,

    P = mu N v,   mu = mu0 (1 + a P),   N = N0 (1 + b P),
    a = slope (s_1/G_1 + s_2/G_2)/2,   b = k (R alpha_1 s_1/G_1 - (R + c) alpha_2 s_2/G_2)/N0,

k being the stiffness of spring and contact in series. There are equilibria up to the speed at which
both roots P meet, where the loop has the gain 1 (Burton, Nerlikar & Kilaparti 1973; Dow & Stockwell
1977; Barber 1969 for the same of a surface):

    mu0 N0 v = 1/(sqrt(a) + sqrt(b))^2,   P = 1/sqrt(a b).
"""

from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from coupling.casefile import from_text
from coupling.iteration import Iterated
from coupling.manager import SCHEMES, Pair, initial
from coupling.model import build
from coupling.verify.registry import Check, Convergence, problem

Array = NDArray[np.float64]

AMBIENT = 293.15  # [K]


@dataclass(frozen=True)
class Seizure:
    """Sizes in SI units; pairs are of shaft and bush.

    preload : float [N]  of the spring while shaft and bush touch without force
    masses : [kg];  conductances : [W/K];  rate : [rad/s]
    """

    radius: float = 0.05
    clearance: float = 1e-4
    spring: float = 1e9
    contact: float = 1e9
    preload: float = 2e3
    friction: float = 0.2
    slope: float = 1e-3
    density: tuple[float, float] = (2700.0, 8800.0)
    expansion: tuple[float, float] = (23.1e-6, 18e-6)
    conductivity: tuple[float, float] = (167.0, 60.0)
    heat_capacity: tuple[float, float] = (896.0, 380.0)
    masses: tuple[float, float] = (0.15, 0.01)
    conductances: tuple[float, float] = (0.8, 0.52)
    rate: float = 1.0

    @property
    def shares(self) -> Array:
        """(2,) of the heat, by effusivity."""
        rows = np.array([self.conductivity, self.density, self.heat_capacity])
        effusivity = np.sqrt(rows.prod(axis=0))
        return effusivity / effusivity.sum()

    @property
    def stiffness(self) -> float:
        """[N/m] against growth."""
        return 1.0 / (1.0 / self.spring + 1.0 / self.contact)

    @property
    def press(self) -> float:
        """[N] between shaft and bush, cold."""
        return self.preload * self.stiffness / self.spring

    @property
    def feedback(self) -> tuple[float, float]:
        """[1/W] by which friction and force rise with their own heat."""
        warmth = self.shares / np.array(self.conductances)
        sizes = np.array([self.radius, -self.radius - self.clearance])
        growth = float((sizes * self.expansion * warmth).sum())
        return 0.5 * self.slope * float(warmth.sum()), self.stiffness * growth / self.press

    @property
    def critical_speed(self) -> float:
        """[m/s] above which there is no equilibrium."""
        a, b = self.feedback
        return 1.0 / ((sqrt(a) + sqrt(b)) ** 2 * self.friction * self.press)

    @property
    def critical_rise(self) -> Array:
        """(2,) [K] above the ambient at that speed."""
        a, b = self.feedback
        return self.shares / (np.array(self.conductances) * sqrt(a * b))

    def force(self, rise: Array) -> float:
        """[N] between shaft and bush at rises (2,) [K] of their temperatures."""
        bore = self.radius + self.clearance
        gap = bore * self.expansion[1] * rise[1] - self.radius * self.expansion[0] * rise[0]
        return max(0.0, (self.preload - self.spring * gap) / (1.0 + self.spring / self.contact))

    def heating(self, rise: Array) -> Array:
        """(2,) [K/s]"""
        speed = self.rate * self.radius * (1.0 + self.expansion[0] * rise[0])
        power = self.friction * (1.0 + self.slope * rise.mean()) * self.force(rise) * speed
        received = self.shares * power - np.array(self.conductances) * rise
        return received / (np.array(self.masses) * self.heat_capacity)

    def course(self, times: Array) -> Array:
        """(k, 2) [K] rises from the ambient on, by DOP853: the motion follows at once."""
        found = solve_ivp(
            lambda t, rise: self.heating(rise), (0.0, times[-1]), [0.0, 0.0], "DOP853", times,
            rtol=1e-11, atol=1e-9,
        )  # fmt: skip
        return found.y.T

    def pair(self) -> Pair:
        """The two solvers and what connects them."""
        return build(from_text(self.text(), Path())).pair

    def text(self) -> str:
        """The case; its bodies are rigid."""
        return f"""
[time]
end = 1.0
window = 1.0
[analysis]
start = "equilibrium"
[integrator]
tolerance = 1e-3
largest_step = 0.5
[body.turning]
kind = "rigid"
position = [0, 0, 0]
mass = 4.0
inertia = [0.02, 0.02, 0.005]
spin = [0, 0, {self.rate!r}]
[body.block]
kind = "rigid"
position = [{self.clearance!r}, 0, 0]
mass = 2.0
inertia = [0.01, 0.01, 0.01]
[joint.drive]
kind = "revolute"
a = {{ body = "turning" }}
axis = [0, 0, 1]
angle = {{ ramp = {{ end = 1e6, from = 0, to = {1e6 * self.rate!r} }} }}
[joint.guide]
kind = "prismatic"
a = {{ body = "block" }}
axis = [1, 0, 0]
[joint.press]
kind = "spring"
a = {{ body = "block" }}
b = {{ body = "ground", position = [{0.3 + self.clearance!r}, 0, 0] }}
stiffness = {self.spring!r}
damping = 1e4
preload = {self.preload!r}
[joint.bore]
kind = "clearance_revolute"
journal = {{ body = "turning" }}
bearing = {{ body = "block" }}
axis = [0, 0, 1]
radius = {self.radius!r}
clearance = {self.clearance!r}
length = 0.06
journal_material = "one"
bearing_material = "other"
[joint.bore.contact]
stiffness = "linear"
value = {self.contact!r}
[joint.bore.friction]
coefficient = {self.friction!r}
temperature_slope = {self.slope!r}
reference_temperature = {AMBIENT!r}
regularisation_speed = 1e-6
[thermal]
solver = "lumped"
initial = {AMBIENT!r}
{self._side(0, "one", "shaft", "bore.journal")}
{self._side(1, "other", "bush", "bore.bearing")}
"""

    def _side(self, i: int, material: str, part: str, side: str) -> str:
        return f"""
[material.{material}]
density = {self.density[i]!r}
youngs_modulus = 1e11
poissons_ratio = 0.3
expansion = {self.expansion[i]!r}
conductivity = {self.conductivity[i]!r}
heat_capacity = {self.heat_capacity[i]!r}
[thermal.part.{part}]
of = "{side}"
material = "{material}"
mass = {self.masses[i]!r}
[thermal.link.{part}]
a = {{ part = "{part}" }}
temperature = {AMBIENT!r}
conductance = {self.conductances[i]!r}
"""


SLOW = Seizure()
LIGHT = (1e-3, 1e-3 / 15.0)
"""[kg] both lumps: the same equilibria, reached 150 times as soon."""
SEIZED = 2.0
"""Rise of the shaft, over that at the critical speed, beyond which it never returns."""


def course(pair: Pair, scheme: str, end: float, count: int) -> Array:
    """(count, 2) [K] rises at the ends of windows."""
    advance = Iterated() if scheme == "iterated" else SCHEMES[scheme]
    state, h, rows = initial(pair, settle=True), end / count, []
    for k in range(count):
        new, why = advance(pair, state, k * h, h, None)
        if new is None:
            raise RuntimeError(why)
        state = new
        rows.append(state.T - AMBIENT)
    return np.array(rows)


def seizes(model: Seizure, window: float = 2.0, most: int = 400) -> bool:
    """Whether the shaft warms without end, from the ambient on.

    It does not where a window adds less than a ten-thousandth to its rise.
    """
    pair, advance = model.pair(), Iterated()
    state = initial(pair, settle=True)
    for k in range(most):
        new, why = advance(pair, state, k * window, window, None)
        if new is None:
            raise RuntimeError(why)
        change, rise = new.T[0] - state.T[0], new.T[0] - AMBIENT
        if rise > SEIZED * model.critical_rise[0]:
            return True
        if abs(change) < 1e-4 * rise:
            return False
        state = new
    raise RuntimeError(f"undecided after {most} windows of {window:g} s")


def critical_rate(model: Seizure, low: float, high: float, halvings: int) -> float:
    """[rad/s] above which a shaft seizes, by runs: the middle of what is left."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        if seizes(_turning(model, middle)):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def _turning(model: Seizure, rate: float) -> Seizure:
    return replace(model, rate=rate, masses=LIGHT)


@problem("coupling", "friction that feeds itself: speed of seizure", "1/(sqrt(a) + sqrt(b))^2")
def threshold() -> list[Check]:
    """By bisection of runs between 0.9 and 1.2 times the speed of the formula."""
    theory = SLOW.critical_speed
    rate = theory / SLOW.radius
    found = critical_rate(SLOW, 0.9 * rate, 1.2 * rate, 5)
    return [Check("critical speed", found * SLOW.radius, theory, 0.01, "m/s")]


@problem("coupling", "friction that feeds itself: course", "ODE by DOP853")
def courses() -> list[Check | Convergence]:
    """The bush answers within seconds, which windows of 20 s do not resolve."""
    checks: list[Check | Convergence] = []
    for scheme, order in (("serial", 1.0), ("corrected", 2.0), ("iterated", 2.0)):
        sizes, errors = [0.5, 0.25, 0.125], []
        for h in sizes:
            count = round(20.0 / h)
            exact = SLOW.course(np.linspace(0.0, 20.0, count + 1)[1:])
            errors.append(float(np.abs(course(SLOW.pair(), scheme, 20.0, count) - exact).max()))
        checks.append(Convergence(scheme, sizes, errors, order, 0.2, "s"))
    exact = SLOW.course(np.linspace(0.0, 600.0, 31)[1:])
    off = np.abs(course(SLOW.pair(), "iterated", 600.0, 30) - exact)[-1].max()
    checks.append(Check("iterated, 30 windows of 20 s", off, 0.0, 0.2, "K", True))
    return checks
