"""Tables of the case file about loads and gravity."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import Direction, Table, Vector, Vector3
from coupling.functions import ForceHistory, LineLoadHistory, MomentHistory, PressureHistory
from coupling.site_tables import Edge, OnGround, Site


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


class TorqueLoad(Table):
    """A moment on a, its reaction on b, in a direction that moves with b: a motor."""

    kind: Literal["torque"]
    a: Site = Field(description="what it turns, {body = ..., at = ...}")
    b: OnGround = Field(description="what takes the reaction; default: the ground")
    direction: Direction = Field(description="[x, y, z] at the start, of any length")
    amplitude: MomentHistory = Field(description="a moment such as '1 N m', or a function of time")


class TractionLoad(Table):
    """A force that is spread over a shell, or over one of its edges, and keeps its direction."""

    kind: Literal["traction"]
    body: str = Field(description="name of a shell, [body.NAME]")
    edge: Edge | None = Field(default=None, description="one of its edges; absent: all of it")
    direction: Direction = Field(description="[x, y, z] of any length")
    pressure: PressureHistory | None = Field(
        default=None, description="per area of the shell, such as '100 Pa', or its history"
    )
    line_load: LineLoadHistory | None = Field(
        default=None, description="per length of the edge, such as '5 N/m', or its history"
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        wanted, other = "pressure", "line_load"
        if "edge" in keys:
            wanted, other = other, wanted
        if wanted not in keys:
            yield wanted, f"missing ({cls.model_fields[wanted].description})"
        if other in keys:
            yield other, f"does not go {'with' if 'edge' in keys else 'without'} an edge"


class Gravity(Table):
    """[gravity]"""

    acceleration: Annotated[Vector3, Vector(quantities.ACCELERATION)] = Field(
        description="[x, y, z] such as [0, 0, '-9.81 m/s^2']"
    )


Load = ForceLoad | MomentLoad | TorqueLoad | TractionLoad
