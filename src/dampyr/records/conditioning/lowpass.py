"""Noise of a displacement: whether it hides the direction of motion, and a stated low-pass against it.

Friction turns within micrometres of travel, and noise of that size turns it at every sample of slow motion. A model runs along
the displacement as it is, so what of it is noise must be said: by a low-pass, noted in the record's history.
"""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.errors import DampyrWarning, InputError
from dampyr.models.numerics.differentiation import response, smooth
from dampyr.records.checks.overview import repeats
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.velocity import PER_TEST_FREQUENCY, WITHOUT_CYCLES, default_bandwidth
from dampyr.records.cycle_analysis.cycles import Cut, cut_cycles, turning_points
from dampyr.records.cycle_analysis.measure import fundamental
from dampyr.records.record import MIN_SAMPLES, Array, Record
from dampyr.records.record_thresholds import USUAL, RecordThresholds
from dampyr.shown import Shown

PROVENANCE = "displacement_lowpass_hz"
WHITE = 0.6745 * math.sqrt(20.0)  # the median absolute third difference of white noise over its standard deviation
ABOVE_NOISE = 10.0  # times the noise's power: there the motion stands out
PASSED = 3.0  # times the highest frequency that stands out: there the low-pass takes less than 1 %
SAMPLES_PER_CYCLE = 40  # as in `dampyr.records.checks.quality`: with fewer, third differences hold the motion
CORNER = 2  # samples to each side of a turning point
LINES = 15  # of the spectrum, over which its power is averaged


