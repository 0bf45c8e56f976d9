"""The editor of campaigns in a browser: a grid, its plan, its envelope, its file."""

import re
import tomllib

import pytest

pytest.importorskip("fastapi")


def test_a_grid_is_planned_repaired_saved_and_opened_again(address, new_page, accessible, data):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.locator("#g-amplitude").fill("4, 8")
    page.locator("#g-frequency").fill("0.5, 2")
    page.locator("#g-voltage").fill("0, 1.98")
    page.get_by_text("The rig refuses 2 items of this campaign, so nothing would run.").wait_for()
    page.get_by_text(re.compile("sine 8 mm at 2 Hz, 1.98 V: needs .*; lower the amplitude to 4.85 mm")).wait_for()
    page.get_by_role("img", name=re.compile("and 8 tests; 2 of them are refused")).wait_for()
    assert page.locator("#plan tbody tr").count() == 8
    accessible(page)
    page.locator("#g-amplitude").fill("4")
    page.get_by_text("The rig can run all 4 tests").wait_for()
    page.locator("#file").fill("my grid")
    page.locator("#save").click()
    page.get_by_text("Saved: my grid").wait_for()
    saved = tomllib.loads((data / "campaigns" / "my grid.toml").read_text())
    assert saved["step"][0]["amplitude"] == ["4 mm"]
    page.reload()
    page.locator("#open").select_option("my grid")
    page.wait_for_function("""() => document.querySelector("#g-frequency").value === "0.5; 2" """)
    page.locator("#file").fill("my grid")
    page.locator("#save").click()
    page.locator("#to-bench").click()
    page.locator("#campaign").wait_for()
    assert page.locator("#campaign").input_value() == "my grid"


def test_text_that_is_more_than_a_grid_is_planned_as_it_is(address, new_page):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.locator("#source").fill('[[step]]\nkind = "sweep"\namplitude = "2 mm"\nstart = "0.5 Hz"\nstop = "2 Hz"\n')
    page.get_by_text("This campaign is more than a grid").wait_for()
    page.get_by_role("cell", name=re.compile("01-sweep")).wait_for()


def test_a_grid_that_is_no_grid_says_so_before_it_asks(address, new_page):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.locator("#g-amplitude").fill("two")
    page.get_by_text("Amplitudes: two must be a number").wait_for()
    page.locator("#g-amplitude").fill("1,5")
    page.get_by_text("1,5 can be one number or two; write 1.5 or 1,5; for the one number").wait_for()
    page.locator("#g-amplitude").fill("1,5; 2")
    page.get_by_text("The rig can run all 18 tests").wait_for()
    assert page.locator("#source").input_value().count('"1.5 mm"') == 1


def test_the_default_campaign_passes_the_default_rig(address, new_page):
    page = new_page(f"{address}#/campaigns")
    page.get_by_text("The rig can run all 27 tests").wait_for()


def test_while_the_console_plans_the_old_verdict_is_gone(address, new_page):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.route("**/api/campaigns/plan", lambda route: None)  # an answer that does not come
    page.locator("#g-amplitude").fill("3")
    page.get_by_text("Planning …").wait_for()
    assert page.locator("#verdict").count() == 0


def test_a_campaign_is_copied_renamed_and_deleted_after_a_question(address, new_page, data):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.locator("#file").fill("first")
    page.locator("#save").click()
    page.get_by_text("Saved: first").wait_for()
    page.locator("#copy").click()
    page.get_by_label("Name of the copy").fill("second")
    page.get_by_role("dialog").get_by_role("button", name="Copy").click()
    page.get_by_text("Copied: second").wait_for()
    page.locator("#rename").click()
    page.get_by_label("New name").fill("third")
    page.get_by_role("dialog").get_by_role("button", name="Rename").click()
    page.get_by_text("Renamed: third").wait_for()
    page.locator("#delete").click()
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="detached")
    assert sorted(path.stem for path in (data / "campaigns").iterdir()) == ["first", "third"]
    page.locator("#delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_text("Deleted: third").wait_for()
    assert [path.stem for path in (data / "campaigns").iterdir()] == ["first"]
    page.locator("#open").select_option("first")
    page.locator("#to-bench").wait_for()  # without saving it again


def test_a_step_of_another_kind_is_built_from_its_fields_and_its_path_is_drawn(address, new_page):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.get_by_text("Add a step").click()
    page.locator("#kind").select_option("sweep")
    page.locator("#step-amplitude").fill("2; 3")
    page.locator("#step-start").fill("0,5")
    page.locator("#step-stop").fill("1.5")
    page.locator("#add").click()
    page.get_by_role("cell", name=re.compile("29-sweep-3mm")).wait_for()
    text = page.locator("#source").input_value()
    assert text.endswith('[[step]]\nkind = "sweep"\namplitude = ["2 mm", "3 mm"]\nstart = "0.5 Hz"\nstop = "1.5 Hz"\n')
    assert page.locator(".gutter").inner_text().split() == [str(k + 1) for k in range(text.count("\n") + 1)]
    page.locator("#path summary").click()
    page.get_by_role("img", name="displacement of the whole campaign over time").wait_for()
    page.locator("#path-of").select_option("29-sweep-3mm-0.5Hz-1.5Hz-0V")
    page.get_by_role("img", name=re.compile("displacement of 29-sweep")).wait_for()


def test_the_builder_the_path_and_a_question_can_be_used_by_all(address, new_page, accessible, data):
    (data / "campaigns").mkdir()
    (data / "campaigns" / "one.toml").write_text('[[step]]\nkind = "rest"\nduration = "1 s"\n')
    page = new_page(f"{address}#/campaigns?open=one")
    page.locator("#verdict").wait_for()
    page.get_by_text("Add a step").click()
    page.locator("#path summary").click()
    page.get_by_role("img", name="displacement of the whole campaign over time").wait_for()
    accessible(page)
    page.locator("#delete").click()
    page.get_by_role("dialog").wait_for()
    accessible(page)
