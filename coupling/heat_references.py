"""Whether the tables under [thermal] fit the bodies, the joints and each other."""

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from coupling.body_tables import LineBody, ShellBody
from coupling.contact_tables import Sided
from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.heat_faces import FaceTable
from coupling.heat_geometry import field_of, solid_mesh
from coupling.heat_tables import ThermalPlace, Wall
from coupling.materials_used import material_problem
from coupling.places import distances
from thermal.solvers import SOLVERS

EXTERNAL = "external"  # the solver that is another process
WHOLE = -1  # in place of a node: all of a shell
STATION_TOLERANCE = 1e-9  # how near to a stretch a node belongs to it, per length of the body


FACES = {"line": ("outer", "inner", "start", "end"), "shell": ("top", "bottom")}
"""Faces of bodies; the first one is meant where a line names none."""
ENDS = {"line": ("start", "end"), "shell": ("top", "bottom")}
"""Places of bodies besides all of them."""


def check_heat(draft: Draft) -> list[Problem]:
    """Everything that does not fit under [thermal]."""
    if "thermal" not in draft.raw:
        return [Problem("output.skins", "there is no [thermal]")] if _skins(draft) else []
    found = [*_skin_names(draft)]
    found += [*_solver(draft), *_on_bodies(draft), *_on_faces(draft), *_parts(draft)]
    found += [*_solids(draft), *_fields(draft), *_places(draft), *_walls(draft)]
    found += [*_contacts(draft), *_elastic(draft), *_environment(draft)]
    return [*found, *_given_twice(draft), *_coverage(draft)]


def _skins(draft: Draft) -> list[str]:
    output = draft.valid.get(("output",))
    return [] if output is None else output.skins


def _skin_names(draft: Draft) -> Iterator[Problem]:
    solids = draft.names("thermal", "solid")
    analysis = draft.valid.get(("analysis",))
    if _skins(draft) and analysis is not None and analysis.kind != "dynamics":
        yield Problem("output.skins", f"are recorded over time, not in {analysis.kind}")
    for i, name in enumerate(_skins(draft)):
        if name not in solids and _kind(draft, name) is None:
            flexible = [n for n in draft.named("body") if _kind(draft, n)]
            text = unknown("flexible body or solid", name, [*flexible, *solids])
            yield Problem(f"output.skins[{i}]", text)


def _solver(draft: Draft) -> Iterator[Problem]:
    heat = draft.valid.get(("thermal",))
    if heat is None:
        return
    if heat.solver not in [*SOLVERS, EXTERNAL]:
        yield Problem(
            "thermal.solver", unknown("thermal solver", heat.solver, [*SOLVERS, EXTERNAL])
        )
    if heat.solver == EXTERNAL and heat.participant is None:
        yield Problem("thermal.participant", "missing: where the external solver listens")
    if heat.solver != EXTERNAL and heat.participant is not None:
        text = f"belongs to the solver '{EXTERNAL}', not to '{heat.solver}'"
        yield Problem("thermal.participant", text)
    if heat.solver == EXTERNAL:
        for name in ("environment", "elastic"):
            if getattr(heat, name) is not None:
                text = (
                    "needs the faces or sections of a solver of this process, not an external one"
                )
                yield Problem(f"thermal.{name}", text)


def _on_bodies(draft: Draft) -> Iterator[Problem]:
    for kind in ("wall", "field"):
        for name, table in draft.named("thermal", kind).items():
            yield from _heated(draft, table.body, f"thermal.{kind}.{name}.body")


def _heated(draft: Draft, name: str, where: str) -> Iterator[Problem]:
    """Bodies that conduct: beams, cables and shells."""
    if name not in draft.names("body"):
        yield Problem(where, unknown("body", name, draft.names("body")))
        return
    body = draft.named("body").get(name)
    if body is not None and not isinstance(body, LineBody | ShellBody):
        kind = "rigid body" if body.kind == "rigid" else body.kind
        text = f"'{name}' is a {kind}: it carries no temperature of [thermal]"
        yield Problem(where, f"{text}; a [thermal.part.NAME] or [thermal.solid.NAME] can")


