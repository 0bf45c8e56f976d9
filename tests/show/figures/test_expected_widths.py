"""Half widths of intervals as a plan expected them, against those that the fit gave."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import lines

from dampyr.show.figures.expected_widths import expected_widths


def test_widths_are_in_per_cent_and_the_band_is_30_per_cent_about_equality() -> None:
    fig = expected_widths({"round 1": [(0.02, 0.022), (0.01, 0.008)], "round 2": [(0.01, 0.012)]})
    by_label, [panel] = lines(fig), fig.axes
    np.testing.assert_allclose(by_label["round 1"], ([2.0, 1.0], [2.2, 0.8]))
    np.testing.assert_allclose(by_label["round 2"], ([1.0], [1.2]))
    [across, up] = (panel.lines[0].get_xdata(), panel.lines[0].get_ydata())
    np.testing.assert_allclose(up, across)
    [band] = panel.collections
    for x, y in band.get_paths()[0].vertices:
        assert min(abs(y / x - 0.7), abs(y / x - 1.3)) < 1e-12
    low, high = panel.get_xlim()
    assert low == pytest.approx(0.8 / 1.5)
    assert high == pytest.approx(2.2 * 1.5)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("expected half width [%]", "achieved half width [%]")


def test_without_any_round_the_band_alone_is_drawn() -> None:
    assert [*lines(expected_widths({}))] == ["_child1"]
