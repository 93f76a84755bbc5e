"""What sun and planet bring to the faces of a structure that moves and deforms."""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.carriers import (
    Carried,
    Curve,
    Frames,
    LineFrames,
    Lines,
    carrier,
    still,
    together,
    vectors,
)
from mechanics.description import Beam, Shell
from mechanics.layout import Layout
from meshes.sections import Section
from thermal.description import Description, Member
from thermal.discretisation import Block, Face
from thermal.illumination import (
    Coating,
    Environment,
    Sky,
    coating_problems,
    infrared,
    sky,
    sunlight,
)
from thermal.shadows import NO_TUBES, Facets, Patches, Tubes, visible

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

PIECES = 2  # straight pieces, of what an element of a line body shades


class Light(NamedTuple):
    """Where the points of the faces are, and what they see.

    points, normals : (m, 3) float [m], [-]  of all coatings, one after the other
    seen : (m,) float [-]  fraction of the sun's disc beside all other things, 0 on the far side
    sky : Sky
    """

    points: Array
    normals: Array
    seen: Array
    sky: Sky


class Exposure:
    """Absorbed sunlight, reflected sunlight and infrared of the planet.

    What the planet sends is not shaded by the structure. Line bodies shade as round tubes of their
    outer perimeter, shells by their middle surfaces, other things by the polygons of ``shading``.
    Bodies that do not move, or of which mechanics knows nothing, stand as in the reference.

    Parameters
    ----------
    environment : Environment
    coatings : of the irradiations that this feeds
    irradiated : condition -> Face, as a thermal solver has it
    description : Description  whose members and sheets stand in the light
    layout : Layout | None  of the mechanical system; None: nothing moves
    shading : body -> Face  whose polygons shade, such as "outer" of solids

    Attributes
    ----------
    rows : condition -> slice  its points among those of ``look``
    """

    def __init__(
        self,
        environment: Environment,
        coatings: Sequence[Coating],
        irradiated: Mapping[str, Face],
        description: Description,
        layout: Layout | None = None,
        shading: Mapping[str, Face] | None = None,
    ) -> None:
        _check(coatings, irradiated, description)
        self.environment, self.coatings, self._layout = environment, tuple(coatings), layout
        self._shade = Shade(description, layout, shading or {})
        counts = [sum(b.areas.size for b in irradiated[c.condition]) for c in coatings]
        ends = np.cumsum([0, *counts])
        self.rows = {
            c.condition: slice(int(a), int(b))
            for c, a, b in zip(coatings, ends, ends[1:], strict=False)
        }
        self._groups, self._along = _groups(layout, coatings, irradiated)
        numbers = [self._shade.number(c.body) for c in coatings]
        self._owner = np.repeat(np.array(numbers, np.intp), counts)

    def at(self, t: float, pose: Any = None) -> dict[str, Array]:
        """Absorbed power density (m,) [W/m^2] of each condition, at the points of its face.

        pose : mechanical motion or state; None: the reference
        """
        light = self.look(t, pose)
        solar = sunlight(light.sky, light.normals, light.seen)
        thermal_part = infrared(light.sky, light.normals)
        return {
            c.condition: c.absorptivity * solar[rows] + c.emissivity * thermal_part[rows]
            for c, rows in zip(self.coatings, self.rows.values(), strict=True)
        }

    def look(self, t: float, pose: Any = None) -> Light:
        """Where the points are, and which part of the sun they see."""
        q, now = self._coordinates(pose), sky(self.environment, t)
        points, normals = np.empty((2, len(self._owner), 3))
        for rows, carried in self._groups:
            points[rows], normals[rows] = carried.at(q)
        if now.flux == 0.0:
            return Light(points, normals, np.zeros(len(points)), now)
        patches = Patches(points, normals, self._along, self._owner)
        seen = visible(patches, *self._shade.at(q), now.sun, now.radius)
        return Light(points, normals, seen, now)

    def _coordinates(self, pose: Any) -> Array:
        if self._layout is None:
            return np.empty(0)
        if pose is None:
            return self._layout.q0
        return getattr(pose, "motion", pose).q


