"""Lines of few points keep every peak, and drawing leaves no trace in matplotlib's settings."""

import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.show.figures.figure_examples import MAKERS, RHO

from dampyr import show
from dampyr.show.figures import style
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.figures.style import ACCELERATION, thin


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 5000), limit=st.integers(8, 400))
def test_thinning_keeps_the_ends_and_all_extremes(seed: int, n: int, limit: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=n).cumsum(), rng.normal(size=n)
    few_x, few_y = thin(x, y, limit)
    assert len(few_x) == len(few_y) <= limit + 2
    assert (few_x[0], few_x[-1]) == (x[0], x[-1])
    for few, all_ in ((few_x, x), (few_y, y)):
        assert few.min() == all_.min()
        assert few.max() == all_.max()


def test_a_single_spike_survives() -> None:
    y = np.zeros(100_000)
    y[73_211] = 1.0
    x, thinned = thin(np.arange(100_000.0), y)
    assert len(x) <= 2402
    assert x[np.argmax(thinned)] == 73_211


def test_missing_values_hide_no_peak() -> None:
    y = np.zeros(10_000)
    y[100:200], y[150] = np.nan, 7.0
    assert np.nanmax(thin(np.arange(10_000.0), y)[1]) == 7.0


def test_short_lines_are_left_alone() -> None:
    x, y = thin([3.0, 1.0, 2.0], [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(x, [3.0, 1.0, 2.0])
    np.testing.assert_array_equal(y, [0.0, 0.0, 1.0])


def test_figures_leave_no_setting_behind_and_need_no_pyplot() -> None:
    before = dict(matplotlib.rcParams)
    ground_motion([0.0, 1.0], [0.0, 1.0])
    assert dict(matplotlib.rcParams) == before
    draw = "from dampyr.show.figures.ground_motion import ground_motion; ground_motion([0.0, 1.0], [0.0, 1.0])"
    code = f"import sys; {draw}; print('matplotlib.pyplot' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"


def test_an_axis_scales_from_si() -> None:
    assert RHO.of(42744.8) == pytest.approx(42.7448)
    assert ACCELERATION.label == "acceleration [m/s²]"


def test_a_figure_can_be_a_file(tmp_path: Path) -> None:
    for kind in ("svg", "png", "pdf"):
        assert show.save(MAKERS["theta"](), tmp_path / "deep" / f"theta.{kind}").stat().st_size > 1000


def test_a_saved_figure_hides_what_is_behind_it_and_one_of_a_page_does_not(tmp_path: Path) -> None:
    from matplotlib.image import imread

    figure = MAKERS["theta"]()
    corner = imread(show.save(figure, tmp_path / "theta.png"))[0, 0]
    np.testing.assert_array_equal(corner, 1.0)  # white, and opaque
    assert figure.patch.get_alpha() == 0.0


@pytest.mark.parametrize(
    ("names", "rows"),
    [
        (["0 V", "0.8712 V", "1.98 V", "3.212 V"], [["0 V", "0.8712 V", "1.98 V", "3.212 V"]]),
        ([f"a long name {k}" for k in range(5)], [["a long name 0", "a long name 1", "a long name 2"],
                                                 ["a long name 3", "a long name 4"]]),
    ],
)  # fmt: skip
def test_a_legend_is_one_line_where_there_is_room_and_else_is_read_line_by_line(
    names: list[str], rows: list[list[str]]
) -> None:
    with style.single_panel(3.0) as (figure, panel):
        for name in names:
            panel.plot([0.0, 1.0], [0.0, 1.0], label=name)
        style.legend(figure, panel)
    figure.draw_without_rendering()
    texts = figure.legends[0].get_texts()
    boxes = {text.get_text(): text.get_window_extent() for text in texts}
    heights = sorted({round(box.y0) for box in boxes.values()}, reverse=True)
    found = [
        [name for name, box in sorted(boxes.items(), key=lambda each: each[1].x0) if round(box.y0) == y]
        for y in heights
    ]
    assert found == rows
    assert max(box.x1 for box in boxes.values()) <= figure.bbox.x1
