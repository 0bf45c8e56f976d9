"""Every page by the keyboard alone, and abort by Escape wherever one is (the bench itself: test_bench_page)."""

import re
import tomllib

import pytest

pytest.importorskip("fastapi")

from dampyr.models import Damper

PAGES = ("bench", "campaigns", "records", "identify", "building")


@pytest.fixture
def at(address, new_page):
    """``at("records")``: that page."""

    def show(name, **settings):
        page = new_page(f"{address}#/{name}", **settings)
        page.get_by_role("heading", level=1, name=name.capitalize()).wait_for()
        return page

    return show


def test_a_campaign_is_planned_and_saved(at, reach, data):
    page = at("campaigns")
    page.locator("#verdict").wait_for()
    for id, typed in (("file", "by hand"), ("g-amplitude", "4"), ("g-frequency", "0.5"), ("g-voltage", "0, 1.98")):
        reach(page, page.locator(f"#{id}"))
        page.keyboard.press("Control+a")
        page.keyboard.type(typed)
    page.get_by_text("The rig can run all 2 tests").wait_for()
    reach(page, page.locator("#save"))
    page.keyboard.press("Enter")
    page.get_by_text("Saved: by hand").wait_for()
    saved = tomllib.loads((data / "campaigns" / "by hand.toml").read_text())
    assert saved["step"][0]["voltage"] == ["0 V", "1.98 V"]
    reach(page, page.locator("#to-bench"))
    page.keyboard.press("Enter")
    page.locator("#campaign").wait_for()
    page.wait_for_function('() => document.activeElement.id === "main"')  # the new page is where the keyboard goes on


@pytest.mark.prove
def test_records_are_identified_and_the_card_is_saved_and_another_page_may_not_replace_it(
    at, reach, data, campaign_folder, new_page
):
    page = at("identify")
    page.get_by_label("Choose ensaio.A.1", exact=True).wait_for()
    reach(page, page.get_by_label("Filter"))
    page.keyboard.type("ensaio.A.")
    reach(page, page.get_by_label("Choose ensaio.A.4", exact=True))
    page.keyboard.press("Space")
    page.get_by_text("1 chosen").wait_for()
    reach(page, page.get_by_label("Hysteresis"))
    page.keyboard.type("dahl")
    reach(page, page.get_by_role("button", name="Identify", exact=True))
    page.keyboard.press("Enter")
    page.wait_for_url(re.compile("job="))
    save = page.get_by_role("button", name="Save the card")
    save.wait_for(timeout=120_000)
    reach(page, page.get_by_label("Name of the card"))
    page.keyboard.press("Control+a")
    page.keyboard.type("mine")
    reach(page, save)
    page.keyboard.press("Space")
    page.get_by_text("Saved the card mine.toml").wait_for()
    before = (data / "cards" / "mine.toml").read_bytes()
    assert Damper.load(data / "cards" / "mine.toml").provenance["records"] == "ensaio.A.4"

    other = new_page(page.url, refused=409)
    other.get_by_label("Name of the card").fill("mine")
    other.get_by_role("button", name="Save the card").click()
    other.get_by_text("There is a card 'mine' already; choose another name").wait_for()
    assert (data / "cards" / "mine.toml").read_bytes() == before


@pytest.mark.prove
def test_a_building_is_shaken_and_its_peaks_are_read(at, reach):
    page = at("building")
    reach(page, page.get_by_label("Inputs"))
    page.keyboard.press("Control+a")
    page.keyboard.type("1.98")
    reach(page, page.get_by_role("button", name="Simulate"))
    page.keyboard.press("Enter")
    peaks = page.get_by_role("region", name=re.compile("Peaks inside the step"))
    peaks.wait_for(timeout=180_000)
    slide = reach(page, page.get_by_label("Time", exact=True))
    before = slide.input_value()
    page.keyboard.press("ArrowRight")
    assert int(slide.input_value()) == int(before) + 1
    reach(page, peaks)  # a table that may be too wide is scrolled by the arrow keys
    reach(page, peaks.get_by_role("button", name=re.compile("floor 1")))
    page.keyboard.press("Enter")
    assert peaks.locator("tbody tr").first.locator("td").first.inner_text() == "1.98 V"


@pytest.mark.prove
@pytest.mark.parametrize("name", PAGES)
def test_abort_is_at_hand_wherever_one_types(at, name):
    page = at(name)
    page.locator("#bench-state", has_text="disconnected").wait_for()
    page.get_by_role("button", name=re.compile("Abort")).wait_for()
    places = page.locator("main").locator("input:visible:enabled, select:visible, textarea:visible, summary:visible")
    places.first.wait_for()
    page.wait_for_load_state("networkidle" if name != "bench" else "load")
    page.wait_for_timeout(500)  # what a page fills in late takes the place of what was there
    count = min(places.count(), 8)
    assert count > 0
    for place in [places.nth(k) for k in range(count)]:
        place.focus()
        before = place.evaluate("one => one.value ?? one.parentElement.open")
        page.evaluate("delete document.documentElement.dataset.aborted")
        page.keyboard.press("Escape")
        page.wait_for_function("() => document.documentElement.dataset.aborted")
        assert place.evaluate("one => one.value ?? one.parentElement.open") == before  # nothing that was typed is lost
    for shown in page.locator("details").all():
        shown.evaluate("one => { one.open = true; }")
    page.evaluate("delete document.documentElement.dataset.aborted")
    page.get_by_role("button", name=re.compile("Abort")).click()
    page.wait_for_function("() => document.documentElement.dataset.aborted")


def test_no_page_opens_a_dialog_that_would_take_escape(static):
    for path in static.rglob("*.js"):
        assert not re.search(r"\b(alert|confirm|prompt|showModal|showPicker)\(", path.read_text("utf-8")), path.name


@pytest.fixture
def static():
    """What the console serves to browsers."""
    from importlib.resources import files

    return files("dampyr.console") / "static"


@pytest.mark.prove
@pytest.mark.parametrize("name", PAGES)
def test_no_page_is_wider_than_a_phone(at, accessible, name, campaign_folder):
    page = at(name, color_scheme="dark", viewport={"width": 390, "height": 844})
    page.locator("main input, main select").first.wait_for()
    for shown in page.locator("details").all():
        shown.evaluate("one => { one.open = true; }")
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.locator(".top").bounding_box()["height"] < 130  # of 844
    accessible(page)
