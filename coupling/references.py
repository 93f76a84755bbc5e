"""Whether the tables of a case fit each other: bodies, joints, loads, probes.

Every check looks at tables that are valid in themselves and returns all it finds. What refers to
a table that is there but faulty is left alone: the fault has been reported where it is.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.heat_references import check_heat
from coupling.materials_used import check_ranges, material_problem
from coupling.motion_tables import GROUND, ClearanceRevolute, LineBody, Particle, Site
from coupling.places import NODE_TOLERANCE, node_of, points_of


def check(draft: Draft) -> list[Problem]:
    """Everything in which the tables of ``draft`` do not fit; fills in ``draft.points``."""
    found = [*_bodies(draft), *_points(draft), *_joints(draft), *_loads(draft), *_probes(draft)]
    return [*found, *check_heat(draft), *check_ranges(draft)]


# --------------------------------------------------------------------------------- bodies


def _bodies(draft: Draft) -> Iterator[Problem]:
    for name, body in draft.named("body").items():
        if isinstance(body, LineBody):
            if body.section not in draft.names("section"):
                text = unknown("section", body.section, draft.names("section"))
                yield Problem(f"body.{name}.section", text)
            yield from material_problem(draft, body.material, f"body.{name}.material")


def _points(draft: Draft) -> Iterator[Problem]:
    for name, body in draft.named("body").items():
        try:
            draft.points[name] = points_of(body, draft.folder)
        except ValueError as error:
            yield Problem(f"body.{name}", str(error).removeprefix(f"{draft.folder}/"))


# ---------------------------------------------------------------------------------- sites


def _site(draft: Draft, site: Any, where: str) -> Iterator[Problem]:
    """What is wrong with a point of a body or of the ground."""
    if site.body == GROUND:
        if site.at is not None:
            yield Problem(
                f"{where}.at", "the ground has no such point; give a position, or nothing"
            )
        return
    if getattr(site, "position", None) is not None:
        yield Problem(f"{where}.position", "is for the ground only; a body takes at")
    if site.body not in draft.names("body"):
        yield Problem(f"{where}.body", unknown("body", site.body, [*draft.names("body"), GROUND]))
    body = draft.named("body").get(site.body)
    if isinstance(body, Particle) and site.at is not None:
        yield Problem(f"{where}.at", f"'{site.body}' is a particle: it is one point, leave at out")
    elif isinstance(body, LineBody):
        yield from _node(draft, site, f"{where}.at")


def _node(draft: Draft, site: Any, where: str) -> Iterator[Problem]:
    if site.at is None:
        yield Problem(where, f"missing ('start', 'end' or a distance along '{site.body}')")
    elif site.body in draft.points:
        try:
            node_of(draft.points[site.body], site.at)
        except ValueError as error:
            yield Problem(where, str(error))


def _position(draft: Draft, site: Site, other: Site) -> Any:
    """Where a faultless site is, (3,) [m]; the ground is where the other side is."""
    if site.body != GROUND:
        return draft.points[site.body][node_of(draft.points[site.body], site.at)]
    return _position(draft, other, site) if site.position is None else np.array(site.position)


# --------------------------------------------------------------------------------- joints

SIDES = {
    "clamp": ("a", "b"),
    "spherical": ("a", "b"),
    "revolute": ("a", "b"),
    "distance": ("a", "b"),
    "clearance_revolute": ("journal", "bearing"),
}


def _joints(draft: Draft) -> Iterator[Problem]:
    seen: dict[Any, str] = {}
    for name, joint in draft.named("joint").items():
        where = f"joint.{name}"
        sites = {side: getattr(joint, side) for side in SIDES[joint.kind]}
        found = [p for s, site in sites.items() for p in _site(draft, site, f"{where}.{s}")]
        found += _orientations(draft, joint, sites, where)
        if isinstance(joint, ClearanceRevolute):
            found += _clearance(draft, joint, where)
        if not found and _placed(draft, sites):
            found += _gap(draft, joint, sites, where)
            pair = joint.kind, frozenset(_point(draft, site) for site in sites.values())
            if pair in seen:
                text = f"holds the same points in the same way as joint.{seen[pair]}"
                found.append(Problem(where, text))
            seen.setdefault(pair, name)
        yield from found


def _placed(draft: Draft, sites: dict[str, Site]) -> bool:
    return all(site.body == GROUND or site.body in draft.points for site in sites.values())


def _point(draft: Draft, site: Site) -> tuple[str, int]:
    on_ground = site.body == GROUND
    return site.body, -1 if on_ground else node_of(draft.points[site.body], site.at)


def _orientations(
    draft: Draft, joint: Any, sites: dict[str, Site], where: str
) -> Iterator[Problem]:
    """Particles where a joint needs something that turns."""
    needed = {"clamp": ("a", "b"), "revolute": ("a", "b"), "clearance_revolute": ("bearing",)}
    driven = getattr(joint, "angle", None) is not None
    bodies = draft.named("body")
    for side, site in sites.items():
        turns = side in needed.get(joint.kind, ()) or driven
        if turns and isinstance(bodies.get(site.body), Particle):
            why = "cannot be driven" if driven else f"cannot be held by a {joint.kind}"
            text = f"'{site.body}' is a particle: it has no orientation and {why}"
            yield Problem(f"{where}.{side}.body", text)


def _clearance(draft: Draft, joint: ClearanceRevolute, where: str) -> Iterator[Problem]:
    from mechanics.contact import DISSIPATION

    for key in ("journal_material", "bearing_material"):
        yield from material_problem(draft, getattr(joint, key), f"{where}.{key}")
    law = joint.contact.dissipation
    if law not in DISSIPATION:
        yield Problem(f"{where}.contact.dissipation", unknown("hysteresis law", law, DISSIPATION))


def _gap(draft: Draft, joint: Any, sites: dict[str, Site], where: str) -> Iterator[Problem]:
    """Whether the two points are as far from each other as the joint asks."""
    (one, first), (two, second) = sites.items()
    if first.body == second.body == GROUND:
        yield Problem(where, "has the ground on both sides")
        return
    if _point(draft, first) == _point(draft, second):
        yield Problem(where, f"joins a point of '{first.body}' with itself")
        return
    gap = np.linalg.norm(_position(draft, first, second) - _position(draft, second, first))
    if joint.kind == "distance":
        if gap == 0.0:
            hint = "; give the ground a position" if GROUND in (first.body, second.body) else ""
            yield Problem(where, f"its two points coincide{hint}")
    elif joint.kind == "clearance_revolute":
        if gap > joint.clearance * (1.0 + 1e-9):
            text = f"starts {gap:g} m off the centre of the bearing, more than the clearance"
            yield Problem(f"{where}.journal", f"{text}, {joint.clearance:g} m")
    elif joint.kind != "clamp" and gap > NODE_TOLERANCE * _size(draft, sites):
        yield Problem(where, f"its points {one} and {two} are {gap:g} m apart")


def _size(draft: Draft, sites: dict[str, Site]) -> float:
    """Extent of the larger body [m]."""
    points = [draft.points[s.body] for s in sites.values() if s.body != GROUND]
    return max(float(np.ptp(p, axis=0).max()) for p in points)


# ------------------------------------------------------------------------ loads and probes


def _loads(draft: Draft) -> Iterator[Problem]:
    bodies = draft.named("body")
    for name, load in draft.named("load").items():
        where = f"load.{name}.at"
        if load.at.body == GROUND:
            yield Problem(f"{where}.body", "a load acts on a body, not on the ground")
            continue
        yield from _site(draft, load.at, where)
        body = bodies.get(load.at.body)
        if load.kind == "moment" and body is not None and body.kind != "beam":
            text = f"'{load.at.body}' is a {body.kind}: only beams take moments"
            yield Problem(f"{where}.body", text)


def _probes(draft: Draft) -> Iterator[Problem]:
    for name, probe in draft.named("probe").items():
        if probe.body == GROUND:
            yield Problem(f"probe.{name}.body", "the ground does not move; a probe sits on a body")
        else:
            yield from _site(draft, probe, f"probe.{name}")
