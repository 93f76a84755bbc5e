"""Tables of the case file about heat: materials and everything under [thermal]."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.environment_tables import EnvironmentTable, SurfaceTable
from coupling.fields import (
    Axes,
    Count,
    Direction,
    Fraction,
    Length,
    Point,
    PositiveLength,
    PositiveMass,
    PositiveTime,
    Quantity,
    Table,
    Temperature,
    Time,
)
from coupling.functions import (
    PAIR,
    FilmHistory,
    FluxHistory,
    PowerHistory,
    TemperatureEnds,
    TemperatureHistory,
)
from coupling.heat_faces import FaceTable
from coupling.histories import History
from coupling.laws import Law, LawOf
from coupling.wire import problem_of


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
    conductivity_around: (
        Annotated[Law, LawOf(Quantity(quantities.CONDUCTIVITY, above=0.0))] | None
    ) = Field(default=None, description="round a tube, or along v of a shell; default: the same")
    conductivity_through: (
        Annotated[Law, LawOf(Quantity(quantities.CONDUCTIVITY, above=0.0))] | None
    ) = Field(default=None, description="through the wall; default: the same")
    source: str = Field(default="case file", description="where the data come from")


Ends = tuple[History, History]
MATERIAL_NAME = "name in the library or of a [material.NAME]"


class ThermalPlace(Table):
    """A body, or an end or a named region of it; or a part."""

    body: str | None = Field(default=None, description="name of a [body.NAME]")
    solid: str | None = Field(default=None, description="name of a [thermal.solid.NAME]")
    at: str | None = Field(
        default=None,
        description="of a beam or cable 'start' or 'end', of a shell 'top' or 'bottom', of a "
        "solid a region; default: all of it",
    )
    part: str | None = Field(default=None, description="name of a [thermal.part.NAME]")

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"body", "solid", "part"}) != 1:
            yield "", "expected {body = ...}, {solid = ...} or {part = ...}"
        elif "part" in keys and "at" in keys:
            yield "at", "does not go with part"


class Emitting(FaceTable):
    """A face and its emissivity."""

    emissivity: Fraction = Field(description="0 to 1")


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


class Flux(FaceTable):
    """Heat that falls on a face."""

    density: FluxHistory = Field(description="a heat flux such as '1361 W/m^2', or its history")
    absorptivity: Fraction = Field(default=1.0, description="part that is absorbed, 0 to 1")
    direction: Direction | None = Field(
        default=None, description="of parallel rays; default: the same flux on every side"
    )


class Film(FaceTable):
    """Convection on a face."""

    coefficient: FilmHistory = Field(description="such as '10 W/m^2/K', or its history")
    surroundings: TemperatureHistory = Field(description="temperature of the fluid")


Emissivity = Annotated[Law, LawOf(Quantity(quantities.NUMBER, least=0.0, most=1.0))]


class Radiation(FaceTable):
    """Grey radiation of a face to its surroundings."""

    emissivity: Emissivity = Field(description="0 to 1, or a law of temperature")
    sink: TemperatureHistory = Field(description="temperature of the surroundings")


class Enclosure(Table):
    """Grey faces that see one another. One face 'inner' of a body: a long tube."""

    faces: list[Emitting] = Field(description="[{body = ..., face = ..., emissivity = ...}, ...]")
    view_factors: list[list[Fraction]] | None = Field(
        default=None, description="row i: from face i to each face; default: computed"
    )
    sink: TemperatureHistory | None = Field(
        default=None, description="temperature that openings show; default: 0 K"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not self.faces:
            yield "faces", "needs at least one face"
        n = len(self.faces)
        rows = self.view_factors or []
        if self.view_factors is not None and [len(row) for row in rows] != [n] * n:
            yield "view_factors", f"expected {n} rows of {n} numbers"
        for i, row in enumerate(rows):
            if sum(row) > 1.0 + 1e-6:
                yield f"view_factors[{i}]", f"sums to {sum(row):g}, more than 1"


class Interface(Table):
    """Conductance per area between two faces that lie on one another."""

    a: FaceTable = Field(description="{body = ..., face = ...} or {solid = ..., face = ...}")
    b: FaceTable = Field(description="{body = ..., face = ...} or {solid = ..., face = ...}")
    coefficient: Annotated[float, Quantity(quantities.FILM, least=0.0)] = Field(
        description="such as '2000 W/m^2/K'"
    )
    factor: Annotated[Law, LawOf(Quantity(quantities.NUMBER, least=0.0))] | None = Field(
        default=None, description="of the coefficient, over the mean temperature"
    )
    radiating: Fraction = Field(
        default=0.0, description="exchange factor of radiation across the gap"
    )


class Fixed(Table):
    """A given temperature."""

    at: ThermalPlace = Field(description="{body = ..., at = ...} or {part = ...}")
    temperature: TemperatureHistory = Field(description="such as '20 degC', or its history")


class Source(Table):
    """Heat from outside."""

    at: ThermalPlace = Field(
        description="{body = ..., at = ...} or {part = ...}; without 'at' in all of the body"
    )
    power: PowerHistory = Field(description="such as '5 W', or its history")


class Part(Table):
    """A lump with one temperature, such as a journal or a bearing."""

    of: str | None = Field(
        default=None, description="'JOINT.journal' or 'JOINT.bearing' that it is"
    )
    material: str = Field(description="name in the library or of a [material.NAME]")
    mass: PositiveMass = Field(description="a mass such as '1.5 kg'")
    area: Annotated[float, Quantity(quantities.AREA, least=0.0)] = Field(
        default=0.0, description="of its face, such as '50 cm^2'; default: it has none"
    )
    initial: Temperature | None = Field(default=None, description="default: thermal.initial")


class Link(Table):
    """A conductance between two places, or to a given temperature."""

    a: ThermalPlace = Field(description="{body = ..., at = ...} or {part = ...}")
    b: ThermalPlace | None = Field(
        default=None, description="{body = ..., at = ...} or {part = ...}"
    )
    temperature: TemperatureHistory | None = Field(default=None, description="given instead of b")
    conductance: Annotated[float, Quantity(quantities.CONDUCTANCE, least=0.0)] = Field(
        default=0.0, description="a conductance such as '2 W/K'"
    )
    factor: Annotated[Law, LawOf(Quantity(quantities.NUMBER, least=0.0))] | None = Field(
        default=None, description="of the conductance, over the mean temperature"
    )
    radiating: Annotated[float, Quantity(quantities.AREA, least=0.0)] = Field(
        default=0.0, description="area times exchange factor of radiation, such as '10 cm^2'"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"b", "temperature"}) != 1:
            yield "b", "give either b or a temperature"
        if not keys & {"conductance", "radiating"}:
            yield "conductance", "missing (give a conductance, or a radiating area, or both)"
        if "factor" in keys and "conductance" not in keys:
            yield "factor", "belongs to a conductance, and there is none"


Force = Annotated[float, Quantity(quantities.FORCE, least=0.0)]
Conductance = Annotated[float, Quantity(quantities.CONDUCTANCE, least=0.0)]


class Contact(Table):
    """Heat through a joint with clearance, between the parts or solids that are its sides."""

    joint: str = Field(description="name of a [joint.NAME] with clearance")
    by_force: list[Annotated[tuple[Force, Conductance], PAIR]] | None = Field(
        default=None, description="[[force, conductance], ...] of each contact, straight between"
    )
    by_gap: list[Annotated[tuple[Length, Conductance], PAIR]] | None = Field(
        default=None, description="[[gap, conductance], ...] while it is open; default: nothing"
    )
    roughness: PositiveLength | None = Field(
        default=None, description="instead of by_force: rms height of both surfaces together"
    )
    slope: Annotated[float, Quantity(quantities.NUMBER, above=0.0)] | None = Field(
        default=None, description="mean slope of the asperities"
    )
    hardness: Annotated[float, Quantity(quantities.PRESSURE, above=0.0)] | None = Field(
        default=None, description="of the softer side, such as '1.1 GPa'"
    )
    area: Annotated[float, Quantity(quantities.AREA, above=0.0)] | None = Field(
        default=None, description="nominal area of each contact, such as '5 cm^2'"
    )
    radiating: Annotated[float, Quantity(quantities.AREA, least=0.0)] = Field(
        default=0.0, description="area times exchange factor of radiation across the gap"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        rough = {"roughness", "slope", "hardness", "area"}
        if "by_force" in keys:
            for key in sorted(rough & keys):
                yield key, "does not go with by_force: give one or the other"
            return
        for key in sorted(rough - keys):
            yield key, "missing (give by_force, or roughness, slope, hardness and area)"
        if "by_gap" in keys:
            yield "by_gap", "goes with by_force"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        for key in ("by_force", "by_gap"):
            rows = getattr(self, key)
            if rows is not None and (not rows or any(b[0] <= a[0] for a, b in pairwise(rows))):
                yield key, "the first numbers must increase from row to row"


class Elastic(Table):
    """Heat that deformation releases and takes up (Gough-Joule)."""

    bodies: list[str] = Field(description="names of beams and cables")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not self.bodies:
            yield "bodies", "needs at least one body"


class FieldTable(Table):
    """Given temperatures of a body over place and time: a table, or a file of another program."""

    body: str = Field(description="name of a [body.NAME]")
    file: str | None = Field(
        default=None,
        description="CSV, VTU or PVD, relative to the case folder: temperatures at points",
    )
    name: str | None = Field(default=None, description="of the data in the file")
    unit: Literal["K", "degC", "degF"] = Field(
        default="K", description="of the temperatures in the file, where it names none"
    )
    length_unit: Literal["m", "mm", "cm", "um", "in", "ft"] = Field(
        default="m", description="of the coordinates in the file, where it names none"
    )
    distances: list[Length] | None = Field(
        default=None, description="from the start of a beam or cable: columns of the table"
    )
    times: list[Time] | None = Field(default=None, description="rows of the table")
    temperatures: list[list[Temperature]] | None = Field(
        default=None, description="one row for each time, one column for each distance"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        table = {"distances", "times", "temperatures"}
        if "file" in keys:
            for key in sorted(table & keys):
                yield key, "does not go with file: give one or the other"
            return
        for key in sorted(table - keys):
            yield key, "missing (give a file, or distances, times and temperatures)"
        for key in sorted({"name", "unit", "length_unit"} & keys):
            yield key, "belongs to a file, and there is none"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        for key in ("distances", "times"):
            values = getattr(self, key)
            if values is not None and (not values or any(b <= a for a, b in pairwise(values))):
                yield key, "expected numbers that increase"
        if self.temperatures is not None and self.times and self.distances:
            shape = [len(row) for row in self.temperatures]
            if shape != [len(self.distances)] * len(self.times):
                yield (
                    "temperatures",
                    f"expected {len(self.times)} rows of {len(self.distances)} temperatures",
                )


class Box(Table):
    """A box from its origin along x, y and z; faces x0, x1, y0, y1, z0, z1."""

    size: Point = Field(description="along x, y and z")
    elements: list[Annotated[int, Count(most=10_000)]] = Field(description="along x, y and z")
    origin: Point = Field(default=(0.0, 0.0, 0.0), description="its lowest corner")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if len(self.elements) != 3:
            yield "elements", f"expected three numbers, got {len(self.elements)}"
        if min(self.size) <= 0.0:
            yield "size", "must be positive"


class SolidTable(Table):
    """A solid that conducts and does not move by itself: a mesh with named regions."""

    mesh: str | None = Field(
        default=None, description="file that meshio reads, relative to the case folder"
    )
    box: Box | None = Field(default=None, description="instead of a mesh")
    unit: PositiveLength = Field(default=1.0, description="of the coordinates of the mesh file")
    material: str | None = Field(default=None, description=MATERIAL_NAME)
    materials: dict[str, str] = Field(
        default_factory=dict, description="of regions of the mesh, instead of material or besides"
    )
    axes: Axes | None = Field(
        default=None, description="directions along, around, through of its conductivities"
    )
    of: str | None = Field(
        default=None, description="'JOINT.journal' or 'JOINT.bearing' that it is"
    )
    rubbing: str | None = Field(
        default=None, description="region that rubs, with of; default: all of it"
    )
    initial: Temperature | None = Field(default=None, description="default: thermal.initial")

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"mesh", "box"}) != 1:
            yield "mesh", "give either a mesh or a box"
        if not keys & {"material", "materials"}:
            yield "material", "missing (name in the library or of a [material.NAME])"
        if "rubbing" in keys and "of" not in keys:
            yield "rubbing", "belongs to the side of a joint: give 'of'"


class Participant(Table):
    """[thermal.participant]: a program in another process that computes the heat."""

    address: str = Field(description="'HOST:PORT', or the path of a socket, where it listens")
    patience: PositiveTime = Field(default=600.0, description="how long an answer may take")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if wrong := problem_of(self.address):
            yield "address", wrong


class Thermal(Table):
    """[thermal]: present when the scene has heat."""

    solver: str = Field(
        default="line",
        description="'thermobody list' names them; 'external': that of [thermal.participant]",
    )
    initial: Temperature = Field(description="temperature at the start")
    start: Literal["initial", "steady"] = Field(
        default="initial",
        description="steady: the temperatures that the conditions at t = 0 would hold",
    )
    scheme: Literal["sdirk2", "crank-nicolson", "backward-euler"] = Field(
        default="sdirk2", description="steps in time of the heat"
    )
    tolerance: Annotated[float, Quantity(quantities.DIFFERENCE, above=0.0)] = Field(
        default=1e-3, description="error of a step in time, such as '1 mK'"
    )
    steps: Annotated[int, Count()] | None = Field(
        default=None, description="equal steps of each window instead of error control"
    )
    linear: Literal["auto", "direct", "multigrid", "petsc"] = Field(
        default="auto", description="who solves the linear systems of the heat"
    )
    order: Literal[1, 2] = Field(default=1, description="of the elements of walls and solids")
    layers: Annotated[int, Count(most=100)] = Field(
        default=1, description="elements through a wall, with the solver solid"
    )
    refine: Annotated[int, Count(most=1000)] = Field(
        default=1, description="stations for each element of a beam or cable"
    )
    full_sections: Literal["mean", "gradients"] = Field(
        default="mean", description="of circles and rectangles: mean, or mean and two gradients"
    )
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
    film: dict[str, Film] = Field(default_factory=dict)
    enclosure: dict[str, Enclosure] = Field(default_factory=dict)
    interface: dict[str, Interface] = Field(default_factory=dict)
    field: dict[str, FieldTable] = Field(default_factory=dict)
    solid: dict[str, SolidTable] = Field(default_factory=dict)
    contact: dict[str, Contact] = Field(default_factory=dict)
    environment: EnvironmentTable | None = Field(
        default=None, description="[thermal.environment]: sun, orbit, planet, attitude"
    )
    surface: dict[str, SurfaceTable] = Field(default_factory=dict)
    elastic: Elastic | None = Field(
        default=None, description="[thermal.elastic]: heat that deformation releases"
    )
    participant: Participant | None = Field(
        default=None, description="[thermal.participant]: who computes, with the solver 'external'"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.wall_points != 1 and (self.wall_points < 4 or self.wall_points % 2):
            yield (
                "wall_points",
                f"must be 1, or an even number of 4 or more, got {self.wall_points}",
            )
