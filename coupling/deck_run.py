"""A scene computed by CalculiX, where it is installed: an outside opinion, stage by stage."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from coupling.deck import Deck, History, Options, beams_of, deck, fineness_of
from coupling.deck_results import Printed, read
from coupling.errors import BadCase, Problem
from coupling.opinion import Opinion, at_rest
from coupling.scene import Scene

Array = NDArray[np.float64]

PATIENCE = 3600.0  # [s] with one job
NAME = "CalculiX"


def solved(made: Deck, patience: float = PATIENCE) -> tuple[Printed, float]:
    """What CalculiX makes of a deck, and its run time [s].

    Raises
    ------
    ValueError : it is not installed, or did not finish
    """
    from thermal.calculix_program import executed, program
    from thermal.calculix_results import message

    chosen = program()
    with TemporaryDirectory(prefix="thermobody-deck-") as folder:
        job = Path(folder) / "deck"
        job.with_suffix(".inp").write_text(made.text)
        begun = perf_counter()
        said, code = executed(chosen, job, patience)
        seconds = perf_counter() - begun
        if code or "*ERROR" in said:
            raise ValueError(f"CalculiX ended with code {code}: {message(said)}")
        return read(job.with_suffix(".dat")), seconds


def opinion(scene: Scene, stage: str, options: Options | None = None) -> Opinion:
    """A stage of a scene by CalculiX.

    Parameters
    ----------
    stage : in ``STAGES``
    options : of the deck; None: cells as [mechanics] asks for them

    Raises
    ------
    BadCase : the deck cannot be written, or CalculiX is missing or did not finish
    """
    if stage not in STAGES:
        known = ", ".join(STAGES)
        raise BadCase(
            str(scene.folder), [Problem("", f"CalculiX has no stage '{stage}', only {known}")]
        )
    try:
        return STAGES[stage](scene, options or Options(fineness_of(scene)))
    except ValueError as error:
        raise BadCase(str(scene.folder), [Problem("", str(error))]) from None


def _heat(scene: Scene) -> History:
    from coupling.deck_heat import history
    from coupling.model import build

    return history(build(beams_of(scene)))


def _made(scene: Scene, options: Options) -> Deck:
    return deck(scene, _heat(scene), options)


def _at_rest(scene: Scene, options: Options) -> Opinion:
    if scene.analysis.kind == "dynamics":
        options = options._replace(moment=scene.time.end)
    made = _made(at_rest(scene, "statics"), options)
    found, seconds = solved(made)
    moved = {name: course[-1] for name, course in courses(made, found).items()}
    reaction = found.reaction[-1] - made.carried if len(found.reaction) else np.zeros(3)
    turned = {name: course[-1] for name, course in turns(made, found).items()}
    return _opinion(made, found, seconds)._replace(
        displacements=moved, reaction=reaction, turns=turned
    )


def _expanded(scene: Scene, options: Options) -> Opinion:
    return _at_rest(scene.model_copy(update={"load": {}, "gravity": None}), options)


def _frequencies(scene: Scene, options: Options) -> Opinion:
    if scene.analysis.kind == "dynamics":
        options = options._replace(moment=scene.time.end)
    made = _made(at_rest(scene, "modes"), options)
    found, seconds = solved(made)
    return _opinion(made, found, seconds)._replace(frequencies=found.frequencies)


def _transient(scene: Scene, options: Options) -> Opinion:
    if scene.analysis.kind != "dynamics":
        raise ValueError(f"a transient is of dynamics, and analysis.kind is {scene.analysis.kind}")
    made = _made(scene, options)
    found, seconds = solved(made)
    still = scene.analysis.start == "equilibrium"
    seen = found.times > (1.0 if still else 0.0)  # CalculiX counts the time of the statics before
    moved = {name: course[seen] for name, course in courses(made, found).items()}
    times = found.times[seen] - (1.0 if still else 0.0)
    turned = {name: course[seen] for name, course in turns(made, found).items()}
    return _opinion(made, found, seconds)._replace(times=times, courses=moved, turns=turned)


def _mass(scene: Scene, options: Options) -> Opinion:
    still = scene.model_copy(update={"thermal": None, "load": {}, "gravity": None})
    return _frequencies(still, options)


def _opinion(made: Deck, found: Printed, seconds: float) -> Opinion:
    densities = np.array([m.body.material.density for m in made.bodies.values()])
    mass = float(densities @ found.volumes) if len(found.volumes) == len(densities) else np.nan
    return Opinion(
        NAME, 3 * made.n, seconds, mass, temperatures=dict(made.temperatures),
        warnings=tuple(made.warnings),
    )  # fmt: skip


def courses(made: Deck, found: Printed) -> dict[str, Array]:
    """(k, 3) [m]  displacement of each probe at each time."""
    moved = {}
    for name, (section, offset) in made.probes.items():
        at = np.searchsorted(found.nodes, section.nodes)
        weights = section.place + offset[1] * section.along_2 + offset[2] * section.along_3
        moved[name] = np.einsum("n,knc->kc", weights, found.displacements[:, at])
    return moved


def turns(made: Deck, found: Printed) -> dict[str, Array]:
    """(k, 3) [rad]  rotation of the section of each probe of a beam at each time."""
    turned = {}
    for name, (section, _) in made.probes.items():
        if section.along_2.any():
            at = np.searchsorted(found.nodes, section.nodes)
            slopes = np.stack([section.along_2, section.along_3])
            now = np.einsum("sn,knc->ksc", slopes, found.displacements[:, at]) + section.axes[1:]
            turned[name] = np.array([_rotation(vectors, section.axes[1:]) for vectors in now])
    return turned


def _rotation(after: Array, before: Array) -> Array:
    """(3,) [rad]  that takes vectors to others, in the least-squares sense (Kabsch 1976)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.align_vectors(after, before)[0].as_rotvec())


STAGES: dict[str, Callable[[Scene, Options], Opinion]] = {
    "mass": _mass,
    "thermal_load": _expanded,
    "static": _at_rest,
    "frequencies": _frequencies,
    "transient": _transient,
}
"""What CalculiX is asked for, by name."""