def _kind(draft: Draft, name: str) -> str | None:
    """Kind of a body in ``FACES``; None: not known."""
    body = draft.named("body").get(name)
    if isinstance(body, LineBody):
        return "line"
    return "shell" if isinstance(body, ShellBody) else None


# ------------------------------------------------------------------------------------- faces


def _all_faces(draft: Draft) -> Iterator[tuple[str, FaceTable]]:
    for kind in ("flux", "film", "radiation", "surface"):
        for name, table in draft.named("thermal", kind).items():
            yield f"thermal.{kind}.{name}", table
    for name, table in draft.named("thermal", "enclosure").items():
        for i, face in enumerate(table.faces):
            yield f"thermal.enclosure.{name}.faces[{i}]", face
    for name, table in draft.named("thermal", "interface").items():
        yield f"thermal.interface.{name}.a", table.a
        yield f"thermal.interface.{name}.b", table.b


def _on_faces(draft: Draft) -> Iterator[Problem]:
    for where, face in _all_faces(draft):
        if face.body is not None:
            yield from _heated(draft, face.body, f"{where}.body")
            yield from _face_of_body(draft, face, where)
        elif face.part is not None:
            yield from _face_of_part(draft, face.part, f"{where}.part")
        elif face.solid not in draft.names("thermal", "solid"):
            text = unknown("solid", str(face.solid), draft.names("thermal", "solid"))
            yield Problem(f"{where}.solid", text)
        elif face.face is not None:
            yield from _region(draft, str(face.solid), face.face, f"{where}.face")


def _face_of_body(draft: Draft, face: FaceTable, where: str) -> Iterator[Problem]:
    kind = _kind(draft, str(face.body))
    if kind is None:
        return
    if face.face is None:
        if kind == "shell":
            text = "missing (of a shell 'top', on the side of its normal along u x v, or 'bottom')"
            yield Problem(f"{where}.face", text)
    elif face.face not in FACES[kind]:
        yield Problem(f"{where}.face", unknown("face", face.face, FACES[kind]))
    elif face.face == "inner" and not _is_tube(draft, str(face.body)):
        yield Problem(f"{where}.face", f"body '{face.body}' is no tube: it has no inner face")


def _is_tube(draft: Draft, name: str) -> bool:
    body = draft.named("body")[name]
    section = draft.named("section").get(body.section)
    return section is None or section.kind == "tube"


def _face_of_part(draft: Draft, name: str, where: str) -> Iterator[Problem]:
    parts = draft.named("thermal", "part")
    if name not in draft.names("thermal", "part"):
        yield Problem(where, unknown("part", name, draft.names("thermal", "part")))
    elif name in parts and parts[name].area == 0.0:
        yield Problem(where, f"thermal.part.{name} has no face: give it an area")


# ------------------------------------------------------------------------------------ solids


def _mesh(draft: Draft, name: str) -> Any:
    """Mesh of a solid, or the sentence why there is none; None where the table is faulty."""
    table = draft.named("thermal", "solid").get(name)
    if table is None:
        return None
    try:
        return solid_mesh(draft.folder, table, 1)
    except ValueError as error:
        return str(error)


def _solids(draft: Draft) -> Iterator[Problem]:
    for name, table in draft.named("thermal", "solid").items():
        where = f"thermal.solid.{name}"
        if name in draft.names("body") or name in draft.names("thermal", "part"):
            yield Problem(where, "a body or part has the same name; give the solid another")
        for key, material in [("material", table.material), *table.materials.items()]:
            if material is not None:
                path = key if key == "material" else f"materials.{key}"
                yield from material_problem(draft, material, f"{where}.{path}")
        mesh = _mesh(draft, name)
        if isinstance(mesh, str):
            yield Problem(f"{where}.mesh", mesh)
            continue
        for region in table.materials:
            yield from _region(draft, name, region, f"{where}.materials.{region}")
        if table.rubbing is not None:
            yield from _region(draft, name, table.rubbing, f"{where}.rubbing")


def _region(draft: Draft, name: str, region: str, where: str) -> Iterator[Problem]:
    mesh = _mesh(draft, name)
    if mesh is not None and not isinstance(mesh, str) and region not in ("outer", *mesh.regions):
        yield Problem(where, unknown("region", region, ["outer", *mesh.regions]))


