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
from meshes.surfaces import Surface

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
    modes : vibrations (a multiple of 3), besides six static modes, of linear elasticity in a
        floating frame (``mechanics.floating``); None: the elements as they are
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
    modes: int | None = None


@dataclass(frozen=True)
class FloatingFrame:
    """Frame of a beam with ``modes``, and their amplitudes; layouts make it.

    Attributes
    ----------
    beam : it starts as the first section of it
    amplitudes : number of modes, three in a vector
    """

    name: str
    beam: Beam
    amplitudes: int

    @property
    def velocity(self) -> Array:
        """That of the beam."""
        return self.beam.velocity

    @property
    def spin(self) -> Array:
        """That of the beam."""
        return self.beam.spin


@dataclass(frozen=True)
class Particle:
    """A point mass [kg] with three coordinates."""

    name: str
    position: Array
    mass: float
    velocity: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class RigidBody:
    """A rigid body, described by its centre of mass and three directors (no singularity).

    Attributes
    ----------
    position : (3,) float [m]  centre of mass
    mass : float [kg]
    inertia : (3, 3) float [kg m^2]  about the centre of mass, in global directions at the start
    axes : (3, 3) float  rows e1, e2, e3: body-fixed directions at the start
    velocity, spin : (3,) float [m/s], [rad/s]  of the centre of mass; angular velocity
    """

    name: str
    position: Array
    mass: float
    inertia: Array
    axes: Array = field(default_factory=lambda: np.eye(3))
    velocity: Array = field(default_factory=_zeros)
    spin: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class Shell:
    """A flexible surface.

    Attributes
    ----------
    surface : middle surface with its nodes and parametric derivatives, see ``meshes.surfaces``
    thickness : float [m]
    element : name in ``mechanics.elements.FAMILIES``: "shell48" (thin, Kirchhoff-Love),
        "shell24" (thick, director), "shell3443" (fully parametrised)
    damping_time : float [s]  Kelvin-Voigt time
    velocity, spin : (3,) float [m/s], [rad/s]  initial rigid motion about the origin
    """

    name: str
    surface: Surface
    thickness: float
    material: Material
    reference_temperature: float
    damping_time: float = 0.0
    element: str = "shell48"
    velocity: Array = field(default_factory=_zeros)
    spin: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class Continuum:
    """A solid body in three dimensions; its nodes carry a position, and a temperature each.

    Attributes
    ----------
    points : (n, 3) float [m]  reference positions of the nodes
    cells : (n_c, k) int  nodes of each cell, numbered as in ``meshes.families``
    reference_temperature : float [K]  free of thermal strain
    element : name in ``mechanics.elements.FAMILIES``: "hexahedron20" (reduced quadrature),
        "hexahedron20-full", "hexahedron27"
    damping_time : float [s]  Kelvin-Voigt time
    velocity, spin : (3,) float [m/s], [rad/s]  initial rigid motion about the origin
    """

    name: str
    points: Array
    cells: NDArray[np.intp]
    material: Material
    reference_temperature: float
    element: str = "hexahedron20"
    damping_time: float = 0.0
    velocity: Array = field(default_factory=_zeros)
    spin: Array = field(default_factory=_zeros)


@dataclass(frozen=True)
class ReferencePoint:
    """A place of a solid body with a position and an orientation, for joints, loads and springs.

    It is the mean of a face: r its mean position, r_y and r_z the plane that fits it best. What
    acts on it spreads over the face, which swells and warps freely.

    Attributes
    ----------
    body : name of a ``Continuum``
    nodes : (k,) int  of the face
    weights : (k,) float [m^2]  area that belongs to each; used where the nodes make no whole face
        of a cell, over which the mean is taken otherwise
    axes : (3, 3) float  rows e1 (normal to the face), e2, e3
    points : (k, 3) float [m]  reference positions of the nodes; None: as the body has them
    shares : (3, k) float  of the nodes in r, r_y [1/m] and r_z [1/m]; None: by the face
    velocity, spin : None: those of the body
    """

    name: str
    body: str
    nodes: NDArray[np.intp]
    weights: Array
    axes: Array
    points: Array | None = None
    shares: Array | None = None
    velocity: Array | None = None
    spin: Array | None = None


