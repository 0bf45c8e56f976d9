"""Minutes of simulated time at 10 kHz on two channels, two pages looking on: nothing lost, memory flat, little work."""

import json
import resource
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fastapi")

from fastapi.testclient import TestClient
from tests.console.layers import state_of
from tests.endurance import Endurance
from tests.rig_time import HANG

from dampyr.console import app
from dampyr.console.rigs import Opener
from dampyr.records import read
from dampyr.rig import RigSettings, simulated
from dampyr.rig.settings import BoardSettings, Wires

HERE = "http://127.0.0.1:8077"
RATE = 10_000.0
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


def memory() -> int:
    """Bytes that this process holds now."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


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
        held: list[int] = []
        while bench.state().phase == "campaign":
            time.sleep(0.1)
            if bench.state().run.fraction > 0.02:
                held.append(memory())
        work, wall = time.process_time() - work, time.monotonic() - begun
        run = bench.state().run
    assert run is not None
    assert run.outcome == "complete", run.reason
    [path] = (data / "runs" / "long").glob("*.h5")
    record = read(path)
    assert np.ptp(np.diff(record.time)) < 1e-9  # no sample is missing
    assert record.time.size >= seconds * RATE
    settled = held[len(held) // 4]
    grown = (max(held[len(held) // 4 :]) - settled) / 2**20
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
