"""Whether joints fit the bodies and each other."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.body_tables import LineBody, family_of
from coupling.contact_tables import (
    ClearanceCylindrical,
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    Loose,
    Sided,
    Telescope,
)
from coupling.draft import Draft
from coupling.errors import Problem, alternatives, unknown
from coupling.materials_used import material_problem
from coupling.places import NODE_TOLERANCE, place_of
from coupling.site_references import (
    check_site,
    is_placed,
    point_key,
    position_of,
    turning_problem,
)
from coupling.site_tables import GROUND, Site
from mechanics.elements import FAMILIES

Array = NDArray[np.float64]

SIDES: dict[str, tuple[str, ...]] = {
    "clamp": ("a", "b"),
    "spherical": ("a", "b"),
    "revolute": ("a", "b"),
    "universal": ("a", "b"),
    "cylindrical": ("a", "b"),
    "prismatic": ("a", "b"),
    "planar": ("a", "b"),
    "axial_drive": ("a", "b"),
    "distance": ("a", "b"),
    "guide": ("a",),
    "fixing": ("a",),
    "sliding": ("a",),
    "gear": (),
    "pulley": (),
    "latch": (),
    "spring": ("a", "b"),
    "torsion_spring": (),
    "bushing": ("a", "b"),
    "clearance_revolute": ("journal", "bearing"),
    "clearance_spherical": ("journal", "bearing"),
    "clearance_cylindrical": ("journal", "bearing"),
    "clearance_translational": ("journal", "bearing"),
    "telescope": (),
}
"""Every kind of joint, and the keys of the points that it joins."""

ORIENTED = {
    **dict.fromkeys(
        ("clamp", "revolute", "universal", "cylindrical", "prismatic", "planar", "bushing"),
        ("a", "b"),
    ),
    "axial_drive": ("b",),
    "clearance_revolute": ("bearing",),
    "clearance_spherical": ("bearing",),
    "clearance_cylindrical": ("journal", "bearing"),
    "clearance_translational": ("journal", "bearing"),
}
"""Which of them must know how they are turned."""

AT_THE_EDGE = Site(body=GROUND)
ON_EDGES = ("clamp", "spherical", "guide", "fixing")
COINCIDENT = ("spherical", "revolute", "universal", "bushing")
APART = ("distance", "spring")
HOLDING = (*COINCIDENT[:3], "clamp", "cylindrical", "prismatic", "planar", "distance")
TURNING = ("revolute", "cylindrical", "clearance_revolute")
REFERS = {
    "gear": {"first": TURNING, "second": TURNING},
    "latch": {"joint": ("revolute", "prismatic", "clearance_revolute")},
    "torsion_spring": {"joint": TURNING},
}
"""Keys that name another joint, and the kinds that it may have."""


def sites_of(joint: Any) -> dict[str, Site]:
    """The points of a joint by their path within its table."""
    found = {side: getattr(joint, side) for side in SIDES[joint.kind]}
    if joint.kind == "pulley":
        found = {f"points[{i}]": site for i, site in enumerate(joint.points)}
    return found


def check_joints(draft: Draft) -> Iterator[Problem]:
    """Everything in which joints do not fit."""
    seen: dict[Any, str] = {}
    for name, joint in draft.named("joint").items():
        where = f"joint.{name}"
        sites = sites_of(joint)
        found = [p for s, site in sites.items() for p in check_site(draft, site, f"{where}.{s}")]
        found += _edges(joint, sites, where)
        found += _orientations(draft, joint, sites, where)
        found += _named_joints(draft, joint, where)
        if isinstance(joint, Loose):
            found += _clearance(draft, joint, where)
        if joint.kind == "sliding":
            found += _rail(draft, joint, where)
        if joint.kind == "fixing" and not found:
            found += _vector(draft, joint, where)
        single = all(site.edge is None for site in sites.values())
        if (
            not found
            and sites
            and single
            and all(is_placed(draft, site) for site in sites.values())
        ):
            found += _gaps(draft, joint, sites, where)
            found += _repeated(draft, joint, sites, name, seen)
        yield from found


def _edges(joint: Any, sites: dict[str, Site], where: str) -> Iterator[Problem]:
    """An edge is held node by node, each where it is."""
    for side, site in sites.items():
        if site.edge is not None and (side != "a" or joint.kind not in ON_EDGES):
            text = f"only side a of {alternatives(ON_EDGES)} takes an edge"
            yield Problem(f"{where}.{side}.edge", text)
        elif site.edge is not None and sites.get("b", AT_THE_EDGE) != AT_THE_EDGE:
            yield Problem(f"{where}.b", "an edge is held by the ground, where it is: leave b out")


def _orientations(
    draft: Draft, joint: Any, sites: dict[str, Site], where: str
) -> Iterator[Problem]:
    """Particles where a joint needs something that turns."""
    driven = getattr(joint, "angle", None) is not None and joint.kind != "torsion_spring"
    aligned = ("a",) if getattr(joint, "aligned", False) else ()
    if isinstance(joint, ClearanceRevolute) and joint.length is not None:
        aligned = ("journal",)  # its pin tilts
    for side, site in sites.items():
        if side in (*ORIENTED.get(joint.kind, ()), *aligned) or driven:
            why = "cannot be driven" if driven else f"cannot be held by a {joint.kind}"
            yield from turning_problem(draft, site, f"{where}.{side}", why)


def _named_joints(draft: Draft, joint: Any, where: str) -> Iterator[Problem]:
    """Joints that a gear, latch or torsion spring refers to."""
    for key, kinds in REFERS.get(joint.kind, {}).items():
        name = getattr(joint, key)
        other = draft.named("joint").get(name)
        if name not in draft.names("joint"):
            yield Problem(f"{where}.{key}", unknown("joint", name, draft.names("joint")))
        elif other is not None and other.kind not in kinds:
            text = f"joint.{name} is a {other.kind}; expected {alternatives(kinds)}"
            yield Problem(f"{where}.{key}", text)


def _clearance(draft: Draft, joint: Loose, where: str) -> Iterator[Problem]:
    from mechanics.contact import DISSIPATION

    if isinstance(joint, Sided):
        for key in ("journal_material", "bearing_material"):
            yield from material_problem(draft, getattr(joint, key), f"{where}.{key}")
    law = joint.contact.dissipation
    if law not in DISSIPATION:
        yield Problem(f"{where}.contact.dissipation", unknown("hysteresis law", law, DISSIPATION))
    if isinstance(joint, Telescope):
        yield from _telescope(draft, joint, where)


def _telescope(draft: Draft, joint: Telescope, where: str) -> Iterator[Problem]:
    """Whether both tubes are there, and one in the other."""
    found = [p for key in ("inner", "outer") for p in _tube(draft, joint, key, where)]
    yield from found
    if not found and {joint.inner, joint.outer} <= draft.points.keys():
        inner, outer = (draft.points[name] for name in (joint.inner, joint.outer))
        mouth, other = (outer[0], outer[-1])[:: 1 if joint.mouth == "start" else -1]
        away, reach = _distance(mouth, inner), joint.radius + joint.clearance
        stowed = max(_distance(inner[i], outer) for i in (0, -1)) <= reach
        if away > reach and not stowed:  # else the whole tube is inside, and not at the mouth yet
            fits = _distance(other, inner) <= reach
            hint = "; did you mean the other end?" if fits else ""
            text = f"is {away:g} m away from the axis of '{joint.inner}', more than the radius"
            yield Problem(f"{where}.mouth", f"{text}, {reach:g} m{hint}")


def _tube(draft: Draft, joint: Telescope, key: str, where: str) -> Iterator[Problem]:
    name = getattr(joint, key)
    body = draft.named("body").get(name)
    if name not in draft.names("body"):
        yield Problem(f"{where}.{key}", unknown("body", name, draft.names("body")))
    elif body is None:
        return
    elif not isinstance(body, LineBody) or body.kind == "cable":
        yield Problem(f"{where}.{key}", f"'{name}' is no beam: only beams telescope")
    elif body.family == "beam3333":
        text = "elements beam3333 have no smooth axis to slide on"
        yield Problem(f"{where}.{key}", text)


def _distance(point: Array, line: Array) -> float:
    """Distance [m] of a point (3,) from a line through points (n, 3)."""
    start, along = line[:-1], np.diff(line, axis=0)
    share = np.sum((point - start) * along, axis=1) / np.sum(along * along, axis=1)
    nearest = start + np.clip(share, 0.0, 1.0)[:, None] * along
    return float(np.linalg.norm(nearest - point, axis=1).min())


def _rail(draft: Draft, joint: Any, where: str) -> Iterator[Problem]:
    """The body on which a point slides."""
    body = draft.named("body").get(joint.body)
    if joint.body not in draft.names("body"):
        yield Problem(f"{where}.body", unknown("body", joint.body, draft.names("body")))
    elif joint.body == joint.a.body:
        yield Problem(f"{where}.body", f"a point of '{joint.body}' cannot slide on it")
    elif isinstance(body, LineBody) and body.family == "beam3333":
        yield Problem(f"{where}.body", "elements beam3333 have no smooth axis to slide on")
    elif body is not None and not isinstance(body, LineBody):
        text = f"'{joint.body}' is a {body.kind}: only beams and cables can be slid on"
        yield Problem(f"{where}.body", text)
    elif joint.aligned and body is not None and body.kind == "cable":
        yield Problem(f"{where}.aligned", f"'{joint.body}' is a cable: it has no sections")


def _vector(draft: Draft, joint: Any, where: str) -> Iterator[Problem]:
    """Whether the node has the vector that is held."""
    if joint.a.body == GROUND:
        yield Problem(f"{where}.a.body", "a fixing holds a body; the ground is held already")
    elif joint.a.body in draft.shapes:
        vectors = FAMILIES[family_of(draft.named("body")[joint.a.body])].vectors
        place = place_of(draft.shapes[joint.a.body], joint.a)
        if joint.vector not in vectors:
            text = f"'{joint.a.body}' has {alternatives(vectors)}, got '{joint.vector}'"
            yield Problem(f"{where}.vector", text)
        elif place.fraction or place.offset.any():
            yield Problem(f"{where}.a", "a fixing holds vectors of a node, and none is there")


def _gaps(draft: Draft, joint: Any, sites: dict[str, Site], where: str) -> Iterator[Problem]:
    """Whether the points are as far from each other as the joint asks."""
    for (one, first), (two, second) in zip(
        list(sites.items())[:-1], list(sites.items())[1:], strict=True
    ):
        if first.body == second.body == GROUND and joint.kind != "pulley":
            yield Problem(where, "has the ground on both sides")
        elif first.body != GROUND and point_key(draft, first) == point_key(draft, second):
            yield Problem(where, f"joins a point of '{first.body}' with itself")
        else:
            away = position_of(draft, first, second) - position_of(draft, second, first)
            if isinstance(joint, Sided):
                yield from _outside(joint, away, f"{where}.journal")
            else:
                gap = float(np.linalg.norm(away))
                yield from _gap(joint, gap, _size(draft, sites), (one, two), sites, where)


def _outside(joint: Sided, away: Array, where: str) -> Iterator[Problem]:
    """A journal that starts beyond its clearance, ``away`` (3,) [m] from the bearing."""
    for gap, clearance, how in _ways(joint, away):
        if gap > clearance * (1.0 + 1e-9):
            text = f"starts {gap:g} m off the centre of the bearing{how}, more than the clearance"
            yield Problem(where, f"{text}, {clearance:g} m")


def _ways(joint: Sided, away: Array) -> Iterator[tuple[float, float, str]]:
    """How far the journal is away [m], how far it may be [m], and in which direction."""
    match joint:
        case ClearanceSpherical() | ClearanceRevolute(length=None):
            yield float(np.linalg.norm(away)), joint.clearance, ""
        case ClearanceRevolute() | ClearanceCylindrical():
            along = float(away @ np.array(joint.axis))
            across = float(np.linalg.norm(away - along * np.array(joint.axis)))
            yield across, joint.clearance, " across the axis"
            if isinstance(joint, ClearanceRevolute) and joint.axial_clearance is not None:
                yield abs(along), joint.axial_clearance, " along the axis"
        case ClearanceTranslational():
            normal = np.array(joint.normal)
            yield abs(float(away @ normal)), joint.clearance, " along the normal"
            if joint.width is not None:
                side = np.cross(joint.axis, normal)
                yield abs(float(away @ side)), joint.clearance, " across axis and normal"


def _gap(
    joint: Any, gap: float, size: float, ends: tuple[str, str], sites: dict[str, Site], where: str
) -> Iterator[Problem]:
    if joint.kind in (*APART, "pulley") and gap == 0.0:
        grounded = any(site.body == GROUND for site in sites.values())
        hint = "; give the ground a position" if grounded else ""
        yield Problem(where, f"its two points coincide{hint}")
    elif joint.kind in COINCIDENT and gap > NODE_TOLERANCE * size:
        yield Problem(where, f"its points {ends[0]} and {ends[1]} are {gap:g} m apart")


def _size(draft: Draft, sites: dict[str, Site]) -> float:
    """Extent of the largest body [m]; of points the distance from the origin."""
    points = [draft.points[s.body] for s in sites.values() if s.body != GROUND]
    extents = [float(np.ptp(p, axis=0).max()) for p in points]
    return max(extents, default=0.0) or max((float(np.abs(p).max()) for p in points), default=0.0)


def _repeated(
    draft: Draft, joint: Any, sites: dict[str, Site], name: str, seen: dict[Any, str]
) -> Iterator[Problem]:
    if joint.kind not in HOLDING:
        return
    pair = joint.kind, frozenset(point_key(draft, site) for site in sites.values())
    if pair in seen:
        text = f"holds the same points in the same way as joint.{seen[pair]}"
        yield Problem(f"joint.{name}", text)
    seen.setdefault(pair, name)
