"""Rows of which joints are made: points that coincide or stay on lines, axes that stay parallel."""

import numpy as np
from numpy.typing import NDArray

from mechanics.constraints import NOTHING, Linear, Product, Row
from mechanics.description import History, RigidBody, Site
from mechanics.directions import (
    ALIGNED,
    direction,
    fixed,
    normal_to,
    only_direction,
    section_axes,
    unit_direction,
)
from mechanics.layout import Layout, Side
from mechanics.relative import DIRECTION, OFFSET

Array = NDArray[np.float64]
Rows = list[Row | Linear]

APART = 1e-6
"""Distance over body size above which two points do not coincide [-]."""
SQUARE = 1e-6
"""Cosine above which two axes are not at right angles [-]."""


def sides(layout: Layout, a: Site, b: Site) -> tuple[Side, Side]:
    """Both ends of a joint, of which one at least is on a body."""
    ends = layout.site(a), layout.site(b)
    if ends[0].fixed and ends[1].fixed:
        raise ValueError("both ends are on the ground")
    return ends


def together(a: Side, b: Side) -> Rows:
    """Three rows: the two points coincide."""
    if apart(a, b):
        gap = np.linalg.norm(a.position - b.position)
        raise ValueError(f"its two points are {gap:.6g} m apart")
    return [offset(a, b, fixed(e)) for e in np.eye(3)]


def apart(a: Side, b: Side) -> bool:
    """Whether the two points do not coincide in the reference."""
    return bool(np.linalg.norm(a.position - b.position) > APART * max(a.size, b.size))


def offset(
    a: Side, b: Side, w: Array, drive: History | None = None, own: int = -1
) -> Row:  # fmt: skip
    """(r_A − r_B)·w keeps its reference value but for what drives it and its own coordinate."""
    return Row(a, b, (Product(OFFSET, NOTHING, w),), drive, own=own)


def across(a: Side, u: Array, b: Side, w: Array) -> Row:
    """Direction u of ``a`` stays normal to direction w of ``b``."""
    return Row(a, b, (Product(DIRECTION, direction(a, u), direction(b, w)),))


def held(a: Side, b: Side, layout: Layout) -> Rows:
    """Orientation of ``a`` in ``b``, sections free to breathe.

    Lengths of the vectors of a section and the angle between them stay free. About the normal of
    the section (of a shell: its own) the mean turn of two directions e', e'' in its plane is
    held, (e'_A·e''_B − e''_A·e'_B)/2: the torsion of a beam is measured and loaded in the same
    way, whereas e'·e'' alone would let a torque shear the section and twist it freely. The
    directions are those of a flexible section: oblique to it they would turn as it deforms.
    """
    if b.directions == 1 or (a.directions != 1 and _stiff(a, layout) and not _stiff(b, layout)):
        a, b = b, a
    if a.directions == 1:
        own = only_direction(a)
        first = normal_to(own, a.triad)
        return [across(a, own, b, w) for w in (first, np.cross(own, first))]
    normal, first, second = section_axes(a)
    products = (
        Product(DIRECTION, direction(a, first), direction(b, second), 0.5),
        Product(DIRECTION, direction(a, second), direction(b, first), -0.5),
    )
    return [across(a, first, b, normal), across(a, second, b, normal), Row(a, b, products)]


def _stiff(side: Side, layout: Layout) -> bool:
    return side.fixed or isinstance(layout.bodies[side.name], RigidBody)


def tilt(a: Side, b: Side, axis: Array) -> Rows:
    """The axis of ``a`` and of ``b`` stay parallel; one row for a cable across the axis."""
    if b.directions == 1 and not b.fixed:
        a, b = b, a
    if a.directions == 1 and not a.fixed and abs(only_direction(a) @ axis) < ALIGNED:
        return [across(a, only_direction(a), b, axis)]
    w = normal_to(axis, b.triad)
    return [across(a, axis, b, w), across(a, axis, b, np.cross(axis, w))]


def turning(
    a: Side, b: Side, axis: Array, angle: History | None = None, own: int = -1
) -> Row:  # fmt: skip
    """sin(turn of a relative to b − angle − own) = 0; its slope is one at every angle."""
    if b.directions == 1 and not b.fixed:
        a, b, axis = b, a, -axis
    first = only_direction(a) if a.directions == 1 and not a.fixed else normal_to(axis, a.triad)
    if abs(first @ axis) > SQUARE:
        raise ValueError(f"{a.name!r} has no turn about its own direction")
    w, sine = direction(b, np.cross(axis, first)), direction(b, first)
    return Row(a, b, (Product(DIRECTION, direction(a, first), w),), angle, sine, own)


def beside(a: Side, b: Side, axis: Array) -> Rows:
    """Two rows: ``a`` stays on a line of ``b`` along ``axis``."""
    w = normal_to(axis, b.triad)
    return [offset(a, b, unit_direction(b, e)) for e in (w, np.cross(axis, w))]


def along(a: Side, b: Side, axis: Array, travel: History | None) -> Rows:
    """The row, if any, that drives ``a`` along ``axis`` of ``b``."""
    return [] if travel is None else [offset(a, b, unit_direction(b, axis), travel)]
