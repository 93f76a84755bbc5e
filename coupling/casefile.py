"""Reading a case: text, overrides, typed tables, and everything that is wrong with it at once.

Each table is validated on its own, so that an error in one hides none in the others; then the
references between those that are valid are checked (``coupling.references``).
"""

import re
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic import ConfigDict, TypeAdapter, ValidationError

from coupling import overrides as changes
from coupling.draft import Draft, Where
from coupling.errors import BadCase, Problem, joined, shown, suggestion
from coupling.fields import said
from coupling.generation import merged
from coupling.generators import written_out
from coupling.heat_tables import Thermal
from coupling.overrides import Override
from coupling.references import check
from coupling.scene import ROOM_TEMPERATURE, Scene
from coupling.site_tables import GROUND
from coupling.variant_tables import chosen

FILE_NAME = "case.toml"
LARGEST_FILE = 10_000_000  # [bytes]
NOT_WRITTEN = {"shapes", "folder", "text", "overrides"}  # what a scene has that its file has not

_NAME = re.compile(r"[A-Za-z0-9_-]+")
_POSITION = re.compile(r"(.*) \(at (?:(line \d+, column \d+)|end of document)\)", re.DOTALL)


def read(
    case: Path | str, settings: Iterable[str] = (), variants: Iterable[str] = ()
) -> Scene:  # fmt: skip
    """The scene of a case folder or TOML file, with ``settings`` such as ``time.end=20 s``.

    Parameters
    ----------
    variants : names of [variant.NAME], whose changes come before the settings

    Raises
    ------
    BadCase : with everything that is wrong with the case
    """
    given = changes.parse(settings)
    file = _file(Path(case))
    text = _text(file)
    made = chosen(_parsed(text, file.name), variants, file.name)
    return from_text(text, file.parent, [*made, *given], file.name)


def from_text(
    text: str, folder: Path, made: Sequence[Override] = (), source: str = FILE_NAME
) -> Scene:
    """The scene that TOML ``text`` describes; mesh files are looked for in ``folder``.

    Raises
    ------
    BadCase : with everything that is wrong with the case
    """
    written, raw = _parsed(text, source), _parsed(text, source)
    misplaced = changes.apply(raw, made)
    if misplaced:
        raise BadCase(source, misplaced)
    draft = Draft(_written_out(raw), folder)
    _read_scene(draft)
    draft.problems += check(draft)
    if draft.problems:
        found = _explained(_folded(draft.problems, draft), _written_out(written), made)
        raise BadCase(source, found)
    return _scene(draft, changes.toml(raw) if made else text, tuple(o.text for o in made))


def _written_out(raw: dict[str, Any]) -> dict[str, Any]:
    """The tables with those that each faultless [generate.NAME] stands for."""
    tables = raw.get("generate", {})
    if not isinstance(tables, dict):
        return raw
    for value in tables.values():
        try:
            raw = merged(written_out(value), raw)
        except ValidationError:
            continue  # reported when it is read with all the others
    return raw


def _folded(problems: list[Problem], draft: Draft) -> list[Problem]:
    """Problems that differ only in the name of a table, once each, where tables are generated."""
    if "generate" not in draft.raw:
        return problems
    alike: dict[tuple[str, ...], list[Problem]] = {}
    for problem in problems:
        kind, _, rest = problem.path.partition(".")
        alike.setdefault((kind, rest.partition(".")[2], problem.text), []).append(problem)
    return [
        first._replace(text=f"{first.text} (and {len(more)} more like it)") if more else first
        for first, *more in alike.values()
    ]


# ----------------------------------------------------------------------------------- text


def _file(path: Path) -> Path:
    """The case file that a path means."""
    try:
        if path.is_dir():
            if not (path / FILE_NAME).exists():
                raise BadCase(str(path), [Problem("", f"the folder has no {FILE_NAME}")])
            return path / FILE_NAME
        if not path.exists():
            near = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            text = f"there is no such file or folder{suggestion(path.name, near)}"
            raise BadCase(str(path), [Problem("", text)])
    except (OSError, ValueError) as error:
        raise BadCase(str(path), [Problem("", f"cannot be opened: {_reason(error)}")]) from None
    return path


def _text(file: Path) -> str:
    problem = ""
    try:
        if not file.is_file():
            problem = f"is not a file; expected a case folder or a {FILE_NAME}"
        elif file.stat().st_size > LARGEST_FILE:
            problem = "is too large to be a case file"
        else:
            text = file.read_text(encoding="utf-8-sig")
            if "\0" not in text:
                return text
            problem = "is a binary file, not text"
    except UnicodeDecodeError:
        problem = "is not text in UTF-8"
    except OSError as error:
        problem = f"cannot be read: {_reason(error)}"
    raise BadCase(file.name, [Problem("", problem)])


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def _parsed(text: str, source: str) -> dict[str, Any]:
    if not text.strip():
        problem = Problem("", "the file is empty; a case needs [time] and a [body.NAME]")
        raise BadCase(source, [problem])
    try:
        return tomllib.loads(text)
    except RecursionError:
        problem = Problem("", "not TOML: nested too deeply")
    except ValueError as error:  # TOMLDecodeError, or a number of too many digits
        match = _POSITION.fullmatch(str(error))
        place, what = (match[2] or "end of file", match[1]) if match else ("", str(error))
        what = what.replace("Cannot overwrite a value", "the key is there twice")
        problem = Problem(place, f"not TOML: {what}")
    raise BadCase(source, [problem])


