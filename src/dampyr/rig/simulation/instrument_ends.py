"""A simulated rig, made of its parts, and the simulated ends of the instruments that it names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from dampyr.errors import FileError
from dampyr.models import Damper
from dampyr.rig.instruments.catalogue import part, place
from dampyr.rig.instruments.connection import assembled, roles_of
from dampyr.rig.instruments.contract import Board, TableDrive
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.real_time import RealTimeSimulator
from dampyr.rig.simulation.simulator import Simulator

S = TypeVar("S", bound=Simulator)


@dataclass(frozen=True)
class Simulation:
    """What a simulated rig is made of; it can be sent to the process that reads it.

    ``settings`` are what the rig really is, ``specimen`` the damper on its table. ``seed``, ``faults`` and ``chip`` as in
    `dampyr.rig.simulation.simulator.Simulator`; ``black_box`` is a file for a line of JSON per event.
    """

    settings: RigSettings
    specimen: Damper
    seed: int = 0
    faults: tuple[FaultSpec, ...] = ()
    black_box: str | Path | None = None
    chip: tuple[str | Path, str | Path] | None = None

    def in_lockstep(self) -> Simulator:
        """The rig whose time passes while it is read."""
        return self._build(Simulator)

    def in_real_time(self) -> RealTimeSimulator:
        """The rig that follows the wall clock; its kernels are compiled before, so that the first samples are not late."""
        trial = Simulator(self.settings, specimen=self.specimen)
        trial.start(self.settings.board.rate)
        trial.advance_to(0.05)
        return self._build(RealTimeSimulator)

    def _build(self, cls: type[S]) -> S:
        log = None if self.black_box is None else EventFile(self.black_box)
        return cls(self.settings, self.seed, self.faults, self.specimen, on_event=log, chip=self.chip)


def simulate_instruments(rig: RigSettings, simulator: Simulator) -> tuple[TableDrive, Board]:
    """The drive and the board of a simulated rig; ``rig`` is what it is taken to be."""
    return assembled(rig, {role: partial(_simulated_end(rig, role), simulator) for role in roles_of(rig)})


def _simulated_end(rig: RigSettings, role: str) -> Callable[[Simulator], Any]:
    """What gives an instrument's simulated end."""
    function: Callable[[Simulator], Any] | None = getattr(part(rig, role, "simulated"), "in_process", None)
    if not callable(function):
        raise FileError(place(rig, role), "its simulated.py has no in_process(), so it cannot be simulated; write one")
    return function
