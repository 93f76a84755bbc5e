"""Functions of time as they stand in the case file: loads, drives, temperatures."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Annotated, Any, Generic, TypeVar

from pydantic import BeforeValidator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from coupling import histories, quantities
from coupling.errors import shown
from coupling.fields import (
    TEMPERATURE,
    PositiveTime,
    Quantity,
    Table,
    Time,
    fault,
    faults,
)
from coupling.quantities import Kind


def _pair(value: Any) -> Any:
    """Arrays of TOML are lists; a row of a table is a pair."""
    if not isinstance(value, list) or len(value) != 2:
        raise fault(f"expected a pair [x, y], got {shown(value)}")
    return tuple(value)


PAIR = BeforeValidator(_pair)
V = TypeVar("V", bound=float)  # a value
D = TypeVar("D", bound=float)  # a difference of values
R = TypeVar("R", bound=float)  # a rate of values


class RampTable(Table, Generic[V]):
    """A straight line between two times, constant before and after."""

    start: Time = Field(default=0.0, description="when it begins")
    end: PositiveTime = Field(description="when it ends")
    first: V = Field(alias="from", description="value before")
    last: V = Field(alias="to", description="value after")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.end <= self.start:
            yield "end", f"must come after the start at {self.start:g} s, got {self.end:g} s"

    def history(self) -> histories.History:
        return histories.Ramp(self.start, self.end, self.first, self.last)


class StepTable(Table, Generic[V]):
    """A sudden change."""

    at: Time = Field(description="when it changes")
    first: V = Field(alias="from", description="value before")
    last: V = Field(alias="to", description="value after")

    def history(self) -> histories.History:
        return histories.Step(self.at, self.first, self.last)


class SineTable(Table, Generic[V, D]):
    """offset + amplitude sin(2 pi frequency t + phase)."""

    amplitude: D = Field(description="largest deviation from the offset")
    frequency: Annotated[float, Quantity(quantities.FREQUENCY, above=0.0)] | None = Field(
        default=None, description="oscillations per second"
    )
    period: PositiveTime | None = Field(default=None, description="time of one oscillation")
    phase: Annotated[float, Quantity(quantities.ANGLE)] = Field(
        default=0.0, description="angle at t = 0"
    )
    offset: V = Field(description="mean value")

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"frequency", "period"}) != 1:
            yield "frequency", "give either a frequency or a period"

    def history(self) -> histories.History:
        frequency = 1.0 / self.period if self.period else self.frequency or 0.0
        return histories.Sine(self.amplitude, frequency, self.phase, self.offset)


class SCurveTable(Table, Generic[D, R]):
    """From 0 to a total, at a rate that rises and falls smoothly."""

    rate: R = Field(description="the constant rate in the middle")
    rise: PositiveTime = Field(description="time in which the rate rises, and falls at the end")
    total: D = Field(description="value that is reached")
    start: Time = Field(default=0.0, description="when it begins")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.rate == 0.0:
            yield "rate", "must not be zero"
        elif self.total / self.rate < self.rise:
            least = f"{self.rate * self.rise:g} in SI units, got {self.total:g}"
            yield "total", f"is reached before the rate has risen; it must be at least {least}"

    def history(self) -> histories.History:
        return histories.SCurve(self.rate, self.rise, self.total, self.start)


class HistoryTable(Table, Generic[V, D, R]):
    """A function of time: one of table, ramp, step, sine, s_curve."""

    table: list[Annotated[tuple[Time, V], PAIR]] | None = Field(
        default=None, description="[[time, value], ...], straight lines between"
    )
    ramp: RampTable[V] | None = None
    step: StepTable[V] | None = None
    sine: SineTable[V, D] | None = None
    s_curve: SCurveTable[D, R] | None = None

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys) != 1:
            yield "", f"expected one of {', '.join(cls.keys())}, got {len(keys)} keys"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        times = [row[0] for row in self.table or ()]
        if self.table == []:
            yield "table", "needs at least one row [time, value]"
        if any(later <= earlier for earlier, later in pairwise(times)):
            yield "table", "the times must increase from row to row"

    def history(self) -> histories.History:
        if self.table is not None:
            times, values = zip(*self.table, strict=True)
            return histories.Table(times, values)
        (shape,) = (x for x in (self.ramp, self.step, self.sine, self.s_curve) if x is not None)
        return shape.history()


def read_by(read: Callable[..., Any], tables: CoreSchema) -> CoreSchema:
    """What pydantic does with a field that ``read`` reads, and leaves as it is when dumping."""
    as_it_is = core_schema.plain_serializer_function_ser_schema(lambda value: value)
    return core_schema.no_info_wrap_validator_function(read, tables, serialization=as_it_is)


def either(value: Quantity, schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """JSON schema of a plain value or the table in its place."""
    number = value.__get_pydantic_json_schema__(schema, handler)
    return {"anyOf": [*number.get("anyOf", [number]), handler(schema["schema"])]}


@dataclass(frozen=True)
class HistoryOf:
    """A function of time: a constant, or a table with one of the shapes above."""

    value: Quantity
    difference: Kind
    rate: Kind

    def read(self, data: Any, validate: Any) -> histories.History:
        """The history in SI units."""
        if callable(data):
            return data
        if not isinstance(data, dict):
            return histories.Constant(self.value.read(data))
        if self.value.kind.absolute and "s_curve" in data:
            raise faults("history", {("s_curve",): "starts from zero; use a ramp for temperatures"})
        history = validate(data).history()
        if self.value.kind.absolute and history.bounds(inf)[0] <= 0.0:
            raise fault(f"falls to {history.bounds(inf)[0]:g} K; temperatures stay above 0 K")
        return history

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        shapes = HistoryTable[
            Annotated[float, self.value],
            Annotated[float, Quantity(self.difference)],
            Annotated[float, Quantity(self.rate)],
        ]
        tables = handler.generate_schema(shapes)
        return read_by(self.read, tables)

    def __get_pydantic_json_schema__(
        self, schema: Any, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return either(self.value, schema, handler)


OF_TEMPERATURE = HistoryOf(TEMPERATURE, quantities.DIFFERENCE, quantities.TEMPERATURE_RATE)
TemperatureHistory = Annotated[histories.History, OF_TEMPERATURE]
AngleHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.ANGLE), quantities.ANGLE, quantities.ANGULAR_SPEED),
]
LengthHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.LENGTH), quantities.LENGTH, quantities.SPEED),
]
FluxHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.HEAT_FLUX), quantities.HEAT_FLUX, quantities.HEAT_FLUX_RATE),
]
PowerHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.POWER), quantities.POWER, quantities.POWER_RATE),
]
FilmHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.FILM, least=0.0), quantities.FILM, quantities.FILM_RATE),
]
PressureHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.STRESS), quantities.STRESS, quantities.STRESS_RATE),
]
LineLoadHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.LINE_LOAD), quantities.LINE_LOAD, quantities.LINE_LOAD_RATE),
]
ForceHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.FORCE), quantities.FORCE, quantities.FORCE_RATE),
]
MomentHistory = Annotated[
    histories.History,
    HistoryOf(Quantity(quantities.MOMENT), quantities.MOMENT, quantities.MOMENT_RATE),
]


class EndsTable(Table):
    """Histories at both ends of a stretch."""

    start: TemperatureHistory = Field(description="temperature at the start of the stretch")
    end: TemperatureHistory = Field(description="temperature at the end of the stretch")


@dataclass(frozen=True)
class EndsOf:
    """One temperature history for a whole stretch, or one for each end: always a pair."""

    def read(self, data: Any, validate: Any) -> tuple[histories.History, histories.History]:
        """The histories at the start and at the end."""
        if isinstance(data, dict) and not data.keys().isdisjoint({"start", "end"}):
            ends = EndsTable.model_validate(data)
            return ends.start, ends.end
        history = validate(data)
        return history, history

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        whole = handler.generate_schema(TemperatureHistory)
        return read_by(self.read, whole)

    def __get_pydantic_json_schema__(
        self, schema: Any, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        whole = OF_TEMPERATURE.__get_pydantic_json_schema__(schema["schema"], handler)
        pair = {
            "type": "object",
            "properties": {"start": whole, "end": whole},
            "required": ["start", "end"],
            "additionalProperties": False,
        }
        return {"anyOf": [whole, pair]}


TemperatureEnds = Annotated[tuple[histories.History, histories.History], EndsOf()]
