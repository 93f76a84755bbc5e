"""Entries of a case changed from outside: ``--set body.arm.elements=32``."""

import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from coupling.errors import BadCase, Problem

_PATH = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+|\[\d+\])*")
_STEP = re.compile(r"[A-Za-z0-9_-]+|\[\d+\]")


ABSENT = object()
"""Value of an override that takes an entry away."""


class Override(NamedTuple):
    """The text as given, its path, the path's keys and array indices, the value to put there."""

    text: str
    path: str
    steps: tuple[str | int, ...]
    value: Any


def parse(settings: Iterable[str]) -> list[Override]:
    """Overrides from texts ``path=value``; the value is TOML, or else plain text.

    Raises
    ------
    BadCase : with all texts that are not of this form
    """
    overrides, found = [], []
    for text in settings:
        path, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not _PATH.fullmatch(path):
            found.append(Problem(text, "expected path=value, such as time.end='20 s'"))
        elif not value:
            found.append(Problem(path, "has no value; write path=value"))
        else:
            overrides.append(Override(text, path, _steps(path), _value(value)))
    if found:
        raise BadCase("--set", found)
    return overrides


def override(path: str, value: Any) -> Override:
    """One override. Raises ValueError where the path is none."""
    if not _PATH.fullmatch(path):
        raise ValueError("expected a path such as integrator.tolerance or load.push.direction[0]")
    return Override(f"{path}={literal(value)}", path, _steps(path), value)


def removal(path: str) -> Override:
    """What takes an entry or a table away. Raises ValueError where the path is none."""
    return override(path, 0)._replace(text=f"without {path}", value=ABSENT)


def _steps(path: str) -> tuple[str | int, ...]:
    steps = _STEP.findall(path)
    return tuple(int(step[1:-1]) if step.startswith("[") else step for step in steps)


def _value(text: str) -> Any:
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text


def apply(case: dict[str, Any], overrides: Iterable[Override]) -> list[Problem]:
    """Put the overrides into ``case`` in place; what cannot be put there is returned."""
    found = []
    for override in overrides:
        try:
            _put(case, override)
        except ValueError as error:
            found.append(Problem(f"--set {override.path}", str(error)))
    return found


def _put(case: dict[str, Any], override: Override) -> None:
    if override.value is ABSENT:
        _take_away(case, override)
        return
    *way, last = override.steps
    place: Any = case
    for step in way:
        if isinstance(step, str) and isinstance(place, dict):
            place = place.setdefault(step, {})
        else:
            place = _item(place, step)
    if isinstance(last, str) and isinstance(place, dict):
        place[last] = override.value
    else:
        _item(place, last)
        place[last] = override.value


def _take_away(case: dict[str, Any], override: Override) -> None:
    *way, last = override.steps
    place: Any = case
    for step in way:
        place = place.get(step) if isinstance(place, dict) else None
    if not isinstance(place, dict) or last not in place:
        raise ValueError("is not there to be taken away")
    del place[last]


def _item(place: Any, step: str | int) -> Any:
    if isinstance(step, str):
        raise ValueError(f"'{step}' is not there: what stands before it is a value, not a table")
    if not isinstance(place, list):
        raise ValueError(f"[{step}] is not there: what stands before it is not an array")
    if step >= len(place):
        raise ValueError(f"[{step}] is not there: the array has {len(place)} items, from [0] on")
    return place[step]


def toml(case: Mapping[str, Any]) -> str:
    """The case as TOML text."""
    return "\n".join(_table(case, ())).strip() + "\n"


def _table(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    """Lines of a table: its own entries first, then the tables within."""
    plain = {k: v for k, v in table.items() if not _is_section(v, path)}
    lines = [f"{_key(k)} = {literal(v)}" for k, v in plain.items()]
    if path and (lines or not table):
        lines = ["", f"[{'.'.join(map(_key, path))}]", *lines]
    for key, value in table.items():
        if key not in plain:
            lines += _table(value, (*path, key))
    return lines


def _is_section(value: Any, path: tuple[str, ...]) -> bool:
    """Tables down to [thermal.wall.NAME] get a heading of their own; deeper ones stand inline."""
    depth = 3 if path[:1] == ("thermal",) else 2
    return isinstance(value, dict) and len(path) < depth


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else literal(key)


def literal(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {literal(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower() if isinstance(value, bool) else repr(value)
