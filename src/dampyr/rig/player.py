"""Player of a drive: set points to the Uno ahead of their time, the coil's voltage to the board on its clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import MAX_POINTS, State
from dampyr.rig.instruments.contract import TableDrive
from dampyr.rig.interlock import Samples
from dampyr.rig.settings import RigSettings

Array = NDArray[np.float64]
AHEAD = 40  # set points in the Uno's queue of 64: 0.4 s at 10 ms


@dataclass
class Player:
    """One drive under way; sample ``start`` is when it begins."""

    drive: Drive
    rig: RigSettings
    uno: TableDrive
    start: int
    sent: int = 0
    running: bool = False
    finished: bool = False

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

    def feed(self, samples: Samples) -> None:
        """Start at its time, keep the queue filled, detect the end, after a block of samples was read."""
        now, status = samples.first + samples.n, samples.status
        if not self.running and now >= self.start:
            self._start_drive()
        elif self.running and not self.finished:
            if self.drive.standing:
                self.finished = now >= self.end
            elif status.state is State.ARMED:
                self.finished = True
            elif self.drive.reversals is None:
                self._send_points(status.free)

    def _start_drive(self) -> None:
        self.running = True
        if self.drive.standing:
            return
        if self.drive.reversals is None:
            self._send_points(AHEAD)
            self.uno.follow(round(self.drive.period * 1000), self.drive.n)
            return
        reversals = self.drive.reversals
        half, pause = round(reversals.half_period * 1000), round(reversals.pause * 1000)
        self.uno.reverse(round(reversals.duty * 255), half, pause, reversals.count)

    def _send_points(self, free: int) -> None:
        """Fill the queue up to `AHEAD`, or as far as there are places."""
        count = self.rig.encoder.count
        while self.sent < self.drive.n and free > 0:
            n = min(MAX_POINTS, free, self.drive.n - self.sent)
            points = self.drive.displacement[self.sent : self.sent + n] / count
            self.uno.points(self.sent, [round(float(p)) for p in points])
            self.sent, free = self.sent + n, free - n


def player_of(drive: Drive, rig: RigSettings, uno: TableDrive, start: int) -> Player:
    """The player of a drive: its own where its set points follow from what is measured, such as in a hybrid test."""
    player: type[Player] = getattr(drive, "player", Player)
    return player(drive, rig, uno, start)
