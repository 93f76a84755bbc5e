"""What a case imports, compiles and allocates: a program of its own, for ``leaving_out``.

It reads and builds a case, takes a few coupling windows or solves its equilibrium, and prints what
that took as JSON.
"""

import gc
import json
import resource
import sys
import time
import tracemalloc
from typing import Any

from numba.core import event
from numba.core.ccallback import CFunc
from numba.core.dispatcher import Dispatcher

WINDOWS = 2
"""Coupling windows that are taken: everything that a run needs has been used by then."""
HEAVY = ("skfem", "pyvista", "matplotlib", "pint", "h5py", "pyamg", "scipy.optimize", "dask")
"""Libraries that are worth leaving out."""
PACKAGES = ("coupling", "mechanics", "meshes", "thermal")


class CompileTime(event.Listener):
    """Seconds in which numba was compiling: outermost spans, as one function compiles others."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._depth, self._since = 0, 0.0

    def on_start(self, event: Any) -> None:
        """The compiler is entered."""
        self._depth += 1
        self._since = time.perf_counter() if self._depth == 1 else self._since

    def on_end(self, event: Any) -> None:
        """The compiler is left."""
        self._depth -= 1
        self.seconds += time.perf_counter() - self._since if self._depth == 0 else 0.0


def used_kernels() -> int:
    """Functions that there is machine code for in this process."""
    things = gc.get_objects()
    functions = sum(len(t.overloads) > 0 for t in things if isinstance(t, Dispatcher))
    return functions + sum(isinstance(t, CFunc) for t in things)


def take(case: str) -> None:
    """Read and build a case, and step it, or do what its analysis is."""
    from coupling import casefile

    scene = casefile.read(case)
    if scene.analysis.kind != "dynamics":
        _analysed(scene)
        return
    from itertools import islice

    from coupling.model import build
    from coupling.simulation import windows

    model = build(scene)
    for _ in islice(windows(model, model.initial()), WINDOWS):
        pass


def _analysed(scene: Any) -> None:
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from coupling import analyses

    with TemporaryDirectory() as folder:
        analyses.run(scene, Path(folder), None)


def main(case: str, traced: bool) -> None:
    """Print what a case took: memory where it is traced, times where it is not."""
    begun = time.perf_counter()
    compiling = CompileTime()
    if traced:
        tracemalloc.start()
    else:
        event.register("numba:compiler_lock", compiling)
    take(case)
    print(json.dumps({
        "seconds": time.perf_counter() - begun,
        "compiling": compiling.seconds,
        "kernels": used_kernels(),
        "modules": sum(m.partition(".")[0] in PACKAGES for m in sys.modules),
        "libraries": [name for name in HEAVY if name in sys.modules],
        "allocated": tracemalloc.get_traced_memory()[1] if traced else 0,
        "resident": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
    }))  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2] == "traced")
