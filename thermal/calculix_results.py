"""Temperatures that CalculiX computed: in all digits from its restart file, or as printed."""

import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COMPONENTS = 4  # of a node's solution: temperature, three displacements
PRINTED = 2e-6  # relative, by which printed temperatures differ from those of the restart file


class Results(NamedTuple):
    """Temperatures (k, n) [K] at times (k,) [s]; exact: whether in all digits at each time."""

    times: Array
    temperatures: Array
    exact: bool


def read(job: Path, n: int) -> Results:
    """What a job, the path of its files without their suffix, has left behind.

    Raises ValueError when there are no temperatures of ``n`` nodes.
    """
    times, steps = _increments(job.with_suffix(".sta"))
    printed = _printed(job.with_suffix(".dat"), n)
    if not len(printed) or len(printed) != len(times):
        raise ValueError(f"it left {len(printed)} temperature fields of {len(times)} increments")
    exact = _restarts(job.with_suffix(".rout"), n)
    ends = np.flatnonzero(np.diff(np.append(steps, steps[-1] + 1)))
    kept = 0
    for i, full in zip(ends, exact, strict=False):
        if np.allclose(full, printed[i], rtol=PRINTED, atol=0.0):
            printed[i], kept = full, kept + 1
    return Results(times, printed, kept == len(times))


def _increments(file: Path) -> tuple[Array, NDArray[np.intp]]:
    """Total time [s] at the end of each accepted increment, and its step."""
    rows = [line.split() for line in file.read_text().splitlines()[2:]] if file.exists() else []
    done = [row for row in rows if len(row) == 7 and not row[2].endswith("U")]
    times = np.array([float(row[4]) for row in done])
    return times, np.array([int(row[0]) for row in done], dtype=np.intp)


def _printed(file: Path, n: int) -> Array:
    """(k, n) [K]"""
    lines = file.read_text().splitlines() if file.exists() else []
    heads = [i for i, line in enumerate(lines) if line.startswith(" temperatures")]
    fields = [np.array([line.split()[1] for line in lines[i + 2 : i + 2 + n]]) for i in heads]
    return np.array([f.astype(float) for f in fields if len(f) == n]).reshape(-1, n)


def _restarts(file: Path, n: int) -> list[Array]:
    """(n,) [K] at the end of each step; empty where the file is not as expected."""
    size = 8 * COMPONENTS * n
    fields = []
    for record in _records(file.read_bytes() if file.exists() else b""):
        if len(record) == size:
            values = np.frombuffer(record).reshape(n, COMPONENTS)
            if values[:, 0].any() and not values[:, 1:].any():
                fields.append(values[:, 0].copy())
    return fields


def _records(content: bytes) -> list[memoryview]:
    """Records of an unformatted sequential Fortran file."""
    view, found, at = memoryview(content), [], 0
    while at + 8 <= len(view):
        (length,) = struct.unpack_from("<i", view, at)
        if length < 0 or at + 8 + length > len(view):
            break
        found.append(view[at + 4 : at + 4 + length])
        at += 8 + length
    return found


def message(output: str, lines: int = 6) -> str:
    """The last words of a job that failed, or what it called an error."""
    said = [line.strip() for line in output.splitlines() if line.strip()]
    errors = [i for i, line in enumerate(said) if line.startswith("*ERROR")]
    return "; ".join(said[errors[-1] :][:lines] if errors else said[-lines:])
