"""Going on with a run that ended early."""

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.errors import BadCase, Problem
from coupling.reading import FORMAT_VERSION
from coupling.results import FILE_NAME, BadResults, Recorder, Results
from coupling.tables import OtherRows

OTHER = "is of another version of the program"


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
            saved = results.attributes()
        if saved["format_version"] != FORMAT_VERSION:
            text = f"format version {saved['format_version']}, not {FORMAT_VERSION}"
            raise BadResults(f"it {OTHER} ({text})")
        check_same_case(str(saved.get("scene", "")), scene)
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


def restored(
    template: Any, saved: Mapping[str, Any], solver: Any, folder: Path
) -> tuple[Any, int, int]:
    """Coupled state that was saved, in the types of ``template``, its tick, size of the window.

    The solver of heat is given back what it kept beside. Raises BadCase where something is not as
    this program has it.
    """
    try:
        remember(solver, saved)
        return restore(template, saved["coupled"]), int(saved["tick"]), int(saved["size"])
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        raise _other(folder, "state", error) from None


@contextmanager
def continuing(folder: Path) -> Iterator[None]:
    """Rows are added to those that were found; BadCase where they have other columns."""
    try:
        yield
    except OtherRows as error:
        raise _other(folder, "history", error) from None


def _other(folder: Path, what: str, error: Exception) -> BadCase:
    text = f"its {what} {OTHER} ({error}); leave out --resume to start anew"
    return BadCase(str(folder), [Problem("", text)])


def memory(solver: Any) -> Mapping[str, Any]:
    """What a solver of heat keeps beside the state, and later windows depend on."""
    return solver.memory() if hasattr(solver, "memory") else {}


def remember(solver: Any, saved: Mapping[str, Any]) -> None:
    """Give back what ``memory`` told."""
    if hasattr(solver, "remember"):
        solver.remember(saved.get("heat", {}))


def restore(template: Any, saved: Any) -> Any:
    """The saved state in the types of ``template`` (nested named tuples of arrays).

    ValueError where it has other fields, or arrays of another shape; what is empty in the template
    may have grown.
    """
    if hasattr(template, "_fields"):
        if odd := sorted(set(template._fields) ^ set(saved)):
            raise ValueError(f"fields that differ: {', '.join(odd)}")
        parts = {k: restore(getattr(template, k), saved[k]) for k in template._fields}
        return type(template)(**parts)
    if isinstance(template, np.ndarray):
        return _restored_array(template, np.asarray(saved, template.dtype))
    if isinstance(template, Mapping):
        return dict(saved)
    return type(template)(saved)


def _restored_array(template: NDArray[Any], value: NDArray[Any]) -> NDArray[Any]:
    if value.size == template.size:
        return value.reshape(template.shape)
    pairs = list(zip(value.shape, template.shape, strict=False))
    if value.ndim == template.ndim and all(size == own or own == 0 for size, own in pairs):
        return value
    raise ValueError(f"an array {value.shape} in place of {template.shape}")
