"""A test that is played block by block beside the same test of an earlier run, and what `accept` says of its record."""

import numpy as np
import pytest
from tests.identification.sine_levels import RATE, force_of, motion

from dampyr.campaigns.run_control import Progress
from dampyr.console import bench_reference
from dampyr.console.bench_reference import Comparison, EarlierRun, JudgedCycle, LiveComparison
from dampyr.identification import accept
from dampyr.identification.acceptance_tests.cycles_under_way import CyclesUnderWay
from dampyr.records import Record
from dampyr.rig.interlock import Samples

BLOCK = 40


def played(
    record: Record, run: EarlierRun, tolerance: float = 0.15, delay: float = 0.0, block: int = BLOCK
) -> tuple[Comparison, list[JudgedCycle], int]:
    """The comparison at the end, all cycles that were counted, and the most samples that were held."""
    live, cycles, most = LiveComparison(Comparison("earlier", tolerance, record.name)), [], 0
    volts = np.broadcast_to(record.voltage, record.n)
    for first in range(0, record.n, block):
        part = slice(first, first + block)
        none = np.zeros((1, record.time[part].size))
        samples = Samples(
            first, record.time[part], record.displacement[part], record.force[part], None, none, none[0].astype(int),
            volts[part], None,
        )  # type: ignore[arg-type]  # fmt: skip
        before = live.comparison.passed + live.comparison.failed
        ends = (first + block) / record.n
        live.take(Progress(0, 1, record.name, "testing", min(1.0, ends), samples=samples, force_delay=delay), run)
        new = live.comparison.passed + live.comparison.failed - before
        cycles += live.comparison.cycles[-new:] if new else ()
        most = max(most, sum(held.shape[1] for held in live._blocks))
    return live.comparison, cycles, most


def earlier(*records: Record) -> EarlierRun:
    return EarlierRun.of(records)


@pytest.mark.parametrize(("factor", "passes"), [(1.0, True), (1.1, True), (1.25, False), (0.8, False)])
@pytest.mark.parametrize("centre", [0.0, 0.005])
def test_a_cycle_passes_within_the_tolerance(factor: float, passes: bool, centre: float) -> None:
    """Cycles are numbered as `accept` numbers them, and their values are its own but for the zero."""
    time, x = motion((0.01, 1.0, 8), taper=True)
    reference = Record(time, x + centre, force_of(time, x), voltage=0.0, name="a")
    record = reference.replace(note="another specimen", force=factor * reference.force + 50.0)
    comparison, cycles, _ = played(record, earlier(reference))
    [judged] = accept(record, reference).results
    assert [cycle.number for cycle in cycles] == [2, 3, 4, 5, 6] == sorted({p.cycle for p in judged.points})
    assert all(cycle.passed is passes for cycle in cycles)
    assert (comparison.passed, comparison.failed, comparison.reason) == (5 * passes, 5 * (not passes), "")
    for cycle in cycles:
        of_cycle = {p.quantity: p.deviation for p in judged.points if p.cycle == cycle.number}
        assert cycle.energy == pytest.approx(of_cycle["energy"], abs=1e-4)
        assert cycle.extension == pytest.approx(of_cycle["extension"], abs=0.01)
        # the zero moves the two forces against each other
        forces = of_cycle["extension"] + of_cycle["compression"]
        assert cycle.extension + cycle.compression == pytest.approx(forces, abs=1e-3)


def test_the_displacement_is_taken_on_the_clock_of_the_force() -> None:
    """As in a record, whose displacement is read so much earlier."""
    time, x = motion((0.008, 2.0, 12))
    later = np.interp(time - 0.02, time, x)
    reference = Record(time, later, force_of(time, later), voltage=0.9, name="a")
    as_read = reference.replace(note="as it is read", displacement=x)
    _, cycles, _ = played(as_read, earlier(reference), delay=0.02)
    assert [cycle.energy for cycle in cycles] == pytest.approx([0.0] * len(cycles), abs=1e-3)
    _, cycles, _ = played(as_read, earlier(reference))
    assert max(cycle.energy for cycle in cycles) < -0.01


@pytest.mark.parametrize(
    ("volts", "counted", "reason"),
    [
        (lambda t: np.where((t < 0.5) | (t > 14.0), 0.0, 0.9), 10, ""),
        (lambda t: np.where(t < 7.0, 0.9, 0.4), 4, "no reference at this input: 0.4 V here, 0.9 V there"),
        (lambda t: np.full(t.size, np.nan), 0, "voltage[0] = nan V is not finite"),
    ],
    ids=["the coil is on for the motion", "another voltage", "no number"],
)
def test_what_cannot_be_judged_says_why_as_accept_does(volts: object, counted: int, reason: str) -> None:
    time, x = motion((0.008, 1.0, 11))
    reference = Record(time, x, force_of(time, x), voltage=0.9, name="a")
    live = reference.replace(note="as it is read", voltage=0.0)
    object.__setattr__(live, "voltage", volts(time))
    comparison, cycles, _ = played(live, earlier(reference))
    assert len(cycles) == pytest.approx(counted, abs=1)
    assert reason in comparison.reason
    assert bool(comparison.reason) is bool(reason)


def test_a_motion_without_levels_is_not_compared() -> None:
    random = np.random.default_rng(1).normal(0.0, 1.0, 10_000)
    x = 0.004 * np.convolve(random, np.hanning(400) / 20.0, "same")
    time = np.arange(x.size) / RATE
    reference = Record(time, x, force_of(time, x), voltage=0.9, name="a")
    comparison, cycles, most = played(reference, earlier(reference))
    twice = reference.replace(note="stronger", force=2.0 * reference.force)
    assert (cycles, most) == ([], 0)
    assert comparison.reason == accept(reference, twice).results[0].reason


def test_the_cost_of_a_block_does_not_grow_with_the_test(monkeypatch: pytest.MonkeyPatch) -> None:
    """How many samples are cut for each that comes, and how many are held."""
    cut: list[int] = []
    judge = CyclesUnderWay.judge
    monkeypatch.setattr(CyclesUnderWay, "judge", lambda cycles, part: cut.append(part.n) or judge(cycles, part))
    for count in (20, 100):
        cut.clear()
        time, x = motion((0.008, 2.0, count))
        record = Record(time, x, force_of(time, x), voltage=0.9, name="a")
        comparison, _, most = played(record, earlier(record))
        assert comparison.passed >= count - 1
        assert sum(cut) < 12 * record.n
        assert most < 5.0 * RATE


def test_a_cycle_without_an_end_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_reference, "MAX_SAMPLES", 3000)
    time, x = motion((0.008, 1.0, 4))
    record = Record(time, x, force_of(time, x), voltage=0.9, name="a")
    still = record.replace(note="it stops", time=10.0 * time, displacement=np.where(time < 3.2, x, x[1600]))
    comparison, cycles, most = played(still, earlier(record))
    assert ([cycle.number for cycle in cycles], comparison.reason) == ([], "a cycle has not ended after 3000 samples")
    assert most <= 3000
