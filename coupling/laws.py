"""Material properties as they stand in the case file: functions of temperature."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Annotated, Any, Generic

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema

from coupling import quantities
from coupling.fields import Path, Quantity, Table, Temperature, faults
from coupling.functions import PAIR, V, either, read_by
from coupling.quantities import Kind


@dataclass(frozen=True)
class Law:
    """A material property as data, in SI units: a table, or else a polynomial.

    temperatures : floats [K]  of a table; empty for a polynomial
    values : floats  of the table, or coefficients of (T - reference)**i, constant first
    lower, upper : float [K]  range of a polynomial
    """

    values: tuple[float, ...]
    temperatures: tuple[float, ...] = ()
    reference: float = 0.0
    lower: float = -inf
    upper: float = inf
    source: str = "case file"

    def property(self, name: str, unit: str) -> Any:
        """The ``meshes.materials.Property`` that it describes."""
        from meshes import materials

        if self.temperatures:
            return materials.table(name, unit, self.temperatures, self.values, self.source)
        return materials.polynomial(
            name, unit, self.values, self.reference, self.lower, self.upper, self.source
        )


class LawTable(Table, Generic[V]):
    """A property that depends on temperature: one of value, table, polynomial."""

    value: V | None = Field(default=None, description="the same at all temperatures")
    table: list[Annotated[tuple[Temperature, V], PAIR]] | None = Field(
        default=None, description="[[temperature, value], ...], straight lines between"
    )
    polynomial: list[Any] | None = Field(
        default=None, description="coefficients of (T - reference)^i, constant first"
    )
    reference: Temperature = Field(
        default=298.15, description="temperature that a polynomial starts from"
    )
    range: Annotated[tuple[Temperature, Temperature], PAIR] | None = Field(
        default=None, description="[lowest, highest] temperature of the polynomial's data"
    )
    source: str = Field(default="case file", description="where the data come from")

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"value", "table", "polynomial"}) != 1:
            yield "", "expected one of value, table, polynomial"
        if "polynomial" in keys and "range" not in keys:
            yield "range", "missing (a polynomial needs the temperatures between which it holds)"
        for key in sorted(keys & {"range", "reference"}):
            if "polynomial" not in keys:
                yield key, "belongs to a polynomial only"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        temperatures = [row[0] for row in self.table or ()]
        if self.table is not None and len(temperatures) < 2:
            yield "table", "needs two or more rows [temperature, value]"
        if any(later <= earlier for earlier, later in pairwise(temperatures)):
            yield "table", "the temperatures must increase from row to row"
        if self.polynomial == []:
            yield "polynomial", "needs at least one coefficient"
        if self.range and self.range[0] >= self.range[1]:
            yield "range", "must go from a lower to a higher temperature"


@dataclass(frozen=True)
class LawOf:
    """A material property: a constant, or a table with one of the forms above."""

    value: Quantity

    def read(self, data: Any, validate: Any) -> Law:
        """The law in SI units."""
        if not isinstance(data, dict):
            return Law((self.value.read(data),))
        form = validate(data)
        if form.table is not None:
            temperatures, values = zip(*form.table, strict=True)
            return Law(values, temperatures, source=form.source)
        if form.polynomial is None:
            return Law((form.value,), source=form.source)
        coefficients = self._coefficients(form.polynomial)
        lower, upper = form.range
        return Law(coefficients, (), form.reference, lower, upper, form.source)

    def _coefficients(self, written: list[Any]) -> tuple[float, ...]:
        found: dict[Path, str] = {}
        numbers = []
        for i, item in enumerate(written):
            try:
                numbers.append(quantities.read(item, _per_kelvin(self.value.kind, i)))
            except ValueError as error:
                found["polynomial", i] = str(error)
        if found:
            raise faults("polynomial", found)
        return tuple(numbers)

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        tables = handler.generate_schema(LawTable[Annotated[float, self.value]])
        return read_by(self.read, tables)

    def __get_pydantic_json_schema__(
        self, schema: Any, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return either(self.value, schema, handler)


def _per_kelvin(kind: Kind, power: int) -> Kind:
    """What the coefficient of T**power measures."""
    if power == 0:
        return kind
    unit = f"{kind.unit or '1'}/K^{power}"
    return Kind(f"{kind.name} per kelvin to the power {power}", unit, f"1e-3 {unit}")
