"""Butterworth filters without phase shift: what is too slow or too fast to be ground motion taken out.

The filter runs forward and backward (acausal), which doubles its order and makes the gain at a corner 1/2 (-6 dB). Zeros are
put before and after the record first, 1.5 * order / corner seconds in all as in [BooreBommer2005]_, so that the filter rings
there and not into the record.

References
----------
.. [BooreBommer2005] D. M. Boore and J. J. Bommer, "Processing of strong-motion accelerograms: needs, options and consequences",
   Soil Dynamics and Earthquake Engineering 25(2), 93-115, 2005.
"""

from __future__ import annotations

import math

import numpy as np

from dampyr.errors import InputError
from dampyr.ground_motions.motion import GroundMotion


def filtered(
    motion: GroundMotion,
    low: float | None = None,
    high: float | None = None,
    order: int = 4,
    keep_pads: bool = True,
) -> GroundMotion:
    """The motion between the corners ``low`` and ``high`` [Hz]: band-pass, or high-pass or low-pass where one is None.

    Parameters
    ----------
    motion
        The motion of the ground.
    low, high
        The corners in Hz, 0 < low < high < half the sampling rate; None leaves that side as it is. Give one or both.
    order
        Of the one-way filter, 1 to 10; the two passes have twice this order.
    keep_pads
        Keep the zeros with what rings in them, without which velocity and displacement are wrong: those of El Centro
        1940 from 0.1 to 20 Hz end at 0.57 m instead of 1 mm. False cuts them off, so that the motion has its old length, for
        uses of the acceleration alone or to correct the baseline afterwards; the history says so.

    Raises
    ------
    InputError
        A corner or the order is not allowed.

    Examples
    --------
    >>> import dampyr as dp
    >>> motion = dp.ground_motions.filtered(dp.ground_motions.el_centro(), low=0.1, high=20.0)
    >>> motion.history[0].partition(",")[0]
    'Butterworth band-pass from 0.1 to 20 Hz'
    """
    nyquist = 0.5 / motion.dt
    corners = [corner for corner in (low, high) if corner is not None]
    if (
        not corners
        or not all(0 < corner < nyquist for corner in corners)
        or (len(corners) == 2 and corners[0] >= corners[1])
    ):
        raise InputError(
            f"corners low = {low} and high = {high} Hz are not allowed; give one or both, 0 < low < high < {nyquist:g} Hz "
            f"(half the sampling rate)"
        )
    if int(order) != order or not 1 <= order <= 10:
        raise InputError(f"order = {order!r} is not allowed; it must be a whole number from 1 to 10")
    # half of the 1.5 * order / corner seconds at each end
    pad = math.ceil(0.75 * order / corners[0] / motion.dt)
    values = _forward_and_backward(np.pad(motion.acceleration, pad), low, high, int(order), 2 * nyquist)
    samples = values if keep_pads else values[pad : pad + motion.n]
    note = f"Butterworth {_band(low, high)}, order {order}, forward and backward"
    seconds = f"{pad * motion.dt:g} s"
    return motion.changed(
        samples, f"{note}, {seconds} more at each end" if keep_pads else f"{note}, {seconds} of pads cut off"
    )


def _forward_and_backward(
    values: np.ndarray, low: float | None, high: float | None, order: int, rate: float
) -> np.ndarray:
    from scipy.signal import butter, sosfiltfilt

    if low is not None and high is not None:
        sos = butter(order, (low, high), "bandpass", output="sos", fs=rate)
    else:
        kind = "highpass" if high is None else "lowpass"
        sos = butter(order, high if low is None else low, kind, output="sos", fs=rate)
    return np.asarray(sosfiltfilt(sos, values, padtype=None), dtype=float)


def _band(low: float | None, high: float | None) -> str:
    if low is None:
        return f"low-pass at {high:g} Hz"
    return f"high-pass at {low:g} Hz" if high is None else f"band-pass from {low:g} to {high:g} Hz"
