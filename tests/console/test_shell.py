"""The shell in a browser: it loads without a network, works from the keyboard, and can be read by everyone."""

import re

import pytest

pytest.importorskip("fastapi")


@pytest.mark.quick
def test_the_first_page_loads_without_a_complaint(address, new_page, accessible):
    page = new_page(address)
    page.get_by_role("heading", level=1).wait_for()
    accessible(page)


def test_light_and_dark_are_chosen_and_kept(address, new_page, accessible):
    page = new_page(address)
    knob = page.get_by_role("button", name=re.compile("Colours"))
    knob.click()
    knob.click()
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.reload()
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.get_by_role("heading", level=1).wait_for()
    accessible(page)


def test_the_keyboard_reaches_the_page(address, new_page):
    page = new_page(address)
    page.get_by_role("heading", level=1).wait_for()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
