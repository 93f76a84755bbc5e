"""What the tables of a case file are made of: checked numbers, counts and vectors.

Each field is a pydantic annotation that reads what may stand in TOML, says clearly what is wrong
with it, and describes itself in the JSON schema of the case file.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf, sqrt
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    model_validator,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from coupling import quantities
from coupling.errors import alternatives, shown, suggestion
from coupling.quantities import Kind

Path = tuple[str | int, ...]
Vector3 = tuple[float, float, float]


def fault(text: str) -> PydanticCustomError:
    """An error that pydantic reports with this text and nothing added."""
    return PydanticCustomError("fault", "{text}", {"text": text})


def faults(title: str, found: Mapping[Path, str]) -> ValidationError:
    """Several errors at once, each at its path within the value being read."""
    details = [
        InitErrorDetails(type=fault(text), loc=path, input=None) for path, text in found.items()
    ]
    return ValidationError.from_exception_data(title, details)


class Table(BaseModel):
    """A table of the case file: unknown keys are refused, values are taken literally."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, populate_by_name=True)

    @classmethod
    def model_parametrized_name(cls, params: tuple[Any, ...]) -> str:
        """Tables for different units have the same name in the JSON schema."""
        return cls.__name__

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        """Problems (key, text) of which keys are present, found before values are read."""
        return iter(())

    def odd_values(self) -> Iterator[tuple[str, str]]:
        """Problems (key, text) of values that are right one by one but not together."""
        return iter(())

    @model_validator(mode="wrap")
    @classmethod
    def _all_at_once(cls, data: Any, handler: Any) -> Any:
        if isinstance(data, cls):
            return data
        if not isinstance(data, dict):
            raise fault(f"expected a table, got {shown(data)}")
        found: dict[Path, str] = {(key,): text for key, text in cls.odd_keys(set(data))}
        value = None
        try:
            value = handler(data)
        except ValidationError as error:
            found |= {tuple(e["loc"]): cls._said(e) for e in error.errors()}
        if value is not None:
            found |= {(key,): text for key, text in value.odd_values()}
        if found:
            raise faults(cls.__name__, found)
        return value

    @classmethod
    def keys(cls) -> list[str]:
        """The keys that may be written."""
        return [field.alias or name for name, field in cls.model_fields.items()]

    @classmethod
    def _said(cls, error: Any) -> str:
        if error["type"] == "extra_forbidden" and len(error["loc"]) == 1:
            key = error["loc"][0]
            hint = suggestion(key, cls.keys()) or f"; known here: {', '.join(cls.keys())}"
            return f"unknown key{hint}"
        if error["type"] == "missing" and len(error["loc"]) == 1:
            fields = {f.alias or name: f for name, f in cls.model_fields.items()}
            meaning = fields[str(error["loc"][0])].description
            return f"missing ({meaning})" if meaning else "missing"
        return said(error)


def said(error: Any) -> str:
    """An error of pydantic in the words of this program."""
    kind, value, context = error["type"], shown(error["input"]), error.get("ctx", {})
    match kind:
        case "union_tag_invalid":
            words = [word.strip(" '") for word in context["expected_tags"].split(",")]
            tag = context["tag"]
            return f"expected {alternatives(words)}, got '{tag}'{suggestion(tag, words)}"
        case "union_tag_not_found":
            return "missing"
        case "literal_error":
            words = [
                word.strip(" '") for word in context["expected"].replace(" or ", ",").split(",")
            ]
            hint = suggestion(error["input"], words)
            return f"expected {alternatives(words)}, got {value}{hint}"
        case "string_type":
            return f"expected text in quotes, got {value}"
        case "list_type" | "tuple_type":
            return f"expected an array, got {value}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"expected a table, got {value}"
    return error["msg"]


@dataclass(frozen=True)
class Quantity:
    """A number with a unit within bounds; ``words`` may stand in its place."""

    kind: Kind
    above: float = -inf
    least: float = -inf
    below: float = inf
    most: float = inf
    words: tuple[str, ...] = ()

    def read(self, value: Any) -> Any:
        """The value in SI units, or one of the words."""
        if isinstance(value, str) and value in self.words:
            return value
        try:
            number = quantities.read(value, self.kind)
        except ValueError as error:
            text = str(error)
            if self.words:
                text = text.replace("expected", f"expected {alternatives(self.words)} or", 1)
            raise fault(text + suggestion(value, self.words)) from None
        if not (self.above < number < self.below and self.least <= number <= self.most):
            raise fault(f"expected {self._wanted()}, got {shown(value)}{self._converted(value)}")
        return number

    def _wanted(self) -> str:
        unit = f" {self.kind.unit}" if self.kind.unit else ""
        bounds = {
            "above": self.above,
            "at least": self.least,
            "below": self.below,
            "at most": self.most,
        }
        limits = [f"{word} {x:g}{unit}" for word, x in bounds.items() if abs(x) < inf]
        return f"{self.kind.name} " + " and ".join(limits)

    def _converted(self, value: Any) -> str:
        if not isinstance(value, str):
            return ""
        return f" ({quantities.read(value, self.kind):g} {self.kind.unit})"

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        limits = {
            "exclusiveMinimum": self.above,
            "minimum": self.least,
            "exclusiveMaximum": self.below,
            "maximum": self.most,
        }
        number = {"type": "number"} | {k: x for k, x in limits.items() if abs(x) < inf}
        if not self.kind.unit:
            return number
        text = {"type": "string", "examples": [*self.words, self.kind.example]}
        return {"anyOf": [number, text]}


