"""Sine: whole cycles of one amplitude and frequency about a centre."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.campaigns.paths import AFTER, GLIDE
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def times(drive):
    return np.arange(drive.n) * drive.period


def test_the_steady_cycles_are_the_sine_about_its_centre():
    """After the rest and the glide to the centre: one cycle of the taper, then the cycles."""
    step = kind("sine")(0.008, 0.5, 1.98, cycles=3, taper=1, centre=0.005, rest_before=1.0, period=0.005)
    drive = step.drive(RIG)
    begin = 1.0 + 0.005 / GLIDE + 0.1  # the glide's ramps take RAMP = 0.1 s more
    t = times(drive) - begin - 2.0
    steady = (t >= 0.0) & (t <= 6.0)
    np.testing.assert_allclose(
        drive.displacement[steady], 0.005 + 0.008 * np.sin(2 * np.pi * 0.5 * t[steady]), atol=1e-12
    )
    assert drive.duration == pytest.approx(begin + 10.0 + 0.6 + AFTER, abs=0.005)
    assert np.all(drive.voltage == 1.98)
    assert (drive.displacement[0], drive.displacement[-1]) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_it_says_where_its_steady_cycles_are():
    step = kind("sine")(0.008, 0.5, 1.98, cycles=3, taper=2, centre=0.005, rest_before=1.0, period=0.005)
    steady, drive = step.steady_cycles, step.drive(RIG)
    assert (steady.begin, steady.period, steady.count) == pytest.approx((1.0 + 0.005 / GLIDE + 0.1 + 4.0, 2.0, 3))
    inside = (times(drive) > steady.begin) & (times(drive) < steady.begin + 3 * steady.period)
    expected = 0.005 + 0.008 * np.sin(np.pi * (times(drive)[inside] - steady.begin))
    np.testing.assert_allclose(drive.displacement[inside], expected, atol=1e-12)


def test_its_peaks_are_those_of_the_sine_or_of_the_glide():
    peaks = kind("sine")(0.008, 0.5, centre=-0.005).peaks(RIG)
    assert (peaks.position, peaks.speed) == pytest.approx((0.013, 2 * np.pi * 0.5 * 0.008))
    assert kind("sine")(0.001, 0.01, centre=0.02).peaks(RIG).speed == GLIDE


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.01, "frequency": 1.0, "cycles": 0}, "cycles = 0"),
        ({"amplitude": -0.01, "frequency": 1.0}, "amplitude = -0.01 m"),
        ({"amplitude": 0.01, "frequency": 15.0}, "at most 8.33 ms"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("sine")(**settings)
