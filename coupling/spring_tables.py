"""Tables of the case file about springs, dampers, bushings and ropes, under [joint.NAME]."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import Axes, PositiveLength, Quantity, Table
from coupling.functions import ForceHistory, LengthHistory, MomentHistory
from coupling.site_tables import OnGround, Site

Stiffness = Annotated[float, Quantity(quantities.STIFFNESS, least=0.0)]
Damping = Annotated[float, Quantity(quantities.DAMPING, least=0.0)]
TurnStiffness = Annotated[float, Quantity(quantities.TURN_STIFFNESS, least=0.0)]
TurnDamping = Annotated[float, Quantity(quantities.TURN_DAMPING, least=0.0)]
Angle = Annotated[float, Quantity(quantities.ANGLE)]


class Spring(Table):
    """Spring, damper and actuator along the line between two points."""

    kind: Literal["spring"]
    a: Site = Field(description="one point, {body = ..., at = ...}")
    b: Site = Field(description="other point, {body = ..., at = ...}")
    stiffness: Stiffness = Field(default=0.0, description="such as '100 N/m'")
    damping: Damping = Field(default=0.0, description="such as '5 N s/m'")
    length: PositiveLength | None = Field(
        default=None, description="free of force; default: as it is at the start"
    )
    preload: Annotated[float, Quantity(quantities.FORCE)] = Field(
        default=0.0, description="tension, added"
    )
    force: ForceHistory | None = Field(default=None, description="tension of an actuator, added")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not (self.stiffness or self.damping or self.preload or self.force):
            yield "stiffness", "missing: without it, damping, preload and force it does nothing"


class TorsionSpring(Table):
    """Spring, damper and motor on the turn of a revolute or cylindrical joint."""

    kind: Literal["torsion_spring"]
    joint: str = Field(description="name of a revolute or cylindrical [joint.NAME]")
    stiffness: TurnStiffness = Field(default=0.0, description="such as '10 N m/rad'")
    damping: TurnDamping = Field(default=0.0, description="such as '0.1 N m s/rad'")
    angle: Angle = Field(default=0.0, description="free of moment, since the start")
    preload: Annotated[float, Quantity(quantities.MOMENT)] = Field(
        default=0.0, description="moment that drives the turn, added"
    )
    torque: MomentHistory | None = Field(default=None, description="moment of a motor, added")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not (self.stiffness or self.damping or self.preload or self.torque):
            yield "stiffness", "missing: without it, damping, preload and torque it does nothing"


class Bushing(Table):
    """Elastic connection of two sections at one point."""

    kind: Literal["bushing"]
    a: Site = Field(description="one side, {body = ..., at = ...}")
    b: OnGround = Field(description="other side; default: the ground")
    axes: Axes = Field(
        default=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        description="its directions at the start, two or three at right angles; they move with b",
    )
    stiffness: list[Stiffness] = Field(description="along the three axes")
    turn_stiffness: list[TurnStiffness] = Field(
        default=[0.0, 0.0, 0.0], description="about the three axes"
    )
    damping: list[Damping] = Field(default=[0.0, 0.0, 0.0], description="along the three axes")
    turn_damping: list[TurnDamping] = Field(
        default=[0.0, 0.0, 0.0], description="about the three axes"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        for key in ("stiffness", "turn_stiffness", "damping", "turn_damping"):
            if len(getattr(self, key)) != 3:
                yield key, f"expected three numbers, got {len(getattr(self, key))}"


class Pulley(Table):
    """A rope whose path leads through points, without friction there."""

    kind: Literal["pulley"]
    points: list[Site] = Field(description="two or more [{body = ..., at = ...}, ...] in order")
    stiffness: Annotated[float, Quantity(quantities.FORCE, above=0.0)] | None = Field(
        default=None,
        description="EA of the rope, which takes no pressure; absent: its length is held",
    )
    damping: Annotated[float, Quantity(quantities.IMPULSE, least=0.0)] = Field(
        default=0.0, description="of a rope with a stiffness: force per relative rate of length"
    )
    length: PositiveLength | None = Field(
        default=None, description="free of force; default: as it is at the start"
    )
    winch: LengthHistory | None = Field(default=None, description="rope paid out since the start")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if len(self.points) < 2:
            yield "points", "a rope needs two points or more"
        for key, given in (("damping", self.damping), ("length", self.length)):
            if given and self.stiffness is None:
                yield key, "belongs to a stiffness: without one the rope keeps its length"
