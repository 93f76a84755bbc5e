"""Joints as scalar constraint rows Φ(q, t) = 0, and the terms that they make.

Rows are of three kinds: an offset (r_A − r_B)·w − constant, a product of directions u·w, a
distance (|r_A − r_B|² − d²)/(2d). The multiplier of an offset or distance is a force [N], that of
a product a moment [N m]; M a + f + Φ_qᵀ λ = 0, so −λ acts on the first end along w.

A hinge to whose turn something refers has that turn φ as a coordinate, tied by
c sin φ − s cos φ = 0 with the cosine c and sine s of the turn of its ends: smooth over any number
of turns. A slide has its travel in the same way.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mechanics.constraints import NOTHING, Constraints, Linear, Product, Row, terms
from mechanics.description import (
    AxialDrive,
    Clamp,
    ClearanceRevolute,
    ClearanceTranslational,
    Cylindrical,
    Distance,
    Fixing,
    Gear,
    Guide,
    Joint,
    Latch,
    Planar,
    Prismatic,
    Pulley,
    Revolute,
    Site,
    Sliding,
    Spherical,
    TorsionSpring,
    Universal,
)
from mechanics.directions import (
    fixed,
    unit,
    unit_direction,
)
from mechanics.joint_rows import (
    SQUARE,
    Rows,
    across,
    along,
    apart,
    beside,
    held,
    offset,
    sides,
    tilt,
    together,
    turning,
)
from mechanics.layout import PLACE, TRAVEL, TURN, Layout, Side, family_of
from mechanics.relative import DISTANCE

Array = NDArray[np.float64]


def build(joints: Sequence[Joint], layout: Layout, first_row: int) -> list[Constraints]:
    """Terms of all joints; their multipliers have indices from ``first_row`` on, term by term.

    A joint that cannot be made is a ``ValueError`` with its name.
    """
    rows = []
    for joint in joints:
        if type(joint) in _MAKERS:
            made = _named(joint, partial(_MAKERS[type(joint)], joint, layout))
            rows += [(joint.name, row) for row in made]
    rows += _own_coordinates(joints, layout)
    found = terms(rows, layout, first_row)
    found += _sliding_terms(joints, layout, first_row + sum(term.rows for term in found))
    return found + _rope_terms(joints, layout, first_row + sum(term.rows for term in found))


def _named(joint: Joint, make: Callable[[], Rows]) -> Rows:
    try:
        return make()
    except ValueError as problem:
        raise ValueError(f"joint {joint.name!r}: {problem}") from None


def _sliding_terms(joints: Sequence[Joint], layout: Layout, first: int) -> list[Constraints]:
    chosen = [joint for joint in joints if isinstance(joint, Sliding)]
    if not chosen:
        return []
    from mechanics import sliding  # compiled only when used

    return sliding.build(chosen, layout, first)


def _rope_terms(joints: Sequence[Joint], layout: Layout, first: int) -> list[Constraints]:
    """Ropes without stiffness; the others are springs."""
    chosen = [joint for joint in joints if isinstance(joint, Pulley) and joint.stiffness is None]
    if not chosen:
        return []
    from mechanics import pulley

    return [pulley.build(chosen, layout, first)]


def _spherical(joint: Spherical, layout: Layout) -> Rows:
    return together(*sides(layout, joint.a, joint.b))


def _distance(joint: Distance, layout: Layout) -> Rows:
    """(|r_A − r_B|² − d²)/(2d) = L + L²/(2d), the length being d + L."""
    a, b = sides(layout, joint.a, joint.b)
    d = float(np.linalg.norm(a.position - b.position))
    if d == 0.0:
        raise ValueError("its two points coincide")
    w = np.zeros(7)
    w[3] = d
    return [Row(a, b, (Product(DISTANCE, NOTHING, w),), joint.length)]


def _guide(joint: Guide, layout: Layout) -> Rows:
    a, ground = sides(layout, joint.a, Site(None))
    return [offset(a, ground, fixed(e)) for e in _independent(joint.directions)]


def _independent(directions: Array) -> list[Array]:
    units = [unit(e) for e in np.atleast_2d(directions)]
    if np.linalg.matrix_rank(np.array(units), tol=1e-6) < len(units):
        raise ValueError("its directions are not independent")
    return units


def _fixing(joint: Fixing, layout: Layout) -> Rows:
    """A vector of a node keeps its reference value along fixed directions."""
    if joint.body not in layout.bodies:
        raise ValueError(f"there is no body {joint.body!r}")
    nodes, known = layout.node_dofs[joint.body], family_of(layout.bodies[joint.body]).vectors
    if joint.vector not in known:
        raise ValueError(f"{joint.body!r} has no {joint.vector!r}: {', '.join(known)}")
    if not -nodes.size <= joint.node < nodes.size:
        raise ValueError(f"body {joint.body!r} has {nodes.size} nodes, not a node {joint.node}")
    at = nodes[joint.node] + 3 * known.index(joint.vector) + np.arange(3)
    scale, value = float(layout.scale[at[0]]), layout.q0[at]
    return [
        Linear(at[e != 0.0], e[e != 0.0], float(e @ value), scale)
        for e in _independent(joint.directions)
    ]


# -- joints ------------------------------------------------------------------------------------


def _clamp(joint: Clamp, layout: Layout) -> Rows:
    """Position, and orientation with sections free to breathe, see ``_held``.

    A shell node keeps the turn of its tangents and is free to stretch and to shear in its plane;
    between nodes a bicubic edge is clamped where ``Fixing`` holds the twist vector as well.
    """
    a, b = sides(layout, joint.a, joint.b)
    turn = held(a, b, layout)
    if not apart(a, b):
        return together(a, b) + turn
    if b.directions == 1 or (a.fixed and not b.fixed):
        a, b = b, a
    return [offset(a, b, unit_direction(b, e)) for e in a.triad] + turn


def _universal(joint: Universal, layout: Layout) -> Rows:
    a, b = sides(layout, joint.a, joint.b)
    u, w = unit(joint.axis_a), unit(joint.axis_b)
    if abs(u @ w) > SQUARE:
        raise ValueError("its two axes are not at right angles")
    return [*together(a, b), across(a, u, b, w)]


def _revolute(joint: Revolute, layout: Layout) -> Rows:
    a, b = sides(layout, joint.a, joint.b)
    axis = unit(joint.axis)
    rows = together(a, b) + tilt(a, b, axis)
    return rows if joint.angle is None else [*rows, turning(a, b, axis, joint.angle)]


def _cylindrical(joint: Cylindrical, layout: Layout) -> Rows:
    a, b = sides(layout, joint.a, joint.b)
    axis = unit(joint.axis)
    rows = beside(a, b, axis) + tilt(a, b, axis) + along(a, b, axis, joint.travel)
    return rows if joint.angle is None else [*rows, turning(a, b, axis, joint.angle)]


def _prismatic(joint: Prismatic, layout: Layout) -> Rows:
    a, b = sides(layout, joint.a, joint.b)
    axis = unit(joint.axis)
    return beside(a, b, axis) + held(a, b, layout) + along(a, b, axis, joint.travel)


def _axial_drive(joint: AxialDrive, layout: Layout) -> Rows:
    """(r_A − r_B)·axis, the axis turning with b, keeps its value but for the travel."""
    a, b = sides(layout, joint.a, joint.b)
    if b.directions < 2 and not b.fixed:
        raise ValueError(f"{b.name!r} has no orientation that could turn an axis")
    return [offset(a, b, unit_direction(b, unit(joint.axis)), joint.travel)]


def _planar(joint: Planar, layout: Layout) -> Rows:
    a, b = sides(layout, joint.a, joint.b)
    normal = unit(joint.normal)
    return [offset(a, b, unit_direction(b, normal)), *tilt(a, b, normal)]


def _loose_revolute(joint: ClearanceRevolute, layout: Layout) -> Rows:
    """What the clearance leaves held: the drive; of a planar one the place along the axis, tilt."""
    a, b = sides(layout, joint.journal, joint.bearing)
    axis = unit(joint.axis)
    rows: Rows = [] if joint.angle is None else [turning(a, b, axis, joint.angle)]
    return rows if joint.length is not None else [*_flat(a, b, axis), *rows]


def _loose_slider(joint: ClearanceTranslational, layout: Layout) -> Rows:
    """What the clearance of a planar slider leaves held: its plane."""
    if joint.width is not None:
        return []
    a, b = sides(layout, joint.journal, joint.bearing)
    return _flat(a, b, unit(np.cross(joint.axis, joint.normal)))


def _flat(a: Side, b: Side, normal: Array) -> Rows:
    """``a`` stays in a plane of ``b``, and parallel to it if it has an orientation."""
    rows: Rows = [offset(a, b, unit_direction(b, normal))]
    return rows + tilt(a, b, normal) if a.fixed or a.directions else rows


# -- coordinates of joints ---------------------------------------------------------------------


def _sliding(joint: Sliding, layout: Layout) -> Rows:
    """The drive of the place; the other rows are in ``mechanics.sliding``."""
    if joint.travel is None:
        return []
    own = layout.joint_dofs[f"{joint.name}.{PLACE}"]
    scale, s = float(layout.scale[own]), float(layout.q0[own])
    return [Linear(np.array([own]), np.ones(1), s, scale, joint.travel)]


def _gear(joint: Gear, layout: Layout) -> Rows:
    if joint.first == joint.second:
        raise ValueError("it needs two joints")
    at = [layout.joint_dofs[f"{name}.{TURN}"] for name in (joint.second, joint.first)]
    return [Linear(np.array(at), np.array([1.0, -joint.ratio]), 0.0, 1.0)]


def _latch(joint: Latch, layout: Layout) -> Rows:
    """A row that is not active before its coordinate has reached ``at``."""
    found = [layout.joint_dofs.get(f"{joint.joint}.{kind}") for kind in (TRAVEL, TURN)]
    at = next(dof for dof in found if dof is not None)
    active = joint.at == 0.0
    return [Linear(np.array([at]), np.ones(1), joint.at, 1.0, active=active)]


def _own_coordinates(joints: Sequence[Joint], layout: Layout) -> list[tuple[str, Row | Linear]]:
    """The rows that tie turns and travels to the ends of their joints."""
    named = {joint.name: joint for joint in joints}
    rows: list[tuple[str, Row | Linear]] = []
    for user in joints:
        for name in _refers(user):
            _named(user, partial(_check_reference, named, name))
    for key, own in layout.joint_dofs.items():
        name, kind = key.rsplit(".", 1)
        if kind in _TIES:
            made = _named(named[name], partial(_TIES[kind], named[name], layout, own))
            rows += [(name, row) for row in made]
    return rows


def _refers(joint: Joint) -> tuple[str, ...]:
    if isinstance(joint, Gear):
        return joint.first, joint.second
    return (joint.joint,) if isinstance(joint, Latch | TorsionSpring) else ()


def _check_reference(named: dict[str, Joint], name: str) -> Rows:
    if name not in named:
        raise ValueError(f"there is no joint {name!r}")
    return []


def _tied_turn(joint: Joint, layout: Layout, own: int) -> Rows:
    if isinstance(joint, ClearanceRevolute):
        a, b = sides(layout, joint.journal, joint.bearing)
    elif isinstance(joint, Revolute | Cylindrical):
        a, b = sides(layout, joint.a, joint.b)
    else:
        raise ValueError("it has no turn for another joint to refer to")
    return [turning(a, b, unit(joint.axis), own=own)]


def _tied_travel(joint: Joint, layout: Layout, own: int) -> Rows:
    if not isinstance(joint, Prismatic | Cylindrical):
        raise ValueError("it has no travel for another joint to refer to")
    a, b = sides(layout, joint.a, joint.b)
    return [offset(a, b, unit_direction(b, unit(joint.axis)), own=own)]


_TIES: dict[str, Callable[..., Rows]] = {TURN: _tied_turn, TRAVEL: _tied_travel}

_MAKERS: dict[type, Callable[..., Rows]] = {
    Clamp: _clamp,
    Spherical: _spherical,
    Universal: _universal,
    Revolute: _revolute,
    Cylindrical: _cylindrical,
    Prismatic: _prismatic,
    Planar: _planar,
    AxialDrive: _axial_drive,
    Distance: _distance,
    Guide: _guide,
    Fixing: _fixing,
    Sliding: _sliding,
    Gear: _gear,
    Latch: _latch,
    ClearanceRevolute: _loose_revolute,
    ClearanceTranslational: _loose_slider,
}
