"""Shunt across the load cell's bridge, switched by a relay of the board: what the cell's chain makes of a known step.

A resistor across one arm unbalances the bridge as a known force would (`dampyr.rig.calibration.shunt_force`), whatever is on
the cell: the step tells the gain of the whole chain, and its rise how fast it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import RigFault
from dampyr.rig.calibration import shunt_force
from dampyr.rig.settings import RigSettings

Array = NDArray[np.float64]
SHUNT_UNCERTAINTY = 5.0e-3  # of a shunt: resistor, bridge and sensitivity as their makers state them
SETTLED = 0.1  # s after the relay was switched: it bounces for some ms, and a cell of 10 Hz is within 0.2 %
READ = 0.3  # s of a reading before the step, and after it
RISE = 2.2  # time constants from a tenth of a step to nine tenths, of one pole


@dataclass(frozen=True)
class ShuntStep:
    """The step [N] of the force as a shunt was switched in, and the s from a tenth of it to nine tenths."""

    force: float
    rise: float


def expected_step(rig: RigSettings) -> float:
    """The force [N] that the rig's shunt simulates."""
    return shunt_force(rig.load_cell, rig.load_cell.shunt)


def slowest_rise(rig: RigSettings) -> float:
    """The s that a step may take from a tenth to nine tenths, by what is known of the amplifier's bandwidth."""
    return RISE * (rig.force_delay + 3.0 * rig.load_cell.delay_uncertainty) + 2.0 / rig.board.rate


def step_of(before: Array, after: Array, rate: float) -> ShuntStep:
    """The step between two readings of the force [N] (n,) at ``rate`` Hz, the latter from about the moment of the switch on."""
    settled = after[round(SETTLED * rate) :]
    low, high = float(np.mean(before)), float(np.mean(settled))
    share = (np.concatenate([before, after]) - low) / (high - low) if high != low else np.zeros(1)
    late, early = (int(np.argmax(share > part)) for part in (0.9, 0.1))
    return ShuntStep(high - low, max(0, late - early) / rate if np.any(share > 0.9) else math.inf)


def switch_shunt(board: Any, on: bool) -> None:
    """Switch the relay; :class:`~dampyr.errors.RigFault` where the board's driver has none."""
    try:
        switch = board.shunt
    except AttributeError:
        raise RigFault(
            "wires.shunt names a relay, and the acquisition's driver has no shunt(); write one, or leave wires.shunt out"
        ) from None
    switch(on)
