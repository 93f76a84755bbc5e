"""Sparse solvers of other people, with pivoting, behind one door.

SuperLU comes with scipy. PARDISO can be used where an ``mkl`` wheel lies in the environment,
UMFPACK where ``scikits.umfpack`` can be imported.
"""

import ctypes
import os
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from mechanics.assembly import Pattern

Array = NDArray[np.float64]


class Library(NamedTuple):
    """A solver for one pattern that keeps its last factors.

    factor : from data (nnz + 1,) to 0, or 1 where the matrix is singular or not finite
    solve : replaces a right-hand side (n,) by the solution, or by NaN without factors
    """

    name: str
    factor: Callable[[Array], int]
    solve: Callable[[Array], None]


def find(name: str, pattern: Pattern, symmetric: bool) -> Library:
    """The library of this name."""
    if name not in MAKERS:
        raise ValueError(f"no linear solver {name!r}; there are {', '.join(MAKERS)}")
    try:
        return MAKERS[name](pattern, symmetric)
    except ImportError as error:
        raise ValueError(f"the linear solver {name!r} is not installed") from error


def _keeping(name: str, factorise: Callable[[Array], Callable[[Array], Array] | None]) -> Library:
    """A library whose ``factorise(data)`` gives a solver, or None."""
    kept: list[Callable[[Array], Array]] = []

    def factor(data: Array) -> int:
        kept.clear()
        found = factorise(data) if np.isfinite(data).all() else None
        kept.extend([found] if found else [])
        return 0 if found else 1

    def solve(b: Array) -> None:
        b[:] = kept[0](b) if kept else np.nan

    return Library(name, factor, solve)


def _superlu(pattern: Pattern, symmetric: bool) -> Library:
    def factorise(data: Array) -> Callable[[Array], Array] | None:
        try:
            return splu(pattern.matrix(data)).solve
        except RuntimeError:  # SuperLU: "Factor is exactly singular"
            return None

    return _keeping("superlu", factorise)


def _umfpack(pattern: Pattern, symmetric: bool) -> Library:
    umfpack = import_module("scikits.umfpack")

    def factorise(data: Array) -> Callable[[Array], Array] | None:
        try:
            return umfpack.splu(pattern.matrix(data)).solve
        except (RuntimeError, ValueError):
            return None

    return _keeping("umfpack", factorise)


# -- PARDISO ---------------------------------------------------------------------------------------

SYMMETRIC_INDEFINITE, UNSYMMETRIC = -2, 11
ANALYSE, FACTORISE, SOLVE = 11, 22, 33
OWN, ORDERING, PIVOT, SCALING, TRANSPOSED, MATCHING, PERTURBED, FROM_ZERO = (
    0, 1, 9, 10, 11, 12, 13, 34,
)  # fmt: skip
"""Places in the array iparm of its manual."""


def _mkl() -> Any:
    """The runtime library of an mkl wheel, on one thread unless the environment says otherwise."""
    os.environ.setdefault("MKL_THREADING_LAYER", "SEQUENTIAL")
    names = "libmkl_rt.so*", "libmkl_rt*.dylib", "mkl_rt*.dll"
    folders = Path(sys.prefix) / "lib", Path(sys.prefix) / "Library" / "bin"
    for folder in folders:
        for name in names:
            for path in sorted(folder.glob(name)):
                return ctypes.CDLL(str(path))
    raise ImportError("no mkl")


def _pardiso(pattern: Pattern, symmetric: bool) -> Library:
    """Symmetric: with scaling and weighted matching, for the zero diagonal of constraints."""
    mkl = _mkl()
    indptr, indices = pattern.indptr, pattern.indices
    kept = np.arange(len(indices))
    if symmetric:  # the lower triangle by columns is the upper one by rows
        column = np.repeat(np.arange(pattern.size), np.diff(indptr))
        kept = np.flatnonzero(indices >= column)
        counts = np.bincount(column[kept], minlength=pattern.size)
        indptr = np.concatenate([[0], np.cumsum(counts)])
    ia, ja = np.ascontiguousarray(indptr, np.int32), np.ascontiguousarray(indices[kept], np.int32)
    values, x = np.zeros(len(kept)), np.zeros(pattern.size)
    memory, iparm = np.zeros(64, np.int64), np.zeros(64, np.int32)
    iparm[[OWN, FROM_ZERO, SCALING, MATCHING]] = 1
    iparm[ORDERING], iparm[PIVOT] = 2, 8 if symmetric else 13
    iparm[TRANSPOSED] = 0 if symmetric else 2  # the columns of a matrix are rows of its transpose
    kind = SYMMETRIC_INDEFINITE if symmetric else UNSYMMETRIC

    analysed: list[bool] = []

    def call(phase: int, b: Array) -> int:
        error, zero, one = ctypes.c_int(0), ctypes.c_int(0), ctypes.c_int(1)
        numbers = [ctypes.c_int(k) for k in (1, 1, kind, phase, pattern.size)]
        arrays = [a.ctypes.data_as(ctypes.c_void_p) for a in (values, ia, ja)]
        ends = [a.ctypes.data_as(ctypes.c_void_p) for a in (iparm,)]
        sides = [a.ctypes.data_as(ctypes.c_void_p) for a in (b, x)]
        by = [ctypes.byref(k) for k in numbers]
        mkl.pardiso(
            memory.ctypes.data_as(ctypes.c_void_p), *by, *arrays, None, ctypes.byref(one), *ends,
            ctypes.byref(zero), *sides, ctypes.byref(error),
        )  # fmt: skip
        return int(error.value)

    def factor(data: Array) -> int:
        if not np.isfinite(data).all():
            return 1
        np.take(data, kept, out=values)
        # the matching of an earlier matrix serves as long as no pivot had to be changed
        if analysed and not call(FACTORISE, x) and not iparm[PERTURBED]:
            return 0
        analysed.append(True)
        return int(bool(call(ANALYSE, x) or call(FACTORISE, x)))

    def solve(b: Array) -> None:
        call(SOLVE, b)
        b[:] = x

    return Library("pardiso", factor, solve)


MAKERS: dict[str, Callable[[Pattern, bool], Library]] = {
    "pardiso": _pardiso,
    "umfpack": _umfpack,
    "superlu": _superlu,
}
