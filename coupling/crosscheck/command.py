"""``thermobody crosscheck CASE``."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from coupling.crosscheck.comparison import CONTINUUM, OUTSIDE, compare
from coupling.crosscheck.picture import draw
from coupling.crosscheck.table import show, written
from coupling.errors import BadCase, Problem, unknown
from coupling.scene import Scene


def crosscheck(
    scene: Scene, wanted: Sequence[str] | None, folder: Path, out: Console
) -> tuple[list[Path], list[str]]:
    """Compare, print, write, draw; the files, and a sentence for each failure.

    Parameters
    ----------
    wanted : participants besides beams; None: all
    """
    names = [CONTINUUM, *OUTSIDE] if wanted is None else list(dict.fromkeys(wanted))
    wrong = [name for name in names if name not in (CONTINUUM, *OUTSIDE)]
    if wrong:
        known = (CONTINUUM, *OUTSIDE)
        raise BadCase("--with", [Problem("", unknown("participant", n, known)) for n in wrong])
    if scene.crosscheck is None:
        text = "missing (a table with stages and the meshes of the continuum says what to compare)"
        raise BadCase(str(scene.folder), [Problem("crosscheck", text)])
    result = compare(scene, names, lambda text: out.print(text, style="dim", markup=False))
    show(result, out)
    return [*written(result, folder), draw(result, folder / "crosscheck.png")], result.failures
