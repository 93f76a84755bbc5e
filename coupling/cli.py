"""The command ``thermobody``.

Nothing heavy is imported before a command needs it: help answers at once.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from coupling.errors import BadCase, Problem

if TYPE_CHECKING:
    from types import ModuleType

    from coupling.model import Model
    from coupling.scene import Scene

DONE, FAILED, BAD_INPUT, STOPPED, INTERRUPTED = 0, 1, 2, 3, 130
MANY_FILES = 10  # more files of one kind in one folder are told in one line

app = typer.Typer(
    name="thermobody",
    help="""Heat and motion of flexible space structures with clearance hinges, coupled.

A case is a folder with a file case.toml that says what there is: bodies, joints, loads, heat.
Running it leaves a numbered folder under results/ in the case folder.

Exit codes: 0 done, 1 a verification failed, 2 something is wrong with the input, 3 the run
stopped before its end, 130 interrupted.""",
    epilog="Start with:  thermobody list    then:  thermobody run cases/arm_rotation",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

CaseArgument = Annotated[
    Path, typer.Argument(metavar="CASE", help="Folder with a case.toml, or a TOML file.")
]
ResultArgument = Annotated[
    Path,
    typer.Argument(
        metavar="RESULT", help="A results.h5, the folder of a run, or a case (its newest run)."
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help="Change an entry of the case, such as time.end='20 s'. May be repeated.",
    ),
]
VariantOption = Annotated[
    list[str] | None,
    typer.Option(
        "--variant",
        metavar="NAME",
        help="Take the changes of a [variant.NAME] of the case, before --set. May be repeated.",
    ),
]


class Format(StrEnum):
    """What ParaView is to open."""

    pvd = "pvd"
    vtkhdf = "vtkhdf"


def main() -> None:
    """Entry point of the command."""
    app()


@contextmanager
def _answering() -> Iterator[None]:
    """Bad input ends in exit code 2 with a sentence, an interrupt in 130: no tracebacks."""
    try:
        yield
    except BadCase as error:
        _complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        _complain(f"stopped: {error}")
        raise typer.Exit(STOPPED) from None
    except KeyboardInterrupt:
        _complain("interrupted")
        raise typer.Exit(INTERRUPTED) from None


def _complain(text: str) -> None:
    Console(stderr=True).print(text, style="red", markup=False, highlight=False, soft_wrap=True)


def _out() -> Console:
    return Console(highlight=False, soft_wrap=True)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import PackageNotFoundError, version

        try:
            typer.echo(f"thermobody {version('thermobody')}")
        except PackageNotFoundError:
            typer.echo("thermobody, not installed (run from its source folder)")
        raise typer.Exit(DONE)


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Options of the command itself."""


# ---------------------------------------------------------------------------------- cases


@app.command(epilog="Example:  thermobody run cases/arm_rotation --set time.end='5 s'")
def run(
    case: CaseArgument,
    settings: SetOption = None,
    variants: VariantOption = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the newest run of the case.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            help="Where numbered run folders go; default: results/ in the case folder.",
        ),
    ] = None,
) -> None:
    """Run a case and write its results.

    Motion in time, or what [analysis] says: equilibria over a load factor, modes of vibration.

    Makes results/001, 002, ... in the case folder and never overwrites one. What the case asks
    for under [output] is written when the run ends. Ctrl-C stops a run; what it has so far is
    kept and --resume goes on from there.
    """
    with _answering():
        from coupling import casefile

        scene = casefile.read(case, settings or (), variants or ())
        parent = output or scene.folder / "results"
        _check_writable(parent)
        _run(scene, parent, resume)


