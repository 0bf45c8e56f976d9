"""Turning points and cycles on plateaus, drift, noise and harmonics, and on all real records."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import (
    Record,
    cut_cycles,
    cycle_average,
    cycle_bounds,
    cycle_table,
    describe,
    measure,
    read,
)
from dampyr.records.cycle_analysis.cycles import cut_part, legs, turning_points

FREQUENCY = 0.9


def true_turns(record: Record, rest: float, frequency: float) -> np.ndarray:
    k = np.arange(100)
    at = rest + (0.25 + 0.5 * k) / frequency
    return at[at < record.time[-1] - 0.3 / frequency]


@pytest.mark.parametrize(
    "fault",
    [
        {},
        {"third": -0.06},
        {"drift": 6e-4},
        {"drift": -6e-4, "amplitude": 2.5e-3},
        {"noise": 2e-4},
        {"quantum": 2e-4},
        {"quantum": 0.0},
        {"rest": 0.0},
    ],
    ids=str,
)
def test_every_turning_point_is_found_once(make_sine, fault):
    record = make_sine(**fault)
    at = record.time[turning_points(record)]
    truth = true_turns(record, fault.get("rest", 2.0), FREQUENCY)
    assert len(at) - len(truth) in (0, 1)  # the last one may or may not be far enough from the end
    assert np.max(np.abs(at[: len(truth)] - truth)) < (0.05 if fault.get("noise") else 0.02)


def test_turning_points_are_those_of_every_sample_looked_at() -> None:
    """Only extremes are looked at; here each sample is, on random walks, plateaus and rounded sines."""

    def plain(x: np.ndarray, threshold: float) -> list[int]:
        turns, low, high, direction = [], 0, 0, 0

        def middle(first: int, end: int) -> int:
            return (first + max(np.flatnonzero(x[first:end] == x[first])) + first) // 2

        for i, value in enumerate(x):
            high, low = (i if value > x[high] else high), (i if value < x[low] else low)
            if direction >= 0 and x[high] - value > threshold:
                turns += [middle(high, i)] if direction > 0 else []
                direction, low, high = -1, i, i
            elif direction <= 0 and value - x[low] > threshold:
                turns += [middle(low, i)] if direction < 0 else []
                direction, low, high = 1, i, i
        return turns

    rng = np.random.default_rng(0)
    for k in range(600):
        n = int(rng.integers(8, 80))
        walk = (
            np.cumsum(rng.integers(-2, 3, n)) if k % 2 else np.round(5 * np.sin(rng.uniform(0.1, 2.0) * np.arange(n)))
        )
        x = walk + (rng.normal(size=n) if k % 3 == 0 else 0.0)
        threshold = float(rng.choice([0.5, 1.0, 1.5, 2.5]))
        record = Record(np.arange(n) * 0.01, x.astype(float), np.zeros(n))
        assert turning_points(record, threshold).tolist() == plain(x, threshold)


def test_a_plateau_counts_once_and_in_its_middle():
    x = np.repeat([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0], 5) * 1e-3
    t = 0.01 * np.arange(len(x))
    points = turning_points(Record(t, x, x))
    assert points.tolist() == [17, 32, 47]


def test_ripple_below_the_threshold_is_no_turning_point(make_sine):
    record = make_sine()
    ripple = 2e-4 * np.sin(2 * np.pi * 17 * record.time)
    rippled = record.replace(note="ripple", displacement=record.displacement + ripple)
    assert len(turning_points(rippled)) == len(turning_points(record))
    assert len(turning_points(rippled, threshold=5e-5)) > 3 * len(turning_points(record))
    with pytest.raises(InputError, match=r"threshold = 0 m is not allowed"):
        turning_points(record, threshold=0.0)


def test_legs_are_peak_to_peak(make_sine):
    assert np.abs(legs(make_sine())) == pytest.approx(0.02, abs=2e-5)


def test_cycles_follow_on_one_another_and_last_one_period(make_sine):
    record = make_sine()
    record_cycles = cycle_bounds(record)
    assert len(record_cycles) == 11
    assert all(a[1] == b[0] for a, b in pairwise(record_cycles))
    assert [i1 - i0 for i0, i1 in record_cycles] == pytest.approx([111.1] * 11, abs=3)


def test_run_in_and_stop_are_left_out(make_sine):
    record = make_sine(duration=30.0, rest=0.0)
    taper = np.clip(record.time / 6.0, 0, 1) * np.clip((30.0 - record.time) / 6.0, 0, 1)
    tapered = record.replace(note="tapered", displacement=record.displacement * taper)
    record_cycles = cycle_bounds(tapered)
    assert record.time[record_cycles[0][0]] > 3.0
    assert record.time[record_cycles[-1][1]] < 27.0
    assert len(record_cycles) > 15


def test_no_motion_has_no_cycles():
    t = 0.01 * np.arange(100)
    still = Record(t, np.zeros(100), np.ones(100))
    assert len(turning_points(still)) == 0
    assert cycle_bounds(still) == []
    with pytest.raises(InputError, match=r"no whole cycle in 0.99 s, and a cycle average needs one"):
        cycle_average(still)


def test_cycle_average_is_the_cycle(make_sine):
    record = make_sine(quantum=0.0, duration=20.0, voltage=1.5)
    mean = cycle_average(record, samples=200)
    assert mean.duration == pytest.approx((1 - 1 / 200) / FREQUENCY, rel=3e-3)
    assert np.ptp(mean.displacement) == pytest.approx(0.02, rel=2e-3)
    assert np.mean(mean.force) == pytest.approx(120.0, abs=1.0)
    assert mean.voltage == 1.5
    assert "whole cycles" in mean.history[-1]
    with pytest.raises(InputError, match="samples = 4 is too few"):
        cycle_average(record, samples=4)


def test_all_real_records_have_regular_cycles(published):
    records = published
    assert len(records) == 39
    for record in records:
        points = turning_points(record)
        record_cycles = cycle_bounds(record)
        sizes = np.abs(np.diff(record.displacement[points]))
        assert np.all(np.diff(np.sign(np.diff(record.displacement[points]))) != 0), record.name
        assert sizes.min() > 0.75 * np.median(sizes), record.name
        assert sizes.max() < 1.25 * np.median(sizes), record.name
        lasting = np.diff(record.time[points])
        assert lasting.max() < 1.3 * np.median(lasting), record.name
        assert 4 <= len(record_cycles) <= 31, record.name
        assert record.duration - (record.time[record_cycles[-1][1]] - record.time[record_cycles[0][0]]) < 8.0, (
            record.name
        )


def in_levels(levels, shape="middle", rest=0.5, pause=0.0, hz=1.0, noise=0.0):
    """Levels (amplitude mm, cycles): from the middle position, or one-sided from the bottom."""
    pieces = [np.zeros(round(200 * rest))]
    for amplitude, count in levels:
        phase = 2 * np.pi * hz * np.arange(round(200 * count / hz)) / 200.0
        pieces += [
            1e-3 * amplitude * (np.sin(phase) if shape == "middle" else 1 - np.cos(phase)),
            np.zeros(round(200 * pause)),
        ]
    x = np.concatenate([*pieces, np.zeros(round(200 * rest) + 1)])
    x = x + noise * np.random.default_rng(0).standard_normal(len(x))
    return Record(np.arange(len(x)) / 200.0, x, 100.0 * np.sign(np.gradient(x)))


STEPS = {
    "rising": [(2, 3), (4, 3), (8, 3)],
    "falling": [(8, 3), (4, 3), (2, 3)],
    "FEMA 461": [(8 * 0.048 * 1.4**k, 2) for k in range(10)],
    "four of five": [(2, 5), (4, 5), (6, 5), (8, 5)],
    "80/100": [(6.4, 5), (8, 5)],
    "peak in the middle": [(4, 3), (8, 3), (4, 3)],
    "single cycle at the end": [(0.8, 3), (1.6, 3), (2.4, 3), (4, 2), (5.6, 2), (8, 1)],
    "one level": [(8, 3)],
}


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize("shape", ["middle", "bottom"])
@pytest.mark.parametrize(("rest", "pause"), [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0)])
def test_cycles_are_those_that_were_commanded_level_by_level(name, shape, rest, pause):
    levels = STEPS[name]
    made = cut_cycles(in_levels(levels, shape, rest, pause))
    assert [each.count for each in made.levels] == [count for _, count in levels]
    assert [1e3 * each.stroke_m for each in made.levels] == pytest.approx([2 * size for size, _ in levels], rel=0.01)
    assert [each.number for each in made.cycles] == list(range(1, len(made.cycles) + 1))
    assert made.run == len(made.cycles) == sum(count for _, count in levels)
    assert [one.stop_s - one.start_s for one in made.cycles] == pytest.approx([1.0] * len(made.cycles), abs=0.1)
    assert made.cycles[0].start_s == pytest.approx(rest, abs=0.03)
    for one, (first, second) in zip(
        made.cycles, zip(made.half_cycles[::2], made.half_cycles[1::2], strict=True), strict=True
    ):
        assert (first.start_s, second.stop_s, first.level) == (one.start_s, one.stop_s, one.level)


def test_half_cycles_are_kept_as_such_and_a_record_that_begins_in_full_motion_says_so(make_sine):
    made = cut_cycles(in_levels([(8, 2.5)]))
    assert (made.run, len(made.cycles), len(made.half_cycles), made.from_start) == (2.5, 2, 5, True)
    record = make_sine()
    part = slice(245, 1200)  # 0.13 of a cycle after the fourth pass
    begun = record.replace(note="later", **{c: getattr(record, c)[part] for c in ("time", "displacement", "force")})
    assert not cut_cycles(begun).from_start
    assert cut_cycles(record).from_start
    assert cut_cycles(record.replace(note="at rest", displacement=np.zeros(record.n))).cycles == ()


@pytest.mark.parametrize(("begins", "from_start"), [(0.0, True), (0.1, False)])
def test_a_record_that_begins_in_full_motion_says_so_where_it_turns_to_another_level_later(begins, from_start):
    """At 3 s the table goes on the other way, from where it stands: the second stretch has a start that is seen."""
    t = np.linspace(begins, 6.0, round((6.0 - begins) * 200) + 1)
    x = np.where(t < 3.0, 0.008, -0.004) * np.sin(2 * np.pi * t)
    made = cut_cycles(Record(t - t[0], x, x))
    assert len(made.levels) > 1
    assert made.from_start == from_start


def test_cycles_of_a_run_in_are_counted_and_belong_to_no_level(make_sine):
    record = make_sine(rest=1.0, duration=16.0)
    ramp = np.clip((record.time - 1.0) / (3.0 / FREQUENCY), 0.0, 1.0)
    made = cut_cycles(record.replace(note="ramp", displacement=record.displacement * ramp))
    assert [each.number for each in made.cycles if not each.level] == [1, 2, 3]
    assert [(each.first, each.last) for each in made.levels] == [(4, len(made.cycles))]


def test_a_force_that_fades_is_compared_with_the_third_cycle_from_the_start():
    """4 % of the first a cycle: the sixth has 0.80 and the third 0.92 of it."""
    record = in_levels([(8, 6)])
    passed = np.clip(np.floor(record.time - 0.5 + 1e-9), 0, 5)
    fading = record.replace(note="fades", force=record.force * (1.0 - 0.04 * passed))
    energies = np.array([one.energy for one in cycle_table(fading)])
    assert len(energies) == 6
    assert np.max(np.abs(energies / energies[2] - 1.0)) == pytest.approx(1.0 - 0.80 / 0.92, abs=2e-3)


def test_energy_per_cycle_is_of_whole_cycles_of_full_amplitude():
    """Three cycles between two ramps of three: friction dissipates four times force and amplitude, a ramp's cycle less."""
    t = np.arange(2001) / 200.0
    x = 0.01 * np.clip(np.minimum(t, 9.0 - t) / 3.0, 0.0, 1.0) * np.sin(2 * np.pi * t)
    record = Record(t, x, 100.0 * np.tanh(np.gradient(x, t) / 1e-5))
    assert measure(record).energy_per_cycle == pytest.approx(4 * 100.0 * 0.01, rel=0.005)
    assert measure(record).peak_to_peak_m == pytest.approx(0.02, rel=0.005)


