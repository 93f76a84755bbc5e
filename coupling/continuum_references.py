"""Whether what a scene has can be computed as a continuum: [mechanics] against the other tables."""

from collections.abc import Iterator
from typing import Any

from coupling.body_tables import LineBody, ShellBody
from coupling.draft import Draft
from coupling.errors import Problem, alternatives, unknown
from coupling.joint_references import sites_of
from coupling.mechanics_tables import Lug, MechanicsTable
from coupling.places import place_of
from coupling.site_tables import GROUND

ON_PLANE = 1e-6
"""How near a place must be to a plane of nodes, relative to the distance of nodes [-]."""
ROUND_BEAMS = "tube, circle or rectangle"
HELD = ("position", "r_y", "r_z")
WHAT = "as a continuum"


def check_mechanics(draft: Draft) -> Iterator[Problem]:
    """Everything that stands against a continuum, and names that [mechanics] gets wrong."""
    table = draft.valid.get(("mechanics",))
    if table is None or not table.is_continuum:
        return
    yield from _names(draft, table)
    yield from _bodies(draft)
    yield from _joints(draft)
    yield from _places(draft, table)
    yield from _heat(draft)


def _names(draft: Draft, table: MechanicsTable) -> Iterator[Problem]:
    for name in table.mesh:
        where = f"mechanics.mesh.{name}"
        body = draft.named("body").get(name)
        if name not in draft.names("body"):
            yield Problem(where, unknown("body", name, draft.names("body")))
        elif body is not None and not isinstance(body, LineBody):
            yield Problem(where, f"'{name}' is a {body.kind}: only beams are meshed")
    for name, lug in table.lug.items():
        where = f"mechanics.lug.{name}"
        joint = draft.named("joint").get(name)
        if name not in draft.names("joint"):
            yield Problem(where, unknown("joint", name, draft.names("joint")))
        elif joint is not None and joint.kind != "clearance_revolute":
            text = f"joint.{name} is a {joint.kind}: only a clearance_revolute has a bore"
            yield Problem(where, text)
        elif joint is not None:
            yield from _lug(joint, lug, where)


def _lug(joint: Any, lug: Lug, where: str) -> Iterator[Problem]:
    if lug.outer_radius <= joint.radius + joint.clearance:
        text = f"must exceed that of the bore, {joint.radius + joint.clearance:g} m"
        yield Problem(f"{where}.outer_radius", text)
    if joint.angle is not None:
        text = "the joint is driven, and a pin in a solid bore is not: turn it with a [load.NAME]"
        yield Problem(where, f"{text} of kind 'torque'")
    if joint.axial_clearance is not None:
        yield Problem(where, "the joint has flanges (axial_clearance), and a solid bore has none")
    if joint.contact.value is not None:
        yield Problem(where, "the joint has a contact stiffness of its own (contact.value)")


def _bodies(draft: Draft) -> Iterator[Problem]:
    bodies = draft.named("body")
    for name, body in bodies.items():
        if isinstance(body, ShellBody):
            text = f"is a shell, which is not meshed {WHAT}: describe it as a beam, or use 'ancf'"
            yield Problem(f"body.{name}", text)
        elif isinstance(body, LineBody) and body.kind == "cable":
            text = f"is a cable: what neither shears nor bends by its section has no shape {WHAT}"
            yield Problem(f"body.{name}", text)
        elif isinstance(body, LineBody):
            if body.formulation is not None:
                text = f"a floating frame has modes of a beam, which is not one {WHAT}"
                yield Problem(f"body.{name}.formulation", text)
            yield from _section(draft, name, body)
    if bodies and not any(isinstance(b, LineBody | ShellBody) for b in bodies.values()):
        yield Problem("mechanics.solver", f"no body is a beam: there is nothing to mesh {WHAT}")


def _section(draft: Draft, name: str, body: LineBody) -> Iterator[Problem]:
    section = draft.named("section").get(body.section)
    if section is None:
        return
    where = f"body.{name}.section"
    if section.kind == "general":
        text = f"'{body.section}' is a general section: it has no shape; use a {ROUND_BEAMS}"
        yield Problem(where, text)
    elif section.kind == "tube" and section.thickness >= 2.0 * section.mean_radius:
        yield Problem(where, f"'{body.section}' is a tube without a hole: use a circle")


def _joints(draft: Draft) -> Iterator[Problem]:
    beams = {n for n, b in draft.named("body").items() if isinstance(b, LineBody)}
    for name, joint in draft.named("joint").items():
        where = f"joint.{name}"
        if joint.kind == "telescope":
            text = f"tubes do not telescope {WHAT}: their contact takes elements of beams"
            yield Problem(where, text)
        elif joint.kind == "sliding" and joint.body in beams:
            yield Problem(where, f"nothing slides on a beam {WHAT}: its axis is not a curve there")
        elif joint.kind == "fixing" and joint.a.body in beams and joint.vector not in HELD:
            text = f"a section {WHAT} has {alternatives(HELD)}, got '{joint.vector}'"
            yield Problem(f"{where}.vector", text)


def _places(draft: Draft, table: MechanicsTable) -> Iterator[Problem]:
    """Places that are on no plane of nodes."""
    for where, site in _sites(draft):
        body = draft.named("body").get(site.body)
        if site.body == GROUND or site.body not in draft.shapes or not isinstance(body, LineBody):
            continue
        try:
            place = place_of(draft.shapes[site.body], site)
        except ValueError:
            continue  # reported where the site is
        along = _along(draft, table, site.body)
        if abs(along * place.fraction - round(along * place.fraction)) > ON_PLANE * along:
            nodes = draft.shapes[site.body].along
            a, b = nodes[place.node : place.node + 2]
            cell = int(along * place.fraction)
            near = [f"{a + (b - a) * k / along:g} m" for k in (cell, cell + 1)]
            text = f"is on no plane of nodes of '{site.body}' {WHAT}; the nearest are at "
            hint = "; choose the cells so that one is there, with mechanics.along"
            yield Problem(f"{where}.at", f"{text}{near[0]} and {near[1]}{hint}")


def _sites(draft: Draft) -> Iterator[tuple[str, Any]]:
    for name, joint in draft.named("joint").items():
        for side, site in sites_of(joint).items():
            yield f"joint.{name}.{side}", site
    for name, load in draft.named("load").items():
        for key in ("at", "a", "b"):
            if hasattr(load, key):
                yield f"load.{name}.{key}", getattr(load, key)
    for name, probe in draft.named("probe").items():
        yield f"probe.{name}", probe


def _along(draft: Draft, table: MechanicsTable, body: str) -> int:
    """Cells from node to node of a beam."""
    from coupling.continuum import chosen

    return chosen(table, draft.valid.get(("thermal",)), body).along


def _heat(draft: Draft) -> Iterator[Problem]:
    heat, output = draft.valid.get(("thermal",)), draft.valid.get(("output",))
    if heat is not None and heat.elastic is not None:
        text = f"takes the resultants of beams, which there are not {WHAT}"
        yield Problem("thermal.elastic", text)
    if heat is not None and heat.environment is not None:
        text = f"light and shadows follow beams, not bodies {WHAT}; use [thermal.flux]"
        yield Problem("thermal.environment", text)
    for i, name in enumerate(output.skins if output is not None else ()):
        if isinstance(draft.named("body").get(name), LineBody):
            text = f"'{name}' is recorded {WHAT} anyway: with its cells, heat and stress"
            yield Problem(f"output.skins[{i}]", text)
