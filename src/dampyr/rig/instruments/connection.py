"""Connection to the instruments that a rig names, in the process that reads them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from typing import Any

from dampyr.rig.instruments.catalogue import OUTPUT, ROLES, part, place
from dampyr.rig.instruments.contract import (
    AcquisitionBoard,
    AnalogueOutput,
    Board,
    CoilSupply,
    TableDrive,
    check_offers,
)
from dampyr.rig.instruments.separate_supply import SeparatelySupplied
from dampyr.rig.settings import RigSettings

CONTRACTS: dict[str, tuple[type, ...]] = {
    "drive": (TableDrive,),
    "acquisition": (AcquisitionBoard,),
    "supply": (CoilSupply,),
}  # in the order in which they are opened


def roles_of(rig: RigSettings) -> list[str]:
    """The roles for which the rig has an instrument of its own."""
    return [role for role in ROLES if getattr(rig.wires, role) != OUTPUT]


def open_instruments(rig: RigSettings) -> tuple[TableDrive, Board]:
    """The drive and the board at the wires of ``rig``, in this process.

    Raises :class:`~dampyr.errors.InputError` for a name that is not that of an instrument, before any is opened.
    """
    drivers = {role: part(rig, role, "driver") for role in roles_of(rig)}
    return assembled(rig, {role: partial(driver.connect, rig) for role, driver in drivers.items()})


def assembled(rig: RigSettings, makers: Mapping[str, Callable[[], Any]]) -> tuple[TableDrive, Board]:
    """The drive and the board of what ``makers`` make, by role; where one fails, those before it are closed."""
    instruments: dict[str, Any] = {}
    with ExitStack() as opened:
        for role, contracts in CONTRACTS.items():
            if role not in makers:
                continue
            instruments[role] = makers[role]()
            if hasattr(instruments[role], "close"):
                opened.callback(instruments[role].close)
            output = (AnalogueOutput,) if role == "acquisition" and "supply" not in makers else ()
            check_offers(instruments[role], (*contracts, *output), role, place(rig, role))
        opened.pop_all()
    if "supply" not in instruments:
        return instruments["drive"], instruments["acquisition"]
    return instruments["drive"], SeparatelySupplied(instruments["acquisition"], instruments["supply"], rig.board.block)
