"""Points computed by the workers of a Dask cluster.

Workers need this program, and the folder of the case at the same path for the files that it
names; all else is sent to them.
"""

from collections.abc import Generator, Sequence
from typing import Any
from uuid import uuid4

from coupling.errors import BadCase, Problem
from coupling.sweeps.points import LOST, Job, Point, compute

RETRIES = 2
"""How often a point is begun again that fails with an error of the cluster."""
PATIENCE = "10 s"
"""Until the scheduler has to answer."""


def cluster(jobs: Sequence[Job], address: str) -> Generator[tuple[Job, Point], None, None]:
    """Compute points on a cluster; each as it is finished.

    A point whose worker dies is begun again on another one, as often as the scheduler allows
    (``distributed.scheduler.allowed-failures``). When the iterator is closed, or interrupted,
    what has not begun is taken back.

    Raises
    ------
    BadCase : Dask is not installed, or no scheduler answers at the address
    """
    with _client(address) as client:
        from distributed import as_completed

        own = uuid4().hex[:8]  # or the scheduler would give results of an earlier sweep
        futures = {
            client.submit(compute, job, key=f"{job.key}-{own}-{n}", retries=RETRIES): job
            for n, job in enumerate(jobs)
        }
        try:
            for future in as_completed(list(futures)):
                yield futures.pop(future), _outcome(future)
        finally:
            client.cancel(list(futures))


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        text = "Dask is not installed; pip install 'thermobody[cluster]'"
        raise BadCase("--scheduler", [Problem("", text)]) from None
    try:
        return Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        text = f"no scheduler answers at {address}: {error}"
        raise BadCase("--scheduler", [Problem("", text)]) from None


def _outcome(future: Any) -> Point:
    try:
        return future.result()
    except Exception as error:  # of the cluster: ``compute`` has none
        return Point(LOST, f"{type(error).__name__}: {error}")
