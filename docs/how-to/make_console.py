"""Take the pictures of console.md and bench.md from one console: ``python docs/how-to/make_console.py [NAME]...``.

It needs Chromium, Playwright and the data set labcontrol, and for the bench a machine that has nothing else to do.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

PICTURES = Path(__file__).with_name("console")
QUIET = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
COLOURS = 224
MAX_WAIT = 180_000  # ms that a fit or a response may take
DESK, PHONE = {"width": 1280, "height": 860}, {"width": 390, "height": 844}
CAMPAIGN = """
name = "three sines"
rest_between = "1 s"
[[step]]
kind = "sine"
amplitude = "8 mm"
frequency = "1 Hz"
voltage = ["0 V", "0.8712 V", "1.98 V"]
cycles = 7
rest_before = "1 s"
"""
SECOND = "02-sine-8mm-1Hz-0.8712V"


@contextmanager
def console(data: str) -> Iterator[str]:
    """A console over the folder ``data``; its address."""
    command = [sys.executable, "-m", "dampyr", "console", "--json", "--port", "0", "--no-browser", "--data", data]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        output = ""
        while not output.rstrip().endswith("}"):
            output += process.stdout.readline()
        try:
            yield json.loads(output)["address"]
        finally:
            process.terminate()


def bench(page: Any, folder: str = "three sines") -> None:
    """The second test of a campaign, as it runs."""
    from playwright.sync_api import TimeoutError

    page.wait_for_function("""() => document.querySelector("#rig")?.checkVisibility()
        ? !document.querySelector("#connect")?.disabled : document.querySelector("#disconnect")?.checkVisibility()""")
    page.wait_for_timeout(1000)
    if page.locator("#connect").is_visible():
        page.locator("#connect").click()
    for _ in range(6):  # a machine with too much to do trips the rig's watchdog
        page.locator("#take:visible, #start:enabled:visible, #stop:visible").first.wait_for()
        if page.locator("#take").is_visible():
            page.locator("#take").click()
            page.wait_for_timeout(1000)
        if page.locator("#start").is_enabled() and "Start" in page.locator("#start").inner_text():
            page.locator("#start").click()
            page.locator("#folder").fill(folder)
            page.locator("#operator").fill("A. Operator")
            page.locator("#specimen").fill("RD-8041-1")
            page.locator("#start-now:enabled").click()
        with suppress(TimeoutError):
            page.locator("#run", has_text=SECOND).wait_for(timeout=45_000)
            break
    page.wait_for_timeout(6000)


def phone(page: Any) -> None:
    """The same on a phone, which takes control."""
    bench(page, "three sines again")


def campaigns(page: Any) -> None:
    """A grid, a part of which the rig cannot do."""
    page.locator("#g-amplitude").fill("4, 8")
    page.locator("#g-frequency").fill("0.5, 1, 2")
    page.locator("#file").fill("grid")
    page.get_by_text("The rig refuses 3 items of this campaign").wait_for()


def records(page: Any) -> None:
    """Three records, overlaid as loops."""
    page.get_by_label("Filter").fill("ensaio")
    for name in ("ensaio.A.1", "ensaio.B.1", "ensaio1.2.2"):
        page.get_by_label(f"Show {name}", exact=True).check()
    page.get_by_role("tab", name="Loops").click()
    page.locator("canvas").nth(1).wait_for()
    page.locator(".table").first.evaluate("table => { table.scrollTop = 0; }")


def acceptance(page: Any) -> None:
    """Records at two voltages, judged by the published damper."""
    page.get_by_label("Filter").fill("ensaio")
    for name in ("ensaio1.1", "ensaio5.1", "ensaio1.2.2", "ensaio6.2.2"):
        page.get_by_label(f"Show {name}", exact=True).check()
    page.get_by_role("tab", name="Acceptance").click()
    page.get_by_label("Reference", exact=True).select_option("raminelli_2020")
    page.set_viewport_size({"width": 1280, "height": 1180})
    page.get_by_role("status").filter(has_text="2 passed, 2 failed.").wait_for(timeout=MAX_WAIT)
    page.locator("canvas").nth(1).wait_for()


def identify(page: Any) -> None:
    """A joint fit of a few records."""
    page.get_by_label("Filter").fill("ensaio.B")
    page.get_by_role("button", name="All shown").click()
    page.get_by_label("Hysteresis").select_option("hyperbolic_tangent")
    page.get_by_label("spring", exact=True).check()
    page.get_by_role("button", name="Identify", exact=True).click()
    page.get_by_role("heading", name="Measured and modelled").wait_for(timeout=MAX_WAIT)
    page.locator("canvas").nth(1).wait_for()


def building(page: Any) -> None:
    """The two storeys with and without damper."""
    page.get_by_label("Inputs").fill("0 1.98")
    page.get_by_label("on off").check()
    page.get_by_role("button", name="Simulate").click()
    page.get_by_role("heading", name="Peaks").wait_for(timeout=MAX_WAIT)


def fragility(page: Any) -> None:
    """The same in thirty earthquakes."""
    page.get_by_label("Inputs").fill("0 1.98")
    page.get_by_text("Many earthquakes").click()
    page.get_by_role("button", name="Run the ensemble").click()
    page.get_by_role("heading", name="Fragility").wait_for(timeout=MAX_WAIT)
    page.locator("canvas").first.wait_for()


def commands(page: Any) -> None:
    """A motion's peaks and spectra."""
    page.locator("#command").select_option("motion")
    page.locator("#perform[data-command='motion']").wait_for()
    page.locator("form summary", has_text="Options").click()
    page.get_by_label("Pga", exact=True).fill("0.3g")
    page.locator("#perform").click()
    page.get_by_role("heading", name="Figures").wait_for(timeout=MAX_WAIT)
    page.wait_for_timeout(1000)


