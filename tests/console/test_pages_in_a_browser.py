"""The pages in a real browser: what a person does, from the first click to the kept card."""

import re

import pytest

pytest.importorskip("fastapi")

from tests.stories.test_a_damper_without_an_input import sine, spoken

from dampyr import records
from dampyr.models import Damper


@pytest.fixture
def page(address, new_page):
    """A page of the console."""
    return new_page(address)


def go(page, name, query=""):
    page.get_by_role("heading", level=1).wait_for()
    page.evaluate("where => location.assign(where)", f"#/{name}{query}")
    page.get_by_role("heading", level=1, name=name.capitalize()).wait_for()


def test_a_record_is_uploaded_fitted_and_its_card_saved(page, data, campaign_folder, tmp_path, accessible):
    record = records.read_campaign(campaign_folder)[0]
    records.write(record, tmp_path / "from the lab.csv")
    go(page, "records", "?source=data")
    page.get_by_text("No records are here yet").wait_for()
    page.get_by_text("Upload records").click()
    page.get_by_label("File", exact=True).set_input_files(tmp_path / "from the lab.csv")
    page.get_by_role("button", name="Upload").click()
    page.get_by_label("Show from the lab").wait_for()
    for view in ("Loops", "Spectra", "Cycles", "Time", "About"):
        page.get_by_role("tab", name=view).click()
        page.get_by_role("tabpanel").locator("canvas, table, dl").first.wait_for()
    page.get_by_label("Note").fill("bolts were loose")
    page.get_by_role("button", name="Save the note").click()
    page.get_by_text("The note is saved").wait_for()
    accessible(page)

    go(page, "identify")
    page.get_by_label("Source").select_option("data")
    page.get_by_label("Choose from the lab").check()
    page.get_by_role("button", name="Identify", exact=True).click()
    page.wait_for_url(re.compile("job="))
    page.reload()  # in the middle of it
    page.get_by_role("button", name="Save the card").wait_for(timeout=120_000)
    page.get_by_role("heading", name="Measured and modelled").wait_for()
    page.get_by_label("Name of the card").fill("lab 1")
    page.get_by_role("button", name="Save the card").click()
    page.get_by_text("Saved the card lab 1.toml").wait_for()
    assert (data / "cards/lab 1.toml").is_file()
    accessible(page)


@pytest.mark.prove
def test_a_published_card_is_validated_on_records_in_four_clicks(page, campaign_folder, accessible):
    """From the empty page: the page, the records that are shown, the card, the button."""
    go(page, "records", "?source=labcontrol")
    page.get_by_role("link", name="Identify").click()
    page.get_by_label("Source").select_option("labcontrol")
    page.get_by_label("Filter").fill("ensaio.A.")
    page.get_by_role("button", name="All shown").click()
    page.get_by_role("button", name="Validate").click()
    page.get_by_text("Choose a card first").wait_for()
    page.get_by_label("Card", exact=True).select_option("raminelli_2020")
    page.get_by_text("Scoring options").click()
    page.get_by_label(re.compile("^Settling")).last.fill("3")  # that of the scores: a fit has one of its own
    page.get_by_role("button", name="Validate").click()
    page.get_by_role("heading", name="raminelli_2020: dahl").wait_for(timeout=120_000)
    page.get_by_text(re.compile("Mean L1 .* over 10 records")).wait_for()
    page.get_by_role("img", name=re.compile("Measured and modelled force of ensaio.A.1 over time")).wait_for()
    page.get_by_label("Record", exact=True).select_option("ensaio.A.10")
    page.get_by_role("img", name=re.compile("Measured and modelled force of ensaio.A.10 over velocity")).wait_for()
    scores = page.locator("section", has=page.get_by_role("heading", name="Scores"))
    assert scores.locator("tr", has_text="ensaio.A.4").first.locator("td").nth(1).inner_text() == "3.212"
    with page.expect_download() as download:
        page.get_by_role("link", name="Save the whole page").click()
    assert "raminelli_2020" in download.value.path().read_text("utf-8")
    page.reload()
    page.get_by_role("heading", name="raminelli_2020: dahl").wait_for()
    page.get_by_role("link", name=re.compile("validation of raminelli_2020, 10 records")).wait_for()
    page.get_by_text("10 chosen").wait_for()  # the form is that of the job
    assert page.get_by_label("Card", exact=True).input_value() == "raminelli_2020"
    page.get_by_text("Scoring options").click()
    assert page.get_by_label(re.compile("^Settling")).last.input_value() == "3"
    accessible(page)


def test_records_are_filtered_and_overlaid_from_the_keyboard(page, campaign_folder):
    go(page, "records", "?source=labcontrol")
    page.get_by_text("39 of 39 records").wait_for()
    page.get_by_label("Filter").focus()
    page.keyboard.type("ensaio.B.")
    page.get_by_text("8 of 39 records").wait_for()
    page.get_by_label("Show ensaio.B.3").focus()
    page.keyboard.press("Space")
    page.get_by_label("Show ensaio.B.5").focus()
    page.keyboard.press("Space")
    page.get_by_role("img", name=re.compile("ensaio.B.3, ensaio.B.5")).first.wait_for()
    page.get_by_role("tab", name="Time").focus()
    page.keyboard.press("ArrowRight")
    page.get_by_role("img", name=re.compile("Force over velocity")).wait_for()
    assert page.evaluate("document.activeElement.textContent") == "Loops"
    url = page.url
    page.reload()
    page.get_by_role("img", name=re.compile("Force over velocity of ensaio.B.3, ensaio.B.5")).wait_for()
    assert page.url == url