@dataclass(frozen=True)
class Site:
    """One end of a joint: a material point of a body, or a fixed point when ``body`` is None.

    Attributes
    ----------
    node : int  node of the body; negative counts from the end
    fraction : float  0 <= fraction < 1  how far towards the next node of a line body
    offset : (3,) float [m]  from there, along e1, e2, e3 of the reference triad
    position : (3,) float [m]  of a point of the ground
    """

    body: str | None
    node: int = 0
    position: Array = field(default_factory=_zeros)
    fraction: float = 0.0
    offset: Array = field(default_factory=_zeros)


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
class Universal:
    """Points coincide; ``axis_a`` (fixed in a) stays normal to ``axis_b`` (fixed in b)."""

    name: str
    a: Site
    b: Site
    axis_a: Array
    axis_b: Array


@dataclass(frozen=True)
class Cylindrical:
    """``a`` slides along and turns about an axis of ``b``; each may be driven."""

    name: str
    a: Site
    b: Site
    axis: Array
    angle: History | None = None
    travel: History | None = None


@dataclass(frozen=True)
class Prismatic:
    """``a`` slides along an axis of ``b`` without turning; ``travel`` [m] drives it."""

    name: str
    a: Site
    b: Site
    axis: Array
    travel: History | None = None


@dataclass(frozen=True)
class Planar:
    """``a`` moves in the plane of ``b`` with the given ``normal`` and turns about it."""

    name: str
    a: Site
    b: Site
    normal: Array


@dataclass(frozen=True)
class AxialDrive:
    """Way of point ``a`` along an axis that turns with ``b``: held, or driven by ``travel`` [m].

    What a lead screw does for a boom section: all else of ``a``, also its tilt, stays free.
    """

    name: str
    a: Site
    b: Site
    axis: Array
    travel: History | None = None


@dataclass(frozen=True)
class Distance:
    """Two points keep their reference distance, or follow ``length`` [m], counted from it."""

    name: str
    a: Site
    b: Site
    length: History | None = None


@dataclass(frozen=True)
class Sliding:
    """Point ``a`` slides along the axis of the flexible line body ``body``.

    Its place on the axis is a coordinate of its own: arc length [m] from the first node, at the
    start that of the point nearest to ``a``.

    aligned : bool  a section of ``a`` also keeps the orientation of the section it passes
    travel : drives the arc length [m], counted from the start
    """

    name: str
    a: Site
    body: str
    aligned: bool = False
    travel: History | None = None


@dataclass(frozen=True)
class Gear:
    """Turns of two revolute or cylindrical joints: turn(second) = ratio * turn(first).

    Turns count from the reference, over any number of revolutions.
    """

    name: str
    first: str
    second: str
    ratio: float


@dataclass(frozen=True)
class Pulley:
    """A rope over pulleys of no size: the length of its path through ``points`` is constant.

    stiffness : float [N] | None  axial stiffness EA of the rope (no compression); None:
        inextensible, and held tight
    damping : float [N s]  with a stiffness: per relative rate of length
    length : float [m] | None  free of force; None: as it is in the reference
    winch : rope paid out [m] over time
    """

    name: str
    points: Sequence[Site]
    stiffness: float | None = None
    damping: float = 0.0
    length: float | None = None
    winch: History | None = None


@dataclass(frozen=True)
class Latch:
    """Locks the turn of a revolute, or the travel of a prismatic joint, once it reaches ``at``.

    joint : name of that joint;  at : float [rad] or [m], counted from the reference
    """

    name: str
    joint: str
    at: float


