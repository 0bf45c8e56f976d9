"""Jobs in workers: none is forked, all are heard of, and who is first changes nothing."""

import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial

import pytest
from tests.identification.tangent_campaign import NAME, campaign

from dampyr.errors import InputError
from dampyr.identification import FitOptions
from dampyr.identification.model_choice import parallel
from dampyr.identification.model_choice.leaderboard import (
    leaderboard,
)


def test_forked_workers_are_refused() -> None:
    from multiprocessing import get_all_start_methods, get_context

    if "fork" not in get_all_start_methods():
        return  # nothing can fork here
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as executor, pytest.raises(InputError, match="spawn"):
        leaderboard(campaign(), FitOptions(models=(NAME,), add_ons=()), executor=executor)


def test_work_without_news_is_heard_of_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    from concurrent.futures import ThreadPoolExecutor
    from threading import Event

    monkeypatch.setattr(parallel, "HEARTBEAT", 0.01)
    heard, ended = [], Event()

    def progress(done: float) -> None:
        heard.append(done)
        if len(heard) > 5:
            ended.set()

    with ThreadPoolExecutor(1) as executor:
        assert parallel.run_all([lambda: ended.wait(60.0)], executor, progress) == [True]
    assert heard[:5] == [0.0] * 5
    assert heard[-1] == 1.0


def test_results_after_the_one_that_is_enough_do_not_count_whoever_is_first() -> None:
    def job(k: int, delay: float) -> int:
        time.sleep(delay)
        return k

    for delays in ((0.0,) * 6, (0.05, 0.03, 0.06, 0.0, 0.0, 0.0), (0.0, 0.0, 0.02, 0.01, 0.06, 0.0)):
        jobs = [partial(job, k, delay) for k, delay in enumerate(delays)]
        heard: list[int] = []

        def enough(k: int, heard: list[int] = heard) -> bool:
            heard.append(k)
            return k == 2

        with ThreadPoolExecutor(4) as executor:
            done = parallel.run_all(jobs, executor, lambda share: None, enough)
        assert done == parallel.run_all(jobs, None, lambda share: None, lambda k: k == 2) == [0, 1, 2, None, None, None]
        assert heard == [0, 1, 2]


@pytest.mark.parametrize("workers", [0, 2])
def test_no_job_begins_after_the_deadline(workers: int) -> None:
    begun: list[float] = []

    def job() -> None:
        begun.append(time.monotonic())
        time.sleep(0.05)

    with ThreadPoolExecutor(workers) if workers else nullcontext() as executor:
        parallel.run_all([job] * 200, executor, lambda share: None, deadline=time.monotonic() + 0.1)
    assert 0 < len(begun) < 200
