"""A correlation matrix: a cell for each pair, and the strong pairs."""

import re

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.show.figures.correlation import correlation, strong_pairs
from dampyr.show.pages.svg import inline_svg

MATRIX = np.array([[1.0, -0.95, np.nan], [-0.95, 1.0, 0.4], [np.nan, 0.4, 1.0]])


def test_a_correlation_is_a_cell_below_the_diagonal() -> None:
    fig = correlation(MATRIX, ["a", "b", "c"])
    panel = fig.axes[0]
    cells = {(round(p.get_x() + 0.46), round(p.get_y() + 0.46)): p for p in panel.patches}
    assert set(cells) == {(0, 1), (1, 2)}, "column, row; the unknown one has no colour"
    negative, positive = cells[0, 1], cells[1, 2]
    assert negative.get_facecolor()[0] > negative.get_facecolor()[2]
    assert positive.get_facecolor()[2] > positive.get_facecolor()[0]
    assert negative.get_alpha() > positive.get_alpha()
    assert [text.get_text() for text in panel.texts] == ["−.95", "–", ".40"]
    svg = inline_svg(fig, "correlation", "f1")
    assert set(re.findall(r"(?:fill|stroke): (#\w+)", svg)) <= {"#ffffff"}
    assert "<image" not in svg


@pytest.mark.parametrize("m", [2, 10, *(pytest.param(m, marks=pytest.mark.prove) for m in (28, 60))])
def test_names_beside_a_correlation_stay_inside_the_figure(m: int) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    fig = correlation(np.full((m, m), -0.95), [f"hyperbolic_tangent.v0 @ 0.{k:04d} V" for k in range(m)])
    FigureCanvasAgg(fig).draw()
    boxes = [label.get_window_extent() for label in fig.axes[0].get_yticklabels()]
    assert min(box.x0 for box in boxes) >= 0.0
    assert max(box.x1 for box in boxes) <= fig.bbox.x1


def test_strong_pairs_come_by_strength_and_unknown_ones_not_at_all() -> None:
    assert strong_pairs(MATRIX, "abc", 0.3) == [("a", "b", -0.95), ("b", "c", 0.4)]
    assert strong_pairs(MATRIX, "abc") == [("a", "b", -0.95)]
    with pytest.raises(InputError, match=r"shape \(3, 3\) for 2 names"):
        correlation(MATRIX, ["a", "b"])