def test_energy_per_cycle_of_a_measured_friction_damper():
    path = Path(__file__).parents[3] / "shared/findings/cases/brfd_friction_0.5Hz_0.5in.csv"
    if not path.is_file():
        pytest.skip(f"{path.name} is not here")
    assert measure(read(path)).energy_per_cycle == pytest.approx(531.0, abs=2.0)


def test_quasi_static_loops_of_rising_amplitude_get_no_hints_of_smoothing_or_noise():
    """Digitised points, joined by straight lines and resampled 20 times as fine: what a moving average of 20 leaves, too."""
    rng = np.random.default_rng(0)
    x = [0.0]
    for amplitude in np.linspace(5.0, 60.0, 8):
        for target in (amplitude, -amplitude, 0.0):
            steps = rng.uniform(0.4, 1.6, max(int(abs(target - x[-1]) / 3.0), 6))
            x += list(x[-1] + np.cumsum(steps / steps.sum()) * (target - x[-1]))
    x, w, force = 1e-3 * np.array(x), 0.0, [0.0]
    for dx in np.diff(x):
        w = np.sign(dx) + (w - np.sign(dx)) * np.exp(-400.0 * abs(dx))
        force.append(1e5 * w)
    fine = np.arange(0.0, len(x) - 1.0, 0.05)
    values = [np.interp(fine, np.arange(len(x)), each) for each in (x, np.array(force))]
    loops = Record(
        np.arange(len(fine)) * 1.0, np.round(values[0], 7), np.round(values[1] + rng.normal(0.0, 20.0, len(fine)), -1)
    )
    about = describe(loops)
    assert about["smoothing"] == ()
    assert [one.words for one in loops.findings] == [
        "strokes that rise or fall from cycle to cycle: 8 whole cycles of 8, 10 to 120 mm peak to peak"
    ]
    assert [each["cycles"] for each in about["levels"]] == [1] * 8
    rising = in_levels(STEPS["rising"])
    stepped = describe(rising)
    assert "3 levels, 9 whole cycles of 9, 4 to 16 mm peak to peak" in [one.words for one in rising.findings]
    assert stepped["smoothing"] == ()
    assert [each["energy_per_cycle"] for each in stepped["levels"]] == pytest.approx([0.8, 1.6, 3.2], rel=0.02)


@pytest.mark.parametrize("phase", [0.0, 0.4, -0.5 * np.pi])
def test_a_later_part_is_cut_where_the_whole_is_cut(phase):
    """Motions that begin at the mean position, beside it and at a turning point, and drift; but for the first and last cycles,
    which have fewer neighbours."""
    t = np.arange(0.0, 24.0, 0.005)
    moving = np.clip(t - 1.0, 0.0, 20.0)
    x = 0.01 * np.sin(2 * np.pi * moving + phase) + 1e-4 * moving
    record = Record(t, x, x)
    whole, away = cut_part(record)
    assert whole == cut_cycles(record)
    assert np.isnan(away) == (phase == -0.5 * np.pi)
    start = whole.cycles[7].first
    part, _ = cut_part(record.sliced(slice(start, None), "a later part"), away)
    assert len(part.cycles) == len(whole.cycles) - 7
    for cycle, same in zip(part.cycles[2:-1], whole.cycles[9:-1], strict=True):
        assert (cycle.start_s, cycle.stop_s) == pytest.approx((same.start_s, same.stop_s), abs=1e-3)
        assert (cycle.first + start, cycle.last + start) == (same.first, same.last)
