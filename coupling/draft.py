"""A case while it is being read: what has passed, what is named, what is wrong."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from coupling.errors import Problem

Where = tuple[str, ...]


@dataclass
class Draft:
    """What has been read of a case so far.

    raw : the tables as TOML gave them
    valid : tables that passed, by path: ``("time",)``, ``("body", "arm")``
    points : (n, 3) float [m] of each body by name, as far as they could be found
    problems : everything that did not pass
    """

    raw: dict[str, Any]
    folder: Path
    valid: dict[Where, Any] = field(default_factory=dict)
    points: dict[str, NDArray] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def named(self, *kind: str) -> dict[str, Any]:
        """The valid tables of one kind by name, such as ``named("thermal", "wall")``."""
        return {where[-1]: table for where, table in self.valid.items() if where[:-1] == kind}

    def names(self, *kind: str) -> list[str]:
        """All names of one kind in the file, valid or not."""
        tables: Any = self.raw
        for step in kind:
            tables = tables.get(step, {}) if isinstance(tables, dict) else {}
        return list(tables) if isinstance(tables, dict) else []
