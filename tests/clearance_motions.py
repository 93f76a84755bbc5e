"""Bodies in joints with clearance that move, for tests of impacts and of friction in time."""

import numpy as np

from coupling.verify.models import ROOM, elastic, model
from mechanics.description import (
    ClearanceCylindrical,
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    NormalContact,
    Particle,
    RigidBody,
    Site,
)
from mechanics.dynamics import Control

X, Y, Z = np.eye(3)
METAL = elastic(2e11, 0.3, 7800.0, 1.2e-5)
HALVES = (METAL, METAL, ROOM)
MASS, RADIUS, CLEARANCE, LENGTH = 0.2, 0.025, 1e-4, 0.06
INERTIA = np.diag([2e-4, 3e-4, 2.5e-4])
HERE, GROUND = Site("body"), Site(None)
HARD = 1e14
"""Stiffness [N/m^1.5] of impacts that are short against flights."""

KINDS = {  # joint about z, and directions in which its journal can fly into contact
    "planar revolute": (
        lambda **law: ClearanceRevolute("j", HERE, GROUND, Z, RADIUS, CLEARANCE, *HALVES, **law),
        [X, (2 * X - Y) / 5**0.5],
    ),
    "revolute": (
        lambda **law: ClearanceRevolute(
            "j", HERE, GROUND, Z, RADIUS, CLEARANCE, *HALVES, length=LENGTH,
            axial_clearance=CLEARANCE, **law
        ),
        [Y, Z],
    ),
    "spherical": (
        lambda **law: ClearanceSpherical("j", HERE, GROUND, RADIUS, CLEARANCE, *HALVES, **law),
        [(2 * X - Y + 2 * Z) / 3, Z],
    ),
    "cylindrical": (
        lambda **law: ClearanceCylindrical(
            "j", HERE, GROUND, Z, RADIUS, CLEARANCE, LENGTH, *HALVES, **law
        ),
        [(X + Y) / 2**0.5],
    ),
    "planar translational": (
        lambda **law: ClearanceTranslational(
            "j", HERE, GROUND, Z, X, LENGTH, 0.04, CLEARANCE, *HALVES, **law
        ),
        [X, -X],
    ),
    "translational": (
        lambda **law: ClearanceTranslational(
            "j", HERE, GROUND, Z, X, LENGTH, 0.04, CLEARANCE, *HALVES, width=0.02, **law
        ),
        [X, -Y],
    ),
}  # fmt: skip
FLIGHTS = [(kind, k) for kind, (_, ways) in KINDS.items() for k in range(len(ways))]


def body(velocity=(0, 0, 0), spin=(0, 0, 0), position=(0, 0, 0), axes=None, mass=MASS,
         inertia=INERTIA):  # fmt: skip
    axes = np.eye(3) if axes is None else axes
    turned = axes.T @ inertia @ axes
    return RigidBody(
        "body", np.asarray(position, float), mass, turned, axes, np.asarray(velocity, float),
        np.asarray(spin, float),
    )  # fmt: skip


def particle(velocity=(0, 0, 0), position=(0, 0, 0), mass=MASS):
    return Particle("body", np.asarray(position, float), mass, np.asarray(velocity, float))


def law(restitution=0.85, value=HARD, stiffness="hertz-external", **more):
    return NormalContact(stiffness, value, restitution=restitution, **more)


def flying(kind, way, speed, contact, friction=None, spin=(0, 0, 0)):
    make, ways = KINDS[kind]
    return model([body(speed * ways[way], spin)], [make(contact=contact, friction=friction)])


def steps(largest, tolerance=1e-6):
    return Control(tolerance, largest, 1e-20)


def kinetic(made, path):
    """(k,) kinetic energy [J] of all steps."""
    return 0.5 * np.sum(path.v * (made.system.mass @ path.v.T).T, axis=1)
