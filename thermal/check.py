"""What makes a thermal description senseless, all of it at once."""

from collections import Counter
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from math import isfinite

import numpy as np

from meshes.materials import Property
from thermal.composite import part_of
from thermal.description import (
    Condition,
    Description,
    Enclosure,
    Faces,
    Field,
    Film,
    Fixed,
    Flux,
    Interface,
    Irradiation,
    Link,
    Member,
    Part,
    Place,
    Radiation,
    Sheet,
    Side,
    Solid,
    Source,
    Wall,
)
from thermal.layout import (
    STATION_TOLERANCE,
    arclength,
    face_positions,
    given,
    layout,
    stations_within,
    wall_positions,
)
from thermal.limits import ALWAYS
from thermal.overlaps import solid_given_twice

OUTER = "outer"
ROOM = 300.0  # [K]
SAMPLES = 200  # temperatures at which an emissivity is looked at
Thing = Member | Part | Sheet | Solid


def check(description: Description) -> None:
    """Raise ValueError with one line for each problem of ``description``."""
    found = problems(description)
    if found:
        count = "1 problem" if len(found) == 1 else f"{len(found)} problems"
        raise ValueError("\n  ".join([f"thermal description: {count}", *found]))


def problems(description: Description) -> list[str]:
    """One sentence for each problem; what depends on a faulty member is not looked at."""
    d = description
    things: list[Thing] = [*d.members, *d.parts, *d.sheets, *d.solids]
    found = [] if things else ["it has neither members nor parts nor sheets nor solids"]
    found += _repeated("member, part, sheet or solid", [thing.name for thing in things])
    names = [x.name for x in (*d.conditions, *d.links, *d.interfaces)]
    found += _repeated("condition or link", names)
    of_things = [p for m in d.members for p in _member_problems(m)]
    of_things += [p for part in d.parts for p in _part_problems(part)]
    of_things += [p for sheet in d.sheets for p in _sheet_problems(sheet)]
    of_things += [p for solid in d.solids for p in _solid_problems(solid)]
    found += of_things
    if not of_things:
        found += [p for link in d.links for p in _link_problems(d, link)]
        found += [p for i in d.interfaces for p in _interface_problems(d, i)]
        found += [p for c in d.conditions for p in _condition_problems(d, c)]
    numbered = _names([*d.members, *d.parts, *d.sheets])
    if not found and numbered:
        found = _given_twice(part_of(d, numbered))
    return found or [p for s in d.solids for p in solid_given_twice(s, d.conditions)]


def _names(things: Sequence[Thing]) -> set[str]:
    return {thing.name for thing in things}


def _repeated(what: str, names: Sequence[str]) -> list[str]:
    return [f"{what} '{n}': the name is used {k} times" for n, k in Counter(names).items() if k > 1]


