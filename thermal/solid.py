"""Heat in 3D: ``SolidSpace``.

Solids with meshes of their own, members with tubes, circles and rectangles as sections, and sheets,
by finite elements of order 1 (hexahedra, tetrahedra) or 2 (hexahedra of 20 or 27 nodes, tetrahedra
of 10). Shape functions and quadrature are scikit-fem's; compiled code sums them up over the cells.

Of order 1 heat is stored at the nodes, unless the settings ask for the consistent capacity. Boxes,
and the cells of tubes, rectangles and sheets, then conduct along their edges alone, by quadrature
at their corners; all other cells by that of Gauss. Steps of backward Euler of any length keep
temperatures between the coldest and the hottest of start and boundary where cells are boxes, of
whatever ratio of sides, or tetrahedra without obtuse dihedral angles; nearly so in tubes and
sheets. Other hexahedra can overshoot where they are long, and with the consistent capacity all
cells do in steps below about (their size)^2 / (6 diffusivity) (Thomée 2006, ch. 15). Of order 2
heat is stored by integrals, and shocks on coarse meshes overshoot.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material
from thermal.description import (
    DEFAULT,
    Condition,
    Description,
    Faces,
    Field,
    Fixed,
    Member,
    Place,
    Settings,
    Sheet,
    Side,
    Solid,
    Wall,
)
from thermal.discretisation import Face, GivenTemperatures, Mean, facing_loads
from thermal.layout import Given, GivenField
from thermal.solid_bodies import Body, Filling, member_body, sheet_body, solid_body
from thermal.solid_faces import blocks, face_mean, facets, volume_mean
from thermal.solid_given import given_by_faces, given_by_wall
from thermal.solid_skin import Cells
from thermal.solid_terms import LUMPABLE, Conduction, conduction, pattern, storage, watched

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CAPACITIES = ("auto", "lumped", "consistent")


class SolidSpace:
    """Members, sheets and solids in 3D; see ``thermal.discretisation``.

    Where facets of two conditions that prescribe temperatures share nodes, the first has them.
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        bodies = _bodies(description, settings)
        firsts = np.cumsum([0] + [len(b.points) for b in bodies])
        self._bodies = {b.name: b for b in bodies}
        self._nodes = {
            b.name: np.arange(i, j) for b, i, j in zip(bodies, firsts, firsts[1:], strict=False)
        }
        self.x = np.vstack([np.zeros((0, 3)), *(b.points for b in bodies)])
        counts = [len(b.points) for b in bodies]
        self.start = np.repeat([float(b.thing.initial) for b in bodies], counts)
        fillings = self._fillings()
        self._entries = pattern(fillings, len(self.x))
        lumped = _lumped(fillings, settings)
        self._stored = storage(fillings, self.x, self._entries, lumped)
        groups = conduction(fillings, self.x, self._entries, lumped)
        self._conducted = Conduction(groups, self._entries)
        self._watched = [w for b in bodies for w in watched(b.name, self._material_nodes(b))]
        self.regions = {name: self._region(b) for name, b in self._bodies.items()}
        self.given = self._prescribed(description.conditions)

    def face(self, side: Side) -> Face:
        """A named region of the boundary, or all of it."""
        body, nodes = self._bodies[side.thing], self._nodes[side.thing]
        own = {f: nodes[found] for f, found in facets(body, side.face).items()}
        return blocks(self.x, own, f"face '{side.face}' of '{side.thing}'")

    irradiated = face

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        return facing_loads(self.face(side), direction, len(self.x))

    def place(self, place: Place) -> Mean:
        """All of a body, a region of its cells, or a face."""
        body, first = self._bodies[place.name], self._nodes[place.name][0]
        cells = body.volumes.get(place.end or "")
        if cells is None:
            assert place.end is not None
            return face_mean(self.face(Side(place.name, place.end)))
        return volume_mean(self.x, _moved(cells, first), body.fillings[0])

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored."""
        return self._stored.heat(T)

    def power(self, T: Array) -> Array:
        """(n,) [W] received by conduction."""
        return self._conducted.power(T)

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``tangent``: every one once, row by row."""
        return self._entries.rows, self._entries.columns.astype(np.intp)

    def tangent(self, T: Array, tau: float) -> Array:
        """Entries of dE/dT - tau dP/dT."""
        data = self._stored.constant + tau * self._conducted.constant
        self._stored.refill(T, data)
        self._conducted.refill(T, tau, data)
        return data

    def unusable(self, T: Array) -> str:
        """Which property's range ``T`` has left, or ""."""
        return next(filter(None, (w.complaint(T) for w in self._watched)), "")

    def _fillings(self) -> list[Filling]:
        return [
            f._replace(cells=self._nodes[name][f.cells])
            for name, body in self._bodies.items()
            for f in body.fillings
        ]

    def _material_nodes(self, body: Body) -> dict[Material, Indices]:
        found: dict[Material, list[Indices]] = {}
        for f in body.fillings:
            found.setdefault(f.material, []).append(f.cells.ravel())
        nodes = self._nodes[body.name]
        return {m: nodes[np.unique(np.concatenate(parts))] for m, parts in found.items()}

    def _region(self, body: Body) -> Indices:
        """Where others look for a body by its name: all of it, or where it rubs."""
        rubbing = body.thing.rubbing if isinstance(body.thing, Solid) else None
        if not rubbing:
            return self._nodes[body.name][body.listed]
        return self.place(Place(body.name, rubbing)).nodes

    def _prescribed(self, conditions: Sequence[Condition]) -> list[GivenTemperatures]:
        free = np.ones(len(self.x), dtype=bool)
        found: list[GivenTemperatures] = []
        for c in conditions:
            own = self._given_by(c)
            if own is not None:
                kept = free[own.nodes]
                free[own.nodes] = False
                found.append(_kept(own, kept))
        return found

    def _given_by(self, c: Condition) -> Given | GivenField | None:
        match c:
            case Wall():
                return given_by_wall(c, self._bodies[c.member], self._nodes[c.member])
            case Faces():
                return given_by_faces(c, self._bodies[c.sheet], self._nodes[c.sheet])
            case Field():
                nodes = self._nodes[c.body]
                return GivenField(c.name, nodes, self.x[nodes], c.temperature)
            case Fixed():
                nodes = self.place(c.place).nodes
                return Given(c.name, nodes, np.ones((len(nodes), 1)), (c.temperature,))
        return None