def _run(scene: "Scene", parent: Path, resume: bool) -> None:
    from coupling import simulation

    if resume and scene.analysis.kind != "dynamics":
        text = f"an analysis of {scene.analysis.kind} is not resumed; leave out --resume"
        raise BadCase("--resume", [Problem("analysis.kind", text)])
    out = _out()
    try:
        if scene.analysis.kind == "dynamics":
            outcome = simulation.run(scene, parent, resume, out)
        else:
            from coupling import analyses

            outcome = analyses.run(scene, parent, out)
    except KeyboardInterrupt:
        _complain(f"interrupted; results so far are under {parent}, --resume goes on from there")
        raise typer.Exit(INTERRUPTED) from None
    except OSError as error:
        _complain(f"stopped: results cannot be written: {error}")
        raise typer.Exit(STOPPED) from None
    if outcome.code != DONE:
        _complain(outcome.reason)
    _say_error(outcome.folder / "results.h5", scene, out)
    _write_what_was_asked(scene, outcome.folder / "results.h5", out)
    out.print(f"results in {outcome.folder}", markup=False)
    raise typer.Exit(outcome.code)


def _say_error(results: Path, scene: "Scene | None", out: Console) -> None:
    """One line about the errors in time of a run, where they have been estimated."""
    from coupling.error_estimate import kept, said
    from coupling.reading import BadResults, Results

    found = None
    with suppress(BadResults), Results.open(results) as opened:  # who needs them says what is wrong
        found = kept(opened.attributes())
    if found is not None:
        out.print(said(found, scene), markup=False)


def _check_writable(folder: Path) -> None:
    """Refuse a place for results before anything is computed."""
    import os

    nearest = folder
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        raise BadCase(str(folder), [Problem("", f"results cannot go there: {nearest} is a file")])
    if not os.access(nearest, os.W_OK):
        text = f"results cannot go there: no permission to write in {nearest}"
        raise BadCase(str(folder), [Problem("", text)])


def _write_what_was_asked(scene: "Scene", results: Path, out: Console) -> None:
    if "vtk" in scene.output.export:
        from coupling.export import export as write

        _tell(out, write(results, "pvd"))
    if "pictures" in scene.output.export:
        from coupling.plot import plot as draw

        _tell(out, draw(results))


def _tell(out: Console, files: list[Path]) -> None:
    """Each file, but the many of one kind in one folder in one line."""
    kinds: dict[tuple[Path, str], list[Path]] = {}
    for file in files:
        kinds.setdefault((file.parent, file.suffix), []).append(file)
    for (folder, suffix), alike in kinds.items():
        if len(alike) > MANY_FILES:
            out.print(f"wrote {folder}/*{suffix}, {len(alike)} files", markup=False)
        else:
            for file in alike:
                out.print(f"wrote {file}", markup=False)


@app.command(epilog="Example:  thermobody check cases/arm_rotation --set thermal.solver=lumped")
def check(case: CaseArgument, settings: SetOption = None, variants: VariantOption = None) -> None:
    """Read and build a case without running it.

    Says everything that is wrong with it at once, each with its place in the file and what was
    expected there.
    """
    with _answering():
        scene, _ = _built(case, settings, variants)
        counts = {"body": len(scene.body), "joint": len(scene.joint), "load": len(scene.load)}
        parts = [_count(n, word) for word, n in counts.items()]
        parts.append("heat by " + scene.thermal.solver if scene.thermal else "no heat")
        parts.append(_count(scene.time.windows, "window"))
        _out().print(f"{case}: ok: {', '.join(parts)}", markup=False)


def _built(
    case: Path, settings: list[str] | None, variants: list[str] | None
) -> "tuple[Scene, Model]":
    """The scene of a case and the model built from it."""
    from coupling import casefile

    scene = casefile.read(case, settings or (), variants or ())
    from coupling.model import build

    return scene, build(scene)


def _count(n: int, word: str) -> str:
    many = {"body": "bodies"}.get(word, f"{word}s")
    return f"{n} {word if n == 1 else many}"


@app.command(epilog="Example:  thermobody plan cases/arm_rotation")
def plan(case: CaseArgument, settings: SetOption = None, variants: VariantOption = None) -> None:
    """Show what a run would compute, and what it leaves out and why."""
    with _answering():
        _, model = _built(case, settings, variants)
        _out().print(str(model).rstrip(), markup=False)


