"""Heat on networks of lines by finite elements: ``LineHeat``.

Along a member temperatures are linear between stations (scikit-fem defines mesh, basis and
quadrature); over the circumference of a tube they are the trigonometric interpolation of the
wall temperatures. The wall is thin: storage and conduction act on its mean surface, radiation
and absorption on its outer face. All members live on one axis with gaps between them; only
links connect them.
"""

import numpy as np
from numpy.typing import NDArray

from thermal.check import check
from thermal.description import DEFAULT, Description, Place, Settings, Side
from thermal.discretisation import Face, Mean
from thermal.elements import absorbing_loads, bulk_terms, discretise, outer_face
from thermal.heat import Heat
from thermal.layout import given, layout, place_nodes
from thermal.pattern import block_entries
from thermal.terms import (
    add_along,
    add_around,
    add_heat,
    along_blocks,
    around_blocks,
    blend,
    capacity_blocks,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class LineHeat(Heat):
    """Finite elements along members.

    Parameters
    ----------
    description : Description
    settings : Settings
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        check(description)
        super().__init__(LineSpace(description), description, settings)


class LineSpace:
    """Linear elements along members, trigonometric interpolation round tubes; lumps."""

    def __init__(self, description: Description) -> None:
        self._description = description
        self._members = {m.name: m for m in description.members}
        self.x, self.regions, self.start = layout(description)
        self.given = given(description, self.regions, self.x)
        self._lines = discretise(description.members)
        self._stored, self._around, self._along = bulk_terms(description, self._lines, self.regions)

    def face(self, side: Side) -> Face:
        """The outer face of a member."""
        name = side.thing
        return [outer_face(self._members[name], self._lines[name], self.regions)]

    irradiated = face

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        name = side.thing
        return absorbing_loads(self._members[name], self._lines[name], self.regions, direction)

    def place(self, place: Place) -> Mean:
        """All round the end of a member, or a part."""
        nodes = place_nodes(self._description, self.regions, place)
        return Mean(nodes, np.full(len(nodes), 1.0 / len(nodes)))

    def heat(self, T: Array) -> Array:
        """(n,) [J]  stored heat, each temperature's share."""
        out = np.zeros_like(T)
        for term in self._stored:
            add_heat(term, T, out)
        return out

    def power(self, T: Array) -> Array:
        """(n,) [W] received by conduction."""
        out = np.zeros_like(T)
        for around in self._around:
            add_around(around, T, out)
        for along in self._along:
            add_along(along, T, out)
        return out

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``tangent``."""
        dofs = [s.dofs for s in self._stored] + [a.dofs for a in self._around]
        return block_entries(dofs + [a.dofs for a in self._along])

    def tangent(self, T: Array, tau: float) -> Array:
        """Entries in the order of ``entries``."""
        stored = [capacity_blocks(s, T).ravel() for s in self._stored]
        conducted = [tau * around_blocks(a, T).ravel() for a in self._around]
        conducted += [tau * along_blocks(a, T).ravel() for a in self._along]
        return np.concatenate([np.empty(0), *stored, *conducted])

    def unusable(self, T: Array) -> str:
        """Which property's range ``T`` has left, or ""."""
        for term in self._stored:
            at = blend(T, term.dofs, term.values)
            slack = 1e-9 * at.max()  # round-off of the interpolation
            for p in term.properties:
                if at.min() < p.lower - slack or at.max() > p.upper + slack:
                    station, angle = np.argwhere((at < p.lower - slack) | (at > p.upper + slack))[0]
                    return (
                        f"{self._owner(int(term.dofs[station, 0]))} left the range of {p.name} "
                        f"({p.lower:g} K to {p.upper:g} K) with {at[station, angle]:g} K"
                    )
        return ""

    def _owner(self, node: int) -> str:
        return next(f"'{name}'" for name, nodes in self.regions.items() if node in nodes)
