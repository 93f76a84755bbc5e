"""Answers to problems with clearance that share nothing with the solver.

Closed forms, and mechanisms with clearance as ordinary differential equations in the fewest
coordinates, by DOP853 from contact to contact: where a contact begins is located, and the speed at
which it does stays that of the impact. Normal force K δ^p (1 + D δ'/v), never attractive;
friction mu F v/(|v| + eps).

Motions with many impacts are sensitive. In the first turn of the slider-cranks here a small
relative change of the speed changes the times of impacts by at most 60 times as much: solutions can
be compared impact by impact; after more turns only what they do on average.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import asin, atan2, cos, hypot, log1p, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = NDArray[np.float64]

# ------------------------------------------------------------------------------ closed forms


def exact_factor(restitution: float) -> float:
    """Factor D that delivers a restitution 0.05 <= e <= 1: D (1 + e) = ln((1 + D)/(1 - D e))."""
    e = restitution
    if e == 1.0:
        return 0.0
    least = 0.5 * (1.0 - e)
    return brentq(
        lambda D: D * (1.0 + e) - log1p(D) + log1p(-D * e), least, (1.0 - 1e-12) / e, xtol=1e-15
    )


def lankarani_nikravesh(restitution: float) -> float:
    """Factor 3/4 (1 - e²) (Lankarani & Nikravesh 1990)."""
    return 0.75 * (1.0 - restitution**2)


def hertz_in_a_bore(journal_radius: float, clearance: float, E: float, nu: float) -> float:
    """K [N/m^1.5] of two spheres, one in the other, of one metal (Flores & Ambrosio 2004)."""
    radius = journal_radius * (journal_radius + clearance) / clearance
    return 4.0 / 3.0 * sqrt(radius) * E / (2.0 * (1.0 - nu**2))


def bounces(height: float, restitution: float, count: int, gravity: float = 9.81) -> Array:
    """(count,) [s]  when a ball dropped from rest hits a rigid floor."""
    fall = sqrt(2.0 * height / gravity)
    return fall * np.cumsum([1.0, *(2.0 * restitution ** np.arange(1, count))])


def bouncing_time(height: float, restitution: float, gravity: float = 9.81) -> float:
    """When it comes to rest after infinitely many bounces [s]."""
    return sqrt(2.0 * height / gravity) * (1.0 + restitution) / (1.0 - restitution)


def between_walls(gap: float, speed: float, restitution: float, count: int) -> Array:
    """(count,) [s]  when a point hits one of two rigid walls ``gap`` apart, having left the other.

    ``speed`` [m/s]  at the start; after n impacts speed e^n.
    """
    return gap / speed * np.cumsum(restitution ** -np.arange(count, dtype=float))


class Rebound(NamedTuple):
    """After an impact: velocity [m/s], spin [rad/s], normal and tangential impulse [N s]."""

    velocity: Array
    spin: Array
    normal: float
    tangential: Array
    slides: bool


def ball_on_wall(
    mass: float,
    radius: float,
    velocity: ArrayLike,
    spin: ArrayLike,
    normal: ArrayLike,
    restitution: float,
    friction: float,
    inertia: float | None = None,
) -> Rebound:
    """A rigid ball that turns hits a wall with Coulomb friction, both rigid.

    The point of contact moves in one direction only, as for every ball: it slides throughout, with
    tangential impulse mu times the normal one, where its speed is at least
    mu (1 + e)(1 + m R²/I) times that of approach (Stronge 2000, ch. 5; for these also Maw, Barber
    & Fawcett 1976, whatever the compliance); otherwise it comes to roll.

    normal : (3,)  unit, from the ball into the wall;  inertia : default 2/5 m R²
    """
    v, w, n = (np.asarray(a, dtype=float) for a in (velocity, spin, normal))
    inertia = 0.4 * mass * radius**2 if inertia is None else inertia
    arm = radius * n
    slip = v + np.cross(w, arm) - (v @ n) * n
    impulse = mass * (1.0 + restitution) * float(v @ n)
    to_stop = mass / (1.0 + mass * radius**2 / inertia) * float(np.linalg.norm(slip))
    slides = to_stop > friction * impulse
    size = friction * impulse if slides else to_stop
    tangential = -size * slip / np.linalg.norm(slip) if size > 0.0 else np.zeros(3)
    return Rebound(
        v + (tangential - impulse * n) / mass,
        w + np.cross(arm, tangential) / inertia,
        impulse, tangential, slides,
    )  # fmt: skip


class Tilted(NamedTuple):
    """Of a pin: forces of the bore on it [N] and its displacement [m] at both ends; angle [rad]."""

    forces: Array
    displacement: Array
    angle: float


def tilted_pin(
    load: float,
    arm: float,
    length: float,
    clearance: float,
    stiffness: float | None = None,
    exponent: float = 1.5,
) -> Tilted:
    """A rigid pin in a bore, pressed across its axis by a load ``arm`` off the middle.

    The first end is the one on the side of the load. Beyond it, arm > length/2, the pin leans on
    opposite edges, at the angle 2 c/L where nothing yields; nearer, it lies on both ends.

    stiffness : K of each end, F = K δ^exponent; None: rigid
    """
    forces = -load * np.array([0.5 + arm / length, 0.5 - arm / length])
    depth = np.zeros(2) if stiffness is None else (np.abs(forces) / stiffness) ** (1.0 / exponent)
    displacement = -np.sign(forces) * (clearance + depth)
    return Tilted(forces, displacement, atan2(displacement[0] - displacement[1], length))


# ------------------------------------------------------------------- motion with contacts


class Law(NamedTuple):
    """Of a contact: K [N/m^p], p, D, friction coefficient, its speed of regularisation [m/s]."""

    stiffness: float
    exponent: float = 1.5
    factor: float = 0.0
    friction: float = 0.0
    slow: float = 1e-3

    def normal(self, depth: float, rate: float, approach: float) -> tuple[float, float]:
        """Elastic force, and force in all [N]; none where there is no approach speed."""
        if approach <= 0.0 or depth <= 0.0:
            return 0.0, 0.0
        elastic = self.stiffness * depth**self.exponent
        return elastic, max(0.0, elastic * (1.0 + self.factor * rate / approach))

    def tangential(self, force: float, slip: float) -> float:
        """Friction [N] along the direction in which ``slip`` is counted."""
        return -self.friction * force * slip / (abs(slip) + self.slow)

    def stored(self, depth: Array) -> Array:
        """Elastic energy [J]."""
        n = self.exponent + 1.0
        return self.stiffness * np.maximum(depth, 0.0) ** n / n


class Impact(NamedTuple):
    """Time [s], which contact, approach speed [m/s]."""

    t: float
    contact: int
    speed: float


class Path(NamedTuple):
    """t (k,), y (n, k), approach speeds (k, P) with 0 in flight, and the impacts."""

    t: Array
    y: Array
    approach: Array
    impacts: list[Impact]


Gaps = Callable[[float, Array], tuple[Sequence[float], Sequence[float]]]
Rate = Callable[[float, Array, Array], Sequence[float]]

GRAZING = 1e-9
"""Least approach speed [m/s]."""


def march(
    rate: Rate, gaps: Gaps, start: ArrayLike, times: Array, largest: float, rtol: float = 1e-11
) -> Path:
    """Integrate y' = rate(t, y, approach) from contact to contact.

    Parameters
    ----------
    gaps : depths (P,) [m] and their rates of the contacts, all open at times[0]
    times : (k,) [s]  where the solution is wanted
    largest : longest step [s]; contacts that begin and end within one are overlooked
    """
    y, t, end = np.asarray(start, dtype=float), float(times[0]), float(times[-1])
    approach = np.zeros(len(gaps(t, y)[0]))
    columns, speeds, impacts = [y[:, None]], [approach[None]], []
    while t < end:
        found = solve_ivp(
            lambda t, y, now=approach: rate(t, y, now), (t, end), y, "DOP853", dense_output=True,
            rtol=rtol, atol=1e-14, max_step=largest, events=_events(gaps, approach),
        )  # fmt: skip
        wanted = times[(times > t) & (times <= found.t[-1])]
        if len(wanted):
            columns.append(found.sol(wanted))
            speeds.append(np.tile(approach, (len(wanted), 1)))
        t, y = float(found.t[-1]), found.y[:, -1]
        approach, begun = _switched(gaps, t, y, approach, found.t_events)
        impacts += begun
    return Path(times, np.concatenate(columns, axis=1), np.concatenate(speeds), impacts)


def _switched(
    gaps: Gaps, t: float, y: Array, approach: Array, located: Sequence[Array]
) -> tuple[Array, list[Impact]]:
    """Approach speeds after an event, and the impacts that begin with it.

    Others may have passed zero within round-off of the one that was located.
    """
    new, begun = approach.copy(), []
    for i, (depth, rate) in enumerate(zip(*gaps(t, y), strict=True)):
        closed = approach[i] > 0.0
        passed = depth * rate > 0.0 and (depth < 0.0) == closed
        if closed and (passed or len(located[i])):
            new[i] = 0.0
        elif passed or len(located[i]):
            new[i] = max(float(rate), GRAZING)
            begun.append(Impact(t, i, float(new[i])))
    return new, begun


def _events(gaps: Gaps, approach: Array) -> list[Callable]:
    """Open contacts that close, and closed ones that open."""

    def event(i: int) -> Callable:
        def depth(t: float, y: Array) -> float:
            return gaps(t, y)[0][i]

        depth.terminal, depth.direction = True, 1.0 if approach[i] == 0.0 else -1.0  # type: ignore
        return depth

    return [event(i) for i in range(len(approach))]


# ------------------------------------------------------------------------------ slider-crank


@dataclass(frozen=True)
class SliderCrank:
    """Crank at constant speed, rod with its centre of mass in the middle, slider; no gravity.

    The crank turns about the origin, the slider moves along x. At t = 0 it is farthest from the
    crank, and everything moves as without clearance.

    The defaults are those of Flores, Ambrosio, Claro & Lankarani (2006).
    """

    crank: float = 0.05
    rod: float = 0.12
    rod_mass: float = 0.21
    rod_inertia: float = 2.5e-4
    slider_mass: float = 0.14
    speed: float = 5000.0 * pi / 30.0

    def pin(self, t: float) -> tuple[float, float]:
        """The crank pin [m]."""
        return self.crank * cos(self.speed * t), self.crank * sin(self.speed * t)

    def ideal(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position [m], velocity and acceleration of the slider without clearance."""
        turn = self.speed * np.asarray(t, dtype=float)
        s, c, r = np.sin(turn), np.cos(turn), self.crank
        root = np.sqrt(self.rod**2 - (r * s) ** 2)
        first = -r * s - r**2 * s * c / root
        second = -r * c - r**2 * ((c**2 - s**2) / root + (r * s * c) ** 2 / root**3)
        return r * c + root, self.speed * first, self.speed**2 * second

    def rod_angle(self, t: float) -> tuple[float, float]:
        """Angle of the rod from x [rad] without clearance, and its rate."""
        s, c = self.crank / self.rod * sin(self.speed * t), cos(self.speed * t)
        return -asin(s), -self.crank / self.rod * self.speed * c / sqrt(1.0 - s**2)