# --------------------------------------------------------------------------------- tables


def _read_scene(draft: Draft) -> None:
    """Validate every table of the file on its own."""
    fields = {k: f for k, f in Scene.model_fields.items() if k not in NOT_WRITTEN}
    for key, value in draft.raw.items():
        if key not in fields:
            hint = suggestion(key, fields) or f"; known here: {', '.join(fields)}"
            draft.problems.append(Problem(key, f"unknown key{hint}"))
        elif key == "thermal":
            _read_thermal(draft, value)
        elif get_origin(fields[key].annotation) is dict:
            _read_named(draft, (key,), value, get_args(fields[key].annotation)[1])
        else:
            _read_one(draft, (key,), value, fields[key].annotation)
    if "time" not in draft.raw:
        draft.problems.append(Problem("time", "missing (a table with end and window)"))
    if not draft.raw.get("body"):
        draft.problems.append(Problem("body", "missing (a case has one [body.NAME] or more)"))


def _read_thermal(draft: Draft, raw: Any) -> None:
    if not isinstance(raw, dict):
        draft.problems.append(Problem("thermal", f"expected a table, got {shown(raw)}"))
        return
    kinds = {
        key: get_args(field.annotation)[1]
        for key, field in Thermal.model_fields.items()
        if get_origin(field.annotation) is dict
    }
    plain = {key: value for key, value in raw.items() if key not in kinds}
    _read_one(draft, ("thermal",), plain, Thermal)
    for key in kinds.keys() & raw.keys():
        _read_named(draft, ("thermal", key), raw[key], kinds[key])


def _read_named(draft: Draft, where: Where, raw: Any, kind: Any) -> None:
    """Tables [where.NAME] of one kind."""
    if not isinstance(raw, dict):
        text = f"expected tables with names such as [{joined(where)}.NAME], got {shown(raw)}"
        draft.problems.append(Problem(joined(where), text))
        return
    adapter = _adapter(kind)
    for name, value in raw.items():
        if not _NAME.fullmatch(name):
            text = "a name consists of letters, digits, _ and -"
            draft.problems.append(Problem(joined((*where, shown(name))), text))
        elif (*where, name) == ("body", GROUND):
            text = "the name is taken: the ground is always there"
            draft.problems.append(Problem(joined((*where, name)), text))
        else:
            _read_one(draft, (*where, name), value, kind, adapter)


def _read_one(
    draft: Draft, where: Where, raw: Any, kind: Any, adapter: TypeAdapter | None = None
) -> None:
    try:
        draft.valid[where] = (adapter or _adapter(kind)).validate_python(raw)
    except ValidationError as error:
        draft.problems += [
            _problem(e, where, get_origin(kind) is Annotated) for e in error.errors()
        ]


def _adapter(kind: Any) -> TypeAdapter:
    """What reads values of a kind; bare types are read as strictly as the tables."""
    return TypeAdapter(kind, config=ConfigDict(strict=True) if kind is str else None)


def _problem(error: Any, where: Where, tagged: bool) -> Problem:
    """An error of pydantic with its path; for unions without the tag that pydantic puts first."""
    inside = tuple(error["loc"])
    if tagged and error["type"].startswith("union_tag"):
        inside = (*inside, "kind")
    elif tagged:
        inside = inside[1:]
    return Problem(joined([step for step in (*where, *inside) if step != ""]), said(error))


# ---------------------------------------------------------------------------------- scene


def _scene(draft: Draft, text: str, given: tuple[str, ...]) -> Scene:
    """The valid tables put together, with the defaults that depend on other tables."""
    single = {where[0]: value for where, value in draft.valid.items() if len(where) == 1}
    heat = single.get("thermal")
    if heat is not None:
        named = {where[1]: draft.named(*where[:2]) for where in draft.valid if len(where) == 3}
        parts = named.get("part", {})
        named["part"] = {n: _filled(p, "initial", heat.initial) for n, p in parts.items()}
        single["thermal"] = heat.model_copy(update=named)
    kinds = {where[0] for where in draft.valid if len(where) == 2}
    tables = single | {kind: draft.named(kind) for kind in kinds}
    T = heat.initial if heat is not None else ROOM_TEMPERATURE
    for kind in ("body", "joint"):
        tables[kind] = {
            n: _filled(v, "reference_temperature", T) for n, v in tables.get(kind, {}).items()
        }
    return Scene.model_construct(
        **tables, shapes=draft.shapes, folder=draft.folder, text=text, overrides=given
    )


def _filled(table: Any, key: str, value: Any) -> Any:
    """The table with ``value`` under ``key`` if it has such a key and nothing there."""
    if getattr(table, key, value) is not None:
        return table
    return table.model_copy(update={key: value})


def _explained(
    problems: list[Problem], written: dict[str, Any], made: Sequence[Override]
) -> list[Problem]:
    """Problems of a table that only ``--set`` made by a mistyped name, said as such."""
    for override in made:
        depth = 3 if override.steps[0] == "thermal" else 2
        *kind, name = override.steps[:depth]
        known: Any = written
        for step in kind:
            known = known.get(step, {}) if isinstance(known, dict) else {}
        path = joined(override.steps[:depth])
        hint = suggestion(name, known) if isinstance(known, dict) and name not in known else ""
        of_it = [p for p in problems if p.path == path or p.path.startswith(path + ".")]
        if hint and of_it:
            problems = [p for p in problems if p not in of_it]
            problems.append(Problem(f"--set {override.path}", f"there is no {path}{hint}"))
    return problems
