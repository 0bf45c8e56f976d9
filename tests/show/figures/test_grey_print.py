"""What a figure tells by colour it tells in a grey print, too: by greys that are apart, by dashes or by shapes."""

from itertools import combinations

import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from tests.show.figures.figure_examples import MAKERS, T, X

from dampyr.show.figures import style
from dampyr.show.figures.building import building_response


def look(line) -> tuple:
    """The grey, and what else a line is told by."""
    dashed = line.get_linestyle() != "None"
    dash = line._dash_pattern[1] if dashed else None
    return style.lightness(line.get_color(), line.get_alpha()), dashed, tuple(dash or ()), line.get_marker()


def told_by_colour_alone(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of lines of one panel whose colours differ, and nothing else does by which a print would tell them."""
    found = []
    for axes in figure.axes:
        for a, b in combinations([line for line in axes.lines if line.get_visible()], 2):
            colours_differ = to_hex(a.get_color()) != to_hex(b.get_color())
            if colours_differ and look(a)[1:] == look(b)[1:] and abs(look(a)[0] - look(b)[0]) < 12.0:
                found.append((str(a.get_label()), str(b.get_label())))
    return found


@pytest.mark.parametrize("name", MAKERS)
def test_no_figure_tells_its_lines_by_colour_alone(name: str) -> None:
    assert told_by_colour_alone(MAKERS[name]()) == []


def test_three_cases_over_one_another_and_seven_beside_the_first() -> None:
    """With their peaks; the legend has what the lines have."""
    for count in (3, 7):
        names = ["no damper", *(f"{k} V" for k in range(1, count))]
        figure = building_response(T, {name: (1.0 - 0.1 * k) * X for k, name in enumerate(names)})
        assert told_by_colour_alone(figure) == []
    figure = building_response(T, dict.fromkeys(("no damper", "0 V", "3 V"), X))
    [axes] = figure.axes
    drawn = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
    [legend] = figure.legends
    for handle, line in zip(legend.get_lines(), drawn, strict=True):
        assert (handle.get_alpha(), look(handle)[2]) == (line.get_alpha(), look(line)[2])
    assert [line.get_alpha() for line in drawn] == [style.PALE, None, None]
    assert len({look(line)[2] for line in drawn}) == 2  # blue and vermillion are one grey


def test_planted_lines_are_found_and_told_apart() -> None:
    """The model and the record of every fit were one grey; two lines that are apart stay as they are."""
    with style.single_panel(2.0) as (figure, panel):
        panel.plot(T, X, color=style.MUTED, label="measured")
        panel.plot(T, X, color=style.VERMILLION, label="model")
        assert told_by_colour_alone(figure) == [("measured", "model")]
    assert told_by_colour_alone(figure) == []
    assert [line.get_alpha() for line in panel.lines] == [style.PALE, None]
    assert [line.get_linestyle() for line in panel.lines] == ["-", "-"]
    with style.single_panel(2.0) as (figure, panel):
        panel.plot(T, X, color=style.INK)
        panel.plot(T, X, color=style.ORANGE)
    assert [(line.get_alpha(), line.get_linestyle()) for line in panel.lines] == [(None, "-"), (None, "-")]


@pytest.mark.parametrize(
    ("colour", "expected"), [("#ffffff", 100.0), ("#000000", 0.0), ("#777777", 50.0), ("#ff0000", 53.24)]
)
def test_lightness_is_that_of_cie(colour: str, expected: float) -> None:
    """White, black, the middle grey and the red of sRGB (CIE 15:2004)."""
    assert style.lightness(colour) == pytest.approx(expected, abs=0.1)


def test_a_loop_that_is_gone_round_again_has_shapes_as_its_dashes_would_fill() -> None:
    figure = MAKERS["loops_without_velocity"]()
    first, second = figure.axes[0].lines
    assert [line.get_linestyle() for line in (first, second)] == ["-", "-"]
    assert (first.get_marker(), second.get_marker()) == ("s", "None")
    assert told_by_colour_alone(figure) == []
