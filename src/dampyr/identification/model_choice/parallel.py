"""Independent jobs, run one after the other or by an executor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

from dampyr.errors import InputError

HEARTBEAT = 4.0  # s: progress is reported at least so often, also while no job ends


def refuse_forks(executor: Executor | None) -> None:
    """Raise :class:`~dampyr.errors.InputError` for an executor that forks its processes."""
    context = getattr(executor, "_mp_context", None)
    if context is not None and context.get_start_method() == "fork":
        raise InputError(
            "the executor forks its processes, which may crash after compiled code has run; make it with "
            "mp_context=multiprocessing.get_context('spawn')"
        )


@contextmanager
def local_processes(workers: int) -> Iterator[Executor | None]:
    """An executor of ``workers`` processes on this machine; None for one, which is this one."""
    if workers <= 1:
        yield None
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as executor:
        yield executor


def run_all(
    jobs: Sequence[Callable[[], Any]],
    executor: Executor | None,
    progress: Callable[[float], None],
    enough: Callable[[Any], bool] = lambda result: False,
    deadline: float = math.inf,
) -> list[Any]:
    """The jobs' results in their order, whatever the order in which they come; None for a job that was not done.

    ``enough`` is given each result, in the order of the jobs; once it says so, the results of all later jobs are None, whether
    they had been done or not, so that neither the number of workers nor their speed changes what comes back. No job begins
    after ``deadline``, a value of ``time.time`` in s.
    """
    progress(0.0)
    if executor is None:
        results: list[Any] = [None] * len(jobs)
        for k, job in enumerate(jobs):
            if time.monotonic() > deadline:
                break
            results[k] = job()
            progress((k + 1) / len(jobs))
            if enough(results[k]):
                break
        return results
    futures: list[Future[Any]] = [executor.submit(job) for job in jobs]
    waiting, heard, stop = set(futures), 0, len(futures)
    while waiting:
        _, waiting = wait(
            waiting, timeout=min(HEARTBEAT, max(deadline - time.monotonic(), 0.1)), return_when=FIRST_COMPLETED
        )
        while heard < stop and futures[heard].done() and not futures[heard].cancelled():
            heard += 1
            if enough(futures[heard - 1].result()):
                stop = heard
        if stop < len(futures) or time.monotonic() > deadline:
            for future in waiting:
                future.cancel()
        progress(1.0 - len(waiting) / len(jobs))
    return [None if k >= stop or future.cancelled() else future.result() for k, future in enumerate(futures)]
