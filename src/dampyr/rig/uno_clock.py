r"""The Uno's clock against the board's: the ratio of the two, with its uncertainty, while a rig is read.

An Uno's ceramic resonator is off by up to 0.5 % (by 0.2 % on one that was measured: forum.arduino.cc, topic 69316), the board's
quartz by 50 ppm. So a path that the Uno is to follow for a minute would be 0.1 to 0.3 s late at its end, and its frequency off
by as much, where what belongs together is not paired through the ratio :math:`\rho` of the Uno's milliseconds to the board's.

After each block the Uno's STATUS tells its time m [ms] while the board has sampled for t [s]:

.. math:: m_k = 1000\,\rho\,t_k + b + \epsilon_k

where :math:`\epsilon` is what the request needed on its line (1 to 16 ms, uneven) and the whole millisecond. The slope of a
straight line through the last `WINDOW` seconds is :math:`\rho`; its standard error is that of even noise, or that of the means
of `BATCHES` batches where these scatter more, as noise that is correlated does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TOLERANCE = 0.003  # standard uncertainty of a clock that was never compared: limits of 0.5 %, over the root of 3
KNOWN = 50e-6  # standard uncertainty with which a ratio is known well enough for a path that is learned or computed
SPACING = 0.02  # s between two pairs, at least: shorter blocks tell no more
WINDOW = 60.0  # s looked back: in less the line's latency counts, in more the drift of a clock that warms
CAPACITY = round(WINDOW / SPACING) + 2
LEAST = 25  # pairs from which on a line is drawn
BATCHES = 8
DRIFT = 20e-6  # by which a ratio may have changed between two armings: 10 ppm/K
ANOTHER = 5.0  # standard uncertainties apart: the Uno was changed, or its clock repaired
PROMPT = 0.05  # share of the pairs that were prompt: the line without its latency passes through them
WRONG = 0.01  # off by more: no resonator is
RECENT = 4.0  # s that are compared with what was before
JUMP = 0.002  # by which a ratio may differ within one arming


@dataclass(frozen=True)
class ClockRatio:
    """Milliseconds of the Uno's to one of the board's, and the standard ``uncertainty`` of that."""

    value: float = 1.0
    uncertainty: float = TOLERANCE

    @property
    def known(self) -> bool:
        """Whether it is known to `KNOWN`."""
        return self.uncertainty <= KNOWN

    def __str__(self) -> str:
        ppm = 1e6 * (self.value - 1.0)
        way = "fast" if ppm > 0.0 else "slow"
        return f"the Uno's clock is {abs(ppm):.0f} ppm {way} against the board's, known to {1e6 * self.uncertainty:.0f} ppm"


class UnoClock:
    """What is known of the Uno's clock: `take` a pair after each block, `restart` where the board begins to count anew.

    Once a second ``ratio`` is worked out, and ``fault``: what is wrong with the clocks, empty where nothing is.
    """

    def __init__(self) -> None:
        self.ratio = ClockRatio()
        self.restart()

    def restart(self) -> None:
        """The board counts from 0; the ratio as it was counts on, less surely."""
        self._before = ClockRatio(self.ratio.value, math.hypot(self.ratio.uncertainty, DRIFT))
        self._pairs, self._first, self._end = np.empty((2, 2 * CAPACITY)), 0, 0
        self._due, self.fault = 0.0, ""

    def take(self, seconds: float, milliseconds: int) -> None:
        """The Uno's time [ms] that it told after the board had sampled for ``seconds``."""
        pairs, end = self._pairs, self._end
        last_time, last = pairs[:, end - 1] if end > self._first else (-math.inf, float(milliseconds))
        if seconds - last_time < SPACING:
            return
        if end == pairs.shape[1]:
            kept = pairs[:, self._first :].copy()
            self._first, end = 0, kept.shape[1]
            pairs[:, :end] = kept
        # The Uno's 32 bits begin anew after 50 days.
        pairs[:, end] = seconds, last + (milliseconds - last) % 2**32
        self._end = end + 1
        while seconds - pairs[0, self._first] > WINDOW:
            self._first += 1
        if self._end - self._first >= LEAST and seconds >= self._due:
            self._due = seconds + 1.0
            t, m = pairs[:, self._first : self._end]
            measured = slope(t, m)
            self.ratio, self.fault = self._weighted(measured), describe_fault(t, m, measured)

    def _weighted(self, measured: ClockRatio) -> ClockRatio:
        """The ratio by a measured one and by what was known before, unless the two are of different Unos."""
        before = self._before
        apart = abs(measured.value - before.value)
        if apart > ANOTHER * math.hypot(measured.uncertainty, before.uncertainty):
            before = ClockRatio()
        weights = before.uncertainty**-2, measured.uncertainty**-2
        value = (weights[0] * before.value + weights[1] * measured.value) / sum(weights)
        return ClockRatio(value, sum(weights) ** -0.5)

    def _delays(self) -> Array:
        """How late the Uno told its times (n,) [ms], from an origin that all of them share."""
        t, m = self._pairs[:, self._first : self._end]
        return np.asarray(m - 1e3 * self.ratio.value * t)

    def seconds_at(self, milliseconds: float) -> float:
        """The board's time [s] at the Uno's, by its promptest answers."""
        last = self._pairs[1, self._end - 1]
        wrapped = milliseconds + 2**32 * round((last - milliseconds) / 2**32)
        return float((wrapped - np.quantile(self._delays(), PROMPT)) / (1e3 * self.ratio.value))

    @property
    def latency(self) -> float:
        """s by which a request is late in the mean, beyond the promptest; 0 where the clocks were not read yet."""
        delays = self._delays()
        return 1e-3 * float(np.mean(delays) - np.quantile(delays, PROMPT)) if delays.size else 0.0


