"""Scores of many records: dots, their means as bars, and what to beat."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import MAKERS, lines

from dampyr.show.figures.scores import scores


def test_a_record_is_a_dot_and_the_bar_ends_at_the_mean_of_its_group() -> None:
    fig = MAKERS["scores"]()
    [panel] = fig.axes
    assert [bar.get_width() for bar in panel.patches] == pytest.approx([7.5, 12.0])
    np.testing.assert_allclose(panel.lines[0].get_xdata(), [5.0, 10.0])
    np.testing.assert_allclose(panel.lines[1].get_xydata(), [[12.0, 1.0]])
    np.testing.assert_allclose(lines(fig)["published"], ([10.9], [0.0]))
    assert [label.get_text() for label in panel.get_yticklabels()] == ["0 V", "1.98 V"]
    assert panel.yaxis_inverted()  # the first group is on top
    assert panel.get_xlabel() == "L1 ratio [%]"


def test_dots_of_one_group_stand_apart_about_its_row() -> None:
    dots = scores({"a": np.full(5, 0.1)}).axes[0].lines[0].get_ydata()
    assert np.mean(dots) == pytest.approx(0.0)
    assert np.all(np.diff(dots) > 0.05)
    assert np.max(np.abs(dots)) < 0.55 / 2  # within the bar
