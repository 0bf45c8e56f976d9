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
    assert page.locator(".envelope circle").count() == 8
    assert page.locator(".envelope .refused").count() == 2
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
    page.wait_for_function("""() => document.querySelector("#g-frequency").value === "0.5, 2" """)
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
    page.get_by_text("amplitude must be numbers separated by commas").wait_for()
