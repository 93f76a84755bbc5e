"""Tables of the case file about heat: materials and everything under [thermal]."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import (
    Count,
    Direction,
    Fraction,
    Length,
    PositiveMass,
    Quantity,
    Table,
    Temperature,
)
from coupling.functions import FluxHistory, PowerHistory, TemperatureEnds, TemperatureHistory
from coupling.histories import History
from coupling.laws import Law, LawOf


class MaterialTable(Table):
    """[material.NAME]: linear elastic, isotropic, conducting; properties may vary with T."""

    density: Annotated[float, Quantity(quantities.DENSITY, above=0.0)] = Field(
        description="a density such as '2700 kg/m^3'"
    )
    youngs_modulus: Annotated[Law, LawOf(Quantity(quantities.PRESSURE, above=0.0))] = Field(
        description="a modulus such as '69 GPa', or {table = ...}, or {polynomial = ...}"
    )
    poissons_ratio: Annotated[Law, LawOf(Quantity(quantities.NUMBER, above=-1, below=0.5))] = Field(
        description="a number between -1 and 0.5"
    )
    expansion: Annotated[Law, LawOf(Quantity(quantities.PER_KELVIN, above=-1.0, below=1.0))] = (
        Field(description="instantaneous expansion coefficient such as '23.1e-6 1/K'")
    )
    conductivity: Annotated[Law, LawOf(Quantity(quantities.CONDUCTIVITY, above=0.0))] = Field(
        description="a conductivity such as '167 W/m/K'"
    )
    heat_capacity: Annotated[Law, LawOf(Quantity(quantities.HEAT_CAPACITY, above=0.0))] = Field(
        description="a heat capacity such as '896 J/kg/K'"
    )
    source: str = Field(default="case file", description="where the data come from")


Ends = tuple[History, History]


class ThermalPlace(Table):
    """An end of a body, or a part."""

    body: str | None = Field(default=None, description="name of a [body.NAME]")
    at: Literal["start", "end"] | None = Field(default=None, description="which end of the body")
    part: str | None = Field(default=None, description="name of a [thermal.part.NAME]")

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if ("body" in keys) == ("part" in keys):
            yield "", "expected {body = ..., at = ...} or {part = ...}"
        elif "body" in keys and "at" not in keys:
            yield "at", "missing (which end of the body: 'start' or 'end')"
        elif "part" in keys and "at" in keys:
            yield "at", "does not go with part"


class Wall(Table):
    """Given temperatures of a body: hot on one side, cold on the other, and linear in between.

    Of a beam or cable on a stretch of it; of a shell everywhere, hot on the side of its normal.
    """

    body: str = Field(description="name of a [body.NAME]")
    start: Length | None = Field(
        default=None, description="distance from the start of the body; default: there"
    )
    end: Length | None = Field(default=None, description="default: the end of the body")
    side: Direction | None = Field(
        default=None,
        description="direction of the hot side; of a shell it is its normal, along u x v",
    )
    hot: TemperatureEnds | None = Field(
        default=None, description="a temperature or {start = ..., end = ...}"
    )
    cold: TemperatureEnds | None = Field(
        default=None, description="a temperature or {start = ..., end = ...}"
    )
    temperature: TemperatureEnds | None = Field(
        default=None, description="the same on all sides, instead of hot and cold"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if "temperature" in keys:
            for key in sorted({"hot", "cold", "side"} & keys):
                yield key, "does not go with temperature, which is the same on all sides"
            return
        for key in ("hot", "cold"):
            if key not in keys:
                yield key, "missing (give hot and cold, or a temperature)"

    @property
    def sides(self) -> tuple[Ends, Ends]:
        """Histories of the hot and of the cold side, each at the start and the end."""
        hot, cold = self.hot or self.temperature, self.cold or self.temperature
        assert hot is not None and cold is not None  # the table has both or a temperature
        return hot, cold


class Flux(Table):
    """Heat that falls on the outer face of a body."""

    body: str = Field(description="name of a [body.NAME]")
    density: FluxHistory = Field(description="a heat flux such as '1361 W/m^2', or its history")
    absorptivity: Fraction = Field(default=1.0, description="part that is absorbed, 0 to 1")
    direction: Direction | None = Field(
        default=None, description="of parallel rays; default: the same flux on every side"
    )


class Radiation(Table):
    """Grey radiation of the outer face of a body to its surroundings."""

    body: str = Field(description="name of a [body.NAME]")
    emissivity: Fraction = Field(description="0 to 1")
    sink: TemperatureHistory = Field(description="temperature of the surroundings")


class Fixed(Table):
    """A given temperature."""

    at: ThermalPlace = Field(description="{body = ..., at = ...} or {part = ...}")
    temperature: TemperatureHistory = Field(description="such as '20 degC', or its history")


class Source(Table):
    """Heat from outside."""

    at: ThermalPlace = Field(description="{body = ..., at = ...} or {part = ...}")
    power: PowerHistory = Field(description="such as '5 W', or its history")


class Part(Table):
    """A lump with one temperature, such as a journal or a bearing."""

    of: str | None = Field(
        default=None, description="'JOINT.journal' or 'JOINT.bearing' that it is"
    )
    material: str = Field(description="name in the library or of a [material.NAME]")
    mass: PositiveMass = Field(description="a mass such as '1.5 kg'")
    initial: Temperature | None = Field(default=None, description="default: thermal.initial")


class Link(Table):
    """A conductance between two places, or to a given temperature."""

    a: ThermalPlace = Field(description="{body = ..., at = ...} or {part = ...}")
    b: ThermalPlace | None = Field(
        default=None, description="{body = ..., at = ...} or {part = ...}"
    )
    temperature: TemperatureHistory | None = Field(default=None, description="given instead of b")
    conductance: Annotated[float, Quantity(quantities.CONDUCTANCE, above=0.0)] = Field(
        description="a conductance such as '2 W/K'"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"b", "temperature"}) != 1:
            yield "b", "give either b or a temperature"


class Thermal(Table):
    """[thermal]: present when the scene has heat."""

    solver: str = Field(default="line", description="'thermobody list' names them")
    initial: Temperature = Field(description="temperature at the start")
    wall_points: Annotated[int, Count(least=1, most=360)] = Field(
        default=4, description="temperatures around a section: 1, or an even number of 4 or more"
    )
    wall: dict[str, Wall] = Field(default_factory=dict)
    flux: dict[str, Flux] = Field(default_factory=dict)
    radiation: dict[str, Radiation] = Field(default_factory=dict)
    fixed: dict[str, Fixed] = Field(default_factory=dict)
    source: dict[str, Source] = Field(default_factory=dict)
    part: dict[str, Part] = Field(default_factory=dict)
    link: dict[str, Link] = Field(default_factory=dict)

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.wall_points != 1 and (self.wall_points < 4 or self.wall_points % 2):
            yield (
                "wall_points",
                f"must be 1, or an even number of 4 or more, got {self.wall_points}",
            )
