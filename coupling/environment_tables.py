"""Tables of the case file about the surroundings in space: sun, orbit, planet, attitude."""

from collections.abc import Iterator
from datetime import datetime
from itertools import pairwise
from math import pi
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import (
    Axes,
    Direction,
    Fraction,
    PositiveLength,
    Quantity,
    Table,
    Temperature,
    Time,
)
from coupling.heat_faces import FaceTable

Angle = Annotated[float, Quantity(quantities.ANGLE)]
Tilt = Annotated[float, Quantity(quantities.ANGLE, least=-0.5 * pi, most=0.5 * pi)]
HeatFlux = Annotated[float, Quantity(quantities.HEAT_FLUX, least=0.0)]
DEEP_SPACE = 2.725  # [K]  Fixsen 2009


class SunTable(Table):
    """Where the sun stands: a direction, a date, or an angle above the orbit."""

    direction: Direction | None = Field(
        default=None, description="towards it; with the equator and the equinox as axes"
    )
    date: datetime | None = Field(
        default=None, description="universal time at t = 0, such as 2026-03-20T12:00:00"
    )
    beta: Tilt | None = Field(default=None, description="angle above the plane of the orbit")
    noon: Angle | None = Field(
        default=None, description="with beta: from the ascending node to where it is noon"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"direction", "date", "beta"}) != 1:
            yield "", "expected one of direction, date, beta"
        if "noon" in keys and "beta" not in keys:
            yield "noon", "belongs to beta"


class OrbitTable(Table):
    """A Kepler orbit about the planet."""

    kind: Literal["geostationary", "circular", "elliptic"] = Field(
        description="geostationary: 42164.17 km, or circular with an altitude, or elliptic"
    )
    altitude: PositiveLength | None = Field(default=None, description="of circular")
    semi_major_axis: PositiveLength | None = Field(default=None, description="of elliptic")
    eccentricity: Annotated[float, Quantity(quantities.NUMBER, least=0.0, below=1.0)] | None = (
        Field(default=None, description="of elliptic")
    )
    perigee: Angle | None = Field(
        default=None, description="of elliptic: from the ascending node to the perigee"
    )
    inclination: Angle = Field(default=0.0, description="to the equator")
    node: Angle = Field(default=0.0, description="right ascension of the ascending node")
    phase: Angle = Field(
        default=0.0, description="from the ascending node to the spacecraft at t = 0"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        own = {
            "geostationary": (),
            "circular": ("altitude",),
            "elliptic": ("semi_major_axis", "eccentricity", "perigee"),
        }
        for key in {key for keys in own.values() for key in keys} - set(own[self.kind]):
            if getattr(self, key) is not None:
                yield key, f"does not go with {self.kind}"
        for key in own[self.kind]:
            if getattr(self, key) is None and key != "perigee":
                yield key, f"missing (of {self.kind})"


class PlanetTable(Table):
    """The planet, which eclipses the sun, reflects light and glows."""

    radius: PositiveLength = Field(default=6378137.0, description="default: the earth's")
    albedo: Fraction = Field(default=0.30, description="part of sunlight that it reflects")
    infrared: HeatFlux = Field(default=238.0, description="emitted at its surface")


class AttitudeTable(Table):
    """How the coordinates of the case stand."""

    frame: Literal["inertial", "nadir", "sun"] = Field(
        default="inertial",
        description="inertial: equator and equinox; nadir: z to the planet's centre, y against "
        "the orbit's normal; sun: x towards the sun",
    )
    axes: Axes | None = Field(
        default=None, description="directions of the case's x, y, z in the frame: two or three"
    )
    table: list[tuple[Time, Angle, Angle, Angle]] | None = Field(
        default=None,
        description="[[time, yaw, pitch, roll], ...] about z, then y, then x, as they turn along",
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if {"axes", "table"} <= keys:
            yield "table", "does not go with axes: give one or the other"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        times = [row[0] for row in self.table or ()]
        if self.table == [] or any(b <= a for a, b in pairwise(times)):
            yield "table", "needs rows whose times increase"


class EnvironmentTable(Table):
    """[thermal.environment]: sunlight, and a planet's, on the surfaces of the moving structure."""

    sun: SunTable = Field(description="{direction = ...}, {date = ...} or {beta = ...}")
    flux: HeatFlux = Field(default=1361.0, description="of sunlight at one astronomical unit")
    orbit: OrbitTable | None = Field(default=None, description="default: far from any planet")
    planet: PlanetTable = Field(
        default=PlanetTable(), description="with an orbit; default: the earth"
    )
    attitude: AttitudeTable = Field(
        default=AttitudeTable(), description="default: the axes of equator and equinox"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if "planet" in keys and "orbit" not in keys:
            yield "planet", "needs an orbit about it"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.orbit is None and self.attitude.frame == "nadir":
            yield "attitude", "the frame nadir needs an orbit"
        if self.orbit is None and self.sun.beta is not None:
            yield "sun", "beta is an angle above an orbit, and there is none"


class SurfaceTable(FaceTable):
    """A face in the light of [thermal.environment]; it radiates to deep space."""

    absorptivity: Fraction = Field(description="of sunlight, 0 to 1")
    emissivity: Fraction = Field(description="of infrared, 0 to 1")
    sink: Temperature = Field(default=DEEP_SPACE, description="of deep space")
