"""Tables of the case file about what moves: sections, bodies, joints, loads, gravity."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field
from pydantic_core import CoreSchema, core_schema

from coupling import quantities
from coupling.fields import (
    Count,
    Direction,
    Point,
    PositiveLength,
    PositiveMass,
    Quantity,
    Table,
    Temperature,
    Time,
    Vector,
    Vector3,
)
from coupling.functions import AngleHistory, ForceHistory, MomentHistory

GROUND = "ground"
Velocity = Annotated[Vector3, Vector(quantities.SPEED)]
Spin = Annotated[Vector3, Vector(quantities.ANGULAR_SPEED)]
Place = Annotated[
    Literal["start", "end"] | float,
    Quantity(quantities.LENGTH, least=0.0, words=("start", "end")),
]


class Tube(Table):
    """A circular tube."""

    kind: Literal["tube"]
    mean_radius: PositiveLength = Field(description="radius of the middle of the wall")
    thickness: PositiveLength = Field(description="of the wall")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.thickness >= 2.0 * self.mean_radius:
            yield "thickness", "must be less than twice the mean radius"


class Circle(Table):
    """A solid circle."""

    kind: Literal["circle"]
    radius: PositiveLength = Field(description="a length such as '5 mm'")


class Rectangle(Table):
    """A solid rectangle."""

    kind: Literal["rectangle"]
    height: PositiveLength = Field(description="extent along the normal of the body")
    width: PositiveLength = Field(description="extent across the normal of the body")


SecondMoment = Annotated[float, Quantity(quantities.SECOND_MOMENT, above=0.0)]
ShearFactor = Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=10.0)]


class GeneralSection(Table):
    """A section given by its numbers."""

    kind: Literal["general"]
    area: Annotated[float, Quantity(quantities.AREA, above=0.0)] = Field(
        description="an area such as '5 cm^2'"
    )
    second_moment_2: SecondMoment = Field(description="integral of y^2, y along the normal")
    second_moment_3: SecondMoment = Field(description="integral of z^2, z across the normal")
    torsion_constant: SecondMoment = Field(description="Saint-Venant's, such as '12 cm^4'")
    shear_factor_2: ShearFactor = Field(default=5 / 6, description="along the normal")
    shear_factor_3: ShearFactor = Field(default=5 / 6, description="across the normal")
    outer_perimeter: PositiveLength | None = Field(
        default=None,
        description="what exchanges heat; default: of the rectangle with the same moments",
    )


class LineBody(Table):
    """A flexible body along a line, straight from start to end or a line mesh from a file.

    A beam shears, bends and twists; a cable stretches and bends.
    """

    kind: Literal["beam", "cable"]
    start: Point | None = Field(default=None, description="first end [x, y, z]")
    end: Point | None = Field(default=None, description="other end [x, y, z]")
    elements: Annotated[int, Count()] | None = Field(default=None, description="number of elements")
    mesh: str | None = Field(
        default=None, description="file with a line mesh instead, relative to the case folder"
    )
    region: str | None = Field(default=None, description="named region of the mesh file")
    normal: Direction | None = Field(
        default=None,
        description="of a beam: direction of the section's height; default: any across it",
    )
    section: str = Field(description="name of a [section.NAME]")
    material: str = Field(description="name in the library or of a [material.NAME]")
    damping: Time = Field(default=0.0, description="Kelvin-Voigt time")
    reference_temperature: Temperature | None = Field(
        default=None, description="free of thermal strain; default: thermal.initial, else 20 degC"
    )
    velocity: Velocity = Field(default=(0.0, 0.0, 0.0), description="initial rigid velocity")
    spin: Spin = Field(
        default=(0.0, 0.0, 0.0), description="initial rigid rotation about the origin"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        straight = {"start", "end", "elements"}
        if "mesh" in keys:
            for key in sorted(straight & keys):
                yield key, "does not go with mesh: give one or the other"
        else:
            if "region" in keys:
                yield "region", "belongs to a mesh, and there is none"
            for key in sorted(straight - keys):
                yield key, f"missing ({cls.model_fields[key].description})"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.normal and self.kind == "cable":
            yield "normal", "does not go with a cable: it does not twist"
        if not (self.start and self.end):
            return
        along = np.subtract(self.end, self.start)
        length = np.linalg.norm(along)
        if length <= 1e-12 * max(1.0, *np.abs(self.start), *np.abs(self.end)):
            yield "end", "is the same point as start: the body has no length"
        elif self.normal and np.linalg.norm(np.cross(along, self.normal)) <= 1e-6 * length:
            yield "normal", "must not be parallel to the body"


class Particle(Table):
    """A point mass."""

    kind: Literal["particle"]
    position: Point = Field(description="where it is at the start [x, y, z]")
    mass: PositiveMass = Field(description="a mass such as '1 kg'")
    velocity: Velocity = Field(default=(0.0, 0.0, 0.0), description="at the start")


class Site(Table):
    """A point of a body, or of the ground."""

    body: str = Field(description="name of a [body.NAME], or 'ground'")
    at: Place | None = Field(
        default=None,
        description="'start', 'end' or the distance from the start along the body to a node",
    )
    position: Point | None = Field(
        default=None, description="for the ground only; default: the other side"
    )


OnGround = Annotated[Site, Field(default_factory=lambda: Site(body=GROUND))]


class Clamp(Table):
    """Holds position and orientation."""

    kind: Literal["clamp"]
    a: Site = Field(description="one side, {body = ..., at = ...}")
    b: OnGround = Field(description="other side; default: the ground")


class Spherical(Table):
    """Holds position, leaves orientation free."""

    kind: Literal["spherical"]
    a: Site = Field(description="one side, {body = ..., at = ...}")
    b: OnGround = Field(description="other side; default: the ground")


class Revolute(Table):
    """Leaves free, or drives, the rotation about an axis."""

    kind: Literal["revolute"]
    a: Site = Field(description="one side, {body = ..., at = ...}")
    b: OnGround = Field(description="other side; default: the ground")
    axis: Direction = Field(description="direction at the start, in global coordinates")
    angle: AngleHistory | None = Field(
        default=None, description="drives the rotation of a relative to b"
    )


class Distance(Table):
    """Keeps the distance between two points."""

    kind: Literal["distance"]
    a: Site = Field(description="one point, {body = ..., at = ...}")
    b: Site = Field(description="other point, {body = ..., at = ...}")


class StiffnessValue:
    """A contact stiffness, whose unit depends on the law: pydantic annotation."""

    def read(self, value: Any, info: Any) -> float:
        """The stiffness in SI units."""
        linear = info.data.get("stiffness") == "linear"
        kind = quantities.STIFFNESS if linear else quantities.HERTZ_STIFFNESS
        return Quantity(kind, above=0.0).read(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return Quantity(quantities.STIFFNESS, above=0.0).__get_pydantic_json_schema__(
            schema, handler
        )


class Contact(Table):
    """Normal law of a clearance joint."""

    stiffness: Literal["hertz-external", "hertz-internal", "linear"] = Field(
        default="hertz-external",
        description="-external: radii as in the paper; -internal: pin in a bore",
    )
    value: Annotated[float, StiffnessValue()] | None = Field(
        default=None,
        description="[N/m] if linear, else [N/m^1.5]; default: Hertz from radii, materials",
    )
    restitution: Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=1.0)] = Field(
        default=0.85, description="speed after an impact / speed before"
    )
    dissipation: str = Field(
        default="exact", description="hysteresis law; 'thermobody list' names them"
    )
    reference_speed: Annotated[float, Quantity(quantities.SPEED, above=0.0)] | None = Field(
        default=None, description="approach speed; default: detected for each impact"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.stiffness == "linear" and self.value is None:
            yield "value", "missing (a linear contact needs a stiffness such as '1e6 N/m')"


class Friction(Table):
    """Regularised Coulomb friction, mu = coefficient (1 + slope (T - reference))."""

    coefficient: Annotated[float, Quantity(quantities.NUMBER, least=0.0, most=10.0)] = Field(
        description="at the reference temperature"
    )
    temperature_slope: Annotated[float, Quantity(quantities.PER_KELVIN)] = Field(
        default=0.0, description="relative change per kelvin"
    )
    reference_temperature: Temperature = Field(
        default=298.15, description="where the coefficient holds"
    )
    regularisation_speed: Annotated[float, Quantity(quantities.SPEED, above=0.0)] = Field(
        default=1e-4, description="slip speed at which half of the friction acts"
    )
    partition: Literal["effusivity", "product"] = Field(
        default="effusivity", description="how frictional heat divides between the two sides"
    )


class ClearanceRevolute(Table):
    """A pin in a bore that is a little wider."""

    kind: Literal["clearance_revolute"]
    journal: Site = Field(description="the pin, {body = ..., at = ...}")
    bearing: OnGround = Field(description="the bore; default: the ground")
    axis: Direction = Field(description="direction at the start, in global coordinates")
    radius: PositiveLength = Field(description="of the journal")
    clearance: PositiveLength = Field(description="radius of the bearing - radius of the journal")
    journal_material: str = Field(description="name in the library or of a [material.NAME]")
    bearing_material: str = Field(description="name in the library or of a [material.NAME]")
    reference_temperature: Temperature | None = Field(
        default=None,
        description="at which the clearance holds; default: thermal.initial, else 20 degC",
    )
    contact: Contact = Field(default_factory=Contact, description="normal law")
    friction: Friction | None = Field(default=None, description="absent: no friction")
    angle: AngleHistory | None = Field(
        default=None, description="drives the journal in the bearing"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.clearance >= self.radius:
            yield "clearance", f"must be below the journal radius, {self.radius:g} m"


class ForceLoad(Table):
    """A force that keeps its direction."""

    kind: Literal["force"]
    at: Site = Field(description="where it acts, {body = ..., at = ...}")
    direction: Direction = Field(description="[x, y, z] of any length")
    amplitude: ForceHistory = Field(description="a force such as '10 N', or a function of time")


class MomentLoad(Table):
    """A moment that keeps its direction."""

    kind: Literal["moment"]
    at: Site = Field(description="where it acts, {body = ..., at = ...}")
    direction: Direction = Field(description="[x, y, z] of any length")
    amplitude: MomentHistory = Field(description="a moment such as '1 N m', or a function of time")


class Gravity(Table):
    """[gravity]"""

    acceleration: Annotated[Vector3, Vector(quantities.ACCELERATION)] = Field(
        description="[x, y, z] such as [0, 0, '-9.81 m/s^2']"
    )


Section = Tube | Circle | Rectangle | GeneralSection
Body = LineBody | Particle
Joint = Clamp | Spherical | Revolute | Distance | ClearanceRevolute
Load = ForceLoad | MomentLoad
