"""Heat in the developed surface of tubes and of shells: ``WallSpace``.

A tube is the rectangle of its length by its circumference, closed on itself, with a thin wall
between stations and wall points; a sheet has two faces, each of which conducts in its own plane,
and heat goes through between them. Elements are quadrilaterals of order 1 (bilinear) or 2
(biquadratic, with nodes of their own half-way, which come after all others and belong to no
region). Storage, exchange and conduction are summed at nodes, as ``thermal.wall_elements`` says.

At order 1, where the lines of the surface cross at right angles (tubes, plates, annuli, spheres),
conductances between neighbours are positive for every ratio of sides and of conductivities. Steps
of backward Euler then keep temperatures between the coldest and the hottest of the start and of
the boundaries, of whatever length. Steps of second order can fall short by the error of a step.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, Property
from thermal.description import (
    DEFAULT,
    Condition,
    Description,
    Faces,
    Field,
    Fixed,
    Place,
    Settings,
    Side,
    Wall,
)
from thermal.discretisation import Block, Face, GivenTemperatures, Mean
from thermal.wall_elements import WEIGHTS, Bonds, shape
from thermal.wall_sheet import SheetWall
from thermal.wall_terms import Conducted, Stored
from thermal.wall_tube import TubeWall

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Surfaces = Mapping[str, TubeWall | SheetWall]


class WallSpace:
    """Tubes and sheets of a description; see ``thermal.discretisation``."""

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        _refuse(description, settings)
        form = shape(settings.order)
        tubes, sheets = description.members, description.sheets
        self._walls: dict[str, TubeWall | SheetWall] = {m.name: TubeWall(m, form) for m in tubes}
        self._walls |= {s.name: SheetWall(s, form) for s in sheets}
        self._nodes = _numbering(self._walls)
        self.regions = {name: self._nodes[name][w.named] for name, w in self._walls.items()}
        n = sum(len(nodes) for nodes in self._nodes.values())
        self.x, self.start = np.zeros((n, 3)), np.zeros(n)
        for name, wall in self._walls.items():
            self.x[self._nodes[name]] = wall.x
            self.start[self._nodes[name]] = wall.thing.initial
        self.given = self._prescribed(description.conditions)
        self._stored = _storage(self._walls, self._nodes)
        self._conducted = _conduction(self._walls, self._nodes, n)

    def face(self, side: Side) -> Face:
        """Of a tube "outer", "inner", "start" and "end", of a sheet "top" and "bottom"."""
        return self._moved(side, self._walls[side.thing].face(side.face))

    def irradiated(self, side: Side) -> Face:
        """Elements with several points each, so that the edge of a shadow falls between them.

        The values at the points are shares of the nodes, see ``side_sharing``.
        """
        return self._moved(side, self._walls[side.thing].irradiated(side.face))

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        loads = np.zeros(len(self.x))
        own = self._walls[side.thing].absorbing(side.face, direction)
        loads[self._nodes[side.thing]] = own
        return loads

    def place(self, place: Place) -> Mean:
        """All of a wall by volume, round an end of a tube, or a face of a sheet."""
        own = self._walls[place.name].place(place.end)
        return Mean(self._nodes[place.name][own.nodes], own.weights)

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored."""
        out = np.zeros_like(T)
        for stored in self._stored:
            out[stored.nodes] = stored.heat(T)
        return out

    def power(self, T: Array) -> Array:
        """(n,) [W] received by conduction."""
        out = np.zeros_like(T)
        for conducted in self._conducted:
            conducted.add(T, out)
        return out

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``tangent``."""
        nodes = [np.empty(0, np.intp), *(s.nodes for s in self._stored)]
        rows = np.concatenate(nodes + [c.rows for c in self._conducted])
        return rows, np.concatenate(nodes + [c.columns for c in self._conducted])

    def tangent(self, T: Array, tau: float) -> Array:
        """Entries in the order of ``entries``."""
        stored = [stored.capacity(T) for stored in self._stored]
        conducted = [conducted.slopes(T, tau) for conducted in self._conducted]
        return np.concatenate([np.empty(0), *stored, *conducted])

    def unusable(self, T: Array) -> str:
        """Which property's range ``T`` has left and where, or ""."""
        for stored in self._stored:
            found = stored.astray(T)
            if found is not None:
                node, p = found
                return (
                    f"'{self._owner(node)}' left the range of {p.name} "
                    f"({p.lower:g} K to {p.upper:g} K) with {T[node]:g} K"
                )
        return ""

    def _owner(self, node: int) -> str:
        return next(name for name, nodes in self._nodes.items() if node in nodes)

    def _moved(self, side: Side, blocks: Sequence[Block]) -> Face:
        nodes = self._nodes[side.thing]
        return [block._replace(dofs=nodes[block.dofs]) for block in blocks]

    def _prescribed(self, conditions: Sequence[Condition]) -> list[GivenTemperatures]:
        return [
            given
            for name, wall in self._walls.items()
            for given in wall.given(
                [c for c in conditions if _target(c) == name], self._nodes[name], self.x
            )
        ]


def _refuse(d: Description, settings: Settings) -> None:
    found = [f"solid '{s.name}' is not a wall; use the solver 'solid'" for s in d.solids]
    found += [
        f"member '{m.name}' is not a wall: it needs the section of a tube, and wall points"
        for m in d.members
        if m.section.kind != "tube" or m.wall_points == 1
    ]
    if settings.order not in WEIGHTS:
        found.append(f"the order of walls is 1 or 2, got {settings.order}")
    if found:
        raise ValueError("\n".join(found))


def _target(c: Condition) -> str | None:
    """Whose temperatures a condition gives."""
    match c:
        case Wall():
            return c.member
        case Faces():
            return c.sheet
        case Field():
            return c.body
        case Fixed():
            return c.place.name
    return None


def _numbering(walls: Surfaces) -> dict[str, Indices]:
    """Temperatures of each wall's nodes: first those with names of all, then what order 2 adds."""
    first = 0
    nodes = {name: np.full(len(wall.x), -1, np.intp) for name, wall in walls.items()}
    for name, wall in walls.items():
        nodes[name][wall.named] = np.arange(first, first + len(wall.named))
        first += len(wall.named)
    for own in nodes.values():
        more = np.flatnonzero(own < 0)
        own[more] = np.arange(first, first + len(more))
        first += len(more)
    return nodes


def _storage(walls: Surfaces, nodes: Mapping[str, Indices]) -> list[Stored]:
    """One term for each material."""
    groups: dict[Material, list[str]] = {}
    for name, wall in walls.items():
        groups.setdefault(wall.thing.material, []).append(name)
    return [
        Stored(
            material,
            np.concatenate([nodes[name] for name in names]),
            material.density * np.concatenate([walls[name].volumes for name in names]),
        )
        for material, names in groups.items()
    ]


def _conduction(walls: Surfaces, nodes: Mapping[str, Indices], n: int) -> list[Conducted]:
    """One term for each conductivity."""
    groups: dict[Property, list[Bonds]] = {}
    for name, wall in walls.items():
        pairs = zip(wall.thing.material.conductivities, wall.bonds, strict=True)
        for conductivity, bonds in pairs:
            if bonds is not None:
                own = nodes[name]
                moved = Bonds(own[bonds.a], own[bonds.b], bonds.c)
                groups.setdefault(conductivity, []).append(moved)
    return [Conducted(conductivity, parts, n) for conductivity, parts in groups.items()]
