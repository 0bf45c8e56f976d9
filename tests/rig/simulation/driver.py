"""A host for tests: requests to a simulator, and the usual beginnings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dampyr.models import Damper
from dampyr.rig.firmware.protocol import Reader, Reply, Request, SerialFrame, Status, encode, status_of
from dampyr.rig.settings import RigSettings, UnoSettings
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.simulator import Simulator

PROMPT = UnoSettings(clock_ppm=0.0, warming=0.0, shortest_latency=0.0, longest_latency=0.0)
"""An Uno with the board's clock at the end of a line that needs no time: what a test asks for happens then."""
LIMITS = (-7400, 7400, 24000, 150, 255, 500, 0, 255, 0)


class Host:
    """Asks a rig, in process or over a wire that takes bytes and gives bytes."""

    def __init__(self, wire: Callable[[bytes], bytes]) -> None:
        self.wire, self.reader, self.number, self.sent = wire, Reader(), 0, 0
        self.began = 0.0

    def ask(self, kind: Request, *values: int) -> SerialFrame:
        self.number = (self.number + 1) % 256
        (reply,) = self.reader.feed(self.wire(encode(SerialFrame(kind, self.number, values))))
        return reply

    def done(self, kind: Request, *values: int) -> int:
        reply = self.ask(kind, *values)
        assert reply.kind == Reply.ACK, reply
        return reply.values[1]

    @property
    def beat(self) -> Status:
        return status_of(self.ask(Request.HEARTBEAT))

    def wait(self) -> None:
        """Let 20 ms pass, where nothing is sampled."""
        assert self.beat

    def arm(self, place: int = 0, limits: Sequence[int] = LIMITS) -> None:
        self.ask(Request.HELLO, 3)
        self.done(Request.CLEAR)
        self.done(Request.LIMITS, *limits)
        self.done(Request.HOME, 0, place)
        assert self.beat.homed
        self.done(Request.ARM)

    def feed(self, points: Any) -> Status:
        """A heartbeat, and the set points that find a place."""
        status = self.beat
        free = status.free
        while free and self.sent < len(points):
            some = [int(p) for p in points[self.sent : self.sent + min(16, free)]]
            free = self.done(Request.SETPOINTS, self.sent, *some)
            self.sent += len(some)
        return status


def rig(
    settings: RigSettings | None = None, *faults: str, specimen: Damper | None = None, **more: Any
) -> tuple[Simulator, Host]:
    """A simulator and its host; its Uno is `PROMPT`."""
    made = Simulator(
        replace(settings or RigSettings(), uno=PROMPT), 1, [FaultSpec.parse(f) for f in faults], specimen, **more
    )
    return made, Host(made.serial)


def sine(amplitude: float, frequency: float, cycles: int, period: float) -> np.ndarray:
    """Counts of a sine that begins and ends at rest, a cycle of taper at both ends."""
    t = np.arange(round(cycles / frequency / period) + 1) * period
    taper = np.minimum(1.0, np.minimum(t, t[-1] - t) * frequency)
    return np.round(amplitude * taper * np.sin(2 * np.pi * frequency * t) / 5e-6).astype(int)


def follow(made: Simulator, host: Host, points: np.ndarray, period: int = 10) -> tuple[np.ndarray, np.ndarray]:
    """Sample at 1 kHz while the table follows: volts (n,) and counts (n,), beginning with FOLLOW."""
    host.sent = 0
    host.feed(points)
    host.done(Request.FOLLOW, period, len(points))
    host.began = made.time
    made.start(1000.0)
    blocks = []
    for _ in range(len(points) * period // 40 + 1):
        blocks.append(made.read(40))
        host.feed(points)
    made.stop()
    return np.concatenate([v[0] for v, _ in blocks]), np.concatenate([c for _, c in blocks])
