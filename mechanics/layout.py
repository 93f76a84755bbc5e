"""Where the coordinates of every node stand in the one vector q.

Nodes carry their position r (3) and, by kind, nothing more (particle), the slope r_x (cable)
or r_x and the section vectors d2 = r_y, d3 = r_z (beam). Nodes of a body are contiguous.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import Beam, Body, ClearanceRevolute, Joint, Particle, Site

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

BEAM, CABLE, PARTICLE, FIXED = 12, 6, 3, 0
"""Coordinates per node; ``FIXED`` is a point of the ground."""

_VECTORS = {PARTICLE: ("position",), CABLE: ("position", "r_x")}
_VECTORS[BEAM] = ("position", "r_x", "r_y", "r_z")


class Side(NamedTuple):
    """One end of a joint.

    name : what to call it in messages
    kind : int  coordinates of its node: 12, 6, 3, or 0 for the ground
    dofs : (9,) int  coordinates of r and of two vectors (beam: d2, d3; cable: r_x); -1 absent
    position : (3,) float [m]  reference position
    triad : (3, 3) float  rows e1, e2, e3 in the reference; identity for ground and particles
    """

    name: str
    kind: int
    dofs: Indices
    position: Array
    triad: Array


@dataclass(frozen=True)
class Layout:
    """The coordinates of all bodies and the points that carry a temperature.

    Attributes
    ----------
    bodies : mapping from name to description, in order
    kinds : mapping from body name to the number of coordinates of its nodes: 12, 6 or 3
    node_dofs : mapping from body name to (n_nodes,) int  first coordinate of each node
    q0 : (n,) float [m], [1]  reference coordinates
    v0 : (n,) float [m/s], [1/s]  initial velocities
    scale : (n,) float [m], [1]  size of a coordinate: length of the body for positions
        (particles: 1 m), 1 for slopes and section vectors
    point_index : mapping from beam name, ``<joint>.journal`` and ``<joint>.bearing`` to
        (k,) int  rows of the temperature array, nodes of beams first
    x : (m, 3) float [m]  reference positions of these points
    axes : (m, 3, 3) float  their section triads; zeros for journals and bearings
    """

    bodies: Mapping[str, Body]
    kinds: Mapping[str, int]
    node_dofs: Mapping[str, Indices]
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
        """Number the coordinates in the order given; joints matter for their temperatures only."""
        named = {body.name: body for body in bodies}
        if len(named) < len(bodies):
            raise ValueError("two bodies have the same name")
        kinds = {body.name: _kind(body) for body in bodies}
        node_dofs, start = {}, 0
        for body in bodies:
            stop = start + kinds[body.name] * _node_count(body)
            node_dofs[body.name] = np.arange(start, stop, kinds[body.name], dtype=np.intp)
            start = stop
        index, x, axes = _points(bodies, joints)
        return cls(
            bodies=named,
            kinds=kinds,
            node_dofs=node_dofs,
            q0=_stack([_coordinates(b) for b in bodies]),
            v0=_stack([_velocities(b) for b in bodies]),
            scale=_stack([_scales(b) for b in bodies]),
            point_index=index,
            x=x,
            axes=axes,
        )

    def site(self, site: Site) -> Side:
        """Coordinates and reference geometry of one end of a joint."""
        if site.body is None:
            absent = np.full(9, -1, dtype=np.intp)
            return Side("ground", FIXED, absent, np.asarray(site.position, float), np.eye(3))
        if site.body not in self.bodies:
            raise ValueError(f"there is no body {site.body!r}")
        body, kind, nodes = self.bodies[site.body], self.kinds[site.body], self.node_dofs[site.body]
        if not -nodes.size <= site.node < nodes.size:
            raise ValueError(f"body {site.body!r} has {nodes.size} nodes, not a node {site.node}")
        dofs = np.full(9, -1, dtype=np.intp)
        first = nodes[site.node]
        dofs[:3] = first + np.arange(3)
        if kind == CABLE:
            dofs[3:6] = first + 3 + np.arange(3)
        if kind == BEAM:
            dofs[3:] = first + 6 + np.arange(6)
        triad = np.eye(3) if isinstance(body, Particle) else np.asarray(body.axes[site.node], float)
        return Side(site.body, kind, dofs, self.q0[first : first + 3].copy(), triad)

    def name_of(self, coordinate: int) -> str:
        """Say in words which coordinate this is, such as ``arm node 3 r_y z``."""
        for name, nodes in self.node_dofs.items():
            node, local = divmod(int(coordinate) - int(nodes[0]), self.kinds[name])
            if 0 <= node < nodes.size:
                vector = _VECTORS[self.kinds[name]][local // 3]
                place = "" if self.kinds[name] == PARTICLE else f" node {node}"
                return f"{name}{place} {vector} {'xyz'[local % 3]}"
        raise IndexError(f"coordinate {coordinate} of {self.ndof}")


def _stack(parts: Sequence[Array]) -> Array:
    return np.concatenate([np.zeros(0), *parts])


def _kind(body: Body) -> int:
    if isinstance(body, Particle):
        return PARTICLE
    return CABLE if body.element == "cable" else BEAM


def _node_count(body: Body) -> int:
    return 1 if isinstance(body, Particle) else len(body.points)


def _vectors(body: Beam) -> Array:
    """(n, k, 3): r_x, or r_x, r_y, r_z of every node in the reference configuration."""
    axes = np.asarray(body.axes, float)
    return axes[:, :1] if _kind(body) == CABLE else axes


def _coordinates(body: Body) -> Array:
    if isinstance(body, Particle):
        return np.array(body.position, float)
    points = np.asarray(body.points, float)[:, None]
    return np.concatenate([points, _vectors(body)], axis=1).ravel()


def _velocities(body: Body) -> Array:
    velocity = np.asarray(body.velocity, float)
    if isinstance(body, Particle):
        return velocity.copy()
    spin = np.asarray(body.spin, float)
    r = velocity + np.cross(spin, np.asarray(body.points, float))
    return np.concatenate([r[:, None], np.cross(spin, _vectors(body))], axis=1).ravel()


def _scales(body: Body) -> Array:
    if isinstance(body, Particle):
        return np.ones(3)
    length = np.linalg.norm(np.diff(body.points, axis=0), axis=1).sum()
    node = np.ones(_kind(body))
    node[:3] = length
    return np.tile(node, len(body.points))


def _place(site: Site, positions: Mapping[str, Array]) -> Array:
    if site.body is None:
        return np.asarray(site.position, float)
    if site.body not in positions:
        raise ValueError(f"there is no body {site.body!r}")
    return positions[site.body][site.node]


def _points(
    bodies: Sequence[Body], joints: Sequence[Joint]
) -> tuple[dict[str, Indices], Array, Array]:
    """Temperature points: nodes of the beams, then journal and bearing of each clearance joint."""
    beams = [body for body in bodies if isinstance(body, Beam)]
    places = {beam.name: (np.asarray(beam.points, float), np.asarray(beam.axes)) for beam in beams}
    positions = {
        body.name: _coordinates(body).reshape(_node_count(body), -1)[:, :3] for body in bodies
    }
    for joint in joints:
        if isinstance(joint, ClearanceRevolute):
            for part, site in (("journal", joint.journal), ("bearing", joint.bearing)):
                at = _place(site, positions)
                places[f"{joint.name}.{part}"] = at[None], np.zeros((1, 3, 3))
    index, start = {}, 0
    for name, (x, _) in places.items():
        index[name] = np.arange(start, start + len(x), dtype=np.intp)
        start += len(x)
    x = np.concatenate([np.zeros((0, 3)), *(x for x, _ in places.values())])
    axes = np.concatenate([np.zeros((0, 3, 3)), *(a for _, a in places.values())])
    return index, x, axes
