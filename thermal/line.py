"""Heat on networks of lines by finite elements: ``LineSpace``.

Along a member temperatures are linear between stations (scikit-fem defines mesh, basis and
quadrature); over a section they follow ``thermal.profiles``: one value, mean and two gradients,
or trigonometric interpolation round a tube, whose wall is thin: storage and conduction act on its
mean surface. All members live on one axis with gaps between them; only links connect them.
"""

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Property
from thermal.description import DEFAULT, Description, Member, Place, Settings, Side
from thermal.discretisation import Affine, Face, Mean, affine, facing_loads
from thermal.elements import chains, discretise, stations
from thermal.layout import given, layout, place_nodes
from thermal.profiles import absorbing_widths, profile, values_at
from thermal.strips import CORNERS, end_face, lengthwise_face
from thermal.terms import Chain, add_heat, add_power, count, entries, tangent

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ENDS = ("start", "end")


class LineSpace:
    """Linear elements along members; see ``thermal.discretisation``.

    Heat is stored at the stations alone, so that no shock at an end cools or heats a station
    beyond the boundaries: by backward Euler at any step and mesh, by SDIRK2 under error control
    within its tolerance. Equal steps of SDIRK2 keep to it up to a Fourier number D h / dx^2 of
    0.4; longer ones may fall below by up to a third of the jump.
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        self._description = description
        self._members = {m.name: m for m in description.members}
        self.x, self.regions, self.start = layout(description)
        self.given = given(description, self.regions, self.x)
        self._lines = discretise(description.members)
        self._chains = chains(description.members, self._lines, self.regions)
        self._watched = [(m, watched(m)) for m in description.members]
        self._constant = [_constant(chain, self.start) for chain in self._chains]

    def face(self, side: Side) -> Face:
        """Strips between half stations all round, or the pieces of an end section."""
        return self._face(side, False)

    def irradiated(self, side: Side) -> Face:
        """As ``face``, with strips narrow enough for the edge of light and shadow."""
        return self._face(side, True)

    def _face(self, side: Side, fine: bool) -> Face:
        m = self._members[side.thing]
        dofs = stations(m, self.regions)
        if side.face in ENDS:
            return end_face(m, side.face, dofs[:1] if side.face == "start" else dofs[-1:])
        return lengthwise_face(m, side.face, fine, dofs, self._lines[m.name].lengths)

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        if side.face != "outer":
            return facing_loads(self.irradiated(side), direction, len(self.x))
        m, loads = self._members[side.thing], np.zeros(len(self.x))
        widths = absorbing_widths(m.section, m.wall_points, facing(m, direction))
        loads[self.regions[m.name]] = (self._lines[m.name].lengths[:, None] * widths).ravel()
        return loads

    def place(self, place: Place) -> Mean:
        """All round the end of a member, or all of it by volume."""
        nodes = place_nodes(self._description, self.regions, place)
        lengths = np.ones(1) if place.end else self._lines[place.name].lengths
        weights = np.repeat(lengths / lengths.sum(), self._members[place.name].wall_points)
        return Mean(nodes, weights / weights.sum())

    def heat(self, T: Array) -> Array:
        """(n,) [J]  stored heat, each temperature's share."""
        out = np.zeros_like(T)
        for chain in self._chains:
            add_heat(chain, T, out)
        return out

    def power(self, T: Array) -> Array:
        """(n,) [W] received by conduction."""
        out = np.zeros_like(T)
        for chain in self._chains:
            add_power(chain, T, out)
        return out

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``tangent``."""
        none = np.empty(0, np.intp)
        rows, columns = zip((none, none), *(entries(chain) for chain in self._chains), strict=True)
        return np.concatenate(rows), np.concatenate(columns)

    def tangent(self, T: Array, tau: float) -> Array:
        """Entries in the order of ``entries``."""
        last = np.cumsum([count(chain) for chain in self._chains])
        out = np.empty(last[-1])
        parts = np.split(out, last[:-1])
        for chain, constant, part in zip(self._chains, self._constant, parts, strict=True):
            if constant is not None:
                part[:] = constant.at(tau)
            else:
                tangent(chain, T, tau, part)
        return out

    def unusable(self, T: Array) -> str:
        """Which property's range ``T`` has left, or ""."""
        found = (
            left_range(m, T[stations(m, self.regions)] @ values.T) for m, values in self._watched
        )
        return next(filter(None, found), "")


def _constant(chain: Chain, T: Array) -> Affine | None:
    def entries(tau: float) -> Array:
        out = np.empty(count(chain))
        tangent(chain, T, tau, out)
        return out

    material = chain.material
    return affine(entries, (material.heat_capacity, *material.conductivities))


def facing(m: Member, direction: Array | None) -> Array | None:
    """(stations, 2)  minus the unit direction of rays along e2 and e3."""
    if direction is None:
        return None
    rays = np.asarray(direction, dtype=float)
    return -np.asarray(m.axes, dtype=float)[:, 1:] @ (rays / np.linalg.norm(rays))


def watched(m: Member) -> Array:
    """(P, N)  shape functions where the range of the properties is watched: also at the outline."""
    inside = profile(m.wall_points).values
    if m.section.kind == "tube" or m.wall_points == 1:
        return inside
    return np.vstack([inside, values_at(m.section, m.wall_points, m.section.outline(CORNERS))])


def properties(m: Member) -> list[Property]:
    """Those that the temperatures of a member must keep to the range of."""
    across = m.material.conductivities if m.wall_points > 1 else m.material.conductivities[:1]
    return list(dict.fromkeys([m.material.heat_capacity, *across]))


def left_range(m: Member, at: Array) -> str:
    """Which property's range temperatures ``at`` [K] of a member have left, or ""."""
    slack = 1e-9 * at.max()  # round-off of the interpolation
    for p in properties(m):
        if at.min() < p.lower - slack or at.max() > p.upper + slack:
            worst = at.min() if at.min() < p.lower - slack else at.max()
            return (
                f"'{m.name}' left the range of {p.name} "
                f"({p.lower:g} K to {p.upper:g} K) with {worst:g} K"
            )
    return ""
