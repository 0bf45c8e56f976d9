"""Measured and simulated records of the same drive, one pair below another."""

import numpy as np
from tests.show.figures.figure_examples import F, T, X

from dampyr.show.figures.side_by_side import MotionStretch, side_by_side


def test_a_pair_is_a_row_of_motion_and_loop() -> None:
    pairs = [
        ("sine", MotionStretch(T, X, F), MotionStretch(T, 0.9 * X, 0.8 * F)),
        ("sweep", MotionStretch(T, 2 * X, F), MotionStretch(T, 1.8 * X, 0.7 * F)),
    ]
    fig = side_by_side(pairs)
    for row, (name, *stretches) in enumerate(pairs):
        left, right = fig.axes[2 * row : 2 * row + 2]
        assert left.get_title(loc="left") == name
        for motion, label, moved, loop in zip(
            stretches, ("measured", "simulated"), left.lines, right.lines, strict=True
        ):
            assert moved.get_label() == loop.get_label() == label
            np.testing.assert_allclose(moved.get_xydata(), np.column_stack((T, 1e3 * motion.displacement)))
            np.testing.assert_allclose(loop.get_xydata(), np.column_stack((1e3 * motion.displacement, motion.force)))
        assert (left.get_ylabel(), right.get_ylabel()) == ("displacement [mm]", "force [N]")
    assert [panel.get_xlabel() for panel in fig.axes] == ["", "", "time [s]", "displacement [mm]"]
