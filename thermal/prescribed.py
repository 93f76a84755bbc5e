"""Temperatures that follow their conditions exactly: ``PrescribedHeat``."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material
from thermal.check import check
from thermal.description import (
    DEFAULT,
    Description,
    Faces,
    Field,
    Fixed,
    Member,
    Part,
    Settings,
    Sheet,
    Solid,
    Wall,
)
from thermal.discretisation import Face, GivenTemperatures
from thermal.heat import NOTHING, Outside
from thermal.layout import arclength, given, given_nodes, layout
from thermal.limits import ALWAYS, Limits, known_times
from thermal.network import face_masses, masses

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Thing = Member | Part | Sheet | Solid

RESERVOIR = "reservoir"
GIVING = Wall | Faces | Field | Fixed
ROUNDING = 1e-6
"""How far rounding may carry a temperature beyond the data of a material [K]."""


class Mass(NamedTuple):
    """Temperatures of one material and the masses (k,) [kg] they stand for."""

    owner: str
    nodes: Indices
    material: Material
    mass: Array


class PrescribedHeat:
    """Temperatures given by wall, face, field and fixed conditions; nothing is solved.

    Parts without a condition stay as they are. All other conditions and the links have no
    effect. What the heat balance lacks flows in from an unlimited reservoir. A solid has a
    temperature at each point of its mesh.

    Attributes
    ----------
    x : (n, 3) float [m]
    regions : name -> its temperatures
    unused : names of the conditions, links and interfaces that have no effect
    times : (first, last) float [s]  from when to when all fields are known
    irradiated : nothing
    settings : Settings
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        check(description)
        self.settings = settings
        self.x, self.regions, self._initial = _with_solids(description)
        self._given = _given(description, self.regions, self.x)
        things: list[Thing] = [*description.members, *description.parts]
        things += [*description.sheets, *description.solids]
        self._masses = [mass for o in things for mass in _masses(o, self.regions[o.name])]
        _require_cover(things, self.regions, given_nodes(self._given))
        self._limits, known = Limits(description), known_times(description)
        starts, ends = zip(ALWAYS, *known.values(), strict=True)
        self.times = max(starts), min(ends)
        _require_common(known, self.times)
        self.unused = _unused(description)
        self.irradiated: Mapping[str, Face] = {}

    def initial(self) -> Array:
        """(n,) [K]  of the conditions at t = 0 where there are any, or at the first known time."""
        return self._at(self._initial, min(max(0.0, self.times[0]), self.times[1]))

    def energy(self, T: Array) -> float:
        """Stored heat [J] above the materials' datum of enthalpy."""
        return float(sum(m.mass @ m.material.enthalpy(T[m.nodes]) for m in self._masses))

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside = NOTHING
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] from the reservoir, reason; see ThermalSolver."""
        why = self._unknown(t + h)
        if why:
            return T.copy(), {RESERVOIR: 0.0}, why
        end = self._at(T, t + h)
        flow = self.energy(end) - self.energy(T) - float(np.sum(heat))
        why = self._fault(end)
        return end, {RESERVOIR: flow}, f"t = {t + h:g} s: {why}" if why else ""

    def steady(
        self, T: Array, t: float, outside: Mapping[str, Array] | None = None
    ) -> tuple[Array, Mapping[str, float], str]:
        """The temperatures given at ``t``; power [W] from the reservoir, reason."""
        why = self._unknown(t)
        if why:
            return T.copy(), {RESERVOIR: 0.0}, why
        end = self._at(T, t)
        why = self._fault(end)
        return end, {RESERVOIR: 0.0}, f"t = {t:g} s: {why}" if why else ""

    def _at(self, T: Array, t: float) -> Array:
        T = T.copy()
        for g in self._given:
            T[g.nodes] = g.at(t)
        return T

    def _unknown(self, t: float) -> str:
        why = self._limits.complaint(t)
        return f"t = {t:g} s: {why}" if why else ""

    def _fault(self, T: Array) -> str:
        for owner, nodes, material, _ in self._masses:
            p = material.heat_capacity
            lower, upper = p.lower - ROUNDING, p.upper + ROUNDING
            for bad in T[nodes][~((T[nodes] >= lower) & (T[nodes] <= upper))]:
                return (
                    f"'{owner}' left the range of {p.name} ({p.lower:g} K to {p.upper:g} K) "
                    f"with {bad:g} K"
                )
        return ""


def _with_solids(description: Description) -> tuple[Array, dict[str, Indices], Array]:
    """Positions, regions and initial temperatures; solids last, by the points of their mesh."""
    regions: dict[str, Indices] = {}
    x, initial = np.zeros((0, 3)), np.empty(0)
    if description.members or description.parts or description.sheets:
        x, regions, initial = layout(description)
    for s in description.solids:
        points = s.mesh.points
        regions = {**regions, s.name: len(x) + np.arange(len(points))}
        x, initial = np.vstack([x, points]), np.append(initial, np.full(len(points), s.initial))
    return x, regions, initial


def _masses(o: Thing, nodes: Indices) -> Iterator[Mass]:
    match o:
        case Member():
            yield Mass(o.name, nodes, o.material, masses(o))
        case Sheet():
            yield Mass(o.name, nodes, o.material, face_masses(o))
        case Part():
            yield Mass(o.name, nodes, o.material, np.array([float(o.mass)]))
        case Solid():
            yield from _solid_masses(o, nodes)


def _solid_masses(s: Solid, nodes: Indices) -> Iterator[Mass]:
    """To each corner of a cell its share of the cell; nodes between corners count for nothing."""
    for family, cells in s.mesh.cells.items():
        corners = _corners(family)
        if not corners:
            continue
        volumes = _volumes(s.mesh.points[cells[:, :corners]])
        for region, material in s.materials.items():
            own = _cells_of(s, family, region)
            mass = np.zeros(len(nodes))
            share = material.density * volumes[own, None] / corners
            np.add.at(mass, cells[own, :corners], np.broadcast_to(share, (len(own), corners)))
            kept = np.unique(cells[own])
            yield Mass(s.name, nodes[kept], material, mass[kept])


def _corners(family: str) -> int:
    return 4 if family.startswith("tetra") else 8 if family.startswith("hexahedron") else 0


def _cells_of(s: Solid, family: str, region: str) -> Indices:
    """Cells of a family in a region; "" is what no other region with a material has."""
    if region:
        of, cells = s.mesh.regions[region]
        return cells if of == family else np.empty(0, np.intp)
    taken = [_cells_of(s, family, name) for name in s.materials if name]
    every = np.arange(len(s.mesh.cells[family]))
    return np.setdiff1d(every, np.concatenate([np.empty(0, np.intp), *taken]))


def _volumes(x: Array) -> Array:
    """(k,) [m^3]  of tetrahedra (k, 4, 3), or of hexahedra (k, 8, 3) in six tetrahedra each."""
    if x.shape[1] == 4:
        edges = x[:, 1:] - x[:, :1]
        return np.abs(np.linalg.det(edges)) / 6.0
    ring = [1, 2, 3, 7, 4, 5, 1]  # round the diagonal from 0 to 6
    pairs = pairwise(ring)
    return sum((_volumes(x[:, [0, a, b, 6]]) for a, b in pairs), np.zeros(len(x)))


def _given(
    description: Description, regions: Mapping[str, Indices], x: Array
) -> list[GivenTemperatures]:
    """What gives temperatures; of a solid either all of them or none."""
    solids = {s.name for s in description.solids}
    found = [
        f"fixed '{c.name}': prescribe all of the solid '{c.place.name}', not its '{c.place.end}'"
        for c in description.conditions
        if isinstance(c, Fixed) and c.place.name in solids and c.place.end is not None
    ]
    if found:
        raise ValueError("\n  ".join(["prescribed temperatures of solids", *found]))
    return given(description, regions, x)


def _unused(description: Description) -> list[str]:
    conditions = [c.name for c in description.conditions if not isinstance(c, GIVING)]
    conditions += [link.name for link in description.links]
    return conditions + [interface.name for interface in description.interfaces]


def _require_common(known: Mapping[str, tuple[float, float]], times: tuple[float, float]) -> None:
    if times[0] > times[1]:
        spans = ", ".join(f"'{n}' from {a:g} s to {b:g} s" for n, (a, b) in known.items())
        raise ValueError(f"fields that have no time in common: {spans}")


def _require_cover(things: Sequence[Thing], regions: Mapping[str, Indices], nodes: Indices) -> None:
    found = []
    for o in things:
        bare = ~np.isin(regions[o.name], nodes)
        if isinstance(o, Sheet) and bare.any():
            found.append(f"sheet '{o.name}': no condition gives the temperatures of its faces")
        if isinstance(o, Solid) and bare.any():
            found.append(f"solid '{o.name}': no condition gives its temperatures")
        if isinstance(o, Member) and bare.any():
            stations = bare.reshape(-1, o.wall_points).any(axis=1)
            where = ", ".join(f"{s:g} m" for s in arclength(o.points)[stations])
            found.append(f"member '{o.name}': no condition gives the temperature at {where}")
    if found:
        what = "all members, sheets and solids"
        raise ValueError("\n  ".join([f"prescribed temperatures must cover {what}", *found]))
