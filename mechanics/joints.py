"""Joints as scalar constraint rows Φ(q, t) = 0.

Rows are of three kinds: an offset (r_A − r_B)·w − constant, a product of directions u·w, a
distance (|r_A − r_B|² − d²)/(2d). The multiplier of an offset or distance is a force [N], that of
a product a moment [N m]; M a + f + Φ_qᵀ λ = 0, so −λ acts on the first end along w.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import (
    Clamp,
    ClearanceRevolute,
    Distance,
    Guide,
    History,
    Joint,
    Revolute,
    Site,
    Spherical,
)
from mechanics.layout import BEAM, CABLE, FIXED, PARTICLE, Layout, Side
from mechanics.relative import DIRECTION, DISTANCE, OFFSET, Terms, evaluate

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_NOTHING = np.zeros(7)
_NO_BENDS = np.empty((0, 18, 18))
_ALIGNED = 1e-9  # sine or cosine below which two reference directions count as aligned
_APART = 1e-6  # distance over body size above which two points do not coincide


class Product(NamedTuple):
    """One term of a row: ``weight`` times a·w; see ``mechanics.relative`` for u and w."""

    kind: int
    u: Array
    w: Array
    weight: float = 1.0


class Drive(NamedTuple):
    """w turns by angle(t): cos(angle) w − sin(angle) ``sine``."""

    angle: History
    sine: Array


class Row(NamedTuple):
    """One equation between two ends: a sum of products, of which a drive turns the first."""

    a: Side
    b: Side
    products: tuple[Product, ...]
    drive: Drive | None = None


@dataclass(frozen=True)
class Constraints:
    """All rows of a system.

    Attributes
    ----------
    names : joint of each row
    dofs : (m, 18) int  coordinates of the row; -1 where absent
    driven : (m,) bool  rows that depend on time
    scale : (m,) float [m] or [1]  size of the row's value: body length or 1 for directions
    """

    names: tuple[str, ...]
    dofs: Indices
    driven: NDArray[np.bool_]
    scale: Array
    terms: Terms
    constant: Array
    drives: tuple[tuple[int, Drive], ...]

    def values(self, q: Array, t: float) -> Array:
        """(m,) float [m] or [1]  Φ; zero in the reference when the drives are at angle zero."""
        return self._evaluate(q, t, np.zeros(self.dofs.shape))

    def jacobian(self, q: Array, t: float, blocks: Array) -> None:
        """Overwrite ``blocks`` (m, 18) with ∂Φ/∂q; zeros where a coordinate is absent."""
        blocks[:] = 0.0
        self._evaluate(q, t, blocks)

    def add_force(self, q: Array, t: float, lam: Array, out: Array) -> Array:
        """out += Φ_qᵀ λ for multipliers ``lam`` (m,); returns Φ (m,), evaluated on the way."""
        blocks = np.zeros(self.dofs.shape)
        values = self._evaluate(q, t, blocks)
        present = self.dofs >= 0
        np.add.at(out, self.dofs[present], (blocks * lam[:, None])[present])
        return values

    def hessian(self, q: Array, t: float, lam: Array, cK: float, blocks: Array) -> None:
        """Overwrite ``blocks`` (m, 18, 18) with cK λ_i ∂²Φ_i/∂q².

        Entries of absent coordinates mean nothing and are to be dropped.
        """
        blocks[:] = 0.0
        terms = self._at(t)
        weighted = terms._replace(weight=cK * terms.weight * lam[terms.row])
        evaluate(*weighted, q, np.zeros(len(lam)), np.zeros(self.dofs.shape), blocks)

    def _at(self, t: float) -> Terms:
        if not self.drives:
            return self.terms
        w = self.terms.w.copy()
        for term, drive in self.drives:
            angle = drive.angle(t)
            w[term] = np.cos(angle) * w[term] - np.sin(angle) * drive.sine
        return self.terms._replace(w=w)

    def _evaluate(self, q: Array, t: float, blocks: Array) -> Array:
        values = -self.constant
        evaluate(*self._at(t), q, values, blocks, _NO_BENDS)
        return values


def build(joints: Sequence[Joint], layout: Layout) -> Constraints:
    """Rows of all joints; a joint that cannot be made is a ``ValueError`` with its name."""
    names, rows = [], []
    for joint in joints:
        try:
            made = _MAKERS[type(joint)](joint, layout)
        except ValueError as problem:
            raise ValueError(f"joint {joint.name!r}: {problem}") from None
        names += [joint.name] * len(made)
        rows += made
    terms, first = _terms(rows)
    reference = np.zeros(len(rows))
    evaluate(*terms, layout.q0, reference, np.zeros((len(rows), 18)), _NO_BENDS)
    return Constraints(
        names=tuple(names),
        dofs=terms.dofs[first],
        driven=np.array([row.drive is not None for row in rows], dtype=bool),
        scale=np.array([_scale(row, layout) for row in rows]),
        terms=terms,
        constant=reference,
        drives=tuple((i, row.drive) for i, row in zip(first, rows, strict=True) if row.drive),
    )


def _terms(rows: Sequence[Row]) -> tuple[Terms, Indices]:
    """Arrays of all products, and the first product of each row."""
    counts = np.array([len(row.products) for row in rows], dtype=np.intp)
    flat = [(i, row, product) for i, row in enumerate(rows) for product in row.products]
    terms = Terms(
        kind=np.array([p.kind for _, _, p in flat], dtype=np.intp),
        row=np.array([i for i, _, _ in flat], dtype=np.intp),
        weight=np.array([p.weight for _, _, p in flat], dtype=float),
        dofs=_array([np.concatenate([r.a.dofs, r.b.dofs]) for _, r, _ in flat], 18, np.intp),
        origin=_array([origin(r.a, r.b) for _, r, _ in flat], 3),
        u=_array([p.u for _, _, p in flat], 7),
        w=_array([p.w for _, _, p in flat], 7),
    )
    return terms, np.cumsum(counts) - counts


def _array(rows: Sequence[Array], width: int, dtype: type = float) -> NDArray:
    return np.array(rows, dtype=dtype).reshape(-1, width)


def _scale(row: Row, layout: Layout) -> float:
    if row.products[0].kind == DIRECTION:
        return 1.0
    return max(_size(row.a, layout), _size(row.b, layout))


def _size(side: Side, layout: Layout) -> float:
    return 0.0 if side.kind == FIXED else float(layout.scale[side.dofs[0]])


def origin(a: Side, b: Side) -> Array:
    """(3,) float [m]  part of r_A − r_B that the ground contributes."""
    absent = [side.position * (side.kind == FIXED) for side in (a, b)]
    return absent[0] - absent[1]


def fixed(vector: Array) -> Array:
    """(7,) coefficients of a direction of the ground."""
    return np.array([0.0, 0.0, 0.0, *vector, 0.0])


def direction(side: Side, vector: Array) -> Array:
    """(7,) coefficients of the direction that is ``vector`` in the reference and moves with it."""
    if side.kind == FIXED:
        return fixed(vector)
    if side.kind == PARTICLE:
        raise ValueError(f"particle {side.name!r} has no orientation")
    along = side.triad @ vector
    if side.kind == BEAM:
        return np.array([*along, 0.0, 0.0, 0.0, 0.0])
    if np.hypot(along[1], along[2]) > 1e-6:
        raise ValueError(f"cable {side.name!r} has no direction but its tangent")
    return np.array([0.0, along[0], 0.0, 0.0, 0.0, 0.0, 0.0])


def unit_direction(side: Side, vector: Array) -> Array:
    """As ``direction``, divided by its length at all times."""
    coefficients = direction(side, vector)
    coefficients[6] = float(side.kind != FIXED)
    return coefficients


def normal_to(axis: Array, triad: Array) -> Array:
    """Unit vector across ``axis``: e2, e3 or e1 of the triad, projected where none is across."""
    e2, e3, e1 = (triad[i] - (triad[i] @ axis) * axis for i in (1, 2, 0))
    best = max((e2, e3, e1), key=lambda e: np.round(np.linalg.norm(e), 6))
    return best / np.linalg.norm(best)


def unit(vector: Array) -> Array:
    """``vector`` (3,) divided by its length."""
    length = np.linalg.norm(vector)
    if length == 0.0:
        raise ValueError("a direction has no length")
    return np.asarray(vector, float) / length


def _sides(layout: Layout, a: Site, b: Site) -> tuple[Side, Side]:
    sides = layout.site(a), layout.site(b)
    if sides[0].kind == sides[1].kind == FIXED:
        raise ValueError("both ends are on the ground")
    return sides


def _together(a: Side, b: Side, layout: Layout) -> list[Row]:
    """Three rows: the two points coincide."""
    if _apart(a, b, layout):
        gap = np.linalg.norm(a.position - b.position)
        raise ValueError(f"its two points are {gap:.6g} m apart")
    return [_offset(a, b, fixed(e)) for e in np.eye(3)]


def _apart(a: Side, b: Side, layout: Layout) -> bool:
    size = max(_size(a, layout), _size(b, layout))
    return bool(np.linalg.norm(a.position - b.position) > _APART * size)


def _offset(a: Side, b: Side, w: Array) -> Row:
    return Row(a, b, (Product(OFFSET, _NOTHING, w),))


def _across(a: Side, u: Array, b: Side, w: Array) -> Row:
    """Direction u of ``a`` stays normal to direction w of ``b``."""
    return Row(a, b, (Product(DIRECTION, direction(a, u), direction(b, w)),))


def _spherical(joint: Spherical, layout: Layout) -> list[Row]:
    return _together(*_sides(layout, joint.a, joint.b), layout)


def _distance(joint: Distance, layout: Layout) -> list[Row]:
    a, b = _sides(layout, joint.a, joint.b)
    length = float(np.linalg.norm(a.position - b.position))
    if length == 0.0:
        raise ValueError("its two points coincide")
    w = np.zeros(7)
    w[3] = length
    return [Row(a, b, (Product(DISTANCE, _NOTHING, w),))]


def _guide(joint: Guide, layout: Layout) -> list[Row]:
    a, ground = _sides(layout, joint.a, Site(None))
    directions = [unit(e) for e in np.atleast_2d(joint.directions)]
    if np.linalg.matrix_rank(np.array(directions), tol=1e-6) < len(directions):
        raise ValueError("its directions are not independent")
    return [_offset(a, ground, fixed(e)) for e in directions]


def _clamp(joint: Clamp, layout: Layout) -> list[Row]:
    """Position, and orientation with a section free to breathe.

    Lengths of r_x, d2, d3 and the angle between d2 and d3 stay free. About the tangent the mean
    turn of d2 and d3 is held, (d2·e3 − d3·e2)/2: the torsion of the beam is measured and loaded
    in the same way, whereas d2·e3 alone would let a torque shear the section and twist it freely.
    """
    a, b = _sides(layout, joint.a, joint.b)
    if b.kind == CABLE or (a.kind == FIXED and b.kind != FIXED):
        a, b = b, a
    e1, e2, e3 = a.triad
    if a.kind == CABLE:
        turn = [_across(a, e1, b, e2), _across(a, e1, b, e3)]
    else:
        products = (
            Product(DIRECTION, direction(a, e2), direction(b, e3), 0.5),
            Product(DIRECTION, direction(a, e3), direction(b, e2), -0.5),
        )
        turn = [_across(a, e2, b, e1), _across(a, e3, b, e1), Row(a, b, products)]
    if _apart(a, b, layout):
        return [_offset(a, b, unit_direction(b, e)) for e in a.triad] + turn
    return _together(a, b, layout) + turn


def _tilt(a: Side, b: Side, axis: Array) -> list[Row]:
    """The axis of ``a`` and of ``b`` stay parallel; one row for a cable across the axis."""
    if b.kind == CABLE:
        a, b = b, a
    if a.kind == CABLE and abs(a.triad[0] @ axis) < _ALIGNED:
        return [_across(a, a.triad[0], b, axis)]
    w = normal_to(axis, b.triad)
    return [_across(a, axis, b, w), _across(a, axis, b, np.cross(axis, w))]


def _driven(a: Side, b: Side, axis: Array, angle: History) -> Row:
    """sin(turn of a relative to b − angle(t)) = 0; its slope is one at every angle."""
    if b.kind == CABLE:
        return _driven(b, a, axis, lambda t: -angle(t))
    first = a.triad[0] if a.kind == CABLE else normal_to(axis, a.triad)
    w, sine = direction(b, np.cross(axis, first)), direction(b, first)
    return Row(a, b, (Product(DIRECTION, direction(a, first), w),), Drive(angle, sine))


def _revolute(joint: Revolute, layout: Layout) -> list[Row]:
    a, b = _sides(layout, joint.a, joint.b)
    axis = unit(joint.axis)
    rows = _together(a, b, layout) + _tilt(a, b, axis)
    return rows if joint.angle is None else [*rows, _driven(a, b, axis, joint.angle)]


def _clearance(joint: ClearanceRevolute, layout: Layout) -> list[Row]:
    """What the clearance leaves held: the position along the axis, tilt, and the drive."""
    a, b = _sides(layout, joint.journal, joint.bearing)
    axis = unit(joint.axis)
    rows = [_offset(a, b, unit_direction(b, axis))]
    if a.kind != PARTICLE:
        rows += _tilt(a, b, axis)
    return rows if joint.angle is None else [*rows, _driven(a, b, axis, joint.angle)]


_MAKERS: dict[type, Callable[..., list[Row]]] = {
    Clamp: _clamp,
    Spherical: _spherical,
    Revolute: _revolute,
    Distance: _distance,
    Guide: _guide,
    ClearanceRevolute: _clearance,
}
