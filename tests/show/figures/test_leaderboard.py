"""Every model that was tried, with its error bare and with the add-ons that were worth it."""

import math

import numpy as np

from dampyr.show.figures.leaderboard import leaderboard_figure


def test_the_best_model_is_on_top_and_one_without_a_damper_is_left_out() -> None:
    fig = leaderboard_figure(
        ["dahl", "lugre", "bingham", "none"], [0.1, math.inf, 0.3, 0.2], [0.08, 0.05, 0.3, math.inf]
    )
    [panel] = fig.axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["lugre", "dahl", "bingham"]
    assert panel.get_ylim()[0] > panel.get_ylim()[1]
    by_name = {
        name: [line.get_xydata() for line in panel.lines if line.get_label() == name]
        for name in ("bare", "with add-ons")
    }
    np.testing.assert_allclose(np.concatenate(by_name["with add-ons"]), [[5.0, 0.0], [8.0, 1.0], [30.0, 2.0]])
    np.testing.assert_allclose(np.concatenate(by_name["bare"]), [[10.0, 1.0], [30.0, 2.0]])
    assert panel.get_xlabel() == "validation error [%]"
