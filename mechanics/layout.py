"""Where the coordinates of every node stand in the one vector q.

A node carries its position r and further vectors, by family (``mechanics.elements``). Nodes of a
body are contiguous. Coordinates that belong to joints, such as the place of a slider on its beam,
follow those of the bodies.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from mechanics.description import (
    Beam,
    Body,
    BoreContact,
    Clearance,
    Continuum,
    Flexible,
    FloatingFrame,
    Gear,
    Joint,
    Latch,
    Particle,
    Prismatic,
    ReferencePoint,
    RigidBody,
    Shell,
    Site,
    Sliding,
    TorsionSpring,
)
from mechanics.elements import FAMILIES, Family
from mechanics.line_elements import arc_lengths
from mechanics.reference_point import face_weights, placed

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TURN, TRAVEL, PLACE = "turn", "travel", "place"
"""Coordinates of joints: angle of a hinge, path of a slide, arc length of a slider on a beam."""


class Side(NamedTuple):
    """One end of a joint: a point r and up to two vectors p, s that say how the section stands.

    Each is a sum of vectors of the coordinates with constant weights.

    name : what to call it in messages
    vectors : (k,) int  first coordinate of each vector, k <= 8; none for the ground
    weights : (3, k) float  of the vectors in r, p, s
    directions : int  2: orientation known; 1: only p (cable: tangent, thick shell: normal); 0: none
    position : (3,) float [m]  reference position
    frame : (3, 3) float  rows g/|g|^1/2 with g = p x s, p, s in the reference; zeros where absent
    triad : (3, 3) float  rows e1, e2, e3 in the reference; identity for ground and particles
    size : float [m]  size of the body; 0 for the ground
    """

    name: str
    vectors: Indices
    weights: Array
    directions: int
    position: Array
    frame: Array
    triad: Array
    size: float

    @property
    def fixed(self) -> bool:
        """Whether it is a point of the ground."""
        return not self.vectors.size


@dataclass(frozen=True)
class Layout:
    """The coordinates of all bodies and joints, and the points that carry a temperature.

    Attributes
    ----------
    bodies : mapping from name to description, in order
    kinds : mapping from body name to the number of coordinates of its nodes
    node_dofs : mapping from body name to (n_nodes,) int  first coordinate of each node
    joint_dofs : mapping from ``<joint>.turn``, ``.travel`` or ``.place`` to its coordinate
    q0 : (n,) float [m], [1]  reference coordinates
    v0 : (n,) float [m/s], [1/s]  initial velocities
    scale : (n,) float [m], [1]  size of a coordinate: length of the body for positions
        (particles: of everything; 1 m where that is a point), 1 for slopes and section vectors
    point_index : mapping from name of a flexible body, ``<joint>.journal`` and
        ``<joint>.bearing`` to (k,) int  rows of the temperature array, nodes of bodies first
    x : (m, 3) float [m]  reference positions of these points
    axes : (m, 3, 3) float  their section triads; zeros for solids, journals, bearings
    """

    bodies: Mapping[str, Body]
    kinds: Mapping[str, int]
    node_dofs: Mapping[str, Indices]
    joint_dofs: Mapping[str, int]
    q0: Array
    v0: Array
    scale: Array
    point_index: Mapping[str, Indices]
    x: Array
    axes: Array

    @property
    def ndof(self) -> int:
        """Number of coordinates."""
        return self.q0.size

    @classmethod
    def of(cls, bodies: Sequence[Body], joints: Sequence[Joint] = ()) -> "Layout":
        """Number the coordinates in the order given."""
        named = {body.name: body for body in bodies}
        if len(named) < len(bodies):
            raise ValueError("two bodies have the same name")
        bodies = [placed(b, named) if isinstance(b, ReferencePoint) else b for b in bodies]
        floating = [b for b in bodies if isinstance(b, Beam) and b.modes is not None]
        bodies = [*bodies, *map(_frame, floating)]
        named = {body.name: body for body in bodies}
        kinds = {body.name: 3 * len(family_of(body).vectors) for body in bodies}
        node_dofs, start = {}, 0
        for body in bodies:
            stop = start + kinds[body.name] * node_count(body)
            node_dofs[body.name] = np.arange(start, stop, kinds[body.name], dtype=np.intp)
            start = stop
        size = _extent(bodies, joints)
        own = _joint_coordinates(named, joints, size)
        index, x, axes = _points(bodies, joints)
        made = cls(
            bodies=named,
            kinds=kinds,
            node_dofs=node_dofs,
            joint_dofs={name: start + i for i, name in enumerate(own)},
            q0=_stack([*(_coordinates(b) for b in bodies), [q for q, _ in own.values()]]),
            v0=_stack([*(_velocities(b) for b in bodies), np.zeros(len(own))]),
            scale=_stack([*(_scales(b, size) for b in bodies), [s for _, s in own.values()]]),
            point_index=index,
            x=x,
            axes=axes,
        )
        for joint in joints:
            if isinstance(joint, Sliding):
                place = made.joint_dofs[f"{joint.name}.{PLACE}"]
                made.q0[place] = _nearest(_track(named, joint), made.site(joint.a).position)
        return made

    def site(self, site: Site) -> Side:
        """Coordinates and reference geometry of one end of a joint."""
        if site.body is None:
            position = np.asarray(site.position, float)
            none = np.zeros(0, np.intp), np.zeros((3, 0))
            return Side("ground", *none, 0, position, np.zeros((3, 3)), np.eye(3), 0.0)
        if site.body not in self.bodies:
            raise ValueError(f"there is no body {site.body!r}")
        body, nodes = self.bodies[site.body], self.node_dofs[site.body]
        if not -nodes.size <= site.node < nodes.size:
            raise ValueError(f"body {site.body!r} has {nodes.size} nodes, not a node {site.node}")
        vectors, weights = self._combination(body, nodes, site)
        return self._side(body, vectors, weights, site)

    def _combination(self, body: Body, nodes: Indices, site: Site) -> tuple[Indices, Array]:
        """Vectors and weights (3, k) of r, p, s on the axis of a body, without the offset."""
        family, node = family_of(body), site.node % nodes.size
        if site.fraction:
            return _inside(body, family, nodes, node, site.fraction)
        weights = np.zeros((3, len(family.vectors)))
        weights[[0, *range(1, 1 + len(family.section))], [0, *family.section]] = 1.0
        return nodes[node] + 3 * np.arange(len(family.vectors)), weights

    def _side(self, body: Body, vectors: Indices, weights: Array, site: Site) -> Side:
        values = self.q0[vectors[:, None] + np.arange(3)]
        directions = len(family_of(body).section)
        triad = _triad(body, weights @ values, site)
        weights = _with_offset(body, weights, weights @ values, triad, np.asarray(site.offset))
        used = np.any(weights != 0.0, axis=0)
        r, p, s = weights @ values
        size = float(self.scale[self.node_dofs[body.name][0]])
        frame = np.stack([_root(np.cross(p, s)), p, s])
        return Side(body.name, vectors[used], weights[:, used], directions, r, frame, triad, size)

    def name_of(self, coordinate: int) -> str:
        """Say in words which coordinate this is, such as ``arm node 3 r_y z``."""
        for name, nodes in self.node_dofs.items():
            node, local = divmod(int(coordinate) - int(nodes[0]), self.kinds[name])
            if 0 <= node < nodes.size:
                vector = family_of(self.bodies[name]).vectors[local // 3]
                place = f" node {node}" if nodes.size > 1 else ""
                return f"{name}{place} {vector} {'xyz'[local % 3]}"
        for name, dof in self.joint_dofs.items():
            if dof == coordinate:
                return " ".join(name.rsplit(".", 1))
        raise IndexError(f"coordinate {coordinate} of {self.ndof}")


STATIC_MODES = 6
"""Modes of a beam in a floating frame besides those asked for: of its last section."""


def frame_name(body: str) -> str:
    """Name of the floating frame of a body."""
    return f"{body}@frame"


def _frame(beam: Beam) -> FloatingFrame:
    return FloatingFrame(frame_name(beam.name), beam, STATIC_MODES + (beam.modes or 0))


def family_of(body: Body) -> Family:
    """The family of a body."""
    if isinstance(body, Flexible):
        return FAMILIES[body.element]
    if isinstance(body, FloatingFrame):
        vectors = FAMILIES["rigid"].vectors
        modes = [f"modes {k + 1} to {k + 3}" for k in range(0, body.amplitudes, 3)]
        return Family("", (*vectors, *modes), (2, 3))
    if isinstance(body, ReferencePoint):
        return FAMILIES["reference"]
    return FAMILIES["particle" if isinstance(body, Particle) else "rigid"]


def node_count(body: Body) -> int:
    """Number of nodes of a body."""
    if isinstance(body, Shell):
        return len(body.surface.points)
    return len(body.points) if isinstance(body, Beam | Continuum) else 1


def _root(g: Array) -> Array:
    """g/|g|^1/2, or zero."""
    length = np.linalg.norm(g)
    return g / np.sqrt(length) if length > 0.0 else g


def _inside(
    body: Body, family: Family, nodes: Indices, node: int, fraction: float
) -> tuple[Indices, Array]:
    """A point between two nodes of a line body with a cubic Hermite axis."""
    if not isinstance(body, Beam) or family.vectors[1] != "r_x":
        raise ValueError(f"{body.name!r} takes points at its nodes only")
    if node + 1 >= nodes.size or not 0.0 <= fraction < 1.0:
        raise ValueError(f"{body.name!r} has no such point: it ends at node {nodes.size - 1}")
    k = len(family.vectors)
    ends = np.asarray(body.points, float)[None, node : node + 2]
    slopes = np.asarray(body.axes, float)[None, node : node + 2, 0]
    L, x = float(arc_lengths(ends, slopes)[0]), fraction
    weights = np.zeros((3, 2 * k))
    weights[0, [0, k]] = (1.0 - x) ** 2 * (1.0 + 2.0 * x), x * x * (3.0 - 2.0 * x)
    weights[0, [1, k + 1]] = L * x * (1.0 - x) ** 2, L * x * x * (x - 1.0)
    for row, vector in enumerate(family.section, 1):
        weights[row, [vector, k + vector]] = 1.0 - x, x
    if family.section == (1,):  # the tangent of a cable follows from its axis
        weights[1, [0, k]] = -6.0 * x * (1.0 - x) / L, 6.0 * x * (1.0 - x) / L
        weights[1, [1, k + 1]] = 1.0 - 4.0 * x + 3.0 * x * x, 3.0 * x * x - 2.0 * x
    return (nodes[node : node + 2, None] + 3 * np.arange(k)).ravel(), weights


def _triad(body: Body, now: Array, site: Site) -> Array:
    """(3, 3) orthonormal rows e1, e2, e3 at a point with r, p, s = ``now``."""
    if isinstance(body, Particle | Continuum):
        return np.eye(3)
    if isinstance(body, RigidBody | ReferencePoint):
        return np.asarray(body.axes, float)
    if isinstance(body, FloatingFrame):
        return np.asarray(body.beam.axes, float)[0]
    if isinstance(body, Beam):
        e1, e2, _ = np.asarray(body.axes, float)[site.node]
        if site.fraction:
            e1, e2 = (now[1], e2) if body.element == "cable" else (np.cross(now[1], now[2]), now[1])
        return _orthonormal(e1, e2)
    e1, e2 = (body.surface.d_u[site.node], body.surface.d_v[site.node])
    return _orthonormal(e1, e2)


def _orthonormal(e1: Array, e2: Array) -> Array:
    e1 = e1 / np.linalg.norm(e1)
    e2 = e2 - (e2 @ e1) * e1
    e2 /= np.linalg.norm(e2)
    return np.stack([e1, e2, np.cross(e1, e2)])


def _with_offset(body: Body, weights: Array, now: Array, triad: Array, offset: Array) -> Array:
    """Weights of the point that is ``offset`` away along the triad, carried by the section."""
    if not offset.any():
        return weights
    away, weights = offset @ triad, weights.copy()
    if isinstance(body, RigidBody):
        weights[0, 1:4] = np.asarray(body.axes, float) @ away
        return weights
    p, s = now[1], now[2]
    parts, rest = np.linalg.lstsq(np.stack([p, s], axis=1), away, rcond=None)[:2]
    if not s.any() or float(rest[0] if rest.size else 0.0) > 1e-20 * float(away @ away):
        raise ValueError(f"the section of {body.name!r} has no point there")
    weights[0] += parts @ weights[1:]
    return weights


def _stack(parts: Sequence) -> Array:
    return np.concatenate([np.zeros(0), *(np.asarray(part, float) for part in parts)])


def _vectors(body: Body) -> Array:
    """(n, k, 3): the vectors of every node but its position, in the reference."""
    if isinstance(body, Particle | Continuum):
        return np.zeros((node_count(body), 0, 3))
    if isinstance(body, RigidBody):
        return np.asarray(body.axes, float)[None]
    if isinstance(body, FloatingFrame):
        still = np.zeros((body.amplitudes // 3, 3))
        return np.vstack([np.asarray(body.beam.axes, float)[0], still])[None]
    if isinstance(body, ReferencePoint):
        return (face_weights(body)[1:] @ np.asarray(body.points, float))[None]
    if isinstance(body, Beam):
        names = family_of(body).vectors[1:]
        return np.asarray(body.axes, float)[:, ["xyz".index(name[2]) for name in names]]
    s = body.surface
    normal = np.cross(s.d_u, s.d_v)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    known = {"r_u": s.d_u, "r_v": s.d_v, "r_uv": s.d_uv, "r_n": normal}
    return np.stack([known[name] for name in family_of(body).vectors[1:]], axis=1)


def _places(body: Body) -> Array:
    """(n, 3) [m] reference positions of the nodes."""
    if isinstance(body, Particle | RigidBody):
        return np.asarray(body.position, float)[None]
    if isinstance(body, FloatingFrame):
        return np.asarray(body.beam.points, float)[:1]
    if isinstance(body, ReferencePoint):
        return face_weights(body)[:1] @ np.asarray(body.points, float)
    return np.asarray(body.surface.points if isinstance(body, Shell) else body.points, float)


def _coordinates(body: Body) -> Array:
    return np.concatenate([_places(body)[:, None], _vectors(body)], axis=1).ravel()


def _velocities(body: Body) -> Array:
    velocity = np.asarray(body.velocity, float)
    if isinstance(body, Particle):
        return velocity.copy()
    spin = np.asarray(body.spin, float)
    arm = np.zeros((1, 3)) if isinstance(body, RigidBody) else _places(body)
    r = velocity + np.cross(spin, arm)
    return np.concatenate([r[:, None], np.cross(spin, _vectors(body))], axis=1).ravel()


def _extent(bodies: Sequence[Body], joints: Sequence[Joint]) -> float:
    """Diagonal [m] of the box about all nodes and points of the ground; 1 if it has none."""
    ground = [
        site.position
        for joint in joints
        for end in vars(joint).values()
        for site in (end if isinstance(end, list | tuple) else [end])
        if isinstance(site, Site) and site.body is None
    ]
    points = np.concatenate(
        [np.zeros((0, 3)), *map(_places, bodies), *np.reshape(ground, (-1, 1, 3))]
    )
    return float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0 if len(points) else 1.0


def _length(body: Body, extent: float) -> float:
    """Size of a body [m]: a rigid one has its radius of gyration, a particle that of the scene."""
    if isinstance(body, Particle | ReferencePoint):
        return extent
    if isinstance(body, FloatingFrame):
        return _length(body.beam, extent)
    if isinstance(body, Continuum):
        return float(np.linalg.norm(np.ptp(body.points, axis=0)))
    if isinstance(body, RigidBody):
        return float(np.sqrt(np.trace(np.asarray(body.inertia)) / (2.0 * body.mass))) or extent
    if isinstance(body, Shell):
        return float(np.linalg.norm(np.ptp(body.surface.points, axis=0)))
    return float(np.linalg.norm(np.diff(body.points, axis=0), axis=1).sum())


def _scales(body: Body, extent: float) -> Array:
    family, length = family_of(body), _length(body, extent)
    node = np.ones(3 * len(family.vectors))
    node[:3] = length
    if isinstance(body, FloatingFrame):
        node[12:] = length
    if "r_uv" in family.vectors:
        node[9:] = 1.0 / length
    return np.tile(node, node_count(body))


def _joint_coordinates(
    bodies: Mapping[str, Body], joints: Sequence[Joint], extent: float
) -> dict[str, tuple[float, float]]:
    """Reference value and scale of the coordinates that joints own.

    Those of sliders wait for the coordinates of the bodies.
    """
    named = {joint.name: joint for joint in joints}
    own: dict[str, tuple[float, float]] = {}
    for joint in joints:
        if isinstance(joint, Sliding):
            own[f"{joint.name}.{PLACE}"] = 0.0, float(_track(bodies, joint).lengths.sum())
        for name in _turning(joint):
            slides = isinstance(named.get(name), Prismatic)
            kind = TRAVEL if slides and isinstance(joint, Latch) else TURN
            own[f"{name}.{kind}"] = 0.0, extent if kind == TRAVEL else 1.0
    return own


def _turning(joint: Joint) -> tuple[str, ...]:
    """Names of the joints whose turn (or travel) a joint needs as a coordinate."""
    if isinstance(joint, Gear):
        return joint.first, joint.second
    return (joint.joint,) if isinstance(joint, Latch | TorsionSpring) else ()


class _Track(NamedTuple):
    """The axis of a line body as cubics: ends (n_e, 2, 3), slopes there, arc lengths (n_e,)."""

    ends: Array
    slopes: Array
    lengths: Array


def _track(bodies: Mapping[str, Body], joint: Sliding) -> _Track:
    body = bodies.get(joint.body)
    if not isinstance(body, Beam) or "r_x" not in family_of(body).vectors:
        raise ValueError(f"joint {joint.name!r}: {joint.body!r} is no beam or cable to slide on")
    points, e1 = np.asarray(body.points, float), np.asarray(body.axes, float)[:, 0]
    ends, slopes = np.stack([points[:-1], points[1:]], 1), np.stack([e1[:-1], e1[1:]], 1)
    return _Track(ends, slopes, arc_lengths(ends, slopes))


def _nearest(track: _Track, target: Array) -> float:
    """Arc length [m] of the point of an axis that is nearest to ``target`` (3,)."""
    found = [_foot(track, e, target) for e in range(len(track.lengths))]
    nearest = int(np.argmin([distance for distance, _ in found]))
    return float(track.lengths[:nearest].sum()) + found[nearest][1] * track.lengths[nearest]


def _foot(track: _Track, element: int, target: Array) -> tuple[float, float]:
    """Least distance [m] of an element to ``target``, and where it is: 0 to 1.

    The distance from a cubic is stationary where a polynomial of degree five vanishes.
    """
    x = np.array([0.0, 1 / 3, 2 / 3, 1.0])
    (a, b), (s, t), L = track.ends[element], track.slopes[element], track.lengths[element]
    weights = np.stack([
        (1 - x) ** 2 * (1 + 2 * x), L * x * (1 - x) ** 2, x * x * (3 - 2 * x), L * x * x * (x - 1)
    ])  # fmt: skip
    powers = np.linalg.solve(np.vander(x, 4, increasing=True), weights.T @ np.stack([a, s, b, t]))
    cubics = [Polynomial(c) for c in (powers - np.eye(4)[:, :1] * target).T]
    slope = sum((c * c.deriv() for c in cubics), Polynomial([0.0]))
    roots = slope.roots()
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < 1.0)]
    return min((float(np.hypot.reduce([c(p) for c in cubics])), float(p)) for p in (0, 1, *inside))


def _place(site: Site, positions: Mapping[str, Array]) -> Array:
    if site.body is None:
        return np.asarray(site.position, float)
    if site.body not in positions:
        raise ValueError(f"there is no body {site.body!r}")
    return positions[site.body][site.node]


def _points(
    bodies: Sequence[Body], joints: Sequence[Joint]
) -> tuple[dict[str, Indices], Array, Array]:
    """Temperature points: nodes of flexible bodies, then parts of the joints with clearance."""
    places = {b.name: (_places(b), _section_axes(b)) for b in bodies if isinstance(b, Flexible)}
    positions = {body.name: _places(body) for body in bodies}
    for joint in joints:
        for part, site in _parts(joint):
            at = _place(site, positions)
            places[f"{joint.name}.{part}"] = at[None], np.zeros((1, 3, 3))
    index, start = {}, 0
    for name, (x, _) in places.items():
        index[name] = np.arange(start, start + len(x), dtype=np.intp)
        start += len(x)
    x = np.concatenate([np.zeros((0, 3)), *(x for x, _ in places.values())])
    axes = np.concatenate([np.zeros((0, 3, 3)), *(a for _, a in places.values())])
    return index, x, axes


def _parts(joint: Joint) -> list[tuple[str, Site]]:
    """Parts of a joint that have a temperature of their own; the bore of a solid is its nodes."""
    if isinstance(joint, BoreContact):
        return [("journal", joint.pin)]
    if isinstance(joint, Clearance):
        return [("journal", joint.journal), ("bearing", joint.bearing)]
    return []


def _section_axes(body: Flexible) -> Array:
    """(n, 3, 3) rows e1, e2, e3 at the nodes; of shells e3 is the normal; zeros in a solid."""
    if isinstance(body, Continuum):
        return np.zeros((len(body.points), 3, 3))
    if isinstance(body, Beam):
        return np.asarray(body.axes, float)
    pairs = zip(body.surface.d_u, body.surface.d_v, strict=True)
    return np.array([_orthonormal(e1, e2) for e1, e2 in pairs])
