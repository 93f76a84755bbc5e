"""Tables of histories that grow by rows, in memory."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coupling.columns import Column

Values = NDArray[Any]
FIRST_CAPACITY = 64


class OtherRows(ValueError):  # noqa: N818 (says it in the language of its reader)
    """A row does not fit those before it."""


class Table:
    """Columns of equal length; the rows of an open stage can vanish again.

    A table with a ``key`` is thinned: of each block of ``stride`` consecutive rows the one
    with the largest key stays (the first row, where there is no such column), and ``stride``
    doubles whenever more than ``limit`` rows are left. Blocks are counted from the first row
    ever accepted, hence neither the coupling windows nor rejected attempts have any influence
    on which rows stay.

    Parameters
    ----------
    name : of the table, for messages
    described : gives unit, meaning and number type of a column by its name
    key : column by which rows are chosen when there are too many; None keeps all
    limit : most rows that stay
    """

    def __init__(
        self,
        name: str,
        described: Callable[[str], Column],
        key: str | None = None,
        limit: int = 200_000,
    ) -> None:
        self.name = name
        self.described = described
        self.key = key
        self.limit = limit
        self.stride = 1
        self.accepted = 0  # rows that were ever accepted
        self.kept = 0  # rows that are left of these
        self.length = 0  # kept rows and staged ones
        self.columns: dict[str, Values] = {}

    def append(self, row: Mapping[str, ArrayLike]) -> None:
        """One row: a value for every column, which the first row defines."""
        self._prepare(row, 0, 1)
        for name, value in row.items():
            self.columns[name][self.length] = value
        self.length += 1

    def append_many(self, rows: Mapping[str, ArrayLike]) -> None:
        """Rows as arrays of shape (k, ...)."""
        blocks = {name: np.asarray(value) for name, value in rows.items()}
        counts = {len(block) for block in blocks.values()}
        if len(counts) != 1:
            raise ValueError(f"{self.name}: columns of different length, {sorted(counts)}")
        count = counts.pop()
        self._prepare(blocks, 1, count)
        for name, block in blocks.items():
            self.columns[name][self.length : self.length + count] = block
        self.length += count

    def fresh(self) -> dict[str, Values]:
        """The rows appended since the last ``accept``, as views; {} where there is none."""
        if self.length == self.kept:
            return {}
        return {name: column[self.kept : self.length] for name, column in self.columns.items()}

    def accept(self) -> None:
        """The rows appended since the last call stay for good."""
        fresh = self.length - self.kept
        if self.stride > 1 and fresh:
            open_block = 1 if self.accepted % self.stride else 0
            raw = np.arange(self.accepted - open_block, self.accepted + fresh)
            self._choose(self.kept - open_block, raw // self.stride)
        self.accepted += fresh
        self.kept = self.length
        while self.key is not None and self.kept > self.limit:
            self.stride *= 2
            self._choose(0, np.arange(self.kept) // 2)
            self.kept = self.length

    def reject(self) -> None:
        """The rows appended since the last ``accept`` vanish."""
        self.length = self.kept

    def cut(self, rows: int) -> None:
        """Keep the first ``rows`` rows."""
        if rows < self.kept:
            self.accepted = rows * self.stride
            self.kept = self.length = rows

    def rows(self) -> dict[str, Values]:
        """The accepted rows, as views."""
        return {name: column[: self.kept] for name, column in self.columns.items()}

    def _choose(self, start: int, block: NDArray[np.intp]) -> None:
        """From row ``start`` on, keep the row with the largest key of each block."""
        key = self.columns.get(self.key or "", np.zeros(self.length))
        largest_first = -key[start : self.length]
        order = np.lexsort((largest_first, block))  # stable: the earlier of two equal rows
        first = np.diff(block[order], prepend=-1) != 0
        chosen = start + order[first]
        self.length = start + len(chosen)
        for column in self.columns.values():
            column[start : self.length] = column[chosen]

    def _prepare(self, row: Mapping[str, ArrayLike], skip: int, count: int) -> None:
        """Make columns at the first row and room for ``count`` more."""
        if not self.columns:
            self.columns = {
                name: np.empty((0, *np.shape(value)[skip:]), dtype=self.described(name).dtype)
                for name, value in row.items()
            }
        if row.keys() != self.columns.keys():
            odd = sorted(row.keys() ^ self.columns.keys())
            raise OtherRows(f"{self.name}: a row needs the columns of the first one; see {odd}")
        for name, value in row.items():
            shape = self.columns[name].shape[1:]
            if shape and np.shape(value)[skip:] != shape:  # assignment would broadcast
                raise OtherRows(f"{self.name}/{name}: shape {np.shape(value)[skip:]}, not {shape}")
        if self.length + count > len(next(iter(self.columns.values()))):
            self._grow(self.length + count)

    def _grow(self, rows: int) -> None:
        capacity = max(FIRST_CAPACITY, rows + rows // 2)
        for name, column in self.columns.items():
            longer = np.empty((capacity, *column.shape[1:]), dtype=column.dtype)
            longer[: self.length] = column[: self.length]
            self.columns[name] = longer
