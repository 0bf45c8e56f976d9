"""Lag of the force: the delay of a dashpot, upper bound of a damper's, and its correction."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import correct_delay, estimate_delay


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
