"""Motions that could be proposed stay within what the rig has shown."""

import numpy as np
import pytest
from tests.identification.parameter_uncertainty.test_profile_likelihood import DAMPER
from tests.identification.synthetic import sine

from dampyr.identification.parameter_uncertainty.candidate_motions import MotionReach, candidate_motions, measure_reach
from dampyr.identification.search.fit_data import piece


def test_candidates_stay_inside_the_envelope() -> None:
    envelope = MotionReach(0.010, 0.05, 0.4)
    kinds = set()
    for one in candidate_motions(envelope):
        kinds.add(one.kind)
        assert np.max(np.abs(one.x)) <= envelope.amplitude * (1 + 1e-9)
        assert np.max(np.abs(one.v)) <= 1.01 * envelope.speed, one.in_words()
        if one.kind != "triangle":
            assert np.max(np.abs(np.gradient(one.v, one.t))) <= 1.05 * envelope.acceleration, one.in_words()
            np.testing.assert_allclose(np.gradient(one.x, one.t), one.v, atol=0.01 * np.max(np.abs(one.v)))
    assert kinds == {"sine", "triangle", "two sines", "random"}


def test_the_envelope_is_that_of_the_records() -> None:
    one = measure_reach([piece(sine(DAMPER, 0.0, amplitude=0.01, frequency=1.0), None)])
    assert one.amplitude == pytest.approx(0.01, rel=0.02)
    assert one.speed == pytest.approx(2 * np.pi * 0.01, rel=0.1)
