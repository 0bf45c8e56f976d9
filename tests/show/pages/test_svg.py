"""A figure as inline SVG: ids of the page, colours as variables, and words for those who cannot see it."""

import re
from xml.etree import ElementTree

import pytest
from matplotlib.figure import Figure

from dampyr.show.figures import style
from dampyr.show.figures.theta import theta
from dampyr.show.pages.svg import inline_svg


@pytest.fixture(scope="module")
def figure() -> Figure:
    return theta([0.0, 0.01], [0.0, 100.0], {"x*": (0.005, 50.0)})


@pytest.fixture(scope="module")
def svg(figure: Figure) -> str:
    return inline_svg(figure, 'theta < "5"', "f7")


def test_it_is_one_well_formed_element_that_is_as_wide_as_the_page(svg: str) -> None:
    root = ElementTree.fromstring(svg)
    assert root.get("aria-label") == 'theta < "5"'
    assert root.get("role") == "img"
    assert root.get("width") is root.get("height") is None
    assert root.get("viewBox") is not None


def test_every_id_has_the_prefix_and_is_referred_to(svg: str) -> None:
    ids = re.findall(r'\sid="([^"]*)"', svg)
    references = set(re.findall(r'(?:url\(#|href="#)([^")]*)', svg))
    assert ids
    assert set(ids) == references
    assert all(name.startswith("f7-") for name in ids)


def test_colours_of_the_style_are_variables_and_texts_are_texts(svg: str) -> None:
    assert "var(--blue)" in svg
    assert "var(--vermillion)" in svg
    assert not [
        colour for colour in (style.INK, style.MUTED, style.GRID, style.BLUE, style.VERMILLION) if colour in svg
    ]
    assert "displacement [mm]</text>" in svg


def test_the_same_figure_gives_the_same_text(figure: Figure, svg: str) -> None:
    assert inline_svg(figure, 'theta < "5"', "f7") == svg
