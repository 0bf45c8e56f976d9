"""Text of a figure that cannot be read is found: it overlaps, it is cut, it is small; and that of every kind of figure can."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from matplotlib.figure import Figure
from tools.figure_text import lines_of_text, unreadable

from dampyr.origin import SIMULATED
from dampyr.show.figures import style
from tests.show.figures.figure_examples import MAKERS


def labelled() -> tuple[Figure, Any]:
    """A figure with names and ticks on its axes, and its panel."""
    with style.single_panel(2.5) as (figure, panel):
        panel.plot([0.0, 1.0], [0.0, 1.0])
        style.name_axes(panel, style.TIME, style.FORCE)
    return figure, panel


def test_text_that_stands_free_is_readable_and_its_boxes_are_where_it_is() -> None:
    figure, panel = labelled()
    assert not unreadable(figure)
    lines = {line.text: line for line in lines_of_text(figure)}
    box = panel.xaxis.label.get_window_extent()
    drawn = lines["time [s]"]
    assert (drawn.left, drawn.low, drawn.right, drawn.high) == pytest.approx((box.x0, box.y0, box.x1, box.y1), abs=3.0)
    box = panel.yaxis.label.get_window_extent()  # turned by a right angle
    drawn = lines["force [N]"]
    assert (drawn.left, drawn.low, drawn.right, drawn.high) == pytest.approx((box.x0, box.y0, box.x1, box.y1), abs=3.0)


def crowd(figure: Figure, panel: Any) -> None:
    panel.set_xticks([0.50, 0.51], ["one tick", "another"])


def write_over(figure: Figure, panel: Any) -> None:
    panel.text(0.5, 0.5, "first")
    panel.text(0.51, 0.52, "second")


def turn_over(figure: Figure, panel: Any) -> None:
    panel.text(0.5, 0.5, "first", rotation=90)
    panel.text(0.5, 0.6, "second", rotation=90)


def leave_no_gap(figure: Figure, panel: Any) -> None:
    first = panel.text(0.2, 0.5, "0.000")
    figure.draw_without_rendering()
    box = first.get_window_extent().transformed(panel.transData.inverted())
    panel.text(box.x1, 0.5, "0.001")


def reach_out(figure: Figure, panel: Any) -> None:
    figure.text(0.95, 0.99, "over the edge")


def clip(figure: Figure, panel: Any) -> None:
    panel.text(0.95, 0.3, "over the panel", clip_on=True)


def shrink(figure: Figure, panel: Any) -> None:
    panel.text(0.1, 0.8, "small", fontsize=4)


@pytest.mark.parametrize(
    ("plant", "found"),
    [
        (crowd, "'one tick' overlaps 'another'"),
        (write_over, "'first' overlaps 'second'"),
        (turn_over, "'first' overlaps 'second'"),
        (leave_no_gap, "'0.000' overlaps '0.001'"),
        (reach_out, "'over the edge' is cut at an edge"),
        (clip, "'over the panel' is cut at an edge"),
        (shrink, "'small' has 4.0 points"),
    ],
)
def test_a_planted_fault_is_found(plant: Callable[[Figure, Any], None], found: str) -> None:
    figure, panel = labelled()
    plant(figure, panel)
    assert unreadable(figure) == [found]


def test_lines_of_one_text_and_a_turned_one_beside_another_are_readable() -> None:
    figure, panel = labelled()
    panel.text(0.2, 0.4, "two\nlines")
    panel.text(0.4, 0.2, "two turned\nlines", rotation=90)
    assert not unreadable(figure)


def test_the_word_of_an_origin_may_lie_over_the_figure() -> None:
    figure, _ = labelled()
    SIMULATED.stamp(figure)
    assert not unreadable(figure)


@pytest.mark.parametrize("name", MAKERS)
def test_every_kind_of_figure_can_be_read(name: str) -> None:
    assert not unreadable(MAKERS[name]())
