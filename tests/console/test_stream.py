"""Whatever a page says on the stream of the bench, it goes on, and abort is answered after it."""

import json
import logging

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

pytest.importorskip("fastapi")

HERE = {"host": "127.0.0.1:8077"}
NUMBERS = st.integers() | st.floats() | st.sampled_from([10**400, -(10**400), 2**63, float("nan"), float("inf")])
THINGS = st.none() | st.booleans() | NUMBERS | st.text(max_size=20) | st.lists(st.integers(), max_size=3)
SAYINGS = st.dictionaries(st.sampled_from(["jog", "heard", "abort", "other"]), THINGS, max_size=3).map(json.dumps)
WORDS = SAYINGS | st.text(max_size=200) | st.binary(max_size=200)


@pytest.fixture
def talk(client):
    """``talk(words)``: say it on a stream; abort is still answered, and the stream is still open."""

    def say(words):
        with client.websocket_connect("/api/bench/stream?client=0123456789", headers=HERE) as socket:
            socket.send_bytes(words) if isinstance(words, bytes) else socket.send_text(words)
            socket.send_text('{"abort": "the sign"}')
            for _ in range(200):  # a stream that has died raises here
                if json.loads(socket.receive_text()).get("aborted") == "the sign":
                    return
        raise AssertionError("abort was not answered")

    return say


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@example(words="[" * 100_000)
@example(words=b"\xff\x00")
@example(words='{"jog": 1' + "0" * 400 + "}")
@example(words='{"jog": NaN}')
@example(words='{"jog": true}')
@example(words='{"heard": 1e999}')
@given(words=WORDS)
def test_a_page_may_say_anything(talk, caplog, words):
    is_answered(talk, caplog, words)


@pytest.mark.prove
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(words=WORDS)
def test_a_page_may_say_anything_at_length(talk, caplog, words):
    is_answered(talk, caplog, words)


def is_answered(talk, caplog, words):
    caplog.clear()
    with caplog.at_level(logging.ERROR):
        talk(words)
    assert caplog.text == ""


ID = "0123456789abcdef"


def stream(client, id=ID, **headers):
    return client.websocket_connect(f"/api/bench/stream?client={id}", headers=HERE | headers)


@pytest.mark.prove
def test_a_page_that_hears_nothing_gets_no_more(client):
    with stream(client) as socket:
        frames = [json.loads(socket.receive_text())["frame"] for _ in range(6)]
        assert frames == [1, 2, 3, 4, 5, 6]
        socket.send_text(json.dumps({"abort": 1}))  # what comes next is its answer, and no seventh frame
        assert json.loads(socket.receive_text()) == {"aborted": 1}
