"""One run, one process: a lock on the folder of a run, which ends with the process that has it."""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from coupling.errors import BadCase, Problem

FILE_NAME = "lock"


class Lock:
    """Held from ``locked`` until ``release``, or until the process ends in whatever way.

    It is a lock of the operating system on a file, not the file: one that a killed process left
    behind keeps nobody out.
    """

    def __init__(self, path: Path, file: IO[str]) -> None:
        self._path = path
        self._file = file

    def release(self) -> None:
        """Let others have the folder."""
        self._path.unlink(missing_ok=True)  # before it is unlocked: nobody finds a file in between
        self._file.close()


@contextmanager
def holding(folder: Path) -> Iterator[Path]:
    """The folder, locked; see ``locked``."""
    lock = locked(folder)
    try:
        yield folder
    finally:
        lock.release()


def locked(folder: Path) -> Lock:
    """Take the folder; BadCase if another process computes there, or nothing can be written."""
    path = folder / FILE_NAME
    while True:
        file = _opened(path)
        if not _taken(file):
            owner = _owner(file)
            file.close()
            text = f"is being computed by {owner}; wait for it, or end it first"
            raise BadCase(str(folder), [Problem("", text)])
        if _is_at(file, path):
            break
        file.close()  # its owner ended between the two, and took the file along
    file.truncate(0)
    file.write(f"process {os.getpid()} on {socket.gethostname()}\n")
    file.flush()
    return Lock(path, file)


def _opened(path: Path) -> IO[str]:
    try:
        return path.open("a+", encoding="utf-8")
    except OSError as error:
        text = f"results cannot go there: {error.strerror or error}"
        raise BadCase(str(path.parent), [Problem("", text)]) from None


def _is_at(file: IO[str], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False


def _owner(file: IO[str]) -> str:
    file.seek(0)
    return file.readline().strip() or "another process"


def _taken(file: IO[str]) -> bool:
    """Whether the lock could be had; file systems without locks keep nobody out."""
    try:
        import fcntl
    except ImportError:
        return _taken_on_windows(file)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _taken_on_windows(file: IO[str]) -> bool:
    import msvcrt

    lock, at_once = (getattr(msvcrt, name) for name in ("locking", "LK_NBLCK"))
    file.seek(1 << 20)  # beyond the text, which others may read
    try:
        lock(file.fileno(), at_once, 1)
    except OSError:
        return False
    return True
