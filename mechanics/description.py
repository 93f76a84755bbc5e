"""Plain data from which a mechanical system is built.

Everything is given in global coordinates of the reference configuration, in SI units and
kelvin. Nothing here computes; ``mechanics.system`` turns it into arrays.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material
from meshes.sections import Section

Array = NDArray[np.float64]
History = Callable[[float], float]

GROUND = None


def _zeros() -> Array:
    return np.zeros(3)


@dataclass(frozen=True)
class Beam:
    """A flexible line body: shear-deformable beam (``beam3243``) or ``cable``.

    Attributes
    ----------
    points : (n, 3) float [m]  reference positions of the nodes
    axes : (n, 3, 3) float  rows are the section triad e1 (tangent), e2, e3 at each node
    section, material : see ``meshes``
    reference_temperature : float [K]  free of thermal strain
    damping_time : float [s]  Kelvin–Voigt time: stress = C (strain + time * strain rate)
    element : name in ``mechanics.elements.FAMILIES``
    velocity, spin : (3,) float [m/s], [rad/s]  initial rigid motion about the origin
    """

    name: str
    points: Array
    axes: Array
    section: Section
    material: Material
    reference_temperature: float
    damping_time: float = 0.0
    element: str = "beam3243"
    velocity: Array = field(default_factory=_zeros)
    spin: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class Particle:
    """A point mass [kg] with three coordinates."""

    name: str
    position: Array
    mass: float
    velocity: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class Site:
    """One end of a joint: a node of a body, or a fixed point when ``body`` is None."""

    body: str | None
    node: int = 0
    position: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class Clamp:
    """Node ``a`` keeps position and orientation relative to ``b``; its section may breathe."""

    name: str
    a: Site
    b: Site


@dataclass(frozen=True)
class Spherical:
    """Points of ``a`` and ``b`` coincide."""

    name: str
    a: Site
    b: Site


@dataclass(frozen=True)
class Revolute:
    """Points coincide; only rotation about ``axis`` is free, or driven by ``angle`` [rad]."""

    name: str
    a: Site
    b: Site
    axis: Array
    angle: History | None = None


@dataclass(frozen=True)
class Distance:
    """Two points keep their reference distance."""

    name: str
    a: Site
    b: Site


@dataclass(frozen=True)
class Guide:
    """Point ``a`` is held along the given fixed ``directions`` only (rows, unit vectors)."""

    name: str
    a: Site
    directions: Array


@dataclass(frozen=True)
class NormalContact:
    """Normal law of a clearance joint.

    stiffness : "hertz-external" (the paper), "hertz-internal" or "linear"
    value : float | None  [N/m^1.5] or [N/m]; None: Hertz from radii and materials
    dissipation : name in ``mechanics.contact.DISSIPATION``
    restitution : float  0 < e <= 1
    reference_speed : float | None [m/s]  None: approach speed detected for each impact
    """

    stiffness: str = "hertz-external"
    value: float | None = None
    dissipation: str = "exact"
    restitution: float = 0.85
    reference_speed: float | None = None


@dataclass(frozen=True)
class Friction:
    """Regularised Coulomb friction with mu(T) = coefficient * (1 + slope (T - reference)).

    T is the mean of journal and bearing temperature.
    """

    coefficient: float
    temperature_slope: float = 0.0
    reference_temperature: float = 298.15
    regularisation_speed: float = 1e-4
    partition: str = "effusivity"


@dataclass(frozen=True)
class ClearanceRevolute:
    """Planar revolute joint with clearance in space.

    The journal centre (node ``journal``) moves inside the bearing circle in the plane normal
    to ``axis``; it is held along the axis and against tilt by constraints. ``angle`` [rad],
    if given, drives the rotation of the journal relative to the bearing.

    radius : float [m]  journal radius
    clearance : float [m]  radial, at the reference temperature
    """

    name: str
    journal: Site
    bearing: Site
    axis: Array
    radius: float
    clearance: float
    journal_material: Material
    bearing_material: Material
    reference_temperature: float
    contact: NormalContact = field(default_factory=NormalContact)
    friction: Friction | None = None
    angle: History | None = None


@dataclass(frozen=True)
class Force:
    """Dead force at a node: ``direction`` (3,) times ``amplitude`` (t) [N]."""

    name: str
    site: Site
    direction: Array
    amplitude: History


@dataclass(frozen=True)
class Moment:
    """Moment fixed in space on the section of a beam node: ``direction`` times amplitude [N m]."""

    name: str
    site: Site
    direction: Array
    amplitude: History


Body = Beam | Particle
Joint = Clamp | Spherical | Revolute | Distance | Guide | ClearanceRevolute
Load = Force | Moment


@dataclass(frozen=True)
class Description:
    """Everything that moves."""

    bodies: Sequence[Body]
    joints: Sequence[Joint] = ()
    loads: Sequence[Load] = ()
    gravity: Array = field(default_factory=_zeros)
