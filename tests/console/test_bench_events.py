"""The log of the bench: who did what, and when energy entered and left."""

import json
from pathlib import Path

import pytest
from fastapi.testclient import TestClient
from tests.console.bench_runs import Phase, Until, records_of, start

from dampyr.console import app
from dampyr.console.bench_events import FILE as EVENTS
from dampyr.console.bench_session import Bench


def test_the_log_says_who_did_what_and_is_kept_with_the_run(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, operator="A. Operator", specimen="damper 7", note="after repair")
    until(lambda: (run := armed.state().run) is not None and run.cycles > 0.3)
    armed.clients.join("b")
    armed.take_control("b")
    armed.abort("page 2")
    phase(armed, "idle", 5.0)
    started = "A. Operator, page 1"
    said = [f"{event.who}: {event.what}" for event in reversed(armed.events.recent())]
    for words in (
        "page 1: connects the original rig, simulated", "page 1: arms", "rig: armed", f"{started}: starts short into run",
        f"page 2: took control from {started}", "page 2: aborts",
    ):  # fmt: skip
        assert words in said, (words, said)
    energy = [words for words in said if words.startswith(("rig: armed", "rig: disarmed"))]
    assert energy == [
        "rig: armed", "rig: disarmed", f"rig: armed for the campaign short, started by {started}", "rig: disarmed",
    ]  # fmt: skip
    lines = [json.loads(line) for line in (records_of(armed) / EVENTS).read_text().splitlines()]
    assert lines[0]["what"] == "starts short into run"
    assert [line["what"] for line in lines if line["who"] == "page 2"] == [f"took control from {started}", "aborts"]
    assert Bench(armed.data).events.recent() == armed.events.recent()  # the next session shows them
    partial = next(records_of(armed).glob("*.h5"))
    assert partial.is_file()


@pytest.mark.parametrize("by_hand", [pytest.param(False, marks=pytest.mark.prove), True])
def test_the_log_says_when_energy_enters_and_leaves_in_a_campaign(
    idle: Bench, phase: Phase, until: Until, by_hand: bool
) -> None:
    """As evidence after an accident: from the begin of a campaign to its end, whether the rig was armed before or not."""
    if by_hand:
        idle.arm("a")
        phase(idle, "armed")
        idle.home("a", here=True)
        phase(idle, "armed")
    start(idle, operator="A. Operator")
    phase(idle, "campaign")
    phase(idle, "idle", 60.0)
    lines = [json.loads(line) for line in (records_of(idle) / EVENTS).read_text().splitlines()]
    said = [line["what"] for line in lines]
    first = said.index("armed for the campaign short, started by A. Operator, page 1")
    assert said[:first] == (["starts short into run"] + by_hand * ["disarmed"])
    assert said[-2:] == ["disarmed", "campaign complete"]
    assert not {"armed", "disarmed"} & set(said[first + 1 : -2])


def test_an_abort_without_a_page_names_its_address(tmp_path: Path) -> None:
    with TestClient(app(tmp_path), "http://localhost", client=("192.0.2.7", 4711)) as asking:
        assert asking.post("/api/bench/abort", json={}).status_code == 200
        event = asking.get("/api/bench/events").json()[0]
    assert (event["who"], event["what"]) == ("a request from 192.0.2.7", "aborts")
