"""Inextensible ropes over pulleys of no size: Φ = Σ |r_(i+1) − r_i| − length − paid out.

The multiplier is the tension [N] of the rope, which is the same in all segments.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics.constraints import Constraints
from mechanics.description import Pulley
from mechanics.kernels import FORCE, TANGENT, kernel
from mechanics.layout import Layout, Side

Array = NDArray[np.float64]

_LENGTH = 1e-9
"""Difference of lengths over the length of the path that counts as none."""


@njit(cache=True, error_model="numpy")
def _path(y, ints, floats, points, t, size):
    """Length of the path; its points, and direction t and length of its segments."""
    N = points.shape[0]
    for p in range(N):
        for i in range(3):
            points[p, i] = floats[1 + 3 * p + i]
    for k in range(ints[2]):
        for i in range(3):
            points[ints[3 + 2 * k], i] += floats[1 + 3 * N + k] * y[ints[4 + 2 * k] + i]
    length = 0.0
    for p in range(ints[1] - 1):
        for i in range(3):
            t[p, i] = points[p + 1, i] - points[p, i]
        size[p] = np.sqrt(t[p, 0] ** 2 + t[p, 1] ** 2 + t[p, 2] ** 2)
        length += size[p]
        for i in range(3):
            t[p, i] /= size[p]
    return length


@njit(cache=True, error_model="numpy")
def _slope(t, p, last, i):
    """Derivative of the length by coordinate i of point p."""
    f = 0.0
    if p > 0:
        f += t[p - 1, i]
    if p < last:
        f -= t[p, i]
    return f


@kernel(FORCE)
def add_force(y, v, coef, ints, floats, out):
    K = (ints.shape[1] - 3) // 2
    N = (floats.shape[1] - 1 - K) // 3
    points, t, size = np.empty((N, 3)), np.empty((N, 3)), np.empty(N)
    for e in range(ints.shape[0]):
        lam, last = y[ints[e, 0]], ints[e, 1] - 1
        length = _path(y, ints[e], floats[e], points, t, size)
        out[ints[e, 0]] += length - floats[e, 0] - coef[e, 0]
        for k in range(ints[e, 2]):
            f = lam * floats[e, 1 + 3 * N + k]
            for i in range(3):
                out[ints[e, 4 + 2 * k] + i] += f * _slope(t, ints[e, 3 + 2 * k], last, i)


@kernel(TANGENT)
def add_tangent(y, v, coef, ints, floats, cK, cC, slots, data):
    K = (ints.shape[1] - 3) // 2
    N, n = (floats.shape[1] - 1 - K) // 3, 3 * K + 1
    points, t, size = np.empty((N, 3)), np.empty((N, 3)), np.empty(N)
    for e in range(ints.shape[0]):
        lam, last, at = cK * y[ints[e, 0]], ints[e, 1] - 1, slots[e]
        _path(y, ints[e], floats[e], points, t, size)
        for k in range(ints[e, 2]):
            a, wk = ints[e, 3 + 2 * k], floats[e, 1 + 3 * N + k]
            for i in range(3):
                f = wk * _slope(t, a, last, i)
                data[at[(3 * k + i) * n + n - 1]] += f
                data[at[(n - 1) * n + 3 * k + i]] += f
            for m in range(ints[e, 2]):
                b, w = ints[e, 3 + 2 * m], lam * wk * floats[e, 1 + 3 * N + m]
                for p in range(last):  # (I − t tᵀ)/size on the two points of each segment
                    f = w / size[p] * (int(a == p + 1) - int(a == p))
                    f *= int(b == p + 1) - int(b == p)
                    if f != 0.0:
                        for i in range(3):
                            for j in range(3):
                                part = int(i == j) - t[p, i] * t[p, j]
                                data[at[(3 * k + i) * n + 3 * m + j]] += f * part


def build(pulleys: Sequence[Pulley], layout: Layout, first: int) -> Constraints:
    """Term of all ropes without stiffness; one that cannot be made is a ``ValueError``."""
    paths = [[layout.site(site) for site in pulley.points] for pulley in pulleys]
    K = max(sum(side.vectors.size for side in path) for path in paths)
    N = max(len(path) for path in paths)
    dofs = np.full((len(paths), 3 * K + 1), -1, dtype=np.intp)
    ints = np.full((len(paths), 3 + 2 * K), -1, dtype=np.int64)
    floats = np.zeros((len(paths), 1 + 3 * N + K))
    for e, (pulley, path) in enumerate(zip(pulleys, paths, strict=True)):
        vectors = np.concatenate([side.vectors for side in path]).astype(np.intp)
        owner = np.repeat(np.arange(len(path)), [side.vectors.size for side in path])
        k = vectors.size
        dofs[e, : 3 * k], dofs[e, -1] = (vectors[:, None] + np.arange(3)).ravel(), first + e
        ints[e, :3] = first + e, len(path), k
        ints[e, 3 : 3 + 2 * k] = np.stack([owner, vectors], axis=1).ravel()
        floats[e, 0] = _checked(pulley, path)
        fixed = [side.position * side.fixed for side in path]
        floats[e, 1 : 1 + 3 * len(path)] = np.ravel(fixed)
        floats[e, 1 + 3 * N : 1 + 3 * N + k] = np.concatenate([side.weights[0] for side in path])
    signals = [(e, 0, p.winch) for e, p in enumerate(pulleys) if p.winch is not None]
    return Constraints(
        "pulleys", [p.name for p in pulleys], dofs, ints, floats, add_force, add_tangent,
        np.zeros((len(paths), 1)), signals,
        driven=np.array([p.winch is not None for p in pulleys], dtype=bool),
        scale=floats[:, 0].copy(),
    )  # fmt: skip


def _checked(pulley: Pulley, path: Sequence[Side]) -> float:
    try:
        return _length(pulley, path)
    except ValueError as problem:
        raise ValueError(f"joint {pulley.name!r}: {problem}") from None


def _length(pulley: Pulley, path: Sequence[Side]) -> float:
    """Length [m] of the path in the reference."""
    if len(path) < 2 or all(side.fixed for side in path):
        raise ValueError("its rope goes to no body")
    pieces = np.linalg.norm(np.diff([side.position for side in path], axis=0), axis=1)
    if not pieces.all():
        raise ValueError("two of its points that follow each other coincide")
    length = float(pieces.sum())
    if pulley.length is not None and abs(pulley.length - length) > _LENGTH * length:
        raise ValueError(f"its path is {length:.9g} m long, its rope {pulley.length:.9g} m")
    return length