@dataclass(frozen=True)
class Count:
    """A whole number within bounds."""

    least: int = 1
    most: int = 100_000

    def read(self, value: Any) -> int:
        """The number itself."""
        word = "a positive integer" if self.least == 1 else f"an integer of at least {self.least}"
        if not isinstance(value, int) or isinstance(value, bool) or value < self.least:
            raise fault(f"expected {word}, got {shown(value)}")
        if value > self.most:
            raise fault(f"expected at most {self.most}, got {shown(value)}")
        return value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.least, "maximum": self.most}


@dataclass(frozen=True)
class Vector:
    """Three numbers with units, [x, y, z]; with ``direction`` of any length but zero, made unit."""

    kind: Kind
    direction: bool = False

    def read(self, value: Any) -> tuple[float, float, float]:
        """The components in SI units."""
        if not isinstance(value, (list, tuple)) or len(value) != 3:
            raise fault(f"expected three numbers [x, y, z], got {shown(value)}")
        found: dict[Path, str] = {}
        numbers = []
        for i, item in enumerate(value):
            try:
                numbers.append(quantities.read(item, self.kind))
            except ValueError as error:
                found[(i,)] = str(error)
        if found:
            raise faults("vector", found)
        x, y, z = numbers
        if not self.direction:
            return x, y, z
        largest = max(abs(x), abs(y), abs(z))
        if largest == 0.0:
            raise fault("expected a direction, got the zero vector")
        x, y, z = x / largest, y / largest, z / largest
        length = sqrt(x * x + y * y + z * z)
        return x / length, y / length, z / length

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        item = Quantity(self.kind).__get_pydantic_json_schema__(schema, handler)
        return {"type": "array", "items": item, "minItems": 3, "maxItems": 3}


@dataclass(frozen=True)
class EitherOf:
    """A number that measures one of several things; a plain number is in SI units of any."""

    kinds: tuple[Kind, ...]

    def read(self, value: Any) -> float:
        """The value in SI units."""
        said = []
        for kind in self.kinds:
            try:
                return quantities.read(value, kind)
            except ValueError as error:
                said.append(str(error))
        wanted = " or ".join(f"{kind.name} such as '{kind.example}'" for kind in self.kinds)
        known = [text for text in said if text.startswith("unknown unit")]
        raise fault(known[0] if known else f"expected {wanted}, got {shown(value)}")

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        examples = [kind.example for kind in self.kinds]
        return {"anyOf": [{"type": "number"}, {"type": "string", "examples": examples}]}


@dataclass(frozen=True)
class RightAngles:
    """Two or three directions at right angles, made unit; the third is e1 x e2."""

    def read(self, value: Any) -> tuple[Vector3, Vector3, Vector3]:
        """Rows e1, e2, e3."""
        if not isinstance(value, (list, tuple)) or len(value) not in (2, 3):
            raise fault(f"expected two or three directions [[x, y, z], ...], got {shown(value)}")
        one = Vector(quantities.NUMBER, direction=True)
        found: dict[Path, str] = {}
        rows: list[Vector3] = []
        for i, item in enumerate(value):
            try:
                rows.append(one.read(item))
            except PydanticCustomError as error:
                found[(i,)] = error.message()
            except ValidationError as error:
                found |= {(i, *e["loc"]): e["msg"] for e in error.errors()}
        if found:
            raise faults("axes", found)
        if abs(_dot(rows[0], rows[1])) > SQUARE:
            raise fault("the first two directions are not at right angles")
        third = _cross(rows[0], rows[1])
        if len(rows) == 3 and _dot(third, rows[2]) < 1.0 - SQUARE:
            raise fault("the third direction is not that of first x second; leave it out")
        return rows[0], rows[1], third

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        row = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
        return {"type": "array", "items": row, "minItems": 2, "maxItems": 3}


SQUARE = 1e-6
"""Cosine up to which two directions count as at right angles [-]."""


def odd_angle(key: str, what: str, a: Vector3, b: Vector3) -> Iterator[tuple[str, str]]:
    """A problem at ``key`` where two directions are not at right angles."""
    if abs(_dot(a, b)) > SQUARE:
        yield key, f"must be at right angles{what}; the cosine is {_dot(a, b):g}"


def _dot(a: Vector3, b: Vector3) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


TEMPERATURE = Quantity(quantities.TEMPERATURE, above=0.0, below=1e5)
Length = Annotated[float, Quantity(quantities.LENGTH)]
PositiveLength = Annotated[float, Quantity(quantities.LENGTH, above=0.0)]
Time = Annotated[float, Quantity(quantities.TIME, least=0.0)]
PositiveTime = Annotated[float, Quantity(quantities.TIME, above=0.0)]
PositiveMass = Annotated[float, Quantity(quantities.MASS, above=0.0)]
Temperature = Annotated[float, TEMPERATURE]
Fraction = Annotated[float, Quantity(quantities.NUMBER, least=0.0, most=1.0)]
Point = Annotated[Vector3, Vector(quantities.LENGTH)]
Direction = Annotated[Vector3, Vector(quantities.NUMBER, direction=True)]
Axes = Annotated[tuple[Vector3, Vector3, Vector3], RightAngles()]
AngleOrLength = Annotated[float, EitherOf((quantities.ANGLE, quantities.LENGTH))]