def _member_problems(m: Member) -> list[str]:
    name = f"member '{m.name}'"
    points, axes = np.asarray(m.points, dtype=float), np.asarray(m.axes, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        return [f"{name}: needs two or more points of three coordinates, got {points.shape}"]
    if axes.shape != (len(points), 3, 3):
        return [f"{name}: needs axes of shape {(len(points), 3, 3)}, got {axes.shape}"]
    if not (np.isfinite(points).all() and np.isfinite(axes).all()):
        return [f"{name}: points and axes must be finite numbers"]
    found = []
    if not (np.diff(arclength(points)) > 0.0).all():
        found.append(f"{name}: two neighbouring points coincide")
    if not np.allclose(axes @ axes.transpose(0, 2, 1), np.eye(3), rtol=0.0, atol=1e-6):
        found.append(f"{name}: its axes must be orthonormal")
    found += _wall_points_problems(m)
    properties = (*m.material.conductivities, m.material.heat_capacity)
    return found + _initial_problems(name, m.initial, properties)


def _wall_points_problems(m: Member) -> list[str]:
    n, kind = m.wall_points, m.section.kind
    if n == 1 or (n == 3 and kind in ("circle", "rectangle")):
        return []
    if kind != "tube":
        allowed = "1" if kind == "general" else "1, or 3 for its gradients"
        return [
            f"member '{m.name}': a section of kind '{kind}' has no wall; "
            f"wall_points must be {allowed}, got {n}"
        ]
    if n < 4 or n % 2:
        return [f"member '{m.name}': wall_points must be 1 or an even number from 4 on, got {n}"]
    return []


def _part_problems(p: Part) -> list[str]:
    name = f"part '{p.name}'"
    found = _initial_problems(name, p.initial, (p.material.heat_capacity,))
    if np.shape(p.position) != (3,) or not np.isfinite(p.position).all():
        found.append(f"{name}: its position must be three finite coordinates")
    if not (isfinite(p.mass) and p.mass > 0.0):
        found.append(f"{name}: its mass must be positive, got {p.mass}")
    if not (isfinite(p.area) and p.area >= 0.0):
        found.append(f"{name}: its area must be positive or zero, got {p.area}")
    return found


def _sheet_problems(s: Sheet) -> list[str]:
    name = f"sheet '{s.name}'"
    found = _initial_problems(name, s.initial, (s.material.heat_capacity,))
    if not (isfinite(s.thickness) and s.thickness > 0.0):
        found.append(f"{name}: its thickness must be positive, got {s.thickness}")
    normals = np.linalg.norm(np.cross(s.surface.d_u, s.surface.d_v), axis=1)
    if not (np.isfinite(normals) & (normals > 0.0)).all():
        found.append(f"{name}: it has no normal at some of its nodes")
    return found


def _solid_problems(s: Solid) -> list[str]:
    name = f"solid '{s.name}'"
    found = []
    for material in s.materials.values():
        properties = (*material.conductivities, material.heat_capacity)
        found += _initial_problems(name, s.initial, properties)
    regions = ["", *s.mesh.regions]
    found += [
        f"{name}: its mesh has no region '{region}'{_meant(region, regions)}"
        for region in s.materials
        if region not in regions
    ]
    if s.rubbing is not None and s.rubbing not in regions:
        found.append(f"{name}: its mesh has no region '{s.rubbing}'{_meant(s.rubbing, regions)}")
    return list(dict.fromkeys(found))


def _meant(name: str, names: Sequence[str]) -> str:
    near = get_close_matches(name, [n for n in names if n], 1)
    return f"; did you mean '{near[0]}'?" if near else ""


def _initial_problems(name: str, T: float, properties: Sequence[Property]) -> list[str]:
    if not (isfinite(T) and T > 0.0):
        return [f"{name}: its initial temperature must be above 0 K, got {T}"]
    return [
        f"{name}: initial temperature {T:g} K is outside the range of {p.name}, "
        f"{p.lower:g} K to {p.upper:g} K"
        for p in properties
        if not p.lower <= T <= p.upper
    ]


def _place_problems(d: Description, owner: str, place: Place) -> list[str]:
    ends = _ends(d, place.name)
    if ends is None:
        return [f"{owner}: there is no member, part, sheet or solid '{place.name}'"]
    if place.end is None or place.end in ends:
        return []
    if not ends:
        return [f"{owner}: part '{place.name}' has no ends, got {place.end!r}"]
    given = ", ".join(f"'{end}'" for end in ends)
    meant = _meant(place.end, list(ends))
    return [f"{owner}: of '{place.name}' give {given}, got {place.end!r}{meant}"]


def _named(d: Description, name: str) -> Thing | None:
    things: list[Thing] = [*d.members, *d.parts, *d.sheets, *d.solids]
    return next((thing for thing in things if thing.name == name), None)


def _ends(d: Description, name: str) -> tuple[str, ...] | None:
    """Places of a thing besides all of it; None: there is no such thing."""
    match _named(d, name):
        case Member():
            return ("start", "end")
        case Sheet():
            return ("top", "bottom")
        case Solid(mesh=mesh):
            return (OUTER, *mesh.regions)
        case Part():
            return ()
    return None


def _faces_of(d: Description, name: str) -> tuple[str, ...] | None:
    """Faces of a thing; None: there is no such thing."""
    match _named(d, name):
        case Member(section=section):
            return (OUTER, *(("inner",) if section.kind == "tube" else ()), "start", "end")
        case Sheet():
            return ("top", "bottom")
        case Part(area=area):
            return (OUTER,) if area > 0.0 else ()
        case Solid(mesh=mesh):
            return (OUTER, *mesh.regions)
    return None


def _side_problems_of(d: Description, owner: str, side: Side) -> list[str]:
    faces = _faces_of(d, side.thing)
    if faces is None:
        return [f"{owner}: there is no member, part, sheet or solid '{side.thing}'"]
    if side.face in faces:
        return []
    if not faces:
        return [f"{owner}: part '{side.thing}' has no area"]
    known = ", ".join(f"'{face}'" for face in faces)
    meant = _meant(side.face, faces)
    return [f"{owner}: '{side.thing}' has no face '{side.face}'; it has {known}{meant}"]


def _link_problems(d: Description, link: Link) -> list[str]:
    owner = f"link '{link.name}'"
    found = _place_problems(d, owner, link.a)
    if isinstance(link.b, Place):
        found += _place_problems(d, owner, link.b)
        if link.a == link.b:
            found.append(f"{owner}: both its ends are at the same place")
    for what, value in (("conductance", link.conductance), ("radiating area", link.radiating)):
        if value is not None and not (isfinite(value) and value >= 0.0):
            found.append(f"{owner}: {what} must be positive or zero, got {value}")
    return found


def _interface_problems(d: Description, x: Interface) -> list[str]:
    owner = f"interface '{x.name}'"
    found = _side_problems_of(d, owner, x.a) + _side_problems_of(d, owner, x.b)
    if x.a == x.b:
        found.append(f"{owner}: both its faces are the same")
    for what, value in (("coefficient", x.coefficient), ("radiating factor", x.radiating)):
        if not (isfinite(value) and value >= 0.0):
            found.append(f"{owner}: {what} must be positive or zero, got {value}")
    return found


def _wall_problems(d: Description, c: Wall) -> list[str]:
    member = next((m for m in d.members if m.name == c.member), None)
    if member is None:
        return [f"wall '{c.name}': there is no member '{c.member}'"]
    owner = f"wall '{c.name}'"
    length = arclength(member.points)[-1]
    slack = STATION_TOLERANCE * length
    if not -slack <= c.start <= c.end <= length + slack:
        return [
            f"{owner}: its stretch from {c.start:g} m to {c.end:g} m must lie within "
            f"member '{c.member}', which is {length:g} m long"
        ]
    if len(stations_within(member, c)) == 0:
        return [f"{owner}: no station of member '{c.member}' lies on its stretch"]
    return _side_problems(owner, member, c)


def _side_problems(owner: str, member: Member, c: Wall) -> list[str]:
    if c.side is None:
        same = c.hot == c.cold
        return [] if same else [f"{owner}: hot and cold differ, so it needs a side"]
    if np.shape(c.side) != (3,) or not np.isfinite(c.side).all() or not np.any(c.side):
        return [f"{owner}: side must be a direction, got {c.side}"]
    across = np.asarray(member.axes)[stations_within(member, c), 1:] @ np.asarray(c.side)
    if np.linalg.norm(across, axis=1).min() < 1e-6 * np.linalg.norm(c.side):
        return [f"{owner}: side is parallel to member '{c.member}'"]
    return []


def _flux_problems(d: Description, c: Flux) -> list[str]:
    found = _side_problems_of(d, f"flux '{c.name}'", Side(c.body, c.face))
    if c.direction is not None and (
        np.shape(c.direction) != (3,)
        or not np.isfinite(c.direction).all()
        or not np.any(c.direction)
    ):
        found.append(f"flux '{c.name}': direction must not be zero, got {c.direction}")
    if c.direction is not None and isinstance(_named(d, c.body), Part):
        rays = f"flux '{c.name}': parallel rays do not fall on part '{c.body}'"
        found.append(f"{rays}, which has no shape")
    return found


def _radiation_problems(d: Description, c: Radiation) -> list[str]:
    found = _side_problems_of(d, f"radiation '{c.name}'", Side(c.body, c.face))
    if isinstance(c.emissivity, Property):
        return found + _emissivity_problems(c.name, c.emissivity)
    if not 0.0 <= c.emissivity <= 1.0:
        found.append(f"radiation '{c.name}': emissivity must be 0 to 1, got {c.emissivity}")
    return found


def _emissivity_problems(name: str, p: Property) -> list[str]:
    ends = [end for end in (p.lower, p.upper) if isfinite(end)]
    inside = np.linspace(ends[0], ends[-1], SAMPLES) if ends else np.array([ROOM])
    T = np.sort(np.concatenate([ends, p.curve.knots, inside]))
    values = p(T)
    bad = np.flatnonzero(~((values >= 0.0) & (values <= 1.0)))
    if not len(bad):
        return []
    first = bad[0]
    text = f"emissivity must be 0 to 1, got {values[first]:g} at {T[first]:g} K"
    return [f"radiation '{name}': {text}"]


def _enclosure_problems(d: Description, c: Enclosure) -> Iterator[str]:
    owner = f"enclosure '{c.name}'"
    for side in c.sides:
        yield from _side_problems_of(d, owner, side)
    if not c.sides:
        yield f"{owner}: it has no faces"
    if len(set(c.sides)) < len(c.sides):
        yield f"{owner}: a face is named twice"
    if len(c.emissivities) != len(c.sides):
        yield f"{owner}: needs {len(c.sides)} emissivities, got {len(c.emissivities)}"
    for value in c.emissivities:
        if not 0.0 <= value <= 1.0:
            yield f"{owner}: emissivity must be 0 to 1, got {value}"
    if c.view_factors is not None:
        yield from _view_factor_problems(owner, np.asarray(c.view_factors), len(c.sides))


def _view_factor_problems(owner: str, F: np.ndarray, n: int) -> Iterator[str]:
    if F.shape != (n, n):
        yield f"{owner}: view factors must be {n} rows of {n}, got {F.shape}"
    elif not (np.isfinite(F).all() and (F >= 0.0).all()):
        yield f"{owner}: view factors must be 0 to 1"
    elif F.sum(axis=1).max() > 1.0 + 1e-6:
        yield f"{owner}: a row of the view factors sums to {F.sum(axis=1).max():g}, more than 1"


def _field_problems(d: Description, c: Field) -> list[str]:
    thing = _named(d, c.body)
    if not isinstance(thing, Member | Sheet | Solid):
        return [f"field '{c.name}': there is no body '{c.body}'"]
    return _reach_problems(c, _positions(thing))


def _positions(thing: Member | Sheet | Solid) -> np.ndarray:
    """(n, 3) [m]  where every solver has temperatures of a thing."""
    match thing:
        case Member():
            return wall_positions(thing)
        case Sheet():
            return face_positions(thing)
    return thing.mesh.points


def _reach_problems(c: Field, x: np.ndarray) -> list[str]:
    """A field is asked once, so that positions far from its data are told at once."""
    first, last = getattr(c.temperature, "times", ALWAYS)
    try:
        T = np.asarray(c.temperature(x, min(max(0.0, first), last)), dtype=float)
    except ValueError as error:
        return [f"field '{c.name}': {error}"]
    if T.shape != (len(x),):
        return [f"field '{c.name}': must give {len(x)} temperatures, got {T.shape}"]
    bad = T[~(np.isfinite(T) & (T >= 0.0))]
    text = f"field '{c.name}': temperatures must be above 0 K, got"
    return [f"{text} {bad[0]:g} K"] if len(bad) else []


def _condition_problems(d: Description, c: Condition) -> list[str]:
    match c:
        case Wall():
            return _wall_problems(d, c)
        case Faces():
            there = c.sheet in [s.name for s in d.sheets]
            return [] if there else [f"faces '{c.name}': there is no sheet '{c.sheet}'"]
        case Field():
            return _field_problems(d, c)
        case Flux():
            return _flux_problems(d, c)
        case Irradiation():
            return _side_problems_of(d, f"irradiation '{c.name}'", Side(c.body, c.face))
        case Film():
            return _side_problems_of(d, f"film '{c.name}'", Side(c.body, c.face))
        case Radiation():
            return _radiation_problems(d, c)
        case Enclosure():
            return list(_enclosure_problems(d, c))
        case Fixed():
            return _place_problems(d, f"fixed '{c.name}'", c.place)
        case Source():
            return _place_problems(d, f"source '{c.name}'", c.place)


def _given_twice(d: Description) -> list[str]:
    places = layout(d)
    region = {node: name for name, nodes in places.regions.items() for node in nodes.tolist()}
    givers: dict[int, list[str]] = {}
    twice: dict[tuple[str, str, str], None] = {}
    for condition in given(d, places.regions, places.x):
        for node in condition.nodes.tolist():
            before = givers.setdefault(node, [])
            twice |= dict.fromkeys((name, condition.name, region[node]) for name in before)
            before.append(condition.name)
    return [f"'{a}' and '{b}' both prescribe temperatures of '{where}'" for a, b, where in twice]
