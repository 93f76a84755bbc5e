"""Messages between a run and a participant in another process, over a stream socket.

A message is a header and arrays: the length of the header in bytes (unsigned 32 bits, little
endian), the header in JSON (UTF-8), then the numbers of its arrays one after the other (64-bit
floats, little endian, C order). The header is an object with ``word``, ``arrays``: a list of
[name, shape], and ``fields``: whatever else there is to say. Nothing in a message is ever executed.
"""

import json
import socket
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH = struct.Struct("<I")
NUMBER = np.dtype("<f8")
LONGEST = 1 << 26  # bytes of a header: what is longer is no message of ours
MOST = 1 << 28  # numbers of an array


class Message(NamedTuple):
    """A word, what it says, and its arrays."""

    word: str
    fields: Mapping[str, Any]
    arrays: Mapping[str, Array]


def send(
    stream: BinaryIO,
    word: str,
    fields: Mapping[str, Any] | None = None,
    arrays: Mapping[str, Array] | None = None,
) -> None:
    """Write a message. OSError where the other side has gone."""
    values = {name: np.ascontiguousarray(a, NUMBER) for name, a in (arrays or {}).items()}
    shapes = [[name, list(a.shape)] for name, a in values.items()]
    header = json.dumps({"word": word, "fields": dict(fields or {}), "arrays": shapes}).encode()
    stream.write(
        b"".join([LENGTH.pack(len(header)), header, *(a.tobytes() for a in values.values())])
    )
    stream.flush()


def receive(stream: BinaryIO) -> Message:
    """Read a message. OSError where the other side has gone, or speaks another language."""
    (length,) = LENGTH.unpack(_exactly(stream, LENGTH.size))
    if length > LONGEST:
        raise OSError("what it sends is no message")
    try:
        header = json.loads(_exactly(stream, length))
        word, fields = str(header["word"]), dict(header.get("fields", {}))
        shapes = [(str(name), tuple(map(int, shape))) for name, shape in header.get("arrays", [])]
    except (ValueError, KeyError, TypeError) as error:
        raise OSError(f"what it sends is no message: {error}") from None
    return Message(word, fields, {name: _array(stream, shape) for name, shape in shapes})


def _array(stream: BinaryIO, shape: tuple[int, ...]) -> Array:
    if min(shape, default=0) < 0 or (count := int(np.prod(shape, dtype=np.int64))) > MOST:
        raise OSError(f"what it sends is no message: an array of shape {shape}")
    values = np.frombuffer(_exactly(stream, NUMBER.itemsize * count), NUMBER)
    return values.astype(float).reshape(shape)


def _exactly(stream: BinaryIO, count: int) -> bytes:
    data = stream.read(count)
    if len(data) < count:
        raise ConnectionError("it has ended")
    return data


def connect(address: str, patience: float) -> socket.socket:
    """A connection to ``HOST:PORT`` or to the path of a socket. OSError where nobody listens."""
    family, place = _place(address)
    there = socket.socket(family)
    there.settimeout(patience)
    try:
        there.connect(place)
    except OSError:
        there.close()
        raise
    return there


def listen(address: str) -> socket.socket:
    """A socket on which others can call ``HOST:PORT`` or a path. OSError where it is taken."""
    family, place = _place(address)
    here = socket.socket(family)
    if family == socket.AF_INET:
        here.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    here.bind(place)
    here.listen(1)
    return here


def address_of(here: socket.socket) -> str:
    """The address of a listening socket, with the port that it was given."""
    place = here.getsockname()
    return place if isinstance(place, str) else f"{place[0]}:{place[1]}"


def problem_of(address: str) -> str:
    """What is wrong with an address, or ""."""
    host, colon, port = address.rpartition(":")
    if "/" in address or (colon and host and port.isdecimal() and int(port) < 65536):
        return ""
    return f"must be HOST:PORT or the path of a socket (with a /), got '{address}'"


def _place(address: str) -> tuple[socket.AddressFamily, Any]:
    if "/" in address:
        return socket.AF_UNIX, str(Path(address))
    host, _, port = address.rpartition(":")
    return socket.AF_INET, (host, int(port))
