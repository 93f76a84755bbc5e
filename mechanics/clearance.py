"""Joints of a journal in a bearing with clearance, as terms.

A joint has contact points, each of which is a ring (the end of a bore around a pin), a ball (in its
socket) or a vertex (a corner at a plane wall):

    revolute, planar     one ring; constraints hold the pin along the axis and against tilt
    revolute, spatial    rings at both ends of the bore; with axial clearance, three vertices on
                         each of the two flanges of the pin
    spherical            one ball
    cylindrical          rings at both ends of the bush
    translational        corners of the slider: four at two walls (planar; constraints hold the
                         rest), or eight, each at two of four walls

Points that carry a load together share the stiffness of the joint: each end of a bore has half
of it, each vertex of a flange a third, each corner all. ``mechanics.clearance_kernels`` has the
forces.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mechanics import clearance_kernels as kernels
from mechanics import contact
from mechanics.clearance_kernels import BALL, RING, VERTEX
from mechanics.contact_laws import (
    ACTIVE,
    CENTRE,
    CLEARANCE,
    CORE,
    FRICTION,
    LAW,
    RADIUS,
    SEIZED,
    SLOT,
)
from mechanics.description import (
    Clearance,
    ClearanceCylindrical,
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    NormalContact,
    ReferencePoint,
    RigidBody,
    Site,
)
from mechanics.directions import direction, normal_to, origin, unit, unit_direction
from mechanics.layout import Layout, Side
from mechanics.reference_point import face_weights

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FLANGE = 1.5
"""Radius of the flanges, in radii of the pin, where none is given [-]."""
VERTICES = 3
"""Contact points around a flange: the least that carry a force and moments alike."""


Round = ClearanceRevolute | ClearanceSpherical | ClearanceCylindrical


class Point(NamedTuple):
    """A contact point of a joint.

    label : what to call it;  geometry : (8,) as ``clearance_kernels.POINT``
    share : part of the stiffness of the joint [-]
    gap : (journal strain, bearing strain) to clearance [m]
    radius : float [m]  of the journal there, for the lever of friction
    bearing_radius : float [m]  in the reference;  length : float [m]  that carries
    law : normal law at this place
    arm : (3,) float [m]  from the centre of the journal, along b1, b2, b3
    """

    label: str
    geometry: Array
    share: float
    gap: Callable[[float, float], float]
    radius: float
    bearing_radius: float
    length: float
    law: NormalContact
    arm: Array


@dataclass(frozen=True, eq=False)
class Joints:
    """All clearance joints of a system with equally many contact points, as one term.

    Attributes
    ----------
    names : joints;  labels : contact points of a joint;  slots : number of these
    dofs : (n_j, 6 K) int  coordinates of journal and bearing; -1 where absent
    points : (n_j, 2) int  rows of journal and bearing in the temperature array
    planes : (n_j, 2, 3) float  directions b1 and b2 in the reference
    contacts : contact points of each joint
    """

    names: list[str]
    labels: list[str]
    dofs: Indices
    ints: NDArray[np.int64]
    floats: Array
    points: Indices
    planes: Array
    joints: tuple[Clearance, ...]
    contacts: tuple[tuple[Point, ...], ...]
    ends: list[list[tuple[Side, Side]]]
    name: str = "clearance"
    symmetric: bool = False
    force: int = kernels.add_force
    tangent: int = kernels.add_tangent
    energy: int = kernels.add_energy
    respond: int = kernels.respond
    remember: int = kernels.remember

    @property
    def slots(self) -> int:
        """Contact points of a joint."""
        return len(self.labels)

    @property
    def contact_names(self) -> list[str]:
        """Name of each contact: of its joint, with its label where there are several."""
        return [
            f"{name}.{label}" if label else name for name in self.names for label in self.labels
        ]

    def coefficients(self, T: Array) -> Array:
        """(n_j, slots SLOT) float, columns of ``contact_laws``, at section temperatures (m, 3)."""
        each = zip(self.joints, self.contacts, T[self.points, 0], strict=True)
        return np.array([
            np.concatenate([_coefficients(joint, point, *at) for point in points])
            for joint, points, at in each
        ])  # fmt: skip

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The coefficients as they are: contacts have no free strains."""
        return c0, c1

    def partition(self, T: Array) -> Array:
        """(n_j, 2) float [-]  share of the frictional heat of journal and bearing."""
        each = zip(self.joints, T[self.points, 0], strict=True)
        return np.array([
            contact.heat_shares(j.friction, (j.journal_material, j.bearing_material), t)
            for j, t in each
        ])  # fmt: skip

    def deposit(self, T: Array, work: Array, response: Array) -> Array:
        """(m,) float [J]  heat at the temperature points from ``work`` (n_c,) [J] of friction."""
        heat = np.zeros(len(T))
        of_joints = work.reshape(-1, self.slots).sum(axis=1, keepdims=True)
        np.add.at(heat, self.points, self.partition(T) * of_joints)
        return heat

    def masses(self, mass: csr_array) -> Array:
        """(n_c,) [kg]  reduced mass of the nodes that meet in an impact."""
        diagonal = mass.diagonal()
        return 1.0 / np.array([_mobility(p, diagonal) for pairs in self.ends for p in pairs])

    def pushes(self, n: int) -> list[Array]:
        """For each contact (k, n): unit forces on both ends, in all directions it may act in."""
        return [
            np.array([_push(pair, d, n) for d in _directions(point, plane)])
            for pairs, points, plane in zip(self.ends, self.contacts, self.planes, strict=True)
            for pair, point in zip(pairs, points, strict=True)
        ]


