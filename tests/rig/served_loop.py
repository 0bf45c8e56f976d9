"""A rig in simulated time, read by a server in a thread, which stands for the other process."""

import threading
from multiprocessing import Pipe

import numpy as np
from tests.rig_time import SimulatedTime

from dampyr.rig import Drive, Rig, RigSettings
from dampyr.rig.loop_process import Link, LoopProcess, StandIn, remote_rig
from dampyr.rig.loop_server import LoopServer


class Served:
    """A rig read by a server in a thread, which stands for the other process; its time is simulated."""

    def __init__(self, *faults: str) -> None:
        self.time = SimulatedTime(*faults)
        self.inner = self.time.connect(RigSettings())
        (questions, self._questions), (blocks, self._blocks) = Pipe(), Pipe()
        self.server = LoopServer(questions, blocks, lambda *_: (self.inner.uno, self.inner.board), self.time)

        def serve() -> None:
            with questions, blocks:  # as when a process ends
                self.server.serve()

        self.thread = threading.Thread(target=serve, daemon=True)
        self.thread.start()
        self.link = Link(self._questions, self._blocks)
        self.link.ask("open", RigSettings())
        self.rig = remote_rig(self.link, RigSettings())


def stroke(start: float, seconds: float = 2.0) -> Drive:
    t = np.arange(0.0, seconds, 0.01)
    return Drive(0.01, start + 0.002 * (1.0 - np.cos(2.0 * np.pi * t)), np.full(t.size, 1.0))


def reader_of(rig: Rig) -> int:
    """The process that reads a rig."""
    assert isinstance(rig.uno, StandIn)
    assert isinstance(rig.uno._link, LoopProcess)
    return rig.uno._link.pid
