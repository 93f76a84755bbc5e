"""What makes a thermal description senseless, all of it at once."""

from collections import Counter
from collections.abc import Sequence
from math import isfinite

import numpy as np

from meshes.materials import Property
from thermal.description import (
    Condition,
    Description,
    Faces,
    Fixed,
    Flux,
    Link,
    Member,
    Part,
    Place,
    Radiation,
    Sheet,
    Source,
    Wall,
)
from thermal.layout import STATION_TOLERANCE, arclength, given, layout, stations_within


def check(description: Description) -> None:
    """Raise ValueError with one line for each problem of ``description``."""
    found = problems(description)
    if found:
        count = "1 problem" if len(found) == 1 else f"{len(found)} problems"
        raise ValueError("\n  ".join([f"thermal description: {count}", *found]))


def problems(description: Description) -> list[str]:
    """One sentence for each problem; what depends on a faulty member is not looked at."""
    d = description
    things: list[Member | Part | Sheet] = [*d.members, *d.parts, *d.sheets]
    found = [] if things else ["it has neither members nor parts nor sheets"]
    found += _repeated("member, part or sheet", [thing.name for thing in things])
    names = [c.name for c in d.conditions] + [link.name for link in d.links]
    found += _repeated("condition or link", names)
    of_things = [p for m in d.members for p in _member_problems(m)]
    of_things += [p for part in d.parts for p in _part_problems(part)]
    of_things += [p for sheet in d.sheets for p in _sheet_problems(sheet)]
    found += of_things
    if not of_things:
        found += [p for link in d.links for p in _link_problems(d, link)]
        found += [p for c in d.conditions for p in _condition_problems(d, c)]
    return found or _given_twice(d)


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
    properties = (m.material.conductivity, m.material.heat_capacity)
    return found + _initial_problems(name, m.initial, properties)


def _wall_points_problems(m: Member) -> list[str]:
    n = m.wall_points
    if n != 1 and (n < 4 or n % 2):
        return [f"member '{m.name}': wall_points must be 1 or an even number from 4 on, got {n}"]
    if n > 1 and m.section.kind != "tube":
        return [
            f"member '{m.name}': a section of kind '{m.section.kind}' has no wall; "
            f"wall_points must be 1, got {n}"
        ]
    return []


def _part_problems(p: Part) -> list[str]:
    name = f"part '{p.name}'"
    found = _initial_problems(name, p.initial, (p.material.heat_capacity,))
    if np.shape(p.position) != (3,) or not np.isfinite(p.position).all():
        found.append(f"{name}: its position must be three finite coordinates")
    if not (isfinite(p.mass) and p.mass > 0.0):
        found.append(f"{name}: its mass must be positive, got {p.mass}")
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
    is_member = place.name in [m.name for m in d.members]
    if not is_member and place.name not in [p.name for p in d.parts]:
        return [f"{owner}: there is no member or part '{place.name}'"]
    if is_member and place.end not in ("start", "end"):
        return [f"{owner}: at member '{place.name}' give 'start' or 'end', got {place.end!r}"]
    if not is_member and place.end is not None:
        return [f"{owner}: part '{place.name}' has no ends, got {place.end!r}"]
    return []


def _link_problems(d: Description, link: Link) -> list[str]:
    owner = f"link '{link.name}'"
    found = _place_problems(d, owner, link.a)
    if isinstance(link.b, Place):
        found += _place_problems(d, owner, link.b)
        if link.a == link.b:
            found.append(f"{owner}: both its ends are at the same place")
    if not (isfinite(link.conductance) and link.conductance >= 0.0):
        found.append(f"{owner}: conductance must be positive or zero, got {link.conductance}")
    return found


def _wall_problems(d: Description, c: Wall) -> list[str]:
    member = next((m for m in d.members if m.name == c.member), None)
    if member is None:
        return _member_missing(d, "wall", c)
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
    found = _member_missing(d, "flux", c)
    if c.direction is not None and (
        np.shape(c.direction) != (3,)
        or not np.isfinite(c.direction).all()
        or not np.any(c.direction)
    ):
        found.append(f"flux '{c.name}': direction must not be zero, got {c.direction}")
    return found


def _radiation_problems(d: Description, c: Radiation) -> list[str]:
    found = _member_missing(d, "radiation", c)
    if not 0.0 <= c.emissivity <= 1.0:
        found.append(f"radiation '{c.name}': emissivity must be 0 to 1, got {c.emissivity}")
    return found


def _condition_problems(d: Description, c: Condition) -> list[str]:
    match c:
        case Wall():
            return _wall_problems(d, c)
        case Faces():
            there = c.sheet in [s.name for s in d.sheets]
            return [] if there else [f"faces '{c.name}': there is no sheet '{c.sheet}'"]
        case Flux():
            return _flux_problems(d, c)
        case Radiation():
            return _radiation_problems(d, c)
        case Fixed():
            return _place_problems(d, f"fixed '{c.name}'", c.place)
        case Source():
            return _place_problems(d, f"source '{c.name}'", c.place)


def _member_missing(d: Description, kind: str, c: Wall | Flux | Radiation) -> list[str]:
    name = c.member if isinstance(c, Wall) else c.body
    if name in [m.name for m in d.members]:
        return []
    return [f"{kind} '{c.name}': there is no member '{name}'"]


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
