"""Mechanisms of rigid bodies for verification, and their motion in equal steps.

Plane mechanisms live in space: a loop of hinges with parallel axes would say three things twice.
Every closed loop therefore has one bar that ends in a ball and in a universal joint.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coupling.verify.models import Model, sections
from mechanics.description import (
    Body,
    Description,
    Joint,
    Load,
    RigidBody,
    Site,
    Spherical,
    Universal,
)
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.march import Rows
from mechanics.schemes import Scheme
from mechanics.system import System

Array = NDArray[np.float64]

Z = np.array([0.0, 0.0, 1.0])
TIGHT = 1e-13
"""Newton tolerance; what remains at a looser one adds up over many steps to more than their error.
"""
HHT = Scheme("hht", alpha=-0.1, newton_tolerance=TIGHT)
ALPHA = Scheme("generalised-alpha", spectral_radius=0.8, newton_tolerance=TIGHT)
WINDOW = 1000
"""Steps between two times that are hit exactly: rounding must not add a step."""


class Steps(NamedTuple):
    """Of each step: t : (k,) [s], q, v : (k, n), lam : (k, m)"""

    t: Array
    q: Array
    v: Array
    lam: Array


def mechanism(
    bodies: Sequence[Body],
    joints: Sequence[Joint],
    loads: Sequence[Load] = (),
    gravity: ArrayLike = (0.0, 0.0, 0.0),
) -> Model:
    """Build a system; nothing in it depends on temperature."""
    system = System(Description(bodies, joints, loads, np.asarray(gravity, float)))
    return Model(system, system.coefficients(sections(system)))


def stepped(made: Model, end: float, h: float, scheme: Scheme = HHT) -> Steps:
    """All steps of ``h`` [s] up to ``end`` [s]; an error if the run stops."""
    control = Control(np.inf, h, h, scheme)
    state, why = initial_state(made.system, control, made.coef)
    if state is None:
        raise RuntimeError(why)
    found: list[Rows] = []
    for t in h * np.arange(0, round(end / h), WINDOW):
        span = min(WINDOW * h, end - t)
        window = Window.between(made.system, float(t), span, made.coef, None)
        state, _, why = advance(made.system, control, state, window, found.append, full=True)
        if why:
            raise RuntimeError(why)
    n = made.system.n
    t, y, v = (np.concatenate([getattr(r, key) for r in found]) for key in ("t", "y", "v"))
    return Steps(t, y[:, :n], v[:, :n], y[:, n:])


def plane_body(
    name: str, centre: ArrayLike, mass: float, inertia: float, angle: float = 0.0
) -> RigidBody:
    """A body that moves in the plane z = 0; e1 is at ``angle`` [rad] to x.

    Inertia [kg m^2] about z; about the other axes it plays no part.
    """
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    position = np.array([*np.asarray(centre, float), 0.0])
    return RigidBody(name, position, mass, inertia * np.eye(3), axes)


def towards(angle: float) -> Array:
    """Unit vector (2,) at an angle [rad] to x."""
    return np.array([np.cos(angle), np.sin(angle)])


def bar(
    name: str, start: ArrayLike, end: ArrayLike, mass: float, inertia: float, centre: float = 0.5
) -> RigidBody:
    """A bar from ``start`` to ``end`` (2,) [m] with its centre of mass at a fraction of it."""
    a, b = np.asarray(start, float), np.asarray(end, float)
    angle = float(np.arctan2(*(b - a)[::-1]))
    return plane_body(name, a + centre * (b - a), mass, inertia, angle)


def turning(body: RigidBody, centre: ArrayLike, rate: float) -> RigidBody:
    """The body turning at ``rate`` [rad/s] about a point of the plane at the start."""
    arm = body.position - np.array([*np.asarray(centre, float), 0.0])
    return replace(body, velocity=np.cross(rate * Z, arm), spin=rate * Z)


def at(body: RigidBody, point: ArrayLike) -> Site:
    """The point of the plane (2,) [m], given in the reference, as one of the body."""
    away = np.array([*np.asarray(point, float), 0.0]) - body.position
    return Site(body.name, offset=np.asarray(body.axes) @ away)


def ground(point: ArrayLike) -> Site:
    """A fixed point of the plane."""
    return Site(None, position=np.array([*np.asarray(point, float), 0.0]))


def coupler(
    body: RigidBody, ball: tuple[Site, ArrayLike], cross: tuple[Site, ArrayLike]
) -> list[Joint]:
    """Joints of a bar that closes a loop: a ball at one end, a universal joint at the other.

    ball, cross : end of the body to which it is joined, and where (2,) [m]
    """
    across = np.asarray(body.axes)[1]
    return [
        Spherical(f"{body.name} ball", at(body, ball[1]), ball[0]),
        Universal(f"{body.name} cross", at(body, cross[1]), cross[0], across, Z),
    ]


def point(made: Model, q: Array, site: Site) -> Array:
    """(k, 3) [m] path of a material point for coordinates q (k, n)."""
    side = made.system.layout.site(site)
    return np.einsum("v,kvi->ki", side.weights[0], q[:, side.vectors[:, None] + np.arange(3)])


def directors(made: Model, q: Array, body: str) -> Array:
    """(k, 3, 3) rows e1, e2, e3 of a rigid body."""
    first = made.system.layout.node_dofs[body][0]
    return q[:, first + 3 : first + 12].reshape(-1, 3, 3)


def turn(made: Model, q: Array, body: str) -> Array:
    """(k,) [rad] turn of e1 in the plane since the reference, over any number of revolutions.

    From one row to the next it must turn by less than half a revolution.
    """
    e = directors(made, np.concatenate([made.system.layout.q0[None], q]), body)[:, 0]
    angle = np.unwrap(np.arctan2(e[:, 1], e[:, 0]))
    return angle[1:] - angle[0]


def spin(made: Model, q: Array, v: Array, body: str) -> Array:
    """(k, 3) [rad/s] angular velocity along the directors."""
    e, rate = directors(made, q, body), directors(made, v, body)
    omega = 0.5 * np.cross(e, rate).sum(axis=1)
    return np.einsum("kij,kj->ki", e, omega)


def halved(coarse: float, count: int) -> list[float]:
    """Step sizes, each half of the one before."""
    return [coarse / 2**i for i in range(count)]


def largest(errors: Sequence[Array]) -> list[float]:
    """Largest absolute value of each."""
    return [float(np.abs(e).max()) for e in errors]
