"""Incremental analyses of peaks whose fractiles are known."""

from __future__ import annotations

import numpy as np
import pytest
from tests.structures.ensembles.known_peaks import SCALES, drawn, made

from dampyr.structures import incremental


def test_fractiles_are_those_across_motions_at_one_intensity() -> None:
    capacity = drawn(41)
    curves = incremental(made(capacity), intensity="scale", fractions=(0.16, 0.5))
    np.testing.assert_allclose(
        curves["0 V"].fractiles, np.quantile(SCALES / capacity[0, 0][:, None], (0.16, 0.5), axis=0), rtol=1e-12
    )
    pga = np.linspace(1.0, 3.0, 41)
    sweep = incremental(made(capacity, pga=pga), intensity="pga", fractions=(0.5,)).sweeps[0]
    assert (sweep.levels[0], sweep.levels[-1]) == pytest.approx((3 * SCALES[0], SCALES[-1]))
    slopes = 1.0 / (capacity[0, 0] * pga)
    np.testing.assert_allclose(sweep.fractiles[0], np.median(slopes) * sweep.levels, rtol=1e-12)
