"""Independent jobs, run one after the other or by an executor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
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


def run_all(
    jobs: Sequence[Callable[[], Any]], executor: Executor | None, progress: Callable[[float], None]
) -> list[Any]:
    """The jobs' results in their order, whatever the order in which they come."""
    progress(0.0)
    if executor is None:
        results = []
        for k, job in enumerate(jobs):
            results.append(job())
            progress((k + 1) / len(jobs))
        return results
    futures: list[Future[Any]] = [executor.submit(job) for job in jobs]
    waiting = set(futures)
    while waiting:
        _, waiting = wait(waiting, timeout=HEARTBEAT, return_when=FIRST_COMPLETED)
        progress(1.0 - len(waiting) / len(jobs))
    return [future.result() for future in futures]


def workers(executor: Executor | None) -> int:
    """How many jobs an executor runs at a time."""
    return 1 if executor is None else max(int(getattr(executor, "_max_workers", 1)), 1)
