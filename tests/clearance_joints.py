"""Joints with clearance of every kind between bodies of every kind, and their terms as arrays."""

import numpy as np

from mechanics import kernels
from mechanics.clearance import build
from mechanics.contact_laws import APPROACH, HISTORY, SLOT, STEP
from mechanics.description import (
    Beam,
    ClearanceCylindrical,
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    Friction,
    NormalContact,
    Particle,
    RigidBody,
    Site,
)
from mechanics.layout import Layout
from mechanics.march import COLUMNS, DEPTH
from meshes.materials import constant_material

X, Y, Z = np.eye(3)
OBLIQUE = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
ACROSS = np.cross(OBLIQUE, Z) / np.linalg.norm(np.cross(OBLIQUE, Z))
STEEL = constant_material("steel", 8000.0, 193e9, 0.29, 17e-6, 16.2, 500.0)
ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
AMBIENT = 298.15
POINT = np.array([1.0, 2.0, 3.0])
"""Where the joints are."""
RADIUS, CLEARANCE, LENGTH = 0.3, 0.05, 0.4
HEIGHT, WIDTH, PLAY = 0.3, 0.2, 0.02


def rotation(axis, angle):
    k = np.cross(np.eye(3), np.asarray(axis, float))
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def beam(name, start, end, element="beam3243"):
    start, end = np.array(start, float), np.array(end, float)
    e1 = (end - start) / np.linalg.norm(end - start)
    e2 = np.cross([0.3, 1.0, 0.2], e1)
    e2 /= np.linalg.norm(e2)
    axes = np.tile([e1, e2, np.cross(e1, e2)], (2, 1, 1))
    return Beam(name, np.array([start, end]), axes, None, None, AMBIENT, element=element)


def rigid(name, position, turn):
    return RigidBody(
        name, np.asarray(position, float), 2.0, np.diag([0.1, 0.2, 0.15]), rotation(OBLIQUE, turn)
    )


BODIES = (
    beam("arm", POINT, (3, 2.5, 3.2)),
    beam("base", POINT, (-1.4, 1.0, 4.0)),
    beam("wire", POINT, POINT + np.array([2, -1, 0]), "cable"),  # normal to the oblique axis
    Particle("ball", POINT, 2.0),
    rigid("hub", POINT, 0.7),
    rigid("block", POINT - [0.1, 0.2, 0.3] @ rotation(OBLIQUE, 0.4), 0.4),
)
ENDS = {
    "arm": Site("arm"),
    "base": Site("base"),
    "wire": Site("wire"),
    "ball": Site("ball"),
    "hub": Site("hub"),
    "block": Site("block", offset=np.array([0.1, 0.2, 0.3])),
    "ground": Site(None, position=POINT),
}
HALVES = (STEEL, ALUMINIUM, AMBIENT)
KINDS = {
    "planar revolute": lambda a, b, **law: ClearanceRevolute(
        "j", a, b, OBLIQUE, RADIUS, CLEARANCE, *HALVES, **law
    ),
    "revolute with flanges": lambda a, b, **law: ClearanceRevolute(
        "j", a, b, OBLIQUE, RADIUS, CLEARANCE, *HALVES, length=LENGTH, axial_clearance=PLAY, **law
    ),
    "spherical": lambda a, b, **law: ClearanceSpherical("j", a, b, RADIUS, CLEARANCE, *HALVES,
                                                        **law),
    "cylindrical": lambda a, b, **law: ClearanceCylindrical(
        "j", a, b, OBLIQUE, RADIUS, CLEARANCE, LENGTH, *HALVES, **law
    ),
    "planar translational": lambda a, b, **law: ClearanceTranslational(
        "j", a, b, OBLIQUE, ACROSS, 0.5, HEIGHT, PLAY, *HALVES, **law
    ),
    "translational": lambda a, b, **law: ClearanceTranslational(
        "j", a, b, OBLIQUE, ACROSS, 0.5, HEIGHT, PLAY, *HALVES, width=WIDTH, **law
    ),
}  # fmt: skip
SLOTS = {
    "planar revolute": 1, "revolute with flanges": 8, "spherical": 1, "cylindrical": 2,
    "planar translational": 4, "translational": 16,
}  # fmt: skip
FRICTIONS = {
    law: Friction(
        0.3, law=law, static_coefficient=0.4, regularisation_speed=0.05, stribeck_speed=0.1,
        viscous=0.01, presliding=0.05, bristle_damping=0.02,
    )
    for law in ("regularised", "stick", "stribeck", "lugre", "rising")
} | {"none": None}  # fmt: skip
LINEAR = NormalContact("linear", 2e3, "exact", 0.8)
HERTZ = NormalContact("hertz-external", 2e3, "exact", 0.8)


