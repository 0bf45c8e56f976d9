"""Voltage steps: levels over whole cycles of a sine."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.campaigns.paths import AFTER
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_the_levels_of_voltage_steps_stand_over_whole_cycles_of_the_sine():
    step = kind("voltage_steps")(0.01, 0.5, voltages=(1.0, 2.0), hold=4.0, rest_before=1.0)
    drive = step.drive(RIG)
    on = np.flatnonzero(drive.voltage > 0) * drive.period
    assert on[0] == pytest.approx(3.0, abs=0.01)
    assert on[-1] - on[0] == pytest.approx(8.0, abs=0.02)
    assert drive.duration == pytest.approx(1.0 + 2.0 + 8.0 + 2.0 + AFTER, abs=0.01)


def test_its_peaks_are_those_of_the_sine():
    peaks = kind("voltage_steps")(0.01, 0.5, voltages=(1.0,)).peaks(RIG)
    assert (peaks.position, peaks.speed) == pytest.approx((0.01, np.pi * 0.01))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.01, "frequency": 1.0, "voltages": ()}, "voltages is empty"),
        ({"amplitude": 0.01, "frequency": 1.0, "voltages": (1.0,), "hold": 0.0}, "hold = 0 s"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("voltage_steps")(**settings)