@dataclass(frozen=True, repr=False)
class DisplacementNoise(Shown):
    """The noise of a displacement against its motion.

    ``rms`` in m, from third differences, which hold the steps of an encoder too; ``backward`` is the part of the samples, from
    the start of the motion, in which the displacement goes back against the motion after a low-pass; ``lowpass_hz`` is the
    proposed one and ``rms_after`` what it leaves of the noise, m.
    """

    rms: float
    backward: float
    lowpass_hz: float
    rms_after: float

    @property
    def hides_direction(self) -> bool:
        """Whether the direction of motion is uncertain in more than 1 % of the samples."""
        return self.backward > USUAL.uncertain_direction

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should look at by the usual thresholds, with the repair; empty where the direction is clear."""
        return self.judged(USUAL)

    def judged(self, thresholds: RecordThresholds) -> tuple[str, ...]:
        """The `notes` by other thresholds."""
        if self.backward <= thresholds.uncertain_direction:
            return ()
        return (
            f"displacement noise of {1e6 * self.rms:.2g} um rms turns the direction of motion in {100 * self.backward:.2g} % "
            f"of the samples: state a low-pass, --lowpass {self.lowpass_hz:.3g} (Hz), leaves {1e6 * self.rms_after:.2g} um",
        )


def displacement_noise(record: Record) -> DisplacementNoise:
    """The noise of a record's displacement, and the low-pass that takes it but not the motion.

    That is 15 times the frequency of a motion that repeats itself, else three times the highest frequency at which
    the motion's power is ten times that of the noise; of a test with rising or falling strokes 15 times the highest
    frequency of a level, and the two samples to each side of a turning point are left out, since a low-pass rounds
    the corners of digitised loops. With fewer than 40 samples a cycle, motion and noise are not distinct, and
    ``backward`` is 0.
    """
    first = int(np.searchsorted(record.time, motion_start(record)))
    first = first if record.n - first >= MIN_SAMPLES else 0
    x = record.displacement
    rms = float(np.median(np.abs(np.diff(x[first:], 3)))) / WHITE
    chosen = _proposed(record, rms)
    moves = np.diff(smooth(record.time, x, chosen))[first:]
    against = np.diff(x)[first:] * moves < 0.0
    cut = cut_cycles(record)
    if cut.graded:  # digitised loops have corners, which a low-pass rounds; no noise is needed for that
        for point in turning_points(record) - first:
            against[max(point - CORNER, 0) : max(point + CORNER, 0)] = False
    backward = float(np.mean(against))
    if _period(record, cut) < SAMPLES_PER_CYCLE * record.dt:
        backward = 0.0
    frequencies = np.linspace(0.0, 0.5 / record.dt, 2000)
    passed = float(np.trapezoid(response(frequencies, chosen) ** 2, frequencies)) * 2.0 * record.dt
    return DisplacementNoise(rms, backward, chosen, rms * math.sqrt(passed))


def _period(record: Record, cut: Cut) -> float:
    """The period of the motion, s: of the shortest level of a test in levels; infinite where it has none."""
    if cut.graded:
        return min(level.period_s for level in cut.levels)
    return 1.0 / fundamental(record)[0] if repeats(record) else math.inf


def _proposed(record: Record, rms: float) -> float:
    if repeats(record):
        return default_bandwidth(record)
    limit = WITHOUT_CYCLES / record.dt
    cut = cut_cycles(record)
    if cut.graded:
        return min(PER_TEST_FREQUENCY / _period(record, cut), limit)
    power = np.abs(np.fft.rfft((record.displacement - record.displacement[0]) * np.hanning(record.n))) ** 2
    floor = rms**2 * float(np.sum(np.hanning(record.n) ** 2))
    averaged = np.convolve(power, np.ones(LINES) / LINES, "same")
    standing_out = np.flatnonzero(averaged > ABOVE_NOISE * floor)
    highest = float(standing_out[-1]) / (record.n * record.dt) if standing_out.size else limit
    return min(max(PASSED * highest, 4.0 / record.duration), limit)


def multiple_or_hz(lowpass: Any) -> tuple[float, bool]:
    """A low-pass in Hz, or, from ``"15 f"``, as a multiple of the motion's frequency: the value, and whether it is a multiple.

    Raises :class:`~dampyr.errors.InputError` where it is neither.
    """
    match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(Hz|f)?\s*", lowpass) if isinstance(lowpass, str) else None
    try:
        value = float(match[1] if match else lowpass if isinstance(lowpass, int | float) else "")
    except ValueError:
        value = math.nan
    if isinstance(lowpass, bool) or not (math.isfinite(value) and value > 0.0):
        raise InputError(
            f'lowpass = {lowpass!r} is not a frequency; give Hz above 0, such as 20, or "15 f", 15 times the motion\'s'
        )
    return value, bool(match and match[2] == "f")


def as_lowpass(lowpass: Any) -> float | str:
    """A low-pass as it is compared: Hz as a number, a multiple of the motion's frequency as a text such as ``"15 f"``.

    Raises :class:`~dampyr.errors.InputError` where it is neither.
    """
    value, is_multiple = multiple_or_hz(lowpass)
    return f"{value:.12g} f" if is_multiple else value


def with_lowpass(record: Record, lowpass: Any) -> Record:
    """The record with its displacement after a low-pass without phase, 3 dB down at ``lowpass`` (Hz, or such as ``"15 f"``).

    The value of the local cubic of `dampyr.models.numerics.differentiation`, gain :math:`(1 + u) e^{-u}` with
    :math:`u = 1.078 (f/f_c)^2`: 3 % at half the frequency, 0.6 % at a third. Force and velocity stay as they are. The history
    states the frequency, and ``provenance["displacement_lowpass_hz"]``.

    A multiple is declared of many records at once. One that it does not fit, whose motion does not repeat itself or whose
    samples do not carry the frequency, stays as it is, with a warning and a line in its history.

    Raises
    ------
    InputError
        It is not a frequency that the samples carry.
    """
    value, is_multiple = multiple_or_hz(lowpass)
    if is_multiple and not repeats(record):
        return _left_off(record, lowpass, "its motion does not repeat itself, so that it has no frequency")
    if is_multiple:
        value *= fundamental(record)[0]
    try:
        passed: Array = smooth(record.time, record.displacement, value)
    except InputError as problem:
        if is_multiple:
            return _left_off(record, lowpass, f"{value:.4g} Hz: {problem}")
        raise InputError(f"{record.name}: lowpass: {problem}") from problem
    note = f"displacement after a low-pass: local cubic, no phase, -3 dB at {value:.4g} Hz"
    provenance = dict(record.provenance) | {PROVENANCE: f"{value:.6g}"}
    return record.replace(note=note, displacement=passed, provenance=provenance)


def _left_off(record: Record, lowpass: Any, reason: str) -> Record:
    """The record as it is, with the reason why a low-pass that is declared for several records is left off here."""
    note = f"low-pass of {lowpass} left off: {reason}"
    warnings.warn(f"{record.name}: {note}", DampyrWarning, stacklevel=3)
    return record.replace(note=note)