def build(joints: Sequence[Clearance], layout: Layout) -> list[Joints]:
    """Terms for all clearance joints; one that cannot be made is a ``ValueError``."""
    groups: dict[int, list[tuple[Clearance, tuple[Point, ...]]]] = {}
    for joint in joints:
        _check(joint)
        points = _POINTS[type(joint)](joint)
        groups.setdefault(len(points), []).append((joint, points))
    return [_term(group, layout) for group in groups.values()]


def _term(group: list[tuple[Clearance, tuple[Point, ...]]], layout: Layout) -> Joints:
    joints, contacts = zip(*group, strict=True)
    sides = [(layout.site(joint.journal), layout.site(joint.bearing)) for joint in joints]
    axes = [bearing_axes(joint, *pair) for joint, pair in zip(joints, sides, strict=True)]
    K = max(side.vectors.size for pair in sides for side in pair)
    vectors = np.array([[_padded(side.vectors, K, -1) for side in pair] for pair in sides])
    components = np.where(vectors[..., None] >= 0, vectors[..., None] + np.arange(3), -1)
    parts = [[f"{joint.name}.{part}" for part in ("journal", "bearing")] for joint in joints]
    each = list(zip(joints, contacts, sides, axes, strict=True))
    return Joints(
        names=[j.name for j in joints],
        labels=[point.label for point in contacts[0]],
        dofs=components.reshape(len(joints), -1).astype(np.intp),
        ints=np.array([_ints(pair, v) for pair, v in zip(sides, vectors, strict=True)], np.int64),
        floats=np.array([_floats(points, pair, b, K) for _, points, pair, b in each]),
        points=np.array([[layout.point_index[p][0] for p in pair] for pair in parts], np.intp),
        planes=np.array([b[:2] for b in axes]),
        joints=joints,
        contacts=contacts,
        ends=[_ends(*one, layout) for one in each],
    )


def _padded(values: NDArray, K: int, absent: float) -> NDArray:
    return np.concatenate([values, np.full(K - len(values), absent)])


def _ints(pair: tuple[Side, Side], vectors: NDArray) -> NDArray:
    return np.concatenate([[side.vectors.size for side in pair], vectors.ravel()])


def _floats(points: Sequence[Point], pair: tuple[Side, Side], b: Array, K: int) -> Array:
    """Row of constants of a joint; see ``mechanics.clearance_kernels``."""
    journal, bearing = pair
    turning = [_of_journal(journal, b[2]), _of_journal(journal, b[0])]
    directions = [unit_direction(bearing, e) for e in b]
    weights = [_padded(side.weights.T.ravel(), 3 * K, 0.0) for side in pair]
    geometry = [point.geometry for point in points]
    return np.concatenate([origin(*pair), *turning, *directions, *geometry, *weights])


def _of_journal(journal: Side, vector: Array) -> Array:
    """Direction of the journal that is ``vector`` in the reference; zeros if it has none, and turns
    with the bearing."""
    try:
        return direction(journal, vector)
    except ValueError:
        return np.zeros(7)


def bearing_axes(joint: Clearance, a: Side, b: Side) -> Array:
    """(3, 3) rows b1, b2, b3 in the reference: b3 along the axis, a guide's b1 across its walls."""
    if isinstance(joint, ClearanceSpherical):
        return b.triad[[1, 2, 0]]
    axis = unit(joint.axis)
    if isinstance(joint, ClearanceTranslational):
        first = unit(np.asarray(joint.normal, float) - (joint.normal @ axis) * axis)
    elif a.directions == 1 and abs(a.triad[0] @ axis) < 1.0 - 1e-9:
        first = unit(a.triad[0] - (a.triad[0] @ axis) * axis)
    else:
        first = normal_to(axis, b.triad if not a.directions else a.triad)
    return np.array([first, np.cross(axis, first), axis])


