"""The file results.h5: recording a run and reading it back.

The file is never changed in place. Every write makes a complete new file beside the old one
and then takes its place. What windows add between two writes stands in ``coupling.journal``, so
that a run killed at any moment loses nothing but the window in progress.
"""

import io
import json
import os
import secrets
import time
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from coupling.columns import Column, standard
from coupling.journal import Journal, records
from coupling.probes import write_probes
from coupling.reading import FILE_NAME, FORMAT, FORMAT_VERSION, BadResults, Results
from coupling.tables import Table

__all__ = ["BadResults", "Recorder", "Results", "new_run_folder"]

OUTCOMES = ("running", "done", "stopped")
STATE = Column("", "what a resumed run starts from")
JOURNAL = "journal"
"""Attribute of the file: name of the journal that continues it."""


def new_run_folder(parent: Path) -> Path:
    """Make and return the folder after the last numbered one: 001, 002, …

    Two runs that start at the same moment get two folders, since only one can make each.
    """
    parent.mkdir(parents=True, exist_ok=True)
    number = 1 + max((int(p.name) for p in parent.iterdir() if p.name.isdecimal()), default=0)
    while True:
        folder = parent / f"{number:03d}"
        try:
            folder.mkdir()
        except FileExistsError:
            number += 1
        else:
            return folder