@dataclass(frozen=True)
class Spring:
    """Spring, damper and actuator along the line between two points.

    stiffness : float [N/m];  damping : float [N s/m]
    length : float [m] | None  free of force; None: as it is in the reference
    preload : float [N]  tension in the reference, added
    force : tension [N] of an actuator over time, added
    """

    name: str
    a: Site
    b: Site
    stiffness: float = 0.0
    damping: float = 0.0
    length: float | None = None
    preload: float = 0.0
    force: History | None = None


@dataclass(frozen=True)
class TorsionSpring:
    """Spring, damper and motor on the turn of a revolute or cylindrical joint ``joint``.

    stiffness : float [N m/rad];  damping : float [N m s/rad]
    angle : float [rad]  free of moment, counted from the reference
    preload : float [N m]  moment that drives the turn, at the reference, added
    torque : moment [N m] that drives the turn, over time, added
    """

    name: str
    joint: str
    stiffness: float = 0.0
    damping: float = 0.0
    angle: float = 0.0
    preload: float = 0.0
    torque: History | None = None


@dataclass(frozen=True)
class Bushing:
    """Elastic connection of two sections that coincide in the reference.

    axes : (3, 3) float  rows: directions of ``b`` in the reference
    stiffness : (6,) float [N/m] three times, [N m/rad] three times, along and about ``axes``
    damping : (6,) float [N s/m], [N m s/rad]
    """

    name: str
    a: Site
    b: Site
    axes: Array
    stiffness: Array
    damping: Array


@dataclass(frozen=True)
class Guide:
    """Point ``a`` is held along the given fixed ``directions`` only (rows, unit vectors)."""

    name: str
    a: Site
    directions: Array


@dataclass(frozen=True)
class Fixing:
    """A vector of a node keeps its reference value along fixed directions.

    For planes of symmetry and clamped slopes, most of all of shells.

    vector : its name in ``mechanics.elements.FAMILIES``, or "position"
    directions : (k, 3) float  rows, unit vectors
    """

    name: str
    body: str
    node: int
    vector: str
    directions: Array


@dataclass(frozen=True)
class NormalContact:
    """Normal law of a joint with clearance, F = F_e(delta) (1 + D delta'/v).

    Attributes
    ----------
    stiffness : name in ``mechanics.contact.STIFFNESS``: "hertz-external" (Hua et al. 2026),
        "hertz-internal", "cylinder" (conformal, Johnson) or "linear"
    value : float | None  [N/m^1.5] or [N/m], of the whole joint; None: from radii and materials
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
    """Friction of a joint with clearance; T is the mean of journal and bearing temperature.

    Attributes
    ----------
    coefficient : kinetic coefficient at the reference temperature
    law : name in ``mechanics.contact.FRICTION``: "regularised" Coulomb, Coulomb with true "stick",
        "stribeck" (regularised), "lugre", "rising" (stick whose bound grows with its duration)
    static_coefficient : float | None  None: as the kinetic one
    temperature_slope : float [1/K]  mu(T) = mu (1 + slope (T - reference)), both coefficients
    table : ((T [K], factor), ...)  instead of the slope: both coefficients times a factor, linear
        between, constant beyond
    regularisation_speed : float [m/s]  of laws without stick: slip speed with half of the friction
    stribeck_speed : float [m/s];  viscous : float [s/m]  viscous part over normal force
    presliding : float [m]  of laws with bristles: deflection at which mu_s F is reached
    bristle_damping : float [s/m]  over normal force
    rise_rate : float [1/s^m];  rise_exponent : m of the bound after sticking for tau,
        mu_s(tau) = mu_s - (mu_s - mu_k) exp(-rate tau^m)
    partition : name in ``mechanics.contact.PARTITION``
    """

    coefficient: float
    temperature_slope: float = 0.0
    reference_temperature: float = 298.15
    regularisation_speed: float = 1e-4
    partition: str = "effusivity"
    law: str = "regularised"
    static_coefficient: float | None = None
    table: Sequence[tuple[float, float]] | None = None
    stribeck_speed: float = 1e-3
    viscous: float = 0.0
    presliding: float = 1e-7
    bristle_damping: float = 0.0
    rise_rate: float = 0.570
    rise_exponent: float = 0.629


@dataclass(frozen=True)
class ClearanceRevolute:
    """Revolute joint with clearance: a pin (journal) in a bore (bearing).

    Without a ``length`` it is planar: the centre of the journal moves inside the bearing circle in
    the plane normal to ``axis``; it is held along the axis and against tilt by constraints. With a
    length nothing is held: the pin touches at both ends of the bore, tilts, and is stopped along
    the axis by two flanges, where ``axial_clearance`` says how far away they are.
    ``angle`` [rad], if given, drives the rotation of the journal relative to the bearing.

    radius : float [m]  journal radius
    clearance : float [m]  radial, at the reference temperature
    length : float [m] | None  of the bore
    axial_clearance : float [m] | None  of each flange; None: free along the axis
    flange_radius : float [m] | None  where flanges touch; None: 1.5 radii
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
    length: float | None = None
    axial_clearance: float | None = None
    flange_radius: float | None = None


