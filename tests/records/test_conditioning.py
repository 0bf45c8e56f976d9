"""Offset, drift and delay: estimated from whole cycles, corrected only when asked, kept in the history."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, correct_delay, estimate_delay, remove_drift, remove_offset
from dampyr.records.conditioning.drift import drift
from dampyr.records.conditioning.force_offset import mean_force


def test_the_offset_is_the_mean_over_whole_cycles_not_over_the_record(make_sine):
    record = make_sine(rest=4.0, offset=120.0)
    at_rest = record.replace(note="gas", force=np.where(record.time < 4.0, 70.0, record.force))
    assert abs(np.mean(at_rest.force) - 120.0) > 10
    assert mean_force(at_rest) == pytest.approx(120.0, abs=0.5)
    removed = remove_offset(at_rest)
    assert mean_force(removed) == pytest.approx(0.0, abs=1e-9)
    assert float(removed.provenance["force_offset_n"]) == mean_force(at_rest)
    assert "mean over whole cycles" in removed.history[-1]
    assert remove_offset(record, 100.0).force == pytest.approx(record.force - 100.0)


def test_uneven_sampling_does_not_bias_the_offset(make_sine):
    record = make_sine(duration=30.0, dt=0.002)
    selected = np.flatnonzero(
        (record.force > 120.0) | (np.arange(record.n) % 5 == 0)
    )  # the upper half sampled more often
    thinned = Record(record.time[selected], record.displacement[selected], record.force[selected])
    assert mean_force(thinned) == pytest.approx(120.0, abs=1.0)
    assert abs(np.mean(thinned.force) - 120.0) > 20


@pytest.mark.parametrize("slope", [6e-4, -3e-4, 0.0])
def test_drift_is_measured_and_removed_when_asked(make_sine, slope):
    record = make_sine(drift=slope, duration=30.0)
    assert drift(record) == pytest.approx(slope, abs=5e-6)
    straight = remove_drift(record)
    assert drift(straight) == pytest.approx(0.0, abs=2e-6)
    assert "drift of" in straight.history[-1]


@pytest.mark.parametrize("lag", [-0.010, 0.0, 0.012, 0.030])
def test_the_lag_of_a_dashpot_is_its_delay(make_sine, lag):
    delay_estimate = estimate_delay(make_sine(lag=lag, duration=20.0))
    assert delay_estimate.seconds == pytest.approx(lag, abs=6e-4)
    assert delay_estimate.spread < 2e-3
    assert "upper bound" in str(delay_estimate)


def test_a_wrong_offset_parts_the_two_sides_and_leaves_the_lag(make_sine):
    record = make_sine(lag=0.012, duration=20.0, third=0.0)
    even_harmonic = record.replace(
        note="a spring", force=record.force + 15.0 * np.cos(4 * np.pi * 0.9 * (record.time - 2.0))
    )
    delay_estimate = estimate_delay(even_harmonic)
    assert abs(delay_estimate.after_upper - delay_estimate.after_lower) > 0.01
    assert delay_estimate.seconds == pytest.approx(0.012, abs=2e-3)


def test_correcting_moves_the_motion_and_leaves_the_force(make_sine):
    record = make_sine(lag=0.025, duration=20.0, quantum=0.0, voltage=1.0)
    fixed = correct_delay(record, 0.025)
    assert set(fixed.force) <= set(record.force)
    assert fixed.n == record.n - 3
    assert fixed.voltage == 1.0
    assert estimate_delay(fixed).seconds == pytest.approx(0.0, abs=6e-4)
    assert "delayed by 0.025 s" in fixed.history[-1]
    with pytest.raises(InputError, match=r"seconds = 50 s is not a possible delay of a record of 20 s"):
        correct_delay(record, 50.0)


def test_a_force_without_a_sign_change_has_no_lag(make_sine):
    record = make_sine()
    with pytest.raises(InputError, match="does not change sign"):
        estimate_delay(record.replace(note="dead cell", force=np.full(record.n, 7.0)))


def test_the_real_records_lag_18_to_46_ms(published_fits):
    lags = [estimate_delay(record) for record in published_fits]
    assert min(lag.seconds for lag in lags) == pytest.approx(0.0165, abs=0.002)
    assert max(lag.seconds for lag in lags) == pytest.approx(0.048, abs=0.003)
    assert all(lag.spread < 0.004 for lag in lags)


def test_the_real_offsets_and_drifts(published_fits):
    records = published_fits
    offsets = [mean_force(record) for record in records]
    assert 102 < min(offsets) < 110
    assert 138 < max(offsets) < 142
    assert 4e-4 < max(abs(drift(record)) for record in records) < 6.5e-4
