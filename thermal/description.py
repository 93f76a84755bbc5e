"""Plain data from which a thermal model is built (SI units, kelvin)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material
from meshes.sections import Section
from meshes.surfaces import Surface

Array = NDArray[np.float64]
History = Callable[[float], float]


@dataclass(frozen=True)
class Member:
    """A line of material with a section that may carry a temperature profile.

    points : (n, 3) float [m]  stations
    axes : (n, 3, 3) float  rows e1 (tangent), e2, e3 of the section at each station
    wall_points : int  temperatures per station: 1 (mean only) or an even number >= 4 spread
        over the circumference, the first on +e2, counted towards e3
    initial : float [K]
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
    """

    name: str
    surface: Surface
    thickness: float
    material: Material
    initial: float


@dataclass(frozen=True)
class Part:
    """A lump with one temperature, such as a journal or a bearing. ``mass`` [kg]."""

    name: str
    position: Array
    material: Material
    mass: float
    initial: float


@dataclass(frozen=True)
class Place:
    """Where a link attaches: a part (``end`` None) or the start or end section of a member."""

    name: str
    end: str | None = None


@dataclass(frozen=True)
class Link:
    """Conductance [W/K] between two places, or between a place and a given temperature."""

    name: str
    a: Place
    b: Place | History
    conductance: float


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
    """Absorbed heat flux density [W/m^2] on the outer face of a member.

    direction : (3,) float | None  parallel rays travelling along ``direction`` (the lit side
        absorbs by the cosine of incidence, the other side nothing); None: uniform. A member
        without wall points absorbs what its shadow takes: of the diameter, or of the rectangle
        of the section's height and width
    """

    name: str
    member: str
    density: History
    direction: Array | None = None


@dataclass(frozen=True)
class Radiation:
    """Grey radiation of the outer face of a member to surroundings at ``sink`` [K]."""

    name: str
    member: str
    emissivity: float
    sink: History


@dataclass(frozen=True)
class Fixed:
    """Prescribed temperature [K] of a part or of one end section of a member."""

    name: str
    place: Place
    temperature: History


@dataclass(frozen=True)
class Source:
    """Heat [W] given to a part or to one end section of a member."""

    name: str
    place: Place
    power: History


Condition = Wall | Faces | Flux | Radiation | Fixed | Source


@dataclass(frozen=True)
class Description:
    """Everything that conducts."""

    members: Sequence[Member]
    parts: Sequence[Part] = ()
    links: Sequence[Link] = ()
    conditions: Sequence[Condition] = ()
    sheets: Sequence[Sheet] = ()
