"""Temperatures that follow their conditions exactly: ``PrescribedHeat``."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from thermal.check import check
from thermal.description import DEFAULT, Description, Member, Part, Settings, Sheet
from thermal.heat import NOTHING, Outside
from thermal.layout import arclength, given, given_nodes, layout, node_areas

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

RESERVOIR = "reservoir"
ROUNDING = 1e-6
"""How far rounding may carry a temperature beyond the data of a material [K]."""


class PrescribedHeat:
    """Temperatures given by wall, face and fixed conditions; nothing is solved.

    Parts without a condition stay as they are. All other conditions and the links have no
    effect. What the heat balance lacks flows in from an unlimited reservoir.
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        check(description)
        self.x, self.regions, self._initial = layout(description)
        self._given = given(description, self.regions, self.x)
        nodes = given_nodes(self._given)
        _require_cover(description.members, description.sheets, self.regions, nodes)
        things: list[tuple[Member | Sheet | Part, Array]] = [
            *((m, _masses(m)) for m in description.members),
            *((s, _face_masses(s)) for s in description.sheets),
            *((p, np.array([p.mass])) for p in description.parts),
        ]
        self._bodies = [(self.regions[o.name], o.material, mass, o.name) for o, mass in things]

    def initial(self) -> Array:
        """(n,) [K]  of the conditions at t = 0 where there are any."""
        return self._at(self._initial, 0.0)

    def energy(self, T: Array) -> float:
        """Stored heat [J] above the materials' datum of enthalpy."""
        return float(sum(mass @ m.enthalpy(T[nodes]) for nodes, m, mass, _ in self._bodies))

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside = NOTHING
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] from the reservoir, reason; see ThermalSolver."""
        end = self._at(T, t + h)
        flow = self.energy(end) - self.energy(T) - float(np.sum(heat))
        why = self._fault(end)
        return end, {RESERVOIR: flow}, f"t = {t + h:g} s: {why}" if why else ""

    def _at(self, T: Array, t: float) -> Array:
        T = T.copy()
        for g in self._given:
            T[g.nodes] = g.at(t)
        return T

    def _fault(self, T: Array) -> str:
        for nodes, material, _, name in self._bodies:
            p = material.heat_capacity
            lower, upper = p.lower - ROUNDING, p.upper + ROUNDING
            for bad in T[nodes][~((T[nodes] >= lower) & (T[nodes] <= upper))]:
                return (
                    f"'{name}' left the range of {p.name} ({p.lower:g} K to {p.upper:g} K) "
                    f"with {bad:g} K"
                )
        return ""


def _masses(m: Member) -> Array:
    """(stations * wall_points,) [kg]  half of the wall to each neighbouring station."""
    s = arclength(m.points)
    lengths = 0.5 * (np.diff(s, append=s[-1]) + np.diff(s, prepend=s[0]))
    share = m.material.density * m.section.area / m.wall_points
    return np.repeat(share * lengths, m.wall_points)


def _face_masses(s: Sheet) -> Array:
    """(2 nodes,) [kg]  half of the thickness to each face."""
    return np.repeat(0.5 * s.material.density * s.thickness * node_areas(s), 2)


def _require_cover(
    members: Sequence[Member],
    sheets: Sequence[Sheet],
    regions: Mapping[str, Indices],
    nodes: Indices,
) -> None:
    found = [
        f"sheet '{s.name}': no condition gives the temperatures of its faces"
        for s in sheets
        if not np.isin(regions[s.name], nodes).all()
    ]
    for m in members:
        bare = ~np.isin(regions[m.name], nodes).reshape(-1, m.wall_points).all(axis=1)
        if bare.any():
            where = ", ".join(f"{s:g} m" for s in arclength(m.points)[bare])
            found.append(f"member '{m.name}': no condition gives the temperature at {where}")
    if found:
        raise ValueError(
            "\n  ".join(["prescribed temperatures must cover all members and sheets", *found])
        )
