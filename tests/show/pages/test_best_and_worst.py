"""The best and the worst record of some scores."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dampyr.identification import Fit, Score
from dampyr.identification.scoring.scoring_window import Window
from dampyr.origin import Origin
from dampyr.show.pages.best_and_worst import best_and_worst_sections, extremes, record_section
from dampyr.show.pages.blocks import FigureBlock

SCORE = Score(0.1, 0.2, 0.96, 0.1, 0.01, -0.02, 3.0, Window(0, 10, 0.0, 1.0))


@pytest.mark.parametrize(
    ("l1", "ends"),
    [
        ({"a": 0.2, "b": 0.1, "c": 0.3}, [("The best record", "b"), ("The worst record", "c")]),
        ({"a": math.nan, "b": 0.1, "c": 0.3}, [("The best record", "b"), ("The worst record", "a")]),
        ({"a": 0.2}, [("The record", "a")]),
    ],
)
def test_records_are_ranked_by_their_l1_and_one_without_a_number_is_worst(
    l1: dict[str, float], ends: list[tuple[str, str]]
) -> None:
    assert extremes({name: replace(SCORE, l1=value) for name, value in l1.items()}) == ends


def test_the_history_is_of_the_first_six_seconds() -> None:
    t = np.arange(2.0, 12.0, 0.01)
    x, force = np.sin(t), np.cos(t)
    section = record_section("The record", "a", (t, x, force, force, 0.5 * force), "fit", Origin("measured"))
    [block] = section.blocks
    assert isinstance(block, FigureBlock)
    loop, _, history, residual = block.figure.axes
    drawn = history.lines[0].get_xdata()
    assert (drawn[0], drawn[-1]) == pytest.approx((2.0, 8.0), abs=0.011)
    np.testing.assert_allclose(residual.lines[0].get_ydata(), 0.5 * force[: len(drawn)], atol=1e-12)
    assert block.caption == "a: loops, and the first 6 s that were scored with the residual (measured minus fit)."
    assert len(loop.lines[0].get_xdata()) == len(t)


def test_of_a_fit_only_scored_samples_are_drawn(joint: Fit) -> None:
    first, last = best_and_worst_sections(joint)
    ranked = sorted(joint.scores, key=lambda name: joint.scores[name].l1)
    assert (first.title, last.title) == (f"The best record: {ranked[0]}", f"The worst record: {ranked[-1]}")
    [block] = first.blocks
    assert isinstance(block, FigureBlock)
    assert block.figure.axes[2].lines[0].get_xdata()[0] >= joint.scores[ranked[0]].window.start - 1e-9
