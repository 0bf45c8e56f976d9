"""Drift of the displacement: measured from whole cycles and removed when asked."""

import pytest

from dampyr.records import remove_drift
from dampyr.records.conditioning.drift import drift


@pytest.mark.parametrize("slope", [6e-4, -3e-4, 0.0])
def test_drift_is_measured_and_removed_when_asked(make_sine, slope):
    record = make_sine(drift=slope, duration=30.0)
    assert drift(record) == pytest.approx(slope, abs=5e-6)
    straight = remove_drift(record)
    assert drift(straight) == pytest.approx(0.0, abs=2e-6)
    assert "drift of" in straight.history[-1]


def test_the_real_drifts(published_fits):
    assert 4e-4 < max(abs(drift(record)) for record in published_fits) < 6.5e-4
