"""Who moves the clock of a simulated rig at the end of its wires: the host in lockstep, the rig alone, or the wall's clock.

In lockstep the host's reads and heartbeats move it. When the host's connection closes, or after three seconds of silence
while the rig is armed or moves, it runs on alone: the firmware's watchdog has to act. In real time the wall's clock moves it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Condition, Event, RLock, Thread, local

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.simulation.board_signals import TIMEOUT, BoardError
from dampyr.rig.simulation.simulator import Simulator

SILENCE = 3.0  # s of the wall's clock: longer than a slow disk keeps a host that lives
STRIDE = 0.01  # s simulated at once when alone
PATIENCE = 60.0  # s of the wall's clock until a client must have come


class EventLog:
    """A line of JSON for each thing that happened, on disk as it happens."""

    def __init__(self, path: str | Path | None) -> None:
        self.path = None if path is None else Path(path)

    def __call__(self, when: float, event: str) -> None:
        if self.path is not None:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"time": round(when, 6), "event": event}) + "\n")


class Keeper:
    """A simulator shared by the wires' threads.

    ``real_time``: the wall's clock moves it. ``once``: `finished` is set when the last client has left and the table has
    rested for a second, simulated.
    """

    def __init__(self, rig: Simulator, box: EventLog, real_time: bool = False, once: bool = False) -> None:
        self.rig, self.box, self.real_time, self.once = rig, box, real_time, once
        rig.wait = self._owe
        if real_time:
            rig.beat = 0.0
        self.lock = RLock()
        self.moved = Condition(self.lock)
        self.finished = Event()
        self.born = self.heard = time.monotonic()
        self.begun = rig.time
        self.clients, self.came, self.alone = 0, False, False
        self._debts = local()
        self.thread = Thread(target=self._watch, name="clock", daemon=True)

    def begin(self) -> None:
        """Begin to keep the clock."""
        self.born = self.heard = time.monotonic()
        self.begun = self.rig.time
        self.thread.start()

    def tell(self, words: str) -> None:
        """A line in the black box."""
        self.box(self.rig.time, words)

    @contextmanager
    def holding(self) -> Iterator[Simulator]:
        """Hold the rig for what a client asks."""
        with self.lock:
            self.heard = time.monotonic()
            yield self.rig
            self.heard = time.monotonic()

    def joined(self) -> None:
        """A client has come."""
        with self.lock:
            self.clients, self.came, self.alone = self.clients + 1, True, False
            self.heard = time.monotonic()
            self.tell("serial connected")

    def left(self) -> None:
        """A client has gone: the rig runs on alone from here."""
        with self.lock:
            self.clients -= 1
            self.alone = self.clients == 0
            self.tell("serial closed")

    def read(self, n: int, timeout: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Samples of the board; in real time, when they exist. The rig is held by the caller."""
        deadline = time.monotonic() + (timeout if timeout >= 0.0 else 1e9)
        while self.real_time and self.rig.waiting < n:
            if not self.moved.wait(max(0.0, deadline - time.monotonic())) and time.monotonic() >= deadline:
                raise BoardError(TIMEOUT)
        return self.rig.read(n)

    def _owe(self, seconds: float) -> None:
        self._debts.late = seconds

    def pay(self) -> None:
        """Be late where a fault of the board says so; the rig is not held meanwhile."""
        late = getattr(self._debts, "late", 0.0)
        self._debts.late = 0.0
        if late:
            time.sleep(late)

    @property
    def dangerous(self) -> bool:
        """Armed or moving."""
        return self.rig.twin.enabled or bool(np.isnan(self.rig.at_rest_since))

    @property
    def settled(self) -> bool:
        """At rest for a second, and not armed."""
        return not self.dangerous and self.rig.time - self.rig.at_rest_since >= 1.0

    def _watch(self) -> None:
        """Move the clock where no host does."""
        while not self.finished.wait(0.002 if self.real_time else 0.02):
            with self.lock:
                self._step()
                self._end()

    def _step(self) -> None:
        if self.real_time:
            self.rig.advance_to(self.begun + time.monotonic() - self.born)
            self.moved.notify_all()
        elif self.alone and not self.settled:
            self._run_on()
        elif not self.alone and self.dangerous and time.monotonic() - self.heard > SILENCE:
            self.tell("silence: runs on alone")
            self._run_on()
            self.heard = time.monotonic()

    def _run_on(self) -> None:
        """Alone until the table has rested for a second, unarmed; the watchdog sees to that."""
        for _ in range(round(5.0 / STRIDE)):
            if self.settled:
                return
            self.rig.alone(STRIDE)

    def _end(self) -> None:
        late = not self.came and time.monotonic() - self.born > PATIENCE
        gone = self.came and self.clients == 0 and self.settled
        if self.once and (late or gone):
            self.tell("ends")
            self.finished.set()
