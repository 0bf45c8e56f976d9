"""Control: the answers of the cases, and below them the inputs of the laws."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, V, X, lines


def test_control_shows_answers_and_below_them_the_inputs_of_the_laws() -> None:
    top, below = MAKERS["controlled"]().axes
    np.testing.assert_allclose(top.lines[2].get_ydata(), 500.0 * X)
    np.testing.assert_allclose(below.lines[0].get_ydata(), 1.5 + np.sign(V))
    assert below.lines[0].get_color() == top.lines[2].get_color()
    assert [text for text in lines(top.figure) if "mm" in text] == ["0 V: 12 mm", "on_off: 6 mm"]
    assert (top.get_ylabel(), below.get_ylabel()) == ("displacement [mm]", "voltage [V]")
