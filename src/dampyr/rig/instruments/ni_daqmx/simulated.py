"""Simulated end of the NI board."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import RigFault
from dampyr.rig.simulation.board_signals import BoardError
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.simulation.timed_command import TimedCommand

Array = NDArray[np.float64]
T = TypeVar("T")


class InProcessBoard:
    """A `dampyr.rig.instruments.contract.Board` of a simulator in this process."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator, self._timed = simulator, False

    def start(self, rate: float, ahead: Array) -> None:
        """Start sampling, and the command with ``ahead``."""
        with self.simulator.at_one_time():
            self.stop()
            self.simulator.start(rate)
            if len(ahead):
                self.simulator.timed, self._timed = TimedCommand(self.simulator.time, rate, ahead), True

    def read(self, n: int) -> tuple[Array, NDArray[np.int64]]:
        """The next n samples."""
        return _call(lambda: self.simulator.read(n))

    def index_counts(self) -> NDArray[np.int64]:
        """The counts at which the index was passed since the last call."""
        passes = self.simulator.index_counts()
        return passes if self.simulator.settings.wires.index else passes[:0]

    def queue(self, volts: Array) -> None:
        """Append to the command."""
        _call(lambda: self.simulator.queue(volts))

    def write(self, volts: float) -> None:
        """Set the command now."""
        with self.simulator.at_one_time():
            self._end_command()
            _call(lambda: self.simulator.write(volts))

    def shunt(self, on: bool) -> None:
        """Switch the relay that puts a shunt across the load cell's bridge."""
        with self.simulator.at_one_time():
            self.simulator.switch_shunt(on)

    def stop(self) -> None:
        """Stop sampling."""
        with self.simulator.at_one_time():
            self._end_command()
            self.simulator.stop()

    def _end_command(self) -> None:
        """End the timed command, if it is this board's."""
        if self._timed:
            self.simulator.timed, self._timed = None, False

    def close(self) -> None:
        """Stop sampling."""
        self.stop()

    def identity(self) -> str:
        """Its product."""
        return "simulated PCI-6221"


def _call(call: Callable[[], T]) -> T:
    try:
        return call()
    except BoardError as problem:
        raise RigFault(f"the simulated board gives an error: {problem}") from problem


def in_process(simulator: Simulator) -> InProcessBoard:
    """The board of a rig that is simulated in this process."""
    return InProcessBoard(simulator)
