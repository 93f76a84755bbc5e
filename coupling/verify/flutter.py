"""Thermal flutter of a slender boom in oblique sunlight.

Yu 1969; Graham 1970; Thornton & Kim 1993.

The wall of a thin tube takes up sunlight by cos(phi) around it, conducts and radiates, so that the
first harmonic of its temperature, and with it the curvature kappa by which the tube bends away from
the sun, follow the angle psi between the sun and the normal of the boom with a time constant,

    tau kappa' + kappa = -K cos(psi + w'),   tau = rho c t/D,
    K = alpha absorptivity S Ro/(2 R^2 D),
    D = k t/R^2 + 4 emissivity sigma T^3 Ro/R.

With w = phi(x) q(t) of the first mode, small about the bent boom of slope w0',

    q'' + 2 zeta omega q' + omega^2 q = omega^2 L z,   tau z' + z = q,
    L = int K sin(psi + w0') phi' phi'' dx / int phi''^2 dx.

Routh and Hurwitz: stable if L < 1 and

    L > -2 zeta (1 + 2 zeta omega tau + omega^2 tau^2)/(omega tau).

Where the sun stands behind the clamp, L < 0: bending away from it takes light away, later.
"""

from cmath import exp
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, cosh, degrees, pi, sin, sinh, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from coupling.casefile import from_text
from coupling.model import Model, build
from coupling.simulation import Stopped, windows
from coupling.verify.registry import Check, problem

Array = NDArray[np.float64]

SIGMA, SOLAR, SPACE = 5.670374419e-8, 1361.0, 2.725
FIRST = 1.8751040687119611
"""First root of cos x cosh x = -1."""


@dataclass(frozen=True)
class Boom:
    """Sizes in SI units.

    sun : float [rad]  from the normal of the boom towards its tip
    damping : float [s]  Kelvin-Voigt time
    """

    length: float = 25.0
    radius: float = 6e-3
    thickness: float = 2e-4
    density: float = 8000.0
    youngs_modulus: float = 193e9
    expansion: float = 17.2e-6
    conductivity: float = 16.2
    heat_capacity: float = 500.0
    absorptivity: float = 0.3
    emissivity: float = 0.1
    sun: float = -pi / 4.0
    damping: float = 0.087

    @property
    def outer(self) -> float:
        """[m]"""
        return self.radius + 0.5 * self.thickness

    @property
    def loss(self) -> float:
        """D [W/m^2/K]"""
        absorbed = self.absorptivity * SOLAR * cos(self.sun) / (pi * self.emissivity * SIGMA)
        mean = (absorbed + SPACE**4) ** 0.25
        radiated = 4.0 * self.emissivity * SIGMA * mean**3 * self.outer / self.radius
        return self.conductivity * self.thickness / self.radius**2 + radiated

    @property
    def lag(self) -> float:
        """tau [s]"""
        return self.density * self.heat_capacity * self.thickness / self.loss

    @property
    def curvature(self) -> float:
        """K [1/m], of full sunlight from the side, at last."""
        light = 0.5 * self.absorptivity * SOLAR * self.outer / self.radius
        return self.expansion * light / (self.loss * self.radius)

    @property
    def frequency(self) -> float:
        """omega [rad/s] of a cantilever."""
        inner = self.radius - 0.5 * self.thickness
        inertia = 0.25 * (self.outer**2 + inner**2)  # second moment over area
        return (FIRST / self.length) ** 2 * sqrt(self.youngs_modulus * inertia / self.density)

    @property
    def ratio(self) -> float:
        """zeta of the first mode [-]."""
        return 0.5 * self.frequency * self.damping

    @cached_property
    def feedback(self) -> float:
        """L [-]"""
        x = np.linspace(0.0, self.length, 801)
        slope, bend = _mode(x / self.length)
        gain = self.curvature * np.sin(self.sun + self._bent(x))
        whole = np.trapezoid(bend**2, x) / self.length
        return float(np.trapezoid(gain * slope * bend, x) / whole)

    def _bent(self, x: Array) -> Array:
        """Slope w0' of the boom at rest."""

        def rate(_: float, slope: Array) -> Array:
            return -self.curvature * np.cos(self.sun + slope)

        return solve_ivp(rate, (0.0, self.length), [0.0], t_eval=x, rtol=1e-9, atol=1e-12).y[0]

    @property
    def critical_ratio(self) -> float:
        """zeta below which it flutters, by Routh and Hurwitz [-]."""
        u, most = self.frequency * self.lag, -self.feedback
        whole = 1.0 + u * u
        return (sqrt(whole * whole + 4.0 * u * u * most) - whole) / (4.0 * u)

    def delayed_ratio(self, delay: float) -> float:
        """The same when light follows the pose only after ``delay`` [s]."""
        w, omega = self.frequency, self.frequency
        for _ in range(50):
            answer = self.feedback * exp(-1j * omega * delay) / (1.0 + 1j * omega * self.lag)
            omega = w * sqrt(1.0 - answer.real)
        return 0.5 * w / omega * answer.imag

    @property
    def growth(self) -> complex:
        """Rate of the vibration [1/s], and its frequency [rad/s] as imaginary part."""
        w, z, lag = self.frequency, self.ratio, self.lag
        cubic = [lag, 1.0 + 2.0 * z * w * lag, 2.0 * z * w + w * w * lag, w * w]
        cubic[3] *= 1.0 - self.feedback
        found = np.roots(cubic)
        return complex(found[np.argmax(found.imag)])

    def model(self, scheme: str = "corrected", window: float = 1.0, end: float = 600.0) -> Model:
        """The model of a run."""
        return build(from_text(self._text(scheme, window, end), Path()))

    def _text(self, scheme: str, window: float, end: float) -> str:
        return f"""
[time]
end = {end!r}
window = {window!r}
[coupling]
scheme = "{scheme}"
[analysis]
start = "equilibrium"
[integrator]
tolerance = 1e-5
largest_step = 0.5
[material.steel]
density = {self.density!r}
youngs_modulus = {self.youngs_modulus!r}
poissons_ratio = 0.29
expansion = {self.expansion!r}
conductivity = {self.conductivity!r}
heat_capacity = {self.heat_capacity!r}
[section.tube]
kind = "tube"
mean_radius = {self.radius!r}
thickness = {self.thickness!r}
[body.boom]
kind = "beam"
start = [0, 0, 0]
end = [{self.length!r}, 0, 0]
elements = 8
normal = [0, 1, 0]
section = "tube"
material = "steel"
damping = {self.damping!r}
[joint.root]
kind = "clamp"
a = {{ body = "boom", at = "start" }}
[thermal]
solver = "line"
initial = 350.0
start = "steady"
wall_points = 8
[thermal.environment]
sun = {{ direction = [{sin(self.sun)!r}, {cos(self.sun)!r}, 0] }}
[thermal.surface.skin]
body = "boom"
absorptivity = {self.absorptivity!r}
emissivity = {self.emissivity!r}
[probe.tip]
body = "boom"
at = "end"
"""


