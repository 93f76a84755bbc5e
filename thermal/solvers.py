"""The thermal solvers by name; one is imported when it is named."""

import importlib
from typing import Any

from thermal.description import DEFAULT, Description, Faces, Settings

SOLVERS = {
    "line": "thermal.line:LineHeat",
    "lumped": "thermal.lumped:LumpedHeat",
    "prescribed": "thermal.prescribed:PrescribedHeat",
}
PRESCRIBED = "prescribed"


def build(name: str, description: Description, settings: Settings = DEFAULT) -> Any:
    """The solver ``name`` for ``description``; it has ``x``, ``regions`` and ``advance``.

    Only lines and parts conduct: the temperatures of sheets are always the prescribed ones.

    Raises ValueError with all problems when the description makes no sense.
    """
    if name not in SOLVERS:
        raise ValueError(f"no thermal solver '{name}'; there are {', '.join(SOLVERS)}")
    if name == PRESCRIBED or not description.sheets:
        return _load(name)(description, settings)
    from thermal.check import check
    from thermal.together import SideBySide

    check(description)
    conducting, sheets = _apart(description)
    given = _load(PRESCRIBED)(sheets, settings)
    if not (conducting.members or conducting.parts):
        return given
    return SideBySide(_load(name)(conducting, settings), given)


def _load(name: str) -> Any:
    module, _, leaf = SOLVERS[name].partition(":")
    return getattr(importlib.import_module(module), leaf)


def _apart(d: Description) -> tuple[Description, Description]:
    """What conducts, and the sheets, whose temperatures are given."""
    others = [c for c in d.conditions if not isinstance(c, Faces)]
    faces = [c for c in d.conditions if isinstance(c, Faces)]
    conducting = Description(d.members, d.parts, d.links, others)
    return conducting, Description([], conditions=faces, sheets=d.sheets)
