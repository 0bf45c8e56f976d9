"""Sweep: as many octaves in every second, up and down."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def crossings(t, x):
    """Times at which x rises through 0."""
    k = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    return t[k] - x[k] * (t[k + 1] - t[k]) / (x[k + 1] - x[k])


def test_a_sweep_changes_its_frequency_by_as_many_octaves_every_second():
    step = kind("sweep")(0.005, 0.5, 4.0, duration=30.0, rest_before=1.0, period=0.001)
    drive = step.drive(RIG)
    t = np.arange(drive.n) * drive.period
    at = crossings(t, drive.displacement)
    frequency, middle = 1 / np.diff(at), 0.5 * (at[1:] + at[:-1]) - 1.0 - 2 / 0.5
    inside = (middle > 1.0) & (middle < step.swept - 1.0)
    np.testing.assert_allclose(frequency[inside], 0.5 * 8.0 ** (middle[inside] / step.swept), rtol=4e-3)
    assert step.swept == pytest.approx(30.0, rel=0.01)


def test_a_sweep_may_run_down():
    drive = kind("sweep")(0.005, 4.0, 0.5, duration=10.0).drive(RIG)
    at = crossings(np.arange(drive.n) * drive.period, drive.displacement)
    assert np.diff(at)[2] < 0.3 < 1.5 < np.diff(at)[-2]


def test_its_peak_speed_is_that_of_the_highest_frequency():
    step = kind("sweep")(0.005, 0.5, 4.0, duration=20.0, period=0.001)
    x = step.drive(RIG).displacement
    assert (step.peaks(RIG).position, step.peaks(RIG).speed) == pytest.approx((0.005, 2 * np.pi * 4.0 * 0.005))
    assert np.abs(x).max() == pytest.approx(0.005, rel=1e-3)
    assert np.abs(np.diff(x)).max() / 0.001 == pytest.approx(step.peaks(RIG).speed, rel=0.01)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.01, "start": 1.0, "stop": 1.0}, "use the kind sine"),
        ({"amplitude": 0.01, "start": 0.1, "stop": 0.2, "duration": 5.0}, "less than 2 cycles"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("sweep")(**settings)
