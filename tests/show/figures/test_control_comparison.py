"""Control: the answers of the cases, and below them the inputs of the laws."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import MAKERS, T, V, X, lines


def test_control_shows_answers_and_below_them_the_inputs_of_the_laws() -> None:
    top, below = MAKERS["controlled"]().axes
    np.testing.assert_allclose(top.lines[2].get_ydata(), 500.0 * X)
    shown, drawn = below.lines[0].get_xdata(), below.lines[0].get_ydata()
    inside = (shown[0] - 1e-9 <= T) & (shown[-1] + 1e-9 >= T)
    np.testing.assert_allclose(drawn, (1.5 + np.sign(V))[inside])
    assert np.any(np.abs(X[inside]) == np.max(np.abs(X))), "the two seconds in which the answer is largest"
    assert shown[-1] - shown[0] == pytest.approx(min(2.0, T[-1] - T[0]), abs=0.03)
    assert below.lines[0].get_color() == top.lines[2].get_color()
    assert [text for text in lines(top.figure) if "mm" in text] == ["0 V: 12 mm", "on_off: 6 mm"]
    share = 100 * np.mean(np.sign(V) > 0.0)
    assert below.get_title(loc="left") == f"on_off: above 1.5 V for {share:.0f} % of the time"
    assert (top.get_ylabel(), below.get_ylabel()) == ("displacement [mm]", "voltage [V]")
