"""What sun and planet bring to the faces of a structure that moves and deforms."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.carriers import Carried, Curve, Frames, LineFrames, carrier, still, vectors
from mechanics.description import Beam, Shell
from mechanics.layout import Layout
from meshes.sections import Section
from thermal.description import Description
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
        self._faces: list[Carried] = []
        along = [np.empty(0)]
        for c in coatings:
            face = irradiated[c.condition]
            points, normals = _flat(face, lambda b: b.points), _flat(face, lambda b: b.normals)
            frames = carried_by(layout, c.body, points)
            self._faces.append(Carried(frames, self._coordinates(None), points, normals))
            along.append(frames.along if isinstance(frames, LineFrames) else np.zeros(len(points)))
        self._along = np.concatenate(along)
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
        both = [face.at(q) for face in self._faces]
        none = [np.empty((0, 3))]
        points = np.concatenate(none + [p for p, _ in both])
        normals = np.concatenate(none + [n for _, n in both])
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


class _Rod(NamedTuple):
    """A line body; ``name`` None: it stands still along ``curve``."""

    name: str | None
    curve: Curve
    radius: float


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
        self._rods = _rods(description, layout)
        self._skins = _skins(description, layout)
        others = {n: f for n, f in shading.items() if n not in {**self._rods, **self._skins}}
        self._skins |= {name: _polygons(layout, name, face) for name, face in others.items()}
        self._numbers = {name: i for i, name in enumerate([*self._rods, *self._skins])}

    def number(self, body: str) -> int:
        """Of a body among those that cast shadows; -1: it casts none."""
        return self._numbers.get(body, -1)

    def at(self, q: Array) -> tuple[Tubes, Facets]:
        """Tubes and facets in a pose."""
        return self._tubes(q), self._facets(q)

    def _tubes(self, q: Array) -> Tubes:
        pieces = [self._tube(name, rod, q) for name, rod in self._rods.items()]
        return Tubes(*(np.concatenate(c) for c in zip(NO_TUBES, *pieces, strict=True)))

    def _tube(self, name: str, rod: _Rod, q: Array) -> Tubes:
        curve = rod.curve
        if rod.name is not None and self._layout is not None:
            curve = Curve.of(self._layout, rod.name, q)
        k = PIECES * len(curve.scale)
        element, x = _stations(len(curve.scale))
        points, along = curve.at(element, x)[0], rod.curve.lengths(element, x)
        free = np.zeros((k, 2), np.bool_)
        free[0, 0] = free[-1, 1] = True
        return Tubes(
            points[:-1], points[1:], np.full(k, rod.radius),
            np.stack([along[:-1], along[1:]], axis=1), free, np.full(k, self._numbers[name]),
        )  # fmt: skip

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


def _stations(elements: int) -> tuple[Indices, Array]:
    """Element and local coordinate of the ends of the pieces of a line body."""
    s = np.arange(elements * PIECES + 1)
    element = np.minimum(s // PIECES, elements - 1)
    return element, (s - element * PIECES) / PIECES


def _rods(description: Description, layout: Layout | None) -> dict[str, _Rod]:
    found = {}
    for name, body in ({} if layout is None else layout.bodies).items():
        if isinstance(body, Beam):
            assert layout is not None
            found[name] = _Rod(name, Curve.of(layout, name, layout.q0), _radius(body.section))
    for m in description.members:
        if m.name not in found:
            points, axes = np.asarray(m.points, float), np.asarray(m.axes, float)
            found[m.name] = _Rod(None, Curve.through(points, axes), _radius(m.section))
    return found


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
