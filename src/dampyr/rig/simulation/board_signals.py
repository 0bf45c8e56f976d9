"""Signals of the NI board: load cell and thermocouple in volts, the converter, and the errors that the board gives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrError, InputError
from dampyr.rig.settings import RigSettings

Array = NDArray[np.float64]
DEGREES_PER_VOLT = 100.0  # the thermocouple's amplifier gives 10 mV/degC
TIMEOUT, OVERRUN, RANGE, UNDERFLOW = -200284, -200279, -200077, -200290
BOARD_MESSAGES = {
    UNDERFLOW: "the generation has stopped to prevent the regeneration of old samples: the host wrote too late",
    TIMEOUT: "some or all of the samples requested have not yet been acquired",
    OVERRUN: "the application is not able to keep up with the hardware acquisition",
    RANGE: "the requested value is not supported for this property",
}


class BoardError(DampyrError):
    """An error of the NI board, with the number that NI-DAQmx gives it."""

    def __init__(self, code: int) -> None:
        super().__init__(f"the board gives error {code}: {BOARD_MESSAGES[code]}")
        self.code = code


def volts_of_force(settings: RigSettings, force: Array) -> Array:
    """The load cell amplifier's output in V for a force in N, before the converter."""
    return np.asarray(settings.load_cell.zero + force / settings.load_cell.scale)


def converted(settings: RigSettings, volts: Array) -> Array:
    """Volts as converted: rounded to whole steps, clipped to the range."""
    step = 2.0 * settings.board.range / 2**settings.board.bits
    codes = np.clip(np.round(volts / step), -(2 ** (settings.board.bits - 1)), 2 ** (settings.board.bits - 1) - 1)
    return np.asarray(codes * step)


def command_of(settings: RigSettings, volts: float) -> float:
    """The command voltage that leaves the converter; BoardError beyond its range."""
    if not np.isfinite(volts):
        raise InputError(f"a command of {volts} V is not finite")
    if abs(volts) > settings.board.range:
        raise BoardError(RANGE)
    return float(converted(settings, np.array(volts)))
