"""Several discretisations as one: members by one kind, sheets and solids by others, and lumps."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.description import Description, Faces, Field, Fixed, Place, Side, Wall
from thermal.discretisation import Discretisation, Face, GivenTemperatures, Mean

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Shifted(NamedTuple):
    """Given temperatures of one discretisation, numbered as in the whole."""

    own: GivenTemperatures
    first: int

    @property
    def name(self) -> str:
        return self.own.name

    @property
    def nodes(self) -> Indices:
        return self.own.nodes + self.first

    def at(self, t: float) -> Array:
        return self.own.at(t)


class Composite:
    """Temperatures of the discretisations one after the other; see ``thermal.discretisation``."""

    def __init__(self, spaces: Sequence[Discretisation]) -> None:
        self._spaces = list(spaces)
        counts = [len(space.x) for space in self._spaces]
        self._firsts = np.concatenate([[0], np.cumsum(counts)]).astype(int)
        self.x = np.vstack([np.zeros((0, 3)), *(space.x for space in self._spaces)])
        self.start = np.concatenate([np.empty(0), *(space.start for space in self._spaces)])
        self.regions: dict[str, Indices] = {}
        self.given: list[GivenTemperatures] = []
        self._owner: dict[str, int] = {}
        for i, (space, first) in enumerate(self._pairs()):
            self.regions |= {name: nodes + first for name, nodes in space.regions.items()}
            self.given += [Shifted(g, first) for g in space.given]
            self._owner |= dict.fromkeys(space.regions, i)

    def face(self, side: Side) -> Face:
        """See Discretisation."""
        space, first = self._of(side.thing)
        return _moved(space.face(side), first)

    def irradiated(self, side: Side) -> Face:
        """See Discretisation."""
        space, first = self._of(side.thing)
        return _moved(space.irradiated(side), first)

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        space, first = self._of(side.thing)
        loads = np.zeros(len(self.x))
        loads[first : first + len(space.x)] = space.absorbing(side, direction)
        return loads

    def place(self, place: Place) -> Mean:
        """See Discretisation."""
        space, first = self._of(place.name)
        mean = space.place(place)
        return Mean(mean.nodes + first, mean.weights)

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored."""
        parts = [space.heat(own) for space, own in self._split(T)]
        return np.concatenate([np.empty(0), *parts])

    def power(self, T: Array) -> Array:
        """(n,) [W] received by conduction."""
        parts = [space.power(own) for space, own in self._split(T)]
        return np.concatenate([np.empty(0), *parts])

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``tangent``."""
        found = [(space.entries(), first) for space, first in self._pairs()]
        none = [np.empty(0, np.intp)]
        rows = np.concatenate(none + [r + first for (r, _), first in found])
        return rows, np.concatenate(none + [c + first for (_, c), first in found])

    def tangent(self, T: Array, tau: float) -> Array:
        """Entries of dE/dT - tau dP/dT."""
        parts = [space.tangent(own, tau) for space, own in self._split(T)]
        return np.concatenate([np.empty(0), *parts])

    def unusable(self, T: Array) -> str:
        """The first complaint, or ""."""
        return next(filter(None, (space.unusable(own) for space, own in self._split(T))), "")

    def _pairs(self) -> list[tuple[Discretisation, int]]:
        return list(zip(self._spaces, self._firsts[:-1].tolist(), strict=True))

    def _split(self, T: Array) -> list[tuple[Discretisation, Array]]:
        return [(space, T[first : first + len(space.x)]) for space, first in self._pairs()]

    def _of(self, name: str) -> tuple[Discretisation, int]:
        return self._pairs()[self._owner[name]]


Make = Callable[[Description], Discretisation]


def part_of(d: Description, names: set[str]) -> Description:
    """The things of some names alone, with what gives their temperatures."""
    return Description(
        [m for m in d.members if m.name in names],
        [p for p in d.parts if p.name in names],
        (),
        [c for c in d.conditions if _gives(c) in names],
        [s for s in d.sheets if s.name in names],
        [s for s in d.solids if s.name in names],
    )


def compose(d: Description, choice: Sequence[tuple[Make, set[str]]]) -> Discretisation:
    """Discretise things, each group of names in its way; of a single group its own."""
    spaces = [make(part_of(d, names)) for make, names in choice if names]
    return spaces[0] if len(spaces) == 1 else Composite(spaces)


def _gives(condition: object) -> str | None:
    """Whose temperatures a condition prescribes."""
    match condition:
        case Wall():
            return condition.member
        case Faces():
            return condition.sheet
        case Field():
            return condition.body
        case Fixed():
            return condition.place.name
    return None


def _moved(face: Face, first: int) -> Face:
    return [block._replace(dofs=block.dofs + first) for block in face]
