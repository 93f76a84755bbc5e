"""``thermobody export CASE --deck``: files for CalculiX, and what they leave out."""

from pathlib import Path
from typing import Any

from coupling.deck import Options, beams_of, deck, fineness_of
from coupling.deck_heat import history
from coupling.errors import BadCase
from coupling.model import Model, build
from coupling.scene import Scene

NAME = "deck.inp"
WHAT = {
    "statics": "equilibrium at the load factor 1",
    "modes": "vibrations about that equilibrium",
    "dynamics": "motion in time, in equal steps of the alpha method",
}
"""Analyses of a deck."""


def export_deck(scene: Scene, file: Path, linear: bool, out: Any) -> list[Path]:
    """Write the deck of a scene, and beside it one of its heat, where CalculiX can express it.

    Parameters
    ----------
    linear : small rotations
    out : rich console that is told what the decks are, and what to mistrust

    Raises
    ------
    BadCase : with one sentence for everything that is not written
    """
    model = build(beams_of(scene))
    options = Options(fineness_of(scene), large=False if linear else None)
    made = deck(scene, history(model), options)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(made.text)
    kind = WHAT[scene.analysis.kind]
    out.print(f"{kind}: {made.n} nodes, {made.cells} cells", markup=False)
    for warning in made.warnings:
        out.print(f"warning: {warning}", markup=False)
    return [file, *_heat_beside(scene, model, file, out)]


def _heat_beside(scene: Scene, model: Model, file: Path, out: Any) -> list[Path]:
    if scene.thermal is None:
        return []
    try:
        text = heat_deck(scene, model)
    except (ValueError, BadCase) as error:
        out.print(f"no deck of the heat: {error}", markup=False)
        return []
    beside = file.with_name(f"{file.stem}-heat{file.suffix}")
    beside.write_text(text)
    return [beside]


def heat_deck(scene: Scene, model: Model) -> str:
    """The heat of a scene: steady before statics and modes, over the whole time in dynamics.

    Raises
    ------
    ValueError, BadCase : CalculiX cannot express it, or is not installed
    """
    assert scene.thermal is not None
    if model.pair.surroundings is not None:
        raise ValueError(
            "light, contacts or heat of deformation come from motion, window by window"
        )
    own = scene.thermal.model_copy(update={"solver": "calculix"})
    solver: Any = build(beams_of(scene).model_copy(update={"thermal": own})).pair.heat_solver
    if scene.analysis.kind == "dynamics":
        return str(solver.deck(solver.initial(), 0.0, model.end))
    return str(solver.steady_deck(solver.initial(), model.end))
