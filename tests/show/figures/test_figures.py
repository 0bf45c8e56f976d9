"""What holds of every figure: it draws, it has units on its axes, and it follows the colours of the page."""

import re
from functools import cache

import pytest
from matplotlib.figure import Figure
from tests.show.figures.figure_examples import MAKERS

from dampyr.show.pages.svg import inline_svg


@cache
def drawn(name: str) -> tuple[Figure, str]:
    """The example of that name, and its SVG on a page."""
    fig = MAKERS[name]()
    return fig, inline_svg(fig, name, "f1")


@pytest.mark.parametrize("name", MAKERS)
def test_a_figure_draws_and_has_a_unit_on_every_axis(name: str) -> None:
    fig, svg = drawn(name)
    assert svg.startswith("<svg")
    shown = [ax for ax in fig.axes if ax.axison]
    assert shown
    for ax in shown:
        if ax.get_xlabel():
            assert ax.get_xlabel().endswith("]")
        if name != "scores" and ax.get_ylabel():
            assert ax.get_ylabel().endswith("]")
    assert any(ax.get_xlabel() for ax in shown)


@pytest.mark.parametrize("name", MAKERS)
def test_a_figure_follows_the_page(name: str) -> None:
    """Only variables for colours: a fixed one would vanish on a dark page."""
    _, svg = drawn(name)
    fixed = set(re.findall(r"(?:fill|stroke): (#\w+)", svg))
    assert fixed <= {"#ffffff"}
    assert "<text" in svg
    assert "<image" not in svg
