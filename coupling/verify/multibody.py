"""Rigid bodies and joints: plane mechanisms, and the orders of the schemes."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from coupling.verify import mechanisms as m
from coupling.verify import spatial, squeezer
from coupling.verify.mechanisms import (
    ALPHA,
    HHT,
    at,
    bar,
    coupler,
    ground,
    mechanism,
    plane_body,
    stepped,
)
from coupling.verify.models import Model
from coupling.verify.registry import Check, Convergence, Result, problem
from mechanics.description import (
    Body,
    Distance,
    Guide,
    Joint,
    Particle,
    Prismatic,
    Revolute,
    Site,
    Spherical,
)
from mechanics.dynamics import Control, initial_state
from mechanics.schemes import Scheme

__all__ = ["spatial", "squeezer"]

Array = NDArray[np.float64]
Rates = Callable[[float, Array], Array]

GRAVITY = (0.0, -9.81, 0.0)
PLANE = np.array([[0.0, 0.0, 1.0]])


# -- pendulum ----------------------------------------------------------------------------------


def _swing(t: Array) -> Array:
    """(k, 2) [m] end of a unit pendulum released from (-1, 0): Jacobi's elliptic functions.

    sin(angle/2) = k cd(w t | k^2) with k = sin(90 deg/2); Whittaker (1937), sec. 44.
    """
    sn = ellipj(np.sqrt(-GRAVITY[1]) * t + ellipk(0.5), 0.5)[0]
    half = np.arcsin(np.sqrt(0.5) * sn)
    return np.stack([-np.sin(2.0 * half), -np.cos(2.0 * half)], axis=1)


def _point_mass() -> Model:
    bob = Particle("bob", np.array([-1.0, 0.0, 0.0]), 1.0)
    joints: list[Joint] = [
        Distance("rod", Site("bob"), Site(None)),
        Guide("plane", Site("bob"), PLANE),
    ]
    return mechanism([bob], joints, gravity=GRAVITY)


def _body_pendulum(hinge: type[Revolute] | type[Spherical]) -> Model:
    """m l^2 + J = m l for l = .8 m, J = .16 kg m^2: it swings as the unit pendulum."""
    bob = plane_body("bob", (-0.8, 0.0), 1.0, 0.16)
    ends = "pin", at(bob, (0.0, 0.0)), ground((0.0, 0.0))
    pin: Joint = Revolute(*ends, m.Z) if hinge is Revolute else Spherical(*ends)
    return mechanism([bob], [pin], gravity=GRAVITY)


_PENDULUMS: dict[str, tuple[Callable[[], Model], Site]] = {
    "point mass": (_point_mass, Site("bob")),
    "hinged body": (partial(_body_pendulum, Revolute), Site("bob", offset=np.array([-0.2, 0, 0]))),
    "body on a ball": (
        partial(_body_pendulum, Spherical), Site("bob", offset=np.array([-0.2, 0, 0])),
    ),
}  # fmt: skip


@problem("multibody", "pendulum as point mass, hinged body, body on a ball", "IFToMM benchmark A01")
def pendulum() -> list[Result]:
    found: list[Result] = []
    for name, (make, site) in _PENDULUMS.items():
        steps, made = m.halved(4e-3, 3), make()
        paths = [m.point(made, stepped(made, 10.0, h).q, site)[:, :2] for h in steps]
        at_times = [
            _swing(h * np.arange(1.0, len(p) + 1)) for h, p in zip(steps, paths, strict=True)
        ]
        errors = m.largest([p - e for p, e in zip(paths, at_times, strict=True)])
        found.append(Convergence(f"{name}, largest error in 10 s", steps, errors, 2.0, 0.1, "s"))
        found.append(Check(f"{name}, x(1 s)", paths[-1][999, 0], 0.98629175, 1e-5, "m"))
        found.append(Check(f"{name}, y(10 s)", paths[-1][-1, 1], -0.96141921, 2e-4, "m"))
    exact = _swing(np.array([1.0, 10.0]))
    found.append(Check("elliptic functions, x(10 s)", exact[1, 0], -0.27508746, 1e-7, "m"))
    return found


# -- orders ------------------------------------------------------------------------------------

_SCHEMES = {
    "HHT, alpha = -.1": (HHT, 2.0),
    "generalised-alpha, rho = .8": (ALPHA, 2.0),
    "HHT, velocities projected": (replace(HHT, constraints="projected"), 2.0),
    "BDF2": (Scheme("bdf2", newton_tolerance=m.TIGHT), 2.0),
    "backward Euler": (Scheme("backward-euler", newton_tolerance=m.TIGHT), 1.0),
}


@problem(
    "multibody", "orders of the schemes in index 3",
    "Negrut et al. 2007, Arnold & Bruls 2007; exact: elliptic functions",
)  # fmt: skip
def orders() -> list[Result]:
    return [
        Convergence(f"{name}: {what}", steps, errors, order, 0.15, "s")
        for name, (scheme, order) in _SCHEMES.items()
        for what, steps, errors in _order_rows(scheme)
    ]


def _order_rows(scheme: Scheme) -> list[tuple[str, list[float], list[float]]]:
    """Errors of position, velocity and multiplier of the pendulum at common times."""
    made, steps, end = _point_mass(), m.halved(8e-3, 4), 0.8
    errors: list[list[float]] = [[], [], []]
    for i, h in enumerate(steps):
        p, every = stepped(made, end, h, scheme), 2**i
        pick = slice(2 * every - 1, None, every)  # from the second of the coarsest steps on
        exact = _swing(p.t)
        rate = _speed(exact)[:, None] * np.stack([-exact[:, 1], exact[:, 0]], axis=1)
        tension = np.sum(rate**2, axis=1) + GRAVITY[1] * exact[:, 1]
        pulled = p.lam[:, made.system.row_names.index("rod")]
        found = p.q[:, :2] - exact, p.v[:, :2] - rate, pulled - tension
        for k, values in enumerate(found):
            errors[k].append(float(np.abs(values[pick]).max()))
    names = "positions", "velocities", "multipliers"
    return [(name, steps, column) for name, column in zip(names, errors, strict=True)]


def _speed(x: Array) -> Array:
    """Angular speed [rad/s] on the first swing, from the energy; anticlockwise."""
    return np.sqrt(np.maximum(2.0 * GRAVITY[1] * x[:, 1], 0.0))


# -- double pendulum ---------------------------------------------------------------------------


def _double_rates(_: float, y: Array) -> Array:
    """Two unit masses on unit rods, angles from the downward vertical."""
    a, b, u, w = y
    c, s, g = np.cos(a - b), np.sin(a - b), -GRAVITY[1]
    M = np.array([[2.0, c], [c, 1.0]])
    f = np.array([-s * w * w - 2.0 * g * np.sin(a), s * u * u - g * np.sin(b)])
    return np.concatenate([[u, w], np.linalg.solve(M, f)])


@problem("multibody", "double pendulum from horizontal", "Lagrange's equations by DOP853")
def double_pendulum() -> list[Result]:
    bobs = [Particle(f"bob{i}", np.array([-float(i), 0.0, 0.0]), 1.0) for i in (1, 2)]
    joints: list[Joint] = [
        Distance("upper", Site("bob1"), Site(None)),
        Distance("lower", Site("bob2"), Site("bob1")),
        Guide("plane1", Site("bob1"), PLANE), Guide("plane2", Site("bob2"), PLANE),
    ]  # fmt: skip
    made, steps = mechanism(bobs, joints, gravity=GRAVITY), m.halved(4e-3, 4)
    paths = [stepped(made, 2.0, h).q[:, 3:5] for h in steps]
    start = [-0.5 * np.pi, -0.5 * np.pi, 0.0, 0.0]
    a, b = _followed(_double_rates, start, 2.0, len(paths[0]))[:2]
    tips = np.stack([np.sin(a) + np.sin(b), -np.cos(a) - np.cos(b)], axis=1)
    x = paths[-1]
    return [
        Convergence("tip, largest error in 2 s", steps, _deviations(paths, tips), 2.0, 0.1, "s"),
        # the published start is on the other side, hence |x|
        Check("|x|(1 s)", abs(x[len(x) // 2 - 1, 0]), 1.44481885, 1e-5, "m"),
        Check("y(1 s)", x[len(x) // 2 - 1, 1], -1.32179446, 1e-5, "m"),
        Check("|x|(2 s)", abs(x[-1, 0]), 1.43412482, 1e-4, "m"),
        Check("y(2 s)", x[-1, 1], -1.12987020, 1e-4, "m"),
    ]


def _followed(rates: Rates, start: Sequence[float], end: float, count: int) -> Array:
    """(k, count) solution of an ordinary equation at the ends of ``count`` equal steps."""
    times = end / count * np.arange(1.0, count + 1)
    return solve_ivp(rates, (0, end), start, "DOP853", times, rtol=1e-12, atol=1e-12).y


def _deviations(paths: Sequence[Array], exact: Array) -> list[float]:
    """Largest deviation of each path from ``exact`` (k, 2), at the ends of its k steps."""
    return [float(np.abs(x[len(x) // len(exact) - 1 :: len(x) // len(exact)] - exact).max())
            for x in paths]  # fmt: skip


# -- N-four-bar --------------------------------------------------------------------------------


def _four_bar() -> Model:
    """Three upright bars and two horizontal ones, 1 m and 1 kg each; the tops move at 1 m/s.

    All bars are in line when they lie down: there the mechanism could change its mode of motion.
    """
    rods = [bar(f"upright{i}", (i, 0.0), (i, 1.0), 1.0, 1.0 / 12.0) for i in range(3)]
    tops = [bar(f"top{i}", (i, 1.0), (i + 1, 1.0), 1.0, 1.0 / 12.0) for i in range(2)]
    joints: list[Joint] = [
        Revolute(f"foot{i}", at(rod, (i, 0.0)), ground((i, 0.0)), m.Z) for i, rod in enumerate(rods)
    ]
    for i, top in enumerate(tops):
        left, right = (i, 1.0), (i + 1, 1.0)
        joints += coupler(top, (at(rods[i], left), left), (at(rods[i + 1], right), right))
    moving: list[Body] = [m.turning(rod, (i, 0.0), -1.0) for i, rod in enumerate(rods)]
    moving += [replace(top, velocity=np.array([1.0, 0.0, 0.0])) for top in tops]
    return mechanism(moving, joints, gravity=GRAVITY)


@problem("multibody", "2-four-bar mechanism through singular positions", "IFToMM benchmark A02")
def four_bar() -> list[Result]:
    made, steps = _four_bar(), m.halved(4e-3, 3)
    end, top = 10.0, Site("upright0", offset=np.array([0.5, 0.0, 0.0]))

    def rates(_: float, y: Array) -> Array:  # 3/2 w^2 + 3.5 g cos(angle) is constant
        return np.array([y[1], 3.5 / 3.0 * -GRAVITY[1] * np.sin(y[0])])

    paths = [m.point(made, stepped(made, end, h, ALPHA).q, top)[:, :2] for h in steps]
    angle = _followed(rates, [0.0, 1.0], end, len(paths[0]))[0]
    exact = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    first, last = paths[-1][round(1.0 / steps[-1]) - 1], paths[-1][-1]
    return [
        Convergence("top, largest error in 10 s", steps, _deviations(paths, exact), 2.0, 0.1, "s"),
        Check("x(1 s)", first[0], -0.195020302, 1e-3, "m"),
        Check("y(1 s)", first[1], -0.980799206, 1e-4, "m"),
        Check("x(10 s)", last[0], 0.328458112, 5e-3, "m"),
        Check("y(10 s)", last[1], 0.944518538, 5e-4, "m"),
        Check("x(10 s), equation of motion", exact[-1, 0], 0.328458112, 1e-7, "m"),
        Check("y(10 s), equation of motion", exact[-1, 1], 0.944518538, 1e-7, "m"),
    ]


# -- slider-crank ------------------------------------------------------------------------------

CRANK, ROD, SPEED = 0.05, 0.12, 5000.0 * 2.0 * np.pi / 60.0


def _slider(angle: Array) -> Array:
    """Acceleration [m/s^2] of the slider at crank angles, the crank turning evenly."""
    s, c = CRANK / ROD * np.sin(angle), CRANK * np.cos(angle)
    root = np.sqrt(1.0 - s * s)
    rise = CRANK**2 * np.cos(2.0 * angle) / (ROD * root)
    return -(SPEED**2) * (
        c + rise + CRANK**4 * np.sin(2.0 * angle) ** 2 / (4.0 * (ROD * root) ** 3)
    )


def _slider_crank(angle: float) -> Model:
    """Driven evenly from ``angle`` [rad] of the crank; data of Flores et al. (2006)."""
    pin = CRANK * m.towards(angle)
    end = np.array([pin[0] + np.sqrt(ROD**2 - pin[1] ** 2), 0.0])
    crank = m.turning(bar("crank", (0.0, 0.0), pin, 0.30, 1e-4), (0.0, 0.0), SPEED)
    rod, slider = bar("rod", pin, end, 0.21, 2.5e-4), plane_body("slider", end, 0.14, 1e-4)
    joints: list[Joint] = [
        Revolute("drive", at(crank, (0.0, 0.0)), ground((0.0, 0.0)), m.Z, lambda t: SPEED * t),
        Prismatic("guide", at(slider, end), ground(end), np.array([1.0, 0.0, 0.0])),
        *coupler(rod, (at(crank, pin), pin), (at(slider, end), end)),
    ]
    return mechanism([crank, rod, slider], joints)


def _started(angle: float) -> float:
    """Acceleration of the slider from the initial balance; other velocities follow the drive."""
    made = _slider_crank(angle)
    state, why = initial_state(made.system, Control(), made.coef)
    if state is None:
        raise RuntimeError(why)
    return float(state.motion.a[made.system.layout.node_dofs["slider"][0]])


@problem("multibody", "ideal slider-crank at 5000 rpm", "closed form; Flores et al. 2006")
def slider_crank() -> list[Result]:
    angles = np.linspace(0.0, np.pi, 20001)
    worst = float(angles[np.argmax(_slider(angles))])
    made, steps, end = _slider_crank(0.0), m.halved(8e-5, 3), 0.024
    errors = []
    for h in steps:
        p = stepped(made, end, h)
        x = p.v[:, made.system.layout.node_dofs["slider"][0]]
        a, s = SPEED * p.t, CRANK / ROD * np.sin(SPEED * p.t)
        v = -SPEED * CRANK * (np.sin(a) + CRANK / ROD * np.sin(2 * a) / (2 * np.sqrt(1 - s * s)))
        errors.append(float(np.abs(x - v).max()))
    return [
        Check("acceleration, crank at 0", _started(0.0), -19419.36, 1e-6, "m/s²"),
        Check("acceleration, crank at 180 degrees", _started(np.pi), 7996.21, 1e-6, "m/s²"),
        Check("largest acceleration", _started(worst), _slider(angles).max(), 1e-6, "m/s²"),
        Check("the same, as published", float(_slider(angles).max()), 9695.90, 1e-5, "m/s²"),
        Convergence("velocity over two turns", steps, errors, 2.0, 0.2, "s"),
    ]
