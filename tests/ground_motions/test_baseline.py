"""Baselines: what is taken off whole, rest at the end, and what is refused."""

import numpy as np
import pytest
from tests.ground_motions.motion_at_rest import DT, TIME, at_rest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, corrected, el_centro


@pytest.mark.parametrize("degree", [1, 2, 4])
def test_a_baseline_of_the_degree_is_taken_off_whole(degree: int) -> None:
    motion = corrected(at_rest(), degree)
    drift = np.polynomial.Polynomial([0.02, -0.001, 3e-5, 2e-6, 1e-7][: degree + 1])
    bent = GroundMotion(motion.acceleration + drift(TIME), DT)
    assert abs(bent.displacement[-1]) > 1.0
    np.testing.assert_allclose(corrected(bent, degree).acceleration, motion.acceleration, atol=1e-11)


def test_a_corrected_motion_ends_at_rest_where_it_began() -> None:
    for degree in (1, 2, 3, 6):
        motion = corrected(el_centro(), degree)
        assert abs(motion.velocity[-1]) < 1e-12
        assert abs(motion.displacement[-1]) < 1e-12
    assert "baseline of degree 6" in motion.history[0]
    assert el_centro().history == ()


def test_without_the_ends_the_velocity_is_smaller_still() -> None:
    raw, free, tied = el_centro(), corrected(el_centro(), 2, at_rest=False), corrected(el_centro(), 2)
    sizes = [float(np.sum(m.velocity**2)) for m in (free, tied, raw)]
    assert sizes[0] < sizes[1] < sizes[2] * 1.01
    worse = free.acceleration + 1e-5 * (TIME[: free.n] / 31.18)
    assert np.sum(GroundMotion(worse, 0.02).velocity ** 2) > sizes[0], "the least is a least"


@pytest.mark.parametrize("degree", [0, 7, 1.5])
def test_a_baseline_of_no_sense_is_refused(degree: float) -> None:
    with pytest.raises(InputError, match="a whole number from 1 to 6"):
        corrected(el_centro(), degree)
    with pytest.raises(InputError, match="too few for a baseline"):
        corrected(GroundMotion(np.ones(5), 0.1))
