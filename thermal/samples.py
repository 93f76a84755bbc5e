"""Points of several faces as rows of one sparse matrix, for exchange between them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from thermal.discretisation import Block, Face

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Samples(NamedTuple):
    """Integration points of faces, one after the other.

    nodes : (u,) intp  temperatures they depend on
    at : (P, u)  interpolation, T[nodes] -> T at the points
    areas : (P,) float [m^2]
    points, normals : (P, 3) float
    facets, faces : (P,) intp  facet and face of each point, counted over all faces
    """

    nodes: Indices
    at: csr_array
    areas: Array
    points: Array
    normals: Array
    facets: Indices
    faces: Indices


def samples(faces: Sequence[Face]) -> Samples:
    """The points of ``faces``."""
    blocks = [block for face in faces for block in face]
    counts = [sum(block.areas.size for block in face) for face in faces]
    each = [_facets(block) for block in blocks]
    firsts = np.cumsum([0, *(len(block.dofs) for block in blocks)])
    every = vstack([_rows(block, _size(blocks)) for block in blocks], format="csr")
    nodes = np.unique(np.concatenate([block.dofs.ravel() for block in blocks]))
    return Samples(
        nodes,
        csr_array(every[:, nodes]),
        np.concatenate([block.areas.ravel() for block in blocks]),
        np.concatenate([block.points.reshape(-1, 3) for block in blocks]),
        np.concatenate([block.normals.reshape(-1, 3) for block in blocks]),
        np.concatenate([own + first for own, first in zip(each, firsts[:-1], strict=True)]),
        np.repeat(np.arange(len(faces)), counts),
    )


def _size(blocks: Sequence[Block]) -> int:
    return 1 + max(int(block.dofs.max()) for block in blocks)


def _facets(block: Block) -> Indices:
    return np.repeat(np.arange(len(block.dofs)), block.areas.shape[1])


def _rows(block: Block, n: int) -> csr_array:
    """(g p, n) interpolation at the points of one block."""
    g, k = block.dofs.shape
    p = len(block.values)
    columns = np.broadcast_to(block.dofs[:, None, :], (g, p, k)).ravel()
    values = np.broadcast_to(block.values, (g, p, k)).ravel()
    return csr_array((values, columns, np.arange(0, g * p * k + 1, k)), shape=(g * p, n))


def averaging(areas: Array, groups: Indices, count: int) -> csr_array:
    """(count, P)  area-weighted means over groups of points."""
    sums = grouped(areas, groups, count)
    rows = np.argsort(groups, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(groups, minlength=count))])
    return csr_array((areas[rows] / sums[groups[rows]], rows, starts), shape=(count, len(areas)))


def grouped(areas: Array, groups: Indices, count: int) -> Array:
    """(count,)  sums over groups of points."""
    return np.asarray(np.bincount(groups, areas, count), dtype=float)


class Products:
    """Products of the entries of each row of one sparse matrix with those of another's row.

    rows, columns : (k,) intp  of the entries of the sum over points p of weight_p a_pi b_pj
    points : (k,) intp  p of each
    """

    def __init__(self, a: csr_array, b: csr_array) -> None:
        many, each = np.diff(a.indptr), np.diff(b.indptr)
        counts = many * each
        self.points = np.repeat(np.arange(len(counts)), counts)
        within = np.arange(len(self.points)) - np.repeat(np.cumsum(counts) - counts, counts)
        i, j = np.divmod(within, each[self.points])
        self.rows = a.indices[a.indptr[:-1][self.points] + i].astype(np.intp)
        self.columns = b.indices[b.indptr[:-1][self.points] + j].astype(np.intp)

    def factors(self, a: csr_array, b: csr_array) -> Array:
        """(k,)  a_pi b_pj of matrices with entries within those of the pattern."""
        return self._entries(a, self.rows) * self._entries(b, self.columns)

    def _entries(self, matrix: csr_array, columns: Indices) -> Array:
        """Matrix entries (points, columns); zero where there are none."""
        ordered = csr_array(matrix)
        ordered.sum_duplicates()
        width = ordered.shape[1]
        lines = np.repeat(np.arange(ordered.shape[0]), np.diff(ordered.indptr))
        keys = lines * width + ordered.indices
        wanted = self.points * width + columns
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where(keys[place] == wanted, ordered.data[place], 0.0)