@dataclass(frozen=True)
class ClearanceSpherical:
    """A ball (journal) in a socket (bearing) that is a little wider.

    radius : float [m]  of the ball;  clearance : float [m]  radial
    """

    name: str
    journal: Site
    bearing: Site
    radius: float
    clearance: float
    journal_material: Material
    bearing_material: Material
    reference_temperature: float
    contact: NormalContact = field(default_factory=NormalContact)
    friction: Friction | None = None


@dataclass(frozen=True)
class ClearanceCylindrical:
    """A rod (journal) in a bush (bearing): it touches at both ends of the bush, slides and turns.

    radius : float [m]  of the rod;  clearance : float [m]  radial;  length : float [m]  of the bush
    """

    name: str
    journal: Site
    bearing: Site
    axis: Array
    radius: float
    clearance: float
    length: float
    journal_material: Material
    bearing_material: Material
    reference_temperature: float
    contact: NormalContact = field(default_factory=NormalContact)
    friction: Friction | None = None


@dataclass(frozen=True)
class ClearanceTranslational:
    """A slider (journal) between the walls of a guide (bearing); its corners touch them.

    Without a ``width`` it is planar: constraints hold the slider in the plane of ``axis`` and
    ``normal``, and four corners can touch two walls. With a width, eight corners can touch four
    walls, and nothing is held.

    axis : (3,) float  of the guide;  normal : (3,) float  of the walls across the height
    length, height, width : float [m]  of the slider
    clearance : float [m]  at each wall, at the reference temperature
    corner_radius : float [m] | None  of rounded corners, for Hertz stiffness
    """

    name: str
    journal: Site
    bearing: Site
    axis: Array
    normal: Array
    length: float
    height: float
    clearance: float
    journal_material: Material
    bearing_material: Material
    reference_temperature: float
    contact: NormalContact = field(default_factory=NormalContact)
    friction: Friction | None = None
    width: float | None = None
    corner_radius: float | None = None


@dataclass(frozen=True)
class Preload:
    """Sprung rollers or pads all around, at the mouth and at the end of the inner tube inside.

    force : [N]  sum of what the pads of one ring press with, both tubes concentric, as made
    stiffness : [N/m]  of one ring sideways: half of the sum of those of its pads
    """

    force: float
    stiffness: float


