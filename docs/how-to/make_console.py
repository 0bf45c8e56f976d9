"""Take the pictures of console.md from a console with the published campaign: ``python docs/how-to/make_console.py``.

It needs Chromium, Playwright and the data set labcontrol.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PICTURES = Path(__file__).with_name("console")
QUIET = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
COLOURS = 96
LONGEST = 180_000  # ms that a fit or a response may take


@contextmanager
def console(data: str) -> Iterator[str]:
    """A console over the folder ``data``; its address."""
    command = [sys.executable, "-m", "dampyr", "console", "--json", "--port", "0", "--no-browser", "--data", data]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        told = ""
        while not told.rstrip().endswith("}"):
            told += process.stdout.readline()
        try:
            yield json.loads(told)["address"]
        finally:
            process.terminate()


def records(page: Any) -> None:
    """Three records, overlaid as loops."""
    page.get_by_label("Filter").fill("ensaio")
    for name in ("ensaio.A.1", "ensaio.B.1", "ensaio1.2.2"):
        page.get_by_label(f"Show {name}", exact=True).check()
    page.get_by_role("tab", name="Loops").click()
    page.locator("canvas").nth(1).wait_for()
    page.locator(".table").first.evaluate("table => { table.scrollTop = 0; }")


def identify(page: Any) -> None:
    """A joint fit of a few records."""
    page.get_by_label("Filter").fill("ensaio.B")
    page.get_by_role("button", name="All shown").click()
    page.get_by_label("Hysteresis").select_option("hyperbolic_tangent")
    page.get_by_label("spring", exact=True).check()
    page.get_by_role("button", name="Identify", exact=True).click()
    page.get_by_role("heading", name="Measured and modelled").wait_for(timeout=LONGEST)
    page.locator("canvas").nth(1).wait_for()


def building(page: Any) -> None:
    """The two storeys with and without damper."""
    page.get_by_label("Inputs").fill("0 1.98")
    page.get_by_label("on off").check()
    page.get_by_role("button", name="Shake it").click()
    page.get_by_role("heading", name="Peaks").wait_for(timeout=LONGEST)


def fragility(page: Any) -> None:
    """The same in thirty earthquakes."""
    page.get_by_label("Inputs").fill("0 1.98")
    page.get_by_text("Many earthquakes").click()
    page.get_by_role("button", name="Run the ensemble").click()
    page.get_by_role("heading", name="Fragility").wait_for(timeout=LONGEST)
    page.locator("canvas").first.wait_for()


SHOTS: dict[str, tuple[str, Callable[[Any], None], str]] = {
    "records": ("records", records, "light"),
    "identify": ("identify", identify, "light"),
    "building": ("building", building, "dark"),
    "fragility": ("building", fragility, "light"),
}


def smaller(path: Path) -> None:
    """A screen has few colours: a palette keeps a picture small."""
    from PIL import Image

    with Image.open(path) as picture:
        few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


def main() -> None:
    """Take every picture."""
    from playwright.sync_api import sync_playwright

    wanted = sys.argv[1:] or list(SHOTS)
    browser_at = shutil.which("chromium") or shutil.which("chromium-browser")
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as data, console(data) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_at, args=QUIET)
        for name in wanted:
            where, act, colours = SHOTS[name]
            size = {"width": 1280, "height": 860}
            page = browser.new_context(viewport=size, color_scheme=colours).new_page()
            page.goto(f"{address}#/{where}")
            act(page)
            page.evaluate("scrollTo(0, 0)")
            page.wait_for_timeout(700)
            page.screenshot(path=PICTURES / f"{name}.png")
            smaller(PICTURES / f"{name}.png")
        browser.close()


if __name__ == "__main__":
    main()
