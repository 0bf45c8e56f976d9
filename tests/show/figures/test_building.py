"""How a building answers: each case with its peak."""

from tests.show.figures.figure_examples import MAKERS, lines


def test_peaks_of_a_building_are_told() -> None:
    by_label = lines(MAKERS["building"]())
    assert "no damper: 12 mm" in by_label
    assert "0 V: 6 mm" in by_label
