"""Heat through faces, places and links: terms that every discretisation shares.

A term adds power to the temperatures and knows minus its derivative as entries at fixed rows and
columns. What time and motion decide reaches it through ``Moment``.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshes.materials import Property
from thermal.description import (
    Description,
    Enclosure,
    Film,
    Flux,
    History,
    Irradiation,
    Link,
    Place,
    Radiation,
    Side,
    Source,
)
from thermal.discretisation import (
    Block,
    Discretisation,
    Face,
    Mean,
    at_points,
    merged,
    weighted,
)
from thermal.pattern import block_entries

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

STEFAN_BOLTZMANN = 5.670374419e-8  # [W/(m^2 K^4)]  CODATA 2018

NONE = np.empty(0, np.intp)


class Moment(NamedTuple):
    """A time [s], and at it what comes from outside by the name of condition or link."""

    t: float
    outside: Mapping[str, Array]


class Term(Protocol):
    """Power into the temperatures.

    names : of the boundaries whose flows ``add`` returns
    """

    @property
    def names(self) -> Sequence[str]: ...

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        """Add the power [W] of each temperature to ``out``; [W] through each boundary."""
        ...

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``slopes``."""
        ...

    def slopes(self, T: Array, at: Moment) -> Array:
        """Entries [W/K] of minus the derivative of the power."""
        ...


class Pointwise:
    """Flux density that depends on the temperature at the same point: convection, radiation.

    flux, slope : density [W/m^2] into the face and minus its derivative, of (T, moment)
    """

    def __init__(
        self,
        name: str,
        face: Face,
        flux: Callable[[Array, Moment], Array],
        slope: Callable[[Array, Moment], Array],
    ) -> None:
        self.names = (name,)
        self.face, self.flux, self.slope = merged(face), flux, slope

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        total = 0.0
        for block in self.face:
            power = block.areas * self.flux(at_points(block, T), at)
            np.add.at(out, block.dofs, power @ block.values)
            total += float(power.sum())
        return (total,)

    def entries(self) -> tuple[Indices, Indices]:
        return block_entries([block.dofs for block in self.face])

    def slopes(self, T: Array, at: Moment) -> Array:
        return np.concatenate(
            [_slopes(block, self.slope(at_points(block, T), at)) for block in self.face]
        )


class Load:
    """Power that does not depend on temperature: loads (n,) times a history."""

    def __init__(self, name: str, loads: Array, history: History) -> None:
        self.names = (name,)
        self.loads, self.history = loads, history
        self.total = float(loads.sum())

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        value = self.history(at.t)
        out += value * self.loads
        return (value * self.total,)

    def entries(self) -> tuple[Indices, Indices]:
        return NONE, NONE

    def slopes(self, T: Array, at: Moment) -> Array:
        return np.empty(0)


class Irradiated:
    """Flux density from outside at the points of a face, one after the other; n temperatures."""

    def __init__(self, name: str, face: Face, n: int) -> None:
        self.names = (name,)
        self._areas = np.concatenate([np.empty(0), *(block.areas.ravel() for block in face)])
        self._shares = _shares_of_points(face, n)

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        density = at.outside[self.names[0]]
        out += self._shares @ density
        return (float(self._areas @ density),)

    def entries(self) -> tuple[Indices, Indices]:
        return NONE, NONE

    def slopes(self, T: Array, at: Moment) -> Array:
        return np.empty(0)


class Bridge:
    """A link between two places, or from a place to a given temperature.

    Power into a: G f(Tm) (Tb - Ta) + sigma A (Tb^4 - Ta^4), Tm the mean of Ta and Tb.
    """

    def __init__(self, link: Link, a: Mean, b: Mean | None) -> None:
        self.link, self.a, self.b = link, a, b
        self.names = (link.name,) if b is None else ()
        ends = [a] if b is None else [a, b]
        self.nodes = np.concatenate([end.nodes for end in ends])
        signs = (1.0, -1.0)
        self.signed = np.concatenate([s * e.weights for s, e in zip(signs, ends, strict=False)])

    def add(self, T: Array, at: Moment, out: Array) -> Sequence[float]:
        power = self._power(*self._ends(T, at), at)
        np.add.at(out, self.nodes, power * self.signed)
        return (power,) if self.b is None else ()

    def entries(self) -> tuple[Indices, Indices]:
        return block_entries([self.nodes[None]])

    def slopes(self, T: Array, at: Moment) -> Array:
        by_a, by_b = self._slopes(*self._ends(T, at), at)
        columns = by_a * self.a.weights
        if self.b is not None:
            columns = np.concatenate([columns, by_b * self.b.weights])
        return -np.outer(self.signed, columns).ravel()

    def _ends(self, T: Array, at: Moment) -> tuple[float, float]:
        Ta = float(self.a.weights @ T[self.a.nodes])
        if self.b is None:
            assert callable(self.link.b)
            return Ta, float(self.link.b(at.t))
        return Ta, float(self.b.weights @ T[self.b.nodes])

    def _conductance(self, at: Moment) -> float:
        if self.link.conductance is None:
            return float(at.outside[self.link.name][0])
        return self.link.conductance

    def _power(self, Ta: float, Tb: float, at: Moment) -> float:
        factor = 1.0 if self.link.law is None else float(self.link.law(0.5 * (Ta + Tb)))
        radiated = STEFAN_BOLTZMANN * self.link.radiating * (Tb**4 - Ta**4)
        return self._conductance(at) * factor * (Tb - Ta) + radiated

    def _slopes(self, Ta: float, Tb: float, at: Moment) -> tuple[float, float]:
        """Derivatives of the power by Ta and Tb."""
        G, law, mean = self._conductance(at), self.link.law, 0.5 * (Ta + Tb)
        factor = 1.0 if law is None else float(law(mean))
        bend = 0.0 if law is None else 0.5 * G * float(law.derivative(mean)) * (Tb - Ta)
        r = 4.0 * STEFAN_BOLTZMANN * self.link.radiating
        return bend - G * factor - r * Ta**3, bend + G * factor + r * Tb**3


