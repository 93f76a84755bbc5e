"""Whether a point that a joint, load or probe names is there."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.body_tables import LineBody, Particle, RigidBody, ShellBody
from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.places import edge_nodes, place_of, point_of
from coupling.site_tables import GROUND, Site

Array = NDArray[np.float64]


def check_site(draft: Draft, site: Any, where: str) -> Iterator[Problem]:
    """What is wrong with a point of a body or of the ground."""
    if site.body == GROUND:
        for key in ("at", "offset", "edge"):
            if getattr(site, key, None) is not None:
                text = "the ground has no such point; give a position, or nothing"
                yield Problem(f"{where}.{key}", text)
        return
    if site.body not in draft.names("body"):
        yield Problem(f"{where}.body", unknown("body", site.body, [*draft.names("body"), GROUND]))
    body = draft.named("body").get(site.body)
    found = list(_misplaced(site, body, where)) if body is not None else []
    yield from found
    if not found and site.body in draft.shapes:
        try:
            place_of(draft.shapes[site.body], site)
        except ValueError as error:
            yield Problem(f"{where}.{'at' if site.position is None else 'position'}", str(error))


def _misplaced(site: Any, body: Any, where: str) -> Iterator[Problem]:
    """Keys that do not say where a point of this kind of body is."""
    name = f"'{site.body}'"
    if isinstance(body, LineBody):
        if site.position is not None:
            text = f"is for the ground, rigid bodies and shells; {name} is a {body.kind}: give at"
            yield Problem(f"{where}.position", text)
        elif site.at is None:
            yield Problem(f"{where}.at", f"missing ('start', 'end' or a distance along {name})")
        if site.offset is not None and body.kind == "cable":
            yield Problem(f"{where}.offset", f"{name} is a cable: it has no section that turns")
    elif site.at is not None:
        hint = "it is one point, leave at out" if isinstance(body, Particle) else "give a position"
        yield Problem(f"{where}.at", f"{name} is a {_kind(body)}: {hint}")
    if isinstance(body, Particle):
        for key in ("position", "offset"):
            if getattr(site, key) is not None:
                text = f"{name} is a particle: it is one point, leave {key} out"
                yield Problem(f"{where}.{key}", text)
    edge = getattr(site, "edge", None)
    if isinstance(body, ShellBody):
        if site.position is None and site.at is None and edge is None:
            yield Problem(f"{where}.position", f"missing (where on {name}: the place of a node)")
        elif edge is not None:
            yield from _edge(site, body, where)
    elif edge is not None:
        yield Problem(f"{where}.edge", f"{name} is a {_kind(body)}: only shells have edges")


def _edge(site: Any, body: ShellBody, where: str) -> Iterator[Problem]:
    for key in ("position", "offset"):
        if getattr(site, key) is not None:
            yield Problem(f"{where}.{key}", "does not go with an edge: give one or the other")
    try:
        edge_nodes(body, site.edge)
    except ValueError as error:
        yield Problem(f"{where}.edge", str(error))


def _kind(body: Any) -> str:
    return "rigid body" if isinstance(body, RigidBody) else body.kind


def turning_problem(
    draft: Draft, site: Site, where: str, why: str, also: tuple[str, ...] = ()
) -> Iterator[Problem]:
    """Particles, and the kinds of bodies named ``also``, where something turns them."""
    body = draft.named("body").get(site.body)
    if body is not None and body.kind in ("particle", *also):
        text = f"'{site.body}' is a {body.kind}: it has no orientation and {why}"
        yield Problem(f"{where}.body", text)


def is_placed(draft: Draft, site: Site) -> bool:
    """Whether ``position_of`` can tell where a faultless site is."""
    return site.body == GROUND or site.body in draft.shapes


def position_of(draft: Draft, site: Site, other: Site | None) -> Array:
    """(3,) [m]  where a faultless site is at the start; the ground is where the ``other`` is."""
    if site.body != GROUND:
        shape = draft.shapes[site.body]
        return point_of(shape, place_of(shape, site))
    if site.position is not None or other is None:
        return np.array(site.position or (0.0, 0.0, 0.0))
    return position_of(draft, other, None)


def point_key(draft: Draft, site: Site) -> tuple[str, bytes]:
    """What two sites have in common that mean the same material point."""
    if site.body == GROUND:
        return GROUND, b""
    node, fraction, offset = place_of(draft.shapes[site.body], site)
    return site.body, np.array([node, fraction, *offset]).tobytes()
