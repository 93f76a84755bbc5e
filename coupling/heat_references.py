"""Whether the tables under [thermal] fit the bodies, the joints and each other."""

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from coupling.body_tables import LineBody, ShellBody
from coupling.contact_tables import Sided
from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.heat_tables import ThermalPlace, Wall
from coupling.materials_used import material_problem
from coupling.places import distances
from thermal.solvers import SOLVERS

WHOLE = -1  # in place of a node: all of a shell
STATION_TOLERANCE = 1e-9  # how near to a stretch a node belongs to it, per length of the body


NO_CONDUCTION = (
    "its temperatures are those of a [thermal.wall.NAME]; conduction in shells is not there yet"
)


def check_heat(draft: Draft) -> list[Problem]:
    """Everything that does not fit under [thermal]."""
    if "thermal" not in draft.raw:
        return []
    found = [*_solver(draft), *_on_bodies(draft), *_parts(draft), *_places(draft)]
    return [*found, *_walls(draft), *_given_twice(draft), *_coverage(draft)]


def _solver(draft: Draft) -> Iterator[Problem]:
    heat = draft.valid.get(("thermal",))
    if heat is not None and heat.solver not in SOLVERS:
        yield Problem("thermal.solver", unknown("thermal solver", heat.solver, SOLVERS))


def _on_bodies(draft: Draft) -> Iterator[Problem]:
    for kind in ("wall", "flux", "radiation"):
        for name, table in draft.named("thermal", kind).items():
            given = kind == "wall" and table.body in _shells(draft)
            if not given:
                yield from _heated(draft, table.body, f"thermal.{kind}.{name}.body")


def _heated(draft: Draft, name: str, where: str) -> Iterator[Problem]:
    """Bodies that conduct: beams and cables."""
    if name not in draft.names("body"):
        yield Problem(where, unknown("body", name, draft.names("body")))
        return
    body = draft.named("body").get(name)
    if isinstance(body, ShellBody):
        yield Problem(where, f"'{name}' is a shell: {NO_CONDUCTION}")
    elif body is not None and not isinstance(body, LineBody):
        kind = "rigid body" if body.kind == "rigid" else body.kind
        yield Problem(where, f"'{name}' is a {kind}: it carries no temperature of [thermal]")


def _parts(draft: Draft) -> Iterator[Problem]:
    taken: dict[str, str] = {}
    for name, part in draft.named("thermal", "part").items():
        where = f"thermal.part.{name}"
        if name in draft.names("body"):
            yield Problem(where, "a body has the same name; give the part another")
        yield from material_problem(draft, part.material, f"{where}.material")
        if part.of is None:
            continue
        yield from _side_of_joint(draft, part.of, f"{where}.of")
        if part.of in taken:
            text = f"'{part.of}' is thermal.part.{taken[part.of]} already"
            yield Problem(f"{where}.of", text)
        taken.setdefault(part.of, name)


def _side_of_joint(draft: Draft, of: str, where: str) -> Iterator[Problem]:
    name, _, side = of.rpartition(".")
    joint = draft.named("joint").get(name)
    if side not in ("journal", "bearing") or not name:
        yield Problem(where, f"expected 'JOINT.journal' or 'JOINT.bearing', got '{of}'")
    elif name not in draft.names("joint"):
        yield Problem(where, unknown("joint", name, draft.names("joint")))
    elif joint is not None and not isinstance(joint, Sided):
        yield Problem(where, f"joint.{name} is a {joint.kind}: it has no {side}")


def _all_places(draft: Draft) -> Iterator[tuple[str, ThermalPlace]]:
    for kind, keys in {"fixed": ("at",), "source": ("at",), "link": ("a", "b")}.items():
        for name, table in draft.named("thermal", kind).items():
            for key in keys:
                place = getattr(table, key)
                if place is not None:
                    yield f"thermal.{kind}.{name}.{key}", place


def _places(draft: Draft) -> Iterator[Problem]:
    parts = draft.names("thermal", "part")
    for where, place in _all_places(draft):
        if place.body is not None:
            yield from _heated(draft, place.body, f"{where}.body")
        elif place.part not in parts:
            yield Problem(f"{where}.part", unknown("part", place.part, parts))
    for name, link in draft.named("thermal", "link").items():
        if link.a == link.b:
            yield Problem(f"thermal.link.{name}", "joins a place with itself")


# ---------------------------------------------------------------------- given temperatures


def _stations(draft: Draft, wall: Wall) -> Any:
    """Nodes of its body on the stretch of a wall."""
    along = distances(draft.points[wall.body])
    slack = STATION_TOLERANCE * along[-1]
    start, end = wall.start or 0.0, along[-1] if wall.end is None else wall.end
    return np.flatnonzero((along >= start - slack) & (along <= end + slack))


