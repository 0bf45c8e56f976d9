"""Rest: a table that stands at a voltage for so long."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def times(drive):
    return np.arange(drive.n) * drive.period


def test_nothing_moves_at_the_voltage_for_the_duration():
    step = kind("rest")(3.0, 1.5)
    drive = step.drive(RIG)
    assert drive.duration == pytest.approx(3.0)
    assert not drive.displacement.any()
    assert np.all(drive.voltage == 1.5)
    assert (step.peaks(RIG).position, step.peaks(RIG).speed) == (0.0, 0.0)


def test_a_rest_is_for_validation_and_keeps_its_place():
    assert kind("rest").role == "validation"
    assert kind("rest").fixed
    with pytest.raises(InputError, match="duration = 0 s"):
        kind("rest")(0.0)
