"""Sweeps: a case at many points, in local processes or on a cluster, and what follows from it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from coupling.scene import Scene
    from coupling.sweeps.table import Sweep


def run(
    scene: "Scene",
    name: str,
    folder: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    console: Any = None,
) -> "Sweep":
    """Run the points of [sweep.NAME] of a case, and write tables and pictures.

    Points that are in the folder already are taken from there.

    Parameters
    ----------
    folder : of this sweep; made if it is not there
    workers : local processes; None: as many as there are cores
    scheduler : address of a Dask scheduler in place of local processes
    console : where progress is told; None: nowhere

    Raises
    ------
    BadCase : there is no such sweep, or a point of it makes the case a faulty one
    KeyboardInterrupt : after what is done has been kept
    """
    from coupling.sweeps.command import sweep

    return sweep(scene, name, folder, workers, scheduler, console)
