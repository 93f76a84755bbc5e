"""``thermobody compare-thermal``: the heat of a scene under every solver that can express it.

Heat alone, at the pose of the start, in the windows of the scene; friction gives none, and joints
with play do not touch. What the solvers make of it is compared where motion feels it: at the
section temperatures, mean and gradients, of the mechanical points.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from coupling.errors import BadCase, Problem, unknown
from coupling.model import Model, build
from coupling.reports.registry import Curve, Picture, Result
from coupling.scene import Scene

Array = NDArray[np.float64]

REFERENCE = "wall"
FINER = 4
"""The solver the others are compared with, with so many times the stations and wall points and a
hundredth of the tolerance; if it refuses, the run of most temperatures."""
COLUMNS = (
    "solver", "temperatures", "steps", "start [s]", "run [s]", "mean: largest [K]",
    "average [K]", "gradient: largest [K/m]", "average [K/m]",
)  # fmt: skip
DASHES = ("-", "--", "-.", ":")


class Run(NamedTuple):
    """The heat of a scene by one solver.

    temperatures : number of unknowns; steps : taken in all windows
    start, seconds : float [s]  of building and a first window, which compiles; of all windows
    times : (w,) float [s];  sections : (w, m, 3) float [K], [K/m]  at the mechanical points
    reached : (m,) bool  points to which a temperature belongs
    why : "" or why the solver cannot express it, or stopped
    """

    solver: str
    why: str
    temperatures: int = 0
    steps: int = 0
    start: float = 0.0
    seconds: float = 0.0
    times: Array = np.empty(0)
    sections: Array = np.empty((0, 0, 3))
    reached: NDArray[np.bool_] = np.empty(0, dtype=bool)


class Difference(NamedTuple):
    """From the reference, over all windows and points: largest and average of mean and gradient."""

    mean: float
    mean_average: float
    gradient: float
    gradient_average: float


class Row(NamedTuple):
    """A run, and how far it is from the reference; None: there is no such number."""

    run: Run
    difference: Difference | None


def compare(
    scene: Scene,
    solvers: Sequence[str] | None = None,
    reference: str | None = None,
    console: Console | None = None,
) -> list[Row]:
    """Run the heat of a scene under several solvers; None: all there are.

    Parameters
    ----------
    reference : solver that the others are compared with; None: a finer run of ``REFERENCE``

    Raises
    ------
    BadCase : the scene has no heat, there is no such solver, or the reference did not run
    """
    names = _chosen(scene, solvers, reference)
    runs = [_told(_run(scene, name), console) for name in names]
    if reference is None:
        finer = _told(_run(_finer(scene), REFERENCE, f"{REFERENCE}, finer"), console)
        runs += [] if finer.why else [finer]
    done = [run for run in runs if not run.why]
    if not done:
        reasons = [Problem(run.solver, run.why) for run in runs]
        raise BadCase(str(scene.folder), reasons)
    standard = _reference(scene, done, reference)
    return [
        Row(run, None if run.why or run is standard else _difference(run, standard)) for run in runs
    ]


def compare_thermal(
    scene: Scene,
    solvers: Sequence[str] | None,
    reference: str | None,
    folder: Path,
    out: Console,
) -> list[Path]:
    """Compare, print the table, write it with pictures; the files that were written."""
    from coupling.report import publish

    return publish(_result(scene, compare(scene, solvers, reference, out)), folder, out)


def _chosen(scene: Scene, solvers: Sequence[str] | None, reference: str | None) -> list[str]:
    from thermal.solvers import SOLVERS

    if scene.thermal is None:
        raise BadCase(str(scene.folder), [Problem("thermal", "the scene has no heat to compare")])
    names = list(SOLVERS) if solvers is None else list(dict.fromkeys(solvers))
    if reference is not None and reference not in names:
        names.append(reference)
    wrong = [name for name in names if name not in SOLVERS]
    if wrong:
        raise BadCase(
            "compare-thermal", [Problem("", unknown("solver", name, SOLVERS)) for name in wrong]
        )
    return names


def _reference(scene: Scene, done: Sequence[Run], name: str | None) -> Run:
    by_name = {run.solver: run for run in done}
    if name is None:
        return by_name.get(f"{REFERENCE}, finer") or max(done, key=lambda run: run.temperatures)
    if name not in by_name:
        text = f"the reference '{name}' did not run"
        raise BadCase(str(scene.folder), [Problem("", text)])
    return by_name[name]


def _told(run: Run, console: Console | None) -> Run:
    if console is not None:
        what = run.why.splitlines()[0] if run.why else f"{run.seconds:.3g} s"
        console.print(f"{run.solver}: {what}", style="dim", markup=False, highlight=False)
    return run


# ------------------------------------------------------------------------------------- runs


def _finer(scene: Scene) -> Scene:
    """The same scene with more temperatures and smaller errors in time."""
    own = scene.thermal
    assert own is not None
    around = own.wall_points if own.wall_points == 1 else min(360, FINER * own.wall_points)
    change = {
        "wall_points": around,
        "refine": min(1000, FINER * own.refine),
        "tolerance": 0.01 * own.tolerance,
        "steps": None if own.steps is None else FINER**2 * own.steps,
    }
    return scene.model_copy(update={"thermal": own.model_copy(update=change)})


def _run(scene: Scene, name: str, label: str = "") -> Run:
    """The heat under one solver, or why not; ``label`` stands for its name in the table."""
    begun = perf_counter()
    assert scene.thermal is not None
    own = scene.thermal.model_copy(update={"solver": name})
    try:
        model = build(scene.model_copy(update={"thermal": own}))
    except BadCase as error:
        return Run(label or name, "\n".join(problem.text for problem in error.problems))
    solver: Any = model.pair.heat_solver
    outside = _outside(model)
    solver.advance(solver.initial(), 0.0, model.window, np.zeros(len(solver.x)), *outside(0))
    start = perf_counter() - begun
    return _windows(model, label or name, outside)._replace(start=start)


def _windows(model: Model, name: str, outside: Callable[[int], tuple[Any, ...]]) -> Run:
    """All windows, of which the time is taken."""
    solver: Any = model.pair.heat_solver
    T, nothing, steps, seconds = solver.initial(), np.zeros(len(solver.x)), 0, 0.0
    sections, why = [model.pair.transfer.read(T)], ""
    for i in range(model.windows):
        given = outside(i)
        begun = perf_counter()
        T, _, why = solver.advance(T, i * model.window, model.window, nothing, *given)
        seconds += perf_counter() - begun
        if why:
            why = f"stopped in the window from {i * model.window:g} s on: {why}"
            break
        steps += getattr(solver, "taken", 1)
        sections.append(model.pair.transfer.read(T))
    times = model.window * np.arange(len(sections), dtype=np.float64)
    reached = np.diff(model.pair.transfer.matrix.indptr)[0::3] > 0
    return Run(name, why, len(T), steps, 0.0, seconds, times, np.array(sections), reached)


def _outside(model: Model) -> Callable[[int], tuple[Any, ...]]:
    """What surrounds the pose of the start, at both ends of a window; () where nothing does."""
    around = model.pair.surroundings
    if around is None:
        return lambda i: ()
    solver: Any = model.pair.heat_solver
    T = solver.initial()

    def both(i: int) -> tuple[Mapping[str, tuple[Array, Array]]]:
        ends = [around.at((i + k) * model.window, None, T) for k in (0, 1)]
        return ({name: (value, ends[1][name]) for name, value in ends[0].items()},)

    return both


def _difference(run: Run, standard: Run) -> Difference:
    """Over all windows but the start, at the points that both reach."""
    both = run.reached & standard.reached
    apart = np.abs(run.sections - standard.sections)[1:, both]
    mean, gradient = apart[..., 0], np.linalg.norm(apart[..., 1:], axis=-1)
    return Difference(*(float(f()) for f in (mean.max, mean.mean, gradient.max, gradient.mean)))


# ----------------------------------------------------------------------------------- output


def _result(scene: Scene, rows: Sequence[Row]) -> Result:
    standard = next(row.run for row in rows if not row.run.why and row.difference is None)
    there = standard.sections[:, standard.reached]
    low, high = there[..., 0].min(), there[..., 0].max()
    steep = np.linalg.norm(there[..., 1:], axis=-1).max()
    notes = [
        f"differences from '{standard.solver}', at the section temperatures of all windows",
        f"there the mean is {low:.6g} K to {high:.6g} K, the gradient up to {steep:.4g} K/m",
        "heat alone at the pose of the start: friction gives no heat, joints with play are open",
        "start: building and a first window, in which kernels are compiled; run: all windows",
    ]
    notes += [
        f"{r.run.solver}: {'; '.join(map(str.strip, r.run.why.splitlines()))}"
        for r in rows
        if r.run.why
    ]
    done = [row for row in rows if not row.run.why]
    title = f"Heat by several solvers: {scene.title or scene.folder.name}"
    pictures = [*_histories(done, standard), *_errors(done)]
    return Result("compare_thermal", title, COLUMNS, [_cells(row) for row in done], notes, pictures)


def _cells(row: Row) -> tuple[str | float | int, ...]:
    run = row.run
    apart = ("reference", "", "", "") if row.difference is None else tuple(row.difference)
    return (run.solver, run.temperatures, run.steps, run.start, run.seconds, *apart)


def _histories(rows: Sequence[Row], standard: Run) -> list[Picture]:
    """Mean temperature and gradient, where those of the reference are largest at the end."""
    end = standard.sections[-1]
    hottest = np.where(standard.reached, end[:, 0], -np.inf).argmax()
    steepest = np.where(standard.reached, np.linalg.norm(end[:, 1:], axis=1), -np.inf).argmax()
    means = [(row.run, row.run.sections[:, hottest, 0]) for row in rows]
    gradients = [
        (row.run, np.linalg.norm(row.run.sections[:, steepest, 1:], axis=1)) for row in rows
    ]
    return [
        Picture("time [s]", f"{label} section", _lines(curves), "")
        for label, curves in (("mean [K], hottest", means), ("gradient [K/m], steepest", gradients))
    ]


def _lines(curves: Sequence[tuple[Run, Array]]) -> list[Curve]:
    """Each with a dash of its own, as most lie on one another."""
    return [
        Curve(run.solver, run.times, y, DASHES[i % len(DASHES)])
        for i, (run, y) in enumerate(curves)
    ]


def _errors(rows: Sequence[Row]) -> list[Picture]:
    """Largest differences over run time; none where nothing can be compared."""
    found = []
    for of, unit in (("mean", "K"), ("gradient", "K/m")):
        curves = [
            Curve(row.run.solver, [row.run.seconds], [getattr(row.difference, of)], "")
            for row in rows
            if row.difference is not None and getattr(row.difference, of) > 0.0
        ]
        if curves:
            found.append(Picture("run time [s]", f"difference of {of} [{unit}]", curves))
    return found