@dataclass(frozen=True)
class Telescope:
    """A tube (``inner``) in a tube (``outer``) with clearance; both bend, contact travels.

    The inner tube can touch at its nodes and the given number of stations between them, where they
    are inside the outer one, and at the mouth of the outer tube.

    inner, outer : names of beams;  mouth : "start" or "end" of the outer one
    radius : float [m]  outer radius of the inner tube;  clearance : float [m]  radial
    stations : of contact in each element of the inner tube, its nodes aside
    preload : None: no pads but the walls
    """

    name: str
    inner: str
    outer: str
    radius: float
    clearance: float
    reference_temperature: float
    mouth: str = "end"
    stations: int = 0
    contact: NormalContact = field(default_factory=NormalContact)
    friction: Friction | None = None
    preload: Preload | None = None


@dataclass(frozen=True)
class BoreContact:
    """A pin (an analytic cylinder that ``pin`` carries) in the bore of a solid body, with friction.

    Pressure at the surface of the bore is stiffness times depth, with the hysteresis of the impact
    that runs; the bore grows with its own temperatures, the pin with one of its own.

    Attributes
    ----------
    body : name of a ``Continuum``;  facets : (n_f, 8 or 9) int  nodes of the surface of its bore
    pin : through which the axis goes, in the middle of the pin, and with which it turns
    axis : (3,) float  of the pin in the reference
    pin_radius : float [m]  at the reference temperature
    stiffness : float [N/m^3]  pressure per depth
    length : float [m] | None  of the pin, whose rims are round; None: endless
    restitution, dissipation, reference_speed : as in ``NormalContact``
    """

    name: str
    body: str
    facets: NDArray[np.intp]
    pin: Site
    axis: Array
    pin_radius: float
    stiffness: float
    journal_material: Material
    bearing_material: Material
    reference_temperature: float
    length: float | None = None
    friction: Friction | None = None
    restitution: float = 0.85
    dissipation: str = "exact"
    reference_speed: float | None = None


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


@dataclass(frozen=True)
class Torque:
    """Moment ``direction`` times ``amplitude`` [N m] on ``a``, and its reaction on ``b``.

    The direction is fixed in ``b``.
    """

    name: str
    a: Site
    b: Site
    direction: Array
    amplitude: History


@dataclass(frozen=True)
class Traction:
    """Dead load on a shell or a face of a solid, per reference area, or per length of an edge.

    direction : (3,) float;  amplitude : over time [N/m^2], or [N/m] on an edge
    edge : nodes of a shell one after the other along grid lines; None: all of the surface
    faces : (n_f, 8 or 9) int  nodes of faces of a solid, numbered as in ``meshes.families``
    """

    name: str
    body: str
    direction: Array
    amplitude: History
    edge: Sequence[int] | None = None
    faces: NDArray[np.intp] | None = None


Body = Beam | Particle | RigidBody | Shell | Continuum | ReferencePoint | FloatingFrame
Flexible = Beam | Shell | Continuum
Joint = (
    Clamp | Spherical | Universal | Revolute | Cylindrical | Prismatic | Planar | Distance | Guide
    | Fixing | Sliding | AxialDrive | Gear | Pulley | Latch | Spring | TorsionSpring | Bushing
    | ClearanceRevolute | ClearanceSpherical | ClearanceCylindrical | ClearanceTranslational
    | Telescope | BoreContact
)  # fmt: skip
Clearance = (
    ClearanceRevolute | ClearanceSpherical | ClearanceCylindrical | ClearanceTranslational
)  # fmt: skip
"""Joints of a journal in a bearing, each of which has a temperature of its own."""
Load = Force | Moment | Torque | Traction


@dataclass(frozen=True)
class Description:
    """Everything that moves.

    Attributes
    ----------
    rayleigh : damping C = first [1/s] M + second [s] K of flexible bodies, K in the reference; it
        damps rigid motion as well and is not objective (Hua et al. 2026); None: no such damping
    heavy_when_cold : bool  mass follows the density law of the materials, window by window
    """

    bodies: Sequence[Body]
    joints: Sequence[Joint] = ()
    loads: Sequence[Load] = ()
    gravity: Array = field(default_factory=_zeros)
    rayleigh: tuple[float, float] | None = None
    heavy_when_cold: bool = False
