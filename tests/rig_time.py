"""Time for tests of a rig that a thread reads: simulated, so that no result depends on a busy machine, or the wall clock's.

`SimulatedTime` opens rigs that are simulated in this process and read by a thread, as a real one is. Their time passes only
while a test waits, by a block of samples at a time. `RealTime` is the wall clock, for a rig in a process of its own that
follows it (``pytest --endure``).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.console.rigs import rig_file
from dampyr.rig import Rig, RigSettings, load_settings, simulated
from dampyr.rig.acquisition import Acquisition
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.session import local_loop
from dampyr.rig.simulation.simulator import Simulator, parse_faults
from dampyr.rig.specimen import specimen_of

STEP = 0.05  # s that pass between two looks at a condition
BACKLOG = 10  # blocks that may wait for a host before time waits for it
SLOWEST = 5.0  # s of the wall clock that it waits for one that takes none
HANG = 120.0  # s of the wall clock after which what does not come is taken to hang


class RealTime:
    """The wall clock."""

    def __init__(self, *faults: str, settings: RigSettings | None = None) -> None:
        self.faults, self.settings = faults, settings
        self.while_waiting: Callable[[], object] = lambda: None  # called whenever a test waits

    def __call__(self) -> float:
        return time.monotonic()

    def open(self, data: Path, name: str, simulate: bool) -> Rig:
        """A rig in a process of its own that follows the wall clock."""
        return simulated(self.settings or rig_file(data, name), real_time=True, faults=self.faults)

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        self.while_waiting()
        time.sleep(seconds)

    def until(self, condition: Callable[[], object], seconds: float = 30.0) -> None:
        """Wait for something; fail where it does not come."""
        end = self() + seconds
        while not condition():
            assert self() < end, f"waited in vain for {condition}"
            self.sleep(0.01)

    @contextmanager
    def passing(self, factor: float | Callable[[], float] = 1.0) -> Iterator[None]:
        """Time passes by itself."""
        yield


class SimulatedTime(RealTime):
    """Time of simulated rigs: it passes while a test waits in `sleep` or `until`, or by itself within `passing`."""

    def __init__(self, *faults: str, settings: RigSettings | None = None) -> None:
        super().__init__(*faults, settings=settings)
        self._changed = threading.Condition()
        self._now, self._allowed, self._next = 0.0, 0.0, 0.0
        self._sampling = self._waits = False
        self._loop: Acquisition | None = None

    def __call__(self) -> float:
        return self._now

    def open(self, data: Path, name: str, simulate: bool) -> Rig:
        """A rig in this process whose time is this one."""
        path = rig_file(data, name)
        return self.connect(self.settings or (load_settings(path) if path else RigSettings()), path and path.parent)

    def connect(self, settings: RigSettings, folder: Path | None = None) -> Rig:
        """A rig in this process whose time is this one."""
        simulator = Simulator(settings, 0, parse_faults(self.faults), specimen_of(settings, folder))
        board = _Board(InProcessBoard(simulator), self)
        uno = Uno(InProcess(board.locked(simulator.serial)))
        return Rig(settings, uno, board, folder=folder, clock=self, make_loop=self._read)

    def _read(self, rig: Rig) -> Acquisition:
        self._loop = local_loop(rig)
        return self._loop

    def _wait_for_host(self) -> None:
        """Let the host take the blocks that wait: however slow its disk is, simulated time does not run away from it."""
        until = time.monotonic() + SLOWEST
        while (
            self._loop is not None
            and not (self._loop.over or self._loop.stopped)
            and len(self._loop.waiting) > BACKLOG
            and time.monotonic() < until
        ):
            time.sleep(0.001)

    def begin(self, sampling: bool) -> None:
        """Sampling starts, or stops; called by the board."""
        with self._changed:
            self._sampling, self._allowed = sampling, self._now
            self._changed.notify_all()

    def take(self, seconds: float) -> None:
        """Take a block's time, once it is allowed to pass; called by the thread that reads."""
        self._wait_for_host()
        with self._changed:
            self._next, self._waits = self._now + seconds - 1e-9, True
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._next <= self._allowed)
            self._now, self._waits = self._now + seconds, False

    def sleep(self, seconds: float) -> None:
        """Let ``seconds`` pass; where no rig is read, none do, and this returns after a moment."""
        self.while_waiting()
        with self._changed:
            if not self._sampling:
                self._changed.wait_for(lambda: self._sampling, timeout=0.02)
                return
            self._allowed += seconds
            self._changed.notify_all()
            used = self._changed.wait_for(
                lambda: not self._sampling or (self._waits and self._next > self._allowed), timeout=HANG
            )
            assert used, "the rig is not read any more"

    def until(self, condition: Callable[[], object], seconds: float = 30.0) -> None:
        """Wait for something; fail where it does not come in ``seconds`` of simulated time and as many of the wall clock,
        by which a slow disk works."""
        end, slow, hangs = self._now + seconds, time.monotonic() + seconds, time.monotonic() + HANG
        while not condition():
            assert self._now < end or time.monotonic() < slow, f"waited {seconds:g} s in vain for {condition}"
            assert time.monotonic() < hangs, f"waited in vain for {condition}"
            self.sleep(STEP)

    @contextmanager
    def passing(self, factor: float | Callable[[], float] = np.inf) -> Iterator[None]:
        """Time passes by itself, at most ``factor`` times as fast as the wall clock's, which may change; it lags where the
        machine is busy."""
        over = threading.Event()
        now_factor = factor if callable(factor) else lambda: factor

        def on() -> None:
            before = time.monotonic()
            while not over.wait(0.005):
                now = time.monotonic()
                with self._changed:
                    limit = max(self._next, self._now + 1.0)
                    self._allowed = min(self._allowed + now_factor() * (now - before), limit)
                    self._changed.notify_all()
                before = now

        thread = threading.Thread(target=on, daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()


class _Board:
    """A board in this process that any thread may use, and whose samples take time."""

    def __init__(self, board: Any, clock: SimulatedTime) -> None:
        self._board, self._clock, self._lock, self._rate = board, clock, threading.RLock(), 1.0
        self.queue, self.write, self.close, self.identity, self.index_counts = (
            self.locked(getattr(board, name)) for name in ("queue", "write", "close", "identity", "index_counts")
        )

    def locked(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """``call``, one at a time."""

        def one_at_a_time(*given: Any) -> Any:
            with self._lock:
                return call(*given)

        return one_at_a_time

    def start(self, rate: float, ahead: Sequence[float] | NDArray[np.float64]) -> None:
        """Start sampling."""
        self._rate = rate
        self.locked(self._board.start)(rate, ahead)
        self._clock.begin(True)

    def stop(self) -> None:
        """Stop sampling."""
        self.locked(self._board.stop)()
        self._clock.begin(False)

    def read(self, n: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """The next samples, once their time has passed."""
        self._clock.take(n / self._rate)
        return self.locked(self._board.read)(n)
