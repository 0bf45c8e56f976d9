"""Clock of a simulated rig in a process of its own: advanced by the host in lockstep, by itself, or by the wall clock.

In lockstep the host's reads and heartbeats advance it. When the host's connection closes, or after three seconds of silence
while the rig is armed or moves, it runs unattended: the firmware's watchdog has to act. In real time it follows the wall clock
and waits for nobody.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Condition, Event, RLock, Thread, local

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.simulation.board_signals import TIMEOUT, BoardError
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.simulator import Simulator

SILENCE = 3.0  # s of the wall clock: longer than a slow disk delays a live host
STRIDE = 0.01  # s simulated at once when unattended: short against the watchdog's 0.15 s
PATIENCE = 60.0  # s of the wall clock until a client must have connected: a server that is never used ends


class Clock:
    """A simulator shared by the threads that serve its wires.

    ``real_time``: it follows the wall clock.
    ``terminal``: its serial wire is a pseudo-terminal, and no TCP port.
    ``once``: `finished` is set when the last client has disconnected and the table has been at rest for a second, simulated.
    """

    def __init__(
        self,
        rig: Simulator,
        event_log: EventFile,
        real_time: bool = False,
        once: bool = False,
        terminal: bool = False,
    ) -> None:
        self.rig, self.event_log, self.real_time, self.once = rig, event_log, real_time, once
        self.terminal = terminal
        rig.delay_read = self._defer_delay
        if real_time:
            rig.heartbeat_interval = 0.0
        self.lock = RLock()
        self.advanced = Condition(self.lock)
        self.finished = Event()
        self.on_end: list[Callable[[], object]] = []
        """What the wires that are served do when the process ends."""
        self.started_at = self.last_heard = time.monotonic()
        self.time_at_start = rig.time
        self.clients, self.client_seen, self.unattended = 0, False, False
        self._deferred = local()
        self.thread = Thread(target=self._run, name="clock", daemon=True)

    def start(self) -> None:
        """Start the thread that advances the clock."""
        self.started_at = self.last_heard = time.monotonic()
        self.time_at_start = self.rig.time
        self.thread.start()

    def log(self, words: str) -> None:
        """Write a line to the event log."""
        self.event_log(self.rig.time, words)

    @contextmanager
    def locked(self) -> Iterator[Simulator]:
        """Lock the rig for a client's request."""
        with self.lock:
            self.last_heard = time.monotonic()
            yield self.rig
            self.last_heard = time.monotonic()

    def client_connected(self) -> None:
        """Register a client."""
        with self.lock:
            self.clients, self.client_seen, self.unattended = self.clients + 1, True, False
            self.last_heard = time.monotonic()
            self.log("serial connected")

    def client_disconnected(self) -> None:
        """Unregister a client; without one the rig runs unattended."""
        with self.lock:
            self.clients -= 1
            self.unattended = self.clients == 0
            self.log("serial closed")

    def read(self, n: int, timeout: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Samples of the board; in real time, when they exist. The caller holds the lock."""
        deadline = time.monotonic() + (timeout if timeout >= 0.0 else 1e9)
        while self.real_time and self.rig.waiting < n:
            if not self.advanced.wait(max(0.0, deadline - time.monotonic())):
                self._step()  # which is late itself where the machine is busy
                if self.rig.waiting < n:
                    raise BoardError(TIMEOUT)
        return self.rig.read(n)

    def space(self, size: int, wanted: int, timeout: float) -> int:
        """The samples that a command's buffer of ``size`` can take; in real time it waits for ``wanted`` of them. The caller
        holds the lock.
        """
        deadline = time.monotonic() + (timeout if timeout >= 0.0 else 1e9)
        while True:
            free = size - (0 if self.rig.timed is None else self.rig.timed.held(self.rig.time))
            left = deadline - time.monotonic()
            if free >= wanted or not self.real_time or left <= 0.0:
                return max(0, free)
            self.advanced.wait(left)

    def _defer_delay(self, seconds: float) -> None:
        self._deferred.delay = seconds

    def sleep_deferred(self) -> None:
        """Sleep for the delay that a fault of the board demands; called without the lock."""
        late = getattr(self._deferred, "delay", 0.0)
        self._deferred.delay = 0.0
        if late:
            time.sleep(late)

    @property
    def hazardous(self) -> bool:
        """Whether the rig is armed or moving."""
        return self.rig.twin.enabled or bool(np.isnan(self.rig.at_rest_since))

    @property
    def rested(self) -> bool:
        """Whether the table has been at rest for a second, and is not armed."""
        return not self.hazardous and self.rig.time - self.rig.at_rest_since >= 1.0

    def _run(self) -> None:
        """Advance the clock where no host does."""
        while not self.finished.wait(0.002 if self.real_time else 0.02):
            with self.lock:
                self._step()
                self._finish()

    def _step(self) -> None:
        if self.real_time:
            self.rig.advance_to(self.time_at_start + time.monotonic() - self.started_at)
            self.advanced.notify_all()
        elif self.unattended and not self.rested:
            self._run_until_rest()
        elif not self.unattended and self.hazardous and time.monotonic() - self.last_heard > SILENCE:
            self.log("silence: runs on alone")
            self._run_until_rest()
            self.last_heard = time.monotonic()

    def _run_until_rest(self) -> None:
        """Advance until the table has been at rest for a second, unarmed; the watchdog stops it."""
        for _ in range(round(5.0 / STRIDE)):
            if self.rested:
                return
            self.rig.run_unattended(STRIDE)

    def _finish(self) -> None:
        late = not self.client_seen and time.monotonic() - self.started_at > PATIENCE
        gone = self.client_seen and self.clients == 0 and self.rested
        if self.once and (late or gone):
            self.log("ends")
            self.finished.set()
