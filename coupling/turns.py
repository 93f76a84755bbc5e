"""How sections are turned: triads, angular velocities, angles of joints."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanics.layout import Layout, Side

Array = NDArray[np.float64]


def triad(side: Side, q: Array) -> Array:
    """(3, 3) rows e1, e2, e3 of a section at coordinates q; those of the ground are fixed.

    e2 is along the first vector of the section, e1 at right angles to both.
    """
    if side.fixed:
        return np.eye(3)
    p, s = _vectors(side, q)[1:]
    e2, e1 = _unit(p), _unit(np.cross(p, s))
    return np.stack([e1, e2, np.cross(e1, e2)])


def spin(side: Side, q: Array, v: Array) -> Array:
    """(3,) float [rad/s]  angular velocity of that triad."""
    if side.fixed:
        return np.zeros(3)
    (p, s), (dp, ds) = _vectors(side, q)[1:], _vectors(side, v)[1:]
    e1, e2, e3 = triad(side, q)
    normal = np.cross(p, s)
    d1 = _turned(e1, np.cross(dp, s) + np.cross(p, ds)) / np.linalg.norm(normal)
    d2 = _turned(e2, dp) / np.linalg.norm(p)
    d3 = np.cross(d1, e2) + np.cross(e1, d2)
    return 0.5 * (np.cross(e1, d1) + np.cross(e2, d2) + np.cross(e3, d3))


def _turned(unit: Array, rate: Array) -> Array:
    """Part of a rate of change that turns a unit vector."""
    return rate - (unit @ rate) * unit


def _vectors(side: Side, values: Array) -> Array:
    """(3, 3) r, p, s of coordinates, or of their rates."""
    return side.weights @ values[side.vectors[:, None] + np.arange(3)]


def _unit(a: Array) -> Array:
    return a / np.linalg.norm(a)


def added(triads: Array) -> Array:
    """(w, 3) float [rad]  rotation vectors from each of w triads to the next, added up."""
    from scipy.spatial.transform import Rotation

    steps = np.einsum("wij,wik->wjk", triads[1:], triads[:-1])
    turned = Rotation.from_matrix(steps).as_rotvec() if len(steps) else np.zeros((0, 3))
    return np.vstack([np.zeros(3), np.cumsum(turned, axis=0)])


def joint(model: Any, name: str, key: str, motion: Any) -> float:
    """Angle [rad], within half a turn, or rate [rad/s] of a revolute joint about its axis."""
    a, b, axis = _sides(model, name)
    layout: Layout = model.layout
    now = triad(b, motion.q)
    if key == "rate":
        apart = spin(a, motion.q, motion.v) - spin(b, motion.q, motion.v)
        return float(apart @ (axis @ triad(b, layout.q0).T @ now))
    start = triad(a, layout.q0), triad(b, layout.q0)
    # directions that side a has turned since the start, seen from b
    turned = (now.T @ start[1]).T @ (triad(a, motion.q).T @ start[0])
    across = _unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    there = turned @ across
    return float(np.arctan2(np.cross(axis, across) @ there, across @ there))


def _sides(model: Any, name: str) -> tuple[Side, Side, Array]:
    """Both sides of a joint, and its axis at the start."""
    from coupling.descriptions import sites_of

    table = model.scene.joint[name]
    first, second = (table.a, table.b) if hasattr(table, "a") else (table.journal, table.bearing)
    a, b, _ = sites_of(model.scene, first, second)
    return model.layout.site(a), model.layout.site(b), np.array(table.axis)
