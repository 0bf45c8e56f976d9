"""A simulated rig whose table stands somewhere, and faults that begin now."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dampyr.rig import Drive, Rig, RigSettings
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.simulation.simulator import Simulator, parse_faults


def settings(switches: bool = False, stop: bool = False, **more: object) -> RigSettings:
    base = RigSettings()
    return replace(base, wires=replace(base.wires, end_switches=switches, emergency_stop=stop, **more))


def standing_at(position: float, *faults: str, rig: RigSettings | None = None) -> tuple[Rig, Simulator]:
    simulator = Simulator(rig or RigSettings(), faults=parse_faults(faults), position=position)
    return host(simulator), simulator


def host(simulator: Simulator) -> Rig:
    return Rig(simulator.settings, Uno(InProcess(simulator.serial)), InProcessBoard(simulator), threaded=False)


def begin_fault(simulator: Simulator, text: str) -> None:
    simulator.faults = (*simulator.faults, *parse_faults([text.replace("@now", f"@{simulator.time + 0.001:.3f}s")]))


def strokes(cycles: int = 3, amplitude: float = 0.010) -> Drive:
    t = np.arange(round(cycles / 0.01) + 1) * 0.01
    return Drive(0.01, amplitude * np.sin(2 * np.pi * t) * np.minimum(1, np.minimum(t, t[-1] - t)), np.zeros(t.size))
