"""Eigenvalues on the motions that constraints allow: K x + B^T l = mu M x, B x = 0.

The lowest are found by subspace iteration with the inverse of the saddle-point matrix
[[K - s M, B^T], [B, 0]], which keeps B x = 0. A block of vectors misses no multiple eigenvalue,
such as the six rigid motions, as the Lanczos method may. The inverse keeps the soft motions of
slender bodies that a dense solution of K x = mu M x loses in the round-off of the stiff ones;
that is used, in a basis of the null space of B, where most eigenvalues are wanted.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, eigh, null_space
from scipy.sparse import block_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from mechanics.signs import negatives_dense

Array = NDArray[np.float64]

PASSES, ITERATIONS = 30, 200
"""Shifts tried on the way to the lowest eigenvalues; iterations with each."""
FAR = 0.3
"""Ten times an eigenvalue, relative to the shift, that calls for one nearer [-]."""
STILL = 1e-11
"""Change of the eigenvalues, relative to the shift, at the end [-]."""
SHARP = 1e-3
"""Change at the end, relative to the largest one sought, that round-off may leave [-]."""
ROUNDING = 1e-12
"""Smallest shift, relative to ``ratio`` [-]."""
LOST = (
    "the lowest eigenvalues cannot be told from round-off: a body is too slender, or free to spin"
)
HELD = 1e-12
"""Constraints of which no more than this part is new are repeated ones [-]."""
STIFF = 1e3
"""Stiffness put in place of constraints to count signs, of that of the coordinates held [-]."""


class Shifted(NamedTuple):
    """The matrix K - s M on the motions that constraints allow.

    below : number of eigenvalues below the shift s
    inverse : makes b (n, k) -> x (n, k) with (K - s M) x + B^T l = b, B x = 0
    """

    below: int
    inverse: Callable[[], Callable[[Array], Array]]


def basis(B: csc_array) -> Array:
    """(n, k) orthonormal basis of the motions that the constraints ``B`` (m, n) allow."""
    m, n = B.shape
    return null_space(B.toarray(), rcond=HELD) if m else np.eye(n)


def lowest(
    K: csc_array,
    M: csc_array,
    B: csc_array,
    count: int,
    size: Array,
    factorised: Callable[[float], Shifted | None] = lambda shift: None,
) -> tuple[Array, Array]:
    """The ``count`` algebraically lowest eigenvalues (k,) and shapes (n, k), x^T M x = 1.

    M is positive semidefinite; where it is zero, as for coordinates of joints, the eigenvalue
    is infinite. All negative eigenvalues come first.

    Parameters
    ----------
    size : (n,)  what of each coordinate is a large change; only its order of magnitude matters
    factorised : from a shift to what is known of K - s M by a factorisation of its own; None: where
        it does not help
    """
    K = csc_array(0.5 * (K + K.T))
    free = K.shape[0] - B.shape[0]
    if count > free // 4:
        return _lowest_dense(K, M, B, count)
    unit = ratio(K, M, size)
    many = min(free, count + max(8, count))
    X = np.random.default_rng(0).standard_normal((K.shape[0], many))
    shift = -1e-5 * unit
    nearer = True
    for _ in range(PASSES):
        shifted = factorised(shift) or _shifted(csc_array(K - shift * M), B)
        if shifted.below:
            shift, nearer = 10.0 * shift, False
            continue
        try:
            values, X, moved = _iterated(M, shifted.inverse(), X, shift, count, not nearer)
        except LinAlgError:  # the shift drowns in round-off
            shift, nearer = 100.0 * shift, False
            continue
        close = max(10.0 * float(values[count - 1]), ROUNDING * unit)
        if not nearer or close > FAR * abs(shift):
            values, X = values[:count], X[:, :count]
            allowed = SHARP * max(float(np.abs(values).max()), ROUNDING * unit)
            if np.any(moved > allowed + noise(K, X)):
                raise ArithmeticError(LOST)
            return values, X
        shift = -close
    raise ArithmeticError(LOST)


def _shifted(matrix: csc_array, B: csc_array) -> Shifted:
    return Shifted(negatives(matrix, B), partial(saddle_solve, matrix, B))


def _iterated(
    M: csc_array,
    inverse: Callable[[Array], Array],
    X: Array,
    shift: float,
    count: int,
    last: bool,
) -> tuple[Array, Array, Array]:
    """Subspace iteration (Bathe 1971): Ritz values (p,) and vectors (n, p) of the block ``X``.

    Ends once the first ``count`` values stand still, also because of round-off, or are seen to
    lie far from the shift; last comes how far they moved at the end.
    """
    before, errors = np.full(count, np.inf), [np.inf]
    for iteration in range(ITERATIONS):
        MX = M @ X
        Y = inverse(MX)
        A, C = Y.T @ MX, Y.T @ (M @ Y)
        theta, V = eigh(0.5 * (C + C.T), 0.5 * (A + A.T))
        theta, V = theta[::-1], V[:, ::-1]
        X = Y @ (V / np.sqrt(theta))
        values = shift + 1.0 / theta
        moved = np.abs(values[:count] - before)
        errors.append(float(moved.max()))
        stagnant = len(errors) > 20 and errors[-1] >= 0.5 * min(errors[:-20])
        if errors[-1] <= STILL * (abs(values[0]) + abs(shift)) or stagnant:
            return values, X, moved
        if not last and iteration >= 2 and 10.0 * values[count - 1] < FAR * abs(shift):
            return values, X, moved
        before = values[:count]
    raise ArithmeticError(LOST)


def noise(K: csc_array, X: Array) -> Array:
    """(k,) what round-off of the products in x^T K x may leave of each of the vectors (n, k)."""
    X = np.abs(X)
    return 1e-15 * np.einsum("ij,ij->j", X, abs(K) @ X)


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


def saddle_solve(K: csc_array, B: csc_array) -> Callable[[Array], Array]:
    """b (n,) or (n, k) -> x of the same shape with K x + B^T l = b, B x = 0."""
    n, m = K.shape[0], B.shape[0]
    matrix = block_array([[K, B.T], [B, None]], format="csc") if m else csc_array(K)
    return refined(matrix, splu(matrix).solve, n)


def refined(matrix: csc_array, solve: Callable[[Array], Array], n: int) -> Callable[[Array], Array]:
    """The first ``n`` unknowns of solutions (n + m,) or (n + m, k), corrected once."""
    m = matrix.shape[0] - n

    def inverse(b: Array) -> Array:
        whole = np.concatenate([b, np.zeros((m, *b.shape[1:]))])
        x = solve(whole)
        return (x + solve(whole - matrix @ x))[:n]  # refined: constraints hold to round-off

    return inverse


def negatives(K: csc_array, B: csc_array) -> int:
    """Number of negative eigenvalues of K on the motions that ``B`` allows.

    By Sylvester's law of inertia, from the signs of the pivots of a symmetric factorisation.
    Constraints are taken as stiff springs, whose forces are unknowns of their own or, where that
    needs other pivots, are eliminated: the signs are the same. Where both need other pivots, from
    the dense factors of Bunch & Kaufman (1977).
    """
    m, K = B.shape[0], csc_array(0.5 * (K + K.T))
    if not m:
        count = _pivots(K)
        return negatives_dense(K.toarray()) if count is None else count
    soft = _softness(K, B)
    matrix = csc_array(block_array([[K, B.T], [B, diags_array(-soft)]], format="csc"))
    count = _pivots(matrix)
    if count is not None:
        return count - m
    count = _pivots(csc_array(K + B.T @ diags_array(1.0 / soft) @ B))
    return negatives_dense(matrix.toarray()) - m if count is None else count


def _pivots(matrix: csc_array) -> int | None:
    """Negative pivots of a factorisation with a symmetric order; None where it needs another."""
    options = {"SymmetricMode": True}
    try:
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # exactly singular
        return None
    if not np.array_equal(lu.perm_r, lu.perm_c):
        return None
    return int(np.count_nonzero(lu.U.diagonal() < 0.0))


def _softness(K: csc_array, B: csc_array) -> Array:
    """(m,) of springs in place of constraints, each far stiffer than what it holds."""
    diagonal = np.abs(K).max(axis=1).toarray().ravel()
    weighted = abs(B) @ diags_array(diagonal)
    largest = csc_array(abs(B)).max(axis=1).toarray().ravel()
    stiff = csc_array(weighted).max(axis=1).toarray().ravel() / np.maximum(largest, 1e-300)
    return largest**2 / (STIFF * np.where(stiff > 0.0, stiff, np.max(diagonal)))
