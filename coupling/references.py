"""Whether the tables of a case fit each other: bodies, loads, probes; joints and heat elsewhere.

Every check looks at tables that are valid in themselves and returns all it finds. What refers to
a table that is there but faulty is left alone: the fault has been reported where it is.
"""

from collections.abc import Iterator

from coupling.body_tables import LineBody, ShellBody
from coupling.continuum_references import check_mechanics
from coupling.crosscheck_tables import check_crosscheck
from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.heat_references import check_heat
from coupling.joint_references import check_joints
from coupling.load_tables import TractionLoad
from coupling.materials_used import check_ranges, material_problem
from coupling.places import edge_nodes, shape_of
from coupling.report_references import check_reports
from coupling.site_references import check_site, turning_problem
from coupling.site_tables import GROUND, Site
from coupling.sweep_references import check_sweeps


def check(draft: Draft) -> list[Problem]:
    """Everything in which the tables of ``draft`` do not fit; fills in ``draft.shapes``."""
    found = [*_bodies(draft), *_shapes(draft), *check_joints(draft), *_loads(draft)]
    return [
        *found,
        *_probes(draft),
        *check_heat(draft),
        *check_mechanics(draft),
        *check_ranges(draft),
        *check_reports(draft),
        *check_sweeps(draft),
        *check_crosscheck(draft),
    ]


def _bodies(draft: Draft) -> Iterator[Problem]:
    for name, body in draft.named("body").items():
        if isinstance(body, LineBody) and body.section not in draft.names("section"):
            text = unknown("section", body.section, draft.names("section"))
            yield Problem(f"body.{name}.section", text)
        if isinstance(body, LineBody | ShellBody):
            yield from material_problem(draft, body.material, f"body.{name}.material")


def _shapes(draft: Draft) -> Iterator[Problem]:
    for name, body in draft.named("body").items():
        try:
            draft.shapes[name] = shape_of(body, draft.folder)
        except ValueError as error:
            yield Problem(f"body.{name}", str(error).removeprefix(f"{draft.folder}/"))


def _loads(draft: Draft) -> Iterator[Problem]:
    for name, load in draft.named("load").items():
        if load.kind == "traction":
            yield from _traction(draft, load, f"load.{name}")
            continue
        key = "a" if load.kind == "torque" else "at"
        where, site = f"load.{name}.{key}", getattr(load, key)
        if site.body == GROUND:
            yield Problem(f"{where}.body", "a load acts on a body, not on the ground")
            continue
        yield from check_site(draft, site, where)
        yield from _no_edge(site, where)
        if load.kind != "force":
            yield from turning_problem(draft, site, where, f"takes no {load.kind}", ("cable",))
        if load.kind == "torque":
            where = f"load.{name}.b"
            yield from check_site(draft, load.b, where)
            yield from _no_edge(load.b, where)
            yield from turning_problem(draft, load.b, where, "takes no reaction", ("cable",))


def _no_edge(site: Site, where: str) -> Iterator[Problem]:
    if site.edge is not None:
        yield Problem(f"{where}.edge", "a load acts at one point; a traction takes an edge")


def _traction(draft: Draft, load: TractionLoad, where: str) -> Iterator[Problem]:
    body = draft.named("body").get(load.body)
    if load.body not in draft.names("body"):
        yield Problem(f"{where}.body", unknown("body", load.body, draft.names("body")))
    elif body is not None and not isinstance(body, ShellBody):
        yield Problem(f"{where}.body", f"'{load.body}' is a {body.kind}: only shells take traction")
    elif body is not None and load.edge is not None:
        try:
            edge_nodes(body, load.edge)
        except ValueError as error:
            yield Problem(f"{where}.edge", str(error))


def _probes(draft: Draft) -> Iterator[Problem]:
    for name, probe in draft.named("probe").items():
        if probe.body == GROUND:
            yield Problem(f"probe.{name}.body", "the ground does not move; a probe sits on a body")
        else:
            yield from check_site(draft, probe, f"probe.{name}")
