"""Dead loads on surfaces and edges of shells and on faces of solids, as consistent forces.

The virtual work of a load t per reference area, integral t.dr dA, puts the integrals of its shape
functions on each vector of a node: on positions, and where these are bicubic or cubic, on slopes.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mechanics.continuum_shapes import FULL, STIFFNESS, face_shape
from mechanics.description import Continuum, Shell, Traction
from mechanics.layout import Layout, family_of
from mechanics.loads import Dead
from meshes.surfaces import Surface

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Shapes = Callable[[Array, Array, int, int], Array]

SIDES = ((0, 1, 0), (1, 2, 1), (3, 2, 0), (0, 3, 1))
"""Sides of an element: first and last corner, and 0 along u, 1 along v."""

_GAUSS, _WEIGHT = np.polynomial.legendre.leggauss(4)
_GAUSS, _WEIGHT = 0.5 + 0.5 * _GAUSS, 0.5 * _WEIGHT
_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def build(loads: Sequence[Traction], layout: Layout) -> Dead:
    """One term for all tractions."""
    parts = [_part(load, layout) for load in loads]
    counts = [len(ints) for ints, _ in parts]
    width = max(ints.shape[1] for ints, _ in parts)
    first = np.cumsum([0, *counts])
    return Dead(
        [load.name for load, count in zip(loads, counts, strict=True) for _ in range(count)],
        np.vstack([_wide(ints, width, -1) for ints, _ in parts]),
        np.vstack([_wide(forces, 3 * width, 0) for _, forces in parts]),
        [
            (int(row), 0, load.amplitude)
            for i, load in enumerate(loads)
            for row in range(first[i], first[i + 1])
        ],
    )


def _wide(rows: NDArray, width: int, filling: int) -> NDArray:
    return np.pad(rows, ((0, 0), (0, width - rows.shape[1])), constant_values=filling)


def _part(load: Traction, layout: Layout) -> tuple[Indices, Array]:
    """First coordinates (n, k) and forces (n, 3 k) at amplitude one, of the loaded nodes."""
    body = layout.bodies.get(load.body)
    if isinstance(body, Continuum) and load.faces is not None:
        weights, vectors = _over_faces(body, np.asarray(load.faces, np.intp)), 1
    elif isinstance(body, Shell):
        shapes, vectors = _family(load, family_of(body).vectors)
        if load.edge is None:
            weights = _over_area(body.surface, shapes, vectors)
        else:
            weights = _along(load, body.surface, shapes, vectors)
    else:
        raise ValueError(f"load {load.name!r}: {load.body!r} is no shell, and no solid with faces")
    loaded = np.flatnonzero(weights.any(axis=1))
    ints = layout.node_dofs[load.body][loaded, None] + 3 * np.arange(vectors)
    forces = weights[loaded, :, None] * np.asarray(load.direction, float)
    return ints, forces.reshape(len(loaded), -1)


def _over_faces(body: Continuum, faces: Indices) -> Array:
    """(n, 1) integrals of the shape functions of the nodes of a solid over its faces [m^2]."""
    form = face_shape(STIFFNESS[body.element][0], FULL)
    X, total = np.asarray(body.points, float), np.zeros((len(body.points), 1))
    tangents = np.einsum("pkr,fki->fpri", form.slopes, X[faces])
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * form.weights
    np.add.at(total[:, 0], faces, area @ form.values)
    return total


def _family(load: Traction, names: tuple[str, ...]) -> tuple[Shapes, int]:
    """Shape functions of the middle surface, and the number of vectors of a node in them."""
    if names[1:] == ("r_u", "r_v", "r_uv"):
        from mechanics.shell48_kernels import shapes

        return shapes, 4
    if names[1:] == ("r_u", "r_v", "r_n"):
        from mechanics.shell3443 import unit_shapes

        return unit_shapes, 3
    if names[1:] == ("r_n",):
        return _bilinear, 1
    raise ValueError(f"load {load.name!r}: no consistent loads for shells with {names}")


def _bilinear(x: Array, y: Array, i: int, j: int) -> Array:
    """(n, 4) derivatives, i by x and j by y, of the bilinear functions."""
    ends = [np.stack([1.0 - z, z]) if k == 0 else np.stack([z * 0 - 1, z * 0 + 1])
            for z, k in ((x, i), (y, j))]  # fmt: skip
    corners = _CORNERS.astype(int)
    return np.stack([ends[0][a] * ends[1][b] for a, b in corners], axis=-1)


def _scaled(surface: Surface, vectors: int) -> Array:
    """(n_e, 4 k) sizes by which slopes by u, v become those by x, y."""
    a, b = surface.sizes.T
    return np.tile(np.stack([np.ones_like(a), a, b, a * b], axis=1)[:, :vectors], 4)


def _nodal(surface: Surface, vectors: int) -> Array:
    """(n_e, 4 k, 3) vectors of the corners, by x and y."""
    every = np.stack([surface.points, surface.d_u, surface.d_v, surface.d_uv], axis=1)
    corners = every[surface.quads][:, :, :vectors].reshape(len(surface.quads), -1, 3)
    return corners * _scaled(surface, vectors)[:, :, None]


def _over_area(surface: Surface, shapes: Shapes, vectors: int) -> Array:
    """(n, k) integrals of the shape functions over the surface [m^2] and by [m] and [m^2]."""
    x, y = (z.ravel() for z in np.meshgrid(_GAUSS, _GAUSS, indexing="ij"))
    X = _nodal(surface, vectors)
    base = [np.einsum("gi,eik->egk", shapes(x, y, i, 1 - i), X) for i in (1, 0)]
    area = np.linalg.norm(np.cross(*base), axis=2) * np.outer(_WEIGHT, _WEIGHT).ravel()
    parts = area @ shapes(x, y, 0, 0) * _scaled(surface, vectors)
    return _summed(surface, surface.quads, parts, vectors)


def _along(load: Traction, surface: Surface, shapes: Shapes, vectors: int) -> Array:
    """(n, k) integrals of the shape functions along an edge."""
    nodes = np.asarray(load.edge, int) % len(surface.points)
    total = np.zeros((len(surface.points), vectors))
    X, scaled = _nodal(surface, vectors), _scaled(surface, vectors)
    for pair in pairwise(nodes):
        e, side = _side(load, surface, pair)
        start, end = _CORNERS[list(SIDES[side][:2])]
        x, y = (start[i] + (end[i] - start[i]) * _GAUSS for i in (0, 1))
        along_u = 1 - SIDES[side][2]
        length = np.linalg.norm(shapes(x, y, along_u, 1 - along_u) @ X[e], axis=1)
        part = (_WEIGHT * length) @ shapes(x, y, 0, 0) * scaled[e]
        total += _summed(surface, surface.quads[e : e + 1], part[None], vectors)
    return total


def _side(load: Traction, surface: Surface, pair: tuple[int, int]) -> tuple[int, int]:
    """An element and the number of its side between two nodes."""
    for side, (first, last, _) in enumerate(SIDES):
        ends = surface.quads[:, [first, last]]
        found = np.flatnonzero((ends == pair).all(axis=1) | (ends == pair[::-1]).all(axis=1))
        if found.size:
            return int(found[0]), side
    raise ValueError(f"load {load.name!r}: nodes {pair[0]} and {pair[1]} have no common edge")


def _summed(surface: Surface, quads: Indices, parts: Array, vectors: int) -> Array:
    """(n, k) sums over elements of parts (n_e, 4 k)."""
    total = np.zeros((len(surface.points), vectors))
    np.add.at(total, quads, parts.reshape(len(quads), 4, vectors))
    return total
