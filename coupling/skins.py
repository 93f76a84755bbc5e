"""Skins: facets of heated faces in the present pose, with temperature and absorbed light.

What the transfer to the mechanics leaves out (all but the mean and the gradients of a section) is
seen here: shadows, steep fields round a tube, solids.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.carriers import Carried
from coupling.descriptions import line_bodies, shells
from coupling.exposure import carried_by
from coupling.heat_descriptions import LIGHT, region_of, side_of
from coupling.scene import Scene
from thermal.description import Side
from thermal.discretisation import Block, Face, at_points

Array = NDArray[np.float64]

CORNERS = 4


class Skin(NamedTuple):
    """One face.

    light : name of its irradiation; None: it has none
    corners : Carried  (4 f,) points
    """

    name: str
    face: Face
    light: str | None
    corners: Carried

    def row(self, T: Array, outside: Mapping[str, Array], q: Array) -> dict[str, Array]:
        """Corners (f, 4, 3) [m], temperature (f,) [K], absorbed light (f,) [W/m^2]."""
        row = {
            "corners": self.corners.at(q)[0].reshape(-1, CORNERS, 3),
            "temperature": _over_facets(self.face, [at_points(b, T) for b in self.face]),
        }
        if self.light is not None:
            sizes = np.cumsum([block.areas.size for block in self.face])[:-1]
            pieces = np.split(outside[self.light], sizes)
            shaped = [v.reshape(b.areas.shape) for v, b in zip(pieces, self.face, strict=True)]
            row["light"] = _over_facets(self.face, shaped)
        return row


def skins(scene: Scene, heat_solver: Any, layout: Any) -> list[Skin]:
    """The faces of what [output] skins names. ValueError where a solver has no faces."""
    if not scene.output.skins:
        return []
    if not hasattr(heat_solver, "space"):
        raise ValueError("output.skins: this thermal solver computes nothing that has a skin")
    lit = _lit(scene)
    found = []
    for name in scene.output.skins:
        for side in _sides(scene, name):
            light = lit.get(side)
            space = heat_solver.space
            face = space.face(side) if light is None else heat_solver.irradiated[light]
            found.append(Skin(f"{name}.{side.face}", face, light, _carried(side, face, layout)))
    return found


def _sides(scene: Scene, name: str) -> list[Side]:
    if name in shells(scene):
        return [Side(name, "top"), Side(name, "bottom")]
    if name in line_bodies(scene):
        return [Side(name, "outer")]
    assert scene.thermal is not None
    return [Side(region_of(name, scene.thermal.solid[name]), "outer")]


def _lit(scene: Scene) -> dict[Side, str]:
    assert scene.thermal is not None
    tables = scene.thermal.surface.items()
    return {side_of(scene, surface): f"{LIGHT}.{name}" for name, surface in tables}


def _carried(side: Side, face: Face, layout: Any) -> Carried:
    corners = np.concatenate([_quads(block).reshape(-1, 3) for block in face])
    frames = carried_by(layout, side.thing, corners)
    return Carried(frames, layout.q0, corners, np.zeros_like(corners))


def _quads(block: Block) -> Array:
    """(f, 4, 3) [m]  corners; a triangle has its last one twice."""
    corners = block.polygons
    if corners.shape[1] == CORNERS - 1:
        corners = np.concatenate([corners, corners[:, -1:]], axis=1)
    return corners[:, :CORNERS]


def _over_facets(face: Face, values: Sequence[Array]) -> Array:
    """(f,)  means by area of values (g, p) at the points of blocks."""
    pairs = zip(face, values, strict=True)
    return np.concatenate([(b.areas * v).sum(1) / b.areas.sum(1) for b, v in pairs])