class Swing(NamedTuple):
    """Motion of a slider-crank with clearance at times ``t`` (k,) [s].

    Attributes
    ----------
    position, velocity, acceleration : (k,) [m], [m/s], [m/s^2]  of the slider along x
    force : (k, P) [N]  normal force of each contact
    orbit : (k, 2) [m]  journal centre in the bearing; of a slider in a guide: its centre across
        the guide, and its angle [rad]
    energy : (k, 5) [J]  kinetic without the crank, elastic, work of the crank, lost to hysteresis
        and to friction; the first two grow by the third less the last two
    impacts : onset, contact, approach speed
    """

    t: Array
    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    orbit: Array
    energy: Array
    impacts: list[Impact]

    @property
    def defect(self) -> Array:
        """(k,) [J]  what the energy balance lacks."""
        kinetic, stored, work, hysteresis, friction = self.energy.T
        return kinetic - kinetic[0] + stored - work + hysteresis + friction


BEARING_RADIUS, YOUNG, POISSON = 10e-3, 207e9, 0.3
"""Of the bore [m], and of both metals [Pa] (Flores et al. 2006)."""


def slider_crank(
    clearance: float = 0.5e-3,
    restitution: float = 0.9,
    friction: float = 0.0,
    t_end: float = 0.012,
    law: Law | None = None,
    mechanism: SliderCrank | None = None,
    samples: int = 2001,
) -> Swing:
    """Slider-crank whose rod ends in a pin that has play in the bore of the slider.

    law : default: Hertz of a pin in a bore of 10 mm radius, the exact factor of restitution
    """
    m = mechanism or SliderCrank()
    radius = BEARING_RADIUS - clearance
    if law is None:
        K = hertz_in_a_bore(radius, clearance, YOUNG, POISSON)
        law = Law(K, factor=exact_factor(restitution), friction=friction)
    loose = _Pin(m, law, clearance, radius)
    angle, turning = m.rod_angle(0.0)
    x, v, _ = m.ideal(0.0)
    start = [angle, float(x), turning, float(v), 0.0, 0.0, 0.0]
    return _swung(loose, start, np.linspace(0.0, t_end, samples))


