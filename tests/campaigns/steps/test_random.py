"""Random displacement: its band of frequencies and nothing else."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.campaigns.steps.random import unit_path
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_a_random_path_has_its_band_and_nothing_else():
    step = kind("random")(0.01, low=0.5, high=2.0, duration=40.0, taper=0.001, rest_before=0.0, seed=3)
    x = step.drive(RIG).displacement[: round(40.0 / 0.01)]
    power = np.abs(np.fft.rfft(x)) ** 2
    f = np.fft.rfftfreq(x.size, 0.01)
    band = (f >= 0.5 - 1e-9) & (f <= 2.0 + 1e-9)
    assert power[band].sum() > 0.9998 * power.sum()  # what is left is the first sample, which the taper makes 0
    speed = f[band] * np.sqrt(power[band])
    assert np.ptp(speed) < 0.02 * speed.mean()


def test_its_peaks_are_those_of_its_path():
    step = kind("random")(0.01, high=1.0, duration=20.0, period=0.002, seed=2)
    x = step.drive(RIG).displacement
    assert np.abs(x).max() == pytest.approx(0.01, rel=1e-3)
    assert step.peaks(RIG).position == 0.01
    assert np.abs(np.diff(x)).max() / 0.002 == pytest.approx(step.peaks(RIG).speed, rel=0.01)
    assert not np.array_equal(
        x, kind("random")(0.01, high=1.0, duration=20.0, period=0.002, seed=3).drive(RIG).displacement
    )


def test_the_speed_of_its_path_is_the_derivative_in_the_tapers_too():
    t, x, v = unit_path(0.2, 1.0, 20.0, 2, 8.0)
    np.testing.assert_allclose(v, np.gradient(x, t), atol=1e-3 * np.abs(v).max())


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.01, "low": 1.0, "high": 1.01}, "fewer than two frequencies"),
        ({"amplitude": 0.01, "duration": 3.0}, "taper = 2 s"),
        ({"amplitude": 0.01, "seed": -1}, "seed = -1 is not allowed"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("random")(**settings)