def _walls(draft: Draft) -> Iterator[Problem]:
    for name, wall in draft.named("thermal", "wall").items():
        if wall.body in _lines(draft):
            yield from _stretch(draft, wall, f"thermal.wall.{name}")
        elif wall.body in _shells(draft):
            yield from _faces(wall, f"thermal.wall.{name}")


def _faces(wall: Wall, where: str) -> Iterator[Problem]:
    """What a wall of a shell cannot have."""
    for key in ("start", "end"):
        if getattr(wall, key) is not None:
            yield Problem(f"{where}.{key}", "does not go with a shell: its wall is all of it")
    if wall.side is not None:
        text = "does not go with a shell: hot is on the side of its normal, along u x v"
        yield Problem(f"{where}.side", text)
    for key in ("hot", "cold", "temperature"):
        ends = getattr(wall, key)
        if ends is not None and ends[0] is not ends[1]:
            text = "a shell has no start and end: expected one temperature or its history"
            yield Problem(f"{where}.{key}", text)


def _shells(draft: Draft) -> list[str]:
    return [name for name, body in draft.named("body").items() if isinstance(body, ShellBody)]


def _lines(draft: Draft) -> list[str]:
    bodies = draft.named("body")
    return [name for name in draft.shapes if isinstance(bodies.get(name), LineBody)]


def _stretch(draft: Draft, wall: Wall, where: str) -> Iterator[Problem]:
    points = draft.points[wall.body]
    length = distances(points)[-1]
    start, end = wall.start or 0.0, length if wall.end is None else wall.end
    for key, value in (("start", start), ("end", end)):
        if not -STATION_TOLERANCE * length <= value <= (1.0 + STATION_TOLERANCE) * length:
            text = f"lies outside body '{wall.body}', from 0 to {length:g} m, got {value:g} m"
            yield Problem(f"{where}.{key}", text)
            return
    if end <= start:
        yield Problem(f"{where}.end", f"must be beyond the start, {start:g} m, got {end:g} m")
    elif not len(_stations(draft, wall)):
        yield Problem(where, f"no node of body '{wall.body}' lies on this stretch")
    if wall.temperature is None and wall.side is None:
        yield Problem(f"{where}.side", "missing (direction of the hot side)")
    if wall.side is None:
        return
    along = np.diff(points, axis=0)
    across = np.linalg.norm(np.cross(along, wall.side), axis=1) / np.linalg.norm(along, axis=1)
    if across.min() < 1e-6:
        yield Problem(f"{where}.side", f"is parallel to body '{wall.body}'")


def _given(draft: Draft) -> dict[str, set[tuple[str, int]]]:
    """The places (body or part, node) where each wall and each fixed gives the temperature."""
    given = {}
    for name, wall in draft.named("thermal", "wall").items():
        if wall.body in _shells(draft):
            given[f"thermal.wall.{name}"] = {(wall.body, WHOLE)}
        elif wall.body in draft.points:
            nodes = _stations(draft, wall)
            given[f"thermal.wall.{name}"] = {(wall.body, int(i)) for i in nodes}
    for name, fixed in draft.named("thermal", "fixed").items():
        place = fixed.at
        if place.part is not None:
            given[f"thermal.fixed.{name}"] = {(place.part, 0)}
        elif place.body in draft.points:
            last = len(draft.points[place.body]) - 1
            given[f"thermal.fixed.{name}"] = {(place.body, last if place.at == "end" else 0)}
    return given


def _given_twice(draft: Draft) -> Iterator[Problem]:
    for (one, first), (two, second) in combinations(_given(draft).items(), 2):
        if first & second:
            thing, node = min(first & second)
            at = ""
            if thing in draft.points and node != WHOLE:
                at = f" at {distances(draft.points[thing])[node]:g} m"
            yield Problem(two, f"gives the temperature of '{thing}'{at}, and so does {one}")


def _coverage(draft: Draft) -> Iterator[Problem]:
    """Temperatures that nothing computes must be given: of shells, and all with "prescribed"."""
    heat = draft.valid.get(("thermal",))
    if heat is None or _given_is_faulty(draft):
        return
    given = set().union(*_given(draft).values())
    for name in _shells(draft):
        if (name, WHOLE) not in given:
            yield Problem(f"body.{name}", f"has no wall: {NO_CONDUCTION}")
    if heat.solver != "prescribed":
        return
    for name, points in draft.points.items():
        free = [i for i in range(len(points)) if (name, i) not in given]
        if free and name in _lines(draft):
            at = distances(points)[free[0]]
            text = f"the prescribed solver needs a wall along all of it; none at {at:g} m"
            yield Problem(f"body.{name}", text)


def _given_is_faulty(draft: Draft) -> bool:
    return any(
        name not in draft.named("thermal", kind)
        for kind in ("wall", "fixed")
        for name in draft.names("thermal", kind)
    )
