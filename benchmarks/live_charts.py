"""The live charts of the bench in Chromium without a graphics card, at 25 updates a second of six charts.

Not among the usual ones: it needs Chromium, ``python -m benchmarks live_charts``. The time is what the processes that run
and draw the page take of a processor in each second; the charts are full, with 1,200 bins in a strip and 400 in a loop.
BokehJS draws the same lines into six plots of its own.
"""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks._lines import Line

TITLE = "Live charts, 25 updates a second of six: processor time per second, software rendering"
OPT_IN = True
SECONDS = 10.0
CHROMIUM = "/usr/bin/chromium"
FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
WAYS = {"canvas": "lib/strip.js, a canvas", "bokeh": "BokehJS", "nothing": "a page without charts"}

FEED = Path(__file__).with_suffix(".js").read_text("utf-8").partition("\n")[2]


def run(_: Path | None) -> list[Line] | str:
    """Processor time per second and pictures a second of each way, or what is missing."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return "playwright is not installed"
    if not Path(CHROMIUM).exists():
        return "Chromium is not installed; `make chromium` installs Debian's"
    with served() as address, sync_playwright() as playwright:
        return [measured(playwright, address, way, words) for way, words in WAYS.items()]


def measured(playwright: Any, address: str, way: str, words: str) -> Line:
    """One way of drawing, in a browser of its own."""
    browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
    try:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(address)
        page.get_by_role("heading", level=1).wait_for()  # the shell has put its own page there
        page.evaluate(FEED, way)
        time.sleep(2.0)  # what is compiled and laid out once is not what is measured
        session = browser.new_browser_cdp_session()
        before, pictures, begun = cores(session), page.evaluate("() => window.drawn"), time.perf_counter()
        time.sleep(SECONDS)
        seconds = time.perf_counter() - begun
        used = (cores(session) - before) / seconds
        assert way == "nothing" or page.locator("main canvas").count() >= 6, "the charts are gone"
        rate = (page.evaluate("() => window.drawn") - pictures) / seconds
    finally:
        browser.close()
    return Line(words, used, used, 1, f"{rate:.0f} pictures/s")


def cores(session: Any) -> float:
    """Seconds of processor time of the processes that run and draw pages."""
    processes = session.send("SystemInfo.getProcessInfo")["processInfo"]
    return float(sum(one["cpuTime"] for one in processes if one["type"] in ("renderer", "GPU")))


@contextmanager
def served() -> Iterator[str]:
    """The address of a console over an empty folder."""
    import uvicorn

    from dampyr.console import app

    with tempfile.TemporaryDirectory() as folder:
        server = uvicorn.Server(uvicorn.Config(app(folder), port=0, log_level="warning"))
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.05)
        yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}/"
        server.should_exit = True
        thread.join(10)
