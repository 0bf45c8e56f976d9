r"""Smooth differentiation with a stated bandwidth and no phase.

At every sample a cubic is fitted to the samples around it with Gaussian weights of standard deviation s, and
its slope is the derivative. Away from the ends of an evenly sampled record this is a symmetric filter with

.. math:: \frac{H(f)}{2\pi j f} = (1 + u)\,e^{-u}, \qquad u = \tfrac12 (2\pi f s)^2,

exact for cubics, flat at zero to fourth order, and 3 dB down where u = 1.07796; the ends need no padding and
uneven sampling no resampling.

References: local polynomial regression, Fan and Gijbels (1996), section 3.2; the filter above is its Fourier
transform.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]
HALF_POWER = 1.077960450100453  # (1 + u)*exp(-u) = 1/sqrt(2)
REACH = 6.0  # standard deviations of the window on each side
FINEST = 0.25  # of the sampling rate: there the gain is still within 0.3 % of the formula
AT_ONCE = 1000  # windows, to bound the memory


def differentiate(time: Array, values: Array, bandwidth_hz: float | None) -> Array:
    """The derivative ``(n,)`` of ``values`` by ``time``, 3 dB down at ``bandwidth_hz``, without phase.

    None: plain central differences, whose bandwidth is the sampling's.

    Raises
    ------
    InputError
        The bandwidth is not within what the sampling carries: from 4 over the duration to a quarter of the
        rate.
    """
    if bandwidth_hz is None:
        return np.asarray(np.gradient(np.asarray(values, dtype=float), np.asarray(time, dtype=float)))
    return _fit_local_cubics(time, values, bandwidth_hz, 1)


def smooth(time: Array, values: Array, bandwidth_hz: float) -> Array:
    """``values`` ``(n,)`` after a low-pass of the same gain, 3 dB down at ``bandwidth_hz``, without phase.

    The value of the local cubic whose slope :func:`differentiate` takes. Raises :class:`~dampyr.errors.InputError` as it does.
    """
    return _fit_local_cubics(time, values, bandwidth_hz, 0)


def _fit_local_cubics(time: Array, values: Array, bandwidth_hz: float, order: int) -> Array:
    """The value (``order`` 0) or the slope (1) of the local cubic at every sample."""
    time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    steps = np.diff(time)
    dt = float(np.median(steps))
    _check_bandwidth(bandwidth_hz, dt, float(time[-1] - time[0]))
    width, reach = window(dt, bandwidth_hz)

    def each_by_itself(samples: NDArray[np.int64]) -> Array:
        fitted = _fit(time, values, samples, width, reach, order)
        return values[samples] + fitted if order == 0 else fitted

    if len(time) < 2 * reach + 2 or np.ptp(steps) > 1e-6 * dt:
        return each_by_itself(np.arange(len(time)))
    # where the sampling is even, all whole windows have the same weights: a convolution
    offsets = dt * np.arange(-reach, reach + 1, dtype=np.float64)
    kernel = _weigh(offsets[None, :], width, order)[0]
    out = np.empty(len(time))
    out[reach:-reach] = np.convolve(values, kernel[::-1], mode="valid")
    ends = np.r_[0:reach, len(time) - reach : len(time)]
    out[ends] = each_by_itself(ends)
    return out


def window(dt: float, bandwidth_hz: float) -> tuple[float, int]:
    """The standard deviation of the weights in s, and how many samples ``dt`` s apart they reach to each side."""
    width = math.sqrt(2.0 * HALF_POWER) / (2.0 * math.pi * bandwidth_hz)
    return width, max(math.ceil(REACH * width / dt), 3)


def response(frequency_hz: Array | float, bandwidth_hz: float) -> Array:
    """The gain of :func:`differentiate` over the true derivative's at these frequencies, in the interior."""
    u = HALF_POWER * (np.asarray(frequency_hz, dtype=float) / bandwidth_hz) ** 2
    return (1.0 + u) * np.exp(-u)


def carried(dt: float, duration: float) -> tuple[float, float]:
    """The lowest and the highest bandwidth in Hz of samples ``dt`` s apart: 4 over the duration, a quarter of the rate."""
    return 4.0 / duration, FINEST / dt * (1 + 1e-9)


def _check_bandwidth(bandwidth_hz: float, dt: float, duration: float) -> None:
    low, high = carried(dt, duration)
    if not low <= bandwidth_hz <= high:
        raise InputError(
            f"bandwidth_hz = {bandwidth_hz:g} Hz is not allowed; samples {dt:g} s apart over {duration:g} s "
            f"carry from {low:.4g} to {high:.4g} Hz"
        )


def _fit(time: Array, values: Array, at: NDArray[np.int64], width: float, reach: int, order: int) -> Array:
    """The cubics' coefficients of ``order`` about the samples ``at``, of the values less those at these samples."""
    n = len(time)
    size = min(2 * reach + 1, n)
    out = np.empty(len(at))
    for start in range(0, len(at), AT_ONCE):
        centres = at[start : start + AT_ONCE]
        window = np.clip(centres - reach, 0, n - size)[:, None] + np.arange(size)[None, :]
        # of differences from the middle sample: a large offset would cost the digits of a small slope
        weights = _weigh(time[window] - time[centres][:, None], width, order)
        out[start : start + AT_ONCE] = np.sum(weights * (values[window] - values[centres][:, None]), axis=1)
    return out


def _weigh(offsets: Array, width: float, order: int) -> Array:
    """``(k, size)`` weights whose sum with the values is the coefficient of ``order`` of the cubic about offset 0."""
    s = offsets / width
    gauss = np.exp(-0.5 * s**2)
    powers = s[..., None] ** np.arange(4)
    normal = np.einsum("ki,kip,kiq->kpq", gauss, powers, powers)
    chosen = np.linalg.solve(normal, np.broadcast_to(np.eye(4)[:, order : order + 1], (len(s), 4, 1)))[..., 0]
    return gauss * np.einsum("kip,kp->ki", powers, chosen) / width**order
