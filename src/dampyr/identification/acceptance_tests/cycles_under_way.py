"""Cycles of a test that is still under way, judged as `dampyr.identification.accept` judges them in the whole record.

The latest cycles are cut by the same cutter and judged by the same rule (`judge_cut`), one when the next one has ended, or when
1.2 of its periods have passed without: its velocity at its end, and whether it is of a level, are not known before. Then its
number, velocities, windows and energy are those in the whole record, but for what only that tells and is not waited for:

- the load cell's zero is the mean force over the cycles so far. A cycle that the mean over the latest one alone would judge
  otherwise is not judged; where the zero drifts on, one near the edge of the band may still be judged otherwise at the end;
- the noise is that of the latest cycles, which moves the edge by the same allowance, a little;
- a cycle like neither neighbour is not judged, as it may be of the run-in or the run-out; nor is the last one of a motion that
  ends with its record, nor the mean of a level;
- where a motion grows over many cycles, or much greater strokes come, which legs count is known only later: the cycles may be
  cut half a cycle earlier, and their numbers be off.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from dampyr.identification.acceptance_tests.acceptance import Acceptance, AcceptOptions, judge_cut
from dampyr.identification.acceptance_tests.reference_cycles import ReferenceTest
from dampyr.records import Record
from dampyr.records.conditioning.nominal_input import nominal_inputs
from dampyr.records.cycle_analysis.cycles import SAME_PERIOD, Cut, CutCycle, cut_part
from dampyr.records.record import Array

KEPT = 3  # cycles before those to be judged: the velocity, the mean position and the noise take them in
BEGUN = 0.5  # of the smallest stroke of the reference's test: with less the motion has not begun
TOO_CLOSE = "too close to the edge of the band for a zero that still moves"


@dataclass
class CyclesUnderWay:
    """The cycles of one test, judged by the ``tests`` of a reference, of which ``planned`` is the same test."""

    tests: Sequence[ReferenceTest]
    planned: ReferenceTest
    options: AcceptOptions
    _before: int = 0  # cycles before the first of the next part
    _judged: int = 0  # the latest cycle that was judged
    _away: float | None = None  # from the mean position to where cycles are cut, m
    _force: Array = field(default_factory=lambda: np.zeros(2))  # over the cycles of levels that have ended: N s, and s

    def judge(self, part: Record) -> tuple[list[Acceptance], int]:
        """The cycles that can be judged since the last part, one `Acceptance` for each, and the sample of ``part`` from which
        the next part must go on. The first part begins with the test.
        """
        if np.ptp(part.displacement) < BEGUN * min(cycle.stroke_m for cycle in self.planned.cycles):
            return [], 0  # beside noise alone noise looks like cycles
        cut, away = cut_part(part, self._away)
        if not cut.cycles:
            return [], 0
        last = cut.cycles[-1]
        over = part.time[-1] - last.stop_s > (1.0 + SAME_PERIOD) * (last.stop_s - last.start_s)
        ended = cut.cycles if over else cut.cycles[:-1]
        levels = {level.number for level in cut.levels if level.count > 1}
        new = [cycle for cycle in ended if cycle.level in levels and self._before + cycle.number > self._judged]
        verdicts = self._judge(part, cut, new) if new else []
        self._judged = self._before + new[-1].number if new else self._judged
        # as long as no level is seen all is kept: a motion that grows has legs that do not count beside later ones
        dropped = max(len(ended) - KEPT, 0) if self._judged else 0
        if dropped:
            self._before, self._away = self._before + dropped, away
        return verdicts, cut.cycles[dropped].first if dropped else 0

    def _judge(self, part: Record, cut: Cut, new: Sequence[CutCycle]) -> list[Acceptance]:
        latest = next(cycle for cycle in reversed(cut.cycles) if cycle.level == new[-1].level)
        known, of_latest = self._force + _force_over(part, {*new, latest}), _force_over(part, [latest])
        self._force = self._force + _force_over(part, new)
        zero = float(known[0] / known[1])
        moved = float(of_latest[0] / of_latest[1]) - zero
        # the coil is on for the motion alone: what its voltage is outside of the cycles is not theirs
        inside = np.clip(np.arange(part.n), new[0].first, latest.last)
        if isinstance(part.voltage, np.ndarray):
            part = part.replace(note="the input of its cycles", voltage=part.voltage[inside])
        [part] = nominal_inputs([part], [test.input_value for test in self.tests if test.input_value is not None])
        values = self.planned.values(self.options.quantities)
        judged = judge_cut(part, cut, self.tests, replace(self.options, offset=zero), values)
        return [self._of_cycle(judged, cycle.number, moved) for cycle in new]

    def _of_cycle(self, judged: Acceptance, number: int, moved: float) -> Acceptance:
        """The judgement of one cycle: that by the zero so far, where that by the zero of the latest cycle is the same."""
        points = tuple(replace(p, cycle=self._before + number) for p in judged.points if p.cycle == number)
        shifted = tuple(
            p if p.quantity == "energy" else replace(p, inside=p.allows(p.measured - moved)) for p in points
        )
        reason = next((p.reason for p in points if p.reason), "")
        first, second = (replace(judged, points=some, levels=(), reason=reason) for some in (points, shifted))
        return first if first.verdict == second.verdict else replace(first, points=(), reason=TOO_CLOSE)


def _force_over(part: Record, cycles: Iterable[CutCycle]) -> Array:
    """The integral of the force over some cycles, N s, and how long they last, s."""
    steps = 0.5 * (part.force[1:] + part.force[:-1]) * np.diff(part.time)
    impulse = np.concatenate([[0.0], np.cumsum(steps)])
    edges = np.array([(cycle.start_s, cycle.stop_s) for cycle in cycles])
    return np.array([np.diff(np.interp(edges, part.time, impulse)).sum(), np.diff(edges).sum()])
