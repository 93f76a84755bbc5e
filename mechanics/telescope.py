"""A tube in a tube: both bend, slide and turn in one another, and touch where they like.

Contact is looked for at stations: nodes of the inner tube and places between them against the
axis of the outer tube, and the mouth of the outer tube against the axis of the inner one. A station
has its foot, the nearest point, wherever on that axis it is at the moment; axes are cubics whose
tangent has no jump from element to element, and so has the force. A station acts where its foot is
on the other tube. Rims are round (radius ``RIM``): beyond an end the bore widens with the square of
the distance, so that a station that comes or goes under load loses it steadily, without a loss of
energy. ``mechanics.telescope_kernels`` has the forces.

Normal laws hold for each station; that of a cylinder in a bore (Johnson 1985, sec. 5.6) is one of
a line contact: a station has π E* times its tributary length, the mouth that of half the mean
distance of stations. It knows two half-spaces, pressed in by δ = F/(π E* L) (ln(P/F) - 1), and
leaves out that walls are thin. A tube of radius R and wall t that is pressed at one place ovalises
by 6.5 F/(E t) (R/t)^1.5 (L/R)^-0.75 (Young & Budynas 2002, table 13.3): with R = 0.27 m, t = 2 mm
and L = 65.5 m of aluminium 1.2 um/N, against 1e-4 um/N by the law of the cylinder for 100 N on a
metre with 0.1 mm of clearance. Where that matters, give such a stiffness to a linear law.

Pads or rollers of a preload are a ring of many springs. While all touch, their sum N0 does not
depend on where the tube is, and sideways they are a spring of stiffness K; as a contact with
N² = N0² + (K D)², force K D towards the middle and friction up to μ N, without a moment about the
axis. Thermal strain changes the clearance c, and so what they press with, N0 + 2 K (c0 - c).

Friction, slip and bristles are measured along the axes of the outer section: along the tube and
twice across it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import contact
from mechanics import telescope_kernels as kernels
from mechanics.contact_laws import (
    ACTIVE,
    BRISTLE,
    CENTRE,
    CLEARANCE,
    CORE,
    FRICTION,
    KINETIC,
    LAW,
    RADIUS,
    SLOT,
    STATIC,
    K,
)
from mechanics.description import Beam, NormalContact, Telescope
from mechanics.elements import FAMILIES
from mechanics.layout import Layout, family_of
from mechanics.line_elements import node_places
from mechanics.march import PLACE
from mechanics.telescope_kernels import (
    BAND,
    LENGTHS,
    OWN,
    PLACED,
    RIM,
    SIGN,
    VECTORS,
    WEIGHTS,
    WIDE,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ROUNDING = 0.1
"""Radius of the rims of both tubes, in radii of the inner one [-]."""
FEW, WIDTH = 4, 2
"""Elements up to which a tube is known to all stations as a whole, and of a band otherwise [-]."""
GRAIN = 0.25
"""How far a tube moves before bands are looked at anew, in its shortest element: with a width of
two elements a foot may go as far again before it leaves its band [-]."""
NOWHERE = -(2**40)
"""First element of an empty band."""
_PLACED = [CLEARANCE, K, KINETIC, STATIC, BRISTLE]


class Tube(NamedTuple):
    """One of the tubes of a joint.

    nodes : (n,) int  first coordinates;  points : (n,) int  rows of the temperature array
    lengths : (n,) float [m]  arc length at the nodes
    """

    body: Beam
    nodes: Indices
    points: Indices
    lengths: Array

    def weights(self, s: float) -> tuple[int, float]:
        """Element of an arc length, and the weight of its second node."""
        last = len(self.lengths) - 2
        e = min(max(int(np.searchsorted(self.lengths, s, side="right")) - 1, 0), last)
        part = (s - self.lengths[e]) / (self.lengths[e + 1] - self.lengths[e])
        return e, float(min(max(part, 0.0), 1.0))

    def at(self, values: Array, s: float) -> float:
        """Values (n,) at the nodes, linear between them."""
        return float(np.interp(s, self.lengths, values))


class Station(NamedTuple):
    """A section of one tube that may touch the other.

    sign : 1 of the inner tube, -1 of the outer one;  node, fraction : where
    length : [m]  of its own tube that is its part;  pads : whether it is a ring of sprung pads
    """

    joint: Telescope
    label: str
    own: Tube
    other: Tube
    sign: float
    node: int
    fraction: float = 0.0
    length: float = 0.0
    pads: bool = False

    @property
    def kind(self) -> tuple[str, float, bool]:
        """What stations have in common that are looked at together."""
        return self.joint.name, self.sign, self.pads

    @property
    def place(self) -> float:
        """Arc length [m] of the section."""
        s = self.own.lengths
        if not self.fraction:
            return float(s[self.node])
        return float(s[self.node] + self.fraction * (s[self.node + 1] - s[self.node]))

    def vectors(self) -> tuple[Indices, Array]:
        """(k,) int first coordinates and (4, k) weights of p, p', p_y, p_z, k = 4 or 8."""
        if not self.fraction:
            return self.own.nodes[self.node] + 3 * np.arange(4), np.eye(4)
        a, b = self.own.lengths[self.node : self.node + 2]
        hermite, weights = np.empty((3, 4)), np.zeros((4, 8))
        kernels.axis_weights(self.place, float(a), float(b), hermite)
        weights[:2, [0, 1, 4, 5]] = hermite[:2]
        weights[[2, 3], [2, 3]], weights[[2, 3], [6, 7]] = 1.0 - self.fraction, self.fraction
        nodes = self.own.nodes[self.node : self.node + 2]
        return (nodes[:, None] + 3 * np.arange(4)).ravel(), weights

    def tubes(self) -> tuple[Tube, Tube]:
        """Inner and outer tube."""
        return (self.own, self.other) if self.sign > 0.0 else (self.other, self.own)


