"""Tables of the case file about loads and gravity."""

from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import Direction, Table, Vector, Vector3
from coupling.functions import ForceHistory, MomentHistory
from coupling.site_tables import OnGround, Site


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


class Gravity(Table):
    """[gravity]"""

    acceleration: Annotated[Vector3, Vector(quantities.ACCELERATION)] = Field(
        description="[x, y, z] such as [0, 0, '-9.81 m/s^2']"
    )


Load = ForceLoad | MomentLoad | TorqueLoad
