"""What a rig is to do: drives that cannot be are refused."""

from __future__ import annotations

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.rig import Drive


def test_a_drive_has_no_negative_voltage() -> None:
    with pytest.raises(InputError, match=r"voltage = -0.1 V is negative"):
        Drive(0.01, np.zeros(3), np.array([0.0, -0.1, 0.0]))


@pytest.mark.parametrize(
    ("period", "displacement", "voltage", "words"),
    [
        (0.01, np.zeros(3), np.zeros(2), "two rows of the same length"),
        (0.01, np.zeros(1), np.zeros(1), "at least 2"),
        (0.01, np.array([0.0, np.nan]), np.zeros(2), "must be finite"),
        (0.0105, np.zeros(2), np.zeros(2), "whole number of milliseconds"),
        (1.001, np.zeros(2), np.zeros(2), "from 1 to 1000"),
    ],
)
def test_a_drive_that_cannot_be_played_is_refused(
    period: float, displacement: np.ndarray, voltage: np.ndarray, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        Drive(period, displacement, voltage)


def test_a_drive_has_the_times_of_its_set_points() -> None:
    drive = Drive(0.02, np.zeros(4), np.zeros(4))
    np.testing.assert_allclose(drive.time, [0.0, 0.02, 0.04, 0.06])
    assert (drive.n, drive.duration) == (4, pytest.approx(0.06))
    assert not drive.displacement.flags.writeable
