"""The journal of a run: what its windows left since ``results.h5`` was last written.

Each window appends one record with its rows and the state at its end, in one write. A record counts
if it is whole, which its length and its checksum tell: so it is there entirely or not at all, as a
file that takes the place of another is, at a tenth of the cost. A name ties the journal to the
``results.h5`` that it continues; with any other file it means nothing.
"""

import json
import os
import struct
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FILE_NAME = "journal"
FIRST = b"thermobody journal 1\n"
LENGTHS = struct.Struct("<QQI")  # of the text and of the arrays in bytes; checksum of both
MARK = "\0"  # begins the text that stands for an array
PLAIN = {str, int, float, bool, type(None)}
SYNC_SHARE = 100.0
"""Time between two calls that bring the journal to the disk, in durations of the last one."""

Values = NDArray[Any]


class Journal:
    """Records appended to the file in a folder; the file is made with the first record.

    Parameters
    ----------
    folder : of the run
    name : of the ``results.h5`` that it continues
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.path = folder / FILE_NAME
        self._name = name
        self._descriptor = -1
        self._length = 0
        self._sync_after = 0.0

    def append(self, record: Mapping[str, Any]) -> None:
        """Add a record: nested mappings, named tuples, lists, arrays, numbers, texts, None.

        OSError where it cannot be written; nothing of it stays then.
        """
        if self._descriptor < 0:
            self._begin()
        self._write(packed(record))
        if time.monotonic() > self._sync_after:
            self._sync()

    def remove(self) -> None:
        """What it says stands in ``results.h5`` now."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
        self.path.unlink(missing_ok=True)

    def _begin(self) -> None:
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
        self._descriptor, self._length = os.open(self.path, flags, 0o666), 0
        self._write(FIRST + self._name.encode() + b"\n")

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        try:
            while left:
                left = left[os.write(self._descriptor, left) :]
        except BaseException:  # a part of a record would hide all later ones
            with suppress(OSError):
                os.ftruncate(self._descriptor, self._length)
                os.lseek(self._descriptor, self._length, os.SEEK_SET)
            raise
        self._length += len(data)

    def _sync(self) -> None:
        """To the disk itself: only loss of power needs it, a killed process does not."""
        started = time.monotonic()
        os.fsync(self._descriptor)
        ended = time.monotonic()
        self._sync_after = ended + SYNC_SHARE * (ended - started)


def records(folder: Path, name: str) -> tuple[list[dict[str, Any]], str]:
    """Whole records that continue the ``results.h5`` called ``name``; "", or what is damaged.

    A last record that ends early is no damage: it was being written.
    """
    try:
        data = (folder / FILE_NAME).read_bytes()
    except FileNotFoundError:
        return [], ""
    head = FIRST + name.encode() + b"\n"
    if not data.startswith(head):
        return [], ""
    found: list[dict[str, Any]] = []
    for record in _whole(memoryview(data), len(head)):
        if record is None:
            return found, f"{FILE_NAME}: damaged after {len(found)} windows"
        found.append(record)
    return found, ""


def _whole(data: memoryview, at: int) -> Iterator[dict[str, Any] | None]:
    """Record after record; None for a damaged one, the last."""
    while at + LENGTHS.size <= len(data):
        text, arrays, checksum = LENGTHS.unpack_from(data, at)
        end = at + LENGTHS.size + text + arrays
        if end > len(data):
            return
        if zlib.crc32(data[at + LENGTHS.size : end]) != checksum:
            yield None
            return
        yield unpacked(data[at:end])
        at = end


def packed(record: Mapping[str, Any]) -> bytes:
    """A record as bytes; TypeError for what cannot be kept."""
    arrays: list[bytes] = []
    text = json.dumps(_flat(record, arrays), separators=(",", ":")).encode()
    body = b"".join(arrays)
    lengths = len(text), len(body), zlib.crc32(body, zlib.crc32(text))
    return b"".join((LENGTHS.pack(*lengths), text, body))


def _flat(value: Any, arrays: list[bytes]) -> Any:
    """What JSON can write of a value; its arrays go to the list."""
    kind = type(value)
    if kind is np.ndarray and value.dtype.kind in "biuf":
        arrays.append(value.tobytes())
        return _stand_in(value.dtype, value.shape)
    if kind in PLAIN:
        return value
    if kind is dict:
        return {key: _flat(part, arrays) for key, part in value.items()}
    if hasattr(value, "_fields"):
        return {key: _flat(part, arrays) for key, part in zip(value._fields, value, strict=True)}
    if isinstance(value, Mapping):
        return _flat(dict(value), arrays)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Sequence) and not isinstance(value, bytes):
        return [_flat(part, arrays) for part in value]
    raise TypeError(f"cannot store a {kind.__name__}")


@lru_cache(maxsize=4096)
def _stand_in(dtype: np.dtype[Any], shape: tuple[int, ...]) -> str:
    """The text that stands for an array; see ``_deep``."""
    return f"{MARK}{dtype.str}{shape}"


def unpacked(record: bytes | memoryview) -> dict[str, Any]:
    """What was packed; named tuples come back as dictionaries."""
    text = LENGTHS.unpack_from(record)[0]
    body = memoryview(record)[LENGTHS.size :]
    return _deep(json.loads(bytes(body[:text])), body[text:], [0])


def _deep(value: Any, arrays: memoryview, at: list[int]) -> Any:
    """The value again; ``at`` counts the bytes of the arrays that are read."""
    if isinstance(value, str) and value.startswith(MARK):
        kind, _, shape = value[1:].partition("(")
        sizes = tuple(int(part) for part in shape.rstrip(")").split(",") if part.strip())
        dtype = np.dtype(kind)
        begin = at[0]
        at[0] += dtype.itemsize * int(np.prod(sizes, dtype=np.int64))
        return np.frombuffer(arrays[begin : at[0]], dtype).reshape(sizes).copy()
    if isinstance(value, dict):
        return {key: _deep(part, arrays, at) for key, part in value.items()}
    if isinstance(value, list):
        return [_deep(part, arrays, at) for part in value]
    return value
