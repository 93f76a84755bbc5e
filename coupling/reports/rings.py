"""The ring truss of the case ``ring_truss``, built for measuring."""

from coupling.rings import ring_description
from mechanics.system import System
from meshes.materials import library_material
from meshes.sections import tube
from meshes.truss import LEVELS, Truss, ring_truss

FITTING = 0.3
DAMPING = 1e-3
STEP = 1e-3
"""Length of the hinge element [m], Kelvin-Voigt time [s], step of the measurements [s]."""


def section():
    """Tube of the members."""
    return tube(0.05, 0.001, 0.33)


def truss(elements: int = LEVELS[3]) -> Truss:
    """The ring with this many elements in the span of a member."""
    return ring_truss(elements=elements, fitting=FITTING)


def ring(elements: int = LEVELS[3], solver: str = "auto") -> System:
    """The system of the ring."""
    material = library_material("al6061-paper")
    return System(ring_description(truss(elements), section(), material, DAMPING), solver)
