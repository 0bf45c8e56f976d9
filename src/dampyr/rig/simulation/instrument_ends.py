"""Simulated ends of the instruments that a rig names: in this process, or behind their wires."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from dampyr.errors import FileError
from dampyr.rig.instruments.catalogue import part, place
from dampyr.rig.instruments.connection import assembled, roles_of
from dampyr.rig.instruments.contract import Board, TableDrive
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.clock import Clock
from dampyr.rig.simulation.simulator import Simulator


def simulate_instruments(rig: RigSettings, simulator: Simulator) -> tuple[TableDrive, Board]:
    """The drive and the board of a rig that is simulated in this process; ``rig`` is what it is taken to be."""
    instead = "simulate it over its wires (without in_process, --in-process)"
    ends = {role: _function(rig, role, "in_process", instead) for role in roles_of(rig)}
    return assembled(rig, {role: partial(end, simulator) for role, end in ends.items()})


def serve_instruments(rig: RigSettings, clock: Clock) -> dict[str, str]:
    """Serve the simulated ends of the wires; the settings of `dampyr.rig.settings.Wires` that lead to them."""
    instead = "simulate it in this process (in_process=True, --in-process)"
    wires: dict[str, str] = {}
    for serve in [_function(rig, role, "serve", instead) for role in roles_of(rig)]:
        wires |= serve(clock)
    return wires


def _function(rig: RigSettings, role: str, name: str, instead: str) -> Callable[[Any], Any]:
    """A function of an instrument's simulated end."""
    function: Callable[[Any], Any] | None = getattr(part(rig, role, "simulated"), name, None)
    if not callable(function):
        raise FileError(place(rig, role), f"its simulated.py has no {name}(); {instead}")
    return function
