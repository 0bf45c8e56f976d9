"""The simulated rig in real time: it follows the wall clock, in the process that reads it.

Such a rig stands for hardware, which waits for nobody; but where the machine is too busy for the process that simulates and
reads it, its clock is held back, and what is late is not a fault of the rig. Time is measured by that clock.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Condition, Event, RLock, Thread
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.simulation.ground_truth import LASTING
from dampyr.rig.simulation.simulator import Simulator

STRIDE = 0.002  # s between two steps of the clock
STALL = 0.05  # s between two steps of a clock that runs: more is a machine that is too busy for it
MAX_HOLD = 1.0  # s for which a host that reads nothing is waited for
REST = 5.0  # s in which a rig without a host comes to rest: its watchdog stops it within 0.2 s


class RealTimeSimulator(Simulator):
    """A `Simulator` whose time passes by itself, and that several threads may use.

    A thread advances it to the wall clock's time, and so does each request before it is answered. While it samples it runs no
    more than two blocks ahead of what has been read, unless nothing has been read for a second; by how much its clock was held
    back is in ``held`` [s]. It reports events, and stores no rows of the ground truth.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._lock, self._depth = RLock(), 1  # no request before it is there
        super().__init__(*args, **kwargs)
        self._depth = 0
        self.heartbeat_interval = 0.0
        self.truth_log.capacity = 0  # nobody in this process looks at it, and it may run for days
        self.delay_read = self._defer
        self.held = 0.0
        self._advanced = Condition(self._lock)
        self._over = Event()
        self._began = self._stepped_at = self._read_at = time.monotonic()
        self._time_at_start, self._wanted, self._delayed, self._delay = self.time, 0, 0, 0.0
        self._thread = Thread(target=self._run, name="simulated rig", daemon=True)
        self._thread.start()

    def clock(self) -> float:
        """The wall clock at the last step, less what this one was held back, s: it stands while this process does not run."""
        return self._stepped_at - self.held

    def close(self) -> None:
        """Wait until the table is at rest and the coil dead, by the firmware's watchdog at the latest; then time stands."""
        until = time.monotonic() + REST
        while not self._is_at_rest() and time.monotonic() < until and self._thread.is_alive():
            time.sleep(STRIDE)
        self._over.set()
        self._thread.join()
        super().close()

    def _is_at_rest(self) -> bool:
        """Whether table and coil have been at rest for longer than `LASTING`, after which the log reports it."""
        with self._lock:
            return not self.twin.enabled and self.time - max(self.at_rest_since, self.coil_dead_since) > LASTING

    # requests of the host

    @contextmanager
    def at_one_time(self) -> Iterator[None]:
        """Requests at the wall clock's time; no time passes between them, and no request of another thread comes between."""
        with self._lock:
            if not self._depth:
                self._follow()
            self._depth += 1
            try:
                yield
            finally:
                self._depth -= 1

    def start(self, rate: float) -> None:
        """As `Simulator.start`."""
        with self.at_one_time():
            super().start(rate)

    def stop(self) -> None:
        """As `Simulator.stop`."""
        with self.at_one_time():
            super().stop()

    def read(self, n: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """As `Simulator.read`, once the samples exist."""
        with self._lock:
            self._read_at, self._wanted = time.monotonic(), n
            try:
                self._follow()
                while self.sampling and self.waiting < n and not self._over.is_set():
                    self._advanced.wait(STRIDE)
                    self._follow()
            finally:
                self._wanted, self._read_at = 0, time.monotonic()
            with self.at_one_time():
                samples = super().read(n)
            late, self._delay = self._delay, 0.0
        if late:
            self._sleep(late)
        return samples

    def index_counts(self) -> NDArray[np.int64]:
        """As `Simulator.index_counts`."""
        with self.at_one_time():
            return super().index_counts()

    def queue(self, volts: NDArray[np.float64]) -> None:
        """As `Simulator.queue`."""
        with self.at_one_time():
            super().queue(volts)

    def write(self, volts: float) -> None:
        """As `Simulator.write`."""
        with self.at_one_time():
            super().write(volts)

    def write_later(self, volts: float, latency: float) -> None:
        """As `Simulator.write_later`."""
        with self.at_one_time():
            super().write_later(volts, latency)

    # the clock

    def _defer(self, seconds: float) -> None:
        """Delay a reading by so much once its lock is released, so that other requests do not wait."""
        self._delay = seconds

    def _let_pass(self, seconds: float) -> None:
        """As `Simulator._let_pass`, on the wall clock; requests of other threads come between."""
        if seconds:
            time.sleep(seconds)

    def _sleep(self, seconds: float) -> None:
        """A delay of the board's: the host waits for it, and not the rig for the host."""
        with self._lock:
            self._delayed += 1
        time.sleep(seconds)
        with self._lock:
            self._delayed -= 1
            self._read_at = time.monotonic()

    def _run(self) -> None:
        """Advance the clock where no request does."""
        while not self._over.wait(STRIDE):
            with self._lock:
                self._follow()
                self._advanced.notify_all()

    def _follow(self) -> None:
        """Advance to the wall clock's time, or less far where the host is late; the caller holds the lock."""
        now = time.monotonic()
        # while this process did not run the host was not silent
        self._read_at += max(0.0, now - self._stepped_at - STALL)
        self._stepped_at = now
        due = self._time_at_start + now - self._began - self.held
        if self.sampling and not self._delayed and now - self._read_at <= MAX_HOLD:
            rate = self.settings.board.rate
            block = round(self.settings.board.block * rate)
            latest = self.time + max(0, max(2 * block, self._wanted + block) - self.waiting) / rate
            self.held += max(0.0, due - latest)
            due = min(due, latest)
        self._depth += 1  # what is output meanwhile is at its own time
        try:
            self.advance_to(due)
        finally:
            self._depth -= 1
