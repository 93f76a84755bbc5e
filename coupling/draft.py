"""A case while it is being read: what has passed, what is named, what is wrong."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from coupling.errors import Problem
from coupling.places import Shape

Where = tuple[str, ...]


@dataclass
class Draft:
    """What has been read of a case so far.

    raw : the tables as TOML gave them
    valid : tables that passed, by path: ``("time",)``, ``("body", "arm")``
    shapes : where each body is at the start, by name, as far as it could be found
    problems : everything that did not pass
    """

    raw: dict[str, Any]
    folder: Path
    valid: dict[Where, Any] = field(default_factory=dict)
    shapes: dict[str, Shape] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    @property
    def points(self) -> dict[str, NDArray]:
        """(n, 3) float [m]  nodes of each body by name."""
        return {name: shape.points for name, shape in self.shapes.items()}

    def named(self, *kind: str) -> dict[str, Any]:
        """The valid tables of one kind by name, such as ``named("thermal", "wall")``."""
        return {where[-1]: table for where, table in self.valid.items() if where[:-1] == kind}

    def names(self, *kind: str) -> list[str]:
        """All names of one kind in the file, valid or not."""
        tables: Any = self.raw
        for step in kind:
            tables = tables.get(step, {}) if isinstance(tables, dict) else {}
        return list(tables) if isinstance(tables, dict) else []
