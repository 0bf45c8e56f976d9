"""Where a damper was calibrated: the box, the records and the greatest speed."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import MAKERS, lines


def test_the_calibrated_box_and_the_greatest_speed_are_in_mm_and_hz() -> None:
    fig = MAKERS["calibrated"]()
    (box,) = fig.axes[0].patches
    assert box.get_bbox().bounds == pytest.approx((0.5, 0.0, 0.7, 20.0))
    by_label = lines(fig)
    np.testing.assert_allclose(by_label["0 V"], [[0.5, 1.2], [20.0, 8.0]])
    f, amplitude = by_label["greatest speed, 70 mm/s"]
    np.testing.assert_allclose(2 * np.pi * f * amplitude, 70.0)
