"""Median and quartiles of the residual over the velocity."""

import numpy as np
from tests.show.figures.figure_examples import T

from dampyr.show.figures.residual_velocity import residual_velocity


def test_the_median_is_a_line_between_the_quartiles_over_mm_per_s() -> None:
    bands = {"speeding up": (T, -T, 0.5 * T, 2 * T), "slowing down": (T, T - 1.0, T, T + 1.0)}
    fig = residual_velocity({"0 V": bands, "1 V": bands, "2 V": bands})
    shown = [panel for panel in fig.axes if panel.axison]
    assert [panel.get_title(loc="left") for panel in shown] == ["0 V", "1 V", "2 V"]
    for panel in shown:
        zero, *medians = panel.lines
        assert set(zero.get_ydata()) == {0.0}
        for line, filled, (v, low, median, high) in zip(medians, panel.collections, bands.values(), strict=True):
            np.testing.assert_allclose(line.get_xydata(), np.column_stack((1e3 * v, median)))
            drawn = {tuple(corner) for corner in np.round(filled.get_paths()[0].vertices, 6)}
            for x, *heights in zip(1e3 * v, low, high, strict=True):
                assert {(round(x, 6), round(height, 6)) for height in heights} <= drawn
    assert [panel.get_ylabel() for panel in shown] == ["residual [N]", "", ""]
    assert [panel.get_xlabel() for panel in shown][-1] == "velocity [mm/s]"
