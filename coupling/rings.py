"""Ring trusses in the words of mechanics, for measuring without a case."""

from dataclasses import dataclass, field

import numpy as np

from mechanics.description import (
    Beam,
    Clamp,
    ClearanceRevolute,
    ClearanceSpherical,
    Description,
    Force,
    Friction,
    Joint,
    NormalContact,
    Revolute,
    Site,
    Spherical,
)
from meshes.generate import frames
from meshes.materials import Material
from meshes.sections import Section
from meshes.truss import START, Hinge, Truss, loaded_corners

LOADED = 24
"""Corners on which an oscillating force acts."""


@dataclass(frozen=True)
class Play:
    """Pins in wider bores in the place of revolutes, of the material of the members.

    radius, clearance : float [m]  of every pin; radial
    spherical : whether spherical hinges as well are balls in wider sockets
    """

    radius: float
    clearance: float
    contact: NormalContact = field(default_factory=NormalContact)
    friction: Friction | None = None
    spherical: bool = False


def ring_description(
    truss: Truss,
    section: Section,
    material: Material,
    damping_time: float = 0.0,
    reference_temperature: float = 293.15,
    amplitude: float = 10.0,
    frequency: float = 0.5,
    clearance: Play | None = None,
) -> Description:
    """A ring held at the foot of its first post, with 24 oscillating vertical forces.

    Parameters
    ----------
    amplitude : float [N];  frequency : float [Hz]  of the forces, phased around the ring
    clearance : of the hinges, at the reference temperature; None: no play
    """
    bodies = [
        Beam(m.name, m.points, frames(m.points, m.normal), section, material,
             reference_temperature, damping_time)
        for m in truss.members
    ]  # fmt: skip
    foot = Site(truss.corners[0][0], 0)
    place = next(m.points[0] for m in truss.members if m.name == foot.body)
    support = Clamp("support", foot, Site(None, 0, place))
    hinges = [
        _hinge(h) if clearance is None or not (clearance.spherical or h.axis is not None)
        else _loose(h, clearance, material, reference_temperature)
        for h in truss.hinges
    ]  # fmt: skip
    loads = [
        Force(f"shaker_{i:02d}", _site(*truss.corners[c]), np.array([0.0, 0.0, 1.0]),
              _oscillation(amplitude, frequency, 2.0 * np.pi * i / LOADED))
        for i, c in enumerate(loaded_corners(len(truss.corners), LOADED))
    ]  # fmt: skip
    return Description(bodies, [support, *hinges], loads)


def _site(body: str, at: str) -> Site:
    return Site(body, 0 if at == START else -1)


def _hinge(hinge: Hinge) -> Joint:
    a, b = _site(hinge.a, hinge.at), _site(hinge.base, hinge.base_at)
    return Spherical(hinge.name, a, b) if hinge.axis is None else Revolute(
        hinge.name, a, b, hinge.axis
    )  # fmt: skip


def _loose(hinge: Hinge, play: Play, material: Material, T: float) -> Joint:
    journal, bearing = _site(hinge.a, hinge.at), _site(hinge.base, hinge.base_at)
    rest = play.radius, play.clearance, material, material, T, play.contact, play.friction
    if hinge.axis is None:
        return ClearanceSpherical(hinge.name, journal, bearing, *rest)
    return ClearanceRevolute(hinge.name, journal, bearing, hinge.axis, *rest)


def _oscillation(amplitude: float, frequency: float, phase: float):
    return lambda t: amplitude * np.sin(2.0 * np.pi * frequency * t + phase)