class Boundary:
    """All terms of a description, on a discretisation.

    Attributes
    ----------
    names : of the boundaries, in the order of the flows that ``power`` returns
    irradiated : condition -> Face whose points get their irradiation from outside
    """

    def __init__(self, description: Description, space: Discretisation) -> None:
        self.irradiated = {
            c.name: space.irradiated(Side(c.body, c.face))
            for c in description.conditions
            if isinstance(c, Irradiation)
        }
        self._terms = _terms(description, space, self.irradiated)
        self.names = [name for term in self._terms for name in term.names]

    def power(self, T: Array, at: Moment) -> tuple[Array, Array]:
        """(n,) [W] into each temperature, (m,) [W] through each boundary."""
        out = np.zeros_like(T)
        flows = [flow for term in self._terms for flow in term.add(T, at, out)]
        return out, np.array(flows, dtype=float)

    def entries(self) -> tuple[Indices, Indices]:
        """Rows and columns of ``slopes``."""
        rows, columns = zip((NONE, NONE), *(term.entries() for term in self._terms), strict=True)
        return np.concatenate(rows), np.concatenate(columns)

    def slopes(self, T: Array, at: Moment) -> Array:
        """Entries [W/K] of minus the derivative of the power."""
        return np.concatenate([np.empty(0), *(term.slopes(T, at) for term in self._terms)])


def _terms(
    description: Description, space: Discretisation, irradiated: Mapping[str, Face]
) -> list[Term]:
    terms: list[Term] = []
    for c in description.conditions:
        match c:
            case Film():
                terms.append(_film(c, space.face(Side(c.body, c.face))))
            case Radiation():
                terms.append(_radiation(c, space.face(Side(c.body, c.face))))
            case Flux():
                loads = space.absorbing(Side(c.body, c.face), c.direction)
                terms.append(Load(c.name, loads, c.density))
            case Irradiation():
                terms.append(Irradiated(c.name, irradiated[c.name], len(space.x)))
            case Source():
                terms.append(Load(c.name, _shares(space.place(c.place), len(space.x)), c.power))
            case Enclosure():
                from thermal.enclosure import enclosure

                terms.append(enclosure(c, [space.face(side) for side in c.sides]))
    if description.interfaces:
        from thermal.interface import Pressed

        terms += [Pressed(i, space.face(i.a), space.face(i.b)) for i in description.interfaces]
    return terms + [_bridge(link, space) for link in description.links]


def _shares_of_points(face: Face, n: int) -> csr_array:
    """(n, points) [m^2]  what each temperature receives of a density at the points of a face."""
    ends = np.cumsum([0] + [block.areas.size for block in face])
    shares = [block.areas[..., None] * block.values for block in face]
    rows = [
        np.broadcast_to(block.dofs[:, None], s.shape) for block, s in zip(face, shares, strict=True)
    ]
    columns = [
        np.broadcast_to(np.arange(a, b).reshape(s.shape[0], -1, 1), s.shape)
        for a, b, s in zip(ends, ends[1:], shares, strict=False)
    ]
    i, j = (np.concatenate([NONE, *(x.ravel() for x in part)]) for part in (rows, columns))
    values = np.concatenate([np.empty(0), *(s.ravel() for s in shares)])
    return csr_array((values, (i, j)), shape=(n, int(ends[-1])))


def _film(c: Film, face: Face) -> Pointwise:
    return Pointwise(
        c.name,
        face,
        lambda T, at: c.coefficient(at.t) * (c.surroundings(at.t) - T),
        lambda T, at: np.full_like(T, c.coefficient(at.t)),
    )


def _radiation(c: Radiation, face: Face) -> Pointwise:
    if isinstance(c.emissivity, Property):
        return _varying_radiation(c, c.emissivity, face)
    strength = STEFAN_BOLTZMANN * c.emissivity
    return Pointwise(
        c.name,
        face,
        lambda T, at: strength * (c.sink(at.t) ** 4 - T**4),
        lambda T, at: 4.0 * strength * T**3,
    )


def _varying_radiation(c: Radiation, emissivity: Property, face: Face) -> Pointwise:
    """The emissivity of the face serves for emission and absorption alike (grey)."""

    def slope(T: Array, at: Moment) -> Array:
        lost = T**4 - c.sink(at.t) ** 4
        return STEFAN_BOLTZMANN * (4.0 * emissivity(T) * T**3 + emissivity.derivative(T) * lost)

    return Pointwise(
        c.name,
        face,
        lambda T, at: STEFAN_BOLTZMANN * emissivity(T) * (c.sink(at.t) ** 4 - T**4),
        slope,
    )


def _shares(mean: Mean, n: int) -> Array:
    loads = np.zeros(n)
    np.add.at(loads, mean.nodes, mean.weights)
    return loads


def _bridge(link: Link, space: Discretisation) -> Bridge:
    other = space.place(link.b) if isinstance(link.b, Place) else None
    return Bridge(link, space.place(link.a), other)


def _slopes(block: Block, slope: Array) -> Array:
    return weighted(block.areas * slope, block.values, block.values).ravel()
