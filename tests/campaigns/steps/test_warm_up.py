"""Warm-up: cycles that end early at a temperature."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_a_warm_up_ends_at_its_temperature_and_other_steps_do_not():
    assert kind("warm_up")(0.005, 1.0, temperature=35.0).drive(RIG).until_temperature == 35.0
    assert kind("warm_up")(0.005, 1.0).drive(RIG).until_temperature is None


def test_its_path_and_peaks_are_those_of_a_sine():
    step = kind("warm_up")(0.005, 1.0, 2.0, cycles=3, temperature=35.0)
    sine = kind("sine")(0.005, 1.0, 2.0, cycles=3)
    np.testing.assert_array_equal(step.drive(RIG).displacement, sine.drive(RIG).displacement)
    assert np.all(step.drive(RIG).voltage == 2.0)
    assert (step.peaks(RIG).position, step.peaks(RIG).speed) == pytest.approx((0.005, 2 * np.pi * 0.005))
