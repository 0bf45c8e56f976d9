"""The corner plot: what stands in which panel, against samples whose spread is known."""

import numpy as np
import pytest

from dampyr.show.figures.corner import BINS, corner
from dampyr.show.figures.style import Axis

AXES = {"a": Axis("a", "N"), "b": Axis("b", "mm", 1e3), "c": Axis("c", "1")}


def test_each_pair_is_drawn_once_below_the_diagonal_and_each_number_on_it() -> None:
    draws = dict(zip("abc", np.random.default_rng(0).normal(size=(3, 600)), strict=True))
    figure = corner(draws, AXES, {"a": 0.5, "b": 0.001, "c": -1.0})
    panels = np.array(figure.axes).reshape(3, 3)
    assert [[panel.axison for panel in row] for row in panels] == [
        [True, False, False],
        [True, True, False],
        [True, True, True],
    ]
    for k, (name, axis) in enumerate(AXES.items()):
        bars = panels[k, k].patches
        assert len(bars) == BINS
        assert sum(bar.get_height() for bar in bars) == 600
        assert bars[0].get_x() == pytest.approx(axis.of(draws[name]).min())
    cloud, outline, centre = panels[2, 1].lines
    np.testing.assert_allclose(cloud.get_xdata(), 1e3 * draws["b"])
    np.testing.assert_allclose(cloud.get_ydata(), draws["c"])
    assert (centre.get_xdata()[0], centre.get_ydata()[0]) == (1.0, -1.0)
    # of a normal distribution the line holds 95 %
    x, y = (np.asarray(values) for values in outline.get_data())
    inverse = np.linalg.inv(np.cov(1e3 * draws["b"], draws["c"]))
    middle = np.array([1e3 * draws["b"].mean(), draws["c"].mean()])
    edge = np.stack((x, y), axis=1) - middle
    np.testing.assert_allclose(np.einsum("ki,ij,kj->k", edge, inverse, edge), 5.991, rtol=1e-9)
    assert [panel.get_xlabel() for panel in panels[2]] == ["a [N]", "b [mm]", "c [1]"]
    assert [panel.get_ylabel() for panel in panels[:, 0]] == ["", "b [mm]", "c [1]"]
