"""Whether reports change entries that can be, and compare what the case has."""

from collections.abc import Iterator
from typing import Any, get_args, get_origin

from coupling.draft import Draft
from coupling.errors import Problem, suggestion, unknown
from coupling.overrides import Override, override
from coupling.report_quantities import FORMS, problem_of
from coupling.report_tables import Overrides, ReportTable

__all__ = ["FORMS", "check_reports"]


def check_reports(draft: Draft) -> Iterator[Problem]:
    """What is wrong with the tables [report.NAME]."""
    for name, table in draft.named("report").items():
        where = f"report.{name}"
        if name in ("work", "newton"):
            yield Problem(where, "the name is taken by a report that every case has")
        for place, overrides in _overrides(table):
            for path in overrides:
                text = path_problem(draft, path)
                if text:
                    yield Problem(f"{where}.{place}", text)
        for key, sought in table.quantity.items():
            text = problem_of(draft, sought.of)
            if text:
                yield Problem(f"{where}.quantity.{key}.of", text)


def _overrides(table: ReportTable) -> Iterator[tuple[str, Overrides]]:
    yield "vary", table.vary
    yield "common", table.common
    yield "reference", table.reference or {}
    yield "check", table.check or {}
    for k, setting in enumerate(table.setting):
        yield f"setting[{k}].set", setting.set
        yield f"setting[{k}].vary", setting.vary


def path_problem(draft: Draft, path: str) -> str:
    """Why an entry cannot be changed; "" as far as can be told without changing it."""
    try:
        made = override(path, None)
    except ValueError as error:
        return f"'{path}': {error}"
    from coupling.scene import Scene

    fields = {key: field.annotation for key, field in Scene.model_fields.items()}
    first = str(made.steps[0])
    if first not in fields or first in ("shapes", "folder", "text", "overrides"):
        return f"'{path}': there is no table '{first}'{suggestion(first, fields)}"
    if first == "report":
        return f"'{path}': a report cannot change reports"
    if first in ("sweep", "variant"):
        return f"'{path}': a run takes no notice of [{first}.NAME]"
    return _inside(draft, made, fields[first])


def _inside(draft: Draft, made: Override, kind: Any) -> str:
    """Why the entry is not in its table."""
    if get_origin(kind) is dict:
        return _named(draft, made, 1)
    if made.steps[0] != "thermal":
        table = next((k for k in (kind, *get_args(kind)) if hasattr(k, "keys")), None)
        return _key(made, 1, table)
    from coupling.heat_tables import Thermal

    key = made.steps[1] if len(made.steps) > 1 else ""
    field = Thermal.model_fields.get(str(key))
    if field is not None and get_origin(field.annotation) is dict:
        return _named(draft, made, 2)
    return _key(made, 1, Thermal)


def _named(draft: Draft, made: Override, depth: int) -> str:
    """Why there is no such named table, or it has no such key."""
    kind, name = made.steps[:depth], made.steps[depth] if len(made.steps) > depth else ""
    names = draft.names(*map(str, kind))
    if name not in names:
        return f"'{made.path}': " + unknown(".".join(map(str, kind)), name, names)
    return _key(made, depth + 1, draft.valid.get((*map(str, kind), str(name))))


def _key(made: Override, depth: int, table: Any) -> str:
    """Why a table has no such key; None: a table with faults of its own."""
    if table is None or len(made.steps) <= depth:
        return ""
    key, keys = made.steps[depth], table.keys()
    if key in keys:
        return ""
    return f"'{made.path}': unknown key '{key}'{suggestion(key, keys)}"
