"""Simulated end of the Uno: its firmware, a model or the binary, without the serial wire."""

from __future__ import annotations

from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.simulation.simulator import Simulator


def in_process(simulator: Simulator) -> Uno:
    """The Uno of a simulated rig."""
    return Uno(InProcess(simulator.serial))
