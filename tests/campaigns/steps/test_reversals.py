"""Reversals: the way of an unloaded actuator under its timed duty."""

import numpy as np
import pytest

from dampyr.campaigns.check import violations_of
from dampyr.campaigns.force_prediction import course
from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def limits(step, settings=RIG, damper=None):
    return [each.limit for each in violations_of(step, settings, damper)]


def test_reversals_go_as_far_as_an_unloaded_actuator_does():
    """The area under the duty of one stroke: half of rise and fall, and all of the pause."""
    step = kind("reversals")(0.4, duty=0.5, pause=0.1, count=4, period=0.001)
    x = course(step.drive(RIG), RIG, None).x
    assert x.max() == pytest.approx(0.5 * 0.078 * (0.2 + 0.1), rel=0.01)
    assert step.peaks(RIG).position == pytest.approx(0.5 * 0.078 * 0.3)
    assert x[-1] == pytest.approx(0.0, abs=1e-4)
    assert limits(kind("reversals")(0.8, pause=0.1)) == ["stroke"]
    assert limits(kind("reversals")(0.8, pause=0.05)) == []


def test_its_set_points_stand_while_the_motor_is_timed():
    step = kind("reversals")(0.4, duty=0.5, pause=0.1, count=4, rest_before=1.0, voltage=2.0)
    drive = step.drive(RIG)
    assert not drive.displacement.any()
    assert np.all(drive.voltage == 2.0)
    assert drive.duration == pytest.approx(1.0 + 4 * 0.5 + 0.5)
    assert step.peaks(RIG).speed == pytest.approx(0.5 * RIG.actuator.free_speed)
    with pytest.raises(InputError, match=r"the reversals take .* min, at most 600 min are drawn; shorten them"):
        kind("reversals")(60.0, count=10_000).drive(RIG)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"half_period": 0.3, "duty": 1.5}, "duty = 1.5"),
        ({"half_period": 0.3, "count": 1}, "count = 1"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("reversals")(**settings)