def _fields(draft: Draft) -> Iterator[Problem]:
    for name, table in draft.named("thermal", "field").items():
        where = f"thermal.field.{name}"
        if table.body not in draft.shapes:
            continue
        if table.file is None and _kind(draft, table.body) == "shell":
            yield Problem(f"{where}.distances", "a table is for beams and cables; give a file")
            continue
        at = f"{where}.file" if table.file else where
        try:
            field = field_of(draft.folder, draft.shapes, table)
            field(draft.points[table.body], field.times[0])
        except ValueError as error:
            yield Problem(at, str(error))
            continue
        span = draft.valid.get(("time",))
        first, last = field.times
        if span is not None and (first > 0.0 or last < span.end * (1.0 - 1e-9)):
            text = f"known from {first:g} s to {last:g} s, the run goes from 0 to {span.end:g} s"
            yield Problem(at, text)


# ------------------------------------------------------------------------- parts and places


def _parts(draft: Draft) -> Iterator[Problem]:
    for name, part in draft.named("thermal", "part").items():
        where = f"thermal.part.{name}"
        if name in draft.names("body"):
            yield Problem(where, "a body has the same name; give the part another")
        yield from material_problem(draft, part.material, f"{where}.material")
    taken: dict[str, str] = {}
    for kind in ("part", "solid"):
        for name, table in draft.named("thermal", kind).items():
            where = f"thermal.{kind}.{name}"
            if table.of is None:
                continue
            yield from _side_of_joint(draft, table.of, f"{where}.of")
            if table.of in taken:
                yield Problem(f"{where}.of", f"'{table.of}' is {taken[table.of]} already")
            taken.setdefault(table.of, where)


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
            kind = _kind(draft, place.body)
            if kind and place.at is not None and place.at not in ENDS[kind]:
                yield Problem(f"{where}.at", unknown("place", place.at, ENDS[kind]))
        elif place.solid is not None:
            yield from _place_of_solid(draft, place, where)
        elif place.part not in parts:
            yield Problem(f"{where}.part", unknown("part", str(place.part), parts))
    for name, link in draft.named("thermal", "link").items():
        if link.a == link.b:
            yield Problem(f"thermal.link.{name}", "joins a place with itself")


def _contacts(draft: Draft) -> Iterator[Problem]:
    sides = {
        table.of for kind in ("part", "solid") for table in draft.named("thermal", kind).values()
    }
    taken: dict[str, str] = {}
    for name, table in draft.named("thermal", "contact").items():
        where = f"thermal.contact.{name}.joint"
        joint = draft.named("joint").get(table.joint)
        if table.joint not in draft.names("joint"):
            yield Problem(where, unknown("joint", table.joint, draft.names("joint")))
        elif joint is not None and not isinstance(joint, Sided):
            yield Problem(where, f"joint.{table.joint} is a {joint.kind}: it has no clearance")
        elif table.joint in taken:
            yield Problem(where, f"thermal.contact.{taken[table.joint]} is of this joint already")
        for side in ("journal", "bearing") if isinstance(joint, Sided) else ():
            if f"{table.joint}.{side}" not in sides:
                text = f"no part or solid is of '{table.joint}.{side}', which would take the heat"
                yield Problem(where, text)
        taken.setdefault(table.joint, name)


def _elastic(draft: Draft) -> Iterator[Problem]:
    heat = draft.valid.get(("thermal",))
    for i, name in enumerate(heat.elastic.bodies if heat is not None and heat.elastic else ()):
        where = f"thermal.elastic.bodies[{i}]"
        if name not in draft.names("body"):
            yield Problem(where, unknown("body", name, draft.names("body")))
        elif name in draft.named("body") and _kind(draft, name) != "line":
            yield Problem(where, f"'{name}' is no beam or cable")


