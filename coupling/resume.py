"""Going on with a run that ended early."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from coupling.errors import BadCase, Problem
from coupling.results import FILE_NAME, BadResults, Recorder, Results


def latest(parent: Path) -> Path:
    """The newest run folder that has results. Raises BadCase if there is none."""
    runs = [p for p in parent.glob("*") if p.name.isdecimal() and (p / FILE_NAME).is_file()]
    if not runs:
        raise BadCase(
            str(parent), [Problem("", "no run to resume; leave out --resume to start one")]
        )
    return max(runs, key=lambda p: int(p.name))


def reopened(folder: Path, scene: str) -> Recorder:
    """Recorder of a run of this case, which goes on where it ended.

    scene : text of the case
    """
    try:
        with Results.open(folder, journal=False) as results:
            saved = str(results.attributes().get("scene", ""))
        check_same_case(saved, scene)
        recorder = Recorder.reopen(folder)
    except BadResults as error:
        text = f"{error}; leave out --resume to start anew"
        raise BadCase(str(folder), [Problem("", text)]) from None
    recorder.attributes |= {"scene": scene}
    return recorder


def check_same_case(saved: str, now: str) -> None:
    """Refuse to go on with another case. Raises BadCase with the tables that differ.

    The end of the run, what is written and texts may differ, and so may the settings of
    integrator and coupling: a run that stopped can go on with others.
    """
    before, after = _essence(saved), _essence(now)
    differ = [name for name in before | after if before.get(name) != after.get(name)]
    if differ:
        text = "is not what the run to resume was started with; leave out --resume to start anew"
        raise BadCase("--resume", [Problem(name, text) for name in differ])


def _essence(text: str) -> dict[str, Any]:
    """What a case is about, without how it is computed and written."""
    tables = tomllib.loads(text)
    for name in ("title", "description", "output", "integrator", "coupling", "report"):
        tables.pop(name, None)
    tables.get("time", {}).pop("end", None)
    return tables


def restored(template: Any, saved: Mapping[str, Any], folder: Path) -> Any:
    """The coupled state that was saved, in the types of ``template``.

    Raises BadCase where it is not one of this program.
    """
    try:
        return restore(template, saved["coupled"])
    except (KeyError, ValueError, TypeError) as error:
        text = f"its state is of another version of the program ({error}); start it anew"
        raise BadCase(str(folder), [Problem("", text)]) from None


def memory(solver: Any) -> Mapping[str, Any]:
    """What a solver of heat keeps beside the state, and later windows depend on."""
    return solver.memory() if hasattr(solver, "memory") else {}


def remember(solver: Any, saved: Mapping[str, Any]) -> None:
    """Give back what ``memory`` told."""
    if hasattr(solver, "remember"):
        solver.remember(saved.get("heat", {}))


def restore(template: Any, saved: Any) -> Any:
    """The saved state in the types of ``template`` (nested named tuples of arrays)."""
    if hasattr(template, "_fields"):
        parts = {k: restore(getattr(template, k), saved[k]) for k in template._fields}
        return type(template)(**parts)
    if isinstance(template, np.ndarray):
        value = np.asarray(saved, template.dtype)  # of another size: as many rows as were seen
        return value.reshape(template.shape) if value.size == template.size else value
    if isinstance(template, Mapping):
        return dict(saved)
    return type(template)(saved)
