"""The page Commands in a real browser: each form filled in with values that are not the usual ones, its clicks counted."""

import shutil
from pathlib import Path

import pytest

pytest.importorskip("fastapi")
from tests.console.test_commands import REQUESTS, check_result, files_of, fill

from dampyr.console.command_words import forms

MOST = 8  # clicks and choices besides typing: the page, a command, its files, its options, Run
LONG = ("demo",)  # half a minute; tests/console/test_commands.py performs it


class Clicks:
    """What a person does with a mouse on the form, counted; typing is not."""

    def __init__(self, page):
        self.page, self.count = page, 0

    def click(self, locator):
        self.count += 1
        locator.click()

    def choose(self, locator, values):
        self.count += 1
        locator.select_option(values)


def fill_in(page, clicks, command, values):
    form = page.locator("form")
    parameters = {parameter["name"]: parameter for parameter in forms()[command]["parameters"]}
    groups = {parameters[name]["group"] or "Options" for name in values if not parameters[name]["files"]}
    for summary in page.locator("form details > summary").all():
        is_open = summary.evaluate("one => one.parentElement.open")
        if summary.inner_text() in groups and not is_open:
            clicks.click(summary)
    for name, value in values.items():
        enter(form, clicks, parameters[name], value)


def enter(form, clicks, parameter, value):
    label = f"{parameter['label']} (needed)" if parameter["required"] else parameter["label"]
    if parameter["files"] == "records":
        if form.get_by_label("Source").input_value() != "data":
            clicks.choose(form.get_by_label("Source"), "data")
        for key in value:
            clicks.click(form.get_by_label(f"Choose {key.split('/')[-1].removesuffix('.h5')}", exact=False).first)
    elif parameter["kind"] == "bool":
        clicks.click(form.get_by_label(label, exact=True))
    elif parameter["choices"] and parameter["several"]:
        for box in form.get_by_role("group", name=label, exact=True).get_by_role("checkbox").all():
            if box.is_checked() != (box.evaluate("one => one.parentElement.textContent") in value):
                clicks.click(box)
    elif parameter["choices"] or parameter["files"] not in ("", "written"):
        clicks.choose(form.get_by_label(label, exact=True), value)
    else:
        form.get_by_label(label, exact=True).fill("; ".join(value) if isinstance(value, list) else value)


def test_every_form_is_filled_in_and_performed(data, serving, new_page, monkeypatch, data_root, accessible):
    """With other values than the usual ones; what was asked for is what the job got."""
    monkeypatch.setenv("DAMPYR_DATA", str(data_root))
    fill(data)
    before, counts = files_of(data), {}
    with serving(data) as address:
        page = new_page(address)
        for command, (values, holds) in REQUESTS.items():
            if command in LONG:
                continue
            page.goto(f"{address}#/")
            clicks = Clicks(page)
            clicks.click(page.locator("#pages a", has_text="Commands"))
            clicks.choose(page.locator("#command"), command)
            page.locator(f"#perform[data-command='{command}']").wait_for()
            if command == "motion":
                accessible(page)
            fill_in(page, clicks, command, values)
            clicks.click(page.locator("#perform"))
            page.get_by_role("heading", name="Result").wait_for()
            assert holds in page.locator("main").inner_text(), command
            job = page.request.get(f"{address}api/jobs").json()[0]
            done = page.request.get(f"{address}api/jobs/{job['id']}").json()
            assert done["request"] == {"command": command, "values": values}
            check_result(command, done["result"], data)
            if command == "accept":
                accessible(page)
                page.reload()  # the form is as it was when the job was started
                page.get_by_role("heading", name="Result").wait_for()
                page.locator(f"#perform[data-command='{command}']").wait_for()
                page.locator("form details > summary", has_text="Options").click()
                assert page.get_by_label("Tolerance", exact=True).input_value() == "20%"
                assert page.get_by_label("Choose test 1").is_checked()
            counts[command] = clicks.count
        page.get_by_text("Commands that are not here").click()
        page.get_by_text("a table is moved from the Bench").wait_for()
    assert max(counts.values()) <= MOST, counts
    beside_the_rig = {Path("rigs/lab/calibration.toml"), Path("rigs/lab/slow_passes.toml")}
    assert {path for path in files_of(data) - before if path.parts[0] not in ("bench", "runs")} <= beside_the_rig


def test_what_a_command_writes_is_kept_in_the_data_folder(data, address, new_page):
    """A campaign that was planned, and a wrong number, which is refused with a sentence before anything runs."""
    fill(data)
    page = new_page(f"{address}#/commands?command=plan", refused=400)
    page.locator("#perform[data-command='plan']").wait_for()
    page.get_by_label("Damper", exact=True).or_(page.get_by_label("Card", exact=True)).first.select_option(
        "cards/damper.toml"
    )
    page.get_by_label("Out", exact=True).fill("next.toml")
    page.get_by_text("Options", exact=True).click()
    page.get_by_label("Tests", exact=True).fill("none of them")
    page.locator("#perform").click()
    page.get_by_text("--tests none of them").wait_for()
    page.get_by_label("Tests", exact=True).fill("2")
    page.locator("#perform").click()
    page.get_by_label("What next.toml is").select_option("campaigns")
    page.get_by_role("button", name="Keep next.toml in the data folder").click()
    page.get_by_text("Kept next.toml among the campaigns").wait_for()
    assert (data / "campaigns" / "next.toml").is_file()
    page.goto(f"{address}#/campaigns")
    page.get_by_text("next").first.wait_for()


@pytest.mark.parametrize("job", ["identify", "validate"])
def test_the_usual_jobs_take_few_clicks_from_an_empty_page(job, data, address, new_page):
    """A fit and a validation, from the dashboard to the result: at most four; a run is tested with the Bench."""
    fill(data)
    for folder in ("response", "specimen-17"):
        shutil.rmtree(data / folder)
    (data / "test.csv").unlink()
    page = new_page(address)
    clicks = Clicks(page)
    clicks.click(page.locator("#pages a", has_text="Identify"))
    page.get_by_label("Source").wait_for()
    if page.get_by_label("Source").input_value() != "data":
        clicks.choose(page.get_by_label("Source"), "data")
    page.get_by_label("Choose test 1").first.wait_for()
    clicks.click(page.get_by_role("button", name="All shown"))
    if job == "validate":
        clicks.choose(page.get_by_label("Card", exact=True), "cards/damper.toml")
    clicks.click(page.get_by_role("button", name={"identify": "Identify", "validate": "Validate"}[job], exact=True))
    page.get_by_role("heading", name="Measured and modelled").wait_for()
    assert clicks.count <= 4
