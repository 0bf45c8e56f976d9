"""The part of a ground motion that matters, and rest around it."""

from __future__ import annotations

import math

import numpy as np

from dampyr.errors import InputError
from dampyr.ground_motions.intensity_measures import reached
from dampyr.ground_motions.motion import GroundMotion


def trimmed(motion: GroundMotion, low: float = 0.001, high: float = 0.999, margin: float = 0.0) -> GroundMotion:
    """The motion from where its Arias intensity has reached the share ``low`` to where it has reached ``high``.

    Cut at whole samples outwards, with ``margin`` seconds more on each side where there are any. Velocity and displacement
    start anew from 0: long periods may notice, so compare spectra, or correct the baseline afterwards.
    """
    if not 0 <= low < high <= 1:
        raise InputError(
            f"shares {low:g} to {high:g} are not allowed; they must be 0 <= low < high <= 1, such as 0.001 to 0.999"
        )
    if not math.isfinite(margin) or margin < 0:
        raise InputError(f"margin = {margin:g} s is not allowed; it must be at least 0")
    first = max(math.floor((reached(motion, low) - margin) / motion.dt), 0)
    last = min(math.ceil((reached(motion, high) + margin) / motion.dt), motion.n - 1)
    shares = f"{100 * low:g} % to {100 * high:g} % of the Arias intensity"
    note = f"cut to {first * motion.dt:g} ... {last * motion.dt:g} s ({shares})"
    return motion.changed(motion.acceleration[first : last + 1], note)


def followed_by_rest(motion: GroundMotion, after: float) -> GroundMotion:
    """The motion with ``after`` seconds of rest, the same object for 0; InputError for a time that is not allowed."""
    if isinstance(after, bool) or not math.isfinite(after) or after < 0:
        raise InputError(f"after = {after!r} s is not allowed; it must be at least 0")
    return motion if after == 0 else padded(motion, after)


def end_in_words(after: float) -> str:
    """Where a response ends, for tables and pages."""
    if after > 0:
        return f"ends {after:g} s after the record"
    return "ends with the record: what still swings then may reach its peak later"


def padded(motion: GroundMotion, seconds: float, before: float = 0.0) -> GroundMotion:
    """The motion with ``seconds`` of rest after it, for the free vibration that follows, and ``before`` seconds before it.

    In whole samples, rounded up. A last sample that is not 0 falls to 0 within one step.
    """
    for name, value in (("seconds", seconds), ("before", before)):
        if not math.isfinite(value) or value < 0:
            raise InputError(f"{name} = {value:g} s is not allowed; it must be at least 0")
    front, back = (math.ceil(value / motion.dt * (1 - 1e-12)) for value in (before, seconds))
    note = f"{back * motion.dt:g} s of rest added" + (f" after and {front * motion.dt:g} s before" if front else "")
    return motion.changed(np.pad(motion.acceleration, (front, back)), note)
