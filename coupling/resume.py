"""Going on with a run that ended early."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from coupling.errors import BadCase, Problem
from coupling.results import FILE_NAME


def latest(parent: Path) -> Path:
    """The newest run folder that has results. Raises BadCase if there is none."""
    runs = [p for p in parent.glob("*") if p.name.isdecimal() and (p / FILE_NAME).is_file()]
    if not runs:
        raise BadCase(
            str(parent), [Problem("", "no run to resume; leave out --resume to start one")]
        )
    return max(runs, key=lambda p: int(p.name))


def restore(template: Any, saved: Any) -> Any:
    """The saved state in the types of ``template`` (nested named tuples of arrays)."""
    if hasattr(template, "_fields"):
        parts = {k: restore(getattr(template, k), saved[k]) for k in template._fields}
        return type(template)(**parts)
    if isinstance(template, np.ndarray):
        return np.asarray(saved, template.dtype).reshape(template.shape)
    if isinstance(template, Mapping):
        return dict(saved)
    return type(template)(saved)
