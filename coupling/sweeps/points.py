"""The points of a sweep: what a worker is given, what it gives back, and the file of each."""

import json
import os
import threading
from collections.abc import Iterable, Mapping
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from coupling.errors import BadCase, Problem
from coupling.reading import FORMAT_VERSION
from coupling.scene import Scene
from coupling.sweep_tables import SweepTable

Array = NDArray[np.float64]

DONE, STOPPED, REFUSED, GIVEN_UP = "done", "stopped", "refused", "given up"
FAILED, LOST = "failed", "lost"
"""Outcomes besides those of ``coupling.reports.timed_runs``: an error of the program; its workers
died."""
FINAL = (DONE, STOPPED, REFUSED)
"""Outcomes that would be the same again."""
ALONE = threading.Lock()
"""Compiled code of a process computes one point at a time."""


class Job(NamedTuple):
    """All that a worker needs.

    key : names the file of the point;  text : of the case;  folder : where its files are
    wanted : names of quantities whose courses are kept;  limit : float [s]  of the wall clock
    """

    key: str
    text: str
    folder: str
    wanted: tuple[str, ...]
    limit: float


class Point(NamedTuple):
    """What became of a point.

    outcome, reason : see ``coupling.reports.timed_runs.Ran``
    seconds : float [s]  it took, building and compiling included
    times : (w,) float [s]  0 and the ends of the windows
    courses : (w,) float  of each quantity, by what it is of
    """

    outcome: str
    reason: str
    seconds: float = np.nan
    times: Array = np.zeros(0)
    courses: Mapping[str, Array] = {}


# --------------------------------------------------------------------------- of the table


def scenes(scene: Scene, table: SweepTable, name: str) -> list[Scene]:
    """The case at each point.

    Raises
    ------
    BadCase : with everything that is wrong with any of them
    """
    found: list[Problem] = []
    made = []
    for number, overrides in enumerate(table.settings(), 1):
        try:
            made.append(_changed(scene, table, overrides))
        except BadCase as refused:
            found += [_at_point(name, number, overrides, problem) for problem in refused.problems]
    if found:
        raise BadCase(f"sweep {name}", found)
    return made


def _changed(scene: Scene, table: SweepTable, overrides: Mapping[str, Any]) -> Scene:
    from coupling.reports.error_time import changed
    from coupling.sweeps.variants import with_variants

    return changed(with_variants(scene, table.variant), {**table.set, **overrides})


def _at_point(name: str, number: int, overrides: Mapping[str, Any], problem: Problem) -> Problem:
    from coupling.report_tables import said

    path = f"point {number} ({said(dict(overrides))})"
    return Problem(f"{path}: {problem.path}" if problem.path else path, problem.text)


def wanted(table: SweepTable) -> tuple[str, ...]:
    """Quantities whose courses a sweep keeps."""
    asked = [one.of for one in table.quantity.values()]
    asked += [of for portrait in table.portrait.values() for of in (portrait.x, portrait.y)]
    return tuple(dict.fromkeys(asked))


def jobs(made: Iterable[Scene], table: SweepTable) -> list[Job]:
    """What the workers are given."""
    limit = np.inf if table.limit is None else table.limit
    return [
        Job(key(scene), scene.text, str(scene.folder.resolve()), wanted(table), limit)
        for scene in made
    ]


def key(scene: Scene) -> str:
    """Name of a point: it follows from the text of the case and the files that this names."""
    hashed = sha256(f"format {FORMAT_VERSION}\0{scene.text}".encode())
    for file in sorted(_files(scene)):
        hashed.update(file.read_bytes())
    return hashed.hexdigest()[:20]


def _files(scene: Scene) -> set[Path]:
    """Files beside the case that a text in it names, such as meshes."""
    import tomllib

    found, left = set(), [*tomllib.loads(scene.text).values()]
    while left:
        value = left.pop()
        if isinstance(value, dict):
            left += value.values()
        elif isinstance(value, list):
            left += value
        elif isinstance(value, str) and 0 < len(value) < 200 and "\n" not in value:
            file = scene.folder / value
            found |= {file} if file.is_file() else set()
    return found


# ------------------------------------------------------------------------------ of a worker


def compute(job: Job) -> Point:
    """Run the case at one point; whatever happens to it is said in what it returns."""
    begun = perf_counter()
    try:
        with ALONE:
            point = _computed(job)
    except BadCase as error:
        point = Point(REFUSED, "; ".join(problem.text for problem in error.problems))
    except Exception as error:  # one point does not lose the others
        point = Point(FAILED, f"{type(error).__name__}: {error}")
    return point._replace(seconds=perf_counter() - begun)


def _computed(job: Job) -> Point:
    from coupling import casefile
    from coupling.report_tables import Sought
    from coupling.reports.timed_runs import timed

    scene = casefile.from_text(job.text, Path(job.folder))
    sought = {of: Sought(of=of) for of in job.wanted}
    ran = timed(scene, sought, repeat=0, limit=job.limit)
    courses = {of: rows[:, 0] for of, rows in ran.values.items()}
    return Point(ran.outcome, ran.reason, 0.0, ran.times, courses)


# ----------------------------------------------------------------------------------- files


def kept(folder: Path, job: Job) -> Point | None:
    """A point that is in the folder with all that is wanted of it; None: it has to be computed."""
    try:
        with np.load(_file(folder, job), allow_pickle=False) as data:
            said = json.loads(str(data["said"]))
            courses = {of: data[f"course {i}"] for i, of in enumerate(said["courses"])}
            point = Point(said["outcome"], said["reason"], said["seconds"], data["times"], courses)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None
    whole = point.outcome != DONE or set(job.wanted) <= set(courses)
    return point if point.outcome in FINAL and whole else None


def keep(folder: Path, job: Job, point: Point) -> Path:
    """Write a point; the file is whole or not there."""
    said = {"outcome": point.outcome, "reason": point.reason, "seconds": point.seconds,
            "courses": list(point.courses)}  # fmt: skip
    arrays: dict[str, Any] = {f"course {i}": c for i, c in enumerate(point.courses.values())}
    file = _file(folder, job)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(f".{os.getpid()}.part")
    with part.open("wb") as stream:
        np.savez_compressed(stream, said=np.array(json.dumps(said)), times=point.times, **arrays)
    part.replace(file)
    return file


def _file(folder: Path, job: Job) -> Path:
    return folder / "points" / f"{job.key}.npz"
