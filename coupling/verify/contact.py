"""A ball in a bearing with clearance, which most problems of contact are about.

All motions are those of the joints in the solver under step control, which divides the duration
of an impact into about 32 steps; restitution is then within 2e-3.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coupling.verify.models import ROOM, elastic, model
from coupling.verify.motion import Path, run
from mechanics.contact import elastic_impact
from mechanics.description import ClearanceRevolute, Friction, NormalContact, Particle, Site
from mechanics.dynamics import Control
from mechanics.march import DEPTH, DEPTH_RATE, DISSIPATIVE, ELASTIC

Array = NDArray[np.float64]

X, Y, AXIS = np.eye(3)
GRAVITY = 9.81  # [m/s^2]
STIFFNESS = 1e10  # [N/m^1.5]
STEEL = elastic(2e11, 0.3, 1.0, 23.1e-6)
CLEARANCE = 1e-4  # [m]


def joint(
    contact: NormalContact,
    clearance: float,
    friction: Friction | None = None,
    body: str = "ball",
    radius: float = 25e-3,
    bearing: ArrayLike = (0.0, 0.0, 0.0),
) -> ClearanceRevolute:
    """A journal at the start of ``body`` in a bearing of the ground, about z."""
    ground = Site(None, position=np.array(bearing))
    return ClearanceRevolute(
        "hinge", Site(body), ground, AXIS, radius, clearance, STEEL, STEEL, ROOM, contact, friction
    )  # fmt: skip


def ball(mass: float, velocity: ArrayLike) -> Particle:
    """A point mass in the middle of the bearing."""
    return Particle("ball", np.zeros(3), mass, np.array(velocity))


def pressed(path: Path, contact: int = 0) -> Array:
    """(k,) [N]  normal force of a contact after each step."""
    return path.response[:, contact, ELASTIC] + path.response[:, contact, DISSIPATIVE]


def onsets(path: Path, contact: int = 0) -> Array:
    """Times [s] at which impacts begin."""
    running = path.approach[:, contact] != 0.0
    return path.t[np.flatnonzero(running & ~np.append(False, running[:-1]))]


class Impact(NamedTuple):
    """Largest penetration [m] and force [N], least force, duration [s], rebound over approach."""

    penetration: float
    force: float
    pull: float
    duration: float
    restitution: float


def impact(mass: float, speed: float, contact: NormalContact, lasting: float = 1.0) -> Impact:
    """First impact of a ball shot from the middle of a bearing with 0.1 mm clearance.

    It may last ``lasting`` times as long as an elastic one.
    """
    made = model(ball(mass, speed * X), [joint(contact, CLEARANCE)])
    duration = float(elastic_impact(mass, contact.value or STIFFNESS, speed).duration)
    flight = CLEARANCE / speed
    path = run(made, flight + 1.5 * lasting * duration, Control(1e-6, 0.3 * flight, 1e-18))
    depth, rate, force = path.response[:, 0, DEPTH], path.response[:, 0, DEPTH_RATE], pressed(path)
    on = np.flatnonzero(depth > 0.0)[0]
    off = on + np.flatnonzero(depth[on:] < 0.0)[0]  # force and rate go on smoothly to zero
    past = depth[off] / rate[off]
    return Impact(
        depth[:off].max(), force[:off].max(), force.min(), path.t[off] - past - flight,
        -rate[off] / speed,
    )  # fmt: skip
