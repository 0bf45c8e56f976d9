"""Quasi-static cycles: a triangle at a constant speed, with short ramps at its turns."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.campaigns.paths import AFTER, GLIDE
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def times(drive):
    return np.arange(drive.n) * drive.period


def test_the_table_goes_from_turn_to_turn_at_the_speed():
    """A move of the distance d at the speed v takes d/v and the ramp of 0.1 s."""
    step = kind("quasi_static")(0.004, 0.002, 1.0, cycles=2, rest_before=1.0)
    drive = step.drive(RIG)
    assert drive.duration == pytest.approx(1.0 + 2 * (2.0 + 0.1) + 3 * (4.0 + 0.1) + AFTER, abs=0.02)
    speeds = np.diff(drive.displacement) / drive.period
    assert np.abs(speeds).max() == pytest.approx(0.002)
    at_speed = np.isclose(np.abs(speeds), 0.002)
    moving = (2 * (2.0 - 0.1) + 3 * (4.0 - 0.1)) / drive.period
    assert at_speed.sum() == pytest.approx(moving, abs=10)
    assert (drive.displacement.max(), drive.displacement.min()) == pytest.approx((0.004, -0.004), abs=1e-8)


def test_its_steady_cycles_go_from_turn_to_turn_and_back():
    step = kind("quasi_static")(0.004, 0.010, 1.0, cycles=4, centre=0.002, rest_before=1.0, period=0.001)
    steady, drive = step.steady_cycles, step.drive(RIG)
    assert (steady.period, steady.count) == (pytest.approx(2 * (0.8 + 0.1)), 3)
    turns = steady.begin + steady.period * np.arange(steady.count + 1)
    assert np.interp(turns, times(drive), drive.displacement) == pytest.approx(0.006, abs=1e-7)
    assert np.interp(turns - 0.5 * steady.period, times(drive), drive.displacement)[1:] == pytest.approx(
        -0.002, abs=1e-7
    )
    assert kind("quasi_static")(0.004, cycles=1).steady_cycles is None


def test_its_peaks_are_the_speed_or_what_a_short_stroke_reaches():
    peaks = kind("quasi_static")(0.004, 0.002).peaks(RIG)
    assert (peaks.position, peaks.speed) == pytest.approx((0.004, 0.002))
    beside = kind("quasi_static")(0.004, 0.002, centre=-0.002).peaks(RIG)
    assert (beside.position, beside.speed) == pytest.approx((0.006, GLIDE))
    short = kind("quasi_static")(1e-5, 0.002)  # v^2 = d v0/0.1 s: half of the way faster, half slower
    assert short.peaks(RIG).speed == pytest.approx(np.sqrt(2e-5 * 0.002 / 0.1))
    reached = np.abs(np.diff(kind("quasi_static")(1e-5, 0.002, period=0.001).drive(RIG).displacement)) / 0.001
    assert reached.max() == pytest.approx(short.peaks(RIG).speed, rel=0.03)


def test_a_speed_of_0_is_refused():
    with pytest.raises(InputError, match="speed = 0 m"):
        kind("quasi_static")(0.004, 0.0)