def _check(
    coatings: Sequence[Coating], irradiated: Mapping[str, Face], description: Description
) -> None:
    members = {m.name for m in description.members}
    wrong = coating_problems(coatings)
    for c in coatings:
        if c.condition not in irradiated:
            wrong.append(f"coating '{c.condition}': there is no such irradiation")
        if c.body in members and c.face == "inner":
            wrong.append(f"coating '{c.condition}': no light falls into '{c.body}'")
    if wrong:
        raise ValueError("\n".join(wrong))


def _groups(
    layout: Layout | None, coatings: Sequence[Coating], irradiated: Mapping[str, Face]
) -> tuple[list[tuple[Indices, Carried]], Array]:
    """Rows of points with what carries them, all that line bodies carry together; arc lengths."""
    faces = [irradiated[c.condition] for c in coatings]
    points = [_flat(face, lambda b: b.points) for face in faces]
    normals = [_flat(face, lambda b: b.normals) for face in faces]
    frames = [carried_by(layout, c.body, p) for c, p in zip(coatings, points, strict=True)]
    ends = np.cumsum([0, *map(len, points)]).tolist()
    rows = [np.arange(a, b) for a, b in pairwise(ends)]
    lines = {i: f for i, f in enumerate(frames) if isinstance(f, LineFrames)}
    q = np.empty(0) if layout is None else layout.q0
    along, groups = np.zeros(ends[-1]), []
    for i, f in enumerate(frames):
        if i not in lines:
            groups.append((rows[i], Carried(f, q, points[i], normals[i])))
    if lines:
        at, x, n = (np.concatenate([a[i] for i in lines]) for a in (rows, points, normals))
        joined = together(list(lines.values()))
        along[at] = joined.along
        groups.append((at, Carried(joined, q, x, n)))
    return groups, along


def carried_by(layout: Layout | None, body: str, points: Array) -> Frames:
    """What carries points of a thermal body; sides of joints go with the nearest body."""
    if layout is None or not (body in layout.bodies or body in layout.point_index):
        return still(len(points))
    if body in layout.bodies:
        return carrier(layout, body, points)
    flexible = [name for name, b in layout.bodies.items() if isinstance(b, Beam | Shell)]
    nodes = {name: vectors(layout, name, layout.q0)["position"] for name in flexible}
    away = {n: np.linalg.norm(x - points[0], axis=1).min() for n, x in nodes.items()}
    return carrier(layout, min(away, key=away.__getitem__), points) if away else still(len(points))


def _flat(face: Face, read: Callable[[Block], Array]) -> Array:
    return np.concatenate([np.empty((0, 3)), *(read(block).reshape(-1, 3) for block in face)])


# --------------------------------------------------------------------------- what casts shadows


class _Pieces(NamedTuple):
    """Straight pieces of line bodies: from ``x[:, 0]`` to ``x[:, 1]`` of elements of a curve."""

    element: Indices
    x: Array
    radius: Array
    along: Array
    free: NDArray[np.bool_]
    owner: Indices

    def tubes(self, curve: Curve) -> Tubes:
        """The pieces where the curve is now."""
        start, end = (curve.points(self.element, x) for x in self.x.T)
        return Tubes(start, end, self.radius, self.along, self.free, self.owner)


def _pieces(curve: Curve, section: Section, first: int, owner: int) -> _Pieces:
    """Pieces of one body, whose curve may begin with the element ``first`` of a longer one."""
    element, x = np.divmod(np.arange(PIECES * len(curve.scale)), PIECES)
    x = (x[:, None] + np.array([0.0, 1.0])) / PIECES
    along = np.stack([curve.lengths(element, end) for end in x.T], axis=1)
    free = np.zeros(along.shape, np.bool_)
    free[0, 0] = free[-1, 1] = True
    k = len(element)
    return _Pieces(element + first, x, np.full(k, _radius(section)), along, free, np.full(k, owner))


class _Skin(NamedTuple):
    """Triangles of a body: ``corners`` (k, 3) of its points, carried or, of shells, its nodes."""

    name: str | None
    corners: Indices
    carried: Carried | None
    fixed: Array


