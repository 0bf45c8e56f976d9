"""Candidate and chosen tests in the plane of frequency and amplitude."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, lines

from dampyr.show.figures.planned_tests import planned_tests


def test_points_are_in_mm_over_hz_and_a_repeated_test_has_its_number_beside_it() -> None:
    fig = MAKERS["planned_tests"]()
    by_label, [panel] = lines(fig), fig.axes
    np.testing.assert_allclose(by_label["candidates"], ([0.4, 1.0], [10.0, 5.0]))
    np.testing.assert_allclose(by_label["chosen: sine"], ([1.0], [5.0]))
    np.testing.assert_allclose(by_label["chosen: voltage steps"], ([0.4], [10.0]))
    assert [(text.get_text(), text.xy) for text in panel.texts] == [("2", (1.0, 5.0))]
    np.testing.assert_allclose([line.get_ydata() for line in panel.lines[:2]], [[30.0, 2.0], [20.0, 1.0]])
    assert "largest sine, 0 V (top) to 3.2 V" in by_label
    assert (panel.get_xscale(), panel.get_yscale()) == ("log", "log")
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("frequency [Hz]", "amplitude [mm]")


def test_a_single_limit_has_no_range_in_its_name() -> None:
    fig = planned_tests([0.4, 4.0], {"0 V": [0.03, 0.002]}, [(0.4, 0.01)], {"sine": [(0.4, 0.01)]})
    assert "largest sine, 0 V" in lines(fig)
    assert len(fig.axes[0].texts) == 0
