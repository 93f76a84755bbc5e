"""Tables of the case file about joints with clearance: contact and friction."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic_core import CoreSchema, core_schema

from coupling import quantities
from coupling.fields import Direction, PositiveLength, Quantity, Table, Temperature
from coupling.functions import AngleHistory
from coupling.site_tables import OnGround, Site


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
