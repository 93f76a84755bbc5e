"""Bodies of CalculiX: the cells of ``thermal.solid``, with directions of their conductivities."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from meshes.families import CORNERS
from thermal.calculix_deck import Elements
from thermal.calculix_model import KINDS, substance
from thermal.description import Description, Member, Settings, Sheet
from thermal.discretisation import Discretisation
from thermal.layout import arclength

if TYPE_CHECKING:
    from thermal.solid_bodies import Body, Filling

Array = NDArray[np.float64]


def solid_space(settings: Settings) -> Callable[[Description], Discretisation]:
    """Makes the temperatures of bodies meshed in 3D, numbered as by ``thermal.solid``."""

    def make(d: Description) -> Discretisation:
        from thermal.solid import SolidSpace

        return SolidSpace(d, settings)

    return make


def elements(d: Description, space: Discretisation, settings: Settings) -> list[Elements]:
    """Elements of all bodies, whose temperatures are the first of ``space``."""
    found: list[Elements] = []
    first = 0
    for body in _bodies(d, settings):
        if not np.array_equal(space.x[first : first + len(body.points)], body.points):
            raise ValueError(f"'{body.name}': its temperatures are not the nodes of its mesh")
        for filling in body.fillings:
            what = substance(filling.material)
            axes = _axes(body, filling) if len(what.conductivities) > 1 else None
            found.append(Elements(KINDS[filling.family], filling.cells + first, what, axes))
        first += len(body.points)
    return found


def _bodies(d: Description, settings: Settings) -> "list[Body]":
    if not (d.members or d.sheets or d.solids):
        return []  # lumps need no scikit-fem
    from thermal.solid_bodies import member_body, sheet_body, solid_body

    bodies = [member_body(m, settings) for m in d.members]
    bodies += [sheet_body(s, settings) for s in d.sheets]
    return bodies + [solid_body(s) for s in d.solids]


def _axes(body: "Body", filling: "Filling") -> Array:
    """(m, 3, 3)  rows along, around, through of each cell, taken at its middle."""
    corners = filling.cells[:, : CORNERS[filling.family]]
    if not isinstance(filling.directions, str):
        return np.tile(np.asarray(filling.directions, dtype=float), (len(corners), 1, 1))
    if isinstance(body.thing, Member):
        return _of_member(body.thing, body.local[corners].mean(axis=1))
    assert isinstance(body.thing, Sheet)  # solids have axes of their own
    return _of_sheet(body.thing, body.points[corners].mean(axis=1))


def _of_member(m: Member, local: Array) -> Array:
    """At arclength and section coordinates (m, 3), with the frame half way between stations."""
    s = arclength(m.points)
    n = np.clip(np.searchsorted(s, local[:, 0], side="right") - 1, 0, len(s) - 2)
    axes = np.asarray(m.axes, dtype=float)
    frame = axes[n] + axes[n + 1]
    frame /= np.linalg.norm(frame, axis=2, keepdims=True)
    angle = np.arctan2(local[:, 2], local[:, 1])[:, None]
    e1, e2, e3 = (frame[:, i] for i in range(3))
    around = np.cos(angle) * e3 - np.sin(angle) * e2
    return np.stack([e1, around, np.cos(angle) * e2 + np.sin(angle) * e3], axis=1)


def _of_sheet(sheet: Sheet, middles: Array) -> Array:
    """Of the quad of the surface whose middle is nearest."""
    from scipy.spatial import KDTree

    surface = sheet.surface
    centres = surface.points[surface.quads].mean(axis=1)
    _, quad = KDTree(centres).query(middles)
    along = surface.d_u[surface.quads].mean(axis=1)[quad]
    normal = np.cross(along, surface.d_v[surface.quads].mean(axis=1)[quad])
    axes = np.stack([along, np.cross(normal, along), normal], axis=1)
    return axes / np.linalg.norm(axes, axis=2, keepdims=True)
