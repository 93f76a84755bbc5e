"""Shells for drawing: every element cut into small quadrilaterals, with what is known there."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from coupling.surfaces import Body, Patches

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

PIECES = 4
"""Pieces of an element each way."""


def refined(position: Array, patches: "Patches", frame: int) -> tuple[Array, Indices]:
    """Points of all elements (n_e (PIECES + 1)^2, 3) [m] and quads of their pieces.

    Bicubic between nodes that have slopes, else bilinear: the shapes of the elements themselves
    but for shells without a mixed derivative, which are near to it.
    """
    corners = position[patches.quads]
    if patches.slopes is None:
        points = np.einsum("kc,eci->eki", _bilinear(), corners)
    else:
        points = _bicubic(corners, patches.slopes[frame][patches.quads], patches.sizes)
    return points.reshape(-1, 3), _pieces(len(corners))


def fields(
    body: "Body", patches: "Patches", frame: int
) -> tuple[Array | None, Array | None, Array | None]:
    """At the points of ``refined``: mean temperature [K] and its gradient along the normal [K/m],
    both (m,), and resultants (m, 8).
    """
    temperature = gradient = resultants = None
    if body.temperature is not None:
        corners = body.temperature[frame][patches.quads][:, :, [0, 2]]
        temperature, gradient = np.einsum("kc,ecf->fek", _bilinear(), corners).reshape(2, -1)
    if body.resultants is not None:
        resultants = np.repeat(body.resultants[frame], (PIECES + 1) ** 2, axis=0)
    return temperature, gradient, resultants


def _grid() -> tuple[Array, Array]:
    """Local coordinates in [0, 1] of the points of an element."""
    s = np.linspace(0.0, 1.0, PIECES + 1)
    x, y = np.meshgrid(s, s, indexing="ij")
    return x.ravel(), y.ravel()


def _bilinear() -> Array:
    """(k, 4) weights of the corners at (0, 0), (1, 0), (1, 1), (0, 1)."""
    x, y = _grid()
    return np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)


def _hermite(x: Array) -> tuple[Array, Array]:
    """(2, k) weights of values, and of slopes times length, at both ends."""
    values = np.stack([(1 - x) ** 2 * (1 + 2 * x), x * x * (3 - 2 * x)])
    return values, np.stack([x * (1 - x) ** 2, x * x * (x - 1)])


def _bicubic(corners: Array, slopes: Array, sizes: Array) -> Array:
    """(n_e, k, 3) points from places (n_e, 4, 3) and derivatives (n_e, 4, 3, 3) of the corners."""
    x, y = _grid()
    (f, g), (p, q) = _hermite(x), _hermite(y)
    points = np.zeros((len(corners), x.size, 3))
    for c, (i, j) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        a, b = sizes[:, :1, None], sizes[:, 1:, None]
        r_u, r_v, r_uv = np.moveaxis(slopes[:, c, None], 2, 0)
        points += (f[i] * p[j])[:, None] * corners[:, c, None]
        points += (g[i] * p[j])[:, None] * (a * r_u) + (f[i] * q[j])[:, None] * (b * r_v)
        points += (g[i] * q[j])[:, None] * (a * b * r_uv)
    return points


def _pieces(elements: int) -> Indices:
    """Quads of the pieces of all elements."""
    side = PIECES + 1
    k = np.arange(side * side).reshape(side, side)
    one = np.stack([k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]], axis=-1).reshape(-1, 4)
    return (np.arange(elements)[:, None, None] * side * side + one).reshape(-1, 4)
