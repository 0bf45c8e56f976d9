"""Work of requests in processes with limits: the server's memory stays, and nothing goes on that nobody waits for."""

import asyncio
import os
import time
from pathlib import Path

import pytest

pytest.importorskip("fastapi")
from fastapi import HTTPException
from tests.console.coroutines import result_of
from tests.console.memory import resident

from dampyr.console.limits import PLANNING, RequestLimits
from dampyr.console.workers import Workers
from dampyr.errors import InputError, MissingData

DOTTED = "a." * 30_000 + "a = 1"
HUNDRED = [f"{0.1 * k:.1f}" for k in range(1, 101)]
CUBE = (
    f'[[step]]\nkind = "sine"\namplitude = {[f"{v} mm" for v in HUNDRED]}\nfrequency = {[f"{v} Hz" for v in HUNDRED]}\n'
    f"voltage = {[f'{v} V' for v in HUNDRED]}\n"
)
MANY = (
    f'[[step]]\nkind = "sine"\namplitude = {[f"{v} mm" for v in HUNDRED[:20]]}\n'
    f"frequency = {[f'{v} Hz' for v in HUNDRED[:20]]}\ncycles = 3\n"
)


@pytest.fixture
def workers():
    made = Workers()
    yield made
    made.close()


class Client:
    """A client that leaves after ``seconds``."""

    def __init__(self, seconds):
        self.until = time.monotonic() + seconds

    async def is_disconnected(self):
        return time.monotonic() > self.until


def plan(client, text, **more):
    return client.post("/api/campaigns/plan", json={"text": text, "rig": "", **more})


def test_work_is_done_in_another_process(workers):
    assert result_of(workers.run(None, PLANNING, os.getpid)) != os.getpid()


def test_what_is_wrong_comes_back_as_it_was_raised(workers):
    from dampyr.console import record_answers

    with pytest.raises(MissingData, match="no such file"):
        result_of(workers.run(None, PLANNING, record_answers.describe_one, Path("/nowhere"), "data/none.csv"))
    with pytest.raises(RuntimeError, match="traceback"):
        result_of(workers.run(None, PLANNING, os.listdir, "/nowhere"))


def test_more_memory_than_allowed_is_refused(workers):
    with pytest.raises(InputError, match=r"more memory than the 1024 MiB.*plan fewer"):
        result_of(workers.run(None, PLANNING, bytearray, 2**32))


def test_more_time_than_allowed_is_refused(workers):
    with pytest.raises(InputError, match=r"more than the 0.2 s.*request less"):
        result_of(workers.run(None, RequestLimits(2**30, 0.2), time.sleep, 600.0))


def test_a_process_ends_when_its_client_leaves(workers):
    with pytest.raises(HTTPException, match="withdrawn"):
        result_of(workers.run(Client(0.3), RequestLimits(2**30, 600.0), time.sleep, 600.0))


def test_requests_wait_for_one_another_and_are_told_their_place():
    one = Workers(at_once=1)

    async def three():
        order = [asyncio.create_task(one.run(None, PLANNING, time.sleep, 0.4, ticket=name)) for name in "abc"]
        await asyncio.sleep(0.2)
        places = [one.position(name) for name in "abcd"]
        await asyncio.gather(*order)
        return places

    assert result_of(three()) == [0, 1, 2, None]
    assert one.position("a") is None
    one.close()


def test_no_more_wait_than_a_server_can_answer(workers, monkeypatch):
    monkeypatch.setattr("dampyr.console.workers.MAX_WAITING", 1)

    async def two():
        first = asyncio.create_task(workers.run(None, PLANNING, time.sleep, 0.2))
        await asyncio.sleep(0)
        try:
            await workers.run(None, PLANNING, os.getpid)
        finally:
            await first

    with pytest.raises(HTTPException, match="waiting already"):
        result_of(two())


def test_campaigns_that_unfold_are_refused_quickly_in_plain_words(client):
    plan(client, '[[step]]\nkind = "rest"\n')
    before = resident()
    for text, words in (
        (DOTTED, "line 1 has a key of more than 32 parts separated by dots"),
        (
            CUBE,
            "1,000,000 tests (step 1: 100 values of amplitude x 100 values of frequency x 100 values of voltage = 1,000,000)",
        ),
        (f"seed = {'9' * 60_000}", "a number in it has thousands of digits"),
        ("x = " + "[" * 30_000, "nest too deeply"),
    ):
        answer = plan(client, text)
        assert answer.status_code == 400
        assert words in answer.json()["detail"]
    assert resident() - before < 30


@pytest.mark.prove
def test_a_plan_of_four_hundred_tests_leaves_the_servers_memory_as_it_was(client):
    plan(client, '[[step]]\nkind = "rest"\n')
    before = resident()
    assert len(plan(client, MANY).json()["tests"]) == 400
    assert resident() - before < 30


def test_it_goes_on_after_the_console_was_closed_and_begun_again():
    again = Workers()
    for _ in range(2):
        assert result_of(again.run(None, PLANNING, os.getpid)) != os.getpid()
        again.close()
