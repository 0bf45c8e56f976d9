"""The console on paper: its charts in light colours, its navigation and lists left out."""

import pytest

pytest.importorskip("fastapi")

from tests.identification.synthetic import sine

from dampyr import records
from dampyr.models import Damper, Interpolation

CARD = Damper("dahl", {"dahl.kx": Interpolation((0.0, 2.0), (800.0, 1800.0)), "dahl.kw": 200.0, "dahl.rho": 3000.0})
RECORD = sine(CARD, 1.0, "a", 0.005, 1.2, noise=1.0)
CHOSEN = "source=data&open=data/a.h5"


def test_charts_are_light_on_paper_and_dark_again_afterwards(address, data, new_page):
    records.write(RECORD, data / "a.h5")
    page = new_page(f"{address}#/records?{CHOSEN}", color_scheme="dark")
    page.get_by_role("tabpanel").locator("canvas, svg").first.wait_for()
    page.evaluate("""() => {
        globalThis.themes = [];
        addEventListener("theme", () => themes.push(document.documentElement.dataset.theme ?? "the system's"));
    }""")
    page.pdf(format="A4")
    assert page.evaluate("themes") == ["light", "the system's"]


def test_navigation_and_lists_are_left_out(address, data, new_page):
    records.write(RECORD, data / "a.h5")
    page = new_page(f"{address}#/records?{CHOSEN}")
    page.get_by_role("tabpanel").locator("canvas, svg").first.wait_for()
    assert page.get_by_role("navigation").first.is_visible()
    assert page.get_by_label("Show a", exact=True).is_visible()
    page.emulate_media(media="print")
    for gone in (page.get_by_role("navigation"), page.get_by_label("Show a", exact=True), page.get_by_role("tab")):
        assert not gone.first.is_visible()
    assert page.get_by_role("tabpanel").is_visible()
