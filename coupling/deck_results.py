"""What CalculiX printed: displacements of nodes, volumes, reactions, frequencies."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_TIME = re.compile(r"time\s+(\S+)\s*$")


class Printed(NamedTuple):
    """Of a job.

    times : (k,) float [s] or load factor;  nodes : (n,) counted from 0
    displacements : (k, n, 3) float [m], of the printed nodes
    reaction : (r, 3) float [N]  sum over held nodes, at times of its own
    volumes : (b,) float [m^3]  of each body at the end
    frequencies : (m,) float [Hz]  negative where the eigenvalue is
    """

    times: Array
    nodes: Indices
    displacements: Array
    reaction: Array
    volumes: Array
    frequencies: Array


def read(file: Path) -> Printed:
    """What a .dat file holds."""
    lines = file.read_text(errors="replace").splitlines() if file.exists() else []
    times, nodes, fields = _fields(lines)
    return Printed(
        times, nodes, fields, _rows_after(lines, " total force"), _volumes(lines),
        _frequencies(lines),
    )  # fmt: skip


def _block(lines: list[str], first: int) -> list[list[str]]:
    """The lines of numbers from one on."""
    found = []
    for line in lines[first:]:
        cells = line.split()
        if not cells or not _is_number(cells[0]):
            break
        found.append(cells)
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _fields(lines: list[str]) -> tuple[Array, Indices, Array]:
    times, fields, nodes = [], [], np.empty(0, np.intp)
    for i, line in enumerate(lines):
        if line.startswith(" displacements") and (at := _TIME.search(line)):
            rows = np.array(_block(lines, i + 2), dtype=float)
            times.append(float(at[1]))
            nodes = rows[:, 0].astype(np.intp) - 1
            fields.append(rows[:, 1:4])
    return np.array(times), nodes, np.array(fields).reshape(len(times), len(nodes), 3)


def _rows_after(lines: list[str], head: str) -> Array:
    found = [
        [float(cell) for cell in rows[0]]
        for i, line in enumerate(lines)
        if line.startswith(head) and (rows := _block(lines, i + 2))
    ]
    return np.array(found).reshape(-1, 3)


def _volumes(lines: list[str]) -> Array:
    """Of the last time that they were printed."""
    heads = [i for i, line in enumerate(lines) if line.startswith(" total volume")]
    named: dict[str, float] = {}
    for i in heads:
        rows = _block(lines, i + 2)
        if rows:
            named[lines[i].split(" set ")[1].split()[0]] = float(rows[0][0])
    return np.array([named[name] for name in sorted(named, key=lambda n: int(n[1:]))])


def _frequencies(lines: list[str]) -> Array:
    """(m,) [Hz]  real part of the last table of eigenvalues; negative where it is imaginary."""
    heads = [i for i, line in enumerate(lines) if "E I G E N V A L U E   O U T P U T" in line]
    if not heads:
        return np.empty(0)
    found = []
    for line in lines[heads[-1] + 1 :]:
        cells = line.split()
        if len(cells) == 5 and cells[0].isdigit():
            found.append(float(cells[3]) or -abs(float(cells[4])))
        elif found and cells and not _is_number(cells[0]):
            break
    return np.array(found)
