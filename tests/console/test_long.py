"""Minutes at 10 kHz on two channels, two pages looking on: nothing lost, memory flat in every process, little work."""

import json
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fastapi")

from fastapi.testclient import TestClient
from tests.console.conftest import served
from tests.console.layers import state_of
from tests.console.memory import descendants, resident
from tests.console.test_beside_work import Bench
from tests.endurance import Endurance
from tests.rig_time import HANG

from dampyr.console import app
from dampyr.console.rigs import Opener
from dampyr.records import read
from dampyr.rig import RigSettings, simulated
from dampyr.rig.settings import BoardSettings, Wires

HERE = "http://127.0.0.1:8077"
RATE = 10_000.0
FAST = """
name = "fast"
[board]
rate = "10 kHz"
[wires]
temperature = "ai1"
"""
MAX_GROWTH = 20.0  # MiB of each process in ten minutes
CAMPAIGN = """
name = "long"
check_amplitude = 0.0
[[step]]
kind = "sine"
amplitude = "6 mm"
frequency = "1 Hz"
cycles = {cycles}
voltage = "0.8712 V"
"""


def fast(real_time: bool) -> Opener:
    """Two channels at 10 kHz; in lockstep as quick as this machine is, each second the same work as a real one."""
    settings = RigSettings(board=BoardSettings(rate=RATE), wires=Wires(temperature="ai1"))
    return lambda *_: simulated(settings, real_time=real_time)


class Page(threading.Thread):
    """A page that looks on: hears, and counts."""

    def __init__(self, client: TestClient, id: str) -> None:
        super().__init__(daemon=True)
        self.client, self.id, self.bins, self.frames, self.over = client, id, 0, 0, threading.Event()

    def run(self) -> None:
        place = f"/api/bench/stream?client={self.id}"
        with self.client.websocket_connect(place, headers={"host": HERE[7:]}) as socket:
            while not self.over.is_set():
                message = json.loads(socket.receive_text())
                if "frame" in message:
                    self.frames += 1
                    self.bins += len(message["strips"]["time"]) if message["strips"] else 0
                    socket.send_text(json.dumps({"heard": message["frame"]}))

    def close(self) -> None:
        """Look on no longer: a page that closes while its client closes would wait for it, and it for the page."""
        self.over.set()
        self.join(60.0)
        assert not self.is_alive()


@pytest.mark.prove
@pytest.mark.endure
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_minutes_at_10_khz(data: Path, endurance: Endurance) -> None:
    seconds = endurance.count(600)
    (data / "campaigns").mkdir()
    (data / "campaigns" / "long.toml").write_text(CAMPAIGN.format(cycles=seconds - 2))
    opener = fast(real_time=endurance.full)
    with TestClient(app(data, opener=opener), base_url=HERE) as client, ExitStack() as closing:
        bench = state_of(client.app).own["bench"]
        pages = [Page(client, f"page-number-{k}") for k in range(2)]
        for page in pages:
            page.start()
            closing.callback(page.close)
        while bench.clients.count < 2:
            time.sleep(0.05)
        holder = bench.clients.holder
        bench.connect(holder)
        connected = time.monotonic() + HANG
        while bench.state().phase != "idle":
            assert time.monotonic() < connected, bench.state().note
            time.sleep(0.05)
        begun, work = time.monotonic(), time.process_time()
        bench.start(holder, "long", "long")
        held: list[float] = []
        while bench.state().phase == "campaign":
            time.sleep(0.1)
            if bench.state().run.fraction > 0.02:
                held.append(resident())
        work, wall = time.process_time() - work, time.monotonic() - begun
        run = bench.state().run
    assert run is not None
    assert run.outcome == "complete", run.reason
    [path] = (data / "runs" / "long").glob("*.h5")
    record = read(path)
    assert np.ptp(np.diff(record.time)) < 1e-9  # no sample is missing
    assert record.time.size >= seconds * RATE
    settled = held[len(held) // 4]
    grown = max(held[len(held) // 4 :]) - settled
    share = work / record.time[-1]
    frames = [page.frames for page in pages]
    endurance.report(
        "a campaign at 10 kHz on two channels, two pages looking on",
        None,
        f"{record.time.size} samples, none missing; {share:.0%} of a core at real time; memory grew by {grown:.1f} MiB; "
        f"{min(frames) / wall:.0f} frames/s to each page",
    )
    assert grown < 32.0
    if endurance.full:  # what a busy machine does not give
        assert min(frames) > 10 * wall
        assert share < 0.30


@pytest.mark.prove
@pytest.mark.endure
def test_no_process_of_a_rig_at_10_khz_in_real_time_grows(data: Path, endurance: Endurance) -> None:
    """Where a console and the process that simulates and reads its rig hold what nobody asks for, they grow without end."""
    seconds = endurance.count(600, part=12)
    for name, text in (("campaigns/long.toml", CAMPAIGN.format(cycles=seconds)), ("rigs/fast/rig.toml", FAST)):
        (data / name).parent.mkdir(parents=True)
        (data / name).write_text(text)
    before = set(descendants())
    with served(data) as address, Bench(address, "fast") as bench:
        held: dict[int, list[float]] = {pid: [] for pid in descendants() if pid not in before}
        bench.start("long", "long")
        bench.page.until(lambda state: state["run"]["phase"] == "testing", 60.0)
        begun, looked = time.monotonic(), 0.0
        while bench.page.state["phase"] == "campaign" and bench.page.state["run"]["fraction"] < 0.97:
            time.sleep(0.25)
            looked = time.monotonic() - begun
            for pid, sizes in held.items():
                sizes.append(resident(pid))
        frames = min(page.frames for page in bench.pages) / looked
        aborted = bench.abort()
        run = bench.ended(60.0)
    assert run["outcome"] == "aborted", run["reason"]
    # it settles in a quarter of the time; then the median of the last quarter over that of the one after the first
    quarter = len(next(iter(held.values()))) // 4
    ten_minutes = 600.0 / (0.5 * looked)
    grown = {
        pid: ten_minutes * float(np.median(sizes[-quarter:]) - np.median(sizes[quarter : 2 * quarter]))
        for pid, sizes in held.items()
    }
    largest = {pid: max(sizes) for pid, sizes in held.items()}
    endurance.report(
        "a campaign at 10 kHz in real time on a served console, two pages looking on: memory of each of its processes",
        None,
        f"{looked:.0f} s; they grow by {max(grown.values()):.1f} MiB in ten minutes at most, "
        f"of {max(largest.values()):.0f} MiB; "
        f"abort after {1e3 * aborted:.0f} ms; {frames:.0f} frames/s to each page",
    )
    assert len(held) >= 2  # the console, and the process of the rig
    assert max(grown.values()) < MAX_GROWTH, (grown, largest)
    if endurance.full:  # as a page sees it, on a machine that has nothing else to do
        assert aborted < 0.050
