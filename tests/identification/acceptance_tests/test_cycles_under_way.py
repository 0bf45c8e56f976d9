"""Cycles of a test that is under way, beside what `accept` says of the whole record."""

import numpy as np
import pytest
from tests.identification.sine_levels import RATE, force_of, motion

from dampyr.identification import AcceptOptions, accept
from dampyr.identification.acceptance_tests.acceptance import Acceptance
from dampyr.identification.acceptance_tests.cycles_under_way import TOO_CLOSE, CyclesUnderWay
from dampyr.identification.acceptance_tests.reference_cycles import ReferenceTest
from dampyr.records import Record


def played(record: Record, reference: Record, block: int) -> list[Acceptance]:
    """The cycles that were judged, as ever more of the record comes."""
    test = ReferenceTest.of(reference)
    cycles, first, judged = CyclesUnderWay([test], test, AcceptOptions()), 0, []
    for last in [*range(block, record.n, block), record.n]:
        new, dropped = cycles.judge(record.sliced(slice(first, last), "what has come"))
        judged += new
        first += dropped
    return judged


def verdicts(record: Record, reference: Record) -> dict[int, bool | None]:
    """What `accept` says of each cycle: False where a value lies outside, None where one is not judged."""
    [judged] = accept(record, reference).results
    inside: dict[int, list[bool | None]] = {}
    for p in judged.points:
        inside.setdefault(p.cycle, []).append(p.inside)
    return {cycle: False if False in values else None if None in values else True for cycle, values in inside.items()}


LEVELS = ((0.006, 1.0, 14), (0.006, 1.5, 16), (0.006, 2.2, 12))


def noisy(seed: int, drift: float) -> tuple[Record, Record]:
    """A record and its reference."""
    random, (time, x) = np.random.default_rng(seed), motion(*LEVELS)
    force, noise = force_of(time, x), random.normal(0.0, 8.0, (2, time.size))
    reference = Record(time, x, force + noise[0], voltage=0.9, name="a")
    faded = np.linspace(1.25, 0.75, time.size) * force + 60.0 + drift * time + noise[1]
    return reference.replace(note="another specimen", force=faded), reference


@pytest.mark.parametrize("block", [125, 700])
@pytest.mark.parametrize("drift", [0.0, 0.3])
@pytest.mark.parametrize("seed", [1, 3])
def test_what_is_counted_is_what_accept_says_of_the_whole_record(block: int, drift: float, seed: int) -> None:
    """Three levels, noise, a load cell that is not zeroed, and a damper that fades from too strong to too weak. Only a cycle at
    the very edge may be judged otherwise at the end, within 1 % of half the band, or 5 % where the zero drifts (N/s)."""
    record, reference = noisy(seed, drift)
    cycles = played(record, reference, block)
    whole = verdicts(record, reference)
    counted = {cycle.points[0].cycle: cycle.passed for cycle in cycles if cycle.passed is not None}
    assert list(counted) == sorted(counted)
    assert set(counted.values()) == {True, False}
    [judged] = accept(record, reference).results
    for number in {number for number, passed in counted.items() if whole[number] is not passed}:
        points = [p for p in judged.points if p.cycle == number]
        beyond = max(abs(p.used) - 1.0 - p.allowance / (p.high - p.expected) for p in points)
        assert beyond == pytest.approx(0.0, abs=0.05 if drift else 0.01)
    allowed = {(p.cycle, p.quantity): p.allowance for p in judged.points}
    shares = [p.allowance / allowed[p.cycle, p.quantity] for cycle in cycles for p in cycle.points]
    assert np.mean(shares) == pytest.approx(1.0, abs=0.05)
    assert len(whole) - len(counted) <= 2  # too close to the edge of the band while the zero moves


@pytest.mark.parametrize("away", [0.0, 0.003, -0.008])
def test_cycles_are_cut_where_accept_cuts_them(away: float) -> None:
    """Motions that begin at the mean position, beside it and at a turning point; with noise, before they begin too."""
    rest, phase = np.zeros(1000), np.arange(0.0, 30.0, 1.0 / RATE)
    x = np.concatenate([rest, 0.008 * np.sin(2.0 * np.pi * phase + np.arcsin(away / 0.008)) - away, rest])
    time, random = np.arange(x.size) / RATE, np.random.default_rng(4)
    noisy_x = x + random.normal(0.0, 2e-5, x.size)
    reference = Record(time, noisy_x, force_of(time, x), voltage=0.9, name="a")
    record = reference.replace(note="stronger", force=1.1 * reference.force + 20.0)
    live = [p for cycle in played(record, reference, 125) for p in cycle.points]
    [judged] = accept(record, reference).results
    assert [(p.cycle, p.quantity) for p in live] == [(p.cycle, p.quantity) for p in judged.points]
    for one, other in zip(live, judged.points, strict=True):
        assert one.speed == pytest.approx(other.speed, rel=1e-3)
        assert one.measured == pytest.approx(other.measured, rel=1e-3 if one.quantity == "energy" else 0.02)


def test_a_cycle_that_another_zero_would_judge_otherwise_is_left_open() -> None:
    """The load cell jumps by 20 N, a tenth of the half band, after the fourth cycle of a damper at the edge of its band."""
    time, x = motion((0.008, 1.0, 12))
    reference = Record(time, x, force_of(time, x), voltage=0.9, name="a")
    force = 1.149 * reference.force + np.where(time < 6.0, 0.0, 20.0)
    judged = played(reference.replace(note="stronger", force=force), reference, 125)
    assert [cycle.verdict for cycle in judged[:3]] == ["passed"] * 3
    assert [(cycle.verdict, cycle.reason) for cycle in judged[4:6]] == [("not judged", TOO_CLOSE)] * 2


@pytest.mark.parametrize(
    ("begin", "cycles_of_growth", "power", "off"), [(2.0, 1, 2, 0), (2.0, 8, 2, 0), (0.0, 10, 1, 1)]
)
def test_a_motion_that_grows_is_numbered_as_in_the_whole_record(
    begin: float, cycles_of_growth: int, power: int, off: int
) -> None:
    """Its first legs count as cycles as long as nothing greater has come. Where it grows over many, which legs count is known
    only later: the cycles may be cut half a cycle earlier, and the numbers be one off; what is measured is the same."""
    time, x = motion((0.008, 2.0, 30))
    x = x * np.sin(0.5 * np.pi * np.clip((time - begin) / (0.5 * cycles_of_growth), 0.0, 1.0)) ** power
    reference = Record(time, x, force_of(time, x), voltage=0.9, name="a")
    judged = played(reference.replace(note="stronger", force=1.05 * reference.force), reference, 20)
    numbers = [cycle.points[0].cycle for cycle in judged]
    whole = {
        p.cycle for p in accept(reference.replace(note="", force=1.05 * reference.force), reference).results[0].points
    }
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert (numbers[0], numbers[-1]) == pytest.approx((min(whole), max(whole)), abs=off)
    for cycle in judged[off : len(judged) - off]:
        assert [p.deviation for p in cycle.points] == pytest.approx([0.05] * 3, abs=0.015)


def test_the_last_cycle_is_judged_when_no_other_follows() -> None:
    time, x = motion((0.008, 1.0, 5))
    reference = Record(time, x, force_of(time, x), voltage=0.9, name="a")
    record = reference.replace(note="stronger", force=1.05 * reference.force)
    for rest, last in ((0.5, 4), (1.5, 5)):
        part = record.until(float(time[-1]) - 2.0 + rest)
        assert played(part, reference, 125)[-1].points[0].cycle == last
