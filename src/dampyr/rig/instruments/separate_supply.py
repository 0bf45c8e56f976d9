"""Board whose command goes to a supply of its own, which has no sample clock."""

from __future__ import annotations

import threading

import numpy as np

from dampyr.origin import OriginKind
from dampyr.rig.instruments.contract import AcquisitionBoard, Array, CoilSupply, Counts, stated_origin
from dampyr.rig.shunt import switch_shunt


class SeparatelySupplied:
    """An acquisition and a supply without a clock, as one `dampyr.rig.instruments.contract.Board`.

    The supply is set once a block, to what the next sample's command is: its voltage is late by up to a block and the
    supply's latency.
    """

    def __init__(self, acquisition: AcquisitionBoard, supply: CoilSupply, block: float) -> None:
        self.acquisition, self.supply, self.block = acquisition, supply, block
        self._lock = threading.Lock()
        self._ahead: Array = np.zeros(0)
        self._last: float | None = None

    def start(self, rate: float, ahead: Array) -> None:
        """Start sampling; the command begins with ``ahead``."""
        with self._lock:
            self._ahead, self._last = np.array(ahead, float), None
            self._set()
        self.acquisition.start(rate, np.zeros(0))

    def read(self, n: int) -> tuple[Array, Counts]:
        """The next n samples; the command is then that of the sample after them."""
        volts, counts = self.acquisition.read(n)
        with self._lock:
            self._ahead = self._ahead[n:]
            self._set()
        return volts, counts

    def _set(self) -> None:
        """Set the supply to the command's first value, where it differs."""
        if self._ahead.size and self._ahead[0] != self._last:
            self._last = float(self._ahead[0])
            self.supply.write(self._last)

    def index_counts(self) -> Counts:
        """The counts at which the index was passed since the last call."""
        return self.acquisition.index_counts()

    def queue(self, volts: Array) -> None:
        """Append to the command."""
        with self._lock:
            self._ahead = np.concatenate([self._ahead, volts])

    def write(self, volts: float) -> None:
        """Set the command now; what was queued is dropped."""
        with self._lock:
            self._ahead, self._last = np.zeros(0), None
            self.supply.write(volts)

    def stop(self) -> None:
        """Stop sampling; the command stays as it is."""
        self.acquisition.stop()

    def close(self) -> None:
        """Close both, whatever fails."""
        try:
            self.acquisition.close()
        finally:
            self.supply.close()

    def shunt(self, on: bool) -> None:
        """Switch the relay of the acquisition that puts a shunt across the load cell's bridge."""
        switch_shunt(self.acquisition, on)

    def command_delay(self) -> float:
        """s by which a change of the command may be late."""
        return self.block + self.supply.latency

    def origin(self) -> OriginKind:
        """That of the acquisition."""
        return stated_origin(self.acquisition).kind

    def identity(self) -> str:
        """Both; the supply with its delay, since it is of every record."""
        return (
            f"{self.acquisition.identity()}, supply {self.supply.identity()} "
            f"(no sample clock: its voltage comes up to {1e3 * self.command_delay():.0f} ms late)"
        )
