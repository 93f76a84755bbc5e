"""Prescribed temperatures of solid bodies, by the positions of their nodes."""

import numpy as np
from numpy.typing import NDArray

from thermal.description import Faces, Member, Wall
from thermal.layout import STATION_TOLERANCE, Given, arclength
from thermal.solid_bodies import Body

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def given_by_wall(c: Wall, body: Body, nodes: Indices) -> Given:
    """Hot and cold across the section, each linear from start to end of the stretch.

    Across the section the field is linear: hot and cold are reached on the mean surface of a tube,
    and on the surface of other sections.
    """
    assert isinstance(body.thing, Member)
    s = body.local[:, 0]
    slack = STATION_TOLERANCE * s.max()
    held = np.flatnonzero((s >= c.start - slack) & (s <= c.end + slack))
    length = c.end - c.start
    along = np.clip((s[held] - c.start) / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(held))
    hot = 0.5 + 0.5 * _facing(body, c.side)[held]
    ramps = np.stack([1.0 - along, along], axis=1)
    weights = np.concatenate([hot[:, None] * ramps, (1.0 - hot[:, None]) * ramps], axis=1)
    return Given(c.name, nodes[held], weights, (*c.hot, *c.cold))


def given_by_faces(c: Faces, body: Body, nodes: Indices) -> Given:
    """Hot at the top, cold at the bottom, linear through the thickness."""
    up = body.local[:, 2]
    return Given(c.name, nodes, np.stack([up, 1.0 - up], axis=1), (c.hot, c.cold))


def _facing(body: Body, side: Array | None) -> Array:
    """(m,)  section coordinate towards ``side``, 1 where hot and -1 where cold are reached."""
    m, (s, y, z) = body.thing, body.local.T
    assert isinstance(m, Member)
    if side is None:
        return np.zeros(len(s))
    stations, axes = arclength(m.points), np.asarray(m.axes, dtype=float)
    inplane = axes[:, 1:] @ np.asarray(side, dtype=float)
    inplane = np.stack([np.interp(s, stations, c) for c in inplane.T], axis=1)
    inplane /= np.linalg.norm(inplane, axis=1, keepdims=True)
    towards = inplane[:, 0] * y + inplane[:, 1] * z
    if m.section.kind == "tube":
        radii = np.hypot(y, z)
        return towards / (0.5 * (radii.min() + radii.max()))
    if m.section.kind == "circle":
        return towards / np.hypot(y, z).max()
    extent = np.abs(inplane) @ np.array([m.section.height, m.section.width]) / 2.0
    return towards / extent
