"""Joints of a scene as linear equations between displacements of a CalculiX deck, loads as forces.

A section is held by its means: its position, and the mean slopes of its two directions, as a node
of a beam is; it may breathe. With the ground most joints are linear in displacements, however
large they are. Between bodies that turn only spherical joints are; others hold for small rotations.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

import mechanics.description as motion
from coupling.deck_bodies import Meshed, Section, column, section_of
from mechanics.description import Description, Site

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ASKEW = 1e-9  # cosine from which a direction is neither along the section nor across it
SMALLEST = 1e-13  # coefficient of an equation, of the largest, that is left out


class Row(NamedTuple):
    """A sum of displacements that is zero: nodes (k,), and directions (k, 3) that multiply them."""

    nodes: Indices
    factors: Array


class Equations(NamedTuple):
    """Displacements ``dependent`` (m,) are -``factors`` (m, k) times ``others`` (k,); 3 n + i."""

    dependent: Indices
    others: Indices
    factors: Array


JOINTS = (
    motion.Clamp, motion.Spherical, motion.Revolute, motion.Cylindrical, motion.Prismatic,
    motion.Planar, motion.Guide, motion.Fixing,
)  # fmt: skip
"""What can be written as equations."""
What = str | tuple[float, float]
"""A displacement ("position"), a "turn", or the slope that is so much of those along e2 and e3."""
VECTORS: dict[str, What] = {
    "position": "position", "r_y": (1.0, 0.0), "r_z": (0.0, 1.0), "r_n": (0.0, 1.0)
}  # fmt: skip
"""Vectors of nodes that a section has."""


def sides_of(joint: motion.Joint) -> tuple[Site, Site]:
    """The body's side and the other one, of a joint in ``JOINTS``."""
    if isinstance(joint, motion.Fixing):
        return Site(joint.body, joint.node), Site(None)
    a, b = joint.a, getattr(joint, "b", Site(None))  # type: ignore[union-attr]
    return (b, a) if a.body is None else (a, b)


def refusals(d: Description, large: bool) -> list[str]:
    """One sentence for each joint and load that is not written.

    large : rotations may be large
    """
    found = []
    for joint in d.joints:
        name = f"joint '{joint.name}'"
        if not isinstance(joint, JOINTS):
            found.append(f"{name}: a {kind_of(joint)} is no linear equation")
        elif getattr(joint, "angle", None) or getattr(joint, "travel", None):
            found.append(f"{name}: it is driven, and equations of a deck hold a zero")
        else:
            found += [f"{name}: {why}" for why in _nonlinear(d, joint, large)]
    for load in d.loads:
        found += [f"load '{load.name}': {why}" for why in _unwritten(load, large)]
    return found


def kind_of(thing: object) -> str:
    """What a description is called in words, such as "rigid body"."""
    letters = [f" {c.lower()}" if c.isupper() else c for c in type(thing).__name__]
    return "".join(letters).strip()


def _nonlinear(d: Description, joint: motion.Joint, large: bool) -> list[str]:
    side, other = sides_of(joint)
    found = []
    if large and other.body is not None and not isinstance(joint, motion.Spherical):
        found.append("between two bodies it is linear for small rotations only")
    for site in (side, other):
        if large and site.body is not None and np.asarray(site.offset)[0]:
            found.append("an offset along the body turns with it: linear for small rotations only")
    if isinstance(joint, motion.Fixing) and joint.vector not in VECTORS:
        found.append(f"a section has no vector {joint.vector}")
    axis = getattr(joint, "axis", getattr(joint, "normal", None))
    turns = isinstance(joint, motion.Revolute | motion.Cylindrical | motion.Planar)
    if large and turns and axis is not None and other.body is None and side.body is not None:
        body = next(b for b in d.bodies if b.name == side.body)
        if not isinstance(body, motion.Beam):
            found.append("the slope of a shell holds an axis for small rotations only")
        elif ASKEW < abs(body.axes[side.node][0] @ _unit(axis)) < 1.0 - ASKEW:
            found.append("its axis lies askew to the section: linear for small rotations only")
    return found


def _unwritten(load: motion.Load, large: bool) -> list[str]:
    if isinstance(load, motion.Torque):
        return ["a torque turns with its body; the forces of a deck keep their directions"]
    if isinstance(load, motion.Moment) and large:
        return ["a moment is a couple of forces that keep their directions: right for small "
                "rotations only"]  # fmt: skip
    if isinstance(load, motion.Force) and large and np.any(load.site.offset):
        return ["a force beside the axis has a moment, which is right for small rotations only"]
    if isinstance(load, motion.Traction) and load.edge is not None:
        return ["loads on an edge of a shell are not written"]
    return []


