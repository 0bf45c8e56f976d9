r"""Comparison of a running test with the record of the same test in an earlier run, cycle by cycle.

A cycle goes from one upward pass of its centre to the next. Three values are compared: the dissipated energy
:math:`\oint F\,dx`, and the mean force in the middle of the stroke, where a sine has its peak speed, in extension and in
compression. A cycle passes where each is within the tolerance of the reference's value, of the forces of the greater of the
two. This is for the eyes of an operator while a test runs; the judgement of a run is `dampyr accept`.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.journal import read_journal
from dampyr.campaigns.recorded_tests import file_of
from dampyr.errors import DampyrError
from dampyr.records import read
from dampyr.records.record import Record
from dampyr.rig.interlock import Samples

Array = NDArray[np.float64]
POINTS = 400  # of the loop that a page draws
MIDDLE = 0.1  # of the amplitude: the part of the stroke about the centre over which a force is averaged
HYSTERESIS = 0.3  # of the amplitude, beyond which a pass of the centre counts
LIKE = 0.05  # of the amplitude by which a cycle may differ from the reference's to be compared
MAX_CYCLES = 12  # judged cycles that a page lists
MAX_SAMPLES = 2_000_000  # of a cycle: one that is longer is not compared


@dataclass(frozen=True)
class CycleMeasures:
    """Energy J, mean forces N in the middle of the stroke, and the amplitude m."""

    energy: float
    extension: float
    compression: float
    amplitude: float


@dataclass(frozen=True)
class JudgedCycle:
    """A cycle of the running test, from 1; the values over the reference's, less 1."""

    number: int
    passed: bool
    energy: float
    extension: float
    compression: float


@dataclass(frozen=True)
class ReferenceLoop:
    """The last whole cycle of a reference's record in units of the page, mm, N and mm/s, for drawing."""

    test: str
    x: list[float]
    force: list[float]
    velocity: list[float]


@dataclass(frozen=True)
class Comparison:
    """How a running test compares; ``reason`` says why it is not compared, empty where it is."""

    folder: str
    tolerance: float
    test: str = ""
    reason: str = ""
    passed: int = 0
    failed: int = 0
    cycles: tuple[JudgedCycle, ...] = ()


@dataclass
class ReferenceTest:
    """The reference of one test: its measures and its loop."""

    measures: CycleMeasures
    loop: ReferenceLoop
    centre: float = 0.0
    """m, about which its cycles lie."""


def reference_test(folder: Path, test: str) -> ReferenceTest:
    """The reference of a test in the folder of an earlier run.

    Raises :class:`~dampyr.errors.InputError` or FileError with the reason where there is none.
    """
    entries, _ = read_journal(folder)
    attempts = [entry.attempt for entry in entries if entry.name == test and entry.state == "complete"]
    if not attempts:
        raise DampyrError(f"the reference has no complete test {test!r}")
    return of_record(read(file_of(folder, test, attempts[0])), test)


def of_record(record: Record, test: str) -> ReferenceTest:
    """The reference that a record gives: the medians of its cycles of full amplitude, and the last of them as a loop."""
    x, force = np.asarray(record.displacement), np.asarray(record.force)
    amplitude, centre = 0.5 * float(np.ptp(x)), 0.5 * float(x.max() + x.min())
    passes = upward_passes(x, centre, HYSTERESIS * amplitude)
    spans = list(itertools.pairwise(passes))
    measures = [cycle_measures(x[i:j], force[i:j]) for i, j in spans]
    whole = [k for k, cycle in enumerate(measures) if abs(cycle.amplitude - amplitude) <= LIKE * amplitude]
    if not whole:
        raise DampyrError("the reference has no two whole cycles of one amplitude, so no cycle can be compared")
    medians = [float(np.median([getattr(measures[k], name) for k in whole])) for name in CycleMeasures.__annotations__]
    i, j = spans[whole[-1]]
    drawn = np.unique(np.linspace(i, j, POINTS).astype(int).clip(0, len(x) - 1))
    velocity = np.gradient(x[drawn], np.asarray(record.time)[drawn])
    channels = (x[drawn] * 1e3, force[drawn], velocity * 1e3)
    loop = ReferenceLoop(test, *(np.round(values, 4).tolist() for values in channels))
    return ReferenceTest(CycleMeasures(*medians), loop, centre)


