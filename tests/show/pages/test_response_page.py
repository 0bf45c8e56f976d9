"""The page of a building's response: one colour for a case everywhere, floors by name, loops without corners."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from tests.show.pages.test_html_page import Reader

from dampyr import structures, studies
from dampyr.ground_motions import GroundMotion
from dampyr.show.figures import style
from dampyr.show.figures.style import case_colours
from dampyr.show.pages import response_page
from dampyr.show.pages.blocks import FigureBlock
from dampyr.show.pages.response_page import FINE, between_samples
from dampyr.show.pages.result_page import write_page
from dampyr.show.structures.responses import floor_name
from dampyr.structures.control_laws import law_of


@pytest.fixture(scope="module")
def simulated():
    t = np.arange(0.0, 2.0, 0.02)
    motion = GroundMotion(2.0 * np.sin(2 * np.pi * 2.0 * t) * np.exp(-t), 0.02)
    damper = studies.raminelli_2020.damper()
    inputs = [0.0, 1.98, law_of("on_off", damper)]
    return structures.respond(structures.two_storey(), motion, damper, voltage=inputs)


@pytest.fixture(scope="module")
def figures(simulated, tmp_path_factory):
    """The figures of its page, by their captions."""
    blocks = {}

    def keep(title, sections, **rest):
        for section in sections:
            blocks.update({b.caption: b.figure for b in section.blocks if isinstance(b, FigureBlock)})
        return "<p></p>"

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(response_page, "page", keep)
        write_page(simulated, tmp_path_factory.mktemp("page") / "r.html")
    return blocks


def drawn_colours(figure):
    """Name of a case -> its colours in a figure; a label goes on with the peak."""
    named = {}
    for axes in figure.axes:
        for line in axes.get_lines():
            name = str(line.get_label()).partition(":")[0]
            if not name.startswith("_"):
                named.setdefault(name, set()).add(to_hex(line.get_color()))
    return named


def test_a_case_has_one_colour_in_all_figures(figures, simulated):
    colours = {}
    for caption, figure in figures.items():
        if caption != "As applied.":
            for name, some in drawn_colours(figure).items():
                colours.setdefault(name, set()).update(some)
    assert set(colours) == set(simulated.cases)
    assert {name: len(some) for name, some in colours.items()} == dict.fromkeys(colours, 1)
    assert colours["no damper"] == {style.MUTED}
    assert len(set.union(*colours.values())) == len(colours)
    [control] = [figure for caption, figure in figures.items() if "input at the coil" in caption]
    [law] = [name for name in simulated.cases if name not in ("no damper", "0 V", "1.98 V")]
    assert {to_hex(control.axes[1].get_lines()[0].get_color())} == colours[law]


def test_floors_are_named(simulated, tmp_path, figures):
    assert {"Floor 1", "Floor 2"} <= {caption.partition(":")[0] for caption in figures}
    assert (floor_name("3"), floor_name("roof")) == ("floor 3", "roof")


@pytest.mark.usefixtures("figures_not_rendered")
def test_peaks_stand_by_floor_and_by_case(simulated, tmp_path):
    reader = Reader(write_page(simulated, tmp_path / "r.html").read_text("utf-8"))
    heads = [text.strip() for text in reader.inside("th")]
    assert {"floor", "peak displacement", "base shear", "mean input", "scheme", "still in motion"} <= set(heads)
    assert heads.count("case") == 4


def test_more_than_three_cases_have_panels_of_their_own(figures):
    [first] = [figure for caption, figure in figures.items() if caption.startswith("Floor 1")]
    assert len(first.axes) == 3
    assert all(len([line for line in axes.get_lines() if len(line.get_xdata()) > 1]) == 2 for axes in first.axes)


def test_a_loop_goes_through_its_samples_and_has_no_peak_of_its_own(simulated):
    r = simulated.cases["1.98 V"]
    stroke, force = between_samples(r.time, r.stroke[0], r.force[0])
    np.testing.assert_allclose(stroke[::FINE], r.stroke[0], atol=1e-12)
    np.testing.assert_allclose(force[::FINE], r.force[0], atol=1e-9)
    assert len(stroke) == FINE * (len(r.time) - 1) + 1
    assert np.max(np.abs(force)) <= np.max(np.abs(r.force[0])) + 1e-9
    t = np.arange(0.0, 1.0, 0.02)
    smooth, _ = between_samples(t, np.sin(2 * np.pi * 2.0 * t), t)
    fine = np.interp(np.arange(len(smooth)) / FINE, np.arange(len(t)), t)
    assert np.max(np.abs(smooth - np.sin(2 * np.pi * 2.0 * fine))) < 1e-3  # straight lines miss by 8e-3


def test_the_drawn_loop_has_every_point(figures, simulated):
    [squares] = [figure for caption, figure in figures.items() if caption.startswith("Force over stroke")]
    [loop] = [panel for panel in squares.axes if panel.get_title(loc="left") == "1.98 V"]
    assert len({panel.get_xlim() + panel.get_ylim() for panel in squares.axes}) == 1, "on the same axes"
    assert len(loop.get_lines()[0].get_xdata()) == FINE * (len(simulated.cases["1.98 V"].time) - 1) + 1


def test_colours_go_on_after_the_reference_and_begin_again():
    names = [f"{k}" for k in range(8)]
    colours = case_colours(names, "3")
    assert colours["3"] == style.MUTED
    assert [colours[name] for name in names if name != "3"] == [*style.CASES, style.CASES[0]]


def test_loads_and_supports_stand_in_the_place_of_a_ground_that_rests(tmp_path):
    wind = structures.FloorLoads([0.0, 0.5, 1.0], {1: [0.0, 30.0, 0.0], 2: [0.0, -60.0, 0.0]}, name="gust")
    page = write_page(structures.respond(structures.two_storey(), None, loads=wind), tmp_path / "r.html").read_text(
        "utf-8"
    )
    assert "The ground motion" not in page
    assert "The loads on the floors" in page
    assert "gust: floor 1 peak 30 N, floor 2 peak 60 N" in page
    motion = GroundMotion(np.sin(np.arange(60.0)), 0.02)
    both = structures.respond(structures.two_storey(), motion, loads=wind)
    page = write_page(both, tmp_path / "b.html").read_text("utf-8")
    assert "The ground motion" in page
    assert "The loads on the floors" in page
    car = structures.half_car(580.0, 900.0, 1.2, 1.4, 45.0, 18e3, 190e3, 300.0)
    roads = structures.axle_roads(0.01 * np.hanning(101), 0.05, 10.0, car.wheelbase)
    page = write_page(structures.respond(car, roads), tmp_path / "c.html").read_text("utf-8")
    assert "The ground motion" not in page
    assert "The motions of the supports" in page
    assert "relative to the supports" in page
