"""Parameters against the input: the law, the fitted points with their bars, and the calibrated range."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import LAWS, T, lines

from dampyr.show.figures.laws import parameters_against_input


def test_law_points_and_others_are_in_the_unit_of_their_parameter() -> None:
    fig = parameters_against_input(LAWS, (0.0, 3.212))
    kw, rho, empty = (panel for panel in fig.axes if panel.axison)
    law, *_ = kw.lines
    np.testing.assert_allclose(law.get_xydata(), np.column_stack((T, 100.0 * T)))
    [bars] = kw.containers
    np.testing.assert_allclose(bars.lines[0].get_xydata(), [[0.0, 10.0], [2.0, 190.0]])
    [(first, second)] = [segments.get_segments() for segments in bars.lines[2]]
    np.testing.assert_allclose(first[:, 1], [5.0, 15.0])
    assert second.size == 0  # an infinite error has no bar
    np.testing.assert_allclose(rho.lines[0].get_ydata(), 1e-3 * (4e4 - T))  # 1/m as 1/mm
    np.testing.assert_allclose(lines(fig)["published"][1], 42.7448)
    for panel in (kw, rho, empty):
        [span] = panel.patches
        assert span.get_extents().transformed(panel.transData.inverted()).intervalx == pytest.approx([0.0, 3.212])
    assert len(empty.lines) == 0


def test_without_a_range_nothing_is_shaded() -> None:
    assert len(parameters_against_input(LAWS[:1]).axes[0].patches) == 0
