"""Connecting to a rig: the real one that a ``rig.toml`` names, or a simulated one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.rig.instruments.board import NiBoard
from dampyr.rig.instruments.uno import Uno
from dampyr.rig.instruments.wire import InProcess, open_wire
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.simulation.faults import FaultSpec


def connect(settings: RigSettings | str | Path) -> Rig:
    """The rig whose wires ``settings`` (or a ``rig.toml``) name; nothing moves and no voltage is set.

    Raises :class:`~dampyr.errors.InputError` where no wires are named, :class:`~dampyr.errors.RigFault` where nothing answers.
    """
    rig = settings if isinstance(settings, RigSettings) else load_settings(settings)
    if not rig.wires.serial:
        raise InputError(
            "wires.serial is empty, so there is nothing to connect to; name the Uno's port, or simulate the rig"
        )
    uno = Uno(open_wire(rig.wires.serial, rig.wires.baud))
    try:
        return Rig(rig, uno, NiBoard(rig))
    except BaseException:
        uno.close()
        raise


def in_process(
    settings: RigSettings, seed: int = 0, faults: Sequence[FaultSpec] = (), specimen: Damper | None = None
) -> Rig:
    """A simulated rig in this process, without wires: the same calls with the same seed give the same bits."""
    from dampyr.rig.simulation.in_process import InProcessBoard
    from dampyr.rig.simulation.simulator import Simulator

    simulator = Simulator(settings, seed, faults, specimen)
    return Rig(settings, Uno(InProcess(simulator.serial)), InProcessBoard(simulator), threaded=False)