def _bodies(d: Description, settings: Settings) -> list[Body]:
    """All bodies, or a ValueError with what is wrong with any of them."""
    found: list[Body] = []
    problems = _settings_problems(settings)
    things: list[Member | Sheet | Solid] = [*d.members, *d.sheets, *d.solids]
    for thing in () if problems else things:
        try:
            found.append(_body(thing, settings))
        except ValueError as error:
            text = str(error)
            problems.append(text if f"'{thing.name}'" in text else f"'{thing.name}': {text}")
    if problems:
        raise ValueError("\n  ".join(["heat in 3D:", *problems]))
    return found


def _body(thing: Member | Sheet | Solid, settings: Settings) -> Body:
    match thing:
        case Member():
            return member_body(thing, settings)
        case Sheet():
            return sheet_body(thing, settings)
    return solid_body(thing)


def _settings_problems(settings: Settings) -> list[str]:
    found = []
    if settings.order not in (1, 2):
        found.append(f"order must be 1 or 2, got {settings.order}")
    if settings.layers < 1:
        found.append(f"layers must be at least 1, got {settings.layers}")
    if settings.capacity not in CAPACITIES:
        known = ", ".join(CAPACITIES)
        found.append(f"capacity must be one of {known}, got {settings.capacity!r}")
    return found


def _lumped(fillings: Sequence[Filling], settings: Settings) -> bool:
    families = {f.family for f in fillings}
    if settings.capacity == "lumped" and (odd := families - set(LUMPABLE)):
        raise ValueError(
            f"cells of {', '.join(sorted(odd))} would store negative heat at their corners: "
            "their capacity must be consistent"
        )
    if settings.capacity == "auto":
        return families <= {"tetra", "hexahedron"}
    return settings.capacity == "lumped"


def _kept(own: Given | GivenField, kept: NDArray[np.bool_]) -> GivenTemperatures:
    if isinstance(own, Given):
        return own._replace(nodes=own.nodes[kept], weights=own.weights[kept])
    return own._replace(nodes=own.nodes[kept], x=own.x[kept])


def _moved(cells: Cells, first: int) -> Cells:
    return {family: nodes + first for family, nodes in cells.items()}
