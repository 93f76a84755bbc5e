"""Heat by a network of lumps and conductances: ``LumpedHeat``.

Finite volumes: every temperature is a lump of wall or section, joined to its neighbours by
conductances with k at the mean of the two temperatures. It sees the same description as the
finite elements and shares with them neither storage and conduction nor, unless a scheme is named,
time integration: that of its own is TR-BDF2.

Over the circumference of a tube and along members and sheets its error falls with the square of
the distance between points. A sheet is two lumps through its thickness t: the steady difference
of its faces and that under a steady flux are exact, a disturbance between them fades with
4 alpha / t^2 instead of pi^2 alpha / t^2. Three lumps of a solid section carry mean and two
gradients.
"""

import numpy as np
from numpy.typing import NDArray

from thermal import integration, trbdf2
from thermal.check import check
from thermal.description import DEFAULT, Description, Member, Part, Place, Settings, Sheet, Side
from thermal.discretisation import Face, Mean, facing_loads
from thermal.heat import Heat
from thermal.layout import given, layout
from thermal.lump_faces import absorbing_arcs, member_face, part_face, sheet_face
from thermal.network import Conductors, Store, cell_lengths, conductors, face_masses, stores
from thermal.profiles import GRADIENTS, absorbing_widths

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Thing = Member | Part | Sheet


class LumpedHeat(Heat):
    """Network of heat capacities and conductances.

    Parameters
    ----------
    description : Description  without solids
    settings : Settings
        of the default scheme, which stands for TR-BDF2, or of another
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        check(description)
        own = settings.scheme == DEFAULT.scheme
        integrate = trbdf2.integrate if own else integration.integrate
        super().__init__(NetworkSpace(description), description, settings, integrate)


class NetworkSpace:
    """Lumps and conductors; see ``thermal.discretisation``."""

    def __init__(self, description: Description) -> None:
        _refuse_solids(description)
        things: list[Thing] = [*description.members, *description.parts, *description.sheets]
        self._things = {thing.name: thing for thing in things}
        self.x, self.regions, self.start = layout(description)
        self.given = given(description, self.regions, self.x)
        self._stores: list[Store] = stores(description, self.regions)
        self._conductors: list[Conductors] = conductors(description, self.regions)

    def face(self, side: Side) -> Face:
        """To each lump its piece of the face."""
        thing, nodes = self._things[side.thing], self.regions[side.thing]
        match thing:
            case Member():
                return member_face(thing, nodes, side.face)
            case Sheet():
                return sheet_face(thing, nodes, side.face)
            case Part():
                return part_face(thing, nodes)

    irradiated = face

    def absorbing(self, side: Side, direction: Array | None) -> Array:
        """(n,) [m^2] by which a flux density is absorbed."""
        thing, n = self._things[side.thing], len(self.x)
        if direction is None or not isinstance(thing, Member) or side.face in ("start", "end"):
            return facing_loads(self.face(side), direction, n)
        loads = np.zeros(n)
        loads[self.regions[side.thing]] = _seen_by_rays(thing, side.face, direction)
        return loads

    def place(self, place: Place) -> Mean:
        """The lumps of a place, by their mass."""
        thing, nodes = self._things[place.name], self.regions[place.name]
        match thing:
            case Sheet():
                side = slice(None) if place.end is None else slice(place.end == "bottom", None, 2)
                nodes, weights = nodes[side], face_masses(thing)[side]
            case Member() if place.end is None:
                weights = np.repeat(cell_lengths(thing), thing.wall_points)
            case Member():
                n = thing.wall_points
                nodes, weights = nodes[:n] if place.end == "start" else nodes[-n:], np.ones(n)
            case Part():
                weights = np.ones(1)
        return Mean(nodes, weights / weights.sum())

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored in each lump."""
        out = np.zeros_like(T)
        for s in self._stores:
            out[s.nodes] = s.mass * s.material.enthalpy(T[s.nodes])
        return out

    def power(self, T: Array) -> Array:
        """(n,) [W] conducted to each lump."""
        out = np.zeros_like(T)
        for c in self._conductors:
            a, b = T[c.a], T[c.b]
            q = c.shape * c.conductivity(0.5 * (a + b)) * (a - b)
            out += np.bincount(c.b, q, len(T)) - np.bincount(c.a, q, len(T))
        return out

    def entries(self) -> tuple[Indices, Indices]:
        """The diagonal of the lumps, and four for each conductor."""
        stored = [s.nodes for s in self._stores]
        rows = [i for c in self._conductors for i in (c.a, c.a, c.b, c.b)]
        columns = [i for c in self._conductors for i in (c.a, c.b, c.a, c.b)]
        return np.concatenate(stored + rows), np.concatenate(stored + columns)

    def tangent(self, T: Array, tau: float) -> Array:
        """Entries of dE/dT - tau dP/dT."""
        values = [s.mass * s.material.heat_capacity(T[s.nodes]) for s in self._stores]
        for c in self._conductors:
            a, b = T[c.a], T[c.b]
            mean = 0.5 * (a + b)
            k = tau * c.shape * c.conductivity(mean)
            bend = 0.5 * tau * c.shape * c.conductivity.derivative(mean) * (a - b)
            values += [k + bend, bend - k, -k - bend, k - bend]
        return np.concatenate(values)

    def unusable(self, T: Array) -> str:
        """Which lump has left the range of a property, or ""."""
        for s in self._stores:
            at = T[s.nodes]
            for p in s.needs:
                out = (at < p.lower * (1.0 - 1e-9)) | (at > p.upper * (1.0 + 1e-9))
                if out.any():
                    node = int(s.nodes[np.argmax(out)])
                    owner = next(name for name, nodes in self.regions.items() if node in nodes)
                    return (
                        f"'{owner}' left the range of {p.name} "
                        f"({p.lower:g} K to {p.upper:g} K) with {T[node]:g} K"
                    )
        return ""


def _seen_by_rays(m: Member, face: str, direction: Array) -> Array:
    """(stations * wall_points,) [m^2]  of a member's outer or inner face."""
    if m.wall_points > GRADIENTS:
        return absorbing_arcs(m, face, direction)
    unit = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    facing = -np.asarray(m.axes, dtype=float)[:, 1:] @ unit
    widths = absorbing_widths(m.section, m.wall_points, facing)
    if face == "inner":
        widths = widths * (1.0 - 2.0 * m.section.thickness / m.section.height)
    return (widths * cell_lengths(m)[:, None]).ravel()


def _refuse_solids(description: Description) -> None:
    if description.solids:
        names = ", ".join(f"'{s.name}'" for s in description.solids)
        raise ValueError(f"the lumped solver has no lumps for solids: {names}")
