"""The materials of a case, and whether their data reach as far as its temperatures do."""

from collections.abc import Iterable, Iterator
from typing import Any

from coupling.body_tables import LineBody, ShellBody
from coupling.contact_tables import Sided, Telescope
from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.heat_tables import MaterialTable
from coupling.scene import ROOM_TEMPERATURE, Scene
from meshes.materials import Material, library, library_material

SLACK = 1e-6  # [K] by which rounding may carry a temperature beyond the data
MECHANICAL = {"youngs_modulus": "Pa", "poissons_ratio": "1", "expansion": "1/K"}
OF_HEAT = {"conductivity": "W/(m K)", "heat_capacity": "J/(kg K)"}
"""Units of the properties that every run needs, and of those that heat adds."""
BY_DIRECTION = ("conductivity_around", "conductivity_through")
"""Properties that a material may have besides."""


def material_of(scene: Scene, name: str) -> Material:
    """The material that a body, joint or part of the scene calls ``name``."""
    if name in scene.material:
        return from_table(name, scene.material[name])
    return library_material(name)


def from_table(name: str, table: MaterialTable) -> Material:
    """The material of a [material.NAME] table.

    Raises
    ------
    ValueError : it is impossible at some temperature of its range
    """
    units = MECHANICAL | OF_HEAT
    units |= {key: "W/(m K)" for key in BY_DIRECTION if getattr(table, key) is not None}
    laws = {key: getattr(table, key).property(key, unit) for key, unit in units.items()}
    return Material(name, table.density, **laws)


def material_problem(draft: Draft, name: str, where: str) -> Iterator[Problem]:
    """A material that is neither in the case nor in the library."""
    known = [*draft.names("material"), *library()]
    if name not in known:
        yield Problem(where, unknown("material", name, known))


def check_ranges(draft: Draft) -> Iterator[Problem]:
    """Impossible materials, and temperatures outside the data of the materials that take them."""
    materials: dict[str, Material] = {}
    for name, table in draft.named("material").items():
        try:
            materials[name] = from_table(name, table)
        except ValueError as error:
            yield Problem(f"material.{name}", str(error).removeprefix(f"material {name}: "))
    needed: dict[str, list[float]] = {}
    for name, temperatures in _uses(draft):
        needed.setdefault(name, []).extend(temperatures)
    for name, temperatures in needed.items():
        if name not in draft.names("material") and name in library():
            materials[name] = library_material(name)
        if name in materials and temperatures:
            yield from _uncovered(draft, materials[name], min(temperatures), max(temperatures))


def _uncovered(draft: Draft, material: Material, low: float, high: float) -> Iterator[Problem]:
    heat = "thermal" in draft.raw
    for p in material.properties:
        ends = [f"begin at {p.lower:g} K"] if low < p.lower - SLACK else []
        ends += [f"end at {p.upper:g} K"] if high > p.upper + SLACK else []
        if ends and (heat or p.name in MECHANICAL):
            needed = f"{low:g} K" if low == high else f"from {low:g} K to {high:g} K"
            text = f"{p.name} needed {needed} by this run, its data {' and '.join(ends)}"
            yield Problem(f"material.{material.name}", text)


def _uses(draft: Draft) -> Iterator[tuple[str, list[float]]]:
    """Each use of a material, with the temperatures that the scene itself names for it."""
    heat = draft.valid.get(("thermal",))
    start = [heat.initial] if heat is not None else []
    default = heat.initial if heat is not None else ROOM_TEMPERATURE
    for name, body in draft.named("body").items():
        if isinstance(body, LineBody | ShellBody):
            reference = body.reference_temperature or default
            yield body.material, [reference, *start, *_of_body(draft, name)]
    for joint in draft.named("joint").values():
        if isinstance(joint, Sided):
            reference = joint.reference_temperature or default
            yield joint.journal_material, [reference, *start]
            yield joint.bearing_material, [reference, *start]
        elif isinstance(joint, Telescope):
            tubes = [draft.named("body").get(name) for name in (joint.inner, joint.outer)]
            reference = joint.reference_temperature or default
            yield from ((t.material, [reference]) for t in tubes if isinstance(t, LineBody))
    for name, part in draft.named("thermal", "part").items():
        temperatures = [part.initial or default, *_of_part(draft, name)]
        yield part.material, temperatures
        yield from _of_side(draft, part.of, temperatures)
    for solid in draft.named("thermal", "solid").values():
        temperatures = [solid.initial or default]
        for material in {*solid.materials.values(), solid.material} - {None}:
            yield material, temperatures
        yield from _of_side(draft, solid.of, temperatures)


def _of_side(
    draft: Draft, of: str | None, temperatures: list[float]
) -> Iterator[tuple[str, list[float]]]:
    """The side of a joint takes the temperatures of its part."""
    joint, _, side = (of or "").rpartition(".")
    table = draft.named("joint").get(joint)
    if isinstance(table, Sided) and side in ("journal", "bearing"):
        yield getattr(table, f"{side}_material"), temperatures


def _of_body(draft: Draft, body: str) -> Iterator[float]:
    for wall in draft.named("thermal", "wall").values():
        if wall.body == body:
            yield from _extremes(draft, [history for side in wall.sides for history in side])
    for fixed in draft.named("thermal", "fixed").values():
        if fixed.at.body == body:
            yield from _extremes(draft, [fixed.temperature])


def _of_part(draft: Draft, part: str) -> Iterator[float]:
    for fixed in draft.named("thermal", "fixed").values():
        if fixed.at.part == part:
            yield from _extremes(draft, [fixed.temperature])


def _extremes(draft: Draft, histories: Iterable[Any]) -> Iterator[float]:
    span = draft.valid.get(("time",))
    for history in histories:
        yield from history.bounds(span.end if span is not None else 0.0)
