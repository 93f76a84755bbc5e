"""Families of bodies by name; each is imported, and compiled, only when a scene uses it."""

from typing import NamedTuple


class Family(NamedTuple):
    """How the nodes of a family look, and who builds its elements.

    build : "module:function"
    vectors : names of the vectors that a node carries, position first
    section : which of them are carried by the section and say how it stands (two, one or none)
    stride : nodes from one element of a line body to the next
    """

    build: str
    vectors: tuple[str, ...]
    section: tuple[int, ...]
    stride: int = 1


_BEAM = ("position", "r_x", "r_y", "r_z")

FAMILIES = {
    "beam3243": Family("mechanics.beam3243:build", _BEAM, (2, 3)),
    "beam3243-continuum": Family("mechanics.continuum_beam:build_naive", _BEAM, (2, 3)),
    "beam3243-enhanced": Family("mechanics.continuum_beam:build_enhanced", _BEAM, (2, 3)),
    "beam3333": Family("mechanics.beam3333:build", ("position", "r_y", "r_z"), (1, 2), 2),
    "cable": Family("mechanics.cable:build", ("position", "r_x"), (1,)),
    "shell48": Family("mechanics.shell48:build", ("position", "r_u", "r_v", "r_uv"), (1, 2)),
    "shell24": Family("mechanics.shell24:build", ("position", "r_n"), (1,)),
    "shell3443": Family("mechanics.shell3443:build", ("position", "r_u", "r_v", "r_n"), (1, 2)),
    "shell3443-continuum": Family(
        "mechanics.shell3443:build_naive", ("position", "r_u", "r_v", "r_n"), (1, 2)
    ),
    "hexahedron20": Family("mechanics.continuum:build", ("position",), ()),
    "hexahedron20-full": Family("mechanics.continuum:build", ("position",), ()),
    "hexahedron27": Family("mechanics.continuum:build", ("position",), ()),
    "reference": Family("", ("position", "r_y", "r_z"), (1, 2)),
    "rigid": Family("mechanics.rigid:build", ("position", "e1", "e2", "e3"), (2, 3)),
    "particle": Family("", ("position",), ()),
}
