"""Compiled code is taken from disk only if no file has changed that it takes helpers from.

Numba asks for the file of a function alone, but what this calls or reads in others is compiled
into it.
"""

import re
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba.core import caching

PACKAGE = Path(__file__).parent
IMPORT = re.compile(r"^from (mechanics[\w.]*) import (.*)", re.MULTILINE)


@cache
def sources(file: Path) -> tuple[Path, ...]:
    """A file and all of this package that it imports, and these in turn."""
    found, ahead = set(), [file]
    while ahead:
        one = ahead.pop()
        if one in found or not one.is_file():
            continue
        found.add(one)
        for module, names in IMPORT.findall(one.read_text(encoding="utf-8")):
            place = PACKAGE.parent.joinpath(*module.split("."))
            ahead += [place.with_suffix(".py"), place / "__init__.py"]
            ahead += [place / f"{name}.py" for name in re.findall(r"\w+", names)]
    return tuple(sorted(found))


@cache
def _hash(file: Path) -> bytes:
    return sha256(file.read_bytes()).digest()


def watch() -> None:
    """Let functions of this package be compiled anew when any of their sources has changed."""
    located: Any = getattr(caching, "_SourceFileBackedLocatorMixin", None)  # not public
    alone = getattr(located, "get_source_stamp", None)
    if alone is None:
        return

    def stamp(self: Any) -> Any:
        file = Path(self._py_file)
        files = sources(file) if PACKAGE in file.parents else ()
        return b"".join(map(_hash, files)) if len(files) > 1 else alone(self)

    located.get_source_stamp = stamp
