"""All models of a case, stage by stage, against the finest continuum or what is known exactly."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.measured import Measured
from coupling.crosscheck.outside import measured_by
from coupling.crosscheck.pairing import paired, spectrum
from coupling.crosscheck.quantities import Quantity, deviation, remaining
from coupling.crosscheck.samples import material_points
from coupling.crosscheck.solved import Failed, Solved, asked
from coupling.crosscheck.stages import measured
from coupling.crosscheck_tables import Crosscheck
from coupling.errors import BadCase
from coupling.scene import Scene

Array = NDArray[np.float64]
Say = Callable[[str], None]

ANCF, CONTINUUM, EXACT = "ancf", "continuum", "exact"
OUTSIDE = ("calculix", "exudyn")
"""Participants that are other programs."""
SPARE = 4
"""Modes that a model computes beyond those of the reference that are sought."""


class Row(NamedTuple):
    """One quantity.

    values : participant -> as shown;  deviations : participant -> from the reference [-]
    tolerances : participant -> most that is allowed of it [-]
    error : float  what the reference itself may be wrong by, from its meshes [-]; nan: not known
    reference : participant, or "": there is none
    """

    stage: str
    quantity: str
    unit: str
    values: dict[str, float]
    deviations: dict[str, float]
    tolerances: dict[str, float]
    error: float
    reference: str

    @property
    def beyond(self) -> list[str]:
        """Participants that are farther away than allowed."""
        return [
            name
            for name, limit in self.tolerances.items()
            if name in self.deviations and not abs(self.deviations[name]) <= limit
        ]

    @property
    def unconverged(self) -> bool:
        """Whether the reference may be wrong by more than what beams are allowed."""
        return self.reference == CONTINUUM and self.error > self.tolerances.get(ANCF, math.inf)


class Comparison(NamedTuple):
    """meshes : of the continuum, coarsest first;  absent : participant -> why it is not there"""

    scene: Scene
    rows: list[Row]
    models: dict[str, Measured]
    meshes: list[Measured]
    absent: dict[str, str]

    @property
    def failures(self) -> list[str]:
        """One sentence for each quantity that is beyond its tolerance."""
        found = [why for m in self.models.values() for why in _missing(m)]
        for row in self.rows:
            if row.unconverged:
                text = f"the continuum is not converged, its error may be {row.error:.2%}"
                found.append(f"{row.stage}, {row.quantity}: {text}")
            for name in row.beyond:
                apart, limit = row.deviations[name], row.tolerances[name]
                text = f"{name} deviates by {apart:.2%}, and {limit:.2%} is allowed"
                found.append(f"{row.stage}, {row.quantity}: {text}")
        return found


def _missing(model: Measured) -> list[str]:
    """Stages that beams or the continuum could not do; other programs may pass."""
    if model.name in OUTSIDE:
        return []
    return [f"{stage}: {model.name} cannot: {why}" for stage, why in model.why.items()]


def compare(scene: Scene, wanted: Sequence[str], say: Say) -> Comparison:
    """Run all participants that are wanted and able.

    Parameters
    ----------
    wanted : participants besides beams: "continuum", "calculix", "exudyn"
    """
    table, absent = asked(scene), dict[str, str]()
    meshes = _meshes(scene, absent, say) if CONTINUUM in wanted else []
    _solved(ANCF, changed(scene, table.ancf), lambda text: None)  # kernels are compiled here
    models = {ANCF: _solved(ANCF, changed(scene, table.ancf), say)}
    if meshes:
        models[CONTINUUM] = meshes[-1]._replace(name=CONTINUUM)
    models |= _others(scene, [name for name in OUTSIDE if name in wanted], absent, say)
    _pair_modes(table, models, meshes)
    rows = [row for stage in table.stages for row in _rows(scene, stage, models, meshes)]
    return Comparison(scene, rows, models, meshes, absent)


def _meshes(scene: Scene, absent: dict[str, str], say: Say) -> list[Measured]:
    """The continuum on all its meshes; none where it cannot express the case."""
    found: list[Measured] = []
    every = asked(scene).continuum
    for number, changes in enumerate(every, 1):
        solid = {"mechanics.solver": "continuum", **changes}
        try:
            found.append(_solved(f"{CONTINUUM} {number}/{len(every)}", changed(scene, solid), say))
        except BadCase as error:
            absent[CONTINUUM] = "; ".join(p.text for p in error.problems)
            return []
    return found


def _others(
    scene: Scene, names: Iterable[str], absent: dict[str, str], say: Say
) -> dict[str, Measured]:
    """Other programs that are installed and able."""
    models = {}
    for name in names:
        found = measured_by(name, changed(scene, getattr(asked(scene), name)))
        if isinstance(found, str):
            absent[name] = found
        else:
            models[name] = found
            say(_told(found))
    return models


def changed(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The case with entries changed. Raises BadCase."""
    from coupling.casefile import from_text
    from coupling.overrides import literal, parse

    made = parse(f"{path}={literal(value)}" for path, value in changes.items())
    return from_text(scene.text, scene.folder, made)


