"""Data sheets of dampers, and contradictions of a fit with them: such a fit is flagged, not refused.

Lord RD-8041-1 (Table A.1 of the dissertation): more than 2447 N peak to peak at 5 cm/s and 1 A, less than 667 N at 20 cm/s and
0 A. The force is that of a sine with this peak speed; a static offset does not count in a peak-to-peak force.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np

from dampyr.config import unknown
from dampyr.errors import DampyrWarning, InputError
from dampyr.models import Damper

STROKE = 0.030  # m, half of the sine's; within the 74 mm of Table A.1
COIL = 4.4  # ohm, of the coil on the original rig: 0.495 A at 2.178 V
SAMPLES = 2000  # of a cycle: its peak is met to a millionth
CYCLES = 3  # of which the last counts, the unknown past forgotten


@dataclass(frozen=True)
class Promise:
    """Peak-to-peak force [N] at a peak speed [m/s] and a current [A]: more than ``low``, less than ``high``."""

    speed: float
    current: float
    low: float = -math.inf
    high: float = math.inf


SHEETS: dict[str, tuple[Promise, ...]] = {
    "RD-8041-1": (Promise(0.05, 1.0, low=2447.0), Promise(0.20, 0.0, high=667.0)),
}


def contradictions(damper: Damper, sheet: str = "RD-8041-1", resistance: float = COIL) -> list[str]:
    """Which promises of a data sheet ``damper`` breaks, each in a sentence; empty where it keeps all that can be checked.

    ``resistance`` [ohm] makes volts of the sheet's currents for a damper over voltage. A promise outside the damper's
    calibrated range of input is not looked at: nothing is extrapolated.
    """
    if sheet not in SHEETS:
        raise InputError(unknown(f"data sheet {sheet!r}", sheet, list(SHEETS)))
    broken: list[str] = []
    if not damper.has_input:  # the sheets are of dampers with a coil
        return broken
    for promise in SHEETS[sheet]:
        value = promise.current * (resistance if damper.input == "V" else 1.0)
        low, high = damper.range
        if low - 1e-9 <= value <= high + 1e-9:
            # clipped, as ohms times amperes may leave the end of the range by rounding
            force = peak_to_peak(damper, promise.speed, min(max(value, low), high))
            if not promise.low < force < promise.high:
                broken.append(_describe_broken(promise, force, value, damper.input, sheet))
    return broken


def peak_to_peak(damper: Damper, speed: float, value: float) -> float:
    """N, in the last cycle of a sine of peak ``speed`` [m/s] at a constant input."""
    omega = speed / STROKE
    t = np.linspace(0.0, CYCLES * 2 * math.pi / omega, CYCLES * SAMPLES + 1)
    voltage, current = (value, None) if damper.input == "V" else (None, value)
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DampyrWarning
        )  # faster and farther than it was calibrated: that is the question
        force = damper.force_of_motion(
            t, STROKE * np.sin(omega * t), velocity=speed * np.cos(omega * t), voltage=voltage, current=current
        )
    return float(np.ptp(force[-SAMPLES:]))


def _describe_broken(promise: Promise, force: float, value: float, unit: str, sheet: str) -> str:
    side, limit = ("more", promise.low) if force <= promise.low else ("less", promise.high)
    return (
        f"at {promise.speed * 100:g} cm/s and {promise.current:g} A ({value:.3g} {unit}) the fit gives {force:.0f} N peak to "
        f"peak, and the data sheet of the {sheet} says {side} than {limit:.0f} N"
    )
