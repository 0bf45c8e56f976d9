"""What a rig is to do: drives that cannot be are refused."""

from __future__ import annotations

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.rig import Drive


def test_a_drive_has_no_negative_voltage() -> None:
    with pytest.raises(InputError, match=r"voltage = -0.1 V is negative"):
        Drive(0.01, np.zeros(3), np.array([0.0, -0.1, 0.0]))