def _swung(loose: "_Pin | _Block", start: Sequence[float], times: Array) -> Swing:
    """Motion of a slider-crank with something loose, in steps of a thousandth of a turn at most."""
    largest = 1e-3 * 2 * pi / loose.mechanism.speed
    return loose.swing(march(loose.rate, loose.gaps, start, times, largest))


@dataclass(frozen=True)
class _Pin:
    """Coordinates: angle of the rod, place of the slider; then work, hysteresis, friction."""

    mechanism: SliderCrank
    law: Law
    clearance: float
    radius: float

    def apart(self, t: float, y: Array) -> tuple[float, float, float, float]:
        """Position and velocity of the journal centre in the bearing."""
        m, (ax, ay) = self.mechanism, self.mechanism.pin(t)
        c, s, w = cos(y[0]), sin(y[0]), m.speed
        return (
            ax + m.rod * c - y[1], ay + m.rod * s,
            -w * ay - m.rod * y[2] * s - y[3], w * ax + m.rod * y[2] * c,
        )  # fmt: skip

    def gaps(self, t: float, y: Array) -> tuple[list[float], list[float]]:
        ex, ey, vx, vy = self.apart(t, y)
        distance = hypot(ex, ey)
        rate = (ex * vx + ey * vy) / distance if distance else hypot(vx, vy)
        return [distance - self.clearance], [rate]

    def acting(self, t: float, y: Array, approach: Array) -> tuple[float, ...]:
        """Force (2) on the pin; moment of friction about its centre; two losses of power [W]."""
        (depth,), (rate,) = self.gaps(t, y)
        elastic, force = self.law.normal(depth, rate, approach[0])
        if force == 0.0:
            return 0.0, 0.0, 0.0, -elastic * rate, 0.0
        ex, ey, vx, vy = self.apart(t, y)
        nx, ny = ex / (depth + self.clearance), ey / (depth + self.clearance)
        slip = nx * vy - ny * vx + self.radius * y[2]
        T = self.law.tangential(force, slip)
        lost = (force - elastic) * rate, -T * slip
        return -force * nx - T * ny, -force * ny + T * nx, self.radius * T, *lost

    def rate(self, t: float, y: Array, approach: Array) -> list[float]:
        m, (ax, ay) = self.mechanism, self.mechanism.pin(t)
        fx, fy, moment, *lost = self.acting(t, y, approach)
        c, s, half, w2 = cos(y[0]), sin(y[0]), 0.5 * m.rod, m.speed**2
        across = w2 * (ax * s - ay * c)  # acceleration of the crank pin across the rod
        inertia = m.rod_inertia + m.rod_mass * half**2
        turning = m.rod * (fy * c - fx * s) + moment - m.rod_mass * half * across
        turning /= inertia
        gx = -w2 * ax - half * (turning * s + y[2] ** 2 * c)
        gy = -w2 * ay + half * (turning * c - y[2] ** 2 * s)
        pull = m.rod_mass * gx - fx, m.rod_mass * gy - fy  # of the crank pin on the rod
        work = m.speed * (pull[1] * ax - pull[0] * ay)
        return [y[2], y[3], turning, -fx / m.slider_mass, work, *lost]

    def swing(self, path: Path) -> Swing:
        m, law = self.mechanism, self.law
        states = list(zip(path.t, path.y.T, path.approach, strict=True))
        orbit = np.array([self.apart(t, y)[:2] for t, y, _ in states])
        gaps = [(self.gaps(t, y), a[0]) for t, y, a in states]
        force = np.array([[law.normal(d[0], v[0], a)[1]] for (d, v), a in gaps])
        depth = np.array([d[0] for (d, _), _ in gaps])
        motion = _rod_energy(m, path) + 0.5 * m.slider_mass * path.y[3] ** 2
        energy = np.column_stack([motion, law.stored(depth), path.y[4:].T])
        pushed = np.array([-self.acting(*state)[0] / m.slider_mass for state in states])
        return Swing(path.t, path.y[1], path.y[3], pushed, force, orbit, energy, path.impacts)


