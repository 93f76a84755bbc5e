"""Whether sweeps change entries that can be, and keep what the case has."""

from collections.abc import Iterator

from coupling.draft import Draft
from coupling.errors import Problem, unknown
from coupling.report_quantities import problem_of, unit_of, width_of
from coupling.report_references import path_problem
from coupling.sweep_tables import SweepTable


def check_sweeps(draft: Draft) -> Iterator[Problem]:
    """What is wrong with the tables [sweep.NAME]."""
    for name, table in draft.named("sweep").items():
        where = f"sweep.{name}"
        for other in table.variant:
            if other not in draft.names("variant"):
                text = unknown("variant", other, draft.names("variant"))
                yield Problem(f"{where}.variant", text)
        for place, path in _paths(table):
            text = "" if table.variant else path_problem(draft, path)  # with it: of the points
            if text:
                yield Problem(f"{where}.{place}", text)
        yield from _quantities(draft, where, table)


def _paths(table: SweepTable) -> Iterator[tuple[str, str]]:
    yield from (("set", path) for path in table.set)
    yield from (("vary", path) for path in table.vary)
    for name, factor in table.factor.items():
        yield from ((f"factor.{name}.entries", path) for path in factor.entries)


def _quantities(draft: Draft, where: str, table: SweepTable) -> Iterator[Problem]:
    asked = [(f"quantity.{key}.of", one.of) for key, one in table.quantity.items()]
    for key, portrait in table.portrait.items():
        asked += [(f"portrait.{key}.{axis}", getattr(portrait, axis)) for axis in "xy"]
    for place, of in asked:
        if table.variant:
            continue  # it may be another analysis: of the points
        text = problem_of(draft, of)
        if not text and width_of(of) > 1:
            text = f"'{of}' is a vector; take one component, such as {of.rpartition('.')[0]}.z"
        if not text and place.startswith("portrait") and unit_of(of) == "Hz":
            text = f"'{of}' has no course"
        if text:
            yield Problem(f"{where}.{place}", text)
