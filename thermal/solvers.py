"""The thermal solvers by name; what one needs is imported when it is named."""

import importlib
from collections.abc import Callable
from typing import Any

from thermal.description import DEFAULT, Description, Settings

SOLVERS = {
    "line": "thermal.solvers:line",
    "hermite": "thermal.solvers:hermite",
    "wall": "thermal.solvers:wall",
    "solid": "thermal.solvers:solid",
    "lumped": "thermal.lumped:LumpedHeat",
    "prescribed": "thermal.prescribed:PrescribedHeat",
    "calculix": "thermal.calculix:CalculixHeat",
}


def build(name: str, description: Description, settings: Settings = DEFAULT) -> Any:
    """The solver ``name`` for ``description``; it has ``x``, ``regions`` and ``advance``.

    Raises ValueError with all problems when the description makes no sense, or when the solver
    cannot express it.
    """
    if name not in SOLVERS:
        raise ValueError(f"no thermal solver '{name}'; there are {', '.join(SOLVERS)}")
    from thermal.check import check

    check(description)
    module, _, leaf = SOLVERS[name].partition(":")
    return getattr(importlib.import_module(module), leaf)(description, settings)


def line(d: Description, settings: Settings) -> Any:
    """Members as lines with trigonometric profiles; sheets as walls, solids in 3D."""
    return _composed(d, settings, [("line", _names(d.members)), *_beside(d)])


def hermite(d: Description, settings: Settings) -> Any:
    """Members by the cubic functions of the beams; sheets as walls, solids in 3D."""
    return _composed(d, settings, [("hermite", _names(d.members)), *_beside(d)])


def wall(d: Description, settings: Settings) -> Any:
    """Tubes and sheets as developed surfaces; other members as lines, solids in 3D."""
    tubes = {m.name for m in d.members if m.section.kind == "tube" and m.wall_points > 1}
    others = _names(d.members) - tubes
    return _composed(d, settings, [("wall", tubes), ("line", others), *_beside(d)])


def solid(d: Description, settings: Settings) -> Any:
    """Everything but lumps in 3D."""
    bodies = _names([*d.members, *d.sheets, *d.solids])
    return _composed(d, settings, [("solid", bodies), ("lumps", _names(d.parts))])


SPACES = {
    "line": "thermal.line:LineSpace",
    "hermite": "thermal.hermite:HermiteSpace",
    "wall": "thermal.wall:WallSpace",
    "solid": "thermal.solid:SolidSpace",
    "lumps": "thermal.lumps:LumpSpace",
}


def _beside(d: Description) -> list[tuple[str, set[str]]]:
    """What stands beside the members, in the order of the temperatures."""
    return [
        ("lumps", _names(d.parts)),
        ("wall", _names(d.sheets)),
        ("solid", _names(d.solids)),
    ]


def _names(things: Any) -> set[str]:
    return {thing.name for thing in things}


def _composed(d: Description, settings: Settings, choice: list[tuple[str, set[str]]]) -> Any:
    from thermal.composite import compose
    from thermal.heat import Heat

    makers = [(_space(name, settings), names) for name, names in choice if names]
    return Heat(compose(d, makers), d, settings)


def _space(name: str, settings: Settings) -> Callable[[Description], Any]:
    module, _, leaf = SPACES[name].partition(":")
    make = getattr(importlib.import_module(module), leaf)
    return lambda part: make(part, settings)