# -------------------------------------------------------------------------------- equations


def rows_of(d: Description, bodies: Mapping[str, Meshed]) -> list[Row]:
    """What the joints hold."""
    found: list[Row] = []
    for joint in d.joints:
        side, other = sides_of(joint)
        one = _Held(section_of(bodies, side), np.asarray(side.offset, float))
        two = None
        if other.body is not None:
            two = _Held(section_of(bodies, other), np.asarray(other.offset, float))
        found += [_difference(one, two, *what) for what in _held(joint, one.section)]
    return [*found, *_between(d, bodies)]


def _between(d: Description, bodies: Mapping[str, Meshed]) -> list[Row]:
    """What holds the nodes of an edge of a shell also holds those half way between them.

    Joints of an edge are one after the other, named after it and their number.
    """
    found = []
    for a, b in pairwise(d.joints):
        kin = type(a) is type(b) and a.name.rpartition(".")[0] == b.name.rpartition(".")[0] != ""
        if not kin or not isinstance(a, JOINTS):
            continue
        (one, ground), (two, _) = sides_of(a), sides_of(b)
        m = bodies[str(one.body)]
        if ground.body is None and isinstance(m.body, motion.Shell):
            held = _Held(column(m, one.node, two.node), np.asarray(one.offset, float))
            if len(held.section.nodes):
                found += [held.row(*what) for what in _held(a, held.section)]
    return found


class _Held(NamedTuple):
    """A section and where, along its axes, the joint is."""

    section: Section
    offset: Array

    def row(self, what: What, direction: Array) -> Row:
        """A displacement, slope or turn in a direction (3,)."""
        s, o = self.section, self.offset
        if what == "position":
            weights = s.place + o[1] * s.along_2 + o[2] * s.along_3
            factors = np.outer(weights, direction)
            if o[0]:
                factors = factors + o[0] * self.row("turn", np.cross(s.axes[0], direction)).factors
            return Row(s.nodes, factors)
        if what == "turn":
            return Row(s.nodes, _turning(s, s.axes @ direction))
        assert not isinstance(what, str)
        return Row(s.nodes, np.outer(what[0] * s.along_2 + what[1] * s.along_3, direction))


def _turning(s: Section, parts: Array) -> Array:
    """(k, 3)  of the turn with components ``parts`` along e1, e2, e3."""
    e1, e2, e3 = s.axes
    about_1 = np.outer(s.torsion_2, e3) - np.outer(s.torsion_3, e2)
    return (
        parts[0] * about_1 + parts[1] * np.outer(s.along_3, e1) - parts[2] * np.outer(s.along_2, e1)
    )


def _difference(one: _Held, two: _Held | None, what: What, direction: Array) -> Row:
    a = one.row(what, direction)
    if two is None:
        return a
    b = two.row(what, direction)
    return Row(np.concatenate([a.nodes, b.nodes]), np.vstack([a.factors, -b.factors]))


def _held(joint: motion.Joint, s: Section) -> list[tuple[What, Array]]:
    """What a joint keeps at zero, and in which direction."""
    every = list(np.eye(3))
    match joint:
        case motion.Spherical():
            return [("position", e) for e in every]
        case motion.Clamp():
            return [("position", e) for e in every] + _orientation(s)
        case motion.Guide():
            return [("position", _unit(e)) for e in joint.directions]
        case motion.Fixing():
            return [(VECTORS[joint.vector], _unit(e)) for e in joint.directions]
        case motion.Revolute():
            return [("position", e) for e in every] + _about(s, _unit(joint.axis))
        case motion.Cylindrical():
            axis = _unit(joint.axis)
            return [("position", e) for e in _across(axis)] + _about(s, axis)
        case motion.Prismatic():
            return [("position", e) for e in _across(_unit(joint.axis))] + _orientation(s)
        case motion.Planar():
            return [("position", _unit(joint.normal)), *_about(s, _unit(joint.normal))]
    raise TypeError(f"no equations of a {kind_of(joint)}")


def _orientation(s: Section) -> list[tuple[What, Array]]:
    kept: list[tuple[What, Array]] = [("turn", e) for e in s.axes]
    return kept if s.along_2.any() else kept[:2]  # a column of a shell has no drilling


