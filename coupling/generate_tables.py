"""Tables of the case file from which many others are made: [generate.NAME]."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.contact_tables import Contact, Friction
from coupling.fields import (
    Count,
    PositiveLength,
    PositiveMass,
    PositiveTime,
    Quantity,
    Table,
    Temperature,
    Time,
)
from meshes.truss import LEVELS

Level = Annotated[int, Count(least=1, most=max(LEVELS))]


class Shakers(Table):
    """Vertical forces that oscillate at corners, evenly spread and in phase around the ring."""

    count: Annotated[int, Count()] = Field(default=24, description="number of forces")
    amplitude: Annotated[float, Quantity(quantities.FORCE)] = Field(description="of each force")
    frequency: Annotated[float, Quantity(quantities.FREQUENCY, above=0.0)] = Field(
        description="oscillations per second"
    )


class Shock(Table):
    """A temperature of the members on one half of the ring, y > 0; the others keep the first."""

    first: Temperature = Field(alias="from", description="temperature before")
    last: Temperature = Field(alias="to", description="temperature after")
    start: Time = Field(default=0.0, description="when it begins")
    duration: PositiveTime = Field(description="how long it takes")


class Clearance(Table):
    """Play in the hinges of a ring: each revolute is a pin in a bore that is a little wider.

    Journals are the ends of chords and diagonals, bearings those of battens; both are of the
    material of the members.
    """

    radius: PositiveLength = Field(description="of every pin")
    clearance: PositiveLength = Field(description="radius of the bore - radius of the pin")
    spherical: bool = Field(
        default=False, description="whether spherical hinges as well are balls in wider sockets"
    )
    mass: PositiveMass | None = Field(
        default=None,
        description="of each pin and of each bore; given: they are parts of [thermal], which take "
        "frictional heat and, in a shock, the temperature of their member",
    )
    reference_temperature: Temperature | None = Field(
        default=None,
        description="at which the clearance holds; default: thermal.initial, else 20 degC",
    )
    contact: Contact = Field(default_factory=Contact, description="normal law")
    friction: Friction | None = Field(default=None, description="absent: no friction")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.clearance >= self.radius:
            yield "clearance", f"must be below the radius of the pin, {self.radius:g} m"


class RingTruss(Table):
    """A ring of hinged members: bodies, joints and, where given, loads and temperatures.

    Makes for each bay, from 0 on, the bodies chord_low_NN, chord_up_NN, batten_NN, diagonal_NN,
    and the joints BODY_start and BODY_end. A table of the case with one of these names changes
    what is made.
    """

    kind: Literal["ring_truss"]
    bays: Annotated[int, Count(least=3, most=1000)] = Field(description="panels around the ring")
    diameter: PositiveLength = Field(description="of the circle of the battens")
    height: PositiveLength = Field(description="of the battens")
    level: Level | None = Field(
        default=None, description="of the mesh: 2, 4, 8 or 16 elements and the fitting per member"
    )
    elements: Annotated[int, Count()] | None = Field(
        default=None, description="instead of level: elements of a member without its fitting"
    )
    fitting: Annotated[float, Quantity(quantities.LENGTH, least=0.0)] = Field(
        default=0.0, description="length of one more element, at the start of each member"
    )
    section: str = Field(description="name of a [section.NAME]")
    material: str = Field(description="name in the library or of a [material.NAME]")
    damping: Time = Field(default=0.0, description="Kelvin-Voigt time")
    element: Literal["beam3243", "beam3333"] = Field(
        default="beam3243", description="of the members"
    )
    support: Literal["clamp", "none"] = Field(
        default="clamp", description="of the foot of the first batten"
    )
    clearance: Clearance | None = Field(default=None, description="absent: hinges without play")
    shakers: Shakers | None = Field(default=None, description="absent: no forces")
    shock: Shock | None = Field(default=None, description="absent: no temperatures are given")

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"level", "elements"}) != 1:
            yield "level", "give either a level or the number of elements"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        chord = self.diameter * _sine(self.bays)
        if self.fitting >= min(self.height, chord):
            text = f"must be shorter than every member, the shortest is {min(self.height, chord):g}"
            yield "fitting", f"{text} m"
        if self.shakers is not None and self.shakers.count > 2 * self.bays:
            yield "shakers.count", f"must not exceed the number of corners, {2 * self.bays}"

    @property
    def pieces(self) -> int:
        """Elements of a member without its fitting."""
        return LEVELS[self.level] if self.level else self.elements or 1


def _sine(bays: int) -> float:
    from math import pi, sin

    return sin(pi / bays)
