"""The file probes.csv: what the probes saw, one row per coupling window or equilibrium."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.clocks import clock_of
from coupling.columns import STANDARD
from coupling.reading import Results

ORDER = {name: rank for rank, name in enumerate(STANDARD["probes"])}
LETTERS = {"position": "", "velocity": "v", "acceleration": "a"}


def write_probes(results: Results, path: Path) -> Path | None:
    """Write all probes to ``path`` and return it; None when the run has no probes.

    The header reads ``time [s],tip.x [m],tip.y [m],…,tip.vx [m/s],…,tip.temperature [K]``.
    In statics and of modes the first column is ``load factor [-]`` or ``mode [-]``. A cell is empty
    where a probe has no row at that time.
    """
    probes = [name for name in results.names("probes") if f"probes/{name}/time" in results]
    if not probes:
        return None
    clocks = {name: results[f"probes/{name}/time"] for name in probes}
    time, rows = _together(list(clocks.values()))
    columns: dict[str, list[Any]] = {clock_of(results).label: time.tolist()}
    for name, row in zip(probes, rows, strict=True):
        columns |= _probe_columns(results, name, row, len(time))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return path


def _together(
    clocks: list[NDArray[np.float64]],
) -> tuple[NDArray[np.float64], list[NDArray[np.intp]]]:
    """All times once, and the row of each time of each clock; a path keeps its order."""
    if all(np.array_equal(clock, clocks[0]) for clock in clocks):
        return clocks[0], [np.arange(len(clocks[0]))] * len(clocks)
    time = np.unique(np.concatenate(clocks))
    return time, [np.searchsorted(time, clock) for clock in clocks]


def _probe_columns(
    results: Results, probe: str, row: NDArray[np.intp], rows: int
) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {}
    table = results.table(f"probes/{probe}")
    table.pop("time")
    for name, data in sorted(table.items(), key=lambda item: ORDER.get(item[0], len(ORDER))):
        unit = results.column(f"probes/{probe}/{name}").unit
        for label, values in _components(name, data):
            cells: list[Any] = [""] * rows
            for index, value in zip(row.tolist(), values.tolist(), strict=True):
                cells[index] = value
            columns[f"{probe}.{label} [{unit}]"] = cells
    return columns


def _components(name: str, data: NDArray[Any]) -> list[tuple[str, NDArray[Any]]]:
    if data.ndim == 1:
        return [(name, data)]
    prefix = LETTERS.get(name, f"{name}_")
    return [(f"{prefix}{axis}", data[:, k]) for k, axis in enumerate("xyz"[: data.shape[1]])]
