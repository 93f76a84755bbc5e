"""Linear systems of heat by PETSc, in a process of its own: ``thermal.petsc_server``.

The process may run under another Python than this one, such as Debian's with python3-petsc4py.
Numbers pass through files in memory, commands and answers through pipes.
"""

import os
import select
import subprocess
import sys
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from glob import glob
from pathlib import Path
from shutil import disk_usage
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from thermal.compressed import Array, Compressed, Indices
from thermal.multigrid import REDUCTION, balanced

NAMED = "THERMOBODY_PETSC_PYTHON"
DEBIAN, DEBIAN_BUILDS = "/usr/bin/python3", "/usr/lib/petscdir/*/*real*"
PROBE = """
from petsc4py import PETSc
assert PETSc.ScalarType().dtype == float and PETSc.IntType().itemsize == 4
"""
MEMORY = "/dev/shm"
SERVER = Path(__file__).parent / "petsc_server.py"
ITERATIONS = 200  # of one solve
PATIENCE = 1800.0  # [s] for an answer


class Petsc:
    """Inexact solutions by PETSc.

    Attributes
    ----------
    accuracy, refresh, trouble : see ``Linear``
    iterations : int  of the last solve
    """

    accuracy = 1e-10
    refresh = 0.02

    def __init__(self, n: int, free: Indices, rows: Indices, columns: Indices) -> None:
        self._rows = Compressed(n, free, rows, columns)
        self._process = Process(self._rows.starts, self._rows.columns)
        self._sent: Array | None = None
        self.iterations, self.trouble = 0, ""

    def factorise(self, values: Array) -> Callable[[Array], Array]:
        """Solver of linear systems with the matrix."""
        A = self._rows.matrix(values)
        sums = A.T @ np.ones(A.shape[0])
        return lambda r: balanced(self._solve(A.data, r), r, sums)

    def _solve(self, data: Array, r: Array) -> Array:
        try:
            if self._sent is not data:
                self._process.put("values", data)
                self._process.ask("matrix")
                self._sent = data
            self._process.put("right", r)
            self.iterations = int(self._process.ask("solve"))
        except OSError as error:
            self.trouble = f"PETSc: {error}"
            return np.full_like(r, np.nan)
        self.trouble = ""
        return self._process.get("solution")


class Process:
    """The server, for one pattern; it ends with this object.

    starts, columns : rows of the matrix
    """

    def __init__(self, starts: NDArray[np.integer], columns: NDArray[np.integer]) -> None:
        command, environment = interpreter()
        n = len(starts) - 1
        where = _memory(12 * len(columns) + 20 * n)
        self._folder = TemporaryDirectory(prefix="petsc-", dir=where, ignore_cleanup_errors=True)
        self._arrays = {
            "starts": self._file("starts", starts.astype(np.int32)),
            "columns": self._file("columns", columns.astype(np.int32)),
            "values": self._file("values", np.zeros(len(columns))),
            "right": self._file("right", np.zeros(n)),
            "solution": self._file("solution", np.zeros(n)),
        }
        self._errors = (Path(self._folder.name) / "errors").open("wb")
        self._server = subprocess.Popen(
            [*command, str(SERVER), self._folder.name, str(REDUCTION), str(ITERATIONS)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=environment,
        )
        self._end = weakref.finalize(self, _end, self._server, self._folder)
        try:
            self._answer()
        except OSError as error:
            raise ValueError(f"linear = 'petsc': {error}") from error

    def put(self, name: str, values: Array) -> None:
        """Write an array for the server."""
        self._arrays[name][:] = values

    def get(self, name: str) -> Array:
        """Read an array of the server."""
        return np.array(self._arrays[name])

    def ask(self, command: str) -> str:
        """Answer to a command; OSError where there is none or it failed."""
        assert self._server.stdin is not None
        self._server.stdin.write(command.encode() + b"\n")
        self._server.stdin.flush()
        word, _, rest = self._answer().partition(" ")
        if word != "ok":
            raise OSError(rest)
        return rest

    def _answer(self) -> str:
        """The next line of the server."""
        assert self._server.stdout is not None
        stream, line, last = self._server.stdout.fileno(), b"", time.monotonic() + PATIENCE
        while not line.endswith(b"\n"):
            ready, _, _ = select.select([stream], [], [], max(0.0, last - time.monotonic()))
            if not ready:
                self._server.kill()
                raise OSError(f"no answer within {PATIENCE:g} s")
            part = os.read(stream, 4096)
            if not part:
                raise OSError(f"its process has ended: {self._last_words()}")
            line += part
        return line.decode().strip()

    def _last_words(self) -> str:
        text = Path(self._errors.name).read_text(errors="replace").strip()
        return text.splitlines()[-1] if text else f"exit code {self._server.wait(5)}"

    def _file(self, name: str, values: NDArray) -> NDArray:
        shape, path = max(values.shape, (1,)), Path(self._folder.name) / name
        array = np.memmap(path, dtype=values.dtype, mode="w+", shape=shape)
        array[: len(values)] = values
        return array


def _end(server: "subprocess.Popen[bytes]", folder: "TemporaryDirectory[str]") -> None:
    """Close the pipes, at which the server ends; end it where it does not."""
    for pipe in (server.stdin, server.stdout):
        assert pipe is not None
        with suppress(OSError):  # what was still to be written to a dead process
            pipe.close()
    try:
        server.wait(5.0)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait()
    folder.cleanup()


def _memory(size: int) -> str | None:
    """Where files are kept in memory if there is room, or the usual place of temporary files."""
    room = os.access(MEMORY, os.W_OK) and disk_usage(MEMORY).free > 2 * size
    return MEMORY if room else None


def interpreter() -> tuple[list[str], Mapping[str, str]]:
    """Command and environment of a Python that has petsc4py; ValueError if there is none."""
    return _interpreter(os.environ.get(NAMED, ""))


@cache
def _interpreter(named: str) -> tuple[list[str], Mapping[str, str]]:
    for command, environment in _candidates(named):
        with suppress(OSError, subprocess.TimeoutExpired):
            probe = [*command, "-c", PROBE]
            ended = subprocess.run(probe, env=environment, capture_output=True, timeout=60)
            if ended.returncode == 0:
                return command, environment
    tried = named or f"{sys.executable}, {DEBIAN}"
    raise ValueError(
        f"linear = 'petsc': petsc4py with real numbers was not found (tried {tried}); install "
        f"Debian's python3-petsc4py, or name a Python that has it in {NAMED}"
    )


def _candidates(named: str) -> Iterator[tuple[list[str], Mapping[str, str]]]:
    """Interpreters, each as it is and with Debian's builds of PETSc, one thread each."""
    here = {**os.environ, "OMP_NUM_THREADS": "1"}
    apart = {name: value for name, value in here.items() if not name.startswith("PYTHON")}
    pythons = [(named, here)] if named else [(sys.executable, here), (DEBIAN, apart)]
    for python, environment in pythons:
        yield [python], environment
    for build in sorted(glob(DEBIAN_BUILDS), reverse=True):
        yield [pythons[-1][0]], {**pythons[-1][1], "PETSC_DIR": build}
