"""A point of one body that slides along the axis of another, flexible one.

The place of the point on the axis, arc length s of the reference, is a massless coordinate with
the equation λ·∂Φ/∂s = 0: no force along the axis. In the element that s is in, the axis is
r(s) = Σ h_j(s) y_j with Hermite functions h of the nodes' r and r_x, so that r'(s) has no jump from
element to element; beyond the ends it is continued straight. Sections turn with linear weights
between nodes (a cable: with r'), hence with a kink at nodes where the body is twisted.

The rows know all nodes of the body, and enter the element that s is in (Sugiyama, Escalona &
Shabana 2003, Formulation of three-dimensional joint constraints using the absolute nodal
coordinates, gives the conditions; here s is found from them and not from its own dynamics).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.constraints import Constraints, Limit, Row, needed
from mechanics.description import Beam, Site, Sliding
from mechanics.joint_rows import held
from mechanics.layout import PLACE, Layout, Side, family_of
from mechanics.line_elements import node_places
from mechanics.relative import PRODUCT, WIDTH
from mechanics.sliding_kernels import (
    A_WEIGHTS,
    ENDS,
    add_orientation_force,
    add_orientation_tangent,
    add_position_force,
    add_position_tangent,
)

Array = NDArray[np.float64]

_APART = 1e-6  # distance over body size above which a point is not on an axis


class Track(NamedTuple):
    """The body on which a point slides.

    first, stride, nodes : first coordinate, coordinates of a node, number of nodes
    lengths : (nodes,) float [m]  arc length at the nodes
    """

    body: Beam
    first: int
    stride: int
    nodes: int
    lengths: Array


def build(joints: Sequence[Sliding], layout: Layout, first: int) -> list[Constraints]:
    """Terms of all sliding joints, with multipliers from ``first`` on."""
    positions, turns = [], []
    for joint in joints:
        try:
            track, a, rows = _parts(joint, layout)
        except ValueError as problem:
            raise ValueError(f"joint {joint.name!r}: {problem}") from None
        positions += [(joint, track, a, axis) for axis in range(3)]
        turns += [(joint, track, row, row.b.name == joint.body) for row in rows]
    found = [_position_term(positions, layout, first)] if positions else []
    return found + ([_turn_term(turns, layout, first + len(positions))] if turns else [])


def _parts(joint: Sliding, layout: Layout) -> tuple[Track, Side, list[Row]]:
    """The body below, the end that slides and the rows of an aligned section."""
    track, a = _track(joint, layout), layout.site(joint.a)
    e, fraction = _where(joint, layout, track)
    b = layout.site(Site(joint.body, e, fraction=fraction))
    _check(a, b)
    rows = held(a, b, layout) if joint.aligned else []
    return track, a, [row for row in rows if isinstance(row, Row)]


def _check(a: Side, b: Side) -> None:
    gap = np.linalg.norm(a.position - b.position)
    if gap > _APART * max(a.size, b.size):
        raise ValueError(f"its point is {gap:.6g} m off the axis of {b.name!r}")
    if a.name == b.name:
        raise ValueError("a body does not slide on itself")


def _track(joint: Sliding, layout: Layout) -> Track:
    body = layout.bodies[joint.body]
    assert isinstance(body, Beam)  # the layout has checked
    lengths = node_places(body.points, body.axes)
    nodes = layout.node_dofs[joint.body]
    return Track(body, int(nodes[0]), layout.kinds[joint.body], nodes.size, lengths)


def _where(joint: Sliding, layout: Layout, track: Track) -> tuple[int, float]:
    """Node and fraction of the place in the reference."""
    s = layout.q0[layout.joint_dofs[f"{joint.name}.{PLACE}"]]
    e = min(int(np.searchsorted(track.lengths, s, side="right")) - 1, track.nodes - 1)
    if e == track.nodes - 1:
        return e, 0.0
    fraction = (s - track.lengths[e]) / (track.lengths[e + 1] - track.lengths[e])
    return e, float(fraction)


def _limits(joints: Sequence[Sliding], tracks: Sequence[Track], layout: Layout) -> list[Limit]:
    limits = {}
    for joint, track in zip(joints, tracks, strict=True):
        reason = f"joint {joint.name!r} slides off the end of {joint.body!r}"
        place = layout.joint_dofs[f"{joint.name}.{PLACE}"]
        limits[place] = Limit(place, 0.0, float(track.lengths[-1]), reason)
    return list(limits.values())


def _term(name: str, joints: Sequence[Sliding], parts: dict, scale: Array) -> Constraints:
    return Constraints(
        name, [joint.name for joint in joints], start=np.zeros((len(joints), 1)), signals=[],
        driven=np.zeros(len(joints), dtype=bool), scale=scale, **parts,
    )  # fmt: skip


def _position_term(
    rows: Sequence[tuple[Sliding, Track, Side, int]], layout: Layout, first: int
) -> Constraints:
    K, N = max(a.vectors.size for _, _, a, _ in rows), max(t.nodes for _, t, _, _ in rows)
    dofs = np.full((len(rows), K + 2 * N + 2), -1, dtype=np.intp)
    ints = np.full((len(rows), ENDS + 2 + K), -1, dtype=np.int64)
    floats = np.zeros((len(rows), 1 + K + N))
    for i, (joint, track, a, axis) in enumerate(rows):
        place, at = layout.joint_dofs[f"{joint.name}.{PLACE}"], a.vectors + axis
        nodes = track.first + axis + track.stride * np.arange(track.nodes)
        dofs[i, : at.size], dofs[i, -2:] = at, (place, first + i)
        dofs[i, K : K + 2 * track.nodes] = (nodes[:, None] + [0, 3]).ravel()
        ints[i, : ENDS + 2] = first + i, place, nodes[0], track.stride, track.nodes, at.size, N
        ints[i, ENDS + 2 : ENDS + 2 + at.size] = at
        floats[i, 0] = a.position[axis] * a.fixed
        floats[i, 1 : 1 + at.size] = a.weights[0]
        floats[i, 1 + K : 1 + K + track.nodes] = track.lengths
    joints = [joint for joint, *_ in rows]
    limits = _limits(joints, [track for _, track, *_ in rows], layout)
    scale = np.array([max(a.size, float(track.lengths[-1])) for _, track, a, _ in rows])
    parts = {"dofs": dofs, "ints": ints, "floats": floats, "limits": limits}
    kernels = {"force": add_position_force, "tangent": add_position_tangent}
    return _term("sliding joints", joints, parts | kernels, scale)


def _turn_term(
    rows: Sequence[tuple[Sliding, Track, Row, bool]], layout: Layout, first: int
) -> Constraints:
    others = [needed(row.a if moving else row.b, row, 1 - moving) for *_, row, moving in rows]
    K, N = max(a.vectors.size for a in others), max(track.nodes for _, track, *_ in rows)
    dofs = np.full((len(rows), 3 * K + 6 * N + 2), -1, dtype=np.intp)
    ints = np.full((len(rows), ENDS + 7 + K), -1, dtype=np.int64)
    floats = np.zeros((len(rows), A_WEIGHTS + 3 * K + N))
    for i, ((joint, track, row, moving), a) in enumerate(zip(rows, others, strict=True)):
        place, k, n = layout.joint_dofs[f"{joint.name}.{PLACE}"], a.vectors.size, track.nodes
        section = family_of(track.body).section
        cable = section == (1,)
        offsets = np.array([0, 3] if cable else [3 * section[0], 3 * section[1]])
        nodes = track.first + track.stride * np.arange(n)
        held = (nodes[:, None] + offsets).ravel()
        dofs[i, : 3 * k] = (a.vectors[:, None] + np.arange(3)).ravel()
        dofs[i, 3 * K : 3 * K + 6 * n] = (held[:, None] + np.arange(3)).ravel()
        dofs[i, -2:] = place, first + i
        ints[i, : ENDS + 2] = first + i, place, nodes[0], track.stride, n, k, N
        ints[i, ENDS + 2 : ENDS + 7] = moving, len(row.products), *offsets, cable
        ints[i, ENDS + 7 : ENDS + 7 + k] = a.vectors
        for j, p in enumerate(row.products):
            start = PRODUCT + WIDTH * j
            floats[i, start : start + WIDTH] = p.weight, *p.u, *p.w
        floats[i, A_WEIGHTS : A_WEIGHTS + 3 * k] = a.weights.T.ravel()
        floats[i, A_WEIGHTS + 3 * K : A_WEIGHTS + 3 * K + n] = track.lengths
    kernels = {"force": add_orientation_force, "tangent": add_orientation_tangent}
    parts = {"dofs": dofs, "ints": ints, "floats": floats} | kernels
    return _term("aligned sliding joints", [j for j, *_ in rows], parts, np.ones(len(rows)))