def test_the_table_sorts_by_its_numbers(page, campaign_folder):
    go(page, "records", "?source=labcontrol")
    page.get_by_role("button", name=re.compile("stroke")).click()
    column = page.locator("tbody tr td:nth-child(5)").all_inner_texts()
    assert [float(text) for text in column] == sorted(float(text) for text in column)


@pytest.mark.prove
def test_a_building_is_shaken_and_the_response_survives_a_reload(page, accessible):
    go(page, "building")
    page.get_by_label("Inputs").fill("1.98")
    page.get_by_role("button", name="Simulate").click()
    page.get_by_role("heading", name="Peaks").wait_for(timeout=180_000)
    assert page.locator("tr", has_text="no damper").first.locator("td").nth(1).inner_text() == "45.53"
    page.reload()
    page.get_by_role("heading", name="Peaks").wait_for()
    page.get_by_role("img", name=re.compile("displacement, floor 2 over time, no damper, 1.98 V")).wait_for()
    histories = page.locator("section", has=page.get_by_role("heading", name="Histories"))
    histories.get_by_role("button", name="no damper").click()  # a history hides, and its colour is that of its frame
    assert histories.get_by_role("button", name="no damper").get_attribute("aria-pressed") == "false"
    swatch = histories.get_by_role("button", name="1.98 V").locator(".swatch")
    slab = page.locator(".frames figure", has_text="1.98 V").locator(".slab").first
    colour = "(one, name) => getComputedStyle(one)[name]"
    assert slab.evaluate(colour, "fill") == swatch.evaluate(colour, "color")
    before = page.get_by_label("Time", exact=True).input_value()
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("was => document.querySelector('input[type=range]').value !== was", arg=before)
    page.get_by_role("button", name="Stop").click()
    accessible(page)


@pytest.mark.prove
def test_a_card_is_added_and_chosen(address, new_page, data, tmp_path, accessible):
    page = new_page(address, refused=400)
    Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 3000.0}).save(tmp_path / "from the lab.toml")
    (tmp_path / "broken.toml").write_text("parts = ", "utf-8")
    go(page, "building")
    page.get_by_text("Add a card, a structure or a motion").click()
    page.get_by_label("File to add").set_input_files(tmp_path / "broken.toml")
    page.get_by_role("button", name="Add", exact=True).click()
    page.get_by_text(re.compile("broken.toml: this is not a TOML file", re.IGNORECASE)).wait_for()
    accessible(page)
    page.get_by_label("File to add").set_input_files(tmp_path / "from the lab.toml")
    page.get_by_role("button", name="Add", exact=True).click()
    page.get_by_text("Added from the lab.toml to the cards").wait_for()
    page.get_by_label("Card or published damper").select_option("cards/from the lab.toml")
    assert (data / "cards" / "from the lab.toml").is_file()
    assert not (data / "cards" / "broken.toml").exists()


@pytest.mark.quick
def test_a_wrong_number_is_told_and_nothing_is_sent(page, client):
    go(page, "building")
    page.get_by_label("Inputs").fill("some")
    page.get_by_role("button", name="Simulate").click()
    page.get_by_text("Inputs: some must be a number").wait_for()


def test_work_is_cancelled_from_the_page(page):
    go(page, "building")
    page.get_by_text("Many earthquakes").click()
    page.get_by_label("Synthetic motions").fill("400")
    page.get_by_role("button", name="Run the ensemble").click()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_text("Cancelled.").wait_for()


@pytest.mark.prove
@pytest.mark.parametrize("name", ["records", "identify", "building"])
def test_every_page_can_be_read_in_the_dark_and_on_a_phone(address, new_page, accessible, name):
    page = new_page(f"{address}#/{name}", color_scheme="dark", viewport={"width": 390, "height": 800})
    page.get_by_role("heading", level=1, name=name.capitalize()).wait_for()
    page.get_by_role("table" if name != "building" else "group").first.wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    accessible(page)


def test_a_damper_without_an_input_goes_through_the_pages_and_nothing_speaks_of_volts(page, data):
    records.write(sine(name="brace"), data / "brace.h5")
    said = {}

    def look(name):
        said[name] = spoken(page.locator("main").inner_text())

    go(page, "records", "?source=data&open=data/brace.h5")
    for view in ("Loops", "Cycles", "Time", "About"):
        page.get_by_role("tab", name=view).click()
        page.get_by_role("tabpanel").locator("canvas, table, dl").first.wait_for()
        said[view] = spoken(page.get_by_role("tabpanel").inner_text())
    go(page, "identify")
    page.get_by_label("Source").select_option("data")
    page.get_by_label("Choose brace").check()
    page.get_by_role("button", name="Identify", exact=True).click()
    page.get_by_role("button", name="Save the card").wait_for(timeout=120_000)
    look("identify")
    page.get_by_label("Name of the card").fill("brace")
    page.get_by_role("button", name="Save the card").click()
    page.get_by_text("Saved the card brace.toml").wait_for()
    go(page, "building")
    page.get_by_label("Damper").select_option("cards/brace.toml")
    page.get_by_role("button", name="Simulate").click()
    page.get_by_role("heading", name="Peaks").wait_for(timeout=180_000)
    page.locator("tr", has_text="no damper").first.wait_for()
    look("building")
    assert {name: words for name, words in said.items() if words} == {}
