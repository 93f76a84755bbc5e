"""Tables of the case file about joints without clearance."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.contact_tables import Loose
from coupling.fields import AngleOrLength, Direction, Quantity, Table, odd_angle
from coupling.functions import AngleHistory, LengthHistory
from coupling.site_tables import OnGround, Site
from coupling.spring_tables import Bushing, Pulley, Spring, TorsionSpring

ONE, OTHER = "one side, {body = ..., at = ...}", "other side; default: the ground"
AXIS = "direction at the start, in global coordinates"


class Clamp(Table):
    """Holds position and orientation."""

    kind: Literal["clamp"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)


class Spherical(Table):
    """Holds position, leaves orientation free."""

    kind: Literal["spherical"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)


class Revolute(Table):
    """Leaves free, or drives, the rotation about an axis."""

    kind: Literal["revolute"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)
    axis: Direction = Field(description=AXIS)
    angle: AngleHistory | None = Field(
        default=None, description="drives the rotation of a relative to b"
    )


class Universal(Table):
    """Holds position and the right angle between an axis of a and one of b."""

    kind: Literal["universal"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)
    axis_a: Direction = Field(description=f"fixed in a; {AXIS}")
    axis_b: Direction = Field(description=f"fixed in b; {AXIS}")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from odd_angle("axis_b", " to axis_a", self.axis_a, self.axis_b)


class Cylindrical(Table):
    """One side slides along an axis of the other and turns about it; either may be driven."""

    kind: Literal["cylindrical"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)
    axis: Direction = Field(description=AXIS)
    angle: AngleHistory | None = Field(default=None, description="drives the rotation")
    travel: LengthHistory | None = Field(default=None, description="drives the sliding")


class Prismatic(Table):
    """One side slides along an axis of the other without turning."""

    kind: Literal["prismatic"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)
    axis: Direction = Field(description=AXIS)
    travel: LengthHistory | None = Field(default=None, description="drives the sliding")


class Planar(Table):
    """One side moves in a plane of the other and turns about its normal."""

    kind: Literal["planar"]
    a: Site = Field(description=ONE)
    b: OnGround = Field(description=OTHER)
    normal: Direction = Field(description=AXIS)


class AxialDrive(Table):
    """Drives a point along an axis of the other side, like a lead screw; all else stays free."""

    kind: Literal["axial_drive"]
    a: Site = Field(description="the point, {body = ..., at = ...}")
    b: OnGround = Field(description="section with which the axis turns; default: the ground")
    axis: Direction = Field(description=AXIS)
    travel: LengthHistory | None = Field(
        default=None, description="way along the axis since the start; absent: it stays"
    )


class Distance(Table):
    """Keeps the distance between two points, or changes it as given."""

    kind: Literal["distance"]
    a: Site = Field(description="one point, {body = ..., at = ...}")
    b: Site = Field(description="other point, {body = ..., at = ...}")
    length: LengthHistory | None = Field(
        default=None, description="change of the distance since the start; absent: it stays"
    )


class Guide(Table):
    """Holds a point along fixed directions only, such as a plane of symmetry."""

    kind: Literal["guide"]
    a: Site = Field(description="the point, {body = ..., at = ...}")
    directions: list[Direction] = Field(
        description="one or two [x, y, z] at right angles, in which the point cannot move"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not 1 <= len(self.directions) <= 2:
            yield "directions", "expected one or two; three are a spherical joint"
        elif len(self.directions) == 2:
            yield from odd_angle("directions", "", *self.directions)


class Fixing(Table):
    """Holds a vector of a node along fixed directions: planes of symmetry, clamped slopes."""

    kind: Literal["fixing"]
    a: Site = Field(description="the node, {body = ..., at = ...} or a position on a shell")
    vector: Literal["position", "r_x", "r_y", "r_z", "r_u", "r_v", "r_uv", "r_n"] = Field(
        description="vector of the node: what there is depends on the elements"
    )
    directions: list[Direction] = Field(
        description="one to three [x, y, z], along which it keeps its value"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not 1 <= len(self.directions) <= 3:
            yield "directions", f"expected one to three, got {len(self.directions)}"


class Sliding(Table):
    """A point slides along the axis of a beam or cable that moves and bends."""

    kind: Literal["sliding"]
    a: Site = Field(description="the point that slides, {body = ..., at = ...}")
    body: str = Field(description="name of the [body.NAME] on which it slides")
    aligned: bool = Field(
        default=False, description="true: a also keeps the orientation of the section it passes"
    )
    travel: LengthHistory | None = Field(
        default=None, description="drives the way along the body since the start"
    )


class Gear(Table):
    """Couples the turns of two joints: turn of second = ratio * turn of first."""

    kind: Literal["gear"]
    first: str = Field(
        description="name of a revolute, clearance_revolute or cylindrical [joint.NAME]"
    )
    second: str = Field(description="name of another")
    ratio: Annotated[float, Quantity(quantities.NUMBER)] = Field(
        description="turn of second / turn of first; negative for wheels that mesh outside"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.ratio == 0.0:
            yield "ratio", "must not be zero"
        if self.first == self.second:
            yield "second", "is the same joint as first"


class Latch(Table):
    """Locks a revolute at an angle, or a prismatic joint at a stroke, once it gets there."""

    kind: Literal["latch"]
    joint: str = Field(
        description="name of a revolute, clearance_revolute or prismatic [joint.NAME]"
    )
    at: AngleOrLength = Field(
        description="angle or travel since the start, such as '90 deg' or '0.5 m'"
    )


Joint = (
    Clamp | Spherical | Revolute | Universal | Cylindrical | Prismatic | Planar | Distance | Guide
    | Fixing | Sliding | AxialDrive | Gear | Pulley | Latch | Spring | TorsionSpring | Bushing
    | Loose
)  # fmt: skip
