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

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics.constraints import Constraints, Limit, Linear, Row, needed
from mechanics.description import Beam, Site, Sliding
from mechanics.kernels import FORCE, TANGENT, kernel
from mechanics.layout import PLACE, Layout, Side, family_of
from mechanics.line_elements import arc_lengths
from mechanics.relative import (
    DIRECTION,
    PRODUCT,
    WIDTH,
    evaluate,
    expand,
    gather,
    scratch,
    spread,
)

Array = NDArray[np.float64]

_APART = 1e-6
_NODES, _VECTORS, _ENDS = 2, 9, 5
"""Columns of ``ints``: multiplier, place; first coordinate of the body, from node to node, nodes;
vectors of the other end; then (aligned rows) the end that moves along, products, their second
kind; offsets of two vectors in a node, 1 for a cable; vectors of the other end."""


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


@njit(cache=True, error_model="numpy")
def _element(s, floats, at, nodes):
    """Element that s is in: 0 to nodes − 2, also for s beyond the ends."""
    e = 0
    while e < nodes - 2 and s > floats[at + e + 1]:
        e += 1
    return e


@njit(cache=True, error_model="numpy")
def _hermite(s, a, b, h):
    """h (4, 4): weights of r_a, r_x,a, r_b, r_x,b in r, r', r'', r''' at s; straight beyond."""
    L, x = b - a, (s - a) / (b - a)
    h[:] = 0.0
    if x < 0.0:
        h[0, 0], h[0, 1], h[1, 1] = 1.0, s - a, 1.0
    elif x > 1.0:
        h[0, 2], h[0, 3], h[1, 3] = 1.0, s - b, 1.0
    else:
        h[0, 0], h[0, 2] = (1.0 - x) ** 2 * (1.0 + 2.0 * x), x * x * (3.0 - 2.0 * x)
        h[0, 1], h[0, 3] = L * x * (1.0 - x) ** 2, L * x * x * (x - 1.0)
        h[1, 2], h[1, 1], h[1, 3] = 6.0 * x * (1.0 - x) / L, (1 - x) * (1 - 3 * x), x * (3 * x - 2)
        h[2, 2], h[2, 1], h[2, 3] = (6 - 12 * x) / L**2, (6 * x - 4) / L, (6 * x - 2) / L
        h[3, 2], h[3, 1], h[3, 3] = -12.0 / L**3, 6.0 / L**2, 6.0 / L**2
        for k in range(1, 4):
            h[k, 0] = -h[k, 2]


# -- position: one row for each direction of space ---------------------------------------------


