"""Tables of the case file about the surfaces of shells."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Annotated, Any, Literal

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema

from coupling import quantities
from coupling.errors import alternatives, shown, suggestion
from coupling.fields import Axes, Count, Point, PositiveLength, Quantity, Table, fault, faults
from coupling.functions import PAIR, read_by

Angle = Annotated[float, Quantity(quantities.ANGLE, least=-2.0 * pi, most=2.0 * pi)]
Latitude = Annotated[float, Quantity(quantities.ANGLE, above=-0.5 * pi, below=0.5 * pi)]
Many = Annotated[int, Count(most=10_000)]
Grid = Annotated[tuple[Many, Many], PAIR]

ORIGIN = "of its own coordinates [x, y, z]"
AXES = "directions of its own x, y, z: two or three [x, y, z]"
FROM, TO = "angle at which it begins, from x towards y", "angle at which it ends"
STANDARD = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _odd_turn(start: float, end: float) -> Iterator[tuple[str, str]]:
    if not 0.0 < end - start <= 2.0 * pi * (1.0 + 1e-12):
        yield "end", "must be beyond the start, by a full turn at most"


class Plate(Table):
    """A rectangle from its origin along x and y; z is its normal."""

    kind: Literal["plate"]
    length: PositiveLength = Field(description="along x")
    width: PositiveLength = Field(description="along y")
    elements: Grid = Field(description="along x and along y")
    origin: Point = Field(default=(0.0, 0.0, 0.0), description=ORIGIN)
    axes: Axes = Field(default=STANDARD, description=AXES)


class TubeSurface(Table):
    """A circular cylinder along z, or a panel of one; the normal points outward."""

    kind: Literal["tube"]
    radius: PositiveLength = Field(description="of the middle surface")
    length: PositiveLength = Field(description="along z")
    start: Angle = Field(default=0.0, description=FROM)
    end: Angle = Field(default=2.0 * pi, description=TO)
    elements: Grid = Field(description="around and along")
    origin: Point = Field(default=(0.0, 0.0, 0.0), description=ORIGIN)
    axes: Axes = Field(default=STANDARD, description=AXES)

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _odd_turn(self.start, self.end)


class Annulus(Table):
    """A ring, or a sector of one, in the plane of x and y; a whole ring is slit along x."""

    kind: Literal["annulus"]
    inner_radius: PositiveLength = Field(description="of the hole")
    outer_radius: PositiveLength = Field(description="of the rim")
    start: Angle = Field(default=0.0, description=FROM)
    end: Angle = Field(default=2.0 * pi, description=TO)
    elements: Grid = Field(description="outward and around")
    origin: Point = Field(default=(0.0, 0.0, 0.0), description=ORIGIN)
    axes: Axes = Field(default=STANDARD, description=AXES)

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _odd_turn(self.start, self.end)
        if self.outer_radius <= self.inner_radius:
            yield "outer_radius", f"must exceed the inner one, {self.inner_radius:g} m"


class Sphere(Table):
    """A zone of a sphere between two latitudes; the normal points outward."""

    kind: Literal["sphere"]
    radius: PositiveLength = Field(description="of the middle surface")
    south: Latitude = Field(description="lower latitude, from the plane of x and y")
    north: Latitude = Field(description="upper latitude; the pole itself is no part of it")
    start: Angle = Field(default=0.0, description=FROM)
    end: Angle = Field(default=2.0 * pi, description=TO)
    elements: Grid = Field(description="around and towards the pole")
    origin: Point = Field(default=(0.0, 0.0, 0.0), description=ORIGIN)
    axes: Axes = Field(default=STANDARD, description=AXES)

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _odd_turn(self.start, self.end)
        if self.north <= self.south:
            yield "north", f"must be north of south, {self.south:g} rad"


SURFACES: dict[str, type[Table]] = {
    "plate": Plate,
    "tube": TubeSurface,
    "annulus": Annulus,
    "sphere": Sphere,
}


@dataclass(frozen=True)
class SurfaceOf:
    """One of the surfaces above, by its kind."""

    def read(self, data: Any, validate: Any) -> Any:
        """The table of that kind."""
        if isinstance(data, tuple(SURFACES.values())):
            return data
        if not isinstance(data, dict):
            raise fault(f"expected a table, got {shown(data)}")
        if "kind" not in data:
            raise faults("surface", {("kind",): f"missing ({alternatives(SURFACES)})"})
        kind = data["kind"]
        if kind not in SURFACES:
            text = f"expected {alternatives(SURFACES)}, got {shown(kind)}"
            raise faults("surface", {("kind",): text + suggestion(kind, SURFACES)})
        return SURFACES[kind].model_validate(data)

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return read_by(self.read, handler.generate_schema(source))

    def __get_pydantic_json_schema__(
        self, schema: Any, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return handler(schema["schema"])


AnySurface = Annotated[Plate | TubeSurface | Annulus | Sphere, SurfaceOf()]