class Scene:
    """The term of one joint, with what its contacts carry with them.

    coef : (1, slots SLOT) float;  rows : (slots, SLOT) a view of it
    """

    def __init__(self, kind, pair, friction="none", contact=HERTZ, T=None):
        made = KINDS[kind](*(ENDS[end] for end in pair), contact=contact,
                           friction=FRICTIONS.get(friction, friction))  # fmt: skip
        self.joint = made
        self.layout = Layout.of(BODIES, [made])
        (self.term,) = build([made], self.layout)
        self.coef = self.term.coefficients(self.temperatures() if T is None else T)
        self.rows = self.coef.reshape(-1, SLOT)
        self.n = self.layout.ndof

    def temperatures(self, journal=AMBIENT, bearing=AMBIENT):
        T = np.zeros((len(self.layout.x), 3))
        T[:, 0] = 250.0
        T[self.layout.point_index["j.journal"], 0] = journal
        T[self.layout.point_index["j.bearing"], 0] = bearing
        return T

    def carry(self, approach=0.0, step=0.0, history=None):
        self.rows[:, APPROACH], self.rows[:, STEP] = approach, step
        if history is not None:
            self.rows[:, HISTORY : HISTORY + 7] = history
        return self

    def vectors(self, q):
        return q.reshape(-1, 3)

    @property
    def positions(self):
        """(n/3,) whether a vector of the coordinates is a position."""
        found = np.zeros(self.n // 3, dtype=bool)
        for nodes in self.layout.node_dofs.values():
            found[nodes // 3] = True
        return found

    def force(self, q, v):
        out = np.zeros(self.n)
        kernels.add_force(self.term, q, v, self.coef, out)
        return out

    def response(self, q, v):
        return kernels.responses(self.term, q, v, self.coef, COLUMNS)

    def history(self, q, v):
        return kernels.histories(self.term, q, v, self.coef, 7)

    def energy(self, q):
        return kernels.energies(self.term, q, np.zeros_like(q), self.coef)[0]

    def tangent(self, q, v, cK, cC):
        blocks = kernels.tangent_blocks(self.term, q, v, self.coef, cK, cC)
        total = np.zeros((self.n + 1, self.n + 1))
        for dofs, block in zip(self.term.dofs, blocks, strict=True):
            np.add.at(total, (dofs[:, None], dofs[None]), block)
        return total[:-1, :-1]

    @property
    def touched(self):
        """Coordinates of the joint."""
        return np.unique(self.term.dofs[self.term.dofs >= 0])


def difference(function, x, which, step=1e-6):
    """Columns ``which`` of the derivative by central differences; the others are zero."""
    found = np.zeros((function(x).size, x.size))
    for k in which:
        e = np.zeros(x.size)
        e[k] = step
        found[:, k] = (function(x + e) - function(x - e)) / (2 * step)
    return found


def moved(scene, seed=5, amount=0.1, speed=1.0):
    """Coordinates away from the reference, sections strained and sheared, and velocities.

    Those of the first seed, from the given one on, for which a contact touches.
    """
    for attempt in range(seed, seed + 100):
        rng = np.random.default_rng(attempt)
        q = scene.layout.q0 + amount * rng.standard_normal(scene.n)
        v = speed * rng.standard_normal(scene.n)
        if scene.response(q, v)[:, DEPTH].max() > 0.1 * amount:
            return q, v
    raise AssertionError("nothing touches")