@app.command(epilog="Example:  thermobody schema > case.schema.json")
def schema() -> None:
    """Print the JSON schema of the case file.

    Editors with a TOML language server use it to complete keys and show what they mean.
    """
    import json

    from coupling.scene import Scene

    described = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    described |= Scene.model_json_schema() | {
        "title": "thermobody case",
        "additionalProperties": False,
    }
    typer.echo(json.dumps(described, indent=2))


@app.command(
    epilog="Example:  thermobody participant cases/sunlit_boom --set thermal.solver=wall "
    "--listen 127.0.0.1:7300"
)
def participant(
    case: CaseArgument,
    listen: Annotated[
        str,
        typer.Option(
            "--listen", metavar="ADDRESS", help="HOST:PORT (port 0: a free one), or a path."
        ),
    ],
    settings: SetOption = None,
    variants: VariantOption = None,
) -> None:
    """Compute the heat of a case for a run in another process.

    The run has the solver 'external' and the address in [thermal.participant]. This process ends
    when the run says that it has ended; if the run is interrupted it waits for the next call.
    Whoever can reach the address can use it: keep to 127.0.0.1 or a path on machines you share.
    """
    with _answering():
        from coupling import wire

        scene, model = _built(case, settings, variants)
        _serve(wire, scene, model, listen)


def _serve(wire: "ModuleType", scene: "Scene", model: "Model", address: str) -> None:
    from coupling.participant import Hosted, serve
    from coupling.shares import shares

    if model.pair.heat_solver is None:
        raise BadCase(str(scene.folder), [Problem("thermal", "missing: there is no heat")])
    wrong = wire.problem_of(address)
    if wrong:
        raise BadCase("--listen", [Problem("", wrong)])
    try:
        here = wire.listen(address)
    except OSError as error:
        text = f"cannot listen at {address}: {error.strerror or error}"
        raise BadCase("--listen", [Problem("", text)]) from None
    with here:
        _out().print(f"listening at {wire.address_of(here)}", markup=False)
        solver = model.pair.heat_solver
        serve(Hosted(solver, shares(scene, solver), scene), here)


# -------------------------------------------------------------------------------- results


@app.command(epilog="Example:  thermobody export cases/arm_rotation/results/001")
def export(
    result: ResultArgument,
    format: Annotated[
        Format, typer.Option("--format", help="pvd: a .vtu per frame; vtkhdf: one file.")
    ] = Format.pvd,
    deck: Annotated[
        bool,
        typer.Option(
            "--deck", help="Instead, write the scene of a CASE for CalculiX, as a 3D continuum."
        ),
    ] = False,
    linear: Annotated[bool, typer.Option("--linear", help="Of a deck: small rotations.")] = False,
    settings: SetOption = None,
    variants: VariantOption = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", metavar="FILE", help="Of a deck; default: results/deck.inp."),
    ] = None,
) -> None:
    """Write the results of a run for ParaView, or with --deck a case for CalculiX.

    Deformed bodies with temperature, stress and the state of their contacts, next to results.h5.
    A deck says in comments what it leaves out; what it cannot express is refused by name.
    """
    if deck:
        with _answering():
            _export_deck(result, settings, variants, output, linear)
        return
    with _answering(), _reading(result):
        file = _results(result)
        from coupling.export import export as write

        _tell(_out(), write(file, format.value))


def _export_deck(
    case: Path,
    settings: list[str] | None,
    variants: list[str] | None,
    output: Path | None,
    linear: bool,
) -> None:
    from coupling import casefile

    scene = casefile.read(case, settings or (), variants or ())
    from coupling.deck_export import NAME, export_deck

    file = output or scene.folder / "results" / NAME
    _check_writable(file.parent)
    _tell(_out(), export_deck(scene, file, linear, _out()))


@app.command(epilog="Example:  thermobody plot cases/arm_rotation")
def plot(result: ResultArgument) -> None:
    """Draw the results of a run.

    Temperatures, motion of the probes, orbits and forces of the hinges, energies; in statics the
    path of equilibria; as PNG files next to results.h5.
    """
    with _answering(), _reading(result):
        file = _results(result)
        from coupling.plot import plot as draw

        _say_error(file, None, _out())
        _tell(_out(), draw(file))


