"""Families of cells as meshio numbers their nodes: faces, corners and nodes between corners.

Hexahedra: 0 to 3 turn about the direction from their face to that of 4 to 7, which lie over them;
then the middles of the edges 01 12 23 30, 45 56 67 74, 04 15 26 37; then of the faces 0473, 1265,
0154, 2376, 0321, 4567; then the centre. Tetrahedra: 0 to 2 turn about the direction to 3; then the
middles of the edges 01 12 02 03 13 23. Quads and triangles: corners, middles of the edges in their
order, centre.
"""

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]

CORNERS = {
    "tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8,
    "triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4,
}  # fmt: skip
SOLID = ("tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27")
FACET = {
    "tetra": "triangle", "tetra10": "triangle6",
    "hexahedron": "quad", "hexahedron20": "quad8", "hexahedron27": "quad9",
}  # fmt: skip

_TETRA = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])
_HEXAHEDRON = np.array(
    [
        [0, 4, 7, 3, 16, 15, 19, 11, 20],
        [1, 2, 6, 5, 9, 18, 13, 17, 21],
        [0, 1, 5, 4, 8, 17, 12, 16, 22],
        [2, 3, 7, 6, 10, 19, 14, 18, 23],
        [0, 3, 2, 1, 11, 10, 9, 8, 24],
        [4, 5, 6, 7, 12, 13, 14, 15, 25],
    ]
)
FACES: dict[str, Indices] = {
    "tetra": _TETRA[:, :3],
    "tetra10": _TETRA,
    "hexahedron": _HEXAHEDRON[:, :4],
    "hexahedron20": _HEXAHEDRON[:, :8],
    "hexahedron27": _HEXAHEDRON,
}
"""(faces, k) nodes of each face of a cell, in the order of the facet's family, turning outward."""

EDGES = {
    "tetra": [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [
        (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6),
        (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7),
    ],
}  # fmt: skip


def middles() -> Indices:
    """(8, 8)  node of a hexahedron27 midway between two of its corners; -1 for a corner itself."""
    found = np.full((8, 8), -1)
    pairs = dict(zip(EDGES["hexahedron"], range(8, 20), strict=True))
    for row in _HEXAHEDRON:
        pairs |= {(row[0], row[2]): row[8], (row[1], row[3]): row[8]}
    pairs |= {(0, 6): 26, (1, 7): 26, (2, 4): 26, (3, 5): 26}
    for (a, b), middle in pairs.items():
        found[a, b] = found[b, a] = middle
    return found
