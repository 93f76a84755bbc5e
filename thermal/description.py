"""Plain data from which a thermal model is built (SI units, kelvin)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property
from meshes.mesh import Mesh
from meshes.sections import Section
from meshes.surfaces import Surface

Array = NDArray[np.float64]
History = Callable[[float], float]


@dataclass(frozen=True)
class Member:
    """A line of material with a section that may carry a temperature profile.

    points : (n, 3) float [m]  stations
    axes : (n, 3, 3) float  rows e1 (tangent), e2, e3 of the section at each station
    wall_points : int  temperatures per station: 1 (mean only); of a tube an even number >= 4
        spread over the circumference, the first on +e2, counted towards e3; of another section 3,
        which carry mean and two gradients
    initial : float [K]

    Its faces are "outer", of a tube "inner", and the end sections "start" and "end".
    """

    name: str
    points: Array
    axes: Array
    section: Section
    material: Material
    wall_points: int
    initial: float


@dataclass(frozen=True)
class Sheet:
    """A shell with a temperature on each of its two faces, and linear in between.

    surface : middle surface with its nodes; its normal is d_u x d_v
    thickness, initial : float [m], [K]

    Its faces are "top", on the side of the normal, and "bottom".
    """

    name: str
    surface: Surface
    thickness: float
    material: Material
    initial: float


@dataclass(frozen=True)
class Part:
    """A lump with one temperature, such as a journal or a bearing.

    mass : float [kg]
    area : float [m^2]  of its face "outer"; 0: it has none
    """

    name: str
    position: Array
    material: Material
    mass: float
    initial: float
    area: float = 0.0


@dataclass(frozen=True)
class Solid:
    """A body of any shape with a temperature at each node of its mesh.

    mesh : cells of one or more of the families tetra, tetra10, hexahedron, hexahedron20,
        hexahedron27; named regions of volume cells, and of triangles and quads on its boundary
    materials : region of volume cells -> Material; "" is what no other region has
    initial : float [K]
    axes : (3, 3) float | None  rows: directions along, around and through, of conductivities that
        differ; None: x, y, z
    rubbing : name of the boundary region on which frictional heat arrives and whose mean
        temperature a joint feels; None: all of the solid

    Its faces are the named regions of its boundary, and "outer", which is all of the boundary
    unless a region has that name.
    """

    name: str
    mesh: Mesh
    materials: Mapping[str, Material]
    initial: float
    axes: Array | None = None
    rubbing: str | None = None


@dataclass(frozen=True)
class Side:
    """A face of a member, sheet, part or solid, such as ``Side("boom", "outer")``."""

    thing: str
    face: str = "outer"


@dataclass(frozen=True)
class Place:
    """A part, an end section of a member ("start", "end"), or a region or face of a solid.

    end : None: all of it
    """

    name: str
    end: str | None = None


@dataclass(frozen=True)
class Link:
    """Conductance between two places, or between a place and a given temperature.

    conductance : float [W/K] | None  None: from outside, under its name, one value (1,)
    law : Property | None  factor of the conductance at the mean of the two temperatures
    radiating : float [m^2]  what sigma (Ta^4 - Tb^4) is multiplied by: area times exchange factor
    """

    name: str
    a: Place
    b: Place | History
    conductance: float | None
    law: Property | None = None
    radiating: float = 0.0


@dataclass(frozen=True)
class Interface:
    """Conductance per area between two faces that lie on one another, such as of two solids.

    coefficient : float [W/(m^2 K)]
    law : Property | None  factor at the mean of the two temperatures
    radiating : float [-]  factor of sigma (Ta^4 - Tb^4) per area
    """

    name: str
    a: Side
    b: Side
    coefficient: float
    law: Property | None = None
    radiating: float = 0.0


@dataclass(frozen=True)
class Wall:
    """Prescribed wall temperature on a stretch of a member, hot on one side, cold on the other.

    Between the two sides the field is linear across the section; a member without wall points
    takes the mean. Histories are given at the two ends of the stretch; between them the
    temperature is linear along the member. All stations on the stretch are held.

    start, end : float [m]  arclength range of the stretch
    side : (3,) float | None  direction of the hot side in the reference configuration; None where
        there is no such side, as hot and cold are the same
    hot, cold : pairs of histories [K], at the start and at the end of the stretch
    """

    name: str
    member: str
    start: float
    end: float
    side: Array | None
    hot: tuple[History, History]
    cold: tuple[History, History]


@dataclass(frozen=True)
class Faces:
    """Prescribed temperatures [K] of a sheet: ``hot`` on the side of its normal, and ``cold``."""

    name: str
    sheet: str
    hot: History
    cold: History


@dataclass(frozen=True)
class Flux:
    """Absorbed heat flux density [W/m^2] on a face.

    body : name of what is heated
    direction : (3,) float | None  parallel rays travelling along ``direction`` (the lit side
        absorbs by the cosine of incidence, the other side nothing); None: uniform. A member
        without wall points absorbs what its shadow takes: of the diameter, or of the rectangle
        of the section's height and width
    """

    name: str
    body: str
    density: History
    direction: Array | None = None
    face: str = "outer"


@dataclass(frozen=True)
class Irradiation:
    """Absorbed heat flux density [W/m^2] on a face, from outside at the points of the face.

    Under its name, (m,) values at the points that the solver lists in ``irradiated``.
    """

    name: str
    body: str
    face: str = "outer"


@dataclass(frozen=True)
class Film:
    """Convection on a face: coefficient [W/(m^2 K)] and temperature of the surroundings [K]."""

    name: str
    body: str
    coefficient: History
    surroundings: History
    face: str = "outer"


@dataclass(frozen=True)
class Radiation:
    """Grey radiation of a face to surroundings at ``sink`` [K].

    emissivity : float | Property  constant, or at the temperature of the face
    """

    name: str
    body: str
    emissivity: float | Property
    sink: History
    face: str = "outer"


@dataclass(frozen=True)
class Enclosure:
    """Grey diffuse faces that see one another, and through openings a sink.

    One face "inner" of a member is a long tube: each station exchanges with itself.

    emissivities : one for each face
    view_factors : (n, n) float | None  from face to face, each of uniform radiosity; what a row
        lacks to one goes to the sink. None: computed between the facets of the faces
    sink : History [K] | None  None: what leaves through openings is lost to 0 K
    """

    name: str
    sides: Sequence[Side]
    emissivities: Sequence[float]
    view_factors: Array | None = None
    sink: History | None = None


@dataclass(frozen=True)
class Fixed:
    """Prescribed temperature [K] of a place.

    Faces of a solid may meet: nodes on their common edge have the temperature of the first.
    """

    name: str
    place: Place
    temperature: History


@dataclass(frozen=True)
class Source:
    """Heat [W] given to a place; to all of a body by volume."""

    name: str
    place: Place
    power: History


@dataclass(frozen=True)
class Field:
    """Prescribed temperatures of a member, sheet or solid: a field T(x, t), such as of a file.

    temperature : takes positions (n, 3) [m] and a time [s], gives (n,) [K]
    """

    name: str
    body: str
    temperature: Callable[[Array, float], Array]


Condition = (
    Wall | Faces | Field | Flux | Irradiation | Film | Radiation | Enclosure | Fixed | Source
)


@dataclass(frozen=True)
class Description:
    """Everything that conducts."""

    members: Sequence[Member] = ()
    parts: Sequence[Part] = ()
    links: Sequence[Link] = ()
    conditions: Sequence[Condition] = ()
    sheets: Sequence[Sheet] = ()
    solids: Sequence[Solid] = ()
    interfaces: Sequence[Interface] = ()


@dataclass(frozen=True)
class Settings:
    """How heat is solved; each solver takes what concerns it.

    tolerance : float [K]  of the estimated error of each step within an interval
    scheme : "sdirk2", "crank-nicolson" or "backward-euler"
    steps : int | None  equal steps of each interval, without error control; None: by tolerance
    linear : "auto", "direct", "multigrid" or "petsc": who solves linear systems
    order : 1 or 2  of the shape functions of walls and solids
    layers : int  elements through a wall, of solids made of members and sheets
    capacity : "lumped", "consistent" or "auto": whether solids store heat at nodes or by integrals;
        "auto": lumped at order 1, lest heat shocks undershoot, and consistent at order 2
    """

    tolerance: float = 1e-3
    scheme: str = "sdirk2"
    steps: int | None = None
    linear: str = "auto"
    order: int = 1
    layers: int = 1
    capacity: str = "auto"


DEFAULT = Settings()