class Shade:
    """Everything that casts shadows, in a pose."""

    def __init__(
        self, description: Description, layout: Layout | None, shading: Mapping[str, Face]
    ) -> None:
        self._layout = layout
        bodies = {} if layout is None else layout.bodies
        beams = {name: b.section for name, b in bodies.items() if isinstance(b, Beam)}
        members = {m.name: m for m in description.members if m.name not in beams}
        rods = [*beams, *members]
        self._skins = _skins(description, layout)
        others = {n: f for n, f in shading.items() if n not in {*rods, *self._skins}}
        self._skins |= {name: _polygons(layout, name, face) for name, face in others.items()}
        self._numbers = {name: i for i, name in enumerate([*rods, *self._skins])}
        self._lines = None if layout is None or not beams else Lines(layout, list(beams))
        self._moving = self._moving_pieces(beams)
        still = [_still_tubes(m, self._numbers[m.name]) for m in members.values()]
        self._still = Tubes(*(np.concatenate(c) for c in zip(NO_TUBES, *still, strict=True)))

    def _moving_pieces(self, beams: Mapping[str, Section]) -> _Pieces | None:
        layout, lines = self._layout, self._lines
        if layout is None or lines is None:
            return None
        each = [
            _pieces(Lines(layout, [name])(layout.q0), section, first, self._numbers[name])
            for (name, section), first in zip(beams.items(), lines.first.tolist(), strict=True)
        ]
        return _Pieces(*(np.concatenate(c) for c in zip(*each, strict=True)))

    def number(self, body: str) -> int:
        """Of a body among those that cast shadows; -1: it casts none."""
        return self._numbers.get(body, -1)

    def at(self, q: Array) -> tuple[Tubes, Facets]:
        """Tubes and facets in a pose."""
        return self._tubes(q), self._facets(q)

    def _tubes(self, q: Array) -> Tubes:
        if self._moving is None or self._lines is None:
            return self._still
        moving = self._moving.tubes(self._lines(q))
        return Tubes(*(np.concatenate(c) for c in zip(moving, self._still, strict=True)))

    def _facets(self, q: Array) -> Facets:
        corners, owners = [np.empty((0, 3, 3))], [np.empty(0, np.intp)]
        for name, skin in self._skins.items():
            corners.append(self._points(skin, q)[skin.corners])
            owners.append(np.full(len(skin.corners), self._numbers[name]))
        return Facets(np.concatenate(corners), np.concatenate(owners))

    def _points(self, skin: _Skin, q: Array) -> Array:
        if skin.carried is not None:
            return skin.carried.at(q)[0]
        if skin.name is not None and self._layout is not None:
            return vectors(self._layout, skin.name, q)["position"]
        return skin.fixed


def _still_tubes(m: Member, owner: int) -> Tubes:
    curve = Curve.through(np.asarray(m.points, float), np.asarray(m.axes, float))
    return _pieces(curve, m.section, 0, owner).tubes(curve)


def _radius(section: Section) -> float:
    """Of the circle of the same perimeter, which convex sections shade like in the mean."""
    return section.outer_perimeter / (2.0 * np.pi)


def _skins(description: Description, layout: Layout | None) -> dict[str, _Skin]:
    bodies = {} if layout is None else layout.bodies
    shells = {name: b.surface for name, b in bodies.items() if isinstance(b, Shell)}
    found = {name: _Skin(name, _triangles(s.quads), None, s.points) for name, s in shells.items()}
    for sheet in description.sheets:
        if sheet.name not in found:
            s = sheet.surface
            found[sheet.name] = _Skin(None, _triangles(s.quads), None, s.points)
    return found


def _polygons(layout: Layout | None, name: str, face: Face) -> _Skin:
    points = _flat(face, lambda block: block.polygons)
    frames = carried_by(layout, name, points)
    carried = Carried(frames, np.empty(0) if layout is None else layout.q0, points, 0.0 * points)
    corners, first = [np.empty((0, 3), np.intp)], 0
    for block in face:
        g, c = block.polygons.shape[:2]
        corners.append(_triangles(first + np.arange(g * c).reshape(g, c)))
        first += g * c
    return _Skin(name, np.concatenate(corners), carried, points)


def _triangles(polygons: Indices) -> Indices:
    """(k, 3)  of polygons (g, c): fans from their first corners."""
    n = polygons.shape[1]
    fans = [polygons[:, [0, i, i + 1]] for i in range(1, n - 1)]
    return np.concatenate([np.empty((0, 3), np.intp), *fans])
