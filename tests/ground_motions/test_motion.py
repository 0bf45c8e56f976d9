"""A ground motion: scaling, and what is no motion."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.ground_motions.intensity_measures import sa


def test_scaling_to_a_peak_or_to_a_spectral_value() -> None:
    motion = el_centro()
    assert motion.scaled_to_pga(2.5).pga == pytest.approx(2.5, rel=1e-14)
    scaled = motion.scaled_to_sa(4.0, 0.48, 0.03)
    assert sa(scaled, 0.48, 0.03) == pytest.approx(4.0, rel=1e-13)
    assert motion.scaled_to_sa(4.0, 0.0).pga == pytest.approx(4.0)
    assert scaled.history[-1].startswith("scaled by ")
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match=r"a PGA of .* is not allowed; it must be greater than 0"):
            motion.scaled_to_pga(wrong)
    with pytest.raises(InputError, match="cannot be reached by scaling: the motion is 0"):
        GroundMotion(np.zeros(9), 0.1).scaled_to_sa(1.0, 0.5)


G = 9.80665


def test_scaled_keeps_the_original():
    motion = el_centro()
    twice = motion.scaled(2.0)
    assert twice.pga == pytest.approx(2 * motion.pga)
    assert motion.pga == pytest.approx(0.31882 * G)
    assert "x 2" in twice.name
    with pytest.raises(InputError, match="not a finite number"):
        motion.scaled(float("nan"))


def test_samples_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        el_centro().acceleration[0] = 1.0


@pytest.mark.parametrize(
    ("values", "dt", "message"),
    [
        ([0.0], 0.02, "at least 2 samples"),
        ([[0.0, 1.0]], 0.02, "one row"),
        ([0.0, np.nan, np.inf], 0.02, "2 of 3 samples are not finite, the first is number 2"),
        ([0.0, 1.0], 0.0, "dt = 0.0 s is not allowed"),
    ],
)
def test_bad_motions_are_refused(values, dt, message):
    with pytest.raises(InputError, match=message):
        GroundMotion(values, dt)