def _results(path: Path) -> Path:
    """The results file that is meant: of a run, or of the newest run of a case."""
    from coupling.resume import latest

    path = path.parent if path.suffix == ".toml" else path
    for file in (path, path / "results.h5"):
        if file.is_file():
            return file
    for parent in (path / "results", path):
        with suppress(BadCase):
            return latest(parent) / "results.h5"
    raise BadCase(str(path), [Problem("", "no results there; thermobody run makes them")])


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Files that are not results, or are damaged, are bad input."""
    from coupling.reading import BadResults

    try:
        yield
    except BadResults as error:
        raise BadCase(str(path), [Problem("", str(error))]) from None


# --------------------------------------------------------------------------- the program


@app.command(name="list", epilog="Example:  thermobody list")
def list_() -> None:
    """Show what there is: cases, materials, solvers, elements, joints, contact laws."""
    with _answering():
        from coupling.catalogue import show

        show(_out())


@app.command(epilog="Example:  thermobody verify heat")
def verify(
    area: Annotated[
        str | None,
        typer.Argument(
            metavar="[AREA]",
            help="an area such as beams or heat, or mechanics for all of its areas; "
            "'thermobody list' names them. Without: everything.",
        ),
    ] = None,
) -> None:
    """Solve problems with known answers and compare.

    Prints value, reference, error and tolerance of each quantity, and the time each problem
    took. Exit code 1 when one of them fails.
    """
    with _answering():
        from coupling.verify.table import show

        passed = show(area, _out())
    raise typer.Exit(DONE if passed else FAILED)


@app.command(
    name="compare-thermal",
    epilog="Example:  thermobody compare-thermal cases/sunlit_boom --solvers line,wall,solid",
)
def compare_thermal(
    case: CaseArgument,
    settings: SetOption = None,
    variants: VariantOption = None,
    solvers: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME", help="Thermal solvers; without: all there are."),
    ] = None,
    reference: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What the others are compared with; without: wall with four times the stations "
            "and wall points.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", metavar="DIR", help="Where table and picture go; default: results."
        ),
    ] = None,
) -> None:
    """Compute the heat of a case with every solver that can, and compare.

    Heat alone, at the pose of the start: friction gives none. Differences of the section
    temperatures that motion feels, against run time; what a solver cannot express it says.
    """
    with _answering():
        from coupling import casefile
        from coupling.compare_heat import compare_thermal as compare

        scene = casefile.read(case, settings or (), variants or ())
        folder = output or scene.folder / "results"
        _check_writable(folder)
        chosen = None if solvers is None else [name.strip() for name in solvers.split(",")]
        _tell(_out(), compare(scene, chosen, reference, folder, _out()))


@app.command(epilog="Example:  thermobody crosscheck cases/heated_boom")
def crosscheck(
    case: CaseArgument,
    settings: SetOption = None,
    variants: VariantOption = None,
    participants: Annotated[
        str | None,
        typer.Option(
            "--with",
            metavar="NAME,NAME",
            help="continuum, calculix, exudyn: what beams are compared with; without: all.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", metavar="DIR", help="Where tables and picture go; default: results."
        ),
    ] = None,
) -> None:
    """Compute a case by beams and as a 3D continuum, and compare stage by stage.

    Mass, rigid motion, expansion, equilibrium, vibration, motion, contact, pointing, as the
    [crosscheck] of the case says; besides by CalculiX and Exudyn, where they are installed, and
    with formulas. Exit code 1 where something deviates by more than the case allows.
    """
    with _answering():
        from coupling import casefile
        from coupling.crosscheck.command import crosscheck as compare

        scene = casefile.read(case, settings or (), variants or ())
        folder = output or scene.folder / "results" / "crosscheck"
        _check_writable(folder)
        chosen = None
        if participants is not None:
            chosen = [name.strip() for name in participants.split(",") if name.strip()]
        files, failures = compare(scene, chosen, folder, _out())
        _tell(_out(), files)
    for failure in failures:
        _complain(failure)
    raise typer.Exit(FAILED if failures else DONE)


@app.command(epilog="Example:  thermobody sweep cases/boom_temperature --workers 2")
def sweep(
    case: CaseArgument,
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="[sweep.NAME] of the case; without: all of them."),
    ] = None,
    settings: SetOption = None,
    variants: VariantOption = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", metavar="N", min=1, help="Local processes; without: one for each core."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            help="Of a Dask cluster in place of local processes, such as tcp://127.0.0.1:8786.",
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on in the newest folder of each sweep.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            help="Where NAME/001, ... go; default: results/sweeps in the case folder.",
        ),
    ] = None,
) -> None:
    """Run a case at many points: grids, and designs of experiments with their effects.

    Makes NAME/001, 002, ... with table.csv, table.md, pictures, and a file of each point. A point
    that fails does not stop the others: the exit code is 3 then. Ctrl-C keeps what is done, and
    --resume goes on from there; of a case that has changed it takes the points that have not.
    """
    with _answering():
        from coupling import casefile

        scene = casefile.read(case, settings or (), variants or ())
        parent = output or scene.folder / "results" / "sweeps"
        _check_writable(parent)
        _sweep(scene, names or (), parent, workers, scheduler, resume)


def _sweep(
    scene: "Scene",
    names: Sequence[str],
    parent: Path,
    workers: int | None,
    scheduler: str | None,
    resume: bool,
) -> None:
    from coupling.sweeps import command

    out, failed = _out(), False
    try:
        made = command.run(scene, names, parent, workers, scheduler, resume, out)
    except KeyboardInterrupt:
        _complain(f"interrupted; the points done are under {parent}, --resume goes on from there")
        raise typer.Exit(INTERRUPTED) from None
    for folder, done in made:
        _tell(out, list(done.files))
        for failure in done.failures:
            _complain(f"{done.name}: {failure}")
        failed = failed or bool(done.failures)
        out.print(f"results in {folder}", markup=False)
    raise typer.Exit(STOPPED if failed else DONE)


@app.command(epilog="Example:  thermobody report ring_truss levels")
def report(
    what: Annotated[
        str,
        typer.Argument(
            metavar="CASE|MODEL",
            help="A case, or ring_truss, contact, heat, mechanics, coupling, stability, extremes, "
            "program; or paper, the source of the project.",
        ),
    ],
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="work, newton, or a [report.NAME] of the case; of the ring truss also levels, "
            "elements, integrators, exudyn, clearance; of contact extremes, impacts, "
            "response_amplitude; of heat extremes, shock, speed; of mechanics extremes; "
            "of coupling extremes, seizure, flutter; of program leaving_out; of "
            "stability steps, exchange, clearance, slenderness, heating; extremes "
            "has all catalogues in one table; without: all of them.",
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", metavar="DIR", help="Where tables and pictures go.")
    ] = Path("report"),
    large: Annotated[
        bool,
        typer.Option(
            "--large",
            help="levels: also ten times the size of Level 4; clearance: the whole 10 s; speed: "
            "also 512 000 temperatures; minutes.",
        ),
    ] = False,
    settings: SetOption = None,
    variants: VariantOption = None,
    error: Annotated[
        float | None,
        typer.Option(
            "--error",
            metavar="NUMBER",
            help="Of [report.NAME]: which setting is the cheapest with a smaller error.",
        ),
    ] = None,
) -> None:
    """Measure how fast and how well motion and heat are computed.

    Times of the parts of a step, ratios to the least possible and to full Newton; growth with
    size; error against time, of models of the program and as [report.NAME] of a case says; Exudyn
    on the same models, where it is installed.
    """
    with _answering():
        from coupling.report import report as make

        _check_writable(output)
        _tell(
            _out(), make(what, name, output, _out(), large, settings or (), error, variants or ())
        )


if __name__ == "__main__":
    main()