@dataclass(frozen=True, eq=False)
class Telescopes:
    """All telescopes of a system as one term with an element for each station.

    Attributes
    ----------
    names : joint of each station;  contact_names : such as ``sleeve.node_03``, ``sleeve.mouth``
    dofs : (E, k) int  coordinates of the own section and positions of the other tube; -1: none
    pattern_dofs : (E2, k2) int  of each station with each element of its band on the other tube,
        in which its tangent may be; rows of its ``slots``
    band : the bands, as ``bands`` gives them
    places : (E,) float [m]  feet in the reference
    slots : contacts of an element
    """

    stations: list[Station]
    dofs: Indices
    pattern_dofs: Indices
    ints: NDArray[np.int64]
    floats: Array
    places: Array
    band: bytes
    name: str = "telescope"
    symmetric: bool = False
    slots: int = 1
    labels: list[str] = field(default_factory=lambda: [""])
    force: int = kernels.add_force
    tangent: int = kernels.add_tangent
    energy: int = kernels.add_energy
    respond: int = kernels.respond
    remember: int = kernels.remember

    @property
    def names(self) -> list[str]:
        """Joint of each station."""
        return [station.joint.name for station in self.stations]

    @property
    def contact_names(self) -> list[str]:
        """Name of each station."""
        return [f"{station.joint.name}.{station.label}" for station in self.stations]

    def coefficients(self, T: Array) -> Array:
        """(E, SLOT + 5 N) columns of ``contact_laws``, then those that follow the place.

        T : (m, 3) float [K]  section temperatures
        """
        found = np.zeros((len(self.stations), SLOT + PLACED * (self.floats.shape[1] - LENGTHS)))
        start = 0
        for _, group in groupby(self.stations, key=lambda s: s.kind):
            stations = list(group)
            values = _coefficients(stations, T[:, 0])
            rows = slice(start, start + len(stations))
            last = SLOT + PLACED * values.shape[1]
            found[rows, SLOT:last] = values[:, :, _PLACED].reshape(len(stations), -1)
            for row, value, s in zip(found[rows], values, self.places[rows], strict=True):
                e, part = stations[0].other.weights(s)
                row[:SLOT] = (1.0 - part) * value[e] + part * value[e + 1]
            start += len(stations)
        return found

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The coefficients as they are: contacts have no free strains."""
        return c0, c1

    def masses(self, mass: csr_array) -> Array:
        """(E,) [kg]  what meets in an impact: reduced mass of both points in the reference."""
        diagonal = mass.diagonal()
        each = zip(self.stations, self.places, strict=True)
        return np.array([1.0 / _mobility(station, place, diagonal) for station, place in each])

    def bands(self, q: Array) -> bytes:
        """First element of the band of each station in the state ``q``, as bytes."""
        feet = kernels.feet(q, self.ints, self.floats)[:, 0]
        return _bands(self.stations, self.places, feet).tobytes()

    def banded(self, band: bytes) -> "Telescopes":
        """The same contacts with other bands."""
        if band == self.band:
            return self
        ints = self.ints.copy()
        ints[:, BAND] = np.frombuffer(band, np.int64)
        return replace(self, ints=ints, band=band, pattern_dofs=_pattern_dofs(self.stations, ints))

    def deposit(self, T: Array, work: Array, response: Array) -> Array:
        """(m,) float [J]  heat at the temperature points from ``work`` (E,) [J] of friction.

        It is shared by the tubes as their materials at the station demand, and by the nodes about
        the station with linear weights.
        """
        heat = np.zeros(len(T))
        for station, done, place in zip(self.stations, work, response[:, PLACE], strict=True):
            shares = _partition(station, float(place), T[:, 0])
            places = (station.place, float(place))
            for tube, s, share in zip((station.own, station.other), places, shares, strict=True):
                e, part = tube.weights(s)
                heat[tube.points[e]] += (1.0 - part) * share * done
                heat[tube.points[e + 1]] += part * share * done
        return heat


# --------------------------------------------------------------------------------- making the term


def build(joints: Sequence[Telescope], layout: Layout) -> list[Telescopes]:
    """The term of all telescopes; one that cannot be made is a ``ValueError``."""
    stations = []
    for joint in joints:
        try:
            stations += _stations(joint, layout)
        except ValueError as problem:
            raise ValueError(f"joint {joint.name!r}: {problem}") from None
    own = [station.vectors() for station in stations]
    room, nodes = max(v.size for v, _ in own), max(len(s.other.nodes) for s in stations)
    ints = np.full((len(stations), OWN + room), -1, dtype=np.int64)
    floats = np.zeros((len(stations), LENGTHS + nodes))
    pair = 0
    for i, (station, (vectors, weights)) in enumerate(zip(stations, own, strict=True)):
        other = station.other
        stride = other.nodes[1] - other.nodes[0]
        wide = _width(other)
        ints[i, :OWN] = vectors.size, other.nodes[0], stride, len(other.nodes), pair, 0, wide
        ints[i, OWN : OWN + vectors.size] = vectors
        floats[i, [SIGN, RIM]] = station.sign, ROUNDING * station.joint.radius
        spread = floats[i, WEIGHTS:LENGTHS].reshape(4, VECTORS)
        spread[:, : vectors.size] = weights
        floats[i, LENGTHS : LENGTHS + len(other.nodes)] = other.lengths
        pair += wide
    feet = kernels.feet(layout.q0, ints, floats)
    _check_inside(stations, feet)
    dofs = _coordinates(stations, ints[:, OWN:], nodes)
    places = feet[:, 0].copy()
    bands = _bands(stations, places, places)
    ints[:, BAND] = bands
    pattern = _pattern_dofs(stations, ints)
    return [Telescopes(stations, dofs, pattern, ints, floats, places, bands.tobytes())]


def _stations(joint: Telescope, layout: Layout) -> list[Station]:
    _check(joint)
    inner, outer = _tube(joint.inner, layout), _tube(joint.outer, layout)
    if joint.inner == joint.outer:
        raise ValueError("a tube does not slide in itself")
    share = np.diff(inner.lengths) / (joint.stations + 1)
    halves = 0.5 * (np.append(share, 0.0) + np.append(0.0, share))
    along = [
        Station(joint, f"node_{node:02d}", inner, outer, 1.0, node, length=float(halves[node]))
        for node in range(len(inner.nodes))
    ]
    between = [
        Station(
            joint, f"station_{e:02d}_{k}", inner, outer, 1.0, e, k / (joint.stations + 1),
            float(share[e]),
        )
        for e in range(len(inner.nodes) - 1)
        for k in range(1, joint.stations + 1)
    ]  # fmt: skip
    end = 0 if joint.mouth == "start" else len(outer.nodes) - 1
    rim = Station(joint, "mouth", outer, inner, -1.0, end, length=0.5 * float(share.mean()))
    pads = [] if joint.preload is None else _pads(rim, _heel(inner, outer, end))
    return [*along, *between, rim, *pads]


def _heel(inner: Tube, outer: Tube, end: int) -> int:
    """Node at the end of the inner tube that is nearer to the bottom of the outer one."""
    ends = 0, len(inner.nodes) - 1
    bottom = outer.body.points[-1 if end == 0 else 0]
    return min(ends, key=lambda node: float(np.linalg.norm(inner.body.points[node] - bottom)))


def _pads(rim: Station, heel: int) -> list[Station]:
    """Rings of pads at the mouth and at the inner end of the inner tube."""
    inner = Station(rim.joint, "heel_pads", rim.other, rim.own, 1.0, heel, pads=True)
    return [rim._replace(label="mouth_pads", pads=True), inner]


def _tube(name: str, layout: Layout) -> Tube:
    body = layout.bodies.get(name)
    if body is None:
        raise ValueError(f"there is no body {name!r}")
    if not isinstance(body, Beam) or family_of(body).vectors != FAMILIES["beam3243"].vectors:
        raise ValueError(f"{name!r} is no beam whose nodes have a position, r_x, r_y and r_z")
    lengths = node_places(body.points, body.axes)
    return Tube(body, layout.node_dofs[name], layout.point_index[name], lengths)


def _check(joint: Telescope) -> None:
    law, friction = joint.contact, joint.friction
    if joint.mouth not in ("start", "end"):
        raise ValueError(f"the mouth is at 'start' or 'end', not {joint.mouth!r}")
    if not (joint.radius > 0.0 and joint.clearance > 0.0 and joint.stations >= 0):
        raise ValueError("radius and clearance are positive, the number of stations not negative")
    if why := contact.refusal(law, friction):
        raise ValueError(why)
    pads = joint.preload
    if pads is not None and not (pads.force > 0.0 and pads.stiffness > 0.0):
        raise ValueError("force and stiffness of a preload are positive")


def _check_inside(stations: Sequence[Station], feet: Array) -> None:
    """In the reference, what is between the ends of a tube is inside it."""
    for station, (s, distance) in zip(stations, feet, strict=True):
        between = 0.0 <= s <= station.other.lengths[-1]
        if between and distance > station.joint.radius + station.joint.clearance:
            name, inner, outer = station.joint.name, station.joint.inner, station.joint.outer
            where = f"{distance:.6g} m at {station.label}"
            raise ValueError(f"joint {name!r}: {inner!r} is not inside {outer!r}: {where}")


def _components(vectors: NDArray) -> Indices:
    """Coordinates (..., 3 k) of vectors (..., k); -1 where absent."""
    found = np.where(vectors[..., None] >= 0, vectors[..., None] + np.arange(3), -1)
    return found.reshape(*vectors.shape[:-1], -1).astype(np.intp)


def _coordinates(stations: Sequence[Station], own: NDArray, nodes: int) -> Indices:
    """Own coordinates and positions of the other tube."""
    others = np.full((len(stations), nodes), -1)
    for row, station in zip(others, stations, strict=True):
        row[: len(station.other.nodes)] = station.other.nodes
    return np.concatenate([_components(own), _components(others)], axis=1)


def _width(other: Tube) -> int:
    """Elements of the other tube that have a place in the matrix for each station."""
    count = len(other.nodes) - 1
    return count if count <= FEW else WIDTH


def _bands(stations: Sequence[Station], start: Array, feet: Array) -> NDArray[np.int64]:
    """First element of the band of each station: ``NOWHERE`` if its foot is far beyond the ends.

    start, feet : (E,) float [m]  feet in the reference and now

    Places are told apart in steps of ``GRAIN``, as far as tubes have moved as a whole, so that
    the bands of most stations change at the same time, and only once in an element.
    """
    found, at = np.zeros(len(stations), np.int64), 0
    for _, group in groupby(stations, key=lambda s: s.kind):
        members = list(group)
        rows, other = slice(at, at + len(members)), members[0].other
        at += len(members)
        if len(other.nodes) - 1 <= FEW:
            continue
        grain = GRAIN * float(np.diff(other.lengths).min())
        middle = start[rows] + grain * np.round(np.median(feet[rows] - start[rows]) / grain)
        middle += grain * np.trunc((feet[rows] - middle) / grain)
        first = np.searchsorted(other.lengths, middle - 2.0 * grain, side="right") - 1
        reach = kernels.FAR * members[0].joint.radius * 2.0 + 2.0 * grain
        far = np.maximum(-middle, middle - other.lengths[-1]) > reach
        found[rows] = np.where(far, NOWHERE, np.clip(first, 0, len(other.nodes) - 1 - WIDTH))
    return found


def _pattern_dofs(stations: Sequence[Station], ints: NDArray) -> Indices:
    """Own coordinates and those of one element, for every element of the bands."""
    found = []
    for row, station in zip(ints, stations, strict=True):
        nodes = station.other.nodes[:, None] + 3 * np.arange(4)
        elements = np.concatenate([nodes[:-1], nodes[1:]], axis=1)
        mine = np.tile(row[OWN:], (row[WIDE], 1))
        if row[BAND] == NOWHERE:
            mine, there = np.full_like(mine, -1), np.full((row[WIDE], elements.shape[1]), -1)
        else:
            there = elements[row[BAND] : row[BAND] + row[WIDE]]
        found.append(np.concatenate([mine, there], axis=1))
    return _components(np.concatenate(found))


# ------------------------------------------------------------------------ temperature and mass


def _temperatures(stations: Sequence[Station], T: Array) -> tuple[Array, Array]:
    """(S, n) [K]  of inner and outer tube where each station is at a node of the other tube.

    The stations are of one tube.
    """
    own, other = stations[0].own, T[stations[0].other.points]
    there = np.interp([station.place for station in stations], own.lengths, T[own.points])
    pair = np.broadcast_arrays(there[:, None], other)
    return (pair[0], pair[1]) if stations[0].sign > 0.0 else (pair[1], pair[0])


def _coefficients(stations: Sequence[Station], T: Array) -> Array:
    """(S, n, SLOT) coefficients of the stations of one tube at the nodes of the other."""
    joint, at, tubes = stations[0].joint, _temperatures(stations, T), stations[0].tubes()
    strains = [
        tube.body.material.thermal_strain(t, joint.reference_temperature)
        for tube, t in zip(tubes, at, strict=True)
    ]
    found = np.zeros((*at[0].shape, SLOT))
    found[..., ACTIVE] = 1.0
    found[..., CLEARANCE] = contact.thermal_clearance(joint.clearance, joint.radius, *strains)
    found[..., RADIUS] = joint.radius * (1.0 + strains[0])
    for column, value in enumerate(_normal(stations, tubes, at), LAW):
        found[..., column] = value
    means, which = np.unique(0.5 * (at[0] + at[1]), return_inverse=True)
    rubbing = [contact.friction_columns(joint.friction, float(t)) for t in means]
    found[..., FRICTION:CORE] = np.array(rubbing)[which.reshape(at[0].shape)]
    found[..., CORE] = CENTRE * joint.clearance
    if stations[0].pads:
        found[..., CORE] *= -1.0
        found[..., CLEARANCE] = _sprung(joint, found[..., CLEARANCE])
    return found


def _sprung(joint: Telescope, clearance: Array) -> Array:
    """Clearance of a ring of pads that is N0/K below zero, or the way to the pads."""
    assert joint.preload is not None
    free = clearance - joint.clearance - 0.5 * joint.preload.force / joint.preload.stiffness
    return np.where(free < 0.0, 2.0 * free, free)


def _normal(
    stations: Sequence[Station], tubes: tuple[Tube, Tube], at: tuple[Array, Array]
) -> tuple[contact.Value, ...]:
    """Columns LAW to REFERENCE at both temperatures (S, n)."""
    joint, share, elastic = stations[0].joint, np.ones((len(stations), 1)), []
    law = joint.contact
    if joint.preload is not None and stations[0].pads:
        law = NormalContact("linear", joint.preload.stiffness, restitution=1.0)
    if law.stiffness == "cylinder":
        share = np.array([[station.length] for station in stations])
    for tube, t in zip(tubes, at, strict=True):
        elastic += [tube.body.material.youngs_modulus(t), tube.body.material.poissons_ratio(t)]
    return contact.normal_columns(law, joint.radius, joint.clearance, 1.0, share, *elastic)


def _partition(station: Station, place: float, T: Array) -> Array:
    """Share of the frictional heat of the own and of the other tube."""
    tubes, places = (station.own, station.other), (station.place, place)
    at = [tube.at(T[tube.points], s) for tube, s in zip(tubes, places, strict=True)]
    materials = [tube.body.material for tube in tubes]
    return contact.heat_shares(station.joint.friction, materials, at)


def _mobility(station: Station, place: float, diagonal: Array) -> float:
    """1/mass [1/kg] with which the station and the place of its foot give way to each other."""
    vectors, weights = station.vectors()
    other = station.other
    e, part = other.weights(place)
    hermite = np.empty((3, 4))
    a, b = float(other.lengths[e]), float(other.lengths[e + 1])
    kernels.axis_weights(a + part * (b - a), a, b, hermite)
    facing = (other.nodes[e : e + 2, None] + [0, 3]).ravel()
    own = np.sum(weights[0] ** 2 / diagonal[vectors])
    return float(own + np.sum(hermite[0] ** 2 / diagonal[facing]))
