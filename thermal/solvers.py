"""The thermal solvers by name; one is imported when it is named."""

import importlib
from typing import Any

from thermal.description import Description

SOLVERS = {
    "line": "thermal.line:LineHeat",
    "lumped": "thermal.lumped:LumpedHeat",
    "prescribed": "thermal.prescribed:PrescribedHeat",
}


def build(name: str, description: Description) -> Any:
    """The solver ``name`` for ``description``; it has ``x``, ``regions`` and ``advance``.

    Raises ValueError with all problems when the description makes no sense.
    """
    if name not in SOLVERS:
        raise ValueError(f"no thermal solver '{name}'; there are {', '.join(SOLVERS)}")
    module, _, leaf = SOLVERS[name].partition(":")
    return getattr(importlib.import_module(module), leaf)(description)
