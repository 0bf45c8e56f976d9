"""Player of a drive: set points to the Uno ahead of their time, the coil's voltage to the board on its clock.

The Uno goes from set point to set point by its own clock, and begins when the request has come through its line. So what it is
sent are the positions that the drive has, on the board's clock, when the Uno will be there: `dampyr.rig.uno_clock`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.drive import Drive, DutyReversals
from dampyr.rig.firmware.protocol import QUEUE, State, Status
from dampyr.rig.instruments.contract import TableDrive
from dampyr.rig.interlock import Samples
from dampyr.rig.settings import RigSettings
from dampyr.rig.uno_clock import UnoClock

Array = NDArray[np.float64]
RESERVE = 0.2  # s of set points beyond the next block: the Uno stops by itself where its host is silent for less
SLEW = 0.02  # by which the motion may be faster or slower, to take up a change of `Player.begin_time`
SPARE_POINTS = 3  # at rest after the last, for a begin that is not measured yet


@dataclass
class Player:
    """One drive under way; sample ``start`` is when it begins.

    The Uno begins to follow earlier, at rest, so that it is known when it did before the drive begins.
    """

    drive: Drive
    rig: RigSettings
    uno: TableDrive
    start: int
    clock: UnoClock = field(default_factory=UnoClock)
    sent: int = 0
    running: bool = False
    finished: bool = False
    points: int = field(init=False, default=0)
    """Set points that the Uno is sent."""
    path: Callable[[Array], Array] = field(init=False)
    """Position [m] at times of the drive [s], once it is prepared."""
    ratio: float = field(init=False, default=1.0)
    """Milliseconds of the Uno's to one of the board's, as the drive began."""
    begin_time: float = field(init=False, default=0.0)
    """s of the drive at which the Uno is at its first set point, as what is sent next takes it."""
    _begin_range: tuple[int, int] | None = field(init=False, default=None)
    """Between which of its milliseconds the Uno began to follow."""

    def prepare(self) -> None:
        """Interpolate the path: through the set points, without overshoot where it has a corner."""
        from scipy.interpolate import Akima1DInterpolator

        self.path = Akima1DInterpolator(self.drive.time, self.drive.displacement)

    @property
    def ahead(self) -> int | None:
        """Samples by which its voltage is asked for ahead of the reading; None: as the loop does."""
        return None

    @property
    def end(self) -> int:
        """The sample after the last."""
        return self.start + round(self.drive.duration * self.rig.board.rate) + 1

    def recorded_slice(self, first: int, n: int) -> slice:
        """Which of n samples from ``first`` on are to be recorded."""
        rate, drive = self.rig.board.rate, self.drive
        begin = self.start + round(drive.record_from * drive.period * rate)
        last = drive.n - 1 if drive.record_to is None else drive.record_to
        end = self.start + round(last * drive.period * rate) + 1
        return slice(min(max(begin - first, 0), n), min(max(end - first, 0), n))

    def voltage(self, first: int, n: int) -> Array:
        """The coil's voltage for n samples from ``first`` on; 0 V after the last set point."""
        time = (np.arange(first, first + n) - self.start) / self.rig.board.rate
        point = np.clip(np.floor(time / self.drive.period + 1e-9).astype(int), 0, self.drive.n - 1)
        return np.where(time > self.drive.duration + 1e-9, 0.0, self.drive.voltage[point])

    def target(self, first: int, n: int) -> Array | None:
        """The position [m] that is asked for at n samples from ``first`` on, nan outside of the drive; None where none is."""
        if self.drive.standing or self.drive.reversals is not None:
            return None
        target: Array = self.path((np.arange(first, first + n) - self.start) / self.rig.board.rate)
        return target

    def take(self, samples: Samples) -> None:
        """Take what was measured, before anything that follows from it is asked for."""

    def feed(self, samples: Samples) -> None:
        """Start, keep the queue filled, detect the end, after a block of samples was read."""
        now, status = samples.first + samples.n, samples.status
        if not self.running:
            self._start(now)
        elif not self.finished:
            if self.drive.standing:
                self.finished = now >= self.end
            elif status.state is State.ARMED:
                self.finished = True
            elif self.drive.reversals is None:
                self._narrow_begin(status)
                self._keep_filled(status.next - QUEUE + status.free, status.free)

    def _start(self, now: int) -> None:
        """Start what is played, now that sample ``now`` is next, or wait."""
        if not self.drive.standing and self.drive.reversals is None:
            self._follow(now)
        elif now >= self.start:
            self.running = True
            if self.drive.reversals is not None:
                self._reverse(self.drive.reversals)

    def _follow(self, now: int) -> None:
        """Have the Uno follow its set points, from where the table rests."""
        self.running = True
        self.ratio = self.clock.ratio.value
        self.begin_time = (now - self.start) / self.rig.board.rate + self.clock.latency
        path = (self.drive.duration - self.begin_time) / self.drive.period
        self.points = math.ceil(path * self.ratio - 1e-9) + 1 + SPARE_POINTS
        # Those before the drive begins, at rest: how the further ones lie follows from when the Uno began.
        self._keep_filled(0, max(2, math.floor(-self.begin_time / self.drive.period)))
        self.uno.follow(self._period, self.points)

    def _reverse(self, reversals: DutyReversals) -> None:
        """Begin reversals of the duty, whose times are told in the Uno's milliseconds."""
        ms = 1000 * self.clock.ratio.value
        half, pause = round(reversals.half_period * ms), round(reversals.pause * ms)
        self.uno.reverse(round(reversals.duty * 255), half, pause, reversals.count)

    @property
    def _period(self) -> int:
        """ms of the Uno's from set point to set point."""
        return round(self.drive.period * 1000)

    def _narrow_begin(self, status: Status) -> None:
        """Narrow down when the Uno began to follow: its time, less the whole periods that it has followed."""
        if status.state is not State.FOLLOWING:
            return
        followed = (status.next - QUEUE + status.free) * self._period
        earliest, latest = status.time - followed - self._period + 1, status.time - followed
        low, high = self._begin_range or (earliest, latest)
        self._begin_range = max(low, earliest), min(high, latest)

    def _keep_filled(self, followed: int, free: int) -> None:
        """Send set points for the next block and `RESERVE`, after the Uno has ``followed`` so many, as far as it has places."""
        ahead = (self.rig.board.block + RESERVE) / self.drive.period
        until = min(self.points, followed + math.ceil(ahead * self.ratio), self.sent + free)
        if self.sent < until:
            times = self._times_of(self.sent, until - self.sent)
            self.uno.points(self.sent, self._in_counts(self.path(times)))
            self.sent = until

    def _times_of(self, first: int, n: int) -> Array:
        """When the Uno reaches its set points ``first`` to ``first`` + n: s of the drive, on the board's clock."""
        k, period = np.arange(n), self.drive.period
        missing = 0.0 if self._begin_range is None else self._measured_begin(first) - self.begin_time
        moves = self.begin_time + first * period / self.ratio > 0.0
        change = np.minimum(abs(missing), SLEW * period * (k + 1) if moves else math.inf)
        begin = self.begin_time + np.copysign(change, missing) * np.ones(n)
        self.begin_time = float(begin[-1])
        return np.clip(begin + (first + k) * period / self.ratio, 0.0, self.drive.duration)

    def _measured_begin(self, number: int) -> float:
        """`begin_time` as both clocks now tell it for a set point, s."""
        assert self._begin_range is not None
        reached = self.clock.seconds_at(0.5 * sum(self._begin_range) + number * self._period)
        return reached - self.start / self.rig.board.rate - number * self.drive.period / self.ratio

    def _in_counts(self, positions: Array) -> list[int]:
        return [round(float(p)) for p in positions / self.rig.encoder.count]


def player_of(drive: Drive, rig: RigSettings, uno: TableDrive, clock: UnoClock) -> Player:
    """The player of a drive: its own where its set points follow from what is measured, such as in a hybrid test.

    It is ready but for its ``start``: what takes long is done here, and not between two blocks.
    """
    player: Player = getattr(drive, "player", Player)(drive, rig, uno, 0, clock)
    player.prepare()
    return player
