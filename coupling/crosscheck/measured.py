"""What one model yields of all stages."""

from typing import NamedTuple

from coupling.crosscheck.quantities import Quantity
from coupling.crosscheck.solved import Solved


class Measured(NamedTuple):
    """What one model yields.

    quantities : stage -> all of it;  seconds : stage -> float [s]  of the processor
    why : stage -> why it yields nothing
    """

    name: str
    dof: int
    quantities: dict[str, list[Quantity]]
    seconds: dict[str, float]
    why: dict[str, str]
    solved: Solved | None = None
