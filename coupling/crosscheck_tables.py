"""[crosscheck]: what a case compares between models that share no element, and how closely."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from coupling import quantities
from coupling.body_tables import LineBody
from coupling.draft import Draft
from coupling.errors import Problem, suggestion
from coupling.fields import Count, Quantity, Table

Stage = Literal[
    "mass", "rigid_modes", "thermal_load", "static", "frequencies", "transient", "contact",
    "pointing",
]  # fmt: skip
STAGES: dict[str, str] = {
    "mass": "mass, centre of mass, principal moments of inertia",
    "rigid_modes": "a body that nothing holds: six motions without frequency or strain",
    "thermal_load": "free expansion: how far heat alone moves the probes, along and across",
    "static": "displacement of the probes in equilibrium under loads and heat",
    "frequencies": "vibrations about that equilibrium, paired by their shapes",
    "transient": "displacement of the probes over time",
    "contact": "normal force, friction work and temperatures of joints with clearance",
    "pointing": "rotation of the section at the probes",
}
"""The stages, from the simplest on."""
Deviation = Annotated[float, Quantity(quantities.NUMBER, above=0.0)]
Changes = dict[str, Any]
PAPER = 0.025
"""Deviation of beams from a 3D continuum that Hua et al. (2026) claim [-]."""


class Tolerances(Table):
    """[crosscheck.tolerance]: largest deviation from the converged continuum, by stage."""

    mass: Deviation = PAPER
    rigid_modes: Deviation = Field(
        default=1e-3, description="of frequency and energy, over those of the first elastic mode"
    )
    thermal_load: Deviation = PAPER
    static: Deviation = PAPER
    frequencies: Deviation = PAPER
    transient: Deviation = PAPER
    contact: Deviation = PAPER
    pointing: Deviation = PAPER


class Exact(Table):
    """[crosscheck.exact.NAME]: a value from a formula, or from a model outside this program."""

    stage: Stage = Field(description="to which it belongs")
    quantity: str = Field(description="as the table of 'thermobody crosscheck' names it")
    value: float | list[float] = Field(description="in the unit of that table; a vector: all of it")
    source: str = Field(description="formula or reference")
    tolerance: Deviation = Field(
        default=PAPER, description="largest deviation from the converged continuum"
    )


class Crosscheck(Table):
    """[crosscheck]: stages, tolerances, and what each model changes in the case."""

    stages: list[Stage] = Field(description="what is compared; 'thermobody list' names them all")
    modes: Annotated[int, Count(most=100)] = Field(default=6, description="of frequencies")
    tolerance: Tolerances = Field(default_factory=Tolerances)
    continuum: list[Changes] = Field(
        description="entries changed in the 3D model, one table for each mesh, the coarsest first: "
        '[{ "mechanics.along" = 20 }, { "mechanics.along" = 40 }]'
    )
    ancf: Changes = Field(default_factory=dict, description="entries changed in the model of beams")
    calculix: Changes = Field(default_factory=dict, description="likewise, of the CalculiX deck")
    exudyn: Changes = Field(default_factory=dict, description="likewise, of the Exudyn model")
    outside: Deviation | None = Field(
        default=None,
        description="largest deviation of CalculiX and Exudyn; absent: they are shown, not judged",
    )
    exact: dict[str, Exact] = Field(default_factory=dict, description="values known otherwise")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not self.stages:
            yield "stages", "needs at least one stage"
        if len(set(self.stages)) < len(self.stages):
            yield "stages", "names a stage twice"
        for name, exact in self.exact.items():
            if exact.stage not in self.stages:
                yield f"exact.{name}.stage", f"'{exact.stage}' is not among the stages"


def check_crosscheck(draft: Draft) -> Iterator[Problem]:
    """Stages that the case has nothing for, and entries that no override can reach."""
    table = draft.valid.get(("crosscheck",))
    if table is None:
        return
    for i, stage in enumerate(table.stages):
        why = _unable(draft, stage)
        if why:
            yield Problem(f"crosscheck.stages[{i}]", f"'{stage}': {why}")
    for key, changes in _all_changes(table):
        for path in changes:
            if path.split(".")[0] not in KNOWN:
                hint = suggestion(path.split(".")[0], KNOWN)
                yield Problem(f"crosscheck.{key}", f"there is no entry '{path}' of a case{hint}")


KNOWN = (
    "time", "coupling", "integrator", "analysis", "damping", "generate", "material", "section",
    "body", "joint", "load", "gravity", "thermal", "mechanics", "probe", "output",
)  # fmt: skip
"""Tables that a model may change."""


def _all_changes(table: Crosscheck) -> Iterator[tuple[str, Changes]]:
    yield from ((f"continuum[{i}]", changes) for i, changes in enumerate(table.continuum))
    yield from ((key, getattr(table, key)) for key in ("ancf", "calculix", "exudyn"))


def _unable(draft: Draft, stage: str) -> str:
    """Why a case has nothing to compare at a stage; "": it has."""
    analysis = draft.valid.get(("analysis",))
    kind = "dynamics" if analysis is None else analysis.kind
    loose = [j for j in draft.raw.get("joint", {}).values() if _is_loose(j)]
    if stage in ("thermal_load", "static", "transient", "pointing") and not draft.raw.get("probe"):
        return "needs a [probe.NAME], at which it is read"
    if stage == "rigid_modes" and not any(
        isinstance(body, LineBody) for body in draft.named("body").values()
    ):
        return "needs a flexible body"
    if stage == "thermal_load":
        return _not_free(draft)
    if stage in ("static", "frequencies") and loose:
        return "joints with clearance have no equilibrium of their own"
    if stage in ("transient", "contact") and kind != "dynamics":
        return f"needs motion in time, and the [analysis] is {kind}"
    if stage == "contact" and not loose:
        return "no joint has clearance"
    return ""


def _is_loose(joint: Any) -> bool:
    kind = joint.get("kind", "") if isinstance(joint, dict) else ""
    return isinstance(kind, str) and (kind.startswith("clearance") or kind == "telescope")


def _not_free(draft: Draft) -> str:
    """Why heat alone would not expand a case freely."""
    if draft.raw.get("thermal") is None:
        return "the case has no heat"
    kinds = [j.get("kind") for j in draft.raw.get("joint", {}).values() if isinstance(j, dict)]
    if len(draft.raw.get("body", {})) != 1 or kinds != ["clamp"]:
        return "expansion is free only of one body that one clamp holds"
    return ""
