"""Loops of levels: a panel for each, every cycle in mm and N, the third one apart."""

import numpy as np
from tests.show.figures.figure_examples import F, X

from dampyr.show.figures.level_loops import level_loops


def test_a_panel_holds_every_cycle_of_its_level_and_the_third_stands_out() -> None:
    levels = {"1 mm": [(k * X, F) for k in (1, 2, 3, 4)], "2 mm": [(X, 2 * F)]}
    figure = level_loops(levels)
    first, second = figure.axes
    assert [panel.get_title(loc="left") for panel in (first, second)] == list(levels)
    np.testing.assert_allclose(first.lines[1].get_xydata(), np.column_stack((2e3 * X, F)))
    assert [line.get_label() for line in first.lines] == ["other cycles", "other cycles", "cycle 3", "other cycles"]
    assert first.lines[2].get_color() != first.lines[0].get_color()
    assert (figure.get_supxlabel(), first.get_ylabel(), second.get_ylabel()) == ("displacement [mm]", "force [N]", "")


def test_panels_without_a_level_are_empty() -> None:
    figure = level_loops({f"{k} mm": [(X, F)] for k in range(4)})
    assert [panel.axison for panel in figure.axes] == [True] * 4 + [False] * 2
