"""Friction: strokes at one speed with a pause at every end."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.campaigns.paths import AFTER
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def times(drive):
    return np.arange(drive.n) * drive.period


def test_the_table_pauses_at_every_end_of_a_stroke():
    """Two strokes there and back: two pauses at either end, and one in the middle at last."""
    step = kind("friction")(0.004, 0.005, pause=0.5, cycles=2, rest_before=1.0)
    drive = step.drive(RIG)
    stands = np.round(drive.displacement[1:][np.diff(drive.displacement) == 0.0], 9)
    counts = {place: int(np.sum(stands == place)) for place in (0.004, -0.004)}
    assert counts == {0.004: pytest.approx(100, abs=4), -0.004: pytest.approx(100, abs=4)}
    assert np.sum(stands == 0.0) == pytest.approx((1.0 + 0.5 + AFTER) / 0.01, abs=4)
    ways = 2 * (0.8 + 0.1) + 3 * (1.6 + 0.1)
    assert drive.duration == pytest.approx(1.0 + ways + 5 * 0.5 + AFTER, abs=0.02)
    assert np.abs(np.diff(drive.displacement)).max() / 0.01 == pytest.approx(0.005)


def test_its_peaks_are_the_amplitude_and_the_speed():
    peaks = kind("friction")(0.004, 0.005).peaks(RIG)
    assert (peaks.position, peaks.speed) == (0.004, 0.005)
    assert kind("friction")(1e-5, 0.005).peaks(RIG).speed == pytest.approx(np.sqrt(2e-5 * 0.005 / 0.1))


def test_a_negative_pause_is_refused():
    with pytest.raises(InputError, match="pause = -1 s"):
        kind("friction")(0.004, pause=-1.0)