def upward_passes(x: Array, centre: float, threshold: float) -> list[int]:
    """The samples at which ``x`` passes ``centre`` upwards, each after an excursion below ``centre - threshold`` and before one
    above ``centre + threshold``."""
    passes, low, candidate = [], False, -1
    sides = (x > centre + threshold).astype(np.int8) - (x < centre - threshold).astype(np.int8)
    above = x >= centre
    rising = np.flatnonzero(~above[:-1] & above[1:]) + 1
    changes = np.flatnonzero(np.diff(sides, prepend=sides[:1] * 0)) if len(sides) else np.empty(0, int)
    moments = sorted([(int(k), 0) for k in rising] + [(int(k), 1) for k in changes])
    for k, kind in moments:
        if kind == 0:
            candidate = k
        elif sides[k] < 0:
            low = True
        elif sides[k] > 0 and low:
            passes.append(candidate)
            low = False
    return [k for k in passes if k >= 0]


def cycle_measures(x: Array, force: Array) -> CycleMeasures:
    """What is compared of one cycle."""
    centre, amplitude = 0.5 * float(x.max() + x.min()), 0.5 * float(np.ptp(x))
    # closed by its first sample, and integrated by the trapezoidal rule
    closed_x, closed_force = np.append(x, x[0]), np.append(force, force[0])
    energy = float(np.sum(0.5 * (closed_force[1:] + closed_force[:-1]) * np.diff(closed_x)))
    top, bottom = int(x.argmax()), int(x.argmin())
    order = np.arange(len(x))
    down = (order >= top) & (order < bottom) if top < bottom else (order >= top) | (order < bottom)
    middle = np.abs(x - centre) <= MIDDLE * amplitude

    def mean(selected: NDArray[np.bool_]) -> float:
        return float(force[selected].mean()) if selected.any() else math.nan

    return CycleMeasures(energy, mean(middle & ~down), mean(middle & down), amplitude)


@dataclass
class CycleJudge:
    """Compares the cycles of one running test with its reference as they end."""

    reference: ReferenceTest
    tolerance: float
    _x: Array = field(default_factory=lambda: np.empty(0))
    _force: Array = field(default_factory=lambda: np.empty(0))
    _number: int = 0

    def take(self, samples: Samples) -> list[JudgedCycle]:
        """Take a block; the cycles that ended in it."""
        self._x = np.concatenate([self._x, samples.displacement])[-MAX_SAMPLES:]
        self._force = np.concatenate([self._force, samples.force])[-MAX_SAMPLES:]
        amplitude, centre = self.reference.measures.amplitude, self.reference.centre
        passes = upward_passes(self._x, centre, HYSTERESIS * amplitude)
        judged = [
            cycle
            for i, j in itertools.pairwise(passes)
            if (cycle := self._judged(cycle_measures(self._x[i:j], self._force[i:j]))) is not None
        ]
        if len(passes) > 1:
            self._x, self._force = self._x[passes[-1] - 1 :], self._force[passes[-1] - 1 :]
            # the excursion below the centre came before what is left: it is put in front
            self._x = np.concatenate([[centre - 2.0 * HYSTERESIS * amplitude], self._x])
            self._force = np.concatenate([self._force[:1], self._force])
        return judged

    def _judged(self, measures: CycleMeasures) -> JudgedCycle | None:
        expected = self.reference.measures
        if abs(measures.amplitude - expected.amplitude) > LIKE * expected.amplitude:
            return None  # it grows, or fades
        self._number += 1
        # by the greater of the two forces: an offset may leave one of them near zero
        greatest = max(abs(expected.extension), abs(expected.compression))
        deviations = (
            measures.energy / expected.energy - 1.0,
            (measures.extension - expected.extension) / greatest,
            (measures.compression - expected.compression) / greatest,
        )
        return JudgedCycle(self._number, all(abs(value) <= self.tolerance for value in deviations), *deviations)
