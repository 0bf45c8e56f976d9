r"""Iterative learning of a drive: the next one from what the table has done under the last one; no rig is needed here.

A test is repeatable: with the same set points the table makes nearly the same error again. So the error of one try corrects the
set points of the next one,

.. math:: u_{k+1}(t) = u_k(t) + w(t)\, Q\,[\,e_k(t + \theta)\,], \qquad e_k = r - x_k

with the wanted displacement r, the achieved one x_k at the set points' times, a lead :math:`\theta` that makes up for the lag
of table and motor, and a low-pass Q without phase (Butterworth, forward and backward), which leaves alone what is too fast for
the table to follow. The gain is 1. The window w is 0 at both ends, so that the drive begins and ends where the table rests. On
a linear plant P the error shrinks monotonically where

.. math:: |Q (1 - P\, e^{j \omega \theta})| < 1 \text{ at all } \omega

which is the condition for learning with a lead and a zero-phase filter (Longman 2000, "Iterative learning control and
repetitive control for engineering practice", Int. J. Control 73(10); Bristow, Tharayil and Alleyne 2006, "A survey of iterative
learning control", IEEE Control Systems Magazine 26(3)). Shaking tables have long been driven so, with the inverse of a measured
transfer function in the place of the lead ("iterative control" of the drive signal); the position loop of the table makes that
unnecessary here, and a constant lead needs no identification. The plant is not quite linear (friction, a force that depends on
the speed), so that the error does not fall for ever: learning ends as soon as it rises. That is judged by its root mean square,
in which the condition above holds; the greatest error, which is to be within the tolerance, is that of one moment and scatters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.rig.drive import Drive

Array = NDArray[np.float64]
TRIES = 5
TOLERANCE = 0.02  # of half of the wanted peak to peak
LEAD = 0.010  # s: the simulated table's loop lags by 1 ms without a force and by 11 ms at 3.2 V
CUTOFF = 15.0  # Hz: above, motor and screw (25 ms) follow so late that the lead does not make up for it
NYQUIST_SHARE = 0.8  # of the set points' Nyquist frequency, where the cut-off would be above it
ORDER = 2  # of the low-pass; forward and backward make 4 of it
ENDS = 0.5  # s at both ends in which the correction grows and fades

REACHED, ROSE, SPENT, LIMITS = "within 2 %", "the error rose", "five tries", "limits"
"""Why learning ended."""


@dataclass(frozen=True)
class Tracking:
    """How far a table was from what it was to do.

    ``error`` is the greatest :math:`|r - x|` over half of the peak to peak of r, ``rms`` the root of the mean square of r - x
    over the same; both at the set points of which samples were kept, the rests before and after the motion included.
    """

    error: float
    rms: float


def tracking(wanted: Drive, achieved: Array) -> Tracking:
    """The `Tracking` of an achieved displacement (n,) [m] at the set points of the drive that was wanted.

    Raises :class:`~dampyr.errors.InputError` where the drive does not move.
    """
    part = slice(wanted.record_from, None if wanted.record_to is None else wanted.record_to + 1)
    size = 0.5 * float(np.ptp(wanted.displacement[part]))
    if size == 0.0:
        raise InputError(
            "the wanted displacement does not change, so that no error can be related to it; give a test that moves"
        )
    error = (wanted.displacement - achieved)[part]
    return Tracking(float(np.abs(error).max()) / size, float(np.sqrt(np.mean(error**2))) / size)


def at_set_points(drive: Drive, time: Array, displacement: Array) -> Array:
    """A recorded displacement (m,) [m] at the set points' times (n,).

    ``time`` (m,) [s] is the board's; its first sample is that of the set point ``record_from``. Set points of which no sample
    was kept get the first or the last one. Take the encoder's own reading, and not a record's displacement, which is on the
    force's clock. :class:`~dampyr.errors.InputError` where the samples end before the set points do.
    """
    first = drive.record_from * drive.period
    last = (drive.n - 1 if drive.record_to is None else drive.record_to) * drive.period
    drive_time = time - time[0] + first
    if drive_time[-1] < last - drive.period:
        raise InputError(
            f"the samples end after {drive_time[-1]:.4g} s, the drive after {last:.4g} s; record the whole drive"
        )
    return np.interp(drive.time, drive_time, displacement)


def next_set_points(wanted: Array, commanded: Array, achieved: Array, period: float) -> Array:
    """The set points (n,) [m] of the next try.

    Parameters
    ----------
    wanted, commanded, achieved : (n,) m, every ``period`` [s].
    """
    from scipy import signal

    time = np.arange(wanted.size) * period
    # The table answers a set point after about LEAD: what is off at t + LEAD is corrected at t.
    early = np.interp(time + LEAD, time, wanted - achieved)
    cutoff = min(CUTOFF, NYQUIST_SHARE * 0.5 / period)
    b, a = signal.butter(ORDER, 2.0 * cutoff * period)
    # The usual pad of filtfilt, by which it continues both ends; less where the drive is shorter than that.
    pad = min(3 * max(len(a), len(b)), wanted.size - 1)
    return np.asarray(commanded + ends_window(wanted.size, period) * signal.filtfilt(b, a, early, padlen=pad))


def ends_window(n: int, period: float) -> Array:
    """The window w (n,): 0 at the first and the last set point, 1 from `ENDS` s on, a raised cosine between."""
    k = np.arange(n)
    share = np.clip(np.minimum(k, k[::-1]) * period / ENDS, 0.0, 1.0)
    return 0.5 * (1.0 - np.cos(np.pi * share))


def ended_because(tries: Sequence[Tracking]) -> str:
    """Why learning ends after these tries, in their order; "" where another one is due. A rise is one of the rms."""
    if not tries:
        return ""
    if tries[-1].error <= TOLERANCE:
        return REACHED
    if len(tries) > 1 and tries[-1].rms > tries[-2].rms:
        return ROSE
    return SPENT if len(tries) >= TRIES else ""


def best_of(tries: Sequence[Tracking]) -> int:
    """Which try had the least `Tracking.error`, from 0."""
    return int(np.argmin([result.error for result in tries]))
