"""A mesh: points, cells by family, named regions."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Points, cells and named sets of cells.

    Attributes
    ----------
    points : (n, 3) float [m]
    cells : family -> (m, k) int  rows of point indices; families named as in meshio
        ("line", "triangle", "quad", "hexahedron", ...)
    regions : name -> (family, (r,) int)  cells of that family
    others : name -> family -> (r,) int  cells that regions have of further families
    """

    points: Array
    cells: Mapping[str, Indices]
    regions: Mapping[str, tuple[str, Indices]] = field(default_factory=dict)
    others: Mapping[str, Mapping[str, Indices]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise ValueError(f"mesh points must have the shape (n, 3), got {self.points.shape}")
        if not np.isfinite(self.points).all():
            raise ValueError("mesh points must be finite")
        for family, cells in self.cells.items():
            _require_indices(f"{family} cells", cells, len(self.points), "points")
        for name in {**self.regions, **self.others}:
            if name not in self.regions:
                raise ValueError(f"region '{name}': it has further cells, but no first ones")
            for family, members in self.cells_of(name).items():
                if family not in self.cells:
                    raise ValueError(f"region '{name}': the mesh has no {family} cells")
                _require_indices(f"region '{name}'", members, len(self.cells[family]), "cells")

    def cells_of(self, region: str) -> dict[str, Indices]:
        """All cells of a region: family -> (r,) int."""
        family, members = self.regions[region]
        return {family: members, **self.others.get(region, {})}


def _require_indices(what: str, indices: Indices, n: int, of: str) -> None:
    if indices.size and not (indices.min() >= 0 and indices.max() < n):
        raise ValueError(f"{what}: an index lies outside the {n} {of} of the mesh")