@dataclass(frozen=True)
class Shot:
    """A picture: of which page, after what was done there, in which colours and on which screen."""

    page: str
    act: Callable[[Any], None]
    colours: str = "light"
    screen: dict[str, int] | None = None


SHOTS = {
    "bench": Shot("bench", bench),
    "phone": Shot("bench", phone, screen=PHONE),
    "campaigns": Shot("campaigns", campaigns),
    "records": Shot("records", records),
    "acceptance": Shot("records", acceptance),
    "identify": Shot("identify", identify),
    "building": Shot("building", building, "dark"),
    "fragility": Shot("building", fragility),
    "commands": Shot("commands", commands),
}


def smaller(path: Path) -> None:
    """A screen has few colours: a palette keeps a picture small."""
    from PIL import Image

    with Image.open(path) as picture:
        few = picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


def main() -> None:
    """Take every picture."""
    from playwright.sync_api import sync_playwright

    wanted = sys.argv[1:] or list(SHOTS)
    browser_at = shutil.which("chromium") or shutil.which("chromium-browser")
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as data:
        campaigns = Path(data) / "campaigns"
        campaigns.mkdir()
        (campaigns / "three sines.toml").write_text(CAMPAIGN)
        with console(data) as address, sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=browser_at, args=QUIET)
            for name in wanted:
                take(browser, address, SHOTS[name], PICTURES / f"{name}.png")
            browser.close()


def take(browser: Any, address: str, shot: Shot, path: Path) -> None:
    """Take one picture."""
    context = browser.new_context(viewport=shot.screen or DESK, color_scheme=shot.colours)
    page = context.new_page()
    page.goto(f"{address}#/{shot.page}")
    page.get_by_role("heading", level=1, name=shot.page.capitalize()).wait_for()
    shot.act(page)
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(700)
    page.screenshot(path=path)
    smaller(path)
    context.close()


if __name__ == "__main__":
    main()
