"""Peaks by floor, the building drawn upright."""

import numpy as np

from dampyr.show.figures import style
from dampyr.show.figures.peaks import peaks_by_floor


def test_a_panel_holds_one_quantity_of_all_cases_with_the_lowest_floor_below() -> None:
    cases = {"no damper": ([0.01, 0.03], [2.0, 5.0]), "1.98 V": ([0.006, 0.02], [1.5, 3.0])}
    fig = peaks_by_floor(["1", "roof"], cases, (style.DISPLACEMENT, style.ACCELERATION))
    displacement, acceleration = fig.axes
    for panel, k, factor in ((displacement, 0, 1e3), (acceleration, 1, 1.0)):
        for line, values in zip(panel.lines, cases.values(), strict=True):
            np.testing.assert_allclose(line.get_xdata(), factor * np.array(values[k]))
            np.testing.assert_array_equal(line.get_ydata(), [0, 1])
        largest = factor * max(max(values[k]) for values in cases.values())
        np.testing.assert_allclose(panel.get_xlim(), (0.0, 1.08 * largest))
    assert [label.get_text() for label in displacement.get_yticklabels()] == ["1", "roof"]
    assert [panel.get_xlabel() for panel in fig.axes] == ["displacement [mm]", "acceleration [m/s²]"]
    assert [line.get_color() for line in displacement.lines] == [style.MUTED, style.CASES[0]]


def test_cases_at_rest_have_an_axis_all_the_same() -> None:
    assert peaks_by_floor(["1"], {"at rest": ([0.0],)}).axes[0].get_xlim() == (0.0, 1.0)