class Recorder:
    """Keeps the histories of a run in memory and writes them to ``results.h5`` now and then.

    Rows that are appended between ``begin`` and ``commit`` belong to a coupling window and
    vanish with ``rollback``. The file always holds whole windows with the state that belongs
    to them. It is written when more than 10 s and more than 100 times the duration of the last
    write have passed, so that writing takes at most 1 % of the time; each window between two
    writes adds a record to the journal.

    Parameters
    ----------
    folder : folder of the run, which exists
    meta : root attributes: title, scene, overrides, plan, versions …; what is not text or a
        number is stored as JSON
    max_rows : most rows that stay in a table below ``joints/``; see ``Table`` on thinning by
        the normal force
    """

    interval = 10.0
    patience = 100.0

    def __init__(self, folder: Path, meta: Mapping[str, Any], max_rows: int = 200_000) -> None:
        self._prepare(folder, max_rows)
        self.attributes = {
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
            **{name: _plain(value) for name, value in meta.items()},
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "outcome": "running",
            "reason": "",
        }
        self.flush()

    @classmethod
    def reopen(cls, folder: Path, max_rows: int = 200_000) -> "Recorder":
        """Recorder that goes on where file and journal in ``folder`` end.

        Raises BadResults when the file cannot be read.
        """
        recorder = cls._read(folder, max_rows)
        recorder.attributes |= {"outcome": "running", "reason": ""}
        recorder.flush()
        return recorder

    @classmethod
    def image(cls, folder: Path) -> io.BytesIO | None:
        """The file as it would be written now, with the journal; None where there is none."""
        recorder = cls._read(folder, 200_000)
        return recorder._image() if recorder._recovered else None

    @classmethod
    def _read(cls, folder: Path, max_rows: int) -> "Recorder":
        recorder = cls.__new__(cls)
        recorder._prepare(folder, max_rows)
        with Results.open(folder, journal=False) as results:
            recorder.attributes = results.attributes()
            recorder._state = results.read_state()
            for group in results.groups():
                recorder._load(results, group)
        recorder._recover()
        return recorder

    def _prepare(self, folder: Path, max_rows: int) -> None:
        self.path = Path(folder) / FILE_NAME
        self.max_rows = max_rows
        self.tables: dict[str, Table] = {}
        self._declared: dict[tuple[str, str], Column] = {}
        self._group_attributes: dict[str, dict[str, Any]] = {}
        self._state: Any = {}
        self._staged = False
        self._state_before: Any = {}
        self._journal: Journal | None = None
        self._changed = False
        self._recovered = 0
        self.damage = ""
        self._written = -np.inf
        self._duration = 0.0

    def _recover(self) -> None:
        """Take what the journal says."""
        found, self.damage = records(self.path.parent, str(self.attributes.get(JOURNAL, "")))
        for record in found:
            for group, rows in record["rows"].items():
                self.append_many(group, rows)
            self._state = record["state"]
            self._accept()
        self._recovered = len(found)

    def declare(
        self, group: str, name: str, unit: str, description: str, dtype: Any = np.float64
    ) -> None:
        """Unit and meaning of a column that ``coupling.columns`` does not know."""
        self._changed = True
        self._declared[group, name] = Column(unit, description, dtype)

    def describe_group(self, group: str, attributes: Mapping[str, Any]) -> None:
        """Attributes of a group, for instance the section of a body."""
        self._changed = True
        known = self._group_attributes.setdefault(group, {})
        for name, value in attributes.items():
            known[name] = np.asarray(value) if isinstance(value, list | tuple) else _plain(value)

    def append(self, group: str, row: Mapping[str, ArrayLike]) -> None:
        """One row; the first row decides which columns the group has."""
        self._table(group).append(row)

    def append_many(self, group: str, rows: Mapping[str, ArrayLike]) -> None:
        """Rows as arrays (k, …), one per column."""
        self._table(group).append_many(rows)

    def state(self, state: Any) -> None:
        """Replace the state: nested mappings, named tuples, lists, arrays, numbers, texts, None.

        Kept by reference until it is written: it must not change afterwards.
        """
        self._state = state

    @property
    def saved_state(self) -> Any:
        """The state as it was given, or as nested dictionaries after ``reopen``."""
        return self._state

    def begin(self) -> None:
        """From here on, rows and state may be taken back."""
        if self._staged:
            raise RuntimeError("the window before has been neither committed nor rolled back")
        self._accept()
        self._staged = True
        self._state_before = self._state

    def commit(self) -> None:
        """The rows since ``begin`` stay, on the disk too; writes the file when it is time."""
        if self._journal is not None and not self._changed:
            fresh = {group: table.fresh() for group, table in self.tables.items()}
            rows = {group: columns for group, columns in fresh.items() if columns}
            self._journal.append({"rows": rows, "state": self._state})
        self._staged = False
        self._accept()
        waited = time.monotonic() - self._written
        if self._changed or waited > max(self.interval, self.patience * self._duration):
            self.flush()

    def rollback(self) -> None:
        """The rows since ``begin`` vanish and the state of then returns."""
        for table in self.tables.values():
            table.reject()
        self._state = self._state_before
        self._staged = False

    def truncate(self, time_limit: float) -> None:
        """Drop all rows later than ``time_limit`` [s]."""
        self._accept()
        clocks = {group: table.rows().get("time") for group, table in self.tables.items()}
        for group, table in self.tables.items():
            clock = clocks.get(_clock(group)) if clocks[group] is None else clocks[group]
            if clock is not None:
                table.cut(int(np.count_nonzero(clock <= time_limit)))

    def flush(self) -> None:
        """Write the file, without the rows of an open window; the journal begins anew."""
        if not self._staged:
            self._accept()
        started = time.monotonic()
        name = secrets.token_hex(8)
        self.attributes[JOURNAL] = name
        temporary = self.path.with_name(FILE_NAME + ".part")
        try:
            temporary.write_bytes(self._image().getbuffer())
            _replace(temporary, self.path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        (self._journal or Journal(self.path.parent, name)).remove()
        self._journal, self._changed = Journal(self.path.parent, name), False
        self._written = time.monotonic()
        self._duration = self._written - started

    def _image(self) -> io.BytesIO:
        """The file in memory: HDF5 itself does not bear a disk that is full."""
        image = io.BytesIO()
        with h5py.File(image, "w") as file:
            self._write(file)
        return image

    def close(self, outcome: str, reason: str = "") -> None:
        """Write the file for the last time, and ``probes.csv``. An open window is dropped."""
        if outcome not in OUTCOMES:
            raise ValueError(f"outcome {outcome!r}: expected one of {', '.join(OUTCOMES)}")
        if self._staged:
            self.rollback()
        self.attributes |= {"outcome": outcome, "reason": reason}
        self.flush()
        with Results.open(self.path, journal=False) as results:
            write_probes(results, self.path.with_name("probes.csv"))

    def _table(self, group: str) -> Table:
        if group not in self.tables:
            key = "normal_force" if group.startswith("joints/") else None
            self.tables[group] = Table(
                group, lambda name: self._column(group, name), key, self.max_rows
            )
        return self.tables[group]

    def _column(self, group: str, name: str) -> Column:
        column = self._declared.get((group, name)) or standard(group, name)
        if column is None:
            raise ValueError(f"{group}/{name}: declare its unit and meaning first")
        return column

    def _accept(self) -> None:
        for table in self.tables.values():
            table.accept()

    def _load(self, results: Results, group: str) -> None:
        attributes = results.attributes(group)
        table = self._table(group)
        columns = results.table(group)
        for name in columns:
            self._declared[group, name] = results.column(f"{group}/{name}")
        if columns:
            table.append_many(columns)
            table.accept()
        table.stride = int(attributes.pop("stride", 1))
        table.accepted = int(attributes.pop("rows_recorded", table.kept))
        self._group_attributes[group] = attributes

    def _write(self, file: h5py.File) -> None:
        file.attrs.update(self.attributes)
        for group, attributes in self._group_attributes.items():
            file.require_group(group).attrs.update(attributes)
        for group, table in self.tables.items():
            self._write_table(file.require_group(group), table)
        _write_value(file, "state", self._state_before if self._staged else self._state)

    def _write_table(self, group: h5py.Group, table: Table) -> None:
        for name, column in table.rows().items():
            _write_array(group, name, column, table.described(name))
        if table.key:
            group.attrs["stride"] = table.stride
            group.attrs["rows_recorded"] = table.accepted


def _clock(group: str) -> str:
    """The group whose column ``time`` belongs to the rows of ``group``."""
    return {"ledger": "windows", "bodies": "frames"}.get(group.split("/", 1)[0], "")


def _plain(value: Any) -> Any:
    """Texts, numbers and arrays as they are, everything else as JSON."""
    if isinstance(value, str | int | float | np.generic | np.ndarray):
        return value
    return json.dumps(value)


def _write_array(group: h5py.Group, name: str, data: Any, column: Column) -> None:
    dataset = group.create_dataset(name, data=data)
    dataset.attrs["unit"] = column.unit
    dataset.attrs["description"] = column.description


def _write_value(parent: h5py.Group, name: str, value: Any) -> None:
    """Write a nested record; see ``Recorder.state`` for what it may hold."""
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        group = parent.create_group(name)
        for key, part in value.items():
            _write_value(group, key, part)
    elif isinstance(value, Sequence) and not isinstance(value, str):
        group = parent.create_group(name)
        group.attrs["sequence"] = True
        for index, part in enumerate(value):
            _write_value(group, f"{index:06d}", part)
    else:
        data = h5py.Empty("f8") if value is None else value
        try:
            _write_array(parent, name, data, STATE)
        except TypeError:
            where = f"{parent.name}/{name}"
            raise TypeError(f"{where}: cannot store a {type(value).__name__}") from None


def _replace(temporary: Path, path: Path) -> None:
    """Put a finished file in its place; it is on the disk before it gets its name."""
    _sync(temporary)
    os.replace(temporary, path)
    if os.name == "posix":
        _sync(path.parent)


def _sync(path: Path) -> None:
    # Windows cannot sync a descriptor that is open for reading only.
    descriptor = os.open(path, os.O_RDONLY if os.name == "posix" else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
