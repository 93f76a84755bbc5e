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
from coupling.skin_shapes import small_facets
from thermal.description import Side
from thermal.discretisation import Block, Face, at_points

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CORNERS = 4


class Skin(NamedTuple):
    """One face.

    light : name of its irradiation; None: it has none
    corners : Carried  (4 f,) points
    order : (p,) of the points of a facet, as ``skin_shapes.small_facets`` cuts it; None: it has
        one point, or not the same number everywhere
    """

    name: str
    face: Face
    light: str | None
    corners: Carried
    order: Indices | None

    def row(self, T: Array, outside: Mapping[str, Array], q: Array) -> dict[str, Array]:
        """Corners (f, 4, 3) [m], temperature (f,) [K], absorbed light (f,), (f, p) [W/m^2]."""
        row = {
            "corners": self.corners.at(q)[0].reshape(-1, CORNERS, 3),
            "temperature": _over_facets(self.face, [at_points(b, T) for b in self.face]),
        }
        if self.light is not None:
            sizes = np.cumsum([block.areas.size for block in self.face])[:-1]
            pieces = np.split(outside[self.light], sizes)
            shaped = [v.reshape(b.areas.shape) for v, b in zip(pieces, self.face, strict=True)]
            row["light"] = _over_facets(self.face, shaped)
            if self.order is not None:
                row["parts"] = np.concatenate(shaped)[:, self.order]
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
            carried = _carried(side, face, layout)
            found.append(Skin(f"{name}.{side.face}", face, light, carried, _order(face)))
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
    if _triangular(block):
        corners = np.concatenate([corners, corners[:, -1:]], axis=1)
    return corners[:, :CORNERS]


def _order(face: Face) -> Indices | None:
    """Which point lies in each part of a facet, if facets are alike and have several points."""
    parts = face[0].areas.shape[1]
    regular = parts > 1 and round(parts**0.5) ** 2 == parts
    if not regular or any(b.areas.shape[1] != parts or _triangular(b) for b in face):
        return None
    orders = [_nearest_points(block, parts) for block in face]
    whole = len(set(orders[0].tolist())) == parts
    return orders[0] if whole and all((order == orders[0]).all() for order in orders) else None


def _triangular(block: Block) -> bool:
    return block.polygons.shape[1] < CORNERS


def _nearest_points(block: Block, parts: int) -> Indices:
    """Of the first facet: its point nearest to the middle of each part."""
    middles = small_facets(_quads(block)[:1], parts)[0].mean(axis=1)
    away = np.linalg.norm(middles[:, None] - block.points[0], axis=2)
    return np.argmin(away, axis=1)


def _over_facets(face: Face, values: Sequence[Array]) -> Array:
    """(f,)  means by area of values (g, p) at the points of blocks.

    Also right where the values of a block are shares (walls of order 2): the mean over a facet by
    shares is Simpson's.
    """
    pairs = zip(face, values, strict=True)
    return np.concatenate([(b.areas * v).sum(1) / b.areas.sum(1) for b, v in pairs])