def _about(s: Section, axis: Array) -> list[tuple[What, Array]]:
    """No turn but about an axis; a slope along it keeps it, however far the section turns."""
    if abs(s.axes[0] @ axis) > ASKEW or not s.along_2.any():
        return [("turn", e) for e in _across(axis)]
    slope = float(s.axes[1] @ axis), float(s.axes[2] @ axis)
    return [(slope, s.axes[0]), (slope, np.cross(s.axes[0], axis))]


def _across(axis: Array) -> list[Array]:
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = _unit(np.cross(axis, other))
    return [first, np.cross(axis, first)]


def _unit(a: Array) -> Array:
    a = np.asarray(a, float)
    return a / np.linalg.norm(a)


def groups(rows: Sequence[Row]) -> list[list[Row]]:
    """The rows that share nodes, directly or by others, together."""
    if not rows:
        return []
    nodes = np.concatenate([row.nodes for row in rows])
    owners = np.repeat(np.arange(len(rows)), [len(row.nodes) for row in rows])
    ones, shape = np.ones(len(nodes)), (len(rows), int(nodes.max()) + 1)
    uses = csr_array((ones, (owners, nodes)), shape=shape)
    count, label = connected_components(uses @ uses.T, directed=False)
    return [[rows[i] for i in np.flatnonzero(label == k).tolist()] for k in range(count)]


def equations(rows: Sequence[Row]) -> Equations:
    """The same rows solved for as many displacements, so that none of them depends on another.

    Rows that follow from others are dropped.
    """
    freedoms = np.unique(np.concatenate([3 * r.nodes[:, None] + np.arange(3) for r in rows]))
    matrix = np.zeros((len(rows), len(freedoms)))
    for i, row in enumerate(rows):
        columns = np.searchsorted(freedoms, 3 * row.nodes[:, None] + np.arange(3))
        np.add.at(matrix[i], columns.ravel(), row.factors.ravel())
        matrix[i] /= np.abs(matrix[i]).max()
    _, R, order = qr(matrix, mode="economic", pivoting=True)
    size = np.abs(np.diag(R))
    rank = int(np.sum(size > 1e-10 * size[0]))
    factors = solve_triangular(R[:rank, :rank], R[:rank, rank:])
    factors[np.abs(factors) < SMALLEST * np.abs(factors).max(initial=0.0)] = 0.0
    return Equations(freedoms[order[:rank]], freedoms[order[rank:]], factors)


# ------------------------------------------------------------------------------------ loads


class Pull(NamedTuple):
    """Nodal forces (k, 3) [N] of a load of amplitude 1, and the amplitude over time."""

    nodes: Indices
    forces: Array
    amplitude: motion.History


def pulls(d: Description, bodies: Mapping[str, Meshed]) -> list[Pull]:
    """The forces, moments and tractions of a description."""
    return [_pull(load, bodies) for load in d.loads]


def _pull(load: motion.Load, bodies: Mapping[str, Meshed]) -> Pull:
    if isinstance(load, motion.Traction):
        return _traction(load, bodies[load.body])
    assert isinstance(load, motion.Force | motion.Moment)
    s, offset = section_of(bodies, load.site), np.asarray(load.site.offset, float)
    direction = np.asarray(load.direction, float)
    if isinstance(load, motion.Moment):
        return Pull(s.nodes, _turning(s, s.axes @ direction), load.amplitude)
    forces = _Held(s, offset).row("position", direction).factors
    return Pull(s.nodes, forces, load.amplitude)


def _traction(load: motion.Traction, m: Meshed) -> Pull:
    """A force per area, through the thickness."""
    assert isinstance(m.body, motion.Shell)
    nodes = m.first + np.arange(len(m.points))
    areas = shares(m) / m.body.thickness
    return Pull(nodes, np.outer(areas, np.asarray(load.direction, float)), load.amplitude)


def shares(m: Meshed) -> Array:
    """(n,) [m^3]  integrals of the functions of the nodes."""
    from thermal.solid_elements import STORAGE, shape

    own = shape(m.family, STORAGE[m.family])
    tangents = np.einsum("qnd,cnx->cqdx", own.slopes, m.points[m.cells])
    volumes = np.abs(np.linalg.det(tangents)) * own.weights
    parts = np.einsum("cq,qn->cn", volumes, own.values)
    return np.bincount(m.cells.ravel(), parts.ravel(), len(m.points)).astype(np.float64)