def _mode(x: Array) -> tuple[Array, Array]:
    """First mode of a cantilever at x/length: phi' length and phi'' length^2, up to a factor."""
    ratio = (cosh(FIRST) + cos(FIRST)) / (sinh(FIRST) + sin(FIRST))
    z = FIRST * x
    slope = np.sinh(z) + np.sin(z) - ratio * (np.cosh(z) - np.cos(z))
    bend = np.cosh(z) + np.cos(z) - ratio * (np.sinh(z) + np.sin(z))
    return FIRST * slope, FIRST**2 * bend


def swing(model: Model) -> tuple[Array, Array]:
    """Times (k,) [s] of the ends of windows, and deflections (k,) [m] of the tip."""
    rows = []
    for window in windows(model, model.initial()):
        if isinstance(window, Stopped):
            raise RuntimeError(window.why)
        rows.append((window.t, model.probes(window.state)["tip"]["position"][1]))
    t, y = np.array(rows).T
    return t, y


def measured(t: Array, y: Array, near: complex, settled: float = 60.0) -> complex:
    """Rate of growth [1/s] and frequency [rad/s] of an oscillation about a straight line.

    near : a guess;  settled : time [s] that is left out, in which the start fades
    """
    t, y = t[t >= settled] - settled, y[t >= settled]

    def off(p: Array) -> Array:
        wave = np.exp((p[0] + 1j * p[1]) * t)
        parts = np.stack([wave.real, wave.imag, np.ones_like(t), t], axis=1)
        return parts @ np.linalg.lstsq(parts, y, rcond=None)[0] - y

    scales = [1e-3 * near.imag, near.imag]
    found = least_squares(off, [near.real, near.imag], x_scale=scales, xtol=1e-14, ftol=1e-14)
    return complex(*found.x)


def found_ratio(boom: Boom, scheme: str, window: float, end: float = 600.0) -> float:
    """zeta at which the vibration neither grows nor fades, by runs on both sides [-].

    The rate falls linearly with damping, so that two runs enclose and interpolate.
    """
    ratios = np.array([0.6, 2.2]) * boom.critical_ratio
    rates = []
    for ratio in ratios:
        one = replace(boom, damping=2.0 * float(ratio) / boom.frequency)
        t, y = swing(one.model(scheme, window, end))
        rates.append(measured(t, y, one.growth).real)
    if not rates[0] > 0.0 > rates[1]:
        raise RuntimeError(f"rates {rates[0]:.3g} and {rates[1]:.3g} 1/s do not enclose zero")
    return float(ratios[0] + (ratios[1] - ratios[0]) * rates[0] / (rates[0] - rates[1]))


BOOM = Boom()


@problem("coupling", "thermal flutter: rate of growth", "Routh & Hurwitz; Thornton & Kim 1993")
def growing() -> list[Check]:
    """Sun behind the clamp and ahead of it."""
    checks = []
    for angle in (-pi / 4.0, pi / 4.0):
        boom = replace(BOOM, sun=angle)
        found = measured(*swing(boom.model()), boom.growth)
        where = f"sun at {degrees(angle):g} deg"
        part = abs(boom.growth.real + boom.ratio * boom.frequency)  # that of the light
        checks.append(Check(f"rate of growth, {where}", found.real, boom.growth.real,
                            0.05 * part, "1/s", True))  # fmt: skip
        checks.append(Check(f"frequency, {where}", found.imag, boom.growth.imag, 2e-3, "rad/s"))
    return checks


@problem("coupling", "thermal flutter: critical damping", "Routh & Hurwitz; light late by h/2")
def threshold() -> list[Check]:
    """Schemes that hand the light over late move the threshold; corrected and iterated do not."""
    theory = BOOM.critical_ratio
    checks = [
        Check(f"{scheme}, windows of 1 s", found_ratio(BOOM, scheme, 1.0), theory, 0.02)
        for scheme in ("corrected", "iterated")
    ]
    for window in (1.0, 4.0):
        late = BOOM.delayed_ratio(0.5 * window)
        found = found_ratio(BOOM, "serial", window)
        checks.append(Check(f"serial, windows of {window:g} s", found, late, 0.02))
    return checks
