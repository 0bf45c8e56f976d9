"""Turning points and cycles on plateaus, drift, noise and harmonics, and on all real records."""

from itertools import pairwise

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, cycle_average, cycles, legs, read_campaign, turning_points

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
    record_cycles = cycles(record)
    assert len(record_cycles) == 11
    assert all(a[1] == b[0] for a, b in pairwise(record_cycles))
    assert [i1 - i0 for i0, i1 in record_cycles] == pytest.approx([111.1] * 11, abs=3)


def test_run_in_and_stop_are_left_out(make_sine):
    record = make_sine(duration=30.0, rest=0.0)
    taper = np.clip(record.time / 6.0, 0, 1) * np.clip((30.0 - record.time) / 6.0, 0, 1)
    tapered = record.replace(note="tapered", displacement=record.displacement * taper)
    record_cycles = cycles(tapered)
    assert record.time[record_cycles[0][0]] > 3.0
    assert record.time[record_cycles[-1][1]] < 27.0
    assert len(record_cycles) > 15


def test_no_motion_has_no_cycles():
    t = 0.01 * np.arange(100)
    still = Record(t, np.zeros(100), np.ones(100))
    assert len(turning_points(still)) == 0
    assert cycles(still) == []
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


def test_all_real_records_have_regular_cycles(campaign_folder):
    records = read_campaign(campaign_folder, role=None)
    assert len(records) == 39
    for record in records:
        points = turning_points(record)
        record_cycles = cycles(record)
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
