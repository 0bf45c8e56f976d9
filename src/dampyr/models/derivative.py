r"""The velocity of a sampled path, with a stated bandwidth.

A Gaussian low-pass and the derivative in one zero-phase step, by the derivative of a Gaussian. Its response to a sine of
frequency f is :math:`i 2\pi f\, e^{-2\pi^2\sigma^2 f^2}`, which is half its power (-3 dB) at the bandwidth
:math:`f_b = \sqrt{\ln 2}/(2\pi\sigma)`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]


def differentiate(t: Array, x: Array, bandwidth: float | None) -> Array:
    """dx/dt, shape (n,), of samples ``x`` at times ``t``; ``bandwidth`` in Hz (-3 dB), None for central differences.

    Filtering needs one sampling interval: InputError where ``t`` is uneven by more than 1 % or the bandwidth is not
    below half of the sampling rate.
    """
    if bandwidth is None:
        return np.asarray(np.gradient(x, t))
    from scipy.ndimage import gaussian_filter1d

    dt = float(np.median(np.diff(t)))
    if np.max(np.abs(np.diff(t) - dt)) > 0.01 * dt:
        raise InputError(f"a derivative of {bandwidth:g} Hz bandwidth needs even sampling; resample the path first")
    if not 0.0 < bandwidth < 0.5 / dt:
        raise InputError(f"the bandwidth {bandwidth:g} Hz must be between 0 and {0.5 / dt:g} Hz, half the sampling rate")
    sigma = math.sqrt(math.log(2.0)) / (2.0 * math.pi * bandwidth)
    smooth = gaussian_filter1d(_mirrored(x), sigma / dt, truncate=6.0)
    return np.asarray(np.gradient(smooth, dt)[x.size : 2 * x.size])


def _mirrored(x: Array) -> Array:
    """The path continued at both ends by point reflection, so that its slope goes on."""
    return np.concatenate((2 * x[0] - x[::-1], x, 2 * x[-1] - x[::-1]))
