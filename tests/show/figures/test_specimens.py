"""Estimates of several specimens with their intervals, the mean, and where a new one lies."""

import numpy as np
import pytest

from dampyr.show.figures.specimens import Estimates, specimen_estimates
from dampyr.show.figures.style import Axis


def test_a_specimen_is_a_row_with_its_interval_in_the_unit_of_the_number() -> None:
    number = Estimates(
        Axis("kx", "N s/mm", 1e-3), {"a": 1000.0, "b": 1200.0}, {"a": 50.0, "b": 20.0}, {"a": 1020.0, "b": 1190.0},
        mean=(1050.0, 1150.0), new=(800.0, 1400.0),
    )  # fmt: skip
    fig = specimen_estimates([number])
    [panel] = fig.axes
    [bars] = panel.containers
    np.testing.assert_allclose(bars.lines[0].get_xydata(), [[1.0, 0.0], [1.2, 1.0]])
    [segments] = [drawn.get_segments() for drawn in bars.lines[2]]
    np.testing.assert_allclose([segment[:, 0] for segment in segments], [[0.95, 1.05], [1.18, 1.22]])
    [shrunken] = [line for line in panel.lines if line.get_label() == "drawn to the mean"]
    np.testing.assert_allclose(shrunken.get_xdata(), [1.02, 1.19])
    spans = {
        patch.get_label(): patch.get_extents().transformed(panel.transData.inverted()).intervalx
        for patch in panel.patches
    }
    assert spans["mean"] == pytest.approx([1.05, 1.15])
    assert spans["new specimen"] == pytest.approx([0.8, 1.4])
    assert [label.get_text() for label in panel.get_yticklabels()] == ["a", "b"]
    assert panel.get_xlabel() == "kx [N s/mm]"
