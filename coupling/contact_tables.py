"""Tables of the case file about joints with clearance: their shapes, normal laws and friction."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic_core import CoreSchema, core_schema

from coupling import quantities
from coupling.errors import alternatives
from coupling.fields import (
    Count,
    Direction,
    PositiveLength,
    Quantity,
    Table,
    Temperature,
    odd_angle,
)
from coupling.functions import PAIR, AngleHistory
from coupling.site_tables import OnGround, Site

LEAST_EXACT = 0.01
"""Least restitution for which the exact hysteresis law is known [-]."""
FRICTION_LAWS: dict[str, tuple[str, ...]] = {
    "regularised": ("regularisation_speed",),
    "stick": ("static_coefficient", "presliding", "bristle_damping", "viscous"),
    "stribeck": ("static_coefficient", "regularisation_speed", "stribeck_speed", "viscous"),
    "lugre": ("static_coefficient", "presliding", "bristle_damping", "stribeck_speed", "viscous"),
    "rising": (
        *("static_coefficient", "presliding", "bristle_damping", "viscous"),
        *("rise_rate", "rise_exponent"),
    ),
}
"""Friction laws, and the keys that belong to some of them only."""
BRISTLES = ("stick", "lugre", "rising")
"""Laws whose contacts stick by bristles, which need a coefficient to bear against."""

Factor = Annotated[float, Quantity(quantities.NUMBER, least=0.0, most=100.0)]
Coefficient = Annotated[float, Quantity(quantities.NUMBER, least=0.0, most=10.0)]
Speed = Annotated[float, Quantity(quantities.SPEED, above=0.0)]
PerSpeed = Annotated[float, Quantity(quantities.PER_SPEED, least=0.0)]

JOURNAL, BEARING = "{body = ..., at = ...}", "default: the ground"
AXIS = "direction at the start, in global coordinates"
MATERIAL = "name in the library or of a [material.NAME]"
HOLDS_AT = "at which the clearance holds; default: thermal.initial, else 20 degC"


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
    """Normal law of a joint with clearance, of the whole joint."""

    stiffness: Literal["hertz-external", "hertz-internal", "cylinder", "linear"] = Field(
        default="hertz-external",
        description="-external: radii as in the paper; -internal: pin in a bore; cylinder: "
        "conformal, of joints with a bore that has a length, and of telescopes",
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
    reference_speed: Speed | None = Field(
        default=None, description="approach speed; default: detected for each impact"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.stiffness == "linear" and self.value is None:
            yield "value", "missing (a linear contact needs a stiffness such as '1e6 N/m')"
        if self.stiffness == "cylinder" and self.value is not None:
            yield "value", "does not go with 'cylinder', which takes materials, radii and length"
        if self.dissipation == "exact" and self.restitution < LEAST_EXACT:
            text = f"must be at least {LEAST_EXACT:g} with dissipation 'exact'"
            yield "restitution", f"{text}, got {self.restitution:g}"


class Friction(Table):
    """Friction; both coefficients change with the mean temperature of the two sides."""

    coefficient: Coefficient = Field(description="kinetic, at the reference temperature")
    law: Literal["regularised", "stick", "stribeck", "lugre", "rising"] = Field(
        default="regularised",
        description="regularised: Coulomb, creeps; stick: Coulomb with true stick; stribeck: "
        "regularised, falls with speed; lugre: bristles that slip; rising: stick whose bound "
        "grows with its duration",
    )
    static_coefficient: Coefficient | None = Field(
        default=None, description="of all laws but regularised; default: the kinetic one"
    )
    temperature_slope: Annotated[float, Quantity(quantities.PER_KELVIN)] = Field(
        default=0.0, description="relative change of the coefficients per kelvin"
    )
    reference_temperature: Temperature = Field(
        default=298.15, description="where the coefficients hold"
    )
    table: list[Annotated[tuple[Temperature, Factor], PAIR]] | None = Field(
        default=None,
        description="instead of a slope: [[temperature, factor], ...] of the coefficients, "
        "straight lines between, constant beyond",
    )
    regularisation_speed: Speed = Field(
        default=1e-4,
        description="of regularised and stribeck: slip speed at which half of the friction acts",
    )
    stribeck_speed: Speed = Field(
        default=1e-3,
        description="of stribeck and lugre: where the fall from the static coefficient is 63 %",
    )
    viscous: PerSpeed = Field(
        default=0.0, description="of all laws but regularised: viscous part over normal force"
    )
    presliding: PositiveLength = Field(
        default=1e-7, description="of stick, lugre, rising: deflection at which a contact slips"
    )
    bristle_damping: PerSpeed = Field(
        default=0.0, description="of stick, lugre, rising: over normal force"
    )
    rise_rate: Annotated[float, Quantity(quantities.NUMBER, above=0.0)] = Field(
        default=0.570, description="of rising: 1/s to the power rise_exponent"
    )
    rise_exponent: Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=5.0)] = Field(
        default=0.629, description="of rising: power m of static - (static - kinetic) e^(-rate t^m)"
    )
    partition: Literal["effusivity", "product"] = Field(
        default="effusivity", description="how frictional heat divides between the two sides"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from self._strange_keys()
        yield from self._static()
        if self.law in BRISTLES and self.coefficient == 0.0:
            text = f"must be above 0 with law = '{self.law}'; without friction leave out the table"
            yield "coefficient", text
        if self.table is not None:
            yield from self._table(self.table)

    def _strange_keys(self) -> Iterator[tuple[str, str]]:
        """Keys that are given and that the law would not use."""
        some = dict.fromkeys(key for keys in FRICTION_LAWS.values() for key in keys)
        for key in some:
            if key in self.model_fields_set and key not in FRICTION_LAWS[self.law]:
                users = alternatives([law for law, keys in FRICTION_LAWS.items() if key in keys])
                yield key, f"belongs to law = {users}, and this one is '{self.law}'"

    def _static(self) -> Iterator[tuple[str, str]]:
        if self.static_coefficient is None:
            if self.law in ("stribeck", "rising"):
                yield "static_coefficient", f"missing (law = '{self.law}' goes between the two)"
            elif self.law == "lugre" and "stribeck_speed" in self.model_fields_set:
                text = "needs a static_coefficient, from which friction falls with speed"
                yield "stribeck_speed", text
        elif self.law != "regularised" and self.static_coefficient < self.coefficient:
            text = f"must not be below the kinetic coefficient, {self.coefficient:g}"
            yield "static_coefficient", f"{text}, got {self.static_coefficient:g}"

    def _table(self, rows: list[tuple[float, float]]) -> Iterator[tuple[str, str]]:
        if len(rows) < 2:
            yield "table", "needs two or more rows [temperature, factor]"
        if any(later[0] <= earlier[0] for earlier, later in pairwise(rows)):
            yield "table", "the temperatures must increase from row to row"
        for key in ("temperature_slope", "reference_temperature"):
            if key in self.model_fields_set:
                yield key, "does not go with a table, which has temperatures of its own"


class _Loose(Table):
    """What all joints with clearance have."""

    reference_temperature: Temperature | None = Field(default=None, description=HOLDS_AT)
    contact: Contact = Field(default_factory=Contact, description="normal law")
    friction: Friction | None = Field(default=None, description="absent: no friction")


class _Sided(_Loose):
    """A journal in a bearing."""

    journal_material: str = Field(description=MATERIAL)
    bearing_material: str = Field(description=MATERIAL)


def _wide(clearance: float, size: float, of: str) -> Iterator[tuple[str, str]]:
    if clearance >= size:
        yield "clearance", f"must be below {of}, {size:g} m"


class ClearanceRevolute(_Sided):
    """A pin in a bore that is a little wider: planar, or in space where it has a length."""

    kind: Literal["clearance_revolute"]
    journal: Site = Field(description=f"the pin, {JOURNAL}")
    bearing: OnGround = Field(description=f"the bore; {BEARING}")
    axis: Direction = Field(description=AXIS)
    radius: PositiveLength = Field(description="of the journal")
    clearance: PositiveLength = Field(description="radius of the bearing - radius of the journal")
    length: PositiveLength | None = Field(
        default=None,
        description="of the bore: the pin tilts and touches at both ends; absent: planar, the pin "
        "is held along the axis and does not tilt",
    )
    axial_clearance: PositiveLength | None = Field(
        default=None,
        description="with a length: way to each of the two flanges; absent: free along the axis",
    )
    flange_radius: PositiveLength | None = Field(
        default=None, description="with an axial_clearance: where flanges touch; default: 1.5 radii"
    )
    angle: AngleHistory | None = Field(
        default=None, description="drives the journal in the bearing"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _wide(self.clearance, self.radius, "the journal radius")
        if self.contact.stiffness == "cylinder" and self.length is None:
            text = "'cylinder' needs the length of the bore: give the joint a length"
            yield "contact.stiffness", f"{text}, which makes it spatial, or take a Hertz stiffness"
        if self.axial_clearance is not None and self.length is None:
            yield "axial_clearance", "needs a length; without one the pin is held along the axis"
        if self.flange_radius is not None:
            yield from self._flange(self.flange_radius)

    def _flange(self, radius: float) -> Iterator[tuple[str, str]]:
        bore = self.radius + self.clearance
        if self.axial_clearance is None:
            yield "flange_radius", "needs an axial_clearance; without one there are no flanges"
        elif radius <= bore:
            yield "flange_radius", f"must exceed the radius of the bore, {bore:g} m"


class ClearanceSpherical(_Sided):
    """A ball in a socket that is a little wider."""

    kind: Literal["clearance_spherical"]
    journal: Site = Field(description=f"the ball, {JOURNAL}")
    bearing: OnGround = Field(description=f"the socket; {BEARING}")
    radius: PositiveLength = Field(description="of the ball")
    clearance: PositiveLength = Field(description="radius of the socket - radius of the ball")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _wide(self.clearance, self.radius, "the radius of the ball")
        if self.contact.stiffness == "cylinder":
            yield "contact.stiffness", "a ball is no cylinder; take 'hertz-internal'"


class ClearanceCylindrical(_Sided):
    """A rod in a bush that is a little wider: it slides, turns, tilts."""

    kind: Literal["clearance_cylindrical"]
    journal: Site = Field(description=f"the rod, {JOURNAL}")
    bearing: OnGround = Field(description=f"the bush; {BEARING}")
    axis: Direction = Field(description=AXIS)
    radius: PositiveLength = Field(description="of the rod")
    clearance: PositiveLength = Field(description="radius of the bush - radius of the rod")
    length: PositiveLength = Field(description="of the bush, at whose ends the rod touches")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _wide(self.clearance, self.radius, "the radius of the rod")


class ClearanceTranslational(_Sided):
    """A slider between the walls of a guide, which its corners touch."""

    kind: Literal["clearance_translational"]
    journal: Site = Field(description=f"centre of the slider, {JOURNAL}")
    bearing: OnGround = Field(description=f"the guide; {BEARING}")
    axis: Direction = Field(description=f"of the guide; {AXIS}")
    normal: Direction = Field(description=f"of the walls across the height; {AXIS}")
    length: PositiveLength = Field(description="of the slider, along the axis")
    height: PositiveLength = Field(description="of the slider, along the normal")
    clearance: PositiveLength = Field(description="way to each wall")
    width: PositiveLength | None = Field(
        default=None,
        description="of the slider, across axis and normal: 8 corners, 4 walls; absent: planar, 4 "
        "corners and 2 walls, held in the plane of axis and normal",
    )
    corner_radius: PositiveLength | None = Field(
        default=None, description="of the rounded corners, for a Hertz stiffness from materials"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from odd_angle("normal", " to axis", self.axis, self.normal)
        yield from _wide(self.clearance, 0.5 * self.height, "half of the height")
        if self.width is not None:
            yield from _wide(self.clearance, 0.5 * self.width, "half of the width")
        yield from self._corners()

    def _corners(self) -> Iterator[tuple[str, str]]:
        law = self.contact
        if law.stiffness in ("cylinder", "hertz-internal"):
            text = "corners touch plane walls; take 'hertz-external' or 'linear'"
            yield "contact.stiffness", text
        elif law.value is None and self.corner_radius is None and law.stiffness != "linear":
            text = "missing (a Hertz stiffness needs it; or give contact.value)"
            yield "corner_radius", text
        elif law.value is not None and self.corner_radius is not None:
            yield "corner_radius", "is not used: contact.value is given"
        smallest = min(x for x in (self.length, self.height, self.width) if x is not None)
        if self.corner_radius is not None and 2.0 * self.corner_radius > smallest:
            yield "corner_radius", f"must not exceed half of the slider, {0.5 * smallest:g} m"


class Preload(Table):
    """Rings of sprung rollers or pads, at the mouth and at the end of the inner tube inside."""

    force: Annotated[float, Quantity(quantities.FORCE, above=0.0)] = Field(
        description="sum of what the pads of one ring press with, tubes concentric"
    )
    stiffness: Annotated[float, Quantity(quantities.STIFFNESS, above=0.0)] = Field(
        description="of one ring sideways"
    )


class Telescope(_Loose):
    """A tube in a tube: both bend, and the places where they touch travel."""

    kind: Literal["telescope"]
    inner: str = Field(description="name of the [body.NAME] of the tube inside, a beam")
    outer: str = Field(description="name of the [body.NAME] around it, a beam")
    mouth: Literal["start", "end"] = Field(
        default="end", description="end of the outer tube through which the inner one leaves it"
    )
    radius: PositiveLength = Field(description="outer radius of the inner tube")
    clearance: PositiveLength = Field(description="inner radius of the outer tube - radius")
    stations: Annotated[int, Count(least=0, most=1000)] = Field(
        default=0, description="places of contact within each element of the inner tube"
    )
    preload: Preload | None = Field(default=None, description="absent: the walls alone guide")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from _wide(self.clearance, self.radius, "the radius of the inner tube")
        if self.inner == self.outer:
            yield "outer", "is the inner tube as well; expected another body"


Sided = ClearanceRevolute | ClearanceSpherical | ClearanceCylindrical | ClearanceTranslational
"""A journal in a bearing, each of which may be a part of the heat."""
Loose = Sided | Telescope
"""Every joint with clearance."""
