"""The rig that is connected to the bench, and what is read of it, armed or not."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from dampyr.console.bench_alarms import Alarms
from dampyr.console.bench_events import EventLog
from dampyr.console.bench_state import ChartLimits, ConnectedRig, Live
from dampyr.console.decimation import MinMaxBins
from dampyr.console.jogging import fastest_jog
from dampyr.errors import RigFault
from dampyr.rig import Rig
from dampyr.rig.interlock import Samples

AGAIN = 5.0  # s until a board that could not be read is tried again while the rig is disarmed


@dataclass(eq=False)
class RigConnection:
    """A rig with its last status and sample; ``clock`` gives s, and the strips begin at ``born``."""

    rig: Rig
    simulated: bool
    alarms: Alarms
    events: EventLog
    clock: Callable[[], float]
    born: float
    live: Live | None = None
    _live_at: float = 0.0
    _unread: float = 0.0
    _doubted: bool = False

    def __post_init__(self) -> None:
        rig = self.rig
        self.strips = MinMaxBins(rig.settings.board.rate, self.clock() - self.born)
        self._identity, _ = rig.identity, rig.origin  # asked of the instruments here, once
        rig.watchers.append(self._take)
        self.look()

    def look(self) -> None:
        """See how the rig is; :class:`~dampyr.errors.RigFault` where it does not answer."""
        self.status = self.rig.uno.heartbeat()

    def monitor(self, until: Callable[[], bool]) -> None:
        """Read the rig, which is not armed, ``until`` there is something else to do."""
        if self.rig.clocked_by_reads or until() or self._unread > self.clock():
            return
        blocks = self.rig.monitor()
        try:
            for samples in blocks:
                self._take(samples)
                if until():
                    return
        except RigFault as problem:
            self._unread = self.clock() + AGAIN
            raise RigFault(f"nothing can be read while the rig is disarmed: {problem}", problem.ring) from None
        finally:
            blocks.close()

    def _take(self, samples: Samples) -> None:
        """A block, by the thread that reads them."""
        rig, warm = self.rig, self.rig.warmth.temperature
        self.strips.take(samples, warm, self.clock() - self.born)
        raised = self.alarms.take(samples, warm, rig.settings.board.rate)
        if (doubt := rig.warmth.doubt) and not self._doubted:
            self.alarms.raise_alarm(doubt)
            raised.append(doubt)
        self._doubted = bool(doubt)
        for words in raised:  # a disk that hesitates must not hold up the thread that reads
            threading.Thread(target=self.events.add, args=("alarm", words), name="alarm", daemon=True).start()
        self.status, self._live_at = samples.status, self.clock()
        self.live = Live(float(samples.displacement[-1]), float(samples.force[-1]), float(samples.voltage[-1]), warm)

    @property
    def live_age(self) -> float | None:
        """s since ``live`` was read; None where nothing was."""
        return round(self.clock() - self._live_at, 1) if self.live is not None else None

    def described(self) -> ConnectedRig:
        """The rig as a page shows it."""
        cell, settings, limits = self.rig.calibration, self.rig.settings, self.rig.settings.limits
        assert cell is not None
        return ConnectedRig(
            settings.name, self.simulated, self._identity, settings.board.rate, limits.stroke, cell.scale, cell.zero, cell.how,
            fastest_jog(self.status.homed), settings.specimen.name,
            ChartLimits(limits.force, settings.travel, limits.speed, limits.voltage, limits.temperature),
            self.rig.origin.notice, self.strips.lag,
        )  # fmt: skip
