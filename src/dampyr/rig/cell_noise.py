"""Noise of the load cell's chain from sample to sample: what an amplifier that has grown slow does not let through."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WINDOW = 0.25  # s of which the noise is taken
LEAST = 100  # samples in such a window, from which its noise is known to a tenth


def least_noise(volts: Array, rate: float, step: float) -> float:
    r"""The least noise [V rms] of the windows of a reading (n,) at ``rate`` Hz, by its second differences; NaN where they are
    too short, or none of them moves by more than some of the converter's ``step`` [V].

    A straight course has no second difference, and that of white noise :math:`\sigma` has :math:`\sqrt{6} \sigma`. By the least
    of the windows vibration does not count, nor turns of the force.
    """
    n = round(WINDOW * rate)
    if n < LEAST or len(volts) < n:
        return math.nan
    windows = volts[: len(volts) // n * n].reshape(-1, n)
    moving = np.ptp(windows, axis=1) > 4.0 * step  # one that stands is another fault
    if not moving.any():
        return math.nan
    return float(np.sqrt(np.mean(np.diff(windows[moving], 2, axis=1) ** 2, axis=1)).min()) / math.sqrt(6.0)
