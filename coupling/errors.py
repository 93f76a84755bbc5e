"""What is wrong with a case, said so that its author can put it right."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple


class Problem(NamedTuple):
    """One thing to put right: where it is, such as ``body.boom.elements``, and what it is."""

    path: str
    text: str


class BadCase(Exception):  # noqa: N818 (says it in the language of its reader)
    """A case that cannot be run as written, with everything found wrong in it.

    Attributes
    ----------
    source : str  the file or option that was read
    problems : tuple of Problem
    """

    def __init__(self, source: str, problems: Iterable[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__(report(source, self.problems))


def report(source: str, problems: Sequence[Problem]) -> str:
    """One line that counts, then one line for each problem."""
    plural = "" if len(problems) == 1 else "s"
    lines = [f"{source}: {len(problems)} problem{plural}"]
    return "\n".join(
        lines + [f"  {p.path}: {p.text}" if p.path else f"  {p.text}" for p in problems]
    )


def suggestion(word: object, known: Iterable[str]) -> str:
    """'; did you mean ...?' when ``word`` resembles one of ``known``, otherwise nothing."""
    names = list(known)
    lower = {name.lower(): name for name in names}
    close = get_close_matches(str(word).lower(), lower, n=1, cutoff=0.6)
    return f"; did you mean '{lower[close[0]]}'?" if close else ""


def alternatives(words: Iterable[str]) -> str:
    """'a', 'b' or 'c'."""
    quoted = [f"'{word}'" for word in words]
    return " or ".join([", ".join(quoted[:-1]), quoted[-1]] if len(quoted) > 1 else quoted)


def unknown(what: str, name: object, known: Iterable[str]) -> str:
    """There is no such body, material, ...; with the nearest name, or all when they are few."""
    names = sorted(known)
    hint = suggestion(name, names)
    if not hint and 0 < len(names) <= 8:
        hint = f"; there is {alternatives(names)}"
    return f"there is no {what} '{name}'{hint}"


def shown(value: Any) -> str:
    """The value as its author wrote it in TOML, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "an array" if len(value) > 4 else "[" + ", ".join(map(shown, value)) + "]"
    try:
        text = repr(value) if isinstance(value, (str, int, float)) else str(value)
    except ValueError:  # an integer of more digits than Python prints
        text = "a very long number"
    return text if len(text) <= 60 else text[:57] + "..."


def joined(path: Sequence[str | int]) -> str:
    """('body', 'arm', 'start', 1) as body.arm.start[1]."""
    text = ""
    for item in path:
        text += f"[{item}]" if isinstance(item, int) else f".{item}" if text else item
    return text
