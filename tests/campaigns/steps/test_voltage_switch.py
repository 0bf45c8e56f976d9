"""Voltage switch: a rise and a fall in either direction, each within a stroke of constant speed."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_the_voltage_rises_and_falls_in_both_directions_at_full_speed():
    drive = kind("voltage_switch")(0.012, 0.03, 2.0, low=0.5, rounds=2, rest_before=0.5, period=0.001).drive(RIG)
    assert set(drive.voltage) == {0.5, 2.0}
    places = np.flatnonzero(np.diff(drive.voltage))
    speed = np.gradient(drive.displacement, drive.period)[places]
    assert np.abs(speed) == pytest.approx(np.full(8, 0.03), rel=1e-6)
    found = list(zip(np.diff(drive.voltage)[places] > 0, speed > 0, strict=True))
    assert found == [(True, True), (False, False), (True, False), (False, True)] * 2
    assert drive.displacement[[0, -1]].tolist() == [0.0, 0.0]
    assert np.max(np.abs(drive.displacement)) == pytest.approx(0.012)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.012, "speed": 0.03, "high": 1.0, "low": 1.0}, "high = 1 V must be above low = 1 V"),
        ({"amplitude": 0.002, "speed": 0.05, "high": 1.0}, "too short for 50 mm/s"),
        ({"amplitude": 0.012, "speed": 0.03, "high": 1.0, "share": 0.9}, "share = 0.9"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("voltage_switch")(**settings)
