"""A campaign in real time while everything else that a console does goes on beside it."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")
import httpx
from tests.console.conftest import served
from tests.console.test_workers import CUBE, DOTTED
from tests.endurance import Endurance
from websockets.sync import client

from dampyr.campaigns import read_journal
from dampyr.records import Record, read, write

CAMPAIGN = """
name = "beside"
rest_between = "0.5 s"
[[step]]
kind = "sine"
amplitude = "6 mm"
frequency = "1 Hz"
cycles = {cycles}
voltage = {voltages}
"""
GRID = """
name = "grid"
[[step]]
kind = "sine"
amplitude = ["1 mm", "2 mm", "3 mm", "4 mm", "5 mm"]
frequency = ["0.5 Hz", "1 Hz", "1.5 Hz", "2 Hz"]
voltage = ["0 V", "0.5 V", "1 V", "1.5 V", "2 V"]
cycles = 10
repeats = 4
"""
ID = "page-number-{}"


class Page(threading.Thread):
    """A page that looks on, draws what it hears and can abort."""

    def __init__(self, address: str, number: int) -> None:
        super().__init__(daemon=True)
        self.place = address.replace("http", "ws", 1) + f"api/bench/stream?client={ID.format(number)}"
        self.origin = address.rstrip("/")
        self.state: dict[str, Any] = {}
        self.frames, self.aborted, self.problem = 0, threading.Event(), None

    def run(self) -> None:
        try:
            with client.connect(self.place, origin=self.origin, max_size=None) as self.socket:
                for text in self.socket:
                    self.take(json.loads(text))
        except Exception as problem:  # the console has ended, or refuses this page
            self.problem = problem

    def take(self, message: dict[str, Any]) -> None:
        self.state = message.get("state") or self.state
        if "aborted" in message:
            self.aborted.set()
        if "frame" in message:
            self.frames += 1
            self.socket.send(json.dumps({"heard": message["frame"]}))

    def until(self, condition: Callable[[dict[str, Any]], object], seconds: float) -> None:
        end = time.monotonic() + seconds
        while not (self.state and condition(self.state)):
            assert self.problem is None, self.problem
            assert time.monotonic() < end, self.state.get("note")
            time.sleep(0.01)


class Bench:
    """A served console with two pages and one simulated rig in real time, connected by the first page."""

    def __init__(self, address: str, rig: str = "") -> None:
        self.http = httpx.Client(base_url=address, headers={"origin": address.rstrip("/")}, timeout=120.0)
        self.pages = [Page(address, k) for k in range(2)]
        for page in self.pages:
            page.start()
        self.page = self.pages[0]
        self.page.until(lambda state: True, 30.0)
        self.tell("control")
        self.tell("connect", rig=rig, simulate=True)
        self.page.until(lambda state: state["phase"] == "idle", 60.0)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
        self.http.close()

    def tell(self, what: str, **given: Any) -> None:
        answer = self.http.post(f"/api/bench/{what}", json={"client": ID.format(0)} | given)
        assert answer.status_code < 300, answer.text

    def save(self, name: str, text: str) -> None:
        answer = self.http.put(f"/api/campaigns/files/{name}", json={"text": text, "rig": ""})
        assert answer.status_code < 300, answer.text

    def start(self, name: str, folder: str) -> None:
        self.tell("start", campaign=name, folder=folder)
        self.page.until(lambda state: state["phase"] == "campaign", 30.0)

    def ended(self, seconds: float) -> dict[str, Any]:
        self.page.until(lambda state: state["phase"] != "campaign", seconds)
        return dict(self.page.state["run"])

    def abort(self) -> float:
        """Abort as the page does; s until it was told that the rig has done it."""
        begun = time.monotonic()
        self.page.socket.send(json.dumps({"abort": 1}))
        assert self.page.aborted.wait(5.0)
        return time.monotonic() - begun


@contextmanager
def work(address: str, counts: dict[str, int], folder: Path) -> Iterator[None]:
    """Plans, uploads and fits, one after the other and all at once, until the block ends."""
    over, rows = threading.Event(), upload(folder)

    def again(name: str, once: Callable[[Any, int], Any]) -> None:
        with httpx.Client(base_url=address, headers={"origin": address.rstrip("/")}, timeout=300.0) as http:
            while not over.is_set():
                answer = once(http, counts[name])
                assert answer.status_code < 300, answer.text
                counts[name] += 1

    def fit(http: Any, number: int) -> Any:
        key = "data/uploads/test-0.h5"
        job = http.post("/api/identify/jobs", json={"records": [key], "model": "dahl + spring + offset"})
        while (
            job.status_code < 300 and not over.is_set() and state_of(http, job) not in ("done", "failed", "cancelled")
        ):
            time.sleep(0.2)
        return job

    def state_of(http: Any, job: Any) -> str:
        return str(http.get(f"/api/jobs/{job.json()['id']}").json()["state"])

    def send(http: Any, number: int) -> Any:
        """Send a record, and take the one before away, but for the first, which is fitted."""
        if number > 1:
            http.delete(f"/api/records/uploads/test-{number - 1}.h5")
        about = {"params": {"voltage": "1"}, "headers": {"content-type": "application/octet-stream"}}
        return http.put(f"/api/records/uploads/test-{number}.csv", content=rows, **about)

    def plan(http: Any, number: int) -> Any:
        """A plan of 400 tests, and in turn what is refused."""
        refused = http.post("/api/campaigns/plan", json={"text": (DOTTED, CUBE)[number % 2], "rig": ""})
        assert refused.status_code == 400, refused.text
        return http.post("/api/campaigns/plan", json={"text": GRID, "rig": ""})

    tasks: dict[str, Callable[[Any, int], Any]] = {
        "plans": plan,
        "uploads": send,
        "fits": fit,
    }
    with httpx.Client(base_url=address, headers={"origin": address.rstrip("/")}, timeout=120.0) as http:
        answer = tasks["uploads"](http, 0)
        assert answer.status_code < 300, answer.text
        counts["uploads"] += 1
    threads = [threading.Thread(target=again, args=each, daemon=True) for each in tasks.items()]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        over.set()
        for thread in threads:
            thread.join(120.0)


def upload(folder: Path) -> bytes:
    """A record of 30,000 samples as CSV."""
    t = np.arange(30000) / 1000.0
    x = 5e-3 * np.sin(2.0 * np.pi * t)
    force = 100.0 * np.tanh(np.gradient(x, t) / 3e-3) + 1e3 * np.gradient(x, t)
    return write(Record(t, x, force), folder / "made.csv").read_bytes()


@pytest.mark.by_hand  # in real time
@pytest.mark.endure
def test_a_campaign_in_real_time_beside_plans_uploads_fits_and_two_pages(
    data: Path, tmp_path: Path, endurance: Endurance
) -> None:
    seconds = endurance.count(600, part=60)
    tests = max(2, seconds // 60)
    voltages = [f"{0.1 * (k % 20):.1f} V" for k in range(tests)]
    counts = {"plans": 0, "uploads": 0, "fits": 0}
    with served(data) as address, Bench(address) as bench:
        bench.save("beside", CAMPAIGN.format(cycles=seconds // tests - 2, voltages=voltages))
        with work(address, counts, tmp_path):
            begun = time.monotonic()
            bench.start("beside", "beside")
            run = bench.ended(3.0 * seconds + 120.0)
            took = time.monotonic() - begun
            assert run["outcome"] == "complete", run["reason"]
            bench.start("beside", "aborted")
            bench.page.until(lambda state: state["run"]["cycles"] > 0.5, 60.0)
            stopped = bench.abort()
            bench.ended(30.0)
        frames = min(page.frames for page in bench.pages) / took
    journal, _ = read_journal(data / "runs" / "beside")
    assert [test.state for test in journal] == ["complete"] * tests
    assert all(test.attempt == 1 for test in journal)
    samples = 0
    for path in sorted((data / "runs" / "beside").glob("*.h5")):
        record = read(path)
        assert np.ptp(np.diff(record.time)) < 1e-9  # no sample is missing
        assert record.marks == ()
        samples += record.n
    assert min(counts.values()) > 0, counts
    endurance.report(
        "a campaign in real time beside plans, uploads, fits and two pages",
        None,
        f"{took:.0f} s, {samples} samples, none missing, no trip, beside {counts['plans']} plans of 400 tests, "
        f"{counts['uploads']} uploads of 30,000 samples and {counts['fits']} fits; abort after {1e3 * stopped:.0f} ms; "
        f"{frames:.0f} frames/s to each page",
    )
    if endurance.full:  # as the page sees it, on a machine that has nothing else to do
        assert stopped < 0.150


@pytest.mark.endure
@pytest.mark.by_hand  # in real time; the guide of the bench, twice with one rig, is the proof that is always run
def test_starts_of_a_campaign_in_a_row(data: Path, endurance: Endurance) -> None:
    starts = max(2, endurance.count(10))
    with served(data) as address, Bench(address) as bench:
        bench.save("short", CAMPAIGN.format(cycles=6 if endurance.full else 2, voltages=["0.5 V", "1 V"]))
        for k in range(starts):
            bench.start("short", f"run-{k}")
            run = bench.ended(120.0)
            assert run["outcome"] == "complete", (k, run)
    endurance.report("starts of a campaign in a row, one rig in real time", None, f"{starts} of {starts} complete")
