"""Cutting to a share of the intensity, and rest before and after."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import el_centro, padded, trimmed
from dampyr.ground_motions.intensity_measures import arias, significant_duration


def test_cutting_keeps_the_share_and_whole_samples() -> None:
    motion = el_centro()
    cut = trimmed(motion, 0.05, 0.95)
    assert 0.9 * arias(motion) <= arias(cut) < 0.91 * arias(motion)
    assert significant_duration(motion) <= cut.duration <= significant_duration(motion) + 2 * 0.02
    start = round(float(cut.history[0].split()[2]) / 0.02)
    np.testing.assert_array_equal(cut.acceleration, motion.acceleration[start : start + cut.n])
    wider = trimmed(motion, 0.05, 0.95, margin=1.0)
    assert wider.duration == pytest.approx(cut.duration + 2.0, abs=1e-9)
    np.testing.assert_array_equal(trimmed(motion, 0.0, 1.0, margin=99.0).acceleration, motion.acceleration)


def test_rest_is_added_in_whole_samples() -> None:
    motion = el_centro()
    longer = padded(motion, 5.0, before=0.03)
    assert longer.n == motion.n + 250 + 2
    np.testing.assert_array_equal(longer.acceleration[2:-250], motion.acceleration)
    assert not longer.acceleration[-250:].any()
    assert longer.history == ("5 s of rest added after and 0.04 s before",)
    with pytest.raises(InputError, match="seconds = -1 s is not allowed"):
        padded(motion, -1.0)
    with pytest.raises(InputError, match="margin = -1 s"):
        trimmed(motion, margin=-1.0)
