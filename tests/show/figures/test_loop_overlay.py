"""Loops over one another: a colour for each name, the units of the axes, no legend of too many names."""

import numpy as np
from tests.show.figures.figure_examples import F, V, X

from dampyr.show.figures.loop_overlay import MOST_NAMES, curve_overlay, loop_overlay
from dampyr.show.figures.style import Axis

INCHES, POUNDS = Axis("displacement", "in", 1.0 / 0.0254), Axis("force", "lbf", 0.224808943)


def test_a_name_has_one_colour_and_the_axes_their_units() -> None:
    figure = loop_overlay(
        {"0 V": [(X, V, F), (2 * X, V, F)], "1 V": [(X, V, 2 * F)]}, displacement=INCHES, force=POUNDS
    )
    place, speed = figure.axes
    assert (place.get_xlabel(), place.get_ylabel()) == ("displacement [in]", "force [lbf]")
    assert speed.get_xlabel() == "velocity [mm/s]"
    np.testing.assert_allclose(place.lines[1].get_xydata(), np.column_stack((2 * X / 0.0254, 0.224808943 * F)))
    colours = [line.get_color() for line in place.lines]
    assert colours[0] == colours[1] != colours[2]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["0 V", "1 V"]


def test_many_names_have_no_legend() -> None:
    few, many = (
        curve_overlay({f"test {k}": [(X, F)] for k in range(n)}, INCHES, POUNDS, zero=True)
        for n in (MOST_NAMES, MOST_NAMES + 1)
    )
    assert (len(few.legends), len(many.legends)) == (1, 0)
    assert few.axes[0].get_ylim()[0] == 0.0
