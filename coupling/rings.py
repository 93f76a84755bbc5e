"""Ring trusses in the words of mechanics, for measuring without a case."""

import numpy as np

from mechanics.description import Beam, Clamp, Description, Force, Revolute, Site, Spherical
from meshes.generate import frames
from meshes.materials import Material
from meshes.sections import Section
from meshes.truss import START, Hinge, Truss, loaded_corners

LOADED = 24
"""Corners on which an oscillating force acts."""


def ring_description(
    truss: Truss,
    section: Section,
    material: Material,
    damping_time: float = 0.0,
    reference_temperature: float = 293.15,
    amplitude: float = 10.0,
    frequency: float = 0.5,
) -> Description:
    """A ring held at the foot of its first post, with 24 oscillating vertical forces.

    Parameters
    ----------
    amplitude : float [N];  frequency : float [Hz]  of the forces, phased around the ring
    """
    bodies = [
        Beam(m.name, m.points, frames(m.points, m.normal), section, material,
             reference_temperature, damping_time)
        for m in truss.members
    ]  # fmt: skip
    foot = Site(truss.corners[0][0], 0)
    place = next(m.points[0] for m in truss.members if m.name == foot.body)
    support = Clamp("support", foot, Site(None, 0, place))
    joints = [support, *(_joint(hinge) for hinge in truss.hinges)]
    loads = [
        Force(f"shaker_{i:02d}", _site(*truss.corners[c]), np.array([0.0, 0.0, 1.0]),
              _oscillation(amplitude, frequency, 2.0 * np.pi * i / LOADED))
        for i, c in enumerate(loaded_corners(len(truss.corners), LOADED))
    ]  # fmt: skip
    return Description(bodies, joints, loads)


def _site(body: str, at: str) -> Site:
    return Site(body, 0 if at == START else -1)


def _joint(hinge: Hinge) -> Revolute | Spherical:
    a, b = _site(hinge.a, hinge.at), _site(hinge.base, hinge.base_at)
    return Spherical(hinge.name, a, b) if hinge.axis is None else Revolute(
        hinge.name, a, b, hinge.axis
    )  # fmt: skip


def _oscillation(amplitude: float, frequency: float, phase: float):
    return lambda t: amplitude * np.sin(2.0 * np.pi * frequency * t + phase)
