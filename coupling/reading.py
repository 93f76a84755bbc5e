"""Reading results.h5, the file that a run leaves behind."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from coupling.columns import Column

FORMAT = "thermobody-results"
FORMAT_VERSION = 2
"""Of what is written: another one with every change of columns or state."""
READABLE = (1, 2)
"""Versions that are drawn and exported; a run goes on from its own only."""
FILE_NAME = "results.h5"


class BadResults(ValueError):  # noqa: N818 (says it in the language of its reader)
    """The file is not what a run writes, or is damaged."""


class Results:
    """Read access to ``results.h5``; arrays are read when asked for.

    ``results["joints/hinge/time"]`` is an array, ``results.table("ledger")`` all columns of a
    group, ``results.attributes("bodies/arm")`` what ``describe_group`` gave.
    """

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path = path
        self._file = file

    @classmethod
    def open(cls, path: Path | str, journal: bool = True) -> "Results":
        """Open a file, or the one in the folder of a run. Raises BadResults with the reason.

        journal : with the windows that a run has finished since it last wrote the file
        """
        path = Path(path)
        path = path / FILE_NAME if path.is_dir() else path
        try:
            source = (_continued(path) if journal else None) or path
            file = h5py.File(source, "r", locking=False)
        except FileNotFoundError:
            raise BadResults(f"{path}: no such file") from None
        except OSError as error:
            raise BadResults(f"{path}: damaged, or no HDF5 file ({error})") from None
        try:
            _check_format(path, file)
        except BadResults:
            file.close()
            raise
        return cls(path, file)

    def close(self) -> None:
        """Close the file; arrays already read stay valid."""
        self._file.close()

    def __enter__(self) -> "Results":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __getitem__(self, name: str) -> NDArray[Any]:
        item = self._item(name)
        if not isinstance(item, h5py.Dataset):
            raise BadResults(
                f"{self.path}: {name} is a group; it has {', '.join(item) or 'nothing'}"
            )
        with _readable(self.path, name):
            return item[()]

    def __contains__(self, name: str) -> bool:
        with _readable(self.path, name):
            return name in self._file

    def names(self, group: str) -> list[str]:
        """Names of the groups or columns in ``group``; none when it does not exist."""
        with _readable(self.path, group):
            return list(self._file[group]) if group in self._file else []

    def table(self, group: str) -> dict[str, NDArray[Any]]:
        """All columns of ``group``."""
        paths = {name: f"{group}/{name}" for name in self.names(group)}
        return {
            name: self[path]
            for name, path in paths.items()
            if isinstance(self._item(path), h5py.Dataset)
        }

    def groups(self) -> list[str]:
        """Groups that hold columns or attributes, without the state."""
        found: list[str] = []

        def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
            children = item.values() if isinstance(item, h5py.Group) else ()
            has_columns = any(isinstance(child, h5py.Dataset) for child in children)
            if (has_columns or len(item.attrs)) and isinstance(item, h5py.Group):
                found.append(name)

        with _readable(self.path, "/"):
            self._file.visititems(visit)
        return [name for name in found if name.split("/")[0] != "state"]

    def attributes(self, group: str = "/") -> dict[str, Any]:
        """Attributes of a group or of the file; numbers as Python numbers."""
        with _readable(self.path, group):
            attributes = dict(self._item(group).attrs)
        return {
            name: value.item() if isinstance(value, np.generic) else value
            for name, value in attributes.items()
        }

    def column(self, name: str) -> Column:
        """Unit, meaning and number type of a column."""
        item = self._item(name)
        return Column(item.attrs["unit"], item.attrs["description"], item.dtype)

    def read_state(self) -> dict[str, Any]:
        """The state as nested dictionaries; named tuples come back as dictionaries."""
        with _readable(self.path, "state"):
            return _read_value(self._item("state"))

    def _item(self, name: str) -> Any:
        with _readable(self.path, name):
            if name in self._file:
                return self._file[name]
        parent = name.rpartition("/")[0] or "/"
        there = self.names(parent)
        raise BadResults(
            f"{self.path}: has no {name}; {parent} has {', '.join(there) or 'nothing'}"
        )


def _continued(path: Path) -> Any:
    """The file in memory with what its journal adds; None where there is no journal."""
    from coupling.journal import FILE_NAME as JOURNAL

    if path.name != FILE_NAME or not path.with_name(JOURNAL).is_file():
        return None
    from coupling.results import Recorder

    return Recorder.image(path.parent)


def _check_format(path: Path, file: h5py.File) -> None:
    with _readable(path, "/"):
        name, version = file.attrs.get("format"), file.attrs.get("format_version")
    if name != FORMAT:
        raise BadResults(f"{path}: an HDF5 file, but not written by thermobody")
    if version not in READABLE:
        known = " and ".join(map(str, READABLE))
        raise BadResults(f"{path}: format version {version}; this program reads {known}")


@contextlib.contextmanager
def _readable(path: Path, name: str) -> Iterator[None]:
    """Turn what h5py raises on damaged data into BadResults."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, UnicodeDecodeError) as error:
        raise BadResults(f"{path}: {name} cannot be read, the file is damaged ({error})") from None


def _read_value(item: h5py.Group | h5py.Dataset) -> Any:
    if isinstance(item, h5py.Dataset):
        value = item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()]
        if isinstance(value, h5py.Empty):
            return None
        return value.item() if isinstance(value, np.generic) else value
    if item.attrs.get("sequence"):
        return [_read_value(item[name]) for name in sorted(item)]
    return {name: _read_value(part) for name, part in item.items()}