@njit(cache=True, error_model="numpy")
def _position(y, ints, floats, h, at):
    """Φ and −∂Φ/∂s, −∂²Φ/∂s² of one row; ``at`` (4,): the coordinates that ``h`` weighs."""
    s, nodes = y[ints[1]], ints[_NODES + 2]
    S = floats.size - ints[_ENDS + 1]
    e = _element(s, floats, S, nodes)
    _hermite(s, floats[S + e], floats[S + e + 1], h)
    for j in range(4):
        at[j] = ints[_NODES] + (e + j // 2) * ints[_NODES + 1] + 3 * (j % 2)
    value, first, second = floats[0], 0.0, 0.0
    for k in range(ints[_ENDS]):
        value += floats[1 + k] * y[ints[_ENDS + 2 + k]]
    for j in range(4):
        value -= h[0, j] * y[at[j]]
        first += h[1, j] * y[at[j]]
        second += h[2, j] * y[at[j]]
    return value, first, second, e


@kernel(FORCE)
def add_position_force(y, v, coef, ints, floats, out):
    h, at = np.empty((4, 4)), np.empty(4, np.int64)
    for e in range(ints.shape[0]):
        value, first, _, _ = _position(y, ints[e], floats[e], h, at)
        lam = y[ints[e, 0]]
        out[ints[e, 0]] += value
        out[ints[e, 1]] -= lam * first
        for k in range(ints[e, _ENDS]):
            out[ints[e, _ENDS + 2 + k]] += lam * floats[e, 1 + k]
        for j in range(4):
            out[at[j]] -= lam * h[0, j]


@kernel(TANGENT)
def add_position_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    h, at = np.empty((4, 4)), np.empty(4, np.int64)
    K = ints.shape[1] - _ENDS - 2
    for e in range(ints.shape[0]):
        _, first, second, element = _position(y, ints[e], floats[e], h, at)
        n, f, slot = int(np.sqrt(slots.shape[1]) + 0.5), cK * y[ints[e, 0]], slots[e]
        place, last = n - 2, n - 1
        for k in range(ints[e, _ENDS]):
            data[slot[k * n + last]] += floats[e, 1 + k]
            data[slot[last * n + k]] += floats[e, 1 + k]
        for j in range(4):
            i = K + 2 * element + j
            data[slot[i * n + last]] -= h[0, j]
            data[slot[last * n + i]] -= h[0, j]
            data[slot[i * n + place]] -= f * h[1, j]
            data[slot[place * n + i]] -= f * h[1, j]
        data[slot[place * n + last]] -= first
        data[slot[last * n + place]] -= first
        data[slot[place * n + place]] -= f * second


# -- orientation -------------------------------------------------------------------------------

_A_WEIGHTS = PRODUCT + 2 * WIDTH


@njit(cache=True, error_model="numpy")
def _passing(y, ints, floats, h, V, at):
    """V (3, 4, 2): weights of four vectors in p, s and their first two derivatives by s."""
    s, nodes = y[ints[1]], ints[_NODES + 2]
    S = floats.size - ints[_ENDS + 1]
    e = _element(s, floats, S, nodes)
    a, b = floats[S + e], floats[S + e + 1]
    _hermite(s, a, b, h)
    x = min(max((s - a) / (b - a), 0.0), 1.0)
    V[:] = 0.0
    for j in range(4):
        node, which = j // 2, j % 2
        at[j] = ints[_NODES] + (e + node) * ints[_NODES + 1] + ints[_ENDS + 4 + which]
        if ints[_ENDS + 6] == 1:
            for k in range(3):
                V[k, j, 0] = h[k + 1, j]
        else:
            V[0, j, which] = x if node else 1.0 - x
            if a < s < b:
                V[1, j, which] = (1.0 if node else -1.0) / (b - a)
    return e


@njit(cache=True, error_model="numpy")
def _orientation(y, ints, floats, h, V, at, x, d, gradient, bend, work):
    """Φ, its gradient and bend by r, p, s of both ends; d (2, 18): first and second dx/ds."""
    e, moving, K = _passing(y, ints, floats, h, V, at), ints[_ENDS + 2], ints[_ENDS]
    vectors = ints[_ENDS + 7 :]
    gather(y, vectors, floats[_A_WEIGHTS:], K, x, 9 * (1 - moving))
    d[:] = 0.0
    for m in range(3):
        for i in range(3):
            o = 9 * moving + 3 * m + i
            x[o] = 0.0
            if m > 0:
                for j in range(4):
                    x[o] += V[0, j, m - 1] * y[at[j] + i]
                    d[0, o] += V[1, j, m - 1] * y[at[j] + i]
                    d[1, o] += V[2, j, m - 1] * y[at[j] + i]
    gradient[:] = 0.0
    bend[:] = 0.0
    value = -floats[0]
    for k in range(ints[_ENDS + 3]):
        o = PRODUCT + WIDTH * k
        u, w = floats[o + 1 :], floats[o + 8 :]
        value += evaluate(DIRECTION, x, floats[1:], u, w, floats[o], gradient, bend, work)
    return value, e


@kernel(FORCE)
def add_orientation_force(y, v, coef, ints, floats, out):
    h, V, at, none = np.empty((4, 4)), np.empty((3, 4, 2)), np.empty(4, np.int64), np.empty((0, 18))
    x, d, gradient, work = np.empty(18), np.empty((2, 18)), np.empty(18), scratch()
    near = np.empty(24)
    for e in range(ints.shape[0]):
        line, lam = ints[e], y[ints[e, 0]]
        value, _ = _orientation(y, line, floats[e], h, V, at, x, d, gradient, none, work)
        out[line[0]] += value
        moving, K = line[_ENDS + 2], line[_ENDS]
        near[:] = 0.0
        expand(gradient, 9 * (1 - moving), floats[e, _A_WEIGHTS:], K, near, 0)
        for k in range(K):
            for i in range(3):
                out[line[_ENDS + 7 + k] + i] += lam * near[3 * k + i]
        for o in range(18):
            out[line[1]] += lam * gradient[o] * d[0, o]
        for j in range(4):
            for m in range(2):
                for i in range(3):
                    out[at[j] + i] += lam * V[0, j, m] * gradient[9 * moving + 3 + 3 * m + i]


@kernel(TANGENT)
def add_orientation_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    h, V, at, bend = (
        np.empty((4, 4)),
        np.empty((3, 4, 2)),
        np.empty(4, np.int64),
        np.empty((18, 18)),
    )
    x, d, gradient, work = np.empty(18), np.empty((2, 18)), np.empty(18), scratch()
    A = ints.shape[1] - _ENDS - 7  # vectors of the other end
    K = max(A, 4)
    counts, weights, local = np.zeros(2, np.int64), np.zeros(6 * K), np.empty(6 * K, np.int64)
    half, H, row, mixed = (
        np.empty((18, 6 * K)),
        np.empty((6 * K, 6 * K)),
        np.empty(6 * K),
        np.empty(6 * K),
    )
    turned, weights1 = np.empty(18), np.zeros(6 * K)
    for e in range(ints.shape[0]):
        line, f, slot = ints[e], cK * y[ints[e, 0]], slots[e]
        _, element = _orientation(y, line, floats[e], h, V, at, x, d, gradient, bend, work)
        n = int(np.sqrt(slots.shape[1]) + 0.5)
        place, last, moving, other = n - 2, n - 1, line[_ENDS + 2], 1 - line[_ENDS + 2]
        counts[moving], counts[other] = 4, line[_ENDS]
        weights[:] = 0.0
        weights1[:] = 0.0
        for i in range(3 * line[_ENDS]):
            weights[3 * K * other + i] = floats[e, _A_WEIGHTS + i]
            local[3 * K * other + i] = i
        for j in range(4):
            for m in range(2):
                weights[3 * K * moving + 3 * j + 1 + m] = V[0, j, m]
                weights1[3 * K * moving + 3 * j + 1 + m] = V[1, j, m]
            for i in range(3):
                local[3 * K * moving + 3 * j + i] = 3 * A + 6 * element + 3 * j + i
        for o in range(18):
            turned[o] = 0.0
            for i in range(18):
                turned[o] += bend[o, i] * d[0, i]
        row[:] = 0.0
        mixed[:] = 0.0
        for side in range(2):
            to = 3 * K * side
            expand(gradient, 9 * side, weights[to:], counts[side], row, to)
            expand(turned, 9 * side, weights[to:], counts[side], mixed, to)
            expand(gradient, 9 * side, weights1[to:], counts[side], mixed, to)
        slope, second = 0.0, 0.0
        for o in range(18):
            slope += gradient[o] * d[0, o]
            second += turned[o] * d[0, o] + gradient[o] * d[1, o]
        data[slot[place * n + last]] += slope
        data[slot[last * n + place]] += slope
        data[slot[place * n + place]] += f * second
        spread(bend, weights, counts, K, half, H)
        for side in range(2):
            for i in range(3 * K * side, 3 * (K * side + counts[side])):
                a = local[i]
                data[slot[a * n + last]] += row[i]
                data[slot[last * n + a]] += row[i]
                data[slot[a * n + place]] += f * mixed[i]
                data[slot[place * n + a]] += f * mixed[i]
                for facing in range(2):
                    for j in range(3 * K * facing, 3 * (K * facing + counts[facing])):
                        data[slot[a * n + local[j]]] += f * H[i, j]


# -- building ----------------------------------------------------------------------------------


def build(
    joints: Sequence[Sliding],
    layout: Layout,
    first: int,
    held: Callable[[Side, Side], list[Row | Linear]],
) -> list[Constraints]:
    """Terms of all sliding joints; ``held`` makes the rows that keep two sections together."""
    positions, turns = [], []
    for joint in joints:
        try:
            track, a, rows = _parts(joint, layout, held)
        except ValueError as problem:
            raise ValueError(f"joint {joint.name!r}: {problem}") from None
        positions += [(joint, track, a, axis) for axis in range(3)]
        turns += [(joint, track, row, row.b.name == joint.body) for row in rows]
    found = [_position_term(positions, layout, first)] if positions else []
    return found + ([_turn_term(turns, layout, first + len(positions))] if turns else [])


def _parts(
    joint: Sliding, layout: Layout, held: Callable[[Side, Side], list[Row | Linear]]
) -> tuple[Track, Side, list[Row]]:
    """The body below, the end that slides and the rows of an aligned section."""
    track, a = _track(joint, layout), layout.site(joint.a)
    e, fraction = _where(joint, layout, track)
    b = layout.site(Site(joint.body, e, fraction=fraction))
    _check(a, b)
    rows = held(a, b) if joint.aligned else []
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
    points, slopes = np.asarray(body.points, float), np.asarray(body.axes, float)[:, 0]
    pairs = [np.stack([x[:-1], x[1:]], axis=1) for x in (points, slopes)]
    lengths = np.concatenate([[0.0], np.cumsum(arc_lengths(*pairs))])
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
    ints = np.full((len(rows), _ENDS + 2 + K), -1, dtype=np.int64)
    floats = np.zeros((len(rows), 1 + K + N))
    for i, (joint, track, a, axis) in enumerate(rows):
        place, at = layout.joint_dofs[f"{joint.name}.{PLACE}"], a.vectors + axis
        nodes = track.first + axis + track.stride * np.arange(track.nodes)
        dofs[i, : at.size], dofs[i, -2:] = at, (place, first + i)
        dofs[i, K : K + 2 * track.nodes] = (nodes[:, None] + [0, 3]).ravel()
        ints[i, : _ENDS + 2] = first + i, place, nodes[0], track.stride, track.nodes, at.size, N
        ints[i, _ENDS + 2 : _ENDS + 2 + at.size] = at
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
    ints = np.full((len(rows), _ENDS + 7 + K), -1, dtype=np.int64)
    floats = np.zeros((len(rows), _A_WEIGHTS + 3 * K + N))
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
        ints[i, : _ENDS + 2] = first + i, place, nodes[0], track.stride, n, k, N
        ints[i, _ENDS + 2 : _ENDS + 7] = moving, len(row.products), *offsets, cable
        ints[i, _ENDS + 7 : _ENDS + 7 + k] = a.vectors
        for j, p in enumerate(row.products):
            start = PRODUCT + WIDTH * j
            floats[i, start : start + WIDTH] = p.weight, *p.u, *p.w
        floats[i, _A_WEIGHTS : _A_WEIGHTS + 3 * k] = a.weights.T.ravel()
        floats[i, _A_WEIGHTS + 3 * K : _A_WEIGHTS + 3 * K + n] = track.lengths
    kernels = {"force": add_orientation_force, "tangent": add_orientation_tangent}
    parts = {"dofs": dofs, "ints": ints, "floats": floats} | kernels
    return _term("aligned sliding joints", [j for j, *_ in rows], parts, np.ones(len(rows)))
