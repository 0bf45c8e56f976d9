"""How often each input is the best: shares and bands in per cent, the first at the top."""

import numpy as np

from dampyr.show.figures.arena import shares_of_best


def test_shares_and_bands_are_in_per_cent_from_the_top() -> None:
    fig = shares_of_best(["one", "two"], np.array([0.75, 0.25]), np.array([[0.5, 0.1], [0.9, 0.4]]))
    [panel] = fig.axes
    assert [(text.get_text(), round(text.get_position()[1])) for text in panel.texts] == [("one", 1), ("two", 0)]
    [points] = [line for line in panel.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(points.get_xdata(), [75.0, 25.0])
    [bands] = panel.collections
    np.testing.assert_allclose([segment[:, 0] for segment in bands.get_segments()], [[50.0, 90.0], [10.0, 40.0]])
    assert panel.get_xlabel() == "best of all inputs [% of the cases]"
