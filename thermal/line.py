"""Heat on networks of lines by finite elements: ``LineHeat``.

Along a member temperatures are linear between stations (scikit-fem defines mesh, basis and
quadrature); over the circumference of a tube they are the trigonometric interpolation of the
wall temperatures. The wall is thin: storage and conduction act on its mean surface, radiation
and absorption on its outer face. All members live on one axis with gaps between them; only
links connect them.
"""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from thermal import sdirk
from thermal.check import check
from thermal.description import Description
from thermal.elements import bulk_terms, discretise, links, radiating_terms, supplies
from thermal.layout import given, given_nodes, layout
from thermal.pattern import Pattern, block_entries
from thermal.terms import (
    add_along,
    add_around,
    add_heat,
    add_radiation,
    along_blocks,
    around_blocks,
    blend,
    capacity_blocks,
    links_power,
    radiation_blocks,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class LineHeat:
    """Finite elements along members; the state is the vector of temperatures.

    Parameters
    ----------
    description : Description
    tolerance : float [K]  of the estimated error of each step within an interval
    """

    def __init__(self, description: Description, tolerance: float = 1e-3) -> None:
        check(description)
        self.tolerance = tolerance
        self.x, self.regions, self._initial = layout(description)
        self._given = given(description, self.regions)
        self._given_nodes = given_nodes(self._given)
        self.free = np.setdiff1d(np.arange(len(self.x)), self._given_nodes)
        lines = discretise(description.members)
        self._stored, self._around, self._along = bulk_terms(description, lines, self.regions)
        self._radiating = radiating_terms(description, lines, self.regions)
        self._supplies = supplies(description, lines, self.regions)
        self._links = links(description, self.regions)
        self._pattern = self._make_pattern()

    def initial(self) -> Array:
        """(n,) [K]"""
        return self._initial.copy()

    def energy(self, T: Array) -> float:
        """Stored heat [J] above the materials' datum of enthalpy."""
        return float(self.heat(T).sum())

    def advance(
        self, T: Array, t: float, h: float, heat: Array
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] through each boundary, reason; see ThermalSolver."""
        end = sdirk.advance(self, T, t, h, heat / h, self.tolerance)
        flows = {g.name: float(end.reactions[g.nodes].sum()) for g in self._given}
        flows.update(zip(self._flow_names(), end.flows.tolist(), strict=True))
        return end.T, flows, end.why

    def given_at(self, t: float) -> tuple[Indices, Array]:
        """Prescribed temperatures: which, and their values [K]."""
        return self._given_nodes, np.concatenate([np.empty(0), *(g.at(t) for g in self._given)])

    def heat(self, T: Array) -> Array:
        """(n,) [J]  stored heat, each temperature's share."""
        out = np.zeros_like(T)
        for term in self._stored:
            add_heat(term, T, out)
        return out

    def power(self, T: Array, t: float) -> tuple[Array, Array]:
        """(n,) [W] received by each temperature, and (m,) [W] of it through each boundary."""
        out = np.zeros_like(T)
        for around in self._around:
            add_around(around, T, out)
        for along in self._along:
            add_along(along, T, out)
        flows = [add_radiation(r, T, t, out) for r in self._radiating]
        for supply in self._supplies:
            power = supply.history(t) * supply.loads
            out += power
            flows.append(float(power.sum()))
        exchanged = links_power(self._links, T, t)
        out += self._links.spread @ exchanged
        return out, np.concatenate([flows, exchanged[self._links.outward]])

    def factorise(self, T: Array, tau: float) -> Callable[[Array], Array]:
        """Solver of (dE/dT - tau dF/dT) x = r among the free temperatures."""
        return self._pattern.factorise(self._tangent_entries(T, tau))

    def unusable(self, T: Array) -> str:
        """Which property's range ``T`` has left, or ""."""
        if T.min() < 0.0:
            return f"{self.owner(int(T.argmin()))} fell below 0 K"
        for term in self._stored:
            at = blend(T, term.dofs, term.values)
            slack = 1e-9 * at.max()  # round-off of the interpolation
            for p in term.properties:
                if at.min() < p.lower - slack or at.max() > p.upper + slack:
                    station, angle = np.argwhere((at < p.lower - slack) | (at > p.upper + slack))[0]
                    return (
                        f"{self.owner(int(term.dofs[station, 0]))} left the range of {p.name} "
                        f"({p.lower:g} K to {p.upper:g} K) with {at[station, angle]:g} K"
                    )
        return ""

    def owner(self, node: int) -> str:
        """The member or part that a temperature belongs to."""
        return next(f"'{name}'" for name, nodes in self.regions.items() if node in nodes)

    def _flow_names(self) -> list[str]:
        named = [r.name for r in self._radiating] + [s.name for s in self._supplies]
        return named + self._links.names

    def _make_pattern(self) -> Pattern:
        dofs = [s.dofs for s in self._stored] + [a.dofs for a in self._around]
        dofs += [a.dofs for a in self._along] + [r.dofs for r in self._radiating]
        rows, columns = block_entries(dofs)
        matrix = self._links.matrix
        rows, columns = np.concatenate([rows, matrix.row]), np.concatenate([columns, matrix.col])
        return Pattern(len(self.x), self.free, rows, columns)

    def _tangent_entries(self, T: Array, tau: float) -> Array:
        """Entries in the order of ``_make_pattern``."""
        stored = [capacity_blocks(s, T).ravel() for s in self._stored]
        conducted = [around_blocks(a, T).ravel() for a in self._around]
        conducted += [along_blocks(a, T).ravel() for a in self._along]
        conducted += [radiation_blocks(r, T).ravel() for r in self._radiating]
        conducted.append(self._links.matrix.data)
        return np.concatenate([*stored, tau * np.concatenate(conducted)])
