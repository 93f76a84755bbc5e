"""Signs of the eigenvalues of a symmetric matrix, from its factors by ``mechanics.block_kernels``.

By Sylvester's law of inertia they are those of the pivots of LDL^T and, of blocks in which pivots
were sought, those of the block as it was before it was eliminated (Haynsworth 1968).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvalsh, ldl

from mechanics.block_kernels import PEAK, RECORDS, SIZE

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PASSES = 4
"""Of scaling rows and columns, each by the root of its largest number."""


def negatives(ints: Indices, work: Array) -> int:
    """Number of negative eigenvalues of a matrix whose factors ``factor_symmetric`` left."""
    size, peak = int(ints[SIZE]), int(ints[PEAK])
    inverses, swaps = work[peak + size : peak + 2 * size], work[peak + 2 * size : peak + 3 * size]
    at, count = int(ints[RECORDS]), 0
    while at < len(ints):
        n, r, start, below, first = (int(x) for x in ints[at + 1 : at + 6])
        if below < 0:
            count += int(np.count_nonzero(inverses[first : first + n] < 0.0))
        else:
            front = work[start : start + n * (n + r)].reshape(n, n + r)[:, :n]
            count += negatives_dense(_whole(front, swaps[first : first + n].astype(int)))
        at = _after(ints, at)
    return count


def negatives_dense(matrix: Array) -> int:
    """Number of negative eigenvalues, from 1x1 and 2x2 blocks of pivots (Bunch & Kaufman 1977)."""
    scaled = 0.5 * (matrix + matrix.T)
    for _ in range(PASSES):
        root = np.sqrt(np.abs(scaled).max(axis=0, initial=0.0))
        root[root == 0.0] = 1.0
        scaled = scaled / np.multiply.outer(root, root)
    return int(np.count_nonzero(eigvalsh(ldl(scaled)[1]) < 0.0))


def _whole(front: Array, swaps: NDArray[np.intp]) -> Array:
    """The block whose LU with partial pivoting stands in ``front``."""
    found = (np.tril(front, -1) + np.eye(len(front))) @ np.triu(front)
    for i in range(len(front) - 1, -1, -1):
        found[[i, swaps[i]]] = found[[swaps[i], i]]
    return found


def _after(ints: Indices, at: int) -> int:
    """The record that follows."""
    at += 7 + 2 * int(ints[at + 6])
    count = int(ints[at])
    at += 1
    for _ in range(count):
        at += 6 + 2 * int(ints[at + 5])
    return at
