"""Low velocity: cycles at constant speeds in their order."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_low_speeds_come_in_their_order():
    drive = kind("low_velocity")(0.002, speeds=(0.001, 0.004), rest_before=0.0).drive(RIG)
    speeds = np.abs(np.diff(drive.displacement)) / drive.period
    assert speeds[: drive.n // 2].max() == pytest.approx(0.001)
    assert speeds.max() == pytest.approx(0.004)


def test_its_peaks_are_the_amplitude_and_the_highest_speed():
    peaks = kind("low_velocity")(0.002, speeds=(0.004, 0.001)).peaks(RIG)
    assert (peaks.position, peaks.speed) == (0.002, 0.004)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"speeds": ()}, "speeds is empty"),
        ({"speeds": (0.001, 0.0)}, "speeds"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("low_velocity")(**settings)
