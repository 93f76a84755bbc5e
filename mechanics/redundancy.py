"""Which joints hold something again that others hold already, and which ask for something else.

The rows of the Jacobian in the reference are made independent of units (coordinates by their
scale, rows by their norm) and taken joint by joint. What is left of the rows of a joint after its
part in the span of those before it is singular where the joint repeats them. Rows that share no
coordinate, also not through others, are independent of each other and are looked at apart.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from mechanics import kernels

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

REPEATED = 1e-8
"""A constraint of which no more than this part is new repeats others [-]."""
_SUSPECT, _STEP, _NAMED = 1e-6, 1e-7, 5
_TIMES = np.concatenate([[0.0], np.logspace(-3.0, 6.0, 19)])
"""Times [s] at which what drives repeated rows is compared."""


class Repetition(NamedTuple):
    """Of the ``total`` rows of a joint, ``repeated`` hold what joints before it hold already.

    before : joints whose rows they repeat; none: the rows hold nothing at all
    contradicts : whether the joints ask for different values of the same
    """

    joint: str
    repeated: int
    total: int
    before: tuple[str, ...]
    contradicts: bool

    def __str__(self) -> str:
        others = ", ".join(repr(name) for name in self.before[:_NAMED])
        others += f" and {len(self.before) - _NAMED} more" * (len(self.before) > _NAMED)
        if not self.before:
            return f"joint {self.joint!r}: {self.repeated} of {self.total} constraints hold nothing"
        if self.contradicts:
            return f"joint {self.joint!r} contradicts {others}: both drive or hold the same motion"
        return f"joint {self.joint!r}: {self.repeated} of {self.total} constraints repeat {others}"


class _Rows(NamedTuple):
    """Scaled rows (m, n), their joints, ∂Φ/∂drive and drives; which hold from the start."""

    jacobian: csr_array
    names: NDArray[np.object_]
    slopes: Array
    drives: dict[int, Any]
    active: Indices


def repetitions(
    terms: Sequence[Any], q0: Array, scale: Array, order: Sequence[str] = ()
) -> list[Repetition]:
    """Joints that repeat or contradict others, in the reference ``q0`` (n,).

    Parameters
    ----------
    terms : constraint terms (those with ``rows``), multipliers numbered from n on
    scale : (n,) float [m] or [1]  size of each coordinate
    order : names of joints, earlier ones first; others come before them, as their rows do
    """
    rows = _gather(terms, q0, scale)
    found: dict[str, Repetition] = {}
    held = rows.jacobian[rows.active]
    _, part = connected_components(held @ held.T, directed=False)
    for members in (rows.active[group] for group in _groups(part)):
        block = rows.jacobian[members]
        dense = block[:, np.unique(block.indices)].toarray()
        if _suspect(dense):
            for again in _examine(dense, members, rows, order):
                _merge(found, again)
    return [_joints_only(again, order) for again in found.values()]


def _joints_only(again: Repetition, order: Sequence[str]) -> Repetition:
    """Without the rigid bodies whose inner constraints take part, where joints do too."""
    joints = tuple(name for name in again.before if name in order)
    return again._replace(before=joints or again.before)


def _merge(found: dict[str, Repetition], again: Repetition) -> None:
    """Rows of a joint that share no coordinate are found apart."""
    one = found.get(again.joint, again._replace(repeated=0, before=()))
    found[again.joint] = again._replace(
        repeated=one.repeated + again.repeated,
        before=tuple(dict.fromkeys([*one.before, *again.before])),
        contradicts=one.contradicts or again.contradicts,
    )


def _groups(part: NDArray[np.int32]) -> list[Indices]:
    sequence = np.argsort(part, kind="stable")
    return np.split(sequence, np.flatnonzero(np.diff(part[sequence])) + 1) if part.size else []


def _suspect(dense: Array) -> bool:
    """A product of singular values is that of the diagonal of R: one vanishes with the other."""
    if dense.shape[0] > dense.shape[1]:
        return True
    return bool(np.abs(np.diagonal(np.linalg.qr(dense.T, mode="r"))).min() < _SUSPECT)


def _gather(terms: Sequence[Any], q0: Array, scale: Array) -> _Rows:
    holding = [term for term in terms if getattr(term, "rows", 0)]
    n, m = q0.size, sum(term.rows for term in holding)
    y = np.concatenate([q0, np.zeros(m)])
    names = np.full(m, "", dtype=object)
    entries: list[tuple[Indices, Indices, Array]] = []
    waiting, slopes, drives = np.zeros(m, dtype=bool), np.zeros(m), {}
    for term in holding:
        entries.append(_entries(term, y, _rest(term), n))
        for name, dofs in zip(term.names, term.dofs, strict=True):
            names[dofs[dofs >= n] - n] = name
        for latch in getattr(term, "latches", ()):
            waiting[term.dofs[latch.row, -1] - n] = True
        for row, _, history in getattr(term, "signals", ()):
            drives[int(term.dofs[row, -1]) - n] = history
        slopes += _slopes(term, y, n)
    row, column, value = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    jacobian = csr_array((value * scale[column], (row, column)), shape=(m, n))
    norms = np.sqrt(np.asarray(jacobian.multiply(jacobian).sum(axis=1)).ravel())
    norms[norms == 0.0] = 1.0
    jacobian = csr_array(jacobian.multiply(1.0 / norms[:, None]))
    jacobian.eliminate_zeros()
    return _Rows(jacobian, names, slopes / norms, drives, np.flatnonzero(~waiting))


def _slopes(term: Any, y: Array, n: int) -> Array:
    """(m,) derivatives of Φ by what drives each row."""
    signals, at_rest = getattr(term, "signals", ()), _rest(term)
    if not signals:
        return np.zeros(y.size - n)
    coef = at_rest.copy()
    for row, column, _ in signals:
        coef[row, column] = _STEP
    return (_values(term, y, coef, n) - _values(term, y, at_rest, n)) / _STEP


def _rest(term: Any) -> Array:
    """Coefficients of a term when nothing drives it."""
    return term.coefficients(np.zeros((0, 3)))


def _entries(term: Any, y: Array, coef: Array, n: int) -> tuple[Indices, Indices, Array]:
    """Row, column and value of ∂Φ/∂q."""
    blocks, dofs = kernels.tangent_blocks(term, y, 0.0 * y, coef, 0.0, 0.0), term.dofs
    k = dofs.shape[1]
    i, j = np.repeat(dofs, k, axis=1).ravel(), np.tile(dofs, (1, k)).ravel()
    kept = (i >= n) & (j >= 0) & (j < n)
    return i[kept] - n, j[kept], blocks.ravel()[kept]


def _values(term: Any, y: Array, coef: Array, n: int) -> Array:
    out = np.zeros_like(y)
    kernels.add_force(term, y, 0.0 * y, coef, out)
    return out[n:]


def _examine(dense: Array, members: Indices, rows: _Rows, order: Sequence[str]) -> list[Repetition]:
    """Repetitions among rows that are tied to each other."""
    rank = {name: i for i, name in enumerate(order)}
    names = rows.names[members]
    joints = sorted(dict.fromkeys(names), key=lambda name: rank.get(name, -1))
    basis, before, found = np.zeros((0, dense.shape[1])), np.zeros(0, np.intp), []
    for name in joints:
        own = np.flatnonzero(names == name)
        fresh = dense[own]
        for _ in range(2):  # twice is enough
            fresh = fresh - (fresh @ basis.T) @ basis
        left, size, right = np.linalg.svd(fresh, full_matrices=len(fresh) > fresh.shape[1])
        count = int(np.sum(size > REPEATED))
        basis = np.concatenate([basis, right[:count]])
        if count < own.size:
            again = left[:, count:].T
            found.append(_repetition(name, again, own, before, dense, members, rows))
        before = np.concatenate([before, own])
    return found


def _repetition(
    name: str, again: Array, own: Indices, before: Indices, dense: Array, members: Indices,
    rows: _Rows,
) -> Repetition:  # fmt: skip
    """``again`` (k, own): combinations of the rows of a joint that rows before it hold already."""
    weights = np.linalg.lstsq(dense[before].T, (again @ dense[own]).T, rcond=1e-10)[0].T
    strong = np.abs(weights).max(axis=0, initial=0.0) > 1e-6
    others = tuple(dict.fromkeys(rows.names[members[before[strong]]]))
    total = np.zeros((len(again), members.size))
    total[:, own], total[:, before] = again, -weights
    total[np.abs(total) < REPEATED] = 0.0
    size = int(np.sum(rows.names[rows.active] == name))
    return Repetition(name, len(again), size, others, _contradicts(total, members, rows))


def _contradicts(combinations: Array, members: Indices, rows: _Rows) -> bool:
    """Whether what drives the rows leaves a combination other than zero at some time."""
    driven = [i for i, row in enumerate(members) if row in rows.drives]
    if not driven:
        return False
    drives = [rows.drives[members[i]] for i in driven]
    asked = np.array([[float(history(t)) for t in _TIMES] for history in drives])
    asked *= rows.slopes[members[driven], None]
    left = combinations[:, driven] @ asked
    size = np.abs(combinations[:, driven]) @ np.abs(asked)
    return bool(np.any(np.abs(left) > 1e-6 * size.max(initial=0.0)))
