"""Points computed by processes of this machine.

Each process is a pool of its own, so that one that dies takes nothing along but its own point.
"""

import os
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from typing import NamedTuple

from coupling.sweeps.points import LOST, Job, Point, compute

TRIES = 3
"""How often a point is begun whose process dies."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class _Begun(NamedTuple):
    """A point that is being computed, by which pool, and for the how manieth time."""

    pool: ProcessPoolExecutor
    job: Job
    attempt: int


def cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on this system
        return os.cpu_count() or 1


def local(jobs: Sequence[Job], workers: int) -> Generator[tuple[Job, Point], None, None]:
    """Compute points in so many processes, of one thread each; each as it is finished.

    A point whose process dies is begun again by a new one, ``TRIES`` times in all. When the
    iterator is closed, or interrupted, its processes are ended.
    """
    left = deque((job, 1) for job in jobs)
    pools: list[ProcessPoolExecutor] = []
    running: dict[Future[Point], _Begun] = {}
    with _one_thread():
        try:
            idle = [_pool(pools) for _ in range(min(workers, len(jobs)))]
            while left or running:
                while left and idle:
                    _begin(running, idle.pop(), *left.popleft())
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    begun = running.pop(future)
                    point = _outcome(future, begun)
                    idle.append(_pool(pools, begun.pool) if _died(future) else begun.pool)
                    if point is None:
                        left.append((begun.job, begun.attempt + 1))
                    else:
                        yield begun.job, point
        finally:
            for pool in pools:
                _end(pool)


def _begin(
    running: dict[Future[Point], _Begun], pool: ProcessPoolExecutor, job: Job, attempt: int
) -> None:
    running[pool.submit(compute, job)] = _Begun(pool, job, attempt)


def _died(future: Future[Point]) -> bool:
    return isinstance(future.exception(), BrokenProcessPool)


def _outcome(future: Future[Point], begun: _Begun) -> Point | None:
    """What became of a point; None: it is to be begun again."""
    error = future.exception()
    if error is None:
        return future.result()
    if not isinstance(error, BrokenProcessPool):
        return Point(LOST, f"{type(error).__name__}: {error}")
    if begun.attempt < TRIES:
        return None
    return Point(LOST, f"its process died {TRIES} times (killed, or out of memory)")


def _pool(pools: list[ProcessPoolExecutor], broken: ProcessPoolExecutor | None = None):
    """A new pool of one process among the pools, in place of a broken one."""
    if broken is not None:
        pools.remove(broken)
        broken.shutdown(wait=False)
    pools.append(ProcessPoolExecutor(1, get_context("spawn"), initializer=_started))
    return pools[-1]


def _end(pool: ProcessPoolExecutor) -> None:
    """End a pool with what it is computing."""
    processes = list((pool._processes or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.kill()
    for process in processes:
        process.join()


@contextmanager
def _one_thread() -> Iterator[None]:
    """What processes that are started here find in their environment."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ |= dict.fromkeys(THREADS, "1")
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _started() -> None:
    """In a new process: Ctrl-C is for the one that started it, with which it ends."""
    import signal
    import threading

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    from multiprocessing.connection import wait as until

    parent = parent_process()
    if parent is not None:
        until([parent.sentinel])
        os._exit(1)