def _environment(draft: Draft) -> Iterator[Problem]:
    heat = draft.valid.get(("thermal",))
    surfaces = draft.names("thermal", "surface")
    if heat is None:
        return
    if heat.environment is None:
        for name in surfaces:
            yield Problem(f"thermal.surface.{name}", "needs a [thermal.environment] to light it")
        return
    if not surfaces:
        yield Problem("thermal.environment", "lights nothing: no [thermal.surface.NAME]")
    from coupling.environments import environment

    try:
        environment(heat.environment)
    except ValueError as error:
        for line in str(error).splitlines():
            yield Problem("thermal.environment", line)


def _place_of_solid(draft: Draft, place: ThermalPlace, where: str) -> Iterator[Problem]:
    solids = draft.names("thermal", "solid")
    if place.solid not in solids:
        yield Problem(f"{where}.solid", unknown("solid", str(place.solid), solids))
    elif place.at is not None:
        yield from _region(draft, str(place.solid), place.at, f"{where}.at")


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
            yield from _sides(draft, wall, f"thermal.wall.{name}")
        elif wall.body in _shells(draft):
            yield from _faces(wall, f"thermal.wall.{name}")


def _sides(draft: Draft, wall: Wall, where: str) -> Iterator[Problem]:
    """Hot and cold sides that the sections of a body cannot tell apart."""
    table, body = draft.valid.get(("thermal",)), draft.named("body").get(wall.body)
    section = draft.named("section").get(getattr(body, "section", ""))
    alike = wall.temperature is not None or wall.hot == wall.cold
    if table is None or section is None or alike or table.solver == "solid":
        return
    if section.kind == "tube" and table.wall_points == 1:
        text = "differs from cold, and thermal.wall_points = 1 knows no sides; give 4 or more"
        yield Problem(f"{where}.hot", text)
    if section.kind in ("circle", "rectangle") and table.full_sections == "mean":
        text = f"differs from cold, and only the mean of a {section.kind} is computed; "
        yield Problem(f"{where}.hot", f"{text}give thermal.full_sections = 'gradients'")


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
    for name, field in draft.named("thermal", "field").items():
        if field.body in draft.points:
            given[f"thermal.field.{name}"] = _all_of(draft, field.body)
    for name, fixed in draft.named("thermal", "fixed").items():
        given[f"thermal.fixed.{name}"] = _held(draft, fixed.at)
    return given


def _all_of(draft: Draft, body: str) -> set[tuple[str, int]]:
    if body in _shells(draft):
        return {(body, WHOLE)}
    return {(body, i) for i in range(len(draft.points[body]))}


def _held(draft: Draft, place: ThermalPlace) -> set[tuple[str, int]]:
    """Nodes whose temperature a place holds; of solids nothing is known here."""
    if place.part is not None:
        return {(place.part, 0)}
    if place.body not in draft.points:
        return set()
    if place.at is None:
        return _all_of(draft, place.body)
    if place.body in _shells(draft):
        return set()
    return {(place.body, len(draft.points[place.body]) - 1 if place.at == "end" else 0)}


def _given_twice(draft: Draft) -> Iterator[Problem]:
    for (one, first), (two, second) in combinations(_given(draft).items(), 2):
        if first & second:
            thing, node = min(first & second)
            at = ""
            if thing in draft.points and node != WHOLE:
                at = f" at {distances(draft.points[thing])[node]:g} m"
            yield Problem(two, f"gives the temperature of '{thing}'{at}, and so does {one}")


def _coverage(draft: Draft) -> Iterator[Problem]:
    """With the solver "prescribed", which computes nothing, all temperatures must be given."""
    heat = draft.valid.get(("thermal",))
    if heat is None or heat.solver != "prescribed" or _given_is_faulty(draft):
        return
    given = set().union(*_given(draft).values())
    for name in _shells(draft):
        if (name, WHOLE) not in given:
            yield Problem(f"body.{name}", "the prescribed solver needs its wall or field")
    for name, points in draft.points.items():
        free = [i for i in range(len(points)) if (name, i) not in given]
        if free and name in _lines(draft):
            at = distances(points)[free[0]]
            text = f"the prescribed solver needs a wall along all of it; none at {at:g} m"
            yield Problem(f"body.{name}", text)


def _given_is_faulty(draft: Draft) -> bool:
    return any(
        name not in draft.named("thermal", kind)
        for kind in ("wall", "fixed", "field")
        for name in draft.names("thermal", kind)
    )
