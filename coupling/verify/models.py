"""Small mechanical models that several verification problems share."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechanics.description import Beam, Clamp, Description, Joint, Load, Particle, Site
from mechanics.statics import Equilibrium, equilibrium
from mechanics.system import Coefficients, System
from meshes.generate import line
from meshes.materials import Material, constant_material
from meshes.sections import Section

Array = NDArray[np.float64]

ROOM = 298.15
"""Reference temperature of all verification models [K]."""


class Model(NamedTuple):
    """A system with the coefficients at the reference temperature."""

    system: System
    coef: Coefficients

    def position(self, q: Array, body: str, node: int) -> Array:
        """Position (3,) [m] of a node."""
        return self.vectors(q, body, node)[0]

    def vectors(self, q: Array, body: str, node: int) -> Array:
        """All vectors (k, 3) of a node: r, r_x, r_y, r_z."""
        layout = self.system.layout
        first = layout.node_dofs[body][node]
        return q[first : first + layout.kinds[body]].reshape(-1, 3)


def elastic(
    youngs_modulus: float, poissons_ratio: float = 0.0, density: float = 1.0, expansion: float = 0.0
) -> Material:
    """A material with constant properties; conductivity and heat capacity play no part."""
    return constant_material(
        "verification", density, youngs_modulus, poissons_ratio, expansion, 1.0, 1.0
    )


def straight(
    length: float,
    elements: int,
    section: Section,
    material: Material,
    element: str = "beam3243",
    direction: ArrayLike = (1.0, 0.0, 0.0),
    normal: ArrayLike = (0.0, 1.0, 0.0),
) -> Beam:
    """A straight beam from the origin, named "beam"."""
    end = length * np.asarray(direction, float)
    points, axes = line(np.zeros(3), end, elements, np.asarray(normal, float))
    return Beam("beam", points, axes, section, material, ROOM, element=element)


def model(
    bodies: Beam | Particle | Sequence[Beam | Particle],
    joints: Sequence[Joint] = (),
    loads: Sequence[Load] = (),
    gravity: ArrayLike = (0.0, 0.0, 0.0),
) -> Model:
    """Build a system and its coefficients at the reference temperature."""
    parts = [bodies] if isinstance(bodies, Beam | Particle) else list(bodies)
    system = System(Description(parts, joints, loads, np.asarray(gravity, float)))
    return Model(system, system.coefficients(sections(system)))


def sections(
    system: System, mean: float = ROOM, along_2: float = 0.0, along_3: float = 0.0
) -> Array:
    """Uniform section temperatures (m, 3) [K, K/m, K/m]."""
    return np.tile([mean, along_2, along_3], (len(system.layout.x), 1))


def clamp(node: int = 0) -> Clamp:
    """The node of "beam" clamped to the ground."""
    return Clamp("clamp", Site("beam", node), Site(None))


def bent(made: Model, steps: int = 10, heated: Coefficients | None = None) -> Equilibrium:
    """Static equilibrium; an error if there is none."""
    found = equilibrium(made.system, made.coef, heated or made.coef, steps)
    if found.why:
        raise RuntimeError(found.why)
    return found
