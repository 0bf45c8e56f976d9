"""The drive of a hybrid test on the rig: its way back to rest."""

import numpy as np
import pytest

from dampyr.hybrid.rig_drive import STOPPING, way_back


def test_the_way_back_ends_at_rest_in_the_middle():
    t = np.linspace(0.0, STOPPING, 3001)
    x = way_back(0.008, 0.03, t)
    v = np.gradient(x, t)
    assert (x[0], x[-1]) == (pytest.approx(0.008), pytest.approx(0.0, abs=1e-12))
    assert (v[0], v[-1]) == (pytest.approx(0.03, rel=0.01), pytest.approx(0.0, abs=1e-4))
