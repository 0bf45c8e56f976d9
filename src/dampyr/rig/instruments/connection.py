"""Connection to the instruments that a rig's wires name, in the process that reads them."""

from __future__ import annotations

from dampyr.rig.instruments.ni_board import NiBoard
from dampyr.rig.instruments.uno import Uno
from dampyr.rig.instruments.wire import open_wire
from dampyr.rig.settings import RigSettings


def open_instruments(rig: RigSettings, wait: float | None = None, tries: int | None = None) -> tuple[Uno, NiBoard]:
    """The Uno and the board at the wires of ``rig``, in this process."""
    given = {} if wait is None or tries is None else {"wait": wait, "tries": tries}
    uno = Uno(open_wire(rig.wires.serial, rig.wires.baud), **given)  # type: ignore[arg-type]
    try:
        return uno, NiBoard(rig)
    except BaseException:
        uno.close()
        raise
