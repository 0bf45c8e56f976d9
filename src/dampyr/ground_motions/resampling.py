"""Resampling of a ground motion to another step; a longer one reports what it loses."""

from __future__ import annotations

import warnings
from fractions import Fraction
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions.motion import GroundMotion

Array = NDArray[np.float64]
How = Literal["linear", "band-limited"]

SAME = 1e-9  # relative: steps that differ by less are equal but for the digits of a file
LOST_SHARE = 1e-3  # of the Arias intensity: what is lost above it gives a warning


def resampled(motion: GroundMotion, dt: float, how: How | None = None) -> GroundMotion:
    """The motion with samples every ``dt`` seconds.

    Where ``dt`` divides the old step a whole number of times, nothing changes but the number of samples: the motion is linear
    between its samples, and so are the new ones. Any other step changes it, and ``how`` must be named:

    - ``"linear"``: samples of the straight lines; what is faster than the new rate can hold is folded into lower frequencies.
    - ``"band-limited"``: a linear-phase FIR filter and a rational change of the rate (``scipy.signal.resample_poly``); what is
      faster is taken out. dt must be a ratio of whole numbers up to 1000 of the old step.

    With a longer step, the share of the Arias intensity above the new Nyquist frequency is in the history, and a
    :class:`~dampyr.errors.DampyrWarning` says it where it exceeds 0.1 %. The new motion does not go beyond the old one's end.
    """
    if not np.isfinite(dt) or dt <= 0:
        raise InputError(f"dt = {dt!r} s is not allowed; it must be greater than 0")
    if how is not None and how not in get_args(How):
        raise InputError(f"how = {how!r} is not known; choose from {', '.join(get_args(How))}")
    ratio = motion.dt / dt
    parts = round(ratio)
    whole = parts >= 1 and abs(ratio - parts) <= SAME * ratio
    if how is None and not whole:
        raise InputError(
            f"dt = {dt:g} s does not divide the motion's {motion.dt:g} s a whole number of times; "
            "say how='linear' or how='band-limited', or choose another dt"
        )
    if motion.duration < dt * (1 - SAME):
        raise InputError(f"dt = {dt:g} s is longer than the motion, {motion.duration:g} s; choose a shorter one")
    if how == "band-limited":
        return motion.changed(_band_limited(motion, dt), _note(motion, dt, "band-limited", "taken out"), dt)
    step = motion.dt / parts if whole else dt
    exactness = "exactly" if whole else "linearly"
    return motion.changed(_linear(motion, step), _note(motion, step, exactness, "folded into lower ones"), step)


def _linear(motion: GroundMotion, dt: float) -> Array:
    count = int(np.floor(motion.duration / dt * (1 + SAME))) + 1
    return np.interp(np.arange(count) * dt, motion.time, motion.acceleration)


def _band_limited(motion: GroundMotion, dt: float) -> Array:
    from scipy.signal import resample_poly

    ratio = Fraction(motion.dt / dt).limit_denominator(1000)
    if ratio == 0 or ratio.numerator > 1000 or abs(float(ratio) * dt / motion.dt - 1) > SAME:
        raise InputError(
            f"dt = {dt:g} s and the motion's {motion.dt:g} s are not in a ratio of whole numbers up to 1000; choose another dt"
        )
    values = resample_poly(np.asarray(motion.acceleration), ratio.numerator, ratio.denominator)
    return np.asarray(values[: int(np.floor(motion.duration / dt * (1 + SAME))) + 1], dtype=float)


def _note(motion: GroundMotion, dt: float, how: str, fate: str) -> str:
    """What was done, and what was lost; warns where that is much."""
    note = f"resampled {how} from {motion.dt:g} s to {dt:g} s"
    if dt <= motion.dt * (1 + SAME):
        return note
    share = above(motion, 0.5 / dt)
    lost = f"{100 * share:.2g} % of the Arias intensity lies above {0.5 / dt:g} Hz and is {fate}"
    if share > LOST_SHARE:
        warnings.warn(f"{motion.name}: {note}: {lost}", DampyrWarning, stacklevel=4)
    return f"{note}; {lost}"


def above(motion: GroundMotion, frequency: float) -> float:
    """The share of the Arias intensity of the samples above ``frequency`` [Hz] (Parseval)."""
    power = np.abs(np.fft.rfft(motion.acceleration, 2 * motion.n)) ** 2
    power[1:-1] *= 2
    f = np.fft.rfftfreq(2 * motion.n, motion.dt)
    return float(power[f > frequency].sum() / power.sum()) if power.any() else 0.0
