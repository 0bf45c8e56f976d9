"""Who computes an ensemble: threads of this process, any executor, or the workers of a dask cluster, by its client."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Protocol, runtime_checkable

from dampyr.errors import DampyrError, InputError, MissingData, install_line

CONNECT = 10.0  # s until a scheduler has to answer
LOST = "KilledWorker"  # dask's error of a task that took several workers with it


@runtime_checkable
class Cluster(Protocol):
    """What is used of ``distributed.Client``."""

    def get_executor(self) -> Any:
        """An executor on the cluster's workers."""

    def nthreads(self) -> Any:
        """The threads of each worker, by its address."""


Workers = Executor | Cluster


@contextmanager
def executor_of(workers: Workers | None) -> Iterator[Executor]:
    """The executor to submit to: one thread per core of its own, the one that was given, or that of a cluster's client.

    :class:`~dampyr.errors.InputError` for anything else.
    """
    if workers is None:
        pool = ThreadPoolExecutor(os.cpu_count())
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)
    elif isinstance(workers, Cluster):
        yield workers.get_executor()
    elif callable(getattr(workers, "submit", None)):
        yield workers
    else:
        raise InputError(
            f"executor is a {type(workers).__name__}; give an executor of concurrent.futures, or the Client of a dask cluster"
        )


def count_of(workers: Workers | None, pool: Executor) -> int:
    """How many tasks run at a time, by now: a cluster may grow; the cores of this machine where it is not known."""
    client = workers if isinstance(workers, Cluster) else getattr(pool, "_client", None)
    if isinstance(client, Cluster):
        return max(1, sum(client.nthreads().values()))
    return int(getattr(pool, "_max_workers", 0) or os.cpu_count() or 1)


@contextmanager
def telling_of_the_lost(where: str = "") -> Iterator[None]:
    """Say what to do where the executor has lost its workers; ``where`` is the file that holds what was done."""
    try:
        yield
    except Exception as problem:
        if not (isinstance(problem, BrokenExecutor) or type(problem).__name__ == LOST):
            raise
        repair = (
            f"what was done is in {where}: run the same again, with new workers, and it goes on from there"
            if where
            else "give out=, a file, so that the next run goes on from what was done, and run the same again with new workers"
        )
        raise DampyrError(f"workers were lost, killed or out of memory ({problem}); {repair}") from problem


@contextmanager
def connected(address: str) -> Iterator[Workers]:
    """The client of a dask scheduler, ``host:8786`` or ``tcp://host:8786``.

    :class:`~dampyr.errors.MissingData` without dask, :class:`~dampyr.errors.InputError` where no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError:
        raise MissingData(f"a cluster needs dask, which is not installed: run {install_line('cluster')}") from None
    try:
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise InputError(
            f"no dask scheduler answers at {address} ({problem}); start one with `dask scheduler`, and workers with "
            f"`dask worker {address}`"
        ) from None
    with client:
        yield client
