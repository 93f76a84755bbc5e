"""The boundary of volume cells, and named regions of facets found on it."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.families import CORNERS, FACES, FACET

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Cells = Mapping[str, Indices]


class Skin(NamedTuple):
    """All facets of the boundary of cells.

    facets : facet family -> (j, k) intp  nodes, turning outward
    numbering : of facets by their corners
    keys : facet family -> (j,) int  rising
    """

    facets: dict[str, Indices]
    numbering: "Numbering"
    keys: dict[str, Indices]

    def found(self, facets: Cells) -> tuple[dict[str, Indices], int]:
        """Those of the boundary with the corners of ``facets``, and how many are not on it."""
        own: dict[str, list[Indices]] = {}
        missing = 0
        for family, nodes in facets.items():
            keys = self.numbering.keys(nodes[:, : CORNERS[family]])
            missing += len(keys)
            for mine, known in self.keys.items():
                at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
                rows = at[known[at] == keys] if _same_kind(mine, family) else at[:0]
                missing -= len(rows)
                own.setdefault(mine, []).append(self.facets[mine][rows])
        joined = {family: np.concatenate(parts) for family, parts in own.items()}
        return {family: nodes for family, nodes in joined.items() if len(nodes)}, missing


class Numbering(NamedTuple):
    """Numbers of facets: cells that meet without gaps share no facet with equal three lowest nodes.

    pairs : (u,) int  lowest two corners of known facets, as one number, rising
    n : nodes in all
    """

    pairs: Indices
    n: int

    def keys(self, corners: Indices) -> Indices:
        """(j,) int of facets with the ``corners`` (j, 3 or 4); -1: there is none."""
        low = np.sort(corners, axis=1)[:, :3]
        pair = low[:, 0] * self.n + low[:, 1]
        at = np.minimum(np.searchsorted(self.pairs, pair), len(self.pairs) - 1)
        return np.where(self.pairs[at] == pair, at * self.n + low[:, 2], -1)


def skin(cells: Cells, n: int) -> Skin:
    """The boundary of volume cells on n nodes: facets of one cell alone."""
    every = {f: c[:, FACES[f]].reshape(-1, FACES[f].shape[1]) for f, c in cells.items()}
    corners = {f: nodes[:, : CORNERS[FACET[f]]] for f, nodes in every.items()}
    low = [np.sort(c, axis=1)[:, :2] for c in corners.values()]
    numbering = Numbering(np.unique(np.concatenate([a[:, 0] * n + a[:, 1] for a in low])), n)
    facets, alone = {}, {}
    for family, corner in corners.items():
        key = numbering.keys(corner)
        same = [numbering.keys(c) for c in corners.values() if c.shape[1] == corner.shape[1]]
        values, uses = np.unique(np.concatenate(same), return_counts=True)
        if (uses > 2).any():
            raise ValueError("three or more of its cells share one face: they overlap")
        rows = np.flatnonzero(uses[np.searchsorted(values, key)] == 1)
        rows = rows[np.argsort(key[rows])]
        facets[FACET[family]], alone[FACET[family]] = every[family][rows], key[rows]
    _require_conforming(facets, numbering)
    return Skin(
        {f: nodes for f, nodes in facets.items() if len(nodes)},
        numbering,
        {f: k for f, k in alone.items() if len(k)},
    )


def _require_conforming(facets: Cells, numbering: Numbering) -> None:
    """No triangle of the boundary may have its corners in a quad of the boundary."""
    triangles = [c[:, :3] for f, c in facets.items() if CORNERS[f] == 3]
    quads = [c[:, :4] for f, c in facets.items() if CORNERS[f] == 4]
    if not (triangles and quads):
        return
    known = numbering.keys(np.concatenate(triangles))
    every = np.concatenate(quads)
    for left_out in range(4):
        corners = np.delete(every, left_out, axis=1)
        lying = np.isin(numbering.keys(corners), known)
        if lying.any():
            raise ValueError(
                f"triangles lie on quads, as of nodes {every[lying][0].tolist()}: tetrahedra and "
                "hexahedra do not conform"
            )


def _same_kind(a: str, b: str) -> bool:
    return CORNERS[a] == CORNERS[b]