def _rod_energy(m: SliderCrank, path: Path) -> Array:
    """Kinetic energy of the rod [J] from its angle y[0] and the rate y[n], n coordinates."""
    angle, turning = path.y[0], path.y[2]
    at, half = m.speed * path.t, 0.5 * m.rod
    vx = -m.crank * m.speed * np.sin(at) - half * turning * np.sin(angle)
    vy = m.crank * m.speed * np.cos(at) + half * turning * np.cos(angle)
    return 0.5 * m.rod_mass * (vx**2 + vy**2) + 0.5 * m.rod_inertia * turning**2


# ------------------------------------------------------------------------- slider in a guide


def slider_in_guide(
    clearance: float = 0.5e-3,
    restitution: float = 0.9,
    friction: float = 0.0,
    t_end: float = 0.012,
    law: Law | None = None,
    length: float = 50e-3,
    height: float = 50e-3,
    mechanism: SliderCrank | None = None,
    samples: int = 2001,
) -> Swing:
    """Slider-crank with ideal pins whose slider has ``clearance`` to both walls of its guide.

    The pin is at the middle of the slider, a homogeneous block. Contacts: corners rear low, rear
    high, front low, front high.

    law : of one corner; default: linear, 1e8 N/m, the exact factor of restitution
    """
    m = mechanism or SliderCrank()
    law = law or Law(1e8, 1.0, exact_factor(restitution), friction)
    loose = _Block(m, law, clearance, length, height)
    angle, turning = m.rod_angle(0.0)
    start = [angle, 0.0, turning, 0.0, 0.0, 0.0, 0.0]
    return _swung(loose, start, np.linspace(0.0, t_end, samples))


