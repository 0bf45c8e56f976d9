"""The shell in a browser: it loads without a network, works from the keyboard, and can be read by everyone."""

import re
import subprocess
import sys

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


def test_another_address_asks_for_the_token_it_printed(data, tmp_path):
    command = [sys.executable, "-m", "dampyr", "console", "--host", "0.0.0.0", "--port", "0", "--data", str(data)]
    with subprocess.Popen([*command, "--no-browser"], stdout=subprocess.PIPE, text=True) as process:
        printed = process.stdout.readline()
        process.terminate()
    assert re.search(r"\?token=[\w-]{32} ", printed)


def test_a_port_that_is_taken_is_one_line(address, data):
    port = address.rstrip("/").rpartition(":")[2]
    command = [sys.executable, "-m", "dampyr", "console", "--port", port, "--no-browser", "--data", str(data)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert re.fullmatch(
        rf"dampyr: 127\.0\.0\.1, port {port} cannot be had \(.*\); choose another --port or --host\n", done.stderr
    )
