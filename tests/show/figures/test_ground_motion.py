"""A ground motion over time, with its peak."""

from tests.show.figures.figure_examples import MAKERS, lines


def test_the_peak_of_a_motion_is_told_in_g() -> None:
    assert "peak 3.127 m/s² = 0.3188 g at 0 s" in lines(MAKERS["motion"]())
