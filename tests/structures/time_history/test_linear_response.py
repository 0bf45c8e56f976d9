"""The bare building and its peaks, which lie between samples too."""

import numpy as np
import pytest

from dampyr.ground_motions import el_centro
from dampyr.structures import respond, two_storey
from dampyr.structures.time_history.linear_response import peak_displacement


def test_the_largest_stroke_lies_between_samples():
    t = np.arange(0.0, 1.0, 0.05) + 0.013
    largest_stroke = peak_displacement(np.sin(7.0 * t), 7.0 * np.cos(7.0 * t), 0.05)
    assert largest_stroke == pytest.approx(1.0, abs=2e-4)
    assert np.abs(np.sin(7.0 * t)).max() < 1.0 - 2e-4


def test_bare_building_needs_no_damper_and_says_linear():
    response = respond(two_storey(), el_centro())
    assert response.scheme == "linear"
    assert response.converged
    assert response.force.shape == (0, 1560)
    assert response.displacement.shape == (2, 1560)
    assert response.error_estimate < 2e-4


def test_peaks_are_taken_inside_the_step():
    coarse = respond(two_storey(), el_centro(), step=0.01)
    sampled = np.abs(coarse.displacement).max(axis=1)
    assert np.all(coarse.peak_displacement > sampled)
    assert coarse.peak_displacement == pytest.approx(
        respond(two_storey(), el_centro(), step=0.0005).peak_displacement, rel=1e-5
    )
