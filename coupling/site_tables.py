"""Tables of the case file that name a point: of a body, or of the ground."""

from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import Point, Quantity, Table

GROUND = "ground"
Place = Annotated[
    Literal["start", "end"] | float,
    Quantity(quantities.LENGTH, least=0.0, words=("start", "end")),
]


Edge = Literal["u-start", "u-end", "v-start", "v-end"]


class Site(Table):
    """A material point of a body, or a fixed point of the ground."""

    body: str = Field(description="name of a [body.NAME], or 'ground'")
    at: Place | None = Field(
        default=None,
        description="on a beam or cable: 'start', 'end' or the distance from the start along it",
    )
    position: Point | None = Field(
        default=None,
        description="point [x, y, z] at the start: of the ground (default: the other side), of a "
        "rigid body (default: its centre of mass), or the node of a shell that is there",
    )
    edge: Edge | None = Field(
        default=None,
        description="of a shell, instead of position: all nodes where u or v starts or ends",
    )
    offset: Point | None = Field(
        default=None,
        description="from there along e1, e2, e3 of the section (rigid: of the body), carried "
        "with it",
    )


OnGround = Annotated[Site, Field(default_factory=lambda: Site(body=GROUND))]
