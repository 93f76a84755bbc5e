"""A sweep from its table to its files; the command ``thermobody sweep``."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from coupling.errors import BadCase, Problem, unknown
from coupling.locks import holding
from coupling.results import new_run_folder
from coupling.scene import Scene
from coupling.sweep_tables import SweepTable
from coupling.sweeps import points, words
from coupling.sweeps.points import Job, Point
from coupling.sweeps.progress import Progress
from coupling.sweeps.table import Sweep, tabulated

CASE = "case.toml"
"""Text of the case in the folder of a sweep."""


class Prepared(NamedTuple):
    """A sweep all of whose points are good cases; ``jobs`` in the order of the points."""

    name: str
    table: SweepTable
    text: str
    jobs: list[Job]

    @property
    def title(self) -> str:
        """Of table and pictures."""
        return self.table.title or f"sweep {self.name}"


def prepared(scene: Scene, name: str) -> Prepared:
    """A sweep of a case, with the case at every point.

    Raises
    ------
    BadCase : there is no such sweep, or what is wrong with any of its points
    """
    if name not in scene.sweep:
        text = unknown("[sweep.NAME]", name, scene.sweep)
        if not scene.sweep:
            text = "the case has no [sweep.NAME]"
        raise BadCase(str(scene.folder), [Problem("", text)])
    table = scene.sweep[name]
    made = points.scenes(scene, table, name)
    return Prepared(name, table, scene.text, points.jobs(made, table))


def sweep(
    scene: Scene,
    name: str,
    folder: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    console: Any = None,
) -> Sweep:
    """Run one sweep in a folder; see ``coupling.sweeps.run``."""
    return carried_out(prepared(scene, name), folder, workers, scheduler, console)


def carried_out(
    one: Prepared, folder: Path, workers: int | None, scheduler: str | None, console: Any
) -> Sweep:
    """Run what is left of a sweep, then write tables and pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    with holding(folder):
        (folder / CASE).write_text(one.text, encoding="utf-8")
        found = _computed(one, folder, workers, scheduler, console)
        made = tabulated(one.name, one.title, one.table, [found[job.key] for job in one.jobs])
        files = words.write(made, one.table, folder)
        from coupling.sweeps.pictures import draw

        return made._replace(files=(*files, *draw(made, one.table, folder)))


def _computed(
    one: Prepared, folder: Path, workers: int | None, scheduler: str | None, console: Any
) -> dict[str, Point]:
    """All points by the names of their files; each is kept as soon as it is there."""
    jobs = {job.key: job for job in one.jobs}
    found = {key: point for key, job in jobs.items() if (point := points.kept(folder, job))}
    left = [job for key, job in jobs.items() if key not in found]
    labels = dict(zip(jobs, _labels(one, jobs), strict=True))
    computed = closing(_workers(left, workers, scheduler))
    with Progress(console, one.name, len(jobs), len(found)) as progress, computed as finished:
        for job, point in finished:
            points.keep(folder, job, point)
            found[job.key] = point
            progress.told(labels[job.key], point)
    return found


def _labels(one: Prepared, jobs: dict[str, Job]) -> Iterator[str]:
    """What is varied at each point, of alike points the first."""
    from coupling.report_tables import said

    settings = one.table.settings()
    for key in jobs:
        place = next(i for i, job in enumerate(one.jobs) if job.key == key)
        yield f"point {place + 1} ({said(settings[place])})"


def _workers(
    jobs: Sequence[Job], workers: int | None, scheduler: str | None
) -> Generator[tuple[Job, Point], None, None]:
    if not jobs:
        return _nothing()
    if scheduler is not None:
        from coupling.sweeps.cluster import cluster

        return cluster(jobs, scheduler)
    from coupling.sweeps.local import cores, local

    return local(jobs, workers or cores())


def _nothing() -> Generator[tuple[Job, Point], None, None]:
    yield from ()


# ----------------------------------------------------------------------------- the command


class Place(NamedTuple):
    """The folder of a sweep, and what there is to say of one that is gone on with."""

    folder: Path
    said: str


def place(one: Prepared, parent: Path, resume: bool) -> Place:
    """A new numbered folder below ``parent``/NAME, or with ``resume`` the newest one there.

    Raises
    ------
    BadCase : there is none to go on with
    """
    folder = parent / one.name
    if not resume:
        return Place(new_run_folder(folder), "")
    there = [p for p in folder.glob("*") if p.name.isdecimal() and (p / CASE).is_file()]
    if not there:
        text = "no sweep to resume; leave out --resume to start one"
        raise BadCase(str(folder), [Problem("", text)])
    newest = max(there, key=lambda p: int(p.name))
    return Place(newest, _said(one, newest))


def _said(one: Prepared, folder: Path) -> str:
    """What a folder has of the points, and whether they are of the same case."""
    jobs = {job.key: job for job in one.jobs}.values()
    have = sum(points.kept(folder, job) is not None for job in jobs)
    text = f"{folder}: {have} of {len(jobs)} points are there"
    if (folder / CASE).read_text(encoding="utf-8") != one.text:
        text += "; the case has changed since: points that are not the same are computed anew"
    return text


def run(
    scene: Scene,
    names: Sequence[str],
    parent: Path,
    workers: int | None,
    scheduler: str | None,
    resume: bool,
    console: Any,
) -> list[tuple[Path, Sweep]]:
    """Sweeps of a case by their names, all if there are none; folder and table of each.

    Everything is checked before anything is run.

    Raises
    ------
    BadCase : there is no such sweep, or what is wrong with any point of any of them
    """
    if not scene.sweep:
        raise BadCase(str(scene.folder), [Problem("", "the case has no [sweep.NAME]")])
    ready: list[Prepared] = []
    found: list[Problem] = []
    for name in dict.fromkeys(names or scene.sweep):
        try:
            ready.append(prepared(scene, name))
        except BadCase as bad:
            found += bad.problems
    if found:
        raise BadCase(f"sweeps of {scene.folder}", found)
    made = []
    for one in ready:
        folder, said = place(one, parent, resume)
        if said:
            console.print(said, markup=False)
        made.append((folder, carried_out(one, folder, workers, scheduler, console)))
    return made
