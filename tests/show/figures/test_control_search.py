"""Candidates beside the first: ratios and bands in per cent, the first at the top."""

import numpy as np

from dampyr.show.figures.control_search import ratios


def test_ratios_and_bands_are_in_per_cent_of_the_first() -> None:
    fig = ratios(["one", "two"], np.array([1.0, 1.25]), np.array([[1.0, 1.1], [1.0, 1.4]]), "drift")
    [panel] = fig.axes
    assert [(text.get_text(), round(text.get_position()[1])) for text in panel.texts] == [("one", 1), ("two", 0)]
    [points] = [line for line in panel.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(points.get_xdata(), [100.0, 125.0])
    [bands] = panel.collections
    np.testing.assert_allclose([segment[:, 0] for segment in bands.get_segments()], [[100.0, 100.0], [110.0, 140.0]])
    assert panel.get_xlabel() == "drift, of the first's [%]"