def describe_fault(t: Array, m: Array, measured: ClockRatio) -> str:
    """What is wrong with pairs of the board's times (n,) [s] and the Uno's (n,) [ms], whose ratio was ``measured``; else ""."""
    off = measured.value - 1.0
    if abs(off) - 3.0 * measured.uncertainty > WRONG:
        return (
            f"the Uno's clock is {100 * abs(off):.3g} % {'fast' if off > 0 else 'slow'} against the board's, and no "
            f"resonator is off by more than {100 * WRONG:g} %; look at the Uno's clock (its fuses, its resonator) and at "
            "board.rate"
        )
    recent = t > t[-1] - RECENT
    if np.sum(recent) < LEAST or np.sum(~recent) < 2 * LEAST:
        return ""
    late, early = slope(t[recent], m[recent]), slope(t[~recent], m[~recent])
    change = late.value - early.value
    if abs(change) <= max(JUMP, 6.0 * math.hypot(late.uncertainty, early.uncertainty)):
        return ""
    return (
        f"the ratio of the Uno's clock to the board's has changed by {100 * change:+.2g} % within {RECENT:g} s; look at "
        "the Uno's resonator and power, and whether this machine was suspended"
    )


def slope(t: Array, m: Array) -> ClockRatio:
    """The ratio by a straight line through pairs of the board's times (n,) [s] and the Uno's (n,) [ms], and its uncertainty."""
    time = t - np.mean(t)
    square = float(time @ time)
    value = float(time @ (m - np.mean(m))) / square
    off = m - np.mean(m) - value * time
    n = len(t)
    even = math.sqrt(float(off @ off) / (n - 2) / square)
    parts = [slice(n * k // BATCHES, n * (k + 1) // BATCHES) for k in range(BATCHES)]
    centre, mean = (np.array([np.mean(row[part]) for part in parts]) for row in (time, off))
    batched = math.sqrt(float(mean @ mean) / (BATCHES - 2) / float(centre @ centre))
    return ClockRatio(1e-3 * value, 1e-3 * max(even, batched, 1e-3 / np.ptp(t)))
