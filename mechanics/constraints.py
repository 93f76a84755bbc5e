"""Terms of scalar constraint rows Φ(y, t) = 0 for the integrator.

A row that is linear in the coordinates with constant weights becomes a row of a linear term
(``mechanics.linear``), any other a row of ``mechanics.relative``. Rows are put together by the
number of coordinates that they need, so that joints at plain nodes stay narrow.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.description import History
from mechanics.directions import origin
from mechanics.layout import Layout, Side
from mechanics.relative import (
    DIRECTION,
    DISTANCE,
    OFFSET,
    PRODUCT,
    SHIFTED,
    SINE,
    STRETCHED,
    TURNED,
    WEIGHTS,
    WIDTH,
    evaluate,
    scratch,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NOTHING = np.zeros(7)
VECTOR_WIDTHS = 2, 4, 8
"""Vectors of each end in rows of one term: a section at a node, a point at or between nodes."""
LINEAR_WIDTHS = 6, 24, 48
"""Coordinates in rows of one linear term."""
_ROUNDING = 1e-15


class Product(NamedTuple):
    """``weight`` times a·w; see ``mechanics.relative`` for u and w."""

    kind: int
    u: Array
    w: Array
    weight: float = 1.0


class Row(NamedTuple):
    """One equation between two ends: a sum of products less its value in the reference.

    drive : what moves the row: an angle [rad] where there is a ``sine``, else what Φ is less
    sine : (7,) coefficients of the direction towards which w of the first product is not turned
    own : coordinate of the joint that is added to the drive
    """

    a: Side
    b: Side
    products: tuple[Product, ...]
    drive: History | None = None
    sine: Array | None = None
    own: int = -1


class Linear(NamedTuple):
    """Σ weight y − constant − drive = 0; an inactive row has no multiplier."""

    coordinates: Indices
    weights: Array
    constant: float
    scale: float
    drive: History | None = None
    active: bool = True


class Latching(NamedTuple):
    """Row of a term that is active once ``coordinate`` has reached ``at``: coef[row, 1] = 1."""

    row: int
    coordinate: int
    at: float


class Limit(NamedTuple):
    """A coordinate that has a meaning between two values only, and what to say beyond them."""

    coordinate: int
    lower: float
    upper: float
    reason: str


@dataclass(frozen=True, eq=False)
class Constraints:
    """Rows of equal width.

    Attributes
    ----------
    name, names : of the term, and joint of each row
    dofs : (rows, k) int  coordinates of the row, its multiplier last; -1 where absent
    ints, floats : (rows, .) constant data of the kernels
    force, tangent : int  addresses of the kernels
    start : (rows, n_c) float  coefficients before functions of time are entered: column 0 is
        what drives the row, column 1 (linear rows) 1 where the row is active
    signals : (row, column, function of time) entries of the coefficients
    driven : (rows,) bool  rows that depend on time
    scale : (rows,) float [m] or [1]  size of the row's value: body length, or 1 for directions
    latches : rows to be made active, see ``Latching``
    limits : coordinates of joints that have ends, see ``Limit``
    """

    name: str
    names: list[str]
    dofs: NDArray[np.intp]
    ints: Indices
    floats: Array
    force: int
    tangent: int
    start: Array
    signals: list[tuple[int, int, History]]
    driven: NDArray[np.bool_]
    scale: Array
    latches: list[Latching] = field(default_factory=list)
    limits: list[Limit] = field(default_factory=list)
    energy: int = 0
    symmetric: bool = True

    @property
    def rows(self) -> int:
        """Number of multipliers."""
        return len(self.names)

    def coefficients(self, T: Array) -> Array:
        """(rows, n_c) float  at section temperatures ``T`` (m, 3), of which nothing depends."""
        return self.start.copy()

    def with_rates(self, c0: Array, c1: Array, h: float) -> tuple[Array, Array]:
        """The coefficients as they are: no row needs their rate."""
        return c0, c1

    def mass_blocks(self) -> None:
        """A joint has no mass."""


def terms(
    rows: Iterable[tuple[str, Row | Linear]], layout: Layout, first: int
) -> list[Constraints]:
    """Terms of named rows; the multipliers have indices from ``first`` on, term by term."""
    groups: dict[tuple[bool, int], list[tuple[str, Any]]] = {}
    for name, row in rows:
        row = _simple(row, layout)
        linear = isinstance(row, Linear)
        width = next(w for w in (LINEAR_WIDTHS if linear else VECTOR_WIDTHS) if _need(row) <= w)
        groups.setdefault((not linear, width), []).append((name, row))
    found: list[Constraints] = []
    for (relative, width), members in sorted(groups.items(), key=lambda item: item[0]):
        make = relative_term if relative else linear_term
        found.append(make(members, layout, first, width))
        first += len(members)
    return found


def _need(row: Row | Linear) -> int:
    """How many coordinates a linear row has, or vectors the larger end of another."""
    if isinstance(row, Linear):
        return row.coordinates.size
    return max(row.a.vectors.size, row.b.vectors.size)


def _numbers(rows: Sequence[Any], dtype: type = float) -> NDArray:
    """(n, k) array of rows, C layout, also without rows."""
    return np.ascontiguousarray(np.array(rows, dtype=dtype).reshape(len(rows), -1))


# -- linear rows -------------------------------------------------------------------------------


def linear_term(
    named: Sequence[tuple[str, Linear]], layout: Layout, first: int, width: int
) -> Constraints:
    """Term of rows with up to ``width`` coordinates each."""
    from mechanics import linear  # compiled only when used

    rows = [row for _, row in named]
    dofs = np.full((len(rows), width + 1), -1, dtype=np.intp)
    ints = np.full((len(rows), 2 + width), -1, dtype=np.int64)
    floats = np.zeros((len(rows), 1 + width))
    for i, row in enumerate(rows):
        k = row.coordinates.size
        dofs[i, :k], dofs[i, -1] = row.coordinates, first + i
        ints[i, : 2 + k] = first + i, k, *row.coordinates
        floats[i, : 1 + k] = row.constant, *row.weights
    start = np.array([[0.0, float(row.active)] for row in rows])
    return Constraints(
        "linear joints", [name for name, _ in named], dofs, ints, floats,
        linear.add_force, linear.add_tangent, start, **_driven(rows),
        scale=np.array([row.scale for row in rows]), latches=_latches(rows),
    )  # fmt: skip


def _latches(rows: Sequence[Linear]) -> list[Latching]:
    waiting = [(i, row) for i, row in enumerate(rows) if not row.active]
    return [Latching(i, int(row.coordinates[0]), row.constant) for i, row in waiting]


def _driven(rows: Sequence[Any]) -> dict[str, Any]:
    signals = [(i, 0, row.drive) for i, row in enumerate(rows) if row.drive is not None]
    driven = np.array([row.drive is not None for row in rows], dtype=bool)
    return {"signals": signals, "driven": driven}


def _simple(row: Row | Linear, layout: Layout) -> Row | Linear:
    """The row without vectors that it does not need; a linear one if it is linear."""
    if isinstance(row, Linear):
        return row
    row = row._replace(a=needed(row.a, row, 0), b=needed(row.b, row, 1))
    if row.sine is not None or not all(_is_linear(p) for p in row.products):
        return row
    gradient, _ = _at_reference(row, layout)
    coordinates, inverse = np.unique(_coordinates(row), return_inverse=True)
    weights = np.bincount(inverse, gradient, coordinates.size)
    if row.own >= 0:
        coordinates, weights = np.append(coordinates, row.own), np.append(weights, -1.0)
    kept = np.abs(weights) > _ROUNDING * np.abs(weights).max(initial=0.0)
    coordinates, weights = coordinates[kept], weights[kept]
    constant = float(weights @ layout.q0[coordinates])
    return Linear(coordinates, weights, constant, _scale(row), row.drive)


def _is_linear(product: Product) -> bool:
    """Whether one factor is constant and the other linear."""
    constant_w = not product.w[:3].any()
    if product.kind == OFFSET:
        return constant_w
    constant_u = not product.u[:3].any()
    simple_w, simple_u = not (product.w[0] or product.w[6]), not product.u[0]
    return product.kind == DIRECTION and (
        (constant_w and simple_u) or (constant_u and simple_w)
    )  # fmt: skip


def needed(side: Side, row: Row, end: int) -> Side:
    """The side without vectors that none of the products sees."""
    seen = np.zeros(3, dtype=bool)
    for product in row.products:
        c = product.w if end else product.u
        c = np.abs(c) + np.abs(row.sine) if end and row.sine is not None else c
        seen[0] |= product.kind != DIRECTION
        if product.kind == DIRECTION or (end and product.kind == OFFSET):
            seen[1:] |= [bool(c[0] or c[1]), bool(c[0] or c[2])]
    used = np.any(side.weights[seen] != 0.0, axis=0)
    weights = np.where(seen[:, None], side.weights, 0.0)[:, used]
    return side._replace(vectors=side.vectors[used], weights=weights)


def _coordinates(row: Row) -> NDArray[np.intp]:
    """Coordinates of the vectors of both ends."""
    vectors = np.concatenate([row.a.vectors, row.b.vectors]).astype(np.intp)
    return (vectors[:, None] + np.arange(3)).ravel()


def _at_reference(row: Row, layout: Layout) -> tuple[Array, float]:
    """Gradient by ``_coordinates`` and value of the products in the reference."""
    x = np.concatenate([_local(side, layout) for side in (row.a, row.b)])
    local, value = np.zeros(18), 0.0
    for p in row.products:
        value += evaluate(
            p.kind, x, origin(row.a, row.b), p.u, p.w, p.weight, local, np.empty((0, 18)), scratch()
        )
    parts = [
        np.einsum("mk,mi->ki", side.weights, part).ravel()
        for side, part in zip((row.a, row.b), local.reshape(2, 3, 3), strict=True)
    ]
    return np.concatenate(parts), value


def _local(side: Side, layout: Layout) -> Array:
    """(9,) r, p, s of an end in the reference; zeros for the ground."""
    return (side.weights @ layout.q0[side.vectors[:, None].astype(np.intp) + np.arange(3)]).ravel()


def _scale(row: Row) -> float:
    return 1.0 if row.products[0].kind == DIRECTION else max(row.a.size, row.b.size)


# -- rows of two ends --------------------------------------------------------------------------


def relative_term(
    named: Sequence[tuple[str, Row]], layout: Layout, first: int, width: int
) -> Constraints:
    """Term of rows with up to ``width`` vectors on each end."""
    from mechanics import relative

    rows = [row for _, row in named]
    return Constraints(
        "joints", [name for name, _ in named],
        _numbers([_dofs(row, first + i, width) for i, row in enumerate(rows)], np.intp),
        _numbers([_ints(row, first + i, width) for i, row in enumerate(rows)], np.int64),
        _numbers([_floats(row, layout, width) for row in rows]),
        relative.add_force, relative.add_tangent, np.zeros((len(rows), 1)), **_driven(rows),
        scale=np.array([_scale(row) for row in rows]),
    )  # fmt: skip


def _dofs(row: Row, multiplier: int, width: int) -> list[int]:
    parts: list[int] = []
    for side in (row.a, row.b):
        held = (side.vectors[:, None].astype(int) + np.arange(3)).ravel()
        parts += [*held, *[-1] * (3 * width - held.size)]
    return [*parts, row.own, multiplier]


def _ints(row: Row, multiplier: int, width: int) -> list[int]:
    kinds = [product.kind for product in row.products]
    mode = SHIFTED if row.sine is None else TURNED
    mode = STRETCHED if kinds[0] == DISTANCE else mode
    counts = row.a.vectors.size, row.b.vectors.size
    line = [multiplier, row.own, mode, len(kinds), *counts, *kinds, *[0] * (2 - len(kinds))]
    for side in (row.a, row.b):
        line += [*side.vectors, *[-1] * (width - side.vectors.size)]
    return line


def _floats(row: Row, layout: Layout, width: int) -> Array:
    line = np.zeros(WEIGHTS + 6 * width)
    line[0] = _at_reference(row, layout)[1]
    line[1:SINE] = origin(row.a, row.b)
    line[SINE:PRODUCT] = NOTHING if row.sine is None else row.sine
    for k, p in enumerate(row.products):
        line[PRODUCT + WIDTH * k : PRODUCT + WIDTH * (k + 1)] = p.weight, *p.u, *p.w
    for k, side in enumerate((row.a, row.b)):
        start = WEIGHTS + 3 * width * k
        line[start : start + side.weights.size] = side.weights.T.ravel()
    return line