@dataclass(frozen=True)
class _Block:
    """Coordinates: angles of rod and slider; then work, hysteresis, friction."""

    mechanism: SliderCrank
    law: Law
    clearance: float
    length: float
    height: float

    @property
    def inertia(self) -> float:
        return self.mechanism.slider_mass * (self.length**2 + self.height**2) / 12.0

    def corners(self, y: Array) -> list[tuple[float, float, float]]:
        """Of each corner, the arm from the centre [m] and the side: -1 low, 1 high."""
        c, s, a, b = cos(y[1]), sin(y[1]), 0.5 * self.length, 0.5 * self.height
        signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
        return [(i * a * c - j * b * s, i * a * s + j * b * c, j) for i, j in signs]

    def centre(self, t: float, y: Array) -> tuple[float, float, float, float]:
        """Position and velocity of the slider's centre."""
        m, (ax, ay) = self.mechanism, self.mechanism.pin(t)
        c, s, w = cos(y[0]), sin(y[0]), m.speed
        return (
            ax + m.rod * c, ay + m.rod * s,
            -w * ay - m.rod * y[2] * s, w * ax + m.rod * y[2] * c,
        )  # fmt: skip

    def gaps(self, t: float, y: Array) -> tuple[list[float], list[float]]:
        _, height, _, rising = self.centre(t, y)
        wall, corners = 0.5 * self.height + self.clearance, self.corners(y)
        depths = [side * (height + sy) - wall for _, sy, side in corners]
        return depths, [side * (rising + y[3] * sx) for sx, _, side in corners]

    def acting(self, t: float, y: Array, approach: Array) -> tuple[float, ...]:
        """Force (2) on the slider, its moment about the centre; two losses of power [W]."""
        along = self.centre(t, y)[2]
        total = np.zeros(5)
        for depth, rate, v, (sx, sy, side) in zip(
            *self.gaps(t, y), approach, self.corners(y), strict=True
        ):
            elastic, force = self.law.normal(depth, rate, v)
            slip = along - y[3] * sy
            fx, fy = self.law.tangential(force, slip), -side * force
            total += fx, fy, sx * fy - sy * fx, (force - elastic) * rate, -fx * slip
        return tuple(total)

    def rate(self, t: float, y: Array, approach: Array) -> list[float]:
        turning, (fx, fy, moment, *lost) = self.turning(t, y, approach)
        m, (ax, ay) = self.mechanism, self.mechanism.pin(t)
        whole, static = m.rod_mass + m.slider_mass, m.rod * (0.5 * m.rod_mass + m.slider_mass)
        c, s, w2 = cos(y[0]), sin(y[0]), m.speed**2
        px = -whole * w2 * ax - static * (turning * s + y[2] ** 2 * c) - fx
        py = -whole * w2 * ay + static * (turning * c - y[2] ** 2 * s) - fy
        work = m.speed * (py * ax - px * ay)  # of the pull of the crank pin on the rod
        return [y[2], y[3], turning, moment / self.inertia, work, *lost]

    def turning(self, t: float, y: Array, approach: Array) -> tuple[float, tuple[float, ...]]:
        """Angular acceleration of the rod [rad/s^2], and what acts on the slider."""
        m, (ax, ay) = self.mechanism, self.mechanism.pin(t)
        acting = self.acting(t, y, approach)
        c, s = cos(y[0]), sin(y[0])
        static = m.rod * (0.5 * m.rod_mass + m.slider_mass)
        inertia = m.rod_inertia + m.rod**2 * (0.25 * m.rod_mass + m.slider_mass)
        across = m.speed**2 * (ax * s - ay * c)
        moment = m.rod * (acting[1] * c - acting[0] * s) - static * across
        return moment / inertia, acting

    def swing(self, path: Path) -> Swing:
        m, law = self.mechanism, self.law
        states = list(zip(path.t, path.y.T, path.approach, strict=True))
        at = np.array([self.centre(t, y) for t, y, _ in states]).T
        gaps = np.array([self.gaps(t, y) for t, y, _ in states])
        force = np.array([
            [law.normal(*contact)[1] for contact in zip(d, v, a, strict=True)]
            for (d, v), a in zip(gaps, path.approach, strict=True)
        ])  # fmt: skip
        turning = np.array([self.turning(*state)[0] for state in states])
        ax = m.crank * np.cos(m.speed * path.t)
        bend = turning * np.sin(path.y[0]) + path.y[2] ** 2 * np.cos(path.y[0])
        motion = _rod_energy(m, path) + 0.5 * m.slider_mass * (at[2] ** 2 + at[3] ** 2)
        motion += 0.5 * self.inertia * path.y[3] ** 2
        energy = np.column_stack([motion, law.stored(gaps[:, 0]).sum(axis=1), path.y[4:].T])
        orbit = np.column_stack([at[1], path.y[1]])
        pushed = -(m.speed**2) * ax - m.rod * bend
        return Swing(path.t, at[0], at[2], pushed, force, orbit, energy, path.impacts)
