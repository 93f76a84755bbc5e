"""[generate.NAME] kind = "deployable_ring": a ring truss that deploys by a rope, and latches."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import (
    Count,
    PositiveLength,
    PositiveMass,
    PositiveTime,
    Quantity,
    Table,
    Time,
)
from coupling.generate_tables import Clearance, Shock
from meshes.deployable_ring import Form

Fraction = Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=1.0)]
Force = Annotated[float, Quantity(quantities.FORCE, above=0.0)]
Impulse = Annotated[float, Quantity(quantities.IMPULSE, least=0.0)]
Damping = Annotated[float, Quantity(quantities.DAMPING, least=0.0)]
Moment = Annotated[float, Quantity(quantities.MOMENT, least=0.0)]
TurnDamping = Annotated[float, Quantity(quantities.TURN_DAMPING, least=0.0)]
Length = Annotated[float, Quantity(quantities.LENGTH, least=0.0)]


class Rope(Table):
    """A rope through all diagonals, from post to post; it takes no pressure."""

    stiffness: Force | None = Field(
        default=None, description="EA; absent: its length is held, and it takes pressure"
    )
    damping: Impulse = Field(
        default=0.0, description="of a rope with a stiffness: force per relative rate of length"
    )


class Winch(Table):
    """Winds the rope in: chords rise at one angular acceleration, then slow down at the same.

    The angle goes from that at the start to the deployed ring and, by ``overrun``, beyond what
    latches allow: this much rope is stretched in the end.
    """

    start: Time = Field(default=0.0, description="when it begins")
    duration: PositiveTime = Field(description="how long it takes")
    overrun: Length = Field(default=0.0, description="rope wound in beyond the deployed length")
    points: Annotated[int, Count(least=2, most=100_000)] = Field(
        default=600, description="of the law, straight lines between"
    )


class Resistance(Table):
    """What the ring works against as it deploys: the mesh that it spans, friction, brakes.

    It acts at the foot of each post between the post and the chord after it.
    """

    moment: Moment = Field(default=0.0, description="constant; keeps the rope tight")
    damping: TurnDamping = Field(default=0.0, description="such as '100 N m s/rad'")


class Sliders(Table):
    """Play of the sliders in the tubes of the diagonals: four corners between two walls."""

    length: PositiveLength = Field(description="of a slider, along the tube")
    height: PositiveLength = Field(description="of a slider, across the tube in its panel")
    corner_radius: PositiveLength = Field(description="of its rounded corners")
    clearance: PositiveLength | None = Field(
        default=None, description="way to each wall; default: that of the revolutes"
    )
    pivots: TurnDamping | None = Field(
        default=None,
        description="resistance to turning of the joints at both ends of a diagonal, such as "
        "'10 kN m s/rad', which keeps its slider from rattling; absent: they turn freely",
    )
    press: Moment | None = Field(
        default=None,
        description="of a spiral spring at the foot of each diagonal, against deployment: it "
        "presses the slider to its tube; absent: sliders float in their play",
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if 2.0 * self.corner_radius > min(self.length, self.height):
            yield "corner_radius", "must not exceed half of the slider"


class Play(Clearance):
    """Play in the hinges of chords, each a pin in a wider bore, and in the sliders of diagonals.

    Journals are the ends of chords and the inner tubes; all are of the material of the members.
    """

    spherical: Literal[False] = Field(default=False, description="balls have no play here")
    mass: PositiveMass | None = Field(
        default=None,
        description="of each pin and of each bore; given: they are parts of [thermal], which take "
        "frictional heat and, in a shock, the temperature of their member",
    )
    sliders: Sliders | None = Field(default=None, description="absent: sliders without play")
    grease: Damping | None = Field(
        default=None,
        description="resistance of what fills the gap of a pin to motion across it, such as "
        "'1 kN s/m'; absent: they are dry",
    )


class WholeShock(Shock):
    """A temperature of the members of the whole ring, or of its half y > 0."""

    over: Literal["half", "ring"] = Field(
        default="half", description="half: the others keep the first temperature"
    )


class DeployableRing(Table):
    """A ring of panels that unfolds: hinged chords, sliding diagonals, wheels, rope and latches.

    Makes for each bay, from 0 on, the bodies chord_low_NN, chord_up_NN, batten_NN, outer_NN and
    inner_NN (the two tubes of a diagonal), and the joints CHORD_start and CHORD_end (revolutes),
    outer_NN_foot, inner_NN_head, slider_NN, gear_NN and latch_NN; one rope. A table of the case
    with one of these names changes what is made.
    """

    kind: Literal["deployable_ring"]
    bays: Annotated[int, Count(least=4, most=1000)] = Field(description="even number of panels")
    diameter: PositiveLength = Field(description="of the circle of the battens, deployed")
    height: PositiveLength = Field(description="of the battens")
    fraction: Fraction = Field(description="of the diameter that is deployed at the start")
    elements: Annotated[int, Count()] = Field(default=1, description="of each member")
    section: str = Field(description="name of a [section.NAME]: of chords and battens")
    outer_section: str = Field(description="of the outer tubes of the diagonals")
    inner_section: str = Field(description="of the inner tubes of the diagonals")
    material: str = Field(description="name in the library or of a [material.NAME]")
    damping: Time = Field(default=0.0, description="Kelvin-Voigt time")
    support: Literal["clamp", "none"] = Field(
        default="clamp", description="of the foot of the first batten"
    )
    gears: bool = Field(
        default=True, description="wheels at the feet of the battens, so that all panels move alike"
    )
    latches: bool = Field(
        default=True, description="which lock the lower chords when the ring is deployed"
    )
    rope: Rope | None = Field(default=None, description="absent: nothing drives the ring")
    winch: Winch | None = Field(default=None, description="absent: the rope keeps its length")
    resistance: Resistance | None = Field(default=None, description="absent: it moves freely")
    clearance: Play | None = Field(default=None, description="absent: joints without play")
    shock: WholeShock | None = Field(default=None, description="absent: no temperatures are given")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.bays % 2:
            yield "bays", "must be even: neighbouring panels fold in opposite senses"
        if self.winch is not None and self.rope is None:
            yield "winch", "needs a rope"

    @property
    def form(self) -> Form:
        """Shape of the ring."""
        return Form(self.bays, self.diameter, self.height)
