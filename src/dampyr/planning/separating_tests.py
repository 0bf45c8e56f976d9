"""Tests that tell a level from a stroke: where the strokes of the records go with their frequencies.

In a campaign whose large strokes are its slow tests nothing tells a force that depends on the stroke from one that depends on
the frequency. The tests of another session lie off that line: where their force is another one, the level of that session or
their stroke may be why. Three sines in one session at one input take them apart: one as a record had it (its force against that
record's is the level), one of the same frequency with another stroke, and one of the same stroke at another frequency.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dampyr.campaigns.check import violations_of
from dampyr.identification import Fit
from dampyr.models import Damper
from dampyr.planning.candidates import Candidate, list_dampers, make_sine, round_down, smallest_amplitude
from dampyr.records import Record, measure
from dampyr.records.checks.overview import overview
from dampyr.rig import RigSettings

TOGETHER = 0.9  # the size of the rank correlation of strokes and frequencies from which on they go together
FEWEST = 4  # motions that differ: of fewer a rank correlation says nothing
SAME = 0.1  # by which two frequencies, or two strokes, may differ and count as one
APART = 1.5  # times a stroke: what counts as another one at the same frequency
FACTORS = (2.0, 0.5, 1.5)  # of stroke and of frequency, in the order in which they are tried


@dataclass(frozen=True)
class _Motion:
    """A sine of the records: amplitude [m], frequency [Hz], input and the record's name."""

    amplitude: float
    frequency: float
    input: float
    record: str


@dataclass(frozen=True)
class Separation:
    """Sines that tell the level of a session, the stroke and the frequency apart, and why each is there; none where the rig can
    do no such three. ``words`` say what the records leave open."""

    words: str
    tests: tuple[Candidate, ...] = ()
    reasons: tuple[str, ...] = ()


def separate_level_from_stroke(
    evidence: Fit, rig: RigSettings, damper: Damper, inputs: Sequence[float], seconds: float
) -> Separation | None:
    """The sines for the records of a fit, at one of ``inputs`` [V]; None where the records tell strokes from frequencies."""
    motions = list(_list_motions(evidence.records))
    correlation = rank_correlation(motions)
    if abs(correlation) < TOGETHER or any(
        _differ_in_stroke(larger, smaller) for larger in motions for smaller in motions
    ):
        return None
    slow = "the larger the stroke the slower" if correlation < 0.0 else "the larger the stroke the faster"
    words = (
        f"in the records stroke and frequency go together ({slow}, rank correlation {correlation:.2f}): a force that differs "
        "in another session cannot be told from one that differs with the stroke"
    )
    middle = sorted(math.log(motion.frequency) for motion in motions)[(len(motions) - 1) // 2]
    strongest_first = sorted(motions, key=lambda motion: (-motion.input, abs(math.log(motion.frequency) - middle)))
    for motion in strongest_first:
        u = min(inputs, key=lambda value: abs(value - motion.input))
        if abs(u - motion.input) > SAME * (max(inputs) - min(inputs)) + 1e-6:
            continue
        tests = _three_sines(motion, motions, u, rig, damper, seconds)
        if tests:
            reasons = (
                f"as {motion.record}: against it, the level of this session",
                "its stroke alone differs from the first test's",
                "its frequency alone differs from the first test's",
            )
            return Separation(words, tests, reasons)
    return Separation(words)


def rank_correlation(motions: Sequence[_Motion]) -> float:
    """Spearman's, of amplitudes and frequencies of the motions that differ, at the input where it is the smallest; 0 where
    fewer than `FEWEST` differ at each input."""
    from scipy.stats import spearmanr

    found = []
    for u in {motion.input for motion in motions}:
        points = sorted({(float(f"{m.amplitude:.2g}"), float(f"{m.frequency:.2g}")) for m in motions if m.input == u})
        amplitudes, frequencies = zip(*points, strict=True)
        if len(points) >= FEWEST:
            order = len({*amplitudes}) > 1 and len({*frequencies}) > 1
            found.append(float(spearmanr(amplitudes, frequencies).statistic) if order else 0.0)
    return min(found, key=abs, default=0.0)


def _list_motions(records: Sequence[Record]) -> Iterator[_Motion]:
    """The records that repeat one cycle, at a constant input or without one."""
    for record in records:
        if not isinstance(record.input_channel, np.ndarray) and overview(record).repeats:
            measured, u = measure(record), float(record.input_value or 0.0)
            yield _Motion(0.5 * measured.peak_to_peak_m, measured.frequency_hz, u, record.name)


def _differ_in_stroke(larger: _Motion, smaller: _Motion) -> bool:
    """Whether two motions differ in their stroke alone."""
    return (
        larger.input == smaller.input
        and abs(math.log(larger.frequency / smaller.frequency)) <= SAME
        and larger.amplitude >= APART * smaller.amplitude
    )


def _three_sines(
    motion: _Motion, motions: Sequence[_Motion], u: float, rig: RigSettings, damper: Damper, seconds: float
) -> tuple[Candidate, ...]:
    """The motion, another stroke, another frequency; nothing where the rig cannot do one of them. Strokes and frequencies
    within those of the records come first."""
    low, high = (choose(m.frequency for m in motions) for choose in (min, max))
    smallest, largest = (choose(m.amplitude for m in motions) for choose in (min, max))
    a, f = round_down(motion.amplitude), round(motion.frequency, 3)

    def first_possible(wanted: list[tuple[float, float, bool]]) -> Candidate | None:
        for frequency, amplitude, _ in sorted(wanted, key=lambda place: not place[2]):
            sine = make_sine(round(frequency, 3), round_down(amplitude), u, seconds)
            if sine.amplitude >= smallest_amplitude(rig) and not any(
                violations_of(sine.step, rig, checked) for checked in list_dampers(rig, damper)
            ):
                return replace(sine, has_input=damper.has_input)
        return None

    found = (
        first_possible([(f, a, True)]),
        first_possible([(f, a * k, smallest <= a * k <= largest) for k in FACTORS]),
        first_possible([(f * k, a, low <= f * k <= high) for k in FACTORS]),
    )
    return tuple(sine for sine in found if sine is not None) if all(found) else ()
