"""The summary of an ensemble whose peaks are known."""

from __future__ import annotations

import numpy as np
from tests.structures.ensembles.known_peaks import drawn, made

from dampyr.structures import summary


def test_a_summary_has_medians_and_84_per_cent() -> None:
    capacity = drawn(50)
    [row] = summary(made(capacity))
    assert row.scale == 1.0
    np.testing.assert_allclose(row.peaks["drift"], np.quantile(1.0 / capacity, [0.5, 0.84]))
