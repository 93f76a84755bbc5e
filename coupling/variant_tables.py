"""Named changes of a case: [variant.NAME], chosen by ``--variant NAME``."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import Field

from coupling import overrides as changes
from coupling.errors import BadCase, Problem, unknown
from coupling.fields import Table
from coupling.overrides import Override


class Variant(Table):
    """[variant.NAME]: the case with other entries, and without some of its tables."""

    title: str = Field(default="", description="what it is, in a line")
    set: dict[str, Any] = Field(
        default_factory=dict, description="paths of entries, and what to put there"
    )
    without: list[str] = Field(
        default_factory=list, description="paths of entries or tables that are taken away first"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        for key, paths in (("set", self.set), ("without", self.without)):
            for path in paths:
                try:
                    changes.override(path, 0)
                except ValueError as error:
                    yield key, f"'{path}': {error}"


def chosen(
    raw: Mapping[str, Any], names: Iterable[str], source: str
) -> list[Override]:  # fmt: skip
    """The changes that the named variants of a case stand for, one after the other.

    Parameters
    ----------
    raw : the tables of the case as they stand in its file

    Raises
    ------
    BadCase : with the names that are not there, and with what is wrong in those that are
    """
    tables = raw.get("variant", {})
    tables = tables if isinstance(tables, dict) else {}
    made: list[Override] = []
    found: list[Problem] = []
    for name in names:
        if name not in tables:
            found.append(Problem(f"--variant {name}", unknown("variant", name, tables)))
            continue
        try:
            made += _changes(tables[name])
        except ValueError as error:  # pydantic's, and that of a path
            text = f"[variant.{name}] is faulty: {str(error).splitlines()[-1].strip()}"
            found.append(Problem(f"--variant {name}", text))
    if found:
        raise BadCase(source, found)
    return made


def _changes(raw: Any) -> list[Override]:
    table = Variant.model_validate(raw)
    gone = [changes.removal(path) for path in table.without]
    return [*gone, *(changes.override(path, value) for path, value in table.set.items())]