# ----------------------------------------------------------------------------- contact points


def _round(joint: Round, label: str, kind: int, height: float, ends: int) -> Point:
    """A ring or a ball; ``ends`` of them carry the load of a joint."""
    c, R = joint.clearance, joint.radius
    length = getattr(joint, "length", None) or 0.0
    geometry = np.array([kind, height, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    return Point(
        label, geometry, 1.0 / ends,
        lambda journal, bearing: float(contact.thermal_clearance(c, R, journal, bearing)),
        R, R + c, length, joint.contact, np.array([0.0, 0.0, height]),
    )  # fmt: skip


def _ends_of_bore(joint: ClearanceRevolute | ClearanceCylindrical) -> tuple[Point, ...]:
    half = 0.5 * joint.length if joint.length else 0.0
    return tuple(
        _round(joint, f"end_{i + 1}", RING, z, 2) for i, z in enumerate((-half, half))
    )  # fmt: skip


def _revolute(joint: ClearanceRevolute) -> tuple[Point, ...]:
    if joint.length is None:
        return (_round(joint, "", RING, 0.0, 1),)
    return _ends_of_bore(joint) + (() if joint.axial_clearance is None else _flanges(joint))


def _flanges(joint: ClearanceRevolute) -> tuple[Point, ...]:
    """Points of the two flanges of a pin, which touch the faces of the bearing."""
    radius, found = joint.flange_radius or FLANGE * joint.radius, []
    assert joint.length is not None and joint.axial_clearance is not None
    half, c = 0.5 * joint.length, joint.axial_clearance
    for flange, sign in ((1, -1.0), (2, 1.0)):
        for k in range(VERTICES):
            angle = 2.0 * np.pi * k / VERTICES
            corner = np.array([radius * np.cos(angle), radius * np.sin(angle), sign * (half + c)])
            found.append(_vertex(
                f"flange_{flange}_{k + 1}", joint.contact, corner, np.array([0.0, 0.0, -sign]),
                -(half + c), 1.0 / VERTICES, radius,
                lambda journal, bearing: c + (half + c) * journal - half * bearing,
            ))  # fmt: skip
    return tuple(found)


def _slider(joint: ClearanceTranslational) -> tuple[Point, ...]:
    """Corners of a slider, at each wall that they can touch."""
    deep = [0.0] if joint.width is None else [-0.5 * joint.width, 0.5 * joint.width]
    found = []
    for i, z in enumerate((-0.5 * joint.length, 0.5 * joint.length)):
        for j, x in enumerate((-0.5 * joint.height, 0.5 * joint.height)):
            for k, y in enumerate(deep):
                corner = np.array([x, y, z])
                label = f"corner_{i + 1}_{j + 1}" + ("" if joint.width is None else f"_{k + 1}")
                walls = [("height", 0)] if joint.width is None else [("height", 0), ("width", 1)]
                for across, axis in walls:
                    name = label if joint.width is None else f"{label}_{across}"
                    found.append(_at_wall(joint, name, corner, axis))
    return tuple(found)


def _at_wall(joint: ClearanceTranslational, label: str, corner: Array, axis: int) -> Point:
    half, c = abs(float(corner[axis])), joint.clearance
    normal = np.sign(corner[axis]) * np.eye(3)[axis]
    return _vertex(
        label, joint.contact, corner, normal, half, 1.0, joint.corner_radius or 0.0,
        lambda journal, bearing: c + (half + c) * bearing - half * journal,
    )  # fmt: skip


def _vertex(
    label: str,
    law: NormalContact,
    corner: Array,
    normal: Array,
    distance: float,
    share: float,
    radius: float,
    gap: Callable[[float, float], float],
) -> Point:
    geometry = np.array([VERTEX, *corner, *normal, distance])
    return Point(label, geometry, share, gap, radius, np.inf, 0.0, law, corner)


_POINTS: dict[type, Callable] = {
    ClearanceRevolute: _revolute,
    ClearanceSpherical: lambda joint: (_round(joint, "", BALL, 0.0, 1),),
    ClearanceCylindrical: _ends_of_bore,
    ClearanceTranslational: _slider,
}


# ----------------------------------------------------------------------------------- checks


def _check(joint: Clearance) -> None:
    if why := contact.refusal(joint.contact, joint.friction) or _lacking(joint):
        raise ValueError(f"joint {joint.name!r}: {why}")


def _lacking(joint: Clearance) -> str:
    """What a stiffness from radii and materials lacks; "" if nothing."""
    stiffness = joint.contact.stiffness
    if joint.contact.value is not None:
        return ""
    flat = isinstance(joint, ClearanceTranslational)
    if stiffness == "cylinder" and (flat or getattr(joint, "length", None) is None):
        return "the law of a cylinder in a bore needs the length of the bore"
    if flat and getattr(joint, "corner_radius", None) is None:
        return "corners need a radius or a stiffness"
    return ""


# ----------------------------------------------------------------------------- coefficients


def _coefficients(joint: Clearance, point: Point, Tj: float, Tb: float) -> Array:
    """(SLOT,) coefficients of a contact point at journal and bearing temperature [K]."""
    strain = joint.journal_material.thermal_strain(Tj, joint.reference_temperature)
    bore = joint.bearing_material.thermal_strain(Tb, joint.reference_temperature)
    c = np.zeros(SLOT)
    c[ACTIVE] = 1.0
    c[CLEARANCE] = point.gap(strain, bore)
    c[RADIUS] = point.radius * (1.0 + strain)
    c[LAW:FRICTION] = _normal(joint, point, Tj, Tb)
    c[FRICTION:CORE] = contact.friction_columns(joint.friction, 0.5 * (Tj + Tb))
    c[CORE] = max(CENTRE * joint.clearance, -SEIZED * c[CLEARANCE])
    return c


def _normal(joint: Clearance, point: Point, Tj: float, Tb: float) -> Array:
    """Law, its two numbers, dissipation factor and reference speed of a contact point."""
    law = point.law
    sides = (joint.journal_material, Tj), (joint.bearing_material, Tb)
    elastic = [f(T) for m, T in sides for f in (m.youngs_modulus, m.poissons_ratio)]
    if law.value is None and np.isinf(point.bearing_radius):  # a corner at a wall
        law = replace(law, stiffness="hertz-external")
    gap = point.bearing_radius - point.radius
    return np.array(
        contact.normal_columns(law, point.radius, gap, point.length, point.share, *elastic)
    )


# ----------------------------------------------------------------------------- what meets


def _ends(
    joint: Clearance,
    points: Sequence[Point],
    pair: tuple[Side, Side],
    b: Array,
    layout: Layout,
) -> list[tuple[Side, Side]]:
    """Both ends of a joint for each contact point: of rigid bodies, at the contact point."""
    return [
        (_at_arm(joint.journal, pair[0], point.arm @ b, layout),
         _at_arm(joint.bearing, pair[1], point.arm @ b, layout))
        for point in points
    ]  # fmt: skip


def _at_arm(site: Site, side: Side, arm: Array, layout: Layout) -> Side:
    body = None if site.body is None else layout.bodies[site.body]
    if isinstance(body, ReferencePoint):
        return _on_face(side, body, layout)
    if not isinstance(body, RigidBody):
        return side
    return layout.site(replace(site, offset=np.asarray(site.offset) + side.triad @ arm))


def _on_face(side: Side, point: ReferencePoint, layout: Layout) -> Side:
    """A reference point has no mass: the nodes of its face move for it."""
    rows = (side.vectors - layout.node_dofs[point.name][0]) // 3
    nodes = layout.node_dofs[point.body][point.nodes]
    return side._replace(vectors=nodes, weights=side.weights @ face_weights(point)[rows])


def _mobility(pair: tuple[Side, Side], diagonal: Array) -> float:
    """1/mass [1/kg] with which two points give way to each other."""
    return sum(float(np.sum(s.weights[0] ** 2 / diagonal[s.vectors])) for s in pair)


def _directions(point: Point, plane: Array) -> Array:
    """(k, 3) directions in the reference in which a contact point may act."""
    b = np.array([*plane, np.cross(*plane)])
    if point.geometry[0] == VERTEX:
        return point.geometry[None, 4:7] @ b
    return b if point.geometry[0] == BALL else plane


def _push(pair: tuple[Side, Side], direction: Array, n: int) -> Array:
    """(n,) generalised force of a unit force on the first end and its reaction on the second."""
    force = np.zeros(n)
    for side, sign in zip(pair, (1.0, -1.0), strict=True):
        np.add.at(
            force, side.vectors[:, None] + np.arange(3),
            sign * side.weights[0][:, None] * direction,
        )  # fmt: skip
    return force
