"""Drives for a simulated rig, and how they are played."""

from collections.abc import Callable

import numpy as np

from dampyr.rig import Drive, Rig, RigSettings, simulated
from dampyr.rig.interlock import Samples
from dampyr.rig.session import ArmedRig
from dampyr.rig.simulation.simulator import Simulator


def made(*faults: str, interlocked: bool = True, settings: RigSettings | None = None) -> tuple[Rig, Simulator]:
    rig = simulated(settings, faults=faults)
    rig.interlocked = interlocked
    return rig, rig.board.simulator


def sine(amplitude: float, frequency: float, seconds: float, volts: float = 2.0) -> Drive:
    t = np.arange(round(seconds / 0.01) + 1) * 0.01
    grows = np.clip(t * frequency, 0.0, 1.0) * np.clip((t[-1] - t) * frequency, 0.0, 1.0)
    return Drive(0.01, amplitude * grows * np.sin(2 * np.pi * frequency * t), np.full(t.size, volts))


def ramp(to: float, seconds: float) -> Drive:
    n = round(seconds / 0.01) + 1
    return Drive(0.01, to * (1 - np.cos(np.linspace(0, np.pi, n))) / 2, np.zeros(n))


def played(
    rig: Rig, drive: Drive, then: Callable[[int, ArmedRig, Samples], None] | None = None, times: int = 1
) -> None:
    """Home, go to where a drive begins, and play it; ``then`` is called with each block."""
    with rig.armed() as table:
        if not table.homed:
            table.home()
        table.go(float(drive.displacement[0]))
        for _ in range(times):
            for k, (block, _) in enumerate(table.play(drive)):
                if then:
                    then(k, table, block)
