"""The page of a result is found by its type, and its choices by their names."""

from pathlib import Path

import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.show.pages.result_page import write_page

MOTION = GroundMotion([0.0, 1.0, -1.0, 0.5] * 10, 0.02)


def test_a_text_is_written_as_it_is(tmp_path: Path) -> None:
    path = write_page("<p>ρ</p>", tmp_path / "deep" / "p.html")
    assert path.read_text("utf-8") == "<p>ρ</p>"


def test_what_has_no_page_is_told_which_results_have(tmp_path: Path) -> None:
    with pytest.raises(
        InputError,
        match=r"dict has no page; give one of Fit, .*CycleFigures, Arena, ControlSearch, Posterior, or the text",
    ):
        write_page({}, tmp_path / "p.html")
    assert not (tmp_path / "p.html").exists()


def test_a_choice_that_a_page_does_not_have_is_refused_with_those_that_it_has(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"write_page\(\.\.\., title=\): the page of GroundMotion.*it has dampings, periods"
    ):
        write_page(MOTION, tmp_path / "p.html", title="T")


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_subclass_has_the_page_of_its_base(tmp_path: Path) -> None:
    class Recorded(GroundMotion):
        pass

    page = write_page(Recorded(MOTION.acceleration, 0.02, name="Elsewhere"), tmp_path / "p.html", dampings=(0.05,))
    assert "<h1>Elsewhere</h1>" in page.read_text("utf-8")
