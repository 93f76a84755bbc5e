"""What conditions ask for at some time that cannot be: no temperature, a field beyond its data."""

from collections.abc import Iterator, Mapping, Sequence
from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Property
from thermal.description import (
    Description,
    Enclosure,
    Faces,
    Field,
    Film,
    Fixed,
    Flux,
    History,
    Link,
    Place,
    Radiation,
    Side,
    Source,
    Wall,
)
from thermal.discretisation import Discretisation, Face, Mean, at_points

Array = NDArray[np.float64]

ALWAYS = (-inf, inf)
REACH = 1e-9  # how far beyond a range a time or a temperature may be, relative: round-off


class Bound(NamedTuple):
    """A history that must not fall below zero, or whose values need only be finite.

    what : in words, with the condition it belongs to
    """

    what: str
    history: History
    unit: str
    least: float

    def complaint(self, t: float) -> str:
        """What is wrong with the value at ``t``, or ""."""
        value = float(self.history(t))
        if not isfinite(value):
            return f"{self.what} is not a number"
        if value < self.least:
            return f"{self.what} is below 0 {self.unit}: {value:g} {self.unit}"
        return ""


class Limits:
    """The histories and fields of a description, and when they make sense."""

    def __init__(self, description: Description) -> None:
        self._bounds = [
            *(b for c in description.conditions for b in _bounds(c)),
            *(b for link in description.links for b in _bounds(link)),
        ]
        self._known = known_times(description)

    def complaint(self, t: float) -> str:
        """What cannot be at time ``t`` [s], or ""."""
        why = beyond(self._known, t)
        return why or next(filter(None, (b.complaint(t) for b in self._bounds)), "")


def known_times(description: Description) -> dict[str, tuple[float, float]]:
    """Name of each field -> first and last time [s] that it is known at."""
    fields = [c for c in description.conditions if isinstance(c, Field)]
    return {c.name: getattr(c.temperature, "times", ALWAYS) for c in fields}


def beyond(known: Mapping[str, tuple[float, float]], t: float) -> str:
    """Which field is not known at ``t``, or ""."""
    for name, (first, last) in known.items():
        slack = REACH * max(abs(t), last - first) if isfinite(last - first) else 0.0
        if not first - slack <= t <= last + slack:
            return f"field '{name}' is known from {first:g} s to {last:g} s only"
    return ""


class Emitting(NamedTuple):
    """A face whose emissivity depends on temperature."""

    condition: Radiation
    emissivity: Property
    face: Face

    def complaint(self, T: Array, t: float) -> str:
        """Whether its temperatures have left the data of the emissivity, or it is none."""
        p = self.emissivity
        for block in self.face:
            at = at_points(block, T)
            slack = REACH * float(at.max(initial=0.0))
            out = at[(at < p.lower - slack) | (at > p.upper + slack)]
            if out.size:
                return (
                    f"radiation '{self.condition.name}': '{self.condition.body}' left the range "
                    f"of {p.name} ({p.lower:g} K to {p.upper:g} K) with {out[0]:g} K"
                )
            values = p(at)
            bad = np.flatnonzero(~((values >= -REACH) & (values <= 1.0 + REACH)).ravel())
            if bad.size:
                value, hot = values.flat[bad[0]], at.flat[bad[0]]
                return (
                    f"radiation '{self.condition.name}': emissivity must be 0 to 1, "
                    f"got {value:g} at {hot:g} K"
                )
        return ""


class Conducting(NamedTuple):
    """A link whose conductance depends on the mean of the temperatures at its ends."""

    link: Link
    law: Property
    ends: Sequence[Mean]

    def complaint(self, T: Array, t: float) -> str:
        """Whether the mean has left the data of the law."""
        means = [float(end.weights @ T[end.nodes]) for end in self.ends]
        means += [float(self.link.b(t))] if not isinstance(self.link.b, Place) else []
        mean, p = sum(means) / 2.0, self.law
        if p.lower * (1.0 - REACH) <= mean <= p.upper * (1.0 + REACH):
            return ""
        return (
            f"link '{self.link.name}' left the range of its law ({p.lower:g} K to {p.upper:g} K) "
            f"with {mean:g} K"
        )


Watched = Emitting | Conducting


def watched(description: Description, space: Discretisation) -> list[Watched]:
    """Faces and links, on a discretisation, whose properties depend on temperature."""
    faces: list[Watched] = [
        Emitting(c, c.emissivity, space.face(Side(c.body, c.face)))
        for c in description.conditions
        if isinstance(c, Radiation) and isinstance(c.emissivity, Property)
    ]
    return faces + [
        Conducting(link, link.law, [space.place(e) for e in _places(link)])
        for link in description.links
        if link.law is not None
    ]


def _places(link: Link) -> list[Place]:
    return [end for end in (link.a, link.b) if isinstance(end, Place)]


def _bounds(c: object) -> Iterator[Bound]:
    match c:
        case Wall():
            yield from _temperatures(f"wall '{c.name}'", [*c.hot, *c.cold])
        case Faces():
            yield from _temperatures(f"faces '{c.name}'", [c.hot, c.cold])
        case Fixed():
            yield from _temperatures(f"fixed '{c.name}'", [c.temperature])
        case Film():
            yield Bound(f"film '{c.name}': its coefficient", c.coefficient, "W/(m^2 K)", 0.0)
            yield from _temperatures(f"film '{c.name}'", [c.surroundings])
        case Radiation():
            yield from _temperatures(f"radiation '{c.name}'", [c.sink])
        case Enclosure(sink=sink) if sink is not None:
            yield from _temperatures(f"enclosure '{c.name}'", [sink])
        case Link(b=b) if not isinstance(b, Place):
            yield from _temperatures(f"link '{c.name}'", [b])
        case Flux():
            yield Bound(f"flux '{c.name}': its density", c.density, "W/m^2", -inf)
        case Source():
            yield Bound(f"source '{c.name}': its power", c.power, "W", -inf)


def _temperatures(owner: str, histories: Sequence[History]) -> Iterator[Bound]:
    for history in {id(h): h for h in histories}.values():
        yield Bound(f"{owner}: its temperature", history, "K", 0.0)
