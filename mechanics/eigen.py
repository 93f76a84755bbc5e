"""Eigenvalues on the motions that constraints allow: K x + B^T l = mu M x, B x = 0.

The lowest are found by the Lanczos method with the inverse of the saddle-point matrix
[[K - s M, B^T], [B, 0]], which keeps B x = 0 (Ericsson & Ruhe 1980, Math. Comp. 35:1251). Besides
being made for large problems, it finds the soft motions of slender bodies that a dense solution
of K x = mu M x loses in the round-off of the stiff ones. Dense, in a basis of the null space of
B, where most eigenvalues are wanted.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, eigh, eigvalsh, ldl, null_space
from scipy.sparse import block_array, csc_array, diags_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu

Array = NDArray[np.float64]

PASSES = 3
"""Shifts tried on the way to the lowest eigenvalues."""
ROUNDING = 1e-12
"""Eigenvalues that are not distinguished from zero, relative to ``ratio`` [-]."""
HELD = 1e-12
"""Constraints of which no more than this part is new are repeated ones [-]."""
STIFF = 1e3
"""Stiffness put in place of constraints to count signs, of that of the coordinates held [-]."""


def basis(B: csc_array) -> Array:
    """(n, k) orthonormal basis of the motions that the constraints ``B`` (m, n) allow."""
    m, n = B.shape
    return null_space(B.toarray(), rcond=HELD) if m else np.eye(n)


def lowest(
    K: csc_array, M: csc_array, B: csc_array, count: int, size: Array
) -> tuple[Array, Array]:
    """The ``count`` algebraically lowest eigenvalues (k,) and shapes (n, k), x^T M x = 1.

    M is positive semidefinite; where it is zero, as for coordinates of joints, the eigenvalue
    is infinite. All negative eigenvalues come first.

    Parameters
    ----------
    size : (n,)  what of each coordinate is a large change; only its order of magnitude matters
    """
    K = csc_array(0.5 * (K + K.T))
    free = K.shape[0] - B.shape[0]
    if count > free // 4:
        return _lowest_dense(K, M, B, count)
    unit = ratio(K, M, size)
    shift, passes = -1e-5 * unit, 0
    while True:
        moved = csc_array(K - shift * M)
        if negatives(moved, B):  # there are eigenvalues below the shift
            shift, passes = 10.0 * shift, PASSES
            continue
        values, shapes = _shifted(K, M, saddle_solve(moved, B), shift, count)
        nearer = max(10.0 * float(values[-1]), ROUNDING * unit)
        if passes >= PASSES or nearer > 1e-3 * abs(shift):
            return values, shapes
        shift, passes = -nearer, passes + 1


def ratio(K: csc_array, M: csc_array, size: Array) -> float:
    """Size of the terms whose sum an eigenvalue is: what round-off is relative to."""
    return float(size @ (abs(K) @ size)) / float(size @ (abs(M) @ size))


def _lowest_dense(K: csc_array, M: csc_array, B: csc_array, count: int) -> tuple[Array, Array]:
    free = basis(B)
    count = min(count, free.shape[1])
    stiffness, inertia = (free.T @ (A @ free) for A in (K, M))
    stiffness, inertia = (0.5 * (A + A.T) for A in (stiffness, inertia))
    try:
        values, shapes = eigh(stiffness, inertia, subset_by_index=[0, count - 1])
    except LinAlgError:  # motions without mass
        values, shapes = _inverted(stiffness, inertia, count)
    return values, free @ shapes


def _inverted(stiffness: Array, inertia: Array, count: int) -> tuple[Array, Array]:
    """M x = theta (K - s M) x with theta = 1/(mu - s), for a semidefinite M."""
    shift = -1e-6 * np.trace(stiffness) / np.trace(inertia)
    for _ in range(40):
        try:
            theta, shapes = eigh(inertia, stiffness - shift * inertia)
        except LinAlgError:
            shift *= 10.0
            continue
        moving = theta > 1e-14 * theta[-1]
        theta, shapes = theta[moving][::-1][:count], shapes[:, moving][:, ::-1][:, :count]
        return shift + 1.0 / theta, shapes / np.sqrt(theta)
    raise ArithmeticError("a motion without mass is unstable")


def _shifted(
    K: csc_array, M: csc_array, inverse: Callable[[Array], Array], shift: float, count: int
) -> tuple[Array, Array]:
    n = K.shape[0]
    operator = LinearOperator((n, n), matvec=inverse, dtype=float)
    first = inverse(M @ np.random.default_rng(0).standard_normal(n))
    values, shapes = eigsh(
        K, count, M, sigma=shift, OPinv=operator, v0=first, ncv=max(2 * count + 20, 40)
    )
    order = np.argsort(values)
    return values[order], shapes[:, order]


def saddle_solve(K: csc_array, B: csc_array) -> Callable[[Array], Array]:
    """b (n,) -> x (n,) with K x + B^T l = b, B x = 0."""
    n, m = K.shape[0], B.shape[0]
    matrix = block_array([[K, B.T], [B, None]], format="csc") if m else csc_array(K)
    solve = splu(matrix).solve

    def inverse(b: Array) -> Array:
        return solve(np.concatenate([np.ravel(b), np.zeros(m)]))[:n]

    return inverse


def negatives(K: csc_array, B: csc_array) -> int:
    """Number of negative eigenvalues of K on the motions that ``B`` allows.

    By Sylvester's law of inertia, from the signs of the pivots of a symmetric factorisation; where
    that needs other pivots, from the dense factors of Bunch & Kaufman (1977). Constraints are
    taken as stiff springs: the signs are the same.
    """
    m = B.shape[0]
    matrix = _penalised(csc_array(0.5 * (K + K.T)), B)
    options = {"SymmetricMode": True}
    try:
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # exactly singular
        return _by_blocks(matrix) - m
    if np.array_equal(lu.perm_r, lu.perm_c):
        return int(np.count_nonzero(lu.U.diagonal() < 0.0)) - m
    return _by_blocks(matrix) - m


def _penalised(K: csc_array, B: csc_array) -> csc_array:
    """[[K, B^T], [B, -e]]: constraints as springs of stiffness 1/e, no zero on the diagonal."""
    if not B.shape[0]:
        return K
    diagonal = np.abs(K).max(axis=1).toarray().ravel()
    weighted = abs(B) @ diags_array(diagonal)
    largest = csc_array(abs(B)).max(axis=1).toarray().ravel()
    stiff = csc_array(weighted).max(axis=1).toarray().ravel() / np.maximum(largest, 1e-300)
    soft = largest**2 / (STIFF * np.where(stiff > 0.0, stiff, np.max(diagonal)))
    return csc_array(block_array([[K, B.T], [B, diags_array(-soft)]], format="csc"))


def _by_blocks(matrix: csc_array) -> int:
    """Negative eigenvalues from the 1x1 and 2x2 blocks of a dense factorisation."""
    blocks = ldl(matrix.toarray())[1]
    return int(np.count_nonzero(eigvalsh(blocks) < 0.0))
