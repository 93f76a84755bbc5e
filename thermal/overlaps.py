"""Conditions that prescribe temperatures of the same piece of a solid."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.families import CORNERS, SOLID
from thermal.description import Condition, Field, Fixed, Solid

Indices = NDArray[np.intp]

OUTER = "outer"


class Piece(NamedTuple):
    """What a condition prescribes of a solid.

    rows : family -> corners (k, c) of facets or cells; None: all of the solid
    """

    name: str
    rows: Mapping[str, Indices] | None


def solid_given_twice(solid: Solid, conditions: Sequence[Condition]) -> list[str]:
    """One sentence for each two conditions that share more than edges.

    Facets of two conditions may meet: nodes on their common edge belong to the first.
    """
    pieces = [p for c in conditions if (p := _piece(solid, c)) is not None]
    return [
        f"'{a.name}' and '{b.name}' both prescribe temperatures of '{solid.name}'"
        for a, b in combinations(pieces, 2)
        if _share(solid, a, b)
    ]


def _piece(solid: Solid, c: Condition) -> Piece | None:
    if isinstance(c, Field) and c.body == solid.name:
        return Piece(c.name, None)
    if not (isinstance(c, Fixed) and c.place.name == solid.name):
        return None
    region = c.place.end
    if region is None:
        return Piece(c.name, None)
    if region == OUTER and region not in solid.mesh.regions:
        return Piece(c.name, _boundary(solid))
    found, cells = solid.mesh.cells_of(region), solid.mesh.cells
    kinds = [f for f in found if f in CORNERS]
    return Piece(c.name, {f: cells[f][found[f]][:, : CORNERS[f]] for f in kinds})


def _boundary(solid: Solid) -> dict[str, Indices]:
    """Facets of the boundary, which are facets of one cell only."""
    from thermal.solid_skin import skin

    volumes = {f: c for f, c in solid.mesh.cells.items() if f in SOLID and len(c)}
    try:
        facets = skin(volumes, len(solid.mesh.points)).facets
    except ValueError:  # of a faulty mesh, which is said by who discretises it
        return {}
    return {f: rows[:, : CORNERS[f]] for f, rows in facets.items()}


def _share(solid: Solid, a: Piece, b: Piece) -> bool:
    """Whether a facet or a cell belongs to both, or a facet of one to the cells of the other."""
    if a.rows is None or b.rows is None:
        return True
    if _flat(a) == _flat(b):
        return any(_common(rows, b.rows.get(f)) for f, rows in a.rows.items())
    facets, cells = (a.rows, b.rows) if _flat(a) else (b.rows, a.rows)
    inside = np.zeros(len(solid.mesh.points), dtype=bool)
    for rows in cells.values():
        inside[rows] = True
    return any(bool(inside[rows].all(axis=1).any()) for rows in facets.values())


def _flat(piece: Piece) -> bool:
    return not any(family in SOLID for family in piece.rows or ())


def _common(a: Indices, b: Indices | None) -> bool:
    if b is None or not len(a) or not len(b):
        return False
    both = np.vstack([np.unique(np.sort(rows, axis=1), axis=0) for rows in (a, b)])
    return len(np.unique(both, axis=0)) < len(both)
