"""Comparison of a running test with an earlier run, cycle by cycle, as `dampyr accept` will judge the record.

The samples of the latest cycles are held here and handed to `dampyr.identification.acceptance_tests.cycles_under_way`, which
says what only the whole record tells. All tests of the earlier run are the reference, as at the end of the run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.run_control import Progress
from dampyr.errors import InputError
from dampyr.identification import AcceptOptions
from dampyr.identification.acceptance_tests.acceptance import Acceptance, explain_unjudged
from dampyr.identification.acceptance_tests.cycles_under_way import CyclesUnderWay
from dampyr.identification.acceptance_tests.reference_cycles import ReferenceTest, comparable_tests
from dampyr.records import Record, cut_cycles, nominal_inputs
from dampyr.records.record import MIN_SAMPLES

Array = NDArray[np.float64]
POINTS = 400  # of the loop that a page draws
FULL = 0.95  # of the largest stroke: the cycle that is drawn neither grows nor fades
MAX_CYCLES = 12  # judged cycles that a page lists
MAX_SAMPLES = 1_000_000  # that are held of a test
# What is held is cut again after so many s, so much of the reference's longest cycle, and so much of what is held.
LEAST, STEP, GROWN = 0.25, 0.25, 0.1


@dataclass(frozen=True)
class JudgedCycle:
    """A cycle of the running test, by its number from the start of the motion; measured over expected less 1, None where the
    reference says nothing of it."""

    number: int
    passed: bool
    energy: float | None
    extension: float | None
    compression: float | None


@dataclass(frozen=True)
class ReferenceLoop:
    """The last cycle of full stroke of a reference's record in units of the page, mm, N and mm/s, for drawing."""

    test: str
    x: list[float]
    force: list[float]
    velocity: list[float]


@dataclass(frozen=True)
class Comparison:
    """How a running test compares; ``reason`` says why it, or the latest cycle, is not judged, empty where it is."""

    folder: str
    tolerance: float
    test: str = ""
    reason: str = ""
    passed: int = 0
    failed: int = 0
    cycles: tuple[JudgedCycle, ...] = ()


@dataclass(frozen=True)
class EarlierRun:
    """What is kept of the records of an earlier run: their cycles; and by a test's name its loop, and why it is not judged."""

    tests: tuple[ReferenceTest, ...]
    loops: Mapping[str, ReferenceLoop]
    unjudged: Mapping[str, str]

    @classmethod
    def of(cls, records: Sequence[Record]) -> EarlierRun:
        """That of its records."""
        records = nominal_inputs(records)
        loops = {record.name: loop_of(record) for record in records if cut_cycles(record).levels}
        unjudged = {record.name: explain_unjudged(cut_cycles(record)) for record in records}
        return cls(tuple(map(ReferenceTest.of, records)), loops, unjudged)


def loop_of(record: Record) -> ReferenceLoop:
    """The last cycle of full stroke."""
    cycles = [cycle for cycle in cut_cycles(record).cycles if cycle.level]
    full = FULL * max(cycle.stroke_m for cycle in cycles)
    cycle = [cycle for cycle in cycles if cycle.stroke_m >= full][-1]
    drawn = np.unique(np.linspace(cycle.first, cycle.last, POINTS).astype(int))
    velocity = np.gradient(record.displacement[drawn], record.time[drawn])
    channels = (record.displacement[drawn] * 1e3, record.force[drawn], velocity * 1e3)
    return ReferenceLoop(record.name, *(np.round(values, 4).tolist() for values in channels))


@dataclass
class LiveComparison:
    """The comparison of one running test."""

    comparison: Comparison
    _cycles: CyclesUnderWay | None = None
    _blocks: list[Array] = field(default_factory=list)  # time, displacement, force and voltage (4, n), not yet judged
    _longest: float = 0.0  # cycle of the reference, s
    _due: float = -np.inf  # when what is held is cut again, s
    _given_up: bool = False

    def take(self, progress: Progress, run: EarlierRun | None) -> None:
        """Take a block, and judge the cycles that have ended once ``run`` has been read."""
        if self._given_up or (samples := progress.samples) is None:
            return
        block = (samples.time, samples.displacement, samples.force, samples.voltage)
        self._blocks.append(np.array(block, dtype=float))
        try:
            if run is not None:
                if self._cycles is None:
                    self._begin(run)
                if samples.time[-1] >= self._due or progress.fraction >= 1.0:
                    self._judge(progress.force_delay)
            if sum(held.shape[1] for held in self._blocks) > MAX_SAMPLES:
                raise InputError(f"a cycle has not ended after {MAX_SAMPLES} samples")
        except Exception as problem:  # told on the page: a comparison that fails must end no test
            self.comparison = replace(self.comparison, reason=str(problem) or type(problem).__name__)
            self._given_up = True
            self._blocks.clear()

    def _begin(self, run: EarlierRun) -> None:
        planned = next((test for test in run.tests if test.name == self.comparison.test), None)
        if planned is None:
            raise InputError(f"the reference has no complete test {self.comparison.test!r}")
        _, reason = comparable_tests(run.tests, planned.conditions)
        if reason := reason or run.unjudged[planned.name]:
            raise InputError(reason)
        self._longest = max(cycle.period_s for cycle in planned.cycles)
        self._cycles = CyclesUnderWay(run.tests, planned, AcceptOptions(tolerance=self.comparison.tolerance))

    def _judge(self, delay: float) -> None:
        """Cut what is held, the displacement on the force's clock as in a record, and count the cycles that are judged."""
        held = np.concatenate(self._blocks, axis=1)
        if self._cycles is None or held.shape[1] < MIN_SAMPLES:
            return
        time, x, force, voltage = held
        judged, first = self._cycles.judge(Record(time, np.interp(time - delay, time, x), force, voltage=voltage))
        self._blocks = [held[:, first:].copy()]
        self._due = time[-1] + max(LEAST, STEP * self._longest, GROWN * (time[-1] - time[first]))
        for acceptance in judged:
            self._count(acceptance)

    def _count(self, acceptance: Acceptance) -> None:
        now = self.comparison
        if acceptance.passed is None:
            self.comparison = replace(now, reason=acceptance.reason)
            return
        deviations = {p.quantity: p.deviation for p in acceptance.points}
        cycle = JudgedCycle(acceptance.points[0].cycle, acceptance.passed, **deviations)
        counts = (now.passed + cycle.passed, now.failed + (not cycle.passed))
        cycles = (*now.cycles, cycle)[-MAX_CYCLES:]
        self.comparison = replace(now, reason="", passed=counts[0], failed=counts[1], cycles=cycles)
