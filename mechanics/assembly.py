"""A sparsity pattern made once, and slots through which blocks are added to it.

The pattern is compressed by columns. A block entry whose row or column is -1 (a coordinate
that does not exist, such as the ground side of a joint) goes to one spare slot at the end of
the data array, so that kernels need no test.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Pattern(NamedTuple):
    """Compressed columns of a square matrix.

    indptr : (n + 1,) int32
    indices : (nnz,) int32  rows, sorted within a column
    """

    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]

    @property
    def size(self) -> int:
        return len(self.indptr) - 1

    def zeros(self) -> Array:
        """Data array (nnz + 1,) with the spare slot at its end."""
        return np.zeros(len(self.indices) + 1)

    def matrix(self, data: Array) -> csc_array:
        """The sparse matrix of a data array, sharing its memory."""
        shape = (self.size, self.size)
        return csc_array((data[:-1], self.indices, self.indptr), shape=shape)


def pattern(size: int, blocks: Sequence[tuple[Indices, Indices]]) -> tuple[Pattern, list[Indices]]:
    """Pattern that holds all blocks, and the slots of each block entry in it.

    Parameters
    ----------
    size : int  number of rows and columns
    blocks : pairs of row indices (n_b, r) and column indices (n_b, c); -1 means absent

    Returns
    -------
    pattern, [slots (n_b, r, c) for each pair]
    """
    keys = [_keys(size, rows, columns) for rows, columns in blocks]
    present = np.sort(np.concatenate([k.ravel() for k in keys]))
    present = present[
        np.append(True, present[1:] != present[:-1])[: present.size]
    ]  # quicker than np.unique
    present = present[present < size * size]
    counts = np.bincount(present // size, minlength=size)
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    slots = [np.searchsorted(present, k).astype(np.intp) for k in keys]
    return Pattern(indptr, (present % size).astype(np.int32)), slots


def _keys(size: int, rows: Indices, columns: Indices) -> NDArray[np.int64]:
    """Position of each entry in column-major order; one past the last for absent entries."""
    rows, columns = np.asarray(rows, np.int64), np.asarray(columns, np.int64)
    keys = columns[:, None, :] * size + rows[:, :, None]
    absent = (rows[:, :, None] < 0) | (columns[:, None, :] < 0)
    return np.where(absent, size * size, keys)
