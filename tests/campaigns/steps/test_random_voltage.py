"""Random voltage: levels that fill their range."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_random_levels_fill_their_range_and_stay_in_it():
    drive = kind("random_voltage")(0.005, 0.5, high=3.0, low=1.0, cycles=50, hold=0.2, seed=4).drive(RIG)
    levels = drive.voltage[drive.voltage > 0]
    assert 1.0 <= levels.min() < 1.05
    assert 2.95 < levels.max() <= 3.0
    assert levels.mean() == pytest.approx(2.0, abs=0.1)


def test_its_motion_is_the_sine_and_its_peaks_too():
    step = kind("random_voltage")(0.005, 0.5, high=3.0, cycles=4, rest_before=1.0)
    drive = step.drive(RIG)
    t = np.arange(drive.n) * drive.period - 1.0
    steady = (t >= 2.0) & (t <= 10.0)
    np.testing.assert_allclose(drive.displacement[steady], 0.005 * np.sin(np.pi * t[steady]), atol=1e-12)
    assert not drive.voltage[(t < 1.99) | (t > 10.01)].any()
    assert (step.peaks(RIG).position, step.peaks(RIG).speed) == pytest.approx((0.005, np.pi * 0.005))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.01, "frequency": 1.0, "high": 1.0, "low": 2.0}, "exchange them"),
        ({"amplitude": 0.01, "frequency": 1.0, "high": 1.0, "hold": 0.005}, "hold longer"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("random_voltage")(**settings)
