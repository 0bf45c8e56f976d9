"""Figures for a journal: their width, font, greys and commas, and that a figure is as it was afterwards."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from tests.show.figures.figure_examples import MAKERS
from tools.figure_text import lines_of_text, unreadable

from dampyr import show
from dampyr.errors import InputError
from dampyr.show.figures import style
from dampyr.show.figures.loops import loops
from dampyr.show.journal_style import JournalStyle, in_style, with_comma

ALL: dict[str, Any] = {"width": "88 mm", "font": "DejaVu Serif", "grey": True, "decimal_comma": True}
X = np.linspace(0.0, 0.01, 50)


def four_loops() -> Any:
    return loops(X, None, None, {f"{k + 0.5} V": k * X for k in range(4)})


@pytest.mark.prove
@pytest.mark.parametrize("name", MAKERS)
def test_every_kind_of_figure_can_be_read_in_a_column(name: str) -> None:
    figure = MAKERS[name]()
    with style.style(), in_style(figure, JournalStyle(**ALL)):
        assert not unreadable(figure)


def test_a_title_is_broken_and_the_unit_of_a_short_axis_stands_below_its_name() -> None:
    title = "a title that is much wider than a column of a journal is, in a bold font"
    with style.panels(2.7, 1, 3, title) as (figure, axes):
        for panel in axes[0]:
            panel.plot(X, X)
            panel.set_xlabel("acceleration [m/s²]")
    with style.style(), in_style(figure, JournalStyle(width=0.088)):
        assert not unreadable(figure)
        assert figure.get_suptitle() != title
        assert axes[0, 2].get_xlabel() == "acceleration\n[m/s²]"
    assert figure.get_suptitle() == title
    assert axes[0, 2].get_xlabel() == "acceleration [m/s²]"


def test_hatching_has_no_colour() -> None:
    figure = MAKERS["laws"]()
    figure.axes[0].fill_between([0.0, 1.0], 0.0, 1.0, color=style.ORANGE, label="more")
    with style.style(), in_style(figure, JournalStyle(grey=True)):
        areas = [area for panel in figure.axes for area in (*panel.patches, *panel.collections) if area.get_hatch()]
        assert areas
        for area in areas:
            for colour in (area.get_facecolor(), area.get_edgecolor()):
                red, green, blue = to_rgb(np.atleast_2d(colour)[0])
                assert red == green == blue


def test_the_file_is_as_wide_as_was_asked_for(tmp_path: Path) -> None:
    path = show.save(four_loops(), tmp_path / "loops.svg", width="88 mm")
    width = ElementTree.parse(path).getroot().get("width")
    assert width is not None
    assert float(width.removesuffix("pt")) / 72 * 25.4 == pytest.approx(88.0, abs=0.01)


def test_in_grey_no_two_cases_look_alike_and_nothing_has_a_colour() -> None:
    figure = four_loops()
    with style.style(), in_style(figure, JournalStyle(grey=True)):
        lines = figure.axes[0].lines
        assert len({str(line._dash_pattern) for line in lines}) == 4  # as it is drawn
        figure.canvas.draw()
        for line in lines:
            red, green, blue = to_rgb(line.get_color())
            assert red == green == blue
        legend = figure.legends[0].get_lines()
        assert [line.get_linestyle() for line in legend] == [line.get_linestyle() for line in lines]
        figure.set_dpi(60)
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3].astype(int)
    # ink and grid of the style are a little blue, in both ways of drawing
    assert np.ptp(pixels, axis=-1).max() <= 20


def test_markers_that_say_something_stay() -> None:
    figure = MAKERS["used"]()
    before = [line.get_marker() for line in figure.axes[0].lines]
    with in_style(figure, JournalStyle(grey=True)):
        assert [line.get_marker() for line in figure.axes[0].lines] == before


def test_numbers_have_commas_and_the_font_is_the_one_asked_for() -> None:
    figure = four_loops()
    with style.style(), in_style(figure, JournalStyle(decimal_comma=True, font="DejaVu Serif")):
        texts = [line.text for line in lines_of_text(figure)]
        assert {"0,5 V", "3,5 V", "0,020"} <= set(texts)
        assert not [text for text in texts if "." in text]
        assert {text.get_fontname() for text in figure.findobj(lambda each: hasattr(each, "get_fontname"))} == {
            "DejaVu Serif"
        }


@pytest.mark.parametrize("name", ["building", "laws", "theta", "scores", "used", "spectrum"])
def test_a_figure_is_afterwards_as_it_was(name: str) -> None:
    figure = MAKERS[name]()

    def drawn() -> list[Any]:
        artists = [
            (line.get_color(), line.get_linestyle(), line.get_marker()) for panel in figure.axes for line in panel.lines
        ]
        return [
            *artists,
            *figure.get_size_inches(),
            *sorted((line.text, line.points) for line in lines_of_text(figure)),
        ]

    before = drawn()
    with style.style(), in_style(figure, JournalStyle(**ALL)):
        assert drawn() != before
    assert drawn() == before


def test_commas_are_written_between_digits_alone() -> None:
    assert with_comma("0.5 m, fig. 3; v1.2") == "0,5 m, fig. 3; v1,2"
    assert with_comma("peak 1.5 at $k_x = 2.5$") == "peak 1,5 at $k_x = 2{,}5$"


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"width": 5.0}, "width = 5000 mm is not allowed; a figure is 50 to 500 mm wide"),
        ({"font": "DejaVu Sarif"}, "the font 'DejaVu Sarif' is not installed here; there is DejaVu Serif"),
    ],
)
def test_what_cannot_be_is_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        JournalStyle(**wrong)