def _solved(name: str, scene: Scene, say: Say) -> Measured:
    """All stages but frequencies, whose shapes wait to be paired."""
    solved = Solved(name, scene)
    found: dict[str, list[Quantity]] = {}
    why: dict[str, str] = {}
    for stage in asked(scene).stages:
        if stage == "frequencies":
            continue
        try:
            found[stage] = measured(solved, stage)
        except Failed as error:
            why[stage] = str(error)
    result = Measured(name, solved.dof, found, solved.seconds, why, solved)
    say(_told(result))
    return result


def _told(model: Measured) -> str:
    spent = sum(model.seconds.values())
    refused = "".join(f"; {stage}: {why}" for stage, why in model.why.items())
    return f"{model.name}: {model.dof} coordinates, {spent:.3g} s{refused}"


def _pair_modes(table: Crosscheck, models: dict[str, Measured], meshes: list[Measured]) -> None:
    """Frequencies of all models, in the order of those of the reference."""
    if "frequencies" not in table.stages:
        return
    reference = models.get(CONTINUUM, models[ANCF]).solved
    assert reference is not None
    points = material_points(reference.model)
    try:
        known = reference.vibrations(table.modes, points)
    except Failed as error:
        models[ANCF].why["frequencies"] = str(error)
        return
    for model in [*meshes, *models.values()]:
        if model.solved is not None:
            found = model.solved.vibrations(table.modes + SPARE, points)
            model.quantities["frequencies"] = spectrum(paired(found, known, table.modes))


# ------------------------------------------------------------------------------------ rows


def _rows(
    scene: Scene, stage: str, models: dict[str, Measured], meshes: list[Measured]
) -> Iterator[Row]:
    table = asked(scene)
    named = {
        name: {q.name: q for q in model.quantities.get(stage, [])} for name, model in models.items()
    }
    known = {e.quantity: e for e in table.exact.values() if e.stage == stage}
    for name, one in named[ANCF].items():
        there = {p: by_name[name] for p, by_name in named.items() if name in by_name}
        limits = _limits(table, stage, one.measure == "nothing", there)
        if name in known and not scene.overrides:
            there[EXACT] = one._replace(value=np.asarray(known[name].value, float))
            limits[EXACT] = known[name].tolerance
        yield _row(stage, there, limits, _alike(meshes, stage, name))


def _limits(
    table: Crosscheck, stage: str, vanishing: bool, there: Iterable[str]
) -> dict[str, float]:
    """What each participant may deviate; rigid modes have besides an elastic one."""
    own = "frequencies" if stage == "rigid_modes" and not vanishing else stage
    limit = getattr(table.tolerance, own)
    limits = {p: table.outside if p in OUTSIDE and not vanishing else limit for p in there}
    return {p: most for p, most in limits.items() if most is not None}


def _alike(meshes: list[Measured], stage: str, name: str) -> list[Quantity]:
    """A quantity on all meshes."""
    return [q for m in meshes for q in m.quantities.get(stage, []) if q.name == name]


def _row(
    stage: str, there: dict[str, Quantity], limits: dict[str, float], meshes: list[Quantity]
) -> Row:
    reference = next((p for p in (CONTINUUM, EXACT) if p in there), "")
    one = there[ANCF]
    if one.measure == "nothing":
        apart, reference = {p: deviation(q, q) for p, q in there.items()}, ""
    elif one.measure == "told":
        apart, reference, limits = {}, "", {}
    else:
        apart = {
            p: deviation(q, there[reference])
            for p, q in there.items()
            if reference and p != reference
        }
    error = remaining(meshes) if reference == CONTINUUM else float("nan")
    shown = {p: q.shown for p, q in there.items()}
    return Row(stage, one.name, one.unit, shown, apart, limits, error, reference)
